//! Record of one frame for `cupola inspect`: each pass, each draw, the matrices, the pictures.
//!
//! The modules of OpenGL and Vulkan describe each draw of the program's last frame ([`note_draw`]).
//! When the program ends, the record is written as a page ([`page`]). Nothing is recorded unless a
//! page was requested. [`last_frame`] writes the statistics and the pictures at the end;
//! [`common_statistics`] holds those of the statistics that come from the plan and the process.

pub mod common_statistics;
pub mod last_frame;
pub mod page;

use crate::intercept::process::settings::{Settings, settings};
use crate::intercept::scene::lens;
use crate::lock::Lock;
use crate::runtime::run_results::Picture;
use crate::runtime::session::Intrinsics;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU8, Ordering};

/// A 4×4 matrix that the lens of a draw may come from.
#[derive(Clone, Debug, PartialEq)]
pub struct MatrixNote {
    /// Its name in the shader.
    pub name: String,
    /// The form in which the program gives it.
    pub form: &'static str,
    /// Meaning of its numbers, in words.
    pub says: String,
}

impl MatrixNote {
    /// Describes a candidate of the search for the lens.
    pub fn new(name: impl Into<String>, form: &'static str, candidate: &lens::Candidate<'_>) -> Self {
        Self { name: name.into(), form, says: candidate.description() }
    }
}

/// Facts about a draw.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawNote {
    /// Draw class.
    pub class: &'static str,
    /// Reason for the draw class.
    pub why: String,
    /// Lens that it is drawn with.
    pub lens: Option<Intrinsics>,
    /// Shaders that draw it.
    pub shaders: String,
    /// Relevant state: depth test, blending and similar.
    pub state: String,
    /// Its matrices.
    pub matrices: Vec<MatrixNote>,
}

/// Consecutive draws to one target.
pub struct PassNote {
    /// Number of the context that draws. Names of framebuffers are valid in one context only.
    pub context: u64,
    /// Target of the draws.
    pub target: String,
    /// Whether the draws are issued once or once per view, and why.
    pub how: String,
    /// The draws; each with the number of draws like it.
    pub draws: Vec<(DrawNote, u64)>,
    /// Picture of the target after the draws.
    pub picture: Option<Picture>,
}

/// Greatest number of different draws of a pass that are described. Further draws are only counted.
const MOST_DRAWS: usize = 400;

/// Greatest number of passes of a frame that are described.
const MOST_PASSES: usize = 400;

static PASSES: Mutex<Vec<PassNote>> = Mutex::new(Vec::new());

/// State of the recording of draws: not known yet, off, on.
static RECORDING: AtomicU8 = AtomicU8::new(UNKNOWN);
const UNKNOWN: u8 = 0;
const OFF: u8 = 1;
const ON: u8 = 2;

/// True if the current frame is the one to describe.
#[inline]
pub fn is_recording() -> bool {
    match RECORDING.load(Ordering::Relaxed) {
        ON => true,
        OFF => false,
        _ => {
            let first = settings().is_some_and(|settings| settings.inspect.is_some() && settings.frames == Some(1));
            RECORDING.store(if first { ON } else { OFF }, Ordering::Relaxed);
            first
        }
    }
}

/// Begins a frame. `last`: the program ends after it.
pub fn begin_frame(settings: &Settings, last: bool) {
    if settings.inspect.is_some() && last && RECORDING.swap(ON, Ordering::Relaxed) != ON {
        PASSES.locked().clear();
    }
}

/// Notes a draw to `target` in the context with this number. For a new pass, `how` returns how its
/// draws are issued. Returns the number of the pass, if it is described.
pub fn note_draw(
    context: u64,
    target: &str,
    how: impl FnOnce() -> String,
    draw: DrawNote,
    number: u64,
) -> Option<usize> {
    let mut passes = PASSES.locked();
    if passes.last().is_none_or(|pass| pass.target != target || pass.context != context) {
        if passes.len() >= MOST_PASSES {
            return None;
        }
        passes.push(PassNote { context, target: target.to_owned(), how: how(), draws: Vec::new(), picture: None });
    }
    let pass = passes.last_mut()?;
    let full = pass.draws.len() >= MOST_DRAWS;
    match pass.draws.last_mut() {
        Some((known, count)) if full || *known == draw => *count += number,
        _ => pass.draws.push((draw, number)),
    }
    Some(passes.len() - 1)
}

/// Stores the picture of a pass.
pub fn note_picture(pass: usize, picture: Picture) {
    if let Some(pass) = PASSES.locked().get_mut(pass) {
        pass.picture = Some(picture);
    }
}

/// Takes the recorded passes.
pub fn take() -> Vec<PassNote> {
    std::mem::take(&mut *PASSES.locked())
}
