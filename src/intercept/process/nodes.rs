//! Several machines that show the same frame at the same time. The program waits here for the
//! others, through `cupola node`, which runs beside it.

use super::{call_sum, clock, log, settings};
use crate::lock::Lock;
use crate::nodes::{Gate, Page, Said};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock};

fn gate() -> Option<&'static Mutex<Gate>> {
    static GATE: OnceLock<Option<Mutex<Gate>>> = OnceLock::new();
    GATE.get_or_init(|| {
        let path = settings::settings()?.node_page.as_deref()?;
        match Page::open(path) {
            Ok(page) => {
                call_sum::begin();
                Some(Mutex::new(Gate::new(page)))
            }
            Err(error) => {
                log::once(&format!("this program shows its frames without the other nodes: {error}"));
                None
            }
        }
    })
    .as_ref()
}

/// True if there are other machines. Call it before the program draws, because its calls are summed
/// up from then on.
pub fn are_there() -> bool {
    gate().is_some()
}

/// Notes that a frame of the window with this handle is complete and will be shown next. The
/// program's time advances, and the program waits for the other machines. Returns `false` if the
/// others are ahead, so that the frame must not be shown.
pub fn end_frame(window: u64, size: impl FnOnce() -> (u32, u32)) -> bool {
    let leads = if clock::is_there() { clock::end_frame(window) } else { is_first(window) };
    let Some(gate) = gate().filter(|_| leads) else { return true };
    let passed = gate.locked().pass(call_sum::take(), clock::time().unwrap_or(0), size());
    if let Some(time) = passed.time {
        clock::advance(time);
    }
    let say = |words: &str| log::once(&format!("node {}: {words}", settings::settings().map_or(0, |s| s.node())));
    match passed.said {
        None => {}
        Some(Said::Alone) => {
            say("the other nodes do not answer in time: this program shows its frames without them until they do \
             (--time-out)")
        }
        Some(Said::InStep) => say("this program is in step with the other nodes again"),
        Some(Said::Left) => {
            say("this program has lost the other nodes, and shows its frames without them from now on");
        }
    }
    !passed.is_late
}

/// True if this window leads. Without a virtual clock the first window does.
fn is_first(window: u64) -> bool {
    static FIRST: AtomicU64 = AtomicU64::new(0);
    FIRST
        .compare_exchange(0, window, Ordering::Relaxed, Ordering::Relaxed)
        .map_or_else(|first| first == window, |_| true)
}
