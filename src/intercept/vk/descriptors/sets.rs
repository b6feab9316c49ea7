//! Hooks of descriptor sets, their layouts and update templates.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::descriptors::per_view_sets::ProgramSet;
use crate::intercept::vk::state::descriptors::set_contents::{Contents, Copies};
use crate::intercept::vk::state::descriptors::{
    Descriptors, Set, SetLayout, Template, TemplateEntry, is_buffer, is_picture, picture,
};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::lock::Lock;
use ash::vk;
use std::collections::HashMap;
use std::sync::Arc;

impl Descriptors {
    fn forget(&self, device: &Device, gone: impl Fn(&vk::DescriptorSet, &Set) -> bool) {
        let forgotten: Vec<Copies> = {
            let mut sets = self.sets.locked();
            let all = sets.extract_if(|handle, set| gone(handle, set));
            all.filter_map(|(_, set)| set.copies).collect()
        };
        forgotten.into_iter().for_each(|copies| copies.destroy(device));
    }

    /// Destroys the copies of the program's sets, before the device is destroyed.
    pub fn clear(&self, device: &Device) {
        self.forget(device, |_, _| true);
    }

    /// Returns the per-view copies of a set, if it refers to the scene.
    ///
    /// # Errors
    /// The reason why there are none.
    pub fn of_views(
        &self,
        device: &Device,
        handle: vk::DescriptorSet,
        layout: &AtlasLayout,
    ) -> Result<Option<Arc<[vk::DescriptorSet]>>, Obstacle> {
        let mut sets = self.sets.locked();
        let Some(set) = sets.get_mut(&handle) else { return Ok(None) };
        let known = self.layout(set.handle).filter(|known| Arc::ptr_eq(known, &set.layout));
        let original =
            ProgramSet { set: handle, handle: known.map(|_| set.handle), layout: &set.layout, contents: &set.contents };
        Copies::of(&mut set.copies, device, &original, layout)
    }
}

hooks! {
    create_descriptor_set_layout = (
        device: vk::Device, info: *const vk::DescriptorSetLayoutCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, layout: *mut vk::DescriptorSetLayout
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, layout);
        if result == vk::Result::SUCCESS {
            let bindings = slice((*info).p_bindings, (*info).binding_count);
            let bindings = bindings.iter().map(|b| (b.binding, (b.descriptor_type, b.descriptor_count))).collect();
            use vk::DescriptorSetLayoutCreateFlags as F;
            let apart = (*info).flags.contains(F::DESCRIPTOR_BUFFER_EXT);
            let changes_later = (*info).flags.contains(F::UPDATE_AFTER_BIND_POOL);
            let new = Arc::new(SetLayout { bindings, apart, changes_later });
            state.descriptors.layouts.locked().insert(*layout, new);
        }
        result
    } }
    destroy_descriptor_set_layout = (
        device: vk::Device, layout: vk::DescriptorSetLayout, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.descriptors.layouts.locked().remove(&layout);
        next(device, layout, allocator)
    } }
    allocate_descriptor_sets = (
        device: vk::Device, info: *const vk::DescriptorSetAllocateInfo<'_>, sets: *mut vk::DescriptorSet
    ) -> vk::Result { |state, next| {
        let result = next(device, info, sets);
        if result == vk::Result::SUCCESS {
            let layouts = slice((*info).p_set_layouts, (*info).descriptor_set_count);
            for (set, handle) in slice(sets, (*info).descriptor_set_count).iter().zip(layouts) {
                let layout = state.descriptors.layout(*handle).unwrap_or_default();
                let new = Set {
                    pool: (*info).descriptor_pool,
                    handle: *handle,
                    layout,
                    contents: Contents::default(),
                    copies: None,
                    buffers: HashMap::new(),
                };
                state.descriptors.sets.locked().insert(*set, new);
            }
        }
        result
    } }
    free_descriptor_sets = (
        device: vk::Device, pool: vk::DescriptorPool, count: u32, sets: *const vk::DescriptorSet
    ) -> vk::Result { |state, next| {
        let gone = slice(sets, count);
        state.descriptors.forget(&state, |handle, _| gone.contains(handle));
        next(device, pool, count, sets)
    } }
    reset_descriptor_pool = (
        device: vk::Device, pool: vk::DescriptorPool, flags: vk::DescriptorPoolResetFlags
    ) -> vk::Result { |state, next| {
        state.descriptors.forget(&state, |_, set| set.pool == pool);
        next(device, pool, flags)
    } }
    destroy_descriptor_pool = (
        device: vk::Device, pool: vk::DescriptorPool, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.descriptors.forget(&state, |_, set| set.pool == pool);
        next(device, pool, allocator)
    } }
    update_descriptor_sets = (
        device: vk::Device, write_count: u32, writes: *const vk::WriteDescriptorSet<'_>, copy_count: u32, copies: *const vk::CopyDescriptorSet<'_>
    ) { |state, next| {
        for write in slice(writes, write_count) {
            let count = write.descriptor_count;
            if is_buffer(write.descriptor_type) {
                for (element, info) in (write.dst_array_element..).zip(slice(write.p_buffer_info, count)) {
                    state.descriptors.describe(write.dst_set, (write.dst_binding, element), info);
                }
            } else if is_picture(write.descriptor_type) {
                slice(write.p_image_info, count).iter().for_each(|info| state.images.described(&state, info.image_view, write.descriptor_type));
            }
            let images = if is_picture(write.descriptor_type) { slice(write.p_image_info, count) } else { &[] };
            for index in 0..count {
                let picture = images.get(index as usize).and_then(|info| picture(info, write.descriptor_type));
                state.descriptors.write(write.dst_set, (write.dst_binding, write.dst_array_element + index), picture);
            }
        }
        slice(copies, copy_count).iter().for_each(|copy| state.descriptors.copy(copy));
        next(device, write_count, writes, copy_count, copies)
    } }
    create_template = (
        device: vk::Device, info: *const vk::DescriptorUpdateTemplateCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, template: *mut vk::DescriptorUpdateTemplate
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, template);
        if result == vk::Result::SUCCESS {
            let entries = slice((*info).p_descriptor_update_entries, (*info).descriptor_update_entry_count);
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
            state.descriptors.templates.locked().insert(*template, new);
        }
        result
    } }
    destroy_template = (
        device: vk::Device, template: vk::DescriptorUpdateTemplate, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.descriptors.templates.locked().remove(&template);
        next(device, template, allocator)
    } }
    update_with_template = (
        device: vk::Device, set: vk::DescriptorSet, handle: vk::DescriptorUpdateTemplate, data: *const std::ffi::c_void
    ) { |state, next| {
        let template = state.descriptors.template(handle);
        for entry in template.iter().flat_map(|template| &template.entries) {
            let place = data.cast::<u8>().add(entry.offset);
            if is_buffer(entry.kind) {
                for index in 0..entry.count {
                    let info = std::ptr::read_unaligned(place.add(index as usize * entry.stride).cast::<vk::DescriptorBufferInfo>());
                    state.descriptors.describe(set, (entry.binding, entry.first + index), &info);
                }
            } else if is_picture(entry.kind) {
                for index in 0..entry.count as usize {
                    let info = std::ptr::read_unaligned(place.add(index * entry.stride).cast::<vk::DescriptorImageInfo>());
                    state.images.described(&state, info.image_view, entry.kind);
                    let new = picture(&info, entry.kind);
                    state.descriptors.write(set, (entry.binding, entry.first + index as u32), new);
                }
            }
            if !is_picture(entry.kind) {
                (0..entry.count).for_each(|index| state.descriptors.write(set, (entry.binding, entry.first + index), None));
            }
        }
        next(device, set, handle, data)
    } }
}
