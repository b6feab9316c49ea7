//! Flat drawing before the scene.

use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::correct::{LowerLeftRect, Size};
use crate::intercept::scene::frame_order::FrameOrder;
use crate::runtime::session::{ClipRows, Session};
use glam::{DMat4, DVec2, DVec3};

/// Least w of a point in a view. A point with a smaller w is outside of the view.
const LEAST_W: f64 = 1e-6;

/// Part of the panel that a viewport covers: scale and offset of clip coordinates to the right and
/// upwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanelPart {
    scale: [f64; 2],
    offset: [f64; 2],
}

impl Default for PanelPart {
    fn default() -> Self {
        Self { scale: [1.0; 2], offset: [0.0; 2] }
    }
}

impl PanelPart {
    /// Returns the part for a viewport in a picture of this size.
    pub fn of(viewport: LowerLeftRect, Size { width, height }: Size) -> Self {
        let LowerLeftRect { x, y, width: across, height: up } = viewport;
        let part = |length: i32, all: i32| f64::from(length) / f64::from(all.max(1));
        let (scale, start) = ([part(across, width), part(up, height)], [part(x, width), part(y, height)]);
        Self { scale, offset: std::array::from_fn(|i| 2.0 * start[i] + scale[i] - 1.0) }
    }

    /// Returns the reprojection for this part, from that for the whole panel.
    fn reprojection(&self, whole: &ClipRows) -> ClipRows {
        let ([across, up], [right, above]) = (self.scale, self.offset);
        let row = |[x, y, w, q]: [f64; 4]| [x * across, y * up, x * right + y * above + w, q];
        ClipRows { x: row(whole.x), y: row(whole.y), w: row(whole.w), ..*whole }
    }
}

/// Order and matrices of flat drawing that comes before the scene in a frame.
#[derive(Default)]
pub struct Background {
    pub(in crate::intercept::gl) order: FrameOrder,
    reprojections: Vec<ClipRows>,
    for_shaders: Vec<ReprojectionMatrix>,
    /// Part of the panel for which `reprojections` were computed.
    part: PanelPart,
    /// Fixed-function projection from which `per_view` was computed.
    matrix: Option<DMat4>,
    per_view: Vec<DMat4>,
}

impl Background {
    /// Notes a draw of the scene.
    pub fn note_scene(&mut self) {
        self.order.note_scene();
    }

    /// Notes a flat draw.
    pub fn note_flat(&mut self) {
        self.order.note_flat();
    }

    /// Ends the frame.
    pub fn end_frame(&mut self) {
        self.order.end_frame();
    }

    /// Forgets all matrices, as the views have changed.
    pub fn clear(&mut self) {
        self.reprojections.clear();
        self.for_shaders.clear();
        self.matrix = None;
    }

    /// Returns the reprojection matrix of a view, for the program's shaders.
    pub fn reprojection(&self, view: usize) -> Option<&ReprojectionMatrix> {
        self.for_shaders.get(view)
    }

    /// Returns the projection of a view, for the fixed-function pipeline.
    pub fn projection(&self, view: usize) -> Option<&DMat4> {
        self.per_view.get(view)
    }

    /// Returns the rectangle of the panel's part in a tile of view `view`: the smallest one around
    /// those points of the part that are in front of the eye.
    pub fn within(&self, view: usize, tile: LowerLeftRect) -> LowerLeftRect {
        let Some(reprojection) = self.reprojections.get(view) else { return tile };
        // x, y and w of clip coordinates.
        let clip = |[x, y]: [f64; 2]| {
            let rows = [reprojection.x, reprojection.y, reprojection.w];
            DVec3::from(rows.map(|[of_x, of_y, of_w, _]| of_x * x + of_y * y + of_w))
        };
        let is_ahead = |point: DVec3| point.z > LEAST_W;
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(clip);
        let (mut least, mut most) = (DVec2::ONE, DVec2::NEG_ONE);
        for (from, to) in corners.into_iter().zip(corners.into_iter().cycle().skip(1)) {
            // The corner, and the point at which the side to the next corner crosses the plane of
            // the eye.
            let crossing =
                (is_ahead(from) != is_ahead(to)).then(|| from + (LEAST_W - from.z) / (to.z - from.z) * (to - from));
            for point in [Some(from).filter(|from| is_ahead(*from)), crossing].into_iter().flatten() {
                let at = (point.truncate() / point.z).clamp(DVec2::NEG_ONE, DVec2::ONE);
                (least, most) = (least.min(at), most.max(at));
            }
        }
        let place = |at: DVec2| (0.5 + 0.5 * at) * tile.size().to_vector();
        let [x, y] = place(least).to_array().map(|at| at.floor() as i32);
        let [right, top] = place(most).to_array().map(|at| at.ceil() as i32);
        LowerLeftRect::new(tile.x + x, tile.y + y, (right - x).max(0), (top - y).max(0))
    }

    pub(in crate::intercept::gl) fn prepare(&mut self, session: &Session, projection: &DMat4, part: PanelPart) -> bool {
        if self.reprojections.is_empty() || self.part != part {
            self.part = part;
            self.reprojections = session.panel_rows();
            self.reprojections.iter_mut().for_each(|reprojection| *reprojection = part.reprojection(reprojection));
            self.for_shaders = self.reprojections.iter().map(ReprojectionMatrix::of).collect();
            self.matrix = None;
        }
        if self.matrix.as_ref() != Some(projection) {
            self.matrix = Some(*projection);
            self.per_view.clear();
            self.per_view.extend(self.reprojections.iter().map(|reprojection| reprojection.matrix() * *projection));
        }
        !self.reprojections.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::PanelPart;
    use crate::correct::{LowerLeftRect, Size};
    use crate::runtime::session::ClipRows;

    #[test]
    fn the_corners_of_a_viewport_are_those_of_its_part() {
        let row = |at: usize| std::array::from_fn(|i| if i == at { 1.0 } else { 0.0 });
        let whole = ClipRows { x: row(0), y: row(1), w: row(2), e: 0.0, curved: false, depth: [0.5, 0.0] };
        let part = PanelPart::of(LowerLeftRect::new(100, 0, 100, 50), Size::new(400, 200)).reprojection(&whole);
        let at = |row: [f64; 4], [x, y]: [f64; 2]| row[0] * x + row[1] * y + row[2];
        for (corner, expected) in [([-1.0, -1.0], [-0.5, -1.0]), ([1.0, 1.0], [0.0, -0.5])] {
            assert_eq!([at(part.x, corner), at(part.y, corner), at(part.w, corner)], [expected[0], expected[1], 1.0]);
        }
    }
}
