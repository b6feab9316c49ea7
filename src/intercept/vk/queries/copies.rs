//! Results of queries that a command copies into a buffer of the program. They are scaled on the
//! device.
//!
//! The results of a pool are copied into a buffer of Cupola. A compute shader scales them, and they
//! are copied to the program's buffer. Results that are not available have the values of the last
//! copy.

use crate::backend::vk::Buffer;
use crate::intercept::vk::commands::conditional_render::unconditionally;
use crate::intercept::vk::queries::results;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::queries::{ONE, Pool, Queries, QueryScaler, Scratch};
use crate::lock::Lock;
use ash::prelude::VkResult;
use ash::vk;

/// The shader's entry point.
const ENTRY: &std::ffi::CStr = c"tell";

/// Number of queries in a workgroup of the shader.
const GROUP: u32 = 64;

include!(concat!(env!("OUT_DIR"), "/queries_spirv.rs"));

/// A copy of results that a program requests.
#[derive(Clone, Copy, Debug)]
pub struct CopiedResults {
    /// The first query and the number of queries.
    pub queries: (u32, u32),
    /// Buffer that the results are copied to.
    pub to: vk::Buffer,
    /// Offset of the first result in the buffer, and distance of two results, in bytes.
    pub place: (u64, u64),
    /// The form.
    pub flags: vk::QueryResultFlags,
}

impl QueryScaler {
    fn new(device: &Device) -> VkResult<Self> {
        let mut new = Self {
            set_layout: vk::DescriptorSetLayout::null(),
            layout: vk::PipelineLayout::null(),
            pipeline: vk::Pipeline::null(),
        };
        new.make(device).inspect_err(|_| new.destroy(device))?;
        Ok(new)
    }

    fn make(&mut self, device: &Device) -> VkResult<()> {
        let binding = |number| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(number)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        };
        let bindings: Vec<_> = (0..3).map(binding).collect();
        let functions = &device.driver.functions;
        // SAFETY: makes objects of Cupola on a live device; they are stored in `self` as soon as
        // they are made.
        unsafe {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            self.set_layout = functions.create_descriptor_set_layout(&info, None)?;
            let layouts = [self.set_layout];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts);
            self.layout = functions.create_pipeline_layout(&info, None)?;
            let module = functions.create_shader_module(&vk::ShaderModuleCreateInfo::default().code(WORDS), None)?;
            let stage = vk::PipelineShaderStageCreateInfo::default().stage(vk::ShaderStageFlags::COMPUTE);
            let info =
                vk::ComputePipelineCreateInfo::default().stage(stage.module(module).name(ENTRY)).layout(self.layout);
            let made = functions.create_compute_pipelines(vk::PipelineCache::null(), &[info], None);
            functions.destroy_shader_module(module, None);
            self.pipeline = made.map_err(|(_, error)| error)?.first().copied().unwrap_or_default();
        }
        Ok(())
    }

    /// Destroys the objects, before the device is destroyed.
    pub fn destroy(&self, device: &Device) {
        // SAFETY: objects of Cupola or null; nothing uses them any more.
        unsafe {
            device.driver.functions.destroy_pipeline(self.pipeline, None);
            device.driver.functions.destroy_pipeline_layout(self.layout, None);
            device.driver.functions.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

/// Returns the offset of the results in the form of `flags`, and the length of each result, in
/// bytes, for `queries` queries of `numbers` numbers.
fn form(flags: vk::QueryResultFlags, numbers: u64, queries: u64) -> (u64, u64) {
    use vk::QueryResultFlags as F;
    let lengths = [8 * numbers, 8 * (numbers + 1), 4 * numbers, 4 * (numbers + 1)];
    let number = usize::from(!flags.contains(F::TYPE_64)) * 2 + usize::from(flags.contains(F::WITH_AVAILABILITY));
    (lengths[..number].iter().sum::<u64>() * queries, lengths[number])
}

impl Scratch {
    fn new(device: &Device, scaler: &QueryScaler, pool: &Pool, queries: u32) -> crate::error::Result<Self> {
        use vk::BufferUsageFlags as U;
        let (numbers, count) = (pool.quantities.len(), queries as usize);
        let size = |words: usize| 4 * words * count;
        let mut new = Self {
            queries,
            counted: Buffer::default(),
            factors: Buffer::default(),
            scaled: Buffer::default(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
        };
        let mut make = || -> crate::error::Result<()> {
            new.counted =
                Buffer::new(&device.driver.api, size(2 * (numbers + 1)), U::STORAGE_BUFFER | U::TRANSFER_DST)?;
            new.counted.write(&device.driver.api, 0, &vec![0; size(2 * (numbers + 1))])?;
            new.factors = Buffer::new(&device.driver.api, 8 + size(2 * numbers), U::STORAGE_BUFFER)?;
            let head = [numbers as u32, queries].map(u32::to_ne_bytes).concat();
            new.factors.write(&device.driver.api, 0, &head)?;
            new.factors.write(&device.driver.api, 8, &ONE.to_ne_bytes().repeat(numbers * count))?;
            new.scaled = Buffer::new(&device.driver.api, size(6 * numbers + 3), U::STORAGE_BUFFER | U::TRANSFER_SRC)?;
            new.describe(device, scaler).map_err(crate::backend::vk::refused("descriptors"))
        };
        if let Err(error) = make() {
            new.destroy(device);
            return Err(error);
        }
        for query in 0..queries {
            new.set_factors(&device.driver, query, &pool.factors(query).collect::<Vec<_>>());
        }
        Ok(new)
    }

    fn describe(&mut self, device: &Device, scaler: &QueryScaler) -> VkResult<()> {
        let sizes = [vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_BUFFER, descriptor_count: 3 }];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        let functions = &device.driver.functions;
        // SAFETY: objects of Cupola on a live device; the buffers are live.
        unsafe {
            self.pool = functions.create_descriptor_pool(&info, None)?;
            let layouts = [scaler.set_layout];
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool).set_layouts(&layouts);
            self.set = functions.allocate_descriptor_sets(&info)?.first().copied().unwrap_or_default();
            let whole = |buffer: &Buffer| {
                [vk::DescriptorBufferInfo { buffer: buffer.handle, offset: 0, range: vk::WHOLE_SIZE }]
            };
            let buffers = [&self.counted, &self.factors, &self.scaled].map(whole);
            let write = |(number, buffer): (u32, &'_ [vk::DescriptorBufferInfo; 1])| {
                let mut write = vk::WriteDescriptorSet::default().dst_set(self.set).dst_binding(number);
                write.descriptor_type = vk::DescriptorType::STORAGE_BUFFER;
                write.descriptor_count = 1;
                write.p_buffer_info = buffer.as_ptr();
                write
            };
            let writes: Vec<_> = (0..).zip(&buffers).map(write).collect();
            functions.update_descriptor_sets(&writes, &[]);
        }
        Ok(())
    }

    /// Destroys the objects for a destroyed pool of the program.
    pub fn destroy(&mut self, device: &Device) {
        // SAFETY: an object of Cupola or null; nothing uses it, since the program destroys its
        // pool.
        unsafe { device.driver.functions.destroy_descriptor_pool(self.pool, None) };
        [&mut self.counted, &mut self.factors, &mut self.scaled]
            .into_iter()
            .for_each(|buffer| buffer.destroy(&device.driver.api));
    }

    /// Records the copy of results to the program's buffer. `next` copies results into a buffer.
    ///
    /// # Safety
    /// The command buffer is being recorded, outside of a pass; the results are the pool's.
    unsafe fn copy(
        &self,
        device: &Device,
        buffer: vk::CommandBuffer,
        scaler: &QueryScaler,
        pool: &Pool,
        wanted: &CopiedResults,
        next: impl FnOnce(vk::Buffer, u64, u64, vk::QueryResultFlags),
    ) {
        use vk::{AccessFlags as A, PipelineStageFlags as S};
        let functions = &device.driver.functions;
        let wait = |(from, written): (S, A), (to, used): (S, A)| {
            let memory = [vk::MemoryBarrier::default().src_access_mask(written).dst_access_mask(used)];
            // SAFETY: as promised.
            unsafe {
                functions.cmd_pipeline_barrier(buffer, from, to, vk::DependencyFlags::empty(), &memory, &[], &[]);
            }
        };
        let (first, count) = wanted.queries;
        let queries = self.queries;
        let stride = pool.stride_in_bytes();
        let (copied, computed) = ((S::TRANSFER, A::TRANSFER_WRITE), (S::COMPUTE_SHADER, A::SHADER_WRITE));
        wait((S::TRANSFER | S::COMPUTE_SHADER, A::TRANSFER_WRITE | A::SHADER_WRITE), copied);
        next(self.counted.handle, u64::from(first) * stride, stride, wanted.flags | results::RAW);
        wait(copied, (S::COMPUTE_SHADER, A::SHADER_READ | A::SHADER_WRITE));
        let point = vk::PipelineBindPoint::COMPUTE;
        // SAFETY: as promised; pipeline and set have the same layout.
        unsafe {
            functions.cmd_bind_pipeline(buffer, point, scaler.pipeline);
            functions.cmd_bind_descriptor_sets(buffer, point, scaler.layout, 0, &[self.set], &[]);
            functions.cmd_dispatch(buffer, queries.div_ceil(GROUP), 1, 1);
        }
        wait(computed, (S::TRANSFER, A::TRANSFER_READ));
        let (begin, length) = form(wanted.flags, pool.quantities.len() as u64, queries.into());
        let (to, apart) = wanted.place;
        let together = count < 2 || apart == length;
        let region = |index: u64| vk::BufferCopy {
            src_offset: begin + (u64::from(first) + index) * length,
            dst_offset: to + index * apart,
            size: if together { u64::from(count) * length } else { length },
        };
        let regions: Vec<_> = (0..if together { 1 } else { count.into() }).map(region).collect();
        // SAFETY: as promised; the program's buffer can be copied to, and has room for the results.
        unsafe { functions.cmd_copy_buffer(buffer, self.scaled.handle, wanted.to, &regions) };
    }
}

impl Queries {
    /// Records a copy of results with their factors. `next` copies results of the pool; its
    /// parameters are a buffer, the offset, the distance of two results and the form. If scaling is
    /// not possible, the results are copied without it.
    ///
    /// # Safety
    /// The command buffer is being recorded, outside of a pass; `wanted` is the program's request.
    pub unsafe fn copy(
        &self,
        device: &Device,
        buffer: vk::CommandBuffer,
        handle: vk::QueryPool,
        wanted: &CopiedResults,
        next: impl Fn(vk::Buffer, u64, u64, vk::QueryResultFlags),
    ) {
        let plainly = || next(wanted.to, wanted.place.0, wanted.place.1, wanted.flags);
        let (Some(pool), Some(scaler)) = (self.get(handle).filter(|_| wanted.queries.1 > 0), self.scaler(device))
        else {
            return plainly();
        };
        let queries = pool.factors.locked().len() as u32;
        let mut scratch = pool.scratch.locked();
        if scratch.is_none() {
            match Scratch::new(device, scaler, &pool, queries) {
                Ok(new) => *scratch = Some(new),
                Err(error) => {
                    crate::intercept::process::log::once(&format!(
                        "Vulkan: counts of queries are copied without scaling: {error}"
                    ));
                }
            }
        }
        let Some(scratch) = &*scratch else { return plainly() };
        // SAFETY: as promised.
        unsafe {
            unconditionally(device, buffer, || {
                scratch.copy(device, buffer, scaler, &pool, wanted, next);
                device
                    .recordings
                    .with(buffer, |recording| recording.compute.restore(&device.driver, &device.next, buffer));
            });
        }
    }

    /// Returns the object that multiplies counts by their factors; `None` if some queues that draw
    /// cannot compute, or if the driver refuses it.
    fn scaler(&self, device: &Device) -> Option<&QueryScaler> {
        use vk::QueueFlags as Q;
        let computes = |family: &Q| !family.contains(Q::GRAPHICS) || family.contains(Q::COMPUTE);
        let make = || device.driver.families.iter().all(computes).then(|| QueryScaler::new(device).ok()).flatten();
        self.scaler.get_or_init(make).as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::form;
    use ash::vk::QueryResultFlags as F;

    #[test]
    fn the_forms_follow_each_other_without_a_gap() {
        let (numbers, queries) = (3, 5);
        let mut end = 0;
        for flags in [F::TYPE_64, F::TYPE_64 | F::WITH_AVAILABILITY, F::empty(), F::WITH_AVAILABILITY] {
            let (begin, length) = form(flags, numbers, queries);
            assert_eq!(begin, end, "{flags:?}");
            end = begin + queries * length;
        }
        assert_eq!(end, 4 * (6 * numbers + 3) * queries);
    }
}
