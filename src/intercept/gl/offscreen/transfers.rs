//! Copies between framebuffers, and from framebuffers to textures, if one side is drawn once per
//! view.

use crate::backend::gl::driver::api;
use crate::backend::gl::objects::framebuffers::{self, FramebufferBindings};
use crate::correct::{BlitRect, LowerLeftRect, Size};
use crate::intercept::gl::context::errors::drop_errors;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::offscreen::view_copies::{
    self, copy_count, look, make_framebuffer, own_tile, possible, supply, views,
};
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::frame::Frame;
use crate::intercept::gl::state::offscreen::depth_converter::DepthConverter;
use crate::intercept::gl::state::offscreen::framebuffers::COLOURS;
use crate::intercept::gl::state::offscreen::images::{Image, Name};
use crate::intercept::gl::state::offscreen::single_sample::SingleSampleImage;
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;

/// One side of a copy.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    /// The window with its views.
    Window,
    /// Framebuffer that is drawn once per view, by its place in the list.
    ViewCopies(usize),
    /// Image with a view copy, by its place in the list.
    Image(usize),
    /// Framebuffer or image that is drawn only once.
    Single,
}

/// Performs `glBlitFramebuffer` between the program's framebuffers. Returns false if the caller
/// must perform it unchanged.
pub fn blit(ctx: &mut Context, source: BlitRect, destination: BlitRect, mask: u32, filter: u32) -> bool {
    if !possible(&ctx.drawable) {
        return false;
    }
    view_copies::look_at_read(&mut ctx.driver, &ctx.app, &mut ctx.view_copies);
    note_blit(ctx, source, destination, mask);
    let (from, to) = (read_side(ctx), draw_side(ctx));
    let part = shown_part(ctx, source, destination).filter(|_| to == Side::Window);
    let fills = to != Side::Window || part.is_some();
    match (from, to) {
        (Side::Single, Side::Single | Side::Window) | (Side::Window, Side::Window | Side::Single) => false,
        (Side::ViewCopies(index), to) if to == Side::Single || !fills => {
            let set = ctx.view_copies.attached(index);
            supply(ctx, set, own_tile(&ctx.drawable, &ctx.view_copies));
            false
        }
        _ => {
            // The part of the window becomes all of each view.
            let destination = part.map_or(destination, |part| spread(&ctx.drawable, part, destination));
            copy_views(ctx, (from, source), (to, destination), mask, filter);
            true
        }
    }
}

/// Returns the part of the window that a copy of the program fills with a whole image, if it is more
/// than half of the window. A copy to nearly all of the window fills all of it.
pub fn shown_part(ctx: &Context, source: BlitRect, destination: BlitRect) -> Option<LowerLeftRect> {
    let size = ctx.drawable.target()?.size();
    let window = LowerLeftRect::of_size(size);
    if fills_window(&ctx.drawable, destination) {
        return Some(window);
    }
    let image = colours_of_read(&ctx.app, &ctx.view_copies).into_iter().flatten().next()?;
    let whole = LowerLeftRect::of_size(ctx.view_copies.image(image)?.size);
    let part = destination.unmirrored();
    (source.unmirrored() == whole && window.contains(part) && part.is_most_of(size)).then_some(part)
}

/// Returns the destination of a copy to `part` of the window, spread to the whole window.
fn spread(drawable: &Drawable, part: LowerLeftRect, destination: BlitRect) -> BlitRect {
    let Some(window) = drawable.target().map(|target| LowerLeftRect::of_size(target.size())) else {
        return destination;
    };
    if part == window {
        return destination;
    }
    let BlitRect { start, end } = window.corners();
    let ends =
        |i: usize| if destination.start[i] > destination.end[i] { [end[i], start[i]] } else { [start[i], end[i]] };
    let [[x0, x1], [y0, y1]] = [ends(0), ends(1)];
    BlitRect::new(x0, y0, x1, y1)
}

/// True if a copy covers all, or nearly all, of the window.
pub fn fills_window(drawable: &Drawable, BlitRect { start: [x0, y0], end: [x1, y1] }: BlitRect) -> bool {
    let Some(target) = drawable.target() else { return false };
    let (width, height) = target.size();
    let inside = |a: i32, b: i32, size: u32| i64::from(a.max(b).min(size as i32) - a.min(b).max(0)).max(0);
    10 * inside(x0, x1, width) * inside(y0, y1, height) >= 9 * i64::from(width) * i64::from(height)
}

/// True if the window's views show anything. The picture of a program without drawing in
/// perspective is on the panel.
fn window_has_scene(frame: &Frame, view_copies: &ViewCopies) -> bool {
    let shown = || view_copies.images.iter().any(|image| image.displayed && image.view_copy.is_some());
    frame.has_scene() || shown()
}

fn read_side(ctx: &Context) -> Side {
    if ctx.reads_redirected() {
        return Side::Window;
    }
    let index = ctx.view_copies.position(ctx.app.read_framebuffer());
    let index = index.filter(|index| ctx.view_copies.has_view_copies(&ctx.view_copies.framebuffers[*index]));
    index.map_or(Side::Single, Side::ViewCopies)
}

fn draw_side(ctx: &mut Context) -> Side {
    if ctx.redirected() {
        return Side::Window;
    }
    let index = look(ctx);
    let duplicated = ctx.view_copies.has_view_copies(&ctx.view_copies.framebuffers[index]);
    if duplicated { Side::ViewCopies(index) } else { Side::Single }
}

/// Notes what a copy reveals about images.
fn note_blit(ctx: &mut Context, source: BlitRect, destination: BlitRect, mask: u32) {
    if mask & api::GL_COLOR_BUFFER_BIT == 0 {
        return;
    }
    let sources = colours_of_read(&ctx.app, &ctx.view_copies);
    if ctx.redirected() {
        let Some(part) = shown_part(ctx, source, destination) else { return };
        for name in sources.into_iter().flatten() {
            let Some(image) = ctx.view_copies.image_mut(name) else { continue };
            let new = !std::mem::replace(&mut image.displayed, true);
            ctx.view_copies.learnt |= new;
        }
        ctx.view_copies.parts.note(part);
        return;
    }
    let from_window = ctx.reads_redirected() && window_has_scene(&ctx.frame, &ctx.view_copies);
    if !from_window && sources.iter().all(Option::is_none) {
        return;
    }
    let index = look(ctx);
    let attachments = ctx.view_copies.framebuffers[index].attachments;
    for name in attachments.into_iter().flatten() {
        note_copy(&mut ctx.view_copies, name, &sources, from_window);
    }
}

/// Notes that a colour image is a copy of others, or of the window.
fn note_copy(view_copies: &mut ViewCopies, name: Name, sources: &[Option<Name>], from_window: bool) {
    if view_copies.image(name).is_some_and(Image::is_colour) {
        note_any_copy(view_copies, name, sources, from_window);
    }
}

/// Notes that an image is a copy of others, or of the window.
fn note_any_copy(view_copies: &mut ViewCopies, name: Name, sources: &[Option<Name>], from_window: bool) {
    let Some(image) = view_copies.image_mut(name) else { return };
    let mut learnt = from_window && !image.copies_window;
    image.copies_window |= from_window;
    for source in sources.iter().flatten() {
        if *source != name && !image.reads.contains(source) {
            image.reads.push(*source);
            learnt = true;
        }
    }
    view_copies.learnt |= learnt;
}

/// Returns the colour images of the read framebuffer.
fn colours_of_read(app: &AppState, view_copies: &ViewCopies) -> [Option<Name>; COLOURS] {
    let index = view_copies.position(app.read_framebuffer());
    let mut colours = [None; COLOURS];
    if let Some(index) = index.filter(|_| app.read_framebuffer() != 0) {
        for (colour, name) in colours.iter_mut().zip(view_copies.framebuffers[index].colours()) {
            *colour = Some(name);
        }
    }
    colours
}

/// Returns the depth image of the read framebuffer.
fn depth_of_read(app: &AppState, view_copies: &ViewCopies) -> Option<Name> {
    let index = view_copies.position(app.read_framebuffer()).filter(|_| app.read_framebuffer() != 0)?;
    view_copies.framebuffers[index].depth()
}

/// Framebuffer of a side for a view, and the position of its picture there.
struct Region {
    framebuffer: u32,
    rect: LowerLeftRect,
    /// Width and height of the picture in the program's pixels.
    size: Size,
    samples: i32,
    format: u32,
}

impl Region {
    /// Returns the region of a side. `mask`: the buffers that are copied.
    fn of(ctx: &mut Context, side: Side, view: usize, mask: u32, reads: bool) -> Option<Self> {
        match side {
            Side::Window => {
                let target = ctx.drawable.target()?;
                let several = target.config().samples > 0;
                let framebuffer = if reads && several { target.readable_framebuffer() } else { target.framebuffer() };
                let (rect, size) = (target.session.tile(view).0, target.size().into());
                let samples = if reads { 0 } else { target.config().samples };
                Some(Self { framebuffer, rect, size, samples, format: window_format(&ctx.drawable) })
            }
            Side::ViewCopies(index) => {
                let framebuffer = &ctx.view_copies.framebuffers[index];
                let depth = framebuffer.depth().filter(|_| mask & api::GL_COLOR_BUFFER_BIT == 0);
                let image = ctx.view_copies.image(depth.or(framebuffer.images().next())?)?;
                let rect = image.view_copy.as_ref()?.grid.tile(view);
                let (size, samples, format) = (image.size, image.samples, image.format);
                Some(Self { framebuffer: framebuffer.view_copy, rect, size, samples, format })
            }
            Side::Image(index) => {
                let image = &mut ctx.view_copies.images[index];
                let framebuffer = image.view_copy_framebuffer(ctx.driver.gl, ctx.driver.id);
                let rect = image.view_copy.as_ref()?.grid.tile(view);
                Some(Self { framebuffer, rect, size: image.size, samples: image.samples, format: image.format })
            }
            Side::Single => None,
        }
    }

    /// Converts the program's corners to corners in the framebuffer.
    fn corners(&self, corners: BlitRect) -> BlitRect {
        let LowerLeftRect { x, y, width, height } = self.rect;
        let scale = |value: i32, size: i32, full: i32| {
            let scaled = i64::from(value) * i64::from(size);
            (scaled as f64 / f64::from(full.max(1))).round() as i32
        };
        let Size { width: across, height: up } = self.size;
        let placed =
            |[to_right, upwards]: [i32; 2]| [x + scale(to_right, width, across), y + scale(upwards, height, up)];
        BlitRect { start: placed(corners.start), end: placed(corners.end) }
    }
}

/// Copies each view, and the program's own picture.
fn copy_views(ctx: &mut Context, from: (Side, BlitRect), to: (Side, BlitRect), mask: u32, filter: u32) {
    let gl = ctx.driver.gl;
    for side in [from.0, to.0] {
        if let Side::ViewCopies(index) = side
            && ctx.view_copies.framebuffers[index].view_copy == 0
            && !make_framebuffer(ctx, index)
        {
            return;
        }
    }
    if to.0 == Side::Window {
        ctx.view_copies.window_changed();
    }
    match to.0 {
        Side::ViewCopies(index) => ctx.view_copies.changed(index),
        Side::Image(index) => ctx.view_copies.images[index].changed(),
        _ => {}
    }
    if from.0 == Side::Window
        && let Some(target) = ctx.drawable.target()
    {
        target.resolve(&ctx.driver, &ctx.app, &ctx.drawable, None);
    }
    let mut buffer = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_integerv(api::GL_READ_BUFFER, &mut buffer) };
    // The window has no tile for the program's own picture, so that picture does not change.
    let count = if from.0 == Side::Window || to.0 == Side::Window {
        views(&ctx.drawable)
    } else {
        copy_count(&ctx.drawable, &ctx.view_copies)
    };
    // SAFETY: framebuffers of Cupola, or as the program bound them; the bindings are put back.
    unsafe {
        let bindings = FramebufferBindings::save(gl);
        for view in 0..count {
            let Some(target) = Region::of(ctx, to.0, view, mask, false) else { break };
            let source = Region::of(ctx, from.0, view, mask, true);
            if let Some(source) = &source {
                gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, source.framebuffer);
                if from.0 != Side::Window {
                    gl.read_buffer(buffer as u32);
                }
            }
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, target.framebuffer);
            ctx.set_scissor(Some(target.rect));
            let here = match &source {
                Some(source) => End { corners: source.corners(from.1), samples: source.samples, format: source.format },
                None => End { corners: from.1, samples: 0, format: target.format },
            };
            let there = End { corners: target.corners(to.1), samples: target.samples, format: target.format };
            resample(ctx, here, there, mask, filter);
        }
        bindings.restore(gl);
    }
    if to.0 != Side::Window {
        view_copies::leave(ctx);
        ctx.restore_window_space();
    }
}

/// Side of a copy between the bound framebuffers.
#[derive(Clone, Copy)]
pub(in crate::intercept::gl) struct End {
    /// Rectangle of the picture.
    pub corners: BlitRect,
    /// Samples per pixel; 0 = not multisampled.
    pub samples: i32,
    /// Format of the colours.
    pub format: u32,
}

/// Copies between the bound framebuffers. A copy to another size goes through a canvas: OpenGL
/// cannot scale multisampled pictures, and a filter would mix in texels beside the rectangle.
pub(in crate::intercept::gl) fn resample(ctx: &mut Context, from: End, to: End, mask: u32, filter: u32) {
    let gl = ctx.driver.gl;
    let (here, there) = (from.corners.unmirrored().size(), to.corners.unmirrored().size());
    let issue = |from: BlitRect, to: BlitRect, mask: u32, filter: u32| {
        // SAFETY: the caller bound both framebuffers.
        unsafe { framebuffers::blit(gl, from, to, mask, filter) };
    };
    let is_depth = mask & api::GL_COLOR_BUFFER_BIT == 0;
    if is_depth && from.format != to.format && here == there && from.samples == 0 && to.samples == 0 {
        convert_depth(&ctx.driver, &mut ctx.view_copies, from, to);
        return;
    }
    // Multisampled pictures can be copied to the same format only.
    let alike = from.format == to.format || (from.samples == 0 && to.samples == 0);
    if here == there && alike {
        issue(from.corners, to.corners, mask, if mask == api::GL_COLOR_BUFFER_BIT { filter } else { api::GL_NEAREST });
        return;
    }
    let depth = mask & !api::GL_COLOR_BUFFER_BIT;
    if depth != 0 && (here == there || (from.samples == 0 && to.samples == 0)) {
        issue(from.corners, to.corners, depth, api::GL_NEAREST);
    }
    let colour = api::GL_COLOR_BUFFER_BIT;
    if mask & colour == 0 {
        return;
    }
    let whole = |size: Size| LowerLeftRect::of_size(size).corners();
    let (resolved, scaled) = (
        canvas(&ctx.driver, &mut ctx.view_copies, here, from.format),
        (to.samples > 0).then(|| canvas(&ctx.driver, &mut ctx.view_copies, there, to.format)),
    );
    let Some(resolved) = resolved else { return };
    // SAFETY: copies between framebuffers of Cupola and the bound ones; the bindings are put back.
    unsafe {
        let bindings = FramebufferBindings::save(gl);
        let scissor = ctx.driver.scissor();
        ctx.set_scissor(None);
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, resolved);
        issue(from.corners, whole(here), colour, api::GL_NEAREST);
        gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, resolved);
        if let Some(Some(scaled)) = scaled {
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, scaled);
            issue(whole(here), whole(there), colour, api::GL_LINEAR);
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, scaled);
        }
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, bindings.draw());
        ctx.set_scissor(scissor);
        match scaled {
            None => issue(whole(here), to.corners, colour, api::GL_LINEAR),
            Some(_) => issue(whole(there), to.corners, colour, api::GL_NEAREST),
        }
        bindings.restore(gl);
    }
}

/// Copies depth to another format by a copy into a texture, as no other command can do it. Does not
/// copy stencil.
fn convert_depth(driver: &Driver, view_copies: &mut ViewCopies, from: End, to: End) {
    let (size, gl) = (from.corners.unmirrored().size(), driver.gl);
    let converters = &mut view_copies.depth_converters;
    if !converters.iter().any(|converter| converter.is(size, to.format)) {
        // One converter of each format is kept.
        if let Some(index) = converters.iter().position(|converter| converter.format() == to.format) {
            converters.swap_remove(index).destroy(gl);
        }
        converters.extend(DepthConverter::new(gl, size, to.format));
    }
    if let Some(converter) = converters.iter().find(|converter| converter.is(size, to.format)) {
        converter.convert(gl, from.corners, to.corners);
    }
}

/// Returns the format of the window's colours.
pub(in crate::intercept::gl) fn window_format(drawable: &Drawable) -> u32 {
    if drawable.target().is_some_and(|target| target.config().srgb) { api::GL_SRGB8_ALPHA8 } else { api::GL_RGBA8 }
}

/// Returns a framebuffer of Cupola with this size and format, and keeps it for later calls.
fn canvas(driver: &Driver, view_copies: &mut ViewCopies, size: Size, format: u32) -> Option<u32> {
    if let Some(canvas) = view_copies.canvases.iter().find(|canvas| canvas.is(size, format)) {
        return Some(canvas.framebuffer());
    }
    let canvas = SingleSampleImage::new(driver.gl, size, format)?;
    let framebuffer = canvas.framebuffer();
    view_copies.canvases.push(canvas);
    Some(framebuffer)
}

/// Performs a copy of a rectangle of the program's read framebuffer into a texture, for each view.
/// Returns true if it was performed, and the texture itself must not be changed.
pub fn into_texture(ctx: &mut Context, texture: u32, level: i32, offset: [i32; 2], source: LowerLeftRect) -> bool {
    let from = read_side(ctx);
    let Some(index) =
        image_of(&ctx.view_copies, texture, level).filter(|_| possible(&ctx.drawable) && from != Side::Single)
    else {
        return false;
    };
    let image = &ctx.view_copies.images[index];
    if image.view_copy.is_none() {
        return false;
    }
    let (mask, [x, y]) = (image.mask, offset);
    let to = (Side::Image(index), LowerLeftRect { x, y, ..source }.corners());
    copy_views(ctx, (from, source.corners()), to, mask, api::GL_NEAREST);
    from != Side::Window || copy_count(&ctx.drawable, &ctx.view_copies) == views(&ctx.drawable)
}

/// Notes that the program has copied a rectangle of its read framebuffer into a texture.
pub fn noted_into_texture(ctx: &mut Context, texture: u32, level: i32, source: LowerLeftRect) {
    let whole = fills_window(&ctx.drawable, source.corners());
    let from_window = ctx.reads_redirected() && whole && window_has_scene(&ctx.frame, &ctx.view_copies);
    let (sources, depth) = (colours_of_read(&ctx.app, &ctx.view_copies), depth_of_read(&ctx.app, &ctx.view_copies));
    if !possible(&ctx.drawable) || (!from_window && depth.is_none() && sources.iter().all(Option::is_none)) {
        return;
    }
    let index = match image_of(&ctx.view_copies, texture, level) {
        Some(index) => index,
        None => {
            ctx.driver.take_errors();
            let image = Image::examine_texture(ctx.driver.gl, texture, level);
            drop_errors(ctx.driver.gl);
            let Some(image) = image else { return };
            ctx.view_copies.images.push(image);
            ctx.view_copies.images.len() - 1
        }
    };
    let image = &ctx.view_copies.images[index];
    let (name, is_colour) = (image.name, image.is_colour());
    if is_colour {
        note_any_copy(&mut ctx.view_copies, name, &sources, from_window);
    } else {
        note_any_copy(&mut ctx.view_copies, name, &[depth], false);
    }
    if copy_count(&ctx.drawable, &ctx.view_copies) > views(&ctx.drawable) {
        let own = own_tile(&ctx.drawable, &ctx.view_copies);
        view_copies::without_scissor(ctx, |ctx| ctx.view_copies.images[index].store(ctx.driver.gl, ctx.driver.id, own));
    }
}

fn image_of(view_copies: &ViewCopies, texture: u32, level: i32) -> Option<usize> {
    let mut images = view_copies.images.iter();
    images.position(
        |image| matches!(image.name, Name::Texture { name, level: own, .. } if name == texture && own == level),
    )
}
