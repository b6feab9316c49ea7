//! Bindings of a command buffer: descriptor sets and pushed descriptors.

use crate::intercept::vk::state::descriptors::{Descriptors, TemplateEntry};
use crate::intercept::vk::state::driver::entry_points::NextLayer;
use crate::intercept::vk::state::driver::structures::slice;
use ash::vk;

/// Greatest number of bytes of push constants that are examined. No current device has more.
pub const PUSH_BYTES: usize = 256;

/// A descriptor set that the program bound.
#[derive(Clone, Default)]
pub struct BoundSet {
    /// The set.
    pub(in crate::intercept::vk) set: vk::DescriptorSet,
    /// Its dynamic offsets.
    pub(in crate::intercept::vk) dynamic: Vec<u32>,
    /// Descriptors that were pushed instead of a set.
    pub(in crate::intercept::vk) pushed: Option<Pushed>,
}

impl BoundSet {
    /// Returns the buffer of a binding, and its offset.
    pub fn buffer(&self, descriptors: &Descriptors, binding: u32) -> Option<(vk::Buffer, u64)> {
        match &self.pushed {
            Some(pushed) => pushed.buffer(binding),
            None => descriptors.buffer(self.set, &self.dynamic, binding),
        }
    }
}

/// A vertex buffer that the program bound.
#[derive(Clone, Copy, Debug)]
pub struct BoundVertices {
    /// The buffer.
    pub(in crate::intercept::vk) buffer: vk::Buffer,
    /// Offset of its first vertex or instance.
    pub(in crate::intercept::vk) offset: u64,
    /// Distance of vertices or instances, if the command gives it.
    pub(in crate::intercept::vk) stride: Option<u64>,
}

/// Content of descriptors.
#[derive(Clone)]
pub(in crate::intercept::vk) enum Content {
    Images(Vec<vk::DescriptorImageInfo>),
    Buffers(Vec<vk::DescriptorBufferInfo>),
    TexelFormat(Vec<vk::BufferView>),
}

/// Descriptors of one binding.
#[derive(Clone)]
pub struct Write {
    pub(in crate::intercept::vk) binding: u32,
    pub(in crate::intercept::vk) element: u32,
    pub(in crate::intercept::vk) kind: vk::DescriptorType,
    pub(in crate::intercept::vk) content: Content,
}

/// Descriptors that were pushed to a set.
#[derive(Clone, Default)]
pub struct Pushed {
    pub(in crate::intercept::vk) writes: Vec<Write>,
}

impl Write {
    /// # Safety
    /// `write` must be the program's.
    pub(in crate::intercept::vk) unsafe fn of(write: &vk::WriteDescriptorSet<'_>) -> Option<Self> {
        let (kind, count) = (write.descriptor_type, write.descriptor_count);
        // SAFETY: as promised; the type determines which array is valid.
        let content = unsafe {
            match content_of(kind)? {
                Content::Images(_) => Content::Images(slice(write.p_image_info, count).to_vec()),
                Content::Buffers(_) => Content::Buffers(slice(write.p_buffer_info, count).to_vec()),
                Content::TexelFormat(_) => Content::TexelFormat(slice(write.p_texel_buffer_view, count).to_vec()),
            }
        };
        Some(Self { binding: write.dst_binding, element: write.dst_array_element, kind, content })
    }

    /// Reads descriptors as a template describes them.
    ///
    /// # Safety
    /// `data` must be the data that the program gives for the template of this entry.
    pub(in crate::intercept::vk) unsafe fn described(entry: &TemplateEntry, data: *const u8) -> Option<Self> {
        /// # Safety
        /// `count` elements lie `stride` bytes from each other.
        unsafe fn all<T>(first: *const u8, stride: usize, count: u32) -> Vec<T> {
            // SAFETY: as promised.
            (0..count as usize).map(|i| unsafe { std::ptr::read_unaligned(first.add(i * stride).cast()) }).collect()
        }
        // SAFETY: as promised.
        let content = unsafe {
            let first = data.add(entry.offset);
            match content_of(entry.kind)? {
                Content::Images(_) => Content::Images(all(first, entry.stride, entry.count)),
                Content::Buffers(_) => Content::Buffers(all(first, entry.stride, entry.count)),
                Content::TexelFormat(_) => Content::TexelFormat(all(first, entry.stride, entry.count)),
            }
        };
        Some(Self { binding: entry.binding, element: entry.first, kind: entry.kind, content })
    }

    /// Returns the views of its images; none if it has no images.
    pub(in crate::intercept::vk) fn views(&self) -> impl Iterator<Item = vk::ImageView> + '_ {
        let infos = match &self.content {
            Content::Images(infos) => &infos[..],
            _ => &[],
        };
        infos.iter().map(|info| info.image_view)
    }

    /// Returns the structure for the driver. It is valid as long as `self`.
    pub(in crate::intercept::vk) fn plain(&self) -> vk::WriteDescriptorSet<'_> {
        let write = vk::WriteDescriptorSet::default()
            .dst_binding(self.binding)
            .dst_array_element(self.element)
            .descriptor_type(self.kind);
        match &self.content {
            Content::Images(images) => write.image_info(images),
            Content::Buffers(buffers) => write.buffer_info(buffers),
            Content::TexelFormat(views) => write.texel_buffer_view(views),
        }
    }
}

/// Returns an empty content for descriptors of a type; `None` for unknown types.
pub(in crate::intercept::vk) fn content_of(kind: vk::DescriptorType) -> Option<Content> {
    use vk::DescriptorType as T;
    match kind {
        T::SAMPLER | T::COMBINED_IMAGE_SAMPLER | T::SAMPLED_IMAGE | T::STORAGE_IMAGE | T::INPUT_ATTACHMENT => {
            Some(Content::Images(Vec::new()))
        }
        T::UNIFORM_BUFFER | T::STORAGE_BUFFER => Some(Content::Buffers(Vec::new())),
        T::UNIFORM_TEXEL_BUFFER | T::STORAGE_TEXEL_BUFFER => Some(Content::TexelFormat(Vec::new())),
        _ => None,
    }
}

impl Pushed {
    /// Returns the first buffer of a binding, and its offset.
    pub fn buffer(&self, binding: u32) -> Option<(vk::Buffer, u64)> {
        let first = |write: &Write| match &write.content {
            Content::Buffers(buffers) if (write.binding, write.element) == (binding, 0) => buffers.first().copied(),
            _ => None,
        };
        self.writes.iter().find_map(first).map(|info| (info.buffer, info.offset))
    }

    /// Adds pushed descriptors. They replace earlier ones of the same binding and element.
    pub(in crate::intercept::vk) fn add(&mut self, write: Write) {
        self.writes.retain(|known| (known.binding, known.element) != (write.binding, write.element));
        self.writes.push(write);
    }

    /// Returns the content after more descriptors were pushed.
    pub fn after(before: Option<Self>, writes: Vec<Write>) -> Self {
        let mut pushed = before.unwrap_or_default();
        writes.into_iter().for_each(|write| pushed.add(write));
        pushed
    }

    /// Pushes all of it again as set `number`.
    ///
    /// # Safety
    /// The command buffer is being recorded; the layout is the program's, which pushed the
    /// descriptors for this set number.
    pub unsafe fn repeat(
        &self,
        next: &NextLayer,
        buffer: vk::CommandBuffer,
        point: vk::PipelineBindPoint,
        layout: vk::PipelineLayout,
        number: u32,
    ) {
        let Some(push) = next.cmd_push_descriptor_set else { return };
        let writes: Vec<_> = self.writes.iter().map(Write::plain).collect();
        // SAFETY: as promised.
        unsafe { push(buffer, point, layout, number, writes.len() as u32, writes.as_ptr()) };
    }
}

#[cfg(test)]
mod tests {
    use super::{Pushed, Write};
    use ash::vk::{self, Handle};

    #[test]
    fn what_was_pushed_last_to_a_place_counts() {
        let mut pushed = Pushed::default();
        for (binding, buffer, offset) in [(3, 7, 64), (4, 8, 0), (3, 9, 128)] {
            let info = [vk::DescriptorBufferInfo { buffer: vk::Buffer::from_raw(buffer), offset, range: 64 }];
            let write = vk::WriteDescriptorSet::default()
                .dst_binding(binding)
                .descriptor_type(vk::DescriptorType::UNIFORM_BUFFER)
                .buffer_info(&info);
            // SAFETY: the array lives.
            pushed.add(unsafe { Write::of(&write) }.expect("a known kind"));
        }
        assert_eq!(pushed.buffer(3), Some((vk::Buffer::from_raw(9), 128)));
        assert_eq!(pushed.buffer(4), Some((vk::Buffer::from_raw(8), 0)));
        assert_eq!((pushed.buffer(5), pushed.writes.len()), (None, 2));
        let unknown = vk::WriteDescriptorSet::default().descriptor_type(vk::DescriptorType::ACCELERATION_STRUCTURE_KHR);
        // SAFETY: no pointer is read.
        assert!(unsafe { Write::of(&unknown) }.is_none());
    }
}
