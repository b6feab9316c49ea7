//! Timing of corrections on an OpenGL context: Cupola's own and those of other programs.
//!
//! All corrections are drawn in turn, round by round, so that other load on the machine affects all
//! of them equally.

use cupola::backend::gl::driver::api::*;
use cupola::backend::gl::driver::headless::{Api, Headless};
use cupola::backend::gl::{GlBackend, Target};
use cupola::correct::LowerLeftRect;
use cupola::correct::Plan;
use cupola::{Error, ErrorKind, Result};
use std::time::Instant;

/// Number of warm-up rounds, which are not counted.
const WARM_UP: u32 = 2;

const VERTEX: &str = "#version 330 core
layout(location = 0) in vec2 place;
layout(location = 1) in vec3 coordinate;
noperspective out vec3 at;
void main() { at = coordinate; gl_Position = vec4(place, 0.0, 1.0); }";

/// Triangles over the output. Each corner has a coordinate that determines the colour of fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrialMesh {
    /// Position (−1…1 from the left and from the bottom) and coordinate of each corner.
    pub corners: Vec<[f32; 5]>,
    /// Indices of the three corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl TrialMesh {
    /// A rectangle over the whole output with coordinates 0…1 from the bottom left.
    pub fn quad() -> Self {
        let corner = |x: f32, y: f32| [2.0 * x - 1.0, 2.0 * y - 1.0, x, y, 0.0];
        let corners = vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        Self { corners, triangles: vec![[0, 1, 2], [0, 2, 3]] }
    }
}

/// Rule that determines a fragment's colour from its coordinate.
#[derive(Clone, Debug, PartialEq)]
pub enum Sampling {
    /// x and y are a position in a picture with this width and height in texels.
    Picture(u32, u32),
    /// A direction in a cube map whose faces have this width in texels.
    Cube(u32),
    /// GLSL that first computes another coordinate, the body of `vec3 formula(vec3 at)`; and how
    /// the result is sampled.
    Formula(String, Box<Sampling>),
}

impl Sampling {
    /// The sampling of the final coordinate.
    pub fn picture(&self) -> &Self {
        match self {
            Self::Formula(_, picture) => picture.picture(),
            picture => picture,
        }
    }
}

/// Times of a correction in each round.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Times {
    /// Seconds from the first call until the driver has finished.
    pub seconds: Vec<f64>,
    /// Processor time of all threads in seconds, which other load on the machine affects less.
    pub processor: Vec<f64>,
}

/// An OpenGL context and the corrections that are timed on it.
pub struct Trial {
    context: Headless,
    size: (u32, u32),
    framebuffer: u32,
    contestants: Vec<Contestant>,
}

struct Contestant {
    pass: Pass,
    texture: u32,
    /// Size of the texture, or of each of its faces.
    extent: (u32, u32),
    times: Times,
}

enum Pass {
    Ours(Box<GlBackend>),
    Mesh { program: u32, vertex_array: u32, indices: i32, target: u32 },
}

impl Trial {
    /// Creates a context and an output of `size` pixels.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] if no context can be created.
    pub fn new(size: (u32, u32)) -> Result<Self> {
        let context = Headless::new(Api::Core)?;
        let framebuffer = framebuffer(&context.gl, size, GL_RGBA8);
        Ok(Self { context, size, framebuffer, contestants: Vec::new() })
    }

    /// Name of the driver.
    pub fn driver(&self) -> String {
        self.context.driver()
    }

    /// The context, to compute maps on.
    pub fn context(&self) -> &Headless {
        &self.context
    }

    /// Adds Cupola's correction of the first output of `plan`. Returns its number among the
    /// results, and the seconds until it was drawn for the first time, including preparation and
    /// compilation by the driver.
    ///
    /// # Errors
    /// Those of [`GlBackend::prepare`].
    pub fn add_plan(&mut self, plan: &Plan) -> Result<(usize, f64)> {
        let gl = &self.context.gl;
        let started = Instant::now();
        let mut backend = GlBackend::new(gl, false)?;
        let only = Plan { views: plan.views.clone(), passes: plan.passes.iter().take(1).cloned().collect() };
        backend.prepare(gl, &only, false)?;
        let viewport = LowerLeftRect::of_size(self.size);
        backend.own_framebuffer(&[Target { framebuffer: self.framebuffer, viewport }], self.size);
        let mut seconds = started.elapsed().as_secs_f64();
        let contestant = Contestant {
            pass: Pass::Ours(Box::new(backend)),
            texture: texture(gl, GL_TEXTURE_2D, plan.views.atlas),
            extent: plan.views.atlas,
            times: Times::default(),
        };
        let started = Instant::now();
        contestant.draw(gl, &Target { framebuffer: self.framebuffer, viewport });
        // SAFETY: the context is current.
        unsafe { gl.finish() };
        seconds += started.elapsed().as_secs_f64();
        self.contestants.push(contestant);
        Ok((self.contestants.len() - 1, seconds))
    }

    /// Adds a mesh. Returns its number among the results.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] if the driver refuses the shader.
    pub fn add_mesh(&mut self, mesh: &TrialMesh, sampling: &Sampling) -> Result<usize> {
        let gl = &self.context.gl;
        let (size, target) = match *sampling.picture() {
            Sampling::Picture(width, height) => ((width, height), GL_TEXTURE_2D),
            Sampling::Cube(side) => ((side, side), GL_TEXTURE_CUBE_MAP),
            Sampling::Formula(..) => return Err(Error::new(ErrorKind::Internal, "a formula has no picture")),
        };
        let texture = texture(gl, target, size);
        let program = program(gl, &fragment(sampling, false))?;
        let vertex_array = vertex_array(gl, mesh);
        let pass = Pass::Mesh { program, vertex_array, indices: 3 * mesh.triangles.len() as i32, target };
        self.contestants.push(Contestant { pass, texture, extent: size, times: Times::default() });
        Ok(self.contestants.len() - 1)
    }

    /// The final coordinate of each pixel of a mesh, row by row from the top. The fourth component
    /// is 0 where nothing was drawn.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] if the driver refuses the shader or cannot render to 32-bit floats.
    pub fn coordinates(&self, mesh: &TrialMesh, sampling: &Sampling) -> Result<Vec<[f32; 4]>> {
        let gl = &self.context.gl;
        let program = program(gl, &fragment(sampling, true))?;
        let vertex_array = vertex_array(gl, mesh);
        let pass =
            Pass::Mesh { program, vertex_array, indices: 3 * mesh.triangles.len() as i32, target: GL_TEXTURE_2D };
        let drawn = Contestant { pass, texture: 0, extent: (0, 0), times: Times::default() };
        let (width, height) = (self.size.0 as i32, self.size.1 as i32);
        let framebuffer = framebuffer(gl, self.size, GL_RGBA32F);
        let mut texels = vec![[0.0f32; 4]; self.size.0 as usize * self.size.1 as usize];
        // SAFETY: the context is current; rows of four floats need no padding, and the array holds
        // width · height of them.
        let error = unsafe {
            gl.clear_color(0.0, 0.0, 0.0, 0.0);
            gl.clear(GL_COLOR_BUFFER_BIT);
            drawn.draw(gl, &Target { framebuffer, viewport: LowerLeftRect::new(0, 0, width, height) });
            gl.read_pixels(0, 0, width, height, GL_RGBA, GL_FLOAT, texels.as_mut_ptr().cast());
            gl.get_error()
        };
        if error != GL_NO_ERROR {
            return Err(Error::new(
                ErrorKind::Graphics,
                format!("the driver reported error {error:#x} for a float target"),
            ));
        }
        Ok(texels.chunks_exact(self.size.0 as usize).rev().flatten().copied().collect())
    }

    /// Replaces the noise in the texture that contestant `number` samples by pictures: one for an
    /// atlas or picture, six in OpenGL's order for a cube map. Texels are RGBA bytes, row by row
    /// from the bottom.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an unknown number and for pictures of another size.
    pub fn fill(&self, number: usize, pictures: &[Vec<u32>]) -> Result<()> {
        let contestant = self.contestant(number)?;
        let texels = contestant.extent.0 as usize * contestant.extent.1 as usize;
        let faces = faces(contestant.target());
        if pictures.len() != faces.len() || pictures.iter().any(|picture| picture.len() != texels) {
            let message = format!("expected {} pictures of {texels} texels", faces.len());
            return Err(Error::new(ErrorKind::InvalidArgument, message));
        }
        let (gl, (width, height)) = (&self.context.gl, contestant.extent);
        // SAFETY: the context is current; each array holds as many texels as the texture.
        unsafe {
            gl.bind_texture(contestant.target(), contestant.texture);
            for (face, picture) in faces.zip(pictures) {
                let (width, height, data) = (width as i32, height as i32, picture.as_ptr().cast());
                gl.tex_sub_image2_d(face, 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, data);
            }
        }
        Ok(())
    }

    /// The picture that contestant `number` draws, RGBA, row by row from the top.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an unknown number.
    pub fn picture(&self, number: usize) -> Result<Vec<[u8; 4]>> {
        let contestant = self.contestant(number)?;
        let (gl, (width, height)) = (&self.context.gl, (self.size.0 as i32, self.size.1 as i32));
        let mut pixels = vec![[0u8; 4]; self.size.0 as usize * self.size.1 as usize];
        // SAFETY: the context is current; rows of four bytes need no padding, and the array holds
        // width · height of them.
        unsafe {
            gl.bind_framebuffer(GL_FRAMEBUFFER, self.framebuffer);
            gl.clear_color(0.0, 0.0, 0.0, 1.0);
            gl.clear(GL_COLOR_BUFFER_BIT);
            contestant
                .draw(gl, &Target { framebuffer: self.framebuffer, viewport: LowerLeftRect::new(0, 0, width, height) });
            gl.bind_framebuffer(GL_READ_FRAMEBUFFER, self.framebuffer);
            gl.read_pixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.as_mut_ptr().cast());
        }
        Ok(pixels.chunks_exact(self.size.0 as usize).rev().flatten().copied().collect())
    }

    fn contestant(&self, number: usize) -> Result<&Contestant> {
        let missing = || Error::new(ErrorKind::InvalidArgument, format!("there is no contestant {number}"));
        self.contestants.get(number).ok_or_else(missing)
    }

    /// Draws all contestants in turn, `rounds` times, and calls `after` after each round. Returns
    /// the times in the order in which contestants were added.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] if the driver reports an error.
    pub fn run(&mut self, rounds: u32, mut after: impl FnMut()) -> Result<Vec<Times>> {
        let gl = &self.context.gl;
        let viewport = LowerLeftRect::of_size(self.size);
        for round in 0..rounds + WARM_UP {
            for contestant in &mut self.contestants {
                let (started, used) = (Instant::now(), processor_seconds());
                contestant.draw(gl, &Target { framebuffer: self.framebuffer, viewport });
                // SAFETY: the context is current.
                unsafe { gl.finish() };
                if round >= WARM_UP {
                    contestant.times.seconds.push(started.elapsed().as_secs_f64());
                    contestant.times.processor.push(processor_seconds() - used);
                }
            }
            after();
        }
        // SAFETY: the context is current.
        let error = unsafe { gl.get_error() };
        if error != GL_NO_ERROR {
            return Err(Error::new(
                ErrorKind::Graphics,
                format!("the driver reported error {error:#x} while corrections were timed"),
            ));
        }
        Ok(self.contestants.iter().map(|contestant| contestant.times.clone()).collect())
    }
}

impl Contestant {
    /// The target that its texture is bound to.
    fn target(&self) -> u32 {
        match self.pass {
            Pass::Ours(_) => GL_TEXTURE_2D,
            Pass::Mesh { target, .. } => target,
        }
    }

    fn draw(&self, gl: &Gl, target: &Target) {
        match &self.pass {
            Pass::Ours(backend) => _ = backend.present(gl, self.texture, &[*target]),
            Pass::Mesh { program, vertex_array, indices, target: binding } => {
                let LowerLeftRect { x, y, width, height } = target.viewport;
                // SAFETY: the context is current, the names are its own, and the index buffer holds
                // `indices` indices.
                unsafe {
                    gl.bind_framebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer);
                    gl.viewport(x, y, width, height);
                    gl.disable(GL_DITHER);
                    gl.use_program(*program);
                    gl.bind_vertex_array(*vertex_array);
                    gl.active_texture(GL_TEXTURE0);
                    gl.bind_texture(*binding, self.texture);
                    gl.draw_elements(GL_TRIANGLES, *indices, GL_UNSIGNED_INT, std::ptr::null());
                }
            }
        }
    }
}

/// Processor time of all threads of this process so far, in seconds.
fn processor_seconds() -> f64 {
    let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `now` is a valid timespec. The clock exists on every Linux; without it the time stays
    // 0.
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &mut now) };
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}

/// The fragment shader of a sampling. With `coordinates` it writes the final coordinate instead of
/// the colour.
fn fragment(sampling: &Sampling, coordinates: bool) -> String {
    let (sampler, place) = match sampling.picture() {
        Sampling::Picture(..) => ("sampler2D", "where.xy"),
        _ => ("samplerCube", "where"),
    };
    let formula = match sampling {
        Sampling::Formula(body, _) => body,
        _ => "return at;",
    };
    let color =
        if coordinates { "vec4(where, 1.0)".to_owned() } else { format!("vec4(texture(picture, {place}).rgb, 1.0)") };
    format!(
        "#version 330 core\nuniform {sampler} picture;\nnoperspective in vec3 at;\nout vec4 color;\n\
         vec3 formula(vec3 at) {{\n{formula}\n}}\nvoid main() {{ vec3 where = formula(at); color = {color}; }}"
    )
}

/// The image targets of a texture target.
fn faces(target: u32) -> std::ops::Range<u32> {
    if target == GL_TEXTURE_2D {
        GL_TEXTURE_2D..GL_TEXTURE_2D + 1
    } else {
        GL_TEXTURE_CUBE_MAP_POSITIVE_X..GL_TEXTURE_CUBE_MAP_NEGATIVE_Z + 1
    }
}

/// A texture filled with noise, 2D or with six faces.
fn texture(gl: &Gl, target: u32, size: (u32, u32)) -> u32 {
    let (width, height) = (size.0 as i32, size.1 as i32);
    let pixels: Vec<u32> = (0..size.0 * size.1).map(|i| i.wrapping_mul(2_654_435_761) | 0xff00_0000).collect();
    let faces = faces(target);
    let mut texture = 0;
    // SAFETY: the context is current; the array holds width · height pixels.
    unsafe {
        gl.gen_textures(1, &mut texture);
        gl.bind_texture(target, texture);
        for face in faces {
            let data = pixels.as_ptr().cast();
            gl.tex_image2_d(face, 0, GL_RGBA8 as i32, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, data);
        }
        gl.tex_parameteri(target, GL_TEXTURE_MIN_FILTER, GL_LINEAR as i32);
        gl.tex_parameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
    }
    texture
}

/// Creates a framebuffer of `size` pixels and binds it for drawing and reading.
fn framebuffer(gl: &Gl, size: (u32, u32), format: u32) -> u32 {
    let (mut renderbuffer, mut framebuffer) = (0, 0);
    // SAFETY: the context is current.
    unsafe {
        gl.gen_renderbuffers(1, &mut renderbuffer);
        gl.bind_renderbuffer(GL_RENDERBUFFER, renderbuffer);
        gl.renderbuffer_storage(GL_RENDERBUFFER, format, size.0 as i32, size.1 as i32);
        gl.gen_framebuffers(1, &mut framebuffer);
        gl.bind_framebuffer(GL_FRAMEBUFFER, framebuffer);
        gl.framebuffer_renderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, renderbuffer);
    }
    framebuffer
}

fn program(gl: &Gl, fragment: &str) -> Result<u32> {
    // SAFETY: the context is current; each string has the length that is given.
    unsafe {
        let program = gl.create_program();
        for (kind, text) in [(GL_VERTEX_SHADER, VERTEX), (GL_FRAGMENT_SHADER, fragment)] {
            let shader = gl.create_shader(kind);
            gl.shader_source(shader, 1, &text.as_ptr().cast(), &(text.len() as i32));
            gl.compile_shader(shader);
            gl.attach_shader(program, shader);
        }
        gl.link_program(program);
        let mut linked = 0;
        gl.get_programiv(program, GL_LINK_STATUS, &mut linked);
        if linked == 0 {
            return Err(Error::new(ErrorKind::Graphics, "the driver cannot link the shader of a correction"));
        }
        Ok(program)
    }
}

fn vertex_array(gl: &Gl, mesh: &TrialMesh) -> u32 {
    let (mut vertex_array, mut buffers) = (0, [0; 2]);
    let stride = size_of::<[f32; 5]>() as i32;
    // SAFETY: the context is current; the slices live during the calls, and the sizes are their
    // lengths in bytes.
    unsafe {
        gl.gen_vertex_arrays(1, &mut vertex_array);
        gl.bind_vertex_array(vertex_array);
        gl.gen_buffers(2, buffers.as_mut_ptr());
        gl.bind_buffer(GL_ARRAY_BUFFER, buffers[0]);
        let (corners, triangles) = (&mesh.corners[..], &mesh.triangles[..]);
        gl.buffer_data(GL_ARRAY_BUFFER, size_of_val(corners) as isize, corners.as_ptr().cast(), GL_STATIC_DRAW);
        gl.bind_buffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
        let indices = triangles.as_ptr().cast();
        gl.buffer_data(GL_ELEMENT_ARRAY_BUFFER, size_of_val(triangles) as isize, indices, GL_STATIC_DRAW);
        gl.vertex_attrib_pointer(0, 2, GL_FLOAT, 0, stride, std::ptr::null());
        gl.vertex_attrib_pointer(1, 3, GL_FLOAT, 0, stride, (2 * size_of::<f32>()) as *const _);
        gl.enable_vertex_attrib_array(0);
        gl.enable_vertex_attrib_array(1);
    }
    vertex_array
}
