//! Pictures between nodes, and their transport: node 0 sends them, the others are its mirrors.

use cupola::ring::layout::NAME_BYTES;
use std::time::Duration;

/// Number of words of a head.
pub const WORDS: usize = 5 + NAME_BYTES / 8;

/// Greatest width and height of a picture, pixels.
const LARGEST: u32 = 16384;

/// Greatest number of bytes for the names of a mirror's outputs.
const NAMES: usize = 1 << 16;

/// Interval at which node 0 sends something, even if there is no new frame.
pub const ALIVE: Duration = Duration::from_secs(1);

/// Time without a message after which the connection counts as lost.
pub const SILENCE: Duration = Duration::from_secs(10);

/// A message that precedes bytes.
#[derive(Clone, Debug, PartialEq)]
pub enum Head {
    /// To node 0: names of the mirror's outputs. The bytes are the names, with line ends between
    /// them.
    Outputs { bytes: usize },
    /// From node 0: a picture. The bytes are its pixels, 4 for each. `left`: number of pictures of
    /// the same frame that follow.
    Picture { frame: u64, left: u64, size: (u32, u32), name: String },
    /// From node 0: there is no new frame.
    Alive,
    /// From node 0: its program has ended.
    End,
}

impl Head {
    /// Encodes the head as numbers.
    pub fn words(&self) -> [u64; WORDS] {
        let mut words = [0; WORDS];
        match self {
            Self::Outputs { bytes } => words[..2].copy_from_slice(&[1, *bytes as u64]),
            Self::Picture { frame, left, size, name } => {
                words[..5].copy_from_slice(&[2, *frame, *left, size.0.into(), size.1.into()]);
                let mut bytes = [0; NAME_BYTES];
                let end = name.floor_char_boundary(NAME_BYTES);
                bytes[..end].copy_from_slice(&name.as_bytes()[..end]);
                for (word, bytes) in words[5..].iter_mut().zip(bytes.as_chunks::<8>().0) {
                    *word = u64::from_ne_bytes(*bytes);
                }
            }
            Self::Alive => words[0] = 3,
            Self::End => words[0] = 4,
        }
        words
    }

    /// Decodes a head; `None` for one of another release, or with bytes beyond the limits.
    pub fn of(words: [u64; WORDS]) -> Option<Self> {
        let side = |word: u64| u32::try_from(word).ok().filter(|side| *side <= LARGEST);
        Some(match words[0] {
            1 => Self::Outputs { bytes: usize::try_from(words[1]).ok().filter(|bytes| *bytes <= NAMES)? },
            2 => {
                let bytes: Vec<u8> = words[5..].iter().flat_map(|word| word.to_ne_bytes()).collect();
                let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(NAME_BYTES);
                let name = String::from_utf8_lossy(&bytes[..end]).into_owned();
                Self::Picture { frame: words[1], left: words[2], size: (side(words[3])?, side(words[4])?), name }
            }
            3 => Self::Alive,
            4 => Self::End,
            _ => return None,
        })
    }

    /// Number of bytes that follow the head.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Outputs { bytes } => *bytes,
            Self::Picture { size: (width, height), .. } => *width as usize * *height as usize * 4,
            Self::Alive | Self::End => 0,
        }
    }
}

/// Connection of node 0 with each mirror. One thread of a node sends to another node, and one
/// receives from it.
pub trait PictureLink: Send + Sync {
    /// Sends a head and its bytes, and waits until the other node has received them; returns false
    /// if the connection is lost. A node that is stopped holds up only this call.
    fn send(&self, to: usize, head: &Head, bytes: &[u8]) -> bool;

    /// Waits for a head of another node, and replaces `bytes` by its bytes. `None`: the connection
    /// is lost or closed.
    fn receive(&self, from: usize, bytes: &mut Vec<u8>) -> Option<Head>;

    /// Ends sending and receiving. `is_clean`: no node was lost.
    fn close(&self, is_clean: bool);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_come_out_as_they_went_in() {
        let picture = |name: &str| Head::Picture { frame: 1, left: 2, size: (3, 4), name: name.into() };
        let long = "é".repeat(NAME_BYTES / 2);
        for head in [Head::Outputs { bytes: 5 }, picture("left"), picture(&long), Head::Alive, Head::End] {
            assert_eq!(Head::of(head.words()), Some(head));
        }
        assert_eq!(Head::of(picture(&format!("a{long}")).words()).map(|head| head.bytes()), Some(3 * 4 * 4));
        let too_large = Head::Picture { frame: 0, left: 0, size: (LARGEST + 1, 1), name: String::new() };
        for wrong in [[9; WORDS], Head::Outputs { bytes: NAMES + 1 }.words(), too_large.words()] {
            assert_eq!(Head::of(wrong), None);
        }
    }
}
