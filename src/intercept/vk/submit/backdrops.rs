//! Backgrounds: the places of the program's picture that each view shows.

use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::correct::single;
use crate::intercept::vk::spirv::BACKDROP_VECTORS;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::recording::draw_groups::{DrawClass, DrawFacts, DrawGroup, Frame};
use crate::intercept::vk::state::views::atlas_layout::AtlasRect;
use crate::intercept::vk::state::views::view_constants::ConstantChunk;
use crate::runtime::session::{ClipRows, Intrinsics};
use glam::{DMat3, DVec2, DVec3};

impl Frame {
    /// Returns the lens of a background's picture, if its shader can fill views: the first one that
    /// the views are drawn with.
    pub(in crate::intercept::vk) fn backdrop_lens(&self, facts: &DrawFacts) -> Option<Intrinsics> {
        self.cameras.shown().next().copied().filter(|_| facts.backdrop)
    }
}

/// Writes, for each slot of a group, the places of a background. In other slots, fragments keep their
/// inputs.
pub(in crate::intercept::vk) fn write(
    device: &Device,
    group: &DrawGroup,
    outcome: DrawClass,
    frame: &mut Frame,
    chunks: &[ConstantChunk],
) {
    let Some(chunk) = chunks.get(group.constants.chunk).filter(|_| group.facts.backdrop) else { return };
    let views = if group.facts.in_views { &group.layout.views[..] } else { &[] };
    let lens = if let DrawClass::Backdrop(lens) = outcome { Some(lens) } else { None };
    let camera = lens.map(|lens| frame.cameras.index(&lens, &group.layout.session));
    let camera = camera.and_then(|index| frame.cameras.get(index));
    for slot in 0..group.slots() {
        let view = views.get(slot as usize).filter(|view| !view.own_lens);
        let made = view.zip(camera).and_then(|(view, camera)| {
            vectors(view.rect, &camera.intrinsics, camera.reprojections.get(slot as usize)?, group.facts.y_up)
        });
        let place = group.constants.slot(slot) + device.view_constants.backdrop_offset();
        chunk.write_backdrop(place, &made.unwrap_or_default());
    }
}

/// Returns what a background's shader reads for a view whose tile is `rect`; `None` if the matrix has
/// no inverse.
fn vectors(
    rect: AtlasRect,
    lens: &Intrinsics,
    reprojection: &ReprojectionMatrix,
    y_up: bool,
) -> Option<[[f32; 4]; BACKDROP_VECTORS]> {
    // Both clip coordinates have y down, unless the program mirrors its viewport.
    let matrix = if y_up { *reprojection } else { reprojection.y_down() };
    let [x, y, w] = [matrix.x, matrix.y, matrix.w].map(|row| row.map(f64::from));
    let rows = ClipRows { x, y, w, e: 0.0, curved: false, depth: [1.0, 0.0] };
    let half = 0.5 * DVec2::new(rect.width.into(), rect.height.into());
    let centre = half + DVec2::new(rect.x.into(), rect.y.into());
    let half = half * DVec2::new(1.0, if y_up { -1.0 } else { 1.0 });
    let to_tile = DMat3::from_cols(DVec3::X / half.x, DVec3::Y / half.y, (-centre / half).extend(1.0));
    let directions = rows.directions(lens) * to_tile;
    let &Intrinsics { a, b, c, d, .. } = lens;
    let side = ((b - 1.0) / a).abs().max(((b + 1.0) / a).abs());
    let column = |column: DVec3| column.extend(0.0).to_array();
    let vectors = [
        column(directions.x_axis),
        column(directions.y_axis),
        column(directions.z_axis),
        [a, b, c, d],
        [half.x, half.y, centre.x, centre.y],
        [1.0 / side.hypot(1.0), 1.0, 0.0, 0.0],
    ];
    directions.is_finite().then(|| vectors.map(single::values))
}
