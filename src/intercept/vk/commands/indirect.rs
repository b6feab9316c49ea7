//! Draws whose parameters lie in memory that is written when a recorded command buffer runs: where they turn out to have nothing to show,
//! they have no instances.
//!
//! Until then a draw may be one of the scene, which the panel does not show, or flat, so that the views do not. What its rows
//! would move out of sight is not even begun.

use crate::intercept::settings;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::draw_parameters::{BYTES, Parameters, Placed};
use crate::intercept::vk::state::recording::Recording;

/// Draws of fewer vertices are not worth fetching parameters for: on lavapipe that costs as much as some hundred of them.
const FEWEST: u32 = 1 << 10;

impl Placed {
    /// Memory for a draw that is issued with so many groups of rows; `None` where it is not worth it, or not to be had.
    pub fn new(device: &Device, recording: &mut Recording, parameters: &Parameters, groups: u32) -> Option<Self> {
        let settings = settings::settings().filter(|settings| settings.cull)?;
        let few = parameters.vertices() < FEWEST && !settings.cull_all;
        if few || parameters.first_instance() != 0 {
            return None;
        }
        // Rows that come behind lie where descriptors may point.
        let stride = device.group_stride();
        let strides = (groups * BYTES).div_ceil(stride);
        let place = device.rows.take(&device.driver, &mut recording.rows, strides as usize, stride).ok()?;
        Some(Self { place, parameters: *parameters })
    }
}
