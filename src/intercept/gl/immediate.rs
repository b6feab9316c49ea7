//! Begin/End: recorded into a list of ours, which is then drawn like any other draw.

use super::culling::bounds::Bounds;
use super::draw::{Changes, draw};
use super::hook::hooks;
use super::lists::Command;
use crate::backend::gl::api::{self, Gl};

/// The current colour, normal and texture coordinate.
fn current_attributes(gl: &Gl) -> [[f32; 4]; 3] {
    let mut values = [[0.0; 4]; 3];
    let names = [api::GL_CURRENT_COLOR, api::GL_CURRENT_NORMAL, api::GL_CURRENT_TEXTURE_COORDS];
    for (value, name) in values.iter_mut().zip(names) {
        // SAFETY: writes four floats at most.
        unsafe { gl.get_floatv(name, value.as_mut_ptr()) };
    }
    values
}

/// Sets them to what they are, at the head of a list. A list in which an attribute comes only after
/// the first vertices (a colour before `glEnd`, for what follows) gives those vertices a wrong value
/// on Mesa unless it was set before them.
fn set_attributes(gl: &Gl, [color, normal, texture]: &[[f32; 4]; 3]) {
    // SAFETY: reads three or four floats.
    unsafe {
        gl.color4fv(color.as_ptr());
        gl.normal3fv(normal.as_ptr());
        gl.tex_coord4fv(texture.as_ptr());
    }
}

hooks! {
    "glBegin" begin(mode: u32) = |ctx, gl| {
        if let Some(recording) = &mut ctx.recording {
            recording.draws = true;
        } else if ctx.target.is_some() && !ctx.picking {
            if ctx.begin_list == 0 {
                ctx.begin_list = super::lists::own_name(ctx);
            }
            let attributes = current_attributes(gl);
            gl.new_list(ctx.begin_list, api::GL_COMPILE);
            set_attributes(gl, &attributes);
            ctx.in_begin = true;
            ctx.begin_bounds = Bounds::EMPTY;
        } else {
            super::draw::plain_program(ctx);
        }
        gl.begin(mode);
    };
    "glEnd" end() = |ctx, gl| {
        gl.end();
        if ctx.in_begin {
            gl.end_list();
            ctx.in_begin = false;
            let list = ctx.begin_list;
            let bounds = ctx.begin_bounds;
            draw(ctx, Changes::Attributes, &bounds, |_, gl| gl.call_list(list));
            super::attributes::restore(gl, &mut ctx.last_attributes);
        }
    };
    "glRenderMode" render_mode(mode: u32) -> i32 = |ctx, gl| {
        ctx.picking = mode != api::GL_RENDER;
        if ctx.picking && ctx.redirected() {
            ctx.set_viewport(ctx.believed.viewport);
        }
        gl.render_mode(mode)
    };
    "glUseProgram" use_program(program: u32) = |ctx, _gl| {
        if ctx.compiling() {
            super::lists::record(ctx, Command::UseProgram(program));
        } else {
            super::programs::use_program(ctx, program);
        }
    };
}
