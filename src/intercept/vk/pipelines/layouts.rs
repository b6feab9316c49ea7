//! Shader modules and pipeline layouts. Each pipeline layout gets one more descriptor set: the view
//! constants, and the counter of primitives that are not divided enough.

use crate::intercept::vk::state::descriptors::SetLayout;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::pipelines::PipelineLayout;
use crate::lock::Lock;
use ash::vk;
use std::sync::Arc;

/// Returns the number of Cupola's set in a layout, if the layout can have it, and whether there is
/// room for the counter.
///
/// # Safety
/// `info` must be the program's.
unsafe fn room(device: &Device, info: &vk::PipelineLayoutCreateInfo<'_>) -> Option<(u32, bool)> {
    // SAFETY: as promised.
    let handles = unsafe { slice(info.p_set_layouts, info.set_layout_count) };
    let sets: Option<Vec<Arc<SetLayout>>> = handles.iter().map(|set| device.descriptors.layout(*set)).collect();
    let sets = sets.filter(|_| info.flags.is_empty())?;
    let limits = &device.driver.limits;
    let count = |kind: fn(vk::DescriptorType) -> bool| -> u32 {
        sets.iter().flat_map(|set| set.bindings.values()).filter(|(k, _)| kind(*k)).map(|(_, count)| count).sum()
    };
    let dynamic = count(|kind| kind == vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC);
    let uniform = dynamic + count(|kind| kind == vk::DescriptorType::UNIFORM_BUFFER);
    let fits = info.set_layout_count < limits.max_bound_descriptor_sets
        && dynamic < limits.max_descriptor_set_uniform_buffers_dynamic
        && uniform < limits.max_per_stage_descriptor_uniform_buffers
        && !sets.iter().any(|set| set.apart);
    let storage =
        count(|kind| [vk::DescriptorType::STORAGE_BUFFER, vk::DescriptorType::STORAGE_BUFFER_DYNAMIC].contains(&kind));
    let counts =
        storage < limits.max_per_stage_descriptor_storage_buffers.min(limits.max_descriptor_set_storage_buffers);
    fits.then_some((info.set_layout_count, counts))
}

hooks! {
    create_shader_module = (
        device: vk::Device, info: *const vk::ShaderModuleCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, module: *mut vk::ShaderModule
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, module);
        if result == vk::Result::SUCCESS {
            let words: Arc<[u32]> = slice((*info).p_code, ((*info).code_size / 4) as u32).into();
            state.layouts.shaders.locked().insert(*module, words);
        }
        result
    } }
    destroy_shader_module = (
        device: vk::Device, module: vk::ShaderModule, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.layouts.shaders.locked().remove(&module);
        next(device, module, allocator)
    } }
    create_pipeline_layout = (
        device: vk::Device, info: *const vk::PipelineLayoutCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, layout: *mut vk::PipelineLayout
    ) -> vk::Result { |state, next| {
        let given = &*info;
        let room = room(&state, given).map(|(number, counts)| (number, counts && state.view_constants.counter(&state.driver).is_some()));
        let set = room.and_then(|(_, counts)| state.view_constants.set_layout(&state.driver, counts));
        let Some(((number, counts), set)) = room.zip(set) else { return next(device, info, allocator, layout) };
        let mut sets = slice(given.p_set_layouts, given.set_layout_count).to_vec();
        sets.push(set);
        let larger = given.set_layouts(&sets);
        if next(device, &larger, std::ptr::null(), layout) != vk::Result::SUCCESS {
            return next(device, info, allocator, layout);
        }
        let destroy = (state.driver.functions.fp_v1_0().destroy_pipeline_layout, device);
        let new = Arc::new(PipelineLayout { handle: *layout, ours: number, counts, destroy });
        state.layouts.layouts.locked().insert(*layout, new);
        vk::Result::SUCCESS
    } }
    destroy_pipeline_layout = (
        device: vk::Device, layout: vk::PipelineLayout, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        let known = state.layouts.layouts.locked().remove(&layout);
        if known.is_none() {
            next(device, layout, allocator)
        }
    } }
}
