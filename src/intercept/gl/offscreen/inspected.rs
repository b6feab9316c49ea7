//! Describes draws for `cupola inspect`.

use crate::backend::gl::driver::api;
use crate::correct::{LowerLeftRect, Size};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::read_pixels::read_back;
use crate::intercept::gl::offscreen::framebuffer_statistics;
use crate::intercept::gl::offscreen::view_copies::views;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::draw::draw_class::DrawClass;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::offscreen::framebuffers::Framebuffer;
use crate::intercept::gl::state::offscreen::images::{Image, Name, Set};
use crate::intercept::gl::state::offscreen::view_copies::InspectedPass;
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::camera_matrices::MatrixStage;
use crate::intercept::gl::state::shader::programs::Program;
use crate::intercept::gl::state::shader::uniforms::{Matrix, MatrixLocation};
use crate::intercept::inspection::{self, DrawNote, MatrixNote};
use crate::intercept::scene::lens::{Candidate, field_of_view};
use crate::lock::Lock;

/// Facts about a draw that the state does not contain.
pub struct Seen<'a> {
    /// Class of the draw.
    pub class: DrawClass,
    /// Followed images that its shaders read.
    pub sampled: Set,
    /// Reason for the class, if the class does not tell it.
    pub why: Option<&'a str>,
}

/// Describes a draw to the program's framebuffer, or to the window if none of its own is bound.
pub fn note(ctx: &mut Context, seen: &Seen<'_>) {
    if !inspection::is_recording() {
        return;
    }
    let target = target(&ctx.app, &ctx.drawable, &ctx.view_copies);
    if ctx.view_copies.inspected.as_ref().is_some_and(|pass| pass.target != target) {
        // The drawing to the previous target is complete.
        note_last_picture(&mut ctx.driver, &ctx.drawable, &mut ctx.view_copies);
    }
    let draw = DrawNote {
        class: class_name(seen),
        why: why(&ctx.app, &ctx.shaders, &ctx.view_copies, seen),
        lens: match seen.class {
            DrawClass::Scene(index) => ctx.frame.cameras().get(index).map(|camera| camera.intrinsics),
            DrawClass::FixedScene => ctx.frame.lens(),
            _ => None,
        },
        shaders: shaders(&ctx.shaders),
        state: state(&ctx.driver, &ctx.app),
        matrices: matrices(&ctx.driver, &ctx.shaders, &ctx.compat),
    };
    let number =
        inspection::note_draw(ctx.driver.id, &target, || how(&ctx.app, &ctx.drawable, &ctx.view_copies), draw, 1);
    let framebuffer = ctx.app.draw_framebuffer();
    ctx.view_copies.inspected = number.map(|number| InspectedPass { number, framebuffer, target });
}

/// Notes the picture of the last pass when the frame is complete.
pub fn end_frame(driver: &mut Driver, drawable: &Drawable, view_copies: &mut ViewCopies) {
    if inspection::is_recording() {
        note_last_picture(driver, drawable, view_copies);
    }
}

fn class_name(seen: &Seen<'_>) -> &'static str {
    match seen.class {
        DrawClass::FixedScene | DrawClass::Scene(_) => "scene",
        DrawClass::Flat if seen.sampled != 0 => "pass over the screen",
        DrawClass::Flat => "flat",
        DrawClass::Behind => "flat, behind the scene",
        DrawClass::Screen => "pass over the screen",
    }
}

fn why(app: &AppState, shaders: &Shaders, view_copies: &ViewCopies, seen: &Seen<'_>) -> String {
    let mut why = match (seen.why, seen.class) {
        (Some(why), _) => why.to_owned(),
        (None, DrawClass::FixedScene) => "fixed-function projection with a perspective".to_owned(),
        (None, DrawClass::Scene(_)) => "a matrix with a perspective flows into its positions".to_owned(),
        (None, DrawClass::Screen) => "a shader has the inverse of a camera matrix".to_owned(),
        (None, DrawClass::Behind) => "flat, and drawn before the scene".to_owned(),
        (None, DrawClass::Flat) => match shaders.program() {
            Some(program) if !program.uniforms.locked().any() => "no 4×4 matrix flows into its positions".to_owned(),
            _ => "no matrix with a perspective".to_owned(),
        },
    };
    if app.picking() || app.discard() {
        why = "nothing is rasterised, or it is drawn for picking".to_owned();
    }
    let images = view_copies.images.iter().enumerate().take(64).filter(|(i, _)| seen.sampled >> i & 1 != 0);
    for (number, (_, image)) in images.enumerate() {
        why.push_str(if number == 0 { "; reads " } else { ", " });
        why.push_str(&name_of(image));
    }
    why
}

fn target(app: &AppState, drawable: &Drawable, view_copies: &ViewCopies) -> String {
    let window = drawable.target().map_or((0, 0), |target| target.size());
    if app.draw_framebuffer() == 0 {
        return format!("window, {} × {}", window.0, window.1);
    }
    let mut text = format!("framebuffer {}", app.draw_framebuffer());
    if let Some(framebuffer) = bound(app, view_copies) {
        for (number, name) in framebuffer.images().enumerate() {
            text.push_str(if number == 0 { ": " } else { ", " });
            text.push_str(&view_copies.image(name).map_or_else(|| "an image".to_owned(), name_of));
        }
    }
    text
}

/// Returns the framebuffer of the program that is bound for drawing.
fn bound<'a>(app: &AppState, view_copies: &'a ViewCopies) -> Option<&'a Framebuffer> {
    let index = view_copies.position(app.draw_framebuffer())?;
    view_copies.framebuffers.get(index)
}

fn name_of(image: &Image) -> String {
    let what = if image.mask & api::GL_COLOR_BUFFER_BIT != 0 { "colour" } else { "depth" };
    let Size { width, height } = image.size;
    let name = match image.name {
        Name::Texture { name, level: 0, .. } => format!("texture {name}"),
        Name::Texture { name, level, .. } => format!("texture {name} level {level}"),
        Name::Renderbuffer(name) => format!("renderbuffer {name}"),
    };
    let samples = if image.samples > 1 { format!(", {} samples", image.samples) } else { String::new() };
    format!("{what} {name} ({}, {width} × {height}{samples})", format_name(image.format))
}

fn format_name(format: u32) -> String {
    let name = match format {
        api::GL_R8 => "R8",
        api::GL_RG8 => "RG8",
        api::GL_RGB8 => "RGB8",
        api::GL_RGBA8 => "RGBA8",
        api::GL_SRGB8_ALPHA8 => "SRGB8_ALPHA8",
        api::GL_RGB10_A2 => "RGB10_A2",
        api::GL_R11F_G11F_B10F => "R11F_G11F_B10F",
        api::GL_R16F => "R16F",
        api::GL_RG16F => "RG16F",
        api::GL_RGB16F => "RGB16F",
        api::GL_RGBA16F => "RGBA16F",
        api::GL_RGBA16 => "RGBA16",
        api::GL_R32F => "R32F",
        api::GL_RGBA32F => "RGBA32F",
        api::GL_DEPTH_COMPONENT16 => "DEPTH_COMPONENT16",
        api::GL_DEPTH_COMPONENT24 => "DEPTH_COMPONENT24",
        api::GL_DEPTH_COMPONENT32F => "DEPTH_COMPONENT32F",
        api::GL_DEPTH24_STENCIL8 => "DEPTH24_STENCIL8",
        api::GL_DEPTH32F_STENCIL8 => "DEPTH32F_STENCIL8",
        other => return format!("format 0x{other:04X}"),
    };
    name.to_owned()
}

/// Describes how draws to the target are issued.
fn how(app: &AppState, drawable: &Drawable, view_copies: &ViewCopies) -> String {
    if app.draw_framebuffer() == 0 {
        return match drawable.target() {
            Some(target) => {
                format!("Draws of the scene are issued to {} views, flat ones once.", target.session.views().len())
            }
            None => "The window keeps its own picture.".to_owned(),
        };
    }
    let Some(framebuffer) = bound(app, view_copies) else {
        return "Draws are issued once: the framebuffer is not followed.".to_owned();
    };
    match framebuffer_statistics::reason(drawable, &view_copies.images, framebuffer) {
        None => format!("Draws are issued once for each of {} views.", views(drawable)),
        Some(reason) => format!("Draws are issued once: {reason}."),
    }
}

fn shaders(shaders: &Shaders) -> String {
    match (shaders.program(), shaders.assembly()) {
        (Some(program), _) => {
            let stages = [
                (api::GL_VERTEX_SHADER_BIT, "vertex"),
                (api::GL_TESS_CONTROL_SHADER_BIT, "tessellation control"),
                (api::GL_TESS_EVALUATION_SHADER_BIT, "tessellation evaluation"),
                (api::GL_GEOMETRY_SHADER_BIT, "geometry"),
            ];
            let present = stages.iter().filter(|(bit, _)| program.stages() & bit != 0).map(|(_, name)| *name);
            let changed = if program.location >= 0 { "" } else { "; its positions cannot be changed" };
            format!("program {} ({}){changed}", program.name, present.collect::<Vec<_>>().join(", "))
        }
        (None, Some(_)) => "vertex program in assembly language".to_owned(),
        (None, None) => "fixed function".to_owned(),
    }
}

fn state(driver: &Driver, app: &AppState) -> String {
    let mut parts = Vec::new();
    let gl = driver.gl;
    for (name, text) in [
        (api::GL_DEPTH_TEST, "depth test"),
        (api::GL_BLEND, "blending"),
        (api::GL_STENCIL_TEST, "stencil test"),
        (api::GL_SCISSOR_TEST, "scissor test"),
    ] {
        // SAFETY: a capability of every version.
        if unsafe { gl.is_enabled(name) } != 0 {
            parts.push(text.to_owned());
        }
    }
    let LowerLeftRect { x, y, width, height } = app.viewport();
    parts.push(format!("viewport {x}, {y}, {width} × {height}"));
    parts.join(", ")
}

fn matrices(driver: &Driver, shaders: &Shaders, compat: &Compat) -> Vec<MatrixNote> {
    let describe = |matrix: &Matrix| MatrixNote::new(&*matrix.name, form(matrix), &matrix.candidate());
    match shaders.program() {
        Some(program) => {
            let mut notes: Vec<_> = program.uniforms.locked().matrices.iter().map(describe).collect();
            notes.extend(camera_matrices(program));
            notes
        }
        None if shaders.assembly().is_none() && driver.profile.compatibility() => {
            let projection = Candidate::either(0, compat.projection.matrix());
            vec![MatrixNote::new("GL_PROJECTION", "fixed function", &projection)]
        }
        None => Vec::new(),
    }
}

/// Describes the matrices that shaders use in addition to that of the position, and that each view
/// has its own version of.
fn camera_matrices(program: &Program) -> Vec<MatrixNote> {
    let camera = program.camera_matrices.locked();
    let substitutes = camera.substitutes.iter().filter_map(|substitute| {
        let name = camera.uniforms.name(substitute.matrix)?.to_owned();
        let form = match substitute.stage {
            MatrixStage::Vertex => "in the vertex shader",
            MatrixStage::Fragment => "in the fragment shader",
        };
        let says = match &substitute.function {
            Some((_, lens)) => format!("a matrix of the camera with {}: each view has its own", field_of_view(lens)),
            None => "no matrix of the camera: it is not changed".to_owned(),
        };
        Some(MatrixNote { name, form, says })
    });
    substitutes.collect()
}

fn form(matrix: &Matrix) -> &'static str {
    match matrix.place {
        MatrixLocation::Uniform(_) => "uniform",
        MatrixLocation::Vectors(_) => "uniform, four vectors",
        MatrixLocation::Block { block, .. } if block.storage => "in a storage block",
        MatrixLocation::Block { .. } => "in a uniform block",
    }
}

/// Gives the last pass a picture of its target.
fn note_last_picture(driver: &mut Driver, drawable: &Drawable, view_copies: &mut ViewCopies) {
    let Some(InspectedPass { number, framebuffer, .. }) = view_copies.inspected.take() else { return };
    let Some(index) = view_copies.position(framebuffer).filter(|_| framebuffer != 0) else { return };
    let Some(framebuffer) = view_copies.framebuffers.get(index) else { return };
    let Some(image) = framebuffer.colours().find_map(|name| view_copies.image(name)) else { return };
    let Size { width, height } = image.size;
    let own = LowerLeftRect::new(0, 0, width, height);
    let (source, rect, name) = match &image.view_copy {
        Some(copy) if framebuffer.view_copy != 0 => {
            let Size { width, height } = copy.grid.extent(views(drawable));
            (framebuffer.view_copy, LowerLeftRect::new(0, 0, width, height), "afterwards, each view")
        }
        _ if image.samples > 1 => return,
        _ => (framebuffer.name, own, "afterwards"),
    };
    let gl = driver.gl;
    driver.take_errors();
    let picture = read_back(gl, source, name, rect);
    // Pictures with integers or with several samples cannot be read in this way.
    // SAFETY: reads the error flag.
    if unsafe { gl.get_error() } == api::GL_NO_ERROR {
        inspection::note_picture(number, picture);
    }
}
