//! The state of the program's context that drawing changes: read, set, restored.
//!
//! Allocates only for programs with subroutines. State outside [`Saved`] does not change. Two
//! things are left to the caller: conditional rendering, which OpenGL does not report, and queries
//! that count samples or primitives.

use crate::backend::gl::driver::api::*;
use crate::backend::gl::driver::values::{boolean, integer};
use crate::backend::gl::state::capabilities::Capabilities;
use crate::backend::gl::state::current_program::CurrentProgram;
use crate::backend::gl::state::known_state;
use crate::backend::gl::state::known_state::{KnownState, MOST_DRAW_BUFFERS, Masks};
use crate::correct::LowerLeftRect;

/// Switches that are off while Cupola draws. The scissor test is handled separately.
const SWITCHES: [u32; 25] = match known_state::SWITCHES.first_chunk() {
    Some(switches) => *switches,
    None => panic!("more are followed"),
};

/// Greatest number of texture units whose bindings are saved: atlas, mask, table, picture of black.
pub(in crate::backend::gl) const UNITS: usize = 4;

/// State of the program before drawing, to be restored.
pub(in crate::backend::gl) struct Saved {
    /// Bit i: `SWITCHES[i]` was on.
    switches: u32,
    scissor: bool,
    program: CurrentProgram,
    vertex_array: u32,
    draw_framebuffer: u32,
    active_texture: u32,
    /// Number of used elements of the next two arrays.
    units: usize,
    textures: [u32; UNITS],
    samplers: [u32; UNITS],
    viewport: [f32; 4],
    color_masks: Masks,
    polygon_mode: [i32; 2],
    clip_control: [u32; 2],
    feedback: bool,
}

/// True if Cupola can draw. A display list that the program compiles would record the calls, and
/// picking would discard the pixels.
pub(in crate::backend::gl) fn can_draw(gl: &Gl, caps: &Capabilities) -> bool {
    !caps.compatibility || (integer(gl, GL_LIST_INDEX) == 0 && integer(gl, GL_RENDER_MODE) == GL_RENDER as i32)
}

/// Reads the state that is not `known`, and sets the state that drawing needs. The caller sets a
/// program, a vertex array, textures on the first `units` units and a viewport.
pub(in crate::backend::gl) fn save_and_set(gl: &Gl, caps: &Capabilities, units: usize, known: &KnownState) -> Saved {
    let mut saved = Saved {
        switches: 0,
        scissor: false,
        program: CurrentProgram::save(gl, if known.may_have_subroutines() { caps.subroutines() } else { 0 }),
        vertex_array: integer(gl, GL_VERTEX_ARRAY_BINDING) as u32,
        draw_framebuffer: integer(gl, GL_DRAW_FRAMEBUFFER_BINDING) as u32,
        active_texture: integer(gl, GL_ACTIVE_TEXTURE) as u32,
        units: units.min(UNITS),
        textures: [0; UNITS],
        samplers: [0; UNITS],
        viewport: [0.0; 4],
        color_masks: [[0; 4]; MOST_DRAW_BUFFERS],
        polygon_mode: [GL_FILL as i32; 2],
        clip_control: [GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE],
        feedback: false,
    };
    // SAFETY: a context is current; every name is one that it knows, and every array is long
    // enough.
    unsafe {
        for (bit, &switch) in SWITCHES.iter().enumerate() {
            if caps.knows(switch) && known.is_on(gl, switch) {
                saved.switches |= 1 << bit;
                set_switch(gl, caps, switch, false);
            }
        }
        saved.scissor =
            if caps.viewport_array { gl.is_enabledi(GL_SCISSOR_TEST, 0) } else { gl.is_enabled(GL_SCISSOR_TEST) } != 0;
        if saved.scissor {
            set_scissor(gl, caps, false);
        }
        saved.color_masks = known.masks(gl, caps.draw_buffers as usize, caps.indexed_blend);
        set_masks(gl, caps, &saved.color_masks);
        if caps.viewport_array {
            gl.get_floati_v(GL_VIEWPORT, 0, saved.viewport.as_mut_ptr());
        } else {
            gl.get_floatv(GL_VIEWPORT, saved.viewport.as_mut_ptr());
        }
        for unit in 0..saved.units {
            gl.active_texture(GL_TEXTURE0 + unit as u32);
            saved.textures[unit] = integer(gl, GL_TEXTURE_BINDING_2D) as u32;
            saved.samplers[unit] = integer(gl, GL_SAMPLER_BINDING) as u32;
        }
        if !caps.gles {
            gl.get_integerv(GL_POLYGON_MODE, saved.polygon_mode.as_mut_ptr());
            if saved.polygon_mode != [GL_FILL as i32; 2] {
                gl.polygon_mode(GL_FRONT_AND_BACK, GL_FILL);
            }
        }
        if caps.clip_control {
            saved.clip_control = [integer(gl, GL_CLIP_ORIGIN) as u32, integer(gl, GL_CLIP_DEPTH_MODE) as u32];
            if saved.clip_control != [GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE] {
                gl.clip_control(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
            }
        }
        saved.feedback = pause_feedback(gl, caps);
    }
    saved
}

/// Pauses transform feedback, since no other program can be used while it is active. Returns true
/// if it has to be resumed.
pub(super) fn pause_feedback(gl: &Gl, caps: &Capabilities) -> bool {
    let runs =
        caps.feedback_pauses && boolean(gl, GL_TRANSFORM_FEEDBACK_ACTIVE) && !boolean(gl, GL_TRANSFORM_FEEDBACK_PAUSED);
    if runs {
        // SAFETY: a context is current; transform feedback is active and not paused.
        unsafe { gl.pause_transform_feedback() };
    }
    runs
}

impl Saved {
    /// Returns the program's mask of the first colour buffer.
    pub(in crate::backend::gl) fn color_mask(&self) -> [u8; 4] {
        self.color_masks[0]
    }
}

/// Restores the state.
pub(in crate::backend::gl) fn restore(gl: &Gl, caps: &Capabilities, saved: &Saved) {
    // SAFETY: as in `save_and_set`; the values are those that the context gave.
    unsafe {
        for (bit, &switch) in SWITCHES.iter().enumerate() {
            if saved.switches >> bit & 1 != 0 {
                set_switch(gl, caps, switch, true);
            }
        }
        if saved.scissor {
            set_scissor(gl, caps, true);
        }
        restore_masks(gl, caps, &saved.color_masks);
        let [x, y, width, height] = saved.viewport;
        if caps.viewport_array {
            gl.viewport_indexedf(0, x, y, width, height);
        } else {
            gl.viewport(x as i32, y as i32, width as i32, height as i32);
        }
        for unit in 0..saved.units {
            gl.active_texture(GL_TEXTURE0 + unit as u32);
            gl.bind_texture(GL_TEXTURE_2D, saved.textures[unit]);
            gl.bind_sampler(unit as u32, saved.samplers[unit]);
        }
        if saved.units > 0 {
            gl.active_texture(saved.active_texture);
        }
        saved.program.restore(gl);
        gl.bind_vertex_array(saved.vertex_array);
        gl.bind_framebuffer(GL_DRAW_FRAMEBUFFER, saved.draw_framebuffer);
        let [front, back] = saved.polygon_mode;
        if caps.compatibility && front != back {
            gl.polygon_mode(GL_FRONT, front as u32);
            gl.polygon_mode(GL_BACK, back as u32);
        } else if front != GL_FILL as i32 {
            gl.polygon_mode(GL_FRONT_AND_BACK, front as u32);
        }
        if saved.clip_control != [GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE] {
            gl.clip_control(saved.clip_control[0], saved.clip_control[1]);
        }
        if saved.feedback {
            gl.resume_transform_feedback();
        }
    }
}

/// Clears a rectangle of the first colour buffer to an opaque colour. Call it between
/// [`save_and_set`] and [`restore`].
pub(in crate::backend::gl) fn clear(gl: &Gl, caps: &Capabilities, rect: LowerLeftRect, [red, green, blue]: [f32; 3]) {
    // SAFETY: a context is current; the colour has four numbers.
    within(gl, caps, rect, || unsafe { gl.clear_bufferfv(GL_COLOR, 0, [red, green, blue, 1.0].as_ptr()) });
}

/// Runs `draw` with the scissor on a rectangle. Call it between [`save_and_set`] and [`restore`].
pub(in crate::backend::gl) fn within(gl: &Gl, caps: &Capabilities, part: LowerLeftRect, draw: impl FnOnce()) {
    let LowerLeftRect { x, y, width, height } = part;
    let mut scissor = [0; 4];
    // SAFETY: a context is current; the box has four numbers.
    unsafe {
        if caps.viewport_array {
            gl.get_integeri_v(GL_SCISSOR_BOX, 0, scissor.as_mut_ptr());
            gl.scissor_indexed(0, x, y, width, height);
        } else {
            gl.get_integerv(GL_SCISSOR_BOX, scissor.as_mut_ptr());
            gl.scissor(x, y, width, height);
        }
        set_scissor(gl, caps, true);
        draw();
        set_scissor(gl, caps, false);
        let [x, y, width, height] = scissor;
        if caps.viewport_array {
            gl.scissor_indexed(0, x, y, width, height);
        } else {
            gl.scissor(x, y, width, height);
        }
    }
}

/// Sets the viewport for Cupola's drawing.
pub(in crate::backend::gl) fn set_viewport(
    gl: &Gl,
    caps: &Capabilities,
    LowerLeftRect { x, y, width, height }: LowerLeftRect,
) {
    // SAFETY: a context is current.
    unsafe {
        if caps.viewport_array {
            gl.viewport_indexedf(0, x as f32, y as f32, width as f32, height as f32);
        } else {
            gl.viewport(x, y, width, height);
        }
    }
}

/// Sets whether colours are written to the first colour buffer. The other buffers are not written
/// while Cupola draws.
pub(in crate::backend::gl) fn set_color_writes(gl: &Gl, caps: &Capabilities, on: bool) {
    let on = u8::from(on);
    // SAFETY: a context is current.
    unsafe {
        if caps.indexed_blend {
            gl.color_maski(0, on, on, on, on);
        } else {
            gl.color_mask(on, on, on, on);
        }
    }
}

unsafe fn set_switch(gl: &Gl, caps: &Capabilities, switch: u32, on: bool) {
    // SAFETY: the caller's context is current and knows the switch.
    unsafe {
        match (switch, on) {
            (GL_BLEND, true) if caps.indexed_blend => gl.enablei(GL_BLEND, 0),
            (GL_BLEND, false) if caps.indexed_blend => gl.disablei(GL_BLEND, 0),
            (_, true) => gl.enable(switch),
            (_, false) => gl.disable(switch),
        }
    }
}

unsafe fn set_scissor(gl: &Gl, caps: &Capabilities, on: bool) {
    // SAFETY: the caller's context is current.
    unsafe {
        match (caps.viewport_array, on) {
            (true, true) => gl.enablei(GL_SCISSOR_TEST, 0),
            (true, false) => gl.disablei(GL_SCISSOR_TEST, 0),
            (false, true) => gl.enable(GL_SCISSOR_TEST),
            (false, false) => gl.disable(GL_SCISSOR_TEST),
        }
    }
}

/// Makes only the first colour buffer writable.
unsafe fn set_masks(gl: &Gl, caps: &Capabilities, masks: &Masks) {
    // SAFETY: the caller's context is current.
    unsafe {
        if caps.indexed_blend {
            for (i, mask) in masks.iter().enumerate().take(caps.draw_buffers as usize) {
                let write = u8::from(i == 0);
                if *mask != [write; 4] {
                    gl.color_maski(i as u32, write, write, write, write);
                }
            }
        } else {
            gl.color_mask(1, 1, 1, 1);
        }
    }
}

unsafe fn restore_masks(gl: &Gl, caps: &Capabilities, masks: &Masks) {
    // SAFETY: the caller's context is current.
    unsafe {
        if caps.indexed_blend {
            for (i, mask) in masks.iter().enumerate().take(caps.draw_buffers as usize) {
                let [r, g, b, a] = *mask;
                if *mask != [u8::from(i == 0); 4] {
                    gl.color_maski(i as u32, r, g, b, a);
                }
            }
        } else {
            let [r, g, b, a] = masks[0];
            gl.color_mask(r, g, b, a);
        }
    }
}
