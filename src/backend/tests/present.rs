//! Presented pictures, compared with pictures computed in f64.

use super::Driver;
use super::picture::Picture;
use super::plans::*;
use crate::correct::Plan;
use crate::correct::{Mask, PixelRect, Source};
use crate::geom::{Frustum, Pose};
use crate::rig::{AngleRamp, DomeAngle, RampShape};
use crate::testing::random::Random;
use crate::views::{Tile, View};
use glam::{DMat3, DVec3};

/// Returns waves that a bilinear filter follows closely, different in each channel.
pub fn waves(size: (u32, u32)) -> Picture {
    Picture::new(size, |x, y| {
        let wave = |a: f64, b: f64| (127.5 + 120.0 * (a * f64::from(x) + b * f64::from(y)).sin()) as u8;
        [wave(0.05, 0.02), wave(-0.03, 0.06), wave(0.02, -0.045), 255]
    })
}

pub fn noise(size: (u32, u32)) -> Picture {
    let random = std::cell::RefCell::new(Random::new(3));
    Picture::new(size, |_, _| std::array::from_fn(|_| (random.borrow_mut().unit() * 256.0) as u8))
}

/// Returns the place in the atlas, in texels, of `direction` in the first view that shows it.
pub fn place(views: &[View], direction: DVec3) -> Option<(f64, f64)> {
    views.iter().find_map(|view| {
        let v = view.rotation * direction;
        let (x, y) = (v.x / -v.z, v.y / -v.z);
        (v.z < 0.0 && view.owned.contains(x, y)).then(|| {
            let tile = view.tile;
            let column = (x - view.frustum.left) / view.frustum.width() * f64::from(tile.width);
            let row = (y - view.frustum.bottom) / view.frustum.height() * f64::from(tile.height);
            (f64::from(tile.x) + column, f64::from(tile.y) + row)
        })
    })
}

/// Returns the greatest difference in codes between the picture `shown` and `exact` (encoded 0…1 of
/// a pixel, row 0 at the top).
pub fn worst(shown: &Picture, exact: impl Fn(u32, u32) -> Option<[f64; 3]>) -> f64 {
    let mut worst = 0.0f64;
    for row in 0..shown.size.1 {
        for column in 0..shown.size.0 {
            let Some(exact) = exact(column, row) else { continue };
            let pixel = shown.at(column, shown.size.1 - 1 - row);
            assert_eq!(pixel[3], 255);
            for k in 0..3 {
                worst = worst.max((f64::from(pixel[k]) - 255.0 * exact[k]).abs());
            }
        }
    }
    worst
}

fn rgb([r, g, b, _]: [f64; 4]) -> [f64; 3] {
    [r, g, b]
}

/// An output that shows the middle of a view 1:1.
pub fn one_to_one(size: (u32, u32)) -> Plan {
    let frustum = Frustum { left: -0.9, right: 0.8, bottom: -0.5, top: 0.7 };
    let tile = Tile { x: 13, y: 29, width: size.0, height: size.1 };
    let view = View {
        name: "program".into(),
        rotation: DMat3::IDENTITY,
        frustum,
        owned: frustum,
        tile,
        program_lens: true,
        curved: None,
        eye: 0.0,
    };
    let source = Source::Perspective { matrix: frustum.rays() };
    let views = view_plan(vec![view], (size.0 + 40, size.1 + 50));
    Plan { views, passes: vec![pass(size, source, vec![0], false)] }
}

pub fn a_picture_1_to_1_is_copied_exactly(driver: &dyn Driver) {
    let plan = one_to_one((317, 203));
    let atlas = noise(plan.views.atlas);
    let shown = driver.show(&plan, false, &atlas);
    for y in 0..203 {
        for x in 0..317 {
            assert_eq!(shown.at(x, y)[..3], atlas.at(13 + x, 29 + y)[..3], "{x}, {y}");
        }
    }
    // Negative control: shifted by half a texel the picture is filtered.
    let mut aside = plan.clone();
    aside.passes[0].source = Source::Perspective {
        matrix: DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(0.5 * 1.7 / 317.0, 0.0, 1.0))
            * Frustum { left: -0.9, right: 0.8, bottom: -0.5, top: 0.7 }.rays(),
    };
    assert_ne!(driver.show(&aside, false, &atlas), shown);
}

pub fn a_fisheye_shows_the_world_and_black_around_it(driver: &dyn Driver) {
    let size = (400, 360);
    let mut plan = fisheye_plan(size, 3.4, DVec3::new(0.1, -0.2, 0.3));
    // The corners are in no batch, the rest is in two.
    plan.passes[0].batches[0].rects = vec![
        PixelRect { x: 20, y: 0, width: 200, height: 360 },
        PixelRect { x: 220, y: 0, width: 160, height: 180 },
        PixelRect { x: 220, y: 180, width: 160, height: 180 },
    ];
    let atlas = waves(plan.views.atlas);
    let shown = driver.show(&plan, false, &atlas);
    let exact = |c, r| match fisheye_direction(&plan, size, c, r) {
        None => Some([0.0; 3]),
        Some(direction) => {
            let (x, y) = place(&plan.views.views, direction)?;
            Some(rgb(atlas.bilinear(x, y)))
        }
    };
    // Near a seam either view may be sampled; here they show unrelated waves.
    let seam = |c: u32, r: u32| {
        let Some(direction) = fisheye_direction(&plan, size, c, r) else { return false };
        let here = place(&plan.views.views, direction);
        [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z].into_iter().any(|axis| {
            match (here, place(&plan.views.views, direction + 2e-3 * axis)) {
                (Some(a), Some(b)) => (a.0 - b.0).hypot(a.1 - b.1) > 3.0,
                _ => true,
            }
        })
    };
    let found = worst(&shown, |c, r| if seam(c, r) { None } else { exact(c, r) });
    assert!(found <= 1.6, "{found}");
    assert_eq!(shown.at(0, 0), [0, 0, 0, 255]);
    // Negative control: upside down it is another picture.
    assert!(worst(&shown, |c, r| exact(c, size.1 - 1 - r)) > 50.0);
}

pub fn mask_ramps_black_level_and_response(driver: &dyn Driver) {
    let size = (200, 160);
    let mut plan = fisheye_plan(size, 3.0, DVec3::ZERO);
    let pole = Pose::new(DVec3::ZERO, 0.0, 1.2, 0.0).rotation;
    let pass = &mut plan.passes[0];
    pass.gamma = 1.8;
    pass.black_level = 0.02;
    pass.dome_rotation = pole;
    pass.ramps = vec![
        AngleRamp { angle: DomeAngle::Polar, zero: 1.9, full: 0.6, shape: RampShape::Smoothstep },
        AngleRamp { angle: DomeAngle::Azimuth, zero: -2.0, full: 0.5, shape: RampShape::Smoothstep },
    ];
    let weights: Vec<u16> = (0..size.0 * size.1).map(|i| (i * 2_011 % 65_536) as u16).collect();
    pass.mask = Some(Mask { width: size.0, height: size.1, weights: weights.clone() });
    let atlas = Picture::new(plan.views.atlas, |_, _| [255, 128, 64, 255]);
    let shown = driver.show(&plan, false, &atlas);
    let smooth = |t: f64| t.clamp(0.0, 1.0).powi(2) * (3.0 - 2.0 * t.clamp(0.0, 1.0));
    let exact = |c: u32, r: u32| {
        let Some(direction) = fisheye_direction(&plan, size, c, r) else { return Some([0.0; 3]) };
        let dome = pole * direction;
        let (polar, azimuth) = (dome.x.hypot(dome.z).atan2(dome.y), dome.x.atan2(-dome.z));
        let mask = f64::from(weights[(r * size.0 + c) as usize]) / 65535.0;
        let weight = mask * smooth((polar - 1.9) / (0.6 - 1.9)) * smooth((azimuth + 2.0) / 2.5);
        let black = 0.02f64.powf(1.0 / 1.8);
        Some([255.0, 128.0, 64.0].map(|c| black + (1.0 - black) * c / 255.0 * weight.powf(1.0 / 1.8)))
    };
    let found = worst(&shown, exact);
    // Half floats in OpenGL ES without 16-bit textures cost a tenth of a code.
    assert!(found <= 0.75, "{found}");
    assert!(worst(&shown, |c, r| exact(c, size.1 - 1 - r)) > 50.0, "the mask's rows are turned over");
}

pub fn the_panel_lies_over_the_scene(driver: &dyn Driver) {
    let size = (240, 240);
    for one_view in [false, true] {
        let mut plan = if one_view {
            projector_plan(&Projector::at(0.3), &[], size)
        } else {
            fisheye_plan(size, 3.0, DVec3::ZERO)
        };
        let frustum = Frustum { left: -0.5, right: 0.5, bottom: -0.3, top: 0.3 };
        let tile = Tile { x: 0, y: plan.views.atlas.1, width: 128, height: 96 };
        plan.views.atlas.1 += 100;
        let rotation = Pose::new(DVec3::ZERO, 0.3, 0.1, 0.1).rotation.transpose();
        let panel = View {
            name: "panel".into(),
            rotation,
            frustum,
            owned: frustum,
            tile,
            program_lens: true,
            curved: None,
            eye: 0.0,
        };
        plan.views.panel = Some(panel.clone());
        let scene_height = plan.views.atlas.1 - 100;
        let scene = waves(plan.views.atlas);
        // Premultiplied: no channel is above alpha.
        let atlas = Picture::new(plan.views.atlas, |x, y| {
            let alpha = ((x * 2) % 256) as u8;
            if y < scene_height { scene.at(x, y) } else { [alpha / 2, 0, alpha, alpha] }
        });
        let direction = |c, r| {
            if one_view {
                let (x, y) = normalised(size, c, r);
                let viewer = viewer();
                Projector::at(0.3).hit(x, y).map(|hit| viewer.rotation.transpose() * (hit - viewer.position))
            } else {
                fisheye_direction(&plan, size, c, r)
            }
        };
        let exact = |c, r, with: bool| {
            let direction = direction(c, r)?;
            let (x, y) = place(&plan.views.views, direction)?;
            let below = atlas.bilinear(x, y);
            let Some((x, y)) = place(std::slice::from_ref(&panel), direction).filter(|_| with) else {
                return Some(rgb(below));
            };
            // The test leaves out places where the filter would reach beyond the tile, and where
            // alpha jumps.
            if !(1.0..127.0).contains(&x)
                || (x as u32).abs_diff(127) < 2
                || y - f64::from(tile.y) < 1.0
                || y - f64::from(tile.y) > 95.0
            {
                return None;
            }
            let above = atlas.bilinear(x, y);
            Some(std::array::from_fn(|k| above[k] + (1.0 - above[3]) * below[k]))
        };
        let shown = driver.show(&plan, true, &atlas);
        let wrong = |shown: &Picture, with| {
            let mut wrong = 0;
            for row in 0..size.1 {
                for column in 0..size.0 {
                    let Some(exact) = exact(column, row, with) else { continue };
                    let pixel = shown.at(column, size.1 - 1 - row);
                    wrong += usize::from((0..3).any(|k| (f64::from(pixel[k]) - 255.0 * exact[k]).abs() > 2.0));
                }
            }
            wrong
        };
        // The exceptions are pixels on seams of the views and on the panel's border.
        assert!(wrong(&shown, true) < 60, "{}", wrong(&shown, true));
        assert!(wrong(&shown, false) > 500, "the panel is not there");
        let without = driver.show(&plan, false, &atlas);
        assert!(wrong(&without, false) < 60);
    }
}
