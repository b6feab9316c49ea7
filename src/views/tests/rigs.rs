//! Rigs for tests: builders of rigs and outputs, and random rigs.

use crate::geom::Frustum;
use crate::rig::*;
use crate::testing::random::Random;
use crate::views::Request;
use glam::DVec3;
use std::f64::consts::PI;

pub(crate) fn rig(outputs: Vec<Output>) -> Rig {
    Rig {
        name: "test".into(),
        passthrough: false,
        dome: Dome { radius: 5.0, tilt: 0.0, coverage: 2.0 * PI },
        screen: None,
        viewer: Viewer { position: DVec3::ZERO, yaw: 0.0, pitch: 0.0, roll: 0.0 },
        camera: Camera::default(),
        views: Views::default(),
        content: None,
        overlay: Overlay { yaw: 0.0, pitch: 0.0, width: 1.0 },
        outputs,
        beside: Vec::new(),
        window: crate::rig::WindowSwaps::default(),
    }
}

pub(crate) fn output(name: &str, kind: OutputKind) -> Output {
    Output { blend: Blend { ramp: 0.2, ..Blend::default() }, ..crate::warp::testing::output(name, kind) }
}

pub(crate) fn fisheye(aperture_degrees: f64, tilt_degrees: f64) -> Output {
    output("dome", OutputKind::Domemaster { aperture: aperture_degrees.to_radians(), tilt: tilt_degrees.to_radians() })
}

pub(crate) fn lens(width_degrees: f64, height_degrees: f64) -> Frustum {
    Frustum::symmetric(width_degrees.to_radians(), height_degrees.to_radians())
}

pub(crate) fn projector(name: &str, position: DVec3, degrees: [f64; 3], frustum: Frustum) -> Output {
    output(name, OutputKind::Projector { position, angles: degrees.map(f64::to_radians), frustum })
}

pub(crate) fn request(sizes: &[(u32, u32)]) -> Request {
    Request { output_sizes: sizes.to_vec(), window: (800, 600), panel: false, primary: false, max_atlas: 16384 }
}

/// Returns a rig of up to four outputs, with everything that the planner depends on.
pub(crate) fn random_rig(random: &mut Random) -> (Rig, Request) {
    let count = 1 + (random.unit() * 4.0) as usize;
    let mut rig = rig(Vec::new());
    rig.dome.radius = random.range(1.0, 20.0);
    rig.dome.tilt = random.range(0.0, PI / 2.0);
    if random.unit() < 0.6 {
        rig.dome.coverage = random.range(2.0, 5.5);
    }
    rig.viewer = Viewer {
        position: random.direction() * random.range(0.0, 0.5) * rig.dome.radius,
        yaw: random.range(-PI, PI),
        pitch: random.range(-1.0, 1.0),
        roll: random.range(-1.0, 1.0),
    };
    rig.views.quality = random.range(0.5, 2.0);
    rig.views.method = if random.unit() < 0.4 { ViewMethod::Cube } else { ViewMethod::Auto };
    rig.views.resolution = if random.unit() < 0.3 { Resolution::Full } else { Resolution::Nominal };
    let mut sizes = Vec::new();
    for index in 0..count {
        let name = format!("output-{index}");
        let frustum = lens(random.range(20.0, 80.0), random.range(15.0, 60.0))
            .shifted(random.range(-0.3, 0.3), random.range(-0.3, 0.3));
        let angles = [random.range(-PI, PI), random.range(-1.2, 1.2), random.range(-0.5, 0.5)];
        let kind = match (random.unit() * 4.0) as u32 {
            0 => OutputKind::Domemaster { aperture: random.range(1.0, 2.0 * PI), tilt: random.range(0.0, 2.0) },
            1 => OutputKind::Perspective { angles, frustum: Some(frustum) },
            _ => OutputKind::Projector {
                position: random.direction() * random.range(0.0, 0.9) * rig.dome.radius,
                angles,
                frustum,
            },
        };
        rig.outputs.push(output(&name, kind));
        sizes.push((random.range(20.0, 160.0) as u32, random.range(20.0, 120.0) as u32));
    }
    (rig, request(&sizes))
}
