//! Cached arrangements of views. Choosing them is most of the work at a start, and depends only on
//! the rig and on the outputs' sizes.

use crate::cache::Cache;
use crate::error::Result;
use crate::rig::{Camera, Overlay, Rig};
use crate::views::arranging::choose;
use crate::views::arranging::planned_view::{Arrangement, PlannedView};
use crate::views::sampling::output_map::OutputMap;

/// Returns the result of [`choose::arrange`], from `cache` if it is there.
pub(in crate::views) fn arrange(rig: &Rig, output_maps: &[OutputMap], cache: &Cache) -> Result<Arrangement> {
    let sizes: Vec<_> = output_maps.iter().map(|output_map| output_map.size).collect();
    let is_sound = |found: &Arrangement| found.views.iter().all(|view| is_sound(view, output_maps.len()));
    cache.cached("views", &(what_decides(rig), sizes), is_sound, || choose::arrange(rig, output_maps))
}

/// Returns the rig without what has no effect on the arrangement, so that a new name, camera or
/// panel finds the same one.
fn what_decides(rig: &Rig) -> Rig {
    let overlay = Overlay { yaw: 0.0, pitch: 0.0, width: 0.0 };
    Rig { name: String::new(), camera: Camera::default(), overlay, ..rig.clone() }
}

/// True if the numbers of a view are finite, and its outputs are below `outputs`.
fn is_sound(view: &PlannedView, outputs: usize) -> bool {
    view.rotation.is_finite()
        && view.fit.extent.is_finite()
        && view.fit.density.is_finite()
        && view.curved.as_ref().is_none_or(|map| map.is_finite())
        && view.eye.is_finite()
        && view.outputs.iter().all(|output| *output < outputs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::{decode, encode};
    use crate::rig::Method;
    use crate::testing::random::Random;
    use crate::views::tests::{fisheye, lens, projector, rig};
    use std::cell::Cell;

    fn output_maps(rig: &Rig, size: (u32, u32)) -> Vec<OutputMap> {
        (0..rig.outputs.len()).map(|index| OutputMap::new(rig, index, size).expect("a map")).collect()
    }

    #[test]
    fn what_is_cached_is_what_was_planned_to_the_bit() {
        let mut random = Random::new(5);
        let mut curved = 0;
        for round in 0..16 {
            let mut outputs = vec![fisheye(random.range(90.0, 240.0), random.range(0.0, 90.0))];
            if round % 2 == 0 {
                let at = random.vector(-0.5, 0.5);
                outputs.push(projector("p", at, [random.range(-180.0, 180.0), 20.0, 0.0], lens(50.0, 40.0)));
            }
            if round % 4 < 2 {
                outputs.iter_mut().for_each(|output| output.method = Method::Vertex);
            }
            outputs[0].eye = if round % 3 == 0 { 0.03 } else { 0.0 };
            let rig = rig(outputs);
            let output_maps = output_maps(&rig, (64, 48));
            let planned = choose::arrange(&rig, &output_maps).expect("a plan");
            curved += planned.views.iter().filter(|view| view.curved.is_some()).count();
            let bytes = encode(&planned).expect("bytes");
            let read = |bytes: &[u8]| {
                let sound = |found: &Arrangement| found.views.iter().all(|view| is_sound(view, output_maps.len()));
                decode::<Arrangement>(bytes).filter(sound)
            };
            let cached = read(&bytes).expect("an arrangement");
            assert_eq!(format!("{planned:?}"), format!("{cached:?}"));

            // Truncated data is refused. Changed data is refused or read as another arrangement,
            // and never ends the program.
            for length in 0..bytes.len() {
                assert!(read(&bytes[..length]).is_none(), "{length}");
            }
            for at in 0..bytes.len() {
                let mut other = bytes.clone();
                other[at] ^= 0xFF;
                read(&other);
            }
        }
        assert!(curved > 4, "{curved}");
    }

    #[test]
    fn another_rig_or_size_is_planned_anew() {
        let cache = Cache::in_memory();
        let planned = Cell::new(0);
        let plan = |rig: &Rig, size| {
            let before = cache.counts().missing;
            let output_maps = output_maps(rig, size);
            let kept = arrange(rig, &output_maps, &cache).expect("a plan");
            let fresh = choose::arrange(rig, &output_maps).expect("a plan");
            assert_eq!(format!("{kept:?}"), format!("{fresh:?}"));
            planned.set(planned.get() + cache.counts().missing - before);
        };
        let one = rig(vec![fisheye(180.0, 90.0)]);
        let mut other = one.clone();
        other.viewer.position.x = f64::MIN_POSITIVE;
        for _ in 0..2 {
            plan(&one, (64, 64));
            plan(&other, (64, 64));
            plan(&one, (64, 65));
        }
        assert_eq!(planned.get(), 3);
        // The views are the same for another camera or panel.
        other = one.clone();
        other.camera.zoom = 2.0;
        other.camera.lens = Some([1.0, 0.8]);
        other.overlay.yaw = 0.5;
        other.overlay.width = 1.5;
        other.name = "other".to_owned();
        plan(&other, (64, 64));
        assert_eq!(planned.get(), 3);
    }
}
