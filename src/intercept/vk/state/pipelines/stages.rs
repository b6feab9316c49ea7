//! A stage of a pipeline: its entry point and its words.

use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::{in_chain, slice};
use ash::vk;
use std::ffi::CStr;
use std::sync::Arc;

/// The name of a stage's entry point.
///
/// # Safety
/// `stage` must be the program's.
pub unsafe fn name_of(stage: &vk::PipelineShaderStageCreateInfo<'_>) -> String {
    // SAFETY: as promised.
    unsafe { CStr::from_ptr(stage.p_name) }.to_string_lossy().into_owned()
}

/// Returns a stage's words, from its module or from its chain.
///
/// # Safety
/// `stage` must be the program's.
pub unsafe fn words_of(device: &Device, stage: &vk::PipelineShaderStageCreateInfo<'_>) -> Option<Arc<[u32]>> {
    if stage.module != vk::ShaderModule::null() {
        return device.layouts.shader(stage.module);
    }
    // SAFETY: as promised.
    unsafe {
        let given = vk::StructureType::SHADER_MODULE_CREATE_INFO;
        let given = in_chain::<vk::ShaderModuleCreateInfo<'_>>(stage.p_next, given)?;
        Some(slice(given.p_code, (given.code_size / 4) as u32).into())
    }
}
