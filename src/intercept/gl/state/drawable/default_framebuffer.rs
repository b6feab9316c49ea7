//! The atlas that stands in for a window's framebuffer, and what corrects it.

use crate::backend::gl::driver::api::Gl;
use crate::backend::gl::objects::surface::Surface;
use crate::backend::gl::{ClearedViews, GlBackend, Target};
use crate::correct::projected::matrices::LensConstants;
use crate::correct::{LowerLeftRect, TexelSpan};
use crate::error::Result;
use crate::intercept::gl::state::drawable::cleared_views::Content;
use crate::intercept::gl::state::drawable::window_config::Config;
use crate::intercept::settings;
use crate::runtime::session::{Extras, Session};
use std::cell::Cell;
use std::sync::Arc;

/// A rectangle that is ready to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::intercept::gl) struct Ready {
    pub(in crate::intercept::gl) part: LowerLeftRect,
    /// Its alpha is that of a window without one.
    pub(in crate::intercept::gl) opaque: bool,
}

/// The atlas and what corrects it.
pub struct DefaultFramebuffer {
    /// Rig and plan for the window's size.
    pub session: Arc<Session>,
    /// Version of the rig's file that it follows.
    pub(in crate::intercept::gl) version: u64,
    pub(in crate::intercept::gl) config: Config,
    pub(in crate::intercept::gl) surface: Surface,
    /// The surface's picture with one sample per pixel, where it has several.
    pub(in crate::intercept::gl) resolved: Option<Surface>,
    /// The atlas that the views are collected in, where they are drawn in turn; elsewhere `surface`
    /// is the atlas.
    pub(in crate::intercept::gl) collected: Option<Surface>,
    pub(in crate::intercept::gl) backend: GlBackend,
    /// Lens of each view, to which vertices are projected; empty where all views are perspective
    /// ones.
    pub lenses: Vec<LensConstants>,
    /// Content of the views.
    pub content: Content,
    pub(in crate::intercept::gl) issued: Vec<u64>,
    pub(in crate::intercept::gl) culled: Vec<u64>,
    /// Texels of each view that are closed for drawing; empty where none are.
    pub(in crate::intercept::gl) closed: Vec<u64>,
    /// Part of the program's own picture that is ready to be read since something was drawn last.
    pub(in crate::intercept::gl) ready: Cell<Option<Ready>>,
    /// Place of each output in the window.
    pub(in crate::intercept::gl) outputs: Vec<Target>,
}

impl DefaultFramebuffer {
    /// The tiles that the program has been seen to need.
    pub fn extras(&self) -> Extras {
        self.session.extras()
    }

    /// Size of the window that it stands for.
    pub fn size(&self) -> (u32, u32) {
        self.session.window()
    }

    /// The window's own configuration.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Returns the framebuffer that stands in for the program's framebuffer 0.
    pub fn framebuffer(&self) -> u32 {
        self.surface.framebuffer()
    }

    /// True if `name` is a framebuffer of Cupola.
    pub fn is_ours(&self, name: u32) -> bool {
        let others = self.resolved.iter().chain(&self.collected);
        name == self.surface.framebuffer() || others.into_iter().any(|other| other.framebuffer() == name)
    }

    /// The tile of the flat panel.
    pub fn panel(&self) -> Option<LowerLeftRect> {
        self.session.panel()
    }

    /// The tile of the program's own picture.
    pub fn primary(&self) -> Option<LowerLeftRect> {
        self.session.primary()
    }

    /// Returns the tiles to which flat drawing goes, each with true if it is the panel (whose alpha
    /// counts).
    pub fn flat_tiles(&self) -> [Option<(LowerLeftRect, bool)>; 3] {
        // What is drawn in turn would show it in each view.
        let own = self.own_tile().filter(|_| self.session.turns().is_none());
        [own.map(|tile| (tile, false)), self.panel().map(|t| (t, true)), self.primary().map(|t| (t, false))]
    }

    /// Returns the tile that the program takes for its window: the one with its own lens, or the
    /// view that is drawn in turn.
    fn own_tile(&self) -> Option<LowerLeftRect> {
        let mut tiles = (0..self.session.views().len()).map(|i| self.session.tile(i));
        tiles.find(|(_, own)| *own).map(|(tile, _)| tile)
    }

    /// Returns the tile from which the program's reads of its window come.
    pub fn own_picture(&self) -> Option<LowerLeftRect> {
        self.primary().or_else(|| self.own_tile())
    }

    /// A draw went to a view.
    pub fn issued(&mut self, view: usize) {
        self.content.draw(view);
        if let Some(count) = self.issued.get_mut(view) {
            *count += 1;
        }
    }

    /// A draw went to a view, into these texels.
    pub fn issued_within(&mut self, view: usize, texels: TexelSpan) {
        self.content.draw_within(view, texels);
        if let Some(count) = self.issued.get_mut(view) {
            *count += 1;
        }
    }

    /// A draw was left out of a view that cannot show it.
    pub fn culled(&mut self, view: usize) {
        if let Some(count) = self.culled.get_mut(view) {
            *count += 1;
        }
    }

    /// Draws issued to each view so far, and draws left out.
    pub fn counts(&self) -> impl Iterator<Item = (u64, u64)> + '_ {
        self.issued.iter().copied().zip(self.culled.iter().copied())
    }

    /// Texels of each view that are closed for drawing, because no output samples them; empty where
    /// none are.
    pub fn closed(&self) -> &[u64] {
        &self.closed
    }

    /// Returns the target of the correction of each output.
    pub fn outputs(&self) -> &[Target] {
        &self.outputs
    }

    /// The views that need not be corrected.
    pub fn views_cleared(&self) -> Option<ClearedViews<'_>> {
        // A view with the program's own lens gets flat drawing, too.
        let followed =
            settings::settings().is_some_and(|s| s.cull) && !self.session.views().iter().any(|v| v.program_lens);
        // In turn a clear is that of one view.
        let followed = followed && self.session.turns().is_none();
        self.content.views_cleared().filter(|_| followed)
    }

    /// The correction.
    pub fn backend(&self) -> &GlBackend {
        &self.backend
    }

    /// The texture with the atlas, one sample per pixel.
    pub fn texture(&self) -> u32 {
        self.collected.as_ref().unwrap_or_else(|| self.readable()).texture()
    }

    /// The framebuffer with the atlas, to be read from.
    pub fn atlas_framebuffer(&self) -> u32 {
        self.collected.as_ref().unwrap_or_else(|| self.readable()).framebuffer()
    }

    pub(in crate::intercept::gl) fn readable(&self) -> &Surface {
        self.resolved.as_ref().unwrap_or(&self.surface)
    }

    /// The framebuffer that can be read from, once [`DefaultFramebuffer::resolve`] has run.
    pub fn readable_framebuffer(&self) -> u32 {
        self.readable().framebuffer()
    }

    /// The objects that contexts do not share.
    pub fn own_objects(&self) -> OwnObjects {
        let name = |surface: &Option<Surface>| surface.as_ref().map_or(0, Surface::framebuffer);
        let framebuffers = [self.surface.framebuffer(), name(&self.resolved), name(&self.collected)];
        OwnObjects { framebuffers, vertex_array: self.backend.vertex_array() }
    }

    /// Makes those anew, in the current context, around the shared ones.
    pub(in crate::intercept::gl) fn rehome(&mut self, gl: &Gl) -> Result<()> {
        self.surface.rehome(gl)?;
        for other in self.resolved.iter_mut().chain(&mut self.collected) {
            other.rehome(gl)?;
        }
        self.backend.rehome(gl);
        Ok(())
    }

    /// Deletes everything in the context, which must be current.
    pub fn destroy(mut self, gl: &Gl) {
        self.backend.destroy(gl);
        self.surface.destroy(gl);
        for other in self.resolved.take().into_iter().chain(self.collected.take()) {
            other.destroy(gl);
        }
    }
}

/// Names of a picture's objects in the context that drew it before.
pub struct OwnObjects {
    framebuffers: [u32; 3],
    vertex_array: u32,
}

impl OwnObjects {
    /// Deletes them in their context, which must be current.
    pub fn destroy(&self, gl: &Gl) {
        // SAFETY: objects of Cupola; the name 0 is ignored.
        unsafe {
            gl.delete_framebuffers(3, self.framebuffers.as_ptr());
            gl.delete_vertex_arrays(1, &self.vertex_array);
        }
    }
}
