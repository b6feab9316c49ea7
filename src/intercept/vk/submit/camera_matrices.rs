//! Camera matrices of shaders beside those of the position. Each view has its own.

use crate::correct::single;
use crate::intercept::scene::eye::Eye;
use crate::intercept::vk::pipelines::matrix_sources::matrix;
use crate::intercept::vk::spirv::CAMERA_BYTES;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::pipelines::MatrixStage;
use crate::intercept::vk::state::recording::draw_groups::{
    CameraFunctions, CameraSource, DrawClass, DrawFacts, DrawGroup, Frame,
};
use crate::intercept::vk::state::views::view_constants::ConstantChunk;
use crate::runtime::session::{Direction, Intrinsics};
use glam::DMat4;

impl CameraFunctions {
    /// True if a matrix, or its inverse in the shader, leads from clip coordinates.
    pub fn holds_inverse(&self, facts: &DrawFacts) -> bool {
        self.functions.iter().zip(&facts.cameras).any(|(function, camera)| {
            function.is_some_and(|(function, _)| camera.inverted || function.direction() == Direction::FromClip)
        })
    }
}

/// Finds the matrices of a group that are functions of the frame's cameras. Returns whether the
/// matrices or the cameras have changed.
pub fn look(device: &Device, group: &mut DrawGroup, frame: &Frame) -> bool {
    if group.facts.cameras.is_empty() {
        return false;
    }
    let value = |source| matrix(device, source);
    let values: Vec<_> = group.facts.cameras.iter().map(|camera| camera.source.as_ref().and_then(value)).collect();
    let now = (values, frame.cameras.changes());
    if group.cameras.seen.as_ref() == Some(&now) {
        return false;
    }
    let CameraFunctions { seen, functions, eye } = &mut group.cameras;
    let values = &seen.insert(now).0;
    let cameras = &group.facts.cameras;
    let function = |(value, camera): (&Option<DMat4>, &CameraSource)| {
        value.and_then(|value| frame.cameras.function_of(&value, camera.inverted))
    };
    *functions = values.iter().zip(cameras).map(function).collect();
    *eye = Eye::of(values, functions, |index| cameras[index].called);
    true
}

/// Writes, for each slot of a group, the matrices that replace the program's in its shaders.
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
            // Positions of the scene are reprojected later, so the outputs of its vertex shader
            // have to fit the program's own matrices.
            let replaced = turned && (stage == MatrixStage::Fragment || outcome == DrawClass::Screen);
            let mut of_view = |lens: &Intrinsics| {
                let index = frame.cameras.index(lens, &layout.session);
                let reprojection = frame.cameras.get(index)?.reprojections.get(view)?;
                Some(if group.facts.y_up { reprojection.matrix() } else { reprojection.y_down().matrix() })
            };
            let CameraFunctions { seen, functions, eye } = &group.cameras;
            let Some((values, _)) = seen else { return };
            // Images of the scene hold positions relative to the program's own eye.
            let eye = eye.as_ref().filter(|_| outcome == DrawClass::Screen && group.facts.sky && !group.facts.screen);
            let eye = eye.and_then(|eye| {
                let (function, lens) = functions[eye.projection]?;
                Some((eye, function.turn(&values[eye.projection]?, &of_view(&lens)?)?))
            });
            let numbers = (0..cameras.len()).filter(|index| cameras[*index].stage == stage);
            let matrices: Vec<_> = numbers
                .map(|index| {
                    let value = values[index].filter(|_| replaced)?;
                    let made = match (functions[index], &eye) {
                        (Some((function, lens)), Some((_, turn))) if function.is_of_projection(&value, &lens) => {
                            function.for_turned_view(&value, &of_view(&lens)?, *turn)?
                        }
                        (Some((function, lens)), _) => function.for_view(&value, &of_view(&lens)?)?,
                        (None, Some((eye, turn))) => eye.views[index]?.turned(&value, eye.transposed, *turn),
                        (None, None) => return None,
                    };
                    Some(single::matrix4(&made))
                })
                .collect();
            let place = group.constants.slot(slot) + device.view_constants.cameras_offset() + behind;
            chunk.write_cameras(place, &matrices);
        }
    }
}
