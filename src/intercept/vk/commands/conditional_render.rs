//! Conditional rendering: the program's condition holds for its own commands, and not for those
//! that Cupola records between them.

use crate::intercept::vk::commands::passes::panel_clears::clear_pending;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::recording::Condition;
use ash::vk;

/// Records by `work` without the program's condition, which holds again afterwards.
///
/// # Safety
/// The command buffer is being recorded; `work` may begin a pass of commands that are recorded into
/// it, or end one.
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
    // SAFETY: as promised; the condition is the program's, and ends where it began, within a pass
    // or outside.
    unsafe {
        end(buffer);
        work();
        begin(buffer, &again);
    }
}

/// A pass is about to begin; `inline`: with commands of its own, not with secondary command
/// buffers. A condition around those would hold for our commands among them, too, and so the
/// program is shown flat.
pub fn pass_follows(device: &Device, buffer: vk::CommandBuffer, inline: bool) {
    let holds = device.recordings.with(buffer, |recording| recording.condition.is_some());
    if holds == Some(true) && !inline {
        device.show_flat("it uses conditional rendering with secondary command buffers");
    }
}

/// Begins a pass by `begin`. What the first draw would have to clear of the panel is cleared at
/// once, where a condition holds.
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
