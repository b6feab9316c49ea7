//! Hooks of draws: in a pass that draws to views, a draw is issued once per view. Other draws are
//! passed on unchanged.

use crate::intercept::vk::commands::draws::rebind::restore;
use crate::intercept::vk::commands::draws::replicate::{self, ProgramDraw};
use crate::intercept::vk::offscreen::scene_graph::{self, Cover};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::pipelines::Pipeline;
use crate::intercept::vk::state::recording::draw_parameters::{DrawParameters, DrawSize};
use crate::intercept::vk::state::recording::{Recording, count_draw};
use ash::vk;

/// Issues a draw of the program with `issue`.
///
/// # Safety
/// The command buffer is being recorded; `issue` records the program's own draw, with this `size`.
unsafe fn draw(device: &Device, buffer: vk::CommandBuffer, size: DrawSize, issue: impl Fn()) {
    let known = device.recordings.with(buffer, |recording| {
        let pipeline = recording.graphics.pipeline.clone();
        if let Some(pipeline) = &pipeline {
            // SAFETY: as promised.
            unsafe {
                if recording.pass.is_some() {
                    let draw = ProgramDraw { device, buffer, pipeline, size, issue: &issue };
                    return replicate::draw_to_views(&draw, recording);
                }
                if device.images.has_candidates() && device.draws_views() {
                    note_candidate(device, recording, pipeline, &size);
                }
                restore(device, buffer, recording);
            }
        }
        count_draw(recording, None, size.vertices(), Some(1));
        issue();
    });
    if known.is_none() {
        issue();
    }
}

/// Notes how a draw in a pass of the program's own uses images that may hold a scene.
fn note_candidate(device: &Device, recording: &mut Recording, pipeline: &Pipeline, size: &DrawSize) {
    let targets = recording.plain.iter().flatten();
    let image = targets.filter_map(|target| Some((*target, device.images.size(*target)?))).next();
    let viewport = pipeline.viewport.or(recording.graphics.viewport).unwrap_or_default();
    let matrices = pipeline.variants.as_ref().map_or(&[][..], |variants| &variants.matrices);
    let main_picture =
        image.is_some_and(|(image, size)| device.scene_graph.is_main(image, &viewport, (size, !matrices.is_empty())));
    scene_graph::note_draw(
        device,
        recording,
        matrices,
        size.first_instance(),
        Cover {
            main_picture,
            few_vertices: size.may_cover_viewport(),
            has_matrices: !matrices.is_empty(),
            told_place: pipeline.variants.as_ref().is_some_and(|variants| variants.moves_place),
        },
    );
}

hooks! {
    cmd_draw = (
        buffer: vk::CommandBuffer, vertices: u32, instances: u32, first_vertex: u32, first_instance: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Known(DrawParameters::of_vertices(vertices, instances, first_vertex, first_instance)), || next(buffer, vertices, instances, first_vertex, first_instance)) }
    cmd_draw_indexed = (
        buffer: vk::CommandBuffer, indices: u32, instances: u32, first_index: u32, vertex_offset: i32, first_instance: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Known(DrawParameters::of_indices(indices, instances, first_index, vertex_offset, first_instance)), || next(buffer, indices, instances, first_index, vertex_offset, first_instance)) }
    cmd_draw_indirect = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, count: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, count, stride)) }
    cmd_draw_indexed_indirect = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, count: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, count, stride)) }
    cmd_draw_indirect_count = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, counts: vk::Buffer, count_offset: vk::DeviceSize, most: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, counts, count_offset, most, stride)) }
    cmd_draw_indexed_indirect_count = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, counts: vk::Buffer, count_offset: vk::DeviceSize, most: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, counts, count_offset, most, stride)) }
    cmd_draw_multi = (
        buffer: vk::CommandBuffer, count: u32, infos: *const vk::MultiDrawInfoEXT, instances: u32, first_instance: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, count, infos, instances, first_instance, stride)) }
    cmd_draw_multi_indexed = (
        buffer: vk::CommandBuffer, count: u32, infos: *const vk::MultiDrawIndexedInfoEXT, instances: u32, first_instance: u32, stride: u32, vertex_offset: *const i32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, count, infos, instances, first_instance, stride, vertex_offset)) }
    cmd_draw_mesh_tasks = (
        buffer: vk::CommandBuffer, x: u32, y: u32, z: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, x, y, z)) }
    cmd_draw_mesh_tasks_nv = (
        buffer: vk::CommandBuffer, count: u32, first: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, count, first)) }
    cmd_draw_mesh_tasks_indirect = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, count: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, count, stride)) }
    cmd_draw_mesh_tasks_indirect_nv = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, count: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, count, stride)) }
    cmd_draw_mesh_tasks_count = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, counts: vk::Buffer, count_offset: vk::DeviceSize, most: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, counts, count_offset, most, stride)) }
    cmd_draw_mesh_tasks_count_nv = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize, counts: vk::Buffer, count_offset: vk::DeviceSize, most: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, from, offset, counts, count_offset, most, stride)) }
    cmd_draw_indirect_byte_count = (
        buffer: vk::CommandBuffer, instances: u32, first_instance: u32, counter: vk::Buffer, offset: vk::DeviceSize, counter_offset: u32, stride: u32
    ) { |state, next| draw(&state, buffer, DrawSize::Unknown, || next(buffer, instances, first_instance, counter, offset, counter_offset, stride)) }
    cmd_begin_transform_feedback = (
        buffer: vk::CommandBuffer, first: u32, count: u32, buffers: *const vk::Buffer, offsets: *const vk::DeviceSize
    ) { |state, next| {
        // Each draw would be captured several times.
        if state.recordings.with(buffer, |recording| recording.pass.is_some()) == Some(true) {
            state.show_flat("it uses transform feedback in a pass to the window");
        }
        next(buffer, first, count, buffers, offsets)
    } }
}
