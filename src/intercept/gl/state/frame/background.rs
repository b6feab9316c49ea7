//! Flat drawing before the scene.

use crate::correct::LowerLeftRect;
use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::scene::frame_order::FrameOrder;
use crate::intercept::scene::viewport::parts::PanelPart;
use crate::runtime::session::{ClipRows, Session};
use glam::{DMat3, DMat4, DVec2, DVec3};

/// Least w of a point in a view. A point with a smaller w is outside of the view.
const LEAST_W: f64 = 1e-6;

/// Order and matrices of flat drawing that comes before the scene in a frame.
#[derive(Default)]
pub struct Background {
    pub(in crate::intercept::gl) order: FrameOrder,
    /// Number of flat draws behind the scene so far in this frame.
    count: u32,
    /// Room for the tiles of the views and their directions. It is used again, so that a background
    /// allocates nothing.
    tiles: Vec<(LowerLeftRect, DMat3)>,
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
        self.count = 0;
    }

    /// Forgets all matrices, as the views have changed.
    pub fn clear(&mut self) {
        self.reprojections.clear();
        self.for_shaders.clear();
        self.matrix = None;
    }

    /// Counts a flat draw behind the scene. Returns its number in this frame, from 1 on.
    pub fn count(&mut self) -> u32 {
        self.count += 1;
        self.count
    }

    /// Takes out the room for the tiles of the views and their directions, which is empty.
    pub fn take_tiles(&mut self) -> Vec<(LowerLeftRect, DMat3)> {
        let mut tiles = std::mem::take(&mut self.tiles);
        tiles.clear();
        tiles
    }

    /// Puts this room back.
    pub fn put_tiles(&mut self, tiles: Vec<(LowerLeftRect, DMat3)>) {
        self.tiles = tiles;
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
