//! An image of the program, its views, and the changes of its layout.

use crate::intercept::vk::state::driver::own_image::OwnImage;
use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect};
use crate::intercept::vk::state::views::view_target::{ATLAS_COPY_USAGE, ViewTarget};
use ash::vk;
use std::sync::{Arc, Weak};

/// An image of the program.
pub(in crate::intercept::vk) struct Image {
    pub(in crate::intercept::vk) flags: vk::ImageCreateFlags,
    pub(in crate::intercept::vk) kind: vk::ImageType,
    pub(in crate::intercept::vk) format: vk::Format,
    pub(in crate::intercept::vk) size: (u32, u32),
    pub(in crate::intercept::vk) mip_levels: u32,
    pub(in crate::intercept::vk) layers: u32,
    pub(in crate::intercept::vk) samples: vk::SampleCountFlags,
    pub(in crate::intercept::vk) usage: vk::ImageUsageFlags,
    /// Layout after the last recorded command.
    pub(in crate::intercept::vk) layout: vk::ImageLayout,
    /// Layout after the last submitted commands, which need not be those that were recorded last.
    pub(in crate::intercept::vk) submitted_layout: vk::ImageLayout,
    /// True if shaders can read it.
    pub(in crate::intercept::vk) described: bool,
    /// True if a pass with depth only drew to its atlas copy instead.
    pub(in crate::intercept::vk) drawn_alone: bool,
    /// True if a pass had it as an attachment.
    pub(in crate::intercept::vk) attached: bool,
    /// True if a pass that drew to the window or to a scene had it as an attachment.
    pub(in crate::intercept::vk) drawn_together: bool,
    /// Layout of the last of these passes, if neither a pass of the program's own nor a copy to the
    /// image came later.
    pub(in crate::intercept::vk) drawn_in: Weak<AtlasLayout>,
    pub(in crate::intercept::vk) target: Option<Arc<ViewTarget>>,
    pub(in crate::intercept::vk) atlas_copies: Vec<((u32, u32), OwnImage)>,
}

/// A view of an image.
pub(in crate::intercept::vk) struct View {
    pub(in crate::intercept::vk) image: vk::Image,
    pub(in crate::intercept::vk) kind: vk::ImageViewType,
    pub(in crate::intercept::vk) format: vk::Format,
    pub(in crate::intercept::vk) components: vk::ComponentMapping,
    pub(in crate::intercept::vk) range: vk::ImageSubresourceRange,
    /// Its usage, if that is less than its image's.
    pub(in crate::intercept::vk) usage: Option<vk::ImageUsageFlags>,
    /// Atlas copies of the view, by the image that they belong to.
    pub(in crate::intercept::vk) atlas_copies: Vec<(vk::Image, vk::ImageView)>,
}

/// An image of Cupola that must be changed to a layout before the next submission.
#[derive(Clone, Copy)]
pub struct PendingLayout {
    /// The image.
    pub(in crate::intercept::vk) image: vk::Image,
    /// The layout that the program expects it to have.
    pub(in crate::intercept::vk) layout: vk::ImageLayout,
    /// Its aspects.
    pub(in crate::intercept::vk) aspects: vk::ImageAspectFlags,
    /// True if its colour is cleared first.
    pub(in crate::intercept::vk) cleared: bool,
    /// The image of the program whose content is copied to it, in the same layout, and the
    /// rectangle for the copy.
    pub(in crate::intercept::vk) filled: Option<(vk::Image, AtlasRect)>,
}

/// Format, usage and samples of an image.
pub type ImageKind = (vk::Format, vk::ImageUsageFlags, vk::SampleCountFlags);

/// An image that was found to hold a scene.
#[derive(Clone, Copy, Debug)]
pub struct KnownScene {
    pub(in crate::intercept::vk) kind: ImageKind,
    pub(in crate::intercept::vk) size: (u32, u32),
    /// Size of the window when the image was found.
    pub(in crate::intercept::vk) window: (u32, u32),
}

impl KnownScene {
    /// True if an image of this kind and size corresponds to it in a window of another size.
    pub(in crate::intercept::vk) fn is_like(&self, kind: ImageKind, size: (u32, u32), window: (u32, u32)) -> bool {
        // Equal up to rounding to whole texels.
        let near = |size: u32, window: u32, own: u32, own_window: u32| {
            let [size, scaled] = [(size, own_window), (window, own)].map(|(a, b)| u64::from(a) * u64::from(b));
            size.abs_diff(scaled) <= u64::from(own_window)
        };
        self.kind == kind
            && near(size.0, window.0, self.size.0, self.window.0)
            && near(size.1, window.1, self.size.1, self.window.1)
    }
}

/// Returns the aspects of a format.
pub fn aspects(format: vk::Format) -> vk::ImageAspectFlags {
    use vk::{Format as F, ImageAspectFlags as A};
    match format {
        F::D16_UNORM | F::X8_D24_UNORM_PACK32 | F::D32_SFLOAT => A::DEPTH,
        F::S8_UINT => A::STENCIL,
        F::D16_UNORM_S8_UINT | F::D24_UNORM_S8_UINT | F::D32_SFLOAT_S8_UINT => A::DEPTH | A::STENCIL,
        _ => A::COLOR,
    }
}

/// An image of the program whose layout must be changed.
#[derive(Clone, Copy, Debug)]
pub struct LayoutChange {
    /// The image.
    pub(in crate::intercept::vk) image: vk::Image,
    /// Its aspects.
    pub(in crate::intercept::vk) aspects: vk::ImageAspectFlags,
    /// The new layout.
    pub(in crate::intercept::vk) layout: vk::ImageLayout,
}

impl Image {
    /// True if it may hold a scene on its way to the window.
    pub(in crate::intercept::vk) fn may_hold_scene(&self) -> bool {
        use vk::ImageUsageFlags as U;
        self.usage.intersects(U::COLOR_ATTACHMENT | U::DEPTH_STENCIL_ATTACHMENT | U::STORAGE)
            && self.usage.intersects(U::SAMPLED | U::TRANSFER_SRC | U::STORAGE)
            && self.kind == vk::ImageType::TYPE_2D
            && self.layers == 1
            && (self.mip_levels == 1 || !self.may_be_attached())
            && self.target.as_ref().is_none_or(|target| !target.window)
    }

    /// True if passes may draw to it. Images that only compute shaders write may have several
    /// levels.
    pub(in crate::intercept::vk) fn may_be_attached(&self) -> bool {
        use vk::ImageUsageFlags as U;
        self.usage.intersects(U::COLOR_ATTACHMENT | U::DEPTH_STENCIL_ATTACHMENT)
    }

    /// Returns the usage of its atlas copy.
    pub(in crate::intercept::vk) fn atlas_copy_usage(&self) -> vk::ImageUsageFlags {
        if self.may_hold_scene() { self.usage | ATLAS_COPY_USAGE } else { self.usage }
    }

    /// True if it has one sample per pixel. Images with more samples cannot be copied to view
    /// copies.
    pub(in crate::intercept::vk) fn is_single(&self) -> bool {
        self.samples == vk::SampleCountFlags::TYPE_1
    }

    pub(in crate::intercept::vk) fn kind(&self) -> ImageKind {
        (self.format, self.usage, self.samples)
    }
}

/// Views of the view copies of a scene.
pub struct ViewCopies {
    /// The scene. It is compared, because new objects may get the same handles later.
    pub(in crate::intercept::vk) of: Weak<ViewTarget>,
    /// One image view for each view of the rig.
    pub(in crate::intercept::vk) views: Vec<vk::ImageView>,
    /// The layout in which shaders read them.
    pub(in crate::intercept::vk) layout: vk::ImageLayout,
}

impl ViewCopies {
    /// Returns the same image for each of `count` views.
    pub fn same(view: vk::ImageView, count: usize) -> Self {
        Self { of: Weak::new(), views: vec![view; count], layout: vk::ImageLayout::UNDEFINED }
    }
}

impl PartialEq for ViewCopies {
    fn eq(&self, other: &Self) -> bool {
        Weak::ptr_eq(&self.of, &other.of) && self.views == other.views
    }
}

#[cfg(test)]
mod tests {
    use super::KnownScene;
    use ash::vk;

    #[test]
    fn images_have_counterparts_in_windows_of_other_sizes() {
        let of_usage = |usage| (vk::Format::R8G8B8A8_UNORM, usage, vk::SampleCountFlags::TYPE_1);
        let (kind, other) = (of_usage(vk::ImageUsageFlags::SAMPLED), of_usage(vk::ImageUsageFlags::TRANSFER_SRC));
        let half = KnownScene { kind, size: (320, 180), window: (640, 360) };
        for (size, window) in [((320, 180), (640, 360)), ((400, 300), (800, 600)), ((401, 226), (801, 451))] {
            assert!(half.is_like(kind, size, window), "{size:?} {window:?}");
            assert!(!half.is_like(other, size, window), "{size:?} {window:?}");
        }
        for (size, window) in [((640, 360), (640, 360)), ((200, 150), (800, 600)), ((400, 320), (800, 600))] {
            assert!(!half.is_like(kind, size, window), "{size:?} {window:?}");
        }
    }
}
