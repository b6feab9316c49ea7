//! Draws whose parameters lie in memory that is written when a recorded command buffer runs: where they turn out to have nothing to show,
//! they have no instances.
//!
//! Until then a draw may be one of the scene, which the panel does not show, or flat, so that the views do not. What its view constants
//! would move out of sight is not even begun.

use crate::intercept::settings;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::draw_parameters::{BYTES, DrawParameters, IndirectDraw};
use crate::intercept::vk::state::recording::Recording;

/// Draws of fewer vertices are not worth fetching parameters for: on lavapipe that costs as much as some hundred of them.
const FEWEST: u32 = 1 << 10;

/// Memory for a draw that is issued with so many slots of view constants; `None` where it is not worth it, or not to be had.
pub fn place(
    device: &Device,
    recording: &mut Recording,
    parameters: &DrawParameters,
    slots: u32,
) -> Option<IndirectDraw> {
    let settings = settings::settings().filter(|settings| settings.cull)?;
    let covers_viewport = parameters.vertices() < FEWEST && !settings.cull_all;
    if covers_viewport || parameters.first_instance() != 0 {
        return None;
    }
    // Matrices that come behind lie where descriptors may point.
    let stride = device.slot_stride();
    let strides = (slots * BYTES).div_ceil(stride);
    let place = device.view_constants.take(&device.driver, &mut recording.constants, strides as usize, stride).ok()?;
    Some(IndirectDraw { at: place, parameters: *parameters })
}
