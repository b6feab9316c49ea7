//! Cached areas that no pixel samples.

use crate::cache::Cache;
use crate::correct::passes::output_pass::Plan;
use crate::correct::plan::unsampled::unsampled_areas;
use crate::views::Tile;
use std::convert::Infallible;

/// Returns [`unsampled_areas`], from `cache` if it has them.
pub fn cached_unsampled_areas(plan: &Plan, cache: &Cache) -> Vec<Vec<Tile>> {
    let views = &plan.views;
    let passes = plan.passes.iter().map(|pass| {
        let rects = pass.batches.iter().flat_map(|batch| &batch.rects);
        (pass.here, pass.size, &pass.source, rects.collect::<Vec<_>>())
    });
    let key = (&views.views, &views.output_views, views.guard, passes.collect::<Vec<_>>());
    let is_sound = |areas: &Vec<Vec<Tile>>| areas.len() == plan.views.views.len();
    let found: Result<_, Infallible> = cache.cached("unsampled", &key, is_sound, || Ok(unsampled_areas(plan)));
    let Ok(areas) = found;
    areas
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::plan::builder::build;
    use crate::views::tests::{fisheye, request, rig};

    #[test]
    fn what_is_cached_is_what_was_found_for_this_plan() {
        let cache = Cache::in_memory();
        let plan = |aperture: f64| build(&rig(vec![fisheye(aperture, 90.0)]), &request(&[(256, 256)])).expect("a plan");
        for _ in 0..2 {
            for aperture in [180.0, 180.5] {
                let plan = plan(aperture);
                let areas = unsampled_areas(&plan);
                assert!(areas.iter().any(|tiles| !tiles.is_empty()));
                assert_eq!(cached_unsampled_areas(&plan, &cache), areas);
            }
        }
        assert_eq!(cache.counts().missing, 2);
    }
}
