//! A call as it is noted, and what arguments point at.

use super::calls::{self, Kind};
use crate::digest::Digest;

/// A call as it is noted.
pub struct Call {
    /// The entry point.
    pub name: &'static str,
    /// A number that tells it from others.
    pub number: u64,
    /// What it may change.
    pub kind: Kind,
    /// Bytes of one number that an argument points at.
    pub size: usize,
}

impl Call {
    /// Of the entry point `name` with arguments that may point at something (`points`), at numbers of so many bytes (`sizes`).
    pub const fn new<const N: usize>(name: &'static str, points: [bool; N], sizes: [usize; N]) -> Self {
        Self::of_kind(name, calls::kind(name, &points), sizes)
    }

    /// The same, of a known kind.
    pub const fn of_kind<const N: usize>(name: &'static str, kind: Kind, sizes: [usize; N]) -> Self {
        let size = match kind {
            Kind::Numbers { pointer, .. } | Kind::Parameter { pointer } => sizes[pointer as usize],
            Kind::MatrixNumbers => sizes[0],
            _ => 1,
        };
        // FNV-1a, which tells names apart.
        let mut hash: u64 = 0xCBF2_9CE4_8422_2325;
        let mut i = 0;
        while i < name.len() {
            hash = (hash ^ name.as_bytes()[i] as u64).wrapping_mul(0x0100_0000_01B3);
            i += 1;
        }
        Self { name, number: hash, kind, size }
    }

    /// Whether it has to be noted at all.
    pub const fn counts(&self) -> bool {
        !matches!(self.kind, Kind::Nothing)
    }
}

/// An argument of a call.
pub trait Word: Copy {
    /// It may point at something.
    const POINTS: bool = false;
    /// … at numbers of so many bytes.
    const SIZE: usize = 1;
    /// Its bits.
    fn word(self) -> u64;
}

macro_rules! words {
    ($($kind:ty)*) => { $( impl Word for $kind { fn word(self) -> u64 { self as u64 } } )* };
}
words!(u8 i8 u16 i16 u32 i32 u64 i64 isize);

impl Word for f32 {
    fn word(self) -> u64 {
        self.to_bits().into()
    }
}

impl Word for f64 {
    fn word(self) -> u64 {
        self.to_bits()
    }
}

impl<T> Word for *const T {
    const POINTS: bool = true;
    const SIZE: usize = size_of::<T>();
    fn word(self) -> u64 {
        self as usize as u64
    }
}

impl<T> Word for *mut T {
    const POINTS: bool = true;
    const SIZE: usize = size_of::<T>();
    fn word(self) -> u64 {
        self as usize as u64
    }
}

/// Adds memory of the program's.
///
/// # Safety
/// `start` must be 0 or point at `length` bytes.
pub unsafe fn add_memory(digest: &mut Digest, start: u64, length: u64) {
    if start == 0 || length == 0 {
        return digest.add(length);
    }
    // SAFETY: as promised.
    digest.add_bytes(unsafe { std::slice::from_raw_parts(start as usize as *const u8, length as usize) });
}
