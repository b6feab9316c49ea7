//! Draws whose parameters lie in memory that is written at submission. If a draw turns out to show
//! nothing in a tile, it gets no instances there.
//!
//! Until submission a draw may be part of the scene, which the panel does not show, or flat, which
//! the views do not show.

use crate::intercept::process::settings;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::recording::Recording;
use crate::intercept::vk::state::recording::draw_parameters::{BYTES, DrawParameters, IndirectDraw};
use crate::intercept::vk::state::views::view_constants::SlotParts;

/// Draws with fewer vertices get no parameters in memory: on lavapipe, fetching parameters costs as
/// much as some hundred vertices.
const FEWEST: u32 = 1 << 10;

/// Takes memory for the parameters of a draw that is issued with `slots` slots; `None` if that is
/// not worth it, or if there is no memory. `writes`: its shaders write to buffers or images, so that
/// it must run only where it is in sight.
pub fn place(
    device: &Device,
    recording: &mut Recording,
    parameters: &DrawParameters,
    slots: u32,
    writes: bool,
) -> Option<IndirectDraw> {
    let is_large = |all| all || parameters.vertices() >= FEWEST;
    let culled =
        settings::settings().filter(|settings| settings.cull).is_some_and(|settings| is_large(settings.cull_all));
    if !culled && !writes || parameters.first_instance() != 0 {
        return None;
    }
    // A multiple of the slot size, so that later slots lie at offsets that descriptors allow.
    let stride = device.slot_stride(SlotParts::Place);
    let strides = (slots * BYTES).div_ceil(stride);
    let place = device.view_constants.take(&device.driver, &mut recording.constants, strides as usize, stride).ok()?;
    Some(IndirectDraw { at: place, parameters: *parameters })
}
