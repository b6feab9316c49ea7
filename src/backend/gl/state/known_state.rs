//! State of a context that the caller follows, since it sees all calls. A known value need not be
//! queried. It stays known until it is noted again or forgotten.

use crate::backend::gl::driver::api::*;
use crate::backend::gl::driver::values::integer;
use std::cell::Cell;

/// The switches that are followed. The first of them are off while Cupola draws
/// (`crate::backend::gl::state`).
pub(in crate::backend::gl) const SWITCHES: [u32; 28] = [
    GL_DEPTH_TEST,
    GL_STENCIL_TEST,
    GL_CULL_FACE,
    GL_DITHER,
    GL_RASTERIZER_DISCARD,
    GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_SAMPLE_COVERAGE,
    GL_SAMPLE_MASK,
    GL_SAMPLE_SHADING,
    GL_COLOR_LOGIC_OP,
    GL_POLYGON_SMOOTH,
    GL_ALPHA_TEST,
    GL_POLYGON_STIPPLE,
    GL_FRAMEBUFFER_SRGB,
    GL_DEPTH_BOUNDS_TEST_EXT,
    GL_PRIMITIVE_RESTART,
    GL_CLIP_DISTANCE0,
    GL_CLIP_DISTANCE1,
    GL_CLIP_DISTANCE2,
    GL_CLIP_DISTANCE3,
    GL_CLIP_DISTANCE4,
    GL_CLIP_DISTANCE5,
    GL_CLIP_DISTANCE6,
    GL_CLIP_DISTANCE7,
    // Blending of the first buffer, where each buffer has its own.
    GL_BLEND,
    GL_PRIMITIVE_RESTART_FIXED_INDEX,
    GL_COLOR_MATERIAL,
    GL_DEBUG_OUTPUT,
];

/// Returns the bit of a switch; 0 if it is not followed. The most frequent switches come first.
fn bit(switch: u32) -> u32 {
    let place = match switch {
        GL_DEPTH_TEST => 0,
        GL_BLEND => 24,
        GL_CULL_FACE => 2,
        GL_CLIP_DISTANCE0..=GL_CLIP_DISTANCE7 => 16 + switch - GL_CLIP_DISTANCE0,
        _ => match SWITCHES.iter().position(|known| *known == switch) {
            Some(place) => place as u32,
            None => return 0,
        },
    };
    1 << place
}

/// Greatest number of colour buffers whose masks are followed.
pub(in crate::backend::gl) const MOST_DRAW_BUFFERS: usize = 16;

/// The masks of all colour buffers.
pub(in crate::backend::gl) type Masks = [[u8; 4]; MOST_DRAW_BUFFERS];

/// Known part of a context's state.
#[derive(Clone, Default)]
pub struct KnownState {
    /// Switches whose state is known, one bit each.
    known: Cell<u32>,
    on: Cell<u32>,
    /// Switches that the context certainly has, since they were on once.
    there: Cell<u32>,
    masks: Cell<Option<Masks>>,
    blending: Cell<Option<[u32; 4]>>,
    clear_color: Cell<Option<[f32; 4]>>,
    clear_depth: Cell<Option<f32>>,
    /// True if no subroutine was chosen since the context was made: `glUseProgram` resets nothing.
    no_subroutines: Cell<bool>,
}

impl KnownState {
    /// Returns the known state of a context that has just been made.
    pub fn of_new_context() -> Self {
        Self { no_subroutines: Cell::new(true), ..Self::default() }
    }

    /// Notes that the program chose subroutines.
    pub fn note_subroutines(&self) {
        self.no_subroutines.set(false);
    }

    /// True if subroutines may have been chosen.
    pub(in crate::backend::gl) fn may_have_subroutines(&self) -> bool {
        !self.no_subroutines.get()
    }

    /// Forgets all values, since anything may have changed.
    pub fn forget(&self) {
        self.known.set(0);
        self.masks.set(None);
        self.blending.set(None);
        self.clear_color.set(None);
        self.clear_depth.set(None);
    }

    /// Notes that the state may have changed back to `saved`, or not. Only values that are equal in
    /// both stay known.
    pub fn restored(&self, saved: &Self) {
        self.known.set(self.known.get() & saved.known.get() & !(self.on.get() ^ saved.on.get()));
        keep_same(&self.masks, &saved.masks);
        keep_same(&self.blending, &saved.blending);
        keep_same(&self.clear_color, &saved.clear_color);
        keep_same(&self.clear_depth, &saved.clear_depth);
    }

    /// Notes that a switch was set. A context that lacks the switch refuses the call. So a switch
    /// counts as on only if the context certainly has it.
    pub fn note(&self, switch: u32, on: bool) {
        let bit = bit(switch);
        if on && self.there.get() & bit == 0 {
            self.known.set(self.known.get() & !bit);
        } else if on {
            self.known.set(self.known.get() | bit);
            self.on.set(self.on.get() | bit);
        } else {
            self.known.set(self.known.get() | bit);
            self.on.set(self.on.get() & !bit);
        }
    }

    /// Notes that a switch may have changed.
    pub fn forget_switch(&self, switch: u32) {
        self.known.set(self.known.get() & !bit(switch));
    }

    /// True if a switch is on. The context must have it. For `GL_BLEND`: blending of the first
    /// colour buffer.
    pub fn is_on(&self, gl: &Gl, switch: u32) -> bool {
        let bit = bit(switch);
        if self.known.get() & bit != 0 {
            return self.on.get() & bit != 0;
        }
        // SAFETY: asks for a switch that the context has.
        let on = unsafe { gl.is_enabled(switch) } != 0;
        if on {
            self.there.set(self.there.get() | bit);
        }
        self.note(switch, on);
        on
    }

    /// Notes that the mask of all colour buffers was set.
    pub fn note_mask(&self, mask: [u8; 4]) {
        self.masks.set(Some([mask.map(|on| u8::from(on != 0)); MOST_DRAW_BUFFERS]));
    }

    /// Notes that the mask of some colour buffer may have changed.
    pub fn forget_masks(&self) {
        self.masks.set(None);
    }

    /// Returns the masks of the first `count` colour buffers. `indexed`: each buffer has its own
    /// mask.
    pub(in crate::backend::gl) fn masks(&self, gl: &Gl, count: usize, indexed: bool) -> Masks {
        if let Some(masks) = self.masks.get() {
            return masks;
        }
        let mut masks = [[0; 4]; MOST_DRAW_BUFFERS];
        if indexed {
            for (index, mask) in masks.iter_mut().enumerate().take(count) {
                // SAFETY: a mask has four parts.
                unsafe { gl.get_booleani_v(GL_COLOR_WRITEMASK, index as u32, mask.as_mut_ptr()) };
            }
        } else {
            masks = [self.mask(gl); MOST_DRAW_BUFFERS];
        }
        self.masks.set(Some(masks));
        masks
    }

    /// Returns the mask of the first colour buffer.
    pub fn mask(&self, gl: &Gl) -> [u8; 4] {
        if let Some(masks) = self.masks.get() {
            return masks[0];
        }
        let mut mask = [0; 4];
        // SAFETY: a mask has four parts.
        unsafe { gl.get_booleanv(GL_COLOR_WRITEMASK, mask.as_mut_ptr()) };
        mask
    }

    /// Notes the factors of blending: source and destination of colours, then of alpha. The context
    /// may refuse unusual factors, so the factors are unknown then.
    pub fn note_blending(&self, factors: [u32; 4]) {
        let usual = |factor: &u32| matches!(*factor, GL_ZERO | GL_ONE | GL_SRC_COLOR..=GL_ONE_MINUS_DST_COLOR);
        self.blending.set(Some(factors).filter(|factors| factors.iter().all(usual)));
    }

    /// Notes that the factors of blending may have changed.
    pub fn forget_blending(&self) {
        self.blending.set(None);
    }

    /// Returns the factors of blending of the first colour buffer.
    pub fn blending(&self, gl: &Gl) -> [u32; 4] {
        let factors = self.blending.get().unwrap_or_else(|| {
            [GL_BLEND_SRC_RGB, GL_BLEND_DST_RGB, GL_BLEND_SRC_ALPHA, GL_BLEND_DST_ALPHA]
                .map(|name| integer(gl, name) as u32)
        });
        self.blending.set(Some(factors));
        factors
    }

    /// Notes the colour of clears; `None`: it may have changed.
    pub fn note_clear_color(&self, color: Option<[f32; 4]>) {
        self.clear_color.set(color);
    }

    /// Returns the colour of clears.
    pub fn clear_color(&self, gl: &Gl) -> [f32; 4] {
        let color = self.clear_color.get().unwrap_or_else(|| {
            let mut color = [0.0; 4];
            // SAFETY: writes four values.
            unsafe { gl.get_floatv(GL_COLOR_CLEAR_VALUE, color.as_mut_ptr()) };
            color
        });
        self.clear_color.set(Some(color));
        color
    }

    /// Notes that the depth of clears may have changed.
    pub fn forget_clear_depth(&self) {
        self.clear_depth.set(None);
    }

    /// Returns the depth of clears.
    pub fn clear_depth(&self, gl: &Gl) -> f32 {
        let depth = self.clear_depth.get().unwrap_or_else(|| {
            let mut depth = 1.0;
            // SAFETY: writes one value.
            unsafe { gl.get_floatv(GL_DEPTH_CLEAR_VALUE, &mut depth) };
            depth
        });
        self.clear_depth.set(Some(depth));
        depth
    }
}

/// Keeps a value only if it equals the saved one.
fn keep_same<T: Copy + PartialEq>(now: &Cell<Option<T>>, saved: &Cell<Option<T>>) {
    now.set(now.get().filter(|value| saved.get() == Some(*value)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_switch_has_a_bit_of_its_own() {
        for (place, switch) in SWITCHES.iter().enumerate() {
            assert_eq!(bit(*switch), 1 << place, "{switch:#x}");
        }
        assert_eq!([bit(GL_SCISSOR_TEST), bit(GL_LIGHTING), bit(0)], [0; 3]);
    }

    #[test]
    fn what_may_be_refused_is_not_believed() {
        let known = KnownState::default();
        known.note(GL_BLEND, true);
        assert_eq!(known.known.get(), 0, "the context may lack the switch");
        known.note(GL_BLEND, false);
        assert_eq!((known.known.get(), known.on.get()), (bit(GL_BLEND), 0));
        known.there.set(bit(GL_BLEND));
        known.note(GL_BLEND, true);
        assert_eq!((known.known.get(), known.on.get()), (bit(GL_BLEND), bit(GL_BLEND)));
        known.note_blending([GL_ONE, GL_ZERO, GL_ONE, 7]);
        assert_eq!(known.blending.get(), None);
        // A switch that is not followed changes nothing.
        known.note(GL_LIGHTING, true);
        assert_eq!(known.known.get(), bit(GL_BLEND));
    }

    #[test]
    fn what_differs_from_what_comes_back_is_not_known() {
        let known = KnownState::default();
        for switch in [GL_DITHER, GL_DEPTH_TEST] {
            known.note(switch, false);
        }
        known.note_mask([1; 4]);
        known.note_clear_color(Some([0.5; 4]));
        let saved = known.clone();
        known.there.set(u32::MAX);
        known.note(GL_DITHER, true);
        known.note(GL_CULL_FACE, true);
        known.note_mask([1, 0, 1, 1]);
        known.restored(&saved);
        assert_eq!(known.known.get(), bit(GL_DEPTH_TEST));
        assert!(known.masks.get().is_none() && known.clear_color.get() == Some([0.5; 4]));
    }
}
