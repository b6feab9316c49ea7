//! The map that the correction's shaders compute, read back. The programs are the same except for
//! the last stage.

use super::barrier::{Use, barrier};
use super::images::{SourceImage, TargetImage};
use super::memory::{Buffer, Image};
use super::passes::VkBackend;
use crate::backend::vk::driver::headless::Headless;
use crate::correct::shaders::draws::from_top;
use crate::correct::shaders::glsl::Stage;
use crate::correct::shaders::map::MapPixel;
use crate::correct::{Plan, UpperLeftRect};
use crate::error::{Error, ErrorKind, Result};
use ash::vk;

const FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Computes the map of output `output` of `plan` on `headless`. Row 0 is at the top. Each direction
/// is that of the atlas coordinates that the sampler gets. So it contains the error of every f32
/// operation up to there; only the step from the atlas back to a direction is computed in f64.
///
/// # Errors
/// [`ErrorKind::InvalidArgument`] where the plan has no such output; [`ErrorKind::Graphics`] where
/// the device cannot draw to 32-bit floats, or refuses a shader or the size.
pub fn gpu_map(headless: &Headless, plan: &Plan, output: usize) -> Result<Vec<MapPixel>> {
    let Some(pass) = plan.passes.get(output) else {
        let message = format!("There is no output {output}; the plan has {}.", plan.passes.len());
        return Err(Error::new(ErrorKind::InvalidArgument, message));
    };
    let mut backend = VkBackend::for_stage(&headless.api, Stage::Map);
    let result = backend
        .prepare_passes(plan, std::slice::from_ref(pass), false, FORMAT)
        .and_then(|()| read(headless, &mut backend, pass.size, plan.views.atlas));
    backend.destroy();
    let shown = from_top(plan);
    Ok(result?.into_iter().map(|texel| MapPixel::new(&shown, texel)).collect())
}

/// Draws into an image of 32-bit floats and reads it, top row first.
fn read(headless: &Headless, backend: &mut VkBackend, size: (u32, u32), atlas: (u32, u32)) -> Result<Vec<[f32; 4]>> {
    let api = &headless.api;
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
    let mut target = Image::new(api, FORMAT, size, usage)?;
    // The map reads no picture, but a descriptor needs one. Its size is only compared.
    let mut source = Image::new(api, vk::Format::R8G8B8A8_UNORM, (1, 1), vk::ImageUsageFlags::SAMPLED)
        .inspect_err(|_| target.destroy(api))?;
    let mut buffer = Buffer::default();
    let result = draw(headless, backend, (size, atlas), (&target, &source), &mut buffer);
    buffer.destroy(api);
    source.destroy(api);
    target.destroy(api);
    result
}

fn draw(
    headless: &Headless,
    backend: &mut VkBackend,
    ((width, height), atlas): ((u32, u32), (u32, u32)),
    (target, source): (&Image, &Image),
    buffer: &mut Buffer,
) -> Result<Vec<[f32; 4]>> {
    let api = &headless.api;
    let none = (vk::PipelineStageFlags::empty(), vk::AccessFlags::empty());
    backend.set_sources(&[SourceImage {
        image: source.handle,
        view: source.view,
        format: vk::Format::R8G8B8A8_UNORM,
        extent: atlas,
        layout: vk::ImageLayout::GENERAL,
        stages: none.0,
        access: none.1,
    }])?;
    backend.set_targets(&[TargetImage {
        image: target.handle,
        view: target.view,
        format: FORMAT,
        extent: (width, height),
        initial_layout: vk::ImageLayout::UNDEFINED,
        final_layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
        before: none,
        after: (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_READ),
    }])?;
    let mut bytes = vec![0u8; width as usize * height as usize * 16];
    *buffer = Buffer::new(api, bytes.len(), vk::BufferUsageFlags::TRANSFER_DST)?;
    headless.run(|commands| {
        let general = vk::ImageLayout::GENERAL;
        // SAFETY: the command buffer is being recorded, outside a render pass; both images are
        // live.
        unsafe {
            let (before, after) = (Use::nothing(vk::ImageLayout::UNDEFINED), Use::sampled(general));
            barrier(&api.device, commands, (source.handle, 1), before, after);
            backend.record(commands, 0, 0, &[UpperLeftRect::new(0, 0, width as i32, height as i32)])?;
        }
        super::images::copy_to(api, commands, target.handle, (width, height), buffer);
        Ok(())
    })?;
    buffer.read(api, &mut bytes)?;
    let (numbers, _) = bytes.as_chunks::<4>();
    let values: Vec<f32> = numbers.iter().map(|b| f32::from_ne_bytes(*b)).collect();
    Ok(values.as_chunks::<4>().0.to_vec())
}
