//! Command buffers of the program: their state while they are recorded, and what has to be known of them when
//! they are submitted.

use crate::intercept::vk::commands::compute_state::Compute;
use crate::intercept::vk::commands::conditional_render::Condition;
use crate::intercept::vk::descriptors::push_descriptors::Pushed;
use crate::intercept::vk::layer::device::Device;
use crate::intercept::vk::layer::hooks::hooks;
use crate::intercept::vk::layer::pnext::in_chain;
use crate::intercept::vk::offscreen::images::Shown;
use crate::intercept::vk::pipelines::program_pipelines::Pipeline;
use crate::intercept::vk::queries::scaling::Pool;
use crate::intercept::vk::submit::draw_groups::{Run, Source};
use crate::intercept::vk::submit::view_constants::Taken;
use ash::vk;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

/// Bytes of push constants that are looked at; no device of today has more.
pub const PUSH_BYTES: usize = 256;

/// A descriptor set that the program bound.
#[derive(Clone, Default)]
pub struct Bound {
    /// The set.
    pub set: vk::DescriptorSet,
    /// Its dynamic offsets.
    pub dynamic: Vec<u32>,
    /// In its place: what was pushed.
    pub pushed: Option<Pushed>,
}

impl Bound {
    /// The buffer of a binding, and where it begins.
    pub fn buffer(&self, device: &Device, binding: u32) -> Option<(vk::Buffer, u64)> {
        match &self.pushed {
            Some(pushed) => pushed.buffer(binding),
            None => device.descriptors.buffer(self.set, &self.dynamic, binding),
        }
    }
}

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
    pub shown: Arc<Shown>,
    /// A draw of it may have belonged to the scene.
    pub scene: bool,
    /// Colour attachments whose panel has to be cleared by the first commands.
    pub unclear: Vec<u32>,
    /// How the pass was begun.
    pub within: Within,
    /// Scenes that it draws, and the layouts that it leaves them in.
    pub scenes: Vec<(Arc<Shown>, vk::ImageLayout)>,
    /// Images of the program that this pass would have brought into a layout.
    pub settled: Vec<Settled>,
}

/// An image of the program that has to be brought into a layout.
#[derive(Clone, Copy, Debug)]
pub struct Settled {
    /// The image.
    pub image: vk::Image,
    /// What it has.
    pub aspects: vk::ImageAspectFlags,
    /// The layout.
    pub layout: vk::ImageLayout,
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
    pub pool: vk::CommandPool,
    /// The bound graphics pipeline.
    pub pipeline: Option<Arc<Pipeline>>,
    /// The pipeline that is bound on the device: it, or a variant of it.
    pub current: vk::Pipeline,
    /// What is bound for compute shaders.
    pub compute: Compute,
    /// Descriptor sets for graphics.
    pub bound: Vec<Option<Bound>>,
    /// From this number on, sets that the program bound are not bound any more.
    pub displaced: Option<u32>,
    /// Push constants.
    pub push: [u8; PUSH_BYTES],
    /// The viewport that the program set.
    pub viewport: Option<vk::Viewport>,
    /// The scissor that the program set.
    pub scissor: Option<vk::Rect2D>,
    /// The device's viewport and scissor are not the program's.
    pub disturbed: bool,
    /// The pass, if it is drawn for each view.
    pub pass: Option<Pass>,
    /// Within a pass that is not: its images that may hold a scene.
    pub plain: Option<Vec<vk::Image>>,
    /// What happens when it runs.
    pub events: Vec<Event>,
    /// Its runs of draws.
    pub runs: Vec<Run>,
    /// Memory of their rows.
    pub rows: Taken,
    /// Command buffers of ours that clear the panel where the program's pass has none but secondary ones.
    pub clearers: Vec<vk::CommandBuffer>,
    /// Scenes whose prints its draws sample.
    pub sampled: Vec<Arc<Shown>>,
    /// The condition that the program has set outside of passes.
    pub condition: Option<Condition>,
    /// How many queries may count what is drawn now.
    pub counting: u32,
}

impl Recording {
    fn new(pool: vk::CommandPool) -> Self {
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
    fn begin(&mut self, device: &Device) {
        device.rows.give_back(&mut self.rows);
        if !self.clearers.is_empty() {
            // SAFETY: of the pool that the program uses now; nothing runs that executes them.
            unsafe { device.functions.free_command_buffers(self.pool, &self.clearers) };
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
    all: RwLock<HashMap<vk::CommandBuffer, Arc<Mutex<Recording>>>>,
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

    /// Command buffers are gone; `of` says which.
    fn forget(&self, device: &Device, of: impl Fn(vk::CommandBuffer, &Recording) -> bool) {
        let known: Vec<_> = {
            let all = self.all.read().unwrap_or_else(PoisonError::into_inner);
            all.iter().map(|(handle, recording)| (*handle, Arc::clone(recording))).collect()
        };
        for (handle, recording) in known {
            let mut state = recording.lock().unwrap_or_else(PoisonError::into_inner);
            if of(handle, &state) {
                device.rows.give_back(&mut state.rows);
                self.all.write().unwrap_or_else(PoisonError::into_inner).remove(&handle);
            }
        }
    }
}

/// What a secondary command buffer will be executed in, as far as it says.
///
/// # Safety
/// `info` must be the program's.
unsafe fn inherited(device: &Device, info: &vk::CommandBufferBeginInfo<'_>) -> Option<Arc<Shown>> {
    if !info.flags.contains(vk::CommandBufferUsageFlags::RENDER_PASS_CONTINUE) || !device.draws_views() {
        return None;
    }
    // SAFETY: as promised.
    unsafe {
        let inheritance = info.p_inheritance_info.as_ref()?;
        if let Some(framebuffer) = device.framebuffers.get(inheritance.framebuffer) {
            return framebuffer.shown_now(device);
        }
        if inheritance.render_pass != vk::RenderPass::null() {
            let framebuffers = &device.framebuffers;
            let shown = framebuffers.shown_by(device, inheritance.render_pass);
            return shown.or_else(|| framebuffers.shown_later(device, inheritance.render_pass));
        }
        let rendering = vk::StructureType::COMMAND_BUFFER_INHERITANCE_RENDERING_INFO;
        let rendering = in_chain::<vk::CommandBufferInheritanceRenderingInfo<'_>>(inheritance.p_next, rendering)?;
        let formats =
            crate::intercept::vk::slice(rendering.p_color_attachment_formats, rendering.color_attachment_count);
        device.latest_shown(*formats.first()?)
    }
}

/// The images that may hold a scene among what a secondary command buffer draws to, where it names its framebuffer.
///
/// # Safety
/// `info` must be the program's.
unsafe fn candidates(device: &Device, info: &vk::CommandBufferBeginInfo<'_>) -> Option<Vec<vk::Image>> {
    if !info.flags.contains(vk::CommandBufferUsageFlags::RENDER_PASS_CONTINUE) || !device.images.has_candidates() {
        return None;
    }
    // SAFETY: as promised.
    let inheritance = unsafe { info.p_inheritance_info.as_ref() }?;
    let framebuffer = device.framebuffers.get(inheritance.framebuffer)?;
    let views = framebuffer.attachments.iter().flatten();
    Some(views.filter_map(|view| device.images.candidate_of(*view)).collect())
}

/// Whether queries of the command buffer that executes it may count what a secondary one draws.
///
/// # Safety
/// `info` must be the program's.
unsafe fn inherits_queries(info: &vk::CommandBufferBeginInfo<'_>) -> bool {
    // SAFETY: as promised.
    let inheritance = unsafe { info.p_inheritance_info.as_ref() };
    let counts = |inheritance: &vk::CommandBufferInheritanceInfo<'_>| {
        inheritance.occlusion_query_enable != vk::FALSE || !inheritance.pipeline_statistics.is_empty()
    };
    info.flags.contains(vk::CommandBufferUsageFlags::RENDER_PASS_CONTINUE) && inheritance.is_some_and(counts)
}

hooks! { recording;
    [c"vkAllocateCommandBuffers"] allocate_command_buffers: vk::PFN_vkAllocateCommandBuffers = (
        device: vk::Device, info: *const vk::CommandBufferAllocateInfo<'_>, buffers: *mut vk::CommandBuffer
    ) -> vk::Result { |state, next| {
        let result = next(device, info, buffers);
        if result == vk::Result::SUCCESS {
            let mut all = state.recordings.all.write().unwrap_or_else(PoisonError::into_inner);
            for buffer in crate::intercept::vk::slice(buffers, (*info).command_buffer_count) {
                all.insert(*buffer, Arc::new(Mutex::new(Recording::new((*info).command_pool))));
            }
        }
        result
    } }
    [c"vkFreeCommandBuffers"] free_command_buffers: vk::PFN_vkFreeCommandBuffers = (
        device: vk::Device, pool: vk::CommandPool, count: u32, buffers: *const vk::CommandBuffer
    ) { |state, next| {
        let gone = crate::intercept::vk::slice(buffers, count);
        let of = |buffer: &vk::CommandBuffer| state.recordings.with(*buffer, |r| std::mem::take(&mut r.clearers));
        let clearers: Vec<_> = gone.iter().filter_map(of).flatten().collect();
        if !clearers.is_empty() {
            next(device, pool, clearers.len() as u32, clearers.as_ptr());
        }
        state.recordings.forget(&state, |handle, _| gone.contains(&handle));
        next(device, pool, count, buffers)
    } }
    [c"vkDestroyCommandPool"] destroy_command_pool: vk::PFN_vkDestroyCommandPool = (
        device: vk::Device, pool: vk::CommandPool, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.recordings.forget(&state, |_, recording| recording.pool == pool);
        next(device, pool, allocator)
    } }
    [c"vkBeginCommandBuffer"] begin_command_buffer: vk::PFN_vkBeginCommandBuffer = (
        buffer: vk::CommandBuffer, info: *const vk::CommandBufferBeginInfo<'_>
    ) -> vk::Result { |state, next| {
        let (shown, candidates) = (inherited(&state, &*info), candidates(&state, &*info));
        let counted = inherits_queries(&*info);
        state.recordings.with(buffer, |recording| {
            recording.begin(&state);
            recording.counting = counted.into();
            recording.plain = candidates.filter(|_| shown.is_none());
            recording.pass = shown.map(|shown| Pass::new(shown, Within::Inherited, Vec::new()));
        });
        next(buffer, info)
    } }
    [c"vkCmdExecuteCommands"] cmd_execute_commands: vk::PFN_vkCmdExecuteCommands = (
        buffer: vk::CommandBuffer, count: u32, others: *const vk::CommandBuffer
    ) { |state, next| {
        let others_list = crate::intercept::vk::slice(others, count);
        // Whether each was recorded for views.
        let kinds: Vec<_> = others_list.iter().map(|other| state.recordings.with(*other, |r| r.pass.is_some())).collect();
        let in_pass = state.recordings.with(buffer, |recording| {
            crate::intercept::vk::commands::passes::clear_by_secondary(&state, buffer, recording);
            recording.events.extend(others_list.iter().map(|other| Event::Execute(*other)));
            recording.forget_state();
            (recording.pass.is_some() || recording.plain.is_some()).then_some(recording.pass.is_some())
        });
        if let Some(Some(views)) = in_pass
            && kinds.iter().flatten().any(|kind| *kind != views)
        {
            state.give_up("its secondary command buffers do not say what they draw to");
        }
        next(buffer, count, others)
    } }
}
