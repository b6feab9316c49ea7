//! Depth and stencil of the program's own picture for its first read. Each pixel gets the values of
//! one texel, from the view that shows its direction.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::objects::framebuffers::{FramebufferBindings, blit};
use crate::correct;
use crate::correct::{BlitRect, LowerLeftRect, Size};
use crate::intercept::gl::context::read_pixels;
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::frame::Frame;
use crate::runtime::cache;
use crate::runtime::session::ClipRows;
use crate::views::{Tile, View};
use glam::{DMat3, DVec3};

/// Greatest depth in 24 bits.
const DEEPEST: u32 = (1 << 24) - 1;

/// Depth and stencil of an empty window.
const EMPTY: u32 = DEEPEST << 8;

/// Fills the primary tile. `directions`: matrix from a pixel (−1…1 to the right and up, 1) to its
/// direction in the viewer's axes. The direction has the length at which it reaches −1 along the
/// program's axis. The views must be drawn and, if they have several samples, resolved.
pub fn fill(driver: &Driver, frame: &Frame, target: &DefaultFramebuffer, directions: DMat3) {
    // OpenGL ES cannot read depth, so the program cannot read it either.
    let (Some(lens), Some(primary), false) = (frame.lens(), target.primary(), driver.profile.es) else {
        return;
    };
    let Size { width, height } = primary.size();
    let gl = driver.gl;
    let plan = target.session.plan();
    let Some(depths) = Depths::of(gl) else { return };
    let mut atlas =
        read(gl, target.readable_framebuffer(), LowerLeftRect::of_size(plan.views.atlas), Content::DepthStencil);
    if !target.closed().is_empty() {
        let row = plan.views.atlas.0 as usize;
        for tile in correct::cached_unsampled_areas(plan, cache::of_process()).concat() {
            let columns = tile.x as usize..(tile.x + tile.width) as usize;
            for line in atlas.chunks_exact_mut(row).skip(tile.y as usize).take(tile.height as usize) {
                line[columns.clone()].fill(EMPTY);
            }
        }
    }
    let reprojections: Vec<ClipRows> = target.session.rows(&lens).collect();
    let texel = |column: i32, line: i32| {
        let place = |i: i32, size: i32| (f64::from(i) + 0.5) * 2.0 / f64::from(size) - 1.0;
        let direction = directions * DVec3::new(place(column, width), place(line, height), 1.0);
        let views = plan.views.views.iter().zip(&reprojections);
        let (reprojection, farther, texel) =
            views.filter(|(view, _)| !view.program_lens).find_map(|(view, reprojection)| {
                let (texel, farther) = find(view, direction)?;
                Some((reprojection, farther, texel))
            })?;
        let value = *atlas.get(texel.1 as usize * plan.views.atlas.0 as usize + texel.0 as usize)?;
        Some(depths.own(value, reprojection, farther))
    };
    let pixels: Vec<u32> = (0..height)
        .flat_map(|line| (0..width).map(move |column| (column, line)))
        .map(|(column, line)| texel(column, line).unwrap_or(EMPTY))
        .collect();
    write(gl, target, primary, Content::DepthStencil, &pixels);
}

/// Kind of values in a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// 24 bits of depth, 8 of stencil.
    DepthStencil,
    /// Red, green, blue and alpha, 8 bits each.
    Color,
}

impl Content {
    /// Returns format and type of the texels and the format of a texture, then attachment and bits
    /// for a copy.
    fn names(self) -> ([u32; 3], [u32; 2]) {
        match self {
            Self::DepthStencil => (
                [api::GL_DEPTH_STENCIL, api::GL_UNSIGNED_INT_24_8, api::GL_DEPTH24_STENCIL8],
                [api::GL_DEPTH_STENCIL_ATTACHMENT, api::GL_DEPTH_BUFFER_BIT | api::GL_STENCIL_BUFFER_BIT],
            ),
            Self::Color => (
                [api::GL_RGBA, api::GL_UNSIGNED_BYTE, api::GL_RGBA8],
                [api::GL_COLOR_ATTACHMENT0, api::GL_COLOR_BUFFER_BIT],
            ),
        }
    }
}

/// Returns the texel of a view that shows a direction, and the ratio of the point's depth along the
/// view's axis to its depth along the program's axis. `None`: the direction does not belong to this
/// view.
pub fn find(view: &View, direction: DVec3) -> Option<((u32, u32), f64)> {
    let seen = view.rotation * direction;
    let Tile { x, y, width, height } = view.tile;
    let texel = |part: f64, texels: u32| ((part * f64::from(texels)) as u32).min(texels.saturating_sub(1));
    if let Some(map) = &view.curved {
        // In the picture of an output the depth is the distance.
        let at = map.shown(seen)?;
        return Some(((x + texel(0.5 + 0.5 * at.x, width), y + texel(0.5 + 0.5 * at.y, height)), direction.length()));
    }
    let (right, up) = (seen.x / -seen.z, seen.y / -seen.z);
    let owned = &view.owned;
    let shown = seen.z < 0.0 && (owned.left..=owned.right).contains(&right) && (owned.bottom..=owned.top).contains(&up);
    let column = x + texel((right - view.frustum.left) / view.frustum.width(), width);
    let line = y + texel((up - view.frustum.bottom) / view.frustum.height(), height);
    shown.then_some(((column, line), -seen.z))
}

/// Relation of stored depths to depths in clip space.
#[derive(Clone, Copy)]
struct Depths {
    /// Stored values of the normalised depths −1 (or 0, as the program has set it) and 1.
    range: [f64; 2],
    /// Normalised depth of the nearest point.
    least: f64,
}

impl Depths {
    /// Returns the program's present relation. `None`: all depths have the same stored value.
    fn of(gl: &Gl) -> Option<Self> {
        let mut range = [0.0f32, 1.0];
        let mut mode = 0;
        // SAFETY: the first writes two numbers, the second one.
        unsafe {
            gl.get_floatv(api::GL_DEPTH_RANGE, range.as_mut_ptr());
            if gl.has_clip_control() {
                gl.get_integerv(api::GL_CLIP_DEPTH_MODE, &mut mode);
            }
        }
        let least = if mode as u32 == api::GL_ZERO_TO_ONE { 0.0 } else { -1.0 };
        (range[0] != range[1]).then_some(Self { range: range.map(f64::from), least })
    }

    /// Returns the value that the program's own picture stores for `texel` of a view. `farther`:
    /// ratio of the point's depth along the view's axis to its depth along the program's axis. The
    /// value of a cleared texel does not change.
    fn own(&self, texel: u32, reprojection: &ClipRows, farther: f64) -> u32 {
        let (depth, stencil) = (texel >> 8, texel & 0xff);
        if depth == 0 || depth == DEEPEST {
            return texel;
        }
        let [near, far] = self.range;
        let normalised =
            self.least + (f64::from(depth) / f64::from(DEEPEST) - near) / (far - near) * (1.0 - self.least);
        let own = reprojection.own_depth(normalised, farther);
        let stored = near + (own - self.least) / (1.0 - self.least) * (far - near);
        ((stored * f64::from(DEEPEST)).round().clamp(0.0, f64::from(DEEPEST)) as u32) << 8 | stencil
    }
}

/// Returns the texels in a rectangle of a framebuffer of Cupola. Bindings and pixel storage are put
/// back.
pub fn read(gl: &Gl, framebuffer: u32, rect: LowerLeftRect, content: Content) -> Vec<u32> {
    let LowerLeftRect { x, y, width, height } = rect;
    let mut texels = vec![EMPTY; width as usize * height as usize];
    let ([format, kind, _], _) = content.names();
    read_pixels::while_reading(gl, framebuffer, || {
        // SAFETY: the array has space for exactly these texels of four bytes.
        unsafe { gl.read_pixels(x, y, width, height, format, kind, texels.as_mut_ptr().cast()) };
    });
    texels
}

/// Writes content into a tile of the stand-in image. Restores all state that it changes.
pub fn write(gl: &Gl, window: &DefaultFramebuffer, tile: LowerLeftRect, content: Content, pixels: &[u32]) {
    let Size { width, height } = tile.size();
    let texture = crate::backend::gl::driver::own_names::texture(gl);
    let ([format, kind, internal], [attachment, bits]) = content.names();
    window.backend().while_uploading(gl, || {
        let start = pixels.as_ptr().cast();
        // SAFETY: the array has exactly this number of texels, without gaps.
        unsafe {
            gl.bind_texture(api::GL_TEXTURE_2D, texture);
            gl.tex_image2_d(api::GL_TEXTURE_2D, 0, internal as i32, width, height, 0, format, kind, start);
        }
    });
    // SAFETY: objects of Cupola; bindings and scissor test are put back.
    unsafe {
        let scissor = gl.is_enabled(api::GL_SCISSOR_TEST) != 0;
        gl.disable(api::GL_SCISSOR_TEST);
        let (bindings, mut own) = (FramebufferBindings::save(gl), 0);
        gl.gen_framebuffers(1, &mut own);
        gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, own);
        gl.framebuffer_texture2_d(api::GL_READ_FRAMEBUFFER, attachment, api::GL_TEXTURE_2D, texture, 0);
        gl.read_buffer(if content == Content::Color { attachment } else { api::GL_NONE });
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, window.framebuffer());
        blit(gl, BlitRect::new(0, 0, width, height), tile.corners(), bits, api::GL_NEAREST);
        bindings.restore(gl);
        gl.delete_framebuffers(1, &own);
        gl.delete_textures(1, &texture);
        if scissor {
            gl.enable(api::GL_SCISSOR_TEST);
        }
    }
}
