//! The atlas that stands in for a window's framebuffer, and its correction.

use crate::backend::gl::driver::api::Gl;
use crate::backend::gl::objects::surface::Surface;
use crate::backend::gl::{ClearedViews, GlBackend, KnownState, Spread, Target};
use crate::correct::projected::matrices::LensConstants;
use crate::correct::{LowerLeftRect, TexelSpan};
use crate::error::Result;
use crate::intercept::gl::state::drawable::cleared_views::ViewContents;
use crate::intercept::gl::state::drawable::window_config::Config;
use crate::intercept::process::live::Live;
use crate::intercept::process::settings;
use crate::rig::Rig;
use crate::runtime::session::{Extras, Session};
use std::cell::Cell;
use std::sync::Arc;
use std::time::Instant;

/// A rig that a rough correction shows.
#[derive(Clone)]
pub struct RoughlyShown {
    /// Time of the rig's last change.
    pub(in crate::intercept::gl) since: Instant,
    /// The rig of the views, as the file had it.
    pub(in crate::intercept::gl) before: Arc<Rig>,
}

/// A rectangle that is ready to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::intercept::gl) struct Ready {
    pub(in crate::intercept::gl) part: LowerLeftRect,
    /// True if its alpha is that of a window without alpha.
    pub(in crate::intercept::gl) opaque: bool,
}

/// The atlas and its correction.
pub struct DefaultFramebuffer {
    /// Rig and plan for the window's size.
    pub session: Arc<Session>,
    /// The rig, as the file has it.
    pub(in crate::intercept::gl) rig: Arc<Rig>,
    /// Version of the rig file that the plan follows.
    pub(in crate::intercept::gl) version: u64,
    /// The rig that follows, and its plan, while its shaders are being made.
    pub(in crate::intercept::gl) next: Option<(Session, Live)>,
    /// A rough correction shows `rig` over the views of `session`, which is that of an earlier rig.
    /// `None`: the session's own correction is in use.
    pub(in crate::intercept::gl) rough: Option<RoughlyShown>,
    pub(in crate::intercept::gl) config: Config,
    pub(in crate::intercept::gl) surface: Surface,
    /// Picture of the surface with one sample per pixel, if the surface has several.
    pub(in crate::intercept::gl) resolved: Option<Surface>,
    /// Atlas in which the views are collected, if they are drawn in turn. Otherwise `surface` is
    /// the atlas.
    pub(in crate::intercept::gl) collected: Option<Surface>,
    pub(in crate::intercept::gl) backend: GlBackend,
    /// Lens of each view, to which vertices are projected; empty if all views are perspective
    /// views.
    pub lenses: Vec<LensConstants>,
    /// Content of the views.
    pub content: ViewContents,
    pub(in crate::intercept::gl) issued: Vec<u64>,
    pub(in crate::intercept::gl) culled: Vec<u64>,
    /// Number of texels of each view that are closed for drawing; empty if there are none.
    pub(in crate::intercept::gl) closed: Vec<u64>,
    /// Part of the program's own picture that is ready to be read. Each draw resets it.
    pub(in crate::intercept::gl) ready: Cell<Option<Ready>>,
    /// Place of each output in the window.
    pub(in crate::intercept::gl) outputs: Vec<Target>,
}

impl DefaultFramebuffer {
    /// Returns the needs of the program, as far as Cupola has seen them.
    pub fn extras(&self) -> Extras {
        self.session.extras()
    }

    /// Returns the size of the window whose framebuffer it replaces.
    pub fn size(&self) -> (u32, u32) {
        self.session.window()
    }

    /// Returns the window's own configuration.
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

    /// Returns the tile of the flat panel.
    pub fn panel(&self) -> Option<LowerLeftRect> {
        self.session.panel()
    }

    /// Returns the tile of the primary view.
    pub fn primary(&self) -> Option<LowerLeftRect> {
        self.session.primary()
    }

    /// Returns the tiles to which flat drawing goes, each with true if it is the panel (whose alpha
    /// counts).
    pub fn flat_tiles(&self) -> [Option<(LowerLeftRect, bool)>; 3] {
        // If views are drawn in turn, each view would show the drawing.
        let own = self.own_tile().filter(|_| self.session.turns().is_none());
        [own.map(|tile| (tile, false)), self.panel().map(|t| (t, true)), self.primary().map(|t| (t, false))]
    }

    /// Returns the tile that the program uses as its window: the tile with the program's own lens,
    /// or the view that is drawn in turn.
    fn own_tile(&self) -> Option<LowerLeftRect> {
        let mut tiles = (0..self.session.views().len()).map(|i| self.session.tile(i));
        tiles.find(|(_, own)| *own).map(|(tile, _)| tile)
    }

    /// Returns the tile from which the program's reads of its window come.
    pub fn own_picture(&self) -> Option<LowerLeftRect> {
        self.primary().or_else(|| self.own_tile())
    }

    /// Notes that something is drawn. What was ready to be read is not any more.
    pub fn note_drawn(&self) {
        self.ready.set(None);
    }

    /// Notes a clear of all views to this colour; `None`: the views have different colours.
    pub fn note_clear(&mut self, color: Option<[f32; 3]>) {
        self.content.clear(color);
    }

    /// Gives each view its own part of a background.
    ///
    /// # Errors
    /// As for [`GlBackend::spread`].
    pub fn spread(&mut self, gl: &Gl, what: &Spread<'_>, known: &KnownState) -> Result<bool> {
        self.backend.spread(gl, what, known)
    }

    /// True if the views are drawn in turn and collected in an atlas of their own.
    pub fn is_collected(&self) -> bool {
        self.collected.is_some()
    }

    /// Notes a draw that went to a view.
    pub fn issued(&mut self, view: usize) {
        self.content.draw(view);
        if let Some(count) = self.issued.get_mut(view) {
            *count += 1;
        }
    }

    /// Notes a draw that went to these texels of a view.
    pub fn issued_within(&mut self, view: usize, texels: TexelSpan) {
        self.content.draw_within(view, texels);
        if let Some(count) = self.issued.get_mut(view) {
            *count += 1;
        }
    }

    /// Notes a draw that was left out of a view, as the view cannot show it.
    pub fn culled(&mut self, view: usize) {
        if let Some(count) = self.culled.get_mut(view) {
            *count += 1;
        }
    }

    /// Returns for each view the number of draws that were issued to it so far, and the number of
    /// draws that were left out.
    pub fn counts(&self) -> impl Iterator<Item = (u64, u64)> + '_ {
        self.issued.iter().copied().zip(self.culled.iter().copied())
    }

    /// Returns the number of texels of each view that are closed for drawing, because no output
    /// samples them; empty if there are none.
    pub fn closed(&self) -> &[u64] {
        &self.closed
    }

    /// Returns the target of the correction of each output.
    pub fn outputs(&self) -> &[Target] {
        &self.outputs
    }

    /// Returns the cleared views, which need not be corrected.
    pub fn views_cleared(&self) -> Option<ClearedViews<'_>> {
        // A view with the program's own lens gets flat drawing, too.
        let followed =
            settings::settings().is_some_and(|s| s.cull) && !self.session.views().iter().any(|v| v.program_lens);
        // If views are drawn in turn, a clear is a clear of one view.
        let followed = followed && self.session.turns().is_none();
        self.content.views_cleared().filter(|_| followed)
    }

    /// Returns the backend that draws the correction.
    pub fn backend(&self) -> &GlBackend {
        &self.backend
    }

    /// Returns the texture with the atlas, one sample per pixel.
    pub fn texture(&self) -> u32 {
        self.collected.as_ref().unwrap_or_else(|| self.readable()).texture()
    }

    /// Returns the framebuffer with the atlas, to be read from.
    pub fn atlas_framebuffer(&self) -> u32 {
        self.collected.as_ref().unwrap_or_else(|| self.readable()).framebuffer()
    }

    pub(in crate::intercept::gl) fn readable(&self) -> &Surface {
        self.resolved.as_ref().unwrap_or(&self.surface)
    }

    /// Returns the framebuffer that can be read from, once [`DefaultFramebuffer::resolve`] has run.
    pub fn readable_framebuffer(&self) -> u32 {
        self.readable().framebuffer()
    }

    /// Returns the objects that contexts do not share.
    pub fn own_objects(&self) -> OwnObjects {
        let name = |surface: &Option<Surface>| surface.as_ref().map_or(0, Surface::framebuffer);
        let framebuffers = [self.surface.framebuffer(), name(&self.resolved), name(&self.collected)];
        OwnObjects { framebuffers, vertex_array: self.backend.vertex_array() }
    }

    /// Makes new objects in the current context in place of those that contexts do not share. The
    /// new objects use the shared ones.
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

/// Names of objects in the context that used the stand-in before.
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
