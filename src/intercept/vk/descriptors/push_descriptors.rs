//! Descriptors that a program pushes into a command buffer. They are kept, so that the lens is found in them, and are pushed
//! again where a set of ours took their place.

use crate::intercept::vk::commands::recording::{Bound, Recording};
use crate::intercept::vk::descriptors::sets::{self, Template};
use crate::intercept::vk::layer::device::Device;
use crate::intercept::vk::layer::hooks::hooks;
use crate::intercept::vk::offscreen::scene_graph::Made;
use ash::vk;

/// What descriptors show.
#[derive(Clone)]
enum Content {
    Images(Vec<vk::DescriptorImageInfo>),
    Buffers(Vec<vk::DescriptorBufferInfo>),
    Texels(Vec<vk::BufferView>),
}

/// Descriptors of one binding.
#[derive(Clone)]
pub struct Write {
    binding: u32,
    element: u32,
    kind: vk::DescriptorType,
    content: Content,
}

/// What was pushed to a set.
#[derive(Clone, Default)]
pub struct Pushed {
    writes: Vec<Write>,
}

impl Write {
    /// # Safety
    /// `write` must be the program's.
    unsafe fn of(write: &vk::WriteDescriptorSet<'_>) -> Option<Self> {
        let (kind, count) = (write.descriptor_type, write.descriptor_count);
        // SAFETY: as promised; the kind says which array counts.
        let content = unsafe {
            match content_of(kind)? {
                Content::Images(_) => Content::Images(crate::intercept::vk::slice(write.p_image_info, count).to_vec()),
                Content::Buffers(_) => {
                    Content::Buffers(crate::intercept::vk::slice(write.p_buffer_info, count).to_vec())
                }
                Content::Texels(_) => {
                    Content::Texels(crate::intercept::vk::slice(write.p_texel_buffer_view, count).to_vec())
                }
            }
        };
        Some(Self { binding: write.dst_binding, element: write.dst_array_element, kind, content })
    }

    /// As a template describes it.
    ///
    /// # Safety
    /// `data` must be what the program gives for the template of this entry.
    unsafe fn described(entry: &sets::TemplateEntry, data: *const u8) -> Option<Self> {
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
                Content::Texels(_) => Content::Texels(all(first, entry.stride, entry.count)),
            }
        };
        Some(Self { binding: entry.binding, element: entry.first, kind: entry.kind, content })
    }

    /// For the driver; it lives as long as this.
    fn plain(&self) -> vk::WriteDescriptorSet<'_> {
        let write = vk::WriteDescriptorSet::default()
            .dst_binding(self.binding)
            .dst_array_element(self.element)
            .descriptor_type(self.kind);
        match &self.content {
            Content::Images(images) => write.image_info(images),
            Content::Buffers(buffers) => write.buffer_info(buffers),
            Content::Texels(views) => write.texel_buffer_view(views),
        }
    }
}

/// An empty list of what descriptors of a kind show; `None` for kinds that are not known.
fn content_of(kind: vk::DescriptorType) -> Option<Content> {
    use vk::DescriptorType as T;
    match kind {
        T::SAMPLER | T::COMBINED_IMAGE_SAMPLER | T::SAMPLED_IMAGE | T::STORAGE_IMAGE | T::INPUT_ATTACHMENT => {
            Some(Content::Images(Vec::new()))
        }
        T::UNIFORM_BUFFER | T::STORAGE_BUFFER => Some(Content::Buffers(Vec::new())),
        T::UNIFORM_TEXEL_BUFFER | T::STORAGE_TEXEL_BUFFER => Some(Content::Texels(Vec::new())),
        _ => None,
    }
}

impl Pushed {
    /// The first buffer of a binding, and where it begins.
    pub fn buffer(&self, binding: u32) -> Option<(vk::Buffer, u64)> {
        let first = |write: &Write| match &write.content {
            Content::Buffers(buffers) if (write.binding, write.element) == (binding, 0) => buffers.first().copied(),
            _ => None,
        };
        self.writes.iter().find_map(first).map(|info| (info.buffer, info.offset))
    }

    /// Descriptors are pushed; what has their place is what they replace.
    fn add(&mut self, write: Write) {
        self.writes.retain(|known| (known.binding, known.element) != (write.binding, write.element));
        self.writes.push(write);
    }

    /// What is there after more was pushed.
    pub fn after(before: Option<Self>, writes: Vec<Write>) -> Self {
        let mut pushed = before.unwrap_or_default();
        writes.into_iter().for_each(|write| pushed.add(write));
        pushed
    }

    /// Pushes all of it again as set `number`.
    ///
    /// # Safety
    /// The command buffer is being recorded; the layout is the program's, which pushed it for this place.
    pub unsafe fn repeat(
        &self,
        (device, buffer): (&Device, vk::CommandBuffer),
        point: vk::PipelineBindPoint,
        layout: vk::PipelineLayout,
        number: u32,
    ) {
        let Some(push) = device.next.pushed.cmd_push_descriptor_set else { return };
        let writes: Vec<_> = self.writes.iter().map(Write::plain).collect();
        // SAFETY: as promised.
        unsafe { push(buffer, point, layout, number, writes.len() as u32, writes.as_ptr()) };
    }
}

/// Descriptors were pushed: what they show cannot be exchanged for a view's.
fn seen(device: &Device, write: &Write) {
    let Content::Images(images) = &write.content else { return };
    if write.kind == vk::DescriptorType::INPUT_ATTACHMENT {
        device.give_up("it pushes descriptors of attachments");
    }
    for view in images.iter().map(|info| info.image_view).filter(|_| sets::is_picture(write.kind)) {
        device.images.described(device, view, write.kind);
        let scene = device.images.candidate_of(view).filter(|_| device.images.has_candidates());
        scene.into_iter().for_each(|image| device.paths.leads(image, Made::Elsewhere));
    }
}

/// Keeps what was pushed for graphics as set `number`.
fn keep(recording: &mut Recording, number: usize, writes: Vec<Write>) {
    if recording.bound.len() <= number {
        recording.bound.resize(number + 1, None);
    }
    let place = &mut recording.bound[number];
    let before = place.take().and_then(|bound| bound.pushed);
    *place = Some(Bound { pushed: Some(Pushed::after(before, writes)), ..Bound::default() });
}

/// All of these descriptors, if all are of known kinds.
fn pushed(
    (device, buffer): (&Device, vk::CommandBuffer),
    (layout, number): (vk::PipelineLayout, u32),
    graphics: bool,
    writes: Option<Vec<Write>>,
) {
    let Some(writes) = writes else { return device.give_up("it pushes descriptors of a kind that is not known") };
    writes.iter().for_each(|write| seen(device, write));
    device.recordings.with(buffer, |recording| match graphics {
        true => keep(recording, number as usize, writes),
        false => recording.compute.push(layout, number, writes),
    });
}

/// # Safety
/// `data` must be what the program gives for the template.
unsafe fn of_template(template: &Template, data: *const u8) -> Option<Vec<Write>> {
    // SAFETY: as promised.
    template.entries.iter().map(|entry| unsafe { Write::described(entry, data) }).collect()
}

hooks! { pushed;
    [c"vkCmdPushDescriptorSetKHR", c"vkCmdPushDescriptorSet"] cmd_push_descriptor_set: vk::PFN_vkCmdPushDescriptorSetKHR = (
        buffer: vk::CommandBuffer, point: vk::PipelineBindPoint, layout: vk::PipelineLayout, number: u32, count: u32, writes: *const vk::WriteDescriptorSet<'_>
    ) { |state, next| {
        let given = crate::intercept::vk::slice(writes, count).iter().map(|write| Write::of(write)).collect();
        pushed((&state, buffer), (layout, number), point == vk::PipelineBindPoint::GRAPHICS, given);
        next(buffer, point, layout, number, count, writes)
    } }
    [c"vkCmdPushDescriptorSetWithTemplateKHR", c"vkCmdPushDescriptorSetWithTemplate"] cmd_push_with_template: vk::PFN_vkCmdPushDescriptorSetWithTemplateKHR = (
        buffer: vk::CommandBuffer, template: vk::DescriptorUpdateTemplate, layout: vk::PipelineLayout, number: u32, data: *const std::ffi::c_void
    ) { |state, next| {
        if let Some(known) = state.descriptors.template(template) {
            pushed((&state, buffer), (layout, number), known.graphics, of_template(&known, data.cast()));
        }
        next(buffer, template, layout, number, data)
    } }
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
        // SAFETY: nothing is looked at.
        assert!(unsafe { Write::of(&unknown) }.is_none());
    }
}
