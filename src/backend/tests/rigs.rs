//! Plans of rigs and exact maps of their outputs. They are the same for all drivers, and made once.

use crate::correct::{Plan, build};
use crate::lock::Lock;
use crate::rig::Rig;
use crate::views::Request;
use crate::warp::TracedMap;
use crate::warp::WarpMap;
use std::sync::{Arc, Mutex, OnceLock};

type Size = (u32, u32);
type Slot<V> = Arc<OnceLock<Arc<V>>>;

/// Cache of values by key. Threads that need different values do not wait for each other.
struct Made<K, V>(Mutex<Vec<(K, Slot<V>)>>);

impl<K: PartialEq, V> Made<K, V> {
    const fn nothing() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    fn get(&self, key: K, make: impl FnOnce() -> V) -> Arc<V> {
        let slot = {
            let mut all = self.0.locked();
            match all.iter().find(|(of, _)| *of == key) {
                Some((_, slot)) => slot.clone(),
                None => {
                    all.push((key, Slot::default()));
                    all[all.len() - 1].1.clone()
                }
            }
        };
        slot.get_or_init(|| Arc::new(make())).clone()
    }
}

pub fn read(text: &str) -> Rig {
    crate::rig::parse(text, "test", std::path::Path::new("")).unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// Returns the plan of a rig whose outputs have one size.
pub fn planned(rig: &Rig, size: Size) -> Arc<Plan> {
    static PLANS: Made<(Rig, Size), Plan> = Made::nothing();
    let sizes = vec![size; rig.outputs.len()];
    PLANS.get((rig.clone(), size), || {
        let request = Request { output_sizes: sizes, window: size, panel: false, primary: false, max_atlas: 8192 };
        build(rig, &request).expect("a plan")
    })
}

/// Returns the exact map of an output.
pub fn exact(rig: &Rig, output: usize, size: Size) -> Arc<TracedMap> {
    static MAPS: Made<WarpMap, TracedMap> = Made::nothing();
    let map = WarpMap::new(rig, output, size, None).expect("a map");
    MAPS.get(map.clone(), || TracedMap::new(map))
}
