//! Render passes and framebuffers: their attachments, and framebuffers over an atlas.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::{in_chain, slice};
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::images::framebuffers::{Framebuffer, Framebuffers, LaterAttachment, RenderPass};
use crate::intercept::vk::state::views::view_target::{ATLAS_FLAGS, ATLAS_USAGE, ViewTarget};
use crate::lock::Lock;
use ash::vk;
use std::sync::{Arc, Mutex};

impl Framebuffers {
    /// Returns the view target that any framebuffer for a render pass contains.
    pub fn target_by_pass(&self, device: &Device, pass: vk::RenderPass) -> Option<Arc<ViewTarget>> {
        let all: Vec<_> = {
            let all = self.all.locked();
            all.values().filter(|framebuffer| framebuffer.pass == pass).cloned().collect()
        };
        let depth = |framebuffer: &Arc<Framebuffer>| {
            device.images.window_of_depth(device, framebuffer.attachments.as_deref().unwrap_or_default())
        };
        let colored = all.iter().find_map(|framebuffer| framebuffer.target_now(&device.images));
        colored.or_else(|| all.iter().find_map(depth))
    }

    /// Returns the window's image that a framebuffer without images may be used with, for a render
    /// pass: the image of the latest window, if size and format are equal.
    pub fn target_later(&self, device: &Device, handle: vk::RenderPass) -> Option<Arc<ViewTarget>> {
        let pass = self.pass(handle)?;
        let size = {
            let all = self.all.locked();
            all.values().find(|framebuffer| framebuffer.pass == handle && framebuffer.attachments.is_none())?.size
        };
        let target = pass.formats.iter().find_map(|format| device.swapchains.latest_target(*format));
        target.filter(|target| target.layout.window == size)
    }
}

impl Framebuffer {
    /// Returns the framebuffer over the atlas of `target`, for a render pass that is compatible
    /// with the program's. `given`: the attachments of the pass that begins, if they are given
    /// there.
    ///
    /// # Errors
    /// The reason why there is none.
    pub fn atlas_copy(
        &self,
        device: &Device,
        target: &ViewTarget,
        pass: vk::RenderPass,
        given: &[vk::ImageView],
    ) -> Result<vk::Framebuffer, Obstacle> {
        let size = target.layout.atlas;
        let known = self.atlas_copies.locked().iter().find(|t| t.0 == size).map(|t| t.1);
        if let Some(known) = known {
            return Ok(known);
        }
        if self.layered || self.size != target.layout.window {
            return Err("it draws to layers, or to a part of the window".into());
        }
        let mut info = vk::FramebufferCreateInfo::default().render_pass(pass).width(size.0).height(size.1).layers(1);
        let views: Vec<vk::ImageView>;
        let images: Vec<vk::FramebufferAttachmentImageInfo<'_>>;
        let mut later;
        match &self.attachments {
            Some(attachments) => {
                let atlas_copy = |view: &vk::ImageView| device.images.atlas_copy(device, *view, &target.layout);
                views = attachments.iter().map(atlas_copy).collect::<Result<_, _>>()?;
                info = info.attachments(&views);
            }
            None => {
                let image = |(index, later): (usize, &'_ LaterAttachment)| {
                    let target = given.get(index).and_then(|view| device.images.target(*view));
                    let (flags, usage) = match target {
                        Some(target) if target.window => (ATLAS_FLAGS, ATLAS_USAGE),
                        _ => {
                            let usage = given.get(index).and_then(|view| device.images.atlas_copy_usage(*view));
                            (later.flags, usage.unwrap_or(later.usage))
                        }
                    };
                    let info = vk::FramebufferAttachmentImageInfo::default().flags(flags).usage(usage);
                    info.width(size.0).height(size.1).layer_count(1)
                };
                let all = self.given_later.iter().enumerate();
                images = all.map(|(index, later)| image((index, later)).view_formats(&later.formats)).collect();
                later = vk::FramebufferAttachmentsCreateInfo::default().attachment_image_infos(&images);
                info = info.flags(vk::FramebufferCreateFlags::IMAGELESS).push_next(&mut later);
                info.attachment_count = images.len() as u32;
            }
        }
        // SAFETY: the structures are complete, the atlas copies are as large as the atlas.
        let made = unsafe { device.driver.functions.create_framebuffer(&info, None) };
        let made = made.map_err(|error| format!("the driver refuses a framebuffer: {error}"))?;
        self.atlas_copies.locked().push((size, made));
        Ok(made)
    }
}

/// # Safety
/// `info` must be the program's.
unsafe fn framebuffer(info: &vk::FramebufferCreateInfo<'_>) -> Framebuffer {
    // SAFETY: as promised.
    unsafe {
        let imageless = info.flags.contains(vk::FramebufferCreateFlags::IMAGELESS);
        let attachments = (!imageless).then(|| slice(info.p_attachments, info.attachment_count).to_vec());
        let later = vk::StructureType::FRAMEBUFFER_ATTACHMENTS_CREATE_INFO;
        let later = in_chain::<vk::FramebufferAttachmentsCreateInfo<'_>>(info.p_next, later);
        let later = later.map_or(&[][..], |l| slice(l.p_attachment_image_infos, l.attachment_image_info_count));
        let formats =
            |i: &vk::FramebufferAttachmentImageInfo<'_>| slice(i.p_view_formats, i.view_format_count).to_vec();
        let given_later =
            later.iter().map(|i| LaterAttachment { flags: i.flags, usage: i.usage, formats: formats(i) }).collect();
        Framebuffer {
            pass: info.render_pass,
            size: (info.width, info.height),
            layered: info.layers != 1,
            attachments,
            given_later,
            atlas_copies: Mutex::default(),
        }
    }
}

/// True if the attachment begins cleared or without content.
fn anew(load: vk::AttachmentLoadOp) -> bool {
    load != vk::AttachmentLoadOp::LOAD
}

/// True if all of an attachment can be drawn although the pass draws only a part: its old content
/// is loaded, or there is none.
fn may_grow(load: vk::AttachmentLoadOp, layout: vk::ImageLayout) -> bool {
    load == vk::AttachmentLoadOp::LOAD || layout == vk::ImageLayout::UNDEFINED
}

/// # Safety
/// `info` must be the program's.
unsafe fn render_pass(info: &vk::RenderPassCreateInfo<'_>) -> RenderPass {
    // SAFETY: as promised.
    unsafe {
        let subpasses = slice(info.p_subpasses, info.subpass_count);
        let multiview = vk::StructureType::RENDER_PASS_MULTIVIEW_CREATE_INFO;
        let multiview = in_chain::<vk::RenderPassMultiviewCreateInfo<'_>>(info.p_next, multiview);
        let masks = multiview.map_or(&[][..], |m| slice(m.p_view_masks, m.subpass_count));
        let colors = |s: &vk::SubpassDescription<'_>| {
            used(slice(s.p_color_attachments, s.color_attachment_count), |r| r.attachment)
        };
        let attachments = slice(info.p_attachments, info.attachment_count).iter();
        RenderPass {
            colors: subpasses.iter().map(colors).collect(),
            begins_anew: attachments.clone().map(|a| anew(a.load_op)).collect(),
            may_grow: attachments.clone().all(|a| may_grow(a.load_op, a.initial_layout)),
            formats: attachments.clone().map(|a| a.format).collect(),
            finds: attachments.clone().map(|a| a.initial_layout).collect(),
            leaves: attachments.map(|a| a.final_layout).collect(),
            obstacle: obstacle(masks.iter().any(|m| *m != 0)),
        }
    }
}

/// # Safety
/// `info` must be the program's.
unsafe fn render_pass2(info: &vk::RenderPassCreateInfo2<'_>) -> RenderPass {
    // SAFETY: as promised.
    unsafe {
        let subpasses = slice(info.p_subpasses, info.subpass_count);
        let colors = |s: &vk::SubpassDescription2<'_>| {
            used(slice(s.p_color_attachments, s.color_attachment_count), |r| r.attachment)
        };
        let attachments = slice(info.p_attachments, info.attachment_count).iter();
        RenderPass {
            colors: subpasses.iter().map(colors).collect(),
            begins_anew: attachments.clone().map(|a| anew(a.load_op)).collect(),
            may_grow: attachments.clone().all(|a| may_grow(a.load_op, a.initial_layout)),
            formats: attachments.clone().map(|a| a.format).collect(),
            finds: attachments.clone().map(|a| a.initial_layout).collect(),
            leaves: attachments.map(|a| a.final_layout).collect(),
            obstacle: obstacle(subpasses.iter().any(|s| s.view_mask != 0)),
        }
    }
}

fn used<R>(references: &[R], attachment: impl Fn(&R) -> u32) -> Vec<(u32, u32)> {
    let attachments = references.iter().map(attachment);
    (0..).zip(attachments).filter(|(_, attachment)| *attachment != vk::ATTACHMENT_UNUSED).collect()
}

fn obstacle(multiview: bool) -> Option<&'static str> {
    multiview.then_some("it uses multiview or layers")
}

impl Framebuffers {
    fn add(&self, handle: vk::RenderPass, pass: RenderPass) {
        self.passes.locked().insert(handle, Arc::new(pass));
    }
}

hooks! {
    create_render_pass = (
        device: vk::Device, info: *const vk::RenderPassCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, pass: *mut vk::RenderPass
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, pass);
        if result == vk::Result::SUCCESS {
            state.framebuffers.add(*pass, render_pass(&*info));
        }
        result
    } }
    create_render_pass2 = (
        device: vk::Device, info: *const vk::RenderPassCreateInfo2<'_>, allocator: *const vk::AllocationCallbacks<'_>, pass: *mut vk::RenderPass
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, pass);
        if result == vk::Result::SUCCESS {
            state.framebuffers.add(*pass, render_pass2(&*info));
        }
        result
    } }
    destroy_render_pass = (
        device: vk::Device, pass: vk::RenderPass, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.framebuffers.passes.locked().remove(&pass);
        next(device, pass, allocator)
    } }
    create_framebuffer = (
        device: vk::Device, info: *const vk::FramebufferCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, made: *mut vk::Framebuffer
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, made);
        if result == vk::Result::SUCCESS {
            let new = Arc::new(framebuffer(&*info));
            // Made now, because the render pass may be destroyed later.
            if let (true, Some(target)) = (state.draws_views(), new.target_now(&state.images))
                && let Err(why) = new.atlas_copy(&state, &target, new.pass, &[])
            {
                state.show_flat(why);
            }
            state.framebuffers.all.locked().insert(*made, new);
        }
        result
    } }
    destroy_framebuffer = (
        device: vk::Device, framebuffer: vk::Framebuffer, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        let gone = state.framebuffers.all.locked().remove(&framebuffer);
        if let Some(gone) = gone {
            for (_, atlas_copy) in gone.atlas_copies.locked().drain(..) {
                state.driver.functions.destroy_framebuffer(atlas_copy, None);
            }
        }
        next(device, framebuffer, allocator)
    } }
}
