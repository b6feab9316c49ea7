//! Life of command buffers: allocation, begin, execution of secondary ones, end.

use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::{in_chain, slice};
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::recording::{Event, Pass, Recording, Recordings, Within};
use crate::intercept::vk::state::views::view_target::ViewTarget;
use crate::lock::{Lock, SharedLock};
use ash::vk;
use std::sync::{Arc, Mutex};

impl Recordings {
    /// Forgets command buffers that are destroyed or reset; `of` selects them.
    fn forget(&self, device: &Device, of: impl Fn(vk::CommandBuffer, &Recording) -> bool) {
        let known: Vec<_> = {
            let all = self.all.reading();
            all.iter().map(|(handle, recording)| (*handle, Arc::clone(recording))).collect()
        };
        for (handle, recording) in known {
            let mut state = recording.locked();
            if of(handle, &state) {
                device.view_constants.give_back(&mut state.constants);
                self.all.writing().remove(&handle);
            }
        }
    }
}

/// Returns the target that a secondary command buffer inherits, if `info` contains it.
///
/// # Safety
/// `info` must be the program's.
unsafe fn inherited(device: &Device, info: &vk::CommandBufferBeginInfo<'_>) -> Option<Arc<ViewTarget>> {
    if !info.flags.contains(vk::CommandBufferUsageFlags::RENDER_PASS_CONTINUE) || !device.draws_views() {
        return None;
    }
    // SAFETY: as promised.
    unsafe {
        let inheritance = info.p_inheritance_info.as_ref()?;
        if let Some(framebuffer) = device.framebuffers.get(inheritance.framebuffer) {
            let views = framebuffer.attachments.as_deref().unwrap_or_default();
            return framebuffer.target_now(&device.images).or_else(|| device.images.window_of_depth(device, views));
        }
        if inheritance.render_pass != vk::RenderPass::null() {
            let framebuffers = &device.framebuffers;
            let target = framebuffers.target_by_pass(device, inheritance.render_pass);
            return target.or_else(|| framebuffers.target_later(device, inheritance.render_pass));
        }
        let rendering = vk::StructureType::COMMAND_BUFFER_INHERITANCE_RENDERING_INFO;
        let rendering = in_chain::<vk::CommandBufferInheritanceRenderingInfo<'_>>(inheritance.p_next, rendering)?;
        let formats = slice(rendering.p_color_attachment_formats, rendering.color_attachment_count);
        device.swapchains.latest_target(*formats.first()?)
    }
}

/// Returns the images that a secondary command buffer draws to and that may hold a scene, if it
/// names its framebuffer.
///
/// # Safety
/// `info` must be the program's.
unsafe fn candidates(device: &Device, info: &vk::CommandBufferBeginInfo<'_>) -> Option<Vec<vk::Image>> {
    if !info.flags.contains(vk::CommandBufferUsageFlags::RENDER_PASS_CONTINUE) || !device.images.has_candidates() {
        return None;
    }
    // SAFETY: as promised.
    let inheritance = unsafe { info.p_inheritance_info.as_ref() }?;
    let framebuffer = device.framebuffers.get(inheritance.framebuffer)?;
    let views = framebuffer.attachments.iter().flatten();
    Some(views.filter_map(|view| device.images.candidate_of(*view)).collect())
}

/// True if queries of the executing command buffer may count draws of a secondary one.
///
/// # Safety
/// `info` must be the program's.
unsafe fn inherits_queries(info: &vk::CommandBufferBeginInfo<'_>) -> bool {
    // SAFETY: as promised.
    let inheritance = unsafe { info.p_inheritance_info.as_ref() };
    let counts = |inheritance: &vk::CommandBufferInheritanceInfo<'_>| {
        inheritance.occlusion_query_enable != vk::FALSE || !inheritance.pipeline_statistics.is_empty()
    };
    info.flags.contains(vk::CommandBufferUsageFlags::RENDER_PASS_CONTINUE) && inheritance.is_some_and(counts)
}

hooks! {
    allocate_command_buffers = (
        device: vk::Device, info: *const vk::CommandBufferAllocateInfo<'_>, buffers: *mut vk::CommandBuffer
    ) -> vk::Result { |state, next| {
        let result = next(device, info, buffers);
        if result == vk::Result::SUCCESS {
            let mut all = state.recordings.all.writing();
            for buffer in slice(buffers, (*info).command_buffer_count) {
                all.insert(*buffer, Arc::new(Mutex::new(Recording::new((*info).command_pool))));
            }
        }
        result
    } }
    free_command_buffers = (
        device: vk::Device, pool: vk::CommandPool, count: u32, buffers: *const vk::CommandBuffer
    ) { |state, next| {
        let gone = slice(buffers, count);
        let of = |buffer: &vk::CommandBuffer| state.recordings.with(*buffer, |r| std::mem::take(&mut r.clearers));
        let clearers: Vec<_> = gone.iter().filter_map(of).flatten().collect();
        if !clearers.is_empty() {
            next(device, pool, clearers.len() as u32, clearers.as_ptr());
        }
        state.recordings.forget(&state, |handle, _| gone.contains(&handle));
        next(device, pool, count, buffers)
    } }
    destroy_command_pool = (
        device: vk::Device, pool: vk::CommandPool, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.recordings.forget(&state, |_, recording| recording.pool == pool);
        next(device, pool, allocator)
    } }
    begin_command_buffer = (
        buffer: vk::CommandBuffer, info: *const vk::CommandBufferBeginInfo<'_>
    ) -> vk::Result { |state, next| {
        let (target, candidates) = (inherited(&state, &*info), candidates(&state, &*info));
        let counted = inherits_queries(&*info);
        let mut changed = *info;
        let mut inheritance = changed.p_inheritance_info.as_ref().copied().unwrap_or_default();
        if target.is_some() && !changed.p_inheritance_info.is_null() {
            // The pass draws to a framebuffer of Cupola, not to the program's.
            inheritance.framebuffer = vk::Framebuffer::null();
            changed.p_inheritance_info = &inheritance;
        }
        state.recordings.with(buffer, |recording| {
            recording.begin(&state.driver, &state.view_constants);
            recording.counting = counted.into();
            recording.plain = candidates.filter(|_| target.is_none());
            recording.pass = target.map(|target| Pass::new(target, Within::Inherited, Vec::new()));
        });
        next(buffer, &changed)
    } }
    cmd_execute_commands = (
        buffer: vk::CommandBuffer, count: u32, others: *const vk::CommandBuffer
    ) { |state, next| {
        let others_list = slice(others, count);
        // For each, whether it was recorded for views.
        let kinds: Vec<_> = others_list.iter().map(|other| state.recordings.with(*other, |r| r.pass.is_some())).collect();
        let in_pass = state.recordings.with(buffer, |recording| {
            crate::intercept::vk::commands::passes::panel_clears::clear_by_secondary(&state, buffer, recording);
            recording.events.extend(others_list.iter().map(|other| Event::Execute(*other)));
            recording.forget_state();
            (recording.pass.is_some() || recording.plain.is_some()).then_some(recording.pass.is_some())
        });
        if let Some(Some(views)) = in_pass
            && kinds.iter().flatten().any(|kind| *kind != views)
        {
            state.show_flat("its secondary command buffers do not name their targets");
        }
        next(buffer, count, others)
    } }
}
