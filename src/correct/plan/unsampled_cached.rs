//! The parts that no pixel samples as bytes.

use crate::cache::{Cache, Reader, Writer};
use crate::correct::passes::output_pass::Plan;
use crate::correct::plan::unsampled::hidden_areas;
use crate::views::Tile;
use std::convert::Infallible;

/// [`hidden_areas`], or what `cache` kept of it.
pub fn kept_hidden_areas(plan: &Plan, cache: &Cache) -> Vec<Vec<Tile>> {
    let views = &plan.views;
    let found: Result<_, Infallible> = cache.kept(
        "hidden",
        |key| {
            let key = key.debug(&views.views).debug(&views.output_views).debug(&views.guard);
            plan.passes.iter().fold(key, |key, pass| {
                let rects = pass.batches.iter().flat_map(|batch| &batch.rects);
                key.debug(&pass.size).debug(&pass.source).debug(&rects.collect::<Vec<_>>())
            })
        },
        |reader| read(reader, plan.views.views.len()),
        |areas, writer| write(areas, writer),
        || Ok(hidden_areas(plan)),
    );
    let Ok(areas) = found;
    areas
}

fn write(areas: &[Vec<Tile>], to: &mut Writer) -> bool {
    for tiles in areas {
        to.length(tiles.len());
        for Tile { x, y, width, height } in tiles {
            [x, y, width, height].into_iter().for_each(|number| to.u32(*number));
        }
    }
    true
}

/// Those of so many views.
fn read(from: &mut Reader<'_>, views: usize) -> Option<Vec<Vec<Tile>>> {
    let tiles = |_| {
        let count = from.length(4 * size_of::<u32>())?;
        let tile = |_| Some(Tile { x: from.u32()?, y: from.u32()?, width: from.u32()?, height: from.u32()? });
        (0..count).map(tile).collect()
    };
    (0..views).map(tiles).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::plan::builder::build;
    use crate::views::tests::{fisheye, request, rig};

    #[test]
    fn what_is_kept_is_what_was_found_for_this_plan() {
        let cache = Cache::in_memory();
        let plan = |aperture: f64| build(&rig(vec![fisheye(aperture, 90.0)]), &request(&[(256, 256)])).expect("a plan");
        for _ in 0..2 {
            for aperture in [180.0, 180.5] {
                let plan = plan(aperture);
                let areas = hidden_areas(&plan);
                assert!(areas.iter().any(|tiles| !tiles.is_empty()));
                assert_eq!(kept_hidden_areas(&plan, &cache), areas);
                let mut writer = Writer::default();
                assert!(write(&areas, &mut writer));
                let bytes = writer.finish();
                assert_eq!(read(&mut Reader::new(&bytes), areas.len()).as_ref(), Some(&areas));
                assert_eq!(read(&mut Reader::new(&bytes[..bytes.len() - 1]), areas.len()), None);
            }
        }
        assert_eq!(cache.counts().missing, 2);
    }
}
