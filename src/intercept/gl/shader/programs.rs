//! The program's shaders: patched when they are linked, and which lens they draw with.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::projected::matrices::{LensConstants, ReprojectionMatrix};
use crate::correct::projected::projection;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::methods;
use crate::intercept::gl::shader::attribute_matrices::{self, Found};
use crate::intercept::gl::shader::patch::{self, Stage};
use crate::intercept::gl::shader::{assembly, dependence, samplers, uniforms};
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::shader::position_names::PositionNames;
use crate::intercept::gl::state::shader::programs::{Lens, Position, Program};
use crate::intercept::gl::vertex_input::buffers;
use crate::intercept::log;
use crate::lock::Lock;
use crate::runtime::session::{MatrixClass, Session};
use std::collections::HashMap;
use std::ffi::{CStr, CString, c_char, c_void};
use std::sync::{Arc, Mutex};

impl Program {
    /// The lens that its matrices hold now.
    pub fn lens(&self, ctx: &mut Context) -> Lens {
        if self.location < 0 {
            return Lens::Flat;
        }
        if self.fixed_matrices {
            ctx.compat.projection.refresh(ctx.driver.gl, ctx.drawable.session());
            if let MatrixClass::Perspective(intrinsics) = ctx.compat.projection.class {
                return Lens::Perspective(intrinsics, "fixed-function matrix in a shader");
            }
        }
        let (lens, known) = self.uniforms_lens(ctx);
        if lens != Lens::Flat {
            return lens;
        }
        let mut matrices = self.attribute_matrices.locked();
        if matrices.is_empty() {
            return if known { lens } else { given(ctx) };
        }
        match attribute_matrices::lens(ctx, &mut matrices) {
            Found::Lens(intrinsics) => Lens::Perspective(intrinsics, "matrix of a vertex attribute"),
            _ if known => Lens::Flat,
            Found::Nothing => given(ctx),
            Found::Unreadable => {
                let lens = given(ctx);
                if ctx.session().and_then(Session::given_lens).is_none() {
                    log::once(
                        "a shader has its matrix from a vertex attribute that cannot be read: what it draws is flat. If it \
                         is a scene, set camera.lens in the rig",
                    );
                }
                lens
            }
        }
    }

    /// The lens that its uniforms hold now, and whether that says everything about uniforms.
    fn uniforms_lens(&self, ctx: &Context) -> (Lens, bool) {
        let mut uniforms = self.uniforms.locked();
        if !uniforms.any() && !self.fixed_matrices {
            return (Lens::Flat, false);
        }
        let generation = ctx.vertex_input.blocks.generation();
        let lens = uniforms.lens(ctx.driver.gl, generation, &buffers::of(&ctx.share));
        (lens, !uniforms.unclear)
    }
}

/// The rig's lens, for what is drawn with a depth test by a program without a matrix.
pub fn given(ctx: &Context) -> Lens {
    match ctx.session().and_then(Session::given_lens) {
        Some(lens) if ctx.driver.known_state.is_on(ctx.driver.gl, api::GL_DEPTH_TEST) => {
            Lens::Perspective(lens, "the rig's lens")
        }
        _ => Lens::Flat,
    }
}

/// Sends `rows` to the program that draws, unless it has them.
pub fn upload(ctx: &Context, rows: &ReprojectionMatrix) {
    if let Some(program) = &ctx.shaders.assembly {
        assembly::upload(ctx, program, rows);
    } else if let Some(program) = &ctx.shaders.program {
        send(ctx, program, rows);
    }
}

/// Sends `rows` to a program, which is the one in use or belongs to a pipeline.
pub fn send(ctx: &Context, program: &Program, rows: &ReprojectionMatrix) {
    if program.location < 0 {
        return;
    }
    let mut uploaded = program.uploaded.locked();
    if uploaded.rows.as_ref() != Some(rows) {
        set_vectors(ctx, program, program.location, &rows.to_array());
        uploaded.rows = Some(*rows);
    }
}

/// Sends the rows of a view to the program that draws, and the lens to whose axes they lead, if they lead to one.
pub fn upload_view(ctx: &Context, rows: &ReprojectionMatrix, lens: Option<&LensConstants>) {
    upload(ctx, rows);
    let (Some(program), Some(lens)) = (&ctx.shaders.program, lens) else { return };
    let mut uploaded = program.uploaded.locked();
    if program.lens_location >= 0 && uploaded.lens.as_ref() != Some(lens) {
        set_vectors(ctx, program, program.lens_location, &lens.to_array());
        uploaded.lens = Some(*lens);
    }
}

/// Sets four vectors of our array.
fn set_vectors(ctx: &Context, program: &Program, location: i32, vectors: &[f32; 16]) {
    // SAFETY: the location is that of the array, or of its second half; where no program is in use, there are
    // pipelines and with them the command that takes a name.
    unsafe {
        if ctx.shaders.pipelines.used == program.name {
            ctx.driver.gl.uniform4fv(location, 4, vectors.as_ptr());
        } else {
            ctx.driver.gl.program_uniform4fv(program.name, location, 4, vectors.as_ptr());
        }
    }
}

/// The record of a program, for queries about it.
pub fn record(share: &ShareGroup, name: u32) -> Option<Arc<Program>> {
    share.programs.locked().programs.get(&name).cloned()
}

/// A block of `name` was bound elsewhere: its matrices are found anew.
pub fn read_again(ctx: &mut Context, name: u32) {
    let Some(old) = record(&ctx.share, name) else { return };
    let (uniforms, _) =
        uniforms::read(ctx.driver.gl, &ctx.driver.profile, name, projection::UNIFORM, old.position_names.as_ref());
    *old.uniforms.locked() = uniforms;
}

fn source_text(count: i32, strings: *const *const c_char, lengths: *const i32) -> Option<Arc<str>> {
    let mut bytes = Vec::new();
    for i in 0..usize::try_from(count).ok()? {
        // SAFETY: the program passes `count` strings, and lengths or null for NUL-terminated ones.
        unsafe {
            let string = *strings.add(i);
            if string.is_null() {
                return None;
            }
            let length = if lengths.is_null() { -1 } else { *lengths.add(i) };
            match usize::try_from(length) {
                Ok(length) => bytes.extend_from_slice(std::slice::from_raw_parts(string.cast::<u8>(), length)),
                Err(_) => bytes.extend_from_slice(CStr::from_ptr(string).to_bytes()),
            }
        }
    }
    // Some programs count the NUL in the length.
    while bytes.last() == Some(&0) {
        bytes.pop();
    }
    Some(String::from_utf8_lossy(&bytes).into())
}

/// A shader was compiled from what its source is now.
fn note_compiled(ctx: &Context, shader: u32) {
    let mut programs = ctx.share.programs.locked();
    match programs.sources.get(&shader).cloned() {
        Some(text) => programs.compiled.insert(shader, text),
        None => programs.compiled.remove(&shader),
    };
}

fn set_source(gl: &Gl, shader: u32, text: &str) {
    let pointer = text.as_ptr().cast::<c_char>();
    let length = text.len() as i32;
    // SAFETY: one string with its length.
    unsafe { gl.shader_source(shader, 1, &pointer, &length) };
}

fn attached(gl: &Gl, program: u32) -> Vec<(u32, u32)> {
    let mut names = [0; 64];
    let mut count = 0;
    // SAFETY: writes at most 64 names and, for each, one integer.
    unsafe {
        gl.get_attached_shaders(program, 64, &mut count, names.as_mut_ptr());
        let names = &names[..usize::try_from(count).unwrap_or(0).min(64)];
        names
            .iter()
            .map(|name| {
                let mut kind = 0;
                gl.get_shaderiv(*name, api::GL_SHADER_TYPE, &mut kind);
                (*name, kind as u32)
            })
            .collect()
    }
}

fn status(gl: &Gl, program: u32) -> bool {
    let mut ok = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_programiv(program, api::GL_LINK_STATUS, &mut ok) };
    ok != 0
}

/// The last stage before rasterisation, with the object that holds its `main`, patched.
fn patched_stage(
    sources: &HashMap<u32, Arc<str>>,
    shaders: &[(u32, u32)],
    es_context: bool,
    curved: bool,
) -> Option<(u32, Arc<str>, String)> {
    let stages = [
        (api::GL_GEOMETRY_SHADER, Stage::Geometry),
        (api::GL_TESS_EVALUATION_SHADER, Stage::TessellationEvaluation),
        (api::GL_VERTEX_SHADER, Stage::Vertex),
    ];
    let (kind, stage) = stages.into_iter().find(|(kind, _)| shaders.iter().any(|s| s.1 == *kind))?;
    shaders.iter().filter(|s| s.1 == kind).find_map(|(shader, _)| {
        let source = sources.get(shader)?;
        patch::patch(source, stage, es_context, curved).map(|patched| (*shader, source.clone(), patched))
    })
}

/// Links with the patched stage; leaves the program as it would be without us where that fails.
fn link(ctx: &mut Context, program: u32) {
    let gl = ctx.driver.gl;
    let shaders = attached(gl, program);
    // Compiling takes long; other threads' contexts use the table meanwhile.
    let sources: HashMap<u32, Arc<str>> = {
        let mut programs = ctx.share.programs.locked();
        forget(gl, programs.programs.remove(&program));
        shaders.iter().filter_map(|s| Some((s.0, programs.compiled.get(&s.0)?.clone()))).collect()
    };
    let patched = patched_stage(&sources, &shaders, ctx.driver.profile.es, methods::asked_for());
    let mut linked = false;
    if let Some((shader, original, text)) = &patched {
        linked = link_patched(gl, program, *shader, original, text);
        // What the program asks for is its own text, which may not have been compiled yet.
        let own = ctx.share.programs.locked().sources.get(shader).cloned();
        set_source(gl, *shader, own.as_deref().unwrap_or(original));
        ctx.frame.counts.linked += 1;
    }
    if !linked {
        // SAFETY: the program's own call.
        unsafe { gl.link_program(program) };
    }
    if !status(gl, program) {
        return;
    }
    let stages = shaders.iter().fold(0, |bits, shader| bits | stage_bit(shader.1));
    if stages != 0 && !linked {
        log::once("a program's shaders could not be patched; what it draws appears flat");
    }
    let words = ["gl_ModelViewProjectionMatrix", "gl_ProjectionMatrix", "ftransform"];
    let position_names = dependence::position_names(&sources, &shaders);
    let mut before = shaders.iter().filter(|s| s.1 != api::GL_FRAGMENT_SHADER).filter_map(|s| sources.get(&s.0));
    let fixed_matrices = match &position_names {
        Some(names) => words.iter().any(|word| names.contain(word)),
        None => before.any(|source| words.iter().any(|word| patch::mentions(source, word))),
    };
    let mut fragments = shaders.iter().filter(|s| s.1 == api::GL_FRAGMENT_SHADER).filter_map(|s| sources.get(&s.0));
    let texts = shaders.iter().filter_map(|s| Some((s.1, sources.get(&s.0)?.clone())));
    let texts = if methods::asked_for() { texts.collect() } else { Vec::new() };
    let mut record = read_program(gl, &ctx.driver.profile, program, linked, stages, fixed_matrices, position_names);
    record.texts = texts;
    record.subroutines = sources.values().any(|source| patch::mentions(source, "subroutine"));
    record.chooses_viewport = sources.values().any(|source| patch::mentions(source, "gl_ViewportIndex"));
    record.reads_frag_coord = fragments.any(|source| patch::mentions(source, "gl_FragCoord"));
    let mut vertices = shaders.iter().filter(|s| s.1 != api::GL_FRAGMENT_SHADER);
    if let (Some((shader, api::GL_VERTEX_SHADER)), None) = (vertices.next(), vertices.next())
        && let Some(source) = sources.get(shader)
    {
        let uniforms = record.uniforms.unlocked_mut();
        record.position = Position::of_shader(gl, program, source, ctx.driver.profile.es, uniforms);
    }
    let record = Arc::new(record);
    let mut programs = ctx.share.programs.locked();
    programs.programs.insert(program, record.clone());
    drop(programs);
    // Linking a program that is in use puts the new one into use.
    if ctx.shaders.program.as_ref().is_some_and(|p| p.name == program) {
        ctx.shaders.program = Some(record);
    }
}

/// Nothing is known of a program any more.
pub(super) fn forget_program(ctx: &Context, name: u32) {
    let record = ctx.share.programs.locked().programs.remove(&name);
    forget(ctx.driver.gl, record);
}

/// A program's record is out of use, and what stood beside the program with it.
fn forget(gl: &Gl, record: Option<Arc<Program>>) {
    if let Some(record) = record {
        record.variants.locked().destroy(gl);
    }
}

/// A program of ours of one vertex shader, which draws with the fixed-function matrices: `patched` is what is linked,
/// `own` the same without what projects. `flat`: a primitive has the colour of its last vertex. `None` where the driver
/// does not link it.
pub fn of_own_text(driver: &Driver, patched: &str, own: Arc<str>, flat: bool) -> Option<Program> {
    let gl = driver.gl;
    // SAFETY: objects of ours.
    let name = unsafe {
        let (shader, name) = (gl.create_shader(api::GL_VERTEX_SHADER), gl.create_program());
        set_source(gl, shader, patched);
        gl.compile_shader(shader);
        gl.attach_shader(name, shader);
        gl.link_program(name);
        gl.delete_shader(shader);
        name
    };
    if !status(gl, name) {
        // SAFETY: as above.
        unsafe { gl.delete_program(name) };
        return None;
    }
    let record = read_program(gl, &driver.profile, name, true, api::GL_VERTEX_SHADER_BIT, true, None);
    Some(Program { flat, texts: vec![(api::GL_VERTEX_SHADER, own)], ..record })
}

/// The bit of a stage before rasterisation; 0 for others.
fn stage_bit(kind: u32) -> u32 {
    match kind {
        api::GL_VERTEX_SHADER => api::GL_VERTEX_SHADER_BIT,
        api::GL_TESS_EVALUATION_SHADER => api::GL_TESS_EVALUATION_SHADER_BIT,
        api::GL_GEOMETRY_SHADER => api::GL_GEOMETRY_SHADER_BIT,
        _ => 0,
    }
}

fn link_patched(gl: &Gl, program: u32, shader: u32, original: &str, text: &str) -> bool {
    let compiles = |text: &str| {
        set_source(gl, shader, text);
        let mut ok = 0;
        // SAFETY: compiles the program's own shader object; writes one integer.
        unsafe {
            gl.compile_shader(shader);
            gl.get_shaderiv(shader, api::GL_COMPILE_STATUS, &mut ok);
        }
        ok != 0
    };
    let mut linked = false;
    if compiles(text) {
        // SAFETY: the program's own call.
        unsafe { gl.link_program(program) };
        linked = status(gl, program) && !captures_position(gl, program);
    }
    if !linked {
        compiles(original);
    }
    linked
}

/// Transform feedback of `gl_Position` must see the program's own values.
fn captures_position(gl: &Gl, program: u32) -> bool {
    let mut count = 0;
    // SAFETY: writes one integer; absent commands answer nothing.
    unsafe { gl.get_programiv(program, api::GL_TRANSFORM_FEEDBACK_VARYINGS, &mut count) };
    (0..u32::try_from(count).unwrap_or(0)).any(|index| {
        let mut name: [c_char; 64] = [0; 64];
        let (mut length, mut size, mut kind) = (0, 0, 0);
        // SAFETY: writes at most 64 characters with their NUL.
        unsafe {
            gl.get_transform_feedback_varying(program, index, 64, &mut length, &mut size, &mut kind, name.as_mut_ptr());
            CStr::from_ptr(name.as_ptr()) == c"gl_Position"
        }
    })
}

fn read_program(
    gl: &Gl,
    profile: &Profile,
    name: u32,
    patched: bool,
    stages: u32,
    fixed_matrices: bool,
    position_names: Option<PositionNames>,
) -> Program {
    let ours = CString::new(projection::UNIFORM).unwrap_or_default();
    // SAFETY: a NUL-terminated name.
    let location = if patched { unsafe { gl.get_uniform_location(name, ours.as_ptr()) } } else { -1 };
    // The vectors of an array have places of their own; −1 where it has no more than the rows.
    let half = CString::new(format!("{}[{}]", projection::UNIFORM, projection::ROWS)).unwrap_or_default();
    // SAFETY: as above.
    let lens_location = if location >= 0 { unsafe { gl.get_uniform_location(name, half.as_ptr()) } } else { -1 };
    let (uniforms, own_uniform) = uniforms::read(gl, profile, name, projection::UNIFORM, position_names.as_ref());
    let attributes =
        if patched { attribute_matrices::of_program(gl, name, position_names.as_ref()) } else { Vec::new() };
    Program {
        name,
        location,
        lens_location,
        own_uniform,
        stages,
        fixed_matrices,
        samplers: samplers::of_program(gl, name),
        position: None,
        subroutines: false,
        reads_frag_coord: false,
        chooses_viewport: false,
        position_names,
        uniforms: Mutex::new(uniforms),
        attribute_matrices: Mutex::new(attributes),
        uploaded: Mutex::default(),
        texts: Vec::new(),
        flat: false,
        variants: Mutex::default(),
    }
}

hooks! {
    "glShaderSource" shader_source(shader: u32, count: i32, strings: *const *const c_char, lengths: *const i32) = |ctx, gl| {
        gl.shader_source(shader, count, strings, lengths);
        if let Some(text) = source_text(count, strings, lengths) {
            ctx.share.programs.locked().sources.insert(shader, text);
        }
    };
    "glCompileShader" compile_shader(shader: u32) = |ctx, gl| {
        gl.compile_shader(shader);
        note_compiled(ctx, shader);
    };
    "glDeleteShader" delete_shader(shader: u32) = |_ctx, gl| {
        // Its source stays known: it may still be attached, and its name comes back only with a new source.
        gl.delete_shader(shader)
    };
    "glLinkProgram" link_program(program: u32) = |ctx, _gl| link(ctx, program);
    "glProgramBinary" program_binary(program: u32, format: u32, binary: *const c_void, length: i32) = |ctx, gl| {
        // What it was linked to is gone; what it is now was never patched.
        gl.program_binary(program, format, binary, length);
        forget_program(ctx, program);
    };
    "glCreateShaderProgramv" create_shader_programv(kind: u32, count: i32, strings: *const *const c_char) -> u32 = |ctx, gl| {
        if count < 0 {
            // The driver says the error.
            return gl.create_shader_programv(kind, count, strings);
        }
        // As OpenGL describes it in terms of the other commands.
        let shader = gl.create_shader(kind);
        if shader == 0 {
            return 0;
        }
        gl.shader_source(shader, count, strings, std::ptr::null());
        if let Some(text) = source_text(count, strings, std::ptr::null()) {
            ctx.share.programs.locked().sources.insert(shader, text);
        }
        gl.compile_shader(shader);
        let mut compiled = 0;
        gl.get_shaderiv(shader, api::GL_COMPILE_STATUS, &mut compiled);
        if compiled == 0 {
            // The program gets the log of the shader, which only the driver can give it.
            gl.delete_shader(shader);
            return gl.create_shader_programv(kind, count, strings);
        }
        note_compiled(ctx, shader);
        let program = gl.create_program();
        if program != 0 {
            gl.program_parameteri(program, api::GL_PROGRAM_SEPARABLE, 1);
            gl.attach_shader(program, shader);
            link(ctx, program);
            gl.detach_shader(program, shader);
        }
        gl.delete_shader(shader);
        program
    };
}
