//! The C interface with structs of any size and content, on the null driver. Each struct lies in memory of exactly the
//! size that it says.
#![no_main]

use cupola::backend::null;
use cupola::correct::LowerLeftRect;
use cupola::ffi::gl::types::{cupola_gl_function, cupola_gl_options, cupola_gl_view};
use cupola::ffi::gl::*;
use cupola::ffi::rig::*;
use std::ffi::{CStr, c_char, c_void};
use std::ptr::null_mut;

unsafe extern "C" fn find(name: *const c_char) -> cupola_gl_function {
    // SAFETY: the library asks with names that end with a zero.
    let address = null::find(unsafe { CStr::from_ptr(name) });
    // SAFETY: an address of a function, or null, which is `None`.
    unsafe { std::mem::transmute::<*const c_void, cupola_gl_function>(address) }
}

/// A struct of the size that its first bytes say, as words: aligned, and not a byte longer than promised where that is
/// less than a page.
fn structure(size: usize, bytes: &mut impl Iterator<Item = u8>) -> Vec<usize> {
    let mut words = vec![0; (size / 8).clamp(1, 1024)];
    for word in words.iter_mut().skip(1) {
        *word = usize::from_le_bytes(std::array::from_fn(|_| bytes.next().unwrap_or_default()));
    }
    words[0] = size;
    words
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let mut bytes = bytes.iter().copied();
    let [first, second, third, kind] = std::array::from_fn(|_| bytes.next().unwrap_or_default());
    let size = |size: u8| if size == 255 { usize::MAX } else { 8 * usize::from(size) + usize::from(kind >> 1 & 1) };
    let sizes = [first, second, third].map(size);
    null::reset(LowerLeftRect::of_size((64, 48)));
    let (mut rig, mut gl) = (null_mut(), null_mut());
    // SAFETY: live arguments; structs are as long as they say, or longer than is allowed.
    unsafe {
        // One view, which is planned quickly.
        let text = c"[[output]]\nkind = \"perspective\"\nfov = [60.0, 40.0]\n";
        cupola_rig_parse(text.as_ptr(), c"".as_ptr(), &mut rig);
        let mut options = structure(sizes[0], &mut bytes);
        if let Some(find_place) = options.get_mut(1) {
            *find_place = find as *const () as usize;
        }
        // Sizes of windows that are planned at once.
        if let Some(size) = options.get_mut(2) {
            *size &= 0x0000_00ff_0000_00ff;
        }
        let _ = cupola_gl_create(rig, options.as_ptr().cast::<cupola_gl_options>(), &mut gl);
        if gl.is_null() && kind & 1 == 0 {
            let options = cupola_gl_options {
                struct_size: size_of::<cupola_gl_options>(),
                get_proc_address: Some(find),
                width: 64,
                height: 48,
            };
            cupola_gl_create(rig, &options, &mut gl);
        }
        if !gl.is_null() {
            let mut view = structure(sizes[1], &mut bytes);
            let number = |bytes: &mut dyn Iterator<Item = u8>| {
                f64::from_le_bytes(std::array::from_fn(|_| bytes.next().unwrap_or_default()))
            };
            let (near, far) = (number(&mut bytes), number(&mut bytes));
            let _ = cupola_gl_get_view(gl, u32::from(kind >> 4), near, far, view.as_mut_ptr().cast::<cupola_gl_view>());
            let mut statistics = structure(sizes[2], &mut bytes);
            let _ = cupola_gl_get_statistics(gl, statistics.as_mut_ptr().cast());
            let position = std::array::from_fn::<f64, 3, _>(|_| number(&mut bytes));
            let angles = [(); 3].map(|()| number(&mut bytes));
            let _ = cupola_gl_set_viewer(gl, position.as_ptr(), angles[0], angles[1], angles[2]);
            let (width, height) =
                (u32::from(bytes.next().unwrap_or_default()), u32::from(bytes.next().unwrap_or_default()));
            let _ = cupola_gl_resize(gl, width, height);
            for call in bytes.by_ref().take(16) {
                let _ = match call % 4 {
                    0 => frame::cupola_gl_begin_frame(gl),
                    1 => frame::cupola_gl_begin_view(gl, u32::from(call >> 4)),
                    2 => frame::cupola_gl_end_view(gl),
                    _ => frame::cupola_gl_end_frame(gl, u32::from(call >> 4), i32::from(call), -1),
                };
            }
            cupola_gl_destroy(gl);
        }
        cupola_rig_free(rig);
    }
    assert!(null::recorded().alive.values().all(|count| *count == 0), "objects are left behind");
});
