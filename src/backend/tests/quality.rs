//! What the filters make of a scene with hard edges, against 64 samples per pixel, and that none reads beyond its tile.

use super::canvas::Picture;
use super::headless;
use super::present::show;
use crate::backend::gl::headless::{Api, Headless};
use crate::correct::Plan;
use crate::correct::plan::build;
use crate::rig::Filter;
use crate::views::tests::{fisheye, request, rig};
use glam::{DVec2, DVec3};

const SIZE: u32 = 512;

/// A checker in space: cells of about 43 pixels, black and white.
fn scene(direction: DVec3) -> f64 {
    let cell = direction.normalize() * 12.0;
    if cell.x.sin() * cell.y.sin() * cell.z.sin() > 0.0 { 1.0 } else { 0.0 }
}

/// A rotated grid of four places in a square of side 1.
const FOUR: [DVec2; 4] =
    [DVec2::new(0.125, 0.375), DVec2::new(-0.375, 0.125), DVec2::new(-0.125, -0.375), DVec2::new(0.375, -0.125)];

/// A fisheye picture's plan with views of `quality` and `filter`.
fn planned(quality: f64, filter: Filter) -> Plan {
    let mut rig = rig(vec![fisheye(180.0, 90.0)]);
    (rig.views.quality, rig.views.filter) = (quality, filter);
    build(&rig, &request(&[(SIZE, SIZE)])).expect("a plan")
}

/// The views as a program draws them, with as many samples per texel as `places`; green is what lies in no tile.
fn drawn(plan: &Plan, places: &[DVec2]) -> Picture {
    let mut atlas = Picture::new(plan.views.atlas, |_, _| [0, 255, 0, 255]);
    for view in &plan.views.views {
        let (tile, frustum) = (view.tile, view.frustum);
        let texel = DVec2::new(frustum.width() / f64::from(tile.width), frustum.height() / f64::from(tile.height));
        for (x, y) in (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (x, y))) {
            let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let light = |place: &DVec2| {
                let at = DVec2::new(frustum.left, frustum.bottom) + (centre + *place) * texel;
                scene(view.rotation.transpose() * at.extend(-1.0))
            };
            let mean = places.iter().map(light).sum::<f64>() / places.len() as f64;
            let code = (255.0 * mean).round() as u8;
            atlas.pixels[((tile.y + y) * plan.views.atlas.0 + tile.x + x) as usize] = [code, 0, code, 255];
        }
    }
    atlas
}

/// The exact mean of each pixel wholly inside the circle, row 0 at the bottom.
fn exact(plan: &Plan) -> Vec<Option<f64>> {
    let pass = &plan.passes[0];
    let mean = |index: u32| {
        let (column, row) = (index % SIZE, SIZE - 1 - index / SIZE);
        let mut sum = 0.0;
        for sample in 0..64 {
            let part = |i: u32| (f64::from(i) + 0.5) / 8.0;
            let (x, y) = (f64::from(column) + part(sample % 8), f64::from(row) + part(sample / 8));
            let (x, y) = pass.source.normalised(pass.size, x, y);
            sum += scene(pass.source.direction(x, y)?);
        }
        Some(sum / 64.0)
    };
    (0..SIZE * SIZE).map(mean).collect()
}

/// Signal to noise in dB of a picture's values, where there is an exact one.
fn signal(values: impl Iterator<Item = f64>, exact: &[Option<f64>]) -> f64 {
    let errors = values.zip(exact).filter_map(|(value, exact)| Some(value - (*exact)?));
    let (sum, count) = errors.fold((0.0, 0), |(sum, count), error| (sum + error * error, count + 1));
    -10.0 * (sum / f64::from(count)).log10()
}

/// What a renderer without any resampling reaches with one sample per pixel, in dB: how hard the scene is.
fn ideal(plan: &Plan, exact: &[Option<f64>]) -> f64 {
    let pass = &plan.passes[0];
    let centre = |index: u32| {
        let (column, row) = (f64::from(index % SIZE) + 0.5, f64::from(SIZE - 1 - index / SIZE) + 0.5);
        let (x, y) = pass.source.normalised(pass.size, column, row);
        pass.source.direction(x, y).map_or(0.0, scene)
    };
    signal((0..SIZE * SIZE).map(centre), exact)
}

/// Signal to noise in dB, and how many pixels show something that lies in no tile.
fn judged(context: &Headless, plan: &Plan, places: &[DVec2], exact: &[Option<f64>]) -> (f64, usize) {
    let shown = show(context, plan, false, &drawn(plan, places));
    let beyond = shown.pixels.iter().filter(|pixel| pixel[1] > 0).count();
    (signal(shown.pixels.iter().map(|pixel| f64::from(pixel[0]) / 255.0), exact), beyond)
}

/// Scenes differ in how many edges they have: numbers are told for one of which a renderer without resampling has
/// 27.2 dB with one sample per pixel. The bounds below are what was measured, less 0.2 dB, to notice what gets worse;
/// they lie below the goals (33.9, 36.5 and 38.5 dB), which this scene does not reach.
const REFERENCE: f64 = 27.2;

#[test]
fn filters_are_as_good_as_they_should_be_and_stay_in_their_tiles() {
    let context = headless(Api::Core);
    let exact = exact(&planned(1.0, Filter::Bilinear));
    let one = [DVec2::ZERO];
    let easier = REFERENCE - ideal(&planned(1.0, Filter::Bilinear), &exact);
    println!("our scene is harder than the reference by {easier:.2} dB");
    let mut failures = Vec::new();
    for (quality, places, filter, least) in [
        (1.0, &FOUR[..], Filter::Bilinear, 31.2),
        (1.0, &FOUR[..], Filter::CatmullRom, 32.3),
        (2.0, &one[..], Filter::Bilinear4, 34.5),
        (1.5, &FOUR[..], Filter::CatmullRom4, 35.5),
    ] {
        let plan = planned(quality, filter);
        let (signal, beyond) = judged(&context, &plan, places, &exact);
        let signal = signal + easier;
        println!("{filter:?}, quality {quality}, {} samples: {signal:.2} dB", places.len());
        if beyond > 0 || signal < least {
            failures.push(format!("{filter:?}: {signal:.2} of {least} dB, {beyond} pixels from beyond a tile"));
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
    // Negative controls: a guard that is too narrow for the kernel is noticed, and so is a source without anti-aliasing.
    let mut narrow = planned(1.0, Filter::Bilinear);
    narrow.passes[0].filter = Filter::CatmullRom4;
    assert!(judged(&context, &narrow, &FOUR, &exact).1 > 0);
    assert!(judged(&context, &planned(1.0, Filter::Bilinear), &one, &exact).0 + easier < 31.2);
}
