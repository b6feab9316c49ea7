//! Objects that the page draws in three dimensions: the screen, and each output as a mesh on it.

mod mesh;

use cupola::blend::Weights;
use cupola::rig::{Output, OutputKind, Rig};
use cupola::views::{self, Surveyor};
use cupola::warp::WarpMap;
use glam::{DMat3, DVec2, DVec3};
use mesh::{Mesh, Vertex};
use serde_json::{Value, json};
use std::sync::Arc;

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

/// A rig with its exact maps and meshes.
pub struct Scene {
    rig: Rig,
    sizes: Vec<(u32, u32)>,
    maps: Vec<Arc<Option<WarpMap>>>,
    meshes: Vec<Arc<Mesh>>,
}

impl Scene {
    /// Makes the scene of a rig whose outputs have these sizes in pixels. Outputs that are the same
    /// as in the scene `before` are taken from it.
    pub fn new(rig: &Rig, sizes: Vec<(u32, u32)>, before: Option<&Self>) -> Self {
        let before = before.filter(|before| before.has_dome_of(rig));
        let made = sizes.iter().enumerate().map(|(index, &size)| {
            let known = before.filter(|before| before.has_output_of(rig, index, size));
            if let Some(Self { maps, meshes, .. }) = known {
                return (maps[index].clone(), meshes[index].clone());
            }
            // The map of an output with the program's own lens is not known here.
            let map = WarpMap::new(rig, index, size, None).ok();
            let mesh = map.as_ref().map_or(Mesh::empty(), |map| Mesh::new(rig, map));
            (Arc::new(map), Arc::new(mesh))
        });
        let (maps, meshes) = made.unzip();
        Self { rig: rig.clone(), sizes, maps, meshes }
    }

    /// True if everything but outputs, on which their places depend, is as in `rig`.
    fn has_dome_of(&self, rig: &Rig) -> bool {
        let old = &self.rig;
        (&old.dome, &old.screen, &old.viewer, &old.content) == (&rig.dome, &rig.screen, &rig.viewer, &rig.content)
    }

    /// True if an output of this size is as in `rig`, but for its light.
    fn has_output_of(&self, rig: &Rig, index: usize, size: (u32, u32)) -> bool {
        self.sizes.get(index) == Some(&size)
            && self
                .rig
                .outputs
                .get(index)
                .zip(rig.outputs.get(index))
                .is_some_and(|(old, new)| Output { blend: old.blend.clone(), ..new.clone() } == *old)
    }

    /// Everything that does not change with the picture, for the page: the length of a text of JSON
    /// in four bytes, the text, filled with spaces to a multiple of four, points of the lines, and
    /// the outputs' meshes but those with the numbers `known`. All numbers begin with the lowest
    /// byte.
    pub fn bytes(&self, version: u64, known: &[u64]) -> Vec<u8> {
        let lines = lines(&self.rig);
        let mut text = json!({ "version": version, "scene": self.json(&lines) }).to_string();
        text.extend(std::iter::repeat_n(' ', text.len().next_multiple_of(4) - text.len()));
        let numbers = lines.iter().flatten().flat_map(|point| point.to_array());
        let meshes = self.meshes.iter().zip(&self.sizes).filter(|(mesh, _)| !known.contains(&mesh.id));
        (text.len() as u32)
            .to_le_bytes()
            .into_iter()
            .chain(text.into_bytes())
            .chain(numbers.flat_map(|number| (number as f32).to_le_bytes()))
            .chain(meshes.flat_map(|(mesh, size)| mesh.bytes(*size)))
            .collect()
    }

    fn json(&self, lines: &[Vec<DVec3>]) -> Value {
        let (rig, viewer) = (&self.rig, self.rig.viewer_pose());
        let outputs = rig.outputs.iter().zip(&self.maps).zip(self.meshes.iter().zip(&self.sizes));
        let outputs: Vec<Value> = outputs
            .map(|((output, map), (mesh, size))| {
                json!({
                    "name": output.name,
                    "kind": kind(&output.kind),
                    "size": [size.0, size.1],
                    "projector": output.kind.is_projector(),
                    "mesh": mesh.id,
                    "counts": [mesh.vertices.len(), mesh.triangles.len(), mesh.coarse.len()],
                    "frustum": (**map).as_ref().map_or(json!([]), |map| points(frustum(map).into_iter().map(Some))),
                    "origin": (**map).as_ref().and_then(|map| map.origin()).map(rounded),
                })
            })
            .collect();
        json!({
            "radius": rig.dome.radius,
            "tilt": rig.dome.tilt.to_degrees(),
            "size": rig.surface().size(),
            "viewer": { "position": rounded(viewer.position), "forward": rounded(viewer.direction_to_parent(DVec3::NEG_Z)) },
            "lines": lines.iter().map(Vec::len).collect::<Vec<_>>(),
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
        maps.filter_map(move |(index, map)| Some((index, (**map).as_ref()?.pixel(point)?)))
    }

    /// Pixels per degree in the direction in which there are fewest.
    fn resolution(&self, index: usize, pixel: DVec2) -> Option<f64> {
        let map = (*self.maps[index]).as_ref()?;
        let (size, here) = (self.sizes[index], map.direction(pixel)?);
        let inwards = |at: f64, length: u32| if 2.0 * at < f64::from(length) { 1.0 } else { -1.0 };
        let steps = [DVec2::X * inwards(pixel.x, size.0), DVec2::Y * inwards(pixel.y, size.1)];
        let angles = steps.into_iter().filter_map(|step| Some(here.angle_between(map.direction(pixel + step)?)));
        let widest = angles.fold(0.0, f64::max).to_degrees();
        (widest > 0.0).then_some(1.0 / widest)
    }
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
        Scene::new(&rig, sizes, None)
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
        let coarse: f64 = mesh.coarse.iter().map(|triangle| area(*triangle)).sum();
        assert!((coarse / whole - 1.0).abs() < 0.03 && mesh.coarse.len() * 9 == mesh.triangles.len(), "{coarse}");
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

    #[test]
    fn outputs_that_stay_the_same_are_taken_from_the_scene_before() {
        let first = scene("planetarium-6");
        let mut rig = first.rig.clone();
        let cupola::rig::OutputKind::Projector { angles, .. } = &mut rig.outputs[2].kind else { panic!("a projector") };
        angles[0] += 0.1;
        rig.outputs[3].blend.gamma += 0.1;
        let next = Scene::new(&rig, first.sizes.clone(), Some(&first));
        let is_taken = |index: usize| Arc::ptr_eq(&first.meshes[index], &next.meshes[index]);
        assert_eq!([0, 1, 2, 3, 4, 5].map(is_taken), [true, true, false, true, true, true]);
        let anew = Scene::new(&rig, first.sizes.clone(), None);
        let bytes = |scene: &Scene| -> Vec<Vec<u8>> { scene.meshes.iter().map(|mesh| mesh.bytes((9, 9))).collect() };
        assert!(bytes(&next) == bytes(&anew) && bytes(&next) != bytes(&first));
        // What the page has is left out.
        let known: Vec<u64> = first.meshes.iter().map(|mesh| mesh.id).collect();
        let moved = next.bytes(7, &[]).len() - next.bytes(7, &known).len();
        assert_eq!(
            moved,
            [0, 1, 3, 4, 5].map(|index: usize| next.meshes[index].bytes((9, 9)).len()).iter().sum::<usize>()
        );
        rig.viewer.position.x += 0.1;
        let moved = Scene::new(&rig, first.sizes.clone(), Some(&next));
        assert!(!Arc::ptr_eq(&moved.meshes[0], &next.meshes[0]), "another viewer");
    }
}
