//! Pictures to correct, and the corrected pictures.

use crate::backend::tests::picture::Picture;
use crate::backend::vk::driver::headless::Headless;
use crate::backend::vk::images::copy_to;
use crate::backend::vk::memory::{Buffer, Image};
use crate::backend::vk::{SourceImage, TargetImage, Use, VkBackend, barrier};
use crate::correct::{Plan, UpperLeftRect};
use ash::vk;

const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// Prepares the plan, presents each of `atlases` into a target of the first output's size, and
/// returns the pictures. Pictures have row 0 at the bottom.
pub fn show_each(headless: &Headless, plan: &Plan, panel: bool, atlases: &[Picture]) -> Vec<Picture> {
    let api = &headless.api;
    let size = plan.passes[0].size;
    let extent = atlases[0].size;
    let mut backend = VkBackend::new(api);
    backend.prepare(plan, panel, FORMAT).expect("pipelines");
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let mut source = Image::new(api, FORMAT, extent, usage).expect("an image");
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
    let mut target = Image::new(api, FORMAT, size, usage).expect("an image");
    let bytes = |(width, height): (u32, u32)| (width * height * 4) as usize;
    let mut upload = Buffer::new(api, bytes(extent), vk::BufferUsageFlags::TRANSFER_SRC).expect("a buffer");
    let mut download = Buffer::new(api, bytes(size), vk::BufferUsageFlags::TRANSFER_DST).expect("a buffer");
    backend
        .set_sources(&[SourceImage {
            image: source.handle,
            view: source.view,
            format: FORMAT,
            extent,
            layout: vk::ImageLayout::TRANSFER_DST_OPTIMAL,
            stages: Use::COPIED_TO.stages,
            access: Use::COPIED_TO.access,
        }])
        .expect("a source");
    backend
        .set_targets(&[TargetImage {
            image: target.handle,
            view: target.view,
            format: FORMAT,
            extent: size,
            initial_layout: vk::ImageLayout::UNDEFINED,
            final_layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
            before: (vk::PipelineStageFlags::empty(), vk::AccessFlags::empty()),
            after: (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_READ),
        }])
        .expect("a target");
    let mut shown = |atlas: &Picture| {
        assert_eq!(atlas.size, extent);
        // Rows from the top.
        let rows = atlas.pixels.chunks_exact(extent.0 as usize).rev();
        upload.write(api, 0, &rows.flat_map(|row| row.as_flattened()).copied().collect::<Vec<u8>>()).expect("mapped");
        let run = headless.run(|commands| {
            let region = vk::BufferImageCopy::default()
                .image_subresource(vk::ImageSubresourceLayers {
                    aspect_mask: vk::ImageAspectFlags::COLOR,
                    layer_count: 1,
                    ..Default::default()
                })
                .image_extent(vk::Extent3D { width: extent.0, height: extent.1, depth: 1 });
            // SAFETY: the command buffer is being recorded; all objects are live, and the sizes are
            // the images' own.
            unsafe {
                let before = Use::nothing(vk::ImageLayout::UNDEFINED);
                barrier(&api.device, commands, (source.handle, 1), before, Use::COPIED_TO);
                let layout = Use::COPIED_TO.layout;
                api.device.cmd_copy_buffer_to_image(commands, upload.handle, source.handle, layout, &[region]);
                backend.record(commands, 0, 0, &[UpperLeftRect::new(0, 0, size.0 as i32, size.1 as i32)])?;
            }
            copy_to(api, commands, target.handle, size, &download);
            Ok(())
        });
        run.expect("a frame");
        let mut pixels = vec![0; bytes(size)];
        download.read(api, &mut pixels).expect("mapped");
        let pixel = |x: u32, y: u32| {
            let at = 4 * ((size.1 - 1 - y) * size.0 + x) as usize;
            [pixels[at], pixels[at + 1], pixels[at + 2], pixels[at + 3]]
        };
        Picture::new(size, pixel)
    };
    let pictures = atlases.iter().map(&mut shown).collect();
    backend.destroy();
    upload.destroy(api);
    download.destroy(api);
    source.destroy(api);
    target.destroy(api);
    pictures
}
