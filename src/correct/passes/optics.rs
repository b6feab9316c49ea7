//! Fisheye projectors, and pinholes before a mirror, whose map has a formula.

use crate::correct::passes::tolerance::{ANGLE, OWN_PIXELS, PIXELS, REFERENCE};
use crate::geom::lenses::equidistant::RadialForm;
use crate::geom::screen::Bounds;
use crate::geom::{Lens, Quadric, Sphere};
use glam::{DAffine3, DMat3, DVec2, DVec3};

/// A fisheye projector, or a pinhole before a mirror, inside a quadric. All values are in the
/// surface's axes.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct OpticsSource {
    /// Place of the lens.
    pub position: DVec3,
    /// Lens axes → surface axes.
    pub rotation: DMat3,
    /// Path of the light as it leaves the projector.
    pub light: Light,
    /// Surface that the projector lights.
    pub quadric: Quadric,
    /// Part of the surface that is screen.
    pub bounds: Bounds,
    /// Maps a point of the screen to its vector from the viewer, in viewer axes.
    pub to_viewer: DAffine3,
    /// Maps a point of the screen to its vector from the dome's centre, with the pole on +y and the
    /// front on −z. For ramps in dome angles.
    pub to_dome: DAffine3,
}

/// Path of the light from a place of the picture (−1…1 from left to right and from bottom to top).
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum Light {
    /// Through a fisheye.
    Fisheye {
        /// Point of the unit disc → ray in lens axes.
        form: RadialForm,
        /// Point of the disc = picture·scale + offset.
        scale: DVec2,
        /// Offset; see `scale`.
        offset: DVec2,
    },
    /// Through a pinhole, then reflected by a mirror.
    Mirror {
        /// `(x, y, 1)` → ray in lens axes.
        rays: DMat3,
        /// The mirror, in the surface's axes.
        mirror: Sphere,
    },
}

impl Light {
    /// Returns the path for a lens whose picture is `aspect` times as wide as high. `None` unless
    /// it is a fisheye without a mirror, or a pinhole without distortion before a mirror. Also
    /// `None` for curves that polynomials do not fit.
    pub fn of(lens: &Lens, aspect: f64, mirror: Option<Sphere>) -> Option<Self> {
        match (lens, mirror) {
            (Lens::Pinhole { .. }, Some(mirror)) => lens.linear_rays().map(|rays| Self::Mirror { rays, mirror }),
            (Lens::Fisheye { lens, circle }, None) => {
                let offset = circle.to_disc(DVec2::ZERO, aspect);
                let scale = circle.to_disc(DVec2::ONE, aspect) - offset;
                Some(Self::Fisheye { form: RadialForm::of(lens)?, scale, offset })
            }
            _ => None,
        }
    }
}

/// Errors that are added to a ray, to estimate the effect of rounding.
#[derive(Clone, Copy, Debug, Default)]
struct Kick {
    /// Error of the ray's direction, which has unit length.
    ray: DVec3,
    /// Error of the ray's moment around the mirror's centre, divided by the radius and the ray's
    /// length; relative to its terms.
    moment: DVec3,
    /// Error of the reflected ray's direction.
    reflected: DVec3,
    /// Relative error of the distance to the screen.
    distance: f64,
    /// Error of the point, relative to its distance from the origin.
    point: DVec3,
}

/// Path of a ray to the screen.
struct RayPath {
    /// Depth of the start inside the surface, see [`Quadric::depth`], relative to its terms there.
    depth: f64,
    /// Distance from the mirror's outline, 0…1; 1 without a mirror.
    incidence: f64,
    /// End of the path.
    point: DVec3,
}

/// Light must start inside the surface scaled by this factor.
const INSIDE: f64 = 0.95;
/// Error of a vector's sum in f32 relative to its terms: about five half steps.
const STEP: f64 = 2.8e-7;
/// Number of places in each direction where the error is estimated.
const PLACES: u32 = 17;

impl OpticsSource {
    /// Returns the direction from the viewer at normalised coordinates, viewer axes, any length;
    /// `None` where nothing is shown.
    pub fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let point = self.hit(x, y).filter(|point| self.bounds.contain(*point))?;
        Some(self.to_viewer.transform_point3(point))
    }

    /// Returns the point of the surface, screen or not, where the light of a place ends.
    pub fn hit(&self, x: f64, y: f64) -> Option<DVec3> {
        self.path(x, y, Kick::default()).map(|path| path.point)
    }

    /// Returns the matrix that maps `(x, y, 1)` to the moment of the ray around a mirror's centre,
    /// in its radii.
    pub fn moment(&self, rays: &DMat3, mirror: &Sphere) -> DMat3 {
        let before = (self.position - mirror.center) / mirror.radius;
        let rays = self.rotation * *rays;
        DMat3::from_cols(before.cross(rays.x_axis), before.cross(rays.y_axis), before.cross(rays.z_axis))
    }

    /// Computes the path as the shader does.
    fn path(&self, x: f64, y: f64, kick: Kick) -> Option<RayPath> {
        let (mut ray, start, incidence);
        match &self.light {
            Light::Fisheye { form, scale, offset } => {
                let disc = DVec2::new(x, y) * *scale + *offset;
                if disc.length_squared() > 1.0 {
                    return None;
                }
                (ray, start, incidence) = (self.rotation * form.direction(disc) + kick.ray, self.position, 1.0);
            }
            Light::Mirror { rays, mirror } => {
                let (place, moment) = (DVec3::new(x, y, 1.0), self.moment(rays, mirror));
                ray = self.rotation * *rays * place;
                let length = ray.length();
                ray = ray / length + kick.ray;
                let terms =
                    DMat3::from_cols(moment.x_axis.abs(), moment.y_axis.abs(), moment.z_axis.abs()) * place.abs();
                let foot = ray.cross((moment * place + kick.moment * terms) / length);
                incidence = (1.0 - foot.length_squared()).sqrt();
                if incidence.is_nan() || incidence <= 0.0 {
                    return None;
                }
                let normal = foot - ray * incidence;
                ray += normal * (2.0 * incidence) + kick.reflected;
                start = mirror.center + normal * mirror.radius;
            }
        }
        let depth = self.quadric.depth(start);
        let along = self.quadric.product(start, ray);
        let reach = along + (along * along + self.quadric.product(ray, ray) * depth).max(0.0).sqrt();
        let point = start + ray * (depth / reach * (1.0 + kick.distance));
        let around = self.quadric.weights.abs().dot(start * start) + self.quadric.level;
        (reach > 0.0).then(|| RayPath { depth: depth / around, incidence, point: point + kick.point * point.length() })
    }

    /// Returns the source if f32 is exact enough for a picture of `size`, else `None`. Rounding may
    /// move directions by 0.002 pixels of a picture 4096 wide, or by 6·10⁻⁷ radians, whichever is
    /// more, but by at most a quarter of the picture's own pixels.
    pub fn settled(self, size: (u32, u32)) -> Option<Self> {
        let (width, height) = (f64::from(size.0.max(1)), f64::from(size.1.max(1)));
        // A pixel of the reference's size.
        let own = REFERENCE / width.max(height);
        let pixel = 2.0 / own / DVec2::new(width, height);
        let place = |i: u32| 2.0 * f64::from(i) / f64::from(PLACES - 1) - 1.0;
        let exact = (0..PLACES * PLACES)
            .map(|i| (place(i % PLACES), place(i / PLACES)))
            .all(|(x, y)| self.direction(x, y).is_none() || self.is_exact_at(x, y, pixel, own) == Some(true));
        (exact && self.is_sound()).then_some(self)
    }

    /// Tests whether rounding moves the content of a place only little; `None` if there is none at
    /// the place or around it. `pixel` is a pixel of the reference's size; `own` is the width of a
    /// pixel of the picture in such pixels.
    fn is_exact_at(&self, x: f64, y: f64, pixel: DVec2, own: f64) -> Option<bool> {
        let seen =
            |x: f64, y: f64, kick: Kick| self.path(x, y, kick).map(|path| self.to_viewer.transform_point3(path.point));
        let path = self.path(x, y, Kick::default())?;
        let exact = self.to_viewer.transform_point3(path.point);
        let angle = |moved: DVec3| exact.cross(moved).length().atan2(exact.dot(moved));
        let bounces = f64::from(u8::from(matches!(self.light, Light::Mirror { .. })));
        let kicks = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| {
            [
                Kick { ray: axis * STEP, ..Kick::default() },
                Kick { moment: axis * STEP, ..Kick::default() },
                Kick { reflected: axis * bounces * STEP / path.incidence, ..Kick::default() },
                Kick { point: axis * STEP, ..Kick::default() },
            ]
        });
        let along = Kick { distance: STEP / path.depth, ..Kick::default() };
        // Roundings are independent of each other.
        let squared = |kick: Kick| seen(x, y, kick).map_or(f64::INFINITY, angle).powi(2);
        let error = kicks.chain([along]).map(squared).sum::<f64>().sqrt();
        let step = |step: DVec2| {
            let there = |side: f64| seen(x + side * step.x, y + side * step.y, Kick::default());
            let (from, to) = (there(-0.5).or_else(|| there(0.0))?, there(0.5).or_else(|| there(0.0))?);
            Some(from.cross(to).length().atan2(from.dot(to)))
        };
        let (across, up) = (step(DVec2::new(pixel.x, 0.0))?, step(DVec2::new(0.0, pixel.y))?);
        let pixel = (0.5 * (across * across + up * up)).sqrt();
        let allowed = (PIXELS * pixel).max(ANGLE.min(OWN_PIXELS * pixel * own));
        Some(error <= allowed)
    }

    /// True if all light starts well inside the surface, and the whole picture looks towards the
    /// mirror. The formula would also find a mirror behind the lens.
    fn is_sound(&self) -> bool {
        let quadric = &self.quadric;
        match &self.light {
            Light::Fisheye { .. } => quadric.contains(self.position, INSIDE),
            // Uses the triangle inequality of the distance that the quadric defines.
            Light::Mirror { rays, mirror: Sphere { center, radius } } => {
                let towards = (self.rotation * *rays).transpose() * (*center - self.position);
                let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
                let ahead = corners.into_iter().all(|(x, y)| towards.dot(DVec3::new(x, y, 1.0)) > 0.0);
                let farthest = quadric.product(*center, *center).sqrt() + radius * quadric.weights.max_element().sqrt();
                ahead && quadric.is_convex() && farthest <= INSIDE * quadric.level.sqrt()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::passes::source::Source;
    use crate::correct::plan::builder::build;
    use crate::rig;
    use crate::views::Request;
    use crate::warp::WarpMap;
    use std::path::Path;

    const SIZE: (u32, u32) = (96, 72);

    fn source(text: &str) -> (rig::Rig, Source) {
        let rig = rig::parse(text, "optics.toml", Path::new("")).unwrap_or_else(|error| panic!("{}", error.message));
        let request = Request {
            output_sizes: vec![SIZE; rig.outputs.len()],
            window: SIZE,
            panel: false,
            primary: false,
            max_atlas: 16384,
        };
        let source = build(&rig, &request).expect("can be planned").passes.remove(0).source;
        (rig, source)
    }

    const FISHEYES: [&str; 3] = [
        "fisheye = { projection = \"equisolid\", aperture = 175, size = [1, 1.333], center = [0.1, 0.05] }",
        "fisheye = { projection = \"polynomial\", aperture = 150, coefficients = [1.0, -0.03, 0.001, 0.0] }",
        "fisheye = { projection = \"orthographic\", aperture = 150 }",
    ];
    const MIRROR: &str =
        "yaw = 180\npitch = 24\nfov = [23.65, 13.44]\nmirror = { center = [0, -0.92, 0.43], radius = 0.32 }";
    const SCREENS: [&str; 4] = [
        "[dome]\nradius = 1.5\ntilt = 90\n",
        "[screen]\nshape = \"sphere\"\nradius = 1.6\nazimuth = [-80, 140]\nposition = [0, 0.1, 0]\n",
        "[screen]\nshape = \"cylinder\"\nradius = 2\nheights = [-2, 2.5]\nazimuth = [-120, 110]\n",
        "[screen]\nshape = \"ellipsoid\"\nradii = [1.6, 2.0, 1.7]\n",
    ];

    /// Compared with the exact map, which traces rays independently.
    #[test]
    fn it_is_the_exact_map() {
        for screen in SCREENS {
            let fisheyes = FISHEYES.map(|fisheye| format!("position = [0.1, -0.3, 0.2]\npitch = 60\n{fisheye}"));
            let mirror = format!("position = [0, -1.29, -0.64]\n{MIRROR}");
            // With a mirror, f32 is exact enough for a viewer in the middle of a dome, but not
            // quite elsewhere.
            let with_viewer = |place: &str, lens: &str| {
                let viewer = format!("[viewer]\nposition = {place}\nyaw = 20\n");
                format!("{screen}{viewer}[[output]]\nkind = \"projector\"\n{lens}\n")
            };
            let before_mirror = [with_viewer("[0, 0, 0]", &mirror)].into_iter().filter(|_| screen.contains("[dome]"));
            for text in fisheyes.iter().map(|lens| with_viewer("[0.2, 0.1, -0.3]", lens)).chain(before_mirror) {
                let (rig, source) = source(&text);
                assert!(matches!(source, Source::Optics(_)), "{text}");
                let exact = WarpMap::new(&rig, 0, SIZE, None).expect("valid");
                let (mut lit, mut dark) = (0, 0);
                for (column, row) in (0..SIZE.1).flat_map(|row| (0..SIZE.0).map(move |column| (column, row))) {
                    let pixel = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
                    let (x, y) = source.normalised(SIZE, pixel.x, pixel.y);
                    match (exact.direction(pixel), source.direction(x, y)) {
                        (Some(exact), Some(found)) => {
                            // A polynomial is within a ten thousandth of a pixel of its lens.
                            assert!(exact.distance(found.normalize()) < 5e-7, "{text}{pixel}: {exact} {found}");
                            lit += 1;
                        }
                        (None, None) => dark += 1,
                        (exact, found) => panic!("{text}{pixel}: {exact:?} {found:?}"),
                    }
                }
                assert!(lit > 500 && dark > 100, "{text}{lit} {dark}");
            }
        }
    }

    #[test]
    fn what_has_no_formula_is_a_table() {
        let fisheye = format!("kind = \"projector\"\npitch = 60\n{}\n", FISHEYES[0]);
        let tables = [
            // Shared light; evened light; and below, a lens near the wall, and a plane as the
            // screen.
            format!("[[output]]\n{fisheye}[[output]]\n{fisheye}"),
            format!("[[output]]\n{fisheye}even_light = 0.5\n"),
            // Pixels of 2e-7 radians.
            "[[output]]\nkind = \"projector\"\npitch = 60\nfisheye = { aperture = 0.001 }\n".to_owned(),
            format!("[[output]]\nposition = [0, 0, 4.9]\n{fisheye}"),
            format!(
                "[screen]\nshape = \"plane\"\nsize = [8, 8]\nposition = [0, 3, 0]\npitch = 90\n[[output]]\n{fisheye}"
            ),
        ];
        for text in tables {
            assert!(matches!(source(&text).1, Source::Table(_)), "{text}");
        }
        assert!(matches!(source(&format!("[[output]]\n{fisheye}")).1, Source::Optics(_)), "the control");
    }
}
