//! Draws a picture behind a scene, in all directions.

use crate::backend::gl::driver::api::*;
use crate::backend::gl::driver::own_names;
use crate::backend::gl::objects::binaries::Binaries;
use crate::backend::gl::objects::framebuffers::{FramebufferBindings, blit};
use crate::backend::gl::objects::program;
use crate::backend::gl::passes::unsampled_areas::counting;
use crate::backend::gl::state;
use crate::backend::gl::state::Capabilities;
use crate::backend::gl::state::known_state::KnownState;
use crate::correct::Intrinsics;
use crate::correct::shaders::glsl::Specialised;
use crate::correct::{BlitRect, LowerLeftRect};
use crate::error::{Error, ErrorKind, Result};
use glam::DMat3;

/// A picture behind the scene, and the tiles to fill with it.
pub struct Spread<'a> {
    /// Framebuffer that contains the picture.
    pub framebuffer: u32,
    /// Rectangle of the picture there.
    pub picture: LowerLeftRect,
    /// Sized format of the picture.
    pub format: u32,
    /// Lens of the picture.
    pub lens: Intrinsics,
    /// Tiles of the bound draw framebuffer. The matrix of a tile maps a place in it (−1…1 to the
    /// right and up, 1) to a direction (right, up, ahead) in the camera's axes.
    pub tiles: &'a [(LowerLeftRect, DMat3)],
}

/// Texts of the shaders for OpenGL 3.3 and OpenGL ES 3.0.
///
/// A direction within the lens has the colour of its place in the picture. A direction outside has
/// the colour of the picture's border. Beyond the left and right sides, directions of equal
/// elevation map to equal heights of the picture. So no view has a seam.
macro_rules! texts {
    ($version:literal) => {
        (
            concat!(
                $version,
                "\nout vec2 place;\nvoid main() {\n",
                "    place = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 4.0 - 1.0;\n",
                "    gl_Position = vec4(place, 0.0, 1.0);\n}\n"
            ),
            concat!(
                $version,
                "\nprecision highp float;\nuniform highp sampler2D picture;\nuniform mat3 directions;\n",
                "uniform vec4 lens;\nuniform float nearest;\nin vec2 place;\nout vec4 colour;\nvoid main() {\n",
                "    vec3 at = normalize(directions * vec3(place, 1.0));\n",
                "    float x = lens.x * at.x / max(at.z, 1e-4) - lens.y;\n",
                "    float y = lens.z * at.y / max(max(at.z, nearest * length(at.xz)), 1e-4) - lens.w;\n",
                "    colour = textureLod(picture, clamp(vec2(x, y), -1.0, 1.0) * 0.5 + 0.5, 0.0);\n}\n"
            ),
        )
    };
}

/// Objects that draw a backdrop, on one context.
#[derive(Debug)]
pub(in crate::backend::gl) struct Backdrop {
    vertex_array: u32,
    program: u32,
    /// Locations of the uniforms `directions`, `lens` and `nearest`.
    places: [i32; 3],
    framebuffer: u32,
    texture: u32,
    size: [i32; 2],
    format: u32,
}

impl Backdrop {
    /// Makes the objects. The caller saves and restores the state that uploading changes.
    ///
    /// # Errors
    /// [`Graphics`](ErrorKind::Graphics) where the driver refuses the shader.
    pub fn new(gl: &Gl, caps: &Capabilities, binaries: &Binaries) -> Result<Self> {
        let (vertex, fragment) = if caps.gles { texts!("#version 300 es") } else { texts!("#version 330 core") };
        let text = Specialised { vertex, fragment: fragment.to_owned(), samplers: &[] };
        let program = program::build(gl, &text, binaries)?;
        let places = [c"directions", c"lens", c"nearest"];
        let mut backdrop =
            Self { vertex_array: 0, program, places: [0; 3], framebuffer: 0, texture: 0, size: [0; 2], format: 0 };
        // SAFETY: a context is current and gave the program, which is in use; a name is written to
        // each place.
        unsafe {
            backdrop.places = places.map(|name| gl.get_uniform_location(program, name.as_ptr()));
            gl.uniform1i(gl.get_uniform_location(program, c"picture".as_ptr()), 0);
            gl.gen_vertex_arrays(1, &mut backdrop.vertex_array);
            backdrop.framebuffer = own_names::framebuffer(gl);
        }
        Ok(backdrop)
    }

    /// Fills the tiles. All state is restored; depth and stencil do not change. Returns false if
    /// nothing could be drawn, or if the program's mask does not write all colours.
    ///
    /// # Errors
    /// [`Graphics`](ErrorKind::Graphics) where the driver cannot copy the picture.
    pub fn spread(&mut self, gl: &Gl, caps: &Capabilities, what: &Spread<'_>, known: &KnownState) -> Result<bool> {
        if counting(gl, caps) || !state::can_draw(gl, caps) || !gl.has_tex_storage2_d() {
            return Ok(false);
        }
        let saved = state::save_and_set(gl, caps, 1, known);
        let writes = saved.color_mask().iter().all(|mask| *mask != 0);
        let done = if writes { self.copy(gl, what).map(|()| self.draw(gl, caps, what)) } else { Ok(()) };
        state::restore(gl, caps, &saved);
        done.map(|()| writes)
    }

    /// Copies the picture into the texture, which is bound afterwards.
    fn copy(&mut self, gl: &Gl, what: &Spread<'_>) -> Result<()> {
        let LowerLeftRect { width, height, .. } = what.picture;
        // SAFETY: objects of Cupola; bindings of framebuffers are restored here, those of textures
        // by the caller.
        let complete = unsafe {
            let framebuffers = FramebufferBindings::save(gl);
            let other = self.size != [width, height] || self.format != what.format;
            if other {
                // The storage of a texture cannot be changed.
                gl.delete_textures(1, &self.texture);
                self.texture = own_names::texture(gl);
            }
            gl.active_texture(GL_TEXTURE0);
            gl.bind_texture(GL_TEXTURE_2D, self.texture);
            gl.bind_sampler(0, 0);
            gl.bind_framebuffer(GL_DRAW_FRAMEBUFFER, self.framebuffer);
            if other {
                gl.tex_storage2_d(GL_TEXTURE_2D, 1, what.format, width, height);
                for name in [GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T] {
                    gl.tex_parameteri(GL_TEXTURE_2D, name, GL_CLAMP_TO_EDGE as i32);
                }
                for name in [GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER] {
                    gl.tex_parameteri(GL_TEXTURE_2D, name, GL_LINEAR as i32);
                }
                gl.framebuffer_texture2_d(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, self.texture, 0);
            }
            let complete = gl.check_framebuffer_status(GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
            if complete {
                gl.bind_framebuffer(GL_READ_FRAMEBUFFER, what.framebuffer);
                let (mask, filter) = (GL_COLOR_BUFFER_BIT, GL_NEAREST);
                blit(gl, what.picture.corners(), BlitRect::new(0, 0, width, height), mask, filter);
                (self.size, self.format) = ([width, height], what.format);
            }
            framebuffers.restore(gl);
            complete
        };
        let refused = || Error::new(ErrorKind::Graphics, "The driver cannot copy the background of a scene.");
        complete.then_some(()).ok_or_else(refused)
    }

    fn draw(&self, gl: &Gl, caps: &Capabilities, what: &Spread<'_>) {
        let [directions, lens, nearest] = self.places;
        let Intrinsics { a, b, c, d, .. } = what.lens;
        let side = ((b - 1.0) / a).abs().max(((b + 1.0) / a).abs());
        // SAFETY: a context is current; all names are ones that it gave; a matrix has nine numbers.
        unsafe {
            gl.bind_vertex_array(self.vertex_array);
            gl.use_program(self.program);
            gl.uniform4f(lens, a as f32, b as f32, c as f32, d as f32);
            gl.uniform1f(nearest, (1.0 / side.hypot(1.0)) as f32);
            for (tile, matrix) in what.tiles {
                state::set_viewport(gl, caps, *tile);
                let numbers = matrix.to_cols_array().map(|number| number as f32);
                gl.uniform_matrix3fv(directions, 1, 0, numbers.as_ptr());
                state::within(gl, caps, *tile, || gl.draw_arrays(GL_TRIANGLES, 0, 3));
            }
        }
    }

    /// Moves to the current context, which shares the program and the texture with the former one,
    /// but not the framebuffer and the vertex array.
    pub fn rehome(&mut self, gl: &Gl) {
        // SAFETY: the context is current, and a name is written.
        unsafe { gl.gen_vertex_arrays(1, &mut self.vertex_array) };
        self.framebuffer = own_names::framebuffer(gl);
        // The next picture gets a new texture, attached to the new framebuffer.
        self.size = [0; 2];
    }

    /// Deletes everything in the context, which must be current.
    pub fn destroy(self, gl: &Gl) {
        // SAFETY: the context is current and gave these names.
        unsafe {
            gl.delete_program(self.program);
            gl.delete_vertex_arrays(1, &self.vertex_array);
            gl.delete_framebuffers(1, &self.framebuffer);
            gl.delete_textures(1, &self.texture);
        }
    }
}
