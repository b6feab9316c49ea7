//! Objects that the page draws in three dimensions: the screen, and each output as a mesh on it.

use cupola::blend::Weights;
use cupola::rig::{OutputKind, Rig};
use cupola::views::{self, Surveyor};
use cupola::warp::WarpMap;
use glam::{DMat3, DVec2, DVec3};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Distance at which flat windows are shown, as a part of the dome's radius.
const WINDOW_AT: f64 = 0.7;
/// Number of halvings between a lit point and an unlit one.
const HALVINGS: usize = 12;
/// Columns and rows of an output's mesh.
const GRID: (usize, usize) = (48, 30);
/// Columns and rows of a mesh around a circle.
const CIRCLE: (usize, usize) = (72, 24);

/// Kinds of values that are shown over the outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlay {
    /// Number of outputs that light a point.
    Coverage,
    /// Sum of their light, as a part of full white.
    Light,
    /// Texels of the views per pixel of the output.
    Density,
    /// Pixels of the output per degree, as the viewer sees them.
    Resolution,
}

impl Overlay {
    /// Overlay with this name in requests.
    pub fn named(name: &str) -> Option<Self> {
        let all = [
            ("coverage", Self::Coverage),
            ("light", Self::Light),
            ("density", Self::Density),
            ("resolution", Self::Resolution),
        ];
        all.into_iter().find(|(known, _)| *known == name).map(|(_, overlay)| overlay)
    }
}

/// A vertex: a pixel position, and the point that it lights.
#[derive(Clone, Copy)]
struct Vertex {
    pixel: DVec2,
    point: Option<DVec3>,
}

/// An output on the screen.
struct Mesh {
    vertices: Vec<Vertex>,
    triangles: Vec<[usize; 3]>,
}

/// A rig with its exact maps and meshes.
pub struct Scene {
    rig: Rig,
    sizes: Vec<(u32, u32)>,
    maps: Vec<Option<WarpMap>>,
    meshes: Vec<Mesh>,
}

impl Scene {
    /// Makes the scene of a rig whose outputs have these sizes in pixels.
    pub fn new(rig: &Rig, sizes: Vec<(u32, u32)>) -> Self {
        // The map of an output with the program's own lens is not known here.
        let maps: Vec<_> =
            sizes.iter().enumerate().map(|(index, size)| WarpMap::new(rig, index, *size, None).ok()).collect();
        let meshes = maps.iter().map(|map| map.as_ref().map_or(Mesh::empty(), |map| Mesh::new(rig, map))).collect();
        Self { rig: rig.clone(), sizes, maps, meshes }
    }

    /// Everything that does not change with the picture, as JSON.
    pub fn json(&self) -> Value {
        let (rig, viewer) = (&self.rig, self.rig.viewer_pose());
        let outputs = rig.outputs.iter().zip(&self.maps).zip(self.meshes.iter().zip(&self.sizes));
        let outputs: Vec<Value> = outputs.map(|((output, map), (mesh, size))| {
            json!({
                "name": output.name,
                "kind": kind(&output.kind),
                "size": [size.0, size.1],
                "projector": output.kind.is_projector(),
                "uv": numbers(mesh.vertices.iter().flat_map(|v| [v.pixel.x / f64::from(size.0), v.pixel.y / f64::from(size.1)])),
                "points": points(mesh.vertices.iter().map(|v| v.point)),
                "triangles": mesh.triangles,
                "frustum": map.as_ref().map_or(json!([]), |map| points(frustum(map).into_iter().map(Some))),
                "origin": map.as_ref().and_then(|map| map.origin()).map(rounded),
            })
        }).collect();
        json!({
            "radius": rig.dome.radius,
            "tilt": rig.dome.tilt.to_degrees(),
            "size": rig.surface().size(),
            "viewer": { "position": rounded(viewer.position), "forward": rounded(viewer.direction_to_parent(DVec3::NEG_Z)) },
            "lines": lines(rig).into_iter().map(|line| points(line.into_iter().map(Some))).collect::<Vec<_>>(),
            "outputs": outputs,
        })
    }

    /// Values of an overlay at each vertex of each output.
    ///
    /// # Errors
    /// Message of the planner.
    pub fn overlay(&self, overlay: Overlay) -> Result<Value, String> {
        let failed = |error: cupola::Error| error.message;
        let weights = Weights::new(&self.rig, &self.sizes).map_err(failed)?;
        let plan = match overlay {
            Overlay::Density => {
                let window = self.rig.extent().unwrap_or((1920, 1200));
                let request = crate::planning::request(self.sizes.clone(), window);
                Some(views::plan(&self.rig, &request).map_err(failed)?)
            }
            _ => None,
        };
        let mut values = Vec::new();
        for (index, mesh) in self.meshes.iter().enumerate() {
            let surveyor = match &plan {
                Some(plan) => Some(Surveyor::new(plan, &self.rig, index, self.sizes[index]).map_err(failed)?),
                None => None,
            };
            let value = |vertex: &Vertex| -> Option<f64> {
                let point = vertex.point?;
                match overlay {
                    Overlay::Coverage => Some(self.lit(point).count() as f64),
                    Overlay::Light => {
                        Some(self.lit(point).filter_map(|(other, pixel)| weights.weight(other, pixel)).sum())
                    }
                    Overlay::Density => surveyor.as_ref()?.at(vertex.pixel)?.texels_per_pixel,
                    Overlay::Resolution => self.resolution(index, vertex.pixel),
                }
            };
            values.push(numbers_or_null(mesh.vertices.iter().map(value)));
        }
        Ok(Value::Array(values))
    }

    /// Outputs that light a point, with the pixels that do.
    fn lit(&self, point: DVec3) -> impl Iterator<Item = (usize, DVec2)> {
        let maps = self.maps.iter().enumerate();
        maps.filter_map(move |(index, map)| Some((index, map.as_ref()?.pixel(point)?)))
    }

    /// Pixels per degree in the direction in which there are fewest.
    fn resolution(&self, index: usize, pixel: DVec2) -> Option<f64> {
        let map = self.maps[index].as_ref()?;
        let (size, here) = (self.sizes[index], map.direction(pixel)?);
        let inwards = |at: f64, length: u32| if 2.0 * at < f64::from(length) { 1.0 } else { -1.0 };
        let steps = [DVec2::X * inwards(pixel.x, size.0), DVec2::Y * inwards(pixel.y, size.1)];
        let angles = steps.into_iter().filter_map(|step| Some(here.angle_between(map.direction(pixel + step)?)));
        let widest = angles.fold(0.0, f64::max).to_degrees();
        (widest > 0.0).then_some(1.0 / widest)
    }
}

impl Mesh {
    fn empty() -> Self {
        Self { vertices: Vec::new(), triangles: Vec::new() }
    }

    fn new(rig: &Rig, map: &WarpMap) -> Self {
        let (width, height) = (f64::from(map.size().0), f64::from(map.size().1));
        let mut mesh = Self::empty();
        if let Some((centre, half)) = map.circle() {
            // A point at the rim is just inside it.
            mesh.grid(CIRCLE, |x, y| {
                let (sine, cosine) = (x * std::f64::consts::TAU).sin_cos();
                centre + half * DVec2::new(cosine, sine) * (y * (1.0 - 1e-6))
            });
        } else {
            // No triangle crosses a discontinuity of the map.
            let faces = map.cubemap_faces();
            let inset = if faces > 1 { 1e-4 } else { 0.0 };
            for face in 0..faces {
                let (from, part) = (f64::from(face) / f64::from(faces), 1.0 / f64::from(faces));
                mesh.grid((GRID.0 / faces as usize, GRID.1), |x, y| {
                    DVec2::new((from + part * (inset + x * (1.0 - 2.0 * inset))) * width, y * height)
                });
            }
        }
        let point = |pixel: DVec2| point(rig, map, pixel);
        mesh.vertices.iter_mut().for_each(|vertex| vertex.point = point(vertex.pixel));
        mesh.reach_for_the_edge(point);
        mesh
    }

    /// Adds a grid with this number of cells.
    fn grid(&mut self, (columns, rows): (usize, usize), pixel: impl Fn(f64, f64) -> DVec2) {
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

/// Points at the ends of the lines from a projector to the corners and the middles of the sides of
/// its picture.
fn frustum(map: &WarpMap) -> Vec<DVec3> {
    let (width, height) = (f64::from(map.size().0), f64::from(map.size().1));
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    corners.into_iter().filter_map(|(x, y)| map.hit(DVec2::new(x * width, y * height))).collect()
}

/// Lines on the screen: circles around the dome's pole and lines through it, every 15 and 30
/// degrees, and rims.
fn lines(rig: &Rig) -> Vec<Vec<DVec3>> {
    let surface = rig.surface();
    let pole = DMat3::from_rotation_x(-rig.dome.tilt);
    let inside = [DVec3::ZERO, rig.viewer_pose().position];
    let hit = |direction: DVec3| inside.iter().find_map(|from| Some(surface.hit(*from, pole * direction)?.point));
    let direction = |polar: f64, around: f64| {
        let ((sine, up), (right, ahead)) = (polar.to_radians().sin_cos(), around.to_radians().sin_cos());
        DVec3::new(sine * right, up, -sine * ahead)
    };
    let circles =
        (1..12).map(|step| (0..=72).map(|part| direction(15.0 * f64::from(step), 5.0 * f64::from(part))).collect());
    let through =
        (0..12).map(|step| (3..=36).map(|part| direction(5.0 * f64::from(part), 30.0 * f64::from(step))).collect());
    let mut lines = Vec::new();
    for directions in circles.chain(through).collect::<Vec<Vec<DVec3>>>() {
        let points: Vec<Option<DVec3>> = directions.into_iter().map(hit).collect();
        lines.extend(
            points
                .split(Option::is_none)
                .filter(|part| part.len() > 1)
                .map(|part| part.iter().flatten().copied().collect()),
        );
    }
    lines.extend(surface.rims().iter().map(|rim| (0..=96).map(|part| rim(f64::from(part) / 96.0)).collect()));
    lines
}

/// Word for a kind of output.
fn kind(kind: &OutputKind) -> &'static str {
    match kind {
        OutputKind::Domemaster { .. } => "domemaster",
        OutputKind::Panorama { .. } => "panorama",
        OutputKind::Projector { .. } | OutputKind::Optics { .. } => "projector",
        OutputKind::Mesh(_) => "mesh",
        OutputKind::Perspective { .. } => "perspective",
    }
}

fn rounded(point: DVec3) -> [f64; 3] {
    point.to_array().map(|value| (value * 1e4).round() / 1e4)
}

fn numbers(values: impl Iterator<Item = f64>) -> Value {
    numbers_or_null(values.map(Some))
}

fn numbers_or_null(values: impl Iterator<Item = Option<f64>>) -> Value {
    let number = |value: Option<f64>| value.filter(|value| value.is_finite()).map(|value| (value * 1e5).round() / 1e5);
    Value::Array(values.map(|value| number(value).map_or(Value::Null, Value::from)).collect())
}

/// Three numbers for each point, 0 if there is none.
fn points(points: impl Iterator<Item = Option<DVec3>>) -> Value {
    Value::Array(points.flat_map(|point| rounded(point.unwrap_or_default()).map(Value::from)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(name: &str) -> Scene {
        let rig = cupola::rig::load(name).expect("a preset");
        let sizes = (0..rig.outputs.len()).map(|output| crate::map::native_size(&rig, output)).collect();
        Scene::new(&rig, sizes)
    }

    /// The area of the meshes of a domemaster is that of its hemisphere.
    #[test]
    fn meshes_lie_on_the_screen_and_reach_its_rim() {
        let scene = scene("fisheye");
        let mesh = &scene.meshes[0];
        let point = |index: usize| mesh.vertices[index].point.expect("all are lit");
        assert!(mesh.vertices.iter().all(|vertex| (vertex.point.expect("lit").length() - 5.0).abs() < 1e-9));
        let area = |[a, b, c]: [usize; 3]| 0.5 * (point(b) - point(a)).cross(point(c) - point(a)).length();
        let total: f64 = mesh.triangles.iter().map(|triangle| area(*triangle)).sum();
        let whole = 2.0 * std::f64::consts::PI * 25.0;
        assert!((total / whole - 1.0).abs() < 0.01, "{total} {whole}");
    }

    #[test]
    fn light_is_even_where_projectors_share_it() {
        let scene = scene("planetarium-6");
        let light = scene.overlay(Overlay::Light).expect("weights");
        let coverage = scene.overlay(Overlay::Coverage).expect("counts");
        let flat = |value: &Value| -> Vec<f64> {
            let outputs = value.as_array().expect("outputs");
            outputs.iter().flat_map(|values| values.as_array().expect("values")).filter_map(Value::as_f64).collect()
        };
        let (light, coverage) = (flat(&light), flat(&coverage));
        assert!(
            light.len() > 3000
                && light.iter().filter(|value| (**value - 1.0).abs() < 1e-4).count() * 100 > light.len() * 98
        );
        assert!(coverage.contains(&1.0) && coverage.contains(&2.0) && coverage.iter().all(|count| *count <= 4.0));
    }
}
