//! Swapchains of the program and what stands in for their images.
//!
//! [`formats`] lists the formats that can be corrected, [`publishing`] reads pictures back for
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

/// Source of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureSource {
    /// The program's picture as it is.
    Own,
    /// The tile of the program's own picture as it is; where there is none, the panel's.
    Tile,
    /// The program's picture on the panel.
    Panel,
    /// The views.
    Views,
}

/// Objects for one image of the swapchain.
pub(in crate::intercept::vk) struct Slot {
    /// The program's image in the place of the real one.
    pub(in crate::intercept::vk) given: OwnImage,
    /// The views and the panel.
    pub(in crate::intercept::vk) atlas: OwnImage,
    /// The program's image as a target of draws.
    pub(in crate::intercept::vk) target: Arc<ViewTarget>,
    /// Views of the atlas: as it is, and with alpha 1.
    pub(in crate::intercept::vk) views: [vk::ImageView; 2],
    /// Signalled when the real image may be presented.
    pub(in crate::intercept::vk) ready: vk::Semaphore,
    /// Signalled when the commands of its last picture are done.
    pub(in crate::intercept::vk) done: vk::Fence,
    /// For each [`PictureSource`]: recorded when first needed, then submitted again and again.
    pub(in crate::intercept::vk) commands: [vk::CommandBuffer; 4],
    /// They were submitted, and that is not known yet.
    pub(in crate::intercept::vk) pending: bool,
    /// The source of the correction among them, if it is timed.
    pub(in crate::intercept::vk) timed: Option<usize>,
}

/// See the module.
pub struct StandIn {
    /// Places in the atlas and the window.
    pub(in crate::intercept::vk) layout: Arc<AtlasLayout>,
    pub(in crate::intercept::vk) real: Vec<vk::Image>,
    /// Views of the real images, or of the picture in between, which the correction draws into.
    pub(in crate::intercept::vk) targets: Vec<vk::ImageView>,
    /// Picture in between, if the real images encode the values that are written to them: the
    /// correction is made here and copied.
    pub(in crate::intercept::vk) between: Option<OwnImage>,
    /// The outputs that are published beside the window, with views.
    pub(in crate::intercept::vk) beside: Vec<(OwnImage, vk::ImageView)>,
    pub(in crate::intercept::vk) beside_images: Vec<vk::Image>,
    pub(in crate::intercept::vk) slots: Vec<Slot>,
    pub(in crate::intercept::vk) backend: VkBackend,
    /// The format that the correction reads and writes.
    pub(in crate::intercept::vk) format: vk::Format,
    pub(in crate::intercept::vk) family: u32,
    pub(in crate::intercept::vk) pool: vk::CommandPool,
    /// The masks are on the device.
    pub(in crate::intercept::vk) uploaded: bool,
    /// Corrections are timed.
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
    /// Read-back of what is published; `None` if nothing is.
    pub(in crate::intercept::vk) publishing: Option<Publishing>,
    /// After a failure: the program's own picture.
    pub(in crate::intercept::vk) failed: bool,
    /// Version of the rig's file that it follows.
    pub(in crate::intercept::vk) version: u64,
}

/// The swapchains that Cupola looks after.
#[derive(Default)]
pub struct Swapchains {
    pub(in crate::intercept::vk) all: Mutex<HashMap<vk::SwapchainKHR, Arc<Mutex<Swapchain>>>>,
    /// The image of a swapchain that was made last, with its format.
    latest: Mutex<Option<(vk::Format, Arc<ViewTarget>)>>,
    /// Not even the program's own picture could be brought to a window: new swapchains are left
    /// alone.
    pub(in crate::intercept::vk) given_up: AtomicBool,
}

impl Swapchains {
    /// The swapchain, if Cupola looks after it.
    pub fn managed(&self, handle: vk::SwapchainKHR) -> Option<Arc<Mutex<Swapchain>>> {
        self.all.locked().get(&handle).cloned()
    }

    /// The swapchain's image that was made last, if it has this format.
    pub fn latest_target(&self, format: vk::Format) -> Option<Arc<ViewTarget>> {
        let latest = self.latest.locked();
        latest.as_ref().filter(|(known, _)| *known == format).map(|(_, target)| Arc::clone(target))
    }

    /// The image of a swapchain that was made last.
    pub fn latest_window(&self) -> Option<Arc<ViewTarget>> {
        self.latest.locked().as_ref().map(|(_, target)| Arc::clone(target))
    }

    /// The layout of the latest swapchain.
    pub fn latest_layout(&self) -> Option<Arc<AtlasLayout>> {
        let latest = self.latest.locked();
        latest.as_ref().map(|(_, target)| Arc::clone(&target.layout))
    }

    /// The layout of the latest swapchain, if it serves a window of this size.
    pub fn layout(&self, size: (u32, u32), read: bool) -> Option<Arc<AtlasLayout>> {
        self.latest_layout().filter(|layout| (layout.window, layout.read) == (size, read))
    }

    /// An image of a swapchain is gone.
    pub fn forget_target(&self, gone: &Arc<ViewTarget>) {
        let mut latest = self.latest.locked();
        if latest.as_ref().is_some_and(|(_, target)| Arc::ptr_eq(target, gone)) {
            *latest = None;
        }
    }

    /// An image of a swapchain was made.
    pub fn note_target(&self, format: vk::Format, target: Arc<ViewTarget>) {
        *self.latest.locked() = Some((format, target));
    }
}
