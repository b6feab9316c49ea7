//! The interface as C calls it: its answers to wrong arguments, on any Vulkan driver.

use super::images::*;
use super::*;
use crate::backend::vk::ash::vk;
use crate::backend::vk::driver::headless::Headless;
use crate::ffi::cupola_last_error;
use crate::ffi::rig::{cupola_rig_free, cupola_rig_load};
use cupola_status::*;
use std::ffi::c_char;
use std::ptr::{null, null_mut};

fn headless() -> Headless {
    Headless::new(&[]).expect("a Vulkan driver (Mesa's lavapipe will do)")
}

fn options(headless: &Headless) -> cupola_vk_options {
    cupola_vk_options {
        struct_size: size_of::<cupola_vk_options>(),
        get_instance_proc_addr: Some(headless.get_instance_proc_addr()),
        instance: headless.api.instance().handle(),
        physical_device: headless.api.physical_device(),
        device: headless.api.device().handle(),
        queue_family: headless.queue_family(),
        frames_in_flight: 2,
        width: 64,
        height: 48,
        target_format: VkFormat::R8G8B8A8_UNORM,
        view_format: VkFormat::R8G8B8A8_UNORM,
        arrangement: CUPOLA_VK_ATLAS,
        reversed_depth: 0,
    }
}

fn rig(name: &std::ffi::CStr) -> *mut cupola_rig {
    let mut rig = null_mut();
    // SAFETY: a NUL-terminated name, a writable place.
    assert_eq!(unsafe { cupola_rig_load(name.as_ptr(), &mut rig) }, CUPOLA_OK);
    rig
}

/// Checks the status and the message.
fn refused(found: cupola_status, expected: cupola_status, word: &str) {
    let mut text = [0u8; 1024];
    // SAFETY: there is room for that number of bytes.
    unsafe { cupola_last_error(text.as_mut_ptr().cast(), text.len(), null_mut()) };
    let text = String::from_utf8_lossy(&text);
    assert!(found == expected && text.contains(word), "{found:?}, not {expected:?} with \"{word}\": {text}");
}

unsafe extern "system" fn finds_nothing(_: vk::Instance, _: *const c_char) -> vk::PFN_vkVoidFunction {
    None
}

#[test]
fn what_nothing_can_be_made_from_is_refused() {
    let headless = headless();
    let rig = rig(c"fisheye");
    let mut made = null_mut();
    let mut create = |change: &dyn Fn(&mut cupola_vk_options)| {
        let mut options = options(&headless);
        change(&mut options);
        // SAFETY: live handles, or wrong ones that are checked before they are used.
        let status = unsafe { cupola_vk_create(rig, &options, &mut made) };
        assert!(made.is_null(), "outputs are written only on success");
        status
    };
    let wrong = CUPOLA_INVALID_ARGUMENT;
    refused(create(&|o| o.struct_size -= 1), wrong, "options.struct_size");
    refused(create(&|o| o.get_instance_proc_addr = None), wrong, "get_instance_proc_addr");
    refused(create(&|o| o.get_instance_proc_addr = Some(finds_nothing)), CUPOLA_GRAPHICS, "vk");
    refused(create(&|o| o.instance = VkInstance::null()), wrong, "`instance`");
    refused(create(&|o| o.physical_device = VkPhysicalDevice::null()), wrong, "`physical_device`");
    refused(create(&|o| o.device = VkDevice::null()), wrong, "`device`");
    refused(create(&|o| o.queue_family = 77), wrong, "queue family 77");
    refused(create(&|o| o.frames_in_flight = 0), wrong, "1 to 16");
    refused(create(&|o| o.frames_in_flight = 17), wrong, "1 to 16");
    refused(create(&|o| o.width = 0), wrong, "0 × 48");
    refused(create(&|o| o.height = 16385), wrong, "16384");
    refused(create(&|o| o.arrangement = 3), wrong, "arrangement");
    refused(create(&|o| o.target_format = VkFormat::UNDEFINED), CUPOLA_GRAPHICS, "UNDEFINED");
    refused(create(&|o| o.target_format = VkFormat::BC1_RGB_UNORM_BLOCK), CUPOLA_GRAPHICS, "BC1");
    refused(create(&|o| o.target_format = VkFormat::B8G8R8A8_SRGB), wrong, "_UNORM");
    refused(create(&|o| o.target_format = VkFormat::R8G8B8A8_UINT), CUPOLA_GRAPHICS, "UINT");
    refused(create(&|o| o.view_format = VkFormat::D32_SFLOAT), CUPOLA_GRAPHICS, "D32");
    refused(create(&|o| o.view_format = VkFormat::R8G8B8A8_SRGB), wrong, "_UNORM");
    refused(create(&|o| o.view_format = VkFormat::from_raw(123_456)), CUPOLA_GRAPHICS, "123456");
    // SAFETY: as above; null where null is refused.
    unsafe {
        refused(cupola_vk_create(null(), &options(&headless), &mut made), wrong, "`rig`");
        refused(cupola_vk_create(rig, null(), &mut made), wrong, "`options`");
        refused(cupola_vk_create(rig, &options(&headless), null_mut()), wrong, "`vk`");
        cupola_rig_free(rig);
        let identity = self::rig(c"identity");
        refused(cupola_vk_create(identity, &options(&headless), &mut made), wrong, "corrects nothing");
        cupola_rig_free(identity);
        assert_eq!(cupola_vk_destroy(null_mut()), CUPOLA_OK);
    }
}

#[test]
fn views_images_and_what_is_wrong_with_them() {
    let headless = headless();
    let rig = rig(c"fisheye");
    let (mut made, wrong) = (null_mut(), CUPOLA_INVALID_ARGUMENT);
    for arrangement in [CUPOLA_VK_ATLAS, CUPOLA_VK_LAYERS, CUPOLA_VK_IMAGES] {
        let wanted = cupola_vk_options { arrangement, ..options(&headless) };
        // SAFETY: live handles and places that are large enough, except those that are checked
        // before they are used.
        unsafe {
            assert_eq!(cupola_vk_create(rig, &wanted, &mut made), CUPOLA_OK);
            let (mut views, mut images, [mut width, mut height, mut layers]) = (0, 0, [0; 3]);
            assert_eq!(cupola_vk_view_count(made, &mut views), CUPOLA_OK);
            assert_eq!(cupola_vk_image_count(made, &mut images), CUPOLA_OK);
            assert_eq!(images, if arrangement == CUPOLA_VK_IMAGES { views } else { 1 });
            refused(cupola_vk_view_count(null_mut(), &mut views), wrong, "`vk`");
            refused(cupola_vk_view_count(made, null_mut()), wrong, "`count`");
            let mut view: cupola_vk_view = std::mem::zeroed();
            refused(cupola_vk_get_view(made, 0, 0.1, 10.0, &mut view), wrong, "struct_size");
            view.struct_size = size_of::<cupola_vk_view>();
            refused(cupola_vk_get_view(made, views, 0.1, 10.0, &mut view), wrong, "no view");
            refused(cupola_vk_get_view(made, 0, 10.0, 0.1, &mut view), wrong, "near");
            refused(cupola_vk_get_view(made, 0, 0.1, 10.0, null_mut()), wrong, "`view`");
            for index in 0..views {
                assert_eq!(cupola_vk_get_view(made, index, 0.1, f64::INFINITY, &mut view), CUPOLA_OK);
                assert_eq!(cupola_vk_image_size(made, view.image, &mut width, &mut height, &mut layers), CUPOLA_OK);
                assert!(view.index == index && view.layer < layers && view.image < images && view.name[0] != 0);
                assert!(view.x >= 0 && view.width > 0 && view.x + view.width <= width as i32);
                assert!(view.y >= 0 && view.height > 0 && view.y + view.height <= height as i32);
            }
            refused(cupola_vk_image_size(made, images, &mut width, &mut height, &mut layers), wrong, "no image");
            refused(cupola_vk_image_size(made, 0, null_mut(), &mut height, &mut layers), wrong, "`width` is null");

            let mut source: cupola_vk_source = std::mem::zeroed();
            source.struct_size = size_of::<cupola_vk_source>();
            refused(cupola_vk_get_source(made, 2, 0, &mut source), wrong, "frame 2");
            refused(cupola_vk_get_source(made, 0, images, &mut source), wrong, "no image");
            let mut all = Vec::new();
            for frame in 0..2 {
                for index in 0..images {
                    let mut source = cupola_vk_source { ..std::ptr::read(&source) };
                    assert_eq!(cupola_vk_get_source(made, frame, index, &mut source), CUPOLA_OK);
                    all.push(source);
                }
            }
            let set = |change: &dyn Fn(&mut cupola_vk_source)| {
                let mut changed: Vec<_> = all.iter().map(|source| std::ptr::read(source)).collect();
                change(&mut changed[0]);
                cupola_vk_set_sources(made, changed.len() as u32, changed.as_ptr())
            };
            refused(set(&|s| s.struct_size -= 8), wrong, "sources.struct_size");
            refused(set(&|s| s.view = VkImageView::null()), wrong, "VK_NULL_HANDLE");
            refused(set(&|s| s.width += 1), wrong, "expected");
            refused(set(&|s| s.format = VkFormat::B8G8R8A8_SRGB), wrong, "_UNORM");
            refused(set(&|s| s.format = VkFormat::D16_UNORM_S8_UINT), CUPOLA_GRAPHICS, "D16");
            refused(set(&|s| s.layout = VkImageLayout::UNDEFINED), wrong, "layout");
            refused(cupola_vk_set_sources(made, 1, all.as_ptr()), wrong, "frames in flight");
            refused(cupola_vk_set_sources(made, 1, null()), wrong, "`sources`");
            refused(cupola_vk_set_targets(made, 1, null()), wrong, "`targets`");
            let mut target: cupola_vk_target = std::mem::zeroed();
            target.struct_size = size_of::<cupola_vk_target>();
            refused(cupola_vk_set_targets(made, 1, &target), wrong, "VK_NULL_HANDLE");
            target.image = all[0].image;
            target.view = all[0].view;
            refused(cupola_vk_set_targets(made, 1, &target), wrong, "layout");
            target.final_layout = VkImageLayout::GENERAL;
            refused(cupola_vk_set_targets(made, 1, &target), wrong, "0 × 0");
            assert_eq!(cupola_vk_set_targets(made, 0, &target), CUPOLA_OK);

            refused(cupola_vk_record(made, VkCommandBuffer::null(), 0, 0, 0, 0), wrong, "command_buffer");
            let recorded = headless.run(|commands| {
                refused(cupola_vk_record(made, commands, 0, 0, 0, 0), wrong, "no target 0");
                refused(cupola_vk_record(made, commands, 2, 0, 0, 0), wrong, "no source 2");
                Ok(())
            });
            assert_eq!(recorded, Ok(()));
            let mut counts: cupola_vk_statistics = std::mem::zeroed();
            refused(cupola_vk_get_statistics(made, &mut counts), wrong, "struct_size");
            counts.struct_size = size_of::<cupola_vk_statistics>();
            assert_eq!(cupola_vk_get_statistics(made, &mut counts), CUPOLA_OK);
            assert_eq!(counts.frames, 0);

            refused(cupola_vk_resize(made, 0, 9), wrong, "0 × 9");
            assert_eq!(cupola_vk_get_source(made, 0, 0, &mut source), CUPOLA_OK, "everything stays");
            assert_eq!(cupola_vk_resize(made, 100, 90), CUPOLA_OK);
            assert_eq!(cupola_vk_get_source(made, 1, images - 1, &mut source), CUPOLA_OK);
            assert_eq!(cupola_vk_destroy(made), CUPOLA_OK);
            made = null_mut();
        }
    }
    // SAFETY: live, and not used again.
    unsafe { cupola_rig_free(rig) };
}
