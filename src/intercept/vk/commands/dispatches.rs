//! Dispatches of compute shaders on the way from the scene to the window.
//!
//! Invocations of a compute shader use pixel positions in the program's image. Images that compute
//! shaders read or write therefore have a copy for each view, as large as the program's image. A
//! dispatch that writes such images is recorded once for each view, with copies of its descriptor
//! sets. The program's own dispatch follows, on the program's images. So numbers that the dispatch
//! gathers in buffers are gathered once.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::commands::draws::tiles::PerViewSet;
use crate::intercept::vk::offscreen::images::{READ_TOGETHER, WRITES_WINDOW, note_window};
use crate::intercept::vk::offscreen::view_copies;
use crate::intercept::vk::pipelines::matrix_sources::compute_source;
use crate::intercept::vk::spirv::{BufferWrites, DescriptorPlace};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::images::scene_graph::Made;
use crate::intercept::vk::state::pipelines::{CameraMatrix, ComputePipeline, ComputeVariant};
use crate::intercept::vk::state::recording::bindings::{Pushed, Write};
use crate::intercept::vk::state::recording::draw_groups::{CameraSource, DrawFacts, DrawGroup};
use crate::intercept::vk::state::recording::{Event, Recording};
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::intercept::vk::state::views::view_constants::{ChunkOffset, SlotParts};
use crate::intercept::vk::state::views::view_target::ViewTarget;
use ash::vk;
use std::sync::Arc;

/// Greatest number of texels of an image that counts as numbers for the whole picture, and not as a
/// picture.
const MOST_NUMBERS: u32 = 256;

/// Reason that prevents a dispatch from being followed.
const LOST: &str = "a compute shader writes a picture of its scene together with numbers of its own";

/// Images that a dispatch reads and writes.
struct Used {
    /// Images that may hold a scene and are read.
    read: Vec<vk::Image>,
    /// Images that may hold a scene and are written.
    written: Vec<vk::Image>,
    /// The window's image, if it is written.
    window: Option<Arc<ViewTarget>>,
    /// True if it writes numbers that all views share.
    numbers: bool,
    /// True if it writes data that would be needed for each view, but cannot be kept for each view.
    lost: bool,
}

/// Returns the images of bound descriptors.
fn images<'a>(
    device: &'a Device,
    recording: &'a Recording,
    places: &'a [DescriptorPlace],
) -> impl Iterator<Item = vk::Image> + 'a {
    places.iter().flat_map(move |(set, binding)| {
        let bound = recording.compute.sets().iter().find(|(number, ..)| number == set);
        let views = bound.map_or(Vec::new(), |(.., bound)| match &bound.pushed {
            Some(pushed) => {
                let of_binding = pushed.writes.iter().filter(|write| write.binding == *binding);
                of_binding.flat_map(Write::views).collect()
            }
            None => device.descriptors.pictures_of(bound.set, *binding),
        });
        views.into_iter().filter_map(|view| device.images.of(view))
    })
}

impl Used {
    /// `single`: there is only one work group, so that its results belong to no position in the
    /// picture.
    fn of(device: &Device, recording: &Recording, pipeline: &ComputePipeline, single: bool) -> Self {
        let uses = &pipeline.uses;
        let read = images(device, recording, &uses.read).filter(|image| device.images.is_candidate(*image)).collect();
        let mut used = Self { read, written: Vec::new(), window: None, numbers: false, lost: false };
        let window = |image: vk::Image| device.images.target_of_image(image).filter(|target| target.window);
        if images(device, recording, &uses.read).any(|image| window(image).is_some()) {
            device.show_flat(READ_TOGETHER);
        }
        for image in images(device, recording, &uses.written) {
            if let Some(window) = window(image) {
                used.window = Some(window);
                continue;
            }
            let few = device.images.size(image).is_some_and(|(width, height)| width * height <= MOST_NUMBERS);
            match device.images.is_candidate(image) {
                _ if few => used.numbers = true,
                true => used.written.push(image),
                false => used.lost = true,
            }
        }
        match uses.buffers {
            BufferWrites::Nothing => {}
            BufferWrites::Places if !single => used.lost = true,
            BufferWrites::Sums | BufferWrites::Places => used.numbers = true,
        }
        // A dispatch for each view would gather them several times.
        let gathers = uses.buffers != BufferWrites::Nothing || uses.image_atomics;
        used.lost |= pipeline.loses_cameras || gathers && (!used.written.is_empty() || used.window.is_some());
        used
    }

    /// Notes the results that are made from images that may hold a scene.
    fn note(&self, device: &Device) {
        let graph = &device.scene_graph;
        for read in &self.read {
            if self.lost {
                graph.note_made(*read, Made::Elsewhere);
            }
            if self.numbers {
                graph.note_measured(*read);
            }
            for written in self.written.iter().filter(|written| *written != read) {
                graph.note_made(*read, Made::Image(*written));
            }
            if self.window.is_some() {
                graph.note_made(*read, Made::Window);
            }
            graph.note_computed(*read);
        }
        for written in &self.written {
            if self.lost {
                graph.note_made(*written, Made::Elsewhere);
            }
            graph.note_computed(*written);
        }
    }
}

/// Notes that a dispatch of an unknown shader may do anything with the bound images.
fn note_unknown(device: &Device, recording: &Recording) {
    let stored = |set: vk::DescriptorSet| device.descriptors.stored(set);
    let sets = recording.compute.sets().iter().filter(|(.., bound)| bound.pushed.is_none());
    note_window(device, sets.flat_map(|(.., bound)| stored(bound.set)));
    if !device.images.has_candidates() {
        return;
    }
    let views = recording.compute.sets().iter().flat_map(|(.., bound)| match &bound.pushed {
        Some(pushed) => pushed.writes.iter().flat_map(Write::views).collect(),
        None => [device.descriptors.pictures(bound.set), device.descriptors.stored(bound.set)].concat(),
    });
    let images = views.filter_map(|view| device.images.candidate_of(view));
    images.for_each(|image| device.scene_graph.note_made(image, Made::Elsewhere));
}

/// Issues a dispatch with `issue`: once for each view, and once as the program's own. `groups`:
/// number of its work groups, if it is known.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass.
unsafe fn dispatch(device: &Device, buffer: vk::CommandBuffer, groups: Option<u32>, issue: &dyn Fn()) {
    let followed = device.recordings.with(buffer, |recording| {
        let Some(pipeline) = device.pipelines.computing(recording.compute.pipeline()) else {
            note_unknown(device, recording);
            return None;
        };
        let used = Used::of(device, recording, &pipeline, groups == Some(1));
        // SAFETY: as promised.
        let followed = unsafe { follow(device, buffer, recording, (&pipeline, &used), issue) };
        let on_window = followed.as_ref().is_ok_and(|scenes| scenes.is_some());
        // Without a scene the window never has views. With a scene it has views from one of the
        // next frames on.
        if used.window.is_some() && !on_window && (used.read.is_empty() || !device.scene_graph.may_be_followed()) {
            device.show_flat(WRITES_WINDOW);
        }
        recording.events.extend(used.window.as_ref().map(|window| Event::Drawn(Arc::clone(window), on_window)));
        let scenes = followed.unwrap_or_else(|why| {
            device.show_flat(why);
            None
        });
        used.window.zip(scenes)
    });
    issue();
    if let Some((window, scenes)) = followed.flatten() {
        // SAFETY: as promised.
        unsafe { view_copies::show(device, buffer, &scenes, &window) };
    }
}

/// Issues a dispatch for each view, if it makes pictures of the scene. Returns the copies that
/// replace the window's image, if it writes that image.
///
/// # Errors
/// The reason why it cannot.
///
/// # Safety
/// As for [`dispatch`].
unsafe fn follow(
    device: &Device,
    buffer: vk::CommandBuffer,
    recording: &mut Recording,
    (pipeline, used): (&ComputePipeline, &Used),
    issue: &dyn Fn(),
) -> Result<Option<Arc<ViewTarget>>, Obstacle> {
    if !device.draws_views() || used.read.is_empty() && used.written.is_empty() {
        return Ok(None);
    }
    used.note(device);
    let scenes = |images: &[vk::Image]| -> Vec<Arc<ViewTarget>> {
        images.iter().filter_map(|image| device.images.scene(*image)).collect()
    };
    let (read, mut written) = (scenes(&used.read), scenes(&used.written));
    if used.lost {
        // A dispatch for each view would repeat work that must be done once.
        return if written.is_empty() { Ok(None) } else { Err(LOST.into()) };
    }
    // Images with views of another layout are replaced by new ones when the frame ends.
    let is_late = written.iter().chain(&read).any(|target| !target.layout.even);
    let window = used.window.as_ref().filter(|_| !read.is_empty() && !is_late);
    let window = window.map(|window| device.images.make_window_copies(device, window)).transpose()?;
    written.extend(window.clone());
    let Some(layout) = written.first().map(|target| Arc::clone(&target.layout)).filter(|_| !is_late) else {
        // The written images may be followed from the next frame on, when these commands are run
        // again.
        let of_window = used.window.iter().flat_map(|_| &used.read);
        let images: Vec<vk::Image> = used.written.iter().chain(of_window).copied().collect();
        recording.events.extend((!images.is_empty()).then_some(Event::Computed(images)));
        return Ok(None);
    };
    let bindings = Bindings::of_views(device, recording, pipeline, &layout)?;
    // SAFETY: as promised; the sets have the layouts of the program's sets, which the program bound
    // under these numbers.
    unsafe {
        view_copies::wait(device, buffer);
        for view in 0..layout.views.len() {
            bindings.bind(device, buffer, view);
            issue();
        }
        view_copies::wait(device, buffer);
        for target in written.iter().filter(|target| device.images.is_attached(target.given)) {
            view_copies::write_back(device, buffer, target);
        }
        recording.compute.restore(&device.driver, &device.next, buffer);
    }
    read.into_iter().chain(written).for_each(|target| recording.samples(target));
    Ok(window)
}

/// Descriptors of a dispatch in each view.
struct Bindings<'a> {
    /// The pipeline of Cupola with its view constants, if the shader has camera matrices.
    variant: Option<(&'a ComputeVariant, vk::DescriptorSet, ChunkOffset)>,
    sets: Vec<(vk::PipelineLayout, PerViewSet)>,
    /// Pushed descriptors of each view, by layout and number of their set.
    pushes: Vec<(vk::PipelineLayout, u32, Vec<Pushed>)>,
}

impl<'a> Bindings<'a> {
    /// # Errors
    /// The reason why there are none.
    fn of_views(
        device: &Device,
        recording: &mut Recording,
        pipeline: &'a ComputePipeline,
        layout: &Arc<AtlasLayout>,
    ) -> Result<Self, Obstacle> {
        let (mut sets, mut pushes) = (Vec::new(), Vec::new());
        for (number, handle, bound) in recording.compute.sets() {
            if let Some(pushed) = &bound.pushed {
                pushes.extend(pushed.of_views(device, layout)?.map(|of_views| (*handle, *number, of_views)));
            } else if let Some(copies) = device.descriptors.of_views(device, bound.set, layout)? {
                let dynamic = bound.dynamic.clone();
                sets.push((*handle, PerViewSet { number: *number, sets: copies, dynamic, attachments: false }));
            }
        }
        let with_constants = |variant: &'a ComputeVariant| {
            let (set, constants) = cameras(device, recording, layout, variant)?;
            Ok::<_, Obstacle>((variant, set, constants))
        };
        Ok(Self { variant: pipeline.variant.as_ref().map(with_constants).transpose()?, sets, pushes })
    }

    /// Binds the descriptors of a view; binds the pipeline only for the first view.
    ///
    /// # Safety
    /// The command buffer is being recorded, with the program's pipeline and layouts.
    unsafe fn bind(&self, device: &Device, buffer: vk::CommandBuffer, view: usize) {
        let (functions, point) = (&device.driver.functions, vk::PipelineBindPoint::COMPUTE);
        // SAFETY: as promised.
        unsafe {
            if let Some((variant, set, constants)) = &self.variant {
                if view == 0 {
                    functions.cmd_bind_pipeline(buffer, point, variant.pipeline);
                }
                let (layout, offsets) = (&variant.layout, [constants.slot(view as u32)]);
                functions.cmd_bind_descriptor_sets(buffer, point, layout.handle, layout.ours, &[*set], &offsets);
            }
            for (handle, PerViewSet { number, sets, dynamic, .. }) in &self.sets {
                let Some(set) = sets.get(view) else { continue };
                functions.cmd_bind_descriptor_sets(buffer, point, *handle, *number, &[*set], dynamic);
            }
            for (handle, number, of_views) in &self.pushes {
                if let Some(pushed) = of_views.get(view) {
                    pushed.repeat(&device.next, buffer, point, *handle, *number);
                }
            }
        }
    }
}

/// Returns the view constants with the camera matrices of each view: their descriptor set and
/// offset.
///
/// # Errors
/// There is no memory.
fn cameras(
    device: &Device,
    recording: &mut Recording,
    layout: &Arc<AtlasLayout>,
    variant: &ComputeVariant,
) -> Result<(vk::DescriptorSet, ChunkOffset), Obstacle> {
    let camera = |camera: &CameraMatrix| {
        let CameraMatrix { matrix, called, stage, inverted } = *camera;
        CameraSource { source: compute_source(device, recording, &matrix), called, stage, inverted }
    };
    let cameras = variant.cameras.iter().map(camera).collect();
    let facts = DrawFacts {
        cameras,
        y_up: recording.y_up,
        in_views: true,
        off_screen: true,
        screen: true,
        ..Default::default()
    };
    let (slots, stride) = (2 + layout.views.len(), device.slot_stride(SlotParts::Cameras));
    let taken = device.view_constants.take(&device.driver, &mut recording.constants, slots, stride);
    let constants = taken.map_err(|error| format!("there is no memory for the constants of {slots} tiles: {error}"))?;
    recording.events.push(Event::DrawGroup(recording.draw_groups.len()));
    recording.draw_groups.push(DrawGroup::new(constants, Arc::clone(layout), facts));
    let chunk = recording.constants.chunks.get(constants.chunk).ok_or("its constants are gone")?;
    Ok((chunk.set(variant.layout.counts), constants))
}

hooks! {
    cmd_dispatch = (buffer: vk::CommandBuffer, x: u32, y: u32, z: u32) { |state, next| {
        let groups = x.saturating_mul(y).saturating_mul(z);
        dispatch(&state, buffer, Some(groups), &|| next(buffer, x, y, z))
    } }
    cmd_dispatch_base = (
        buffer: vk::CommandBuffer, first_x: u32, first_y: u32, first_z: u32, x: u32, y: u32, z: u32
    ) { |state, next| {
        let groups = x.saturating_mul(y).saturating_mul(z);
        dispatch(&state, buffer, Some(groups), &|| next(buffer, first_x, first_y, first_z, x, y, z))
    } }
    cmd_dispatch_indirect = (
        buffer: vk::CommandBuffer, from: vk::Buffer, offset: vk::DeviceSize
    ) { |state, next| dispatch(&state, buffer, None, &|| next(buffer, from, offset)) }
}
