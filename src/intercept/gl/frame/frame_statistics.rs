//! Statistics and captures of the last frame.

use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::errors::take_own_errors;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::context::read_pixels::read_back;
use crate::intercept::gl::context::registry;
use crate::intercept::gl::frame::capture;
use crate::intercept::gl::offscreen::framebuffer_statistics as off_screen_report;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::offscreen::images::Image;
use crate::intercept::gl::state::offscreen::issued::Issued;
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;
use crate::intercept::inspection::common_statistics;
use crate::intercept::inspection::last_frame::{self, LastFrame};
use crate::intercept::process::settings;
use crate::intercept::scene::flat_program::OffScreen;
use crate::lock::Lock;
use crate::runtime::run_results::{Picture, Statistics, ViewStatistics};
use std::sync::Arc;

/// Stores the statistics and captures that the settings request.
pub fn keep(ctx: &mut Context, settings: &settings::Settings) {
    if !settings.has_report() {
        return;
    }
    ctx.driver.take_errors();
    let statistics = settings.needs_statistics().then(|| statistics(ctx, settings));
    let pictures = if last_frame::wants_outputs(settings) {
        output_pictures(&ctx.driver, &ctx.drawable, settings)
    } else {
        Vec::new()
    };
    let views = if last_frame::wants_views(settings) { view_pictures(&ctx.driver, &ctx.drawable) } else { Vec::new() };
    take_own_errors(&mut ctx.driver);
    let times = ctx.frame.measured_times();
    last_frame::store(LastFrame { statistics, times, pictures, views });
}

/// Returns how the program draws to images: in this context, and in the contexts that are current
/// on no thread.
pub fn off_screen(ctx: &Context) -> OffScreen {
    let mut found =
        off_screen_report::off_screen(&ctx.drawable, ctx.view_copies.images(), ctx.view_copies.framebuffers());
    each_other(&ctx.share, &ctx.view_copies, |other, images, _| {
        let other = off_screen_report::off_screen(&other.drawable, images, other.view_copies.framebuffers());
        if found == OffScreen::Nothing || (found == OffScreen::Flat && other != OffScreen::Nothing) {
            found = other;
        }
    });
    found
}

/// Calls `look` for each context that is current on no thread, with the images of its group and the
/// draws to them. For this context's group these data are in `ctx`, for other groups in the share
/// group.
fn each_other(share: &Arc<ShareGroup>, view_copies: &ViewCopies, mut look: impl FnMut(&Context, &[Image], &Issued)) {
    registry::each_idle(|other| {
        if Arc::ptr_eq(share, &other.share) {
            look(other, view_copies.images(), other.view_copies.issued());
            return;
        }
        match &*other.share.off_screen.locked() {
            Some(group) => look(other, &group.images, &group.issued),
            None => look(other, other.view_copies.images(), other.view_copies.issued()),
        }
    });
}

/// Adds the counts of `ctx`, whose group has these images. Toolkits often draw in one context and
/// show the result in another.
fn add_counts(statistics: &mut Statistics, ctx: &Context, images: &[Image], draws: &Issued) {
    let counts = ctx.frame.counts();
    statistics.draws_seen += counts.draws_seen;
    statistics.panel_draws += counts.panel_draws;
    statistics.primary_draws += counts.primary_draws;
    statistics.bounded_draws += counts.bounded_draws;
    statistics.draws_at_border += counts.places.crossing;
    statistics.draws_beside += counts.places.outside;
    statistics.ranges_read += ctx.vertex_input.ranges_read();
    statistics.closings += counts.closings;
    statistics.shaders_linked += counts.linked;
    statistics.own_errors += ctx.driver.own_errors();
    statistics.duplicated_draws += draws.draws;
    let (duplicated, single) = off_screen_report::status(&ctx.drawable, images, ctx.view_copies.framebuffers());
    statistics.duplicated_framebuffers += duplicated;
    for (reason, framebuffers) in single {
        *statistics.single_framebuffers.entry(reason).or_default() += framebuffers;
    }
    for lens in common_statistics::lenses(ctx.frame.cameras()) {
        if !statistics.lenses.contains(&lens) {
            statistics.lenses.push(lens);
        }
    }
    if let Some(note) = ctx.frame.flat_note().filter(|note| !statistics.notes.iter().any(|known| known == note)) {
        statistics.notes.push(note.to_owned());
    }
    for (how, draws) in counts.found.iter() {
        *statistics.projection_found.entry(how.to_owned()).or_default() += draws;
    }
    for (index, view) in statistics.views.iter_mut().enumerate() {
        let [issued, left_out] = draws.of_view(index);
        view.duplicated_draws_issued += issued;
        view.duplicated_draws_culled += left_out;
    }
}

fn statistics(ctx: &Context, settings: &settings::Settings) -> Statistics {
    let driver = format!("{}, {}", ctx.driver.gl.text(api::GL_VERSION), ctx.driver.gl.text(api::GL_RENDERER));
    let target = ctx.drawable.target();
    let mut statistics = Statistics {
        hidden_frames: ctx.frame.counts().hidden_frames,
        batches_left_out: target.map_or(0, |t| t.backend().left_out()),
        coarse_primitives: ctx.projected.coarse_primitives(ctx.driver.gl),
        outputs_narrowed: target.map_or(0, |t| t.backend().narrowed()),
        ..common_statistics::begin(ctx.frame.counts().frames, &settings.rig.name, driver)
    };
    if let Some(target) = target {
        statistics.own_errors += target.backend().errors();
        common_statistics::add_plan(&mut statistics, &target.session);
        let views = target.session.views().iter().zip(target.counts()).enumerate();
        statistics.views = views
            .map(|(index, (view, (draws_issued, draws_culled)))| ViewStatistics {
                name: view.name.clone(),
                width: view.tile.width,
                height: view.tile.height,
                closed_texels: target.closed().get(index).copied().unwrap_or(0),
                draws_issued,
                draws_culled,
                ..ViewStatistics::default()
            })
            .collect();
    }
    add_counts(&mut statistics, ctx, ctx.view_copies.images(), ctx.view_copies.issued());
    each_other(&ctx.share, &ctx.view_copies, |other, images, draws| add_counts(&mut statistics, other, images, draws));
    statistics
}

/// Returns the pictures of the outputs of the frame that was just corrected.
fn output_pictures(driver: &Driver, drawable: &Drawable, settings: &settings::Settings) -> Vec<Picture> {
    let gl = driver.gl;
    let Some(target) = drawable.target() else {
        let Some(window) = drawable.window() else { return Vec::new() };
        return vec![read_back(gl, 0, "window", LowerLeftRect::of_size(window.size()))];
    };
    let outputs = target.session.rig().outputs.iter().zip(target.session.viewports()).enumerate();
    let here = outputs.filter(|(_, (output, _))| output.here);
    if settings.offscreen {
        return here.filter_map(|(i, (output, _))| capture::picture(driver, drawable, i, &output.name)).collect();
    }
    here.map(|(_, (output, rect))| read_back(gl, 0, &output.name, rect)).collect()
}

/// Returns the pictures of all views, of the panel and of the primary view.
fn view_pictures(driver: &Driver, drawable: &Drawable) -> Vec<Picture> {
    let Some(target) = drawable.target() else { return Vec::new() };
    let session = &target.session;
    let mut pictures = Vec::new();
    for (i, view) in session.views().iter().enumerate() {
        let tile = session.atlas_tile(i).unwrap_or_default();
        pictures.push(read_back(driver.gl, target.atlas_framebuffer(), &view.name, tile));
    }
    for (name, tile) in [("panel", session.atlas_panel()), ("primary", session.primary())] {
        if let Some(tile) = tile {
            pictures.push(read_back(driver.gl, target.atlas_framebuffer(), name, tile));
        }
    }
    pictures
}
