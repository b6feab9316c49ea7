//! Remarks about values that are possible in a rig, but rarely meant.

use super::numbers::{degrees, number};
use cupola::geom::{Lens, Screen, screen::Shape};
use cupola::rig::{Output, OutputKind, Rig};
use cupola::views::{Report, ViewReport};
use cupola::warp::WarpMap;
use glam::DVec3;

/// Usual radii of domes in metres, with a margin.
const RADII: std::ops::RangeInclusive<f64> = 0.2..=60.0;
/// Opening of a projector, radians, below which its angles were probably given in radians.
const NARROW: f64 = 0.07;
/// Number of directions in which the dome is examined.
const PLACES: u32 = 2000;
/// Number of texels for each pixel that are remarked.
const MANY: f64 = 4.0;
/// Number of texels for each pixel that a better quality aims at.
const FEW: f64 = 2.0;
/// Part of all texels from which on a view is remarked.
const LARGE: f64 = 0.1;
/// Part of the screen that is usually lit.
const LIT: f64 = 0.5;

/// Remarks about a rig whose outputs have these sizes.
pub fn remarks(rig: &Rig, sizes: &[(u32, u32)]) -> Vec<String> {
    let mut remarks = Vec::new();
    if !RADII.contains(&rig.dome.radius) {
        remarks.push(format!("the dome has a radius of {} m; lengths are in metres", number(rig.dome.radius)));
    }
    for output in &rig.outputs {
        let frustum = match &output.kind {
            OutputKind::Projector { frustum, .. } => Some(*frustum),
            OutputKind::Optics { optics, .. } => match &optics.lens {
                Lens::Pinhole { frustum, .. } => Some(*frustum),
                Lens::Fisheye { .. } => None,
            },
            _ => None,
        };
        let opening = |low: f64, high: f64| high.atan() - low.atan();
        let openings = frustum.map(|f| (opening(f.left, f.right), opening(f.bottom, f.top)));
        if let Some((width, height)) = openings.filter(|(width, height)| width.max(*height) < NARROW) {
            let (name, width, height) = (&output.name, degrees(width), degrees(height));
            remarks.push(format!("{name} opens only {width} × {height}; angles are in degrees"));
        }
    }
    if let Some(lit) = lit(rig, sizes).filter(|lit| *lit < LIT) {
        let percent = (100.0 * lit).round();
        remarks.push(format!("{percent} % of the screen is lit by projectors; `cupola simulate` shows where"));
    }
    remarks
}

/// Remarks about views that draw many texels for each pixel that they serve, with a quality that
/// needs fewer.
pub fn costly(rig: &Rig, report: &Report, sizes: &[(u32, u32)]) -> Vec<String> {
    let served = |view: &ViewReport| -> f64 {
        let outputs = rig.outputs.iter().zip(sizes);
        let part = |(output, (width, height)): (&Output, &(u32, u32))| {
            let share = view.coverage.iter().find(|share| share.output == output.name).map_or(0.0, |share| share.share);
            let lit = match output.kind.is_circular() {
                true => std::f64::consts::FRAC_PI_4 * f64::from(*width.min(height)).powi(2),
                false => f64::from(*width) * f64::from(*height),
            };
            share * lit
        };
        outputs.map(part).sum()
    };
    let costly = report.views.iter().filter_map(|view| {
        let texels = f64::from(view.width) * f64::from(view.height);
        let each = texels / served(view).max(1.0);
        // A small view costs little, and its border makes up much of it.
        let large = texels >= LARGE * report.view_texels as f64;
        (each > MANY && large && !view.program_lens).then(|| {
            let quality = rig.views.quality * (FEW / each).sqrt();
            format!(
                "view {} draws {each:.1} texels for each pixel that it serves, perhaps for the sake of a few pixels; \
                 `views.quality = {}` needs about {FEW}",
                view.name,
                number((100.0 * quality).ceil() / 100.0)
            )
        })
    });
    costly.collect()
}

/// The part of a dome that projectors light; `None` for rigs without projectors, and for other
/// screens.
fn lit(rig: &Rig, sizes: &[(u32, u32)]) -> Option<f64> {
    let projectors = || rig.outputs.iter().zip(sizes).enumerate().filter(|(_, (output, _))| output.kind.is_projector());
    let Screen { shape: Shape::Ellipsoid(_), pose } = rig.surface() else { return None };
    if projectors().count() == 0 || rig.screen.is_some() {
        return None;
    }
    let maps: Vec<WarpMap> =
        projectors().filter_map(|(index, (_, size))| WarpMap::new(rig, index, *size, None).ok()).collect();
    let half = 0.5 * rig.dome.coverage;
    let (mut screen, mut lit) = (0u32, 0u32);
    for place in 0..PLACES {
        // The directions lie evenly over the cap, in a spiral.
        let part = (f64::from(place) + 0.5) / f64::from(PLACES);
        let up = 1.0 - part * (1.0 - half.cos());
        let around = 2.399_963_229_728_653 * f64::from(place);
        let level = (1.0 - up * up).max(0.0).sqrt();
        let point = pose.point_to_parent(rig.dome.radius * DVec3::new(level * around.cos(), up, level * around.sin()));
        screen += 1;
        lit += u32::from(maps.iter().any(|map| map.pixel(point).is_some()));
    }
    Some(f64::from(lit) / f64::from(screen.max(1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn remarks_of(text: &str) -> Vec<String> {
        let rig = cupola::rig::parse(text, "rig.toml", Path::new("")).expect("a rig");
        let sizes = vec![(320, 200); rig.outputs.len()];
        remarks(&rig, &sizes)
    }

    #[test]
    fn units_that_are_not_meant_are_remarked() {
        let radians =
            "[dome]\nradius = 5000\n[[output]]\nkind = \"projector\"\nposition = [0, 0, 2000]\nfov = [1.117, 0.676]\n";
        let found = remarks_of(radians);
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found[0].contains("5000 m") && found[1].contains("1.117°") && found[2].starts_with("0 %"), "{found:?}");
    }

    #[test]
    fn presets_are_not_remarked() {
        for preset in cupola::rig::presets() {
            let rig = cupola::rig::load(preset.name).expect("a preset");
            let sizes = vec![(192, 108); rig.outputs.len()];
            assert_eq!(remarks(&rig, &sizes), Vec::<String>::new(), "{}", preset.name);
            let request = crate::planning::window_request(&rig, None);
            let plan = cupola::views::plan(&rig, &request).expect("a plan");
            let report = cupola::views::report(&plan, &rig, &request.output_sizes);
            assert_eq!(costly(&rig, &report, &request.output_sizes), Vec::<String>::new(), "{}", preset.name);
        }
    }

    #[test]
    fn views_that_cost_much_are_remarked_with_a_quality_that_costs_less() {
        let text = "[[output]]\nname = \"a\"\nkind = \"domemaster\"\nsize = [400, 400]\n[views]\nquality = ";
        let planned = |quality: &str| {
            let rig = cupola::rig::parse(&format!("{text}{quality}\n"), "rig.toml", Path::new("")).expect("a rig");
            let request = crate::planning::window_request(&rig, Some((400, 400)));
            let plan = cupola::views::plan(&rig, &request).expect("a plan");
            let report = cupola::views::report(&plan, &rig, &request.output_sizes);
            (costly(&rig, &report, &request.output_sizes), report.texels_per_pixel)
        };
        let (remarks, each) = planned("4.0");
        assert!(each > 8.0 && !remarks.is_empty(), "{each} {remarks:?}");
        let proposed = remarks.iter().filter_map(|remark| remark.split("quality = ").nth(1)?.split('`').next());
        let least = proposed.map(|quality| quality.parse().expect("a number")).fold(4.0, f64::min);
        let (remarks, each) = planned(&least.to_string());
        assert!(each < 4.0 && remarks.is_empty(), "{each} {remarks:?}");
    }

    /// A projector in the middle of a hemisphere that looks up with 90° × 90° lights a pyramid: a
    /// third of the half sphere, 2π/3 of 2π.
    #[test]
    fn the_lit_part_is_that_of_a_pyramid() {
        let text = "[[output]]\nkind = \"projector\"\npitch = 90.0\nfov = [90.0, 90.0]\n";
        let rig = cupola::rig::parse(text, "rig.toml", Path::new("")).expect("a rig");
        let lit = lit(&rig, &[(200, 200)]).expect("a dome");
        assert!((lit - 1.0 / 3.0).abs() < 0.01, "{lit}");
    }
}
