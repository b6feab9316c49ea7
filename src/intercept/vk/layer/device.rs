//! Life of a device: `vkCreateDevice`, its queues, `vkDestroyDevice`.

use crate::backend::vk::{Api, missing_of_device};
use crate::intercept::process::{clock, log, nodes, settings};
use crate::intercept::vk::layer::features::Enabled;
use crate::intercept::vk::layer::{chain_links, features, present_barrier};
use crate::intercept::vk::state::device::{DEVICES, Device, Role, get};
use crate::intercept::vk::state::driver::entry_points::NextLayer;
use crate::intercept::vk::state::driver::instance;
use crate::intercept::vk::state::driver::instance::{Instance, address, dispatch_key};
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::driver::{Driver, SetDeviceLoaderData};
use crate::intercept::vk::state::views::vertices::VertexProcessing;
use crate::intercept::vk::state::views::view_constants::ConstantPool;
use crate::lock::{Lock, SharedLock};
use crate::runtime::cache;
use ash::{ext, khr, nv, vk};
use std::collections::HashMap;
use std::ffi::CStr;
use std::sync::Arc;

/// `vkCreateDevice`. Enables only what the program asks for, and geometry shaders and their counter
/// if the rig needs them.
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
            (chain_links::take_device_link(given.p_next), instance::get(physical))
        else {
            return failed;
        };
        let create = (link.get_instance_proc_addr)(parent.functions.handle(), c"vkCreateDevice".as_ptr());
        let Some(create) = create else { return failed };
        let create: vk::PFN_vkCreateDevice = std::mem::transmute(create);
        let active = wanted(given);
        let has = || parent.functions.get_physical_device_features(physical);
        let mut enabled = features::enable(given, active, has);
        let barrier =
            (active && has_present_barrier(&parent, physical)).then(|| present_barrier::device(&mut enabled.info));
        let joins_barriers = barrier.as_ref().is_some_and(Option::is_some);
        let result = create(physical, &enabled.info, allocator, handle);
        if result == vk::Result::SUCCESS {
            let made = *handle;
            let missing = missing_of_device(|name| address((link.get_device_proc_addr)(made, name.as_ptr())));
            let active = active && missing.is_none();
            // From now on calls are summed up, if there are other machines.
            nodes::are_there();
            if let Some(name) = missing {
                log::once(&format!("Vulkan: a device's windows keep the program's own picture: there is no {name}"));
            }
            let driver = driver(&parent, physical, made, link.get_device_proc_addr, callback);
            let state = Device {
                next: NextLayer::load(&|name| (link.get_device_proc_addr)(made, name.as_ptr())),
                role: Role { joins_barriers, ..role(given, active, &enabled) },
                flatness: Default::default(),
                recordings: Default::default(),
                framebuffers: Default::default(),
                images: Default::default(),
                scene_graph: Default::default(),
                layouts: Default::default(),
                pipelines: Default::default(),
                descriptors: Default::default(),
                host_memory: Default::default(),
                view_constants: ConstantPool::new(
                    enabled.decision.vertices != VertexProcessing::Views,
                    enabled.decision.counts,
                ),
                frame: Default::default(),
                queries: Default::default(),
                swapchains: Default::default(),
                queues: Default::default(),
                presented: Default::default(),
                driver,
            };
            insert(dispatch_key(vk::Handle::as_raw(made)), state);
        }
        result
    }
}

/// Registers a device under its dispatch key.
fn insert(key: usize, device: Device) {
    let mut devices = DEVICES.writing();
    devices.get_or_insert_with(HashMap::new).insert(key, Arc::new(device));
}

/// Returns the driver's side of a new device.
///
/// # Safety
/// `made` must be a device of `physical`, and `next` the next layer's function for it.
unsafe fn driver(
    parent: &Arc<Instance>,
    physical: vk::PhysicalDevice,
    made: vk::Device,
    next: vk::PFN_vkGetDeviceProcAddr,
    set_loader_data: Option<SetDeviceLoaderData>,
) -> Driver {
    // SAFETY: as promised.
    unsafe {
        let find = |name: &CStr| address(next(made, name.as_ptr()));
        let properties = parent.functions.get_physical_device_properties(physical);
        let version = properties.api_version;
        let families = parent.functions.get_physical_device_queue_family_properties(physical);
        let functions = ash::Device::load_with(find, made);
        Driver {
            get_device_proc_addr: next,
            api: Api::new(&parent.functions, physical, &functions).with_cache(cache::of_process()),
            functions,
            instance: Arc::clone(parent),
            physical,
            limits: properties.limits,
            swapchain: khr::swapchain::DeviceFn::load(find),
            memory: parent.functions.get_physical_device_memory_properties(physical),
            name: format!(
                "Vulkan {}.{}.{}, {}",
                vk::api_version_major(version),
                vk::api_version_minor(version),
                vk::api_version_patch(version),
                properties.device_name_as_c_str().unwrap_or_default().to_string_lossy()
            ),
            families: families.iter().map(|family| family.queue_flags).collect(),
            set_loader_data,
        }
    }
}

/// Returns the tasks of Cupola on a device that the program made in this way.
///
/// # Safety
/// `given` must be the program's.
unsafe fn role(given: &vk::DeviceCreateInfo<'_>, active: bool, enabled: &Enabled<'_>) -> Role {
    Role {
        active,
        corrects: settings::settings().is_some_and(|settings| !settings.rig.passthrough),
        vertices: enabled.decision.clone(),
        counts_samples: enabled.counts_samples,
        // SAFETY: as promised.
        topologies_change: unsafe { enables(given, ext::extended_dynamic_state3::NAME) },
        joins_barriers: false,
    }
}

/// True if the rig wants a present barrier, and the device and the instance have what it needs.
///
/// # Safety
/// `physical` must be of this instance.
unsafe fn has_present_barrier(parent: &Instance, physical: vk::PhysicalDevice) -> bool {
    if !present_barrier::wanted() {
        return false;
    }
    let name = c"vkGetPhysicalDeviceSurfaceCapabilities2KHR".as_ptr();
    // SAFETY: as promised.
    let (can_ask, known) = unsafe {
        let can_ask = (parent.get_instance_proc_addr)(parent.functions.handle(), name).is_some();
        (can_ask, parent.functions.enumerate_device_extension_properties(physical).unwrap_or_default())
    };
    can_ask && known.iter().any(|known| known.extension_name_as_c_str() == Ok(nv::present_barrier::NAME))
}

/// True if Cupola has anything to do on a device.
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
        log::once(
            "Vulkan: outputs have the resolution of their rectangle in the window; CUPOLA_OFFSCREEN is for OpenGL",
        );
    }
    let is_counted = settings.frames.is_some() || clock::is_there();
    !settings.rig.passthrough || is_counted || settings.capture.is_some() || settings.stats.is_some()
}

/// True if the program enables an extension.
///
/// # Safety
/// `info` must be the program's.
unsafe fn enables(info: &vk::DeviceCreateInfo<'_>, extension: &CStr) -> bool {
    // SAFETY: the program's list of names.
    let names = unsafe { slice(info.pp_enabled_extension_names, info.enabled_extension_count) };
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
    let state = DEVICES.writing().as_mut().and_then(|all| all.remove(&key));
    if let Some(state) = state {
        // The device has finished everything, including the last frames.
        crate::intercept::vk::swapchain::present::count_again(&state);
        state.pipelines.clear(&state);
        state.descriptors.clear(&state);
        state.images.clear(&state);
        state.layouts.clear();
        state.queries.clear(&state);
        state.view_constants.destroy(&state.driver);
        // SAFETY: the program's own call with its arguments.
        unsafe { (state.driver.functions.fp_v1_0().destroy_device)(handle, allocator) };
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
        (state.driver.functions.fp_v1_0().get_device_queue)(handle, family, index, queue);
        state.queues.locked().insert(*queue, family);
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
        (state.driver.functions.fp_v1_1().get_device_queue2)(handle, info, queue);
        if *queue != vk::Queue::null() {
            let family = (*info).queue_family_index;
            state.queues.locked().insert(*queue, family);
        }
    }
}
