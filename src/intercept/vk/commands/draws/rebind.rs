//! Restores on the device the state that the program bound and set, after draws of Cupola.

use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::pipelines::Pipeline;
use crate::intercept::vk::state::recording::Recording;
use ash::vk;

/// Restores the state that the program bound and set, after draws of Cupola.
///
/// # Safety
/// The command buffer is being recorded.
pub unsafe fn restore(device: &Device, buffer: vk::CommandBuffer, recording: &mut Recording) {
    let Some(pipeline) = recording.graphics.pipeline.clone() else { return };
    // SAFETY: as promised; what is bound and set is the program's own.
    unsafe {
        if recording.graphics.current != pipeline.own {
            device.driver.functions.cmd_bind_pipeline(buffer, vk::PipelineBindPoint::GRAPHICS, pipeline.own);
            recording.graphics.current = pipeline.own;
        }
        if recording.graphics.disturbed {
            if let (None, Some(viewport)) = (pipeline.viewport, recording.graphics.viewport) {
                device.driver.functions.cmd_set_viewport(buffer, 0, &[viewport]);
            }
            if let (None, Some(scissor)) = (pipeline.scissor, recording.graphics.scissor) {
                device.driver.functions.cmd_set_scissor(buffer, 0, &[scissor]);
            }
            recording.graphics.disturbed = false;
        }
        rebind(device, buffer, recording, &pipeline);
    }
}

/// Binds the program's descriptor sets again that were replaced by sets of Cupola.
///
/// # Safety
/// The command buffer is being recorded.
pub unsafe fn rebind(device: &Device, buffer: vk::CommandBuffer, recording: &mut Recording, pipeline: &Pipeline) {
    let (Some(from), Some(layout)) = (recording.graphics.displaced, &pipeline.layout) else { return };
    if from >= layout.ours {
        return;
    }
    for (number, bound) in (0..layout.ours).zip(&recording.graphics.bound).filter(|(number, _)| *number >= from) {
        let Some(bound) = bound else { continue };
        // SAFETY: as promised; the program bound or pushed this set under this number.
        unsafe {
            let (functions, point) = (&device.driver.functions, vk::PipelineBindPoint::GRAPHICS);
            match &bound.pushed {
                Some(pushed) => pushed.repeat(&device.next, buffer, point, layout.handle, number),
                None => {
                    let (sets, dynamic) = ([bound.set], &bound.dynamic);
                    functions.cmd_bind_descriptor_sets(buffer, point, layout.handle, number, &sets, dynamic);
                }
            }
        }
    }
    recording.graphics.displaced = None;
}
