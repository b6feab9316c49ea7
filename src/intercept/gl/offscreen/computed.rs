//! Dispatches of compute shaders between the scene and the window. They are issued once per view in
//! the program's own images, which get the content of each view in turn.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::Size;
use crate::intercept::gl::context::errors::drop_errors;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::offscreen::sampling;
use crate::intercept::gl::offscreen::view_copies::{
    before_reading_images, copy_count, leave, own_tile, possible, supply, views, without_scissor,
};
use crate::intercept::gl::shader::camera_matrices::upload;
use crate::intercept::gl::shader::changed::images::{self, ImageUnit};
use crate::intercept::gl::shader::programs;
use crate::intercept::gl::state::draw::draw_class::DrawClass;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::offscreen::images::{Image, Name, Set};
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;
use crate::intercept::gl::state::shader::programs::{BufferWrites, ComputeStage};
use crate::runtime::Session;

/// Greatest number of texels of an image that may hold numbers for the whole picture, and is no
/// picture itself.
const MOST_NUMBERS: i32 = 256;

/// Images that a dispatch reads and writes.
struct Used {
    read: Set,
    /// Pictures that it writes.
    written: Set,
    /// True if it writes numbers for the whole picture.
    numbers: bool,
    /// True if it cannot be followed: it writes separate values for each place, or numbers and
    /// pictures at once.
    lost: bool,
}

/// Issues a dispatch. `groups`: number of its work groups, if it is known.
pub fn dispatch(ctx: &mut Context, groups: Option<u32>, issue: &mut dyn FnMut(&Gl)) {
    if ctx.shaders.used() != 0 {
        return dispatch_by_program(ctx, groups, issue);
    }
    let computing = programs::record(&ctx.share, ctx.shaders.stages().compute());
    let drawing = ctx.shaders.choose(computing);
    dispatch_by_program(ctx, groups, issue);
    ctx.shaders.choose(drawing);
}

/// Issues a dispatch of the program in `ctx.shaders`.
fn dispatch_by_program(ctx: &mut Context, groups: Option<u32>, issue: &mut dyn FnMut(&Gl)) {
    let gl = ctx.driver.gl;
    if let Some(view) = ctx.session().and_then(Session::turn) {
        upload::load_view(ctx, view, DrawClass::Flat);
        issue(gl);
        return upload::load_own(ctx);
    }
    let program = ctx.shaders.program().cloned();
    let stage = program.as_ref().and_then(|program| program.compute.as_ref());
    let Some(stage) = stage.filter(|_| ctx.view_copies.any() && possible(&ctx.drawable)) else { return issue(gl) };
    let used = used(ctx, stage, groups == Some(1));
    ctx.view_copies.computes |= used.written != 0;
    note(&mut ctx.view_copies, &used);
    let has_view_copy = |ctx: &Context, set: Set| {
        let images = ctx.view_copies.images.iter().enumerate().take(64);
        images.filter(|(i, _)| set >> i & 1 != 0).any(|(_, image)| image.view_copy.is_some())
    };
    if used.lost || !has_view_copy(ctx, used.written) {
        if used.numbers && used.read != 0 {
            before_reading_images(&mut ctx.view_copies, used.read);
        }
        supply(ctx, used.read, own_tile(&ctx.drawable, &ctx.view_copies));
        return issue(gl);
    }
    leave(ctx);
    let own = views(&ctx.drawable);
    for view in 0..copy_count(&ctx.drawable, &ctx.view_copies) {
        supply(ctx, used.read | used.written, view);
        match view < own {
            true => upload::load_view(ctx, view, DrawClass::Flat),
            false => upload::load_own(ctx),
        }
        barrier(gl);
        issue(gl);
        barrier(gl);
        without_scissor(ctx, |ctx| {
            let images = ctx.view_copies.images.iter_mut().enumerate().take(64);
            for (_, image) in images.filter(|(i, _)| used.written >> i & 1 != 0) {
                image.store(gl, ctx.driver.id, view);
            }
        });
    }
    upload::load_own(ctx);
}

/// Makes the writes of shaders visible to copies and to shaders.
fn barrier(gl: &Gl) {
    // SAFETY: every context with compute shaders has this command.
    unsafe { gl.memory_barrier(api::GL_ALL_BARRIER_BITS) };
}

/// Determines the images that a dispatch uses. Written images that were not followed are followed
/// from now on, if the dispatch makes them from followed ones.
fn used(ctx: &mut Context, stage: &ComputeStage, single: bool) -> Used {
    let mut used = Used {
        read: sampling::sampled(&ctx.driver, &ctx.shaders, &ctx.view_copies),
        written: 0,
        numbers: false,
        lost: stage.loses_cameras,
    };
    let gl = ctx.driver.gl;
    let program = ctx.shaders.program().map_or(0, |program| program.name);
    let mut unknown = false;
    for location in &stage.images {
        let Some(bound) = bound_image(gl, program, *location) else { continue };
        match position(&ctx.view_copies, &bound) {
            Some(index) => used.add(ctx, &bound, index),
            None => unknown |= bound.written,
        }
    }
    if unknown && used.read != 0 {
        for location in &stage.images {
            let Some(bound) = bound_image(gl, program, *location).filter(|bound| bound.written) else { continue };
            if position(&ctx.view_copies, &bound).is_some() {
                continue;
            }
            match examine(&mut ctx.driver, &mut ctx.view_copies, &bound) {
                Some(index) => used.add(ctx, &bound, index),
                None => used.lost = true,
            }
        }
    }
    let writes = |location: &i32| bound_image(gl, program, *location).is_some_and(|bound| bound.written);
    used.lost |= used.read != 0 && stage.other_images.iter().any(writes);
    match stage.buffers {
        BufferWrites::Nothing => {}
        BufferWrites::Places if !single => used.lost = true,
        BufferWrites::Sums | BufferWrites::Places => used.numbers = true,
    }
    // A dispatch for each view would add up these values several times.
    let gathers = stage.buffers != BufferWrites::Nothing || stage.image_atomics;
    used.lost |= gathers && used.written != 0;
    used
}

impl Used {
    /// Adds a bound image, which is at `index` in the list.
    fn add(&mut self, ctx: &Context, bound: &BoundImage, index: usize) {
        let Size { width, height } = ctx.view_copies.images[index].size;
        let bit = if index < 64 { 1 << index } else { 0 };
        if bound.read {
            self.read |= bit;
        }
        if bound.written {
            match i64::from(width) * i64::from(height) <= i64::from(MOST_NUMBERS) {
                true => self.numbers = true,
                false => self.written |= bit,
            }
        }
    }
}

/// Texture that is bound as an image.
struct BoundImage {
    texture: u32,
    level: i32,
    read: bool,
    written: bool,
}

/// Returns the texture that is bound for the program's image at this location.
fn bound_image(gl: &Gl, program: u32, location: i32) -> Option<BoundImage> {
    let ImageUnit { texture, level, access } = images::unit(gl, program, location)?;
    let (read, written) = (access != api::GL_WRITE_ONLY, access != api::GL_READ_ONLY);
    Some(BoundImage { texture, level, read, written })
}

/// Returns the place of a bound image in the list.
fn position(view_copies: &ViewCopies, bound: &BoundImage) -> Option<usize> {
    let is_it = |image: &Image| matches!(image.name, Name::Texture { name, level, .. } if (name, level) == (bound.texture, bound.level));
    view_copies.images.iter().position(is_it)
}

/// Adds a bound image to the list, if it can be followed.
fn examine(driver: &mut Driver, view_copies: &mut ViewCopies, bound: &BoundImage) -> Option<usize> {
    let key = (bound.texture, bound.level);
    if view_copies.not_followed.contains(&key) {
        return None;
    }
    driver.take_errors();
    let image = Image::examine_texture(driver.gl, bound.texture, bound.level);
    drop_errors(driver.gl);
    let Some(image) = image else {
        view_copies.not_followed.push(key);
        return None;
    };
    view_copies.images.push(image);
    Some(view_copies.images.len() - 1)
}

/// Notes which images the dispatch makes from which others.
fn note(view_copies: &mut ViewCopies, used: &Used) {
    let images = &mut view_copies.images;
    let names: [Option<Name>; 64] = std::array::from_fn(|i| images.get(i).map(|image| image.name));
    for (i, image) in images.iter_mut().enumerate().take(64) {
        if used.lost && (used.read | used.written) >> i & 1 != 0 && !image.lost {
            image.lost = true;
            view_copies.learnt = true;
        }
        if used.lost || used.written >> i & 1 == 0 {
            continue;
        }
        let sources = names.iter().enumerate().filter(|(j, _)| *j != i && used.read >> j & 1 != 0);
        for source in sources.filter_map(|(_, name)| *name) {
            if !image.reads.contains(&source) {
                image.reads.push(source);
                view_copies.learnt = true;
            }
        }
    }
}
