//! Hooks of pipelines.

use crate::intercept::vk::pipelines::variants;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::pipelines::create_info::Parts;
use crate::intercept::vk::state::pipelines::{Pipeline, Pipelines, TilePipelines};
use crate::lock::Lock;
use ash::vk;
use std::sync::Arc;

impl Pipelines {
    /// Removes all pipelines, before the device is destroyed.
    pub fn clear(&self, device: &Device) {
        let all = std::mem::take(&mut *self.all.locked());
        all.values().for_each(|pipeline| pipeline.destroy(device));
        let all = std::mem::take(&mut *self.computing.locked());
        all.values().for_each(|pipeline| pipeline.destroy(device));
    }
}

impl Pipeline {
    fn destroy(&self, device: &Device) {
        let Some(variants) = &self.variants else { return };
        for TilePipelines { view, panel } in [Some(variants.tiles), variants.quiet].into_iter().flatten() {
            // SAFETY: pipelines of Cupola; nothing uses them, since the program destroys its own.
            unsafe {
                device.driver.functions.destroy_pipeline(panel, None);
                if view != panel {
                    device.driver.functions.destroy_pipeline(view, None);
                }
            }
        }
    }
}

hooks! {
    create_graphics_pipelines = (
        device: vk::Device, cache: vk::PipelineCache, count: u32, infos: *const vk::GraphicsPipelineCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, pipelines: *mut vk::Pipeline
    ) -> vk::Result { |state, next| {
        let result = next(device, cache, count, infos, allocator, pipelines);
        let made = slice(pipelines, count);
        for (info, &own) in slice(infos, count).iter().zip(made).filter(|(_, own)| **own != vk::Pipeline::null()) {
            let parts = Parts::of(info);
            let made = if parts.is_seen() && state.draws_views() { variants::make(&state, cache, &parts) } else { Err("its drawing is not visible".into()) };
            let new = variants::pipeline(&state, own, &parts, made.inspect_err(|why| state.flatness.note_pipeline(why)).ok());
            state.pipelines.all.locked().insert(own, Arc::new(new));
        }
        result
    } }
    destroy_pipeline = (
        device: vk::Device, pipeline: vk::Pipeline, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        let gone = state.pipelines.computing.locked().remove(&pipeline);
        gone.iter().for_each(|gone| gone.destroy(&state));
        let gone = state.pipelines.all.locked().remove(&pipeline);
        if let Some(gone) = gone {
            gone.destroy(&state);
        }
        next(device, pipeline, allocator)
    } }
}
