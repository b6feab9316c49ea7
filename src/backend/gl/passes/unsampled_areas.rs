//! Closes parts of the atlas by their depth, so that nothing is shaded there.
//!
//! One call draws all rectangles. A clear with a scissor for each rectangle would need no other
//! state, but software renderers take 0.2 ms for each.

use crate::backend::gl::driver::api::*;
use crate::backend::gl::driver::own_names;
use crate::backend::gl::driver::values;
use crate::backend::gl::objects::binaries::Binaries;
use crate::backend::gl::objects::program;
use crate::backend::gl::state;
use crate::backend::gl::state::Capabilities;
use crate::backend::gl::state::known_state::KnownState;
use crate::correct::shaders::glsl::Specialised;
use crate::correct::{LowerLeftRect, Tile};
use crate::error::Result;

/// Texts of the shaders for OpenGL 3.3 and OpenGL ES 3.0. They map texels of the atlas to clip
/// coordinates, at the depth `frame.z`.
macro_rules! texts {
    ($version:literal) => {
        (
            concat!(
                $version,
                "\nlayout(location = 0) in vec2 texel;\nuniform vec3 frame;\n",
                "void main() { gl_Position = vec4(texel * frame.xy - 1.0, frame.z, 1.0); }\n"
            ),
            concat!($version, "\nvoid main() {}\n"),
        )
    };
}

/// Unsampled areas of the atlas, as objects of one context.
#[derive(Debug)]
pub(in crate::backend::gl) struct UnsampledAreas {
    vertex_array: u32,
    buffer: u32,
    program: u32,
    /// Location of the uniform `frame`.
    frame: i32,
    vertices: i32,
    texels: u64,
    /// Width and height of the atlas.
    atlas: (u32, u32),
}

impl UnsampledAreas {
    /// Uploads `areas` of an atlas of the given size. The caller saves and restores the state that
    /// uploading changes.
    ///
    /// # Errors
    /// [`Graphics`](crate::ErrorKind::Graphics) where the driver refuses the shader.
    pub fn new(gl: &Gl, caps: &Capabilities, binaries: &Binaries, areas: &[Tile], atlas: (u32, u32)) -> Result<Self> {
        let (vertex, fragment) = if caps.gles { texts!("#version 300 es") } else { texts!("#version 330 core") };
        let text = Specialised { vertex, fragment: fragment.to_owned(), samplers: &[] };
        let program = program::build(gl, &text, binaries)?;
        let corners: Vec<[f32; 2]> = areas
            .iter()
            .flat_map(|tile| {
                let [left, bottom] = [tile.x as f32, tile.y as f32];
                let [right, top] = [(tile.x + tile.width) as f32, (tile.y + tile.height) as f32];
                [[left, bottom], [right, bottom], [left, top], [left, top], [right, bottom], [right, top]]
            })
            .collect();
        let mut unsampled = Self {
            vertex_array: 0,
            buffer: 0,
            program,
            frame: 0,
            vertices: corners.len() as i32,
            texels: areas.iter().map(Tile::area).sum(),
            atlas,
        };
        // SAFETY: a context is current; one name is written to each place; `size` is that of the
        // array.
        unsafe {
            unsampled.frame = gl.get_uniform_location(program, c"frame".as_ptr());
            gl.gen_vertex_arrays(1, &mut unsampled.vertex_array);
            unsampled.buffer = own_names::buffer(gl);
            gl.bind_vertex_array(unsampled.vertex_array);
            gl.bind_buffer(GL_ARRAY_BUFFER, unsampled.buffer);
            let size = std::mem::size_of_val(corners.as_slice()) as isize;
            gl.buffer_data(GL_ARRAY_BUFFER, size, corners.as_ptr().cast(), GL_STATIC_DRAW);
            gl.enable_vertex_attrib_array(0);
            gl.vertex_attrib_pointer(0, 2, GL_FLOAT, 0, 0, std::ptr::null());
        }
        Ok(unsampled)
    }

    /// Sets the rectangles of the bound framebuffer to the depth that is farthest from `cleared`.
    /// Returns the number of their texels, or 0 if nothing could be done. All state is restored;
    /// stencil and colour do not change.
    pub fn close(&self, gl: &Gl, caps: &Capabilities, cleared: f32, known: &KnownState) -> u64 {
        // If depth is not written, the program's clear did not change it either.
        if !values::boolean(gl, GL_DEPTH_WRITEMASK) || counting(gl, caps) || !state::can_draw(gl, caps) {
            return 0;
        }
        let saved = state::save_and_set(gl, caps, 0, known);
        let function = values::integer(gl, GL_DEPTH_FUNC) as u32;
        let mut range = [0.0f32; 4];
        let (width, height) = (self.atlas.0 as f32, self.atlas.1 as f32);
        // SAFETY: a context is current; all names are ones that it gave; a range has two parts.
        unsafe {
            gl.get_floatv(GL_DEPTH_RANGE, range.as_mut_ptr());
            // Depth −1 of clip coordinates becomes the first end of the range.
            let first = (range[0] <= range[1]) == (cleared >= 0.5);
            gl.enable(GL_DEPTH_TEST);
            gl.depth_func(GL_ALWAYS);
            state::set_color_writes(gl, caps, false);
            state::set_viewport(gl, caps, LowerLeftRect::of_size(self.atlas));
            gl.bind_vertex_array(self.vertex_array);
            gl.use_program(self.program);
            gl.uniform3f(self.frame, 2.0 / width, 2.0 / height, if first { -1.0 } else { 1.0 });
            gl.draw_arrays(GL_TRIANGLES, 0, self.vertices);
            state::set_color_writes(gl, caps, true);
            gl.depth_func(function);
            gl.disable(GL_DEPTH_TEST);
        }
        state::restore(gl, caps, &saved);
        self.texels
    }

    /// Deletes everything in the context, which must be current.
    pub fn destroy(self, gl: &Gl) {
        // SAFETY: the context is current and gave these names.
        unsafe {
            gl.delete_program(self.program);
            gl.delete_buffers(1, &self.buffer);
            gl.delete_vertex_arrays(1, &self.vertex_array);
        }
    }
}

/// True if a query of the program is active that would count samples or primitives of Cupola.
pub(super) fn counting(gl: &Gl, caps: &Capabilities) -> bool {
    let desktop: &[u32] = &[GL_SAMPLES_PASSED, GL_PRIMITIVES_GENERATED];
    let conservative: &[u32] = &[GL_ANY_SAMPLES_PASSED_CONSERVATIVE];
    let targets = [
        if caps.gles { &[] } else { desktop },
        &[GL_ANY_SAMPLES_PASSED],
        if caps.gles || caps.version >= 43 { conservative } else { &[] },
    ];
    targets.into_iter().flatten().any(|&target| {
        let mut active = 0;
        // SAFETY: a context is current and knows the target; one number is written.
        unsafe { gl.get_queryiv(target, GL_CURRENT_QUERY, &mut active) };
        active != 0
    })
}
