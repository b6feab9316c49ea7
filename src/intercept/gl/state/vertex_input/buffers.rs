//! Buffers of a group of contexts.

use std::collections::{HashMap, HashSet};

/// The buffers of a group of contexts.
#[derive(Default)]
pub struct Buffers {
    list: HashMap<u32, Buffer>,
    /// Names that OpenGL has given as those of buffers, not deleted since.
    pub(in crate::intercept::gl) objects: HashSet<u32>,
    /// Grows with every change of a buffer.
    version: u64,
    /// Grows with every frame of any context.
    frame: u64,
    /// Something went on unseen.
    lost: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::intercept::gl) struct Buffer {
    version: u64,
    /// The frame of its last change.
    changed: u64,
    known: bool,
}

/// More buffers are not followed.
pub(in crate::intercept::gl) const MOST: usize = 1 << 16;

impl Buffers {
    /// The version of a buffer's content, another one after each change, and whether it has
    /// outlasted a frame. `None`: it may change unseen.
    pub fn content(&self, name: u32) -> Option<(u64, bool)> {
        let buffer = self.list.get(&name).filter(|buffer| buffer.known && !self.lost)?;
        Some((buffer.version, buffer.changed < self.frame))
    }

    /// A frame ended.
    pub fn end_frame(&mut self) {
        self.frame += 1;
    }

    /// The number of the frame.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// True if this is certainly a buffer's name.
    pub fn is_object(&self, name: u32) -> bool {
        self.objects.contains(&name)
    }

    /// OpenGL has said that a buffer of this name is bound.
    pub fn note_object(&mut self, name: u32) {
        if self.objects.len() < MOST {
            self.objects.insert(name);
        }
    }

    /// Commands were not seen: nothing is known from now on.
    pub fn lose(&mut self) {
        self.lost = true;
    }

    /// The buffer's content was written. `new`: it may have had none before.
    pub(in crate::intercept::gl) fn write(&mut self, name: u32, new: bool) {
        self.version += 1;
        let (version, changed) = (self.version, self.frame);
        if let Some(buffer) = self.list.get_mut(&name) {
            (buffer.version, buffer.changed) = (version, changed);
        } else if name != 0 && self.list.len() < MOST {
            self.list.insert(name, Buffer { version, changed, known: new });
        }
    }

    /// The buffer may change unseen from now on.
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
        assert_eq!(buffers.content(2), None, "a name that came back");
        assert_eq!(buffers.content(0), None);
        buffers.write(3, true);
        buffers.lose();
        assert_eq!(buffers.content(3), None);
    }
}
