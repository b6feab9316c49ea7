//! Places of views, panel and outputs: in the atlas, on the surface that the program draws to, and
//! in the window.

use crate::correct::{LowerLeftRect, PixelRect, UpperLeftRect};
use crate::runtime::session::Session;
use crate::views::Tile;

/// Free rows between a view and the panel, if views are drawn in turn.
const TURN_GUTTER: u32 = 1;

/// Rectangle of a tile.
fn rect(tile: &Tile) -> LowerLeftRect {
    LowerLeftRect::new(tile.x as i32, tile.y as i32, tile.width as i32, tile.height as i32)
}

impl Session {
    /// Returns the rectangle of a view, and whether flat drawing goes there as well.
    pub fn tile(&self, index: usize) -> (LowerLeftRect, bool) {
        match (self.views().get(index), &self.turns) {
            (None, _) => (LowerLeftRect::new(0, 0, 1, 1), true),
            (Some(_), Some(_)) => (LowerLeftRect::of_size(self.request.window), true),
            (Some(view), None) => (rect(&view.tile), view.program_lens),
        }
    }

    /// Tile of a view in the atlas.
    pub fn atlas_tile(&self, index: usize) -> Option<LowerLeftRect> {
        self.views().get(index).map(|view| rect(&view.tile))
    }

    /// Tile of the panel in the atlas.
    pub fn atlas_panel(&self) -> Option<LowerLeftRect> {
        self.plan.views.panel.as_ref().map(|panel| rect(&panel.tile))
    }

    /// Size in texels of the surface that the program draws to: the atlas, or, in turn, a view and
    /// the panel above it.
    pub fn surface_size(&self) -> (u32, u32) {
        let (width, height) = self.request.window;
        if self.turns.is_some() { (width, 2 * height + TURN_GUTTER) } else { self.plan.views.atlas }
    }

    /// Returns the rectangle of the flat panel.
    pub fn panel(&self) -> Option<LowerLeftRect> {
        let window = LowerLeftRect::of_size(self.request.window);
        let above = LowerLeftRect { y: window.height + TURN_GUTTER as i32, ..window };
        self.atlas_panel().map(|panel| if self.turns.is_some() { above } else { panel })
    }

    /// Tile of the primary view; `None` in turn.
    pub fn primary(&self) -> Option<LowerLeftRect> {
        self.plan.views.primary.as_ref().filter(|_| self.turns.is_none()).map(rect)
    }

    /// Returns the rectangle of each output in the window from the top left, `place` added.
    pub fn viewports_from_top(&self, place: (i32, i32)) -> Vec<UpperLeftRect> {
        let from_top = move |r: &PixelRect| {
            let (x, y) = (place.0.saturating_add(r.x as i32), place.1.saturating_add(r.y as i32));
            UpperLeftRect::new(x, y, r.width as i32, r.height as i32)
        };
        self.rects.iter().map(from_top).collect()
    }

    /// Returns the rectangle of each output in the window.
    pub fn viewports(&self) -> impl Iterator<Item = LowerLeftRect> + '_ {
        let height = self.request.window.1 as i32;
        let from_top = move |r: &PixelRect| {
            LowerLeftRect::new(r.x as i32, height - r.y as i32 - r.height as i32, r.width as i32, r.height as i32)
        };
        self.rects.iter().map(from_top)
    }
}
