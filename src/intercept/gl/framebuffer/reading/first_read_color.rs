//! Colours of the program's own picture for its first read, if the views are pictures of outputs.
//! Each pixel gets the texel that shows its direction, with the flat panel over it.

use crate::correct::{LowerLeftRect, Size};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::framebuffer::reading::first_read_depth::{self, Content, find};
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::driver::Driver;
use glam::{DMat3, DVec3};

/// Fills the primary tile. `directions`: matrix from a pixel (−1…1 to the right and up, 1) to its
/// direction in the viewer's axes. The views must be drawn and, if they have several samples,
/// resolved. Directions that no output shows become black.
pub fn fill(driver: &Driver, target: &DefaultFramebuffer, directions: DMat3) {
    let Some(primary) = target.primary() else { return };
    let Size { width, height } = primary.size();
    let views = &target.session.plan().views;
    let atlas = first_read_depth::read(
        driver.gl,
        target.readable_framebuffer(),
        LowerLeftRect::of_size(views.atlas),
        Content::Color,
    );
    let texel = |(column, line): (u32, u32)| {
        let value = atlas.get(line as usize * views.atlas.0 as usize + column as usize).copied().unwrap_or(0);
        value.to_ne_bytes().map(u16::from)
    };
    let part = |i: i32, size: i32| (f64::from(i) + 0.5) / f64::from(size);
    let pixel = |column: i32, line: i32| {
        let (right, up) = (part(column, width), part(line, height));
        let direction = directions * DVec3::new(2.0 * right - 1.0, 2.0 * up - 1.0, 1.0);
        let mut shown = views.views.iter().filter(|view| !view.program_lens).filter_map(|view| find(view, direction));
        let scene = shown.next().map_or([0; 4], |(place, _)| texel(place));
        let flat = views.panel.as_ref().map_or([0; 4], |panel| {
            let tile = panel.tile;
            let along = |start: u32, texels: u32, part: f64| start + (part * f64::from(texels)) as u32;
            texel((along(tile.x, tile.width, right), along(tile.y, tile.height, up)))
        });
        // The colours of the panel are multiplied by its alpha already.
        let over = |i: usize| (flat[i] + (scene[i] * (255 - flat[3]) + 127) / 255).min(255) as u8;
        u32::from_ne_bytes([over(0), over(1), over(2), 255])
    };
    let pixels: Vec<u32> =
        (0..height).flat_map(|line| (0..width).map(move |column| (column, line))).map(|(c, l)| pixel(c, l)).collect();
    first_read_depth::write(driver.gl, target, primary, Content::Color, &pixels);
}

/// Fills the primary tile before a scene was drawn. All views have the colour of the program's
/// clear. The panel is over it, with its own depth.
pub fn fill_flat(ctx: &Context, target: &DefaultFramebuffer) {
    let (gl, session) = (ctx.driver.gl, &target.session);
    let Some(primary) = target.primary() else { return };
    let Size { width, height } = primary.size();
    let atlas = target.readable_framebuffer();
    target.resolve(&ctx.driver, &ctx.app, &ctx.drawable, Some(LowerLeftRect::of_size(session.plan().views.atlas)));
    let tile = session.tile(0).0;
    let centre = LowerLeftRect::new(tile.x + tile.width / 2, tile.y + tile.height / 2, 1, 1);
    let [cleared] = first_read_depth::read(gl, atlas, centre, Content::Color)[..] else { return };
    let under = cleared.to_ne_bytes().map(u16::from);
    let count = width as usize * height as usize;
    let colours = match session.panel() {
        // The colours of the panel are multiplied by its alpha already. The panel is as large as
        // the window.
        Some(tile) if tile.size() == primary.size() => {
            let over = |flat: u32| {
                let flat = flat.to_ne_bytes().map(u16::from);
                u32::from_ne_bytes(std::array::from_fn(|i| {
                    (flat[i] + (under[i] * (255 - flat[3]) + 127) / 255).min(255) as u8
                }))
            };
            first_read_depth::read(gl, atlas, tile, Content::Color).into_iter().map(over).collect()
        }
        _ => vec![cleared; count],
    };
    first_read_depth::write(gl, target, primary, Content::Color, &colours);
    // OpenGL ES cannot read depth, so the program cannot read it either.
    if session.panel().is_none() && !ctx.driver.profile.es {
        let [depth] = first_read_depth::read(gl, atlas, centre, Content::DepthStencil)[..] else { return };
        first_read_depth::write(gl, target, primary, Content::DepthStencil, &vec![depth; count]);
    }
}
