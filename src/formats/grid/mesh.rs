//! Nodes with triangles.

use super::Sample;
use crate::digest::Digest;
use crate::error::Result;
use crate::formats::reading::input::invalid;
use glam::{DVec2, DVec3};
use serde::{Serialize, Serializer};
use std::fmt;

/// Greatest number of nodes of a mesh.
pub const MOST_NODES: usize = 1 << 20;
/// Greatest number of entries of the index: 128 MiB.
const MOST_ENTRIES: u64 = 1 << 25;
/// Greatest ratio of the area of all triangles' boxes to the area of their mesh. A grid of squares
/// has 2, a folded one a few more. Beyond this limit the file is damaged, and finding a pixel's
/// triangle would take too long.
const MOST_LAYERS: f64 = 256.0;

/// Distance outside a triangle, in barycentric parts, at which a point still belongs to it. So no
/// pixel falls between two triangles by rounding.
const SLACK: f64 = 1e-9;

/// A node of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Position in the output: from the middle, x to the right, y up, in the units of the mesh's
    /// [`Grid`](super::Grid).
    pub position: DVec2,
    /// Value at the position, see [`Sample::value`].
    pub value: DVec3,
    /// Factor on the displayed (encoded) value, 0…1.
    pub intensity: f64,
}

/// Triangles over an output. The values inside a triangle follow linearly from its three nodes.
#[derive(Clone, PartialEq)]
pub struct Mesh {
    nodes: Vec<Node>,
    triangles: Vec<[u32; 3]>,
    index: Index,
}

/// The text has a checksum of all bits of nodes and triangles; the index follows from these.
impl fmt::Debug for Mesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sum = format_args!("{:x}", self.sum());
        let (nodes, triangles) = (self.nodes.len(), self.triangles.len());
        f.debug_struct("Mesh").field("nodes", &nodes).field("triangles", &triangles).field("sum", &sum).finish()
    }
}

/// As in [`Debug`](fmt::Debug), a checksum replaces the numbers.
impl Serialize for Mesh {
    fn serialize<S: Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        (self.nodes.len(), self.triangles.len(), self.sum()).serialize(to)
    }
}

impl Mesh {
    fn sum(&self) -> Digest {
        let of_node = |node: &Node| {
            let (DVec2 { x, y }, value) = (node.position, node.value);
            [x, y, value.x, value.y, value.z, node.intensity]
        };
        let nodes = self.nodes.iter().flat_map(of_node);
        let corners = self.triangles.iter().flatten().map(|node| f64::from(*node));
        nodes.chain(corners).collect()
    }

    /// Makes a mesh from nodes and triangles of either orientation. Where triangles overlap, the
    /// later one is visible. `name` is the file's, for messages.
    ///
    /// # Errors
    /// [`InvalidRig`](crate::ErrorKind::InvalidRig) if a triangle names a node that does not exist,
    /// a number is not finite, there are more than [`MOST_NODES`] nodes or three times as many
    /// triangles, or the triangles overlap hundreds of times.
    pub fn new(name: &str, nodes: Vec<Node>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        let finite = |node: &Node| node.position.is_finite() && node.value.is_finite() && node.intensity.is_finite();
        if nodes.len() > MOST_NODES || triangles.len() > 3 * MOST_NODES {
            let (nodes, triangles) = (nodes.len(), triangles.len());
            return Err(invalid(
                name,
                format!("has {nodes} nodes and {triangles} triangles; expected at most {MOST_NODES} nodes"),
            ));
        }
        if let Some(number) = nodes.iter().position(|node| !finite(node)) {
            return Err(invalid(name, format!("node {number} (from 0) has a number that is not finite")));
        }
        if let Some(number) = triangles.iter().flatten().find(|number| **number as usize >= nodes.len()) {
            return Err(invalid(name, format!("a triangle has the node {number}, there are {} (from 0)", nodes.len())));
        }
        match Index::new(&nodes, &triangles) {
            Some(index) => Ok(Self { nodes, triangles, index }),
            None => Err(invalid(name, "its triangles lie over each other hundreds of times; the file is damaged")),
        }
    }

    /// Makes a mesh from a grid of `columns` × `rows` nodes, row by row; `None` is a missing node.
    /// A cell is drawn if all four corners exist, as two triangles with the diagonal from its first
    /// corner. `closed`: the last column is followed by the first.
    ///
    /// # Errors
    /// As [`Self::new`], and if the number of nodes is not that of the grid.
    pub fn from_grid(name: &str, columns: usize, rows: usize, grid: &[Option<Node>], closed: bool) -> Result<Self> {
        if columns.checked_mul(rows) != Some(grid.len()) || grid.len() > MOST_NODES {
            return Err(invalid(name, format!("{} nodes do not make a grid of {columns} × {rows}", grid.len())));
        }
        let mut numbers = vec![None; grid.len()];
        let mut nodes = Vec::new();
        for (number, node) in numbers.iter_mut().zip(grid) {
            if let Some(node) = node {
                *number = Some(nodes.len() as u32);
                nodes.push(*node);
            }
        }
        let mut triangles = Vec::new();
        let cells_across = if closed { columns } else { columns.saturating_sub(1) };
        for row in 1..rows {
            for column in 0..cells_across {
                let next = (column + 1) % columns;
                let corner = |column: usize, row: usize| numbers[row * columns + column];
                let corners = [corner(column, row - 1), corner(next, row - 1), corner(next, row), corner(column, row)];
                if let [Some(a), Some(b), Some(c), Some(d)] = corners {
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        Self::new(name, nodes, triangles)
    }

    /// Nodes of the mesh.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Triangles, as indices of their nodes.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Returns the value at a place of the output, in the units of the nodes' positions; `None`
    /// outside all triangles.
    pub fn sample(&self, position: DVec2) -> Option<Sample> {
        let candidates = self.index.candidates(position)?;
        candidates.iter().rev().find_map(|triangle| {
            let corners = self.corners(*triangle as usize);
            let parts = barycentric(corners.map(|node| node.position), position)?;
            let [a, b, c] = corners;
            Some(Sample {
                value: a.value * parts[0] + b.value * parts[1] + c.value * parts[2],
                intensity: a.intensity * parts[0] + b.intensity * parts[1] + c.intensity * parts[2],
            })
        })
    }

    fn corners(&self, triangle: usize) -> [&Node; 3] {
        self.triangles[triangle].map(|node| &self.nodes[node as usize])
    }
}

/// Barycentric parts of the corners of a triangle at `point`; `None` outside, and in triangles
/// without area.
fn barycentric([a, b, c]: [DVec2; 3], point: DVec2) -> Option<[f64; 3]> {
    let area = (b - a).perp_dot(c - a);
    let second = (point - a).perp_dot(c - a) / area;
    let third = (b - a).perp_dot(point - a) / area;
    let parts = [1.0 - second - third, second, third];
    parts.iter().all(|part| *part >= -SLACK).then_some(parts)
}

/// Bounding box of a triangle.
fn bounds([a, b, c]: [DVec2; 3]) -> (DVec2, DVec2) {
    (a.min(b).min(c), a.max(b).max(c))
}

/// Index of the triangles that may contain a point. It lists the triangles of each cell of a grid
/// over the mesh's box.
#[derive(Clone, Debug, PartialEq)]
struct Index {
    low: DVec2,
    /// Number of cells for each unit of length.
    scale: DVec2,
    /// Number of columns, and of rows.
    side: usize,
    /// Index in `triangles` at which each cell's triangles begin, and the end.
    starts: Vec<u32>,
    /// Indices of triangles, in ascending order within a cell.
    triangles: Vec<u32>,
}

impl Index {
    /// Makes about as many cells as there are triangles, fewer where long triangles would fill the
    /// lists; `None` if the triangles cover the mesh's box too many times.
    fn new(nodes: &[Node], triangles: &[[u32; 3]]) -> Option<Self> {
        let boxes = || triangles.iter().map(|triangle| bounds(triangle.map(|node| nodes[node as usize].position)));
        let low = boxes().fold(DVec2::INFINITY, |low, (corner, _)| low.min(corner));
        let high = boxes().fold(DVec2::NEG_INFINITY, |high, (_, corner)| high.max(corner));
        let extent = (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        let layers: f64 = boxes().map(|(low, high)| ((high - low) / extent).element_product()).sum();
        if layers > MOST_LAYERS {
            return None;
        }
        let mut index = Self { low, scale: DVec2::ONE, side: 0, starts: Vec::new(), triangles: Vec::new() };
        let mut side = ((triangles.len() as f64).sqrt() as usize).clamp(1, 2048);
        loop {
            (index.side, index.scale) = (side, DVec2::splat(side as f64) / extent);
            let entries = |(left, bottom, right, top)| ((right - left + 1) * (top - bottom + 1)) as u64;
            if side == 1 || boxes().map(|bounds| entries(index.cells(bounds))).sum::<u64>() <= MOST_ENTRIES {
                break;
            }
            side /= 2;
        }
        // Goes through the triangles twice, to count and to fill, so that no cell needs a list of
        // its own.
        let mut ends = vec![0_u32; side * side + 1];
        boxes().for_each(|bounds| index.visit(bounds, |cell| ends[cell + 1] += 1));
        for cell in 1..ends.len() {
            ends[cell] += ends[cell - 1];
        }
        index.starts = ends.clone();
        let mut listed = vec![0; ends[side * side] as usize];
        for (number, bounds) in (0..).zip(boxes()) {
            index.visit(bounds, |cell| {
                listed[ends[cell] as usize] = number;
                ends[cell] += 1;
            });
        }
        index.triangles = listed;
        Some(index)
    }

    /// Cells that a box touches: first column and row, last column and row.
    fn cells(&self, (low, high): (DVec2, DVec2)) -> (usize, usize, usize, usize) {
        let ((left, bottom), (right, top)) = (self.cell(low), self.cell(high));
        (left, bottom, right, top)
    }

    /// Calls `visit` with each cell that a box touches.
    fn visit(&self, bounds: (DVec2, DVec2), mut visit: impl FnMut(usize)) {
        let (left, bottom, right, top) = self.cells(bounds);
        for row in bottom..=top {
            for column in left..=right {
                visit(row * self.side + column);
            }
        }
    }

    /// Column and row of the cell of a point, or of the one nearest to it.
    fn cell(&self, point: DVec2) -> (usize, usize) {
        let at = (point - self.low) * self.scale;
        // The conversion saturates, and turns NaN into 0.
        ((at.x as usize).min(self.side - 1), (at.y as usize).min(self.side - 1))
    }

    /// Triangles in the cell of `point`, in ascending order.
    fn candidates(&self, point: DVec2) -> Option<&[u32]> {
        if self.triangles.is_empty() || !point.is_finite() {
            return None;
        }
        let (column, row) = self.cell(point);
        let cell = row * self.side + column;
        self.triangles.get(self.starts[cell] as usize..self.starts[cell + 1] as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;

    fn node(x: f64, y: f64, value: DVec3) -> Node {
        Node { position: DVec2::new(x, y), value, intensity: 0.5 + 0.1 * x }
    }

    /// A grid over −1…1 with the values of `value`.
    fn grid(side: usize, value: impl Fn(f64, f64) -> DVec3) -> Vec<Option<Node>> {
        let at = |index: usize| 2.0 * index as f64 / (side - 1) as f64 - 1.0;
        (0..side * side).map(|i| (at(i % side), at(i / side))).map(|(x, y)| Some(node(x, y, value(x, y)))).collect()
    }

    #[test]
    fn a_linear_mesh_is_linear_and_has_no_cracks() {
        let value = |x: f64, y: f64| DVec3::new(3.0 * x - y, x + 10.0 * y, 4.0);
        let mesh = Mesh::from_grid("mesh", 13, 13, &grid(13, value), false).unwrap();
        let mut random = Random::new(1);
        for _ in 0..20_000 {
            let at = DVec2::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0));
            // Every other point is on an edge between two triangles.
            let at = if random.unit() < 0.5 { DVec2::new((at.x * 6.0).round() / 6.0, at.y) } else { at };
            let sample = mesh.sample(at).unwrap();
            assert!(sample.value.distance(value(at.x, at.y)) < 1e-12);
            assert!((sample.intensity - 0.5 - 0.1 * at.x).abs() < 1e-12);
        }
        assert_eq!(mesh.sample(DVec2::new(1.01, 0.0)), None);
        assert_eq!(mesh.sample(DVec2::NAN), None);
    }

    #[test]
    fn a_cell_without_a_corner_is_not_drawn() {
        let mut nodes = grid(4, |_, _| DVec3::ONE);
        nodes[5] = None;
        let mesh = Mesh::from_grid("mesh", 4, 4, &nodes, false).unwrap();
        assert_eq!(mesh.triangles().len(), 2 * (9 - 4));
        assert!(mesh.sample(DVec2::new(-0.5, 0.1)).is_none() && mesh.sample(DVec2::new(0.8, 0.8)).is_some());
    }

    #[test]
    fn the_later_triangle_is_seen() {
        let nodes = [DVec3::X, DVec3::Y]
            .into_iter()
            .flat_map(|value| [node(-1.0, -1.0, value), node(1.0, -1.0, value), node(0.0, 1.0, value)]);
        let mesh = Mesh::new("mesh", nodes.collect(), vec![[0, 1, 2], [3, 4, 5]]).unwrap();
        assert_eq!(mesh.sample(DVec2::ZERO).map(|sample| sample.value), Some(DVec3::Y));
    }

    #[test]
    fn damaged_meshes_are_refused() {
        let good = || vec![node(0.0, 0.0, DVec3::X), node(1.0, 0.0, DVec3::X), node(0.0, 1.0, DVec3::X)];
        assert!(Mesh::new("mesh", good(), vec![[0, 1, 2]]).is_ok());
        assert!(Mesh::new("mesh", good(), vec![[0, 1, 3]]).unwrap_err().message.contains("node 3"));
        let mut broken = good();
        broken[1].value.y = f64::NAN;
        assert!(Mesh::new("mesh", broken, vec![[0, 1, 2]]).unwrap_err().message.contains("node 1"));
        assert!(Mesh::new("mesh", good(), vec![[0, 1, 2]; 1000]).unwrap_err().message.contains("over each other"));
    }

    #[test]
    fn a_fan_of_needles_stays_within_bounds() {
        let needle = |i: usize| {
            let y = i as f64 / 5000.0 - 1.0;
            [node(-1.0, y, DVec3::X), node(1.0, y, DVec3::X), node(1.0, y + 1e-4, DVec3::X)]
        };
        let triangles = (0..10_000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh::new("mesh", (0..10_000).flat_map(needle).collect(), triangles).unwrap();
        assert!(mesh.index.triangles.len() < 10_000 * 200);
    }

    #[test]
    fn nothing_at_all_is_a_mesh_too() {
        let mesh = Mesh::new("mesh", Vec::new(), Vec::new()).unwrap();
        assert_eq!(mesh.sample(DVec2::ZERO), None);
    }
}
