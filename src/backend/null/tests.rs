//! Plans, passes and errors of the OpenGL backend, without a driver.

use super::{driver, fail_at, recorded, reset};
use crate::backend::gl::{GlBackend, Target};
use crate::correct::shaders::draws::{Rows, draws};
use crate::correct::{LowerLeftRect, PixelRect, Plan, build};
use crate::rig;
use crate::views::Request;

const WINDOW: (u32, u32) = (640, 360);

/// Returns the plan of a preset, and the places of its outputs in the window.
fn plan(name: &str) -> (Plan, Vec<LowerLeftRect>) {
    let rig = rig::load(name).expect("a preset");
    let places = rig.layout(WINDOW);
    let output_sizes = places.iter().map(|place| place.size()).collect();
    let request = Request { output_sizes, window: WINDOW, panel: true, primary: false, max_atlas: 16384 };
    (build(&rig, &request).expect("a plan"), places.into_iter().map(from_below).collect())
}

/// A rectangle of the window, from below.
fn from_below(PixelRect { x, y, width, height }: PixelRect) -> LowerLeftRect {
    LowerLeftRect::new(x as i32, (WINDOW.1 - y - height) as i32, width as i32, height as i32)
}

/// Returns the names of the presets that correct something.
fn presets() -> impl Iterator<Item = &'static str> {
    ["fisheye", "fisheye-210", "planetarium-2", "planetarium-6", "idome"].into_iter()
}

#[test]
fn each_output_is_drawn_in_its_place_with_the_triangles_of_its_plan() {
    for name in presets() {
        let (plan, places) = plan(name);
        let list = draws(&plan, &plan.passes, true, Rows::FromBottom).expect("draws");
        reset(LowerLeftRect::of_size(WINDOW));
        let gl = driver();
        let mut backend = GlBackend::new(&gl, false).expect("a version that is new enough");
        backend.prepare(&gl, &plan, true).expect("nothing fails");
        assert!(recorded().draws.is_empty(), "{name}: preparing draws nothing");
        let targets: Vec<Target> = places.iter().map(|place| Target { framebuffer: 0, viewport: *place }).collect();
        assert_eq!(backend.present(&gl, 1, &targets), 0, "{name}: no error is pending");
        let record = recorded();
        let drawn = |place: &LowerLeftRect| -> Vec<i32> {
            record.draws.iter().filter(|draw| draw.viewport == *place).map(|draw| draw.count).collect()
        };
        for (place, output) in places.iter().zip(&list.outputs) {
            let planned: Vec<i32> = output.iter().map(|draw| draw.count as i32).collect();
            assert_eq!(drawn(place), planned, "{name}");
        }
        assert_eq!(record.draws.len(), list.outputs.iter().map(Vec::len).sum::<usize>(), "{name}: nothing else");
        assert!(record.draws.iter().all(|draw| draw.program != 0 && draw.framebuffer == 0), "{name}");
        backend.destroy(&gl);
        assert!(recorded().alive.values().all(|count| *count == 0), "{name}: {:?}", recorded().alive);
    }
}

#[test]
fn a_second_frame_makes_and_links_nothing() {
    let (plan, places) = plan("planetarium-2");
    reset(LowerLeftRect::default());
    let gl = driver();
    let mut backend = GlBackend::new(&gl, false).expect("a version that is new enough");
    backend.prepare(&gl, &plan, true).expect("nothing fails");
    let targets: Vec<Target> = places.iter().map(|place| Target { framebuffer: 0, viewport: *place }).collect();
    backend.present(&gl, 1, &targets);
    let first = recorded();
    backend.present(&gl, 1, &targets);
    let second = recorded();
    assert_eq!(second.draws.len(), 2 * first.draws.len());
    assert_eq!((second.linked, &second.alive), (first.linked, &first.alive));
    assert!(first.linked > 0, "the control: something was linked");
}

/// The driver runs out of memory at each call of a preparation in turn. The preparation reports an
/// error or succeeds, and leaves no object behind.
#[test]
fn errors_while_preparing_leave_nothing_behind() {
    let (plan, _) = plan("planetarium-2");
    let prepare = |fails_at: Option<u64>| {
        reset(LowerLeftRect::default());
        let gl = driver();
        let mut backend = GlBackend::new(&gl, false).expect("a version that is new enough");
        fails_at.into_iter().for_each(fail_at);
        let result = backend.prepare(&gl, &plan, true);
        let calls = recorded().calls;
        backend.destroy(&gl);
        let alive: i64 = recorded().alive.values().sum();
        assert_eq!(alive, 0, "{fails_at:?}: {:?}", recorded().alive);
        (result.is_err(), calls)
    };
    let (failed, calls) = prepare(None);
    assert!(!failed);
    let refused = (1..calls).filter(|call| prepare(Some(*call)).0).count();
    assert!(refused > 0, "no error was noticed");
}
