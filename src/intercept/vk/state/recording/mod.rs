//! Command buffers of the program: their state while they are recorded, and the data that is needed
//! when they are submitted.
//!
//! [`bindings`] and [`compute_bindings`] hold the state that the program has bound, so that it can
//! be bound again after commands of Cupola. [`draw_groups`] are the draws that are classified at
//! submission. [`draw_parameters`] are the parameters of draws that lie in memory.

pub mod bindings;
pub mod compute_bindings;
pub mod draw_groups;
pub mod draw_parameters;

use crate::intercept::vk::state::driver::Driver;
use crate::intercept::vk::state::images::LayoutChange;
use crate::intercept::vk::state::images::coverage::QueryBlock;
use crate::intercept::vk::state::pipelines::Pipeline;
use crate::intercept::vk::state::queries::Pool;
use crate::intercept::vk::state::recording::bindings::{BoundSet, BoundVertices, PUSH_BYTES};
use crate::intercept::vk::state::recording::compute_bindings::ComputeBindings;
use crate::intercept::vk::state::recording::draw_groups::{DrawGroup, MatrixSource};
use crate::intercept::vk::state::views::view_constants::{ConstantChunks, ConstantPool};
use crate::intercept::vk::state::views::view_target::ViewTarget;
use crate::lock::{Lock, SharedLock};
use ash::vk;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, RwLock};

/// Event that happens when a command buffer runs and matters at submission.
pub enum Event {
    /// Draws that share a lens, by the index of their group.
    DrawGroup(usize),
    /// A copy from buffer to buffer.
    Copy(vk::Buffer, vk::Buffer, vk::BufferCopy),
    /// Bytes that are written to a buffer, at an offset.
    Update(vk::Buffer, u64, Vec<u8>),
    /// A change of an image to a layout.
    Layout(vk::Image, vk::ImageLayout),
    /// Execution of another command buffer.
    Execute(vk::CommandBuffer),
    /// A draw to a view target. True: to its atlas; false: to the program's image.
    Drawn(Arc<ViewTarget>, bool),
    /// Draws to images that may hold a scene, and the matrices that they may use.
    Suspected(Vec<vk::Image>, Vec<MatrixSource>),
    /// Compute shaders write the program's own images, which may hold a scene.
    Computed(Vec<vk::Image>),
    /// Measurement of the part of the window that a draw fills.
    Measured(Arc<QueryBlock>),
    /// Begin of a query that is scaled, by its number in the pool.
    BeginQuery(Arc<Pool>, u32),
    /// End of such a query.
    EndQuery(Arc<Pool>, u32),
    /// Draws that a query may count.
    Counted {
        /// Index of their group, if they have view constants.
        group: Option<usize>,
        /// Number of their vertices.
        vertices: u64,
        /// Number of times that each draw is issued; `None`: the number of tiles in which the group
        /// is in sight.
        times: Option<u32>,
    },
}

/// A pass that is drawn for each view.
pub struct Pass {
    /// Target of its draws.
    pub(in crate::intercept::vk) target: Arc<ViewTarget>,
    /// True if it draws to the target's image, not only to depth.
    pub(in crate::intercept::vk) colored: bool,
    /// True if one of its draws may belong to the scene.
    pub(in crate::intercept::vk) scene: bool,
    /// Colour attachments whose panel must be cleared by the first commands.
    pub(in crate::intercept::vk) uncleared_panels: Vec<u32>,
    /// Kind of command that began the pass.
    pub(in crate::intercept::vk) within: Within,
    /// Scenes that it draws, and their layouts after the pass.
    pub(in crate::intercept::vk) scenes: Vec<(Arc<ViewTarget>, vk::ImageLayout)>,
    /// Images of the program whose layouts this pass would have changed.
    pub(in crate::intercept::vk) layout_changes: Vec<LayoutChange>,
}

/// Kind of command that began a pass, with the data that a secondary command buffer inherits.
pub enum Within {
    /// A render pass.
    Pass {
        /// The render pass.
        pass: vk::RenderPass,
        /// Number of the current subpass.
        subpass: u32,
    },
    /// Dynamic rendering, with attachments of these formats.
    Rendering {
        /// Formats of the colours.
        colors: Vec<vk::Format>,
        /// Format of the depth.
        depth: vk::Format,
        /// Format of the stencil.
        stencil: vk::Format,
        /// Samples per pixel.
        samples: vk::SampleCountFlags,
    },
    /// The pass of the command buffer that executes this one.
    Inherited,
}

impl Pass {
    /// Returns a pass that begins.
    pub fn new(target: Arc<ViewTarget>, within: Within, uncleared_panels: Vec<u32>) -> Self {
        Self {
            target,
            colored: true,
            scene: false,
            uncleared_panels,
            within,
            scenes: Vec::new(),
            layout_changes: Vec::new(),
        }
    }
}

/// Greatest number of bindings of vertex buffers that are followed.
const MOST_BINDINGS: usize = 64;

/// State that is bound and set for graphics while a command buffer is recorded.
pub struct GraphicsState {
    /// The bound pipeline.
    pub(in crate::intercept::vk) pipeline: Option<Arc<Pipeline>>,
    /// The pipeline that is bound on the device: `pipeline`, or a variant of it.
    pub(in crate::intercept::vk) current: vk::Pipeline,
    /// Descriptor sets.
    pub(in crate::intercept::vk) bound: Vec<Option<BoundSet>>,
    /// First number from which on the program's sets are not bound on the device.
    pub(in crate::intercept::vk) displaced: Option<u32>,
    /// Vertex buffers by their binding.
    pub(in crate::intercept::vk) vertices: Vec<Option<BoundVertices>>,
    /// Push constants.
    pub(in crate::intercept::vk) push: [u8; PUSH_BYTES],
    /// The viewport that the program set.
    pub(in crate::intercept::vk) viewport: Option<vk::Viewport>,
    /// The scissor that the program set.
    pub(in crate::intercept::vk) scissor: Option<vk::Rect2D>,
    /// True if viewport and scissor on the device differ from the program's.
    pub(in crate::intercept::vk) disturbed: bool,
}

impl GraphicsState {
    /// Notes vertex buffers that are bound from the binding `first` on. Bindings beyond
    /// `MOST_BINDINGS`, more than drivers have, are not followed.
    pub fn bind_vertices(&mut self, first: u32, bound: impl ExactSizeIterator<Item = BoundVertices>) {
        let end = (first as usize).saturating_add(bound.len());
        if end > MOST_BINDINGS {
            return;
        }
        if self.vertices.len() < end {
            self.vertices.resize(end, None);
        }
        for (place, bound) in self.vertices.iter_mut().skip(first as usize).zip(bound) {
            *place = Some(bound);
        }
    }

    /// Notes that sets of Cupola replace the program's from this number on.
    pub fn displace_from(&mut self, number: u32) {
        self.displaced = Some(self.displaced.map_or(number, |from| from.min(number)));
    }
}

impl Default for GraphicsState {
    fn default() -> Self {
        Self {
            pipeline: None,
            current: vk::Pipeline::null(),
            bound: Vec::new(),
            vertices: Vec::new(),
            displaced: None,
            push: [0; PUSH_BYTES],
            viewport: None,
            scissor: None,
            disturbed: false,
        }
    }
}

/// A command buffer.
pub struct Recording {
    /// The pool that it is from.
    pub(in crate::intercept::vk) pool: vk::CommandPool,
    /// Bound state for graphics.
    pub(in crate::intercept::vk) graphics: GraphicsState,
    /// Bound state for compute shaders.
    pub(in crate::intercept::vk) compute: ComputeBindings,
    /// The pass, if it is drawn for each view.
    pub(in crate::intercept::vk) pass: Option<Pass>,
    /// The images that may hold a scene, within a pass that is not drawn for each view.
    pub(in crate::intercept::vk) plain: Option<Vec<vk::Image>>,
    /// Events that happen when it runs.
    pub(in crate::intercept::vk) events: Vec<Event>,
    /// Images that barriers of the program change, with the layout in which the first barrier of
    /// each finds it.
    pub(in crate::intercept::vk) found: HashMap<vk::Image, vk::ImageLayout>,
    /// Its groups of draws.
    pub(in crate::intercept::vk) draw_groups: Vec<DrawGroup>,
    /// Memory of their view constants.
    pub(in crate::intercept::vk) constants: ConstantChunks,
    /// Command buffers of Cupola that clear the panel if the program's pass has only secondary
    /// command buffers.
    pub(in crate::intercept::vk) clearers: Vec<vk::CommandBuffer>,
    /// Scenes whose view copies its draws sample.
    pub(in crate::intercept::vk) sampled: Vec<Arc<ViewTarget>>,
    /// Queries of Cupola that it resets, for the draws that follow.
    pub(in crate::intercept::vk) measures: Vec<Arc<QueryBlock>>,
    /// The condition that the program has set outside of passes.
    pub(in crate::intercept::vk) condition: Option<Condition>,
    /// True if the last draw that may belong to the scene had y up.
    pub(in crate::intercept::vk) y_up: bool,
    /// Number of active queries, which may count draws.
    pub(in crate::intercept::vk) counting: u32,
}

impl Recording {
    pub(in crate::intercept::vk) fn new(pool: vk::CommandPool) -> Self {
        Self {
            pool,
            graphics: GraphicsState::default(),
            compute: ComputeBindings::default(),
            pass: None,
            plain: None,
            events: Vec::new(),
            found: HashMap::new(),
            draw_groups: Vec::new(),
            constants: ConstantChunks::default(),
            clearers: Vec::new(),
            sampled: Vec::new(),
            measures: Vec::new(),
            condition: None,
            y_up: false,
            counting: 0,
        }
    }

    /// Begins a new recording: nothing is bound, and no view constants are needed.
    pub(in crate::intercept::vk) fn begin(&mut self, driver: &Driver, constants: &ConstantPool) {
        constants.give_back(&mut self.constants);
        if !self.clearers.is_empty() {
            // SAFETY: they are from the pool that the program uses now, and nothing that executes
            // them is running.
            unsafe { driver.functions.free_command_buffers(self.pool, &self.clearers) };
        }
        *self = Self::new(self.pool);
    }

    /// Notes that a barrier of the program finds an image in this layout.
    pub(in crate::intercept::vk) fn finds(&mut self, image: vk::Image, layout: vk::ImageLayout) {
        self.found.entry(image).or_insert(layout);
    }

    /// Notes draws with these matrices to images that may hold a scene.
    pub fn suspect(&mut self, targets: Vec<vk::Image>, sources: Vec<MatrixSource>) {
        let again = |event: &Event| matches!(event, Event::Suspected(t, s) if (t, s) == (&targets, &sources));
        if !sources.is_empty() && !self.events.last().is_some_and(again) {
            self.events.push(Event::Suspected(targets, sources));
        }
    }

    /// Notes that draws sample the view copies of this scene. The copies must stay as long as the
    /// draws are recorded.
    pub fn samples(&mut self, scene: Arc<ViewTarget>) {
        if !self.sampled.iter().any(|known| Arc::ptr_eq(known, &scene)) {
            self.sampled.push(scene);
        }
    }

    /// Forgets the bound state, because other commands ran in between.
    pub fn forget_state(&mut self) {
        let push = self.graphics.push;
        self.graphics = GraphicsState { push, ..GraphicsState::default() };
        self.compute = ComputeBindings::default();
    }
}

/// All command buffers.
#[derive(Default)]
pub struct Recordings {
    pub(in crate::intercept::vk) all: RwLock<HashMap<vk::CommandBuffer, Arc<Mutex<Recording>>>>,
}

impl Recordings {
    /// Returns the recording of a command buffer.
    pub fn get(&self, buffer: vk::CommandBuffer) -> Option<Arc<Mutex<Recording>>> {
        self.all.reading().get(&buffer).cloned()
    }

    /// Calls `run` with the state of a command buffer; `None` if the command buffer is unknown.
    pub fn with<T>(&self, buffer: vk::CommandBuffer, run: impl FnOnce(&mut Recording) -> T) -> Option<T> {
        let recording = self.get(buffer)?;
        let mut recording = recording.locked();
        Some(run(&mut recording))
    }
}

/// A condition that the program has set outside of passes.
#[derive(Clone, Copy, Debug)]
pub struct Condition {
    pub(in crate::intercept::vk) buffer: vk::Buffer,
    pub(in crate::intercept::vk) offset: vk::DeviceSize,
    pub(in crate::intercept::vk) flags: vk::ConditionalRenderingFlagsEXT,
}

/// Number of vertices that is assumed for a draw if only the device knows its size.
const UNKNOWN_SIZE: u64 = 1 << 10;

/// Notes a draw of `vertices` vertices that is issued `times` times, if a query may be active.
/// `None`: it is issued as often as its group is in sight. `group`: index of its group, if it has
/// view constants.
pub fn count_draw(recording: &mut Recording, group: Option<usize>, vertices: u32, times: Option<u32>) {
    if recording.counting == 0 {
        return;
    }
    let new = if vertices == u32::MAX { UNKNOWN_SIZE } else { vertices.into() };
    match recording.events.last_mut() {
        Some(Event::Counted { group: last, vertices, times: t }) if (*last, *t) == (group, times) => *vertices += new,
        _ => recording.events.push(Event::Counted { group, vertices: new, times }),
    }
}
