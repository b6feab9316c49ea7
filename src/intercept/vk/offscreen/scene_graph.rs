//! Choice of the images that hold a scene on its way to the window.
//!
//! While commands are recorded, the images that each command draws to and samples are noted.
//! Between two frames, images are chosen that perspective draws reach and that lead to the window.
//! An image leads to the window by a flat draw of a few vertices that samples it and covers the
//! whole target, or by a copy of the whole image.

use crate::intercept::process::settings;
use crate::intercept::scene::lens::{self, Candidate};
use crate::intercept::vk::offscreen::images::READ_TOGETHER;
use crate::intercept::vk::pipelines::matrix_sources::{matrix, source};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::images::scene_graph::Made;
use crate::intercept::vk::state::recording::Recording;
use crate::intercept::vk::state::recording::draw_groups::MatrixSource;
use ash::vk;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ends a frame: images that were found to hold a scene on its way to the window are drawn for each
/// view from now on.
pub fn decide(device: &Device) {
    device.images.sweep(device);
    let Some(settings) = settings::settings() else { return };
    let Some(chosen) = device.scene_graph.news(settings.rig.views.duplicate) else { return };
    if !device.draws_views() {
        return;
    }
    let Some(layout) = device.swapchains.latest_layout() else { return };
    let (computed, measured) = device.scene_graph.is_computed(&chosen);
    let copied = !chosen.is_empty() && device.scene_graph.is_copied();
    // The border of a part lies between texels of views that have another size.
    let even = computed || copied || device.scene_graph.is_partial(&chosen);
    let own_read = computed && measured || copied;
    let images = &device.images;
    let is_new = |known: &AtomicBool, now: bool| now && !known.swap(true, Ordering::Relaxed);
    if is_new(&images.even, even) | is_new(&images.own_read, own_read)
        && let Err(why) = images.follow(device, &layout)
    {
        return device.show_flat(why);
    }
    if computed && measured && chosen.iter().any(|image| images.lacks_own_picture(*image)) {
        return device.show_flat("compute shaders measure its picture in an image that cannot be copied to");
    }
    for image in &chosen {
        if let Err(why) = device.images.duplicate(device, *image, &layout) {
            return device.show_flat(why);
        }
    }
    if device.images.duplicated().any(|image| device.scene_graph.is_lost(image)) {
        device.show_flat("a picture of its scene is used in a new way");
    }
    if device.scene_graph.lost().into_iter().any(|image| device.images.is_read_and_drawn_together(image)) {
        device.show_flat(READ_TOGETHER);
    }
}

/// Area that a draw covers.
#[derive(Clone, Copy, Debug)]
pub struct Cover {
    /// True if its viewport shows the main picture of its target.
    pub main_picture: bool,
    /// True if it has so few vertices that it may be one triangle or square over its viewport.
    pub few_vertices: bool,
    /// True if it has matrices that may belong to a camera.
    pub has_matrices: bool,
    /// True if its fragments read the coordinates of the program's window.
    pub told_place: bool,
}

impl Cover {
    /// True if the result that the draw makes from an image covers all of the picture. `mapped`:
    /// unless the image is read at the fragment's position, it is a texture in the scene, such as
    /// the depths of a shadow map.
    fn follows(&self, mapped: bool) -> bool {
        self.main_picture && (self.few_vertices || self.has_matrices && (self.told_place || !mapped))
    }

    /// Returns the result of a draw that shows `image`, if that matters: `made`, or a result that
    /// cannot be followed. Images whose size is not the window's, and that are not read at the
    /// fragment's position, are mirrors.
    pub fn made(&self, device: &Device, image: vk::Image, made: Made) -> Option<Made> {
        let depths = device.images.is_depth(image);
        let mapped = depths || !device.images.has_size_of_window(image);
        let mirror = self.follows(false) && !depths;
        match self.follows(mapped) {
            true => Some(made),
            false => (!mirror).then_some(Made::Elsewhere),
        }
    }
}

/// Notes the images that a draw reads and writes in a pass that is not drawn for each view. Its
/// matrices are examined when the commands run.
pub fn note_draw(
    device: &Device,
    recording: &mut Recording,
    matrices: &[crate::intercept::vk::spirv::Matrix],
    first_instance: u32,
    cover: Cover,
) {
    let Some(targets) = recording.plain.clone() else { return };
    note_stored(device, recording);
    for picture in pictures(device, recording) {
        if targets.is_empty() {
            device.scene_graph.note_made(picture, Made::Elsewhere);
        }
        let made = targets.iter().filter_map(|target| cover.made(device, picture, Made::Image(*target)));
        made.for_each(|made| device.scene_graph.note_made(picture, made));
    }
    let targets: Vec<_> = targets.into_iter().filter(|target| device.images.is_large(*target)).collect();
    if !cover.main_picture || targets.is_empty() {
        return;
    }
    let of_draw = |matrix| source(device, recording, matrix, first_instance);
    let sources: Vec<MatrixSource> = matrices.iter().filter_map(of_draw).collect();
    recording.suspect(targets, sources);
}

/// Notes the images that may hold a scene and that shaders of the next draw can write.
pub fn note_stored(device: &Device, recording: &Recording) {
    for view in views_by(device, recording, |set| device.descriptors.stored(set)) {
        if device.images.target(view).is_some_and(|target| target.window) {
            device.show_flat(READ_TOGETHER);
        }
        let scene = device.images.candidate_of(view);
        scene.into_iter().for_each(|image| device.scene_graph.note_made(image, Made::Elsewhere));
    }
}

/// Returns the images that may hold a scene and that shaders of the next draw can sample.
pub fn pictures(device: &Device, recording: &Recording) -> Vec<vk::Image> {
    let views = views_by(device, recording, |set| device.descriptors.pictures(set));
    views.into_iter().filter_map(|view| device.images.candidate_of(view)).collect()
}

pub(super) fn views_by(
    device: &Device,
    recording: &Recording,
    of: impl Fn(vk::DescriptorSet) -> Vec<vk::ImageView>,
) -> Vec<vk::ImageView> {
    if !device.images.has_candidates() {
        return Vec::new();
    }
    let sets = recording
        .graphics
        .pipeline
        .as_ref()
        .and_then(|pipeline| pipeline.layout.as_ref())
        .map_or(0, |layout| layout.ours);
    let bound = recording.graphics.bound.iter().take(sets as usize).flatten();
    bound.flat_map(|bound| of(bound.set)).collect()
}

/// Notes that draws with these matrices ran in passes to these images.
pub fn ran(device: &Device, targets: &[vk::Image], sources: &[MatrixSource]) {
    let matrices: Vec<_> =
        sources.iter().filter_map(|source| matrix(device, source).map(|m| (source.matrix.rank, m))).collect();
    if lens::find(matrices.iter().map(|(rank, value)| Candidate::either(*rank, value))).is_none() {
        return;
    }
    for target in targets {
        device.scene_graph.note_scene(*target);
    }
    computed(device, targets);
}

/// Notes that the program's own images were drawn to, or written by compute shaders. The views do
/// not have this content.
pub fn computed(device: &Device, images: &[vk::Image]) {
    let missed = |image: &vk::Image| device.images.target_of_image(*image).is_some_and(|target| target.was_missed());
    if images.iter().filter(|image| missed(image)).count() > 0 {
        device.show_flat("the commands that draw its scene were recorded before it was found in the window");
    }
}
