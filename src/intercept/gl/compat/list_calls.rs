//! Commands on display lists that are allowed between Begin and End, or have an effect there.

use crate::intercept::gl::compat::{begin_end, display_lists};
use crate::intercept::gl::context::hooks::hooks;
use std::ffi::c_void;

hooks! {
    between;
    "glEndList" end_list() = |ctx, gl| {
        // The End of the primitive is in another list.
        begin_end::leave_to_list(ctx);
        if ctx.compat.immediate.under_way() { gl.end_list() } else { display_lists::finish_recording(ctx) }
    };
    "glCallList" call_list(list: u32) = |ctx, _gl| {
        begin_end::leave_to_list(ctx);
        display_lists::call_list(ctx, list);
    };
    "glCallLists" call_lists(count: i32, kind: u32, names: *const c_void) = |ctx, _gl| {
        begin_end::leave_to_list(ctx);
        display_lists::call_lists(ctx, count, kind, names);
    };
}
