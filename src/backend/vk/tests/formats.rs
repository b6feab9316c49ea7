//! Devices that cannot filter textures of 16 bits, which Vulkan allows.

use super::headless;
use crate::backend::tests::Driver;
use crate::backend::tests::picture::Picture;
use crate::backend::tests::plans::fisheye_plan;
use crate::backend::vk::driver::api::Api;
use crate::correct::BlackPicture;
use crate::correct::Mask;
use ash::vk;
use glam::DVec3;
use std::ffi::{CStr, c_void};
use std::sync::OnceLock;

static OWN: OnceLock<vk::PFN_vkGetPhysicalDeviceFormatProperties> = OnceLock::new();

/// Answers as the driver does, but reports no features of formats with 16 bits.
unsafe extern "system" fn without_16_bits(
    device: vk::PhysicalDevice,
    format: vk::Format,
    properties: *mut vk::FormatProperties,
) {
    let Some(own) = OWN.get() else { return };
    // SAFETY: the arguments are the caller's.
    unsafe { own(device, format, properties) };
    if [vk::Format::R16_UNORM, vk::Format::R16G16B16A16_UNORM].contains(&format) {
        // SAFETY: the caller's structure, which the driver has just filled.
        unsafe { (*properties).optimal_tiling_features = vk::FormatFeatureFlags::empty() };
    }
}

/// Masks and pictures of black then have 8 bits. Values that 8 bits can represent are shown as with
/// 16.
#[test]
fn masks_and_blacks_have_8_bits_where_textures_of_16_cannot_be_filtered() {
    let mut headless = headless();
    let size = (200, 160);
    let mut plan = fisheye_plan(size, 3.0, DVec3::ZERO);
    let count = size.0 * size.1;
    // Codes of 8 bits, written with 16.
    let code = |code: u32| (code % 256 * 257) as u16;
    let weights = (0..count).map(|i| code(i * 37)).collect();
    let codes = (0..count).map(|i| [code(i * 5), code(i * 3 % 90), code(i / 200), u16::MAX]).collect();
    plan.passes[0].gamma = 1.8;
    plan.passes[0].mask = Some(Mask { width: size.0, height: size.1, weights });
    plan.passes[0].black = Some(BlackPicture { width: size.0, height: size.1, codes });
    let atlas = Picture::new(plan.views.atlas, |_, _| [255, 128, 64, 255]);
    let expected = headless.show(&plan, false, &atlas);

    // Less than half a code of 8 bits more.
    let mut finer = plan.clone();
    let black = finer.passes[0].black.as_mut().expect("there is one");
    black.codes.iter_mut().for_each(|codes| codes[0] = codes[0].saturating_add(100));
    assert!(headless.show(&finer, false, &atlas).pixels != expected.pixels, "16 bits were not used");

    let get = headless.get_instance_proc_addr();
    let instance = headless.api.instance().handle();
    let own = |name: &CStr| {
        // SAFETY: the instance is live.
        let found = unsafe { get(instance, name.as_ptr()) };
        found.map_or(std::ptr::null(), |function| function as *const c_void)
    };
    let name = c"vkGetPhysicalDeviceFormatProperties";
    // SAFETY: the name's type is that of the Vulkan specification.
    OWN.get_or_init(|| unsafe { std::mem::transmute(own(name)) });
    let find = |wanted: &CStr| match wanted == name {
        true => without_16_bits as vk::PFN_vkGetPhysicalDeviceFormatProperties as usize as *const c_void,
        false => own(wanted),
    };
    // SAFETY: each function has the type of the function that it replaces.
    let table = unsafe { ash::Instance::load_with(find, instance) };
    headless.api = Api::new(&table, headless.api.physical_device(), headless.api.device());
    let shown = headless.show(&plan, false, &atlas);
    let channels = shown.pixels.as_flattened().iter().zip(expected.pixels.as_flattened());
    assert!(channels.map(|(a, b)| a.abs_diff(*b)).max() <= Some(1));
    assert!(headless.show(&finer, false, &atlas).pixels == shown.pixels, "8 bits were not used");
}
