//! The accumulation buffer of old OpenGL, which framebuffer objects do not have.
//!
//! Values are 32-bit floats: a sum of many pictures must not lose a step of 1/255, and 16-bit
//! floats have only 11 bits.

use super::driver::api::Gl;
use super::driver::own_names;
use super::objects::program::{ATLAS_UNIT, link};
use super::state::Capabilities;
use super::state::known_state::KnownState;
use crate::backend::gl::driver::api;
use crate::backend::gl::state;
use crate::correct::LowerLeftRect;
use crate::error::{Error, ErrorKind, Result};

/// Operation of `glAccum` on the buffer `A` and the colours `C`, with its value `v`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// `A += v C`.
    Accumulate,
    /// `A = v C`.
    Load,
    /// `A += v`.
    Add,
    /// `A *= v`.
    Multiply,
    /// `C = v A`, in the channels that the program's colour mask writes.
    Return,
}

/// An accumulation buffer. Its methods need the context on which it was made to be current.
#[derive(Debug)]
pub struct Accumulation {
    caps: Capabilities,
    framebuffer: u32,
    texture: u32,
    vertex_array: u32,
    /// Sampler that does not convert from sRGB.
    sampler: u32,
    program: u32,
    scale: i32,
    offset: i32,
    size: (i32, i32),
}

const VERTEX: &str = "#version 130
void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
}
";

const FRAGMENT: &str = "#version 130
uniform sampler2D source;
uniform float scale;
uniform float offset;
out vec4 result;
void main() {
    // Not texelFetch, which decodes sRGB whatever the sampler says.
    result = scale * texture(source, gl_FragCoord.xy / vec2(textureSize(source, 0))) + offset;
}
";

impl Accumulation {
    /// Makes a buffer of `size` (width, height in pixels), all zero. Restores every binding that it
    /// changes.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where the driver refuses the shader (OpenGL before 3.0) or the
    /// framebuffer.
    pub fn new(gl: &Gl, size: (i32, i32)) -> Result<Self> {
        let caps = Capabilities::of(gl, false);
        let (framebuffer, mut vertex_array, mut sampler) = (own_names::framebuffer(gl), 0, 0);
        let saved = state::save_and_set(gl, &caps, state::UNITS, &KnownState::default());
        let program = link(gl, VERTEX, FRAGMENT);
        // SAFETY: makes objects of Cupola on the current context; `saved` holds the state that
        // changes.
        let (texture, status) = unsafe {
            let texture = own_names::texture(gl);
            gl.active_texture(api::GL_TEXTURE0);
            gl.bind_texture(api::GL_TEXTURE_2D, texture);
            gl.tex_storage2_d(api::GL_TEXTURE_2D, 1, api::GL_RGBA32F, size.0, size.1);
            gl.gen_vertex_arrays(1, &mut vertex_array);
            gl.gen_samplers(1, &mut sampler);
            gl.sampler_parameteri(sampler, api::GL_TEXTURE_MIN_FILTER, api::GL_NEAREST as i32);
            gl.sampler_parameteri(sampler, api::GL_TEXTURE_MAG_FILTER, api::GL_NEAREST as i32);
            if caps.srgb_decode {
                gl.sampler_parameteri(sampler, api::GL_TEXTURE_SRGB_DECODE_EXT, api::GL_SKIP_DECODE_EXT as i32);
            }
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, framebuffer);
            let (target, point) = (api::GL_DRAW_FRAMEBUFFER, api::GL_COLOR_ATTACHMENT0);
            gl.framebuffer_texture2_d(target, point, api::GL_TEXTURE_2D, texture, 0);
            gl.clear_bufferfv(api::GL_COLOR, 0, [0.0f32; 4].as_ptr());
            (texture, gl.check_framebuffer_status(api::GL_DRAW_FRAMEBUFFER))
        };
        state::restore(gl, &caps, &saved);
        let mut made =
            Self { caps, framebuffer, texture, vertex_array, sampler, program: 0, scale: -1, offset: -1, size };
        match program {
            Ok(program) if status == api::GL_FRAMEBUFFER_COMPLETE => {
                made.program = program;
                // SAFETY: names end with zeroes.
                unsafe {
                    made.scale = gl.get_uniform_location(program, c"scale".as_ptr());
                    made.offset = gl.get_uniform_location(program, c"offset".as_ptr());
                }
                Ok(made)
            }
            other => {
                made.program = other.as_ref().copied().unwrap_or(0);
                made.destroy(gl);
                Err(other.err().unwrap_or_else(|| {
                    let message =
                        format!("The driver cannot make an accumulation buffer of {} × {} pixels.", size.0, size.1);
                    Error::new(ErrorKind::Graphics, message)
                }))
            }
        }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (i32, i32) {
        self.size
    }

    /// Runs an operation of `glAccum` in the rectangles `parts`. Accumulate and load read the
    /// texture `colours`; return writes to `framebuffer`. Both have the size of this buffer.
    pub fn operate(
        &self,
        gl: &Gl,
        operation: Operation,
        value: f32,
        colours: u32,
        framebuffer: u32,
        parts: &[LowerLeftRect],
    ) {
        let saved = state::save_and_set(gl, &self.caps, state::UNITS, &KnownState::default());
        let returns = operation == Operation::Return;
        let (scale, offset) = match operation {
            Operation::Add | Operation::Multiply => (0.0, value),
            _ => (value, 0.0),
        };
        let blend = match operation {
            Operation::Accumulate | Operation::Add => Some((api::GL_ONE, api::GL_ONE)),
            Operation::Multiply => Some((api::GL_ZERO, api::GL_SRC_COLOR)),
            _ => None,
        };
        // SAFETY: a context is current; state that `saved` does not hold is restored below.
        unsafe {
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, if returns { framebuffer } else { self.framebuffer });
            gl.active_texture(api::GL_TEXTURE0 + ATLAS_UNIT);
            gl.bind_texture(api::GL_TEXTURE_2D, if returns { self.texture } else { colours });
            gl.bind_sampler(ATLAS_UNIT, self.sampler);
            gl.bind_vertex_array(self.vertex_array);
            gl.use_program(self.program);
            gl.uniform1f(self.scale, scale);
            gl.uniform1f(self.offset, offset);
            if returns {
                let [red, green, blue, alpha] = saved.color_mask();
                gl.color_maski(0, red, green, blue, alpha);
            }
            let blended = blend.map(|(source, destination)| SavedBlend::replace(gl, source, destination));
            for part in parts {
                state::set_viewport(gl, &self.caps, *part);
                gl.draw_arrays(api::GL_TRIANGLES, 0, 3);
            }
            if let Some(saved) = blended {
                saved.put_back(gl);
            }
            if returns {
                gl.color_maski(0, 1, 1, 1, 1);
            }
        }
        state::restore(gl, &self.caps, &saved);
    }

    /// Fills `parts` with `colour`.
    pub fn clear(&self, gl: &Gl, colour: [f32; 4], parts: &[LowerLeftRect]) {
        let saved = state::save_and_set(gl, &self.caps, 0, &KnownState::default());
        let mut scissor = [0; 4];
        // SAFETY: a context is current; the scissor is restored.
        unsafe {
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, self.framebuffer);
            gl.get_integerv(api::GL_SCISSOR_BOX, scissor.as_mut_ptr());
            gl.enable(api::GL_SCISSOR_TEST);
            for LowerLeftRect { x, y, width, height } in parts {
                gl.scissor(*x, *y, *width, *height);
                gl.clear_bufferfv(api::GL_COLOR, 0, colour.as_ptr());
            }
            gl.disable(api::GL_SCISSOR_TEST);
            let [x, y, width, height] = scissor;
            gl.scissor(x, y, width, height);
        }
        state::restore(gl, &self.caps, &saved);
    }

    /// Deletes the buffer's objects.
    pub fn destroy(&self, gl: &Gl) {
        // SAFETY: objects of Cupola; the name 0 is ignored.
        unsafe {
            gl.delete_program(self.program);
            gl.delete_framebuffers(1, &self.framebuffer);
            gl.delete_textures(1, &self.texture);
            gl.delete_vertex_arrays(1, &self.vertex_array);
            gl.delete_samplers(1, &self.sampler);
        }
    }
}

/// Blending state of the first draw buffer, saved while an operation blends with other factors.
struct SavedBlend {
    /// Factors and equations, as in [`FUNCTIONS`] and [`EQUATIONS`].
    functions: [i32; 4],
    equations: [i32; 2],
}

const FUNCTIONS: [u32; 4] =
    [api::GL_BLEND_SRC_RGB, api::GL_BLEND_DST_RGB, api::GL_BLEND_SRC_ALPHA, api::GL_BLEND_DST_ALPHA];
const EQUATIONS: [u32; 2] = [api::GL_BLEND_EQUATION_RGB, api::GL_BLEND_EQUATION_ALPHA];

impl SavedBlend {
    /// Saves the state, and switches blending on: a sum with these factors.
    ///
    /// # Safety
    /// A context is current.
    unsafe fn replace(gl: &Gl, source: u32, destination: u32) -> Self {
        let mut saved = Self { functions: [0; 4], equations: [0; 2] };
        // SAFETY: as promised; each question writes one integer.
        unsafe {
            for (value, name) in saved.functions.iter_mut().zip(FUNCTIONS) {
                gl.get_integerv(name, value);
            }
            for (value, name) in saved.equations.iter_mut().zip(EQUATIONS) {
                gl.get_integerv(name, value);
            }
            gl.enablei(api::GL_BLEND, 0);
            gl.blend_equation(api::GL_FUNC_ADD);
            gl.blend_func(source, destination);
        }
        saved
    }

    /// Switches blending off, with the factors and equations that it had.
    ///
    /// # Safety
    /// As for [`replace`](Self::replace).
    unsafe fn put_back(self, gl: &Gl) {
        let [source, destination, source_alpha, destination_alpha] = self.functions.map(|value| value as u32);
        let [colour, alpha] = self.equations.map(|value| value as u32);
        // SAFETY: as promised.
        unsafe {
            gl.blend_func_separate(source, destination, source_alpha, destination_alpha);
            gl.blend_equation_separate(colour, alpha);
            gl.disablei(api::GL_BLEND, 0);
        }
    }
}
