//! Features that Cupola enables on a device: geometry shaders, if the rig asks for divided
//! primitives, and atomic operations, if the statistics count primitives that are not divided
//! enough. Exact occlusion queries measure the part of the window in which a program shows its scene.

use crate::intercept::process::settings;
use crate::intercept::vk::layer::device_structures::length_for_device;
use crate::intercept::vk::projected_vertices;
use crate::intercept::vk::state::driver::structures::{Copied, in_chain};
use crate::intercept::vk::state::views::vertices::VertexDecision;
use ash::vk;

/// The structure that creates a device, as the program gave it or with more features.
pub struct Enabled<'a> {
    /// The structure. It points into other fields of this type.
    pub info: vk::DeviceCreateInfo<'a>,
    /// Vertex processing with these features.
    pub decision: VertexDecision,
    /// True if occlusion queries count samples exactly.
    pub counts_samples: bool,
    _copies: [Copies; 2],
}

/// Enables the features that the rig needs. `looked_after`: Cupola has something to do on the
/// device. `has` returns the features of the device.
///
/// # Safety
/// `given` must be the program's.
pub unsafe fn enable<'a>(
    given: &vk::DeviceCreateInfo<'a>,
    looked_after: bool,
    has: impl Fn() -> vk::PhysicalDeviceFeatures,
) -> Enabled<'a> {
    let (mut info, mut copies) = (*given, Copies::default());
    let settings = settings::settings().filter(|_| looked_after);
    let decision = projected_vertices::decide(settings.map(|settings| &settings.rig), || {
        let has = has();
        if has.geometry_shader == vk::FALSE {
            return Err(projected_vertices::NO_STAGE.into());
        }
        // Only the statistics use the count.
        let wanted = settings.is_some_and(|settings| settings.stats.is_some());
        let counts = wanted && has.vertex_pipeline_stores_and_atomics == vk::TRUE;
        // If the program enables geometry shaders itself, only the counter may need a change.
        let ways = [counts, false].into_iter();
        // SAFETY: as promised.
        let mut ways = ways.filter_map(|counts| unsafe { with_geometry(&mut info, counts) }.zip(Some(counts)));
        let counts;
        (copies, counts) = ways.next().ok_or(projected_vertices::NO_WAY)?;
        Ok(counts)
    });
    let corrects = settings.is_some_and(|settings| !settings.rig.passthrough);
    let exact = corrects && has().occlusion_query_precise == vk::TRUE;
    // SAFETY: as promised.
    let exact =
        exact.then(|| unsafe { with_features(&mut info, |features| features.occlusion_query_precise = vk::TRUE) });
    let exact = exact.flatten();
    let counts_samples = exact.is_some();
    Enabled { info, decision, counts_samples, _copies: [copies, exact.unwrap_or_default()] }
}

/// Copies of structures that `info` points at then.
type Copies = (Option<Box<vk::PhysicalDeviceFeatures>>, Option<Copied>);

/// Enables geometry shaders in `info`, with `counts` also what they need to count. `None` if this is
/// not possible.
///
/// # Safety
/// As for [`with_features`].
unsafe fn with_geometry(info: &mut vk::DeviceCreateInfo<'_>, counts: bool) -> Option<Copies> {
    let enable = |features: &mut vk::PhysicalDeviceFeatures| {
        features.geometry_shader = vk::TRUE;
        if counts {
            features.vertex_pipeline_stores_and_atomics = vk::TRUE;
        }
    };
    // SAFETY: as promised.
    unsafe { with_features(info, enable) }
}

/// Enables features in `info`. The program's structures are not changed. `None` if this is not
/// possible.
///
/// # Safety
/// `info` must be a copy of the program's.
unsafe fn with_features(
    info: &mut vk::DeviceCreateInfo<'_>,
    enable: impl Fn(&mut vk::PhysicalDeviceFeatures),
) -> Option<Copies> {
    let complete = |features: &vk::PhysicalDeviceFeatures| {
        let mut complete = *features;
        enable(&mut complete);
        complete
    };
    // Features that matter here: the others do not change.
    let enabled = |features: &vk::PhysicalDeviceFeatures| {
        [features.geometry_shader, features.vertex_pipeline_stores_and_atomics, features.occlusion_query_precise]
    };
    // SAFETY: as promised.
    unsafe {
        let kind = vk::StructureType::PHYSICAL_DEVICE_FEATURES_2;
        if let Some(given) = in_chain::<vk::PhysicalDeviceFeatures2<'_>>(info.p_next, kind) {
            let wanted = complete(&given.features);
            if enabled(&given.features) == enabled(&wanted) {
                return Some((None, None));
            }
            let mut chain = Copied::up_to(info.p_next, kind, length_for_device)?;
            chain.last::<vk::PhysicalDeviceFeatures2<'_>>()?.features = wanted;
            info.p_next = chain.first();
            return Some((None, Some(chain)));
        }
        let features = Box::new(complete(&info.p_enabled_features.as_ref().copied().unwrap_or_default()));
        info.p_enabled_features = &raw const *features;
        Some((Some(features), None))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stage_is_enabled_beside_what_the_program_enables() {
        let own = vk::PhysicalDeviceFeatures { wide_lines: vk::TRUE, ..Default::default() };
        let all = [vk::DeviceCreateInfo::default(), vk::DeviceCreateInfo::default().enabled_features(&own)];
        for (given, counts) in all.into_iter().flat_map(|given| [(given, true), (given, false)]) {
            let mut info = given;
            // SAFETY: structures of this test.
            unsafe {
                let _copies = with_geometry(&mut info, counts).expect("there is nothing unknown");
                let made = *info.p_enabled_features;
                assert_eq!(made.geometry_shader, vk::TRUE);
                assert_eq!(made.vertex_pipeline_stores_and_atomics, vk::Bool32::from(counts));
                assert_eq!(made.wide_lines, given.p_enabled_features.as_ref().map_or(vk::FALSE, |own| own.wide_lines));
            }
        }
        assert_eq!(own.geometry_shader, vk::FALSE, "the program's own structure is unchanged");
    }

    #[test]
    fn the_stage_is_enabled_in_a_chain_whose_beginning_is_known() {
        let mut before = vk::PhysicalDeviceVulkan12Features::default().host_query_reset(true);
        let mut own = vk::PhysicalDeviceFeatures2::default();
        own.features.wide_lines = vk::TRUE;
        let mut behind = vk::PhysicalDeviceVulkan13Features::default();
        let behind_at: *const std::ffi::c_void = (&raw const behind).cast();
        own = own.push_next(&mut behind);
        before.p_next = (&raw mut own).cast();
        let given = vk::DeviceCreateInfo { p_next: (&raw const before).cast(), ..Default::default() };
        let mut info = given;
        // SAFETY: structures of this test.
        unsafe {
            let copies = with_geometry(&mut info, true).expect("all is known");
            assert!(copies.0.is_none() && info.p_enabled_features.is_null());
            let kind = vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
            let first: &vk::PhysicalDeviceVulkan12Features<'_> = in_chain(info.p_next, kind).expect("it is copied");
            assert_eq!(first.host_query_reset, vk::TRUE);
            let kind = vk::StructureType::PHYSICAL_DEVICE_FEATURES_2;
            let made: &vk::PhysicalDeviceFeatures2<'_> = in_chain(info.p_next, kind).expect("it is copied");
            assert_eq!((made.features.geometry_shader, made.features.wide_lines), (vk::TRUE, vk::TRUE));
            assert_eq!(made.features.vertex_pipeline_stores_and_atomics, vk::TRUE);
            assert_eq!(made.p_next.cast_const(), behind_at, "the rest is the program's");
            let program: &vk::PhysicalDeviceFeatures2<'_> = in_chain(given.p_next, kind).expect("it is there");
            assert_eq!(program.features.geometry_shader, vk::FALSE, "the program's own structure is unchanged");
            // A structure with an unknown type.
            let mut unknown = vk::BaseInStructure { p_next: given.p_next.cast(), ..Default::default() };
            unknown.s_type = vk::StructureType::from_raw(77);
            let mut info = vk::DeviceCreateInfo { p_next: (&raw const unknown).cast(), ..Default::default() };
            assert!(with_geometry(&mut info, false).is_none());
            // The program enables geometry shaders itself, so nothing has to change for them; a
            // change is needed for the counter.
            (*before.p_next.cast::<vk::PhysicalDeviceFeatures2<'_>>()).features.geometry_shader = vk::TRUE;
            assert!(with_geometry(&mut info, true).is_none());
            assert!(matches!(with_geometry(&mut info, false), Some((None, None))));
        }
    }
}
