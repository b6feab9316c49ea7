//! Scenes that a program draws off screen and then shows: each view gets a picture of its own.
//!
//! A framebuffer of the program's that is as large as the window, gets perspective draws and is then shown,
//! by a flat draw or a copy to the window, perhaps through others of that size, is duplicated from the next frame
//! on: drawing goes to a *twin*, whose attachments hold a cell for each view, so that draws of the
//! scene change no framebuffer. Cells have the size of the program's own attachments, so that what it
//! believes about them (size, texel, viewport) stays true. Before a flat draw that samples such a texture is
//! issued to a view, the view's cell is copied into the program's texture: its filter, wrapping and sampler
//! objects hold without being followed.
//!
//! Shadow maps (no colour, or another size), maps and mirrors (another size) stay single.

use super::context::Context;
use super::default_framebuffer::{take_error, take_own_errors};
use super::draw::{Changes, Place, own_window_space};
use crate::backend::gl::api::{self, Gl};
use crate::backend::gl::surface::greatest_texture;
use crate::intercept::log;

/// The most colour attachments that are followed.
const COLOURS: usize = 8;

/// The most samplers of a program that are asked about.
const SAMPLERS: usize = 16;

/// The program's framebuffers that were drawn to.
#[derive(Default)]
pub struct Duplicates {
    list: Vec<Framebuffer>,
    /// The twin of the program's draw framebuffer is bound in its place.
    bound: bool,
    /// Off-screen draws that were issued once per view.
    pub draws: u64,
}

/// A framebuffer of the program's.
struct Framebuffer {
    name: u32,
    /// Textures of its colour attachments; 0 = none.
    colours: [u32; COLOURS],
    size: [i32; 2],
    /// It can have a twin.
    fits: bool,
    /// It has a depth buffer.
    depth: bool,
    /// It got perspective draws.
    scene: bool,
    /// It was shown in the window.
    shown: bool,
    /// Framebuffers whose textures were sampled to draw it.
    reads: Vec<u32>,
    twin: Option<Twin>,
}

/// What stands for a framebuffer: as many cells of its size as there are views.
struct Twin {
    framebuffer: u32,
    textures: [u32; COLOURS],
    depth: u32,
    /// Copies go from `source` to `copy`, which have one attachment at a time.
    source: u32,
    copy: u32,
    columns: i32,
    size: [i32; 2],
}

impl Twin {
    fn cell(&self, index: usize) -> [i32; 4] {
        let (index, [width, height]) = (index as i32, self.size);
        [index % self.columns * width, index / self.columns * height, width, height]
    }

    fn destroy(&self, gl: &Gl) {
        // SAFETY: objects of ours; the name 0 is ignored.
        unsafe {
            gl.delete_framebuffers(3, [self.framebuffer, self.source, self.copy].as_ptr());
            gl.delete_textures(COLOURS as i32, self.textures.as_ptr());
            gl.delete_renderbuffers(1, &self.depth);
        }
    }
}

impl Duplicates {
    /// Whether any framebuffer of the program's is followed.
    pub fn any(&self) -> bool {
        !self.list.is_empty()
    }

    fn position(&self, name: u32) -> Option<usize> {
        self.list.iter().position(|f| f.name == name)
    }

    /// The framebuffers that lie between a scene and the window, by their places in the list.
    fn wanted(&self) -> Vec<usize> {
        let close = |start: &dyn Fn(&Framebuffer) -> bool, step: &dyn Fn(&Framebuffer, &Framebuffer) -> bool| {
            let mut marks: Vec<bool> = self.list.iter().map(start).collect();
            for _ in 0..self.list.len() {
                for i in 0..self.list.len() {
                    let reached = |j: usize| marks[j] && step(&self.list[j], &self.list[i]);
                    marks[i] = marks[i] || (0..self.list.len()).any(reached);
                }
            }
            marks
        };
        let from_scene = close(&|f| f.scene, &|from, to| to.reads.contains(&from.name));
        let to_window = close(&|f| f.shown, &|to, from| to.reads.contains(&from.name));
        let wanted = |i: &usize| from_scene[*i] && to_window[*i] && self.list[*i].fits;
        (0..self.list.len()).filter(wanted).collect()
    }
}

/// Whether there is anything to do: views of ours, which are not the program's own picture.
fn possible(ctx: &Context) -> bool {
    crate::intercept::settings::settings().is_some_and(|s| s.duplicate)
        && ctx.target.as_ref().is_some_and(|t| t.session.views().iter().any(|v| !v.program_lens))
}

/// Looks at the framebuffer that is bound for drawing.
fn examine(ctx: &Context, name: u32) -> Framebuffer {
    let gl = ctx.gl;
    let mut found = Framebuffer {
        name,
        colours: [0; COLOURS],
        size: [0; 2],
        fits: false,
        depth: false,
        scene: false,
        shown: false,
        reads: Vec::new(),
        twin: None,
    };
    let asks_levels = if ctx.profile.es { ctx.profile.version >= 31 } else { ctx.profile.version >= 30 };
    let Some(target) = ctx.target.as_ref().filter(|_| asks_levels) else { return found };
    let window = [target.size().0 as i32, target.size().1 as i32];
    let ask = |attachment: u32, what: u32| {
        let mut answer = 0;
        // SAFETY: writes one integer about the program's framebuffer.
        unsafe { gl.get_framebuffer_attachment_parameteriv(api::GL_DRAW_FRAMEBUFFER, attachment, what, &mut answer) };
        answer
    };
    let kind = |attachment: u32| ask(attachment, api::GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE) as u32;
    let mut fits = true;
    let mut any = false;
    for (i, colour) in found.colours.iter_mut().enumerate() {
        let attachment = api::GL_COLOR_ATTACHMENT0 + i as u32;
        match kind(attachment) {
            api::GL_NONE => continue,
            api::GL_TEXTURE => {}
            _ => {
                fits = false;
                continue;
            }
        }
        let whole = ask(attachment, api::GL_FRAMEBUFFER_ATTACHMENT_TEXTURE_LEVEL) == 0
            && ask(attachment, api::GL_FRAMEBUFFER_ATTACHMENT_TEXTURE_CUBE_MAP_FACE) == 0;
        let texture = ask(attachment, api::GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME) as u32;
        let size = if whole { level_size(gl, texture) } else { None };
        fits &= size == Some(window);
        any = true;
        *colour = texture;
    }
    let depth = kind(api::GL_DEPTH_ATTACHMENT);
    if depth == api::GL_TEXTURE {
        log::once("a scene that the program draws off screen with a depth texture is shown flat");
        fits = false;
    }
    found.depth = depth == api::GL_RENDERBUFFER;
    found.size = window;
    found.fits = fits && any;
    found
}

/// Width and height of a two-dimensional texture; `None` for others.
fn level_size(gl: &Gl, texture: u32) -> Option<[i32; 2]> {
    let mut size = [0; 2];
    with_texture(gl, texture, || {
        // SAFETY: writes one integer each.
        unsafe {
            gl.get_tex_level_parameteriv(api::GL_TEXTURE_2D, 0, api::GL_TEXTURE_WIDTH, &mut size[0]);
            gl.get_tex_level_parameteriv(api::GL_TEXTURE_2D, 0, api::GL_TEXTURE_HEIGHT, &mut size[1]);
        }
    });
    (size[0] > 0 && size[1] > 0).then_some(size)
}

/// Runs `run` with a texture bound; the program's binding is put back.
fn with_texture(gl: &Gl, texture: u32, run: impl FnOnce()) {
    let mut bound = 0;
    // SAFETY: a texture of the program's or of ours; the binding is put back.
    unsafe {
        gl.get_integerv(api::GL_TEXTURE_BINDING_2D, &mut bound);
        gl.bind_texture(api::GL_TEXTURE_2D, texture);
        run();
        gl.bind_texture(api::GL_TEXTURE_2D, bound as u32);
    }
}

/// The program's draw framebuffer is bound itself again, for calls that name its binding.
pub fn leave(ctx: &mut Context) {
    if std::mem::take(&mut ctx.duplicates.bound) {
        // SAFETY: what the program bound.
        unsafe { ctx.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, ctx.believed.draw_framebuffer) };
        ctx.restore_window_space();
    }
}

/// The binding changed: nothing of ours stands in its place.
pub fn rebound(ctx: &mut Context) -> bool {
    std::mem::take(&mut ctx.duplicates.bound)
}

/// What the program knows of a framebuffer changed, or its name is free: it is looked at anew.
pub fn forget(ctx: &mut Context, name: u32) {
    if let Some(index) = ctx.duplicates.position(name) {
        if ctx.believed.draw_framebuffer == name {
            leave(ctx);
        }
        if let Some(twin) = ctx.duplicates.list.swap_remove(index).twin {
            twin.destroy(ctx.gl);
        }
    }
}

/// A texture was deleted or got another size: what it was attached to is looked at anew.
pub fn forget_texture(ctx: &mut Context, texture: u32) {
    while let Some(name) = ctx.duplicates.list.iter().find(|f| f.colours.contains(&texture)).map(|f| f.name) {
        forget(ctx, name);
    }
}

/// The program does with the framebuffer `name` what only its own picture can answer: it stays single from now on.
pub fn refuse(ctx: &mut Context, name: u32, what: &str) {
    let twins = |f: &Framebuffer| f.name == name && f.twin.is_some();
    if name == 0 || !ctx.duplicates.list.iter().any(twins) {
        return;
    }
    leave(ctx);
    for framebuffer in ctx.duplicates.list.iter_mut().filter(|f| twins(f)) {
        framebuffer.fits = false;
        if let Some(twin) = framebuffer.twin.take() {
            twin.destroy(ctx.gl);
        }
        log::once(&format!("a scene that the program draws off screen is shown flat from now on: {what}"));
    }
}

/// [`refuse`] for the framebuffers that a texture belongs to; 0 = the one that is bound.
pub fn refuse_texture(ctx: &mut Context, texture: u32, what: &str) {
    let mut bound = texture as i32;
    if texture == 0 {
        // SAFETY: writes one integer.
        unsafe { ctx.gl.get_integerv(api::GL_TEXTURE_BINDING_2D, &mut bound) };
    }
    let holds = |f: &&Framebuffer| bound != 0 && f.twin.is_some() && f.colours.contains(&(bound as u32));
    while let Some(name) = ctx.duplicates.list.iter().find(holds).map(|f| f.name) {
        refuse(ctx, name, what);
    }
}

/// The views changed: all twins are made anew.
pub fn clear(ctx: &mut Context) {
    leave(ctx);
    for framebuffer in std::mem::take(&mut ctx.duplicates.list) {
        if let Some(twin) = framebuffer.twin {
            twin.destroy(ctx.gl);
        }
    }
}

/// A frame ended: what was seen to be a scene on its way to the window gets its twin.
pub fn end_frame(ctx: &mut Context) {
    let list = &ctx.duplicates.list;
    let news = list.iter().any(|f| f.fits && f.twin.is_none() && (f.shown || f.scene || !f.reads.is_empty()));
    if !news || !possible(ctx) {
        return;
    }
    for index in ctx.duplicates.wanted() {
        if ctx.duplicates.list[index].twin.is_some() {
            continue;
        }
        leave(ctx);
        take_error(ctx);
        let twin = make(ctx, &ctx.duplicates.list[index]);
        take_own_errors(ctx);
        if twin.is_none() {
            ctx.duplicates.list[index].fits = false;
            log::once(
                "a scene that the program draws off screen is shown flat: the driver gives no copies of its size",
            );
        }
        ctx.duplicates.list[index].twin = twin;
    }
}

/// The sized format for one that leaves its size to the driver.
fn sized(format: u32) -> u32 {
    match format {
        api::GL_RGBA => api::GL_RGBA8,
        api::GL_RGB => api::GL_RGB8,
        other => other,
    }
}

/// Makes the twin of a framebuffer; all bindings are put back.
fn make(ctx: &Context, of: &Framebuffer) -> Option<Twin> {
    let gl = ctx.gl;
    let views = ctx.target.as_ref()?.session.views().len() as i32;
    let [width, height] = of.size;
    let columns = (1..=views).find(|columns| columns * columns >= views)?;
    let (across, up) = (columns * width, (views + columns - 1) / columns * height);
    if across.max(up) as u32 > greatest_texture(gl) {
        return None;
    }
    let mut twin =
        Twin { framebuffer: 0, textures: [0; COLOURS], depth: 0, source: 0, copy: 0, columns, size: of.size };
    // SAFETY: makes objects of ours; bindings and scissor test are put back.
    let complete = unsafe {
        let (mut draw, mut renderbuffer) = (0, 0);
        gl.get_integerv(api::GL_DRAW_FRAMEBUFFER_BINDING, &mut draw);
        gl.get_integerv(api::GL_RENDERBUFFER_BINDING, &mut renderbuffer);
        let mut buffers = [api::GL_NONE; COLOURS];
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, of.name);
        for (i, buffer) in buffers.iter_mut().enumerate() {
            let mut value = 0;
            gl.get_integerv(api::GL_DRAW_BUFFER0 + i as u32, &mut value);
            *buffer = value as u32;
        }
        gl.gen_framebuffers(1, &mut twin.framebuffer);
        gl.gen_framebuffers(1, &mut twin.source);
        gl.gen_framebuffers(1, &mut twin.copy);
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, twin.framebuffer);
        for (i, texture) in of.colours.iter().enumerate().filter(|(_, texture)| **texture != 0) {
            let mut format = 0;
            with_texture(gl, *texture, || {
                gl.get_tex_level_parameteriv(api::GL_TEXTURE_2D, 0, api::GL_TEXTURE_INTERNAL_FORMAT, &mut format);
            });
            gl.gen_textures(1, &mut twin.textures[i]);
            with_texture(gl, twin.textures[i], || {
                gl.tex_storage2_d(api::GL_TEXTURE_2D, 1, sized(format as u32), across, up);
            });
            let attachment = api::GL_COLOR_ATTACHMENT0 + i as u32;
            gl.framebuffer_texture2_d(api::GL_DRAW_FRAMEBUFFER, attachment, api::GL_TEXTURE_2D, twin.textures[i], 0);
        }
        if of.depth {
            gl.gen_renderbuffers(1, &mut twin.depth);
            gl.bind_renderbuffer(api::GL_RENDERBUFFER, twin.depth);
            gl.renderbuffer_storage(api::GL_RENDERBUFFER, api::GL_DEPTH24_STENCIL8, across, up);
            let (point, kind) = (api::GL_DEPTH_STENCIL_ATTACHMENT, api::GL_RENDERBUFFER);
            gl.framebuffer_renderbuffer(api::GL_DRAW_FRAMEBUFFER, point, kind, twin.depth);
        }
        gl.draw_buffers(COLOURS as i32, buffers.as_ptr());
        let status = gl.check_framebuffer_status(api::GL_DRAW_FRAMEBUFFER);
        gl.bind_renderbuffer(api::GL_RENDERBUFFER, renderbuffer as u32);
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, draw as u32);
        status == api::GL_FRAMEBUFFER_COMPLETE && gl.get_error() == api::GL_NO_ERROR
    };
    if !complete {
        twin.destroy(gl);
        return None;
    }
    Some(twin)
}

/// Puts the twin of the program's draw framebuffer in its place; its index in the list, if it has one.
fn enter(ctx: &mut Context) -> Option<usize> {
    let index = ctx.duplicates.position(ctx.believed.draw_framebuffer)?;
    let framebuffer = ctx.duplicates.list[index].twin.as_ref()?.framebuffer;
    if !ctx.duplicates.bound {
        ctx.duplicates.bound = true;
        // SAFETY: a framebuffer of ours; `leave` puts the program's back.
        unsafe { ctx.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, framebuffer) };
    }
    Some(index)
}

/// Which framebuffers in the list the next draw samples, as a set of bits.
pub fn sampled(ctx: &Context) -> u64 {
    if !ctx.duplicates.list.iter().any(|f| f.fits) {
        return 0;
    }
    let gl = ctx.gl;
    let mut found = 0;
    let mut active = 0;
    // SAFETY: asks which textures are bound where the program samples; the active unit is put back.
    unsafe {
        gl.get_integerv(api::GL_ACTIVE_TEXTURE, &mut active);
        let mut look = |unit: u32| {
            gl.active_texture(api::GL_TEXTURE0 + unit);
            let mut texture = 0;
            gl.get_integerv(api::GL_TEXTURE_BINDING_2D, &mut texture);
            for (i, framebuffer) in ctx.duplicates.list.iter().enumerate().take(64) {
                found |= u64::from(texture != 0 && framebuffer.colours.contains(&(texture as u32))) << i;
            }
        };
        match &ctx.program {
            Some(program) if program.draws_vertices() => {
                for location in program.samplers.iter().take(SAMPLERS) {
                    let mut unit = 0;
                    gl.get_uniformiv(program.name, *location, &mut unit);
                    look(unit as u32);
                }
            }
            _ if ctx.profile.compatibility() => {
                for unit in 0..4 {
                    gl.active_texture(api::GL_TEXTURE0 + unit);
                    if gl.is_enabled(api::GL_TEXTURE_2D) != 0 {
                        look(unit);
                    }
                }
            }
            _ => {}
        }
        gl.active_texture(active as u32);
    }
    found
}

/// Whether a flat draw to the window shows a duplicated scene. What it samples is remembered as shown.
pub fn shows(ctx: &mut Context, sampled: u64) -> bool {
    let mut twins = false;
    for (i, framebuffer) in ctx.duplicates.list.iter_mut().enumerate().take(64) {
        if sampled >> i & 1 != 0 {
            framebuffer.shown = true;
            twins |= framebuffer.twin.is_some();
        }
    }
    twins
}

/// Copies view `view` of what is sampled into the program's own textures.
pub fn supply(ctx: &mut Context, sampled: u64, view: usize) {
    let gl = ctx.gl;
    let mut bound = None;
    for (i, framebuffer) in ctx.duplicates.list.iter().enumerate().take(64) {
        let Some(twin) = framebuffer.twin.as_ref().filter(|_| sampled >> i & 1 != 0) else { continue };
        let [x, y, w, h] = twin.cell(view);
        // SAFETY: copies between a texture of ours and the program's, by framebuffers of ours; bindings and
        // scissor test are put back below.
        unsafe {
            if bound.is_none() {
                let (mut draw, mut read) = (0, 0);
                gl.get_integerv(api::GL_DRAW_FRAMEBUFFER_BINDING, &mut draw);
                gl.get_integerv(api::GL_READ_FRAMEBUFFER_BINDING, &mut read);
                let scissor = gl.is_enabled(api::GL_SCISSOR_TEST) != 0;
                bound = Some((draw, read, scissor));
                gl.disable(api::GL_SCISSOR_TEST);
            }
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, twin.source);
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, twin.copy);
            let pairs = twin.textures.iter().zip(&framebuffer.colours);
            for (from, to) in pairs.filter(|(from, _)| **from != 0) {
                let (point, kind) = (api::GL_COLOR_ATTACHMENT0, api::GL_TEXTURE_2D);
                gl.framebuffer_texture2_d(api::GL_READ_FRAMEBUFFER, point, kind, *from, 0);
                gl.framebuffer_texture2_d(api::GL_DRAW_FRAMEBUFFER, point, kind, *to, 0);
                gl.blit_framebuffer(x, y, x + w, y + h, 0, 0, w, h, api::GL_COLOR_BUFFER_BIT, api::GL_NEAREST);
            }
        }
    }
    if let Some((draw, read, scissor)) = bound {
        // SAFETY: puts back what was found above.
        unsafe {
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, read as u32);
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, draw as u32);
            if scissor {
                gl.enable(api::GL_SCISSOR_TEST);
            }
        }
    }
}

/// A draw to a framebuffer of the program's. `false`: it is single and is to be drawn as it is.
pub fn draw(ctx: &mut Context, changes: Changes, issue: &mut dyn FnMut(&mut Context, &Gl)) -> bool {
    let name = ctx.believed.draw_framebuffer;
    if name == 0 || ctx.picking || ctx.discard || ctx.feedback || !possible(ctx) {
        leave(ctx);
        return false;
    }
    let index = match ctx.duplicates.position(name) {
        Some(index) => index,
        None => {
            take_error(ctx);
            let found = examine(ctx, name);
            take_error_of_ours(ctx);
            ctx.duplicates.list.push(found);
            ctx.duplicates.list.len() - 1
        }
    };
    if !ctx.duplicates.list[index].fits {
        return false;
    }
    let place = super::draw::place_by_lens(ctx);
    let sampled = if place == Place::Flat { sampled(ctx) & !(1 << index) } else { 0 };
    note(ctx, index, place, sampled);
    if enter(ctx).is_none() {
        return false;
    }
    ctx.duplicates.draws += 1;
    let views = ctx.target.as_ref().map_or(0, |t| t.session.views().len());
    let Some(twin) = &ctx.duplicates.list[index].twin else { return false };
    let cells: [[i32; 4]; 32] = std::array::from_fn(|view| twin.cell(view));
    super::draw::each_view(ctx, changes, views.min(cells.len()), issue, |ctx, view| {
        supply(ctx, sampled, view);
        own_window_space(ctx, cells[view]);
        place
    });
    true
}

/// Remembers what a draw says about the framebuffer at `index`.
fn note(ctx: &mut Context, index: usize, place: Place, sampled: u64) {
    let names: [u32; 64] = std::array::from_fn(|i| ctx.duplicates.list.get(i).map_or(0, |f| f.name));
    let framebuffer = &mut ctx.duplicates.list[index];
    framebuffer.scene |= place != Place::Flat;
    for (i, name) in names.into_iter().enumerate() {
        if sampled >> i & 1 != 0 && !framebuffer.reads.contains(&name) {
            framebuffer.reads.push(name);
        }
    }
}

/// Errors of questions that a driver need not know are nobody's.
fn take_error_of_ours(ctx: &Context) {
    // SAFETY: asks for the error flag; there are a handful of them at most.
    for _ in 0..8 {
        if unsafe { ctx.gl.get_error() } == api::GL_NO_ERROR {
            break;
        }
    }
}

/// A clear of a framebuffer of the program's. `false`: it is single.
pub fn clear_with(ctx: &mut Context, issue: &dyn Fn(&Gl)) -> bool {
    if ctx.believed.draw_framebuffer == 0 || ctx.picking || !possible(ctx) {
        return false;
    }
    let Some(index) = enter(ctx) else { return false };
    let gl = ctx.gl;
    if !ctx.believed.scissor_test {
        ctx.set_scissor(None);
        issue(gl);
        return true;
    }
    let views = ctx.target.as_ref().map_or(0, |t| t.session.views().len());
    for view in 0..views {
        let Some(twin) = &ctx.duplicates.list[index].twin else { return true };
        let cell = twin.cell(view);
        own_window_space(ctx, cell);
        issue(gl);
    }
    true
}

/// A copy of the whole of a framebuffer of the program's into the window. `false`: it is single.
pub fn show_by_copy(ctx: &mut Context, source: [i32; 4], destination: [i32; 4], mask: u32) -> bool {
    let gl = ctx.gl;
    let Some(target) = ctx.target.as_ref() else { return false };
    let whole = [0, 0, target.size().0 as i32, target.size().1 as i32];
    let possible = possible(ctx) && mask & api::GL_COLOR_BUFFER_BIT != 0 && target.config().samples == 0;
    let Some(index) = ctx.duplicates.position(ctx.believed.read_framebuffer) else { return false };
    if source != whole || destination != whole || !possible {
        return false;
    }
    ctx.duplicates.list[index].shown = true;
    let Some(twin) = &ctx.duplicates.list[index].twin else { return false };
    let Some(target) = ctx.target.as_ref() else { return false };
    let framebuffer = twin.framebuffer;
    let views = target.session.views().len();
    let pairs: [([i32; 4], [i32; 4]); 32] = std::array::from_fn(|i| (twin.cell(i), target.session.tile(i).0));
    if let Some(target) = &mut ctx.target {
        target.content.forget();
    }
    ctx.set_scissor(None);
    let mut buffer = 0;
    // SAFETY: copies from a framebuffer of ours to the window's, which is ours; the binding is put back.
    unsafe {
        gl.get_integerv(api::GL_READ_BUFFER, &mut buffer);
        gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, framebuffer);
        gl.read_buffer(buffer as u32);
        for ([x, y, w, h], [u, v, across, up]) in pairs.into_iter().take(views) {
            let filter = if (w, h) == (across, up) { api::GL_NEAREST } else { api::GL_LINEAR };
            gl.blit_framebuffer(x, y, x + w, y + h, u, v, u + across, v + up, api::GL_COLOR_BUFFER_BIT, filter);
        }
        gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, ctx.believed.read_framebuffer);
    }
    true
}
