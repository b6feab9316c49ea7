//! Compiling and linking of the program's shaders, with texts that Cupola changes ([`texts`]).

pub mod relinking;
pub mod texts;

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::projected::projection;
use crate::intercept::gl::context::gl_context::{Context, ShareGroup};
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::methods;
use crate::intercept::gl::shader::changed::buffers;
use crate::intercept::gl::shader::linking::texts::{Changes, Linked, Texts};
use crate::intercept::gl::shader::programs::forget_program;
use crate::intercept::gl::shader::source::patch;
use crate::intercept::gl::shader::source::{compute, dependence};
use crate::intercept::gl::shader::uniforms::location;
use crate::intercept::gl::shader::{attribute_matrices, camera_matrices, samplers, uniforms};
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::shader::position_names::PositionNames;
use crate::intercept::gl::state::shader::programs::{FragCoord, Position, Program};
use crate::intercept::process::{call_sum, log};
use crate::lock::Lock;
use std::collections::{HashMap, HashSet};
use std::ffi::{CStr, c_char, c_void};
use std::sync::atomic::{AtomicBool, AtomicU32};
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
    // Some programs include the NUL in the length.
    while bytes.last() == Some(&0) {
        bytes.pop();
    }
    Some(String::from_utf8_lossy(&bytes).into())
}

/// Notes that a shader was compiled from its present source.
fn note_compiled(ctx: &Context, shader: u32) {
    let mut programs = ctx.share.programs.locked();
    match programs.sources.get(&shader).cloned() {
        Some(text) => programs.compiled.insert(shader, text),
        None => programs.compiled.remove(&shader),
    };
    programs.changed.remove(&shader);
}

/// Links with the changed stages. If that fails, links the program without changes.
fn link(ctx: &mut Context, program: u32) {
    let gl = ctx.driver.gl;
    let shaders = attached(gl, program);
    let trial = relinking::begin(ctx, program, &shaders);
    let (sources, left) = texts_of(&ctx.share, &shaders);
    let position_names = dependence::position_names(&sources, &shaders);
    let (es, curved) = (ctx.driver.profile.es, methods::asked_for());
    let texts = Texts { sources: &sources, shaders: &shaders, position_names: position_names.as_ref(), es, curved };
    let (linked, touched) = link_with_changes(gl, trial.unwrap_or(program), &texts, left);
    let ended = trial.is_none_or(|trial| relinking::end(ctx, program, trial, &shaders, status(gl, trial)));
    give_back_texts(ctx, &sources, &linked, touched);
    ctx.frame.note_linked(u64::from(texts.position().is_some()));
    if !ended {
        // The program keeps its executable.
        return;
    }
    forget_program(&ctx.share, &ctx.driver, program);
    if !status(gl, program) {
        return;
    }
    let record = Arc::new(record(&ctx.driver, program, &texts, &linked));
    ctx.share.programs.locked().programs.insert(program, record.clone());
    // If a program in use is linked, its new version is in use at once.
    ctx.shaders.note_relinked(record);
}

/// Returns the texts from which a program's shaders were compiled, and the shaders that were
/// compiled with changes for another program.
fn texts_of(share: &ShareGroup, shaders: &[(u32, u32)]) -> (HashMap<u32, Arc<str>>, HashSet<u32>) {
    // Compiling takes long, so the lock is not held meanwhile: contexts of other threads use this
    // table.
    let programs = share.programs.locked();
    let source = |name: u32| Some((name, programs.compiled.get(&name)?.clone()));
    let sources: HashMap<u32, Arc<str>> = shaders.iter().filter_map(|shader| source(shader.0)).collect();
    let left = sources.keys().copied().filter(|shader| programs.changed.contains(shader)).collect();
    (sources, left)
}

/// Sets the program's own texts again in the shaders `touched`, without compiling them.
fn give_back_texts(ctx: &Context, sources: &HashMap<u32, Arc<str>>, linked: &Linked, touched: HashSet<u32>) {
    for shader in touched {
        let mut programs = ctx.share.programs.locked();
        match linked.texts.contains_key(&shader) {
            true => programs.changed.insert(shader),
            false => programs.changed.remove(&shader),
        };
        // The program may ask for its latest text, which it may not have compiled yet.
        let own = programs.sources.get(&shader).cloned();
        drop(programs);
        set_source(ctx.driver.gl, shader, own.as_deref().unwrap_or(&sources[&shader]));
    }
}

/// Returns the record of a program that was linked.
fn record(driver: &Driver, program: u32, texts: &Texts<'_>, linked: &Linked) -> Program {
    let (gl, profile) = (driver.gl, &driver.profile);
    let (shaders, sources) = (texts.shaders, texts.sources);
    let stages = shaders.iter().fold(0, |bits, shader| bits | stage_bit(shader.1));
    if stages != 0 && !linked.changes.position {
        log::once("a program's shaders could not be changed: its drawing appears flat");
    }
    let position_names = texts.position_names.cloned();
    let fixed = has_fixed_matrices(texts);
    let mut record = read_program(gl, profile, program, linked.changes.position, stages, fixed, position_names);
    if texts.curved {
        record.texts = shaders.iter().filter_map(|s| Some((s.1, sources.get(&s.0)?.clone()))).collect();
    }
    let drawing = || {
        let shaders = shaders.iter().filter(|shader| shader.1 != api::GL_COMPUTE_SHADER);
        shaders.filter_map(|shader| sources.get(&shader.0))
    };
    if drawing().any(|source| compute::may_write_buffers(source)) {
        record.changed_buffers.extend(buffers::storage_of(gl, program));
    }
    if drawing().any(|source| compute::may_write_images(source)) {
        record.written_images = compute::images_of(gl, program).collect();
    }
    record.subroutines = sources.values().any(|source| patch::mentions(source, "subroutine"));
    record.chooses_viewport = sources.values().any(|source| patch::mentions(source, "gl_ViewportIndex"));
    // If a shader does not use the coordinates, its uniform has no location.
    record.frag_coord = linked
        .changes
        .frag_coord
        .then(|| location(gl, program, FragCoord::UNIFORM))
        .and_then(|location| (location >= 0).then_some(FragCoord { location, upper_left: linked.upper_left }));
    record.reads_frag_coord = texts.asking().next().is_some() && !linked.changes.frag_coord;
    let matrices = camera_matrices::of_program(gl, profile, program, &linked.matrices);
    record.has_camera_matrices = !matrices.substitutes.is_empty();
    let mut computing = shaders.iter().filter(|s| s.1 == api::GL_COMPUTE_SHADER).filter_map(|s| sources.get(&s.0));
    record.compute = computing.next().map(|source| {
        let loses_cameras = compute::has_matrices(source) && !record.has_camera_matrices;
        compute::of_program(gl, program, source, loses_cameras)
    });
    record.camera_matrices = Mutex::new(matrices);
    let mut vertices = shaders.iter().filter(|s| s.1 != api::GL_FRAGMENT_SHADER);
    if let (Some((shader, api::GL_VERTEX_SHADER)), None) = (vertices.next(), vertices.next())
        && let Some(source) = sources.get(shader)
    {
        let uniforms = record.uniforms.unlocked_mut();
        record.position = Position::of_shader(gl, program, source, profile.es, uniforms);
    }
    record
}

/// True if matrices of the fixed-function pipeline may flow into positions, according to the texts.
fn has_fixed_matrices(texts: &Texts<'_>) -> bool {
    let words = ["gl_ModelViewProjectionMatrix", "gl_ProjectionMatrix", "ftransform"];
    match texts.position_names {
        Some(names) => words.iter().any(|word| names.contain(word)),
        None => {
            let mut before = texts.shaders.iter().filter(|shader| shader.1 != api::GL_FRAGMENT_SHADER);
            before.any(|shader| words.iter().any(|word| patch::mentions(texts.source(shader.0), word)))
        }
    }
}

/// Links with as many changes as possible. Shaders that do not link with their change are compiled
/// without it, and so are the shaders `left` that were changed for another program. Also returns
/// the shaders whose text was replaced.
fn link_with_changes(gl: &Gl, program: u32, texts: &Texts<'_>, left: HashSet<u32>) -> (Linked, HashSet<u32>) {
    let position = texts.position().is_some();
    let frag_coord = texts.asking().next().is_some();
    let attempts = [(true, true, true), (true, true, false), (true, false, false), (false, true, false)];
    let attempts = attempts.map(|(with_position, with_frag_coord, matrices)| Changes {
        position: position && with_position,
        frag_coord: frag_coord && with_frag_coord,
        matrices,
    });
    let mut touched = left;
    for (number, attempt) in attempts.iter().enumerate() {
        if *attempt == Changes::default() || attempts[..number].contains(attempt) {
            continue;
        }
        let Some(linked) = texts.changed(*attempt) else { continue };
        for shader in touched.iter().filter(|shader| !linked.texts.contains_key(shader)) {
            compiles(gl, *shader, texts.source(*shader));
        }
        touched.extend(linked.texts.keys());
        if link_changed(gl, program, &linked.texts) && !(attempt.position && captures_position(gl, program)) {
            return (linked, touched);
        }
    }
    for shader in &touched {
        compiles(gl, *shader, texts.source(*shader));
    }
    // SAFETY: the program's own call.
    unsafe { gl.link_program(program) };
    (Linked::default(), touched)
}

/// Compiles a text in the program's own shader object. Returns true if it compiles.
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

fn link_changed(gl: &Gl, program: u32, texts: &HashMap<u32, String>) -> bool {
    texts.iter().all(|(shader, text)| compiles(gl, *shader, text)) && {
        // SAFETY: the program's own call.
        unsafe { gl.link_program(program) };
        status(gl, program)
    }
}

/// True if transform feedback captures `gl_Position`, which must have the program's own values.
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

/// Returns the bit of a stage before rasterisation; 0 for other stages.
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
    // The vectors of an array have consecutive locations. The location is −1 if the array has only
    // the rows.
    let half = format!("{}[{}]", projection::UNIFORM, projection::ROWS);
    let lens_location = if rows >= 0 { location(gl, name, &half) } else { -1 };
    let (uniforms, own_uniforms) = uniforms::read(gl, profile, name, position_names.as_ref());
    let attributes =
        if patched { attribute_matrices::of_program(gl, name, position_names.as_ref()) } else { Vec::new() };
    Program {
        name,
        location: rows,
        lens_location,
        own_locations: uniforms::locations(gl, name, &own_uniforms),
        own_uniforms,
        failed: AtomicU32::new(0),
        is_stage: AtomicBool::new(false),
        changed_buffers: buffers::of_program(gl, profile, name),
        written_images: Vec::new(),
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
        compute: None,
        has_camera_matrices: false,
        camera_matrices: Mutex::default(),
        variants: Mutex::default(),
    }
}

/// Returns a program of Cupola with one vertex shader, which draws with the fixed-function
/// matrices. `patched` is the linked text, `own` the text without projection. `flat`: a primitive
/// has the colour of its last vertex. `None`: the driver does not link it.
pub fn of_own_text(driver: &Driver, patched: &str, own: Arc<str>, flat: bool) -> Option<Program> {
    let gl = driver.gl;
    // SAFETY: objects of Cupola.
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
            call_sum::add_values(text.as_ptr(), text.len());
            ctx.share.programs.locked().sources.insert(shader, text);
        }
    };
    "glCompileShader" compile_shader(shader: u32) = |ctx, gl| {
        gl.compile_shader(shader);
        note_compiled(ctx, shader);
    };
    "glDeleteShader" delete_shader(shader: u32) = |_ctx, gl| {
        // Its source remains known: the shader may still be attached, and a new shader of this name
        // gets a new source.
        gl.delete_shader(shader)
    };
    "glLinkProgram" link_program(program: u32) = |ctx, _gl| link(ctx, program);
    "glProgramBinary" program_binary(program: u32, format: u32, binary: *const c_void, length: i32) = |ctx, gl| {
        // The earlier link result is gone, and the binary was never patched.
        gl.program_binary(program, format, binary, length);
        forget_program(&ctx.share, &ctx.driver, program);
    };
    "glCreateShaderProgramv" create_shader_programv(kind: u32, count: i32, strings: *const *const c_char) -> u32 = |ctx, gl| {
        if count < 0 {
            // The driver reports the error.
            return gl.create_shader_programv(kind, count, strings);
        }
        // OpenGL defines this command by these other commands.
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
            // The program must get the log of the shader, which only the driver can provide.
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
