//! Devices: the next layer's functions for each, its queues and swapchains.

use crate::backend::vk::Api;
use crate::intercept::vk::commands::framebuffers::Framebuffers;
use crate::intercept::vk::commands::recording::Recordings;
use crate::intercept::vk::descriptors::sets::Descriptors;
use crate::intercept::vk::layer::features::{self, Decision, Vertices};
use crate::intercept::vk::layer::instance::{self, Instance, address, dispatch_key};
use crate::intercept::vk::layer::negotiate::{self, SetDeviceLoaderData};
use crate::intercept::vk::layer::table::NextLayer;
use crate::intercept::vk::offscreen::images::{Images, Shown};
use crate::intercept::vk::offscreen::scene_graph::Paths;
use crate::intercept::vk::pipelines::layouts::Layouts;
use crate::intercept::vk::pipelines::program_pipelines::Pipelines;
use crate::intercept::vk::queries::scaling::Queries;
use crate::intercept::vk::submit::draw_groups::Frame;
use crate::intercept::vk::submit::host_memory::Memory;
use crate::intercept::vk::submit::view_constants::Rows;
use crate::intercept::vk::swapchain::atlas_layout::Layout;
use crate::intercept::vk::swapchain::create::Swapchain;
use crate::intercept::{log, settings};
use crate::runtime::cache;
use ash::prelude::VkResult;
use ash::{ext, khr, vk};
use std::collections::HashMap;
use std::ffi::CStr;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, RwLock};

/// A device of the program.
pub struct Device {
    /// The next layer's `vkGetDeviceProcAddr`.
    pub get_device_proc_addr: vk::PFN_vkGetDeviceProcAddr,
    /// The next layer's functions.
    pub functions: ash::Device,
    /// Those of `VK_KHR_swapchain`; they may be called only where the program enabled it.
    pub swapchain: khr::swapchain::DeviceFn,
    /// The same for the correction.
    pub api: Api,
    /// The instance, for questions about surfaces.
    pub instance: Arc<Instance>,
    /// The device that it was made from.
    pub physical: vk::PhysicalDevice,
    /// The device's limits.
    pub limits: vk::PhysicalDeviceLimits,
    /// Kinds of memory.
    pub memory: vk::PhysicalDeviceMemoryProperties,
    /// Name of the driver's device and its version, for the statistics.
    pub driver: String,
    /// Cupola has something to do here.
    pub active: bool,
    /// It corrects pictures, and does not only count and capture.
    pub corrects: bool,
    /// The next layer's functions that hooks for the views call.
    pub next: NextLayer,
    /// Command buffers.
    pub recordings: Recordings,
    /// Images.
    pub images: Images,
    /// Render passes and framebuffers.
    pub framebuffers: Framebuffers,
    /// Shaders and pipeline layouts.
    pub layouts: Layouts,
    /// Pipelines.
    pub pipelines: Pipelines,
    /// Descriptor sets.
    pub descriptors: Descriptors,
    /// Buffers and memory.
    pub memory_of_program: Memory,
    /// Queries that count.
    pub queries: Queries,
    /// What is done with vertices.
    pub vertices: Decision,
    /// Commands may change the class of what a pipeline draws.
    pub topologies_change: bool,
    /// Memory for rows.
    pub rows: Rows,
    /// Which images hold a scene on its way to the window.
    pub paths: Paths,
    /// The frame that is being submitted.
    pub frame: Mutex<Frame>,
    /// The image of a swapchain that was made last.
    pub latest: Mutex<Option<(vk::Format, Arc<Shown>)>>,
    /// Why draws are not issued for each view; `None` as long as they are.
    flat: OnceLock<String>,
    /// Why some pipeline has no variants.
    pipeline_obstacle: OnceLock<String>,
    /// What each queue family can do.
    pub families: Vec<vk::QueueFlags>,
    /// The family of each queue that the program asked for.
    pub queues: Mutex<HashMap<vk::Queue, u32>>,
    /// The swapchains that Cupola looks after.
    pub swapchains: Mutex<HashMap<vk::SwapchainKHR, Arc<Mutex<Swapchain>>>>,
    /// Frames presented.
    pub frames: std::sync::atomic::AtomicU64,
    /// What was kept last of its frames.
    pub kept: std::sync::atomic::AtomicU64,
    set_loader_data: Option<SetDeviceLoaderData>,
}

static DEVICES: RwLock<Option<HashMap<usize, Arc<Device>>>> = RwLock::new(None);

/// The device that a device, queue or command buffer belongs to.
pub fn get(handle: impl vk::Handle) -> Option<Arc<Device>> {
    let object = handle.as_raw();
    if object == 0 {
        return None;
    }
    // SAFETY: the program passed a live handle to Vulkan.
    let key = unsafe { dispatch_key(object) };
    DEVICES.read().unwrap_or_else(PoisonError::into_inner).as_ref()?.get(&key).cloned()
}

impl Device {
    /// A primary command buffer of ours, one that layers below can dispatch.
    ///
    /// # Errors
    /// The driver's.
    ///
    /// # Safety
    /// The pool must be one of ours, in use by no other thread.
    pub unsafe fn command_buffer(&self, pool: vk::CommandPool) -> VkResult<vk::CommandBuffer> {
        // SAFETY: as promised.
        unsafe { self.allocate(pool, vk::CommandBufferLevel::PRIMARY) }
    }

    /// A secondary one.
    ///
    /// # Errors
    /// The driver's.
    ///
    /// # Safety
    /// The pool must be in use by no other thread.
    pub unsafe fn secondary_command_buffer(&self, pool: vk::CommandPool) -> VkResult<vk::CommandBuffer> {
        // SAFETY: as promised.
        unsafe { self.allocate(pool, vk::CommandBufferLevel::SECONDARY) }
    }

    /// # Safety
    /// The pool must be in use by no other thread.
    unsafe fn allocate(&self, pool: vk::CommandPool, level: vk::CommandBufferLevel) -> VkResult<vk::CommandBuffer> {
        let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).level(level).command_buffer_count(1);
        // SAFETY: as promised; the loader's own function, for an object of its device.
        unsafe {
            let buffer = self.functions.allocate_command_buffers(&info)?.first().copied().unwrap_or_default();
            let set = self.set_loader_data.ok_or(vk::Result::ERROR_INITIALIZATION_FAILED)?;
            set(self.functions.handle(), vk::Handle::as_raw(buffer) as *mut _).result()?;
            Ok(buffer)
        }
    }

    /// Greatest width and height of an image that can be drawn to.
    pub fn greatest_image(&self) -> u32 {
        let limits = &self.limits;
        limits.max_image_dimension2_d.min(limits.max_framebuffer_width).min(limits.max_framebuffer_height)
    }

    /// From one group of rows to the next, bytes.
    pub fn group_stride(&self) -> u32 {
        (self.rows.group() as u32).max(self.limits.min_uniform_buffer_offset_alignment.min(1 << 12) as u32)
    }

    /// Whether primitives are divided where the rig says so.
    pub fn divides(&self) -> bool {
        self.vertices.vertices == Vertices::Divided
    }

    /// Whether draws are issued for each view.
    pub fn draws_views(&self) -> bool {
        self.flat.get().is_none()
    }

    /// From now on the program's picture is shown flat; the log says why.
    pub fn give_up(&self, why: &str) {
        if self.flat.set(why.to_owned()).is_ok() {
            log::once(&self.flat_note().unwrap_or_default());
        }
    }

    /// What the log and the statistics say of a program that is shown flat.
    pub fn flat_note(&self) -> Option<String> {
        let why = self.flat.get()?;
        Some(format!(
            "Vulkan: the program's picture is shown flat, on the panel; its draws are not issued for each view: {why}"
        ))
    }

    /// A pipeline has no variants; that matters when it draws to a window.
    pub fn note_pipeline(&self, why: &str) {
        let _ = self.pipeline_obstacle.set(why.to_owned());
    }

    /// Why some pipeline has no variants.
    pub fn pipeline_obstacle(&self) -> String {
        self.pipeline_obstacle.get().cloned().unwrap_or_else(|| "a pipeline that is not known".to_owned())
    }

    /// The swapchain's image that was made last, if it has this format.
    pub fn latest_shown(&self, format: vk::Format) -> Option<Arc<Shown>> {
        let latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        latest.as_ref().filter(|(known, _)| *known == format).map(|(_, shown)| Arc::clone(shown))
    }

    /// The layout of the latest swapchain.
    pub fn latest_layout(&self) -> Option<Arc<Layout>> {
        let latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        latest.as_ref().map(|(_, shown)| Arc::clone(&shown.layout))
    }

    /// The layout of the latest swapchain, if it serves a window of this size.
    pub fn layout(&self, size: (u32, u32), read: bool) -> Option<Arc<Layout>> {
        self.latest_layout().filter(|layout| (layout.window, layout.read) == (size, read))
    }

    /// An image of a swapchain is gone.
    pub fn forget_shown(&self, gone: &Arc<Shown>) {
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        if latest.as_ref().is_some_and(|(_, shown)| Arc::ptr_eq(shown, gone)) {
            *latest = None;
        }
    }

    /// The swapchain, if Cupola looks after it.
    pub fn managed(&self, handle: vk::SwapchainKHR) -> Option<Arc<Mutex<Swapchain>>> {
        self.swapchains.lock().unwrap_or_else(PoisonError::into_inner).get(&handle).cloned()
    }

    /// The kind of memory among `allowed` with all of `wanted`.
    pub fn memory_type(&self, allowed: u32, wanted: vk::MemoryPropertyFlags) -> Option<u32> {
        let kinds = self.memory.memory_types_as_slice().iter().enumerate();
        let mut fitting =
            kinds.filter(|(index, kind)| allowed & (1 << index) != 0 && kind.property_flags.contains(wanted));
        fitting.next().map(|(index, _)| index as u32)
    }
}

/// `vkCreateDevice`. Nothing is enabled that the program did not ask for, but geometry shaders, and what they
/// count by, where the rig needs them.
///
/// # Safety
/// Called by the Vulkan loader with the program's arguments.
pub unsafe extern "system" fn create(
    physical: vk::PhysicalDevice,
    info: *const vk::DeviceCreateInfo<'_>,
    allocator: *const vk::AllocationCallbacks<'_>,
    handle: *mut vk::Device,
) -> vk::Result {
    // SAFETY: the loader's chain, and the program's own call with its arguments.
    unsafe {
        let failed = vk::Result::ERROR_INITIALIZATION_FAILED;
        let Some(given) = info.as_ref() else { return failed };
        let (Some((link, callback)), Some(parent)) =
            (negotiate::take_device_link(given.p_next), instance::get(physical))
        else {
            return failed;
        };
        let create = (link.get_instance_proc_addr)(parent.functions.handle(), c"vkCreateDevice".as_ptr());
        let Some(create) = create else { return failed };
        let create: vk::PFN_vkCreateDevice = std::mem::transmute(create);
        let active = wanted(given);
        let has = || parent.functions.get_physical_device_features(physical);
        let enabled = features::enable(given, active, has);
        let result = create(physical, &enabled.info, allocator, handle);
        if result == vk::Result::SUCCESS {
            let made = *handle;
            let next = link.get_device_proc_addr;
            let find = |name: &CStr| address(next(made, name.as_ptr()));
            let properties = parent.functions.get_physical_device_properties(physical);
            let version = properties.api_version;
            let families = parent.functions.get_physical_device_queue_family_properties(physical);
            let functions = ash::Device::load_with(find, made);
            let limits = &properties.limits;
            let state = Device {
                get_device_proc_addr: next,
                api: Api::new(&parent.functions, physical, &functions).with_cache(cache::of_process()),
                functions,
                instance: Arc::clone(&parent),
                physical,
                limits: *limits,
                next: NextLayer::load(&|name| next(made, name.as_ptr())),
                recordings: Recordings::default(),
                images: Images::default(),
                framebuffers: Framebuffers::default(),
                layouts: Layouts::default(),
                pipelines: Pipelines::default(),
                descriptors: Descriptors::default(),
                memory_of_program: Memory::default(),
                queries: Queries::default(),
                vertices: enabled.decision,
                topologies_change: enables(given, ext::extended_dynamic_state3::NAME),
                rows: Rows::new(enabled.decision.vertices != Vertices::Views, enabled.decision.counts),
                paths: Paths::default(),
                frame: Mutex::default(),
                latest: Mutex::default(),
                flat: OnceLock::new(),
                pipeline_obstacle: OnceLock::new(),
                swapchain: khr::swapchain::DeviceFn::load(find),
                memory: parent.functions.get_physical_device_memory_properties(physical),
                driver: format!(
                    "Vulkan {}.{}.{}, {}",
                    vk::api_version_major(version),
                    vk::api_version_minor(version),
                    vk::api_version_patch(version),
                    properties.device_name_as_c_str().unwrap_or_default().to_string_lossy()
                ),
                active,
                corrects: settings::settings().is_some_and(|settings| !settings.rig.passthrough),
                families: families.iter().map(|family| family.queue_flags).collect(),
                queues: Mutex::default(),
                swapchains: Mutex::default(),
                frames: 0.into(),
                kept: 0.into(),
                set_loader_data: callback,
            };
            let key = dispatch_key(vk::Handle::as_raw(made));
            let mut devices = DEVICES.write().unwrap_or_else(PoisonError::into_inner);
            devices.get_or_insert_with(HashMap::new).insert(key, Arc::new(state));
        }
        result
    }
}

/// Whether there is anything to do on a device.
///
/// # Safety
/// `info` must be the program's.
unsafe fn wanted(info: &vk::DeviceCreateInfo<'_>) -> bool {
    // SAFETY: as promised.
    let presents = unsafe { enables(info, khr::swapchain::NAME) };
    if settings::switched_off() || !presents {
        return false;
    }
    let Some(settings) = settings::settings() else { return false };
    if settings.offscreen {
        log::once("Vulkan: outputs have the resolution of their place in the window; CUPOLA_OFFSCREEN is for OpenGL");
    }
    !settings.rig.passthrough || settings.frames.is_some() || settings.capture.is_some() || settings.stats.is_some()
}

/// Whether the program enables an extension.
///
/// # Safety
/// `info` must be the program's.
unsafe fn enables(info: &vk::DeviceCreateInfo<'_>, extension: &CStr) -> bool {
    // SAFETY: the program's list of names.
    let names = unsafe { crate::intercept::vk::slice(info.pp_enabled_extension_names, info.enabled_extension_count) };
    // SAFETY: as above.
    names.iter().any(|name| unsafe { CStr::from_ptr(*name) } == extension)
}

/// `vkDestroyDevice`.
///
/// # Safety
/// Called by the program.
pub unsafe extern "system" fn destroy(handle: vk::Device, allocator: *const vk::AllocationCallbacks<'_>) {
    if handle == vk::Device::null() {
        return;
    }
    // SAFETY: a live handle.
    let key = unsafe { dispatch_key(vk::Handle::as_raw(handle)) };
    let state = DEVICES.write().unwrap_or_else(PoisonError::into_inner).as_mut().and_then(|all| all.remove(&key));
    if let Some(state) = state {
        // All is done now, the last frames too.
        crate::intercept::vk::swapchain::present::count_again(&state);
        state.pipelines.clear(&state);
        state.descriptors.clear(&state);
        state.images.clear(&state);
        state.layouts.clear();
        state.queries.clear(&state);
        state.rows.destroy(&state);
        // SAFETY: the program's own call with its arguments.
        unsafe { (state.functions.fp_v1_0().destroy_device)(handle, allocator) };
    }
}

/// `vkGetDeviceQueue`.
///
/// # Safety
/// Called by the program.
pub unsafe extern "system" fn queue(handle: vk::Device, family: u32, index: u32, queue: *mut vk::Queue) {
    let Some(state) = get(handle) else { return };
    // SAFETY: the program's own call with its arguments.
    unsafe {
        (state.functions.fp_v1_0().get_device_queue)(handle, family, index, queue);
        state.queues.lock().unwrap_or_else(PoisonError::into_inner).insert(*queue, family);
    }
}

/// `vkGetDeviceQueue2`.
///
/// # Safety
/// Called by the program.
pub unsafe extern "system" fn queue2(handle: vk::Device, info: *const vk::DeviceQueueInfo2<'_>, queue: *mut vk::Queue) {
    let Some(state) = get(handle) else { return };
    // SAFETY: the program's own call with its arguments.
    unsafe {
        (state.functions.fp_v1_1().get_device_queue2)(handle, info, queue);
        if *queue != vk::Queue::null() {
            let family = (*info).queue_family_index;
            state.queues.lock().unwrap_or_else(PoisonError::into_inner).insert(*queue, family);
        }
    }
}
