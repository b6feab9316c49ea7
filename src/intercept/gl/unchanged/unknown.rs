//! Calls that the registry does not know: libglvnd asks for some, and programs are newer than libraries.
//!
//! Their arguments are not known either, so what stands before such a function only notes that it was called, and jumps.

use std::ffi::c_void;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicUsize, Ordering};

/// The program made, or may have made, a call that is not known.
static CALLED: AtomicBool = AtomicBool::new(false);

/// Whether the program made such a call, or may have.
pub fn called() -> bool {
    CALLED.load(Ordering::Relaxed)
}

/// A call that is known may have come by a way that is not noted.
pub fn suspect() {
    CALLED.store(true, Ordering::Relaxed);
}

/// So many functions can be noted.
const MOST: usize = 512;

/// The driver's functions.
static REAL: [AtomicPtr<c_void>; MOST] = [const { AtomicPtr::new(std::ptr::null_mut()) }; MOST];
static COUNT: AtomicUsize = AtomicUsize::new(0);

/// What stands before the driver's function `real`; none where that cannot be: then it counts as called.
pub fn noted(real: *const c_void) -> Option<*const ()> {
    let known = REAL.iter().position(|known| known.load(Ordering::Acquire).cast_const() == real);
    let number = known.unwrap_or_else(|| COUNT.fetch_add(1, Ordering::Relaxed));
    let before = REAL.get(number).and_then(|place| {
        place.store(real.cast_mut(), Ordering::Release);
        before(number)
    });
    if before.is_none() {
        suspect();
    }
    before
}

#[cfg(target_arch = "x86_64")]
std::arch::global_asm!(
    ".pushsection .text",
    ".balign 32",
    "cupola_unknown_calls:",
    ".set cupola_unknown_call, 0",
    ".rept {most}",
    ".balign 32",
    "endbr64",
    "movb $1, {called}(%rip)",
    "jmpq *({real} + 8 * cupola_unknown_call)(%rip)",
    ".set cupola_unknown_call, cupola_unknown_call + 1",
    ".endr",
    ".popsection",
    most = const MOST,
    called = sym CALLED,
    real = sym REAL,
    options(att_syntax),
);

// x16 and x17 are free at the border between functions.
#[cfg(target_arch = "aarch64")]
std::arch::global_asm!(
    ".pushsection .text",
    ".balign 32",
    "cupola_unknown_calls:",
    ".set cupola_unknown_call, 0",
    ".rept {most}",
    ".balign 32",
    // bti c, which assemblers know by this name whatever the processor.
    "hint #34",
    "adrp x16, {called}",
    "mov w17, #1",
    "strb w17, [x16, :lo12:{called}]",
    "adrp x16, {real} + 8 * cupola_unknown_call",
    "ldr x16, [x16, :lo12:{real} + 8 * cupola_unknown_call]",
    "br x16",
    ".set cupola_unknown_call, cupola_unknown_call + 1",
    ".endr",
    ".popsection",
    most = const MOST,
    called = sym CALLED,
    real = sym REAL,
);

/// The code that notes the function of this number.
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
fn before(number: usize) -> Option<*const ()> {
    unsafe extern "C" {
        static cupola_unknown_calls: [[u8; 32]; MOST];
    }
    let code = &raw const cupola_unknown_calls;
    (number < MOST).then(|| code.cast::<[u8; 32]>().wrapping_add(number).cast())
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn before(_number: usize) -> Option<*const ()> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    extern "C" fn sum(a: i32, b: f64, c: i32, d: i32, e: i32, f: i32, g: i32, h: i32) -> f64 {
        f64::from(a + c + d + e + f + g + h) + b
    }

    #[test]
    fn a_call_is_noted_and_keeps_its_arguments() {
        let real = sum as *const c_void;
        let before = noted(real).expect("this machine can");
        assert_eq!(noted(real), Some(before), "one for each function");
        assert_eq!(before as usize % 32, 0);
        // SAFETY: the code jumps to `sum`.
        let call: extern "C" fn(i32, f64, i32, i32, i32, i32, i32, i32) -> f64 = unsafe { std::mem::transmute(before) };
        let other = before.wrapping_byte_add(32);
        CALLED.store(false, Ordering::Relaxed);
        assert_eq!(call(1, 0.5, 2, 3, 4, 5, 6, 7), 28.5);
        assert!(called());
        assert_ne!(other, before);
        assert!(super::before(MOST).is_none());
    }
}
