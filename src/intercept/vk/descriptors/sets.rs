//! Descriptor sets of the program: which buffer a binding leads to.

use crate::intercept::vk::descriptors::per_view_sets::{Contents, Copies, Original, Picture};
use crate::intercept::vk::layer::device::Device;
use crate::intercept::vk::layer::hooks::hooks;
use crate::intercept::vk::swapchain::atlas_layout::Layout;
use ash::vk;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// The layout of a descriptor set.
#[derive(Default)]
pub struct SetLayout {
    /// Type and number of each binding.
    pub bindings: BTreeMap<u32, (vk::DescriptorType, u32)>,
    /// Its descriptors lie in buffers: no set of ours can be bound beside them.
    pub apart: bool,
    /// Descriptors may change while they are bound.
    pub changes_later: bool,
}

/// Buffers whose offset is given when they are bound.
pub fn is_dynamic(kind: vk::DescriptorType) -> bool {
    [vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC, vk::DescriptorType::STORAGE_BUFFER_DYNAMIC].contains(&kind)
}

fn is_buffer(kind: vk::DescriptorType) -> bool {
    is_dynamic(kind) || [vk::DescriptorType::UNIFORM_BUFFER, vk::DescriptorType::STORAGE_BUFFER].contains(&kind)
}

impl SetLayout {
    /// How many dynamic offsets are given when such a set is bound.
    pub fn dynamic_offsets(&self) -> u32 {
        self.bindings.values().filter(|(kind, _)| is_dynamic(*kind)).map(|(_, count)| count).sum()
    }

    /// Which of the dynamic offsets is that of a binding's first descriptor; `None` if it has none.
    fn dynamic_index(&self, binding: u32) -> Option<usize> {
        self.bindings.get(&binding).filter(|(kind, _)| is_dynamic(*kind))?;
        let before = self.bindings.range(..binding).filter(|(_, (kind, _))| is_dynamic(*kind));
        Some(before.map(|(_, (_, count))| *count as usize).sum())
    }
}

/// A descriptor set.
struct Set {
    pool: vk::DescriptorPool,
    handle: vk::DescriptorSetLayout,
    layout: Arc<SetLayout>,
    contents: Contents,
    copies: Option<Copies>,
    /// The first buffer of each binding, and where it begins.
    buffers: HashMap<u32, (vk::Buffer, u64)>,
}

/// An entry of a template.
pub struct TemplateEntry {
    /// The binding that it describes.
    pub binding: u32,
    /// The first element there.
    pub first: u32,
    /// Kind of the descriptors.
    pub kind: vk::DescriptorType,
    /// Their number.
    pub count: u32,
    /// Where they begin in the program's data, bytes.
    pub offset: usize,
    /// From one to the next, bytes.
    pub stride: usize,
}

/// A template for updates of descriptors.
pub struct Template {
    /// Its entries.
    pub entries: Vec<TemplateEntry>,
    /// Where descriptors are pushed by it: they are for graphics.
    pub graphics: bool,
}

/// Descriptor sets and their layouts.
#[derive(Default)]
pub struct Descriptors {
    layouts: Mutex<HashMap<vk::DescriptorSetLayout, Arc<SetLayout>>>,
    sets: Mutex<HashMap<vk::DescriptorSet, Set>>,
    templates: Mutex<HashMap<vk::DescriptorUpdateTemplate, Arc<Template>>>,
    /// Some set has had attachments that shaders can read.
    attachments: AtomicBool,
}

impl Descriptors {
    /// A layout.
    pub fn layout(&self, handle: vk::DescriptorSetLayout) -> Option<Arc<SetLayout>> {
        self.layouts.lock().unwrap_or_else(PoisonError::into_inner).get(&handle).cloned()
    }

    /// A template.
    pub fn template(&self, handle: vk::DescriptorUpdateTemplate) -> Option<Arc<Template>> {
        self.templates.lock().unwrap_or_else(PoisonError::into_inner).get(&handle).cloned()
    }

    /// How many dynamic offsets are given when a set is bound.
    pub fn dynamic_offsets(&self, set: vk::DescriptorSet) -> u32 {
        let sets = self.sets.lock().unwrap_or_else(PoisonError::into_inner);
        sets.get(&set).map_or(0, |set| set.layout.dynamic_offsets())
    }

    /// The buffer of a binding of a set that is bound with `dynamic` offsets, and where it begins.
    pub fn buffer(&self, set: vk::DescriptorSet, dynamic: &[u32], binding: u32) -> Option<(vk::Buffer, u64)> {
        let sets = self.sets.lock().unwrap_or_else(PoisonError::into_inner);
        let state = sets.get(&set)?;
        let (buffer, offset) = *state.buffers.get(&binding)?;
        let moved = state.layout.dynamic_index(binding).and_then(|index| dynamic.get(index)).copied();
        Some((buffer, offset + u64::from(moved.unwrap_or(0))))
    }

    fn describe(&self, set: vk::DescriptorSet, binding: u32, buffer: &vk::DescriptorBufferInfo) {
        if let Some(set) = self.sets.lock().unwrap_or_else(PoisonError::into_inner).get_mut(&set) {
            set.buffers.insert(binding, (buffer.buffer, buffer.offset));
        }
    }

    fn forget(&self, device: &Device, gone: impl Fn(&vk::DescriptorSet, &Set) -> bool) {
        let forgotten: Vec<Copies> = {
            let mut sets = self.sets.lock().unwrap_or_else(PoisonError::into_inner);
            let all = sets.extract_if(|handle, set| gone(handle, set));
            all.filter_map(|(_, set)| set.copies).collect()
        };
        forgotten.into_iter().for_each(|copies| copies.destroy(device));
    }

    /// Destroys what was made beside the program's sets, before the device is destroyed.
    pub fn clear(&self, device: &Device) {
        self.forget(device, |_, _| true);
    }

    /// Views of the images that shaders can read by a set.
    pub fn pictures(&self, set: vk::DescriptorSet) -> Vec<vk::ImageView> {
        let sets = self.sets.lock().unwrap_or_else(PoisonError::into_inner);
        sets.get(&set).map_or(Vec::new(), |set| set.contents.views().collect())
    }

    /// Copies of a set for each view, where it shows the scene.
    ///
    /// # Errors
    /// Why there are none.
    pub fn of_views(
        &self,
        device: &Device,
        handle: vk::DescriptorSet,
        layout: &Layout,
    ) -> Result<Option<Arc<[vk::DescriptorSet]>>, String> {
        let mut sets = self.sets.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(set) = sets.get_mut(&handle) else { return Ok(None) };
        let known = self.layout(set.handle).filter(|known| Arc::ptr_eq(known, &set.layout));
        let original =
            Original { set: handle, handle: known.map(|_| set.handle), layout: &set.layout, contents: &set.contents };
        Copies::of(&mut set.copies, device, &original, layout)
    }

    /// Whether shaders can read attachments by a set.
    pub fn reads_attachments(&self, set: vk::DescriptorSet) -> bool {
        let sets = self.sets.lock().unwrap_or_else(PoisonError::into_inner);
        sets.get(&set).is_some_and(|set| set.contents.reads_attachments())
    }

    /// Whether any set was written by which shaders can read attachments.
    pub fn any_attachments(&self) -> bool {
        self.attachments.load(Ordering::Relaxed)
    }

    fn write(&self, set: vk::DescriptorSet, place: (u32, u32), picture: Option<Picture>) {
        if picture.is_some_and(|picture| picture.attachment.is_some()) {
            self.attachments.store(true, Ordering::Relaxed);
        }
        if let Some(set) = self.sets.lock().unwrap_or_else(PoisonError::into_inner).get_mut(&set) {
            set.contents.write(place, picture);
        }
    }

    fn copy(&self, copy: &vk::CopyDescriptorSet<'_>) {
        let mut sets = self.sets.lock().unwrap_or_else(PoisonError::into_inner);
        // Out and in again: both may be one.
        let mut contents = sets.get_mut(&copy.dst_set).map(|set| std::mem::take(&mut set.contents)).unwrap_or_default();
        if let Some(from) = sets.get(&copy.src_set).filter(|_| copy.src_set != copy.dst_set) {
            for index in 0..copy.descriptor_count {
                let source = (copy.src_binding, copy.src_array_element + index);
                contents.copy(&from.contents, (source, (copy.dst_binding, copy.dst_array_element + index)));
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

/// What shaders read pictures by.
pub fn is_picture(kind: vk::DescriptorType) -> bool {
    use vk::DescriptorType as T;
    [T::COMBINED_IMAGE_SAMPLER, T::SAMPLED_IMAGE, T::STORAGE_IMAGE, T::INPUT_ATTACHMENT].contains(&kind)
}

/// Those of them that pictures of the scene can be exchanged in.
pub fn is_sampled(kind: vk::DescriptorType) -> bool {
    [vk::DescriptorType::COMBINED_IMAGE_SAMPLER, vk::DescriptorType::SAMPLED_IMAGE].contains(&kind)
}

/// What a descriptor of this kind shows a picture by; `None` for those whose picture cannot be exchanged.
fn picture(info: &vk::DescriptorImageInfo, kind: vk::DescriptorType) -> Option<Picture> {
    let attachment = (kind == vk::DescriptorType::INPUT_ATTACHMENT).then_some(info.image_layout);
    let picture = Picture { view: info.image_view, sampler: info.sampler, attachment };
    (is_sampled(kind) || attachment.is_some()).then_some(picture)
}

hooks! { descriptors;
    [c"vkCreateDescriptorSetLayout"] create_descriptor_set_layout: vk::PFN_vkCreateDescriptorSetLayout = (
        device: vk::Device, info: *const vk::DescriptorSetLayoutCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, layout: *mut vk::DescriptorSetLayout
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, layout);
        if result == vk::Result::SUCCESS {
            let bindings = crate::intercept::vk::slice((*info).p_bindings, (*info).binding_count);
            let bindings = bindings.iter().map(|b| (b.binding, (b.descriptor_type, b.descriptor_count))).collect();
            use vk::DescriptorSetLayoutCreateFlags as F;
            let apart = (*info).flags.contains(F::DESCRIPTOR_BUFFER_EXT);
            let changes_later = (*info).flags.contains(F::UPDATE_AFTER_BIND_POOL);
            let new = Arc::new(SetLayout { bindings, apart, changes_later });
            state.descriptors.layouts.lock().unwrap_or_else(PoisonError::into_inner).insert(*layout, new);
        }
        result
    } }
    [c"vkDestroyDescriptorSetLayout"] destroy_descriptor_set_layout: vk::PFN_vkDestroyDescriptorSetLayout = (
        device: vk::Device, layout: vk::DescriptorSetLayout, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.descriptors.layouts.lock().unwrap_or_else(PoisonError::into_inner).remove(&layout);
        next(device, layout, allocator)
    } }
    [c"vkAllocateDescriptorSets"] allocate_descriptor_sets: vk::PFN_vkAllocateDescriptorSets = (
        device: vk::Device, info: *const vk::DescriptorSetAllocateInfo<'_>, sets: *mut vk::DescriptorSet
    ) -> vk::Result { |state, next| {
        let result = next(device, info, sets);
        if result == vk::Result::SUCCESS {
            let layouts = crate::intercept::vk::slice((*info).p_set_layouts, (*info).descriptor_set_count);
            for (set, handle) in crate::intercept::vk::slice(sets, (*info).descriptor_set_count).iter().zip(layouts) {
                let layout = state.descriptors.layout(*handle).unwrap_or_default();
                let new = Set {
                    pool: (*info).descriptor_pool,
                    handle: *handle,
                    layout,
                    contents: Contents::default(),
                    copies: None,
                    buffers: HashMap::new(),
                };
                state.descriptors.sets.lock().unwrap_or_else(PoisonError::into_inner).insert(*set, new);
            }
        }
        result
    } }
    [c"vkFreeDescriptorSets"] free_descriptor_sets: vk::PFN_vkFreeDescriptorSets = (
        device: vk::Device, pool: vk::DescriptorPool, count: u32, sets: *const vk::DescriptorSet
    ) -> vk::Result { |state, next| {
        let gone = crate::intercept::vk::slice(sets, count);
        state.descriptors.forget(&state, |handle, _| gone.contains(handle));
        next(device, pool, count, sets)
    } }
    [c"vkResetDescriptorPool"] reset_descriptor_pool: vk::PFN_vkResetDescriptorPool = (
        device: vk::Device, pool: vk::DescriptorPool, flags: vk::DescriptorPoolResetFlags
    ) -> vk::Result { |state, next| {
        state.descriptors.forget(&state, |_, set| set.pool == pool);
        next(device, pool, flags)
    } }
    [c"vkDestroyDescriptorPool"] destroy_descriptor_pool: vk::PFN_vkDestroyDescriptorPool = (
        device: vk::Device, pool: vk::DescriptorPool, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.descriptors.forget(&state, |_, set| set.pool == pool);
        next(device, pool, allocator)
    } }
    [c"vkUpdateDescriptorSets"] update_descriptor_sets: vk::PFN_vkUpdateDescriptorSets = (
        device: vk::Device, write_count: u32, writes: *const vk::WriteDescriptorSet<'_>, copy_count: u32, copies: *const vk::CopyDescriptorSet<'_>
    ) { |state, next| {
        for write in crate::intercept::vk::slice(writes, write_count) {
            let count = write.descriptor_count;
            if is_buffer(write.descriptor_type) && write.dst_array_element == 0 {
                if let Some(info) = crate::intercept::vk::slice(write.p_buffer_info, count).first() {
                    state.descriptors.describe(write.dst_set, write.dst_binding, info);
                }
            } else if is_picture(write.descriptor_type) {
                crate::intercept::vk::slice(write.p_image_info, count).iter().for_each(|info| state.images.described(&state, info.image_view, write.descriptor_type));
            }
            let images = if is_picture(write.descriptor_type) { crate::intercept::vk::slice(write.p_image_info, count) } else { &[] };
            for index in 0..count {
                let picture = images.get(index as usize).and_then(|info| picture(info, write.descriptor_type));
                state.descriptors.write(write.dst_set, (write.dst_binding, write.dst_array_element + index), picture);
            }
        }
        crate::intercept::vk::slice(copies, copy_count).iter().for_each(|copy| state.descriptors.copy(copy));
        next(device, write_count, writes, copy_count, copies)
    } }
    [c"vkCreateDescriptorUpdateTemplate", c"vkCreateDescriptorUpdateTemplateKHR"] create_template: vk::PFN_vkCreateDescriptorUpdateTemplate = (
        device: vk::Device, info: *const vk::DescriptorUpdateTemplateCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, template: *mut vk::DescriptorUpdateTemplate
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, template);
        if result == vk::Result::SUCCESS {
            let entries = crate::intercept::vk::slice((*info).p_descriptor_update_entries, (*info).descriptor_update_entry_count);
            let entry = |e: &vk::DescriptorUpdateTemplateEntry| TemplateEntry {
                binding: e.dst_binding,
                first: e.dst_array_element,
                kind: e.descriptor_type,
                count: e.descriptor_count,
                offset: e.offset,
                stride: e.stride,
            };
            let graphics = (*info).pipeline_bind_point == vk::PipelineBindPoint::GRAPHICS;
            let new = Arc::new(Template { entries: entries.iter().map(entry).collect(), graphics });
            state.descriptors.templates.lock().unwrap_or_else(PoisonError::into_inner).insert(*template, new);
        }
        result
    } }
    [c"vkDestroyDescriptorUpdateTemplate", c"vkDestroyDescriptorUpdateTemplateKHR"] destroy_template: vk::PFN_vkDestroyDescriptorUpdateTemplate = (
        device: vk::Device, template: vk::DescriptorUpdateTemplate, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.descriptors.templates.lock().unwrap_or_else(PoisonError::into_inner).remove(&template);
        next(device, template, allocator)
    } }
    [c"vkUpdateDescriptorSetWithTemplate", c"vkUpdateDescriptorSetWithTemplateKHR"] update_with_template: vk::PFN_vkUpdateDescriptorSetWithTemplate = (
        device: vk::Device, set: vk::DescriptorSet, handle: vk::DescriptorUpdateTemplate, data: *const std::ffi::c_void
    ) { |state, next| {
        let template = state.descriptors.template(handle);
        for entry in template.iter().flat_map(|template| &template.entries) {
            let place = data.cast::<u8>().add(entry.offset);
            if is_buffer(entry.kind) && entry.first == 0 && entry.count > 0 {
                let info = std::ptr::read_unaligned(place.cast::<vk::DescriptorBufferInfo>());
                state.descriptors.describe(set, entry.binding, &info);
            } else if is_picture(entry.kind) {
                for index in 0..entry.count as usize {
                    let info = std::ptr::read_unaligned(place.add(index * entry.stride).cast::<vk::DescriptorImageInfo>());
                    state.images.described(&state, info.image_view, entry.kind);
                    let shown = picture(&info, entry.kind);
                    state.descriptors.write(set, (entry.binding, entry.first + index as u32), shown);
                }
            }
            if !is_picture(entry.kind) {
                (0..entry.count).for_each(|index| state.descriptors.write(set, (entry.binding, entry.first + index), None));
            }
        }
        next(device, set, handle, data)
    } }
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
    }
}
