//! Content of the program's buffers, as far as it is known on the host.

use crate::lock::Lock;
use ash::vk;
use std::collections::HashMap;
use std::sync::Mutex;

/// A buffer that shaders may read matrices from.
pub(in crate::intercept::vk) struct KnownBuffer {
    pub(in crate::intercept::vk) memory: vk::DeviceMemory,
    pub(in crate::intercept::vk) offset: u64,
    pub(in crate::intercept::vk) size: u64,
    /// Ranges that commands wrote, with the bytes that were written last.
    pub(in crate::intercept::vk) written: Vec<(u64, Vec<u8>)>,
}

/// The mapping of the program's memory, which Cupola keeps.
pub(in crate::intercept::vk) struct Mapping {
    pub(in crate::intercept::vk) address: usize,
}

/// Greatest number of bytes that are stored for one buffer.
pub(in crate::intercept::vk) const MOST_KEPT: u64 = 1 << 16;

/// Buffers and mapped memory.
#[derive(Default)]
pub struct HostMemory {
    pub(in crate::intercept::vk) buffers: Mutex<HashMap<vk::Buffer, KnownBuffer>>,
    pub(in crate::intercept::vk) mapped: Mutex<HashMap<vk::DeviceMemory, Mapping>>,
}

impl HostMemory {
    /// Reads the content of a buffer at `offset`. Returns `false` if it is unknown.
    pub fn read(&self, buffer: vk::Buffer, offset: u64, to: &mut [u8]) -> bool {
        let buffers = self.buffers.locked();
        let Some(state) = buffers.get(&buffer) else { return false };
        let Some(end) = offset.checked_add(to.len() as u64).filter(|end| *end <= state.size) else { return false };
        let kept = state.written.iter().rev().find(|(at, bytes)| *at <= offset && end <= at + bytes.len() as u64);
        if let Some((at, bytes)) = kept {
            let start = (offset - at) as usize;
            to.copy_from_slice(&bytes[start..start + to.len()]);
            return true;
        }
        let mapped = self.mapped.locked();
        let Some(mapping) = mapped.get(&state.memory) else { return false };
        let from = mapping.address + (state.offset + offset) as usize;
        // SAFETY: all of the memory is mapped, and the buffer lies in it.
        unsafe { std::ptr::copy_nonoverlapping(from as *const u8, to.as_mut_ptr(), to.len()) };
        true
    }

    /// Stores the bytes that a command writes to a buffer.
    pub fn written(&self, buffer: vk::Buffer, offset: u64, bytes: Vec<u8>) {
        let mut buffers = self.buffers.locked();
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

    /// Stores the bytes that a copy writes to a buffer, if both buffers are known.
    pub fn copied(&self, from: vk::Buffer, to: vk::Buffer, region: &vk::BufferCopy) {
        let wanted = self.buffers.locked().contains_key(&to);
        if !wanted || region.size > MOST_KEPT {
            return;
        }
        let mut bytes = vec![0; region.size as usize];
        if self.read(from, region.src_offset, &mut bytes) {
            self.written(to, region.dst_offset, bytes);
        }
    }

    pub(in crate::intercept::vk) fn bound(&self, buffer: vk::Buffer, memory: vk::DeviceMemory, offset: u64) {
        if let Some(state) = self.buffers.locked().get_mut(&buffer) {
            (state.memory, state.offset) = (memory, offset);
        }
    }

    /// Returns the address of memory that is already mapped.
    pub(in crate::intercept::vk) fn address(&self, memory: vk::DeviceMemory) -> Option<usize> {
        self.mapped.locked().get(&memory).map(|mapping| mapping.address)
    }

    /// Notes that memory is mapped completely from now on.
    pub(in crate::intercept::vk) fn map(&self, memory: vk::DeviceMemory, address: usize) {
        self.mapped.locked().insert(memory, Mapping { address });
    }
}

#[cfg(test)]
mod tests {
    use super::{HostMemory, KnownBuffer};
    use ash::vk::{self, Handle};

    fn with_buffer() -> (HostMemory, vk::Buffer) {
        let (memory, handle) = (HostMemory::default(), vk::Buffer::from_raw(7));
        let buffer = KnownBuffer { memory: vk::DeviceMemory::from_raw(9), offset: 4, size: 64, written: Vec::new() };
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
