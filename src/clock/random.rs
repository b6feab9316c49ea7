//! Random numbers: the same in each run with the same seed.

use super::caller::{interpose, is_served};
use super::real;
use super::settings::settings;
use std::cell::Cell;
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::sync::atomic::{AtomicU64, Ordering};

interpose! {
    3 getrandom => getrandom_for;
    2 getentropy => getentropy_for;
    0 arc4random => arc4random_for;
    2 arc4random_buf => arc4random_buf_for;
    1 arc4random_uniform => arc4random_uniform_for;
    3 open => open_for;
    3 open64 => open_for;
    2 __open_2 => open_two;
    2 __open64_2 => open_two;
    4 openat => openat_for;
    4 openat64 => openat_for;
    3 __openat_2 => openat_two;
    3 __openat64_2 => openat_two;
    2 fopen => fopen_for;
    2 fopen64 => fopen_for;
}

/// Number of bytes that a device of random numbers gives each time it is opened.
const DEVICE: usize = 1 << 20;

thread_local! {
    /// Number of this thread, from 1, in the order in which threads first ask for random numbers; 0
    /// before.
    static THREAD: Cell<u64> = const { Cell::new(0) };
    /// Number of values that this thread got. Each thread has its own sequence.
    static TAKEN: Cell<u64> = const { Cell::new(0) };
}

/// Step between the states of Steele, Lea and Flood's SplitMix64.
const STEP: u64 = 0x9E37_79B9_7F4A_7C15;

/// Output function of SplitMix64.
fn mix(state: u64) -> u64 {
    let state = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let state = (state ^ (state >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    state ^ (state >> 31)
}

/// Next number of this thread.
fn next() -> u64 {
    static THREADS: AtomicU64 = AtomicU64::new(0);
    if THREAD.get() == 0 {
        THREAD.set(THREADS.fetch_add(1, Ordering::Relaxed) + 1);
    }
    TAKEN.set(TAKEN.get() + 1);
    let seed = settings().map_or(0, |settings| settings.seed);
    let stream = mix(seed.wrapping_add(STEP.wrapping_mul(THREAD.get())));
    mix(stream.wrapping_add(STEP.wrapping_mul(TAKEN.get())))
}

/// Fills `length` bytes.
///
/// # Safety
/// They can be written.
unsafe fn fill(bytes: *mut c_void, length: usize) {
    if length > 0 && !bytes.is_null() {
        // SAFETY: as promised.
        let bytes = unsafe { std::slice::from_raw_parts_mut(bytes.cast::<u8>(), length) };
        for part in bytes.chunks_mut(8) {
            part.copy_from_slice(&next().to_le_bytes()[..part.len()]);
        }
    }
}

pub unsafe extern "C" fn getrandom_for(bytes: *mut c_void, length: usize, flags: c_uint, caller: usize) -> isize {
    // SAFETY: the program's own call.
    unsafe {
        if !is_served(caller) {
            return real::getrandom(bytes, length, flags);
        }
        fill(bytes, length);
    }
    length as isize
}

unsafe extern "C" fn getentropy_for(bytes: *mut c_void, length: usize, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    unsafe {
        if length > 256 || !is_served(caller) {
            return real::getentropy(bytes, length);
        }
        fill(bytes, length);
    }
    0
}

unsafe extern "C" fn arc4random_for(caller: usize) -> u32 {
    // SAFETY: the program's own call.
    if is_served(caller) { next() as u32 } else { unsafe { real::arc4random() } }
}

unsafe extern "C" fn arc4random_buf_for(bytes: *mut c_void, length: usize, caller: usize) {
    // SAFETY: the program's own call.
    unsafe { if is_served(caller) { fill(bytes, length) } else { real::arc4random_buf(bytes, length) } }
}

unsafe extern "C" fn arc4random_uniform_for(bound: u32, caller: usize) -> u32 {
    match is_served(caller) {
        // The high half of a product is as uniform as the number.
        true => ((u128::from(next()) * u128::from(bound)) >> 64) as u32,
        // SAFETY: the program's own call.
        false => unsafe { real::arc4random_uniform(bound) },
    }
}

/// Opens a file of random numbers in place of a random device; `None` for other paths.
unsafe fn device(path: *const c_char, caller: usize) -> Option<c_int> {
    if path.is_null() {
        return None;
    }
    // SAFETY: the program's text.
    let path = unsafe { CStr::from_ptr(path) };
    if ![c"/dev/urandom", c"/dev/random"].contains(&path) || !is_served(caller) {
        return None;
    }
    let mut content = vec![0_u8; DEVICE];
    // SAFETY: owned bytes, and a file that was just opened.
    unsafe {
        fill(content.as_mut_ptr().cast(), content.len());
        let file = libc::memfd_create(c"cupola-random".as_ptr(), libc::MFD_CLOEXEC);
        let written = if file < 0 { -1 } else { libc::write(file, content.as_ptr().cast(), content.len()) };
        libc::lseek(file, 0, libc::SEEK_SET);
        (written == DEVICE as isize).then_some(file)
    }
}

unsafe extern "C-unwind" fn open_for(path: *const c_char, flags: c_int, mode: c_uint, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    unsafe { device(path, caller).unwrap_or_else(|| real::open(path, flags, mode)) }
}

unsafe extern "C-unwind" fn open_two(path: *const c_char, flags: c_int, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    unsafe { open_for(path, flags, 0, caller) }
}

unsafe extern "C-unwind" fn openat_for(
    folder: c_int,
    path: *const c_char,
    flags: c_int,
    mode: c_uint,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call.
    unsafe { device(path, caller).unwrap_or_else(|| real::openat(folder, path, flags, mode)) }
}

unsafe extern "C-unwind" fn openat_two(folder: c_int, path: *const c_char, flags: c_int, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    unsafe { openat_for(folder, path, flags, 0, caller) }
}

unsafe extern "C-unwind" fn fopen_for(path: *const c_char, mode: *const c_char, caller: usize) -> *mut libc::FILE {
    // SAFETY: the program's own call.
    unsafe {
        match device(path, caller) {
            Some(file) => libc::fdopen(file, mode),
            None => real::fopen(path, mode),
        }
    }
}
