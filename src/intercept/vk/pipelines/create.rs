//! Creation of the pipelines that draw into the tiles: for a view and for the panel.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::pipelines::create_info::{Parts, Relinked};
use crate::intercept::vk::state::pipelines::{Pipeline, TilePipelines, Variants};
use ash::vk;
use std::sync::Arc;

/// Returns blending in which the alpha of the panel collects how much of it is covered. The
/// composition needs this.
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

/// What the pipelines of the tiles are made from.
pub struct Sources<'a> {
    /// Stages for the views and for the panel.
    pub stages: [&'a [vk::PipelineShaderStageCreateInfo<'a>]; 2],
    /// Libraries of the program that its pipeline is linked from.
    pub linked: &'a [Arc<Pipeline>],
    /// Chooses those variants of a library that are linked.
    pub of_library: fn(&Variants) -> TilePipelines,
}

/// Makes the pipelines for a view and for the panel, each with its stages. They are the same
/// pipeline if there is no difference.
///
/// # Errors
/// The request that the driver refuses, or the library that cannot be linked.
///
/// # Safety
/// `parts` must be of a pipeline that the program has just made; the sources must be of the same
/// pipeline.
pub unsafe fn create(
    device: &Device,
    cache: vk::PipelineCache,
    parts: &Parts<'_>,
    sources: &Sources<'_>,
) -> Result<TilePipelines, Obstacle> {
    use vk::DynamicState as D;
    let Sources { stages, linked, of_library } = sources;
    let mut states = parts.dynamic.to_vec();
    for (plain, with_count) in [(D::VIEWPORT, D::VIEWPORT_WITH_COUNT), (D::SCISSOR, D::SCISSOR_WITH_COUNT)] {
        if parts.places_vertices() && !states.contains(&plain) && !states.contains(&with_count) {
            states.push(plain);
        }
    }
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&states);
    // A variant is not a derivative, and must be made in any case.
    let dropped = vk::PipelineCreateFlags::DERIVATIVE
        | vk::PipelineCreateFlags::FAIL_ON_PIPELINE_COMPILE_REQUIRED
        | vk::PipelineCreateFlags::EARLY_RETURN_ON_FAILURE;
    let mut changed = (*parts.info).stages(stages[0]).dynamic_state(&dynamic).flags(parts.info.flags & !dropped);
    changed.base_pipeline_handle = vk::Pipeline::null();
    changed.base_pipeline_index = -1;
    let create = |mut info: vk::GraphicsPipelineCreateInfo<'_>, of: fn(TilePipelines) -> vk::Pipeline| {
        let libraries = linked.iter().filter_map(|library| library.variants.as_ref());
        let libraries: Vec<_> = libraries.map(|variants| of(of_library(variants))).collect();
        // SAFETY: as promised; the structures differ only in the fields that are set here.
        unsafe {
            let chain = Some(info.p_next).filter(|_| !libraries.is_empty());
            let chain = chain.map(|chain| Relinked::new(chain, libraries).ok_or("unknown structures in a chain"));
            let chain = chain.transpose()?;
            info.p_next = chain.as_ref().map_or(info.p_next, Relinked::first);
            let mut made = vk::Pipeline::null();
            let create = device.driver.functions.fp_v1_0().create_graphics_pipelines;
            let result = create(device.driver.functions.handle(), cache, 1, &info, std::ptr::null(), &mut made);
            result.result_with_success(made).map_err(|error| format!("the driver refuses a pipeline: {error}"))
        }
    };
    let view = create(changed, |tiles| tiles.view)?;
    // SAFETY: the program's array.
    let blends = parts.blend.map(|blend| unsafe { slice(blend.p_attachments, blend.attachment_count) });
    let opaque = |b: &vk::PipelineColorBlendAttachmentState| {
        b.blend_enable == vk::FALSE && b.color_write_mask.contains(vk::ColorComponentFlags::A)
    };
    let variants = linked.iter().filter_map(|library| library.variants.as_ref());
    let alike = stages[0].len() == stages[1].len() && blends.unwrap_or_default().iter().all(opaque);
    if alike && variants.map(*of_library).all(|library| library.view == library.panel) {
        return Ok(TilePipelines { view, panel: view });
    }
    let attachments: Vec<_> = blends.unwrap_or_default().iter().map(covering).collect();
    let blend = parts.blend.map(|blend| (*blend).attachments(&attachments));
    changed = changed.stages(stages[1]);
    if let Some(blend) = &blend {
        changed = changed.color_blend_state(blend);
    }
    // SAFETY: a pipeline of Cupola that nothing uses yet.
    let undone = |_: &String| unsafe { device.driver.functions.destroy_pipeline(view, None) };
    let panel = create(changed, |tiles| tiles.panel).inspect_err(undone)?;
    Ok(TilePipelines { view, panel })
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
