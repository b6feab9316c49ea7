//! The geometry stage that divides primitives. Decides which pipelines get one, and gives the
//! reason why others do not.

use crate::correct::projected::division::Input;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::projected_vertices::geometry_stage::{Limits, divide};
use crate::intercept::vk::projected_vertices::stage_outputs::stage_outputs;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::in_chain;
use crate::intercept::vk::state::pipelines::PipelineLayout;
use crate::intercept::vk::state::pipelines::create_info::Parts;
use crate::intercept::vk::state::pipelines::stages::{name_of, words_of};
use ::spirv::ExecutionModel;
use ash::vk;

const NO_COUNTER: &str = "it needs the feature vertexPipelineStoresAndAtomics of the device";
const NO_ROOM: &str = "a pipeline has no storage buffer to spare";

/// Returns the words of a geometry stage that reads the view constants through Cupola's set of
/// `layout`, and counts in it; `None` if there is nothing to divide.
///
/// # Errors
/// The reason why primitives that could be divided are not, for the log.
///
/// # Safety
/// `parts` must be of a pipeline that the program has just made, and that can be followed.
pub unsafe fn stage(device: &Device, parts: &Parts<'_>, layout: &PipelineLayout) -> Result<Option<Vec<u32>>, Obstacle> {
    let stage_of = |flag: vk::ShaderStageFlags| parts.stages.iter().find(|stage| stage.stage == flag);
    let others = |stage: &vk::PipelineShaderStageCreateInfo<'_>| {
        ![vk::ShaderStageFlags::VERTEX, vk::ShaderStageFlags::FRAGMENT].contains(&stage.stage)
    };
    if !device.role.divides() {
        return Ok(None);
    }
    if parts.stages.iter().any(others) {
        return Err("it has geometry or tessellation shaders of its own".into());
    }
    if !parts.shades_all() {
        return Err("it is linked from libraries with separate shaders".into());
    }
    // SAFETY: as promised; a pipeline with a vertex shader has these structures.
    unsafe {
        let feedback = vk::StructureType::PIPELINE_CREATION_FEEDBACK_CREATE_INFO;
        let feedback = in_chain::<vk::PipelineCreationFeedbackCreateInfo<'_>>(parts.info.p_next, feedback);
        if feedback.is_some_and(|feedback| feedback.pipeline_stage_creation_feedback_count > 0) {
            return Err("the program requests creation feedback for each stage".into());
        }
        let raster = parts.info.p_rasterization_state.as_ref();
        if raster.is_some_and(|raster| raster.polygon_mode == vk::PolygonMode::POINT) {
            return Ok(None);
        }
        let Some(input) = input(device, parts)? else { return Ok(None) };
        let Some(vertex) = stage_of(vk::ShaderStageFlags::VERTEX) else { return Ok(None) };
        const UNKNOWN: &str = "its shaders' words are not known";
        let fragment = stage_of(vk::ShaderStageFlags::FRAGMENT);
        let fragment = match fragment {
            Some(stage) => Some((words_of(device, stage).ok_or(UNKNOWN)?, name_of(stage))),
            None => None,
        };
        let (words, name) = (words_of(device, vertex).ok_or(UNKNOWN)?, name_of(vertex));
        let fragment = fragment.as_ref().map(|(words, name)| (&words[..], ExecutionModel::Fragment, name.as_str()));
        let outputs = stage_outputs((&words, ExecutionModel::Vertex, &name), fragment)?;
        let provoking = if provokes_last(parts)? { input.corners() - 1 } else { 0 };
        let limits = &device.driver.limits;
        let limits = Limits {
            vertices: limits.max_geometry_output_vertices,
            all_components: limits.max_geometry_total_output_components,
            components: [limits.max_geometry_input_components, limits.max_geometry_output_components],
            runs: limits.max_geometry_shader_invocations,
        };
        let words = divide(input, &outputs, provoking, layout.ours, layout.counts, &limits)?;
        if !layout.counts {
            device.pipelines.divided.note_uncounted(if device.role.vertices.counts { NO_ROOM } else { NO_COUNTER });
        }
        Ok(Some(words))
    }
}

/// Returns the kind of primitives that the pipeline draws, if they can be divided.
///
/// # Safety
/// As for [`stage`].
unsafe fn input(device: &Device, parts: &Parts<'_>) -> Result<Option<Input>, Obstacle> {
    if device.role.topologies_change && parts.dynamic.contains(&vk::DynamicState::PRIMITIVE_TOPOLOGY) {
        return Err("commands may change the kind of its primitives".into());
    }
    // SAFETY: as promised; if commands set the topology, its class is given here.
    let assembly = unsafe { parts.info.p_input_assembly_state.as_ref() };
    use vk::PrimitiveTopology as T;
    Ok(match assembly.map(|assembly| assembly.topology) {
        Some(T::TRIANGLE_LIST | T::TRIANGLE_STRIP | T::TRIANGLE_FAN) => Some(Input::Triangles),
        Some(T::LINE_LIST | T::LINE_STRIP) => Some(Input::Lines),
        Some(T::POINT_LIST) => None,
        _ => return Err("it draws primitives with neighbours".into()),
    })
}

/// True if values that are not interpolated come from the last vertex of a primitive.
///
/// # Safety
/// As for [`stage`].
unsafe fn provokes_last(parts: &Parts<'_>) -> Result<bool, Obstacle> {
    if parts.dynamic.contains(&vk::DynamicState::PROVOKING_VERTEX_MODE_EXT) {
        return Err("commands may change which of its vertices is the provoking one".into());
    }
    let kind = vk::StructureType::PIPELINE_RASTERIZATION_PROVOKING_VERTEX_STATE_CREATE_INFO_EXT;
    // SAFETY: as promised.
    let given = unsafe {
        let raster = parts.info.p_rasterization_state.as_ref();
        raster.and_then(|raster| {
            in_chain::<vk::PipelineRasterizationProvokingVertexStateCreateInfoEXT<'_>>(raster.p_next, kind)
        })
    };
    Ok(given.is_some_and(|given| given.provoking_vertex_mode == vk::ProvokingVertexModeEXT::LAST_VERTEX))
}
