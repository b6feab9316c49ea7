//! Records of the program's framebuffers and of the images in them.

use crate::intercept::gl::state::offscreen::coverage::Coverage;
use crate::intercept::gl::state::offscreen::depth_converter::DepthConverter;
use crate::intercept::gl::state::offscreen::displayed::DisplayedPictures;
use crate::intercept::gl::state::offscreen::framebuffers::Framebuffer;
use crate::intercept::gl::state::offscreen::images::{Image, Name, Pair, Set};
use crate::intercept::gl::state::offscreen::issued::Issued;
use crate::intercept::gl::state::offscreen::single_sample::SingleSampleImage;
use crate::intercept::scene::viewport::parts::Parts;
use crate::lock::Lock;
use std::sync::Mutex;

/// Records of the program's framebuffers.
#[derive(Default)]
pub struct ViewCopies {
    pub(in crate::intercept::gl) images: Vec<Image>,
    pub(in crate::intercept::gl) framebuffers: Vec<Framebuffer>,
    pub(in crate::intercept::gl) coverage: Coverage,
    /// Parts of the window that images of the program fill.
    pub(in crate::intercept::gl) parts: Parts,
    /// True if the view copy of the program's draw framebuffer is bound in its place.
    pub(in crate::intercept::gl) bound: bool,
    /// True if new facts about the images were found in this frame.
    pub(in crate::intercept::gl) learnt: bool,
    /// True if view copies have one more tile, which is drawn with the program's own lens, because
    /// the program reads its pictures back.
    pub(in crate::intercept::gl) own_picture: bool,
    /// True if compute shaders make some of the images.
    pub(in crate::intercept::gl) computes: bool,
    /// Textures and their levels that compute shaders write and that cannot be followed, as they
    /// have layers or three dimensions.
    pub(in crate::intercept::gl) not_followed: Vec<(u32, i32)>,
    /// Pictures for copies to another size. Each has another size or format.
    pub(in crate::intercept::gl) canvases: Vec<SingleSampleImage>,
    /// Converters of depth, each of another size or format.
    pub(in crate::intercept::gl) depth_converters: Vec<DepthConverter>,
    /// Pictures for flat draws that show images which are drawn once per view.
    pub(in crate::intercept::gl) displayed: DisplayedPictures,
    /// Off-screen draws that were issued once per view.
    pub(in crate::intercept::gl) issued: Issued,
    /// The pass of the last described draw.
    pub(in crate::intercept::gl) inspected: Option<InspectedPass>,
    /// Number of view copies that were deleted so far. Framebuffers of Cupola may have had them
    /// attached.
    pub(in crate::intercept::gl) deleted: u64,
    /// Framebuffers that other contexts have to delete.
    pub(in crate::intercept::gl) left: Vec<Pair>,
    /// True if this context holds the records that the group shares. Otherwise another thread holds
    /// them, and the images are those of this context alone.
    pub(in crate::intercept::gl) shared: bool,
}

/// A pass that is described for `cupola inspect`.
pub struct InspectedPass {
    /// Its number in the frame.
    pub(in crate::intercept::gl) number: usize,
    /// The framebuffer that it draws to; 0 = the window.
    pub(in crate::intercept::gl) framebuffer: u32,
    /// Its name on the page.
    pub(in crate::intercept::gl) target: String,
}

/// Records that contexts of a group share about their common images. Toolkits draw a scene in one
/// context and compose the window in another.
#[derive(Default)]
pub struct SharedViewCopies {
    pub(in crate::intercept::gl) images: Vec<Image>,
    pub(in crate::intercept::gl) parts: Parts,
    pub(in crate::intercept::gl) learnt: bool,
    pub(in crate::intercept::gl) own_picture: bool,
    pub(in crate::intercept::gl) issued: Issued,
    pub(in crate::intercept::gl) deleted: u64,
    pub(in crate::intercept::gl) left: Vec<Pair>,
}

impl ViewCopies {
    /// Images of the program that are followed.
    pub fn images(&self) -> &[Image] {
        &self.images
    }

    /// Framebuffers of the program.
    pub fn framebuffers(&self) -> &[Framebuffer] {
        &self.framebuffers
    }

    /// Off-screen draws that were issued once per view.
    pub fn issued(&self) -> &Issued {
        &self.issued
    }

    /// True if any image of the program is followed.
    pub fn any(&self) -> bool {
        !self.images.is_empty()
    }

    /// Notes that the window was changed by something other than a draw.
    pub fn window_changed(&mut self) {
        self.displayed.current = None;
    }

    /// Gives the shared records back to the group, as the context is not current any more.
    pub fn deposit(&mut self, group: &Mutex<Option<SharedViewCopies>>) {
        if !std::mem::take(&mut self.shared) {
            return;
        }
        // Other contexts may delete these textures.
        self.not_followed.clear();
        let travelling = SharedViewCopies {
            images: std::mem::take(&mut self.images),
            parts: std::mem::take(&mut self.parts),
            learnt: std::mem::take(&mut self.learnt),
            own_picture: self.own_picture,
            issued: std::mem::take(&mut self.issued),
            deleted: self.deleted,
            left: std::mem::take(&mut self.left),
        };
        *group.locked() = Some(travelling);
    }

    pub(in crate::intercept::gl) fn image(&self, name: Name) -> Option<&Image> {
        self.images.iter().find(|image| image.name == name)
    }

    pub(in crate::intercept::gl) fn image_mut(&mut self, name: Name) -> Option<&mut Image> {
        self.images.iter_mut().find(|image| image.name == name)
    }

    pub(in crate::intercept::gl) fn position(&self, framebuffer: u32) -> Option<usize> {
        self.framebuffers.iter().position(|f| f.name == framebuffer)
    }

    /// True if any of the images of a framebuffer is to be drawn once per view.
    pub(in crate::intercept::gl) fn has_view_copies(&self, framebuffer: &Framebuffer) -> bool {
        framebuffer.has_view_copies(&self.images)
    }

    /// Returns the images of a framebuffer, as a set.
    pub(in crate::intercept::gl) fn attached(&self, index: usize) -> Set {
        let mut set = 0;
        for (i, image) in self.images.iter().enumerate().take(64) {
            set |= Set::from(self.framebuffers[index].attachments.contains(&Some(image.name))) << i;
        }
        set
    }

    /// Notes that a framebuffer was drawn to.
    pub(in crate::intercept::gl) fn changed(&mut self, index: usize) {
        for name in self.framebuffers[index].attachments.into_iter().flatten() {
            if let Some(image) = self.images.iter_mut().find(|image| image.name == name) {
                image.changed();
            }
        }
    }
}
