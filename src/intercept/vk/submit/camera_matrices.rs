//! Matrices of the camera that shaders have beside those of the position: each view has its own.

use crate::correct::single;
use crate::intercept::vk::pipelines::matrix_sources::matrix;
use crate::intercept::vk::spirv::CAMERA_BYTES;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::pipelines::MatrixStage;
use crate::intercept::vk::state::recording::draw_groups::{CameraFunctions, DrawClass, DrawFacts, DrawGroup, Frame};
use crate::intercept::vk::state::views::view_constants::ConstantChunk;
use crate::runtime::session::{Direction, Intrinsics};

impl CameraFunctions {
    /// Whether a matrix leads from clip coordinates, or its inverse does.
    pub fn holds_inverse(&self, facts: &DrawFacts) -> bool {
        self.functions.iter().zip(&facts.cameras).any(|(function, camera)| {
            function.is_some_and(|(function, _)| camera.inverted || function.direction() == Direction::FromClip)
        })
    }
}

/// Looks which matrices of a group are functions of the frame's cameras; whether they, or the cameras, have changed.
pub fn look(device: &Device, group: &mut DrawGroup, frame: &Frame) -> bool {
    if group.facts.cameras.is_empty() {
        return false;
    }
    let value = |source| matrix(device, source);
    let values: Vec<_> = group.facts.cameras.iter().map(|camera| camera.source.as_ref().and_then(value)).collect();
    let now = Some((values, frame.cameras.changes()));
    if group.cameras.seen == now {
        return false;
    }
    let CameraFunctions { seen, functions } = &mut group.cameras;
    *seen = now;
    functions.clear();
    for (value, camera) in seen.iter().flat_map(|(values, _)| values).zip(&group.facts.cameras) {
        functions.push(value.and_then(|value| frame.cameras.function_of(&value, camera.inverted)));
    }
    true
}

/// Writes for each slot of a group the matrices that its shaders have in the place of the program's.
pub(in crate::intercept::vk) fn write(
    device: &Device,
    group: &DrawGroup,
    outcome: DrawClass,
    frame: &mut Frame,
    chunks: &[ConstantChunk],
) {
    let cameras = &group.facts.cameras;
    let Some(chunk) = chunks.get(group.constants.chunk).filter(|_| !cameras.is_empty()) else { return };
    let layout = &group.layout;
    let views = group.slots() as usize - 2;
    for slot in 0..group.slots() {
        let view = slot as usize;
        let turned = view < views
            && layout.views.get(view).is_some_and(|view| !view.own_lens)
            && matches!(outcome, DrawClass::Scene(_) | DrawClass::Screen);
        for (behind, stage) in [(0, MatrixStage::Fragment), (CAMERA_BYTES / 2, MatrixStage::Vertex)] {
            // Positions of the scene are re-projected: what its vertex shader hands on fits them.
            let replaced = turned && (stage == MatrixStage::Fragment || outcome == DrawClass::Screen);
            let mut of_view = |lens: &Intrinsics| {
                let index = frame.cameras.index(lens, &layout.session);
                let rows = frame.cameras.get(index)?.rows.get(view)?;
                Some(if group.facts.y_up { rows.matrix() } else { rows.y_down().matrix() })
            };
            let values = group.cameras.seen.iter().flat_map(|(values, _)| values);
            let all = values.zip(&group.cameras.functions).zip(cameras);
            let of_stage = all.filter(|(_, camera)| camera.stage == stage);
            let matrices: Vec<_> = of_stage
                .map(|((value, function), _)| {
                    let (function, lens) = function.filter(|_| replaced)?;
                    let made = function.for_view(&(*value)?, &of_view(&lens)?)?;
                    Some(single::values(made))
                })
                .collect();
            let place = group.constants.slot(slot) + device.view_constants.cameras_offset() + behind;
            chunk.write_cameras(place, &matrices);
        }
    }
}
