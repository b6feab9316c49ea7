//! A draw: its class, its primitives, and the views that it goes to.
//!
//! [`draw_class`] names the classes, [`primitives`] the kinds of primitives, [`views`] is a set of
//! views, [`bounds`] a box around vertices, [`max_width`] the greatest width of points and lines.

pub mod bounds;
pub mod draw_class;
pub mod max_width;
pub mod primitives;
pub mod views;

use crate::correct::TexelSpan;
use crate::intercept::gl::state::draw::max_width::MaxWidth;
use crate::intercept::gl::state::draw::primitives::WidePrimitives;
use crate::intercept::scene::to_window::ToWindow;

/// Facts about the draw that is being issued.
#[derive(Default)]
pub struct DrawState {
    /// Area that the draw covers in each view, if it is known.
    pub(in crate::intercept::gl) areas: Vec<TexelSpan>,
    /// Points and lines that may leave their tile.
    pub(in crate::intercept::gl) wide_primitives: WidePrimitives,
    /// The greatest width of points and lines so far.
    pub(in crate::intercept::gl) max_width: MaxWidth,
    /// Conversion of window coordinates of the driver to those of the program, for the next draw
    /// that is issued.
    pub(in crate::intercept::gl) to_window: ToWindow,
    /// Number that attributes use for the draw's first instance (its base instance).
    pub(in crate::intercept::gl) first_instance: u32,
}
