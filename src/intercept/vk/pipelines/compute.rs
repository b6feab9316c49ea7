//! Compute pipelines: the data that their shaders read and write, and variants with the camera
//! matrices of a view.

use crate::intercept::process::log;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::pipelines::variants::Modules;
use crate::intercept::vk::spirv;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::pipelines::stages::{name_of, words_of};
use crate::intercept::vk::state::pipelines::{CameraMatrix, ComputePipeline, ComputeVariant, MatrixStage};
use crate::lock::Lock;
use ::spirv::ExecutionModel;
use ash::vk;
use std::sync::Arc;

impl ComputePipeline {
    /// # Safety
    /// `info` must be of a pipeline that the program has just made.
    unsafe fn of(device: &Device, cache: vk::PipelineCache, info: &vk::ComputePipelineCreateInfo<'_>) -> Option<Self> {
        // SAFETY: as promised.
        unsafe {
            let words = words_of(device, &info.stage)?;
            let mut made = Self { uses: spirv::compute_use(&words)?, variant: None, loses_cameras: false };
            match variant(device, cache, info, &words) {
                Ok(variant) => made.variant = variant,
                Err(why) => {
                    made.loses_cameras = true;
                    if let Some(reason) = why.reason() {
                        log::once(&format!(
                            "Vulkan: a compute shader keeps the matrices of the program in all views: {reason}"
                        ));
                    }
                }
            }
            Some(made)
        }
    }

    pub(super) fn destroy(&self, device: &Device) {
        if let Some(variant) = &self.variant {
            // SAFETY: a pipeline of Cupola; nothing uses it, since the program destroys its own.
            unsafe { device.driver.functions.destroy_pipeline(variant.pipeline, None) };
        }
    }
}

/// Returns the pipeline with the matrices of a view; `None` if its shader has no matrices that may
/// be the camera's.
///
/// # Errors
/// The reason why there is none.
///
/// # Safety
/// `info` must be the program's.
unsafe fn variant(
    device: &Device,
    cache: vk::PipelineCache,
    info: &vk::ComputePipelineCreateInfo<'_>,
    words: &[u32],
) -> Result<Option<ComputeVariant>, Obstacle> {
    // SAFETY: as promised.
    let entry = unsafe { name_of(&info.stage) };
    let layout = device.layouts.layout(info.layout);
    let ours = layout.as_ref().map_or(0, |layout| layout.ours);
    let offset = device.view_constants.cameras_offset();
    let Some(chosen) = spirv::camera_matrices(words, ExecutionModel::GLCompute, &entry, ours, offset)? else {
        return Ok(None);
    };
    let layout = layout.ok_or("there is no room for a descriptor set of Cupola")?;
    let mut modules = Modules::new(device);
    let mut stage = info.stage;
    if stage.module == vk::ShaderModule::null() {
        // Without a module, the program's words are in the chain. The module below replaces them.
        stage.p_next = std::ptr::null();
    }
    stage.module = modules.make(&chosen.words)?;
    let dropped = vk::PipelineCreateFlags::DERIVATIVE
        | vk::PipelineCreateFlags::FAIL_ON_PIPELINE_COMPILE_REQUIRED
        | vk::PipelineCreateFlags::EARLY_RETURN_ON_FAILURE;
    let changed =
        vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.handle).flags(info.flags & !dropped);
    // SAFETY: the structure is complete.
    let made = unsafe { device.driver.functions.create_compute_pipelines(cache, &[changed], None) };
    let made = made.map_err(|(_, error)| format!("the driver refuses a pipeline: {error}"))?;
    let pipeline = *made.first().ok_or("the driver makes no pipeline")?;
    let (stage, inverted) = (MatrixStage::Fragment, chosen.inverts);
    let cameras = chosen.matrices.into_iter().map(|(matrix, called)| CameraMatrix { matrix, called, stage, inverted });
    Ok(Some(ComputeVariant { pipeline, layout, cameras: cameras.collect() }))
}

hooks! {
    create_compute_pipelines = (
        device: vk::Device, cache: vk::PipelineCache, count: u32, infos: *const vk::ComputePipelineCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, pipelines: *mut vk::Pipeline
    ) -> vk::Result { |state, next| {
        let result = next(device, cache, count, infos, allocator, pipelines);
        let made = slice(pipelines, count);
        for (info, &own) in slice(infos, count).iter().zip(made).filter(|(_, own)| **own != vk::Pipeline::null()) {
            if let Some(new) = state.draws_views().then(|| ComputePipeline::of(&state, cache, info)).flatten() {
                state.pipelines.computing.locked().insert(own, Arc::new(new));
            }
        }
        result
    } }
}
