//! Issue of a draw once per view.

use crate::backend::gl::api::{self, Gl};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::matrices::load_projection;
use crate::intercept::gl::projected_vertices::lens;
use crate::intercept::gl::queries::scaling;
use crate::intercept::gl::shader::programs;
use crate::intercept::gl::state::attribute_stack;
use crate::intercept::gl::state::draw::{Changes, Place};
use crate::intercept::gl::state::views::Views;
use crate::intercept::scene::query_weights::QueryWeights;

/// Issues a draw for each of `views` that is `shown` it; `prepare` sets the window space and says where the draw belongs.
/// What is beyond the number of views is the program's own picture, which gets all draws.
pub fn each_view(
    ctx: &mut Context,
    changes: Changes,
    views: usize,
    shown: Views,
    issue: &mut dyn FnMut(&mut Context, &Gl),
    prepare: impl Fn(&mut Context, usize) -> Place,
) {
    let gl = ctx.gl;
    let share = 1.0 / views.max(1) as f64;
    let session = ctx.target.as_ref().map(|target| target.session.clone()).or_else(|| ctx.lent.clone());
    let own = session.as_ref().map_or(0, |session| session.views().len());
    let repeats = Repeats::new(changes, ctx, 0);
    let mut projection_loaded = false;
    let gets = |view: usize| view >= own || shown.contain(view);
    let last_shown = (0..views).rev().find(|view| gets(*view));
    for (number, view) in (0..views).filter(|view| gets(*view)).enumerate() {
        let place = prepare(ctx, view);
        if ctx.counting.any() {
            let samples = match (place, &session) {
                (Place::FixedScene | Place::Scene(_), Some(_)) if view >= own => 0.0,
                (Place::FixedScene | Place::Scene(_), Some(session)) => scaling::scene_samples(ctx, session, true),
                _ => share,
            };
            scaling::weigh(ctx, QueryWeights { samples, primitives: share });
        }
        let mut divided = None;
        match place {
            _ if view >= own => {
                plain_program(ctx);
                restore_projection(ctx, &mut projection_loaded);
            }
            Place::FixedScene => {
                plain_program(ctx);
                if let Some(matrix) = ctx.projection.per_view.get(view) {
                    load_projection(ctx, matrix);
                    projection_loaded = true;
                }
            }
            Place::Scene(camera) => {
                if let Some(rows) = ctx.cameras.get(camera).and_then(|c| c.rows.get(view)).copied() {
                    let lens = ctx.target.as_ref().and_then(|target| target.lenses.get(view)).copied();
                    programs::upload_view(ctx, &rows, lens.as_ref());
                    let division = ctx.session().and_then(|session| session.division(view));
                    divided = lens::begin(ctx, &rows, lens.as_ref(), division);
                }
            }
            Place::Flat | Place::Background => plain_program(ctx),
        }
        repeats.around(gl, number, Some(view) == last_shown, || issue(ctx, gl));
        if let Some((variant, in_use)) = divided {
            variant.end(ctx, &in_use);
        }
    }
    restore_projection(ctx, &mut projection_loaded);
}

/// Puts the program's own projection back, if a view's was loaded.
pub(in crate::intercept::gl) fn restore_projection(ctx: &Context, loaded: &mut bool) {
    if std::mem::take(loaded) {
        load_projection(ctx, &ctx.projection.matrix);
    }
}

/// Programs that we patched draw untouched where the picture is the program's own.
pub fn plain_program(ctx: &mut Context) {
    programs::upload(ctx, &crate::intercept::gl::state::programs::IDENTITY);
}

/// Keeps a draw that is issued several times one draw for the program: vertex attributes (and what
/// else it may set) are put back in between, and transform feedback records it once.
pub struct Repeats {
    mask: u32,
    /// The material follows the colour.
    follows: bool,
    feedback: bool,
}

impl Repeats {
    /// `pushed` are so many attributes of ours at that time, beside the program's.
    pub fn new(changes: Changes, ctx: &Context, pushed: usize) -> Self {
        let mask = match changes {
            _ if !ctx.profile.compatibility() => 0,
            // No place is left on the stack; a pop would take what is the program's.
            _ if ctx.attribute_stack.len() + pushed >= attribute_stack::ATTRIBUTE_DEPTH => 0,
            Changes::Nothing | Changes::Alike => 0,
            Changes::Attributes => api::GL_CURRENT_BIT | api::GL_LIGHTING_BIT,
            Changes::Anything => api::GL_ALL_ATTRIB_BITS,
        };
        let follows = mask != 0 && ctx.known_state.is_on(ctx.gl, api::GL_COLOR_MATERIAL);
        // Without a pause (OpenGL before 4.0) there is no drawing without recording.
        Self { mask, follows, feedback: ctx.feedback && ctx.gl.has_pause_transform_feedback() }
    }

    /// Runs `issue` for the `number`-th time; unless it is the `last`, what it changes is put back.
    pub(in crate::intercept::gl) fn around(&self, gl: &Gl, number: usize, last: bool, issue: impl FnOnce()) {
        if self.feedback && number == 1 {
            // SAFETY: transform feedback is active and not paused.
            unsafe { gl.pause_transform_feedback() };
        }
        self.unchanged(gl, last, issue);
        if self.feedback && last && number > 0 {
            // SAFETY: paused above.
            unsafe { gl.resume_transform_feedback() };
        }
    }

    /// Runs `issue`; unless it is the `last`, what it changes is put back.
    pub fn unchanged(&self, gl: &Gl, last: bool, issue: impl FnOnce()) {
        if self.mask == 0 || last {
            issue();
            return;
        }
        // SAFETY: pushed and popped in pairs around one draw.
        unsafe { gl.push_attrib(self.mask) };
        issue();
        // SAFETY: as above; the material is made to follow the colour that is current again, which Mesa forgets to do.
        unsafe {
            gl.pop_attrib();
            if self.follows {
                gl.disable(api::GL_COLOR_MATERIAL);
                gl.enable(api::GL_COLOR_MATERIAL);
            }
        }
    }
}
