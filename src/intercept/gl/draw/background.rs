//! Flat drawing behind the scene ([`FrameOrder`]): it goes into the views themselves, where the
//! panel would be. A flat clip position is a point of the panel, seen with the panel's opening as a
//! lens.

use crate::correct::projected::matrices;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::scene::frame_order::FrameOrder;
use crate::runtime::session::{ClipRows, Session};

/// What is known about flat drawing before the scene.
#[derive(Default)]
pub struct Background {
    order: FrameOrder,
    rows: Vec<ClipRows>,
    shader_rows: Vec<[f32; 16]>,
    /// The fixed-function projection that `per_view` is made from.
    matrix: Option<[f64; 16]>,
    per_view: Vec<[f64; 16]>,
}

impl Background {
    /// Notes a draw of the scene.
    pub fn note_scene(&mut self) {
        self.order.note_scene();
    }

    /// Notes a flat draw.
    pub fn note_flat(&mut self) {
        self.order.note_flat();
    }

    /// Ends the frame.
    pub fn end_frame(&mut self) {
        self.order.end_frame();
    }

    /// The views changed: nothing is valid any more.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.shader_rows.clear();
        self.matrix = None;
    }

    /// A view's rows, for the program's shaders.
    pub fn shader_rows(&self, view: usize) -> Option<&[f32; 16]> {
        self.shader_rows.get(view)
    }

    /// A view's projection, for the fixed-function pipeline.
    pub fn projection(&self, view: usize) -> Option<&[f64; 16]> {
        self.per_view.get(view)
    }

    fn prepare(&mut self, session: &Session, projection: &[f64; 16]) -> bool {
        if self.rows.is_empty() {
            self.rows = session.panel_rows();
            self.shader_rows = self.rows.iter().map(matrices::clip_rows).collect();
            self.matrix = None;
        }
        if self.matrix.as_ref() != Some(projection) {
            self.matrix = Some(*projection);
            self.per_view.clear();
            self.per_view.extend(
                self.rows
                    .iter()
                    .map(|rows| crate::intercept::gl::compat::matrices::multiply(&rows.matrix(), projection)),
            );
        }
        !self.rows.is_empty()
    }
}

/// Whether a flat draw with the present state goes behind the scene.
pub fn is_behind(ctx: &mut Context) -> bool {
    if !ctx.background.order.is_behind() || !crate::intercept::gl::draw::issue::main_viewport(ctx) {
        return false;
    }
    let Some(target) = &ctx.target else { return false };
    let (width, height) = target.size();
    let [x, y, across, up] = ctx.believed.scissor.map(i64::from);
    let whole = x <= 0 && y <= 0 && x + across >= width.into() && y + up >= height.into();
    (whole || !ctx.believed.scissor_test) && ctx.background.prepare(&target.session, &ctx.projection.matrix)
}
