//! Regions of commands that copy, blit or resolve from image to image.

use crate::intercept::vk::state::views::atlas_layout::AtlasRect;
use ash::vk;

/// Returns an offset in a tile, as an offset in the atlas.
pub(in crate::intercept::vk) fn moved(offset: vk::Offset3D, AtlasRect { x, y, .. }: AtlasRect) -> vk::Offset3D {
    vk::Offset3D { x: offset.x + x, y: offset.y + y, z: offset.z }
}

fn extent(from: vk::Offset3D, size: vk::Extent3D) -> [vk::Offset3D; 2] {
    let last = vk::Offset3D { x: from.x + size.width as i32, y: from.y + size.height as i32, z: 1 };
    [from, last]
}

/// Region of a command that copies, blits or resolves from image to image.
pub(in crate::intercept::vk) trait Region: Clone {
    /// Whether the command can change the size.
    const SCALES: bool;
    /// Whether the command resolves samples.
    const RESOLVES: bool;
    /// Returns the corners of the region that is read.
    fn src(&self) -> [vk::Offset3D; 2];
    /// Returns the corners of the region that is written.
    fn dst(&self) -> [vk::Offset3D; 2];
    /// Moves the region that is read to a rectangle.
    fn read_at(&mut self, place: AtlasRect);
    /// Moves the region that is written to a rectangle.
    fn write_at(&mut self, place: AtlasRect);
    /// Changes the region to all of an image of this size.
    fn take_all(&mut self, size: vk::Extent3D);
    /// Changes the region to a copy from one rectangle to another.
    fn take(&mut self, from: AtlasRect, to: AtlasRect);
}

/// Regions with one extent.
macro_rules! sized {
    ($($kind:ty, $resolves:literal);+) => { $( impl Region for $kind {
        const SCALES: bool = false;
        const RESOLVES: bool = $resolves;
        fn src(&self) -> [vk::Offset3D; 2] {
            extent(self.src_offset, self.extent)
        }
        fn dst(&self) -> [vk::Offset3D; 2] {
            extent(self.dst_offset, self.extent)
        }
        fn read_at(&mut self, place: AtlasRect) {
            self.src_offset = moved(self.src_offset, place);
        }
        fn write_at(&mut self, place: AtlasRect) {
            self.dst_offset = moved(self.dst_offset, place);
        }
        fn take_all(&mut self, size: vk::Extent3D) {
            self.extent = size;
        }
        /// Only blits change the size.
        fn take(&mut self, from: AtlasRect, to: AtlasRect) {
            (self.src_offset, self.dst_offset, self.extent) = (from.offset(), to.offset(), to.extent());
        }
    } )+ };
}
sized!(vk::ImageCopy, false; vk::ImageResolve, true; vk::ImageCopy2<'_>, false; vk::ImageResolve2<'_>, true);

/// Regions with corners.
macro_rules! scaled {
    ($($kind:ty),+) => { $( impl Region for $kind {
        const SCALES: bool = true;
        const RESOLVES: bool = false;
        fn src(&self) -> [vk::Offset3D; 2] {
            self.src_offsets
        }
        fn dst(&self) -> [vk::Offset3D; 2] {
            self.dst_offsets
        }
        fn read_at(&mut self, place: AtlasRect) {
            self.src_offsets = self.src_offsets.map(|offset| moved(offset, place));
        }
        fn write_at(&mut self, place: AtlasRect) {
            self.dst_offsets = self.dst_offsets.map(|offset| moved(offset, place));
        }
        fn take_all(&mut self, size: vk::Extent3D) {
            self.src_offsets = extent(vk::Offset3D::default(), size);
            self.dst_offsets = self.src_offsets;
        }
        fn take(&mut self, from: AtlasRect, to: AtlasRect) {
            self.src_offsets = extent(from.offset(), from.extent());
            self.dst_offsets = extent(to.offset(), to.extent());
        }
    } )+ };
}
scaled!(vk::ImageBlit, vk::ImageBlit2<'_>);
