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

/// Usage of a scene's atlas beside that of the program's image.
pub const ATLAS_COPY_USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::TRANSFER_SRC.as_raw() | vk::ImageUsageFlags::TRANSFER_DST.as_raw(),
);

/// Number of passes into the program's own image, recorded before it became a target, after which
/// it is given up.
pub const PATIENCE: u32 = 8;

/// An image of a swapchain, or one that holds a scene on its way to the window.
pub struct ViewTarget {
    /// Places in the atlas.
    pub(in crate::intercept::vk) layout: Arc<AtlasLayout>,
    /// The program's image.
    pub(in crate::intercept::vk) given: vk::Image,
    /// The atlas.
    pub(in crate::intercept::vk) atlas: vk::Image,
    /// Aspects of the image.
    pub(in crate::intercept::vk) aspects: vk::ImageAspectFlags,
    /// It is a swapchain's.
    pub(in crate::intercept::vk) window: bool,
    /// The program's image can be copied to.
    pub(in crate::intercept::vk) copied_to: bool,
    /// The latest frame is in the atlas, not in the program's picture.
    pub(in crate::intercept::vk) in_views: AtomicBool,
    /// Of a scene that shaders sample: an image for each view.
    pub(in crate::intercept::vk) view_copies: Vec<OwnImage>,
    /// The layout in which these are kept.
    pub(in crate::intercept::vk) kept: vk::ImageLayout,
    /// Compute shaders may write the view copies: they are newer than the atlas. With a texel that
    /// is clear, for the panel.
    pub(in crate::intercept::vk) nothing: Option<OwnImage>,
    /// Number of times that the program's own image was drawn to since the views are.
    pub(in crate::intercept::vk) missed: AtomicU32,
    /// A command outside of passes was recorded that clears all of the atlas, and with it the panel,
    /// which would cover what passes draw to the views from here on.
    pub(in crate::intercept::vk) panel_is_filled: AtomicBool,
}

impl ViewTarget {
    /// A swapchain's image, with its atlas.
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

    /// A pass begins; whether it has to clear the panel, which a command outside of passes filled.
    pub fn takes_filled_panel(&self) -> bool {
        self.panel_is_filled.swap(false, Ordering::Relaxed)
    }

    /// True if compute shaders may write its view copies.
    pub fn is_stored(&self) -> bool {
        self.nothing.is_some()
    }

    /// Commands for the program's own image ran; whether that is so again and again.
    pub fn was_missed(&self) -> bool {
        !self.window && self.missed.fetch_add(1, Ordering::Relaxed) > PATIENCE
    }
}

/// Marks what the next picture of a swapchain's image is made of.
pub fn drawn(target: &ViewTarget, in_views: bool) {
    target.in_views.store(in_views, Ordering::Relaxed);
}
