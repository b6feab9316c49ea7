//! Shaders and pipeline layouts. Each pipeline layout has one more descriptor set than the program asked for: the
//! rows of the view that is drawn, and the counter of what is not divided far enough.

use crate::intercept::vk::descriptors::sets::SetLayout;
use crate::intercept::vk::layer::device::Device;
use crate::intercept::vk::layer::hooks::hooks;
use ash::vk;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A pipeline layout. The driver's object lives as long as a pipeline needs it, though the program may destroy it
/// before.
pub struct PipelineLayout {
    /// The driver's object.
    pub handle: vk::PipelineLayout,
    /// Number of the set of ours.
    pub ours: u32,
    /// The set has the counter, too.
    pub counts: bool,
    destroy: (vk::PFN_vkDestroyPipelineLayout, vk::Device),
}

impl Drop for PipelineLayout {
    fn drop(&mut self) {
        let (destroy, device) = self.destroy;
        // SAFETY: made by us, without callbacks; the device outlives what is kept of it.
        unsafe { destroy(device, self.handle, std::ptr::null()) };
    }
}

/// Shaders and pipeline layouts.
#[derive(Default)]
pub struct Layouts {
    shaders: Mutex<HashMap<vk::ShaderModule, Arc<[u32]>>>,
    layouts: Mutex<HashMap<vk::PipelineLayout, Arc<PipelineLayout>>>,
}

impl Layouts {
    /// A shader's words.
    pub fn shader(&self, module: vk::ShaderModule) -> Option<Arc<[u32]>> {
        self.shaders.lock().unwrap_or_else(PoisonError::into_inner).get(&module).cloned()
    }

    /// A pipeline layout.
    pub fn layout(&self, handle: vk::PipelineLayout) -> Option<Arc<PipelineLayout>> {
        self.layouts.lock().unwrap_or_else(PoisonError::into_inner).get(&handle).cloned()
    }

    /// Forgets all, before the device is destroyed.
    pub fn clear(&self) {
        self.layouts.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }
}

/// The number that our set gets in a layout, if it can have one, and whether there is room for the counter.
///
/// # Safety
/// `info` must be the program's.
unsafe fn room(device: &Device, info: &vk::PipelineLayoutCreateInfo<'_>) -> Option<(u32, bool)> {
    // SAFETY: as promised.
    let handles = unsafe { crate::intercept::vk::slice(info.p_set_layouts, info.set_layout_count) };
    let sets: Option<Vec<Arc<SetLayout>>> = handles.iter().map(|set| device.descriptors.layout(*set)).collect();
    let sets = sets.filter(|_| info.flags.is_empty())?;
    let limits = &device.limits;
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

hooks! { layouts;
    [c"vkCreateShaderModule"] create_shader_module: vk::PFN_vkCreateShaderModule = (
        device: vk::Device, info: *const vk::ShaderModuleCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, module: *mut vk::ShaderModule
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, module);
        if result == vk::Result::SUCCESS {
            let words: Arc<[u32]> = crate::intercept::vk::slice((*info).p_code, ((*info).code_size / 4) as u32).into();
            state.layouts.shaders.lock().unwrap_or_else(PoisonError::into_inner).insert(*module, words);
        }
        result
    } }
    [c"vkDestroyShaderModule"] destroy_shader_module: vk::PFN_vkDestroyShaderModule = (
        device: vk::Device, module: vk::ShaderModule, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.layouts.shaders.lock().unwrap_or_else(PoisonError::into_inner).remove(&module);
        next(device, module, allocator)
    } }
    [c"vkCreatePipelineLayout"] create_pipeline_layout: vk::PFN_vkCreatePipelineLayout = (
        device: vk::Device, info: *const vk::PipelineLayoutCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, layout: *mut vk::PipelineLayout
    ) -> vk::Result { |state, next| {
        let given = &*info;
        let room = room(&state, given).map(|(number, counts)| (number, counts && state.rows.counter(&state).is_some()));
        let set = room.and_then(|(_, counts)| state.rows.set_layout(&state, counts));
        let Some(((number, counts), set)) = room.zip(set) else { return next(device, info, allocator, layout) };
        let mut sets = crate::intercept::vk::slice(given.p_set_layouts, given.set_layout_count).to_vec();
        sets.push(set);
        let larger = given.set_layouts(&sets);
        if next(device, &larger, std::ptr::null(), layout) != vk::Result::SUCCESS {
            return next(device, info, allocator, layout);
        }
        let destroy = (state.functions.fp_v1_0().destroy_pipeline_layout, device);
        let new = Arc::new(PipelineLayout { handle: *layout, ours: number, counts, destroy });
        state.layouts.layouts.lock().unwrap_or_else(PoisonError::into_inner).insert(*layout, new);
        vk::Result::SUCCESS
    } }
    [c"vkDestroyPipelineLayout"] destroy_pipeline_layout: vk::PFN_vkDestroyPipelineLayout = (
        device: vk::Device, layout: vk::PipelineLayout, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        let known = state.layouts.layouts.lock().unwrap_or_else(PoisonError::into_inner).remove(&layout);
        if known.is_none() {
            next(device, layout, allocator)
        }
    } }
}
