//! Messages between the nodes, and their transport.

use super::agreed::Agreed;
use super::input::Event;
use cupola::nodes::Arrival;

/// Words of a message.
pub const WORDS: usize = 6;

/// A message between nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Message {
    /// To node 0: the program is at the end of a frame.
    Arrived(Arrival),
    /// To node 0: the program has ended; `well`: by itself and without an error.
    Gone { well: bool },
    /// From node 0: frames up to this number may be shown. `time` is the program's time after it; 0
    /// leaves it open.
    Release { frame: u64, time: u64 },
    /// From node 0: its program has ended, and the others have to end.
    End,
    /// From node 0: all nodes have ended. `is_clean`: each of them has said so.
    Over { is_clean: bool },
    /// From node 0, before the release of this frame: what reaches the program at its end.
    Input { frame: u64, event: Event },
    /// From node 0, first of all: the settings of all programs.
    Settings(Agreed),
}

impl Message {
    /// Encodes the message as numbers.
    pub fn words(&self) -> [u64; WORDS] {
        match *self {
            Self::Arrived(Arrival { frame, digest, time, went, size: (width, height) }) => {
                [1, frame, digest, time, went, u64::from(width) << 32 | u64::from(height)]
            }
            Self::Gone { well } => [2, well.into(), 0, 0, 0, 0],
            Self::Release { frame, time } => [3, frame, time, 0, 0, 0],
            Self::End => [4, 0, 0, 0, 0, 0],
            Self::Over { is_clean } => [5, is_clean.into(), 0, 0, 0, 0],
            Self::Input { frame, event } => {
                let [kind, first, second] = event.words();
                [6, frame, kind, first, second, 0]
            }
            Self::Settings(settings) => {
                let [rate, seed, start, size] = settings.words();
                [7, rate, seed, start, size, 0]
            }
        }
    }

    /// Decodes a message; `None` for one of another release.
    pub fn of(words: [u64; WORDS]) -> Option<Self> {
        let [kind, frame, digest, time, went, size] = words;
        Some(match kind {
            1 => Self::Arrived(Arrival { frame, digest, time, went, size: ((size >> 32) as u32, size as u32) }),
            2 => Self::Gone { well: frame != 0 },
            3 => Self::Release { frame, time: digest },
            4 => Self::End,
            5 => Self::Over { is_clean: frame != 0 },
            6 => Self::Input { frame, event: Event::of([digest, time, went])? },
            7 => Self::Settings(Agreed::of([frame, digest, time, went])),
            _ => return None,
        })
    }
}

/// Connection from this node to others. Node 0 is connected to all, the others to node 0.
pub trait Link: Send + Sync {
    /// Sends messages in their order without waiting until they are received. Does nothing if the
    /// connection is lost.
    fn send(&self, to: usize, messages: &[Message]);

    /// True if all nodes are on this machine, and share one clock.
    fn is_one_machine(&self) -> bool;

    /// Ends sending. `is_clean`: no node was lost.
    fn close(&self, is_clean: bool);
}

/// Callback for messages of a node; `None`: its connection is lost.
pub type Deliver = dyn Fn(usize, Option<Message>) + Send + Sync;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_come_out_as_they_went_in() {
        let arrival = Arrival { frame: 1, digest: 2, time: 3, went: 4, size: (5, 6) };
        let over = Message::Over { is_clean: true };
        let release = Message::Release { frame: 7, time: 8 };
        let input = Message::Input { frame: 9, event: Event::Shift { x: -1, y: 2 } };
        let gone = Message::Gone { well: true };
        let settings = Message::Settings(Agreed::of([60 << 32 | 1, 7, 8, 9 << 32 | 10]));
        for message in [Message::Arrived(arrival), gone, release, Message::End, over, input, settings] {
            assert_eq!(Message::of(message.words()), Some(message));
        }
        assert_eq!(Message::of([9, 0, 0, 0, 0, 0]), None);
    }
}
