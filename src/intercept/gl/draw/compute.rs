//! `glDispatchCompute…`.

use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::offscreen::computed::dispatch;

hooks! {
    "glDispatchCompute" dispatch_compute(x: u32, y: u32, z: u32) = |ctx, _gl| {
        let groups = x.saturating_mul(y).saturating_mul(z);
        dispatch(ctx, Some(groups), &mut |gl| gl.dispatch_compute(x, y, z));
    };
    "glDispatchComputeIndirect" dispatch_compute_indirect(offset: isize) = |ctx, _gl| {
        dispatch(ctx, None, &mut |gl| gl.dispatch_compute_indirect(offset));
    };
}
