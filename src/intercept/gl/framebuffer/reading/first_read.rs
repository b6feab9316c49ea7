//! The program's own picture, resampled from the views for its first read.

use crate::backend::gl::objects::framebuffers::{FramebufferBindings, blit};
use crate::backend::gl::{GlBackend, OwnFramebuffer, Target};

use crate::backend::gl::driver::api;
use crate::correct::{Batch, LowerLeftRect, OutputPass, PixelRect, Plan, Source};
use crate::error::Result;
use crate::intercept::gl::context::errors::take_own_errors;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::framebuffer::reading::{first_read_color, first_read_depth};
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::frame::Frame;
use crate::intercept::process::log;
use crate::rig::{Camera, Filter, Transfer};
use crate::runtime::session::{Frustum, Session};
use glam::DMat3;

/// Fills the tile of the program's own picture from the views. Needed for the first read, as
/// nothing was drawn to the tile before.
pub fn fill_primary(ctx: &mut Context) {
    let Some(target) = ctx.drawable.take_target() else { return };
    ctx.driver.take_errors();
    let camera = &target.session.program_camera();
    let directions = own_directions(&ctx.frame, camera);
    if directions.is_none() {
        first_read_color::fill_flat(ctx, &target);
    }
    if let (Some(tile), Some(directions)) = (target.primary(), directions) {
        let plan = own_picture(&ctx.frame, &target.session, directions);
        target.resolve(&ctx.driver, &ctx.app, &ctx.drawable, Some(LowerLeftRect::of_size(plan.views.atlas)));
        if !target.lenses.is_empty() {
            // These views are pictures of outputs, which a pass cannot sample.
            first_read_color::fill(&ctx.driver, &target, directions);
        } else if let Err(error) = copy(&ctx.driver, &plan, target.texture(), target.framebuffer(), tile) {
            log::once(&format!("the first picture that the program reads is black: {error}"));
        }
        first_read_depth::fill(&ctx.driver, &ctx.frame, &target, directions);
    }
    ctx.drawable.put_target(target);
    take_own_errors(&mut ctx.driver);
}

/// Returns the matrix from a pixel of the program's own picture (−1…1 to the right and up, 1) to
/// its direction in the viewer's axes. The direction has the length at which it reaches −1 along
/// the program's axis. `None`: the program's lens is not known yet.
pub(in crate::intercept::gl) fn own_directions(frame: &Frame, camera: &Camera) -> Option<DMat3> {
    let lens = frame.lens()?;
    let zoom = camera.zoom;
    let tangents = DMat3::from_cols_array(&[
        zoom / lens.a,
        0.0,
        0.0,
        0.0,
        zoom / lens.c,
        0.0,
        zoom * lens.b / lens.a,
        zoom * lens.d / lens.c,
        -1.0,
    ]);
    Some(crate::runtime::session::camera_rotation(camera) * tangents)
}

/// Returns the pass that draws the picture of the program's own lens from the same views.
pub(in crate::intercept::gl) fn own_picture(frame: &Frame, session: &Session, directions: DMat3) -> Plan {
    let (plan, size) = (session.plan(), session.window());
    let rect = PixelRect { x: 0, y: 0, width: size.0, height: size.1 };
    let views = (0..plan.views.views.len()).collect();
    let pass = OutputPass {
        here: true,
        name: "primary".to_owned(),
        size,
        source: Source::Perspective { matrix: directions },
        batches: vec![Batch {
            views,
            neighbours: Vec::new(),
            edge: true,
            masked: false,
            rects: vec![rect],
            facets: None,
        }],
        mask: None,
        filter: Filter::Bilinear,
        gamma: 1.0,
        transfer: Transfer::Power,
        black_level: 0.0,
        black: None,
        lift: 0.0,
        dither: 0.0,
        flip: crate::rig::Flip::default(),
        content: None,
        ramps: Vec::new(),
        dome_rotation: DMat3::IDENTITY,
    };
    let mut views = plan.views.clone();
    if let (Some(panel), Some(lens)) = (&mut views.panel, frame.lens()) {
        // In the program's own picture the panel fills the whole window.
        let camera = session.program_camera();
        let own = lens.frustum();
        panel.rotation = crate::runtime::session::camera_rotation(&camera).transpose();
        panel.frustum = Frustum {
            left: camera.zoom * own.left,
            right: camera.zoom * own.right,
            bottom: camera.zoom * own.bottom,
            top: camera.zoom * own.top,
        };
        panel.owned = panel.frustum;
    }
    Plan { views, passes: vec![pass] }
}

pub(in crate::intercept::gl) fn copy(
    driver: &Driver,
    plan: &Plan,
    atlas: u32,
    framebuffer: u32,
    tile: LowerLeftRect,
) -> Result<()> {
    let gl = driver.gl;
    let mut backend = GlBackend::new(gl, driver.profile.es)?.with_cache(gl, crate::runtime::cache::of_process());
    backend.prepare(gl, plan, plan.views.panel.is_some())?;
    let LowerLeftRect { width, height, .. } = tile;
    let whole = LowerLeftRect::new(0, 0, width, height);
    let canvas = OwnFramebuffer::new(gl, width, height);
    backend.present(gl, atlas, &[Target { framebuffer: canvas.framebuffer, viewport: whole }]);
    // SAFETY: copies between framebuffers of Cupola; bindings and scissor test are put back.
    unsafe {
        let scissor = gl.is_enabled(api::GL_SCISSOR_TEST) != 0;
        gl.disable(api::GL_SCISSOR_TEST);
        let bindings = FramebufferBindings::save(gl);
        gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, canvas.framebuffer);
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, framebuffer);
        blit(gl, whole.corners(), tile.corners(), api::GL_COLOR_BUFFER_BIT, api::GL_NEAREST);
        bindings.restore(gl);
        if scissor {
            gl.enable(api::GL_SCISSOR_TEST);
        }
    }
    canvas.destroy(gl);
    backend.destroy(gl);
    Ok(())
}
