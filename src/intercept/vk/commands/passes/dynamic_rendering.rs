//! Dynamic rendering. If it draws to a view target, it draws to its atlas instead.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::commands::passes::render_passes::{end, is_whole, plain, served, whole_atlas};
use crate::intercept::vk::commands::{barriers_and_clears, conditional_render};
use crate::intercept::vk::offscreen::coverage;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::recording::{Pass, Within};
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::intercept::vk::state::views::view_target::ViewTarget;
use ash::vk;
use std::sync::Arc;

/// Attachments of dynamic rendering, as the program gives them.
struct Given<'a> {
    info: &'a vk::RenderingInfo<'a>,
    colors: &'a [vk::RenderingAttachmentInfo<'a>],
    depth: Option<&'a vk::RenderingAttachmentInfo<'a>>,
    stencil: Option<&'a vk::RenderingAttachmentInfo<'a>>,
}

impl<'a> Given<'a> {
    /// # Safety
    /// `info` must be the program's.
    unsafe fn of(info: &'a vk::RenderingInfo<'a>) -> Self {
        // SAFETY: as promised.
        unsafe {
            Self {
                info,
                colors: slice(info.p_color_attachments, info.color_attachment_count),
                depth: info.p_depth_attachment.as_ref(),
                stencil: info.p_stencil_attachment.as_ref(),
            }
        }
    }

    /// Returns the views of the colour attachments and of their resolve images.
    fn views(&self) -> Vec<vk::ImageView> {
        let views = self.colors.iter().flat_map(|color| [color.image_view, color.resolve_image_view]);
        views.filter(|view| *view != vk::ImageView::null()).collect()
    }

    /// Returns the views of depth and stencil.
    fn depths(&self) -> Vec<vk::ImageView> {
        let deep = self.depth.iter().chain(&self.stencil);
        deep.map(|attachment| attachment.image_view).filter(|view| *view != vk::ImageView::null()).collect()
    }

    /// Returns the views of depth and stencil if there are no colours. Secondary command buffers do
    /// not name the images. In passes with such buffers, these attachments are not replaced.
    fn depth_alone(&self) -> Vec<vk::ImageView> {
        let inline = !self.has(vk::RenderingFlags::CONTENTS_SECONDARY_COMMAND_BUFFERS);
        if inline && self.views().is_empty() { self.depths() } else { Vec::new() }
    }

    fn has(&self, flag: vk::RenderingFlags) -> bool {
        self.info.flags.contains(flag)
    }

    /// Returns the pass that draws to the atlas of `target`.
    fn pass(&self, device: &Device, target: &Arc<ViewTarget>) -> Pass {
        let whole = is_whole(&self.info.render_area, &target.layout) && !self.has(vk::RenderingFlags::RESUMING);
        let is_filled = |view| device.images.target(view).is_some_and(|target| target.takes_filled_panel());
        let begins = |color: &vk::RenderingAttachmentInfo<'_>| {
            // Images that are resolved to get the panel of the samples.
            is_filled(color.resolve_image_view);
            let anew = whole && color.load_op != vk::AttachmentLoadOp::LOAD;
            color.image_view != vk::ImageView::null() && (is_filled(color.image_view) || anew)
        };
        let uncleared_panels = (0..).zip(self.colors).filter(|(_, color)| begins(color));
        let uncleared_panels = uncleared_panels.map(|(number, _)| number).collect();
        let kind = |given: &vk::RenderingAttachmentInfo<'_>| device.images.kind(given.image_view);
        let format = |given: Option<&vk::RenderingAttachmentInfo<'_>>| given.and_then(kind).unwrap_or_default().0;
        let within = Within::Rendering {
            colors: self.colors.iter().map(|color| format(Some(color))).collect(),
            depth: format(self.depth),
            stencil: format(self.stencil),
            samples: self.colors.iter().chain(self.depth).find_map(kind).unwrap_or_default().1,
        };
        let mut pass = Pass::new(Arc::clone(target), within, uncleared_panels);
        if !self.has(vk::RenderingFlags::SUSPENDING) {
            let ends = self.colors.iter().flat_map(|color| {
                [(color.image_view, color.image_layout), (color.resolve_image_view, color.resolve_image_layout)]
            });
            let deep = self.depth.iter().chain(&self.stencil).map(|given| (given.image_view, given.image_layout));
            for (view, layout) in ends.chain(deep) {
                let scene = device.images.target(view).filter(|scene| !scene.window);
                let known = |scene: &Arc<ViewTarget>| pass.scenes.iter().any(|(known, _)| Arc::ptr_eq(known, scene));
                pass.scenes.extend(scene.filter(|scene| !known(scene)).map(|scene| (scene, layout)));
            }
        }
        pass
    }
}

/// Begins dynamic rendering with `next`.
///
/// # Safety
/// `info` must be the program's; `next` begins rendering as its argument describes.
pub unsafe fn begin(
    device: &Device,
    buffer: vk::CommandBuffer,
    info: &vk::RenderingInfo<'_>,
    next: impl Fn(&vk::RenderingInfo<'_>),
) {
    // SAFETY: as promised.
    let given = unsafe { Given::of(info) };
    let views = given.views();
    let deep = given.depths();
    let colored = views.iter().chain(&deep).find_map(|view| device.images.target(*view));
    let is_colored = colored.is_some();
    let Some(target) = colored.or_else(|| device.images.window_of_depth(device, &given.depth_alone())) else {
        for attachment in given.depth.iter().chain(&given.stencil).filter(|a| a.load_op == vk::AttachmentLoadOp::LOAD) {
            device.images.goes_on_with(device, attachment.image_view);
        }
        plain(device, buffer, None, &[views, deep].concat());
        return next(info);
    };
    let layout = &target.layout;
    let attached = [&views[..], &deep].concat();
    let moved = barriers_and_clears::moved_before(device, buffer, &attached, layout);
    let (all, clears) = match replace(device, &given, layout) {
        Ok(replaced) => replaced,
        Err(why) => {
            device.show_flat(why);
            plain(device, buffer, Some(Arc::clone(&target)), &attached);
            return next(info);
        }
    };
    let mut changed = (*info).render_area(whole_atlas(layout)).color_attachments(&all.colors);
    if let Some(depth) = &all.depth {
        changed = changed.depth_attachment(depth);
    }
    if let Some(stencil) = &all.stencil {
        changed = changed.stencil_attachment(stencil);
    }
    let mut pass = given.pass(device, &target);
    pass.colored = is_colored;
    if is_colored {
        device.images.draws_together(device, layout, views.iter().chain(&deep).copied());
    }
    // SAFETY: as promised; the clears are recorded directly after the pass has begun, with these
    // attachments.
    unsafe {
        barriers_and_clears::follow(device, buffer, &moved, layout);
        if target.window && !given.has(vk::RenderingFlags::RESUMING) {
            coverage::prepare(device, buffer);
        }
        conditional_render::begin_pass(device, buffer, || {
            next(&changed);
            served(device, buffer, pass);
            if !given.has(vk::RenderingFlags::RESUMING) && !clears.is_empty() {
                let area = vk::ClearRect { rect: info.render_area, base_array_layer: 0, layer_count: 1 };
                barriers_and_clears::clear(device, buffer, layout, &clears, &[area]);
            }
        });
    }
}

/// Returns the attachments over the atlas, and the partial clears that replace the clears of the
/// program's attachments.
///
/// # Errors
/// The reason that prevents the replacement.
fn replace<'a>(
    device: &Device,
    given: &Given<'a>,
    layout: &AtlasLayout,
) -> Result<(Attachments<'a>, Vec<vk::ClearAttachment>), Obstacle> {
    if !device.draws_views() {
        return Err(Obstacle::AlreadyFlat);
    }
    if given.info.view_mask != 0 || given.info.layer_count != 1 {
        return Err("it uses multiview or layers".into());
    }
    let atlas_copy = |view: vk::ImageView| match view == vk::ImageView::null() {
        true => Ok(view),
        false => device.images.atlas_copy(device, view, layout),
    };
    let mut all = Attachments {
        colors: given.colors.iter().map(|color| attachment(color, &atlas_copy)).collect::<Result<_, _>>()?,
        depth: given.depth.map(|depth| attachment(depth, &atlas_copy)).transpose()?,
        stencil: given.stencil.map(|stencil| attachment(stencil, &atlas_copy)).transpose()?,
    };
    let clears = if is_whole(&given.info.render_area, layout) { Vec::new() } else { all.keep() };
    if given.has(vk::RenderingFlags::CONTENTS_SECONDARY_COMMAND_BUFFERS) && !clears.is_empty() {
        return Err("it clears a part of the window in a pass of secondary command buffers".into());
    }
    Ok((all, clears))
}

/// Returns an attachment with atlas copies in place of its images.
fn attachment<'a>(
    given: &vk::RenderingAttachmentInfo<'a>,
    atlas_copy: &dyn Fn(vk::ImageView) -> Result<vk::ImageView, Obstacle>,
) -> Result<vk::RenderingAttachmentInfo<'a>, Obstacle> {
    let mut changed = *given;
    changed.image_view = atlas_copy(given.image_view)?;
    changed.resolve_image_view = atlas_copy(given.resolve_image_view)?;
    Ok(changed)
}

/// Attachments of dynamic rendering.
struct Attachments<'a> {
    colors: Vec<vk::RenderingAttachmentInfo<'a>>,
    depth: Option<vk::RenderingAttachmentInfo<'a>>,
    stencil: Option<vk::RenderingAttachmentInfo<'a>>,
}

impl Attachments<'_> {
    /// Makes all attachments load their content. Returns the clears that must be recorded as
    /// commands instead.
    fn keep(&mut self) -> Vec<vk::ClearAttachment> {
        use vk::ImageAspectFlags as A;
        let colors = (0..).zip(&mut self.colors).map(|(number, color)| (A::COLOR, number, color));
        let deep = self.depth.iter_mut().map(|depth| (A::DEPTH, 0, depth));
        let stencil = self.stencil.iter_mut().map(|stencil| (A::STENCIL, 0, stencil));
        let mut clears = Vec::new();
        for (aspect_mask, color_attachment, attachment) in colors.chain(deep).chain(stencil) {
            if attachment.image_view == vk::ImageView::null() {
                continue;
            }
            let load = std::mem::replace(&mut attachment.load_op, vk::AttachmentLoadOp::LOAD);
            if load == vk::AttachmentLoadOp::CLEAR {
                clears.push(vk::ClearAttachment { aspect_mask, color_attachment, clear_value: attachment.clear_value });
            }
        }
        clears
    }
}

hooks! {
    cmd_begin_rendering = (
        buffer: vk::CommandBuffer, info: *const vk::RenderingInfo<'_>
    ) { |state, next| {
        conditional_render::pass_follows(&state, buffer, !(*info).flags.contains(vk::RenderingFlags::CONTENTS_SECONDARY_COMMAND_BUFFERS));
        begin(&state, buffer, &*info, |info| next(buffer, info))
    } }
    cmd_end_rendering = (
        buffer: vk::CommandBuffer
    ) { |state, next| {
        end(&state, buffer, || next(buffer))
    } }
}
