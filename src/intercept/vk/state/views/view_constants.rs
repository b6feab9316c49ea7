//! Memory for view constants: one slot for each view, for the panel and for the primary view.
//!
//! Shaders read it when a recorded command buffer runs, so that command buffers stay valid when the
//! program's lens changes. A slot holds the reprojection matrix, the lens constants if vertices are
//! projected to outputs, the conversion of fragments to the program's window, and factors of images
//! that are read by texel coordinates. A counter of the dividing stage may lie beside it. The
//! parameters of large draws lie in the same chunks.

use crate::intercept::scene::to_window::ToWindow;
use crate::intercept::vk::spirv::{BACKDROP_VECTORS, CAMERA_BYTES, MOST_CAMERAS, MOST_PICTURES};
use crate::intercept::vk::state::driver::Driver;
use crate::intercept::vk::state::views::division_counter::Counter;
use crate::lock::Lock;
use ash::prelude::VkResult;
use ash::vk;
use glam::Mat4;
use std::sync::{Mutex, OnceLock};

/// Number of floats of a reprojection matrix. The lens constants that may follow have the same
/// number.
const FLOATS: usize = 16;

/// Size of a chunk of memory in bytes.
const CHUNK_BYTES: u64 = 1 << 16;

/// A chunk of memory with its descriptor.
pub struct ConstantChunk {
    buffer: vk::Buffer,
    memory: vk::DeviceMemory,
    pool: vk::DescriptorPool,
    /// Its descriptor sets, without and with the counter. Their offset is given when they are
    /// bound.
    sets: [vk::DescriptorSet; 2],
    address: usize,
}

/// Location of a draw group's view constants.
#[derive(Clone, Copy, Debug)]
pub struct ChunkOffset {
    /// Index of the chunk among those of the command buffer.
    pub chunk: usize,
    /// Offset in the chunk, in bytes.
    pub offset: u32,
    /// Distance of two slots, in bytes.
    pub stride: u32,
}

impl ChunkOffset {
    /// Returns the offset of a slot in the chunk, in bytes.
    pub fn slot(&self, index: u32) -> u32 {
        self.offset + index * self.stride
    }
}

/// Parts of a slot after the matrices that reproject. Each value includes the ones before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlotParts {
    /// Conversion of fragments to the program's window: offset and scale.
    Place,
    /// Factors of images that fragments read by texel coordinates.
    Factors,
    /// Places of backgrounds.
    Backdrop,
    /// Camera matrices.
    Cameras,
}

/// Chunks of the device that no command buffer uses.
pub struct ConstantPool {
    lenses: bool,
    counts: bool,
    counter: OnceLock<Option<Counter>>,
    /// Layouts without and with the counter.
    set_layouts: [OnceLock<Option<vk::DescriptorSetLayout>>; 2],
    free: Mutex<Vec<ConstantChunk>>,
}

/// Chunks of a command buffer.
#[derive(Default)]
pub struct ConstantChunks {
    /// The chunks.
    pub chunks: Vec<ConstantChunk>,
    used: u64,
}

impl ConstantPool {
    /// Makes an empty pool. `lenses`: slots have lenses; `counts`: the dividing stage may count.
    pub fn new(lenses: bool, counts: bool) -> Self {
        Self { lenses, counts, counter: OnceLock::new(), set_layouts: Default::default(), free: Mutex::default() }
    }

    /// True if slots have lenses.
    pub fn have_lenses(&self) -> bool {
        self.lenses
    }

    /// Returns the offset in a slot of the conversion of fragments to the program's window (offset
    /// and scale), in bytes.
    pub fn to_window_offset(&self) -> u32 {
        (if self.lenses { 2 } else { 1 }) * (FLOATS * size_of::<f32>()) as u32
    }

    /// Returns the offset in a slot of the places of backgrounds, in bytes.
    pub fn backdrop_offset(&self) -> u32 {
        self.to_window_offset() + ((1 + MOST_PICTURES) * size_of::<[f32; 4]>()) as u32
    }

    /// Returns the offset in a slot of the camera matrices, in bytes. Those of the vertex stage
    /// follow those of the fragment stage.
    pub fn cameras_offset(&self) -> u32 {
        self.backdrop_offset() + (BACKDROP_VECTORS * size_of::<[f32; 4]>()) as u32
    }

    /// Returns the size of a slot with these parts, in bytes.
    pub fn slot(&self, parts: SlotParts) -> u32 {
        match parts {
            SlotParts::Place => self.to_window_offset() + size_of::<[f32; 4]>() as u32,
            SlotParts::Factors => self.backdrop_offset(),
            SlotParts::Backdrop => self.cameras_offset(),
            SlotParts::Cameras => self.cameras_offset() + CAMERA_BYTES,
        }
    }

    /// Returns the counter, if this driver can count.
    pub fn counter(&self, driver: &Driver) -> Option<&Counter> {
        self.counter.get_or_init(|| self.counts.then(|| Counter::new(driver).ok()).flatten()).as_ref()
    }

    /// Returns the count, if there is a counter.
    pub fn counted(&self) -> Option<u32> {
        self.counter.get()?.as_ref().map(Counter::read)
    }

    /// Returns the layout of the set with the view constants, and with the counter if `counts`;
    /// `None` if the driver refuses it.
    pub fn set_layout(&self, driver: &Driver, counts: bool) -> Option<vk::DescriptorSetLayout> {
        *self.set_layouts[usize::from(counts)].get_or_init(|| {
            let constants = vk::DescriptorSetLayoutBinding::default()
                .descriptor_type(vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::ALL_GRAPHICS | vk::ShaderStageFlags::COMPUTE);
            let counter = vk::DescriptorSetLayoutBinding::default()
                .binding(1)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::GEOMETRY);
            let bindings = [constants, counter];
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings[..1 + usize::from(counts)]);
            // SAFETY: the device is live.
            unsafe { driver.functions.create_descriptor_set_layout(&info, None) }.ok()
        })
    }

    /// Takes memory for `slots` slots at a distance of `stride` bytes.
    ///
    /// # Errors
    /// The driver's.
    pub fn take(
        &self,
        driver: &Driver,
        taken: &mut ConstantChunks,
        slots: usize,
        stride: u32,
    ) -> VkResult<ChunkOffset> {
        let length = slots as u64 * u64::from(stride);
        if length > CHUNK_BYTES {
            return Err(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY);
        }
        if taken.chunks.is_empty() || taken.used + length > CHUNK_BYTES {
            let free = self.free.locked().pop();
            let chunk = match free {
                Some(chunk) => chunk,
                None => self.make(driver)?,
            };
            taken.chunks.push(chunk);
            taken.used = 0;
        }
        let place = ChunkOffset { chunk: taken.chunks.len() - 1, offset: taken.used as u32, stride };
        taken.used += length;
        Ok(place)
    }

    /// Takes back the chunks that a command buffer no longer needs.
    pub fn give_back(&self, taken: &mut ConstantChunks) {
        taken.used = 0;
        self.free.locked().append(&mut taken.chunks);
    }

    fn make(&self, driver: &Driver) -> VkResult<ConstantChunk> {
        let counter = self.counter(driver);
        let layouts: Option<Vec<vk::DescriptorSetLayout>> = [false, true]
            .into_iter()
            .take(1 + counter.iter().count())
            .map(|counts| self.set_layout(driver, counts))
            .collect();
        let layouts = layouts.ok_or(vk::Result::ERROR_INITIALIZATION_FAILED)?;
        let mut chunk = ConstantChunk {
            buffer: vk::Buffer::null(),
            memory: vk::DeviceMemory::null(),
            pool: vk::DescriptorPool::null(),
            sets: Default::default(),
            address: 0,
        };
        match chunk.fill(driver, &layouts, self.slot(SlotParts::Cameras).into(), counter) {
            Ok(()) => Ok(chunk),
            Err(error) => {
                chunk.destroy(driver);
                Err(error)
            }
        }
    }

    /// Destroys all free chunks and the layouts, before the device is destroyed.
    pub fn destroy(&self, driver: &Driver) {
        for chunk in self.free.locked().drain(..) {
            chunk.destroy(driver);
        }
        for layout in self.set_layouts.iter().filter_map(|layout| layout.get().copied().flatten()) {
            // SAFETY: a layout of Cupola; nothing uses it any more.
            unsafe { driver.functions.destroy_descriptor_set_layout(layout, None) };
        }
        if let Some(Some(counter)) = self.counter.get() {
            counter.destroy(driver);
        }
    }
}

impl ConstantChunk {
    /// Returns its descriptor set, with or without the counter.
    pub fn set(&self, counts: bool) -> vk::DescriptorSet {
        self.sets[usize::from(counts)]
    }

    /// Makes its objects, with a set for each of the `layouts`.
    fn fill(
        &mut self,
        driver: &Driver,
        layouts: &[vk::DescriptorSetLayout],
        slot: u64,
        counter: Option<&Counter>,
    ) -> VkResult<()> {
        let functions = &driver.functions;
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::INDIRECT_BUFFER;
        // The descriptor of the last slot may reach beyond the slot's end.
        let info = vk::BufferCreateInfo::default().size(CHUNK_BYTES + slot).usage(usage);
        let visible = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let count = layouts.len() as u32;
        let sizes = [
            vk::DescriptorPoolSize { ty: vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC, descriptor_count: count },
            vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_BUFFER, descriptor_count: 1 },
        ];
        let pool = vk::DescriptorPoolCreateInfo::default().max_sets(count).pool_sizes(&sizes[..layouts.len()]);
        // SAFETY: makes objects of Cupola on a live device; they are stored in `self` as soon as
        // they are made.
        unsafe {
            self.buffer = functions.create_buffer(&info, None)?;
            let needs = functions.get_buffer_memory_requirements(self.buffer);
            let kind = driver.memory_type(needs.memory_type_bits, visible).unwrap_or(0);
            let allocation = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
            self.memory = functions.allocate_memory(&allocation, None)?;
            functions.bind_buffer_memory(self.buffer, self.memory, 0)?;
            let flags = vk::MemoryMapFlags::empty();
            self.address = functions.map_memory(self.memory, 0, vk::WHOLE_SIZE, flags)? as usize;
            self.pool = functions.create_descriptor_pool(&pool, None)?;
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool).set_layouts(layouts);
            let sets = functions.allocate_descriptor_sets(&info)?;
            self.sets.iter_mut().zip(&sets).for_each(|(place, set)| *place = *set);
            let constants = [vk::DescriptorBufferInfo { buffer: self.buffer, offset: 0, range: slot }];
            let write = |set| {
                let kind = vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC;
                vk::WriteDescriptorSet::default().dst_set(set).descriptor_type(kind).buffer_info(&constants)
            };
            let mut writes: Vec<_> = sets.iter().map(|set| write(*set)).collect();
            let counter = counter.map(|counter| [counter.descriptor()]);
            if let Some(counter) = &counter {
                let write = vk::WriteDescriptorSet::default().dst_set(self.set(true)).dst_binding(1);
                writes.push(write.descriptor_type(vk::DescriptorType::STORAGE_BUFFER).buffer_info(counter));
            }
            functions.update_descriptor_sets(&writes, &[]);
        }
        Ok(())
    }

    /// The buffer.
    pub fn buffer(&self) -> vk::Buffer {
        self.buffer
    }

    /// Writes a slot, with its lens if it has one. Writes nothing beyond the chunk.
    pub fn write(&self, offset: u32, reprojection: &[f32; FLOATS], lens: Option<&[f32; FLOATS]>) {
        self.write_words(offset, &reprojection.map(f32::to_bits));
        if let Some(lens) = lens {
            self.write_words(offset + size_of_val(reprojection) as u32, &lens.map(f32::to_bits));
        }
    }

    /// Writes the conversion of fragments to the program's window, at this offset.
    pub fn write_to_window(&self, offset: u32, to_window: &ToWindow) {
        self.write_words(offset, &to_window.vector(false).map(f32::to_bits));
    }

    /// Writes the factors of images that fragments read by texel coordinates. They come after the
    /// conversion to the program's window, which is at `offset`.
    pub fn write_factors(&self, offset: u32, factors: &[[f32; 4]]) {
        let place = offset + size_of::<[f32; 4]>() as u32;
        self.write_words(place, &factors.as_flattened().iter().map(|factor| factor.to_bits()).collect::<Vec<_>>());
    }

    /// Writes the places of a background, at this offset.
    pub fn write_backdrop(&self, offset: u32, vectors: &[[f32; 4]; BACKDROP_VECTORS]) {
        self.write_words(offset, &vectors.as_flattened().iter().map(|number| number.to_bits()).collect::<Vec<_>>());
    }

    /// Writes the matrices that replace those of the program in a stage, at this offset.
    pub fn write_cameras(&self, offset: u32, matrices: &[Option<Mat4>]) {
        let mut chosen = [0.0f32; MOST_CAMERAS];
        for ((number, matrix), chosen) in (0..).zip(matrices).zip(&mut chosen) {
            if let Some(matrix) = matrix {
                *chosen = 1.0;
                self.write_words(offset + number * size_of::<Mat4>() as u32, &matrix.to_cols_array().map(f32::to_bits));
            }
        }
        let behind = (MOST_CAMERAS * size_of::<Mat4>()) as u32;
        self.write_words(offset + behind, &chosen.map(f32::to_bits));
    }

    /// Writes words. Writes nothing if they would not lie in the chunk.
    pub fn write_words(&self, offset: u32, words: &[u32]) {
        if u64::from(offset) + size_of_val(words) as u64 > CHUNK_BYTES {
            return;
        }
        let to = (self.address + offset as usize) as *mut u32;
        // SAFETY: the chunk stays mapped, and the words lie in it; the commands that read them are
        // not running, since their command buffer is being submitted.
        unsafe { std::ptr::copy_nonoverlapping(words.as_ptr(), to, words.len()) };
    }

    fn destroy(&self, driver: &Driver) {
        // SAFETY: objects of Cupola or null; the device has finished with them.
        unsafe {
            driver.functions.destroy_descriptor_pool(self.pool, None);
            driver.functions.destroy_buffer(self.buffer, None);
            driver.functions.free_memory(self.memory, None);
        }
    }
}
