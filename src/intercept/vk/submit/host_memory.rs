//! Buffers and memory of the program.
//!
//! Memory that the program maps stays mapped in the driver until it is freed, so that Cupola can
//! read it at any time. Data that commands copy or write into a buffer is stored beside the buffer.

use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::host_memory::KnownBuffer;
use crate::lock::Lock;
use ash::vk;

/// Returns the state of a new buffer; `None` if it can hold no matrices, and can be the source of no
/// copy of matrices.
fn known(info: &vk::BufferCreateInfo<'_>) -> Option<KnownBuffer> {
    use vk::BufferUsageFlags as U;
    let read = U::UNIFORM_BUFFER | U::STORAGE_BUFFER | U::TRANSFER_SRC | U::SHADER_DEVICE_ADDRESS;
    let of_vertices = !info.usage.intersects(read);
    let known = !of_vertices || info.usage.contains(U::VERTEX_BUFFER);
    let (memory, offset, size) = (vk::DeviceMemory::null(), 0, info.size);
    known.then(|| KnownBuffer { memory, offset, size, of_vertices, written: Vec::new() })
}

hooks! {
    create_buffer = (
        device: vk::Device, info: *const vk::BufferCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, buffer: *mut vk::Buffer
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, buffer);
        if let Some(new) = known(&*info).filter(|_| result == vk::Result::SUCCESS) {
            state.host_memory.buffers.locked().insert(*buffer, new);
        }
        result
    } }
    destroy_buffer = (
        device: vk::Device, buffer: vk::Buffer, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.host_memory.forget(buffer);
        next(device, buffer, allocator)
    } }
    get_buffer_address = (
        device: vk::Device, info: *const vk::BufferDeviceAddressInfo<'_>
    ) -> vk::DeviceAddress { |state, next| {
        let address = next(device, info);
        state.host_memory.note_address(address, (*info).buffer);
        address
    } }
    bind_buffer_memory = (
        device: vk::Device, buffer: vk::Buffer, memory: vk::DeviceMemory, offset: vk::DeviceSize
    ) -> vk::Result { |state, next| {
        state.host_memory.bound(buffer, memory, offset);
        next(device, buffer, memory, offset)
    } }
    bind_buffer_memory2 = (
        device: vk::Device, count: u32, infos: *const vk::BindBufferMemoryInfo<'_>
    ) -> vk::Result { |state, next| {
        for info in slice(infos, count) {
            state.host_memory.bound(info.buffer, info.memory, info.memory_offset);
        }
        next(device, count, infos)
    } }
    map_memory = (
        device: vk::Device, memory: vk::DeviceMemory, offset: vk::DeviceSize, size: vk::DeviceSize, flags: vk::MemoryMapFlags, data: *mut *mut std::ffi::c_void
    ) -> vk::Result { |state, next| {
        if let Some(address) = state.host_memory.address(memory) {
            *data = (address + offset as usize) as *mut _;
            return vk::Result::SUCCESS;
        }
        if !flags.is_empty() || next(device, memory, 0, vk::WHOLE_SIZE, flags, data) != vk::Result::SUCCESS {
            return next(device, memory, offset, size, flags, data);
        }
        let address = *data as usize;
        state.host_memory.map(memory, address);
        *data = (address + offset as usize) as *mut _;
        vk::Result::SUCCESS
    } }
    map_memory2 = (
        device: vk::Device, info: *const vk::MemoryMapInfoKHR<'_>, data: *mut *mut std::ffi::c_void
    ) -> vk::Result { |state, next| {
        let given = *info;
        if !given.p_next.is_null() || !given.flags.is_empty() {
            return next(device, info, data);
        }
        let address = match state.host_memory.address(given.memory) {
            Some(address) => address,
            None => {
                let whole = vk::MemoryMapInfoKHR { offset: 0, size: vk::WHOLE_SIZE, ..given };
                if next(device, &whole, data) != vk::Result::SUCCESS {
                    return next(device, info, data);
                }
                state.host_memory.map(given.memory, *data as usize);
                *data as usize
            }
        };
        *data = (address + given.offset as usize) as *mut _;
        vk::Result::SUCCESS
    } }
    unmap_memory = (device: vk::Device, memory: vk::DeviceMemory) { |state, next| {
        if state.host_memory.address(memory).is_none() {
            next(device, memory);
        }
    } }
    unmap_memory2 = (
        device: vk::Device, info: *const vk::MemoryUnmapInfoKHR<'_>
    ) -> vk::Result { |state, next| {
        if state.host_memory.address((*info).memory).is_some() { vk::Result::SUCCESS } else { next(device, info) }
    } }
    free_memory = (
        device: vk::Device, memory: vk::DeviceMemory, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.host_memory.mapped.locked().remove(&memory);
        next(device, memory, allocator)
    } }
}
