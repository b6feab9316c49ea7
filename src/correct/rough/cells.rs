//! An output cut into triangles whose corners are exact.

use crate::correct::passes::facets::FacetCorner;
use crate::correct::sources::surface_sample::{SurfaceSample, SurfaceSampler};
use glam::DVec2;

/// Number of cells along the longer side of an output.
const CELLS: u32 = 40;
/// Number of times that cells at the rim of a screen, or where the map jumps, are divided.
const HALVINGS: u32 = 3;
/// Least cosine of the angle between two corners of a triangle. Directions jump where it is less.
const LEAST_COSINE: f64 = 0.7;

/// A triangle over an output.
pub(super) type Triangle = [FacetCorner; 3];

/// Returns the triangles of an output. Cells at a rim or a jump are divided; the last ones there
/// are left out.
pub(super) fn triangles(sampler: &SurfaceSampler) -> Vec<Triangle> {
    let (width, height) = sampler.size();
    let longest = width.max(height);
    let count = |length: u32| (length * CELLS).div_ceil(longest).clamp(1, length);
    let (columns, rows) = (count(width), count(height));
    let place = |column: u32, row: u32| {
        let at = |number: u32, count: u32, length: u32| f64::from(number) / f64::from(count) * f64::from(length);
        DVec2::new(at(column, columns, width), at(row, rows, height))
    };
    let corners: Vec<_> = (0..=rows)
        .flat_map(|row| (0..=columns).map(move |column| place(column, row)))
        .map(|place| (place, sampler.at(place)))
        .collect();
    let mut triangles = Vec::with_capacity(2 * corners.len());
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let first = (row * (columns + 1) + column) as usize;
        let next = first + columns as usize + 1;
        let cell = [corners[first], corners[first + 1], corners[next + 1], corners[next]];
        fill(sampler, &cell, HALVINGS, &mut triangles);
    }
    triangles
}

/// A place, and what the output shows there.
type Corner = (DVec2, Option<SurfaceSample>);

/// Adds the triangles of a cell, whose corners are given around it.
fn fill(sampler: &SurfaceSampler, cell: &[Corner; 4], halvings: u32, triangles: &mut Vec<Triangle>) {
    let known = cell.map(|(place, sample)| {
        sample.map(|SurfaceSample { vector, weight }| FacetCorner { place, direction: vector, weight })
    });
    if let [Some(a), Some(b), Some(c), Some(d)] = known
        && [[a, b], [b, c], [c, d], [d, a], [a, c]].iter().all(are_near)
    {
        triangles.extend([[a, c, b], [a, d, c]]);
    } else if halvings > 0 && known.iter().any(Option::is_some) {
        let [a, b, c, d] = *cell;
        let between = |a: Corner, b: Corner| {
            let place = 0.5 * (a.0 + b.0);
            (place, sampler.at(place))
        };
        let (top, right, bottom, left, middle) =
            (between(a, b), between(b, c), between(c, d), between(d, a), between(a, c));
        for part in
            [[a, top, middle, left], [top, b, right, middle], [middle, right, c, bottom], [left, middle, bottom, d]]
        {
            fill(sampler, &part, halvings - 1, triangles);
        }
    }
}

/// True if the directions of two corners are so near that others lie between them.
fn are_near([a, b]: &[FacetCorner; 2]) -> bool {
    a.direction.dot(b.direction) > LEAST_COSINE * a.direction.length() * b.direction.length()
}
