//! The commands of one Begin/End, kept as they came and played back once per view.
//!
//! Values are not converted: each command is played back by the driver's own entry point that takes the same
//! components as an array, so that OpenGL's rules for integers, packed numbers and generic attributes are the
//! driver's. The memory is used again for the next Begin/End.

use super::super::culling::bounds::Bounds;
use super::commands::{self, Command};
use crate::backend::gl::api::{self, Gl};

/// What a command sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sets {
    /// A vertex, by its coordinates.
    Position,
    /// A vertex, whose coordinates only the driver knows.
    Vertex,
    /// The generic attribute of this number; number 0 is the position.
    Generic,
    /// … by numbers that the driver converts.
    ConvertedGeneric,
    /// The colour.
    Color,
    /// The secondary colour.
    SecondaryColor,
    /// The normal.
    Normal,
    /// The fog coordinate.
    Fog,
    /// The colour index.
    Index,
    /// The edge flag.
    EdgeFlag,
    /// The texture coordinates of the first unit.
    Texture,
    /// Those of the unit in the first parameter.
    TextureUnit,
    /// A property of the material.
    Material,
}

/// Units of texture coordinates, and generic attributes, that are told apart.
const NUMBERED: u64 = 27;

const COLOR: u64 = 1;
const NORMAL: u64 = 1 << 1;
const TEXTURE: u64 = 1 << 2;
/// What is not told apart.
const OTHER: u64 = 1 << 63;

impl Sets {
    /// Whether it makes a vertex.
    pub fn is_vertex(self, prefix: &[u64]) -> bool {
        let first = prefix.first().copied().unwrap_or(0);
        match self {
            Self::Position | Self::Vertex => true,
            Self::Generic | Self::ConvertedGeneric => first == 0,
            _ => false,
        }
    }

    /// The bit of what it sets.
    fn bit(self, prefix: &[u64]) -> u64 {
        let first = prefix.first().copied().unwrap_or(0);
        let numbered = |start: u64, number: u64| if number < NUMBERED { 1 << (start + number) } else { OTHER };
        match self {
            Self::Position | Self::Vertex => 0,
            Self::Material => OTHER,
            Self::Color => COLOR,
            Self::Normal => NORMAL,
            Self::Texture => TEXTURE,
            Self::SecondaryColor => 1 << 3,
            Self::Fog => 1 << 4,
            Self::Index => 1 << 5,
            Self::EdgeFlag => 1 << 6,
            Self::TextureUnit => match first.wrapping_sub(api::GL_TEXTURE0.into()) {
                0 => TEXTURE,
                unit => numbered(8, unit),
            },
            Self::Generic | Self::ConvertedGeneric => numbered(8 + NUMBERED, first),
        }
    }
}

/// A number of the program's.
pub trait Number: Copy {
    /// Its value.
    fn value(self) -> f64;
}

macro_rules! numbers {
    ($($t:ty)*) => { $( impl Number for $t {
        fn value(self) -> f64 {
            self as f64
        }
    } )* };
}
numbers!(f32 f64 i8 u8 i16 u16 i32 u32 i64 u64);

/// A box around a vertex of these numbers; missing coordinates are 0, 0, 1 as OpenGL says.
pub fn add_vertex<T: Number>(bounds: &mut Bounds, sets: Sets, values: &[T]) {
    if matches!(sets, Sets::Position | Sets::Generic) {
        let mut position = [0.0, 0.0, 0.0, 1.0];
        for (coordinate, value) in position.iter_mut().zip(values) {
            *coordinate = value.value();
        }
        bounds.add(position);
    } else {
        bounds.add_unknown();
    }
}

/// A command's head is one word: which command, how many words follow, and whether it makes a vertex.
const LENGTH: u32 = 16;
const VERTEX: u64 = 1 << 32;

/// What came since `glBegin`.
#[derive(Default)]
pub struct Recorder {
    /// Of each command its head, its parameters before the components (a word each), and the components.
    words: Vec<u64>,
    /// What was set since `glBegin`, a bit each.
    set: u64,
    vertices: bool,
    /// What was set only after a vertex.
    late: u64,
}

impl Recorder {
    /// Forgets everything but the memory.
    pub fn clear(&mut self) {
        self.words.clear();
        (self.set, self.vertices, self.late) = (0, false, 0);
    }

    /// Keeps a command, with its parameters before the components and those.
    #[inline]
    pub fn push<T: Number>(&mut self, command: Command, sets: Sets, prefix: &[u64], values: &[T]) {
        let vertex = sets.is_vertex(prefix);
        if vertex {
            self.vertices = true;
        } else {
            let bit = sets.bit(prefix);
            if bit == OTHER || (self.vertices && self.set & bit == 0) {
                self.late |= bit;
            }
            self.set |= bit;
        }
        let length = prefix.len() + size_of_val(values).div_ceil(size_of::<u64>());
        let head = command as u64 | (length as u64) << LENGTH | if vertex { VERTEX } else { 0 };
        self.words.reserve(1 + length);
        self.words.push(head);
        self.words.extend_from_slice(prefix);
        let start = self.words.len();
        self.words.resize(start + length - prefix.len(), 0);
        // SAFETY: the words from `start` on have room for the values, which are plain numbers.
        unsafe {
            let room = self.words.as_mut_ptr().add(start).cast::<u8>();
            std::ptr::copy_nonoverlapping(values.as_ptr().cast::<u8>(), room, size_of_val(values));
        }
    }

    /// Whether colour, normal and texture coordinate were set only after a vertex: playing back again would
    /// give them to the first vertices.
    pub fn sets_late(&self) -> [bool; 3] {
        [COLOR, NORMAL, TEXTURE].map(|bit| self.late & bit != 0)
    }

    /// The same for anything else.
    pub fn sets_others_late(&self) -> bool {
        self.late & !(COLOR | NORMAL | TEXTURE) != 0
    }

    /// Whether anything was set besides vertices.
    pub fn sets_anything(&self) -> bool {
        self.set != 0
    }

    /// Where the next command will be: a place to play back from.
    pub fn place(&self) -> usize {
        self.words.len()
    }

    /// Calls the driver with every command.
    ///
    /// # Safety
    /// The context of `gl` must be current, between Begin and End.
    pub unsafe fn play(&self, gl: &Gl) {
        // SAFETY: as promised.
        unsafe { self.play_from(gl, 0, true) };
    }

    /// Calls the driver with the commands from the place `start` on that make no vertex.
    ///
    /// # Safety
    /// The context of `gl` must be current.
    pub unsafe fn play_attributes(&self, gl: &Gl, start: usize) {
        // SAFETY: as promised.
        unsafe { self.play_from(gl, start, false) };
    }

    unsafe fn play_from(&self, gl: &Gl, start: usize, vertices: bool) {
        let mut rest = self.words.get(start..).unwrap_or_default();
        while let [head, after @ ..] = rest {
            let length = (head >> LENGTH) as u16 as usize;
            let Some((values, next)) = after.split_at_checked(length) else { return };
            if vertices || head & VERTEX == 0 {
                // SAFETY: the words that `push` kept for this command.
                unsafe { commands::play(gl, *head as u16, values.as_ptr()) };
            }
            rest = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::commands::Command;
    use super::{Recorder, Sets};

    #[test]
    fn what_comes_only_after_a_vertex_is_late() {
        let mut recorder = Recorder::default();
        recorder.push(Command::color3fv, Sets::Color, &[], &[1.0f32; 3]);
        recorder.push(Command::vertex3fv, Sets::Position, &[], &[1.0f32; 3]);
        recorder.push(Command::color3fv, Sets::Color, &[], &[0.0f32; 3]);
        assert_eq!((recorder.sets_late(), recorder.sets_others_late()), ([false; 3], false));
        recorder.push(Command::normal3fv, Sets::Normal, &[], &[0.0f32; 3]);
        recorder.push(Command::multi_tex_coord2fv, Sets::TextureUnit, &[0x84C0], &[0.0f32; 2]);
        assert_eq!((recorder.sets_late(), recorder.sets_others_late()), ([false, true, true], false));
        recorder.push(Command::vertex_attrib1fv, Sets::Generic, &[3], &[0.0f32]);
        assert!(recorder.sets_others_late());
        recorder.clear();
        assert!(!recorder.sets_anything() && !recorder.sets_others_late());
    }

    #[test]
    fn materials_and_high_numbers_are_always_late() {
        for (sets, prefix) in [(Sets::Material, [0x408, 0x1600]), (Sets::Generic, [999, 0])] {
            let mut recorder = Recorder::default();
            recorder.push(Command::vertex_attrib4fv, sets, &prefix, &[0.0f32; 4]);
            assert!(recorder.sets_others_late(), "{sets:?}");
        }
    }

    #[test]
    fn generic_attribute_0_is_a_vertex() {
        assert!(Sets::Generic.is_vertex(&[0]) && !Sets::Generic.is_vertex(&[1]));
        assert!(!Sets::Color.is_vertex(&[]));
    }

    /// The memory of one Begin/End serves the next.
    #[test]
    fn nothing_is_allocated_again() {
        let mut recorder = Recorder::default();
        let fill = |recorder: &mut Recorder| {
            for _ in 0..100 {
                recorder.push(Command::vertex_attrib4_nubv, Sets::ConvertedGeneric, &[0], &[1u8, 2, 3, 4]);
            }
        };
        fill(&mut recorder);
        let (length, memory) = (recorder.place(), recorder.words.as_ptr());
        assert_eq!(length, 300);
        recorder.clear();
        fill(&mut recorder);
        assert_eq!((recorder.place(), recorder.words.as_ptr()), (length, memory));
    }
}
