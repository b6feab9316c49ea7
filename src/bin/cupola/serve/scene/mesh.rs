//! Meshes of outputs on the screen.

use cupola::rig::Rig;
use cupola::warp::WarpMap;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

/// Distance at which flat windows are shown, as a part of the dome's radius.
const WINDOW_AT: f64 = 0.7;
/// Number of halvings between a lit point and an unlit one.
const HALVINGS: usize = 12;
/// Columns and rows of an output's mesh.
const GRID: (usize, usize) = (48, 30);
/// Columns and rows of a mesh around a circle.
const CIRCLE: (usize, usize) = (72, 24);
/// Columns and rows of cells that coarse triangles unite.
const BLOCK: usize = 3;

/// A vertex: a pixel position, and the point that it lights.
#[derive(Clone, Copy)]
pub struct Vertex {
    /// Position in the output, pixels from the top left.
    pub pixel: DVec2,
    /// The point, dome axes.
    pub point: Option<DVec3>,
}

/// An output on the screen.
pub struct Mesh {
    /// Number that no other mesh of this process has.
    pub id: u64,
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// Triangles, as numbers of vertices.
    pub triangles: Vec<[usize; 3]>,
    /// Fewer triangles for moving pictures: one ninth of them away from edges. Where graphics are
    /// slow, they are what the page spends most time with.
    pub coarse: Vec<[usize; 3]>,
}

/// Cells of a grid that the coarse triangles unite.
struct Block {
    vertices: Vec<usize>,
    /// From the top left, around.
    corners: [usize; 4],
    fine: Vec<[usize; 3]>,
    /// True if some vertex lights nothing.
    is_at_edge: bool,
}

impl Block {
    /// Triangles of the block, which is not divided unless it is at an edge.
    fn triangles(self, vertices: &[Vertex]) -> Vec<[usize; 3]> {
        if !self.is_at_edge {
            return two(self.corners).to_vec();
        }
        let is_lit = |triangle: &[usize; 3]| triangle.iter().all(|vertex| vertices[*vertex].point.is_some());
        self.fine.into_iter().filter(is_lit).collect()
    }
}

/// Triangles between four corners, from the top left around.
fn two([a, b, c, d]: [usize; 4]) -> [[usize; 3]; 2] {
    [[a, b, d], [b, c, d]]
}

impl Mesh {
    /// Mesh of an output that lights nothing.
    pub fn empty() -> Self {
        static MADE: AtomicU64 = AtomicU64::new(1);
        let id = MADE.fetch_add(1, Ordering::Relaxed);
        Self { id, vertices: Vec::new(), triangles: Vec::new(), coarse: Vec::new() }
    }

    /// Mesh of an output with this map.
    pub fn new(rig: &Rig, map: &WarpMap) -> Self {
        let (width, height) = (f64::from(map.size().0), f64::from(map.size().1));
        let mut mesh = Self::empty();
        let mut blocks = Vec::new();
        if let Some((centre, half)) = map.circle() {
            // A point at the rim is just inside it.
            mesh.grid(CIRCLE, &mut blocks, |x, y| {
                let (sine, cosine) = (x * std::f64::consts::TAU).sin_cos();
                centre + half * DVec2::new(cosine, sine) * (y * (1.0 - 1e-6))
            });
        } else {
            // No triangle crosses a discontinuity of the map.
            let faces = map.cubemap_faces();
            let inset = if faces > 1 { 1e-4 } else { 0.0 };
            for face in 0..faces {
                let (from, part) = (f64::from(face) / f64::from(faces), 1.0 / f64::from(faces));
                mesh.grid((GRID.0 / faces as usize, GRID.1), &mut blocks, |x, y| {
                    DVec2::new((from + part * (inset + x * (1.0 - 2.0 * inset))) * width, y * height)
                });
            }
        }
        let point = |pixel: DVec2| point(rig, map, pixel);
        mesh.vertices.iter_mut().for_each(|vertex| vertex.point = point(vertex.pixel));
        let at_edge = |vertices: &[usize]| vertices.iter().any(|vertex| mesh.vertices[*vertex].point.is_none());
        blocks.iter_mut().for_each(|block| block.is_at_edge = at_edge(&block.vertices));
        mesh.reach_for_the_edge(point);
        mesh.coarse = blocks.into_iter().flat_map(|block| block.triangles(&mesh.vertices)).collect();
        mesh
    }

    /// Bytes of the mesh for the page: points, places in the picture of `size` pixels, triangles,
    /// coarse triangles.
    pub fn bytes(&self, size: (u32, u32)) -> Vec<u8> {
        let vertices = self.vertices.iter();
        let points = vertices.clone().flat_map(|vertex| vertex.point.unwrap_or_default().to_array());
        let places = vertices.flat_map(|v| [v.pixel.x / f64::from(size.0), v.pixel.y / f64::from(size.1)]);
        let corners = self.triangles.iter().chain(&self.coarse).flatten().map(|corner| *corner as u32);
        let numbers = points.chain(places).flat_map(|number| (number as f32).to_le_bytes());
        numbers.chain(corners.flat_map(u32::to_le_bytes)).collect()
    }

    /// Adds a grid with this number of cells, and its blocks of cells to `blocks`.
    fn grid(&mut self, (columns, rows): (usize, usize), blocks: &mut Vec<Block>, pixel: impl Fn(f64, f64) -> DVec2) {
        let first = self.vertices.len();
        for row in 0..=rows {
            for column in 0..=columns {
                let pixel = pixel(column as f64 / columns as f64, row as f64 / rows as f64);
                self.vertices.push(Vertex { pixel, point: None });
            }
        }
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let at = first + row * (columns + 1) + column;
            self.triangles.push([at, at + 1, at + columns + 1]);
            self.triangles.push([at + 1, at + columns + 2, at + columns + 1]);
        }
        let at = |column: usize, row: usize| first + row * (columns + 1) + column;
        for (top, left) in (0..rows).step_by(BLOCK).flat_map(|top| (0..columns).step_by(BLOCK).map(move |x| (top, x))) {
            let (bottom, right) = ((top + BLOCK).min(rows), (left + BLOCK).min(columns));
            let places =
                |x: [usize; 2], y: [usize; 2]| (y[0]..y[1]).flat_map(move |y| (x[0]..x[1]).map(move |x| (x, y)));
            let cells = places([left, right], [top, bottom]);
            blocks.push(Block {
                vertices: places([left, right + 1], [top, bottom + 1]).map(|(x, y)| at(x, y)).collect(),
                corners: [at(left, top), at(right, top), at(right, bottom), at(left, bottom)],
                fine: cells.flat_map(|(x, y)| two([at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)])).collect(),
                is_at_edge: false,
            });
        }
    }

    /// Moves vertices that light nothing to the edge of the lit area, if a neighbour is lit, and
    /// removes the triangles of the others.
    fn reach_for_the_edge(&mut self, point: impl Fn(DVec2) -> Option<DVec3>) {
        let mut moved: BTreeMap<usize, Vertex> = BTreeMap::new();
        for triangle in &self.triangles {
            for (&dark, &lit) in triangle.iter().flat_map(|a| triangle.iter().map(move |b| (a, b))) {
                let (from, to) = (self.vertices[lit], self.vertices[dark]);
                if from.point.is_none() || to.point.is_some() || moved.contains_key(&dark) {
                    continue;
                }
                let (mut best, mut beyond) = (from, to.pixel);
                for _ in 0..HALVINGS {
                    let pixel = 0.5 * (best.pixel + beyond);
                    match point(pixel) {
                        Some(found) => best = Vertex { pixel, point: Some(found) },
                        None => beyond = pixel,
                    }
                }
                moved.insert(dark, best);
            }
        }
        for (index, vertex) in moved {
            self.vertices[index] = vertex;
        }
        let vertices = &self.vertices;
        self.triangles.retain(|triangle| triangle.iter().all(|index| vertices[*index].point.is_some()));
    }
}

/// Point at which a pixel is seen: on the screen, or in a window in front of the viewer.
fn point(rig: &Rig, map: &WarpMap, pixel: DVec2) -> Option<DVec3> {
    map.hit(pixel).or_else(|| {
        let is_window = map.origin().is_none() && map.screen().size() > 0.0;
        let direction = map.direction(pixel).filter(|_| is_window)?;
        Some(map.viewer().point_to_parent(direction * WINDOW_AT * rig.dome.radius))
    })
}
