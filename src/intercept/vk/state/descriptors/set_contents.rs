//! Content that the program wrote to a descriptor set, and the copies of the set for each view.

use crate::intercept::vk::state::images::ViewCopies;
use ash::vk;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A descriptor: binding and element of its array.
pub type DescriptorSlot = (u32, u32);

/// Descriptor of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DescriptorPicture {
    /// The view of its image.
    pub(in crate::intercept::vk) view: vk::ImageView,
    /// The sampler, if the layout has none.
    pub(in crate::intercept::vk) sampler: vk::Sampler,
    /// Layout of the image, if it is an attachment that is read at the pixel that is drawn.
    pub(in crate::intercept::vk) attachment: Option<vk::ImageLayout>,
    /// True if shaders may write it.
    pub(in crate::intercept::vk) stored: bool,
}

/// Descriptors that were written to a set.
#[derive(Default)]
pub struct Contents {
    pub(in crate::intercept::vk) written: BTreeSet<DescriptorSlot>,
    pub(in crate::intercept::vk) pictures: BTreeMap<DescriptorSlot, DescriptorPicture>,
    /// Increases with each change.
    pub(in crate::intercept::vk) version: u64,
}

impl Contents {
    /// Notes a written descriptor, with its picture if it has one.
    pub fn write(&mut self, place: DescriptorSlot, picture: Option<DescriptorPicture>) {
        self.version += 1;
        self.written.insert(place);
        match picture {
            Some(picture) => self.pictures.insert(place, picture),
            None => self.pictures.remove(&place),
        };
    }

    /// Copies a descriptor of another set to a descriptor of this one.
    pub fn copy(&mut self, from: &Self, source: DescriptorSlot, target: DescriptorSlot) {
        if from.written.contains(&source) {
            self.write(target, from.pictures.get(&source).copied());
        }
    }

    /// Returns the views of the images that shaders can sample.
    pub fn views(&self) -> impl Iterator<Item = vk::ImageView> + '_ {
        let sampled = |picture: &&DescriptorPicture| picture.attachment.is_none() && !picture.stored;
        self.pictures.values().filter(sampled).map(|picture| picture.view)
    }

    /// Returns the views of the images that shaders can write.
    pub fn stored(&self) -> impl Iterator<Item = vk::ImageView> + '_ {
        self.pictures.values().filter(|picture| picture.stored).map(|picture| picture.view)
    }

    /// True if shaders can read attachments.
    pub fn reads_attachments(&self) -> bool {
        self.pictures.values().any(|picture| picture.attachment.is_some())
    }
}

/// The copies of a set.
pub struct Copies {
    pub(in crate::intercept::vk) pool: vk::DescriptorPool,
    pub(in crate::intercept::vk) version: u64,
    pub(in crate::intercept::vk) view_copies: Vec<CopiedDescriptor>,
    pub(in crate::intercept::vk) sets: Arc<[vk::DescriptorSet]>,
    /// Pools of copies that may still be in use.
    pub(in crate::intercept::vk) retired: Vec<vk::DescriptorPool>,
}

/// A descriptor of an image of the scene, and the images that replace it in the views.
pub(in crate::intercept::vk) type CopiedDescriptor = (DescriptorSlot, DescriptorPicture, ViewCopies);

#[cfg(test)]
mod tests {
    use super::{Contents, DescriptorPicture};
    use ash::vk::{self, Handle};

    #[test]
    fn what_was_written_last_counts() {
        let picture =
            |number| DescriptorPicture { view: vk::ImageView::from_raw(number), ..DescriptorPicture::default() };
        let (mut from, mut to) = (Contents::default(), Contents::default());
        from.write((3, 1), Some(picture(7)));
        to.copy(&from, (3, 1), (0, 0));
        to.copy(&from, (9, 9), (1, 0));
        assert_eq!(to.views().collect::<Vec<_>>(), [vk::ImageView::from_raw(7)]);
        assert_eq!(to.written.len(), 1, "what was never written is not copied");
        let version = to.version;
        to.write((0, 0), None);
        assert!(to.views().next().is_none() && to.version > version);
        to.write((0, 0), Some(DescriptorPicture { attachment: Some(vk::ImageLayout::GENERAL), ..picture(8) }));
        assert!(to.views().next().is_none() && to.reads_attachments(), "an attachment is not sampled");
    }
}
