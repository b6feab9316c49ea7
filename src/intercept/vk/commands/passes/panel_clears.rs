//! Clears of the panel to transparent black, so that the views behind it are visible.

use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::recording::{Recording, Within};
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use ash::prelude::VkResult;
use ash::vk;

/// Clears the panel of colour attachments to transparent black.
///
/// # Safety
/// The command buffer is being recorded, within a pass that has these attachments.
pub unsafe fn clear_panel(device: &Device, buffer: vk::CommandBuffer, layout: &AtlasLayout, attachments: &[u32]) {
    if attachments.is_empty() {
        return;
    }
    let clear = |attachment: &u32| vk::ClearAttachment {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        color_attachment: *attachment,
        clear_value: vk::ClearValue::default(),
    };
    let clears: Vec<_> = attachments.iter().map(clear).collect();
    let rect = vk::ClearRect { rect: layout.panel_with_border().to_vk(), base_array_layer: 0, layer_count: 1 };
    // SAFETY: as promised; the panel lies in the atlas.
    unsafe { device.driver.functions.cmd_clear_attachments(buffer, &clears, &[rect]) };
}

/// Clears the parts of the panel that would otherwise be cleared at the first draw of a pass.
///
/// # Safety
/// The command buffer is being recorded.
pub unsafe fn clear_pending(device: &Device, buffer: vk::CommandBuffer, recording: &mut Recording) {
    let Some(pass) = &mut recording.pass else { return };
    let uncleared_panels = std::mem::take(&mut pass.uncleared_panels);
    // SAFETY: as promised; within the pass.
    unsafe { clear_panel(device, buffer, &pass.target.layout, &uncleared_panels) };
}

/// Clears the panel in a pass that has only secondary command buffers, with one of Cupola's.
///
/// # Safety
/// The command buffer is being recorded; the program uses its pool on this thread.
pub unsafe fn clear_by_secondary(device: &Device, buffer: vk::CommandBuffer, recording: &mut Recording) {
    let Recording { pass, clearers, pool, .. } = recording;
    let Some(pass) = pass.as_mut().filter(|pass| !pass.uncleared_panels.is_empty()) else { return };
    let uncleared_panels = std::mem::take(&mut pass.uncleared_panels);
    let functions = &device.driver.functions;
    let mut record = || -> VkResult<vk::CommandBuffer> {
        let mut rendering = vk::CommandBufferInheritanceRenderingInfo::default();
        let mut inheritance = vk::CommandBufferInheritanceInfo::default();
        match &pass.within {
            Within::Pass { pass, subpass } => inheritance = inheritance.render_pass(*pass).subpass(*subpass),
            Within::Rendering { colors, depth, stencil, samples } => {
                rendering = rendering
                    .color_attachment_formats(colors)
                    .depth_attachment_format(*depth)
                    .stencil_attachment_format(*stencil)
                    .rasterization_samples(*samples);
                inheritance = inheritance.push_next(&mut rendering);
            }
            Within::Inherited => return Err(vk::Result::ERROR_INITIALIZATION_FAILED),
        }
        let usage = vk::CommandBufferUsageFlags::RENDER_PASS_CONTINUE | vk::CommandBufferUsageFlags::SIMULTANEOUS_USE;
        let info = vk::CommandBufferBeginInfo::default().flags(usage).inheritance_info(&inheritance);
        // SAFETY: as promised; the pass has these attachments.
        unsafe {
            let clearer = device.driver.secondary_command_buffer(*pool)?;
            clearers.push(clearer);
            functions.begin_command_buffer(clearer, &info)?;
            clear_panel(device, clearer, &pass.target.layout, &uncleared_panels);
            functions.end_command_buffer(clearer)?;
            Ok(clearer)
        }
    };
    match record() {
        // SAFETY: as promised.
        Ok(clearer) => unsafe { functions.cmd_execute_commands(buffer, &[clearer]) },
        Err(error) => device.show_flat(format!("the driver refuses a command buffer: {error}")),
    }
}
