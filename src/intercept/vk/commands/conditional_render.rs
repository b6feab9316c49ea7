//! Conditional rendering. The program's condition must apply to its own commands, but not to
//! commands that Cupola records between them.

use crate::intercept::vk::commands::passes::panel_clears::clear_pending;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::recording::Condition;
use ash::vk;

/// Records with `work` without the program's condition, which is set again afterwards.
///
/// # Safety
/// The command buffer is being recorded; `work` may begin a pass whose commands are recorded into
/// this buffer, or end one.
pub unsafe fn unconditionally(device: &Device, buffer: vk::CommandBuffer, work: impl FnOnce()) {
    let condition = device.recordings.with(buffer, |recording| recording.condition).flatten();
    let next = &device.next;
    let (Some(condition), Some(begin), Some(end)) =
        (condition, next.cmd_begin_conditional_rendering, next.cmd_end_conditional_rendering)
    else {
        return work();
    };
    let again = vk::ConditionalRenderingBeginInfoEXT::default()
        .buffer(condition.buffer)
        .offset(condition.offset)
        .flags(condition.flags);
    // SAFETY: as promised; the condition is the program's. It ends in the scope in which it began:
    // within the pass, or outside.
    unsafe {
        end(buffer);
        work();
        begin(buffer, &again);
    }
}

/// Notes that a pass is about to begin; `inline`: its commands are not in secondary command
/// buffers. A condition around secondary command buffers would also apply to Cupola's commands in
/// them. Therefore the program is shown flat.
pub fn pass_follows(device: &Device, buffer: vk::CommandBuffer, inline: bool) {
    let holds = device.recordings.with(buffer, |recording| recording.condition.is_some());
    if holds == Some(true) && !inline {
        device.show_flat("it uses conditional rendering with secondary command buffers");
    }
}

/// Begins a pass with `begin`. Under a condition, the panel is cleared at once, and not at the
/// first draw.
///
/// # Safety
/// As for [`unconditionally`].
pub unsafe fn begin_pass(device: &Device, buffer: vk::CommandBuffer, begin: impl FnOnce()) {
    // SAFETY: as promised.
    unsafe {
        unconditionally(device, buffer, || {
            begin();
            device.recordings.with(buffer, |recording| {
                if recording.condition.is_some() {
                    clear_pending(device, buffer, recording);
                }
            });
        });
    }
}

hooks! {
    cmd_begin_conditional_rendering = (
        buffer: vk::CommandBuffer, info: *const vk::ConditionalRenderingBeginInfoEXT<'_>
    ) { |state, next| {
        state.recordings.with(buffer, |recording| {
            clear_pending(&state, buffer, recording);
            let within = recording.pass.is_some() || recording.plain.is_some();
            let given = &*info;
            let condition = Condition { buffer: given.buffer, offset: given.offset, flags: given.flags };
            recording.condition = (!within).then_some(condition);
        });
        next(buffer, info)
    } }
    cmd_end_conditional_rendering = (
        buffer: vk::CommandBuffer
    ) { |state, next| {
        state.recordings.with(buffer, |recording| recording.condition = None);
        next(buffer)
    } }
}
