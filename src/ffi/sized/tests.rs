//! Callers of older and of newer versions, and callers with mistakes.

use super::*;

/// The first version of a struct.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
struct First {
    struct_size: usize,
    width: u32,
    height: u32,
}

/// The same struct of the version that the library knows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
struct Known {
    struct_size: usize,
    width: u32,
    height: u32,
    depth: f64,
}

/// The same struct of a later version.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
struct Later {
    struct_size: usize,
    width: u32,
    height: u32,
    depth: f64,
    time: u64,
}

// SAFETY: `repr(C)`, the size first, numbers only.
unsafe impl Growing for Known {
    const FIRST_SIZE: usize = first_size!(Known, height);
}

const FIRST: First = First { struct_size: size_of::<First>(), width: 3, height: 4 };
const KNOWN: Known = Known { struct_size: size_of::<Known>(), width: 3, height: 4, depth: 5.0 };
const LATER: Later = Later { struct_size: size_of::<Later>(), width: 3, height: 4, depth: 5.0, time: 0 };

fn read_of<S>(given: &S) -> Result<Known> {
    // SAFETY: a struct of as many bytes as it says, or of a size that is refused.
    unsafe { read(std::ptr::from_ref(given).cast(), "given") }
}

fn write_to<S>(place: &mut S, value: &Known) -> Result<()> {
    // SAFETY: as above.
    unsafe { SizedPlace::new(std::ptr::from_mut(place).cast(), "given") }.map(|place| place.set(value))
}

fn refused<T: std::fmt::Debug>(result: Result<T>, word: &str) {
    let error = result.expect_err(word);
    assert!(error.kind == ErrorKind::InvalidArgument && error.message.contains(word), "{error:?} without \"{word}\"");
}

#[test]
fn the_first_size_is_that_of_the_first_version() {
    assert_eq!(Known::FIRST_SIZE, size_of::<First>());
    assert!(Known::FIRST_SIZE < size_of::<Known>(), "control: the struct has grown");
}

#[test]
fn a_struct_of_the_same_version_is_read_and_written_whole() {
    assert_eq!(read_of(&KNOWN), Ok(KNOWN));
    let mut place = Known { struct_size: size_of::<Known>(), width: 9, height: 9, depth: 9.0 };
    assert_eq!(write_to(&mut place, &Known { struct_size: 0, ..KNOWN }), Ok(()));
    assert_eq!(place, KNOWN, "the caller's size stays");
}

#[test]
fn an_older_caller_s_missing_field_is_zero() {
    // The bytes behind the caller's struct belong to another object.
    let given = (FIRST, [0xff_u8; 16]);
    assert_eq!(read_of(&given), Ok(Known { struct_size: size_of::<First>(), depth: 0.0, ..KNOWN }));
    // Control: with today's size the field would be read from the other object's bytes.
    let wrong = (First { struct_size: size_of::<Known>(), ..FIRST }, [0xff_u8; 16]);
    assert!(read_of(&wrong).is_ok_and(|read| read.depth.is_nan()));
}

#[test]
fn an_older_caller_gets_no_more_than_it_has() {
    let mut place = (First { width: 0, height: 0, ..FIRST }, [0xa5_u8; 16]);
    assert_eq!(write_to(&mut place, &KNOWN), Ok(()));
    assert_eq!(place, (FIRST, [0xa5; 16]));
}

#[test]
fn a_newer_caller_is_served_while_unknown_fields_are_zero() {
    assert_eq!(read_of(&LATER), Ok(Known { struct_size: size_of::<Later>(), ..KNOWN }));
    let mut place = Later { width: 0, depth: 0.0, time: u64::MAX, ..LATER };
    assert_eq!(write_to(&mut place, &KNOWN), Ok(()));
    assert_eq!(place, LATER, "an unknown field of a result is 0");
}

#[test]
fn a_newer_caller_that_sets_an_unknown_field_is_refused() {
    for bit in 0..64 {
        let byte = size_of::<Known>() + bit / 8;
        refused(read_of(&Later { time: (1_u64 << bit).to_le(), ..LATER }), &format!("byte {byte} is not 0"));
    }
}

#[test]
fn absurd_sizes_are_refused_before_anything_is_read_or_written() {
    let sizes = [0, 1, 8, size_of::<First>() - 8, size_of::<First>() - 1, size_of::<First>() + 1];
    let sizes = sizes.into_iter().chain([size_of::<Known>() + 4, LARGEST + 8, isize::MAX as usize, usize::MAX]);
    for size in sizes {
        refused(read_of(&size), &format!("`given.struct_size` is {size};"));
        let mut place = Known { struct_size: size, ..KNOWN };
        refused(write_to(&mut place, &Known { width: 77, ..KNOWN }), &format!("`given.struct_size` is {size};"));
        assert_eq!(place, Known { struct_size: size, ..KNOWN });
    }
    // Control: the greatest accepted size.
    #[repr(C, align(8))]
    struct Large([u8; LARGEST]);
    let mut large = Large([0; LARGEST]);
    large.0[..8].copy_from_slice(&LARGEST.to_ne_bytes());
    assert!(read_of(&large).is_ok());
}

#[test]
fn null_and_misaligned_pointers_are_refused() {
    let space = [KNOWN; 2];
    for shift in 1..align_of::<Known>() {
        let shifted = space.as_ptr().wrapping_byte_add(shift);
        // SAFETY: refused before anything is read.
        refused(unsafe { read(shifted, "given") }.map(|_: Known| ()), "`given` is 0x");
        // SAFETY: refused before anything is read.
        refused(unsafe { SizedPlace::new(shifted.cast_mut(), "given") }.map(|_| ()), "`given` is 0x");
        // SAFETY: refused before anything is read.
        refused(unsafe { read_array(shifted, 1, "given") }.map(|_| ()), "`given` is 0x");
    }
    let nothing: *const Known = std::ptr::null();
    // SAFETY: null is refused.
    refused(unsafe { read(nothing, "given") }, "`given` is null");
    // SAFETY: null is refused.
    refused(unsafe { SizedPlace::new(nothing.cast_mut(), "given") }.map(|_| ()), "`given` is null");
    // SAFETY: null is refused.
    refused(unsafe { read_array(nothing, 0, "given") }, "`given` is null");
}

#[test]
fn arrays_lie_as_far_apart_as_the_first_struct_says() {
    let older = [1, 2, 3].map(|width| First { width, ..FIRST });
    let newer = [1, 2, 3].map(|width| Later { width, ..LATER });
    // SAFETY: three structs of the size that the first one says.
    let (older, newer) = unsafe {
        (read_array::<Known>(older.as_ptr().cast(), 3, "all"), read_array::<Known>(newer.as_ptr().cast(), 3, "all"))
    };
    let widths = |all: Result<Vec<Known>>| all.map(|all| all.iter().map(|one| one.width).collect::<Vec<_>>());
    assert_eq!(widths(older), Ok(vec![1, 2, 3]));
    assert_eq!(widths(newer), Ok(vec![1, 2, 3]));
    let unknown = [Later { time: 0, ..LATER }, Later { time: 7, ..LATER }];
    // SAFETY: two structs of the size that the first one says.
    refused(unsafe { read_array::<Known>(unknown.as_ptr().cast(), 2, "all") }, "`all` sets a field");
    // SAFETY: as above; only the first is read.
    assert_eq!(widths(unsafe { read_array(unknown.as_ptr().cast(), 1, "all") }), Ok(vec![3]));
    // SAFETY: an array of no elements is not read.
    assert_eq!(unsafe { read_array::<Known>([0_usize].as_ptr().cast(), 0, "all") }, Ok(Vec::new()));
}
