//! Queries that count what the program draws, though each draw is issued once per view.
//!
//! OpenGL cannot pause a query. So what must not be counted as it is (our own work, a picture that
//! shows the same once more, the repetitions of a draw) is kept apart by ending the object that
//! counts and going on with one of Cupola's. The program gets the sum of these parts, each times
//! its factor:
//!
//! - samples: all views together, scaled so that what fills the program's own picture counts as
//!   many as that has. Samples outside the program's own picture count too: otherwise the program
//!   would not draw what only the dome shows. A count is at least 1 if anything was seen. Flat
//!   drawing counts once;
//! - primitives and the work of shaders on them: divided by the number of times that the draw was
//!   issued;
//! - time: without our own work;
//! - whether any samples passed: yes if any passed in any view.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::queries::{Count, Queries, Running, begin_real, end_real, kind, quantity, result};
use crate::intercept::scene::query_scaling::{QueryScaling, factor};
use crate::runtime::Session;

/// The next draw counts with these factors.
///
/// A query of the program is a sequence of queries of the driver, its parts, each with one factor.
/// A part whose factor is not chosen yet takes the first that is wanted. With another factor the
/// part ends and the next one begins; a factor of 0 needs no part. At the end the results are added
/// up, each times its factor.
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

/// Returns the number of samples of the program's own picture that one of the views' is worth.
/// Drawing that fills that picture counts as many samples as it has. `off_screen`: each view has as
/// many samples as that picture.
pub fn scene_samples(ctx: &mut Context, session: &Session, off_screen: bool) -> f64 {
    let Some(lens) = ctx.frame.lens else { return 1.0 };
    let seen = Some((lens, ctx.app.viewport, off_screen));
    if ctx.queries.seen != seen {
        let [width, height] = ctx.app.viewport.size().map(f64::from);
        let own = width * height;
        ctx.queries.worth = factor(own, session.samples(&lens, own, off_screen));
        ctx.queries.seen = seen;
    }
    ctx.queries.worth
}

/// `glBeginQuery`, `glBeginQueryIndexed`.
pub fn begin(driver: &mut Driver, queries: &mut Queries, target: u32, index: u32, name: u32) {
    let gl = driver.gl;
    let collides = |r: &Running| (kind(r.target) == kind(target) && r.index == index) || r.name == name;
    if queries.running.iter().any(collides) {
        // The driver may have another object of that kind now, or none.
        return driver.note_error(api::GL_INVALID_OPERATION);
    }
    driver.take_errors();
    begin_real(gl, target, index, name);
    // SAFETY: asks for the error flag. Only that says whether the driver takes the query.
    match unsafe { gl.get_error() } {
        api::GL_NO_ERROR => {
            if let Some(old) = queries.split.remove(&name) {
                queries.give_back(&old, name);
            }
            queries.wide = !driver.profile.es && driver.profile.version >= 33;
            let before = Count { target, ..Count::default() };
            queries.running.push(Running { target, index, name, now: Some((name, None)), before });
        }
        error => driver.note_error(error),
    }
}

/// `glEndQuery`, `glEndQueryIndexed`.
pub fn end(gl: &Gl, queries: &mut Queries, target: u32, index: u32) {
    let Some(number) = queries.running.iter().position(|r| r.target == target && r.index == index) else {
        // An error of the program's, for the driver to say.
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

/// The object that conditional rendering goes by, in place of the program's query: one that saw
/// something.
pub fn condition(gl: &Gl, queries: &Queries, name: u32) -> u32 {
    let seen = |count: &Count| count.parts.iter().find(|part| result(gl, queries.wide, part.0) > 0).map(|part| part.0);
    queries.split.get(&name).and_then(seen).unwrap_or(name)
}
