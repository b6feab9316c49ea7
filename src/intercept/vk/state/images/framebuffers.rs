//! Render passes and framebuffers of the program.

use crate::intercept::vk::state::images::Images;
use crate::intercept::vk::state::views::view_target::ViewTarget;
use crate::lock::Lock;
use ash::vk;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// A render pass.
pub struct RenderPass {
    /// Colour attachments that each subpass uses: number in the subpass, and attachment.
    pub(in crate::intercept::vk) colors: Vec<Vec<(u32, u32)>>,
    /// For each attachment, true if its old content is not needed.
    pub(in crate::intercept::vk) begins_anew: Vec<bool>,
    /// True if drawing may extend beyond the area of the pass: either all content outside is kept,
    /// or none.
    pub(in crate::intercept::vk) may_grow: bool,
    /// The attachments' formats.
    pub(in crate::intercept::vk) formats: Vec<vk::Format>,
    /// Layouts of the attachments before the pass.
    pub(in crate::intercept::vk) finds: Vec<vk::ImageLayout>,
    /// Layouts of the attachments after the pass.
    pub(in crate::intercept::vk) leaves: Vec<vk::ImageLayout>,
    /// Reason why it cannot be drawn for each view; `None` if it can.
    pub(in crate::intercept::vk) obstacle: Option<&'static str>,
}

/// A framebuffer.
pub struct Framebuffer {
    /// The render pass that it was made for.
    pub(in crate::intercept::vk) pass: vk::RenderPass,
    /// Its size.
    pub(in crate::intercept::vk) size: (u32, u32),
    /// True if it has more than one layer.
    pub(in crate::intercept::vk) layered: bool,
    /// Its attachments, unless they are given when a pass begins.
    pub(in crate::intercept::vk) attachments: Option<Vec<vk::ImageView>>,
    /// Properties of attachments that are given later.
    pub(in crate::intercept::vk) given_later: Vec<LaterAttachment>,
    /// Copies with the atlas attached, by the size of the atlas. If attachments are given later,
    /// there is only one copy.
    pub(in crate::intercept::vk) atlas_copies: Mutex<Vec<((u32, u32), vk::Framebuffer)>>,
}

/// An attachment that is given when a pass begins.
pub(in crate::intercept::vk) struct LaterAttachment {
    pub(in crate::intercept::vk) flags: vk::ImageCreateFlags,
    pub(in crate::intercept::vk) usage: vk::ImageUsageFlags,
    pub(in crate::intercept::vk) formats: Vec<vk::Format>,
}

/// Render passes and framebuffers.
#[derive(Default)]
pub struct Framebuffers {
    pub(in crate::intercept::vk) passes: Mutex<HashMap<vk::RenderPass, Arc<RenderPass>>>,
    pub(in crate::intercept::vk) all: Mutex<HashMap<vk::Framebuffer, Arc<Framebuffer>>>,
}

impl RenderPass {
    /// Returns the colour attachments of a subpass, by their number in it, whose use begins there
    /// without old content.
    pub fn begin_in(&self, subpass: usize) -> Vec<u32> {
        let (earlier, colors) = self.colors.split_at(subpass.min(self.colors.len()));
        let drawn = |attachment: u32| earlier.iter().flatten().any(|(_, known)| *known == attachment);
        let anew = |attachment: u32| self.begins_anew.get(attachment as usize).copied().unwrap_or(true);
        let begin = |(_, attachment): &&(u32, u32)| anew(*attachment) && !drawn(*attachment);
        colors.first().into_iter().flatten().filter(begin).map(|(number, _)| *number).collect()
    }

    /// Returns those of the first subpass, and its attachments that are `filled`.
    pub fn begin_with(&self, filled: &[bool]) -> Vec<u32> {
        let mut begin = self.begin_in(0);
        for (number, attachment) in self.colors.iter().take(1).flatten() {
            let is_filled = filled.get(*attachment as usize).copied().unwrap_or(false);
            if is_filled && !begin.contains(number) {
                begin.push(*number);
            }
        }
        begin
    }
}

impl Framebuffers {
    /// Returns a render pass.
    pub fn pass(&self, handle: vk::RenderPass) -> Option<Arc<RenderPass>> {
        self.passes.locked().get(&handle).cloned()
    }

    /// Returns a framebuffer.
    pub fn get(&self, handle: vk::Framebuffer) -> Option<Arc<Framebuffer>> {
        self.all.locked().get(&handle).cloned()
    }
}

impl Framebuffer {
    /// Returns the target of the first attachment that is a window's image, or holds a scene by
    /// now.
    pub fn target_now(&self, images: &Images) -> Option<Arc<ViewTarget>> {
        self.attachments.iter().flatten().find_map(|view| images.target(*view))
    }
}

#[cfg(test)]
mod tests {
    use super::RenderPass;

    #[test]
    fn an_attachment_begins_with_the_first_subpass_that_draws_to_it() {
        let pass = RenderPass {
            colors: vec![vec![(0, 2), (1, 0)], vec![(0, 0), (1, 1), (2, 3)]],
            begins_anew: vec![true, true, true, false],
            may_grow: true,
            formats: Vec::new(),
            finds: Vec::new(),
            leaves: Vec::new(),
            obstacle: None,
        };
        assert_eq!(pass.begin_with(&[true, true, false, true]), [0, 1]);
        let keeps = RenderPass { begins_anew: vec![false; 4], ..pass };
        assert_eq!(keeps.begin_with(&[false, true, true, true]), [0], "one that is filled, in the first subpass");
        let pass = RenderPass { begins_anew: vec![true, true, true, false], ..keeps };
        assert_eq!((pass.begin_in(0), pass.begin_in(1), pass.begin_in(2)), (vec![0, 1], vec![1], vec![]));
    }
}
