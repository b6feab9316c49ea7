//! Runs a plan in the program's command buffers: one draw for each batch of rectangles, one for the
//! pixels that are always black.

mod record;

use crate::backend::vk::descriptors::{Descriptors, Reads};
use crate::backend::vk::driver::api::{Api, refused};
use crate::backend::vk::driver::formats::check_target_format;
use crate::backend::vk::driver::timers::{Timers, Timing};
use crate::backend::vk::images::{SourceImage, TargetImage};
use crate::backend::vk::memory::{Buffer, Image};
use crate::backend::vk::program::Common;
use crate::correct::OutputPass;
use crate::correct::shaders::constants::Pass;
use crate::correct::shaders::draws::{Rows, draws};
use crate::correct::shaders::glsl::Stage;
use crate::correct::shaders::spirv::{Modules, specialise};
use crate::correct::{Arrangement, ImageSize, Plan, Source};
use crate::error::{Error, ErrorKind, Result};
use ash::vk;
use std::collections::HashMap;
use std::mem::take;

/// One draw call.
#[derive(Clone, Debug)]
struct Draw {
    pipeline: vk::Pipeline,
    first: u32,
    count: u32,
    views: Vec<usize>,
    nearest: bool,
    /// True if the draw shows only black.
    black: bool,
}

/// Draws and textures of one output.
#[derive(Debug, Default)]
struct Output {
    size: (u32, u32),
    draws: Vec<Draw>,
    /// Indices of mask, table and picture of black in the list of textures.
    mask: Option<usize>,
    table: Option<usize>,
    black: Option<usize>,
}

/// A mask, a table or a picture of black, and the offset of its values in the staging buffer.
struct Texture {
    image: Image,
    size: (u32, u32),
    offset: u64,
}

/// A command buffer of the program that is being recorded.
pub struct Recording(vk::CommandBuffer);

impl Recording {
    /// Makes it from a command buffer for which the caller vouches.
    ///
    /// # Safety
    /// While this lives the command buffer is being recorded, outside a render pass, for a queue
    /// that can draw, on the device of the [`VkBackend`] that uses it. The images of the backend
    /// are live, and are in the declared layouts when the commands are executed.
    pub unsafe fn new(command_buffer: vk::CommandBuffer) -> Self {
        Self(command_buffer)
    }
}

/// The correction on one device.
///
/// Every function except [`VkBackend::record`] needs that no command buffer recorded by the backend
/// is pending. Dropping destroys nothing; call [`VkBackend::destroy`] while the device is live.
pub struct VkBackend {
    api: Api,
    stage: Stage,
    format: vk::Format,
    common: Common,
    pipelines: HashMap<Modules, vk::Pipeline>,
    /// Pipelines of the plan before: rigs that are edited often return to them.
    earlier: HashMap<Modules, vk::Pipeline>,
    vertices: Buffer,
    indices: Buffer,
    staging: Buffer,
    textures: Vec<Texture>,
    /// True if the next command buffer has to fill the textures.
    upload: bool,
    /// Dummy texture, bound where a shader has no mask, table or picture of black.
    dummy: Option<usize>,
    outputs: Vec<Output>,
    arrangement: Arrangement,
    /// Sizes of the images of a source.
    sizes: Vec<ImageSize>,
    descriptors: Descriptors,
    targets: Vec<(TargetImage, vk::Framebuffer)>,
    timers: Timers,
}

impl VkBackend {
    /// Makes a backend with nothing prepared.
    pub fn new(api: &Api) -> Self {
        Self::for_stage(api, Stage::Present)
    }

    /// As [`VkBackend::new`], with another last stage.
    pub(in crate::backend::vk) fn for_stage(api: &Api, stage: Stage) -> Self {
        Self {
            api: api.clone(),
            stage,
            format: vk::Format::UNDEFINED,
            common: Common::default(),
            pipelines: HashMap::new(),
            earlier: HashMap::new(),
            vertices: Buffer::default(),
            indices: Buffer::default(),
            staging: Buffer::default(),
            textures: Vec::new(),
            upload: false,
            dummy: None,
            outputs: Vec::new(),
            arrangement: Arrangement::Atlas,
            sizes: Vec::new(),
            descriptors: Descriptors::default(),
            targets: Vec::new(),
            timers: Timers::default(),
        }
    }

    /// Makes all pipelines of `plan` for targets of `format`, and its vertices, masks and tables.
    /// `panel`: the flat panel is shown where the plan has one. Sources and targets have to be set
    /// again afterwards. Takes milliseconds per batch: call it only when the rig or a size changes.
    /// After an error, either nothing is prepared, or everything is as before.
    ///
    /// The command buffer that is recorded next fills masks and tables. It has to be submitted
    /// before later ones.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an sRGB format; [`ErrorKind::Graphics`] where the device
    /// cannot draw to the format, or refuses an object; [`ErrorKind::Internal`] where the plan
    /// exceeds the limits of the shaders.
    pub fn prepare(&mut self, plan: &Plan, panel: bool, format: vk::Format) -> Result<()> {
        self.arrange(Arrangement::Atlas);
        self.prepare_passes(plan, &plan.passes, panel, format)
    }

    /// As [`VkBackend::prepare`] for a plan that was arranged as `arrangement`.
    ///
    /// # Errors
    /// As for [`VkBackend::prepare`].
    pub fn prepare_arranged(&mut self, plan: &Plan, arrangement: Arrangement, format: vk::Format) -> Result<()> {
        self.arrange(arrangement);
        self.prepare_passes(plan, &plan.passes, false, format)
    }

    /// Destroys the objects of another arrangement.
    fn arrange(&mut self, arrangement: Arrangement) {
        if arrangement != self.arrangement {
            self.destroy();
            self.arrangement = arrangement;
        }
    }

    /// As [`VkBackend::prepare`] for some of the plan's outputs.
    pub(in crate::backend::vk) fn prepare_passes(
        &mut self,
        plan: &Plan,
        passes: &[OutputPass],
        panel: bool,
        format: vk::Format,
    ) -> Result<()> {
        check_target_format(&self.api, format)?;
        self.forget();
        if format != self.format {
            self.destroy();
        }
        let result = self.build(plan, passes, panel, format);
        if result.is_err() {
            self.destroy();
        }
        result
    }

    fn build(&mut self, plan: &Plan, passes: &[OutputPass], panel: bool, format: vk::Format) -> Result<()> {
        let list = draws(plan, passes, panel, Rows::FromTop)?;
        if self.format != format {
            self.common = Common::new(&self.api, format, self.arrangement)?;
            self.format = format;
        }
        self.sizes = self.arrangement.images(plan);
        let bytes: Vec<u8> = list.vertices.iter().flat_map(|v| v.to_ne_bytes()).collect();
        self.vertices = Buffer::new(&self.api, bytes.len(), vk::BufferUsageFlags::VERTEX_BUFFER)?;
        self.vertices.write(&self.api, 0, &bytes)?;
        let bytes: Vec<u8> = list.indices.iter().flat_map(|v| v.to_ne_bytes()).collect();
        self.indices = Buffer::new(&self.api, bytes.len(), vk::BufferUsageFlags::INDEX_BUFFER)?;
        self.indices.write(&self.api, 0, &bytes)?;
        let (mut old, mut before) = (take(&mut self.pipelines), take(&mut self.earlier));
        let result = passes.iter().zip(&list.outputs).try_for_each(|(pass, draws)| {
            let mut output = Output { size: pass.size, ..Output::default() };
            for draw in draws {
                let modules = specialise(&draw.constants, self.arrangement, self.stage);
                let known = self.pipelines.get(&modules).copied();
                let known = known.or_else(|| old.remove(&modules)).or_else(|| before.remove(&modules));
                let pipeline = known.map_or_else(|| self.common.pipeline(&self.api, &modules), Ok)?;
                self.pipelines.insert(modules, pipeline);
                output.draws.push(Draw {
                    pipeline,
                    first: draw.first,
                    count: draw.count,
                    views: draw.views.clone(),
                    nearest: draw.nearest,
                    black: self.stage == Stage::Present && draw.constants.pass() == Pass::Black,
                });
            }
            self.outputs.push(output);
            Ok(())
        });
        self.earlier = old;
        for pipeline in before.into_values() {
            // SAFETY: a pipeline of Cupola, and nothing is pending.
            unsafe { self.api.device.destroy_pipeline(pipeline, None) };
        }
        result?;
        self.stage_textures(passes)
    }

    /// Makes the textures of masks, tables and pictures of black, and writes their values to the
    /// staging buffer.
    fn stage_textures(&mut self, passes: &[OutputPass]) -> Result<()> {
        let mut bytes: Vec<u8> = Vec::new();
        let mut add = |format, size, values: Vec<u8>| -> Result<usize> {
            let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
            // Copies have to be aligned to a texel; a table's texel has 16 bytes.
            bytes.resize(bytes.len().next_multiple_of(16), 0);
            let image = Image::new(&self.api, format, size, usage)?;
            self.textures.push(Texture { image, size, offset: bytes.len() as u64 });
            bytes.extend(values);
            Ok(self.textures.len() - 1)
        };
        if self.arrangement == Arrangement::Layers {
            // Masks and tables are 2D images, but the pictures of this arrangement are arrays.
            self.dummy = Some(add(vk::Format::R8_UNORM, (1, 1), vec![u8::MAX])?);
        }
        for (pass, output) in passes.iter().zip(&mut self.outputs) {
            if let Some(mask) = &pass.mask {
                let filtered = vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
                let size = (mask.width, mask.height);
                output.mask = Some(if self.api.features(vk::Format::R16_UNORM).contains(filtered) {
                    let values = mask.weights.iter().flat_map(|w| w.to_ne_bytes()).collect();
                    add(vk::Format::R16_UNORM, size, values)?
                } else {
                    // Every device can filter 8 bits. The weight is rounded by up to half a code.
                    let values = mask.weights.iter().map(|w| ((u32::from(*w) + 128) / 257) as u8).collect();
                    add(vk::Format::R8_UNORM, size, values)?
                });
            }
            if let Some(black) = &pass.black {
                let filtered = vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
                let (size, codes) = ((black.width, black.height), black.codes.as_flattened());
                output.black = Some(if self.api.features(vk::Format::R16G16B16A16_UNORM).contains(filtered) {
                    let values = codes.iter().flat_map(|code| code.to_ne_bytes()).collect();
                    add(vk::Format::R16G16B16A16_UNORM, size, values)?
                } else {
                    let values = codes.iter().map(|code| ((u32::from(*code) + 128) / 257) as u8).collect();
                    add(vk::Format::R8G8B8A8_UNORM, size, values)?
                });
            }
            let table_is_read = pass.batches.iter().any(|batch| batch.facets.is_none());
            if let Source::Table(table) = &pass.source
                && table_is_read
            {
                let values = table.texels().as_flattened().iter().flat_map(|v| v.to_ne_bytes()).collect();
                output.table = Some(add(vk::Format::R32G32B32A32_SFLOAT, table.entries(), values)?);
            }
        }
        self.upload = !self.textures.is_empty();
        if self.upload {
            self.staging = Buffer::new(&self.api, bytes.len(), vk::BufferUsageFlags::TRANSFER_SRC)?;
            self.staging.write(&self.api, 0, &bytes)?;
        }
        Ok(())
    }

    /// Sets the source images, from which [`VkBackend::record`] chooses: one image for each source,
    /// or with [`Arrangement::Images`] one image for each view of each source. They replace the
    /// former ones.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an image that does not match [`SourceImage`], or a wrong
    /// number of images; [`ErrorKind::Graphics`] where the device cannot filter the format, or
    /// refuses an object.
    pub fn set_sources(&mut self, images: &[SourceImage]) -> Result<()> {
        self.expect_prepared()?;
        let view =
            |texture: Option<usize>| texture.and_then(|i| self.textures.get(i)).map(|texture| texture.image.view);
        let reads: Vec<Reads> = self
            .outputs
            .iter()
            .flat_map(|output| output.draws.iter().map(move |draw| (output, draw)))
            .map(|(output, draw)| Reads {
                views: draw.views.clone(),
                mask: view(output.mask.or(self.dummy)),
                table: view(output.table.or(self.dummy)),
                black: view(output.black.or(self.dummy)),
            })
            .collect();
        let new = Descriptors::new(&self.api, &self.common, self.arrangement, &reads, &self.sizes, images)?;
        self.descriptors.destroy(&self.api);
        self.descriptors = new;
        Ok(())
    }

    /// Sets the target images, from which [`VkBackend::record`] chooses. They replace the former
    /// ones.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an image that does not match [`TargetImage`];
    /// [`ErrorKind::Graphics`] where the device cannot draw to its format, or refuses an object.
    pub fn set_targets(&mut self, images: &[TargetImage]) -> Result<()> {
        self.expect_prepared()?;
        images.iter().try_for_each(|image| image.check(&self.api, self.format))?;
        self.forget_targets();
        for &image in images {
            let views = [image.view];
            let info = vk::FramebufferCreateInfo::default()
                .render_pass(self.common.render_passes[0])
                .attachments(&views)
                .width(image.extent.0)
                .height(image.extent.1)
                .layers(1);
            // SAFETY: the device and the view are live; the structure is complete.
            let made = unsafe { self.api.device.create_framebuffer(&info, None) };
            self.targets.push((image, made.map_err(refused("a framebuffer"))?));
        }
        Ok(())
    }

    /// From now on measures how long the device takes for corrections of `sources` sources in
    /// queues of `family`. The time of a correction is read when the next correction of its source
    /// is recorded. Nothing is measured if the queues have no timestamps.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where the device refuses the queries.
    pub fn measure(&mut self, sources: usize, family: u32) -> Result<()> {
        self.timers.destroy(&self.api);
        self.timers = Timers::new(&self.api, sources, family)?;
        Ok(())
    }

    /// Reads the time of a finished correction of `source` whose commands are submitted again
    /// without being recorded again.
    pub fn read_timing(&mut self, source: usize) {
        self.timers.read(&self.api, source);
    }

    /// Returns the times measured so far.
    pub fn timing(&self) -> Timing {
        self.timers.timing()
    }

    fn expect_prepared(&self) -> Result<()> {
        if self.outputs.is_empty() {
            return Err(Error::new(ErrorKind::InvalidState, "nothing is prepared yet"));
        }
        Ok(())
    }

    fn forget_targets(&mut self) {
        for (_, framebuffer) in take(&mut self.targets) {
            // SAFETY: a framebuffer of Cupola, and nothing is pending.
            unsafe { self.api.device.destroy_framebuffer(framebuffer, None) };
        }
    }

    /// Destroys everything except the pipelines and the objects that they share.
    fn forget(&mut self) {
        self.descriptors.destroy(&self.api);
        self.forget_targets();
        self.outputs.clear();
        self.dummy = None;
        for mut texture in take(&mut self.textures) {
            texture.image.destroy(&self.api);
        }
        self.staging.destroy(&self.api);
        self.vertices.destroy(&self.api);
        self.indices.destroy(&self.api);
        self.upload = false;
    }

    /// Destroys everything.
    pub fn destroy(&mut self) {
        self.forget();
        for pipeline in take(&mut self.pipelines).into_values().chain(take(&mut self.earlier).into_values()) {
            // SAFETY: a pipeline of Cupola, and nothing is pending.
            unsafe { self.api.device.destroy_pipeline(pipeline, None) };
        }
        self.common.destroy(&self.api);
        self.timers.destroy(&self.api);
        self.format = vk::Format::UNDEFINED;
    }
}
