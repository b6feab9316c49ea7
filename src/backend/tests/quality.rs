//! Quality of the filters for a scene with hard edges, against 64 samples per pixel. No filter
//! reads beyond its tile.

use super::Driver;
use super::picture::Picture;
use crate::correct::Plan;
use crate::correct::build;
use crate::rig::{Filter, OutputKind, ViewMethod};
use crate::testing::random::Random;
use crate::views::tests::{fisheye, output, projector, request, rig};
use crate::views::{Tile, View};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::LazyLock;

const SIZE: u32 = 512;

/// Returns the brightness of a checker in space, black and white: edges of all directions cross the
/// sphere. It is turned, so that none of them coincides with a border of pixels, texels or views.
fn checker(direction: DVec3) -> f64 {
    let turned = DVec3::new(
        direction.dot(DVec3::new(0.64, 0.48, 0.6)),
        direction.dot(DVec3::new(-0.6, 0.8, 0.0)),
        direction.dot(DVec3::new(-0.48, -0.36, 0.8)),
    );
    let cell = turned * (CELLS / direction.length()) + DVec3::new(0.3, 1.1, 2.0);
    if cell.x.sin() * cell.y.sin() * cell.z.sin() > 0.0 { 1.0 } else { 0.0 }
}

/// Brightness in a direction of any length, 0…1.
type Scene<'a> = &'a dyn Fn(DVec3) -> f64;

/// π divided by a cell's side.
const CELLS: f64 = 6.0;

/// Samples of a texel with fourfold anti-aliasing, as drivers choose them.
const FOUR: [DVec2; 4] =
    [DVec2::new(0.125, 0.375), DVec2::new(-0.375, 0.125), DVec2::new(-0.125, -0.375), DVec2::new(0.375, -0.125)];
/// Four samples in a grid. On edges of all directions they are half a decibel better.
const GRID: [DVec2; 4] =
    [DVec2::new(0.25, 0.25), DVec2::new(-0.25, 0.25), DVec2::new(0.25, -0.25), DVec2::new(-0.25, -0.25)];
const ONE: [DVec2; 1] = [DVec2::ZERO];

const FILTERS: [Filter; 4] = [Filter::Bilinear, Filter::CatmullRom, Filter::Bilinear4, Filter::CatmullRom4];

/// Returns the direction that a view shows at a place of its tile, in texels from the bottom left.
fn direction(view: &View, place: DVec2) -> DVec3 {
    let (tile, frustum) = (view.tile, view.frustum);
    let texel = DVec2::new(frustum.width() / f64::from(tile.width), frustum.height() / f64::from(tile.height));
    view.rotation.transpose() * (DVec2::new(frustum.left, frustum.bottom) + place * texel).extend(-1.0)
}

/// Draws `scene` into the views, as a program would, with the samples `places` in each texel.
fn drawn(plan: &Plan, places: &[DVec2], scene: Scene) -> Picture {
    let mut atlas = Picture::new(plan.views.atlas, |_, _| [0; 4]);
    for view in &plan.views.views {
        let tile = view.tile;
        for (x, y) in (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (x, y))) {
            let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let light = |place: &DVec2| scene(direction(view, centre + *place));
            let mean = places.iter().map(light).sum::<f64>() / places.len() as f64;
            let code = (255.0 * mean).round() as u8;
            atlas.pixels[((tile.y + y) * plan.views.atlas.0 + tile.x + x) as usize] = [code, code, code, 255];
        }
    }
    atlas
}

/// Returns the mean of `side`² samples of `scene` in each pixel that lies wholly in the picture,
/// row 0 at the bottom.
fn sampled(plan: &Plan, side: u32, scene: Scene) -> Vec<Option<f64>> {
    let (pass, (width, height)) = (&plan.passes[0], plan.passes[0].size);
    let mean = |index: u32| {
        let (column, row) = (index % width, height - 1 - index / width);
        let mut sum = 0.0;
        for sample in 0..side * side {
            let part = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
            let (x, y) = (f64::from(column) + part(sample % side), f64::from(row) + part(sample / side));
            let (x, y) = pass.source.normalised(pass.size, x, y);
            sum += scene(pass.source.direction(x, y)?);
        }
        Some(sum / f64::from(side * side))
    };
    (0..width * height).map(mean).collect()
}

/// Returns the signal to noise in dB of a picture's values, where there is an exact one.
fn signal(values: impl Iterator<Item = f64>, exact: &[Option<f64>]) -> f64 {
    let errors = values.zip(exact).filter_map(|(value, exact)| Some(value - (*exact)?));
    let (sum, count) = errors.fold((0.0, 0), |(sum, count), error| (sum + error * error, count + 1));
    -10.0 * (sum / f64::from(count)).log10()
}

/// Returns the signal to noise in dB of an atlas as a driver shows it.
fn shown(driver: &dyn Driver, plan: &Plan, atlas: &Picture, exact: &[Option<f64>]) -> f64 {
    let picture = driver.show(plan, false, atlas);
    signal(picture.pixels.iter().map(|pixel| f64::from(pixel[0]) / 255.0), exact)
}

/// Plans a fisheye picture of 180° with views of `quality` and `filter`.
fn planned(size: u32, quality: f64, filter: Filter) -> Plan {
    let mut rig = rig(vec![fisheye(180.0, 90.0)]);
    (rig.views.quality, rig.views.filter) = (quality, filter);
    build(&rig, &request(&[(size, size)])).expect("a plan")
}

/// Exact values of the pixels of a fisheye picture. The same for all drivers.
static EXACT: LazyLock<Vec<Option<f64>>> =
    LazyLock::new(|| sampled(&planned(SIZE, 1.0, Filter::Bilinear), 8, &checker));

/// A domemaster with views of one quality, one filter and some samples for each texel.
struct Filtered {
    name: String,
    plan: Plan,
    atlas: Picture,
    /// Least signal to noise, dB.
    least: f64,
}

/// Measured cases. Each bound is the measured value less 0.2 dB, so that a loss is noticed. The
/// same for all drivers.
static FILTERED: LazyLock<Vec<Filtered>> = LazyLock::new(|| {
    let (four, grid) = (("4 samples", &FOUR[..]), ("a grid of 4 samples", &GRID[..]));
    let cases = [
        (1.0, four, Filter::Bilinear, 33.0),
        (1.25, four, Filter::Bilinear, 35.0),
        (1.0, four, Filter::CatmullRom, 34.0),
        (2.0, ("one sample", &ONE[..]), Filter::Bilinear4, 36.5),
        (1.5, four, Filter::CatmullRom4, 38.0),
        (1.0, grid, Filter::Bilinear, 33.9),
        (1.5, grid, Filter::CatmullRom4, 38.5),
    ];
    let filtered = |(quality, (samples, places), filter, least)| {
        let plan = planned(SIZE, quality, filter);
        let atlas = drawn(&plan, places, &checker);
        Filtered { name: format!("{filter:?}, quality {quality}, {samples}"), plan, atlas, least }
    };
    cases.into_iter().map(filtered).collect()
});

pub fn filters_are_as_good_as_they_should_be(driver: &dyn Driver) {
    let exact = EXACT.as_slice();
    let plain = planned(SIZE, 1.0, Filter::Bilinear);
    let single = sampled(&plain, 1, &checker);
    let ideal = signal(single.into_iter().map(|value| value.unwrap_or_default()), exact);
    println!("no resampling, one sample: {ideal:.2} dB");
    // The scene is as hard as that of goal G10 (docs/results.md).
    assert!((ideal - 27.2).abs() < 0.3, "{ideal}");
    let mut failures = Vec::new();
    for Filtered { name, plan, atlas, least } in FILTERED.iter() {
        let signal = shown(driver, plan, atlas, exact);
        println!("{name}: {signal:.2} dB");
        if signal < *least {
            failures.push(format!("{name}: {signal:.2} of {least} dB"));
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
    // Negative control: a source without anti-aliasing is noticed.
    assert!(shown(driver, &plain, &drawn(&plain, &ONE, &checker), exact) < 32.0);
}

/// A scene, the pixels of a projector that should show it, and its views for the projector's
/// picture and for a domemaster.
struct Resampled {
    name: &'static str,
    exact: Vec<Option<f64>>,
    atlas: Picture,
    dome_atlas: Picture,
    /// Least gain of one resampling, dB.
    least: f64,
}

/// A projector's picture, and a domemaster of the same resolution. The same for all drivers.
static PROJECTOR_AND_DOME: LazyLock<(Plan, Plan, Vec<Resampled>)> = LazyLock::new(|| {
    let (width, height) = (256, 160);
    let frustum = crate::geom::Frustum::symmetric(60f64.to_radians(), 39.68f64.to_radians());
    let output = projector("one", DVec3::new(0.0, 0.4, 3.0), [10.0, 5.0, 3.0], frustum);
    let plan = build(&rig(vec![output]), &request(&[(width, height)])).expect("a plan");
    // The domemaster has as many pixels per angle as the middle of the projector's picture.
    let towards = |x: f64, y: f64| plan.passes[0].source.direction(x, y).expect("from inside every ray hits");
    let middle = towards(0.0, 0.0);
    let pixel = middle.angle_between(towards(2.0 / f64::from(width), 0.0));
    let side = (PI / pixel).round();
    let dome = planned(side as u32, 1.0, Filter::Bilinear);

    // Circles around the middle, finer and finer, up to 0.42 of a period for each pixel in the
    // farthest corner.
    let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let farthest = corners.map(|(x, y)| middle.angle_between(towards(x, y))).into_iter().fold(0.0, f64::max);
    let zones = |direction: DVec3| {
        let angle = middle.angle_between(direction);
        0.5 + 0.5 * (PI * 0.42 / pixel * angle * angle / farthest).cos()
    };
    let scenes = [("edges", &checker as Scene, 3.5), ("zone plate", &zones, 6.0)].map(|(name, scene, least)| {
        let (atlas, dome_atlas) = (drawn(&plan, &FOUR, scene), drawn(&dome, &FOUR, scene));
        Resampled { name, exact: sampled(&plan, 8, scene), atlas, dome_atlas, least }
    });
    (plan, dome, scenes.into())
});

/// Compares a projector's picture made directly with one made from a domemaster of the same
/// resolution, as programs make it that know only domemasters.
pub fn one_resampling_is_better_than_two(driver: &dyn Driver) {
    let (plan, dome, scenes) = &*PROJECTOR_AND_DOME;
    for scene in scenes {
        let gain = gain_of_one_resampling(driver, plan, dome, scene);
        assert!(gain >= scene.least, "{}: {gain}", scene.name);
    }
}

/// Returns the gain of a projector's picture of a scene over one made of a domemaster, dB.
fn gain_of_one_resampling(driver: &dyn Driver, plan: &Plan, dome: &Plan, scene: &Resampled) -> f64 {
    let direct = shown(driver, plan, &scene.atlas, &scene.exact);
    let master = driver.show(dome, false, &scene.dome_atlas);
    let (width, height) = plan.passes[0].size;
    let side = f64::from(dome.passes[0].size.0);
    let twice = (0..width * height).map(|index| {
        let pass = &plan.passes[0];
        let (column, row) = (f64::from(index % width) + 0.5, f64::from(height - 1 - index / width) + 0.5);
        let (x, y) = pass.source.normalised(pass.size, column, row);
        let lens = pass.source.direction(x, y).expect("from inside every ray hits");
        let at = crate::geom::Fisheye { aperture: PI }.point(lens);
        master.bilinear(0.5 * side * (1.0 + at.x), 0.5 * side * (1.0 + at.y))[0]
    });
    let twice = signal(twice, &scene.exact);
    println!("{}, domemaster {side}²: resampled once {direct:.2} dB, twice {twice:.2} dB", scene.name);
    direct - twice
}

/// Moves the views apart in the atlas, so that there is room around each.
fn spread(plan: &Plan) -> Plan {
    let mut plan = plan.clone();
    let mut right = ROOM;
    for view in &mut plan.views.views {
        (view.tile.x, view.tile.y) = (right, ROOM);
        right += view.tile.width + ROOM;
    }
    let highest = plan.views.views.iter().map(|view| view.tile.height).max().unwrap_or_default();
    plan.views.atlas = (right, highest + 2 * ROOM);
    plan
}

/// Texels between tiles.
const ROOM: u32 = 8;

/// Returns an atlas with noise in all tiles. Their outermost `ring` texels and all texels around
/// them are `beyond`.
fn within(plan: &Plan, ring: u32, beyond: u8) -> Picture {
    let random = std::cell::RefCell::new(Random::new(5));
    Picture::new(plan.views.atlas, |x, y| {
        let noise = if random.borrow_mut().unit() < 0.5 { 0 } else { 255 };
        let inside = |tile: &Tile| {
            let within = |at: u32, start: u32, length: u32| at >= start + ring && at + ring < start + length;
            within(x, tile.x, tile.width) && within(y, tile.y, tile.height)
        };
        let code = if plan.views.views.iter().any(|view| inside(&view.tile)) { noise } else { beyond };
        [code, code, code, 255]
    })
}

/// A projection, a filter and a quality, with tiles that have room between them.
struct Apart {
    what: String,
    plan: Plan,
    /// For rings of 0 and 1 texels: two atlases that differ in the rings and around the tiles.
    atlases: [[Picture; 2]; 2],
}

/// The same for all drivers.
static APART: LazyLock<Vec<Apart>> = LazyLock::new(|| {
    let frustum = crate::geom::Frustum::symmetric(1.2, 0.9);
    let (position, degrees) = (DVec3::new(0.5, 0.2, 2.5), [40.0, 17.0, 6.0]);
    let pose = crate::geom::Pose::new(position, 0.7, 0.3, 0.1);
    // Not quite a pinhole lens, so that it is tabulated.
    let distortion = crate::geom::lenses::lens::Distortion { radial: [1e-6, 0.0, 0.0], tangential: [0.0; 2] };
    let lens = crate::geom::Lens::Pinhole { frustum, distortion, keystone: glam::DMat3::IDENTITY };
    let optics = crate::geom::Optics { pose, lens, mirror: None };
    let tabulated = output("one", OutputKind::Optics { optics: Box::new(optics), even_light: 0.0 });
    let mut all = Vec::new();
    for output in [fisheye(180.0, 90.0), projector("one", position, degrees, frustum), tabulated] {
        let mut rig = rig(vec![output]);
        rig.views.method = ViewMethod::Cube;
        for filter in FILTERS {
            for quality in [1.0, 2.3] {
                (rig.views.filter, rig.views.quality) = (filter, quality);
                let plan = spread(&build(&rig, &request(&[(120, 96)])).expect("a plan"));
                let what = format!("{:?}, {filter:?}, quality {quality}", rig.outputs[0].kind);
                let atlases = [0, 1].map(|ring| [0, 255].map(|beyond| within(&plan, ring, beyond)));
                all.push(Apart { what, plan, atlases });
            }
        }
    }
    all
});

/// The picture near seams does not depend on texels beyond the tiles, to the last bit.
pub fn filters_read_nothing_beyond_their_tiles(driver: &dyn Driver) {
    for Apart { what, plan, atlases } in APART.iter() {
        let pictures = driver.show_each(plan, false, atlases.as_flattened());
        let differing = |a: &Picture, b: &Picture| a.pixels.iter().zip(&b.pixels).filter(|(a, b)| a != b).count();
        assert_eq!(differing(&pictures[0], &pictures[1]), 0, "{what}");
        // Negative control: a guard that is narrower by one texel is not enough.
        let narrower = differing(&pictures[2], &pictures[3]);
        assert!(narrower > 0, "{what}: the guard is too wide, or the test does not notice texels beyond it");
    }
}
