//! The map of a random rig, as the shaders or their formulas compute it, compared with the exact
//! map.

use super::case::{Case, Place, pick};
use super::driver::Driver;
use super::report::Finding;
use crate::failure::Failure;
use crate::planning::request;
use crate::random::Random;
use cupola::correct::{Plan, Source};
use cupola::rig::Rig;
use cupola::views::Surveyor;
use cupola::warp::{MapError, WarpMap, compare_each, displacement};
use glam::DVec2;
use std::f64::consts::FRAC_PI_4;

/// Width in pixels of the picture in whose pixels errors are given. Small pictures then have the
/// same bounds as large ones.
const REFERENCE_WIDTH: f64 = 4096.0;

/// Bound on the error, in pixels of [`REFERENCE_WIDTH`], for viewers and projectors within 0.9
/// radii of the centre.
const INSIDE: f64 = 0.002;
/// Bound on the error for projectors near the screen, up to touching it, and outside, up to the
/// silhouette.
const FAR: f64 = 0.004;
/// Error in radians that is allowed for any pixel size. Directions in f32 have steps of 6e-8, and
/// the pixels of narrow pictures are not much larger.
const ANGLE: f64 = 6e-7;

/// Distance from a silhouette, in pixels of [`REFERENCE_WIDTH`], within which errors may be
/// [`FAR`].
const BESIDE: f64 = 64.0;
/// Distance between directions on both sides of a silhouette, radians.
const JUMP: f64 = 0.1;

/// Names of the quantities of a part of the report.
pub struct Quantities {
    inside: &'static str,
    far: &'static str,
    not_finite: &'static str,
    ghosts: &'static str,
    uncovered: &'static str,
    /// Places where the greater bound holds.
    greater_bound: GreaterBound,
}

/// Places where errors may be [`FAR`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum GreaterBound {
    /// For projectors near the screen and outside.
    Far,
    /// For these and for tables: 5·10⁻⁷ of the width of a view of twice [`REFERENCE_WIDTH`].
    FarAndTables,
    /// Beside silhouettes only, wherever projectors are.
    Silhouettes,
}

/// Quantities for pinholes and domemasters on a dome.
pub const DOMES: Quantities = Quantities {
    inside: "map, within 0.9 radii: error / (0.002 px of 4096 or 6e-7 rad)",
    far: "map, near the screen, outside: error / (0.004 px or 6e-7 rad)",
    not_finite: "map: pixels not finite",
    ghosts: "map: ghosts",
    uncovered: "map: pixels uncovered",
    greater_bound: GreaterBound::Far,
};

/// Quantities for any lens on any screen.
pub const SCREENS: Quantities = Quantities {
    inside: "screen, within 0.6 radii: error / (0.002 px of 4096 or 6e-7 rad)",
    far: "screen, farther out, tables: error / (0.004 px or 6e-7 rad)",
    not_finite: "screen: pixels not finite",
    ghosts: "screen: ghosts",
    uncovered: "screen: pixels uncovered",
    greater_bound: GreaterBound::FarAndTables,
};

/// Quantities for projectors whose pictures reach beyond the outlines of screens.
pub const OUTSIDE: Quantities = Quantities {
    inside: "outside: error / (0.002 px of 4096 or 6e-7 rad)",
    far: "outside, beside silhouettes: error / (0.004 px or 6e-7 rad)",
    not_finite: "outside: pixels not finite",
    ghosts: "outside: ghosts",
    uncovered: "outside: pixels uncovered",
    greater_bound: GreaterBound::Silhouettes,
};

/// Errors of the driver's map of a rig in a picture of `size` pixels.
pub fn case(case: &Case, size: (u32, u32), driver: &Driver, names: &Quantities) -> Result<Vec<Finding>, Failure> {
    let refused =
        |failure: Failure| Failure::new(format!("{}\nsize {}x{}\n{}", failure.message, size.0, size.1, case.text));
    let scale = REFERENCE_WIDTH / f64::from(size.0.max(size.1));
    // The views are those of a picture of the reference width. A small picture would have fewer and
    // wider views.
    let mut rig = case.rig.clone();
    rig.views.quality *= scale;
    let plan = planned(&rig, &[size]).map_err(refused)?;
    let directions = driver.directions(&plan, 0).map_err(refused)?;
    let exact = WarpMap::new(&case.rig, 0, size, None)?;
    let at = |x: u32, y: u32| directions[(y * size.0 + x) as usize];
    let look = |x: u32, y: u32| at(x, y).map(|(direction, _)| direction);
    let is_table = matches!(plan.passes[0].source, Source::Table(_));
    let all_far = match names.greater_bound {
        GreaterBound::Far => case.place == Place::Far,
        GreaterBound::FarAndTables => case.place == Place::Far || is_table,
        GreaterBound::Silhouettes => false,
    };
    let surveyor = Surveyor::new(&plan.views, &rig, 0, size)?;
    let mut near = Worst::default();
    let mut far = Worst::default();
    let error = compare_each(&exact, 1, look, |found| {
        // Angle of a pixel at the reference width.
        let pixel = found.angle / found.pixels / scale;
        let part_of = |pixels: f64| {
            let part = found.angle / (pixels * pixel).max(ANGLE);
            if part <= 1.0 {
                return part;
            }
            // The error of a view that is coarser because of the size limit counts in texels of the
            // sampled view. Beside a border, that may be the one that ends there.
            let sampled = at(found.pixel.0, found.pixel.1).and_then(|(_, view)| view);
            let surveyed = sampled.and_then(|view| surveyor.in_view(found.centre(), view));
            let texels = surveyed.and_then(|pixel| pixel.texels_per_pixel);
            let part = part * texels.map_or(1.0, |texels| (texels / scale).min(1.0));
            // Near a silhouette the direction changes much within a small part of a pixel. The
            // error there is the distance to the pixel position with this direction.
            let displaced = displacement(&exact, found.centre(), found.angle);
            displaced.map_or(part, |displaced| part.min(displaced * scale / pixels))
        };
        let part = part_of(if all_far { FAR } else { INSIDE });
        let at_silhouette = names.greater_bound == GreaterBound::Silhouettes
            && part > 1.0
            && is_beside_silhouette(&exact, found.centre(), BESIDE / scale);
        match all_far || at_silhouette {
            true => far.add(if at_silhouette { part_of(FAR) } else { part }, found.pixel),
            false => near.add(part, found.pixel),
        }
    });
    Ok(findings(case, size, names, all_far, [&near, &far], &error))
}

/// Findings in one picture: its greatest errors `near` and `far`, and the number of completely
/// wrong pixels.
fn findings(
    case: &Case,
    size: (u32, u32),
    names: &Quantities,
    all_far: bool,
    [near, far]: [&Worst; 2],
    error: &MapError,
) -> Vec<Finding> {
    let input = |pixel: (u32, u32)| format!("size {}x{}, pixel {pixel:?}\n{}", size.0, size.1, case.text);
    let finding = |quantity, value, bound, compared, pixels| Finding {
        quantity,
        value,
        bound,
        compared,
        pixels,
        input: input(if quantity == names.far { far.pixel } else { near.pixel }),
    };
    let mut findings = Vec::new();
    if !all_far {
        findings.push(finding(names.inside, near.part, 1.0, error.compared, true));
    }
    if all_far || far.pixels > 0 {
        let compared = if all_far { error.compared } else { far.pixels };
        findings.push(finding(names.far, far.part, 1.0, compared, all_far));
    }
    let count = |quantity, number: u64| finding(quantity, number as f64, 0.0, error.compared, false);
    findings.extend([
        count(names.not_finite, error.non_finite),
        count(names.ghosts, error.ghosts),
        count(names.uncovered, error.uncovered),
    ]);
    findings
}

/// The greatest error of a map, as a part of its bound.
#[derive(Default)]
struct Worst {
    part: f64,
    pixel: (u32, u32),
    /// Number of pixels.
    pixels: u64,
}

impl Worst {
    fn add(&mut self, part: f64, pixel: (u32, u32)) {
        self.pixels += 1;
        if part.is_nan() || part > self.part {
            (self.part, self.pixel) = (part, pixel);
        }
    }
}

/// True if, `distance` pixels away, the map shows nothing or a direction that is far from the
/// pixel's own.
fn is_beside_silhouette(exact: &WarpMap, centre: DVec2, distance: f64) -> bool {
    let Some(here) = exact.direction(centre) else { return true };
    let around = (0..8).map(|turn| DVec2::from_angle(f64::from(turn) * FRAC_PI_4) * distance);
    let mut seen = around.map(|aside| exact.direction(centre + aside));
    seen.any(|direction| direction.is_none_or(|direction| direction.distance(here) > JUMP))
}

/// A random size of 64…512 pixels in each direction, some odd.
pub fn size(random: &mut Random) -> (u32, u32) {
    let side = |random: &mut Random| {
        let odd = 64 + (random.unit() * 448.0) as u32;
        pick(random, &[64, 128, 256, 512, odd])
    };
    (side(random), side(random))
}

/// The plan of a rig with outputs of these sizes.
pub fn planned(rig: &Rig, sizes: &[(u32, u32)]) -> Result<Plan, Failure> {
    let request = request(sizes.to_vec(), (512, 512));
    Ok(cupola::correct::build(rig, &request)?)
}
