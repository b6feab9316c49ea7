//! The C interface for OpenGL on the null driver: without a display and without a driver.

use super::frame::{cupola_gl_begin_frame, cupola_gl_draw_frame, cupola_gl_end_view};
use super::types::{cupola_gl_function, cupola_gl_options, cupola_gl_view};
use super::{cupola_gl, cupola_gl_create, cupola_gl_destroy};
use crate::backend::null;
use crate::correct::LowerLeftRect;
use crate::ffi::cupola_status;
use crate::ffi::rig::{cupola_rig_free, cupola_rig_load};
use std::ffi::{CStr, c_char, c_void};
use std::ptr;

const SIZE: (u32, u32) = (320, 200);

unsafe extern "C" fn find(name: *const c_char) -> cupola_gl_function {
    // SAFETY: the library asks with names that end with a zero.
    let address = null::find(unsafe { CStr::from_ptr(name) });
    // SAFETY: an address of a function, or null, which is `None`.
    unsafe { std::mem::transmute::<*const c_void, cupola_gl_function>(address) }
}

/// Makes a rig and its object on the null driver, and gives both to `work`.
fn with_rig(name: &CStr, work: impl FnOnce(*mut cupola_gl)) {
    null::reset(LowerLeftRect::of_size(SIZE));
    let (mut rig, mut gl) = (ptr::null_mut(), ptr::null_mut());
    let options = cupola_gl_options {
        struct_size: size_of::<cupola_gl_options>(),
        get_proc_address: Some(find),
        width: SIZE.0,
        height: SIZE.1,
    };
    // SAFETY: live arguments, as the functions' contracts ask for; the null driver is current
    // everywhere.
    unsafe {
        assert_eq!(cupola_rig_load(name.as_ptr(), &mut rig), cupola_status::CUPOLA_OK);
        assert_eq!(cupola_gl_create(rig, &options, &mut gl), cupola_status::CUPOLA_OK);
        cupola_rig_free(rig);
        work(gl);
        cupola_gl_destroy(gl);
    }
    let alive = null::recorded().alive;
    assert!(alive.values().all(|count| *count == 0), "{alive:?}");
}

/// Notes the tile that a view is drawn to.
unsafe extern "C" fn draw(view: *const cupola_gl_view, user: *mut c_void) {
    // SAFETY: the library's own view, and the list that the test hands over.
    let (view, tiles) = unsafe { (&*view, &mut *user.cast::<Vec<[i32; 4]>>()) };
    tiles.push([view.x, view.y, view.width, view.height]);
}

#[test]
fn a_frame_draws_each_view_and_corrects_into_the_framebuffer() {
    with_rig(c"fisheye", |gl| {
        let mut tiles: Vec<[i32; 4]> = Vec::new();
        let user = ptr::from_mut(&mut tiles).cast();
        // SAFETY: as above.
        let status = unsafe { cupola_gl_draw_frame(gl, 0.1, 100.0, Some(draw), user, 7, 10, 20) };
        assert_eq!(status, cupola_status::CUPOLA_OK);
        assert!(tiles.len() > 3, "a fisheye has several views: {tiles:?}");
        let record = null::recorded();
        assert!(!record.draws.is_empty());
        for draw in &record.draws {
            assert_eq!(
                (draw.framebuffer, draw.viewport),
                (7, LowerLeftRect::new(10, 20, SIZE.0 as i32, SIZE.1 as i32))
            );
        }
    });
}

#[test]
fn a_call_at_the_wrong_time_is_refused() {
    with_rig(c"fisheye", |gl| {
        // SAFETY: as above.
        unsafe {
            assert_eq!(cupola_gl_end_view(gl), cupola_status::CUPOLA_INVALID_STATE);
            assert_eq!(cupola_gl_begin_frame(gl), cupola_status::CUPOLA_OK);
            assert_eq!(cupola_gl_begin_frame(gl), cupola_status::CUPOLA_INVALID_STATE);
        }
        assert!(null::recorded().draws.is_empty(), "nothing is drawn by refused calls");
    });
}
