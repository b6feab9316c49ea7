//! Compiling and linking of the program's shaders, with texts that Cupola changes.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::projected::projection;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::methods;
use crate::intercept::gl::shader::patch::{self, Stage};
use crate::intercept::gl::shader::programs::{forget, forget_program};
use crate::intercept::gl::shader::{attribute_matrices, dependence, frag_coord, samplers, uniforms};
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::shader::position_names::PositionNames;
use crate::intercept::gl::state::shader::programs::{FragCoord, Position, Program};
use crate::intercept::log;
use crate::lock::Lock;
use std::collections::HashMap;
use std::ffi::{CStr, CString, c_char, c_void};
use std::sync::{Arc, Mutex};

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

/// Links with the patched stages; leaves the program as it would be without us where that fails.
fn link(ctx: &mut Context, program: u32) {
    let gl = ctx.driver.gl;
    let shaders = attached(gl, program);
    // Compiling takes long; other threads' contexts use the table meanwhile.
    let sources: HashMap<u32, Arc<str>> = {
        let mut programs = ctx.share.programs.locked();
        forget(gl, programs.programs.remove(&program));
        shaders.iter().filter_map(|s| Some((s.0, programs.compiled.get(&s.0)?.clone()))).collect()
    };
    let (es, curved) = (ctx.driver.profile.es, methods::asked_for());
    let position = patched_stage(&sources, &shaders, es, curved);
    let asks = |shader: &u32| sources.get(shader).is_some_and(|source| patch::mentions(source, "gl_FragCoord"));
    let fragments: Vec<u32> =
        shaders.iter().filter(|s| s.1 == api::GL_FRAGMENT_SHADER).map(|s| s.0).filter(asks).collect();
    let (patches, upper_left) = patched_fragments(&sources, &fragments, es).unwrap_or_else(|| {
        // One that another program has, too, may still be compiled with the text that was changed for it.
        let originals = fragments.iter().filter_map(|shader| Some((*shader, sources.get(shader)?)));
        originals.for_each(|(shader, original)| _ = compiles(gl, shader, original));
        Default::default()
    });
    let linked = link_with_patches(gl, program, position.as_ref(), &patches);
    for patch in position.iter().chain(&patches) {
        // What the program asks for is its own text, which may not have been compiled yet.
        let own = ctx.share.programs.locked().sources.get(&patch.shader).cloned();
        set_source(gl, patch.shader, own.as_deref().unwrap_or(&patch.original));
    }
    ctx.frame.counts.linked += u64::from(position.is_some());
    if !status(gl, program) {
        return;
    }
    let stages = shaders.iter().fold(0, |bits, shader| bits | stage_bit(shader.1));
    if stages != 0 && !linked.position {
        log::once("a program's shaders could not be patched; what it draws appears flat");
    }
    let words = ["gl_ModelViewProjectionMatrix", "gl_ProjectionMatrix", "ftransform"];
    let position_names = dependence::position_names(&sources, &shaders);
    let mut before = shaders.iter().filter(|s| s.1 != api::GL_FRAGMENT_SHADER).filter_map(|s| sources.get(&s.0));
    let fixed_matrices = match &position_names {
        Some(names) => words.iter().any(|word| names.contain(word)),
        None => before.any(|source| words.iter().any(|word| patch::mentions(source, word))),
    };
    let texts = shaders.iter().filter_map(|s| Some((s.1, sources.get(&s.0)?.clone())));
    let texts = if methods::asked_for() { texts.collect() } else { Vec::new() };
    let mut record =
        read_program(gl, &ctx.driver.profile, program, linked.position, stages, fixed_matrices, position_names);
    record.texts = texts;
    record.subroutines = sources.values().any(|source| patch::mentions(source, "subroutine"));
    record.chooses_viewport = sources.values().any(|source| patch::mentions(source, "gl_ViewportIndex"));
    // The uniform of a shader that uses the coordinates nowhere has no location.
    record.frag_coord = linked
        .fragments
        .then(|| location(gl, program, FragCoord::UNIFORM))
        .and_then(|location| (location >= 0).then_some(FragCoord { location, upper_left }));
    record.reads_frag_coord = !fragments.is_empty() && !linked.fragments;
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

/// A shader whose text is changed.
struct Patched {
    shader: u32,
    original: Arc<str>,
    text: String,
}

/// The last stage before rasterisation, with the object that holds its `main`, patched.
fn patched_stage(
    sources: &HashMap<u32, Arc<str>>,
    shaders: &[(u32, u32)],
    es_context: bool,
    curved: bool,
) -> Option<Patched> {
    let stages = [
        (api::GL_GEOMETRY_SHADER, Stage::Geometry),
        (api::GL_TESS_EVALUATION_SHADER, Stage::TessellationEvaluation),
        (api::GL_VERTEX_SHADER, Stage::Vertex),
    ];
    let (kind, stage) = stages.into_iter().find(|(kind, _)| shaders.iter().any(|s| s.1 == *kind))?;
    shaders.iter().filter(|s| s.1 == kind).find_map(|(shader, _)| {
        let original = sources.get(shader)?.clone();
        let text = patch::patch(&original, stage, es_context, curved)?;
        Some(Patched { shader: *shader, original, text })
    })
}

/// The fragment shaders that ask where on the screen they are, patched, and whether they count rows from above. `None`
/// where one of them cannot be patched.
fn patched_fragments(
    sources: &HashMap<u32, Arc<str>>,
    fragments: &[u32],
    es_context: bool,
) -> Option<(Vec<Patched>, bool)> {
    let (mut patches, mut upper_left) = (Vec::new(), false);
    for shader in fragments {
        let original = sources.get(shader)?.clone();
        let (text, convention) = frag_coord::patch(&original, es_context)?;
        upper_left = convention.upper_left;
        patches.push(Patched { shader: *shader, original, text });
    }
    Some((patches, upper_left))
}

/// What linking made of a program's shaders.
#[derive(Clone, Copy, Default)]
struct Linked {
    /// The last stage before rasterisation is patched.
    position: bool,
    /// The fragment shaders are.
    fragments: bool,
}

/// Links with as much as can be patched. Shaders that could not be linked with their change are compiled as they were.
fn link_with_patches(gl: &Gl, program: u32, position: Option<&Patched>, fragments: &[Patched]) -> Linked {
    let attempts =
        [(true, true), (true, false), (false, true)].map(|(position, fragments)| Linked { position, fragments });
    let possible =
        |attempt: &Linked| (!attempt.position || position.is_some()) && (!attempt.fragments || !fragments.is_empty());
    for attempt in attempts.into_iter().filter(possible) {
        let fragments = if attempt.fragments { fragments } else { &[] };
        let patches: Vec<&Patched> = position.into_iter().filter(|_| attempt.position).chain(fragments).collect();
        let linked = link_patched(gl, program, &patches) && !(attempt.position && captures_position(gl, program));
        if linked {
            return attempt;
        }
        for patch in patches {
            compiles(gl, patch.shader, &patch.original);
        }
    }
    // SAFETY: the program's own call.
    unsafe { gl.link_program(program) };
    Linked::default()
}

/// Compiles the program's own shader object with a text.
fn compiles(gl: &Gl, shader: u32, text: &str) -> bool {
    set_source(gl, shader, text);
    let mut ok = 0;
    // SAFETY: writes one integer.
    unsafe {
        gl.compile_shader(shader);
        gl.get_shaderiv(shader, api::GL_COMPILE_STATUS, &mut ok);
    }
    ok != 0
}

fn link_patched(gl: &Gl, program: u32, patches: &[&Patched]) -> bool {
    patches.iter().all(|patch| compiles(gl, patch.shader, &patch.text)) && {
        // SAFETY: the program's own call.
        unsafe { gl.link_program(program) };
        status(gl, program)
    }
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

/// The bit of a stage before rasterisation; 0 for others.
fn stage_bit(kind: u32) -> u32 {
    match kind {
        api::GL_VERTEX_SHADER => api::GL_VERTEX_SHADER_BIT,
        api::GL_TESS_EVALUATION_SHADER => api::GL_TESS_EVALUATION_SHADER_BIT,
        api::GL_GEOMETRY_SHADER => api::GL_GEOMETRY_SHADER_BIT,
        _ => 0,
    }
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

fn set_source(gl: &Gl, shader: u32, text: &str) {
    let pointer = text.as_ptr().cast::<c_char>();
    let length = text.len() as i32;
    // SAFETY: one string with its length.
    unsafe { gl.shader_source(shader, 1, &pointer, &length) };
}

fn status(gl: &Gl, program: u32) -> bool {
    let mut ok = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_programiv(program, api::GL_LINK_STATUS, &mut ok) };
    ok != 0
}

/// Location of a uniform; −1 = there is none.
fn location(gl: &Gl, program: u32, uniform: &str) -> i32 {
    let name = CString::new(uniform).unwrap_or_default();
    // SAFETY: a NUL-terminated name.
    unsafe { gl.get_uniform_location(program, name.as_ptr()) }
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
    let rows = if patched { location(gl, name, projection::UNIFORM) } else { -1 };
    // The vectors of an array have places of their own; −1 where it has no more than the rows.
    let half = format!("{}[{}]", projection::UNIFORM, projection::ROWS);
    let lens_location = if rows >= 0 { location(gl, name, &half) } else { -1 };
    let (uniforms, own_uniforms) = uniforms::read(gl, profile, name, position_names.as_ref());
    let attributes =
        if patched { attribute_matrices::of_program(gl, name, position_names.as_ref()) } else { Vec::new() };
    Program {
        name,
        location: rows,
        lens_location,
        own_uniforms,
        stages,
        fixed_matrices,
        samplers: samplers::of_program(gl, name),
        position: None,
        subroutines: false,
        reads_frag_coord: false,
        frag_coord: None,
        chooses_viewport: false,
        position_names,
        has_vectors: uniforms.has_vectors(),
        uniforms: Mutex::new(uniforms),
        attribute_matrices: Mutex::new(attributes),
        uploaded: Mutex::default(),
        texts: Vec::new(),
        flat: false,
        variants: Mutex::default(),
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
