//! Calls that make points and lines wider than a pixel.

use crate::intercept::gl::context::hooks::hooks;

hooks! {
    "glPointSize" point_size(size: f32) = |ctx, gl| {
        ctx.draw.note_width(size);
        gl.point_size(size);
    };
    "glLineWidth" line_width(width: f32) = |ctx, gl| {
        ctx.draw.note_width(width);
        gl.line_width(width);
    };
    "glPointParameterf" point_parameterf(name: u32, value: f32) = |ctx, gl| {
        ctx.draw.note_unknown_width();
        gl.point_parameterf(name, value);
    };
    "glPointParameterfv" point_parameterfv(name: u32, values: *const f32) = |ctx, gl| {
        ctx.draw.note_unknown_width();
        gl.point_parameterfv(name, values);
    };
    "glPointParameteri" point_parameteri(name: u32, value: i32) = |ctx, gl| {
        ctx.draw.note_unknown_width();
        gl.point_parameteri(name, value);
    };
    "glPointParameteriv" point_parameteriv(name: u32, values: *const i32) = |ctx, gl| {
        ctx.draw.note_unknown_width();
        gl.point_parameteriv(name, values);
    };
}
