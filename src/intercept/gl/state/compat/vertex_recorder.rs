//! The commands of one Begin/End, stored in their order and played back once per view.
//!
//! Values are not converted. Each command is played back by the driver's entry point that takes the
//! same components as an array. The driver thus applies OpenGL's rules for integers, packed numbers
//! and generic attributes. The next Begin/End uses the memory again.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::compat::vertex_commands::{self, VertexCommand};
use crate::intercept::gl::state::draw::bounds::Bounds;

/// Value that a command sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Sets {
    /// A vertex, by its coordinates.
    Position,
    /// A vertex, whose coordinates only the driver knows.
    Vertex,
    /// The generic attribute of this number; number 0 is the position.
    Generic,
    /// A generic attribute, by numbers that the driver converts.
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
    /// The texture coordinates of the unit in the first parameter.
    TextureUnit,
    /// A property of the material.
    Material,
}

/// Number of texture units, and of generic attributes, that have a bit of their own.
const NUMBERED: u64 = 27;
const COLOR: u64 = 1;
const NORMAL: u64 = 1 << 1;
const TEXTURE: u64 = 1 << 2;

/// Bit of all values that have no bit of their own.
const OTHER: u64 = 1 << 63;

impl Sets {
    /// All values, in the order of their numbers.
    const ALL: [Self; 13] = [
        Self::Position,
        Self::Vertex,
        Self::Generic,
        Self::ConvertedGeneric,
        Self::Color,
        Self::SecondaryColor,
        Self::Normal,
        Self::Fog,
        Self::Index,
        Self::EdgeFlag,
        Self::Texture,
        Self::TextureUnit,
        Self::Material,
    ];

    /// True if the command makes a vertex.
    pub fn is_vertex(self, prefix: &[u64]) -> bool {
        let first = prefix.first().copied().unwrap_or(0);
        match self {
            Self::Position | Self::Vertex => true,
            Self::Generic | Self::ConvertedGeneric => first == 0,
            _ => false,
        }
    }

    /// Returns the bit of the value that the command sets.
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

/// A number that the program passes to a command.
pub trait Number: Copy {
    /// Index of the type in `READ`.
    const KIND: u8;

    /// Returns the number's value.
    fn value(self) -> f64;
}

/// Function that reads a number of one type. Returns its value, and the value that it has as a part
/// of 1 if it is a normalised integer.
///
/// # Safety
/// The address must be that of a number of this type.
type Read = unsafe fn(*const u8) -> (f64, f64);

macro_rules! numbers {
    ($($kind:literal $t:ident $part:expr;)*) => {
        $( impl Number for $t {
            const KIND: u8 = $kind;

            fn value(self) -> f64 {
                self as f64
            }
        } )*
        static READ: &[Read] = &[$( |at| {
            // SAFETY: as the type `Read` requires; the address may have any alignment.
            let value = unsafe { at.cast::<$t>().read_unaligned() }.value();
            let part: fn(f64) -> f64 = $part;
            (value, part(value))
        }, )*];
    };
}

// Values of normalised integers, as in colours and normals: OpenGL 2.1, table 2.9.
numbers! {
    0 f32 |c| c;
    1 f64 |c| c;
    2 i8 |c| (2.0 * c + 1.0) / 255.0;
    3 u8 |c| c / 255.0;
    4 i16 |c| (2.0 * c + 1.0) / 65_535.0;
    5 u16 |c| c / 65_535.0;
    6 i32 |c| (2.0 * c + 1.0) / 4_294_967_295.0;
    7 u32 |c| c / 4_294_967_295.0;
    8 i64 |c| c;
    9 u64 |c| c;
}

/// Extends the box to a vertex of these numbers. Missing coordinates are 0, 0, 1, as in OpenGL.
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

/// Layout of a command's head, which is one word: the command, the number of words that follow, a
/// bit for vertices, the type of the components, the value that the command sets, the number of
/// components, and the number of words before them.
const LENGTH: u32 = 16;
const VERTEX: u64 = 1 << 32;
const KIND: u32 = 33;
const SETS: u32 = 37;
const COUNT: u32 = 41;
const BEFORE: u32 = 45;

/// Bit of a command that calls a display list of the driver. The name of the list follows.
const LIST: u64 = 1 << 48;

/// A command that was recorded.
#[derive(Clone, Copy, Debug)]
pub struct Recorded<'a> {
    /// Value that the command sets.
    pub sets: Sets,
    /// First parameter before the components: a unit, or the number of an attribute; 0 if there is
    /// none.
    pub prefix: u64,
    /// Number of components.
    pub count: usize,
    /// True if the components are plain numbers.
    pub plain: bool,
    vertex: bool,
    kind: u8,
    components: &'a [u64],
}

impl Recorded<'_> {
    /// True if the command makes a vertex.
    pub fn is_vertex(&self) -> bool {
        self.vertex
    }

    /// Returns a component. `normalised`: integers count as parts of 1.
    pub fn number(&self, index: usize, normalised: bool) -> Option<f64> {
        let read = READ.get(usize::from(self.kind))?;
        // The largest types fill a word.
        let width = [4, 8, 1, 1, 2, 2, 4, 4, 8, 8].get(usize::from(self.kind))?;
        if index >= self.count || (index + 1) * width > size_of_val(self.components) {
            return None;
        }
        // SAFETY: the address is inside the components; `push` stored their type.
        let (value, part) = unsafe { read(self.components.as_ptr().cast::<u8>().add(index * width)) };
        Some(if normalised { part } else { value })
    }
}

/// Commands since `glBegin`.
#[derive(Default)]
pub struct Recorder {
    /// For each command: its head, its parameters before the components (a word each), and the
    /// components.
    words: Vec<u64>,
    /// Values that were set since `glBegin`, a bit each.
    set: u64,
    vertices: bool,
    /// Values that were set only after a vertex, a bit each.
    late: u64,
    /// True if there are display lists among the commands.
    lists: bool,
}

impl Recorder {
    /// Removes all commands. The memory stays allocated.
    pub fn clear(&mut self) {
        self.words.clear();
        (self.set, self.vertices, self.late, self.lists) = (0, false, 0, false);
    }

    /// Stores a command with its parameters before the components (`prefix`) and its components
    /// (`values`).
    #[inline]
    pub fn push<T: Number>(&mut self, command: VertexCommand, sets: Sets, prefix: &[u64], values: &[T]) {
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
        let head = command as u64
            | (length as u64) << LENGTH
            | if vertex { VERTEX } else { 0 }
            | u64::from(T::KIND) << KIND
            | (sets as u64) << SETS
            | (values.len() as u64) << COUNT
            | (prefix.len() as u64) << BEFORE;
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

    /// Stores a display list of the driver, which may make vertices and set any attribute.
    pub fn push_list(&mut self, list: u32) {
        (self.vertices, self.lists) = (true, true);
        (self.set, self.late) = (u64::MAX, u64::MAX);
        self.words.push(1 << LENGTH | VERTEX | (Sets::Vertex as u64) << SETS | LIST);
        self.words.push(list.into());
    }

    /// True if there are display lists among the commands.
    pub fn has_lists(&self) -> bool {
        self.lists
    }

    /// True for colour, normal and texture coordinate if they were set only after a vertex. If the
    /// commands were played back again, the first vertices would get these values.
    pub fn sets_late(&self) -> [bool; 3] {
        [COLOR, NORMAL, TEXTURE].map(|bit| self.late & bit != 0)
    }

    /// True if any other value may have been set only after a vertex.
    pub fn sets_others_late(&self) -> bool {
        self.late & !(COLOR | NORMAL | TEXTURE) != 0
    }

    /// True if anything was set besides vertices.
    pub fn sets_anything(&self) -> bool {
        self.set != 0
    }

    /// Returns the position of the next command in the memory, from which commands can be played
    /// back.
    pub fn place(&self) -> usize {
        self.words.len()
    }

    /// Returns the commands in their order.
    pub fn commands(&self) -> impl Iterator<Item = Recorded<'_>> {
        let mut rest = self.words.as_slice();
        std::iter::from_fn(move || {
            let (head, after) = rest.split_first()?;
            let (words, next) = after.split_at_checked((head >> LENGTH) as u16 as usize)?;
            rest = next;
            let (prefix, components) = words.split_at_checked((head >> BEFORE & 7) as usize)?;
            Some(Recorded {
                sets: *Sets::ALL.get((head >> SETS & 15) as usize)?,
                prefix: prefix.first().copied().unwrap_or(0),
                count: (head >> COUNT & 15) as usize,
                plain: vertex_commands::is_plain(*head as u16),
                vertex: head & VERTEX != 0,
                kind: (head >> KIND & 15) as u8,
                components,
            })
        })
    }

    /// Calls the driver with every command.
    ///
    /// # Safety
    /// The context of `gl` must be current, between Begin and End.
    pub unsafe fn play(&self, gl: &Gl) {
        // SAFETY: as promised.
        unsafe { self.play_from(gl, 0, true) };
    }

    /// Calls the driver with the commands from position `start` on that make no vertex.
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
            // SAFETY: the words that `push` and `push_list` stored for this command.
            match values {
                [list] if vertices && head & LIST != 0 => unsafe { gl.call_list(*list as u32) },
                _ if vertices || head & VERTEX == 0 => unsafe {
                    vertex_commands::play(gl, *head as u16, values.as_ptr());
                },
                _ => {}
            }
            rest = next;
        }
    }
}

#[cfg(test)]
mod tests;
