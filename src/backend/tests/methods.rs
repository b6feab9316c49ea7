//! Tables and meshes as methods of outputs: their maps stay within the requested error, and their
//! weights are those of the default method.

use super::{Driver, rigs};
use crate::correct::shaders::map::MapPixel;
use crate::correct::{Plan, Source};
use crate::rig::{Method, Rig};
use crate::warp::MapError;
use glam::{DVec2, DVec3};
use std::sync::Arc;

const SIZE: (u32, u32) = (320, 200);

const FISHEYE: &str = "[dome]\ntilt = 90.0\n[[output]]\nkind = \"domemaster\"\n";
/// A rim, a viewer off the centre, and ramps in dome angles.
const OFF_CENTRE: &str = "[dome]\ntilt = 40.0\ncoverage = 190.0\n[viewer]\nposition = [1.0, 0.5, -0.8]\nyaw = 20.0\n\
    [[output]]\nkind = \"domemaster\"\naperture = 220.0\n\
    [output.blend]\nramps = [{ angle = \"polar\", zero = 100.0, full = 40.0 }]\n";
/// Three overlapping pictures. The screen's rim crosses the first one.
const OVERLAP: &str = "[dome]\ntilt = 60.0\ncoverage = 150.0\n[viewer]\nposition = [0.3, -0.4, 0.2]\n\
    [[output]]\nkind = \"projector\"\nposition = [0.0, 0.0, 3.0]\npitch = -8.0\nroll = 4.0\nfov = [60.0, 40.0]\n\
    [[output]]\nkind = \"projector\"\nposition = [0.0, 0.0, 3.0]\nyaw = 30.0\nfov = [60.0, 40.0]\n\
    [[output]]\nkind = \"projector\"\nposition = [1.0, 0.0, 2.0]\npitch = 25.0\nfov = [60.0, 40.0]\n\
    [output.blend]\nramp = 0.15\n";
/// From outside the dome, whose outline is in the picture.
const OUTSIDE: &str = "[dome]\ntilt = 90.0\ncoverage = 170.0\n[[output]]\nkind = \"projector\"\nposition = [1.0, 0.0, 20.0]\nyaw = -2.0\n\
    fov = [32.0, 22.0]\n";
/// A lens without a closed formula.
const LENS: &str = "[screen]\nshape = \"cylinder\"\nradius = 4.0\nheights = [-1.0, 2.0]\nazimuth = [-70.0, 60.0]\n\
    [[output]]\nkind = \"projector\"\nposition = [0.0, 0.5, 1.0]\nfov = [100.0, 70.0]\ndistortion = { radial = [-0.05, 0.0, 0.0] }\n";
/// A window, which has no place on the dome.
const WINDOW: &str =
    "[[output]]\nkind = \"perspective\"\nyaw = 20.0\nroll = 10.0\nfov = [80.0, 60.0]\nshift = [0.1, 0.0]\n";

fn planned(text: &str, method: &str) -> (Rig, Arc<Plan>) {
    let rig = rigs::read(text).with_method_override(method).expect("a method for it");
    let plan = rigs::planned(&rig, SIZE);
    (rig, plan)
}

/// Returns the error of an output on a driver, and the weight of each pixel.
fn shown(driver: &dyn Driver, rig: &Rig, plan: &Plan, output: usize) -> (MapError, Vec<Option<f32>>) {
    let exact = rigs::exact(rig, output, SIZE);
    let map = driver.map(plan, output);
    let at = |x: u32, y: u32| &map[(y * SIZE.0 + x) as usize];
    let direction = |pixel: &MapPixel| pixel.view.map(|_| DVec3::from_array(pixel.direction.map(f64::from)));
    let error = exact.compare(1, |x, y| direction(at(x, y)));
    // Negative control: a map that is one pixel off.
    let moved = exact.compare(7, |x, y| direction(at((x + 1).min(SIZE.0 - 1), y)));
    assert!(moved.compared > 150 && moved.max > 0.9, "{:?}: {moved:?}", rig.outputs[output].method);
    for pixel in &map {
        let Some(view) = pixel.view.map(|index| &plan.views.views[index]) else { continue };
        let local = view.rotation * DVec3::from_array(pixel.direction.map(f64::from));
        let at = local.truncate() / -local.z;
        let (frustum, tile) = (&view.frustum, &view.tile);
        let half_texel =
            0.5 * DVec2::new(frustum.width() / f64::from(tile.width), frustum.height() / f64::from(tile.height));
        let low = DVec2::new(frustum.left, frustum.bottom) + half_texel * 0.99;
        let high = DVec2::new(frustum.right, frustum.top) - half_texel * 0.99;
        let inside = at.cmpge(low).all() && at.cmple(high).all();
        assert!(inside, "{:?}: {at} of {frustum:?} has neighbours that no view draws", rig.outputs[output].method);
    }
    (error, map.iter().map(|pixel| pixel.view.map(|_| pixel.weight)).collect())
}

/// Returns the greatest and the root mean square difference of weights where both show something.
fn weight_errors(found: &[Option<f32>], expected: &[Option<f32>]) -> (f64, f64) {
    let both = found.iter().zip(expected).filter_map(|(a, b)| Some(f64::from(((*a)? - (*b)?).abs())));
    let (most, sum, count) = both.fold((0.0f64, 0.0, 0.0), |(m, s, n), e| (m.max(e), s + e * e, n + 1.0));
    (most, (sum / f64::max(count, 1.0)).sqrt())
}

/// Returns the number of entries or triangles of a plan's first output.
fn parts(plan: &Plan) -> usize {
    match &plan.passes[0].source {
        Source::Table(table) if plan.passes[0].batches[0].facets.is_none() => {
            table.entries().0 as usize * table.entries().1 as usize
        }
        _ => plan.passes[0].batches.iter().flat_map(|batch| &batch.facets).map(|f| f.triangles.len()).sum(),
    }
}

pub fn tables_and_meshes_err_by_no_more_than_was_asked(driver: &dyn Driver) {
    for text in [FISHEYE, OFF_CENTRE, OVERLAP, OUTSIDE, LENS, WINDOW] {
        let (rig, plan) = planned(text, "fragment");
        let (_, expected) = shown(driver, &rig, &plan, 0);
        // Negative control: where there are ramps, weights that are one pixel off are seen.
        let (moved, _) = weight_errors(&expected[1..], &expected);
        assert!(!text.contains("blend") || moved > 1.1e-3, "{text}: {moved}");
        for name in ["table", "mesh"] {
            let mut sizes = Vec::new();
            for bound in [0.5, 0.05] {
                let (rig, plan) = planned(text, &format!("{name},max_error={bound}"));
                let (error, weights) = shown(driver, &rig, &plan, 0);
                let (wrong, _) = weight_errors(&weights, &expected);
                println!("{name} {bound}: {} parts, weights {wrong:.1e}, {error:?}", parts(&plan));
                assert!(error.is_sound() && error.compared > 10_000, "{text}, {name}: {error:?}");
                // The addition is for the rounding of the corners' positions, and of f32.
                assert!(error.max <= bound + 0.004, "{text}, {name}, {bound}: {error:?}");
                assert!(wrong <= 1.1e-3, "{text}, {name}: {wrong}");
                sizes.push(parts(&plan));
                // For a fisheye, neither a table nor a mesh is much more exact than requested.
                assert!(text != FISHEYE || error.max >= 0.1 * bound, "{name}, {bound}: {error:?}");
            }
            let fewer = if text == WINDOW { sizes[0] == sizes[1] } else { sizes[0] <= sizes[1] };
            assert!(fewer, "{text}, {name}: {sizes:?}");
        }
    }
}

pub fn a_mesh_of_the_dome_is_four_times_as_exact_with_half_the_cells(driver: &dyn Driver) {
    for (text, uncovered) in [(FISHEYE, 400), (OVERLAP, 200), (OUTSIDE, 600)] {
        let (rig, plan) = planned(text, "fragment");
        let (_, expected) = shown(driver, &rig, &plan, 0);
        let mut errors = Vec::new();
        for density in [16, 32, 64] {
            let (rig, plan) = planned(text, &format!("cube-mesh,density={density}"));
            assert_eq!(rig.outputs[0].method, Method::CubeMesh { density });
            let (error, weights) = shown(driver, &rig, &plan, 0);
            // Weights jump where borders of pictures cross, which triangles cannot follow.
            let (_, wrong) = weight_errors(&weights, &expected);
            println!("density {density}: {} parts, weights {wrong:.1e}, {error:?}", parts(&plan));
            assert!(error.non_finite == 0 && error.ghosts < uncovered, "{text}: {error:?}");
            assert!(error.compared > 10_000 && error.uncovered < uncovered, "{text}: {error:?}");
            errors.push((error.rms, wrong));
        }
        for pair in errors.windows(2) {
            assert!((2.5..6.0).contains(&(pair[0].0 / pair[1].0)), "{text}: {errors:?}");
        }
        assert!(errors[2].1 < 0.01 && errors[2].1 <= errors[0].1, "{text}: {errors:?}");
    }
}
