//! Pipelines: beside each of the program's, one that draws into a view and one that draws onto the panel.

use super::device::Device;
use super::hook::hooks;
use super::layouts::PipelineLayout;
use super::spirv::{self, Matrix};
use crate::intercept::log;
use ash::vk;
use spirv_words::ExecutionModel;
use std::collections::HashMap;
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

/// The crate of SPIR-V's numbers; `spirv` is our own module here.
use ::spirv as spirv_words;

/// A graphics pipeline of the program.
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

/// A structure in a chain, by its kind.
///
/// # Safety
/// `chain` must be a chain of Vulkan structures, `T` the one of that kind.
pub unsafe fn in_chain<'a, T>(chain: *const c_void, kind: vk::StructureType) -> Option<&'a T> {
    let mut at = chain.cast::<vk::BaseInStructure<'_>>();
    while !at.is_null() {
        // SAFETY: each structure begins with its kind and the next one.
        unsafe {
            if (*at).s_type == kind {
                return Some(&*at.cast::<T>());
            }
            at = (*at).p_next;
        }
    }
    None
}

/// What keeps a pipeline from having variants.
///
/// # Safety
/// `info` must be the program's.
unsafe fn obstacle(info: &vk::GraphicsPipelineCreateInfo<'_>) -> Option<&'static str> {
    // SAFETY: as promised.
    unsafe {
        let part = in_chain::<c_void>(info.p_next, vk::StructureType::GRAPHICS_PIPELINE_LIBRARY_CREATE_INFO_EXT);
        let linked = in_chain::<c_void>(info.p_next, vk::StructureType::PIPELINE_LIBRARY_CREATE_INFO_KHR);
        if info.flags.contains(vk::PipelineCreateFlags::LIBRARY_KHR) || part.is_some() || linked.is_some() {
            return Some("pipelines are linked from libraries");
        }
        let rendering = vk::StructureType::PIPELINE_RENDERING_CREATE_INFO;
        let rendering = in_chain::<vk::PipelineRenderingCreateInfo<'_>>(info.p_next, rendering);
        if rendering.is_some_and(|rendering| rendering.view_mask != 0) {
            return Some("it draws several views itself");
        }
        let viewports = info.p_viewport_state.as_ref();
        if viewports.is_some_and(|state| state.viewport_count > 1 || state.scissor_count > 1) {
            return Some("several viewports");
        }
    }
    None
}

/// A stage's words: of its module, or given with it.
///
/// # Safety
/// `stage` must be the program's.
unsafe fn words_of(device: &Device, stage: &vk::PipelineShaderStageCreateInfo<'_>) -> Option<Arc<[u32]>> {
    if stage.module != vk::ShaderModule::null() {
        return device.layouts.shader(stage.module);
    }
    // SAFETY: as promised.
    unsafe {
        let given = vk::StructureType::SHADER_MODULE_CREATE_INFO;
        let given = in_chain::<vk::ShaderModuleCreateInfo<'_>>(stage.p_next, given)?;
        Some(super::slice(given.p_code, (given.code_size / 4) as u32).into())
    }
}

/// The last stage before rasterisation, as an index, with what SPIR-V calls it.
fn last_stage(stages: &[vk::PipelineShaderStageCreateInfo<'_>]) -> Option<(usize, ExecutionModel)> {
    let order = [
        (vk::ShaderStageFlags::GEOMETRY, ExecutionModel::Geometry),
        (vk::ShaderStageFlags::TESSELLATION_EVALUATION, ExecutionModel::TessellationEvaluation),
        (vk::ShaderStageFlags::VERTEX, ExecutionModel::Vertex),
    ];
    order.into_iter().find_map(|(flag, model)| stages.iter().position(|s| s.stage == flag).map(|at| (at, model)))
}

/// While the panel is drawn, its alpha collects how much of it is covered, for the composition.
fn covering(blend: &vk::PipelineColorBlendAttachmentState) -> vk::PipelineColorBlendAttachmentState {
    let mut changed = *blend;
    if blend.blend_enable == vk::TRUE {
        let covers = blend.dst_color_blend_factor == vk::BlendFactor::ONE_MINUS_SRC_ALPHA;
        let (source, destination) = if covers {
            (vk::BlendFactor::ONE, vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
        } else {
            (vk::BlendFactor::ZERO, vk::BlendFactor::ONE)
        };
        changed = changed.src_alpha_blend_factor(source).dst_alpha_blend_factor(destination);
        changed.alpha_blend_op = vk::BlendOp::ADD;
    }
    if !changed.color_write_mask.is_empty() {
        changed.color_write_mask |= vk::ColorComponentFlags::A;
    }
    changed
}

/// The states that commands set.
///
/// # Safety
/// `info` must be the program's.
unsafe fn dynamic_states<'a>(info: &vk::GraphicsPipelineCreateInfo<'a>) -> &'a [vk::DynamicState] {
    // SAFETY: as promised.
    unsafe {
        info.p_dynamic_state
            .as_ref()
            .map_or(&[], |state| super::slice(state.p_dynamic_states, state.dynamic_state_count))
    }
}

/// Makes the variants of a pipeline that was made after `info`.
///
/// # Safety
/// `info` must be the program's.
unsafe fn variants(
    device: &Device,
    cache: vk::PipelineCache,
    info: &vk::GraphicsPipelineCreateInfo<'_>,
) -> Result<Variants, String> {
    // SAFETY: as promised; shaders of ours are destroyed when the pipelines are made.
    unsafe {
        if let Some(why) = obstacle(info) {
            return Err(why.to_owned());
        }
        let layout = device.layouts.layout(info.layout).ok_or("there is no room for a descriptor set of ours")?;
        let stages = super::slice(info.p_stages, info.stage_count);
        let fragments = stages.iter().filter(|stage| stage.stage == vk::ShaderStageFlags::FRAGMENT);
        let asks_place = fragments.filter_map(|s| words_of(device, s)).any(|words| spirv::asks_place(&words));
        let mut matrices = Vec::new();
        for stage in stages.iter().filter(|stage| stage.stage != vk::ShaderStageFlags::FRAGMENT) {
            matrices.extend(words_of(device, stage).iter().flat_map(|words| spirv::matrices(words)));
        }
        matrices.sort_by_key(|matrix| matrix.rank);
        let spliced = last_stage(stages).ok_or("a pipeline without a vertex shader").and_then(|(index, model)| {
            let words = words_of(device, &stages[index]).ok_or("a shader whose words are not known")?;
            let entry = CStr::from_ptr(stages[index].p_name).to_string_lossy();
            Ok((index, spirv::splice(&words, model, &entry, layout.ours)?))
        });
        let states = dynamic_states(info);
        let with_count = states.contains(&vk::DynamicState::VIEWPORT_WITH_COUNT)
            || states.contains(&vk::DynamicState::SCISSOR_WITH_COUNT);
        let deep = states.contains(&vk::DynamicState::DEPTH_TEST_ENABLE)
            || info.p_depth_stencil_state.as_ref().is_some_and(|state| state.depth_test_enable == vk::TRUE);
        let mut stages = stages.to_vec();
        let mut module = vk::ShaderModule::null();
        match &spliced {
            Ok((index, words)) => {
                let info = vk::ShaderModuleCreateInfo::default().code(words);
                module = device.functions.create_shader_module(&info, None).map_err(|error| error.to_string())?;
                stages[*index].module = module;
                // The words that may be given here are the program's.
                stages[*index].p_next = std::ptr::null();
            }
            Err(why) => log::once(&format!("Vulkan: what a pipeline draws is flat: {why}")),
        }
        let made = make(device, cache, info, &stages, states);
        device.functions.destroy_shader_module(module, None);
        let (view, panel) = made.map_err(|error| format!("the driver refuses a pipeline: {error}"))?;
        Ok(Variants { view, follows: spliced.is_ok(), panel, matrices, with_count, asks_place, deep })
    }
}

/// The pipelines for a view and for the panel; the same where nothing tells them apart.
///
/// # Safety
/// `info` must be the program's, `stages` of the same pipeline.
unsafe fn make(
    device: &Device,
    cache: vk::PipelineCache,
    info: &vk::GraphicsPipelineCreateInfo<'_>,
    stages: &[vk::PipelineShaderStageCreateInfo<'_>],
    states: &[vk::DynamicState],
) -> ash::prelude::VkResult<(vk::Pipeline, vk::Pipeline)> {
    use vk::DynamicState as D;
    let mut states = states.to_vec();
    let counted = |states: &[D], plain, with_count| !states.contains(&plain) && !states.contains(&with_count);
    for (plain, with_count) in [(D::VIEWPORT, D::VIEWPORT_WITH_COUNT), (D::SCISSOR, D::SCISSOR_WITH_COUNT)] {
        if counted(&states, plain, with_count) {
            states.push(plain);
        }
    }
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&states);
    // A variant is not a derivative, and is made in any case.
    let dropped = vk::PipelineCreateFlags::DERIVATIVE
        | vk::PipelineCreateFlags::FAIL_ON_PIPELINE_COMPILE_REQUIRED
        | vk::PipelineCreateFlags::EARLY_RETURN_ON_FAILURE;
    let mut changed = (*info).stages(stages).dynamic_state(&dynamic).flags(info.flags & !dropped);
    changed.base_pipeline_handle = vk::Pipeline::null();
    changed.base_pipeline_index = -1;
    // SAFETY: as promised; the structures differ in what is said here.
    unsafe {
        let create = |info: &vk::GraphicsPipelineCreateInfo<'_>| {
            let mut made = vk::Pipeline::null();
            let create = device.functions.fp_v1_0().create_graphics_pipelines;
            create(device.functions.handle(), cache, 1, info, std::ptr::null(), &mut made).result_with_success(made)
        };
        let view = create(&changed)?;
        let Some(blend) = info.p_color_blend_state.as_ref() else { return Ok((view, view)) };
        let attachments = super::slice(blend.p_attachments, blend.attachment_count);
        let opaque = |b: &vk::PipelineColorBlendAttachmentState| {
            b.blend_enable == vk::FALSE && b.color_write_mask.contains(vk::ColorComponentFlags::A)
        };
        if attachments.iter().all(opaque) {
            return Ok((view, view));
        }
        let attachments: Vec<_> = attachments.iter().map(covering).collect();
        let blend = (*blend).attachments(&attachments);
        let panel = create(&changed.color_blend_state(&blend))
            .inspect_err(|_| device.functions.destroy_pipeline(view, None))?;
        Ok((view, panel))
    }
}

/// Whether what a pipeline draws can be seen: it has a colour attachment and rasterises.
///
/// # Safety
/// `info` must be the program's.
unsafe fn is_seen(info: &vk::GraphicsPipelineCreateInfo<'_>) -> bool {
    // SAFETY: as promised.
    let discards =
        unsafe { info.p_rasterization_state.as_ref() }.is_some_and(|r| r.rasterizer_discard_enable == vk::TRUE);
    !discards
}

hooks! { pipelines;
    [c"vkCreateGraphicsPipelines"] create_graphics_pipelines: vk::PFN_vkCreateGraphicsPipelines = (
        device: vk::Device, cache: vk::PipelineCache, count: u32, infos: *const vk::GraphicsPipelineCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, pipelines: *mut vk::Pipeline
    ) -> vk::Result { |state, next| {
        let result = next(device, cache, count, infos, allocator, pipelines);
        let made = super::slice(pipelines, count);
        for (info, &own) in super::slice(infos, count).iter().zip(made).filter(|(_, own)| **own != vk::Pipeline::null()) {
            let states = dynamic_states(info);
            let viewports = info.p_viewport_state.as_ref();
            let fixed = |dynamic: [vk::DynamicState; 2]| viewports.filter(|_| !dynamic.iter().any(|d| states.contains(d)));
            let viewport = fixed([vk::DynamicState::VIEWPORT, vk::DynamicState::VIEWPORT_WITH_COUNT]);
            let scissor = fixed([vk::DynamicState::SCISSOR, vk::DynamicState::SCISSOR_WITH_COUNT]);
            let variants = if is_seen(info) && state.draws_views() { variants(&state, cache, info) } else { Err("it is not seen".to_owned()) };
            let new = Pipeline {
                own,
                layout: state.layouts.layout(info.layout),
                viewport: viewport.and_then(|v| super::slice(v.p_viewports, v.viewport_count).first().copied()),
                scissor: scissor.and_then(|v| super::slice(v.p_scissors, v.scissor_count).first().copied()),
                variants: variants.inspect_err(|why| state.note_pipeline(why)).ok(),
            };
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

#[cfg(test)]
mod tests {
    use super::covering;
    use ash::vk;

    #[test]
    fn the_panels_alpha_collects_what_covers_it() {
        let opaque = vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA);
        assert_eq!(covering(&opaque).src_alpha_blend_factor, opaque.src_alpha_blend_factor);
        let translucent = opaque.blend_enable(true).dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA);
        assert_eq!(covering(&translucent).src_alpha_blend_factor, vk::BlendFactor::ONE);
        let additive = opaque.blend_enable(true).dst_color_blend_factor(vk::BlendFactor::ONE);
        assert_eq!(covering(&additive).dst_alpha_blend_factor, vk::BlendFactor::ONE, "light covers nothing");
        let colours = vk::ColorComponentFlags::R | vk::ColorComponentFlags::G | vk::ColorComponentFlags::B;
        assert!(covering(&opaque.color_write_mask(colours)).color_write_mask.contains(vk::ColorComponentFlags::A));
    }
}
