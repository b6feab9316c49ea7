//! The dome as a mesh of triangles, as a projector sees it, or flattened to a domemaster.
//!
//! The faces of a cube are cut into triangles and inflated to the dome (Bourke & Felinto 2009,
//! "tessellate, inflate, flatten"). The part that the output shows is drawn. A projector draws it
//! in perspective (Kooima, Roberts & SubbaRao 2009, "fixed-function fragment correction"); the mesh
//! is subdivided along the sides of all pictures and of their ramps, so that weights at the corners
//! can fade there. A domemaster draws it by the formula of its lens. Each corner lies on the dome
//! and is exact. Between corners the error is about 0.4 times the square of a cell's angle, seen
//! from the centre.

use crate::blend::EdgeWeight;
use crate::correct::passes::facets::Facets;
use crate::correct::sources::facets::clip::HalfSpace;
use crate::correct::sources::surface_sample::{SurfaceSample, SurfaceSampler};
use crate::geom::cube::Face;
use crate::geom::{Fisheye, Frustum, Lens, Pose, Sphere, pose};
use crate::rig::{Output, OutputKind, Rig};
use crate::views::sampling::output_map::{lens_rotation, pole, viewer_rotation};
use glam::{DMat3, DVec2, DVec3};
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_4, TAU};

/// Least distance of triangles from the lens, as a part of the dome's radius: nearer ones would
/// surround it.
const NEAR: f64 = 1e-3;
/// Approximate number of triangles that are measured.
const MEASURED: usize = 8192;

/// Returns the triangles of output `index` of `rig` with `density` cells along the edge of the
/// cube; none for outputs that are neither projectors with plain lenses nor equidistant
/// domemasters.
pub(in crate::correct) fn dome_facets(rig: &Rig, index: usize, sampler: &SurfaceSampler, density: u32) -> Facets {
    let Some(picture) = Picture::of(rig, &rig.outputs[index]) else { return Facets::default() };
    let cuts = picture.cuts(rig, index);
    let mut builder = Builder { sampler, picture, facets: Facets::default(), numbers: HashMap::new() };
    for triangle in inflated_cube(density, builder.picture.cube(rig), rig.dome.radius) {
        builder.add(&triangle, &cuts);
    }
    builder.facets.error = builder.measured();
    builder.facets
}

/// Returns the triangles of a cube whose faces are cut into `cells`² squares and inflated to a
/// sphere of a radius; the axes are those of the cube.
fn inflated_cube(cells: u32, axes: DMat3, radius: f64) -> impl Iterator<Item = [DVec3; 3]> {
    Face::ALL.into_iter().flat_map(move |face| {
        let rotation = axes * face.rotation();
        let corner = move |x: u32, y: u32| {
            let at = |index: u32| 2.0 * f64::from(index) / f64::from(cells) - 1.0;
            rotation * DVec3::new(at(x), at(y), -1.0).normalize() * radius
        };
        let places = (0..cells).flat_map(move |y| (0..cells).map(move |x| (x, y)));
        places.flat_map(move |(x, y)| {
            let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
            [[a, b, c], [a, c, d]]
        })
    })
}

/// Picture of the dome in an output; everything in dome axes.
enum Picture {
    Projector { pose: Pose, frustum: Frustum, sphere: Sphere, cap: Option<HalfSpace> },
    Circle { lens: Fisheye, rotation: DMat3, radius: f64 },
}

/// The planes by which triangles are cut.
struct Cuts {
    /// Half-spaces outside of which nothing is shown.
    clipped: Vec<HalfSpace>,
    /// Planes along which triangles are divided.
    split: Vec<HalfSpace>,
}

impl Picture {
    fn of(rig: &Rig, output: &Output) -> Option<Self> {
        match &output.kind {
            OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } => Some(Self::Projector {
                pose: Pose::new(*position, *yaw, *pitch, *roll),
                frustum: *frustum,
                sphere: Sphere { center: DVec3::ZERO, radius: rig.dome.radius },
                cap: (rig.dome.coverage < TAU).then(|| HalfSpace {
                    normal: pole(rig),
                    offset: (0.5 * rig.dome.coverage).cos() * rig.dome.radius,
                }),
            }),
            OutputKind::Domemaster { aperture, tilt } => Some(Self::Circle {
                lens: Fisheye { aperture: *aperture },
                rotation: viewer_rotation(rig) * lens_rotation(*tilt),
                radius: rig.dome.radius,
            }),
            _ => None,
        }
    }

    /// Returns the rotation from the cube's axes to dome axes. In a domemaster an edge of the cube
    /// points forward, so that the rim of 180° goes along diagonals.
    fn cube(&self, rig: &Rig) -> DMat3 {
        match self {
            Self::Projector { .. } => viewer_rotation(rig),
            Self::Circle { rotation, .. } => *rotation * pose::rotation(FRAC_PI_4, 0.0, 0.0),
        }
    }

    fn cuts(&self, rig: &Rig, index: usize) -> Cuts {
        match self {
            Self::Circle { lens, rotation, radius } => {
                let rim = HalfSpace { normal: -rotation.z_axis, offset: (0.5 * lens.aperture).cos() * radius };
                Cuts { clipped: vec![rim], split: Vec::new() }
            }
            Self::Projector { pose, frustum, sphere, cap } => {
                let axis = -pose.rotation.z_axis;
                let near = HalfSpace::through(pose.position + axis * (NEAR * sphere.radius), axis);
                let own_sides = sides(pose, frustum, 1.0);
                let clipped = own_sides.into_iter().chain([near]).chain(*cap).collect();
                let own = &rig.outputs[index];
                let mut split = Vec::new();
                for output in rig.outputs.iter().filter(|_| own.blend.overlap) {
                    let Some((pose, frustum)) = pinhole(output) else { continue };
                    // A ramp ends at this part of the picture's half; wider ones have a crease in
                    // the middle.
                    let inner = (1.0 - 2.0 * EdgeWeight::of(&output.blend).width).abs().min(1.0);
                    split.extend(sides(&pose, &frustum, inner));
                    if !std::ptr::eq(output, own) {
                        split.extend(sides(&pose, &frustum, 1.0));
                    }
                }
                Cuts { clipped, split }
            }
        }
    }

    /// Returns the place of a point in the output's circle or picture, −1…1 from the left and from
    /// the bottom, and the dome's point there.
    fn place(&self, point: DVec3) -> (DVec2, DVec3) {
        match self {
            Self::Circle { lens, rotation, radius } => {
                (lens.point(rotation.transpose() * point), point.normalize_or_zero() * *radius)
            }
            Self::Projector { pose, frustum, sphere, .. } => {
                let ray = point - pose.position;
                let picture = frustum.picture() * pose.direction_to_local(ray);
                (picture.truncate() / picture.z, sphere.far_hit(pose.position, ray).unwrap_or(point))
            }
        }
    }

    /// True if light that goes to a triangle meets its inner side.
    fn lights(&self, [a, b, c]: &[DVec3; 3]) -> bool {
        let Self::Projector { pose, .. } = self else { return true };
        let normal = (*b - *a).cross(*c - *a);
        // The inner side is the one of the dome's centre.
        (pose.position - *a).dot(normal) * -a.dot(normal) > 0.0
    }
}

/// Returns the position and the opening of a projector with a plain lens.
fn pinhole(output: &Output) -> Option<(Pose, Frustum)> {
    match &output.kind {
        OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } => {
            Some((Pose::new(*position, *yaw, *pitch, *roll), *frustum))
        }
        OutputKind::Optics { optics, .. } if optics.mirror.is_none() => match &optics.lens {
            Lens::Pinhole { frustum, .. } => Some((optics.pose, *frustum)),
            Lens::Fisheye { .. } => None,
        },
        _ => None,
    }
}

/// Returns the planes through a lens along the sides of the inner `part` of its picture, inwards.
fn sides(pose: &Pose, frustum: &Frustum, part: f64) -> [HalfSpace; 4] {
    let ((x, y), (half_x, half_y)) = (frustum.middle(), frustum.half_size());
    let (left, right) = (x - part * half_x, x + part * half_x);
    let (bottom, top) = (y - part * half_y, y + part * half_y);
    [
        DVec3::new(1.0, 0.0, left),
        DVec3::new(-1.0, 0.0, -right),
        DVec3::new(0.0, 1.0, bottom),
        DVec3::new(0.0, -1.0, -top),
    ]
    .map(|normal| HalfSpace::through(pose.position, pose.direction_to_parent(normal)))
}

/// Collects the triangles of one output.
struct Builder<'a> {
    sampler: &'a SurfaceSampler<'a>,
    picture: Picture,
    facets: Facets,
    /// Corners by the bits of their points.
    numbers: HashMap<[u64; 3], Option<u32>>,
}

impl Builder<'_> {
    fn add(&mut self, triangle: &[DVec3; 3], cuts: &Cuts) {
        if !self.picture.lights(triangle) {
            return;
        }
        let mut polygon = triangle.to_vec();
        for plane in &cuts.clipped {
            polygon = plane.clip(&polygon);
            if polygon.is_empty() {
                return;
            }
        }
        let mut parts = vec![polygon];
        for plane in &cuts.split {
            parts = parts.into_iter().flat_map(|part| plane.split(part)).collect();
        }
        for part in parts {
            let numbers: Option<Vec<u32>> = part.iter().map(|&point| self.number(point)).collect();
            let Some(numbers) = numbers else { continue };
            let fan = numbers.windows(2).skip(1).map(|pair| [numbers[0], pair[0], pair[1]]);
            self.facets.triangles.extend(fan);
        }
    }

    /// Returns the number of the corner at a point; `None` if the viewer is at that point.
    fn number(&mut self, point: DVec3) -> Option<u32> {
        let (sampler, picture, facets) = (self.sampler, &self.picture, &mut self.facets);
        *self.numbers.entry(point.to_array().map(f64::to_bits)).or_insert_with(|| {
            let (place, hit) = picture.place(point);
            let sample = SurfaceSample { vector: sampler.vector(hit)?, weight: sampler.weight(hit) };
            Some(facets.push(pixel(sampler, picture, place), sample))
        })
    }

    /// Returns the greatest error of some triangles, in their middles and those of their sides,
    /// pixels.
    fn measured(&self) -> f64 {
        let step = (self.facets.triangles.len() / MEASURED).max(1);
        let (width, height) = self.sampler.size();
        let mut worst = 0.0f64;
        for triangle in self.facets.triangles.iter().step_by(step) {
            let corners = triangle.map(|number| self.facets.corners[number as usize]);
            for parts in [[1.0 / 3.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]] {
                let mut place = DVec2::ZERO;
                let mut direction = DVec3::ZERO;
                for (part, corner) in parts.iter().zip(&corners) {
                    place += corner.place * *part;
                    direction += corner.direction * *part;
                }
                let inside =
                    place.cmpgt(DVec2::ZERO).all() && place.x < f64::from(width) && place.y < f64::from(height);
                if inside && let Some(error) = self.sampler.error(place, direction) {
                    worst = worst.max(error);
                }
            }
        }
        worst
    }
}

/// Returns the pixel position of a place in the output.
fn pixel(sampler: &SurfaceSampler, picture: &Picture, place: DVec2) -> DVec2 {
    let (width, height) = (f64::from(sampler.size().0), f64::from(sampler.size().1));
    let half = match picture {
        Picture::Circle { .. } => DVec2::splat(0.5 * width.min(height)),
        Picture::Projector { .. } => 0.5 * DVec2::new(width, height),
    };
    DVec2::new(0.5 * width + place.x * half.x, 0.5 * height - place.y * half.y)
}
