//! Descriptor sets of the program, their layouts and update templates.
//!
//! [`set_contents`] holds the descriptors that the program wrote to a set. The per-view copies of
//! the set are made from it.

pub mod set_contents;

use crate::intercept::vk::state::descriptors::set_contents::{Contents, Copies, DescriptorPicture, DescriptorSlot};
use crate::lock::Lock;
use ash::vk;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// The layout of a descriptor set.
#[derive(Default)]
pub struct SetLayout {
    /// Type and number of each binding.
    pub(in crate::intercept::vk) bindings: BTreeMap<u32, (vk::DescriptorType, u32)>,
    /// True if its descriptors lie in buffers. No set of Cupola can be bound beside such a set.
    pub(in crate::intercept::vk) apart: bool,
    /// True if descriptors may change while they are bound.
    pub(in crate::intercept::vk) changes_later: bool,
}

/// True for buffers whose offset is given when they are bound.
pub fn is_dynamic(kind: vk::DescriptorType) -> bool {
    [vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC, vk::DescriptorType::STORAGE_BUFFER_DYNAMIC].contains(&kind)
}

pub(in crate::intercept::vk) fn is_buffer(kind: vk::DescriptorType) -> bool {
    is_dynamic(kind) || [vk::DescriptorType::UNIFORM_BUFFER, vk::DescriptorType::STORAGE_BUFFER].contains(&kind)
}

impl SetLayout {
    /// Returns the descriptor at a binding and element. If an update has more elements than the
    /// binding, it continues in the next binding.
    fn slot(&self, (binding, element): DescriptorSlot) -> DescriptorSlot {
        let mut rest = element;
        for (binding, (_, count)) in self.bindings.range(binding..) {
            if rest < *count {
                return (*binding, rest);
            }
            rest -= count;
        }
        (binding, element)
    }

    /// Returns the number of dynamic offsets that are given when such a set is bound.
    pub fn dynamic_offsets(&self) -> u32 {
        self.bindings.values().filter(|(kind, _)| is_dynamic(*kind)).map(|(_, count)| count).sum()
    }

    /// Returns the index of the dynamic offset of a binding's first descriptor; `None` if it has
    /// none.
    pub(in crate::intercept::vk) fn dynamic_index(&self, binding: u32) -> Option<usize> {
        self.bindings.get(&binding).filter(|(kind, _)| is_dynamic(*kind))?;
        let before = self.bindings.range(..binding).filter(|(_, (kind, _))| is_dynamic(*kind));
        Some(before.map(|(_, (_, count))| *count as usize).sum())
    }
}

/// A descriptor set.
pub(in crate::intercept::vk) struct Set {
    pub(in crate::intercept::vk) pool: vk::DescriptorPool,
    pub(in crate::intercept::vk) handle: vk::DescriptorSetLayout,
    pub(in crate::intercept::vk) layout: Arc<SetLayout>,
    pub(in crate::intercept::vk) contents: Contents,
    pub(in crate::intercept::vk) copies: Option<Copies>,
    /// The first buffer of each binding, and its offset.
    pub(in crate::intercept::vk) buffers: HashMap<u32, (vk::Buffer, u64)>,
}

/// An entry of a template.
pub struct TemplateEntry {
    /// The binding that it describes.
    pub(in crate::intercept::vk) binding: u32,
    /// The first element in the binding.
    pub(in crate::intercept::vk) first: u32,
    /// Kind of the descriptors.
    pub(in crate::intercept::vk) kind: vk::DescriptorType,
    /// Number of descriptors.
    pub(in crate::intercept::vk) count: u32,
    /// Offset of the first descriptor in the program's data, in bytes.
    pub(in crate::intercept::vk) offset: usize,
    /// Distance of two descriptors, in bytes.
    pub(in crate::intercept::vk) stride: usize,
}

/// A template for updates of descriptors.
pub struct Template {
    /// Its entries.
    pub(in crate::intercept::vk) entries: Vec<TemplateEntry>,
    /// True if descriptors that are pushed with it are for graphics.
    pub(in crate::intercept::vk) graphics: bool,
}

/// Descriptor sets and their layouts.
#[derive(Default)]
pub struct Descriptors {
    pub(in crate::intercept::vk) layouts: Mutex<HashMap<vk::DescriptorSetLayout, Arc<SetLayout>>>,
    pub(in crate::intercept::vk) sets: Mutex<HashMap<vk::DescriptorSet, Set>>,
    pub(in crate::intercept::vk) templates: Mutex<HashMap<vk::DescriptorUpdateTemplate, Arc<Template>>>,
    /// True if any set has had attachments that shaders can read.
    pub(in crate::intercept::vk) attachments: AtomicBool,
}

impl Descriptors {
    /// Returns a layout.
    pub fn layout(&self, handle: vk::DescriptorSetLayout) -> Option<Arc<SetLayout>> {
        self.layouts.locked().get(&handle).cloned()
    }

    /// Returns a template.
    pub fn template(&self, handle: vk::DescriptorUpdateTemplate) -> Option<Arc<Template>> {
        self.templates.locked().get(&handle).cloned()
    }

    /// Returns the number of dynamic offsets that are given when a set is bound.
    pub fn dynamic_offsets(&self, set: vk::DescriptorSet) -> u32 {
        let sets = self.sets.locked();
        sets.get(&set).map_or(0, |set| set.layout.dynamic_offsets())
    }

    /// Returns the buffer of a binding of a set that is bound with `dynamic` offsets, and its
    /// offset.
    pub fn buffer(&self, set: vk::DescriptorSet, dynamic: &[u32], binding: u32) -> Option<(vk::Buffer, u64)> {
        let sets = self.sets.locked();
        let state = sets.get(&set)?;
        let (buffer, offset) = *state.buffers.get(&binding)?;
        let moved = state.layout.dynamic_index(binding).and_then(|index| dynamic.get(index)).copied();
        Some((buffer, offset + u64::from(moved.unwrap_or(0))))
    }

    pub(in crate::intercept::vk) fn describe(
        &self,
        set: vk::DescriptorSet,
        place: DescriptorSlot,
        buffer: &vk::DescriptorBufferInfo,
    ) {
        if let Some(set) = self.sets.locked().get_mut(&set)
            && let (binding, 0) = set.layout.slot(place)
        {
            set.buffers.insert(binding, (buffer.buffer, buffer.offset));
        }
    }

    /// Returns the views of the images that shaders can read through a set.
    pub fn pictures(&self, set: vk::DescriptorSet) -> Vec<vk::ImageView> {
        let sets = self.sets.locked();
        sets.get(&set).map_or(Vec::new(), |set| set.contents.views().collect())
    }

    /// Returns the views of the images that shaders can write through a set.
    pub fn stored(&self, set: vk::DescriptorSet) -> Vec<vk::ImageView> {
        let sets = self.sets.locked();
        sets.get(&set).map_or(Vec::new(), |set| set.contents.stored().collect())
    }

    /// Returns the views of the images of a binding.
    pub fn pictures_of(&self, set: vk::DescriptorSet, binding: u32) -> Vec<vk::ImageView> {
        let sets = self.sets.locked();
        let of_binding = |set: &Set| {
            let pictures = set.contents.pictures.range((binding, 0)..=(binding, u32::MAX));
            pictures.map(|(_, picture)| picture.view).collect()
        };
        sets.get(&set).map_or(Vec::new(), of_binding)
    }

    /// Returns the view of the image that shaders can sample through a descriptor.
    pub fn picture(&self, set: vk::DescriptorSet, place: DescriptorSlot) -> Option<vk::ImageView> {
        let sets = self.sets.locked();
        let picture = sets.get(&set)?.contents.pictures.get(&place)?;
        (picture.attachment.is_none() && !picture.stored).then_some(picture.view)
    }

    /// True if shaders can read attachments through a set.
    pub fn reads_attachments(&self, set: vk::DescriptorSet) -> bool {
        let sets = self.sets.locked();
        sets.get(&set).is_some_and(|set| set.contents.reads_attachments())
    }

    /// True if any written set lets shaders read attachments.
    pub fn any_attachments(&self) -> bool {
        self.attachments.load(Ordering::Relaxed)
    }

    pub(in crate::intercept::vk) fn write(
        &self,
        set: vk::DescriptorSet,
        place: (u32, u32),
        picture: Option<DescriptorPicture>,
    ) {
        if picture.is_some_and(|picture| picture.attachment.is_some()) {
            self.attachments.store(true, Ordering::Relaxed);
        }
        if let Some(set) = self.sets.locked().get_mut(&set) {
            let place = set.layout.slot(place);
            set.contents.write(place, picture);
        }
    }

    pub(in crate::intercept::vk) fn copy(&self, copy: &vk::CopyDescriptorSet<'_>) {
        let mut sets = self.sets.locked();
        // The contents are taken out and put back, because both sets may be the same.
        let mut contents = sets.get_mut(&copy.dst_set).map(|set| std::mem::take(&mut set.contents)).unwrap_or_default();
        let layout = sets.get(&copy.dst_set).map(|set| Arc::clone(&set.layout)).unwrap_or_default();
        if let Some(from) = sets.get(&copy.src_set).filter(|_| copy.src_set != copy.dst_set) {
            for index in 0..copy.descriptor_count {
                let source = from.layout.slot((copy.src_binding, copy.src_array_element + index));
                let target = layout.slot((copy.dst_binding, copy.dst_array_element + index));
                contents.copy(&from.contents, source, target);
            }
        }
        if let Some(to) = sets.get_mut(&copy.dst_set) {
            to.contents = contents;
        }
        if copy.src_array_element != 0 || copy.dst_array_element != 0 {
            return;
        }
        let from = sets.get(&copy.src_set).and_then(|set| set.buffers.get(&copy.src_binding)).copied();
        if let (Some(from), Some(to)) = (from, sets.get_mut(&copy.dst_set)) {
            to.buffers.insert(copy.dst_binding, from);
        }
    }
}

/// True if shaders access images through descriptors of this type.
pub fn is_picture(kind: vk::DescriptorType) -> bool {
    use vk::DescriptorType as T;
    [T::COMBINED_IMAGE_SAMPLER, T::SAMPLED_IMAGE, T::STORAGE_IMAGE, T::INPUT_ATTACHMENT].contains(&kind)
}

/// True for descriptor types in which a picture of the scene can be replaced.
pub fn is_sampled(kind: vk::DescriptorType) -> bool {
    [vk::DescriptorType::COMBINED_IMAGE_SAMPLER, vk::DescriptorType::SAMPLED_IMAGE].contains(&kind)
}

/// Returns the picture of a descriptor of this type; `None` for types in which it cannot be
/// replaced.
pub(in crate::intercept::vk) fn picture(
    info: &vk::DescriptorImageInfo,
    kind: vk::DescriptorType,
) -> Option<DescriptorPicture> {
    let attachment = (kind == vk::DescriptorType::INPUT_ATTACHMENT).then_some(info.image_layout);
    let stored = kind == vk::DescriptorType::STORAGE_IMAGE;
    let picture = DescriptorPicture { view: info.image_view, sampler: info.sampler, attachment, stored };
    (is_sampled(kind) || stored || attachment.is_some()).then_some(picture)
}

#[cfg(test)]
mod tests {
    use super::SetLayout;
    use ash::vk::DescriptorType as T;

    #[test]
    fn dynamic_offsets_are_in_the_order_of_bindings() {
        let bindings =
            [(5, (T::UNIFORM_BUFFER_DYNAMIC, 1)), (1, (T::STORAGE_BUFFER_DYNAMIC, 2)), (3, (T::UNIFORM_BUFFER, 1))];
        let layout = SetLayout { bindings: bindings.into_iter().collect(), apart: false, changes_later: false };
        assert_eq!(layout.dynamic_offsets(), 3);
        assert_eq!(layout.dynamic_index(1), Some(0));
        assert_eq!(layout.dynamic_index(5), Some(2));
        assert_eq!(layout.dynamic_index(3), None);
        let places = [(1, 0), (1, 1), (1, 2), (1, 3), (1, 4)].map(|place| layout.slot(place));
        assert_eq!(places, [(1, 0), (1, 1), (3, 0), (5, 0), (1, 4)], "updates continue in the next binding");
    }
}
