//! Compiled pipelines of the driver, cached by the shaders, the driver and the device.
//!
//! Most drivers have a cache of their own; some use only the data that a program gives back to
//! them.

use crate::backend::vk::driver::api::Api;
use crate::correct::shaders::spirv::Modules;
use crate::error::Result;
use ash::vk;

/// Number of bytes of the header of cache data. Data of this length contains no pipeline.
const HEADER: usize = 32;

/// Returns a pipeline made by `make`. If results are cached, `make` gets a pipeline cache with the
/// driver's earlier data for the same shaders, and adds its new data to it.
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

/// Runs `body` with a pipeline cache that contains `data`, or with a null handle if the driver
/// refuses one. Drivers ignore data of other drivers.
fn with<T>(api: &Api, data: &[u8], body: impl FnOnce(vk::PipelineCache) -> Result<T>) -> Result<T> {
    let info = vk::PipelineCacheCreateInfo::default().initial_data(data);
    // SAFETY: the device is live; the structure is complete.
    let cache = unsafe { api.device.create_pipeline_cache(&info, None) }.unwrap_or_default();
    let result = body(cache);
    // SAFETY: an object of Cupola or null; a pipeline does not need it once it is made.
    unsafe { api.device.destroy_pipeline_cache(cache, None) };
    result
}

/// Returns the data of a pipeline cache; empty if the driver offers none.
fn data(api: &Api, cache: vk::PipelineCache) -> Vec<u8> {
    if cache == vk::PipelineCache::null() {
        return Vec::new();
    }
    // SAFETY: an object of Cupola; the device is live.
    unsafe { api.device.get_pipeline_cache_data(cache) }.unwrap_or_default()
}
