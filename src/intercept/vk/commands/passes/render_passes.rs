//! Render passes. A pass that draws to a view target draws to its atlas instead.

use crate::backend::vk::COLOR;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::commands::passes::panel_clears::{clear_panel, clear_pending};
use crate::intercept::vk::commands::{barriers_and_clears, conditional_render};
use crate::intercept::vk::offscreen::{coverage, view_copies};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::{in_chain, slice};
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::images::LayoutChange;
use crate::intercept::vk::state::images::framebuffers::Framebuffer;
use crate::intercept::vk::state::recording::{Event, Pass, Within};
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::intercept::vk::state::views::view_target::ViewTarget;
use ash::vk;
use std::sync::Arc;

/// Replacement of the target of a pass.
struct Replaced {
    framebuffer: vk::Framebuffer,
    /// Attachments, if they are given with the pass.
    attachments: Option<Vec<vk::ImageView>>,
    pass: Pass,
}

/// Returns the attachments of a pass that begins: the framebuffer's, or those that are given with
/// it.
///
/// # Safety
/// `begin` must be the program's, with this framebuffer.
unsafe fn views_of<'a>(begin: &vk::RenderPassBeginInfo<'a>, framebuffer: &'a Framebuffer) -> &'a [vk::ImageView] {
    if let Some(attachments) = &framebuffer.attachments {
        return attachments;
    }
    let kind = vk::StructureType::RENDER_PASS_ATTACHMENT_BEGIN_INFO;
    // SAFETY: as promised.
    unsafe {
        in_chain::<vk::RenderPassAttachmentBeginInfo<'_>>(begin.p_next, kind)
            .map_or(&[], |given| slice(given.p_attachments, given.attachment_count))
    }
}

/// # Safety
/// `begin` must be the program's.
unsafe fn replace(device: &Device, begin: &vk::RenderPassBeginInfo<'_>) -> Option<Result<Replaced, Obstacle>> {
    let framebuffer = device.framebuffers.get(begin.framebuffer)?;
    // SAFETY: as promised.
    let views = unsafe { views_of(begin, &framebuffer) };
    let given = framebuffer.attachments.is_none().then_some(views);
    let colored =
        framebuffer.target_now(&device.images).or_else(|| views.iter().find_map(|view| device.images.target(*view)));
    let is_colored = colored.is_some();
    let target = colored.or_else(|| device.images.window_of_depth(device, views))?;
    let replaced = || {
        let pass = device.framebuffers.pass(begin.render_pass).ok_or("a render pass that is not known")?;
        if let Some(why) = pass.obstacle {
            return Err(why.into());
        }
        if !is_whole(&begin.render_area, &target.layout) && !pass.may_grow {
            return Err("it draws a part of the window at a time".into());
        }
        let atlas_copy = framebuffer.atlas_copy(device, &target, begin.render_pass, given.unwrap_or_default())?;
        let attachments = match given.filter(|given| !given.is_empty()) {
            Some(given) => {
                let atlas_copies = given.iter().map(|view| device.images.atlas_copy(device, *view, &target.layout));
                Some(atlas_copies.collect::<Result<Vec<_>, _>>()?)
            }
            None => None,
        };
        let within = Within::Pass { pass: begin.render_pass, subpass: 0 };
        // This includes images that are only resolved to: they get the panel of the samples.
        let is_filled =
            |view: &vk::ImageView| device.images.target(*view).is_some_and(|target| target.takes_filled_panel());
        let filled: Vec<_> = views.iter().map(is_filled).collect();
        let mut new = Pass::new(Arc::clone(&target), within, pass.begin_with(&filled));
        new.colored = is_colored;
        if is_colored {
            device.images.draws_together(device, &target.layout, views.iter().copied());
        }
        for ((view, layout), found) in views.iter().zip(&pass.leaves).zip(&pass.finds) {
            match device.images.target(*view) {
                Some(scene) if !scene.window => new.scenes.push((scene, *layout)),
                Some(window) => new.layout_changes.extend(change_of_window(&window, *found, *layout)),
                None => new
                    .layout_changes
                    .extend(device.images.of(*view).and_then(|image| device.images.change_layout(image, *layout))),
            }
        }
        Ok(Replaced { framebuffer: atlas_copy, attachments, pass: new })
    };
    if !device.draws_views() {
        return Some(Err(Obstacle::AlreadyFlat));
    }
    Some(replaced())
}

/// Returns the change of layout that a pass would have made to the window's image. The pass does
/// not draw to that image. The image is in the layout for presentation when a frame begins.
fn change_of_window(window: &ViewTarget, found: vk::ImageLayout, left: vk::ImageLayout) -> Option<LayoutChange> {
    let presentable = vk::ImageLayout::PRESENT_SRC_KHR;
    let is_so = left == presentable && matches!(found, vk::ImageLayout::UNDEFINED | vk::ImageLayout::PRESENT_SRC_KHR);
    let aspects = vk::ImageAspectFlags::COLOR;
    (!is_so).then_some(LayoutChange { image: window.given, aspects, layout: left })
}

/// True if an area is the whole window.
pub fn is_whole(area: &vk::Rect2D, layout: &AtlasLayout) -> bool {
    area.offset == vk::Offset2D::default() && (area.extent.width, area.extent.height) == layout.window
}

/// The whole atlas.
pub fn whole_atlas(layout: &AtlasLayout) -> vk::Rect2D {
    vk::Extent2D { width: layout.atlas.0, height: layout.atlas.1 }.into()
}

/// Begins a pass with `next`: the program's, or the one that draws to the atlas.
///
/// # Safety
/// `info` must be the program's; `next` begins a pass as its argument describes.
unsafe fn begin(
    device: &Device,
    buffer: vk::CommandBuffer,
    info: &vk::RenderPassBeginInfo<'_>,
    next: impl Fn(&vk::RenderPassBeginInfo<'_>),
) {
    // SAFETY: as promised.
    let replaced = unsafe { replace(device, info) };
    let replaced = match replaced {
        Some(Ok(replaced)) => replaced,
        other => {
            if let Some(Err(why)) = other {
                device.show_flat(why);
            }
            // SAFETY: as promised.
            unsafe { note_plain(device, buffer, info) };
            return next(info);
        }
    };
    if replaced.pass.target.window {
        // SAFETY: as promised.
        unsafe { coverage::prepare(device, buffer) };
    }
    for (scene, layout) in &replaced.pass.scenes {
        barriers_and_clears::moved(device, buffer, scene.given, *layout);
    }
    let mut changed = *info;
    changed.framebuffer = replaced.framebuffer;
    changed.render_area = whole_atlas(&replaced.pass.target.layout);
    let mut attachments = vk::RenderPassAttachmentBeginInfo::default();
    if let Some(atlas_copies) = &replaced.attachments {
        // SAFETY: the chain is the program's.
        let first = unsafe { info.p_next.cast::<vk::BaseInStructure<'_>>().as_ref() };
        let first = first.filter(|first| first.s_type == vk::StructureType::RENDER_PASS_ATTACHMENT_BEGIN_INFO);
        let Some(first) = first else {
            device.show_flat("unknown structures in a chain");
            plain(device, buffer, Some(replaced.pass.target), &[]);
            return next(info);
        };
        attachments = attachments.attachments(atlas_copies);
        attachments.p_next = first.p_next.cast();
        changed.p_next = std::ptr::from_ref(&attachments).cast();
    }
    // SAFETY: as promised.
    unsafe {
        conditional_render::begin_pass(device, buffer, || {
            next(&changed);
            served(device, buffer, replaced.pass);
        });
    }
}

/// Notes that a pass of the program's own begins; its images are followed.
///
/// # Safety
/// `info` must be the program's.
unsafe fn note_plain(device: &Device, buffer: vk::CommandBuffer, info: &vk::RenderPassBeginInfo<'_>) {
    let framebuffer = device.framebuffers.get(info.framebuffer);
    // SAFETY: as promised.
    let views = framebuffer.as_ref().map_or(&[][..], |framebuffer| unsafe { views_of(info, framebuffer) });
    let pass = device.framebuffers.pass(info.render_pass);
    let (leaves, anew) = pass.as_ref().map_or((&[][..], &[][..]), |pass| (&pass.leaves, &pass.begins_anew));
    for ((view, layout), anew) in views.iter().zip(leaves).zip(anew) {
        let image = device.images.of(*view);
        image.into_iter().for_each(|image| barriers_and_clears::moved(device, buffer, image, *layout));
        if !anew {
            device.images.goes_on_with(device, *view);
        }
    }
    // An imageless framebuffer has no target of its own.
    let target = framebuffer.as_ref().and_then(|framebuffer| framebuffer.target_now(&device.images));
    let target = target.or_else(|| views.iter().find_map(|view| device.images.target(*view)));
    plain(device, buffer, target, views);
}

/// Notes that a pass begins that is drawn for each view.
pub fn served(device: &Device, buffer: vk::CommandBuffer, pass: Pass) {
    device.recordings.with(buffer, |recording| {
        recording.events.extend(pass.colored.then(|| Event::Drawn(Arc::clone(&pass.target), true)));
        recording.pass = Some(pass);
    });
}

/// Notes that a pass of the program's own begins, with `views` of images.
pub fn plain(device: &Device, buffer: vk::CommandBuffer, target: Option<Arc<ViewTarget>>, views: &[vk::ImageView]) {
    let candidates = match device.images.has_candidates() {
        true => views.iter().filter_map(|view| device.images.candidate_of(*view)).collect::<Vec<_>>(),
        false => Vec::new(),
    };
    candidates.iter().for_each(|image| device.images.attached(*image));
    device.recordings.with(buffer, |recording| {
        recording.plain = Some(candidates);
        recording.events.extend(target.map(|target| Event::Drawn(target, false)));
    });
}

/// Ends a pass with `next`. Does the clears that are still pending in a pass without draws, and
/// makes view copies of the scenes that the pass drew.
///
/// # Safety
/// The command buffer is being recorded, within the pass.
pub unsafe fn end(device: &Device, buffer: vk::CommandBuffer, next: impl FnOnce()) {
    let pass = device.recordings.with(buffer, |recording| {
        recording.plain = None;
        recording.pass.take()
    });
    let Some(pass) = pass.flatten() else { return next() };
    // SAFETY: as promised; after `next`, the commands are outside of the pass.
    unsafe {
        conditional_render::unconditionally(device, buffer, || {
            clear_panel(device, buffer, &pass.target.layout, &pass.uncleared_panels);
            next();
            for (scene, layout) in &pass.scenes {
                view_copies::make(device, buffer, scene, *layout);
            }
            change_layout(device, buffer, &pass.layout_changes);
            for LayoutChange { image, layout, .. } in &pass.layout_changes {
                barriers_and_clears::moved(device, buffer, *image, *layout);
            }
        });
    }
}

/// Begins the next subpass with `next`. It has its own attachments.
///
/// # Safety
/// The command buffer is being recorded, within a pass.
unsafe fn next_subpass(device: &Device, buffer: vk::CommandBuffer, next: impl FnOnce()) {
    // SAFETY: as promised; the cleared attachments are those of the subpass that ends.
    device.recordings.with(buffer, |recording| unsafe { clear_pending(device, buffer, recording) });
    next();
    device.recordings.with(buffer, |recording| {
        let Some(pass) = &mut recording.pass else { return };
        let Within::Pass { pass: handle, subpass } = &mut pass.within else { return };
        *subpass += 1;
        let known = device.framebuffers.pass(*handle);
        pass.uncleared_panels = known.map(|known| known.begin_in(*subpass as usize)).unwrap_or_default();
    });
}

/// Changes images of the program to the layouts in which a pass would have left them.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass.
unsafe fn change_layout(device: &Device, buffer: vk::CommandBuffer, layout_changes: &[LayoutChange]) {
    let change = |layout_changes: &LayoutChange| {
        let range = vk::ImageSubresourceRange { aspect_mask: layout_changes.aspects, ..COLOR };
        vk::ImageMemoryBarrier::default()
            .image(layout_changes.image)
            .new_layout(layout_changes.layout)
            .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
            .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .subresource_range(range)
    };
    let changes: Vec<_> = layout_changes.iter().map(change).collect();
    if !changes.is_empty() {
        let (stages, flags) = (vk::PipelineStageFlags::ALL_COMMANDS, vk::DependencyFlags::empty());
        // SAFETY: as promised; the old content of the images is not needed.
        unsafe { device.driver.functions.cmd_pipeline_barrier(buffer, stages, stages, flags, &[], &[], &changes) };
    }
}

hooks! {
    cmd_begin_render_pass = (
        buffer: vk::CommandBuffer, info: *const vk::RenderPassBeginInfo<'_>, contents: vk::SubpassContents
    ) { |state, next| {
        conditional_render::pass_follows(&state, buffer, contents == vk::SubpassContents::INLINE);
        begin(&state, buffer, &*info, |info| next(buffer, info, contents))
    } }
    cmd_begin_render_pass2 = (
        buffer: vk::CommandBuffer, info: *const vk::RenderPassBeginInfo<'_>, subpass: *const vk::SubpassBeginInfo<'_>
    ) { |state, next| {
        conditional_render::pass_follows(&state, buffer, (*subpass).contents == vk::SubpassContents::INLINE);
        begin(&state, buffer, &*info, |info| next(buffer, info, subpass))
    } }
    cmd_next_subpass = (
        buffer: vk::CommandBuffer, contents: vk::SubpassContents
    ) { |state, next| next_subpass(&state, buffer, || next(buffer, contents)) }
    cmd_next_subpass2 = (
        buffer: vk::CommandBuffer, begin: *const vk::SubpassBeginInfo<'_>, end: *const vk::SubpassEndInfo<'_>
    ) { |state, next| next_subpass(&state, buffer, || next(buffer, begin, end)) }
    cmd_end_render_pass = (buffer: vk::CommandBuffer) { |state, next| {
        end(&state, buffer, || next(buffer))
    } }
    cmd_end_render_pass2 = (
        buffer: vk::CommandBuffer, info: *const vk::SubpassEndInfo<'_>
    ) { |state, next| {
        end(&state, buffer, || next(buffer, info))
    } }
}
