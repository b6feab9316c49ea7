//! State of a Begin/End: the phase and the recorded commands.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::compat::vertex_recorder::Recorder;
use crate::intercept::gl::state::draw::bounds::Bounds;

/// Phase of the program in a Begin/End.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// Outside of Begin/End, or inside one that is passed on unchanged.
    #[default]
    Outside,
    /// Commands are recorded, and the driver is between Begin and End without vertices.
    Recording,
    /// Elements of arrays go into a list of Cupola, since the program may change its arrays before
    /// the End.
    Elements,
}

/// The Begin/End that the program is in.
pub struct Immediate {
    /// Phase of the program.
    pub phase: Phase,
    pub(in crate::intercept::gl) mode: u32,
    pub(in crate::intercept::gl) recorder: Recorder,
    /// Box around the vertices since `glBegin`.
    pub(in crate::intercept::gl) bounds: Bounds,
    /// Number of generic attributes of a vertex.
    pub(in crate::intercept::gl) generic_attributes: u32,
    /// Lists of Cupola, one for each sequence of elements.
    pub(in crate::intercept::gl) lists: Vec<u32>,
    /// Number of these lists that hold elements of this Begin/End.
    pub(in crate::intercept::gl) used_lists: usize,
    /// True if `glBegin` lies in a list that was recorded.
    pub(in crate::intercept::gl) begun_by_list: bool,
    /// True if the commands become an item of a list, and the driver is not between Begin and End.
    pub(in crate::intercept::gl) apart: bool,
    /// True if `glBegin` was passed on unchanged. The driver may be between Begin and End.
    pub(in crate::intercept::gl) passed_on: bool,
}

impl Default for Immediate {
    fn default() -> Self {
        let (phase, recorder, bounds) = (Phase::Outside, Recorder::default(), Bounds::EMPTY);
        Self {
            phase,
            mode: 0,
            recorder,
            bounds,
            generic_attributes: 0,
            lists: Vec::new(),
            used_lists: 0,
            begun_by_list: false,
            apart: false,
            passed_on: false,
        }
    }
}

impl Immediate {
    /// True between `glBegin` and `glEnd` of a draw of Cupola.
    pub fn under_way(&self) -> bool {
        self.phase != Phase::Outside
    }

    pub(in crate::intercept::gl) fn begin(&mut self, mode: u32, generic_attributes: u32) {
        self.phase = Phase::Recording;
        self.mode = mode;
        self.generic_attributes = generic_attributes;
        self.recorder.clear();
        self.bounds = Bounds::EMPTY;
        self.begun_by_list = false;
        self.apart = false;
        self.used_lists = 0;
    }

    /// True if the driver is to refuse a command that is not allowed between Begin and End.
    pub fn refuses(&mut self, gl: &Gl) -> bool {
        self.close_elements(gl);
        if self.under_way() {
            if !self.apart && !is_between(gl) {
                self.was_refused(gl);
            }
            return self.under_way();
        }
        self.passed_on = self.passed_on && is_between(gl);
        self.passed_on
    }

    /// The driver has refused the program's `glBegin`, and with it the commands since then.
    fn was_refused(&mut self, gl: &Gl) {
        self.phase = Phase::Outside;
        // SAFETY: the program's own commands, outside of Begin/End, as without Cupola.
        unsafe { self.recorder.play(gl) };
    }

    /// Ends the open list of elements, if there is one.
    pub(in crate::intercept::gl) fn close_elements(&mut self, gl: &Gl) {
        if self.phase == Phase::Elements {
            let list = self.lists.get(self.used_lists).copied().unwrap_or_default();
            self.used_lists += 1;
            self.recorder.push_list(list);
            self.phase = Phase::Recording;
            // SAFETY: ends a list of Cupola. Then the driver is between Begin and End, as the
            // program is.
            unsafe {
                gl.end_list();
                gl.begin(list_of(self.mode));
            }
        }
    }
}

/// True if the driver is between Begin and End. It answers no question there. The question causes
/// the same error as the command that follows.
fn is_between(gl: &Gl) -> bool {
    let mut mode = 0;
    // SAFETY: a query of the compatibility profile; it writes one value, which is never 0.
    unsafe { gl.get_integerv(api::GL_MATRIX_MODE, &mut mode) };
    mode == 0
}

/// Returns the mode of separate primitives that causes the same errors as `mode`. While Cupola
/// records, the driver is between Begin and End in this mode, without vertices. With strips, fans
/// or polygons Mesa would drop the next one of the same mode after such an empty one.
pub(in crate::intercept::gl) fn list_of(mode: u32) -> u32 {
    match mode {
        api::GL_LINE_LOOP | api::GL_LINE_STRIP => api::GL_LINES,
        api::GL_TRIANGLE_STRIP | api::GL_TRIANGLE_FAN | api::GL_QUAD_STRIP | api::GL_POLYGON => api::GL_TRIANGLES,
        api::GL_LINE_STRIP_ADJACENCY => api::GL_LINES_ADJACENCY,
        api::GL_TRIANGLE_STRIP_ADJACENCY => api::GL_TRIANGLES_ADJACENCY,
        _ => mode,
    }
}
