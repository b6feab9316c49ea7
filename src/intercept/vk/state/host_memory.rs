//! Content of the program's buffers, as far as it is known on the host.

use crate::lock::Lock;
use ash::vk;
use std::collections::{BTreeMap, HashMap};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// A buffer that shaders may read matrices from.
pub(in crate::intercept::vk) struct KnownBuffer {
    pub(in crate::intercept::vk) memory: vk::DeviceMemory,
    pub(in crate::intercept::vk) offset: u64,
    pub(in crate::intercept::vk) size: u64,
    /// True if shaders read it only as vertex attributes, which seldom hold the camera's matrix.
    pub(in crate::intercept::vk) of_vertices: bool,
    /// Ranges that commands wrote, with the bytes that were written last.
    pub(in crate::intercept::vk) written: Vec<(u64, Vec<u8>)>,
}

/// The mapping of the program's memory, which Cupola keeps.
pub(in crate::intercept::vk) struct Mapping {
    pub(in crate::intercept::vk) address: usize,
}

/// Greatest number of bytes that are stored for one buffer.
pub(in crate::intercept::vk) const MOST_KEPT: u64 = 1 << 16;

/// A copy between buffers that is too large to be stored. Of its bytes those are stored that somebody
/// reads.
#[derive(Clone, Copy)]
struct LargeCopy {
    from: vk::Buffer,
    to: vk::Buffer,
    region: vk::BufferCopy,
}

impl LargeCopy {
    /// Returns the place in the source of what is copied to `offset`, up to `end`.
    fn source(&self, buffer: vk::Buffer, offset: u64, end: u64) -> Option<(vk::Buffer, u64)> {
        let start = offset.checked_sub(self.region.dst_offset).filter(|_| self.to == buffer)?;
        (end - self.region.dst_offset <= self.region.size).then_some((self.from, self.region.src_offset + start))
    }
}

/// Greatest number of large copies that are known.
const MOST_LARGE_COPIES: usize = 256;

/// Buffers and mapped memory.
#[derive(Default)]
pub struct HostMemory {
    pub(in crate::intercept::vk) buffers: Mutex<HashMap<vk::Buffer, KnownBuffer>>,
    pub(in crate::intercept::vk) mapped: Mutex<HashMap<vk::DeviceMemory, Mapping>>,
    /// Buffers by the addresses that the program has asked for.
    addresses: Mutex<BTreeMap<u64, vk::Buffer>>,
    /// True if a pipeline has a matrix among its attributes. What is copied to buffers of vertices
    /// is kept from then on.
    keeps_vertices: AtomicBool,
    /// Large copies of this frame, in their order: their sources may get other content after it.
    large_copies: Mutex<Vec<LargeCopy>>,
}

impl HostMemory {
    /// Reads the content of a buffer at `offset`. Returns `false` if it is unknown.
    pub fn read(&self, buffer: vk::Buffer, offset: u64, to: &mut [u8]) -> bool {
        self.read_after(buffer, offset, to, MOST_LARGE_COPIES)
    }

    /// Reads what a buffer holds after the first `copies` large copies.
    fn read_after(&self, buffer: vk::Buffer, offset: u64, to: &mut [u8], copies: usize) -> bool {
        let buffers = self.buffers.locked();
        let Some(state) = buffers.get(&buffer) else { return false };
        let Some(end) = offset.checked_add(to.len() as u64).filter(|end| *end <= state.size) else { return false };
        let kept = state.written.iter().rev().find(|(at, bytes)| *at <= offset && end <= at + bytes.len() as u64);
        if let Some((at, bytes)) = kept {
            let start = (offset - at) as usize;
            to.copy_from_slice(&bytes[start..start + to.len()]);
            return true;
        }
        let source = self.large_copies.locked().iter().enumerate().take(copies).rev().find_map(|(index, copy)| {
            let (from, start) = copy.source(buffer, offset, end)?;
            Some((from, start, index))
        });
        if let Some((from, start, earlier)) = source {
            drop(buffers);
            let is_known = self.read_after(from, start, to, earlier);
            if is_known {
                self.written(buffer, offset, to.to_vec());
            }
            return is_known;
        }
        let mapped = self.mapped.locked();
        let Some(mapping) = mapped.get(&state.memory) else { return false };
        let from = mapping.address + (state.offset + offset) as usize;
        // SAFETY: all of the memory is mapped, and the buffer lies in it.
        unsafe { std::ptr::copy_nonoverlapping(from as *const u8, to.as_mut_ptr(), to.len()) };
        true
    }

    /// Keeps what is copied to buffers of vertices from now on.
    pub fn keep_vertices(&self) {
        self.keeps_vertices.store(true, Ordering::Relaxed);
    }

    fn keeps(&self, buffer: &KnownBuffer) -> bool {
        !buffer.of_vertices || self.keeps_vertices.load(Ordering::Relaxed)
    }

    /// Notes the address of a buffer.
    pub fn note_address(&self, address: u64, buffer: vk::Buffer) {
        self.addresses.locked().insert(address, buffer);
    }

    /// Returns the buffer that an address lies in, and the offset in it.
    pub fn at_address(&self, address: u64) -> Option<(vk::Buffer, u64)> {
        let (start, buffer) = self.addresses.locked().range(..=address).next_back().map(|(s, b)| (*s, *b))?;
        let size = self.buffers.locked().get(&buffer)?.size;
        (address - start < size).then_some((buffer, address - start))
    }

    /// Forgets a buffer that is destroyed.
    pub fn forget(&self, buffer: vk::Buffer) {
        self.buffers.locked().remove(&buffer);
        self.large_copies.locked().retain(|copy| copy.from != buffer && copy.to != buffer);
        self.addresses.locked().retain(|_, known| *known != buffer);
    }

    /// Stores the bytes that a command writes to a buffer.
    pub fn written(&self, buffer: vk::Buffer, offset: u64, bytes: Vec<u8>) {
        let mut buffers = self.buffers.locked();
        let Some(state) = buffers.get_mut(&buffer).filter(|buffer| self.keeps(buffer)) else { return };
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
        let wanted = self.buffers.locked().get(&to).is_some_and(|buffer| self.keeps(buffer));
        if !wanted {
            return;
        }
        if region.size > MOST_KEPT {
            return self.copied_much(LargeCopy { from, to, region: *region });
        }
        let mut bytes = vec![0; region.size as usize];
        if self.read(from, region.src_offset, &mut bytes) {
            self.written(to, region.dst_offset, bytes);
        }
    }

    /// Notes a large copy, and stores those of its bytes that were stored before.
    fn copied_much(&self, copy: LargeCopy) {
        let LargeCopy { to, region, .. } = copy;
        let mut stored = Vec::new();
        if let Some(state) = self.buffers.locked().get_mut(&to) {
            let copied = region.dst_offset..region.dst_offset.saturating_add(region.size);
            state.written.retain(|(at, bytes)| {
                let end = at + bytes.len() as u64;
                if copied.start <= *at && end <= copied.end {
                    stored.push((*at, bytes.len()));
                }
                end <= copied.start || copied.end <= *at
            });
        }
        let mut copies = self.large_copies.locked();
        if copies.len() == MOST_LARGE_COPIES {
            copies.remove(0);
        }
        copies.push(copy);
        drop(copies);
        for (at, length) in stored {
            self.read(to, at, &mut vec![0; length]);
        }
    }

    /// Ends a frame: the program may write to the sources of its copies.
    pub fn end_frame(&self) {
        self.large_copies.locked().clear();
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
    use super::{HostMemory, KnownBuffer, MOST_KEPT};
    use ash::vk::{self, Handle};

    fn with_buffer() -> (HostMemory, vk::Buffer) {
        let (memory, handle) = (HostMemory::default(), vk::Buffer::from_raw(7));
        let (of, size) = (vk::DeviceMemory::from_raw(9), 64);
        let buffer = KnownBuffer { memory: of, offset: 4, size, of_vertices: false, written: Vec::new() };
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
    fn an_address_belongs_to_the_buffer_that_it_lies_in() {
        let (memory, buffer) = with_buffer();
        memory.note_address(1000, buffer);
        assert_eq!(memory.at_address(1010), Some((buffer, 10)));
        assert_eq!((memory.at_address(999), memory.at_address(1064)), (None, None));
        memory.forget(buffer);
        assert_eq!(memory.at_address(1010), None);
    }

    #[test]
    fn copies_to_vertices_are_kept_only_if_they_are_needed() {
        let (memory, buffer) = with_buffer();
        memory.buffers.lock().expect("no panic").get_mut(&buffer).expect("known").of_vertices = true;
        memory.written(buffer, 0, vec![1; 8]);
        let mut read = [0; 4];
        assert!(!memory.read(buffer, 0, &mut read));
        memory.keep_vertices();
        memory.written(buffer, 0, vec![1; 8]);
        assert!(memory.read(buffer, 0, &mut read));
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

    #[test]
    fn of_large_copies_is_stored_what_is_read() {
        let [from, to, last] = [1, 2, 3].map(vk::Buffer::from_raw);
        let [host, device] = [4, 5].map(vk::DeviceMemory::from_raw);
        let (memory, size) = (HostMemory::default(), 2 * MOST_KEPT);
        for (handle, of) in [(from, host), (to, device), (last, device)] {
            let buffer = KnownBuffer { memory: of, offset: 0, size, of_vertices: false, written: Vec::new() };
            memory.buffers.lock().expect("no panic").insert(handle, buffer);
        }
        let mut bytes: Vec<u8> = (0..size).map(|at| (at % 251) as u8).collect();
        memory.map(host, bytes.as_mut_ptr() as usize);
        let region = vk::BufferCopy { src_offset: 8, dst_offset: 16, size: size - 16 };
        let read = |at: u64| {
            let mut read = [0; 4];
            memory.read(to, at, &mut read).then_some(read)
        };
        assert_eq!(read(100), None, "nothing was copied yet");
        memory.written(to, 14, vec![9; 4]);
        memory.copied(from, to, &region);
        assert_eq!(read(100), Some([92, 93, 94, 95]));
        assert_eq!([read(8), read(size - 2)], [None, None], "beside the copy");
        assert_eq!(read(14), None, "written before the copy, which covers half of it");
        memory.end_frame();
        bytes.fill(7);
        assert_eq!((read(100), read(200)), (Some([92, 93, 94, 95]), None), "the copy's content stays");
        memory.copied(from, to, &region);
        memory.end_frame();
        assert_eq!(read(100), Some([7; 4]), "what was read once is stored by each copy");
        memory.copied(from, to, &region);
        memory.copied(to, last, &region);
        let mut copied = [0; 4];
        assert!(memory.read(last, 500, &mut copied) && copied == [7; 4], "through both copies");
        assert!(memory.buffers.lock().expect("no panic")[&to].written.len() < 4);
    }
}
