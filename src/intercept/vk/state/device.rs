//! Devices: the state that Cupola has of each, in parts.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::state::descriptors::Descriptors;
use crate::intercept::vk::state::driver::entry_points::NextLayer;
use crate::intercept::vk::state::driver::instance::dispatch_key;
use crate::intercept::vk::state::driver::{Driver, Queue};
use crate::intercept::vk::state::flatness::Flatness;
use crate::intercept::vk::state::host_memory::HostMemory;
use crate::intercept::vk::state::images::Images;
use crate::intercept::vk::state::images::framebuffers::Framebuffers;
use crate::intercept::vk::state::images::scene_graph::SceneGraph;
use crate::intercept::vk::state::pipelines::{PipelineLayouts, Pipelines};
use crate::intercept::vk::state::queries::Queries;
use crate::intercept::vk::state::recording::Recordings;
use crate::intercept::vk::state::recording::draw_groups::Frame;
use crate::intercept::vk::state::swapchains::Swapchains;
use crate::intercept::vk::state::views::vertices::{VertexDecision, VertexProcessing};
use crate::intercept::vk::state::views::view_constants::{ConstantPool, SlotParts};
use crate::lock::{Lock, SharedLock};
use crate::rig::Duplicate;
use crate::runtime::frame_times::FrameTimes;
use ash::vk;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex, RwLock};

/// A device of the program. Each part has its owner: the module that changes it.
pub struct Device {
    /// The driver's side; set once.
    pub(in crate::intercept::vk) driver: Driver,
    /// The next layer's functions that hooks call.
    pub(in crate::intercept::vk) next: NextLayer,
    /// Tasks of Cupola on this device, decided when it is created.
    pub(in crate::intercept::vk) role: Role,
    /// Reasons why draws are not issued for each view.
    pub(in crate::intercept::vk) flatness: Flatness,
    /// Command buffers (`commands`).
    pub(in crate::intercept::vk) recordings: Recordings,
    /// Render passes and framebuffers (`commands`).
    pub(in crate::intercept::vk) framebuffers: Framebuffers,
    /// Images (`offscreen`).
    pub(in crate::intercept::vk) images: Images,
    /// Images that hold a scene on its way to the window (`offscreen`).
    pub(in crate::intercept::vk) scene_graph: SceneGraph,
    /// Shaders and pipeline layouts (`pipelines`).
    pub(in crate::intercept::vk) layouts: PipelineLayouts,
    /// Pipelines (`pipelines`).
    pub(in crate::intercept::vk) pipelines: Pipelines,
    /// Descriptor sets (`descriptors`).
    pub(in crate::intercept::vk) descriptors: Descriptors,
    /// Buffers and memory (`submit`).
    pub(in crate::intercept::vk) host_memory: HostMemory,
    /// Memory of the view constants (`commands` takes it, `submit` writes it).
    pub(in crate::intercept::vk) view_constants: ConstantPool,
    /// The frame that is being submitted (`submit`).
    pub(in crate::intercept::vk) frame: Mutex<Frame>,
    /// Queries that count (`queries`).
    pub(in crate::intercept::vk) queries: Queries,
    /// Swapchains (`swapchain`).
    pub(in crate::intercept::vk) swapchains: Swapchains,
    /// The family of each queue that the program requested (`layer`).
    pub(in crate::intercept::vk) queues: Mutex<HashMap<vk::Queue, u32>>,
    /// Frames that were presented, and the report of the last one (`swapchain`).
    pub(in crate::intercept::vk) presented: Presented,
}

/// Tasks of Cupola on a device.
pub struct Role {
    /// True if Cupola has anything to do here.
    pub(in crate::intercept::vk) active: bool,
    /// True if it corrects pictures, and does not only count and capture.
    pub(in crate::intercept::vk) corrects: bool,
    /// How shaders process vertices.
    pub(in crate::intercept::vk) vertices: VertexDecision,
    /// True if occlusion queries count samples exactly.
    pub(in crate::intercept::vk) counts_samples: bool,
    /// True if commands may change the class of the primitives of a pipeline.
    pub(in crate::intercept::vk) topologies_change: bool,
    /// True if its windows may join the driver's present barrier.
    pub(in crate::intercept::vk) joins_barriers: bool,
}

/// Frames that were presented.
#[derive(Default)]
pub struct Presented {
    /// Number of presented frames.
    pub(in crate::intercept::vk) frames: AtomicU64,
    /// Number of the last report.
    pub(in crate::intercept::vk) report: AtomicU64,
    /// Times of the frames, if statistics are needed.
    pub(in crate::intercept::vk) times: Arc<Mutex<FrameTimes>>,
}

pub(in crate::intercept::vk) static DEVICES: RwLock<Option<HashMap<usize, Arc<Device>>>> = RwLock::new(None);

/// Returns the device that a device, queue or command buffer belongs to.
pub fn get(handle: impl vk::Handle) -> Option<Arc<Device>> {
    let object = handle.as_raw();
    if object == 0 {
        return None;
    }
    // SAFETY: the program passed a live handle to Vulkan.
    let key = unsafe { dispatch_key(object) };
    DEVICES.reading().as_ref()?.get(&key).cloned()
}

impl Role {
    /// True if this device divides primitives for outputs that request it.
    pub fn divides(&self) -> bool {
        self.vertices.vertices == VertexProcessing::Divided
    }
}

impl Device {
    /// Returns the distance of two slots of view constants, in bytes.
    pub fn slot_stride(&self, parts: SlotParts) -> u32 {
        let alignment = self.driver.limits.min_uniform_buffer_offset_alignment.clamp(1, 1 << 12) as u32;
        self.view_constants.slot(parts).next_multiple_of(alignment)
    }

    /// True if draws are issued for each view.
    pub fn draws_views(&self) -> bool {
        self.flatness.draws_views()
    }

    /// Shows the program's picture flat from now on. The log gives the reason.
    pub fn show_flat(&self, why: impl Into<Obstacle>) {
        self.flatness.show_flat(&why.into());
    }

    /// Returns the atlas copies of an image that follow its layout, while draws are issued for each
    /// view.
    pub fn atlas_copies(&self, image: vk::Image) -> Vec<vk::Image> {
        if self.draws_views() { self.images.atlas_copies(image) } else { Vec::new() }
    }

    /// Returns the reasons why images with a scene are drawn only once, with the number of images
    /// for each reason.
    pub fn single_images(&self, rule: Duplicate) -> BTreeMap<String, u64> {
        self.scene_graph.single(rule, |image| self.images.is_shown_small(image))
    }

    /// Returns a queue with its family.
    pub fn queue(&self, handle: vk::Queue) -> Queue {
        let queues = self.queues.locked();
        Queue { handle, family: queues.get(&handle).copied().unwrap_or(0) }
    }
}
