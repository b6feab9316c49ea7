//! Rectangles cut into triangles until these are exact enough.
//!
//! All sides are rows or columns of pixels. So a corner in the middle of a neighbour's side lies
//! exactly on it, rounded or not, and no gap opens between triangles of different size.

use crate::correct::passes::facets::Facets;
use crate::correct::sources::facets::WEIGHT_ERROR;
use crate::correct::sources::surface_sample::{SurfaceSample, SurfaceSampler};
use crate::geom::rectangle::PixelRect;
use glam::DVec2;
use std::collections::HashMap;

/// Part of the allowed error that may be measured at a few places, so that the error everywhere
/// stays within the bound.
const MEASURED: f64 = 0.8;

impl Facets {
    /// Returns the triangles for rectangles of an output in which all pixels' centres show
    /// something. They are as large as `max_error`, in pixels, allows. The error is measured in the
    /// middle of each triangle, of its sides, and between. Where the map is discontinuous,
    /// triangles are as small as pixels, and exact at the pixels' centres.
    pub(in crate::correct) fn within(sampler: &SurfaceSampler, rects: &[PixelRect], max_error: f64) -> Self {
        Builder::new(sampler, max_error).build(rects)
    }
}

/// Makes the triangles of one output.
struct Builder<'a> {
    sampler: &'a SurfaceSampler<'a>,
    max_error: f64,
    facets: Facets,
    /// Shared corners, by whole pixel positions.
    numbers: HashMap<(u32, u32), u32>,
    /// Samples at whole pixel positions and half-way between.
    seen: HashMap<(u32, u32), Option<SurfaceSample>>,
}

/// Four corners of a rectangle, from the top left clockwise.
type Corners = [SurfaceSample; 4];

/// Diagonal that cuts a rectangle, and its error.
#[derive(Clone, Copy)]
struct Cut {
    /// True: from the top left to the bottom right; false: the other diagonal.
    falling: bool,
    error: f64,
    fits: bool,
}

impl<'a> Builder<'a> {
    fn new(sampler: &'a SurfaceSampler<'a>, max_error: f64) -> Self {
        let facets = Facets { fills: true, ..Facets::default() };
        Self { sampler, max_error, facets, numbers: HashMap::new(), seen: HashMap::new() }
    }

    fn build(mut self, rects: &[PixelRect]) -> Facets {
        for rect in rects {
            self.fill(*rect);
        }
        self.facets
    }

    /// Returns the sample at a place in half pixels.
    fn see(&mut self, x: u32, y: u32) -> Option<SurfaceSample> {
        let sampler = self.sampler;
        *self.seen.entry((x, y)).or_insert_with(|| sampler.at(0.5 * DVec2::new(f64::from(x), f64::from(y))))
    }

    fn fill(&mut self, rect: PixelRect) {
        let PixelRect { x, y, width, height } = rect;
        let cut = self.corners(rect).map(|corners| (corners, self.cut(rect, &corners)));
        match cut {
            Some((corners, cut)) if cut.fits => self.emit(rect, &corners, cut),
            _ if width == 1 && height == 1 => self.emit_pixel(rect),
            _ => {
                // The cut is across the longer side, or across both if they have about the same
                // length.
                let columns = if 2 * width > height && width > 1 {
                    vec![(x, width / 2), (x + width / 2, width - width / 2)]
                } else {
                    vec![(x, width)]
                };
                let rows = if 2 * height > width && height > 1 {
                    vec![(y, height / 2), (y + height / 2, height - height / 2)]
                } else {
                    vec![(y, height)]
                };
                for (y, height) in rows {
                    for &(x, width) in &columns {
                        self.fill(PixelRect { x, y, width, height });
                    }
                }
            }
        }
    }

    /// Returns the samples at the corners, if all show something.
    fn corners(&mut self, rect: PixelRect) -> Option<Corners> {
        let (left, top) = (2 * rect.x, 2 * rect.y);
        let (right, bottom) = (left + 2 * rect.width, top + 2 * rect.height);
        Some([self.see(left, top)?, self.see(right, top)?, self.see(right, bottom)?, self.see(left, bottom)?])
    }

    /// Returns the better diagonal, and its error.
    fn cut(&mut self, rect: PixelRect, corners: &Corners) -> Cut {
        let middle = self.see(2 * rect.x + rect.width, 2 * rect.y + rect.height);
        let departs = |a: SurfaceSample, b: SurfaceSample| {
            let mean = (a.vector + b.vector).normalize_or_zero();
            middle.map_or(0.0, |middle| mean.distance(middle.vector.normalize_or_zero()))
        };
        let falling = departs(corners[0], corners[2]) <= departs(corners[1], corners[3]);
        let mut cut = Cut { falling, error: 0.0, fits: true };
        // The middles of the sides, of the diagonal and of the triangles' halves.
        for (across, down) in [(2, 2), (2, 0), (0, 2), (4, 2), (2, 4), (1, 1), (3, 1), (1, 3), (3, 3)] {
            let place = DVec2::new(
                f64::from(rect.x) + 0.25 * f64::from(across * rect.width),
                f64::from(rect.y) + 0.25 * f64::from(down * rect.height),
            );
            let even = (across * rect.width).is_multiple_of(2) && (down * rect.height).is_multiple_of(2);
            let exact = match even {
                true => self.see(2 * rect.x + across * rect.width / 2, 2 * rect.y + down * rect.height / 2),
                false => self.sampler.at(place),
            };
            let found = interpolated(corners, falling, 0.25 * f64::from(across), 0.25 * f64::from(down));
            let error = exact.and_then(|exact| {
                let error = self.sampler.error(place, found.vector)?;
                let same_light = (exact.weight - found.weight).abs() <= MEASURED * WEIGHT_ERROR;
                same_light.then_some(error)
            });
            match error {
                Some(error) if error <= MEASURED * self.max_error => cut.error = cut.error.max(error),
                _ => return Cut { fits: false, ..cut },
            }
        }
        cut
    }

    fn emit(&mut self, rect: PixelRect, corners: &Corners, cut: Cut) {
        let (right, bottom) = (rect.x + rect.width, rect.y + rect.height);
        let places = [(rect.x, rect.y), (right, rect.y), (right, bottom), (rect.x, bottom)];
        let mut numbers = [0; 4];
        for ((number, place), corner) in numbers.iter_mut().zip(places).zip(corners) {
            let facets = &mut self.facets;
            *number = *self
                .numbers
                .entry(place)
                .or_insert_with(|| facets.push(DVec2::new(f64::from(place.0), f64::from(place.1)), *corner));
        }
        let [a, b, c, d] = numbers;
        self.facets.triangles.extend(if cut.falling { [[a, c, b], [a, d, c]] } else { [[a, d, b], [b, d, c]] });
        self.facets.error = self.facets.error.max(cut.error);
    }

    /// Adds a pixel that shows the sample of its centre everywhere: the last resort where the map
    /// jumps.
    fn emit_pixel(&mut self, rect: PixelRect) {
        let Some(sample) = self.see(2 * rect.x + 1, 2 * rect.y + 1) else { return };
        let (x, y) = (f64::from(rect.x), f64::from(rect.y));
        let [a, b, c, d] = [(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)]
            .map(|(x, y)| self.facets.push(DVec2::new(x, y), sample));
        self.facets.triangles.extend([[a, c, b], [a, d, c]]);
    }
}

/// Returns the sample that the triangles of a rectangle show at a place, in parts of its width and
/// height from the top left.
fn interpolated(corners: &Corners, falling: bool, x: f64, y: f64) -> SurfaceSample {
    let [a, b, c, d] = corners;
    let parts = match falling {
        // Above the diagonal from a to c, and below.
        true if x >= y => [1.0 - x, x - y, y, 0.0],
        true => [1.0 - y, 0.0, x, y - x],
        // Above the diagonal from b to d, and below.
        false if x + y <= 1.0 => [1.0 - x - y, x, 0.0, y],
        false => [0.0, 1.0 - y, x + y - 1.0, 1.0 - x],
    };
    let sum = |of: &dyn Fn(&SurfaceSample) -> f64| {
        parts.iter().zip([a, b, c, d]).map(|(part, corner)| part * of(corner)).sum()
    };
    let vector = parts.iter().zip([a, b, c, d]).map(|(part, corner)| corner.vector * *part).sum();
    SurfaceSample { vector, weight: sum(&|corner| corner.weight) }
}
