//! The raster position, and drawing at it: bitmaps and pixel rectangles.
//!
//! The driver transforms a raster position once, when it is set. This is correct for the flat
//! panel. A position in the scene is at another point in each view. So it is stored with its
//! model-view matrix, and set again in each view before a draw at it.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::{LowerLeftRect, Size};
use crate::intercept::gl::compat::scene_position::{PlacedPosition, is_valid, move_by, raster_position};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::{self, Command};
use crate::intercept::gl::framebuffer::commands::summed_pixels;
use crate::intercept::gl::framebuffer::reading::read_back;
use crate::intercept::gl::framebuffer::target::enlarge::want_panel;
use crate::intercept::gl::per_view::classify::classify;
use crate::intercept::gl::per_view::issue::Repeats;
use crate::intercept::gl::per_view::window_space::own_window_space;
use crate::intercept::gl::queries::scaling;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::compat::projection;
use crate::intercept::gl::state::compat::raster_position::{ScenePosition, TextureCoordinates};
use crate::intercept::gl::state::draw::draw_class::{Changes, DrawClass};
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::scene::query_scaling::QueryScaling;
use glam::{DMat4, DVec3, DVec4, Vec2};
use std::ffi::c_void;

/// `glRasterPos`.
pub fn set_position(ctx: &mut Context, object: DVec4) {
    let gl = ctx.driver.gl;
    let old = ctx.compat.raster.forget();
    if ctx.redirected() && !ctx.app.picking() {
        let class = classify(ctx);
        if class == DrawClass::FixedScene {
            let mut model_view = DMat4::ZERO;
            let mut depths = [0.0; 2];
            // SAFETY: writes eighteen doubles; a raster position implies a fixed-function pipeline.
            let texture = unsafe {
                gl.get_doublev(api::GL_MODELVIEW_MATRIX, model_view.as_mut().as_mut_ptr());
                gl.get_doublev(api::GL_DEPTH_RANGE, depths.as_mut_ptr());
                TextureCoordinates::of(gl)
            };
            ctx.compat.projection.copy_views_to(&mut ctx.compat.raster.projections);
            ctx.compat.raster.scene =
                Some(ScenePosition { object, model_view, color: [0.0; 4], texture, depths, moved: Vec2::ZERO });
            // The driver's own state is set too, for the program's queries, as in the program's
            // window.
            ctx.set_viewport(ctx.app.viewport());
        } else {
            ctx.compat.raster.origin = flat_window_space(ctx);
        }
    } else if ctx.drawable.target().is_some() {
        // In a framebuffer of the program, or for picking, there are no tiles.
        ctx.set_viewport(ctx.app.viewport());
    }
    // SAFETY: the program's own call.
    unsafe { gl.raster_pos4dv(object.as_ref().as_ptr()) };
    if !is_valid(gl) {
        // A clipped position leaves the driver's coordinates unchanged.
        ctx.compat.raster.origin = old;
    }
    if ctx.compat.raster.scene.is_some() {
        let color = taken_color(&ctx.driver, &ctx.app, &ctx.compat, object);
        ctx.compat.raster.scene.iter_mut().for_each(|scene| scene.color = color);
    }
}

/// Returns the lit colour of the raster position. If the position is clipped in the program's
/// window, OpenGL has computed no lit colour, so the position is set again where it is not clipped.
fn taken_color(driver: &Driver, app: &AppState, compat: &Compat, object: DVec4) -> [f32; 4] {
    let gl = driver.gl;
    let mut color = [0.0; 4];
    // SAFETY: writes four floats. The current values, including the raster position, are pushed and
    // popped.
    unsafe {
        if is_valid(gl) {
            gl.get_floatv(api::GL_CURRENT_RASTER_COLOR, color.as_mut_ptr());
            return color;
        }
        gl.get_floatv(api::GL_CURRENT_COLOR, color.as_mut_ptr());
        if !app.can_push(0) {
            return color;
        }
        gl.push_attrib(api::GL_CURRENT_BIT);
        // This matrix moves every position to the middle of the picture.
        let middle = DMat4::from_diagonal(DVec4::W);
        projection::load(driver.gl, app.matrix_mode(), &middle);
        gl.raster_pos4dv(object.as_ref().as_ptr());
        if is_valid(gl) {
            gl.get_floatv(api::GL_CURRENT_RASTER_COLOR, color.as_mut_ptr());
        }
        projection::load(driver.gl, app.matrix_mode(), compat.projection.matrix());
        gl.pop_attrib();
    }
    color
}

/// `glWindowPos`.
pub fn set_window_position(ctx: &mut Context, position: DVec3) {
    ctx.compat.raster.forget();
    if ctx.redirected() && !ctx.app.picking() {
        ctx.compat.raster.origin = flat_window_space(ctx);
    }
    let DVec3 { x, y, z } = position;
    let [left, bottom] = ctx.compat.raster.origin.map(f64::from);
    // SAFETY: the program's own call, moved to the panel.
    unsafe { ctx.driver.gl.window_pos3d(x + left, y + bottom, z) };
}

/// Prepares the flat tile. Returns its origin in the atlas.
fn flat_window_space(ctx: &mut Context) -> [i32; 2] {
    want_panel(ctx);
    let tile = ctx.drawable.target().and_then(|t| t.flat_tiles().into_iter().flatten().next());
    match tile {
        Some((tile, _)) => {
            own_window_space(ctx, tile);
            tile.origin()
        }
        None => [0, 0],
    }
}

/// Draws at the raster position. `changes`: state that the draw changes. Returns false if the
/// caller must treat it like any other draw.
pub fn draw_at_raster(ctx: &mut Context, changes: Changes, issue: impl Fn(&Gl)) -> bool {
    if ctx.app.picking() || (!ctx.redirected() && ctx.compat.raster.origin == [0, 0]) {
        return false;
    }
    // Bitmaps may reach beyond the border of their tile.
    ctx.draw.cut_at_tile();
    if !ctx.redirected() {
        scaling::scale(ctx.driver.gl, &mut ctx.queries, QueryScaling::ONCE);
        move_origin(&ctx.driver, &mut ctx.compat, [0, 0]);
        issue(ctx.driver.gl);
        return true;
    }
    ctx.frame.note_draw();
    ctx.note_drawn();
    match ctx.compat.raster.scene.take() {
        Some(position) => draw_in_scene(ctx, position, changes, &issue),
        None => draw_flat(ctx, changes, &issue),
    }
    true
}

/// Draws at a raster position in the scene.
fn draw_in_scene(ctx: &mut Context, mut position: ScenePosition, changes: Changes, issue: &dyn Fn(&Gl)) {
    let gl = ctx.driver.gl;
    // `PlacedPosition` pushes one entry.
    let repeats = Repeats::new(changes, &ctx.driver, &ctx.app, 1);
    ctx.compat.projection.refresh(gl, ctx.drawable.session());
    let Some(mut target) = ctx.drawable.take_target() else { return };
    let before = raster_position(gl);
    // The current values, including the raster position, are restored. This is impossible if the
    // stack is full.
    let keeps = ctx.app.can_push(0);
    let placed = PlacedPosition::begin(gl, &position, ctx.app.matrix_mode(), keeps);
    draw_in_views(ctx, &placed, &mut target, &mut || repeats.unchanged(gl, false, || issue(gl)));
    placed.end();
    // Draws once more at the position in the program's window, with an empty scissor. This moves
    // the raster position as the program expects.
    ctx.set_viewport(ctx.app.viewport());
    ctx.set_scissor(Some(LowerLeftRect::default()));
    issue(gl);
    let after = raster_position(gl);
    position.moved = position.moved + after - before;
    ctx.compat.raster.scene = Some(position);
    ctx.drawable.put_target(target);
}

/// Draws at a position of the scene in each view and in the program's own picture.
fn draw_in_views(ctx: &mut Context, placed: &PlacedPosition, target: &mut DefaultFramebuffer, issue: &mut dyn FnMut()) {
    let (gl, mode) = (ctx.driver.gl, ctx.app.matrix_mode());
    scaling::scale(gl, &mut ctx.queries, QueryScaling::ONCE);
    for index in 0..target.session.views().len() {
        let Some(projection) = ctx.compat.raster.projections.get(index).copied() else { break };
        let (tile, own_lens) = target.session.tile(index);
        let turn = target.session.turn();
        if turn.is_some_and(|turn| turn != index) {
            continue;
        }
        if own_lens {
            own_window_space(ctx, tile);
        } else {
            ctx.set_scissor(Some(tile));
            ctx.set_viewport(tile);
        }
        if own_lens && turn.is_none() {
            placed.as_set(tile);
        } else {
            projection::load(gl, mode, &projection);
            placed.set();
        }
        issue();
        target.issued(index);
    }
    projection::load(gl, mode, ctx.compat.projection.matrix());
    if let Some(tile) = target.primary() {
        scaling::scale(gl, &mut ctx.queries, QueryScaling { samples: 0.0, ..QueryScaling::ONCE });
        own_window_space(ctx, tile);
        placed.as_set(tile);
        issue();
        ctx.frame.note_primary_draw();
    }
    if !placed.keeps() {
        ctx.set_viewport(ctx.app.viewport());
        placed.set();
    }
}

/// Draws at a raster position on the flat panel, and in the other tiles that show flat drawing.
fn draw_flat(ctx: &mut Context, changes: Changes, issue: &dyn Fn(&Gl)) {
    let gl = ctx.driver.gl;
    want_panel(ctx);
    ctx.frame.note_panel_draw();
    let Some(tiles) = ctx.drawable.target().map(|t| t.flat_tiles()) else { return };
    let repeats = Repeats::new(changes, &ctx.driver, &ctx.app, 0);
    let (mut before, pictures) = (None, tiles.iter().flatten().count());
    for (number, (tile, _)) in tiles.into_iter().flatten().enumerate() {
        let samples = if number == 0 { 1.0 } else { 0.0 };
        scaling::scale(ctx.driver.gl, &mut ctx.queries, QueryScaling { samples, ..QueryScaling::ONCE });
        own_window_space(ctx, tile);
        move_origin(&ctx.driver, &mut ctx.compat, tile.origin());
        let position = raster_position(gl) - Vec2::new(tile.x as f32, tile.y as f32);
        // Drawing in each tile begins at the same position as in the first tile.
        let first = *before.get_or_insert(position);
        move_by(gl, first - position);
        repeats.unchanged(gl, number + 1 == pictures, || issue(gl));
    }
}

/// Moves the driver's raster position to the tile with this origin. An invalid position cannot be
/// moved, and draws nothing.
fn move_origin(driver: &Driver, compat: &mut Compat, [left, bottom]: [i32; 2]) {
    let [x, y] = compat.raster.origin;
    if [x, y] != [left, bottom] && is_valid(driver.gl) {
        move_by(driver.gl, Vec2::new((left - x) as f32, (bottom - y) as f32));
        compat.raster.origin = [left, bottom];
    }
}

/// Handles a command that draws at the raster position.
pub fn raster_command(ctx: &mut Context, issue: impl Fn(&Gl)) {
    let gl = ctx.driver.gl;
    if ctx.lists.recording.is_some() {
        list_recording::will_draw(&ctx.share, &ctx.driver, &mut ctx.lists, true);
        issue(gl);
    } else if !draw_at_raster(ctx, Changes::Nothing, &issue) {
        issue(gl);
    }
}

fn raster_position_command(ctx: &mut Context, position: DVec4) {
    if ctx.compiling() {
        list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::RasterPosition(position));
    } else {
        set_position(ctx, position);
    }
}

fn window_position_command(ctx: &mut Context, position: DVec3) {
    if ctx.compiling() {
        list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::WindowPosition(position));
    } else {
        set_window_position(ctx, position);
    }
}

/// Returns the program's array of N numbers, padded like OpenGL pads positions.
///
/// # Safety
/// `v` must point at `N` numbers.
unsafe fn padded<T: Copy + Into<f64>, const N: usize>(v: *const T) -> DVec4 {
    DVec4::from_array(std::array::from_fn(|i| match i {
        // SAFETY: as promised above.
        i if i < N => unsafe { (*v.add(i)).into() },
        i => f64::from(u8::from(i == 3)),
    }))
}

macro_rules! raster_hooks {
    ($( $t:ty: $p2:literal $m2:ident $p2v:literal $m2v:ident $p3:literal $m3:ident $p3v:literal $m3v:ident
        $p4:literal $m4:ident $p4v:literal $m4v:ident $w2:literal $n2:ident $w2v:literal $n2v:ident $w3:literal $n3:ident $w3v:literal $n3v:ident; )*) => {
        hooks! {
            $(
                $p2 $m2(x: $t, y: $t) = |ctx, _gl| raster_position_command(ctx, DVec4::new(x.into(), y.into(), 0.0, 1.0));
                $p2v $m2v(v: *const $t) = |ctx, _gl| raster_position_command(ctx, padded::<_, 2>(v));
                $p3 $m3(x: $t, y: $t, z: $t) = |ctx, _gl| raster_position_command(ctx, DVec4::new(x.into(), y.into(), z.into(), 1.0));
                $p3v $m3v(v: *const $t) = |ctx, _gl| raster_position_command(ctx, padded::<_, 3>(v));
                $p4 $m4(x: $t, y: $t, z: $t, w: $t) = |ctx, _gl| raster_position_command(ctx, DVec4::new(x.into(), y.into(), z.into(), w.into()));
                $p4v $m4v(v: *const $t) = |ctx, _gl| raster_position_command(ctx, padded::<_, 4>(v));
                $w2 $n2(x: $t, y: $t) = |ctx, _gl| window_position_command(ctx, DVec3::new(x.into(), y.into(), 0.0));
                $w2v $n2v(v: *const $t) = |ctx, _gl| window_position_command(ctx, padded::<_, 2>(v).truncate());
                $w3 $n3(x: $t, y: $t, z: $t) = |ctx, _gl| window_position_command(ctx, DVec3::new(x.into(), y.into(), z.into()));
                $w3v $n3v(v: *const $t) = |ctx, _gl| window_position_command(ctx, padded::<_, 3>(v).truncate());
            )*
            "glBitmap" bitmap(w: i32, h: i32, x: f32, y: f32, dx: f32, dy: f32, bits: *const u8) = |ctx, _gl|
                raster_command(ctx, |gl| gl.bitmap(w, h, x, y, dx, dy, bits));
            "glDrawPixels" draw_pixels(w: i32, h: i32, format: u32, kind: u32, pixels: *const c_void) = |ctx, _gl| {
                summed_pixels::add(&ctx.driver, Size::new(w, h), (format, kind), pixels);
                raster_command(ctx, |gl| gl.draw_pixels(w, h, format, kind, pixels));
            };
            "glCopyPixels" copy_pixels(x: i32, y: i32, w: i32, h: i32, kind: u32) = |ctx, _gl|
                list_recording::now_or_later(ctx, move |ctx| {
                    let [left, bottom] = if ctx.reads_redirected() { read_back::prepare(ctx, LowerLeftRect::new(x, y, w, h), kind == api::GL_COLOR) } else { [0, 0] };
                    let (x, y) = (x + left, y + bottom);
                    // SAFETY: the program's own call, with the coordinates of its picture in the
                    // atlas.
                    raster_command(ctx, |gl| unsafe { gl.copy_pixels(x, y, w, h, kind) });
                    read_back::finish(ctx);
                });
        }
    };
}

raster_hooks! {
    f64: "glRasterPos2d" raster_pos2d "glRasterPos2dv" raster_pos2dv "glRasterPos3d" raster_pos3d "glRasterPos3dv" raster_pos3dv
        "glRasterPos4d" raster_pos4d "glRasterPos4dv" raster_pos4dv "glWindowPos2d" window_pos2d "glWindowPos2dv" window_pos2dv
        "glWindowPos3d" window_pos3d "glWindowPos3dv" window_pos3dv;
    f32: "glRasterPos2f" raster_pos2f "glRasterPos2fv" raster_pos2fv "glRasterPos3f" raster_pos3f "glRasterPos3fv" raster_pos3fv
        "glRasterPos4f" raster_pos4f "glRasterPos4fv" raster_pos4fv "glWindowPos2f" window_pos2f "glWindowPos2fv" window_pos2fv
        "glWindowPos3f" window_pos3f "glWindowPos3fv" window_pos3fv;
    i32: "glRasterPos2i" raster_pos2i "glRasterPos2iv" raster_pos2iv "glRasterPos3i" raster_pos3i "glRasterPos3iv" raster_pos3iv
        "glRasterPos4i" raster_pos4i "glRasterPos4iv" raster_pos4iv "glWindowPos2i" window_pos2i "glWindowPos2iv" window_pos2iv
        "glWindowPos3i" window_pos3i "glWindowPos3iv" window_pos3iv;
    i16: "glRasterPos2s" raster_pos2s "glRasterPos2sv" raster_pos2sv "glRasterPos3s" raster_pos3s "glRasterPos3sv" raster_pos3sv
        "glRasterPos4s" raster_pos4s "glRasterPos4sv" raster_pos4sv "glWindowPos2s" window_pos2s "glWindowPos2sv" window_pos2sv
        "glWindowPos3s" window_pos3s "glWindowPos3sv" window_pos3sv;
}
