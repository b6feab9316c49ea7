//! State that the program binds and sets: pipelines, descriptor sets, push constants, viewports.

use crate::intercept::vk::offscreen::images::note_window;
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::images::scene_graph::Made;
use crate::intercept::vk::state::recording::bindings::{BoundSet, BoundVertices, PUSH_BYTES};
use ash::vk;

hooks! {
    cmd_bind_pipeline = (
        buffer: vk::CommandBuffer, point: vk::PipelineBindPoint, pipeline: vk::Pipeline
    ) { |state, next| {
        if point == vk::PipelineBindPoint::COMPUTE {
            state.recordings.with(buffer, |recording| recording.compute.bind(pipeline));
        }
        if point == vk::PipelineBindPoint::GRAPHICS {
            let known = state.pipelines.get(pipeline);
            state.recordings.with(buffer, |recording| {
                recording.graphics.pipeline = known;
                recording.graphics.current = pipeline;
            });
        }
        next(buffer, point, pipeline)
    } }
    cmd_bind_descriptor_sets = (
        buffer: vk::CommandBuffer, point: vk::PipelineBindPoint, layout: vk::PipelineLayout, first: u32, count: u32, sets: *const vk::DescriptorSet, dynamic_count: u32, dynamic: *const u32
    ) { |state, next| {
        let known = [vk::PipelineBindPoint::GRAPHICS, vk::PipelineBindPoint::COMPUTE];
        if !known.contains(&point) {
            note_window(&state, slice(sets, count).iter().flat_map(|set| state.descriptors.stored(*set)));
        }
        if !known.contains(&point) && state.images.has_candidates() {
            let views = slice(sets, count).iter().flat_map(|set| [state.descriptors.pictures(*set), state.descriptors.stored(*set)].concat());
            let images = views.filter_map(|view| state.images.candidate_of(view));
            images.for_each(|image| state.scene_graph.note_made(image, Made::Elsewhere));
        }
        if point == vk::PipelineBindPoint::GRAPHICS || point == vk::PipelineBindPoint::COMPUTE {
            let (sets, mut offsets) = (slice(sets, count), slice(dynamic, dynamic_count));
            let bound: Vec<BoundSet> = sets.iter().map(|set| {
                let number = (state.descriptors.dynamic_offsets(*set) as usize).min(offsets.len());
                let (own, rest) = offsets.split_at(number);
                offsets = rest;
                BoundSet { set: *set, dynamic: own.to_vec(), pushed: None }
            }).collect();
            state.recordings.with(buffer, |recording| {
                if point == vk::PipelineBindPoint::COMPUTE {
                    return recording.compute.bind_sets(layout, first, bound);
                }
                let end = first as usize + bound.len();
                if recording.graphics.bound.len() < end {
                    recording.graphics.bound.resize(end, None);
                }
                for (place, bound) in recording.graphics.bound.iter_mut().skip(first as usize).zip(bound) {
                    *place = Some(bound);
                }
            });
        }
        next(buffer, point, layout, first, count, sets, dynamic_count, dynamic)
    } }
    cmd_push_constants = (
        buffer: vk::CommandBuffer, layout: vk::PipelineLayout, stages: vk::ShaderStageFlags, offset: u32, size: u32, values: *const std::ffi::c_void
    ) { |state, next| {
        let given = slice(values.cast::<u8>(), size);
        if stages.contains(vk::ShaderStageFlags::COMPUTE) {
            state.recordings.with(buffer, |recording| recording.compute.push_constants(offset as usize, given));
        }
        if stages != vk::ShaderStageFlags::COMPUTE {
            let values = given;
            state.recordings.with(buffer, |recording| {
                let start = (offset as usize).min(PUSH_BYTES);
                let end = (start + values.len()).min(PUSH_BYTES);
                recording.graphics.push[start..end].copy_from_slice(&values[..end - start]);
            });
        }
        next(buffer, layout, stages, offset, size, values)
    } }
    cmd_set_viewport = (
        buffer: vk::CommandBuffer, first: u32, count: u32, viewports: *const vk::Viewport
    ) { |state, next| {
        if let (0, Some(viewport)) = (first, slice(viewports, count).first()) {
            state.recordings.with(buffer, |recording| recording.graphics.viewport = Some(*viewport));
        }
        next(buffer, first, count, viewports)
    } }
    cmd_set_scissor = (
        buffer: vk::CommandBuffer, first: u32, count: u32, scissors: *const vk::Rect2D
    ) { |state, next| {
        if let (0, Some(scissor)) = (first, slice(scissors, count).first()) {
            state.recordings.with(buffer, |recording| recording.graphics.scissor = Some(*scissor));
        }
        next(buffer, first, count, scissors)
    } }
    cmd_set_viewport_with_count = (
        buffer: vk::CommandBuffer, count: u32, viewports: *const vk::Viewport
    ) { |state, next| {
        if let Some(viewport) = slice(viewports, count).first() {
            state.recordings.with(buffer, |recording| recording.graphics.viewport = Some(*viewport));
        }
        next(buffer, count, viewports)
    } }
    cmd_set_scissor_with_count = (
        buffer: vk::CommandBuffer, count: u32, scissors: *const vk::Rect2D
    ) { |state, next| {
        if let Some(scissor) = slice(scissors, count).first() {
            state.recordings.with(buffer, |recording| recording.graphics.scissor = Some(*scissor));
        }
        next(buffer, count, scissors)
    } }
    cmd_bind_vertex_buffers = (
        buffer: vk::CommandBuffer, first: u32, count: u32, buffers: *const vk::Buffer, offsets: *const vk::DeviceSize
    ) { |state, next| {
        let bound = slice(buffers, count).iter().zip(slice(offsets, count));
        let bound = bound.map(|(buffer, offset)| BoundVertices { buffer: *buffer, offset: *offset, stride: None });
        state.recordings.with(buffer, |recording| recording.graphics.bind_vertices(first, bound));
        next(buffer, first, count, buffers, offsets)
    } }
    cmd_bind_vertex_buffers2 = (
        buffer: vk::CommandBuffer, first: u32, count: u32, buffers: *const vk::Buffer, offsets: *const vk::DeviceSize,
        sizes: *const vk::DeviceSize, strides: *const vk::DeviceSize
    ) { |state, next| {
        let strides_given = if strides.is_null() { &[][..] } else { slice(strides, count) };
        let bound = slice(buffers, count).iter().zip(slice(offsets, count)).enumerate();
        let bound = bound.map(|(index, (buffer, offset))| {
            BoundVertices { buffer: *buffer, offset: *offset, stride: strides_given.get(index).copied() }
        });
        state.recordings.with(buffer, |recording| recording.graphics.bind_vertices(first, bound));
        next(buffer, first, count, buffers, offsets, sizes, strides)
    } }
    cmd_bind_shaders = (
        buffer: vk::CommandBuffer, count: u32, stages: *const vk::ShaderStageFlags, shaders: *const vk::ShaderEXT
    ) { |state, next| {
        state.show_flat("shader objects");
        next(buffer, count, stages, shaders)
    } }
}

/// Sets the viewport and scissor of a command buffer; `with_count`: sets their number, too.
///
/// # Safety
/// The command buffer is being recorded, with a pipeline for which these states are dynamic in this
/// form.
pub unsafe fn set_window(
    device: &crate::intercept::vk::state::device::Device,
    buffer: vk::CommandBuffer,
    viewport: &vk::Viewport,
    scissor: &vk::Rect2D,
    with_count: bool,
) {
    let next = &device.next;
    // SAFETY: as promised.
    unsafe {
        match (next.cmd_set_viewport_with_count, next.cmd_set_scissor_with_count, with_count) {
            (Some(set_viewport), Some(set_scissor), true) => {
                set_viewport(buffer, 1, viewport);
                set_scissor(buffer, 1, scissor);
            }
            _ => {
                device.driver.functions.cmd_set_viewport(buffer, 0, std::slice::from_ref(viewport));
                device.driver.functions.cmd_set_scissor(buffer, 0, std::slice::from_ref(scissor));
            }
        }
    }
}
