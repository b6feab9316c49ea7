//! Answers to the program's questions about its queries: the program's own names, and the sums of
//! the parts of each query.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::{hooks, list_recording};
use crate::intercept::gl::queries::scaling::{begin, end};
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::queries::{Count, Queries, ResultBuffer, available};
use crate::intercept::gl::vertex_input::buffers;

/// Returns true if the program's query is running. In that case records the error that OpenGL gives
/// to a question for its result.
fn refuses(driver: &mut Driver, queries: &Queries, name: u32) -> bool {
    let runs = queries.running.iter().any(|r| r.name == name);
    if runs {
        driver.note_error(api::GL_INVALID_OPERATION);
    }
    runs
}

/// Returns Cupola's answer to a question about a query whose result is spread over several objects.
/// `None`: the driver answers.
fn answer(driver: &Driver, queries: &Queries, name: u32, what: u32) -> Option<u64> {
    let count = queries.split.get(&name)?;
    let ready = || count.parts.iter().all(|part| available(driver.gl, part.0));
    let _unbound = ResultBuffer::unbind(driver.gl, queries.has_buffers);
    match what {
        api::GL_QUERY_RESULT => Some(count.total(driver.gl, queries.wide)),
        api::GL_QUERY_RESULT_NO_WAIT if ready() => Some(count.total(driver.gl, queries.wide)),
        api::GL_QUERY_RESULT_AVAILABLE => Some(u64::from(ready())),
        _ => None,
    }
}

/// Writes an answer to the program's memory or, if a buffer for results is bound, to that buffer.
///
/// # Safety
/// `values` must point at writable memory for a `T`, or be an offset if a buffer for results is
/// bound.
unsafe fn write<T: Copy>(driver: &mut Driver, queries: &Queries, value: T, values: *mut T) {
    if ResultBuffer::unbind(driver.gl, queries.has_buffers).name() != 0 {
        write_to_buffer(driver, Target::Bound, values as isize, value);
    } else if !values.is_null() {
        // SAFETY: `values` points at memory for a `T`, as the caller guarantees.
        unsafe { values.write(value) };
    }
}

/// Returns the program's name of the running query of this target. `None` if no query of the
/// program is known to run there.
fn current(queries: &Queries, target: u32, index: u32) -> Option<u32> {
    queries.running.iter().find(|r| r.target == target && r.index == index).map(|r| r.name)
}

/// Forgets deleted queries.
fn forget(gl: &Gl, queries: &mut Queries, names: &[u32]) {
    for name in names.iter().filter(|name| **name != 0) {
        if let Some(number) = queries.running.iter().position(|r| r.name == *name) {
            let mut running = queries.running.swap_remove(number);
            running.end_part(gl);
            queries.give_back(&running.before, *name);
        }
        if let Some(count) = queries.split.remove(name) {
            queries.give_back(&count, *name);
        }
    }
}

/// Returns true if `name` is a query object of Cupola, which the program must not see.
fn is_own(queries: &Queries, name: u32) -> bool {
    let part = |count: &Count, of: u32| name != of && count.parts.iter().any(|part| part.0 == name);
    queries.own.iter().any(|own| own.1 == name)
        || queries.fresh.contains(&name)
        || queries.split.iter().any(|(of, count)| part(count, *of))
        || queries
            .running
            .iter()
            .any(|r| part(&r.before, r.name) || r.now.is_some_and(|n| n.0 == name && name != r.name))
}

/// A buffer of the program for results.
#[derive(Clone, Copy)]
enum Target {
    /// The one that is bound for results.
    Bound,
    /// The one with this name.
    Named(u32),
}

/// Writes an answer into a buffer of the program, also if only the device may change its contents (immutable storage
/// without `GL_DYNAMIC_STORAGE_BIT`): such buffers can be cleared, word by word.
fn write_to_buffer<T: Copy>(driver: &mut Driver, buffer: Target, offset: isize, value: T) {
    driver.take_errors();
    let (gl, from) = (driver.gl, (&raw const value).cast::<u8>());
    let whole = size_of::<T>() as isize;
    let step = if offset % 4 == 0 { 4 } else { whole };
    let mut error = api::GL_NO_ERROR;
    // The last word first: if the buffer is too short, nothing is written.
    for at in (0..whole).step_by(step as usize).rev() {
        let clear = (api::GL_R32UI, offset + at, 4, api::GL_RED_INTEGER, api::GL_UNSIGNED_INT);
        // SAFETY: the word lies in `value`. The driver checks the place in the buffer.
        error = unsafe {
            let word = from.offset(at).cast();
            match (buffer, step == 4) {
                (Target::Bound, true) => {
                    gl.clear_buffer_sub_data(api::GL_QUERY_BUFFER, clear.0, clear.1, clear.2, clear.3, clear.4, word);
                }
                (Target::Named(name), true) => {
                    gl.clear_named_buffer_sub_data(name, clear.0, clear.1, clear.2, clear.3, clear.4, word);
                }
                // Clearing needs a place that is a multiple of four.
                (Target::Bound, false) => gl.buffer_sub_data(api::GL_QUERY_BUFFER, offset, whole, word),
                (Target::Named(name), false) => gl.named_buffer_sub_data(name, offset, whole, word),
            }
            gl.get_error()
        };
        if error != api::GL_NO_ERROR {
            break;
        }
    }
    if error != api::GL_NO_ERROR {
        // For a query beyond the end of the buffer is a wrong operation, not a wrong value.
        driver.note_error(if offset < 0 { error } else { api::GL_INVALID_OPERATION });
    }
}

macro_rules! counting_hooks {
    ($( $name:literal $method:ident $t:ty, $buffer_name:literal $buffer_method:ident; )*) => {
        hooks::hooks! {
            "glBeginQuery" begin_query(target: u32, name: u32) = |ctx, _gl|
                list_recording::now_or_later(ctx, move |ctx| begin(&mut ctx.driver, &mut ctx.queries, target, 0, name));
            "glEndQuery" end_query(target: u32) = |ctx, _gl| list_recording::now_or_later(ctx, move |ctx| end(ctx.driver.gl, &mut ctx.queries, target, 0));
            "glBeginQueryIndexed" begin_query_indexed(target: u32, index: u32, name: u32) = |ctx, _gl|
                list_recording::now_or_later(ctx, move |ctx| begin(&mut ctx.driver, &mut ctx.queries, target, index, name));
            "glEndQueryIndexed" end_query_indexed(target: u32, index: u32) = |ctx, _gl|
                list_recording::now_or_later(ctx, move |ctx| end(ctx.driver.gl, &mut ctx.queries, target, index));
            "glDeleteQueries" delete_queries(count: i32, names: *const u32) = |ctx, gl| {
                if !names.is_null() {
                    forget(gl, &mut ctx.queries, std::slice::from_raw_parts(names, usize::try_from(count).unwrap_or(0)));
                }
                gl.delete_queries(count, names);
            };
            "glIsQuery" is_query(name: u32) -> u8 = |ctx, gl| if is_own(&ctx.queries, name) { 0 } else { gl.is_query(name) };
            "glGetQueryiv" get_queryiv(target: u32, what: u32, values: *mut i32) = |ctx, gl| {
                match current(&ctx.queries, target, 0).filter(|_| what == api::GL_CURRENT_QUERY && !values.is_null()) {
                    Some(name) => *values = name as i32,
                    None => gl.get_queryiv(target, what, values),
                }
            };
            "glGetQueryIndexediv" get_query_indexediv(target: u32, index: u32, what: u32, values: *mut i32) = |ctx, gl| {
                match current(&ctx.queries, target, index).filter(|_| what == api::GL_CURRENT_QUERY && !values.is_null()) {
                    Some(name) => *values = name as i32,
                    None => gl.get_query_indexediv(target, index, what, values),
                }
            };
            $(
                $name $method(name: u32, what: u32, values: *mut $t) = |ctx, gl| {
                    if !refuses(&mut ctx.driver, &ctx.queries, name) {
                        match answer(&ctx.driver, &ctx.queries, name, what) {
                            Some(count) => write(&mut ctx.driver, &ctx.queries, <$t>::try_from(count).unwrap_or(<$t>::MAX), values),
                            None => gl.$method(name, what, values),
                        }
                    }
                };
                $buffer_name $buffer_method(name: u32, buffer: u32, what: u32, offset: isize) = |ctx, gl| {
                    buffers::written_by_device(&ctx.share, buffer);
                    if !refuses(&mut ctx.driver, &ctx.queries, name) {
                        match answer(&ctx.driver, &ctx.queries, name, what) {
                            Some(count) => {
                                write_to_buffer(&mut ctx.driver, Target::Named(buffer), offset, <$t>::try_from(count).unwrap_or(<$t>::MAX));
                            }
                            None => gl.$buffer_method(name, buffer, what, offset),
                        }
                    }
                };
            )*
        }
    };
}

counting_hooks! {
    "glGetQueryObjectiv" get_query_objectiv i32, "glGetQueryBufferObjectiv" get_query_buffer_objectiv;
    "glGetQueryObjectuiv" get_query_objectuiv u32, "glGetQueryBufferObjectuiv" get_query_buffer_objectuiv;
    "glGetQueryObjecti64v" get_query_objecti64v i64, "glGetQueryBufferObjecti64v" get_query_buffer_objecti64v;
    "glGetQueryObjectui64v" get_query_objectui64v u64, "glGetQueryBufferObjectui64v" get_query_buffer_objectui64v;
}
