//! Command buffers of the program: their state while they are recorded, and what has to be known of
//! them when they are submitted.

use crate::intercept::vk::state::bindings::Bound;
use crate::intercept::vk::state::compute_bindings::Compute;
use crate::intercept::vk::state::draw_groups::{Run, Source};
use crate::intercept::vk::state::driver::Driver;
use crate::intercept::vk::state::images::Settled;
use crate::intercept::vk::state::pipelines::Pipeline;
use crate::intercept::vk::state::queries::Pool;
use crate::intercept::vk::state::shown::Shown;
use crate::intercept::vk::state::view_constants::{Rows, Taken};
use ash::vk;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

/// Bytes of push constants that are looked at; no device of today has more.
pub const PUSH_BYTES: usize = 256;

/// What happens when a command buffer runs, as far as it matters when it is submitted.
pub enum Event {
    /// Draws that share a lens, by their index.
    Run(usize),
    /// A copy from buffer to buffer.
    Copy(vk::Buffer, vk::Buffer, vk::BufferCopy),
    /// A buffer is written.
    Update(vk::Buffer, u64, Vec<u8>),
    /// Another command buffer runs.
    Execute(vk::CommandBuffer),
    /// A swapchain's image is drawn: its atlas, or itself.
    Drawn(Arc<Shown>, bool),
    /// Draws to images that may hold a scene, and the matrices that they may use.
    Suspected(Vec<vk::Image>, Vec<Source>),
    /// A query that is weighed begins, by its number in the pool.
    BeginQuery(Arc<Pool>, u32),
    /// It ends.
    EndQuery(Arc<Pool>, u32),
    /// Draws that a query may count.
    Counted {
        /// Their run, if they have rows.
        run: Option<usize>,
        /// How many vertices they have.
        vertices: u64,
        /// How often each is issued; `None`: as often as the run is in sight.
        times: Option<u32>,
    },
}

/// A pass that is drawn for each view.
pub struct Pass {
    /// What it draws to.
    pub(in crate::intercept::vk) shown: Arc<Shown>,
    /// A draw of it may have belonged to the scene.
    pub(in crate::intercept::vk) scene: bool,
    /// Colour attachments whose panel has to be cleared by the first commands.
    pub(in crate::intercept::vk) unclear: Vec<u32>,
    /// How the pass was begun.
    pub(in crate::intercept::vk) within: Within,
    /// Scenes that it draws, and the layouts that it leaves them in.
    pub(in crate::intercept::vk) scenes: Vec<(Arc<Shown>, vk::ImageLayout)>,
    /// Images of the program that this pass would have brought into a layout.
    pub(in crate::intercept::vk) settled: Vec<Settled>,
}

/// How a pass was begun: what a secondary command buffer in it has to be told.
pub enum Within {
    /// By a render pass.
    Pass {
        /// It.
        pass: vk::RenderPass,
        /// The number of the subpass that is recorded.
        subpass: u32,
    },
    /// By dynamic rendering, with attachments of these formats.
    Rendering {
        /// Colours.
        colors: Vec<vk::Format>,
        /// Depth.
        depth: vk::Format,
        /// Stencil.
        stencil: vk::Format,
        /// Samples of a pixel.
        samples: vk::SampleCountFlags,
    },
    /// By the command buffer that executes this one.
    Inherited,
}

impl Pass {
    /// A pass that begins.
    pub fn new(shown: Arc<Shown>, within: Within, unclear: Vec<u32>) -> Self {
        Self { shown, scene: false, unclear, within, scenes: Vec::new(), settled: Vec::new() }
    }
}

/// A command buffer.
pub struct Recording {
    /// The pool that it is from.
    pub(in crate::intercept::vk) pool: vk::CommandPool,
    /// The bound graphics pipeline.
    pub(in crate::intercept::vk) pipeline: Option<Arc<Pipeline>>,
    /// The pipeline that is bound on the device: it, or a variant of it.
    pub(in crate::intercept::vk) current: vk::Pipeline,
    /// What is bound for compute shaders.
    pub(in crate::intercept::vk) compute: Compute,
    /// Descriptor sets for graphics.
    pub(in crate::intercept::vk) bound: Vec<Option<Bound>>,
    /// From this number on, sets that the program bound are not bound any more.
    pub(in crate::intercept::vk) displaced: Option<u32>,
    /// Push constants.
    pub(in crate::intercept::vk) push: [u8; PUSH_BYTES],
    /// The viewport that the program set.
    pub(in crate::intercept::vk) viewport: Option<vk::Viewport>,
    /// The scissor that the program set.
    pub(in crate::intercept::vk) scissor: Option<vk::Rect2D>,
    /// The device's viewport and scissor are not the program's.
    pub(in crate::intercept::vk) disturbed: bool,
    /// The pass, if it is drawn for each view.
    pub(in crate::intercept::vk) pass: Option<Pass>,
    /// Within a pass that is not: its images that may hold a scene.
    pub(in crate::intercept::vk) plain: Option<Vec<vk::Image>>,
    /// What happens when it runs.
    pub(in crate::intercept::vk) events: Vec<Event>,
    /// Its runs of draws.
    pub(in crate::intercept::vk) runs: Vec<Run>,
    /// Memory of their rows.
    pub(in crate::intercept::vk) rows: Taken,
    /// Command buffers of ours that clear the panel where the program's pass has none but secondary ones.
    pub(in crate::intercept::vk) clearers: Vec<vk::CommandBuffer>,
    /// Scenes whose prints its draws sample.
    pub(in crate::intercept::vk) sampled: Vec<Arc<Shown>>,
    /// The condition that the program has set outside of passes.
    pub(in crate::intercept::vk) condition: Option<Condition>,
    /// How many queries may count what is drawn now.
    pub(in crate::intercept::vk) counting: u32,
}

impl Recording {
    pub(in crate::intercept::vk) fn new(pool: vk::CommandPool) -> Self {
        Self {
            pool,
            pipeline: None,
            current: vk::Pipeline::null(),
            compute: Compute::default(),
            bound: Vec::new(),
            displaced: None,
            push: [0; PUSH_BYTES],
            viewport: None,
            scissor: None,
            disturbed: false,
            pass: None,
            plain: None,
            events: Vec::new(),
            runs: Vec::new(),
            rows: Taken::default(),
            clearers: Vec::new(),
            sampled: Vec::new(),
            condition: None,
            counting: 0,
        }
    }

    /// It is recorded anew: nothing is bound, and no rows are needed.
    pub(in crate::intercept::vk) fn begin(&mut self, driver: &Driver, rows: &Rows) {
        rows.give_back(&mut self.rows);
        if !self.clearers.is_empty() {
            // SAFETY: of the pool that the program uses now; nothing runs that executes them.
            unsafe { driver.functions.free_command_buffers(self.pool, &self.clearers) };
        }
        *self = Self::new(self.pool);
    }

    /// Draws with these matrices go to images that may hold a scene.
    pub fn suspect(&mut self, targets: Vec<vk::Image>, sources: Vec<Source>) {
        let again = |event: &Event| matches!(event, Event::Suspected(t, s) if (t, s) == (&targets, &sources));
        if !sources.is_empty() && !self.events.last().is_some_and(again) {
            self.events.push(Event::Suspected(targets, sources));
        }
    }

    /// Draws sample the prints of this scene, which have to stay as long as they are recorded.
    pub fn samples(&mut self, scene: Arc<Shown>) {
        if !self.sampled.iter().any(|known| Arc::ptr_eq(known, &scene)) {
            self.sampled.push(scene);
        }
    }

    /// Other commands than the recorded ones ran: nothing of the state is known any more.
    pub fn forget_state(&mut self) {
        self.pipeline = None;
        self.current = vk::Pipeline::null();
        self.bound.clear();
        self.compute = Compute::default();
        self.displaced = None;
        self.disturbed = false;
        (self.viewport, self.scissor) = (None, None);
    }
}

/// All command buffers.
#[derive(Default)]
pub struct Recordings {
    pub(in crate::intercept::vk) all: RwLock<HashMap<vk::CommandBuffer, Arc<Mutex<Recording>>>>,
}

impl Recordings {
    /// A command buffer.
    pub fn get(&self, buffer: vk::CommandBuffer) -> Option<Arc<Mutex<Recording>>> {
        self.all.read().unwrap_or_else(PoisonError::into_inner).get(&buffer).cloned()
    }

    /// Runs `run` with the state of a command buffer; `None` where it is not known.
    pub fn with<T>(&self, buffer: vk::CommandBuffer, run: impl FnOnce(&mut Recording) -> T) -> Option<T> {
        let recording = self.get(buffer)?;
        let mut recording = recording.lock().unwrap_or_else(PoisonError::into_inner);
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

/// Vertices that a draw is taken to have whose size only the device knows.
const UNKNOWN_SIZE: u64 = 1 << 10;

/// A draw of so many vertices is issued `times` times, where a query may run; `None`: as often as its run is in sight. `run`: the
/// index of its run, if it has rows.
pub fn drawn(recording: &mut Recording, run: Option<usize>, vertices: u32, times: Option<u32>) {
    if recording.counting == 0 {
        return;
    }
    let new = if vertices == u32::MAX { UNKNOWN_SIZE } else { vertices.into() };
    match recording.events.last_mut() {
        Some(Event::Counted { run: last, vertices, times: t }) if (*last, *t) == (run, times) => *vertices += new,
        _ => recording.events.push(Event::Counted { run, vertices: new, times }),
    }
}
