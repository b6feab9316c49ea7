//! Pipelines of the program and their layouts, with what is drawn by in their place.

use crate::intercept::log;
use crate::intercept::vk::spirv::{ComputeUse, DescriptorPlace, Matrix};
use crate::lock::Lock;
use crate::runtime::session::ViewMatrix;
use ash::vk;
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, OnceLock};

/// A pipeline layout. The driver's object lives as long as a pipeline needs it, though the program
/// may destroy it before.
pub struct PipelineLayout {
    /// The driver's object.
    pub(in crate::intercept::vk) handle: vk::PipelineLayout,
    /// Number of the set of Cupola.
    pub(in crate::intercept::vk) ours: u32,
    /// The set has the counter, too.
    pub(in crate::intercept::vk) counts: bool,
    pub(in crate::intercept::vk) destroy: (vk::PFN_vkDestroyPipelineLayout, vk::Device),
}

impl Drop for PipelineLayout {
    fn drop(&mut self) {
        let (destroy, device) = self.destroy;
        // SAFETY: made by us, without callbacks; the device outlives what is kept of it.
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
    /// A shader's words.
    pub fn shader(&self, module: vk::ShaderModule) -> Option<Arc<[u32]>> {
        self.shaders.locked().get(&module).cloned()
    }

    /// A pipeline layout.
    pub fn layout(&self, handle: vk::PipelineLayout) -> Option<Arc<PipelineLayout>> {
        self.layouts.locked().get(&handle).cloned()
    }

    /// Forgets all, before the device is destroyed.
    pub fn clear(&self) {
        self.layouts.locked().clear();
    }
}

/// A graphics pipeline of the program, or a library of which some are linked.
pub struct Pipeline {
    /// The program's.
    pub(in crate::intercept::vk) own: vk::Pipeline,
    /// Its layout, if that has a set of Cupola.
    pub(in crate::intercept::vk) layout: Option<Arc<PipelineLayout>>,
    /// Number of viewports and scissors is set by commands, too.
    pub(in crate::intercept::vk) with_count: bool,
    /// Pipelines that draw in its place.
    pub(in crate::intercept::vk) variants: Option<Variants>,
    /// The program's viewport, unless it is set by commands.
    pub(in crate::intercept::vk) viewport: Option<vk::Viewport>,
    /// Its scissor, likewise.
    pub(in crate::intercept::vk) scissor: Option<vk::Rect2D>,
    /// Its vertices have no attributes.
    pub(in crate::intercept::vk) without_attributes: bool,
}

/// The pipelines for the views. Their viewport and scissor are set by commands.
pub struct Variants {
    /// Draws into a view, and wherever the program's own picture is drawn.
    pub(in crate::intercept::vk) view: vk::Pipeline,
    /// Its shader re-projects; where it could not be followed, what is drawn is flat.
    pub(in crate::intercept::vk) follows: bool,
    /// Draws onto the panel.
    pub(in crate::intercept::vk) panel: vk::Pipeline,
    /// Places of the matrices that its shaders read.
    pub(in crate::intercept::vk) matrices: Vec<Matrix>,
    /// Its fragment shader gets coordinates of the program's window, and the texels of the
    /// program's images.
    pub(in crate::intercept::vk) moves_place: bool,
    /// It should be, and cannot.
    pub(in crate::intercept::vk) loses_place: bool,
    /// Descriptors of the images that it reads by texels, or asks for their size.
    pub(in crate::intercept::vk) pictures: Vec<DescriptorPlace>,
    /// Matrices of its shaders that may be functions of the camera, each with its place among ours.
    pub(in crate::intercept::vk) cameras: Vec<CameraMatrix>,
    /// It tests depth.
    pub(in crate::intercept::vk) deep: bool,
}

/// A stage whose matrices are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixStage {
    /// The vertex shader, where it computes what does not become a position.
    Vertex,
    /// The fragment shader, or a compute shader.
    Fragment,
}

/// A matrix of the program that a shader may replace by one of Cupola's.
#[derive(Clone, Copy, Debug)]
pub struct CameraMatrix {
    pub(in crate::intercept::vk) matrix: Matrix,
    /// Kind of view matrix that its name suggests, if it turns and moves.
    pub(in crate::intercept::vk) called: Option<ViewMatrix>,
    pub(in crate::intercept::vk) stage: MatrixStage,
    /// The shader computes inverses.
    pub(in crate::intercept::vk) inverted: bool,
}

/// A compute pipeline of the program.
pub struct ComputePipeline {
    /// Images and buffers that its shader reads and writes.
    pub(in crate::intercept::vk) uses: ComputeUse,
    /// Its shader has matrices that may be the camera's: the pipeline with those of a view.
    pub(in crate::intercept::vk) variant: Option<ComputeVariant>,
    /// There should be one, and cannot be.
    pub(in crate::intercept::vk) loses_cameras: bool,
}

/// A compute pipeline with the camera's matrices of a view.
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
    /// Statistics of pipelines that are divided, or should be.
    pub(in crate::intercept::vk) divided: DivisionStatistics,
}

/// Statistics of division.
#[derive(Default)]
pub struct DivisionStatistics {
    pub(in crate::intercept::vk) uncounted: OnceLock<&'static str>,
    pub(in crate::intercept::vk) undivided: Mutex<BTreeMap<String, u64>>,
}

impl DivisionStatistics {
    /// Notes a pipeline whose primitives are not divided; the log says why, once.
    pub fn note_undivided(&self, why: &str) {
        log::once(&format!("Vulkan: what a pipeline draws is not divided: {why}"));
        *self.undivided.locked().entry(why.to_owned()).or_default() += 1;
    }

    /// Number of pipelines that are not divided, by reason.
    pub fn undivided(&self) -> BTreeMap<String, u64> {
        self.undivided.locked().clone()
    }

    /// Returns the reason why some pipeline that is divided does not count primitives that are not
    /// fine enough.
    pub fn uncounted(&self) -> Option<&'static str> {
        self.uncounted.get().copied()
    }
}

impl Pipelines {
    /// A compute pipeline.
    pub fn computing(&self, handle: vk::Pipeline) -> Option<Arc<ComputePipeline>> {
        self.computing.locked().get(&handle).cloned()
    }

    /// A graphics pipeline.
    pub fn get(&self, handle: vk::Pipeline) -> Option<Arc<Pipeline>> {
        self.all.locked().get(&handle).cloned()
    }
}
