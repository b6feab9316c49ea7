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
use cupola::warp::{WarpMap, compare_each, displacement};

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

/// Names of the quantities of a part of the report.
pub struct Quantities {
    inside: &'static str,
    far: &'static str,
    not_finite: &'static str,
    ghosts: &'static str,
    uncovered: &'static str,
    /// Whether the bound for distant projectors also holds for tables: 5·10⁻⁷ of the width of a
    /// view of twice [`REFERENCE_WIDTH`].
    far_tables: bool,
}

/// Quantities for pinholes and domemasters on a dome.
pub const DOMES: Quantities = Quantities {
    inside: "map, within 0.9 radii: error / (0.002 px of 4096 or 6e-7 rad)",
    far: "map, near the screen, outside: error / (0.004 px or 6e-7 rad)",
    not_finite: "map: pixels not finite",
    ghosts: "map: ghosts",
    uncovered: "map: pixels uncovered",
    far_tables: false,
};

/// Quantities for any lens on any screen.
pub const SCREENS: Quantities = Quantities {
    inside: "screen, within 0.6 radii: error / (0.002 px of 4096 or 6e-7 rad)",
    far: "screen, farther out, tables: error / (0.004 px or 6e-7 rad)",
    not_finite: "screen: pixels not finite",
    ghosts: "screen: ghosts",
    uncovered: "screen: pixels uncovered",
    far_tables: true,
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
    let look = |x: u32, y: u32| directions[(y * size.0 + x) as usize];
    let far_table = names.far_tables && matches!(plan.passes[0].source, Source::Table(_));
    let (quantity, pixels) = match case.place {
        Place::Inside if !far_table => (names.inside, INSIDE),
        _ => (names.far, FAR),
    };
    let surveyor = Surveyor::new(&plan.views, &rig, 0, size)?;
    let (mut greatest, mut worst) = (0.0f64, (0, 0));
    let error = compare_each(&exact, 1, look, |found| {
        // Angle of a pixel at the reference width.
        let pixel = found.angle / found.pixels / scale;
        let mut part = found.angle / (pixels * pixel).max(ANGLE);
        if part > 1.0 {
            // The error of a view that is coarser because of the size limit counts in texels.
            let texels = surveyor.at(found.centre()).and_then(|pixel| pixel.texels_per_pixel);
            part *= texels.map_or(1.0, |texels| (texels / scale).min(1.0));
            // Near a silhouette the direction changes much within a small part of a pixel. The
            // error there is the distance to the pixel position with this direction.
            let displaced = displacement(&exact, found.centre(), found.angle);
            part = displaced.map_or(part, |displaced| part.min(displaced * scale / pixels));
        }
        if part.is_nan() || part > greatest {
            (greatest, worst) = (part, found.pixel);
        }
    });
    let input = format!("size {}x{}, pixel {worst:?}\n{}", size.0, size.1, case.text);
    let finding = |quantity, value, bound, compared, pixels| Finding {
        quantity,
        value,
        bound,
        compared,
        pixels,
        input: input.clone(),
    };
    Ok(vec![
        finding(quantity, greatest, 1.0, error.compared, true),
        finding(names.not_finite, error.non_finite as f64, 0.0, error.compared, false),
        finding(names.ghosts, error.ghosts as f64, 0.0, error.compared, false),
        finding(names.uncovered, error.uncovered as f64, 0.0, error.compared, false),
    ])
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
