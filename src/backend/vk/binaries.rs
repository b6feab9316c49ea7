//! Compiled shaders of the driver, cached by the shaders and by the driver on its device.
//!
//! Drivers keep what they compile, too, most of them; some only what they are given back.

use crate::backend::vk::driver::api::Api;
use crate::correct::shaders::spirv::Modules;
use crate::error::Result;
use ash::vk;

/// Number of bytes of a header. Data of this length contains nothing else.
const HEADER: usize = 32;

/// A pipeline by `make`, which is told where the driver finds what it made of the same shaders
/// before, and leaves what it makes.
///
/// # Errors
/// Those of `make`.
pub(super) fn pipeline(
    api: &Api,
    modules: &Modules,
    make: impl Fn(vk::PipelineCache) -> Result<vk::Pipeline>,
) -> Result<vk::Pipeline> {
    if api.cache.is_none() {
        return make(vk::PipelineCache::null());
    }
    let made = api.cache.cached_as(
        "pipeline",
        &(&api.driver, modules.vertex, &modules.fragment),
        |known| {
            let known = Some(known).filter(|data| data.len() > HEADER)?;
            with(api, known, &make).ok().map(|pipeline| (pipeline, Vec::new()))
        },
        |(_, data)| Some(data.clone()).filter(|data| data.len() > HEADER),
        || with(api, &[], |cache| Ok((make(cache)?, data(api, cache)))),
    );
    made.map(|(pipeline, _)| pipeline)
}

/// Runs `body` with a cache of the driver's that knows `data`, or with none where it refuses one;
/// drivers ignore data of others.
fn with<T>(api: &Api, data: &[u8], body: impl FnOnce(vk::PipelineCache) -> Result<T>) -> Result<T> {
    let info = vk::PipelineCacheCreateInfo::default().initial_data(data);
    // SAFETY: the device is live; the structure is complete.
    let cache = unsafe { api.device.create_pipeline_cache(&info, None) }.unwrap_or_default();
    let result = body(cache);
    // SAFETY: ours or null, and a pipeline does not need it once it is made.
    unsafe { api.device.destroy_pipeline_cache(cache, None) };
    result
}

/// Returns the data of the driver's cache; empty if the driver gives none.
fn data(api: &Api, cache: vk::PipelineCache) -> Vec<u8> {
    if cache == vk::PipelineCache::null() {
        return Vec::new();
    }
    // SAFETY: ours, with the device live.
    unsafe { api.device.get_pipeline_cache_data(cache) }.unwrap_or_default()
}
