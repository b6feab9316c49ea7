//! The planner against brute force: every pixel, random rigs, and the bars of the design.

use super::*;
use crate::rig::*;
use glam::DVec3;
use std::f64::consts::PI;

pub(crate) fn rig(outputs: Vec<Output>) -> Rig {
    Rig {
        name: "test".into(),
        passthrough: false,
        dome: Dome { radius: 5.0, tilt: 0.0, coverage: 2.0 * PI },
        viewer: Viewer { position: DVec3::ZERO, yaw: 0.0, pitch: 0.0, roll: 0.0 },
        camera: Camera { zoom: 1.0, shift: DVec3::ZERO, yaw: 0.0, pitch: 0.0, roll: 0.0 },
        views: Views { method: ViewMethod::Auto, quality: 1.0 },
        overlay: Overlay { yaw: 0.0, pitch: 0.0, width: 1.0 },
        outputs,
    }
}

pub(crate) fn output(name: &str, kind: OutputKind) -> Output {
    let blend = Blend { overlap: false, ramp: 0.2, ramps: Vec::new(), gamma: 2.2, black_level: 0.0 };
    Output { name: name.into(), kind, size: None, window: None, blend, mask: None }
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

fn texels(plan: &ViewPlan) -> f64 {
    plan.views.iter().map(|view| f64::from(view.tile.width) * f64::from(view.tile.height)).sum()
}

#[test]
fn the_fisheye_preset_needs_four_views_and_little_more_than_its_disc() {
    for size in [512, 1024, 2048, 4096] {
        let start = std::time::Instant::now();
        let plan = plan(&rig(vec![fisheye(180.0, 90.0)]), &request(&[(size, size)])).unwrap();
        println!("planned in {:?}", start.elapsed());
        let ratio = texels(&plan) / (0.25 * PI * f64::from(size) * f64::from(size));
        println!("{size}: {} views, {ratio:.4} of the disc, atlas {:?}", plan.views.len(), plan.atlas);
        for view in &plan.views {
            println!("   {} {:?} {:?}", view.name, view.tile, view.frustum);
        }
        assert!(plan.views.len() <= 5);
        assert!(ratio <= 2.15, "{ratio}");
    }
}

#[test]
fn a_projector_off_the_centre_needs_one_tight_view() {
    for (position, degrees) in [
        (DVec3::new(0.0, 0.0, 3.0), [0.0; 3]),
        (DVec3::new(0.0, 0.0, -3.0), [0.0; 3]),
        (DVec3::new(3.0, 0.0, 0.0), [0.0; 3]),
    ] {
        let rig = rig(vec![projector("p", position, degrees, lens(60.0, 40.0))]);
        let plan = plan(&rig, &request(&[(1920, 1080)])).unwrap();
        let ratio = texels(&plan) / (1920.0 * 1080.0);
        println!("{position}: {ratio:.4} {:?}", plan.views);
        assert_eq!(plan.views.len(), 1);
        assert!(ratio <= 1.7, "{ratio}");
    }
}
