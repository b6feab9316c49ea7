//! Screens of triangles, which may hide parts of themselves.
//!
//! A tree of boxes finds the first triangle on a ray. It does not come from a crate: such crates
//! either compute in f32 or depend on another linear algebra, and the code is about a hundred
//! lines.

use super::{Hit, INSET, Rim, Surface, unit};
use crate::digest::Digest;
use glam::DVec3;
use serde::{Serialize, Serializer};
use std::collections::HashMap;
use std::fmt;

/// Greatest number of triangles of a screen.
pub const MOST_TRIANGLES: usize = 1 << 22;

/// The corners of a triangle, counter-clockwise as seen from its front.
pub type Triangle = [DVec3; 3];

/// Side of a mesh's triangles that is screen. The other side stops light and shows nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Faces {
    /// The side from which corners run counter-clockwise.
    Front,
    /// The other side.
    Back,
    /// Either.
    Both,
}

/// A screen of triangles. Light stops at the first triangle on its way, whichever side it meets.
#[derive(Clone, PartialEq)]
pub struct Mesh {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
    faces: Faces,
    size: f64,
    /// Mean number of triangles that a ray is tested with.
    layers: f64,
    /// Edges that belong to only one triangle, just within it; at most [`MOST_RIMS`], evenly
    /// chosen.
    rims: Vec<[DVec3; 2]>,
}

/// Reason why triangles are no screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeshProblem {
    /// No triangle has an area, there are too many, or a corner is not finite.
    NoSurface,
    /// Too many triangles lie in one place: mean number that a ray meets.
    Layers(f64),
}

/// Greatest mean number of triangles that a ray must be tested with. A surface has about ten. With
/// a file whose triangles all lie in one place, every step would take minutes.
const MOST_ON_RAY: f64 = 1024.0;
/// Number of rays for this mean.
const RAYS: usize = 256;
/// Greatest number of triangles that are counted for one of these rays.
const MOST_TRIED: usize = 64 * MOST_ON_RAY as usize;
/// Greatest number of edges that are rims.
const MOST_RIMS: usize = 2048;

/// Prints a checksum over all bits of the triangles in place of the triangles.
impl fmt::Debug for Mesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sum = format_args!("{:x}", self.sum());
        f.debug_struct("Mesh")
            .field("triangles", &self.triangles.len())
            .field("sum", &sum)
            .field("faces", &self.faces)
            .finish()
    }
}

/// A box and its content: `count` triangles from `first`. If `count` is 0, two nodes: the next one
/// and number `first`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    low: DVec3,
    high: DVec3,
    first: u32,
    count: u32,
}

/// Greatest number of triangles in a leaf: testing them costs about as much as another box.
const LEAF: usize = 4;
/// Margin of a box around its content, as a part of the mesh: more than rounding can move a hit.
const PADDING: f64 = 1e-12;
/// Greatest depth of the tree: halving [`MOST_TRIANGLES`] takes 22 steps.
const DEEPEST: usize = 64;

/// Writes a checksum in place of the triangles, as [`Debug`](fmt::Debug) does.
impl Serialize for Mesh {
    fn serialize<S: Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        (self.triangles.len(), self.sum(), self.faces).serialize(to)
    }
}

impl Mesh {
    fn sum(&self) -> Digest {
        self.triangles.iter().flatten().flat_map(DVec3::to_array).collect()
    }

    /// Makes a screen of `triangles`; those without area are left out.
    ///
    /// # Errors
    /// Returns a [`MeshProblem`] if no triangle is left, if there are more than [`MOST_TRIANGLES`],
    /// if a corner is not finite, or if a ray meets more than a thousand on average.
    pub fn new(triangles: Vec<Triangle>, faces: Faces) -> Result<Self, MeshProblem> {
        let few = triangles.len() <= MOST_TRIANGLES;
        let finite = triangles.iter().flatten().all(|corner| corner.is_finite());
        let mut triangles = triangles;
        triangles.retain(|[a, b, c]| (b - a).cross(c - a) != DVec3::ZERO);
        if !few || !finite || triangles.is_empty() {
            return Err(MeshProblem::NoSurface);
        }
        let (low, high) = bounds(&triangles);
        let size = 0.5 * (high - low).max_element();
        let mut nodes = Vec::with_capacity(triangles.len());
        build(&mut triangles, 0, PADDING * size, &mut nodes);
        let mut mesh = Self { triangles, nodes, faces, size, layers: 0.0, rims: Vec::new() };
        mesh.layers = mesh.mean_on_ray();
        if mesh.layers > MOST_ON_RAY {
            return Err(MeshProblem::Layers(mesh.layers));
        }
        mesh.rims = single_edges(&mesh.triangles);
        Ok(mesh)
    }

    /// Returns the mean number of triangles that a ray through one of the triangles is tested with.
    fn mean_on_ray(&self) -> f64 {
        let step = self.triangles.len().div_ceil(RAYS);
        let rays = self.triangles.iter().step_by(step).map(|[a, b, c]| {
            let normal = (b - a).cross(c - a).normalize_or(DVec3::Z);
            // Not along the normal: such a ray would run along the sides of boxes.
            let direction = (normal + 0.1 * normal.any_orthonormal_vector()).normalize();
            let start = (a + b + c) / 3.0 - direction * (4.0 * self.size);
            self.tried_on(&Ray::new(start, direction)) as f64
        });
        let tried: Vec<f64> = rays.collect();
        tried.iter().sum::<f64>() / tried.len() as f64
    }

    /// Returns the number of triangles whose boxes a ray meets, up to about [`MOST_TRIED`].
    fn tried_on(&self, ray: &Ray) -> usize {
        let mut tried = 0;
        let mut waiting = vec![0];
        while let Some(index) = waiting.pop() {
            let node = &self.nodes[index as usize];
            if tried < MOST_TRIED && ray.meets(node, f64::INFINITY) {
                tried += node.count as usize;
                if node.count == 0 {
                    waiting.extend([node.first, index + 1]);
                }
            }
        }
        tried
    }

    /// The triangles, in no particular order.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Returns the mean number of triangles that a ray through one of them is tested with.
    pub fn tested(&self) -> f64 {
        self.layers
    }

    /// Returns the side of the triangles that is screen.
    pub fn faces(&self) -> Faces {
        self.faces
    }

    /// Returns the nearest triangle on a ray, and the point.
    fn first_on(&self, ray: &Ray) -> Option<(&Triangle, DVec3)> {
        let mut nearest = f64::INFINITY;
        let mut found = None;
        let mut stack = [0u32; DEEPEST];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let index = stack[waiting];
            let node = &self.nodes[index as usize];
            if !ray.meets(node, nearest) {
                continue;
            }
            if node.count == 0 {
                if waiting + 2 <= DEEPEST {
                    (stack[waiting], stack[waiting + 1]) = (node.first, index + 1);
                    waiting += 2;
                }
                continue;
            }
            let first = node.first as usize;
            for triangle in &self.triangles[first..first + node.count as usize] {
                if let Some((distance, point)) = ray.meet(triangle).filter(|(distance, _)| *distance < nearest) {
                    nearest = distance;
                    found = Some((triangle, point));
                }
            }
        }
        found
    }
}

impl Surface for Mesh {
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let direction = unit(direction).filter(|_| origin.is_finite())?;
        let ([a, b, c], point) = self.first_on(&Ray::new(origin, direction))?;
        let normal = (b - a).cross(c - a).normalize_or(-direction);
        let front = normal.dot(direction) < 0.0;
        let lit = match self.faces {
            Faces::Front => front,
            Faces::Back => !front,
            Faces::Both => true,
        };
        lit.then_some(Hit { point, normal: if front { normal } else { -normal } })
    }

    fn unbounded_hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        self.hit(origin, direction)
    }

    /// Edges that belong to only one triangle.
    fn rims(&self) -> Vec<Rim<'_>> {
        self.rims.iter().map(|&[from, to]| -> Rim<'_> { Box::new(move |part| from.lerp(to, part)) }).collect()
    }

    fn size(&self) -> f64 {
        self.size
    }
}

/// Returns the edges that belong to only one of `triangles`, moved inwards a little; at most
/// [`MOST_RIMS`], evenly chosen.
fn single_edges(triangles: &[Triangle]) -> Vec<[DVec3; 2]> {
    let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
    let mut number = |corner: DVec3| {
        let next = numbers.len() as u32;
        // +0 and −0 are the same position.
        *numbers.entry((corner + 0.0).to_array().map(f64::to_bits)).or_insert(next)
    };
    // Ends, triangle and side of each edge.
    let mut edges: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(3 * triangles.len());
    for (triangle, corners) in (0..).zip(triangles) {
        let ends = corners.map(&mut number);
        for side in 0..3u8 {
            let (from, to) = (ends[usize::from(side)], ends[(usize::from(side) + 1) % 3]);
            edges.push(([from.min(to), from.max(to)], triangle, side));
        }
    }
    edges.sort_unstable();
    let alone: Vec<_> = edges.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|same| same[0]).collect();
    let inwards = |&(_, triangle, side): &([u32; 2], u32, u8)| {
        let corners = &triangles[triangle as usize];
        let center = (corners[0] + corners[1] + corners[2]) / 3.0;
        let (from, to) = (corners[usize::from(side)], corners[(usize::from(side) + 1) % 3]);
        [from, to].map(|end| end.lerp(center, INSET))
    };
    alone.iter().step_by(alone.len().div_ceil(MOST_RIMS).max(1)).map(inwards).collect()
}

fn bounds(triangles: &[Triangle]) -> (DVec3, DVec3) {
    triangles
        .iter()
        .flatten()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), corner| (low.min(*corner), high.max(*corner)))
}

/// Orders `triangles` into a tree by halving them along the longest side of their box. `before` is
/// the number of triangles of the mesh that precede them.
fn build(triangles: &mut [Triangle], before: usize, padding: f64, nodes: &mut Vec<Node>) {
    let (low, high) = bounds(triangles);
    let (low, high) = (low - padding, high + padding);
    let own = nodes.len();
    let count = if triangles.len() <= LEAF { triangles.len() as u32 } else { 0 };
    nodes.push(Node { low, high, first: before as u32, count });
    if count > 0 {
        return;
    }
    let sides = high - low;
    let axis = (0..3).max_by(|&a, &b| sides[a].total_cmp(&sides[b])).unwrap_or(0);
    let place = |triangle: &Triangle| triangle.iter().map(|corner| corner[axis]).sum::<f64>();
    let half = triangles.len() / 2;
    triangles.select_nth_unstable_by(half, |a, b| place(a).total_cmp(&place(b)));
    let (left, right) = triangles.split_at_mut(half);
    build(left, before, padding, nodes);
    nodes[own].first = nodes.len() as u32;
    build(right, before + half, padding, nodes);
}

/// A ray, prepared for the test of Woop, Benthin and Wald (*Watertight Ray/Triangle Intersection*,
/// 2013). Space is sheared so that the ray runs along the axis of its longest component. Edges that
/// triangles share are tested with the same numbers.
struct Ray {
    origin: DVec3,
    inverse: DVec3,
    /// Axes of space; that of the ray's longest component is the last.
    axes: [usize; 3],
    shear: DVec3,
}

impl Ray {
    fn new(origin: DVec3, direction: DVec3) -> Self {
        let size = direction.abs();
        let z = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(2);
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let shear = DVec3::new(direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]);
        Self { origin, inverse: direction.recip(), axes: [x, y, z], shear }
    }

    /// True if the ray goes through a box before the distance `nearest`.
    fn meets(&self, node: &Node, nearest: f64) -> bool {
        // An axis along which the ray does not move gives ±∞, or NaN exactly on a side; min and max
        // ignore NaN. There is no loop over the axes, since this is the most frequent operation.
        let to_low = (node.low - self.origin) * self.inverse;
        let to_high = (node.high - self.origin) * self.inverse;
        let enter = 0.0f64.max(to_low.x.min(to_high.x)).max(to_low.y.min(to_high.y)).max(to_low.z.min(to_high.z));
        let leave = nearest.min(to_low.x.max(to_high.x)).min(to_low.y.max(to_high.y)).min(to_low.z.max(to_high.z));
        enter <= leave
    }

    /// Returns distance and point of the intersection with a triangle.
    fn meet(&self, triangle: &Triangle) -> Option<(f64, DVec3)> {
        let [x, y, z] = self.axes;
        let sheared = triangle.map(|corner| {
            let p = corner - self.origin;
            DVec3::new(p[x] - self.shear.x * p[z], p[y] - self.shear.y * p[z], self.shear.z * p[z])
        });
        let [a, b, c] = sheared;
        let parts = [c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x];
        let inside = parts.iter().all(|part| *part >= 0.0) || parts.iter().all(|part| *part <= 0.0);
        let sum: f64 = parts.iter().sum();
        if !inside || sum == 0.0 {
            return None;
        }
        let share = parts.map(|part| part / sum);
        let distance = share[0] * a.z + share[1] * b.z + share[2] * c.z;
        let [p, q, r] = triangle;
        (distance > 0.0).then(|| (distance, *p * share[0] + *q * share[1] + *r * share[2]))
    }
}

/// Returns the point that [`Mesh::hit`] should find, by testing every triangle.
#[cfg(test)]
pub(super) fn by_every_triangle(mesh: &Mesh, origin: DVec3, direction: DVec3) -> Option<DVec3> {
    let ray = Ray::new(origin, direction);
    let met = mesh.triangles.iter().filter_map(|triangle| Some((ray.meet(triangle)?, triangle)));
    let ((_, point), [a, b, c]) = met.min_by(|a, b| a.0.0.total_cmp(&b.0.0))?;
    let front = (b - a).cross(c - a).dot(direction) < 0.0;
    (front == (mesh.faces != Faces::Back) || mesh.faces == Faces::Both).then_some(point)
}
