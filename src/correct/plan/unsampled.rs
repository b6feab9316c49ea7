//! Parts of views that no pixel samples.
//!
//! A view is a rectangle, but outputs sample only a part of it. The corners beyond a dome's rim,
//! and parts that an earlier view serves, are drawn in vain. A program that adapts itself can leave
//! them out.

#[cfg(test)]
mod tests;

use crate::correct::passes::output_pass::{OutputPass, Plan};
use crate::correct::plan::rectangles::{self, BLOCK};
use crate::geom::Frustum;
use crate::geom::rectangle::PixelSpan;
use crate::views::sampling::cone::{Cone, Relation, WIDEST, diameter};
use crate::views::{Tile, View};
use glam::{DVec2, DVec3};

/// Side of a sheet's cell, texels.
const CELL: u32 = 2;

/// Blocks of pixels that no border crosses are examined as a whole; others are divided down to this
/// size in pixels.
const FINEST: u32 = 1;

/// Directions nearer than this (radians) to the side of a view may count as on either side in
/// 32-bit arithmetic.
const ROUNDING: f64 = 1e-5;

/// Returns, for each view, the rectangles of its tile that no pixel of this machine's outputs
/// reads, filters included. They are disjoint, in texels of the atlas, and consist of cells of 2
/// texels. The result is conservative: uncertain cells count as sampled. Views with the program's
/// own lens, and views with projected vertices, have none.
pub fn unsampled_areas(plan: &Plan) -> Vec<Vec<Tile>> {
    let mut sheets: Vec<Sheet> = plan.views.views.iter().map(|view| Sheet::new(view, plan.views.guard)).collect();
    let here = plan.passes.iter().zip(&plan.views.output_views).filter(|(pass, _)| pass.here);
    for (pass, views) in here {
        let cones = views.iter().map(|&view| (view, Cone::of(&plan.views.views[view]))).collect();
        Marker { pass, cones, sheets: &mut sheets }.mark_all();
    }
    sheets.iter().zip(&plan.views.views).map(|(sheet, view)| sheet.unsampled(view)).collect()
}

/// Cells of a view's tile, and which of them are sampled.
struct Sheet {
    columns: u32,
    rows: u32,
    sampled: Vec<bool>,
    frustum: Frustum,
    /// Size of the tile, texels.
    size: DVec2,
    /// Greatest distance of a texel that a pixel reads from the pixel's place, in texels.
    guard: f64,
}

impl Sheet {
    fn new(view: &View, guard: u32) -> Self {
        let Tile { width, height, .. } = view.tile;
        let (columns, rows) = (width.div_ceil(CELL), height.div_ceil(CELL));
        Self {
            columns,
            rows,
            sampled: vec![view.program_lens || view.curved.is_some(); (columns * rows) as usize],
            frustum: view.frustum,
            size: DVec2::new(f64::from(width), f64::from(height)),
            // Filters and the overlap of views reach less far than the guard, which is counted in
            // whole texels.
            guard: f64::from(guard),
        }
    }

    /// Marks the cells that a patch touches, given its corners in the view's axes and how far it
    /// departs from their quadrilateral (radians).
    fn mark(&mut self, corners: &[DVec3], departure: f64) {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in corners {
            // A patch that reaches behind the view, or nearly so, may be anywhere in it.
            if -corner.z < departure.max(1e-3) {
                (low, high) = (DVec2::NEG_INFINITY, DVec2::INFINITY);
                break;
            }
            let at = corner.truncate() / -corner.z;
            // The tangent grows by less than this over the departure, since it lies within the
            // patch's own size.
            let slack = 2.0 * departure * (1.0 + at.length_squared());
            (low, high) = (low.min(at - slack), high.max(at + slack));
        }
        let corner = DVec2::new(self.frustum.left, self.frustum.bottom);
        let scale = self.size / DVec2::new(self.frustum.width(), self.frustum.height());
        let cell = |at: f64, cells: u32| (at / f64::from(CELL)).floor().clamp(-1.0, f64::from(cells)) as i64;
        let (low, high) = ((low - corner) * scale - self.guard, (high - corner) * scale + self.guard);
        let (left, right) = (cell(low.x, self.columns), cell(high.x, self.columns));
        let (bottom, top) = (cell(low.y, self.rows), cell(high.y, self.rows));
        for row in bottom.max(0)..=top.min(i64::from(self.rows) - 1) {
            let start = row as usize * self.columns as usize;
            for column in left.max(0)..=right.min(i64::from(self.columns) - 1) {
                self.sampled[start + column as usize] = true;
            }
        }
    }

    /// Returns the cells that are not marked, as rectangles of the atlas.
    fn unsampled(&self, view: &View) -> Vec<Tile> {
        let classes: Vec<Option<usize>> = self.sampled.iter().map(|sampled| (!sampled).then_some(0)).collect();
        let merged = rectangles::merge(&classes, CELL, (view.tile.width, view.tile.height), 1);
        merged
            .into_iter()
            .flatten()
            .map(|rect| Tile {
                x: view.tile.x + rect.x,
                y: view.tile.y + rect.y,
                width: rect.width,
                height: rect.height,
            })
            .collect()
    }
}

/// Marks the cells that one output samples.
struct Marker<'a> {
    pass: &'a OutputPass,
    /// The views of the output, in order of precedence.
    cones: Vec<(usize, Cone)>,
    sheets: &'a mut [Sheet],
}

impl Marker<'_> {
    fn mark_all(&mut self) {
        for rect in self.pass.batches.iter().flat_map(|batch| &batch.rects) {
            for top in (rect.y..rect.y + rect.height).step_by(BLOCK as usize) {
                for left in (rect.x..rect.x + rect.width).step_by(BLOCK as usize) {
                    let (right, bottom) =
                        ((left + BLOCK).min(rect.x + rect.width), (top + BLOCK).min(rect.y + rect.height));
                    self.mark_block(PixelSpan::new(left, top, right, bottom));
                }
            }
        }
    }

    /// Returns the direction at a pixel position, unit length, if something is shown there.
    fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let source = &self.pass.source;
        let (x, y) = source.normalised(self.pass.size, x, y);
        source.direction(x, y).and_then(DVec3::try_normalize)
    }

    /// Returns the directions at the corners of a block, widened by this number of pixels, if all
    /// show something.
    fn corners(&self, block: PixelSpan, wider: f64) -> Option<[DVec3; 4]> {
        let [x0, y0, x1, y1] = block.edges();
        let (x0, y0, x1, y1) = (x0 - wider, y0 - wider, x1 + wider, y1 + wider);
        let corner = |x: f64, y: f64| self.direction(x, y);
        Some([corner(x0, y0)?, corner(x1, y0)?, corner(x0, y1)?, corner(x1, y1)?])
    }

    /// True if a block lies well inside one view: at least `distance` radians from the sides of all
    /// views, and not next to pixels that show nothing. A rectangle around its texels then contains
    /// no unsampled ones.
    fn is_amid(&self, block: PixelSpan, corners: &[DVec3; 4], distance: f64) -> bool {
        let distance = distance.max(ROUNDING);
        let relation =
            self.cones.iter().map(|(_, cone)| cone.relation(corners, distance)).find(|r| *r != Relation::Outside);
        relation.is_none_or(|relation| relation == Relation::Inside) && self.corners(block, f64::from(BLOCK)).is_some()
    }

    fn mark_block(&mut self, block: PixelSpan) {
        let PixelSpan { left, top, right, bottom } = block;
        let smallest = right - left <= FINEST && bottom - top <= FINEST;
        if let Some(corners) = self.corners(block, 0.0) {
            let size = diameter(&corners);
            if size < WIDEST && (smallest || self.is_amid(block, &corners, size + size * size)) {
                self.mark_patch(&corners, size * size);
                return;
            }
        }
        if !smallest {
            let (middle_x, middle_y) = (left + (right - left).div_ceil(2), top + (bottom - top).div_ceil(2));
            for (top, bottom) in [(top, middle_y), (middle_y, bottom)].into_iter().filter(|rows| rows.0 < rows.1) {
                for (left, right) in [(left, middle_x), (middle_x, right)].into_iter().filter(|part| part.0 < part.1) {
                    self.mark_block(PixelSpan::new(left, top, right, bottom));
                }
            }
            return;
        }
        for (y, x) in (top..bottom).flat_map(|y| (left..right).map(move |x| (y, x))) {
            let (x, y) = (f64::from(x), f64::from(y));
            // The corners count as well as the centre: a picture that is scaled when it is
            // presented samples between centres.
            for (x, y) in [(0.5, 0.5), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(u, v)| (x + u, y + v)) {
                if let Some(direction) = self.direction(x, y) {
                    self.mark_patch(&[direction; 4], ROUNDING);
                }
            }
        }
    }

    /// Marks a patch of directions in every view that may serve a part of it.
    fn mark_patch(&mut self, corners: &[DVec3; 4], departure: f64) {
        for (view, cone) in &self.cones {
            let relation = cone.relation(corners, departure.max(ROUNDING));
            if relation == Relation::Outside {
                continue;
            }
            self.sheets[*view].mark(&cone.localized(corners), departure);
            if relation == Relation::Inside {
                break;
            }
        }
    }
}
