//! Reads of a program from its window. They read the primary view.
//!
//! Other tiles of the atlas are next to this view. So reads are limited to the window, and the
//! program's memory for pixels outside the window is not written.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::framebuffer::reading::first_read;
use crate::intercept::gl::framebuffer::reading::resolve::make_ready;
use crate::intercept::gl::framebuffer::target::enlarge::enlarge;
use crate::intercept::gl::offscreen::view_copies;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::driver::Driver;
use std::ffi::c_void;

/// Binds the framebuffer for the program's reads of `part` of its window. Returns the origin of the
/// program's picture in it. `alpha`: the read includes alpha.
pub fn prepare(ctx: &mut Context, part: LowerLeftRect, alpha: bool) -> [i32; 2] {
    let own_picture = DefaultFramebuffer::own_picture;
    if ctx.drawable.target().is_some_and(|t| own_picture(t).is_none()) {
        enlarge(ctx, |extras| extras.primary = true);
        first_read::fill_primary(&mut OwnCalls::begin(ctx));
    }
    let Some(tile) = ctx.drawable.target().and_then(own_picture) else { return [0, 0] };
    make_ready(ctx, part.moved_into(tile), alpha);
    let Some(target) = ctx.drawable.target().filter(|target| target.resolved.is_some()) else {
        return tile.origin();
    };
    // SAFETY: a framebuffer of Cupola; `finish` puts the program's back.
    unsafe { ctx.driver.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, target.readable().framebuffer()) };
    tile.origin()
}

/// Restores the read framebuffer that [`prepare`] replaced.
pub fn finish(ctx: &mut Context) {
    if ctx.reads_redirected()
        && let Some(target) = ctx.drawable.target().filter(|target| target.resolved.is_some())
    {
        // SAFETY: binds the stand-in framebuffer for the program's window.
        unsafe { ctx.driver.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, target.framebuffer()) };
    }
}

/// Runs a read of the program, with the origin of its rectangle moved to the tile of its picture.
pub fn read<R>(ctx: &mut Context, part: LowerLeftRect, alpha: bool, issue: impl FnOnce(i32, i32) -> R) -> R {
    let [x, y] = part.origin();
    if !ctx.reads_redirected() {
        view_copies::before_reading_framebuffer(ctx);
        return issue(x, y);
    }
    // A read during compilation is not part of the display list. The calls that prepare it must not
    // become part of the list either.
    let compiling = list_recording::pause(&ctx.share, &ctx.driver, &mut ctx.lists);
    let [left, bottom] = prepare(ctx, part, alpha);
    if compiling {
        list_recording::go_on(&ctx.share, &ctx.driver, &mut ctx.lists, None);
    }
    let answer = issue(x + left, y + bottom);
    finish(ctx);
    answer
}

/// Returns the part of a rectangle in the window. `None`: all of it is in the window, or a size is
/// below 0, which is an error that the driver reports.
fn cut(ctx: &Context, part: LowerLeftRect) -> Option<LowerLeftRect> {
    let window = ctx.drawable.target().filter(|_| ctx.reads_redirected())?.size();
    let inside = part.moved_into(LowerLeftRect::of_size(window));
    (inside != part && part.width >= 0 && part.height >= 0).then_some(inside)
}

/// Performs a copy from the window's own framebuffer, which has no drawing of the program. Returns
/// true if the driver refuses it, and notes the error.
fn is_refused(driver: &mut Driver, drawable: &Drawable, issue: impl FnOnce()) -> bool {
    let gl = driver.gl;
    let Some(framebuffer) = drawable.target().map(|target| target.framebuffer()) else { return false };
    driver.take_errors();
    // SAFETY: the binding is put back.
    let error = unsafe {
        gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, 0);
        issue();
        gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, framebuffer);
        gl.get_error()
    };
    if error != api::GL_NO_ERROR {
        driver.note_error(error);
    }
    error != api::GL_NO_ERROR
}

/// Runs a copy into a part of a texture. `issue` gets the rectangle, and its offset in that part.
pub fn copy_part(ctx: &mut Context, part: LowerLeftRect, issue: impl Fn(LowerLeftRect, [i32; 2])) {
    let inside = match cut(ctx, part) {
        // The driver does not see the whole rectangle, so it cannot refuse it.
        Some(_) if is_refused(&mut ctx.driver, &ctx.drawable, || issue(part, [0, 0])) => return,
        inside => inside.unwrap_or(part),
    };
    let moved = [inside.x - part.x, inside.y - part.y];
    read(ctx, inside, true, |x, y| issue(LowerLeftRect { x, y, ..inside }, moved));
}

/// True if pixels of this format have alpha.
fn has_alpha(format: u32) -> bool {
    !matches!(
        format,
        api::GL_RGB
            | api::GL_BGR
            | api::GL_RED
            | api::GL_GREEN
            | api::GL_BLUE
            | api::GL_RG
            | api::GL_LUMINANCE
            | api::GL_DEPTH_COMPONENT
            | api::GL_STENCIL_INDEX
            | api::GL_DEPTH_STENCIL
    )
}

/// `glReadPixels`, without a change of the memory for pixels outside the window.
fn read_pixels_part(ctx: &mut Context, part: LowerLeftRect, format: u32, issue: impl FnOnce(LowerLeftRect)) {
    const STORE: [u32; 3] = [api::GL_PACK_ROW_LENGTH, api::GL_PACK_SKIP_PIXELS, api::GL_PACK_SKIP_ROWS];
    let gl = ctx.driver.gl;
    // In OpenGL ES 2 there are no gaps between the rows in memory.
    let gaps = !ctx.driver.profile.es || ctx.driver.profile.version >= 30;
    let Some(inside) = cut(ctx, part).filter(|_| gaps) else {
        return read(ctx, part, has_alpha(format), |x, y| issue(LowerLeftRect { x, y, ..part }));
    };
    let mut before = [0; 3];
    // SAFETY: state that this version has; restored below.
    unsafe {
        for (value, name) in before.iter_mut().zip(STORE) {
            gl.get_integerv(name, value);
        }
        let [length, pixels, rows] = before;
        let length = if length == 0 { part.width } else { length };
        let now = [length, pixels + inside.x - part.x, rows + inside.y - part.y];
        for (value, name) in now.iter().zip(STORE) {
            gl.pixel_storei(name, *value);
        }
    }
    read(ctx, inside, has_alpha(format), |x, y| issue(LowerLeftRect { x, y, ..inside }));
    for (value, name) in before.iter().zip(STORE) {
        // SAFETY: as above.
        unsafe { gl.pixel_storei(name, *value) };
    }
}

/// Runs a copy into a texture, which may be a part of a display list.
fn copy(ctx: &mut Context, part: LowerLeftRect, issue: impl Fn(&Gl, LowerLeftRect, [i32; 2]) + Send + Sync + 'static) {
    list_recording::now_or_later(ctx, move |ctx| {
        let gl = ctx.driver.gl;
        copy_part(ctx, part, |part, moved| issue(gl, part, moved));
    });
}

hooks! {
    "glReadPixels" read_pixels(x: i32, y: i32, w: i32, h: i32, format: u32, kind: u32, pixels: *mut c_void) = |ctx, gl|
        read_pixels_part(ctx, LowerLeftRect::new(x, y, w, h), format, |r| gl.read_pixels(r.x, r.y, r.width, r.height, format, kind, pixels));
    "glReadnPixels" readn_pixels(x: i32, y: i32, w: i32, h: i32, format: u32, kind: u32, size: i32, pixels: *mut c_void) = |ctx, gl|
        read_pixels_part(ctx, LowerLeftRect::new(x, y, w, h), format, |r| gl.readn_pixels(r.x, r.y, r.width, r.height, format, kind, size, pixels));
    "glCopyTexImage1D" copy_tex_image1_d(target: u32, level: i32, format: u32, x: i32, y: i32, w: i32, border: i32) = |ctx, _gl|
        list_recording::now_or_later(ctx, move |ctx| {
            let gl = ctx.driver.gl;
            // SAFETY: the program's own call, with the coordinates of its picture in the atlas.
            read(ctx, LowerLeftRect::new(x, y, w, 1), true, |x, y| unsafe { gl.copy_tex_image1_d(target, level, format, x, y, w, border) });
        });
    "glCopyTexSubImage1D" copy_tex_sub_image1_d(target: u32, level: i32, dx: i32, x: i32, y: i32, w: i32) = |ctx, _gl|
        copy(ctx, LowerLeftRect::new(x, y, w, 1), move |gl, r, [u, _]| {
            gl.copy_tex_sub_image1_d(target, level, dx + u, r.x, r.y, if r.height > 0 { r.width } else { 0 })
        });
    "glCopyTexSubImage3D" copy_tex_sub_image3_d(target: u32, level: i32, dx: i32, dy: i32, dz: i32, x: i32, y: i32, w: i32, h: i32) = |ctx, _gl|
        copy(ctx, LowerLeftRect::new(x, y, w, h), move |gl, r, [u, v]|
            gl.copy_tex_sub_image3_d(target, level, dx + u, dy + v, dz, r.x, r.y, r.width, r.height));
}
