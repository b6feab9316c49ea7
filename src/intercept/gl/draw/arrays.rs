//! Draws from arrays, and boxes around their vertices.
//!
//! Arrays in the program's memory are read at every draw, since they may change without a call.
//! Arrays in buffers are read once, and again only after the buffer has changed
//! ([`crate::intercept::gl::vertex_input::ranges`]).

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::draw::commands::draw_command;
use crate::intercept::gl::draw::divided;
use crate::intercept::gl::per_view::culling::position;
use crate::intercept::gl::projected_vertices;
use crate::intercept::gl::state::draw::bounds::Bounds;
use crate::intercept::gl::state::draw::primitives::Shape;
use crate::intercept::gl::state::vertex_input::vertex_ranges::{Layout, Vertices};
use crate::intercept::gl::vertex_input::ranges::{self, index_at, index_width, restarts};
use crate::intercept::gl::vertex_input::vertex_arrays;
use crate::intercept::process::call_sum;
use std::ffi::c_void;

/// Returns a box around `vertices` of the arrays that the program has set.
///
/// # Safety
/// The arrays must hold the vertices, as the program guarantees to OpenGL.
pub unsafe fn around(ctx: &mut Context, vertices: Vertices) -> Bounds {
    // SAFETY: as promised.
    unsafe { find(ctx, vertices) }.unwrap_or(Bounds::UNKNOWN)
}

/// Adds a box around vertices in the program's memory to the checksum of the frame's calls. Arrays in
/// buffers are summed when they are filled; an enabled array without memory has no vertices.
///
/// # Safety
/// As for [`around`].
unsafe fn sum_up(ctx: &mut Context, vertices: Vertices) {
    if !call_sum::is_on() || ctx.compiling() {
        return;
    }
    let array = position::array(&ctx.driver, &ctx.app, &ctx.shaders);
    let layout =
        array.and_then(|(array, components)| Layout::of(&ctx.driver, &mut ctx.vertex_input, array, components));
    if layout.is_some_and(|layout| layout.buffer == 0 && layout.start != 0) {
        // SAFETY: as promised.
        let known = unsafe { around(ctx, vertices) }.known();
        let corners = known.into_iter().flat_map(|(low, high)| [low, high]).flat_map(|corner| corner.to_array());
        corners.for_each(|value| call_sum::add(value.to_bits()));
    }
}

/// # Safety
/// As for [`around`].
unsafe fn find(ctx: &mut Context, vertices: Vertices) -> Option<Bounds> {
    let (array, components) = position::array(&ctx.driver, &ctx.app, &ctx.shaders)?;
    let layout = Layout::of(&ctx.driver, &mut ctx.vertex_input, array, components)?;
    match vertices {
        Vertices::Range { first, count } => {
            let (start, count) = (usize::try_from(first).ok()?, usize::try_from(count).ok()?);
            if layout.buffer == 0 {
                // SAFETY: as promised.
                Some(unsafe { ranges::in_memory(&layout, layout.start as *const u8, start..start + count) })
            } else if ctx.compiling() {
                // The range is read once, when the vertices become part of the display list.
                ranges::in_buffer(ctx.driver.gl, &ctx.driver.profile, &layout, start..start + count)
            } else {
                Some(ranges::around(&ctx.share, &ctx.driver, &mut ctx.vertex_input, layout, vertices, 0))
            }
        }
        Vertices::Elements { count, kind, indices, base } => {
            if restarts(&ctx.driver) {
                return None;
            }
            let buffer = vertex_arrays::elements(&ctx.share, &ctx.driver, &mut ctx.vertex_input);
            if buffer != 0 {
                let known = layout.buffer != 0 && !ctx.compiling();
                return known
                    .then(|| ranges::around(&ctx.share, &ctx.driver, &mut ctx.vertex_input, layout, vertices, buffer));
            }
            index_width(kind).filter(|_| !indices.is_null() && base == 0)?;
            let numbers = 0..usize::try_from(count).ok()?;
            // SAFETY: as promised: `count` indices of the type `kind`.
            let numbers = numbers.map(|number| unsafe { index_at(indices.cast(), kind, number) } as usize);
            if layout.buffer == 0 {
                // SAFETY: as promised.
                Some(unsafe { ranges::in_memory(&layout, layout.start as *const u8, numbers) })
            } else if ctx.compiling() {
                ranges::in_buffer(ctx.driver.gl, &ctx.driver.profile, &layout, numbers)
            } else {
                None
            }
        }
    }
}

/// Returns a box around the vertices of several draws. `vertices` gives the vertices of each draw.
///
/// # Safety
/// As for [`around`], for each of the draws.
unsafe fn around_all(ctx: &mut Context, draws: i32, vertices: impl Fn(usize) -> Vertices) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for index in 0..usize::try_from(draws).unwrap_or(0) {
        // SAFETY: as promised.
        bounds.join(&unsafe { around(ctx, vertices(index)) });
        if bounds.known().is_none() {
            return Bounds::UNKNOWN;
        }
    }
    bounds
}

/// Hooks of draws from the arrays that the program has set. All instances have the same vertices.
/// The prover knows nothing of the attributes that differ between instances, so the position of a
/// proven draw does not depend on them.
macro_rules! array_hooks {
    ($( $name:literal $method:ident ( $($p:ident : $t:ty),* ) of $vertices:expr $(, from $instance:expr)?; )*) => {
        hooks! {
            $( $name $method(mode: u32, $($p: $t),*) = |ctx, _gl| {
                sum_up(ctx, $vertices);
                let read = projected_vertices::read_arrays(ctx, mode, $vertices);
                let bounds = |ctx: &mut Context| around(ctx, $vertices);
                let issue = |ctx: &mut Context, gl: &Gl| gl.$method(ctx.draw.issued_mode(mode), $($p),*);
                ctx.draw.note_mode(mode);
                $( ctx.draw.note_first_instance($instance); )?
                match read {
                    Some(vertices) => divided::draw_arrays(ctx, mode, vertices, bounds, issue),
                    None => draw_command(ctx, Shape::of_mode(mode), bounds, issue),
                }
                ctx.draw.note_first_instance(0);
            }; )*
            "glMultiDrawArrays" multi_draw_arrays(mode: u32, first: *const i32, count: *const i32, draws: i32) = |ctx, _gl| {
                let vertices = |i: usize| Vertices::Range { first: *first.add(i), count: *count.add(i) };
                draw_command(ctx, Shape::of_mode(mode), |ctx: &mut Context| around_all(ctx, draws, vertices), |_, gl| {
                    gl.multi_draw_arrays(mode, first, count, draws);
                });
            };
            "glMultiDrawElements" multi_draw_elements(mode: u32, count: *const i32, kind: u32, indices: *const *const c_void, draws: i32) = |ctx, _gl| {
                let vertices = |i: usize| Vertices::Elements { count: *count.add(i), kind, indices: *indices.add(i), base: 0 };
                draw_command(ctx, Shape::of_mode(mode), |ctx: &mut Context| around_all(ctx, draws, vertices), |_, gl| {
                    gl.multi_draw_elements(mode, count, kind, indices, draws);
                });
            };
        }
    };
}

array_hooks! {
    "glDrawArrays" draw_arrays(first: i32, count: i32) of Vertices::Range { first, count };
    "glDrawArraysInstanced" draw_arrays_instanced(first: i32, count: i32, instances: i32) of Vertices::Range { first, count };
    "glDrawArraysInstancedBaseInstance" draw_arrays_instanced_base_instance(first: i32, count: i32, instances: i32, instance: u32) of Vertices::Range { first, count }, from instance;
    "glDrawElements" draw_elements(count: i32, kind: u32, indices: *const c_void) of Vertices::Elements { count, kind, indices, base: 0 };
    "glDrawElementsInstanced" draw_elements_instanced(count: i32, kind: u32, indices: *const c_void, instances: i32) of Vertices::Elements { count, kind, indices, base: 0 };
    "glDrawElementsInstancedBaseInstance" draw_elements_instanced_base_instance(count: i32, kind: u32, indices: *const c_void, instances: i32, instance: u32) of Vertices::Elements { count, kind, indices, base: 0 }, from instance;
    "glDrawElementsBaseVertex" draw_elements_base_vertex(count: i32, kind: u32, indices: *const c_void, base: i32) of Vertices::Elements { count, kind, indices, base };
    "glDrawElementsInstancedBaseVertex" draw_elements_instanced_base_vertex(count: i32, kind: u32, indices: *const c_void, instances: i32, base: i32) of Vertices::Elements { count, kind, indices, base };
    "glDrawElementsInstancedBaseVertexBaseInstance" draw_elements_instanced_base_vertex_base_instance(count: i32, kind: u32, indices: *const c_void, instances: i32, base: i32, instance: u32) of Vertices::Elements { count, kind, indices, base }, from instance;
    "glDrawRangeElements" draw_range_elements(start: u32, end: u32, count: i32, kind: u32, indices: *const c_void) of Vertices::Elements { count, kind, indices, base: 0 };
    "glDrawRangeElementsBaseVertex" draw_range_elements_base_vertex(start: u32, end: u32, count: i32, kind: u32, indices: *const c_void, base: i32) of Vertices::Elements { count, kind, indices, base };
}
