//! Begin/End: recorded into a list of ours, which is then drawn like any other draw.

use super::draw::{Changes, draw};
use super::hook::hooks;
use super::lists::Command;
use crate::backend::gl::api;

hooks! {
    "glBegin" begin(mode: u32) = |ctx, gl| {
        if let Some(recording) = &mut ctx.recording {
            recording.draws = true;
        } else if ctx.redirected() && !ctx.picking {
            if ctx.begin_list == 0 {
                ctx.begin_list = super::lists::own_name(ctx);
            }
            gl.new_list(ctx.begin_list, api::GL_COMPILE);
            ctx.in_begin = true;
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
            draw(ctx, Changes::Attributes, |_, gl| gl.call_list(list));
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
