//! Buffers of a group of contexts.

use std::collections::{HashMap, HashSet};

/// The buffers of a group of contexts.
#[derive(Default)]
pub struct Buffers {
    list: HashMap<u32, Buffer>,
    /// Names that OpenGL has given as names of bound buffers, and that were not deleted since.
    pub(in crate::intercept::gl) objects: HashSet<u32>,
    /// Number that grows with every change of a buffer.
    version: u64,
    /// Number that grows with every frame of any context.
    frame: u64,
    /// True if Cupola missed commands.
    lost: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::intercept::gl) struct Buffer {
    version: u64,
    /// The frame of its last change.
    changed: u64,
    known: bool,
}

/// Greatest number of buffers that are followed.
pub(in crate::intercept::gl) const MOST: usize = 1 << 16;

impl Buffers {
    /// Returns the version of a buffer's content, which differs after each change, and true if the
    /// content has outlasted a frame. `None`: the content may change without a call that Cupola
    /// sees.
    pub fn content(&self, name: u32) -> Option<(u64, bool)> {
        let buffer = self.list.get(&name).filter(|buffer| buffer.known && !self.lost)?;
        Some((buffer.version, buffer.changed < self.frame))
    }

    /// Notes the end of a frame.
    pub fn end_frame(&mut self) {
        self.frame += 1;
    }

    /// Returns the number of the frame.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// True if this is certainly a buffer's name.
    pub fn is_object(&self, name: u32) -> bool {
        self.objects.contains(&name)
    }

    /// Notes that a buffer of this name is bound, as OpenGL has answered.
    pub fn note_object(&mut self, name: u32) {
        if self.objects.len() < MOST {
            self.objects.insert(name);
        }
    }

    /// Notes that Cupola missed commands. From now on nothing is known about the buffers.
    pub fn lose(&mut self) {
        self.lost = true;
    }

    /// Notes that the buffer's content was written. `new`: it may have had none before.
    pub(in crate::intercept::gl) fn write(&mut self, name: u32, new: bool) {
        self.version += 1;
        let (version, changed) = (self.version, self.frame);
        if let Some(buffer) = self.list.get_mut(&name) {
            (buffer.version, buffer.changed) = (version, changed);
        } else if name != 0 && self.list.len() < MOST {
            self.list.insert(name, Buffer { version, changed, known: new });
        }
    }

    /// Notes that the buffer may change from now on without a call that Cupola sees.
    pub(in crate::intercept::gl) fn forget(&mut self, name: u32) {
        self.write(name, false);
        if let Some(buffer) = self.list.get_mut(&name) {
            buffer.known = false;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Buffers;

    #[test]
    fn a_buffer_is_known_from_its_storage_on_until_it_is_used_otherwise() {
        let mut buffers = Buffers::default();
        buffers.write(1, false);
        assert_eq!(buffers.content(1), None, "its storage was not seen");
        buffers.write(2, true);
        let (first, rests) = buffers.content(2).expect("known");
        assert!(!rests);
        buffers.end_frame();
        assert_eq!(buffers.content(2), Some((first, true)));
        buffers.write(2, false);
        let (second, rests) = buffers.content(2).expect("known");
        assert!(second != first && !rests);
        buffers.forget(2);
        buffers.write(2, true);
        assert_eq!(buffers.content(2), None, "a forgotten buffer stays unknown");
        assert_eq!(buffers.content(0), None);
        buffers.write(3, true);
        buffers.lose();
        assert_eq!(buffers.content(3), None);
    }
}
