//! Pipelines: beside each of the program's, one that draws into a view and one that draws onto the panel.
//!
//! `parts` has what a structure says, of a whole pipeline or of a library; `variants` makes the others, `division` the stage that
//! divides.

use crate::intercept::vk::layer::device::Device;
use crate::intercept::vk::layer::hooks::hooks;
use crate::intercept::vk::pipelines::create_info::Parts;
use crate::intercept::vk::pipelines::layouts::PipelineLayout;
use crate::intercept::vk::pipelines::{dividing_stage, variants};
use crate::intercept::vk::spirv::Matrix;
use ash::vk;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A graphics pipeline of the program, or a library of which some are linked.
pub struct Pipeline {
    /// The program's.
    pub own: vk::Pipeline,
    /// Its layout, if that has a set of ours.
    pub layout: Option<Arc<PipelineLayout>>,
    /// What is drawn by in its place.
    pub variants: Option<Variants>,
    /// The program's viewport, unless it is set by commands.
    pub viewport: Option<vk::Viewport>,
    /// Its scissor, likewise.
    pub scissor: Option<vk::Rect2D>,
}

/// The pipelines for the views. Their viewport and scissor are set by commands.
pub struct Variants {
    /// Draws into a view, and wherever the program's own picture is drawn.
    pub view: vk::Pipeline,
    /// Its shader re-projects; where it could not be followed, what is drawn is flat.
    pub follows: bool,
    /// Draws onto the panel.
    pub panel: vk::Pipeline,
    /// Where its shaders' matrices are.
    pub matrices: Vec<Matrix>,
    /// Number of viewports and scissors is set by commands, too.
    pub with_count: bool,
    /// Its fragment shader asks where on the screen it is.
    pub asks_place: bool,
    /// What it draws is tested by its depth.
    pub deep: bool,
}

/// The program's pipelines.
#[derive(Default)]
pub struct Pipelines {
    all: Mutex<HashMap<vk::Pipeline, Arc<Pipeline>>>,
    /// What the statistics say of those that are divided, or should be.
    pub divided: dividing_stage::Divided,
}

impl Pipelines {
    /// A graphics pipeline.
    pub fn get(&self, handle: vk::Pipeline) -> Option<Arc<Pipeline>> {
        self.all.lock().unwrap_or_else(PoisonError::into_inner).get(&handle).cloned()
    }

    /// Forgets all, before the device is destroyed.
    pub fn clear(&self, device: &Device) {
        let all = std::mem::take(&mut *self.all.lock().unwrap_or_else(PoisonError::into_inner));
        all.values().for_each(|pipeline| pipeline.destroy(device));
    }
}

impl Pipeline {
    fn destroy(&self, device: &Device) {
        let Some(variants) = &self.variants else { return };
        // SAFETY: ours; the program says by destroying its own that nothing uses them.
        unsafe {
            device.functions.destroy_pipeline(variants.panel, None);
            if variants.view != variants.panel {
                device.functions.destroy_pipeline(variants.view, None);
            }
        }
    }
}

hooks! { pipelines;
    [c"vkCreateGraphicsPipelines"] create_graphics_pipelines: vk::PFN_vkCreateGraphicsPipelines = (
        device: vk::Device, cache: vk::PipelineCache, count: u32, infos: *const vk::GraphicsPipelineCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, pipelines: *mut vk::Pipeline
    ) -> vk::Result { |state, next| {
        let result = next(device, cache, count, infos, allocator, pipelines);
        let made = crate::intercept::vk::slice(pipelines, count);
        for (info, &own) in crate::intercept::vk::slice(infos, count).iter().zip(made).filter(|(_, own)| **own != vk::Pipeline::null()) {
            let parts = Parts::of(info);
            let made = if parts.is_seen() && state.draws_views() { variants::make(&state, cache, &parts) } else { Err("it is not seen".to_owned()) };
            let new = variants::pipeline(&state, own, &parts, made.inspect_err(|why| state.note_pipeline(why)).ok());
            state.pipelines.all.lock().unwrap_or_else(PoisonError::into_inner).insert(own, Arc::new(new));
        }
        result
    } }
    [c"vkDestroyPipeline"] destroy_pipeline: vk::PFN_vkDestroyPipeline = (
        device: vk::Device, pipeline: vk::Pipeline, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        let gone = state.pipelines.all.lock().unwrap_or_else(PoisonError::into_inner).remove(&pipeline);
        if let Some(gone) = gone {
            gone.destroy(&state);
        }
        next(device, pipeline, allocator)
    } }
}
