//! `VK_NV_present_barrier`: what an instance and a device need so that windows can join a barrier.
//!
//! Windows that have joined are presented at one time, also by several cards and machines. An
//! extension can be enabled only when an instance or a device is made, so nothing is enabled unless
//! the rig has a swap group by then.

use crate::intercept::process::live;
use ash::{khr, nv, vk};
use std::ffi::{CStr, c_char};

/// A list of extensions that ends with one more.
type Names = Vec<*const c_char>;

/// Returns true if windows of the rig join a swap group.
pub fn wanted() -> bool {
    live::rig().is_some_and(|live| live.rig.window.group.is_some())
}

/// Returns the program's structure with the extension that tells whether a surface can join.
/// `None`: the program enables it, or draws to no surface. The list must outlive the structure.
///
/// # Safety
/// `given` must be the program's.
pub unsafe fn instance<'a>(given: &vk::InstanceCreateInfo<'a>) -> Option<(vk::InstanceCreateInfo<'a>, Names)> {
    // SAFETY: the program's list.
    let names = unsafe { list(given.pp_enabled_extension_names, given.enabled_extension_count) };
    if !has(&names, khr::surface::NAME) {
        return None;
    }
    let names = with(names, khr::get_surface_capabilities2::NAME)?;
    let mut info = *given;
    (info.pp_enabled_extension_names, info.enabled_extension_count) = (names.as_ptr(), names.len() as u32);
    Some((info, names))
}

/// What a device's structure points at if the barrier is enabled.
pub struct Enabled {
    _names: Names,
    _features: Box<vk::PhysicalDevicePresentBarrierFeaturesNV<'static>>,
}

/// Enables the barrier in `info`. `None` if the program has enabled the extension, and then joins by
/// itself. Vulkan requires the feature of every device with the extension.
///
/// # Safety
/// `info` must be a copy of the program's. The result must outlive it.
pub unsafe fn device(info: &mut vk::DeviceCreateInfo<'_>) -> Option<Enabled> {
    // SAFETY: the program's list.
    let names = unsafe { list(info.pp_enabled_extension_names, info.enabled_extension_count) };
    let names = with(names, nv::present_barrier::NAME)?;
    let mut features = Box::new(vk::PhysicalDevicePresentBarrierFeaturesNV::default().present_barrier(true));
    features.p_next = info.p_next.cast_mut();
    info.p_next = (&raw const *features).cast();
    (info.pp_enabled_extension_names, info.enabled_extension_count) = (names.as_ptr(), names.len() as u32);
    Some(Enabled { _names: names, _features: features })
}

/// Copies a list of names.
///
/// # Safety
/// `names` must point at `count` names that live as long as the copy is used.
unsafe fn list(names: *const *const c_char, count: u32) -> Names {
    // SAFETY: as promised.
    unsafe { crate::intercept::vk::state::driver::structures::slice(names, count) }.to_vec()
}

fn has(names: &Names, name: &CStr) -> bool {
    // SAFETY: names of a list that the program or Vulkan has ended with a zero.
    names.iter().any(|known| unsafe { CStr::from_ptr(*known) } == name)
}

/// Returns the list with one name more; `None` if it has this name.
fn with(mut names: Names, name: &'static CStr) -> Option<Names> {
    if has(&names, name) {
        return None;
    }
    names.push(name.as_ptr());
    Some(names)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intercept::vk::state::driver::structures::in_chain;

    /// Extensions of a structure after `change`.
    fn names(pointer: *const *const c_char, count: u32) -> Vec<&'static CStr> {
        // SAFETY: lists of these tests, whose names are constants.
        unsafe { list(pointer, count).iter().map(|name| CStr::from_ptr(*name)).collect() }
    }

    #[test]
    fn an_instance_with_surfaces_can_ask_for_more() {
        let own = [khr::surface::NAME.as_ptr()];
        let given = vk::InstanceCreateInfo::default().enabled_extension_names(&own);
        // SAFETY: structures of this test.
        let (info, list) = unsafe { instance(&given) }.expect("the program did not enable it");
        let expected = [khr::surface::NAME, khr::get_surface_capabilities2::NAME];
        assert_eq!(names(info.pp_enabled_extension_names, info.enabled_extension_count), expected);
        // SAFETY: as above.
        assert!(unsafe { instance(&info) }.is_none(), "it is not enabled twice");
        drop(list);
        // SAFETY: as above.
        assert!(unsafe { instance(&vk::InstanceCreateInfo::default()) }.is_none(), "there are no surfaces");
    }

    #[test]
    fn a_device_gets_the_extension_and_its_feature_beside_its_own() {
        let own = [khr::swapchain::NAME.as_ptr()];
        let mut chained = vk::PhysicalDeviceVulkan12Features::default();
        let given = vk::DeviceCreateInfo::default().enabled_extension_names(&own).push_next(&mut chained);
        let mut info = given;
        // SAFETY: structures of this test.
        let enabled = unsafe { device(&mut info) }.expect("the program did not enable it");
        let expected = [khr::swapchain::NAME, nv::present_barrier::NAME];
        assert_eq!(names(info.pp_enabled_extension_names, info.enabled_extension_count), expected);
        let kind = vk::StructureType::PHYSICAL_DEVICE_PRESENT_BARRIER_FEATURES_NV;
        // SAFETY: as above.
        let features = unsafe { in_chain::<vk::PhysicalDevicePresentBarrierFeaturesNV<'_>>(info.p_next, kind) };
        assert_eq!(features.map(|features| features.present_barrier), Some(vk::TRUE));
        assert_eq!(features.map(|features| features.p_next.cast_const()), Some(given.p_next));
        // SAFETY: as above.
        assert!(unsafe { device(&mut info) }.is_none(), "it is not enabled twice");
        drop(enabled);
    }
}
