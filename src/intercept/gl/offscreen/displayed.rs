//! Flat draws to the window that show a scene which was drawn off screen. Each view is filled with
//! its own picture. If the scene lies between the widgets of a toolkit, its rectangle of the window
//! fills the views, and becomes a hole in the panel, which has the widgets.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::objects::framebuffers::FramebufferBindings;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::offscreen::target::each_view;
use crate::intercept::gl::offscreen::transfers::{End, resample, window_format};
use crate::intercept::gl::offscreen::view_copies::{own_tile, possible, supply, views};
use crate::intercept::gl::offscreen::{coverage, in_turn, sampling};
use crate::intercept::gl::per_view::{panel, window_space};
use crate::intercept::gl::state::draw::draw_class::{Changes, DrawClass};
use crate::intercept::gl::state::draw::views::Views;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::offscreen::displayed::Shows;
use crate::intercept::gl::state::offscreen::images::Set;
use crate::intercept::gl::state::offscreen::single_sample::SingleSampleImage;
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;
use crate::intercept::scene::viewport;
use std::cell::Cell;

/// Determines what a flat draw to the window shows. `main`: the draw has the main viewport.
pub fn look(ctx: &mut Context, main: bool) -> Shows {
    if in_turn::is_on(&ctx.drawable) {
        return in_turn::look_at_window(ctx, main);
    }
    if !ctx.view_copies.any() || !possible(&ctx.drawable) {
        return Shows::Nothing;
    }
    let sampled = sampling::sampled(&ctx.driver, &ctx.shaders, &ctx.view_copies);
    if sampled == 0 {
        return Shows::Nothing;
    }
    let part = if main { coverage::filled_part(ctx, sampled) } else { Ok(None) };
    match part {
        Err(measure) => Shows::Unknown(measure),
        Ok(Some(part)) if holds_whole_image(ctx, sampled, part) => {
            let mut any_copy = false;
            for (_, image) in ctx.view_copies.images.iter_mut().enumerate().filter(|(i, _)| sampled >> i & 1 != 0) {
                ctx.view_copies.learnt |= !image.displayed;
                image.displayed = true;
                any_copy |= image.view_copy.is_some();
            }
            if any_copy { Shows::Pictures(sampled, part) } else { Shows::Nothing }
        }
        Ok(_) => {
            // A small picture in the window shows the view of the program's own lens.
            supply(ctx, sampled, own_tile(&ctx.drawable, &ctx.view_copies));
            Shows::Nothing
        }
    }
}

/// True if `part` is the whole window, or has the shape of an image in `sampled`. Otherwise it may
/// show only a part of the image.
fn holds_whole_image(ctx: &Context, sampled: Set, part: LowerLeftRect) -> bool {
    let is_whole = ctx.drawable.target().is_some_and(|target| part.contains(LowerLeftRect::of_size(target.size())));
    let mut images = ctx.view_copies.images.iter().enumerate().filter(|(i, _)| *i < 64 && sampled >> i & 1 != 0);
    is_whole || images.any(|(_, image)| viewport::has_shape(image.size, part.size()))
}

/// Issues a draw that shows the images in `sampled` in the rectangle `part` of the window.
pub fn show(
    ctx: &mut Context,
    changes: Changes,
    (sampled, part): (Set, LowerLeftRect),
    issue: &mut dyn FnMut(&mut Context, &Gl),
) {
    note_shown(ctx, part);
    if in_turn::is_on(&ctx.drawable) {
        in_turn::show(ctx, changes, issue);
        return;
    }
    if make_canvases(&ctx.driver, &ctx.drawable, &mut ctx.view_copies) {
        show_by_canvas(ctx, changes, (sampled, part), issue);
        return;
    }
    // Without canvases no part of the window is measured, so the draw fills the window.
    each_view(ctx, changes, views(&ctx.drawable), Views::ALL, issue, |ctx, view| {
        supply(ctx, sampled, view);
        if let Some(target) = ctx.drawable.target_mut() {
            let (tile, _) = target.session.tile(view);
            target.issued(view);
            window_space::view_window_space(ctx, tile, None);
        }
        DrawClass::Flat
    });
}

/// Notes that the rectangle `part` of the window gets a scene, which covers all earlier flat drawing
/// there.
pub fn note_shown(ctx: &mut Context, part: LowerLeftRect) {
    let whole = ctx.drawable.target().is_none_or(|target| part.contains(LowerLeftRect::of_size(target.size())));
    if whole {
        ctx.frame.note_scene();
        panel::clear_panel(ctx);
    } else {
        ctx.frame.note_scene_in_part();
        panel::clear_part(ctx, part);
    }
}

/// Makes the canvases at the first call. Returns false if there can be none: OpenGL ES cannot copy
/// a picture with one sample to a window with several.
fn make_canvases(driver: &Driver, drawable: &Drawable, view_copies: &mut ViewCopies) -> bool {
    let Some(target) = drawable.target() else { return false };
    if driver.profile.es && target.config().samples > 0 {
        return false;
    }
    let size = target.size().into();
    let (count, format) = (views(drawable), canvas_format(driver, drawable));
    while view_copies.displayed.canvases.len() < count {
        let Some(canvas) = SingleSampleImage::new(driver.gl, size, format) else { return false };
        view_copies.displayed.canvases.push(canvas);
    }
    true
}

/// Returns the format of a canvas. The content of a canvas is scaled afterwards, so it has more
/// bits than the window to avoid rounding twice. OpenGL ES has no such format, and sRGB has only 8
/// bits.
fn canvas_format(driver: &Driver, drawable: &Drawable) -> u32 {
    match window_format(drawable) {
        api::GL_RGBA8 if !driver.profile.es => api::GL_RGBA16,
        format => format,
    }
}

fn show_by_canvas(
    ctx: &mut Context,
    changes: Changes,
    (sampled, part): (Set, LowerLeftRect),
    issue: &mut dyn FnMut(&mut Context, &Gl),
) {
    let Some(target) = ctx.drawable.target() else { return };
    let (window, samples, format) = (target.framebuffer(), target.config().samples, window_format(&ctx.drawable));
    let whole = LowerLeftRect::of_size(target.size());
    // True if the last draw to the window used the canvases too, so that they are up to date. This
    // draw is counted already.
    let number = ctx.frame.counts().draws_seen;
    let current = ctx.view_copies.displayed.current.is_some_and(|(last, of)| last + 1 == number && of == part);
    let view_now = Cell::new(0);
    // Copies between a canvas and a view's tile. The canvas remains bound for drawing.
    let copy = |ctx: &mut Context, view: usize, to_view: bool| {
        let (Some(canvas), Some(target)) = (ctx.view_copies.displayed.canvases.get(view), ctx.drawable.target()) else {
            return;
        };
        let (canvas, tile) = (canvas.framebuffer(), target.session.tile(view).0);
        let tile = End { corners: tile.corners(), samples, format };
        let picture = End { corners: part.corners(), samples: 0, format: canvas_format(&ctx.driver, &ctx.drawable) };
        let (from, to) =
            if to_view { ((canvas, picture), (window, tile)) } else { ((window, tile), (canvas, picture)) };
        // SAFETY: framebuffers of Cupola; the read binding is put back.
        unsafe {
            let bindings = FramebufferBindings::save(ctx.driver.gl);
            ctx.set_scissor(None);
            ctx.driver.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, from.0);
            ctx.driver.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, to.0);
            resample(ctx, from.1, to.1, api::GL_COLOR_BUFFER_BIT, api::GL_NEAREST);
            bindings.restore(ctx.driver.gl);
        }
    };
    let mut by_canvas = |ctx: &mut Context, gl: &Gl| {
        issue(ctx, gl);
        copy(ctx, view_now.get(), true);
    };
    each_view(ctx, changes, views(&ctx.drawable), Views::ALL, &mut by_canvas, |ctx, view| {
        view_now.set(view);
        supply(ctx, sampled, view);
        if !current {
            copy(ctx, view, false);
        }
        if let Some(target) = ctx.drawable.target_mut() {
            target.issued(view);
        }
        if let Some(canvas) = ctx.view_copies.displayed.canvases.get(view) {
            // SAFETY: a framebuffer of Cupola, bound instead of the stand-in framebuffer, which is
            // bound again below.
            unsafe { ctx.driver.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, canvas.framebuffer()) };
        }
        window_space::own_window_space(ctx, whole);
        window_space::program_window_space(&mut ctx.draw);
        DrawClass::Flat
    });
    // SAFETY: the stand-in framebuffer of the program's window.
    unsafe { ctx.driver.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, window) };
    ctx.view_copies.displayed.current = Some((number, part));
}
