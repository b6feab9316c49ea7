//! Structures of the program: their arrays and chains, and copies of chains with changes.

use ash::vk;
use std::ffi::c_void;

/// Returns an array of a program's structure. The pointer of an empty array may be null.
///
/// # Safety
/// `pointer` must point at `count` elements, or be null.
pub unsafe fn slice<'a, T>(pointer: *const T, count: u32) -> &'a [T] {
    if count == 0 || pointer.is_null() {
        return &[];
    }
    // SAFETY: as promised.
    unsafe { std::slice::from_raw_parts(pointer, count as usize) }
}

/// Returns a structure in a chain, by its type.
///
/// # Safety
/// `chain` must be a chain of Vulkan structures, `T` the structure of the type `kind`.
pub unsafe fn in_chain<'a, T>(chain: *const c_void, kind: vk::StructureType) -> Option<&'a T> {
    let mut at = chain.cast::<vk::BaseInStructure<'_>>();
    while !at.is_null() {
        // SAFETY: each structure begins with its type and a pointer to the next.
        unsafe {
            if (*at).s_type == kind {
                return Some(&*at.cast::<T>());
            }
            at = (*at).p_next;
        }
    }
    None
}

/// A copy of the program's chain up to a structure of a certain type. The copies may be changed.
/// The structures after them are the program's.
pub struct Copied(Vec<Box<[u64]>>);

impl Copied {
    /// `None` if there is no structure of the type `last`, or if the length in bytes of one before
    /// it is unknown.
    ///
    /// # Safety
    /// `chain` must be the program's.
    pub unsafe fn up_to(
        chain: *const c_void,
        last: vk::StructureType,
        length: fn(vk::StructureType) -> Option<usize>,
    ) -> Option<Self> {
        let mut copies: Vec<Box<[u64]>> = Vec::new();
        let mut at = chain.cast::<vk::BaseInStructure<'_>>();
        loop {
            // SAFETY: as promised; a structure of a known type has that length, and begins with its
            // type and a pointer to the next.
            unsafe {
                let given = at.as_ref()?;
                let bytes = length(given.s_type)?;
                let mut copy = vec![0u64; bytes.div_ceil(8)].into_boxed_slice();
                std::ptr::copy_nonoverlapping(at.cast::<u8>(), copy.as_mut_ptr().cast(), bytes);
                if let Some(before) = copies.last_mut() {
                    (*before.as_mut_ptr().cast::<vk::BaseOutStructure<'_>>()).p_next = copy.as_mut_ptr().cast();
                }
                copies.push(copy);
                if given.s_type == last {
                    return Some(Self(copies));
                }
                at = given.p_next;
            }
        }
    }

    /// The first structure.
    pub fn first(&self) -> *const c_void {
        self.0.first().map_or(std::ptr::null(), |copy| copy.as_ptr().cast())
    }

    /// Returns the last copied structure.
    ///
    /// # Safety
    /// `T` must be the structure of the type that was passed as `last`.
    pub unsafe fn last<T>(&mut self) -> Option<&mut T> {
        let last = self.0.last_mut().filter(|copy| 8 * copy.len() >= size_of::<T>())?;
        // SAFETY: as promised; the alignment of the copy is sufficient for the pointers and numbers
        // of such structures.
        Some(unsafe { &mut *last.as_mut_ptr().cast::<T>() })
    }
}
