//! Shader stages of a pipeline, changed for views in parts beside the position: positions on the
//! screen, texels of images of the scene, camera matrices.

use crate::intercept::process::log;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::spirv::{self, DescriptorPlace};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::pipelines::stages::{name_of, words_of};
use crate::intercept::vk::state::pipelines::{CameraMatrix, MatrixStage};
use ::spirv::ExecutionModel;
use ash::vk;
use std::sync::Arc;

/// A stage that was changed, and the view constants that its words read.
pub struct ViewStage {
    /// Its words; `None`: the program's own.
    pub words: Option<Vec<u32>>,
    /// True if its fragments get the coordinates of the program's window.
    pub moves_place: bool,
    /// True if its fragments need these coordinates, but cannot get them.
    pub loses_place: bool,
    /// Descriptors of the images that it reads by texel coordinates.
    pub pictures: Vec<DescriptorPlace>,
    /// Its matrices that may be functions of the camera.
    pub cameras: Vec<CameraMatrix>,
    /// True if its inputs can be those of another place: for backgrounds.
    pub backdrop: bool,
}

/// Returns a fragment stage for views, which reads the view constants through set `ours`.
/// `may_fill`: it may be that of a background.
///
/// # Safety
/// `stage` must be the program's.
pub unsafe fn fragment(
    device: &Device,
    stage: &vk::PipelineShaderStageCreateInfo<'_>,
    ours: u32,
    may_fill: bool,
) -> ViewStage {
    let mut made = ViewStage {
        words: None,
        moves_place: false,
        loses_place: false,
        pictures: Vec::new(),
        cameras: Vec::new(),
        backdrop: false,
    };
    // SAFETY: as promised.
    let (words, entry) = unsafe { (words_of(device, stage), name_of(stage)) };
    let Some(words) = words else { return made };
    let offset = device.view_constants.to_window_offset();
    let mut lost = |what: &str, why: &Obstacle| {
        made.loses_place = true;
        if let Some(reason) = why.reason() {
            log::once(&format!("Vulkan: {what}: {reason}"));
        }
    };
    let moved = match spirv::asks_place(&words) {
        true => spirv::frag_coord(&words, &entry, ours, offset),
        false => Ok(None),
    };
    let moved = moved.inspect_err(|why| lost("FragCoord is the position in a view, not in the window", why));
    let moved = moved.ok().flatten();
    let followed = spirv::texels(moved.as_deref().unwrap_or(&words), &entry, ours, offset);
    let followed = followed.inspect_err(|why| lost("texel coordinates of a scene are those of a view's image", why));
    made.moves_place = moved.is_some();
    made.words = moved;
    if let Ok(Some(followed)) = followed {
        made.moves_place = true;
        made.pictures = followed.pictures;
        made.words = Some(followed.words);
    }
    let before: Arc<[u32]> = made.words.as_deref().map_or(words, Arc::from);
    if let Some((words, cameras)) = with_cameras(device, &before, &entry, MatrixStage::Fragment, ours) {
        made.words = Some(words);
        made.cameras = cameras;
    } else if may_fill && made.pictures.is_empty() {
        let filled = spirv::backdrop(&before, &entry, ours, device.view_constants.backdrop_offset());
        made.backdrop = filled.is_ok();
        made.words = filled.ok().or(made.words);
    }
    made
}

/// Returns the words of a vertex stage with the matrices of views, and these matrices.
///
/// # Safety
/// `stage` must be the program's.
pub unsafe fn vertex(
    device: &Device,
    stage: &vk::PipelineShaderStageCreateInfo<'_>,
    ours: u32,
) -> Option<(Vec<u32>, Vec<CameraMatrix>)> {
    // SAFETY: as promised.
    let (words, entry) = unsafe { (words_of(device, stage)?, name_of(stage)) };
    with_cameras(device, &words, &entry, MatrixStage::Vertex, ours)
}

fn with_cameras(
    device: &Device,
    words: &[u32],
    entry: &str,
    stage: MatrixStage,
    ours: u32,
) -> Option<(Vec<u32>, Vec<CameraMatrix>)> {
    let (model, behind) = match stage {
        MatrixStage::Fragment => (ExecutionModel::Fragment, 0),
        MatrixStage::Vertex => (ExecutionModel::Vertex, spirv::CAMERA_BYTES / 2),
    };
    let offset = device.view_constants.cameras_offset() + behind;
    match spirv::camera_matrices(words, model, entry, ours, offset) {
        Ok(Some(chosen)) => {
            let camera = |(matrix, called)| CameraMatrix { matrix, called, stage, inverted: chosen.inverts };
            Some((chosen.words, chosen.matrices.into_iter().map(camera).collect()))
        }
        Ok(None) => None,
        Err(why) => {
            if let Some(reason) = why.reason() {
                log::once(&format!("Vulkan: a shader keeps the matrices of the program in all views: {reason}"));
            }
            None
        }
    }
}
