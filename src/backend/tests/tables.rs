//! Maps that come from a texture.

use super::Driver;
use super::picture::Picture;
use super::plans::*;
use super::rigs::{exact, planned, read};
use crate::blend::{Weights, code_of};
use crate::correct::{Plan, Source};
use crate::correct::{Table, TablePixel};
use crate::warp::WarpMap;
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Returns the table entry of a bent projector at a pixel: a narrow picture with a hole, and
/// weights.
fn shown(size: (u32, u32), opening: f64, column: u32, row: u32) -> Option<TablePixel> {
    let (x, y) = normalised(size, column, row);
    let direction = DVec3::new(opening * (x + 0.1 * y * y), opening * (y - 0.2 * x * y), -1.0);
    let hole = x * x + y * y < 0.01;
    (!hole).then(|| TablePixel {
        direction: viewer().rotation * direction * 3.0,
        weight: 0.25 + 0.25 * (x + 1.0),
        dark: 0.0,
    })
}

pub fn a_table_is_shown_as_it_was_computed(driver: &dyn Driver) {
    let size = (640, 400);
    // From a wide picture to one of two arc minutes, the error in pixels stays the same.
    for opening in [0.9, 0.01, 3e-4] {
        let table = Table::new(size, |column, row| shown(size, opening, column, row));
        assert!(table.is_weighted());
        let half = 1.5 * opening;
        let owned = crate::geom::Frustum { left: -half, right: half, bottom: -half, top: half };
        let tile = crate::views::Tile { x: 8, y: 4, width: 900, height: 900 };
        let views = view_plan(vec![view("one", viewer().rotation.transpose(), owned, tile)], (920, 910));
        let source = Source::Table(Arc::new(table));
        let plan = Plan { views, passes: vec![pass(size, source, vec![0], true)] };
        let map = driver.map(&plan, 0);
        let pixel = 2.0 * opening / f64::from(size.0);
        let mut wrong: f64 = 0.0;
        for (i, found) in map.iter().enumerate() {
            let (column, row) = (i as u32 % size.0, i as u32 / size.0);
            let expected = shown(size, opening, column, row);
            assert_eq!(expected.is_some(), found.view.is_some(), "{column} {row}");
            let Some(expected) = expected else { continue };
            // In view axes, where f64 keeps the angle even of the narrowest picture.
            let atlas = found.atlas.map(f64::from);
            let frustum = plan.views.views[0].frustum;
            let tangent = |atlas: f64, extent: f64, start: f64, low: f64, width: f64| {
                low + (atlas * extent - start) / 900.0 * width
            };
            let (x, y) = (
                tangent(atlas[0], 920.0, 8.0, frustum.left, frustum.width()),
                tangent(atlas[1], 910.0, 4.0, frustum.bottom, frustum.height()),
            );
            let exact = viewer().rotation.transpose() * expected.direction;
            let error = (exact.x / -exact.z - x).hypot(exact.y / -exact.z - y) / pixel;
            assert!(error < 0.002, "{opening}: {error} at {column}, {row}");
            assert!((f64::from(found.weight) - expected.weight).abs() < 1e-6);
            let neighbour = shown(size, opening, column ^ 1, row);
            let mirrored = neighbour.map_or(0.0, |n| (n.weight - f64::from(found.weight)).abs());
            wrong = wrong.max(mirrored);
        }
        assert!(wrong > 5e-4, "the neighbouring pixel is not taken for this one");
    }
}

/// Compares the outputs of a rig file with the exact map, pixel by pixel, through plan and shader.
/// `by_table`: outputs have tables or formulas of lenses; `None`: either, as f32 allows.
fn check_rig(driver: &dyn Driver, text: &str, size: (u32, u32), by_table: Option<bool>) {
    let rig = read(text);
    let plan = planned(&rig, size);
    for output in 0..rig.outputs.len() {
        match &plan.passes[output].source {
            Source::Table(_) => assert_ne!(by_table, Some(false), "{text}"),
            Source::Optics(_) => assert_ne!(by_table, Some(true), "{text}"),
            other => panic!("{text}: {other:?}"),
        }
        let exact = exact(&rig, output, size);
        let map = driver.map(&plan, output);
        let at = |x: u32, y: u32| &map[(y * size.0 + x) as usize];
        let direction = |x, y| at(x, y).view.map(|_| DVec3::from_array(at(x, y).direction.map(f64::from)));
        let error = exact.compare(1, direction);
        println!("{error:?}");
        assert!(error.is_sound() && error.compared > 5_000, "{text}: {error:?}");
        assert!(error.max < 0.002, "{text}: {error:?}");
        // Negative control: the map of the neighbouring pixel is noticed.
        let shifted = exact.compare(7, |x, y| direction((x + 1).min(size.0 - 1), y));
        assert!(shifted.compared > 100 && shifted.rms > 0.3, "{text}: {shifted:?}");
        // Every sample lies in the part of the atlas that its view draws.
        for pixel in &map {
            let Some(index) = pixel.view else { continue };
            let tile = &plan.views.views[index].tile;
            let (x, y) = (
                f64::from(pixel.atlas[0]) * f64::from(plan.views.atlas.0) - f64::from(tile.x),
                f64::from(pixel.atlas[1]) * f64::from(plan.views.atlas.1) - f64::from(tile.y),
            );
            let inside = x >= 0.5 && y >= 0.5 && x <= f64::from(tile.width) - 0.5 && y <= f64::from(tile.height) - 0.5;
            assert!(inside, "{text}: ({x}, {y}) of {tile:?}");
        }
    }
}

pub fn mirrors_and_lenses_show_what_the_exact_map_says(driver: &dyn Driver) {
    let idome = crate::rig::presets().iter().find(|preset| preset.name == "idome").expect("a preset").text;
    let (head, evened) = idome.split_once("even_light").expect("light that is evened out is in a table");
    let plain = format!("{head}#{evened}");
    check_rig(driver, idome, (640, 360), Some(true));
    check_rig(driver, &plain, (640, 360), Some(false));
    let projector = |lens: &str, viewer: &str| {
        format!(
            "[dome]\nradius = 4.0\ntilt = 60.0\n[viewer]\nposition = {viewer}\n\
             [[output]]\nkind = \"projector\"\nposition = [0.3, -0.5, 1.0]\npitch = 30.0\n{lens}\n"
        )
    };
    for viewer in ["[0.0, 0.0, 0.0]", "[0.8, -0.5, 0.7]", "[-2.0, 1.0, -0.8]"] {
        // The last viewer is too far from the centre for some formulas.
        let formula = if viewer.starts_with("[-2") { None } else { Some(false) };
        for projection in ["equidistant", "equisolid", "stereographic", "orthographic"] {
            let lens = format!("fisheye = {{ projection = \"{projection}\", aperture = 150.0 }}");
            check_rig(driver, &projector(&lens, viewer), (320, 240), formula);
            check_rig(driver, &projector(&format!("{lens}\neven_light = 1e-9"), viewer), (320, 240), Some(true));
        }
        let lens =
            "fisheye = { projection = \"polynomial\", aperture = 190.0, coefficients = [1.0, -0.03, 0.001, 0.0] }";
        check_rig(driver, &projector(lens, viewer), (320, 240), formula);
        let lens = "fov = [70.0, 50.0]\nshift = [0.0, 0.2]\n\
                    distortion = { radial = [-0.1, 0.02, 0.0], tangential = [0.002, -0.001] }";
        check_rig(driver, &projector(lens, viewer), (320, 240), Some(true));
    }
}

pub fn a_projector_that_looks_away_makes_no_ghosts(driver: &dyn Driver) {
    // The projector is outside, and half of its picture looks away. The closed form would find the
    // dome behind it.
    let text = "[dome]\nradius = 1.0\ncoverage = 360.0\n[[output]]\nkind = \"projector\"\n\
                position = [0.0, 0.0, 1.2]\nyaw = 70.0\nfov = [120.0, 90.0]\n";
    check_rig(driver, text, (320, 240), Some(true));
}

/// Two overlapping projectors with distorted lenses and grey blacks. Their pictures match f64, and
/// the sum of light and blacks is the same at every point.
pub fn blacks_are_evened_out_by_tables_too(driver: &dyn Driver) {
    let projector = |name: &str, yaw: f64, contrast: f64| {
        format!(
            "[[output]]\nname = \"{name}\"\nkind = \"projector\"\nyaw = {yaw:?}\npitch = 20.0\nfov = [70.0, 50.0]\n\
             distortion = {{ radial = [-0.05, 0.0, 0.0] }}\nblend = {{ contrast = {contrast:?}, ramp = 0.4 }}\n"
        )
    };
    let text = projector("left", -20.0, 60.0) + &projector("right", 20.0, 40.0);
    let rig = read(&text);
    let (size, sizes) = ((200, 120), [(200, 120); 2]);
    let plan = planned(&rig, size);
    let weights = Weights::new(&rig, &sizes).expect("valid");
    let most = weights.greatest_black();
    assert!((most - 1.0 / 60.0 - 1.0 / 40.0).abs() < 1e-12);
    let mut seen = [0, 0];
    for index in 0..2 {
        let one = Plan { views: plan.views.clone(), passes: vec![plan.passes[index].clone()] };
        assert!(matches!(one.passes[0].source, Source::Table(_)) && one.passes[0].lift > 0.0);
        let map = WarpMap::new(&rig, index, size, None).expect("a map");
        for white in [0.0, 1.0] {
            let code = (255.0 * white) as u8;
            let shown = driver.show(&one, false, &Picture::new(one.views.atlas, |_, _| [code, code, code, 255]));
            for (column, row) in (0..size.1).flat_map(|row| (0..size.0).map(move |column| (column, row))) {
                let pixel = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
                let Some(point) = map.hit(pixel) else { continue };
                let dark = weights.black_at(point);
                let light = weights.weight_at(index, point) * ((1.0 - most) * white + most - dark);
                let exact = 255.0 * code_of(light, &rig.outputs[index].blend, 0);
                let found = f64::from(shown.at(column, size.1 - 1 - row)[0]);
                assert!((found - exact).abs() <= 0.6, "white {white}, {column} {row}: {found} {exact}");
                seen[usize::from(most - dark > 1e-9)] += 1;
            }
        }
    }
    assert!(seen[0] > 1_000 && seen[1] > 1_000, "overlapped and alone: {seen:?}");
}
