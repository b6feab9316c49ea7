//! Buffers and memory of the program: what a uniform block holds when a frame is submitted.
//!
//! Memory that the program maps stays mapped below us until it is freed, so that it can be read at any time. What
//! the program copies or writes into a buffer by commands is kept beside it.

use crate::intercept::vk::layer::hooks::hooks;
use ash::vk;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// A buffer that shaders may read matrices from.
struct Buffer {
    memory: vk::DeviceMemory,
    offset: u64,
    size: u64,
    /// Ranges that commands wrote: what they wrote there last.
    written: Vec<(u64, Vec<u8>)>,
}

/// The program's mapping of memory, kept by us.
struct Mapping {
    address: usize,
}

/// More bytes than this of one buffer are not kept.
const MOST_KEPT: u64 = 1 << 16;

/// Buffers and mapped memory.
#[derive(Default)]
pub struct Memory {
    buffers: Mutex<HashMap<vk::Buffer, Buffer>>,
    mapped: Mutex<HashMap<vk::DeviceMemory, Mapping>>,
}

impl Memory {
    /// Reads what a buffer holds at `offset`; `false` if that is not known.
    pub fn read(&self, buffer: vk::Buffer, offset: u64, to: &mut [u8]) -> bool {
        let buffers = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(state) = buffers.get(&buffer) else { return false };
        let Some(end) = offset.checked_add(to.len() as u64).filter(|end| *end <= state.size) else { return false };
        let kept = state.written.iter().rev().find(|(at, bytes)| *at <= offset && end <= at + bytes.len() as u64);
        if let Some((at, bytes)) = kept {
            let start = (offset - at) as usize;
            to.copy_from_slice(&bytes[start..start + to.len()]);
            return true;
        }
        let mapped = self.mapped.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(mapping) = mapped.get(&state.memory) else { return false };
        let from = mapping.address + (state.offset + offset) as usize;
        // SAFETY: all of the memory is mapped, and the buffer lies in it.
        unsafe { std::ptr::copy_nonoverlapping(from as *const u8, to.as_mut_ptr(), to.len()) };
        true
    }

    /// Keeps what a command writes into a buffer.
    pub fn written(&self, buffer: vk::Buffer, offset: u64, bytes: Vec<u8>) {
        let mut buffers = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(state) = buffers.get_mut(&buffer) else { return };
        let end = offset + bytes.len() as u64;
        state.written.retain(|(at, old)| *at < offset || at + old.len() as u64 > end);
        state.written.push((offset, bytes));
        let mut kept = 0;
        let counted = state.written.iter().rev().take_while(|(_, bytes)| {
            kept += bytes.len() as u64;
            kept <= MOST_KEPT
        });
        let surplus = state.written.len() - counted.count();
        state.written.drain(..surplus);
    }

    /// Keeps what a copy brings into a buffer, if both are known.
    pub fn copied(&self, from: vk::Buffer, to: vk::Buffer, region: &vk::BufferCopy) {
        let wanted = self.buffers.lock().unwrap_or_else(PoisonError::into_inner).contains_key(&to);
        if !wanted || region.size > MOST_KEPT {
            return;
        }
        let mut bytes = vec![0; region.size as usize];
        if self.read(from, region.src_offset, &mut bytes) {
            self.written(to, region.dst_offset, bytes);
        }
    }

    fn bound(&self, buffer: vk::Buffer, memory: vk::DeviceMemory, offset: u64) {
        if let Some(state) = self.buffers.lock().unwrap_or_else(PoisonError::into_inner).get_mut(&buffer) {
            (state.memory, state.offset) = (memory, offset);
        }
    }

    /// The address of memory that is mapped already.
    fn address(&self, memory: vk::DeviceMemory) -> Option<usize> {
        self.mapped.lock().unwrap_or_else(PoisonError::into_inner).get(&memory).map(|mapping| mapping.address)
    }

    /// Memory is mapped from its beginning from now on.
    fn map(&self, memory: vk::DeviceMemory, address: usize) {
        self.mapped.lock().unwrap_or_else(PoisonError::into_inner).insert(memory, Mapping { address });
    }
}

/// Buffers with these uses can hold matrices, or bring them.
fn may_hold_matrices(usage: vk::BufferUsageFlags) -> bool {
    use vk::BufferUsageFlags as U;
    usage.intersects(U::UNIFORM_BUFFER | U::STORAGE_BUFFER | U::TRANSFER_SRC)
}

hooks! { memory;
    [c"vkCreateBuffer"] create_buffer: vk::PFN_vkCreateBuffer = (
        device: vk::Device, info: *const vk::BufferCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, buffer: *mut vk::Buffer
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, buffer);
        if result == vk::Result::SUCCESS && may_hold_matrices((*info).usage) {
            let new = Buffer { memory: vk::DeviceMemory::null(), offset: 0, size: (*info).size, written: Vec::new() };
            state.memory_of_program.buffers.lock().unwrap_or_else(PoisonError::into_inner).insert(*buffer, new);
        }
        result
    } }
    [c"vkDestroyBuffer"] destroy_buffer: vk::PFN_vkDestroyBuffer = (
        device: vk::Device, buffer: vk::Buffer, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.memory_of_program.buffers.lock().unwrap_or_else(PoisonError::into_inner).remove(&buffer);
        next(device, buffer, allocator)
    } }
    [c"vkBindBufferMemory"] bind_buffer_memory: vk::PFN_vkBindBufferMemory = (
        device: vk::Device, buffer: vk::Buffer, memory: vk::DeviceMemory, offset: vk::DeviceSize
    ) -> vk::Result { |state, next| {
        state.memory_of_program.bound(buffer, memory, offset);
        next(device, buffer, memory, offset)
    } }
    [c"vkBindBufferMemory2", c"vkBindBufferMemory2KHR"] bind_buffer_memory2: vk::PFN_vkBindBufferMemory2 = (
        device: vk::Device, count: u32, infos: *const vk::BindBufferMemoryInfo<'_>
    ) -> vk::Result { |state, next| {
        for info in crate::intercept::vk::slice(infos, count) {
            state.memory_of_program.bound(info.buffer, info.memory, info.memory_offset);
        }
        next(device, count, infos)
    } }
    [c"vkMapMemory"] map_memory: vk::PFN_vkMapMemory = (
        device: vk::Device, memory: vk::DeviceMemory, offset: vk::DeviceSize, size: vk::DeviceSize, flags: vk::MemoryMapFlags, data: *mut *mut std::ffi::c_void
    ) -> vk::Result { |state, next| {
        if let Some(address) = state.memory_of_program.address(memory) {
            *data = (address + offset as usize) as *mut _;
            return vk::Result::SUCCESS;
        }
        if !flags.is_empty() || next(device, memory, 0, vk::WHOLE_SIZE, flags, data) != vk::Result::SUCCESS {
            return next(device, memory, offset, size, flags, data);
        }
        let address = *data as usize;
        state.memory_of_program.map(memory, address);
        *data = (address + offset as usize) as *mut _;
        vk::Result::SUCCESS
    } }
    [c"vkMapMemory2KHR"] map_memory2: vk::PFN_vkMapMemory2KHR = (
        device: vk::Device, info: *const vk::MemoryMapInfoKHR<'_>, data: *mut *mut std::ffi::c_void
    ) -> vk::Result { |state, next| {
        let given = *info;
        if !given.p_next.is_null() || !given.flags.is_empty() {
            return next(device, info, data);
        }
        let address = match state.memory_of_program.address(given.memory) {
            Some(address) => address,
            None => {
                let whole = vk::MemoryMapInfoKHR { offset: 0, size: vk::WHOLE_SIZE, ..given };
                if next(device, &whole, data) != vk::Result::SUCCESS {
                    return next(device, info, data);
                }
                state.memory_of_program.map(given.memory, *data as usize);
                *data as usize
            }
        };
        *data = (address + given.offset as usize) as *mut _;
        vk::Result::SUCCESS
    } }
    [c"vkUnmapMemory"] unmap_memory: vk::PFN_vkUnmapMemory = (device: vk::Device, memory: vk::DeviceMemory) { |state, next| {
        if state.memory_of_program.address(memory).is_none() {
            next(device, memory);
        }
    } }
    [c"vkUnmapMemory2KHR"] unmap_memory2: vk::PFN_vkUnmapMemory2KHR = (
        device: vk::Device, info: *const vk::MemoryUnmapInfoKHR<'_>
    ) -> vk::Result { |state, next| {
        if state.memory_of_program.address((*info).memory).is_some() { vk::Result::SUCCESS } else { next(device, info) }
    } }
    [c"vkFreeMemory"] free_memory: vk::PFN_vkFreeMemory = (
        device: vk::Device, memory: vk::DeviceMemory, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        state.memory_of_program.mapped.lock().unwrap_or_else(PoisonError::into_inner).remove(&memory);
        next(device, memory, allocator)
    } }
}

#[cfg(test)]
mod tests {
    use super::{Buffer, Memory};
    use ash::vk::{self, Handle};

    fn with_buffer() -> (Memory, vk::Buffer) {
        let (memory, handle) = (Memory::default(), vk::Buffer::from_raw(7));
        let buffer = Buffer { memory: vk::DeviceMemory::from_raw(9), offset: 4, size: 64, written: Vec::new() };
        memory.buffers.lock().expect("no panic").insert(handle, buffer);
        (memory, handle)
    }

    #[test]
    fn mapped_memory_is_read_where_the_buffer_lies() {
        let (memory, buffer) = with_buffer();
        let bytes: Vec<u8> = (0..100).collect();
        let mut read = [0; 3];
        assert!(!memory.read(buffer, 2, &mut read), "nothing is mapped yet");
        memory.map(vk::DeviceMemory::from_raw(9), bytes.as_ptr() as usize);
        assert!(memory.read(buffer, 2, &mut read));
        assert_eq!(read, [6, 7, 8]);
        assert!(!memory.read(buffer, 62, &mut read), "beyond the buffer's end");
    }

    #[test]
    fn what_commands_wrote_last_counts() {
        let (memory, buffer) = with_buffer();
        memory.written(buffer, 8, vec![1; 8]);
        memory.written(buffer, 8, vec![2; 8]);
        memory.written(buffer, 24, vec![3; 8]);
        let mut read = [0; 4];
        assert!(memory.read(buffer, 10, &mut read) && read == [2; 4]);
        assert!(memory.read(buffer, 24, &mut read) && read == [3; 4]);
        assert!(!memory.read(buffer, 14, &mut read), "known in part only");
    }

    #[test]
    fn copies_are_followed() {
        let (memory, buffer) = with_buffer();
        memory.written(buffer, 0, (0..16).collect());
        let region = vk::BufferCopy { src_offset: 4, dst_offset: 40, size: 4 };
        memory.copied(buffer, buffer, &region);
        let mut read = [0; 4];
        assert!(memory.read(buffer, 40, &mut read) && read == [4, 5, 6, 7]);
    }
}
