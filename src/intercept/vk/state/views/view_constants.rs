//! Memory for view constants: one slot for each view, for the panel and for the primary view.
//!
//! Shaders read it when a recorded command buffer runs, so that command buffers stay valid when the
//! program's lens changes. A slot holds the reprojection matrix, the lens constants where vertices
//! are projected to outputs, what takes fragments to the program's window, and the factors of
//! images that they read by numbers; a counter of the dividing stage may lie beside it. The
//! parameters of large draws lie in the same chunks.

use crate::intercept::scene::to_window::ToWindow;
use crate::intercept::vk::spirv::{CAMERA_BYTES, MOST_CAMERAS, MOST_PICTURES};
use crate::intercept::vk::state::driver::Driver;
use crate::intercept::vk::state::views::division_counter::Counter;
use crate::lock::Lock;
use ash::prelude::VkResult;
use ash::vk;
use std::sync::{Mutex, OnceLock};

/// Number of floats of a reprojection matrix, and of the lens constants that may follow it.
const FLOATS: usize = 16;

/// Bytes of a chunk of memory.
const CHUNK_BYTES: u64 = 1 << 16;

/// A chunk of memory with its descriptor.
pub struct ConstantChunk {
    buffer: vk::Buffer,
    memory: vk::DeviceMemory,
    pool: vk::DescriptorPool,
    /// Its descriptor sets, whose offset is given when one is bound: without the counter, and with
    /// it.
    sets: [vk::DescriptorSet; 2],
    address: usize,
}

/// Place of a draw group's view constants.
#[derive(Clone, Copy, Debug)]
pub struct ChunkOffset {
    /// Index of the chunk among those of the command buffer.
    pub chunk: usize,
    /// Offset in it, bytes.
    pub offset: u32,
    /// From one slot to the next, bytes.
    pub stride: u32,
}

impl ChunkOffset {
    /// Returns the offset of a slot in the chunk, bytes.
    pub fn slot(&self, index: u32) -> u32 {
        self.offset + index * self.stride
    }
}

/// Parts of a slot behind the matrices that re-project.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlotParts {
    /// Offset and scale that take fragments to the program's window.
    Place,
    /// And factors of images that they read by texels.
    Factors,
    /// And matrices of the camera.
    Cameras,
}

/// The device's chunks that no command buffer has.
pub struct ConstantPool {
    lenses: bool,
    counts: bool,
    counter: OnceLock<Option<Counter>>,
    /// Without the counter, and with it.
    set_layouts: [OnceLock<Option<vk::DescriptorSetLayout>>; 2],
    free: Mutex<Vec<ConstantChunk>>,
}

/// Those of a command buffer.
#[derive(Default)]
pub struct ConstantChunks {
    /// The chunks.
    pub chunks: Vec<ConstantChunk>,
    used: u64,
}

impl ConstantPool {
    /// No memory yet. `lenses`: for slots with lenses; `counts`: what divides may count.
    pub fn new(lenses: bool, counts: bool) -> Self {
        Self { lenses, counts, counter: OnceLock::new(), set_layouts: Default::default(), free: Mutex::default() }
    }

    /// True if slots have lenses.
    pub fn have_lenses(&self) -> bool {
        self.lenses
    }

    /// Returns the offset in a slot of the values that take fragments to the program's window,
    /// bytes: an offset and a scale.
    pub fn to_window_offset(&self) -> u32 {
        (if self.lenses { 2 } else { 1 }) * (FLOATS * size_of::<f32>()) as u32
    }

    /// Returns the offset in a slot of the matrices of the camera, bytes: those of fragments,
    /// behind them those of vertices.
    pub fn cameras_offset(&self) -> u32 {
        self.to_window_offset() + ((1 + MOST_PICTURES) * size_of::<[f32; 4]>()) as u32
    }

    /// Bytes of a slot with these parts.
    pub fn slot(&self, parts: SlotParts) -> u32 {
        match parts {
            SlotParts::Place => self.to_window_offset() + size_of::<[f32; 4]>() as u32,
            SlotParts::Factors => self.cameras_offset(),
            SlotParts::Cameras => self.cameras_offset() + CAMERA_BYTES,
        }
    }

    /// The counter, if this driver can count.
    pub fn counter(&self, driver: &Driver) -> Option<&Counter> {
        self.counter.get_or_init(|| self.counts.then(|| Counter::new(driver).ok()).flatten()).as_ref()
    }

    /// The count, if there is a counter.
    pub fn counted(&self) -> Option<u32> {
        self.counter.get()?.as_ref().map(Counter::read)
    }

    /// The layout of the set that shaders read the view constants by, and count by with `counts`;
    /// `None` where the driver refuses it.
    pub fn set_layout(&self, driver: &Driver, counts: bool) -> Option<vk::DescriptorSetLayout> {
        *self.set_layouts[usize::from(counts)].get_or_init(|| {
            let rows = vk::DescriptorSetLayoutBinding::default()
                .descriptor_type(vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::ALL_GRAPHICS | vk::ShaderStageFlags::COMPUTE);
            let counter = vk::DescriptorSetLayoutBinding::default()
                .binding(1)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::GEOMETRY);
            let bindings = [rows, counter];
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings[..1 + usize::from(counts)]);
            // SAFETY: the device is live.
            unsafe { driver.functions.create_descriptor_set_layout(&info, None) }.ok()
        })
    }

    /// Room for `slots` slots, each `stride` bytes from the last.
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

    /// A command buffer needs its chunks no more.
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

    /// Destroys what is left, before the device is destroyed.
    pub fn destroy(&self, driver: &Driver) {
        for chunk in self.free.locked().drain(..) {
            chunk.destroy(driver);
        }
        for layout in self.set_layouts.iter().filter_map(|layout| layout.get().copied().flatten()) {
            // SAFETY: ours; nothing uses it any more.
            unsafe { driver.functions.destroy_descriptor_set_layout(layout, None) };
        }
        if let Some(Some(counter)) = self.counter.get() {
            counter.destroy(driver);
        }
    }
}

impl ConstantChunk {
    /// Its descriptor set, with the counter or without.
    pub fn set(&self, counts: bool) -> vk::DescriptorSet {
        self.sets[usize::from(counts)]
    }

    /// With a set for each of the `layouts`.
    fn fill(
        &mut self,
        driver: &Driver,
        layouts: &[vk::DescriptorSetLayout],
        slot: u64,
        counter: Option<&Counter>,
    ) -> VkResult<()> {
        let functions = &driver.functions;
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::INDIRECT_BUFFER;
        // The descriptor of the last slot reaches farther than some slots.
        let info = vk::BufferCreateInfo::default().size(CHUNK_BYTES + slot).usage(usage);
        let visible = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let count = layouts.len() as u32;
        let sizes = [
            vk::DescriptorPoolSize { ty: vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC, descriptor_count: count },
            vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_BUFFER, descriptor_count: 1 },
        ];
        let pool = vk::DescriptorPoolCreateInfo::default().max_sets(count).pool_sizes(&sizes[..layouts.len()]);
        // SAFETY: makes objects of Cupola on a live device; they are kept in `self` as soon as they
        // are made.
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
            let rows = [vk::DescriptorBufferInfo { buffer: self.buffer, offset: 0, range: slot }];
            let rows = |set| {
                let kind = vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC;
                vk::WriteDescriptorSet::default().dst_set(set).descriptor_type(kind).buffer_info(&rows)
            };
            let mut writes: Vec<_> = sets.iter().map(|set| rows(*set)).collect();
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

    /// Writes a slot, with its lens if it has one; nothing where it would not lie in the chunk.
    pub fn write(&self, offset: u32, rows: &[f32; FLOATS], lens: Option<&[f32; FLOATS]>) {
        self.write_words(offset, &rows.map(f32::to_bits));
        if let Some(lens) = lens {
            self.write_words(offset + size_of_val(rows) as u32, &lens.map(f32::to_bits));
        }
    }

    /// Writes what takes fragments to the program's window, at this place.
    pub fn write_to_window(&self, offset: u32, to_window: &ToWindow) {
        self.write_words(offset, &to_window.vector(false).map(f32::to_bits));
    }

    /// Writes the factors of images that fragments read by numbers, behind what takes them to the
    /// program's window.
    pub fn write_factors(&self, offset: u32, factors: &[[f32; 4]]) {
        let place = offset + size_of::<[f32; 4]>() as u32;
        self.write_words(place, &factors.as_flattened().iter().map(|factor| factor.to_bits()).collect::<Vec<_>>());
    }

    /// Writes the matrices of a stage that are in the place of the program's, at this place.
    pub fn write_cameras(&self, offset: u32, matrices: &[Option<[f32; FLOATS]>]) {
        let mut chosen = [0.0f32; MOST_CAMERAS];
        for ((number, matrix), chosen) in (0..).zip(matrices).zip(&mut chosen) {
            if let Some(matrix) = matrix {
                *chosen = 1.0;
                self.write_words(offset + number * size_of_val(matrix) as u32, &matrix.map(f32::to_bits));
            }
        }
        let behind = (MOST_CAMERAS * size_of::<[f32; FLOATS]>()) as u32;
        self.write_words(offset + behind, &chosen.map(f32::to_bits));
    }

    /// Writes numbers; nothing where they would not lie in the chunk.
    pub fn write_words(&self, offset: u32, words: &[u32]) {
        if u64::from(offset) + size_of_val(words) as u64 > CHUNK_BYTES {
            return;
        }
        let to = (self.address + offset as usize) as *mut u32;
        // SAFETY: the chunk stays mapped, and the numbers lie in it; what reads them is not
        // running, since its command buffer is being submitted.
        unsafe { std::ptr::copy_nonoverlapping(words.as_ptr(), to, words.len()) };
    }

    fn destroy(&self, driver: &Driver) {
        // SAFETY: ours or null; the device has finished with them.
        unsafe {
            driver.functions.destroy_descriptor_pool(self.pool, None);
            driver.functions.destroy_buffer(self.buffer, None);
            driver.functions.free_memory(self.memory, None);
        }
    }
}
