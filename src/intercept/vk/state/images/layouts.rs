//! Layouts of images: those that commands leave, and the changes that wait for the next submission.

use crate::intercept::vk::state::images::Images;
use crate::intercept::vk::state::images::image::{LayoutChange, PendingLayout, aspects};
use crate::lock::Lock;
use ash::vk;

impl Images {
    /// Notes a recorded change of an image's layout. Returns whether the image is known.
    pub fn moved(&self, image: vk::Image, layout: vk::ImageLayout) -> bool {
        let mut images = self.images.locked();
        let state = images.get_mut(&image);
        state.map(|state| state.layout = layout).is_some()
    }

    /// Notes that commands that change an image to a layout were submitted.
    pub fn submitted(&self, image: vk::Image, layout: vk::ImageLayout) {
        if let Some(state) = self.images.locked().get_mut(&image) {
            state.submitted_layout = layout;
        }
    }

    /// Notes that a pass would have changed an image to a layout, but draws to its atlas copy.
    /// Returns the change that has to be done instead.
    pub fn change_layout(&self, image: vk::Image, layout: vk::ImageLayout) -> Option<LayoutChange> {
        let mut images = self.images.locked();
        let state = images.get_mut(&image).filter(|state| state.layout != layout)?;
        state.layout = layout;
        Some(LayoutChange { image, aspects: aspects(state.format), layout })
    }

    /// Takes the layout changes that have to be done before the next submission.
    pub fn take_pending(&self) -> Vec<PendingLayout> {
        std::mem::take(&mut self.pending.locked())
    }

    /// Notes that an image of Cupola with a pending change of its layout will have the layout
    /// `found` instead. Returns the image, its aspects, and the layout of the pending change.
    pub fn begins_in(
        &self,
        image: vk::Image,
        found: vk::ImageLayout,
    ) -> Option<(vk::Image, vk::ImageAspectFlags, vk::ImageLayout)> {
        let mut pending = self.pending.locked();
        let index = pending.iter().position(|pending| pending.image == image)?;
        let PendingLayout { aspects, layout, .. } = pending[index];
        match found == vk::ImageLayout::UNDEFINED {
            true => drop(pending.swap_remove(index)),
            false => pending[index].layout = found,
        }
        Some((image, aspects, layout))
    }
}
