//! Replacement of the fixed-function pipeline, since only shaders can project its vertices to a
//! lens. A program of Cupola replaces the vertex stage while a draw of the scene is issued.
//!
//! [`pipeline`] has the switches of the stage that are on, [`shader_text`] the shader that does the
//! same. There is a program for each state of the switches that the application has used. The
//! stages that follow (textures, fog, blending) are still those of the pipeline.
//!
//! If primitives have to be divided, [`vertices`] are read from the recorded commands or from
//! [`arrays`] and become triangles and lines ([`assembly`]). The driver gets them together with the
//! new vertices between them ([`division`]).

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::projected::matrices::LensConstants;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::context::{errors, list_recording, methods};
use crate::intercept::gl::projected_vertices::fixed_function::shader_text;
use crate::intercept::gl::shader::linking;
use crate::intercept::gl::shader::source::patch::{self, Stage};
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::projected_vertices::ProjectedVertices;
use crate::intercept::gl::state::projected_vertices::fixed_pipeline::Pipeline;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::programs::Program;
use crate::intercept::process::call_sum;
use crate::intercept::scene::obstacle::Obstacle;
use std::sync::Arc;

/// Uses a program that does the same as the pipeline's vertex stage.
///
/// # Errors
/// The reason why there is no such program, for the log.
pub fn begin(ctx: &mut Context) -> Result<(), Obstacle> {
    if ctx.shaders.program().is_some() || ctx.shaders.used() != 0 {
        return Err("a program has shaders for fragments only".into());
    }
    // SAFETY: asks for a switch that the program has used.
    if ctx.app.assembly() && unsafe { ctx.driver.gl.is_enabled(api::GL_VERTEX_PROGRAM_ARB) } != 0 {
        return Err("the program's vertices go through a program in assembly language".into());
    }
    if ctx.projected.pipeline().is_none() {
        let pipeline = Pipeline::read(&ctx.driver);
        errors::drop_errors(ctx.driver.gl);
        ctx.projected.note_pipeline(pipeline);
    }
    let (program, two_sided, separate) = match ctx.projected.pipeline() {
        Some(Ok(pipeline)) => {
            let lighting = pipeline.lighting.unwrap_or_default();
            (ctx.projected.stand_in(pipeline), lighting.two_sided, lighting.separate_specular)
        }
        Some(Err(why)) => return Err(why.clone()),
        None => return Err("the state of the pipeline is not known".into()),
    };
    let program = match program {
        Some(program) => program,
        None => make(ctx)?,
    };
    let gl = ctx.driver.gl;
    // The pipeline takes these two settings from its lighting, shaders take them from switches.
    let wanted = [(two_sided, api::GL_VERTEX_PROGRAM_TWO_SIDE), (separate, api::GL_COLOR_SUM)];
    let mut switched = Vec::new();
    // SAFETY: switches of OpenGL 2.0, put back in `end`; a program of Cupola.
    unsafe {
        for (_, switch) in wanted.into_iter().filter(|(wanted, switch)| *wanted && gl.is_enabled(*switch) == 0) {
            gl.enable(switch);
            switched.push(switch);
        }
        gl.use_program(program.name);
    }
    ctx.shaders.use_stand_in(program);
    ctx.projected.use_stand_in(switched);
    Ok(())
}

/// Uses the pipeline again, if a program has replaced it.
pub fn end(driver: &Driver, shaders: &mut Shaders, projected: &mut ProjectedVertices) {
    let Some(switched) = projected.end_stand_in() else { return };
    shaders.end_stand_in();
    // SAFETY: restores the state before `begin`.
    unsafe {
        for switch in switched {
            driver.gl.disable(switch);
        }
        driver.gl.use_program(0);
    }
}

/// True if a primitive has the colour, and with lighting the normal, of one vertex.
pub(super) fn is_flat(projected: &ProjectedVertices) -> bool {
    matches!(projected.pipeline(), Some(Ok(pipeline)) if pipeline.flat)
}

/// True if the processor has to read the vertices of the next draw of `mode`, in order to divide
/// them for a view.
pub fn reads(app: &AppState, drawable: &Drawable, shaders: &Shaders, mode: u32) -> bool {
    let divides = drawable.target().is_some_and(|target| target.lenses.iter().any(LensConstants::divides));
    divides && !app.picking() && !app.feedback() && shaders.program().is_none() && mode != api::GL_POINTS
}

/// Links the program for the present switches.
fn make(ctx: &mut Context) -> Result<Arc<Program>, Obstacle> {
    let Some(Ok(pipeline)) = ctx.projected.pipeline().cloned() else {
        return Err("the state of the pipeline is not known".into());
    };
    let own = shader_text::text(&pipeline);
    let patched = patch::patch(&own, Stage::Vertex, false, true).unwrap_or_default();
    let program = {
        let ctx: &mut Context = &mut OwnCalls::without_messages(ctx);
        ctx.driver.take_errors();
        let program = linking::of_own_text(&ctx.driver, &patched, own.into(), pipeline.flat);
        errors::drop_errors(ctx.driver.gl);
        program
    };
    ctx.frame.note_linked(1);
    let Some(program) = program.map(Arc::new) else {
        let why = Obstacle::from("the driver does not link the shader that replaces the fixed-function pipeline");
        ctx.projected.note_pipeline(Err(why.clone()));
        return Err(why);
    };
    ctx.projected.store_stand_in(pipeline, program.clone());
    Ok(program)
}

/// Runs a command that sets a switch. While a display list is compiled, the command becomes an item
/// of its own, so that each draw of the list gets the right program.
pub fn switch(ctx: &mut Context, run: impl Fn(&Gl) + Send + Sync + 'static) {
    if !methods::asked_for() {
        run(ctx.driver.gl);
        return;
    }
    list_recording::now_or_later(ctx, move |ctx| {
        ctx.projected.note_switch();
        run(ctx.driver.gl);
    });
}

/// Returns the first four numbers of an array, or the number that `name` has: planes and colours
/// have four, all others one.
///
/// # Safety
/// `values` must hold these numbers, as the program promises OpenGL.
unsafe fn four<T: Copy + Default>(name: u32, values: *const T) -> [T; 4] {
    let many = [api::GL_OBJECT_PLANE, api::GL_EYE_PLANE, api::GL_FOG_COLOR, api::GL_LIGHT_MODEL_AMBIENT];
    let count = if many.contains(&name) { 4 } else { 1 };
    // SAFETY: as promised.
    unsafe { call_sum::add_values(values, count) };
    // SAFETY: as promised; the array may be unaligned.
    std::array::from_fn(|i| if i < count { unsafe { values.add(i).read_unaligned() } } else { T::default() })
}

hooks! {
    "glShadeModel" shade_model(mode: u32) = |ctx, _gl| switch(ctx, move |gl| gl.shade_model(mode));
    "glColorMaterial" color_material(face: u32, mode: u32) = |ctx, _gl| switch(ctx, move |gl| gl.color_material(face, mode));
    "glLightModelf" light_modelf(name: u32, value: f32) = |ctx, _gl| switch(ctx, move |gl| gl.light_modelf(name, value));
    "glLightModeli" light_modeli(name: u32, value: i32) = |ctx, _gl| switch(ctx, move |gl| gl.light_modeli(name, value));
    "glLightModelfv" light_modelfv(name: u32, values: *const f32) = |ctx, _gl| {
        let values = four(name, values);
        switch(ctx, move |gl| gl.light_modelfv(name, values.as_ptr()));
    };
    "glLightModeliv" light_modeliv(name: u32, values: *const i32) = |ctx, _gl| {
        let values = four(name, values);
        switch(ctx, move |gl| gl.light_modeliv(name, values.as_ptr()));
    };
    "glFogf" fogf(name: u32, value: f32) = |ctx, _gl| switch(ctx, move |gl| gl.fogf(name, value));
    "glFogi" fogi(name: u32, value: i32) = |ctx, _gl| switch(ctx, move |gl| gl.fogi(name, value));
    "glFogfv" fogfv(name: u32, values: *const f32) = |ctx, _gl| {
        let values = four(name, values);
        switch(ctx, move |gl| gl.fogfv(name, values.as_ptr()));
    };
    "glFogiv" fogiv(name: u32, values: *const i32) = |ctx, _gl| {
        let values = four(name, values);
        switch(ctx, move |gl| gl.fogiv(name, values.as_ptr()));
    };
    "glTexGenf" tex_genf(coordinate: u32, name: u32, value: f32) = |ctx, _gl| switch(ctx, move |gl| gl.tex_genf(coordinate, name, value));
    "glTexGend" tex_gend(coordinate: u32, name: u32, value: f64) = |ctx, _gl| switch(ctx, move |gl| gl.tex_gend(coordinate, name, value));
    "glTexGeni" tex_geni(coordinate: u32, name: u32, value: i32) = |ctx, _gl| switch(ctx, move |gl| gl.tex_geni(coordinate, name, value));
    "glTexGenfv" tex_genfv(coordinate: u32, name: u32, values: *const f32) = |ctx, _gl| {
        let values = four(name, values);
        switch(ctx, move |gl| gl.tex_genfv(coordinate, name, values.as_ptr()));
    };
    "glTexGendv" tex_gendv(coordinate: u32, name: u32, values: *const f64) = |ctx, _gl| {
        let values = four(name, values);
        switch(ctx, move |gl| gl.tex_gendv(coordinate, name, values.as_ptr()));
    };
    "glTexGeniv" tex_geniv(coordinate: u32, name: u32, values: *const i32) = |ctx, _gl| {
        let values = four(name, values);
        switch(ctx, move |gl| gl.tex_geniv(coordinate, name, values.as_ptr()));
    };
}
