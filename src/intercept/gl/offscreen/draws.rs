//! Draws to the program's own framebuffers: once for each view that can show them.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::offscreen::inspected::{self, Seen};
use crate::intercept::gl::offscreen::target::each_view;
use crate::intercept::gl::offscreen::view_copies::{
    copy_count, duplicate_mode, enter, leave, look, own_tile, possible, supply, views, without_scissor,
};
use crate::intercept::gl::offscreen::{backdrop, coverage, in_turn, sampling};
use crate::intercept::gl::per_view::background;
use crate::intercept::gl::per_view::classify::{classify_by_projection, several_viewports};
use crate::intercept::gl::per_view::culling::select;
use crate::intercept::gl::per_view::window_space::{own_window_space, program_window_space};
use crate::intercept::gl::shader::camera_matrices::upload;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::draw::bounds::Bounds;
use crate::intercept::gl::state::draw::draw_class::{Changes, DrawClass};
use crate::intercept::gl::state::draw::views::Views;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::frame::Frame;
use crate::intercept::gl::state::offscreen::coverage::Measure;
use crate::intercept::gl::state::offscreen::images::{Name, Set};
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::scene::to_window::ToWindow;
use crate::intercept::scene::viewport;
use crate::intercept::scene::viewport::parts::PanelPart;
use crate::rig::Duplicate;
use crate::runtime::session::Session;
use glam::DVec2;
use std::cell::Cell;

/// Issues a draw with vertices within `bounds` to a framebuffer of the program. Returns false if
/// the framebuffer is drawn only once: the caller issues the draw then.
pub fn draw(
    ctx: &mut Context,
    changes: Changes,
    bounds: impl FnOnce(&mut Context) -> Bounds,
    issue: &mut dyn FnMut(&mut Context, &Gl),
) -> bool {
    if in_turn::is_on(&ctx.drawable) {
        return in_turn::draw(ctx, changes, issue);
    }
    if ctx.app.draw_framebuffer() == 0
        || ctx.app.picking()
        || ctx.app.discard()
        || ctx.app.feedback()
        || !possible(&ctx.drawable)
    {
        leave(ctx);
        let why = Some("draws here are issued once (picking, discard, feedback, or no view with another lens)");
        inspected::note(ctx, &Seen { class: DrawClass::Flat, sampled: 0, why });
        return false;
    }
    let index = look(ctx);
    let attached = ctx.view_copies.attached(index);
    let Classified { class, sampled, in_framebuffer } = classified(ctx, attached);
    note(&ctx.app, &ctx.drawable, &mut ctx.view_copies, index, class, sampled);
    inspected::note(ctx, &Seen { class, sampled, why: None });
    if !enter(ctx, index) {
        supply(ctx, sampled, own_tile(&ctx.drawable, &ctx.view_copies));
        return false;
    }
    let part = panel_part(&ctx.app, &ctx.shaders, &ctx.view_copies, index);
    let framebuffer = &mut ctx.view_copies.framebuffers[index];
    let in_perspective = matches!(class, DrawClass::Scene(_) | DrawClass::FixedScene);
    framebuffer.has_scene |= part.is_none() && in_perspective;
    if in_perspective {
        framebuffer.viewports.note(ctx.app.viewport(), Frame::ended());
    }
    // Examples are a display of the axes in a corner, after the scene was drawn, and pictures side by
    // side.
    let beside = framebuffer.has_scene || framebuffer.viewports.are_several();
    let corner = part.filter(|_| beside && sampled == 0);
    let class = if corner.is_some() { DrawClass::Flat } else { class };
    let shown = match ctx.queries.primitives() {
        true => Views::ALL,
        false => select::views_off_screen(ctx, class, bounds, changes),
    };
    let count = views(&ctx.drawable);
    ctx.view_copies.issued.count(shown, count);
    let on_panel = part.map(|part| part.of_picture_at(shown_at(ctx, index)));
    let placed = match (class, on_panel) {
        (DrawClass::Flat, Some(part)) if sampled == 0 => {
            let placed = background::prepare(&ctx.drawable, &mut ctx.frame, &ctx.compat, part);
            FlatPlacement::of(if placed { DrawClass::Behind } else { class })
        }
        (DrawClass::Flat, None) if sampled == 0 => place(ctx, index),
        _ => FlatPlacement::of(class),
    };
    let class = placed.class;
    let measure = Cell::new(placed.measure);
    let issue = &mut |ctx: &mut Context, gl: &Gl| match measure.take() {
        Some(measure) => coverage::measure(ctx, measure, |ctx| issue(ctx, gl)),
        None => issue(ctx, gl),
    };
    if in_framebuffer && sampled != 0 {
        draw_through(ctx, attached, class, sampled, (changes, shown), issue);
        return true;
    }
    if !draw_in_tiles(ctx, index, (class, sampled), (changes, shown), issue) {
        return false;
    }
    if placed.fills {
        backdrop::spread(ctx, index);
    }
    true
}

/// Class of a draw to a framebuffer of the program, and the images that it samples.
struct Classified {
    class: DrawClass,
    /// Sampled images that have per-view copies.
    sampled: Set,
    /// True if the fragment shader uses its position in the framebuffer, and Cupola could not
    /// change the shader.
    in_framebuffer: bool,
}

/// Classifies a draw to a framebuffer with the images `attached`.
fn classified(ctx: &mut Context, attached: Set) -> Classified {
    let class = classify_by_projection(ctx);
    // A draw in perspective samples images at coordinates of its own, which are the same for all
    // views. Only a flat draw, or a shader that uses window coordinates, needs the view's own
    // image.
    let program = ctx.shaders.program();
    let in_framebuffer = program.is_some_and(|program| program.reads_frag_coord);
    let by_frag_coord = in_framebuffer || program.is_some_and(|program| program.frag_coord.is_some());
    let sampled = if class == DrawClass::Flat || by_frag_coord {
        sampling::sampled(&ctx.driver, &ctx.shaders, &ctx.view_copies)
    } else {
        0
    };
    let sampled = sampled & !attached;
    let screen = class == DrawClass::Flat && sampled == 0 && upload::holds_inverse(ctx);
    Classified { class: if screen { DrawClass::Screen } else { class }, sampled, in_framebuffer }
}

/// Returns the part of the panel that corresponds to the viewport, if this is not the main viewport
/// of its framebuffer.
fn panel_part(app: &AppState, shaders: &Shaders, view_copies: &ViewCopies, index: usize) -> Option<PanelPart> {
    let framebuffer = view_copies.framebuffers.get(index)?;
    let picture = view_copies.image(framebuffer.images().next()?)?.size;
    let DVec2 { x: across, y: up } = app.viewport().size().to_vector();
    let is_main = viewport::is_main(across, up, picture.area() as f64);
    (!is_main && !several_viewports(app, shaders)).then(|| PanelPart::of(app.viewport(), picture))
}

/// Draws to the tile of each view in framebuffer `index`. Each view samples its own version of the
/// images `sampled`. Returns false if there are no tiles.
fn draw_in_tiles(
    ctx: &mut Context,
    index: usize,
    (class, sampled): (DrawClass, Set),
    (changes, shown): (Changes, Views),
    issue: &mut dyn FnMut(&mut Context, &Gl),
) -> bool {
    ctx.view_copies.changed(index);
    let first = ctx.view_copies.framebuffers[index].images().next();
    let Some(grid) = first.and_then(|name| Some(ctx.view_copies.image(name)?.view_copy.as_ref()?.grid)) else {
        return false;
    };
    let (count, own) = (copy_count(&ctx.drawable, &ctx.view_copies), views(&ctx.drawable));
    each_view(ctx, changes, count, shown, issue, |ctx, view| {
        supply(ctx, sampled, view);
        own_window_space(ctx, grid.tile(view));
        if class == DrawClass::Behind && view < own {
            ctx.set_viewport(grid.tile(view));
            ctx.set_scissor(Some(ctx.frame.background().within(view, grid.tile(view))));
        }
        ctx.draw.note_window_space(ToWindow::of_tile(grid.tile(view).into(), grid.extent(count).height));
        class
    });
    if sampled != 0 {
        supply_last(ctx, sampled, count, shown);
    }
    true
}

/// Class of a flat draw in the views, and its coverage.
struct FlatPlacement {
    class: DrawClass,
    /// Measurement of the coverage, if it is needed.
    measure: Option<Measure>,
    /// True if the draw fills the picture.
    fills: bool,
}

impl FlatPlacement {
    fn of(class: DrawClass) -> Self {
        Self { class, measure: None, fills: false }
    }
}

/// Returns the class of a flat draw that samples no image of the scene. A draw that fills the
/// picture fills each view; a text goes to the position of the panel.
fn place(ctx: &mut Context, index: usize) -> FlatPlacement {
    let image = ctx.view_copies.framebuffers[index].images().next().and_then(|name| ctx.view_copies.image(name));
    let samples = image.map_or(0, |image| image.samples);
    if ctx.app.scissor_test() && !ctx.app.scissor().contains(ctx.app.viewport()) {
        return FlatPlacement::of(DrawClass::Flat);
    }
    let part = shown_at(ctx, index);
    let (class, measure, fills) = match coverage::fills_viewport(ctx, samples) {
        Err(measure) => (DrawClass::Flat, Some(measure), false),
        Ok(false) if background::prepare(&ctx.drawable, &mut ctx.frame, &ctx.compat, part) => {
            (DrawClass::Behind, None, false)
        }
        Ok(fills) => (DrawClass::Flat, None, fills),
    };
    FlatPlacement { class, measure, fills }
}

/// Returns the part of the panel that corresponds to the framebuffer at `index`.
fn shown_at(ctx: &Context, index: usize) -> PanelPart {
    let image = ctx.view_copies.framebuffers[index].images().next().and_then(|name| ctx.view_copies.image(name));
    let part = image.and_then(|image| ctx.view_copies.parts.of(image.size));
    match (part, ctx.session().map(Session::window)) {
        (Some(part), Some(window)) => PanelPart::of(part, window.into()),
        _ => PanelPart::default(),
    }
}

/// Makes sure that the sampled images have the last view's content afterwards, whether the draw
/// went to this view or not. Draws in perspective, which sample these images at coordinates of
/// their own, get this content.
fn supply_last(ctx: &mut Context, sampled: Set, count: usize, shown: Views) {
    let last = count.saturating_sub(1);
    if !shown.contain(last) {
        supply(ctx, sampled, last);
    }
}

/// Issues a draw whose shader uses window coordinates that Cupola cannot change. It draws to the
/// program's own framebuffer, which gets the content of each view in turn.
fn draw_through(
    ctx: &mut Context,
    attached: Set,
    class: DrawClass,
    sampled: Set,
    (changes, shown): (Changes, Views),
    issue: &mut dyn FnMut(&mut Context, &Gl),
) {
    leave(ctx);
    let view_now = Cell::new(0);
    let mut through = |ctx: &mut Context, gl: &Gl| {
        issue(ctx, gl);
        without_scissor(ctx, |ctx| {
            let images = ctx.view_copies.images.iter_mut().enumerate().take(64);
            for (_, image) in images.filter(|(i, _)| attached >> i & 1 != 0) {
                image.store(gl, ctx.driver.id, view_now.get());
            }
        });
    };
    let count = copy_count(&ctx.drawable, &ctx.view_copies);
    each_view(ctx, changes, count, shown, &mut through, |ctx, view| {
        view_now.set(view);
        supply(ctx, sampled | attached, view);
        ctx.restore_window_space();
        program_window_space(&mut ctx.draw);
        class
    });
    supply_last(ctx, sampled | attached, count, shown);
}

/// Notes what a draw reveals about the images of the framebuffer at `index`.
fn note(
    app: &AppState,
    drawable: &Drawable,
    view_copies: &mut ViewCopies,
    index: usize,
    class: DrawClass,
    sampled: Set,
) {
    let Some(window) = drawable.session().map(Session::window) else { return };
    let ViewCopies { framebuffers, images, learnt, parts, .. } = view_copies;
    let alike = duplicate_mode() == Duplicate::Always
        || viewport::has_shape_of_window(app.viewport().size(), window)
        || parts.of(app.viewport().size()).is_some();
    if class == DrawClass::Flat && sampled == 0 {
        return;
    }
    let names: [Option<Name>; 64] = std::array::from_fn(|i| images.get(i).map(|image| image.name));
    let sources = |set: Set| names.into_iter().enumerate().filter(move |(i, _)| set >> i & 1 != 0).filter_map(|n| n.1);
    // A depth image belongs to the scene if the framebuffer has colours too. A framebuffer with
    // depth only is a shadow map.
    let is_colour = |name: Name| framebuffers[index].colours().any(|colour| colour == name);
    let has_colours = framebuffers[index].colours().next().is_some();
    for name in framebuffers[index].images().filter(|_| has_colours) {
        let Some(image) = images.iter_mut().find(|image| image.name == name) else { continue };
        if class != DrawClass::Flat {
            *learnt |= alike && !image.scene;
            image.scene |= alike;
            image.other_shape |= !alike;
        }
        for source in sources(sampled).filter(|_| is_colour(name)) {
            if !image.reads.contains(&source) {
                image.reads.push(source);
                *learnt = true;
            }
        }
    }
}
