//! Swapchains of the program, and the stand-in images that replace their images.
//!
//! [`formats`] lists the formats that can be corrected. [`publishing`] reads pictures back for
//! other processes.

pub mod formats;
pub mod publishing;

use crate::backend::vk::VkBackend;
use crate::intercept::vk::state::driver::own_image::OwnImage;
use crate::intercept::vk::state::swapchains::formats::TexelFormat;
use crate::intercept::vk::state::swapchains::publishing::Publishing;
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::intercept::vk::state::views::view_target::ViewTarget;
use crate::lock::Lock;
use ash::vk;
use std::collections::HashMap;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Source of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureSource {
    /// The program's picture, unchanged.
    Own,
    /// The tile of the program's own picture, unchanged; if there is none, the panel.
    Tile,
    /// The program's picture on the panel.
    Panel,
    /// The views.
    Views,
}

/// Objects for one image of the swapchain.
pub(in crate::intercept::vk) struct Slot {
    /// The program's image instead of the real one.
    pub(in crate::intercept::vk) given: OwnImage,
    /// Image with the views and the panel.
    pub(in crate::intercept::vk) atlas: OwnImage,
    /// The program's image as a target of draws.
    pub(in crate::intercept::vk) target: Arc<ViewTarget>,
    /// Views of the atlas: unchanged, and with alpha 1.
    pub(in crate::intercept::vk) views: [vk::ImageView; 2],
    /// Signalled when the real image may be presented.
    pub(in crate::intercept::vk) ready: vk::Semaphore,
    /// Signalled when the commands of its last picture are done.
    pub(in crate::intercept::vk) done: vk::Fence,
    /// Commands for each [`PictureSource`], recorded when they are first needed and then submitted
    /// again.
    pub(in crate::intercept::vk) commands: [vk::CommandBuffer; 4],
    /// True if they were submitted, and `done` was not waited for since.
    pub(in crate::intercept::vk) pending: bool,
    /// The source of the correction in these commands, if it is timed.
    pub(in crate::intercept::vk) timed: Option<usize>,
}

/// Stand-in images of a swapchain, and everything that the correction needs.
pub struct StandIn {
    /// Positions in the atlas and the window.
    pub(in crate::intercept::vk) layout: Arc<AtlasLayout>,
    pub(in crate::intercept::vk) real: Vec<vk::Image>,
    /// Views of the real images, or of the image in between. The correction draws to them.
    pub(in crate::intercept::vk) targets: Vec<vk::ImageView>,
    /// Image in between, needed if the real images encode the values that are written to them. The
    /// correction draws to it, and it is copied.
    pub(in crate::intercept::vk) between: Option<OwnImage>,
    /// Image of the window's format between `between` and the real image, if `between` has 16 bits.
    pub(in crate::intercept::vk) narrow: Option<OwnImage>,
    /// The outputs outside of the window that are published, with views.
    pub(in crate::intercept::vk) beside: Vec<(OwnImage, vk::ImageView)>,
    pub(in crate::intercept::vk) beside_images: Vec<vk::Image>,
    pub(in crate::intercept::vk) slots: Vec<Slot>,
    pub(in crate::intercept::vk) backend: VkBackend,
    /// The format that the correction reads.
    pub(in crate::intercept::vk) format: vk::Format,
    /// The format that it writes: the same, or one of 16 bits.
    pub(in crate::intercept::vk) target_format: vk::Format,
    pub(in crate::intercept::vk) family: u32,
    pub(in crate::intercept::vk) pool: vk::CommandPool,
    /// True if the masks are on the device.
    pub(in crate::intercept::vk) uploaded: bool,
    /// True if corrections are timed.
    pub(in crate::intercept::vk) timed: bool,
}

/// A swapchain of the program.
pub struct Swapchain {
    /// Size of its images.
    pub(in crate::intercept::vk) extent: vk::Extent2D,
    /// Layout of their texels in memory.
    pub(in crate::intercept::vk) texel_format: TexelFormat,
    /// Usage that its surface supports.
    pub(in crate::intercept::vk) supported: vk::ImageUsageFlags,
    /// The real images.
    pub(in crate::intercept::vk) real: Vec<vk::Image>,
    /// Stand-in images; `None`: the program has the real images.
    pub(in crate::intercept::vk) stand_in: Option<StandIn>,
    /// Read-back of the published pictures; `None` if none are published.
    pub(in crate::intercept::vk) publishing: Option<Publishing>,
    /// True after a failure: the window shows the program's own picture.
    pub(in crate::intercept::vk) failed: bool,
    /// Version of the rig's file that it uses.
    pub(in crate::intercept::vk) version: u64,
    /// Version of the rig's file that its pictures show.
    pub(in crate::intercept::vk) shown: u64,
    /// Version that the pictures from the next one on show, if they differ in the camera.
    pub(in crate::intercept::vk) coming: Option<u64>,
    /// What is left to do for the last change of the rig.
    pub(in crate::intercept::vk) due: Option<Due>,
}

/// What is left to do for a changed rig, when it has rested.
#[derive(Clone, Copy, Debug)]
pub struct Due {
    /// Time of the change.
    pub(in crate::intercept::vk) since: Instant,
    /// True if the rig is shown roughly, and has to be shown exactly.
    pub(in crate::intercept::vk) rough: bool,
    /// True if only a new swapchain shows it as it is planned: the program is asked for one.
    pub(in crate::intercept::vk) outdated: bool,
}

/// The swapchains that Cupola manages.
#[derive(Default)]
pub struct Swapchains {
    pub(in crate::intercept::vk) all: Mutex<HashMap<vk::SwapchainKHR, Arc<Mutex<Swapchain>>>>,
    /// The image of the latest swapchain, with its format.
    latest: Mutex<Option<(vk::Format, Arc<ViewTarget>)>>,
    /// True if not even the program's own picture could be shown in a window. New swapchains are
    /// then left alone.
    pub(in crate::intercept::vk) given_up: AtomicBool,
}

impl Swapchains {
    /// Returns the swapchain, if Cupola manages it.
    pub fn managed(&self, handle: vk::SwapchainKHR) -> Option<Arc<Mutex<Swapchain>>> {
        self.all.locked().get(&handle).cloned()
    }

    /// Returns the image of the latest swapchain, if it has this format.
    pub fn latest_target(&self, format: vk::Format) -> Option<Arc<ViewTarget>> {
        let latest = self.latest.locked();
        latest.as_ref().filter(|(known, _)| *known == format).map(|(_, target)| Arc::clone(target))
    }

    /// Returns the image of the latest swapchain.
    pub fn latest_window(&self) -> Option<Arc<ViewTarget>> {
        self.latest.locked().as_ref().map(|(_, target)| Arc::clone(target))
    }

    /// Returns the layout of the latest swapchain.
    pub fn latest_layout(&self) -> Option<Arc<AtlasLayout>> {
        let latest = self.latest.locked();
        latest.as_ref().map(|(_, target)| Arc::clone(&target.layout))
    }

    /// Returns the layout of the latest swapchain, if it fits a window of this size.
    pub fn layout(&self, size: (u32, u32), read: bool) -> Option<Arc<AtlasLayout>> {
        self.latest_layout().filter(|layout| (layout.window, layout.read) == (size, read))
    }

    /// Forgets an image of a destroyed swapchain.
    pub fn forget_target(&self, gone: &Arc<ViewTarget>) {
        let mut latest = self.latest.locked();
        if latest.as_ref().is_some_and(|(_, target)| Arc::ptr_eq(target, gone)) {
            *latest = None;
        }
    }

    /// Notes a new image of a swapchain.
    pub fn note_target(&self, format: vk::Format, target: Arc<ViewTarget>) {
        *self.latest.locked() = Some((format, target));
    }
}
