//! The part of the statistics that comes from the plan, the rig and the process, for both APIs.

use crate::intercept::process::publishing;
use crate::intercept::process::settings::settings;
use crate::intercept::scene::camera::Cameras;
use crate::runtime::Session;
use crate::runtime::run_results::Statistics;

/// Statistics with the names of the rig and the profile, and the counts of the cache.
pub fn begin(frames: u64, rig: &str, driver: String) -> Statistics {
    let cache = crate::runtime::cache::of_process().counts();
    let profile = settings().and_then(|settings| settings.profile.as_ref());
    let profile = profile.map_or_else(String::new, |chosen| chosen.profile.name.clone());
    Statistics {
        frames,
        rig: rig.to_owned(),
        driver,
        profile,
        cache,
        published: publishing::statistics(),
        ..Statistics::default()
    }
}

/// Returns the edges of the program's pictures, for the lenses of `cameras` that are shown: left,
/// right, bottom, top, as tangents.
pub fn lenses(cameras: &Cameras) -> impl Iterator<Item = [f64; 4]> {
    let edges = |scale: f64, offset: f64| {
        let [one, other] = [(offset - 1.0) / scale, (offset + 1.0) / scale];
        [one.min(other), one.max(other)]
    };
    cameras.shown().map(move |lens| {
        let ([left, right], [bottom, top]) = (edges(lens.a, lens.b), edges(lens.c, lens.d));
        [left, right, bottom, top]
    })
}

/// Adds the pixels and the notes of a plan.
pub fn add_plan(statistics: &mut Statistics, session: &Session) {
    let plan = session.plan();
    for pass in &plan.passes {
        let rects = pass.batches.iter().flat_map(|batch| &batch.rects);
        statistics.output_pixels += u64::from(pass.size.0) * u64::from(pass.size.1);
        statistics.corrected_pixels += rects.map(|rect| u64::from(rect.width) * u64::from(rect.height)).sum::<u64>();
    }
    statistics.notes.extend(plan.views.notes.iter().cloned());
}
