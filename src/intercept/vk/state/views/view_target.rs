//! Images that are drawn for each view, with their atlas.

use crate::intercept::vk::state::driver::own_image::OwnImage;
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use ash::vk;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Flags of an atlas.
pub const ATLAS_FLAGS: vk::ImageCreateFlags = vk::ImageCreateFlags::MUTABLE_FORMAT;

/// Usage of an atlas.
pub const ATLAS_USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::COLOR_ATTACHMENT.as_raw()
        | vk::ImageUsageFlags::SAMPLED.as_raw()
        | vk::ImageUsageFlags::TRANSFER_DST.as_raw()
        | vk::ImageUsageFlags::TRANSFER_SRC.as_raw(),
);

/// Usage of a scene's atlas, in addition to that of the program's image.
pub const ATLAS_COPY_USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::TRANSFER_SRC.as_raw() | vk::ImageUsageFlags::TRANSFER_DST.as_raw(),
);

/// Number of passes to the program's own image that were recorded before it became a target and run
/// afterwards. After more, the image is given up.
pub const PATIENCE: u32 = 8;

/// An image of a swapchain, or one that holds a scene on its way to the window.
pub struct ViewTarget {
    /// Positions in the atlas.
    pub(in crate::intercept::vk) layout: Arc<AtlasLayout>,
    /// The program's image.
    pub(in crate::intercept::vk) given: vk::Image,
    /// The atlas.
    pub(in crate::intercept::vk) atlas: vk::Image,
    /// Aspects of the image.
    pub(in crate::intercept::vk) aspects: vk::ImageAspectFlags,
    /// True if the image is a window's.
    pub(in crate::intercept::vk) window: bool,
    /// True if the program's image can be copied to.
    pub(in crate::intercept::vk) copied_to: bool,
    /// True if the latest frame is in the atlas, not in the program's own image.
    pub(in crate::intercept::vk) in_views: AtomicBool,
    /// An image for each view, if the target is a scene that shaders sample.
    pub(in crate::intercept::vk) view_copies: Vec<OwnImage>,
    /// Layout of the view copies between commands.
    pub(in crate::intercept::vk) kept: vk::ImageLayout,
    /// Clear texel for the panel. If it exists, compute shaders may write the view copies, which
    /// are then newer than the atlas.
    pub(in crate::intercept::vk) nothing: Option<OwnImage>,
    /// Number of times that the program's own image was drawn to since the views exist.
    pub(in crate::intercept::vk) missed: AtomicU32,
    /// True if a recorded command outside of passes clears the complete atlas, including the panel.
    /// The filled panel would cover the draws of later passes to the views.
    pub(in crate::intercept::vk) panel_is_filled: AtomicBool,
}

impl ViewTarget {
    /// Makes the target for a window's image and its atlas.
    pub fn of_window(layout: Arc<AtlasLayout>, given: vk::Image, atlas: vk::Image) -> Self {
        Self {
            layout,
            given,
            atlas,
            window: true,
            aspects: vk::ImageAspectFlags::COLOR,
            copied_to: false,
            in_views: false.into(),
            view_copies: Vec::new(),
            kept: vk::ImageLayout::UNDEFINED,
            nothing: None,
            missed: 0.into(),
            panel_is_filled: false.into(),
        }
    }

    /// Returns, when a pass begins, whether it has to clear the panel that a command outside of
    /// passes filled.
    pub fn takes_filled_panel(&self) -> bool {
        self.panel_is_filled.swap(false, Ordering::Relaxed)
    }

    /// True if compute shaders may write its view copies.
    pub fn is_stored(&self) -> bool {
        self.nothing.is_some()
    }

    /// Notes that commands for the program's own image ran. Returns whether this happens again and
    /// again.
    pub fn was_missed(&self) -> bool {
        !self.window && self.missed.fetch_add(1, Ordering::Relaxed) > PATIENCE
    }
}

/// Notes whether the next picture of a window's image is made from its views.
pub fn drawn(target: &ViewTarget, in_views: bool) {
    target.in_views.store(in_views, Ordering::Relaxed);
}
