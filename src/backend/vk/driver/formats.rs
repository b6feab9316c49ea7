//! Formats of images from which views can be read, and into which they can be corrected.

use crate::backend::vk::driver::api::Api;
use crate::error::{Error, ErrorKind, Result};
use ash::vk;

/// Returns the names of the usual formats that work both for views and for targets.
pub fn usable_formats(api: &Api) -> Vec<String> {
    use vk::Format as F;
    let usual = [F::B8G8R8A8_UNORM, F::R8G8B8A8_UNORM, F::A2B10G10R10_UNORM_PACK32, F::R16G16B16A16_SFLOAT];
    let usable = |format: &F| check_source_format(api, *format).is_ok() && check_target_format(api, *format).is_ok();
    usual.into_iter().filter(usable).map(|format| format!("{format:?}")).collect()
}

/// Checks that views can be read from images of `format`.
pub(in crate::backend::vk) fn check_source_format(api: &Api, format: vk::Format) -> Result<()> {
    let needed = vk::FormatFeatureFlags::SAMPLED_IMAGE | vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
    check_format(api, "an image with views", format, needed)
}

/// Checks that encoded values can be drawn to images of `format`.
pub(in crate::backend::vk) fn check_target_format(api: &Api, format: vk::Format) -> Result<()> {
    let what = "an image to correct into";
    // The requirement of blending excludes integers, which cannot be blended. 32-bit floats are
    // allowed without blending.
    let needed = match format {
        vk::Format::R32G32B32A32_SFLOAT => vk::FormatFeatureFlags::COLOR_ATTACHMENT,
        _ => vk::FormatFeatureFlags::COLOR_ATTACHMENT | vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND,
    };
    check_format(api, what, format, needed)
}

fn check_format(api: &Api, what: &str, format: vk::Format, needed: vk::FormatFeatureFlags) -> Result<()> {
    if is_srgb(format) {
        return Err(Error::new(
            ErrorKind::InvalidArgument,
            format!(
                "{what} has the sRGB format {format:?}, which converts; expected a view of the same image with the \
             _UNORM format (VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT)"
            ),
        ));
    }
    if format == vk::Format::UNDEFINED || !api.features(format).contains(needed) {
        let message = format!("The device cannot use {format:?} for {what}, which needs {needed:?}.");
        return Err(Error::new(ErrorKind::Graphics, message));
    }
    Ok(())
}

fn is_srgb(format: vk::Format) -> bool {
    use vk::Format as F;
    matches!(format, F::R8G8B8A8_SRGB | F::B8G8R8A8_SRGB | F::A8B8G8R8_SRGB_PACK32 | F::R8G8B8_SRGB | F::B8G8R8_SRGB)
}
