//! Scaling of query results, as each draw is issued once per view.
//!
//! OpenGL cannot pause a query. Three kinds of drawing need a factor of their own: internal drawing
//! of Cupola, the repetitions of a draw, and further pictures of the same draw. So the running
//! query object of the driver ends there and another one begins. The program gets the sum of these
//! parts, each multiplied by its factor:
//!
//! - Samples: the sum over all views, scaled so that drawing that fills the program's own picture
//!   counts as many samples as that picture has. Samples outside the program's own picture count
//!   too. Otherwise the program would leave out objects that are only visible on the dome. The
//!   result is at least 1 if any sample passed. Flat drawing counts once.
//! - Primitives, and the shader invocations for them: divided by the number of times that the draw
//!   was issued.
//! - Time: without internal drawing of Cupola.
//! - Whether any sample passed: true if any sample passed in any view.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::frame::Frame;
use crate::intercept::gl::state::queries::{
    Count, Queries, ResultBuffer, Running, begin_real, end_real, kind, quantity, result,
};
use crate::intercept::scene::query_scaling::{Quantity, QueryScaling, factor};
use crate::runtime::Session;

/// Sets the factors for the next draw.
///
/// A query of the program is a sequence of queries of the driver, its parts, each with one factor.
/// A part without a factor gets the first factor that is set. A different factor ends the part and
/// begins the next one. A factor of 0 needs no part. At the end the results of the parts are
/// multiplied by their factors and added.
pub fn scale(gl: &Gl, queries: &mut Queries, factors: QueryScaling) {
    for number in 0..queries.running.len() {
        let running = &mut queries.running[number];
        let wanted = factors.of(quantity(running.target));
        match &mut running.now {
            Some((_, factor)) if factor.is_none_or(|w| w == wanted) && wanted > 0.0 => *factor = Some(wanted),
            None if wanted == 0.0 => {}
            _ => {
                running.end_part(gl);
                if wanted > 0.0 {
                    queries.begin_part(gl, number, Some(wanted));
                }
            }
        }
    }
}

/// Returns the factor from samples in all views to samples in the program's own picture. Drawing
/// that fills that picture counts as many samples as the picture has. `off_screen`: each view has
/// as many samples as that picture.
pub fn scene_samples(
    app: &AppState,
    frame: &mut Frame,
    queries: &mut Queries,
    session: &Session,
    off_screen: bool,
) -> f64 {
    let Some(lens) = frame.lens() else { return 1.0 };
    let seen = Some((lens, app.viewport(), off_screen));
    if queries.seen != seen {
        let own = app.viewport().size().area() as f64;
        queries.worth = factor(own, session.samples(&lens, own, off_screen));
        queries.seen = seen;
    }
    queries.worth
}

/// `glBeginQuery`, `glBeginQueryIndexed`.
pub fn begin(driver: &mut Driver, queries: &mut Queries, target: u32, index: u32, name: u32) {
    let gl = driver.gl;
    let collides = |r: &Running| (kind(r.target) == kind(target) && r.index == index) || r.name == name;
    if queries.running.iter().any(collides) {
        // The driver may not see this error: it may have another query object of that kind, or
        // none.
        return driver.note_error(api::GL_INVALID_OPERATION);
    }
    driver.take_errors();
    begin_real(gl, target, index, name);
    // SAFETY: reads the error flag, which is the only sign whether the driver accepts the query.
    match unsafe { gl.get_error() } {
        api::GL_NO_ERROR => {
            if let Some(old) = queries.split.remove(&name) {
                queries.give_back(&old, name);
            }
            queries.wide = !driver.profile.es && driver.profile.version >= 33;
            queries.has_buffers = !driver.profile.es && driver.profile.version >= 44;
            let samples = kind(target) == api::GL_SAMPLES_PASSED;
            queries.have_counted |= samples || quantity(target) != Quantity::Unscaled;
            let before = Count { target, ..Count::default() };
            queries.running.push(Running { target, index, name, now: Some((name, None)), before });
        }
        error => driver.note_error(error),
    }
}

/// `glEndQuery`, `glEndQueryIndexed`.
pub fn end(gl: &Gl, queries: &mut Queries, target: u32, index: u32) {
    let Some(number) = queries.running.iter().position(|r| r.target == target && r.index == index) else {
        // An error of the program, which the driver reports.
        end_real(gl, target, index);
        return;
    };
    let mut running = queries.running.swap_remove(number);
    running.end_part(gl);
    let Running { name, before, .. } = running;
    if before.sum > 0.0 || before.parts != [(name, 1.0)] {
        queries.split.insert(name, before);
    }
}

/// Returns the object that conditional rendering uses in place of the program's query: a part of
/// the query with a result above 0, if there is one.
pub fn condition(gl: &Gl, queries: &Queries, name: u32) -> u32 {
    let _unbound = ResultBuffer::unbind(gl, queries.has_buffers);
    let seen = |count: &Count| count.parts.iter().find(|part| result(gl, queries.wide, part.0) > 0).map(|part| part.0);
    queries.split.get(&name).and_then(seen).unwrap_or(name)
}
