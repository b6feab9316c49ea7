//! Pipelines of the program and their layouts, and the pipelines that draw instead of them.
//!
//! [`create_info`] and [`stages`] read the structures from which the program makes pipelines.

pub mod create_info;
pub mod stages;

use crate::intercept::process::log;
use crate::intercept::scene::flat_program::MissingLens;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::spirv::{ComputeUse, DescriptorPlace, Matrix};
use crate::lock::Lock;
use crate::runtime::session::ViewMatrix;
use ash::vk;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

/// A pipeline layout. The driver's object lives as long as a pipeline needs it, even if the program
/// destroys it earlier.
pub struct PipelineLayout {
    /// The driver's object.
    pub(in crate::intercept::vk) handle: vk::PipelineLayout,
    /// Number of the set of Cupola.
    pub(in crate::intercept::vk) ours: u32,
    /// True if the set also has the counter.
    pub(in crate::intercept::vk) counts: bool,
    pub(in crate::intercept::vk) destroy: (vk::PFN_vkDestroyPipelineLayout, vk::Device),
}

impl Drop for PipelineLayout {
    fn drop(&mut self) {
        let (destroy, device) = self.destroy;
        // SAFETY: made by Cupola, without callbacks; the device outlives the objects that are
        // stored for it.
        unsafe { destroy(device, self.handle, std::ptr::null()) };
    }
}

/// Shaders and pipeline layouts.
#[derive(Default)]
pub struct PipelineLayouts {
    pub(in crate::intercept::vk) shaders: Mutex<HashMap<vk::ShaderModule, Arc<[u32]>>>,
    pub(in crate::intercept::vk) layouts: Mutex<HashMap<vk::PipelineLayout, Arc<PipelineLayout>>>,
}

impl PipelineLayouts {
    /// Returns a shader's words.
    pub fn shader(&self, module: vk::ShaderModule) -> Option<Arc<[u32]>> {
        self.shaders.locked().get(&module).cloned()
    }

    /// Returns a pipeline layout.
    pub fn layout(&self, handle: vk::PipelineLayout) -> Option<Arc<PipelineLayout>> {
        self.layouts.locked().get(&handle).cloned()
    }

    /// Removes everything, before the device is destroyed.
    pub fn clear(&self) {
        self.layouts.locked().clear();
    }
}

/// A graphics pipeline of the program, or a pipeline library.
pub struct Pipeline {
    /// The program's pipeline.
    pub(in crate::intercept::vk) own: vk::Pipeline,
    /// Its layout, if the layout has a set of Cupola.
    pub(in crate::intercept::vk) layout: Option<Arc<PipelineLayout>>,
    /// True if commands also set the number of viewports and scissors.
    pub(in crate::intercept::vk) with_count: bool,
    /// Pipelines that draw instead of it.
    pub(in crate::intercept::vk) variants: Option<Variants>,
    /// The program's viewport, unless it is set by commands.
    pub(in crate::intercept::vk) viewport: Option<vk::Viewport>,
    /// The program's scissor, unless it is set by commands.
    pub(in crate::intercept::vk) scissor: Option<vk::Rect2D>,
    /// True if it draws triangles whose vertices have no attributes.
    pub(in crate::intercept::vk) bare_triangles: bool,
    /// Attributes of instances that may be columns of a matrix.
    pub(in crate::intercept::vk) columns: Vec<InstanceColumn>,
}

/// Four floats that each instance has as an attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InstanceColumn {
    /// Location in the vertex shader.
    pub(in crate::intercept::vk) location: u32,
    /// Number of the vertex buffer.
    pub(in crate::intercept::vk) binding: u32,
    /// Offset in the data of an instance, in bytes.
    pub(in crate::intercept::vk) offset: u32,
    /// Distance of instances in bytes, unless the command that binds the buffer gives it.
    pub(in crate::intercept::vk) stride: u32,
}

/// The pipelines that draw into the tiles. Their viewport and scissor are set by commands.
#[derive(Clone, Copy, Default)]
pub struct TilePipelines {
    /// Draws into a view, and into the primary view.
    pub(in crate::intercept::vk) view: vk::Pipeline,
    /// Draws onto the panel.
    pub(in crate::intercept::vk) panel: vk::Pipeline,
}

/// The variants of a pipeline.
pub struct Variants {
    /// The pipelines of the tiles.
    pub(in crate::intercept::vk) tiles: TilePipelines,
    /// The same with shaders that do not write to buffers and images; `None` if they do not write,
    /// or if the driver refuses these.
    pub(in crate::intercept::vk) quiet: Option<TilePipelines>,
    /// True if its shader reprojects. If the shader cannot be followed, the draws are flat.
    pub(in crate::intercept::vk) follows: bool,
    /// Locations of the matrices that its shaders read.
    pub(in crate::intercept::vk) matrices: Vec<Matrix>,
    /// Reason why its draws have no lens, if there are no matrices.
    pub(in crate::intercept::vk) missing_lens: MissingLens,
    /// True if its fragment shader gets coordinates of the program's window, and the texels of the
    /// program's images.
    pub(in crate::intercept::vk) moves_place: bool,
    /// True if its fragment shader needs these, but cannot get them.
    pub(in crate::intercept::vk) loses_place: bool,
    /// Descriptors of the images that it reads by texel coordinates, or whose size it queries.
    pub(in crate::intercept::vk) pictures: Vec<DescriptorPlace>,
    /// Matrices of its shaders that may be functions of the camera, in the order of Cupola's
    /// matrices.
    pub(in crate::intercept::vk) cameras: Vec<CameraMatrix>,
    /// True if it tests depth.
    pub(in crate::intercept::vk) deep: bool,
    /// True if its shaders may write to buffers or images.
    pub(in crate::intercept::vk) writes: bool,
    /// True if positions are numbers in its vertex shader.
    pub(in crate::intercept::vk) fixed_position: bool,
    /// True if the inputs of its fragments can be those of another place: for backgrounds.
    pub(in crate::intercept::vk) backdrop: bool,
}

impl Variants {
    /// The pipelines of the tiles in which shaders do not write to buffers and images, as far as
    /// there are such pipelines.
    pub fn without_writes(&self) -> TilePipelines {
        self.quiet.unwrap_or(self.tiles)
    }
}

/// A stage in which Cupola chooses matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixStage {
    /// The vertex shader, in computations that do not make the position.
    Vertex,
    /// The fragment shader, or a compute shader.
    Fragment,
}

/// A matrix of the program that a shader may replace by one of Cupola's.
#[derive(Clone, Copy, Debug)]
pub struct CameraMatrix {
    pub(in crate::intercept::vk) matrix: Matrix,
    /// Kind of view matrix that its name suggests. The matrix itself must only rotate and
    /// translate.
    pub(in crate::intercept::vk) called: Option<ViewMatrix>,
    pub(in crate::intercept::vk) stage: MatrixStage,
    /// True if the shader computes inverses.
    pub(in crate::intercept::vk) inverted: bool,
}

/// A compute pipeline of the program.
pub struct ComputePipeline {
    /// Images and buffers that its shader reads and writes.
    pub(in crate::intercept::vk) uses: ComputeUse,
    /// The pipeline with the matrices of a view, if its shader has matrices that may be the
    /// camera's.
    pub(in crate::intercept::vk) variant: Option<ComputeVariant>,
    /// True if such a pipeline is needed, but cannot be made.
    pub(in crate::intercept::vk) loses_cameras: bool,
}

/// A compute pipeline with the camera matrices of a view.
pub struct ComputeVariant {
    pub(in crate::intercept::vk) pipeline: vk::Pipeline,
    /// Its layout, with the set of Cupola.
    pub(in crate::intercept::vk) layout: Arc<PipelineLayout>,
    /// Matrices of the program.
    pub(in crate::intercept::vk) cameras: Vec<CameraMatrix>,
}

/// The program's pipelines.
#[derive(Default)]
pub struct Pipelines {
    pub(in crate::intercept::vk) computing: Mutex<HashMap<vk::Pipeline, Arc<ComputePipeline>>>,
    pub(in crate::intercept::vk) all: Mutex<HashMap<vk::Pipeline, Arc<Pipeline>>>,
    /// Statistics of pipelines that divide primitives, or should.
    pub(in crate::intercept::vk) divided: DivisionStatistics,
    /// True if shaders of a pipeline may write to buffers or images.
    write: AtomicBool,
}

/// Statistics of division.
#[derive(Default)]
pub struct DivisionStatistics {
    uncounted: OnceLock<&'static str>,
    undivided: Mutex<BTreeMap<String, u64>>,
}

impl DivisionStatistics {
    /// Notes a pipeline whose primitives are not divided. The log gives the reason once.
    pub fn note_undivided(&self, why: &Obstacle) {
        let Some(reason) = why.reason() else { return };
        log::once(&format!("Vulkan: what a pipeline draws is not divided: {reason}"));
        *self.undivided.locked().entry(reason.to_owned()).or_default() += 1;
    }

    /// Returns the number of pipelines that are not divided, by reason.
    pub fn undivided(&self) -> BTreeMap<String, u64> {
        self.undivided.locked().clone()
    }

    /// Notes why a pipeline that divides does not count primitives that are not fine enough.
    pub fn note_uncounted(&self, why: &'static str) {
        let _ = self.uncounted.set(why);
    }

    /// Returns the reason why some pipeline that divides does not count primitives that are not
    /// fine enough.
    pub fn uncounted(&self) -> Option<&'static str> {
        self.uncounted.get().copied()
    }
}

impl Pipelines {
    /// Notes a pipeline whose shaders may write to buffers or images.
    pub fn note_writes(&self) {
        self.write.store(true, Ordering::Relaxed);
    }

    /// True if shaders of a pipeline may write to buffers or images. They write in the program's own
    /// picture, which is needed for that.
    pub fn write(&self) -> bool {
        self.write.load(Ordering::Relaxed)
    }

    /// Returns a compute pipeline.
    pub fn computing(&self, handle: vk::Pipeline) -> Option<Arc<ComputePipeline>> {
        self.computing.locked().get(&handle).cloned()
    }

    /// Returns a graphics pipeline.
    pub fn get(&self, handle: vk::Pipeline) -> Option<Arc<Pipeline>> {
        self.all.locked().get(&handle).cloned()
    }
}
