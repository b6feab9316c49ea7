//! Plans made by hand, and their pictures, computed independently in f64.

use crate::blend::EdgeWeight;
use crate::correct::{Batch, EvaluationMethod, Neighbour, OutputPass, PixelRect, Plan, ProjectorSource, Source};
use crate::geom::screen::{Bounds, ClosedSurface};
use crate::geom::{Fisheye, Frustum, PinholeRays, Pose, Quadric, Sphere};
use crate::rig::Blend;
use crate::views::{Tile, View, ViewPlan};
use glam::{DMat3, DVec3};

pub const GUARD: u32 = 2;

/// Makes a view whose owned part is `owned`, with a guard around it.
pub fn view(name: &str, rotation: DMat3, owned: Frustum, tile: Tile) -> View {
    let inner = (f64::from(tile.width - 2 * GUARD), f64::from(tile.height - 2 * GUARD));
    let (dx, dy) = (f64::from(GUARD) * owned.width() / inner.0, f64::from(GUARD) * owned.height() / inner.1);
    let frustum =
        Frustum { left: owned.left - dx, right: owned.right + dx, bottom: owned.bottom - dy, top: owned.top + dy };
    View { name: name.into(), rotation, frustum, owned, tile, program_lens: false, curved: None, eye: 0.0 }
}

pub fn view_plan(views: Vec<View>, atlas: (u32, u32)) -> ViewPlan {
    let all = (0..views.len()).collect();
    ViewPlan {
        views,
        output_views: vec![all],
        atlas,
        panel: None,
        primary: None,
        guard: GUARD,
        sampling_margin: 0,
        notes: Vec::new(),
    }
}

/// Makes the views of a cube: front, right, left, up, down, back, `side` texels each, three in a
/// row.
pub fn cube_views(side: u32, turn: DMat3) -> ViewPlan {
    let angles = [(0.0, 0.0), (90.0, 0.0), (-90.0, 0.0), (0.0, 90.0), (0.0, -90.0), (180.0, 0.0)];
    let square = Frustum { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 };
    let views = angles
        .iter()
        .enumerate()
        .map(|(i, &(yaw, pitch)): (usize, &(f64, f64))| {
            let rotation =
                Pose::new(DVec3::ZERO, yaw.to_radians(), pitch.to_radians(), 0.0).rotation.transpose() * turn;
            let (column, row) = (i as u32 % 3, i as u32 / 3);
            let tile = Tile { x: column * side, y: row * side, width: side, height: side };
            view(&format!("face-{i}"), rotation, square, tile)
        })
        .collect();
    view_plan(views, (3 * side, 2 * side))
}

pub fn pass(size: (u32, u32), source: Source, views: Vec<usize>, edge: bool) -> OutputPass {
    let rects = vec![PixelRect { x: 0, y: 0, width: size.0, height: size.1 }];
    OutputPass {
        here: true,
        name: "output".into(),
        size,
        source,
        batches: vec![Batch { views, neighbours: Vec::new(), edge, masked: true, rects, facets: None }],
        mask: None,
        ramps: Vec::new(),
        dome_rotation: DMat3::IDENTITY,
        filter: crate::rig::Filter::Bilinear,
        gamma: 2.2,
        transfer: crate::rig::Transfer::Power,
        black_level: 0.0,
        black: None,
        lift: 0.0,
        dither: 0.0,
        flip: crate::rig::Flip::default(),
        content: None,
    }
}

/// Makes a fisheye picture over a cube of views, with the viewer at `-offset` radii.
pub fn fisheye_plan(size: (u32, u32), aperture: f64, offset: DVec3) -> Plan {
    let rotation = Pose::new(DVec3::ZERO, 0.3, -0.2, 0.1).rotation;
    let turn = Pose::new(DVec3::ZERO, 0.5, 0.4, 0.2).rotation;
    let side = (f64::from(size.0.min(size.1)) * 2.0 / aperture) as u32 + 2 * GUARD;
    let source = Source::Fisheye { aperture, rotation, offset };
    Plan { views: cube_views(side, turn), passes: vec![pass(size, source, (0..6).collect(), true)] }
}

/// Position and opening of a projector of the tests.
#[derive(Clone, Copy, Debug)]
pub struct Projector {
    pub pose: Pose,
    pub frustum: Frustum,
    pub ramp: f64,
}

impl Projector {
    /// A 60°×40° projector at `distance` radii behind the centre, aimed slightly aside.
    pub fn at(distance: f64) -> Self {
        let position = DVec3::new(0.2, -0.1, 0.97).normalize() * distance;
        let frustum = Frustum::symmetric(60f64.to_radians(), 40f64.to_radians()).shifted(0.05, 0.1);
        Self { pose: Pose::new(position, 0.2, 0.3, 0.05), frustum, ramp: 0.2 }
    }

    pub fn border(&self) -> EdgeWeight {
        EdgeWeight { width: self.ramp, ..EdgeWeight::of(&Blend::default()) }
    }

    pub fn rays(&self) -> DMat3 {
        self.pose.rotation * self.frustum.rays()
    }

    /// Returns the point at which the pixel's ray meets the unit sphere around the origin, far
    /// side.
    pub fn hit(&self, x: f64, y: f64) -> Option<DVec3> {
        // The usual quadratic formula, on purpose another form than the tested one.
        let (o, d) = (self.pose.position, self.rays() * DVec3::new(x, y, 1.0));
        let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - 1.0);
        if c > 1e3 {
            // From far away the formula loses digits, in f64 too.
            return Sphere { center: DVec3::ZERO, radius: 1.0 }.far_hit(o, d);
        }
        let discriminant = b * b - a * c;
        (discriminant >= 0.0).then(|| o + d * ((-b + discriminant.sqrt()) / a))
    }

    /// Returns the picture coordinates of a point, if it is in front.
    pub fn picture(&self, point: DVec3) -> Option<(f64, f64)> {
        let local = self.pose.rotation.transpose() * (point - self.pose.position);
        (local.z < 0.0).then(|| {
            let (x, y) = (local.x / -local.z, local.y / -local.z);
            let (cx, cy) = self.frustum.middle();
            let (hx, hy) = self.frustum.half_size();
            ((x - cx) / hx, (y - cy) / hy)
        })
    }

    pub fn source(&self, viewer: &Pose, others: &[Projector]) -> ProjectorSource {
        let surface = ClosedSurface::Quadric(Quadric::ellipsoid(DVec3::ONE));
        let pinhole = PinholeRays { origin: self.pose.position, rays: self.rays(), surface };
        let form = |eye, target| pinhole.seen_from(eye, target);
        let neighbours = others
            .iter()
            .enumerate()
            .map(|(output, other)| Neighbour {
                output,
                picture: form(other.pose.position, other.frustum.picture() * other.pose.rotation.transpose()),
                edge_weight: other.border(),
            })
            .collect();
        ProjectorSource {
            pinhole,
            direction: form(viewer.position, viewer.rotation.transpose()),
            bounds: Bounds::default(),
            rim: None,
            dome_direction: form(DVec3::ZERO, DMat3::IDENTITY),
            neighbours,
            edge_weight: self.border(),
            evaluation: EvaluationMethod::Forms,
        }
        .settled((1920, 1080))
        .expect("f32 is enough")
    }
}

/// The viewer of the projector tests: off the centre and turned.
pub fn viewer() -> Pose {
    Pose::new(DVec3::new(0.2, -0.3, 0.25), 0.1, 0.2, -0.05)
}

/// Makes one tight view of everything that a projector shows, and its pass.
pub fn projector_plan(projector: &Projector, others: &[Projector], size: (u32, u32)) -> Plan {
    let viewer = viewer();
    let seen: Vec<DVec3> = (0..=32)
        .flat_map(|i| (0..=32).map(move |j| (f64::from(i) / 16.0 - 1.0, f64::from(j) / 16.0 - 1.0)))
        .filter_map(|(x, y)| projector.hit(x, y))
        .map(|hit| (viewer.rotation.transpose() * (hit - viewer.position)).normalize())
        .collect();
    let axis = seen.iter().sum::<DVec3>().normalize();
    let right = axis.cross(DVec3::Y).normalize();
    let rotation = DMat3::from_cols(right, right.cross(axis), -axis).transpose();
    let mut owned = Frustum { left: 0.0, right: 0.0, bottom: 0.0, top: 0.0 };
    for direction in seen {
        let v = rotation * direction;
        let (x, y) = (v.x / -v.z, v.y / -v.z);
        owned.left = owned.left.min(x - 0.01);
        owned.right = owned.right.max(x + 0.01);
        owned.bottom = owned.bottom.min(y - 0.01);
        owned.top = owned.top.max(y + 0.01);
    }
    let tile = Tile { x: 40, y: 24, width: 5 * size.0 / 4, height: 5 * size.1 / 4 };
    let views = view_plan(vec![view("tight", rotation, owned, tile)], (tile.width + 80, tile.height + 100));
    let source = Source::Projector(Box::new(projector.source(&viewer, others)));
    let mut pass = pass(size, source, vec![0], false);
    pass.batches[0].neighbours = (0..others.len()).collect();
    Plan { views, passes: vec![pass] }
}

/// Returns the normalised coordinates of the centre of a pixel (row 0 at the top).
pub fn normalised(size: (u32, u32), column: u32, row: u32) -> (f64, f64) {
    let x = 2.0 * (f64::from(column) + 0.5) / f64::from(size.0) - 1.0;
    let y = 1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(size.1);
    (x, y)
}

/// Returns the exact direction of a fisheye pixel in viewer axes.
pub fn fisheye_direction(plan: &Plan, size: (u32, u32), column: u32, row: u32) -> Option<DVec3> {
    let Source::Fisheye { aperture, rotation, offset } = plan.passes[0].source else { return None };
    let (x, y) = normalised(size, column, row);
    let shorter = f64::from(size.0.min(size.1));
    let lens = Fisheye { aperture };
    let direction = lens.direction(x * f64::from(size.0) / shorter, y * f64::from(size.1) / shorter)?;
    Some((rotation * direction + offset).normalize())
}
