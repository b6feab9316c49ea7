//! The part of the statistics that a plan and a rig give, on both APIs.

use crate::intercept::publishing;
use crate::runtime::Session;
use crate::runtime::report::Statistics;

/// Statistics with the name of the rig, and the counts of the cache.
pub fn begin(frames: u64, rig: &str, driver: String) -> Statistics {
    let cache = crate::runtime::cache::of_process().counts();
    Statistics {
        frames,
        rig: rig.to_owned(),
        driver,
        cache,
        published: publishing::statistics(),
        ..Statistics::default()
    }
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
