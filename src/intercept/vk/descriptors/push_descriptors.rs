//! Push descriptors. They are stored so that matrices are found in them. They are pushed again
//! after a set of Cupola has replaced them.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::state::descriptors;
use crate::intercept::vk::state::descriptors::Template;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::images::scene_graph::Made;
use crate::intercept::vk::state::recording::Recording;
use crate::intercept::vk::state::recording::bindings::{BoundSet, Content, Pushed, Write};
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use ash::vk;

/// Notes pushed descriptors. Pushed graphics descriptors cannot be replaced by those of a view.
fn seen(device: &Device, write: &Write, graphics: bool) {
    let Content::Images(images) = &write.content else { return };
    if write.kind == vk::DescriptorType::INPUT_ATTACHMENT {
        device.show_flat("it sets descriptors of attachments by vkCmdPushDescriptorSetKHR");
    }
    for view in images.iter().map(|info| info.image_view).filter(|_| descriptors::is_picture(write.kind)) {
        device.images.described(device, view, write.kind);
        let scene = device.images.candidate_of(view).filter(|_| graphics && device.images.has_candidates());
        scene.into_iter().for_each(|image| device.scene_graph.note_made(image, Made::Elsewhere));
    }
}

impl Pushed {
    /// Returns the same descriptors for each view of `layout`, with the view's images; `None` if
    /// they do not refer to the scene.
    ///
    /// # Errors
    /// The reason why there are none.
    pub fn of_views(&self, device: &Device, layout: &AtlasLayout) -> Result<Option<Vec<Self>>, Obstacle> {
        let mut all = vec![self.clone(); layout.views.len()];
        let mut any = false;
        for (number, write) in self.writes.iter().enumerate() {
            for (place, view) in write.views().enumerate() {
                let Some(copies) = device.images.view_copies(device, view, layout)? else { continue };
                any = true;
                for (pushed, view) in all.iter_mut().zip(&copies.views) {
                    if let Some(Content::Images(infos)) = pushed.writes.get_mut(number).map(|write| &mut write.content)
                        && let Some(info) = infos.get_mut(place)
                    {
                        (info.image_view, info.image_layout) = (*view, copies.layout);
                    }
                }
            }
        }
        Ok(any.then_some(all))
    }
}

/// Stores the descriptors that were pushed for graphics as set `number`.
fn keep(recording: &mut Recording, number: usize, writes: Vec<Write>) {
    if recording.graphics.bound.len() <= number {
        recording.graphics.bound.resize(number + 1, None);
    }
    let place = &mut recording.graphics.bound[number];
    let before = place.take().and_then(|bound| bound.pushed);
    *place = Some(BoundSet { pushed: Some(Pushed::after(before, writes)), ..BoundSet::default() });
}

/// Returns all of these descriptors, if all are of known kinds.
fn pushed(
    device: &Device,
    buffer: vk::CommandBuffer,
    layout: vk::PipelineLayout,
    number: u32,
    graphics: bool,
    writes: Option<Vec<Write>>,
) {
    let Some(writes) = writes else {
        return device.show_flat("it sets descriptors of an unknown kind by vkCmdPushDescriptorSetKHR");
    };
    writes.iter().for_each(|write| seen(device, write, graphics));
    device.recordings.with(buffer, |recording| match graphics {
        true => keep(recording, number as usize, writes),
        false => recording.compute.push(layout, number, writes),
    });
}

/// # Safety
/// `data` must be the data that the program gives for the template.
unsafe fn of_template(template: &Template, data: *const u8) -> Option<Vec<Write>> {
    // SAFETY: as promised.
    template.entries.iter().map(|entry| unsafe { Write::described(entry, data) }).collect()
}

hooks! {
    cmd_push_descriptor_set = (
        buffer: vk::CommandBuffer, point: vk::PipelineBindPoint, layout: vk::PipelineLayout, number: u32, count: u32, writes: *const vk::WriteDescriptorSet<'_>
    ) { |state, next| {
        let given = slice(writes, count).iter().map(|write| Write::of(write)).collect();
        pushed(&state, buffer, layout, number, point == vk::PipelineBindPoint::GRAPHICS, given);
        next(buffer, point, layout, number, count, writes)
    } }
    cmd_push_with_template = (
        buffer: vk::CommandBuffer, template: vk::DescriptorUpdateTemplate, layout: vk::PipelineLayout, number: u32, data: *const std::ffi::c_void
    ) { |state, next| {
        if let Some(known) = state.descriptors.template(template) {
            pushed(&state, buffer, layout, number, known.graphics, of_template(&known, data.cast()));
        }
        next(buffer, template, layout, number, data)
    } }
}
