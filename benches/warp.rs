//! What correcting costs, in units of drawing one bilinear full-screen quad.
//!
//! `cargo bench --bench warp [-- WIDTH HEIGHT ROUNDS]`. All passes are timed in turn, round by
//! round, so that a busy machine slows all alike; the medians of the ratios are reported.

use cupola::backend::gl::api::*;
use cupola::backend::gl::headless::{Api, Headless};
use cupola::backend::gl::{GlBackend, Target};
use cupola::correct::Plan;
use cupola::correct::plan::build;
use cupola::geom::Frustum;
use cupola::rig::*;
use cupola::views::Request;
use glam::DVec3;
use std::time::Instant;

const VERTEX: &str = "#version 330 core
out vec2 at;
void main() {
    vec2 corner = vec2(gl_VertexID == 1 || gl_VertexID == 2 || gl_VertexID == 4, gl_VertexID == 2 || gl_VertexID == 4 || gl_VertexID == 5);
    at = corner;
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}";
const FRAGMENT: &str = "#version 330 core
uniform sampler2D picture;
in vec2 at;
out vec4 color;
void main() { color = vec4(texture(picture, at).rgb, 1.0); }";

type Failure = Box<dyn std::error::Error>;

/// One thing that is timed.
struct Contestant {
    name: String,
    backend: Option<GlBackend>,
    atlas: u32,
    /// Elapsed, and of all threads' processor time, which a busy machine disturbs less.
    seconds: Vec<f64>,
    processor: Vec<f64>,
}

fn main() -> Result<(), Failure> {
    let numbers: Vec<u32> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let size = (numbers.first().copied().unwrap_or(1920), numbers.get(1).copied().unwrap_or(1080));
    let rounds = numbers.get(2).copied().unwrap_or(15);
    let context = Headless::new(Api::Core)?;
    let gl = &context.gl;
    println!("{}; {}×{}, {rounds} rounds", context.driver(), size.0, size.1);
    let framebuffer = framebuffer(gl, size);
    let quad = quad(gl)?;

    let mut contestants = vec![Contestant {
        name: "bilinear quad".into(),
        backend: None,
        atlas: texture(gl, size),
        seconds: Vec::new(),
        processor: Vec::new(),
    }];
    for (name, rig) in rigs() {
        let plan = plan(&rig, size)?;
        let started = Instant::now();
        let mut backend = GlBackend::new(gl, false)?;
        backend.prepare(gl, &plan, false)?;
        let prepared = started.elapsed().as_secs_f64() * 1e3;
        let pass = &plan.passes[0];
        let part = |wanted: &dyn Fn(&cupola::correct::Batch) -> bool| {
            let rects = pass.batches.iter().filter(|b| wanted(b)).flat_map(|b| &b.rects);
            let pixels: f64 = rects.fold(0.0, |sum, r| sum + f64::from(r.width) * f64::from(r.height));
            100.0 * pixels / f64::from(size.0) / f64::from(size.1)
        };
        println!(
            "{name}: {} views, {} batches prepared in {prepared:.0} ms; {:.0} % of the pixels drawn, {:.0} % with several views, {:.0} % blended, {:.0} % with an edge",
            plan.views.views.len(),
            pass.batches.len(),
            part(&|_| true),
            part(&|b| b.views.len() > 1),
            part(&|b| !b.neighbours.is_empty()),
            part(&|b| b.edge),
        );
        let atlas = texture(gl, plan.views.atlas);
        contestants.push(Contestant {
            name,
            backend: Some(backend),
            atlas,
            seconds: Vec::new(),
            processor: Vec::new(),
        });
    }
    let viewport = [0, 0, size.0 as i32, size.1 as i32];
    for round in 0..rounds + 2 {
        for contestant in &mut contestants {
            let (started, used) = (Instant::now(), processor_seconds());
            match &contestant.backend {
                Some(backend) => _ = backend.present(gl, contestant.atlas, &[Target { framebuffer, viewport }]),
                None => draw_quad(gl, quad, contestant.atlas, framebuffer, viewport),
            }
            // SAFETY: the context is current.
            unsafe { gl.finish() };
            // The first rounds compile and warm up.
            if round >= 2 {
                contestant.seconds.push(started.elapsed().as_secs_f64());
                contestant.processor.push(processor_seconds() - used);
            }
        }
    }
    println!("\n{:32} {:>10} {:>10} {:>7} {:>17}", "pass", "median ms", "least ms", "ratio", "processor's ratio");
    let ratio = |of: &[f64], base: &[f64]| median(of.iter().zip(base).map(|(a, b)| a / b).collect());
    let base = &contestants[0];
    for contestant in &contestants {
        let least = contestant.seconds.iter().copied().fold(f64::INFINITY, f64::min);
        println!(
            "{:32} {:10.2} {:10.2} {:7.2} {:17.2}",
            contestant.name,
            median(contestant.seconds.clone()) * 1e3,
            least * 1e3,
            ratio(&contestant.seconds, &base.seconds),
            ratio(&contestant.processor, &base.processor),
        );
    }
    for contestant in &mut contestants {
        if let Some(backend) = &mut contestant.backend {
            backend.destroy(gl);
            if backend.errors() != 0 {
                return Err(format!("{}: {} OpenGL errors", contestant.name, backend.errors()).into());
            }
        }
    }
    Ok(())
}

/// Processor time of all threads of this process so far.
fn processor_seconds() -> f64 {
    let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the structure is ours.
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &mut now) };
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// What is compared: name and rig; the first output is drawn.
fn rigs() -> Vec<(String, Rig)> {
    let frustum = Frustum::symmetric(60f64.to_radians(), 40f64.to_radians());
    let beamer = |name: &str, yaw: f64, overlap| {
        let kind = OutputKind::Projector {
            position: DVec3::new(0.0, 0.0, 3.0),
            angles: [yaw.to_radians(), 0.1, 0.0],
            frustum,
        };
        output(name, kind, overlap)
    };
    let dome = |degrees: f64| {
        let kind = OutputKind::Domemaster { aperture: degrees.to_radians(), tilt: std::f64::consts::FRAC_PI_2 };
        output("dome", kind, false)
    };
    vec![
        ("projector 60×40° at 0.6 R".into(), rig(vec![beamer("one", 0.0, false)])),
        (
            "blended on both sides".into(),
            with_own_views(rig(vec![
                beamer("one", 0.0, true),
                beamer("two", 40.0, true),
                beamer("three", -40.0, true),
            ])),
        ),
        (
            "the same, views shared by all".into(),
            rig(vec![beamer("one", 0.0, true), beamer("two", 40.0, true), beamer("three", -40.0, true)]),
        ),
        ("fisheye 180°".into(), rig(vec![dome(180.0)])),
        ("fisheye 240°".into(), rig(vec![dome(240.0)])),
    ]
}

fn output(name: &str, kind: OutputKind, overlap: bool) -> Output {
    let blend = Blend { overlap, ramp: 0.3, ..Blend::default() };
    Output { name: name.into(), kind, size: None, window: None, blend, mask: None, eye: 0.0 }
}

fn rig(outputs: Vec<Output>) -> Rig {
    Rig {
        name: "bench".into(),
        passthrough: false,
        dome: Dome { radius: 5.0, tilt: 0.0, coverage: std::f64::consts::TAU },
        screen: None,
        viewer: Viewer { position: DVec3::ZERO, yaw: 0.0, pitch: 0.0, roll: 0.0 },
        camera: Camera::default(),
        views: Views::default(),
        overlay: Overlay { yaw: 0.0, pitch: 0.0, width: 1.0 },
        outputs,
    }
}

/// One tight view for each output.
fn with_own_views(mut rig: Rig) -> Rig {
    rig.views.method = ViewMethod::Single;
    rig
}

fn plan(rig: &Rig, size: (u32, u32)) -> Result<Plan, Failure> {
    let mut plan = build(
        rig,
        &Request {
            output_sizes: vec![size; rig.outputs.len()],
            window: size,
            panel: false,
            primary: false,
            max_atlas: 16384,
        },
    )?;
    plan.passes.truncate(1);
    Ok(plan)
}

/// A texture of a varied picture.
fn texture(gl: &Gl, size: (u32, u32)) -> u32 {
    let (width, height) = (size.0 as i32, size.1 as i32);
    let pixels: Vec<u32> = (0..size.0 * size.1).map(|i| i.wrapping_mul(2_654_435_761) | 0xff00_0000).collect();
    let mut texture = 0;
    // SAFETY: the context is current; the array holds width · height pixels.
    unsafe {
        gl.gen_textures(1, &mut texture);
        gl.bind_texture(GL_TEXTURE_2D, texture);
        let data = pixels.as_ptr().cast();
        gl.tex_image2_d(GL_TEXTURE_2D, 0, GL_RGBA8 as i32, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, data);
        gl.tex_parameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR as i32);
        gl.tex_parameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    }
    texture
}

fn framebuffer(gl: &Gl, size: (u32, u32)) -> u32 {
    let (mut renderbuffer, mut framebuffer) = (0, 0);
    // SAFETY: the context is current.
    unsafe {
        gl.gen_renderbuffers(1, &mut renderbuffer);
        gl.bind_renderbuffer(GL_RENDERBUFFER, renderbuffer);
        gl.renderbuffer_storage(GL_RENDERBUFFER, GL_RGBA8, size.0 as i32, size.1 as i32);
        gl.gen_framebuffers(1, &mut framebuffer);
        gl.bind_framebuffer(GL_FRAMEBUFFER, framebuffer);
        gl.framebuffer_renderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, renderbuffer);
    }
    framebuffer
}

/// Program and vertex array of the plain quad.
fn quad(gl: &Gl) -> Result<(u32, u32), Failure> {
    // SAFETY: the context is current; each string has the length that is given.
    unsafe {
        let program = gl.create_program();
        for (kind, text) in [(GL_VERTEX_SHADER, VERTEX), (GL_FRAGMENT_SHADER, FRAGMENT)] {
            let shader = gl.create_shader(kind);
            gl.shader_source(shader, 1, &text.as_ptr().cast(), &(text.len() as i32));
            gl.compile_shader(shader);
            gl.attach_shader(program, shader);
        }
        gl.link_program(program);
        let mut linked = 0;
        gl.get_programiv(program, GL_LINK_STATUS, &mut linked);
        if linked == 0 {
            return Err("the driver cannot link the plain quad's shader".into());
        }
        let mut vertex_array = 0;
        gl.gen_vertex_arrays(1, &mut vertex_array);
        Ok((program, vertex_array))
    }
}

fn draw_quad(gl: &Gl, quad: (u32, u32), texture: u32, framebuffer: u32, [x, y, width, height]: [i32; 4]) {
    // SAFETY: the context is current; the names are those that it gave.
    unsafe {
        gl.bind_framebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
        gl.viewport(x, y, width, height);
        gl.disable(GL_DITHER);
        gl.use_program(quad.0);
        gl.bind_vertex_array(quad.1);
        gl.bind_texture(GL_TEXTURE_2D, texture);
        gl.draw_arrays(GL_TRIANGLES, 0, 6);
    }
}
