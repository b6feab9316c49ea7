//! Issue of a draw once per view.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::projected_vertices;
use crate::intercept::gl::queries::scaling;
use crate::intercept::gl::shader::camera_matrices::upload;
use crate::intercept::gl::shader::changed::{Changed, KeptValues};
use crate::intercept::gl::shader::programs;
use crate::intercept::gl::shader::source::frag_coord;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::compat::projection;
use crate::intercept::gl::state::draw::DrawState;
use crate::intercept::gl::state::draw::draw_class::{Changes, DrawClass};
use crate::intercept::gl::state::draw::views::Views;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::variants::{InUse, Variant};
use crate::intercept::scene::query_scaling::QueryScaling;
use std::sync::Arc;

/// Target of the copies of a draw: the atlas of the window, or the per-view copies of a framebuffer
/// of the program.
pub trait CopyTarget {
    /// Sets the window space for `view`. Returns the draw class for it. `None`: the view is the
    /// program's own picture, with the program's own matrices.
    fn prepare(&mut self, ctx: &mut Context, view: usize) -> Option<DrawClass>;

    /// Factors of the view in the program's queries.
    fn factors(&self, ctx: &mut Context, view: usize, class: Option<DrawClass>) -> QueryScaling;

    /// Notes that the draw went to `view`.
    fn issued(&mut self, _ctx: &mut Context, _view: usize) {}

    /// Notes that the draw was left out of `view`, which cannot show it.
    fn left_out(&mut self, _ctx: &mut Context, _view: usize) {}
}

/// Copies of one draw.
pub struct Copies {
    /// State that the draw changes.
    pub changes: Changes,
    /// Number of the rig's views.
    pub views: usize,
    /// Number of copies: the rig's views and after them, if it exists, the program's own picture,
    /// which gets all draws.
    pub count: usize,
    /// Views that can show the draw.
    pub shown: Views,
}

impl Copies {
    fn contain(&self, view: usize) -> bool {
        view >= self.views || self.shown.contain(view)
    }
}

/// Issues a draw once for each of its copies.
pub fn issue(ctx: &mut Context, copies: &Copies, target: &mut dyn CopyTarget, draw: &mut dyn FnMut(&mut Context, &Gl)) {
    let gl = ctx.driver.gl;
    let mut repeats =
        Repeats::new(copies.changes, &ctx.driver, &ctx.app, 0).counting(&ctx.share, &mut ctx.driver, &ctx.shaders);
    let last = (0..copies.count).rev().find(|view| copies.contain(*view));
    let (mut projection_loaded, mut number) = (false, 0);
    for view in 0..copies.count {
        if !copies.contain(view) {
            target.left_out(ctx, view);
            continue;
        }
        let class = target.prepare(ctx, view);
        if ctx.queries.any() {
            let factors = target.factors(ctx, view, class);
            scaling::scale(ctx.driver.gl, &mut ctx.queries, factors);
        }
        let divided = load_view(ctx, class, view, &mut projection_loaded);
        repeats.around(gl, number, Some(view) == last, || draw(ctx, gl));
        if let Some((variant, in_use)) = divided {
            variant.end(ctx, &in_use);
        }
        target.issued(ctx, view);
        number += 1;
    }
    restore_projection(&ctx.driver, &ctx.app, &ctx.compat, &mut projection_loaded);
}

/// Sets the projection of a view in the program or in the fixed-function pipeline. Returns the
/// variant of the program that divides the draw's primitives, if there is one.
fn load_view(
    ctx: &mut Context,
    class: Option<DrawClass>,
    view: usize,
    projection_loaded: &mut bool,
) -> Option<(Arc<Variant>, InUse)> {
    let in_shader = ctx.shaders.program().is_some_and(|program| program.draws_vertices());
    let takes_matrix = in_shader || ctx.shaders.assembly().is_some();
    match class {
        None => {
            plain_program(ctx);
            restore_projection(&ctx.driver, &ctx.app, &ctx.compat, projection_loaded);
        }
        Some(class @ (DrawClass::Flat | DrawClass::Screen)) => {
            plain_reprojection(&ctx.share, &ctx.driver, &ctx.draw, &ctx.shaders);
            upload::load_view(ctx, view, class);
        }
        Some(class @ DrawClass::Scene(camera)) => {
            ctx.frame.show_camera(camera);
            let reprojection =
                ctx.frame.cameras().get(camera).and_then(|camera| camera.reprojections.get(view)).copied()?;
            upload::load_view(ctx, view, class);
            return load_reprojection(ctx, view, &reprojection);
        }
        Some(DrawClass::Behind) if takes_matrix => {
            let reprojection = ctx.frame.background().reprojection(view).copied()?;
            return load_reprojection(ctx, view, &reprojection);
        }
        Some(class) => {
            plain_program(ctx);
            if class == DrawClass::FixedScene {
                ctx.frame.show_fixed_camera();
                upload::load_view(ctx, view, class);
            }
            let matrix = match class {
                DrawClass::Behind => ctx.frame.background().projection(view),
                _ => ctx.compat.projection.of_view(view),
            };
            if let Some(matrix) = matrix {
                projection::load(ctx.driver.gl, ctx.app.matrix_mode(), matrix);
                *projection_loaded = true;
            }
        }
    }
    None
}

/// Sends the reprojection matrix and the lens of a view to the program in use.
fn load_reprojection(
    ctx: &mut Context,
    view: usize,
    reprojection: &ReprojectionMatrix,
) -> Option<(Arc<Variant>, InUse)> {
    let lens = ctx.drawable.target().and_then(|target| target.lenses.get(view)).copied();
    programs::upload_view(&ctx.driver, &ctx.shaders, reprojection, lens.as_ref());
    frag_coord::upload(&ctx.share, &ctx.driver, &ctx.draw, &ctx.shaders);
    let division = ctx.session().and_then(|session| session.division(view));
    projected_vertices::begin_view(ctx, reprojection, lens.as_ref(), division)
}

/// Restores the program's own projection if the projection of a view was loaded.
fn restore_projection(driver: &Driver, app: &AppState, compat: &Compat, loaded: &mut bool) {
    if std::mem::take(loaded) {
        projection::load(driver.gl, app.matrix_mode(), compat.projection.matrix());
    }
}

/// Makes patched programs draw as the original ones, for the program's own picture.
pub fn plain_program(ctx: &mut Context) {
    plain_reprojection(&ctx.share, &ctx.driver, &ctx.draw, &ctx.shaders);
    upload::load_own(ctx);
}

/// Sends the identity as reprojection matrix, and the present window space.
fn plain_reprojection(share: &ShareGroup, driver: &Driver, draw: &DrawState, shaders: &Shaders) {
    programs::upload(driver, shaders, &crate::intercept::gl::state::shader::programs::IDENTITY);
    frag_coord::upload(share, driver, draw, shaders);
}

/// Keeps repetitions of a draw invisible to the program. Vertex attributes and other state that the
/// draw sets are restored in between, transform feedback records the draw once, and buffers and
/// images that the shaders write have the values of the last time.
pub struct Repeats {
    mask: u32,
    /// True if the material follows the colour.
    follows: bool,
    feedback: bool,
    /// What the shaders change.
    changed: Changed,
    /// Values before the draw.
    values: Option<KeptValues>,
}

impl Repeats {
    /// `pushed`: number of entries of Cupola on the attribute stack, in addition to the program's.
    pub fn new(changes: Changes, driver: &Driver, app: &AppState, pushed: usize) -> Self {
        let mask = match changes {
            _ if !driver.profile.compatibility() => 0,
            // The stack is full: a pop would remove an entry of the program.
            _ if !app.can_push(pushed) => 0,
            Changes::Nothing | Changes::Alike => 0,
            Changes::Attributes => api::GL_CURRENT_BIT | api::GL_LIGHTING_BIT,
            Changes::Anything => api::GL_ALL_ATTRIB_BITS,
        };
        let follows = mask != 0 && driver.known_state.is_on(driver.gl, api::GL_COLOR_MATERIAL);
        // Before OpenGL 4.0 there is no pause, so every repetition is recorded.
        let feedback = app.feedback() && driver.gl.has_pause_transform_feedback();
        Self { mask, follows, feedback, changed: Changed::default(), values: None }
    }

    /// Lets a draw of the present shaders change buffers and images once.
    pub fn counting(self, share: &ShareGroup, driver: &mut Driver, shaders: &Shaders) -> Self {
        Self { changed: Changed::present(share, driver, shaders), ..self }
    }

    /// Runs `issue` for the `number`-th time. Restores what it changes, unless it is the `last`
    /// time.
    pub(in crate::intercept::gl) fn around(&mut self, gl: &Gl, number: usize, last: bool, issue: impl FnOnce()) {
        match &self.values {
            Some(values) => values.put_back(gl),
            None if !last && !self.changed.is_empty() => self.values = Some(KeptValues::keep(gl, &self.changed)),
            None => {}
        }
        if self.feedback && number == 1 {
            // SAFETY: transform feedback is active and not paused.
            unsafe { gl.pause_transform_feedback() };
        }
        self.unchanged(gl, last, issue);
        if self.feedback && last && number > 0 {
            // SAFETY: paused above.
            unsafe { gl.resume_transform_feedback() };
        }
        if let Some(values) = self.values.take_if(|_| last) {
            values.delete(gl);
        }
    }

    /// Runs `issue`. Restores what it changes, unless it is the `last` time.
    pub fn unchanged(&self, gl: &Gl, last: bool, issue: impl FnOnce()) {
        if self.mask == 0 || last {
            issue();
            return;
        }
        // SAFETY: pushed and popped in pairs around one draw.
        unsafe { gl.push_attrib(self.mask) };
        issue();
        // SAFETY: as above. The material has to be made to follow the restored colour, which Mesa
        // forgets.
        unsafe {
            gl.pop_attrib();
            if self.follows {
                gl.disable(api::GL_COLOR_MATERIAL);
                gl.enable(api::GL_COLOR_MATERIAL);
            }
        }
    }
}
