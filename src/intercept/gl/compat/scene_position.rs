//! Driver state for a raster position of the scene.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::LowerLeftRect;
use crate::intercept::gl::state::compat::raster_position::{ScenePosition, TextureCoordinates};
use glam::{Vec2, Vec4, Vec4Swizzles};

/// Raster position of the scene during drawing in several views. [`PlacedPosition::end`] restores the
/// driver's state.
pub(in crate::intercept::gl) struct PlacedPosition<'a> {
    gl: &'static Gl,
    position: &'a ScenePosition,
    present: Present,
    /// The program's matrix mode.
    mode: u32,
    /// True if the current attributes were pushed.
    keeps: bool,
}

impl<'a> PlacedPosition<'a> {
    /// Pushes the model-view matrix and loads the matrix of the position. `keeps`: pushes the
    /// current attributes too.
    pub(in crate::intercept::gl) fn begin(
        gl: &'static Gl,
        position: &'a ScenePosition,
        mode: u32,
        keeps: bool,
    ) -> Self {
        // SAFETY: `end` pops what is pushed.
        unsafe {
            if keeps {
                gl.push_attrib(api::GL_CURRENT_BIT);
            }
            gl.matrix_mode(api::GL_MODELVIEW);
            gl.push_matrix();
            gl.load_matrixd(position.model_view.as_ref().as_ptr());
            gl.matrix_mode(mode);
        }
        Self { gl, position, present: Present::of(gl), mode, keeps }
    }

    /// True if the raster position is restored at the end.
    pub fn keeps(&self) -> bool {
        self.keeps
    }

    /// Sets the position with the present projection and viewport.
    pub fn set(&self) {
        self.present.set_again(self.gl, self.position);
        move_by(self.gl, self.position.moved);
    }

    /// Sets the position that the program has set in its own window, moved to `tile`. The present
    /// viewport and projection have no effect.
    pub fn as_set(&self, tile: LowerLeftRect) {
        if !self.keeps {
            self.set();
            return;
        }
        // SAFETY: restores what `begin` pushed, and pushes it again.
        unsafe {
            self.gl.pop_attrib();
            self.gl.push_attrib(api::GL_CURRENT_BIT);
        }
        if is_valid(self.gl) {
            move_by(self.gl, Vec2::new(tile.x as f32, tile.y as f32));
        }
    }

    /// Restores what `begin` pushed.
    pub fn end(&self) {
        let gl = self.gl;
        // SAFETY: these pops match the pushes in `begin`.
        unsafe {
            gl.matrix_mode(api::GL_MODELVIEW);
            gl.pop_matrix();
            gl.matrix_mode(self.mode);
            if self.keeps {
                gl.pop_attrib();
            }
        }
    }
}

/// State at the beginning of a draw that setting the position again would change.
struct Present {
    /// True for each of [`Present::SWITCHES`] that is on.
    on: [bool; 2],
    color: [f32; 4],
    texture: TextureCoordinates,
    depths: [f64; 2],
}

impl Present {
    /// Switches that are off while a position is set again. The colour of a position is lit
    /// already, and the material must not follow it.
    const SWITCHES: [u32; 2] = [api::GL_LIGHTING, api::GL_COLOR_MATERIAL];

    fn of(gl: &Gl) -> Self {
        let (mut color, mut depths) = ([0.0; 4], [0.0; 2]);
        // SAFETY: plain state; writes four floats, and two doubles.
        let (on, texture) = unsafe {
            gl.get_floatv(api::GL_CURRENT_COLOR, color.as_mut_ptr());
            gl.get_doublev(api::GL_DEPTH_RANGE, depths.as_mut_ptr());
            (Self::SWITCHES.map(|switch| gl.is_enabled(switch) != 0), TextureCoordinates::of(gl))
        };
        Self { on, color, texture, depths }
    }

    /// Sets a position of the scene again, with the colour, the texture coordinates and the depth
    /// range that it was first set with. All other state stays unchanged.
    fn set_again(&self, gl: &Gl, position: &ScenePosition) {
        let ([near, far], [own_near, own_far]) = (position.depths, self.depths);
        let on = || Self::SWITCHES.iter().zip(self.on).filter(|(_, on)| *on).map(|(switch, _)| *switch);
        // SAFETY: the program's own position; the rest is put back.
        unsafe {
            on().for_each(|switch| gl.disable(switch));
            gl.depth_range(near, far);
            gl.color4fv(position.color.as_ptr());
            position.texture.set(gl);
            gl.raster_pos4dv(position.object.as_ref().as_ptr());
            gl.depth_range(own_near, own_far);
            gl.color4fv(self.color.as_ptr());
            self.texture.set(gl);
            on().for_each(|switch| gl.enable(switch));
        }
    }
}

/// True if the raster position was in the clip volume when it was set.
pub fn is_valid(gl: &Gl) -> bool {
    let mut valid = 0;
    // SAFETY: writes one boolean.
    unsafe { gl.get_booleanv(api::GL_CURRENT_RASTER_POSITION_VALID, &mut valid) };
    valid != 0
}

/// Moves the raster position by pixels.
pub fn move_by(gl: &Gl, distance: Vec2) {
    if distance != Vec2::ZERO {
        // SAFETY: an empty bitmap only moves the raster position.
        unsafe { gl.bitmap(0, 0, 0.0, 0.0, distance.x, distance.y, std::ptr::null()) };
    }
}

/// Returns the driver's raster position, in its window coordinates.
pub fn raster_position(gl: &Gl) -> Vec2 {
    let mut position = Vec4::ZERO;
    // SAFETY: writes four floats.
    unsafe { gl.get_floatv(api::GL_CURRENT_RASTER_POSITION, position.as_mut().as_mut_ptr()) };
    position.xy()
}
