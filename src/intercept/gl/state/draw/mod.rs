//! A draw: its class, its primitives, and the views that it goes to.
//!
//! [`draw_class`] names the classes, [`primitives`] the kinds of primitives, [`views`] is a set of
//! views, [`bounds`] a box around vertices, [`max_width`] the greatest width of points and lines.

pub mod bounds;
pub mod draw_class;
pub mod max_width;
pub mod primitives;
pub mod views;

use crate::backend::gl::driver::api;
use crate::correct::TexelSpan;
use crate::intercept::gl::state::draw::max_width::MaxWidth;
use crate::intercept::gl::state::draw::primitives::{Patch, Shape, WidePrimitives};
use crate::intercept::scene::to_window::ToWindow;

/// Facts about the draw that is being issued.
#[derive(Default)]
pub struct DrawState {
    /// Area that the draw covers in each view, if it is known.
    areas: Vec<TexelSpan>,
    /// Points and lines that may leave their tile.
    wide_primitives: WidePrimitives,
    /// The greatest width of points and lines so far.
    max_width: MaxWidth,
    /// Conversion of window coordinates of the driver to those of the program, for the next draw
    /// that is issued.
    to_window: ToWindow,
    /// Number that attributes use for the draw's first instance (its base instance).
    first_instance: u32,
}

impl DrawState {
    /// Notes the primitives of the next draw.
    pub fn note_shape(&mut self, shape: Shape) {
        self.wide_primitives.shape = shape;
    }

    /// Notes the mode of the next draw, which its hook can issue as patches.
    pub fn note_mode(&mut self, mode: u32) {
        self.wide_primitives.mode = Some(mode);
    }

    /// Notes the number that attributes use for the next draw's first instance.
    pub fn note_first_instance(&mut self, instance: u32) {
        self.first_instance = instance;
    }

    /// Number that attributes use for the draw's first instance (its base instance).
    pub fn first_instance(&self) -> u32 {
        self.first_instance
    }

    /// Begins a draw, and determines whether it may reach beyond its tile. `emits`: a geometry
    /// shader makes its primitives. `es`: the context has OpenGL ES.
    pub fn begin(&mut self, emits: bool, es: bool) {
        self.wide_primitives.begin(self.max_width.exceeds_gutter(), emits, es);
    }

    /// Notes that the draw that is being issued may reach beyond its tile.
    pub fn cut_at_tile(&mut self) {
        self.wide_primitives.cut = true;
    }

    /// True if the draw that is being issued is cut at its tile, as it may reach beyond it.
    pub fn is_cut(&self) -> bool {
        self.wide_primitives.cut
    }

    /// Primitives of the draw that is being issued.
    pub fn drawn_shape(&self) -> Shape {
        self.wide_primitives.drawn
    }

    /// Patches as which the present draw can be issued.
    pub fn patch(&self) -> Option<Patch> {
        self.wide_primitives.patch
    }

    /// From now on, or no longer, the hook issues the draw as patches.
    pub fn issue_as_patches(&mut self, on: bool) {
        self.wide_primitives.as_patches = on;
    }

    /// Returns the mode with which a hook issues a draw of `mode`.
    pub fn issued_mode(&self, mode: u32) -> u32 {
        if self.wide_primitives.as_patches { api::GL_PATCHES } else { mode }
    }

    /// `glPolygonMode`.
    pub fn note_polygon_mode(&mut self, mode: u32) {
        self.wide_primitives.polygons |= mode != api::GL_FILL;
    }

    /// True if polygons may be drawn as outlines.
    pub fn may_outline(&self) -> bool {
        self.wide_primitives.polygons
    }

    /// Notes a width of points or lines that the program set.
    pub fn note_width(&mut self, width: f32) {
        self.max_width.note(width);
    }

    /// Notes that points have sizes that Cupola does not know.
    pub fn note_unknown_width(&mut self) {
        self.max_width.note_unknown();
    }

    /// Number of pixels that a primitive may cover beside its vertices.
    pub fn spread(&self) -> f64 {
        self.max_width.spread()
    }

    /// Notes the conversion of window coordinates for the next draw that is issued.
    pub fn note_window_space(&mut self, to_window: ToWindow) {
        self.to_window = to_window;
    }

    /// Conversion of window coordinates of the driver to those of the program.
    pub fn to_window(&self) -> &ToWindow {
        &self.to_window
    }

    /// Takes the room for the areas out, to fill it beside the context.
    pub fn take_areas(&mut self) -> Vec<TexelSpan> {
        std::mem::take(&mut self.areas)
    }

    /// Notes the area that the draw covers in each view.
    pub fn put_areas(&mut self, areas: Vec<TexelSpan>) {
        self.areas = areas;
    }

    /// Area that the draw covers in a view.
    pub fn area(&self, view: usize) -> Option<TexelSpan> {
        self.areas.get(view).copied()
    }
}
