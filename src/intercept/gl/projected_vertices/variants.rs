//! Variants of the application's programs: the same shaders, followed by a stage of Cupola that
//! divides lines or triangles.
//!
//! A program with a geometry stage draws only one kind of primitive, so the application's own
//! program cannot get this stage. A variant is linked when a draw first needs it. Before each draw
//! it gets the values of the program's uniforms.

use crate::backend::gl::CurrentProgram;
use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::projected::matrices::{LensConstants, ReprojectionMatrix};
use crate::correct::projected::projection;
use crate::intercept::gl::context::errors;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::projected_vertices::geometry_stage::{self, Limits, Passing};
use crate::intercept::gl::projected_vertices::interface::{self, Interface};
use crate::intercept::gl::projected_vertices::{carriers, tessellation};
use crate::intercept::gl::shader::source::patch;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::projected_vertices::ProjectedVertices;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::division_counter::Counter;
use crate::intercept::gl::state::shader::programs::Program;
use crate::intercept::gl::state::shader::uniform_mirror::Mirror;
use crate::intercept::gl::state::shader::variants::{InUse, Kind, State, Variant};
use crate::intercept::process::log;
use crate::intercept::scene::obstacle::Obstacle;
use crate::lock::Lock;
use std::ffi::{CStr, CString, c_char};
use std::sync::Arc;

/// Returns the variant of this kind of the program in use, and links it if it is new. `None`: there
/// can be no variant.
pub fn of(ctx: &mut Context, kind: Kind) -> Option<Arc<Variant>> {
    let program = ctx.shaders.program().cloned()?;
    let state = program.variants.locked().state(kind);
    match state {
        State::Made(variant) => Some(variant),
        State::Refused => None,
        State::Untried => {
            let made = {
                let ctx: &mut Context = &mut OwnCalls::without_messages(ctx);
                ctx.driver.take_errors();
                let made = make(&ctx.driver, &ctx.shaders, &mut ctx.projected, &program, kind);
                errors::drop_errors(ctx.driver.gl);
                made
            };
            ctx.frame.note_linked(1);
            let (state, variant) = match made {
                Ok(variant) => {
                    let variant = Arc::new(variant);
                    (State::Made(variant.clone()), Some(variant))
                }
                Err(why) => {
                    let by = if matches!(kind, Kind::Tessellation(_)) { "tessellated" } else { "divided" };
                    if let Some(reason) = why.reason() {
                        log::once(&format!("a program's primitives cannot be {by}: {reason}"));
                    }
                    (State::Refused, None)
                }
            };
            program.variants.locked().set(kind, state);
            variant
        }
    }
}

impl Variant {
    /// Uses the variant instead of the program, with the values of its uniforms, for a view with
    /// this reprojection matrix and this lens.
    pub fn begin(&self, ctx: &mut Context, reprojection: &ReprojectionMatrix, lens: &LensConstants) -> InUse {
        let gl = ctx.driver.gl;
        let counter = ctx.projected.counter().filter(|_| self.counts).map(|counter| counter.begin(gl));
        let subroutines = ctx.shaders.program().is_some_and(|program| program.subroutines);
        let own = subroutines.then(|| CurrentProgram::save(gl, ctx.driver.profile.version as i32));
        // SAFETY: a program of Cupola. The locations are those of the two halves of Cupola's array.
        unsafe {
            gl.use_program(self.name);
            gl.uniform4fv(self.locations[0], projection::ROWS, reprojection.to_array().as_ptr());
            gl.uniform4fv(self.locations[1], projection::LENS, lens.to_array().as_ptr());
        }
        if let Some(own) = &own {
            own.copy_subroutines(gl, self.name);
        }
        self.mirror.copy(gl, ctx.shaders.used(), self.name);
        let mut vertices = 0;
        if let Some(own) = self.patch {
            // SAFETY: reads and sets a number that OpenGL 4.0 has; `end` restores it.
            unsafe {
                gl.get_integerv(api::GL_PATCH_VERTICES, &mut vertices);
                gl.patch_parameteri(api::GL_PATCH_VERTICES, own);
            }
            ctx.draw.issue_as_patches(true);
        }
        InUse { counter, vertices, own }
    }

    /// Uses the application's own program again.
    pub fn end(&self, ctx: &mut Context, in_use: &InUse) {
        if self.patch.is_some() {
            ctx.draw.issue_as_patches(false);
            // SAFETY: restores the value that `begin` found.
            unsafe { ctx.driver.gl.patch_parameteri(api::GL_PATCH_VERTICES, in_use.vertices) };
        }
        if let (Some(counter), Some(before)) = (ctx.projected.counter(), &in_use.counter) {
            counter.end(ctx.driver.gl, before);
        }
        match &in_use.own {
            Some(own) => own.restore(ctx.driver.gl),
            // SAFETY: the program that the application uses.
            None => unsafe { ctx.driver.gl.use_program(ctx.shaders.used()) },
        }
    }
}

/// Returns the limits of the context for a stage of Cupola.
fn limits(driver: &Driver, kind: Kind) -> Limits {
    let number = |name: u32| {
        let mut value = 0;
        // SAFETY: writes one integer.
        unsafe { driver.gl.get_integerv(name, &mut value) };
        usize::try_from(value).unwrap_or(0)
    };
    let counters = match kind {
        Kind::Geometry(_) => api::GL_MAX_GEOMETRY_ATOMIC_COUNTERS,
        Kind::Tessellation(_) => api::GL_MAX_TESS_CONTROL_ATOMIC_COUNTERS,
    };
    let counted = driver.profile.version >= 42 && number(counters) > 0;
    let wanted = crate::intercept::process::settings::settings().is_some_and(|settings| settings.stats.is_some());
    let bindings = number(api::GL_MAX_ATOMIC_COUNTER_BUFFER_BINDINGS) as u32;
    Limits {
        vertices: number(api::GL_MAX_GEOMETRY_OUTPUT_VERTICES),
        components: number(api::GL_MAX_GEOMETRY_TOTAL_OUTPUT_COMPONENTS),
        shared: driver.profile.version >= 40,
        counter: (counted && wanted && bindings > 0).then(|| bindings - 1),
        compatibility: driver.profile.compatibility(),
    }
}

fn make(
    driver: &Driver,
    shaders: &Shaders,
    projected: &mut ProjectedVertices,
    program: &Program,
    kind: Kind,
) -> Result<Variant, Obstacle> {
    if shaders.used() != program.name {
        return Err("it is part of a program pipeline".into());
    }
    let index = dividable(driver.profile, program, kind)?;
    let limits = limits(driver, kind);
    let (interface, dividing) = dividing_stages(program, index, kind, &limits)?;
    let carrying = carriers::carry(&program.texts[index].1, &interface);

    let gl = driver.gl;
    let mut shaders: Vec<u32> = dividing.iter().map(|stage| compile(gl, stage.kind, &stage.text)).collect();
    for (number, (kind, source)) in program.texts.iter().enumerate() {
        shaders.push(compile(gl, *kind, if number == index { &carrying } else { source }));
    }
    let outputs: Vec<Interface> =
        fragments(program).filter_map(|source| interface::read(&patch::strip_comments(source)).ok()).collect();
    let linked = link(gl, program.name, &shaders, &outputs);
    for shader in shaders {
        // SAFETY: a shader of Cupola.
        unsafe { gl.delete_shader(shader) };
    }
    let name = linked?;
    let location = |index: i32| {
        let name_of = CString::new(format!("{}[{index}]", projection::UNIFORM)).unwrap_or_default();
        // SAFETY: a NUL-terminated name.
        unsafe { gl.get_uniform_location(name, name_of.as_ptr()) }
    };
    if let (Some(binding), None) = (limits.counter, projected.counter()) {
        projected.count_with(Counter::new(gl, binding));
    }
    projected.note_counting(limits.counter.is_some());
    Ok(Variant {
        name,
        locations: [location(0), location(projection::ROWS)],
        mirror: Mirror::new(gl, program.name, name),
        counts: limits.counter.is_some(),
        patch: match kind {
            Kind::Geometry(_) => None,
            Kind::Tessellation(patch) => Some(patch.corners() as i32),
        },
    })
}

/// Returns the index, among the program's shaders, of the last one before the stages that divide,
/// or the reason why the program cannot have such stages.
fn dividable(profile: Profile, program: &Program, kind: Kind) -> Result<usize, Obstacle> {
    if profile.es || profile.version < 32 {
        return Err("there are no geometry shaders before OpenGL 3.2".into());
    }
    let has = |wanted: u32| program.texts.iter().any(|(kind, _)| *kind == wanted);
    if has(api::GL_GEOMETRY_SHADER) {
        return Err("it has a geometry shader of its own".into());
    }
    let tessellates = matches!(kind, Kind::Tessellation(_));
    if tessellates && profile.version < 40 {
        return Err("there are no tessellation shaders before OpenGL 4.0".into());
    }
    let last = if has(api::GL_TESS_EVALUATION_SHADER) { api::GL_TESS_EVALUATION_SHADER } else { api::GL_VERTEX_SHADER };
    if tessellates && (has(api::GL_TESS_EVALUATION_SHADER) || has(api::GL_TESS_CONTROL_SHADER)) {
        return Err("it has tessellation shaders of its own".into());
    }
    let index = program.texts.iter().position(|(kind, source)| *kind == last && patch::has_main(source));
    index.ok_or_else(|| "its shaders' texts are not known".into())
}

/// A stage of Cupola.
struct Stage {
    /// `GL_GEOMETRY_SHADER` and so on.
    kind: u32,
    text: String,
}

/// Returns the stages that divide, and the outputs that the shader of this index passes to them.
fn dividing_stages(
    program: &Program,
    index: usize,
    kind: Kind,
    limits: &Limits,
) -> Result<(Interface, Vec<Stage>), Obstacle> {
    let bare = patch::strip_comments(&program.texts[index].1);
    let mut interface = interface::read(&bare)?;
    let built_in = if limits.compatibility { interface::built_in(&bare) } else { Vec::new() };
    if limits.compatibility {
        interface.add_texture_coordinates(&bare)?;
    }
    let numbered = fragments(program).any(|source| patch::mentions(source, "gl_PrimitiveID"));
    let functions = projection::functions(false, true);
    let passing = Passing { number: numbered, flat: program.flat };
    Ok(match kind {
        Kind::Geometry(input) => {
            let text = geometry_stage::text(input, &interface, &built_in, passing, &functions, limits)
                .ok_or("the driver's geometry shaders emit too few vertices")?;
            (interface, vec![Stage { kind: api::GL_GEOMETRY_SHADER, text }])
        }
        Kind::Tessellation(patch) => {
            let interface = tessellation::with_built_in(interface, &built_in, passing);
            let [control, evaluation] = tessellation::texts(patch, &interface, &functions, limits);
            let control = Stage { kind: api::GL_TESS_CONTROL_SHADER, text: control };
            let evaluation = Stage { kind: api::GL_TESS_EVALUATION_SHADER, text: evaluation };
            (interface, vec![control, evaluation])
        }
    })
}

/// Texts of the program's fragment shaders.
fn fragments(program: &Program) -> impl Iterator<Item = &str> {
    program.texts.iter().filter(|(kind, _)| *kind == api::GL_FRAGMENT_SHADER).map(|(_, source)| &**source)
}

/// Compiles a shader of Cupola. The driver's messages are logged if the program does not link.
fn compile(gl: &Gl, kind: u32, source: &str) -> u32 {
    let length = source.len() as i32;
    let start = source.as_ptr().cast::<c_char>();
    // SAFETY: one string with its length.
    unsafe {
        let shader = gl.create_shader(kind);
        gl.shader_source(shader, 1, &start, &length);
        gl.compile_shader(shader);
        shader
    }
}

/// Links a program with the attribute and fragment output locations of the program `original`.
fn link(gl: &Gl, original: u32, shaders: &[u32], outputs: &[Interface]) -> Result<u32, Obstacle> {
    let mut linked = 0;
    // SAFETY: objects of Cupola. Names end with NUL. Queries write no more than the buffers can
    // hold.
    unsafe {
        let name = gl.create_program();
        for shader in shaders {
            gl.attach_shader(name, *shader);
        }
        let mut count = 0;
        gl.get_programiv(original, api::GL_ACTIVE_ATTRIBUTES, &mut count);
        for index in 0..u32::try_from(count).unwrap_or(0) {
            let mut attribute: [c_char; 256] = [0; 256];
            let (mut length, mut size, mut kind) = (0, 0, 0);
            gl.get_active_attrib(original, index, 256, &mut length, &mut size, &mut kind, attribute.as_mut_ptr());
            let location = gl.get_attrib_location(original, attribute.as_ptr());
            if let Ok(location) = u32::try_from(location) {
                gl.bind_attrib_location(name, location, attribute.as_ptr());
            }
        }
        for output in outputs.iter().flat_map(|interface| &interface.values) {
            let Ok(text) = CString::new(output.own.as_str()) else { continue };
            if let Ok(location) = u32::try_from(gl.get_frag_data_location(original, text.as_ptr())) {
                gl.bind_frag_data_location(name, location, text.as_ptr());
            }
        }
        gl.link_program(name);
        gl.get_programiv(name, api::GL_LINK_STATUS, &mut linked);
        if linked != 0 {
            return Ok(name);
        }
        tell(gl, name, shaders);
        gl.delete_program(name);
    }
    Err("it does not link with the stage that divides primitives".into())
}

/// Logs the driver's messages about a program that does not link.
fn tell(gl: &Gl, program: u32, shaders: &[u32]) {
    let mut buffer: [c_char; 512] = [0; 512];
    let mut say = |read: &dyn Fn(*mut c_char)| {
        buffer[0] = 0;
        read(buffer.as_mut_ptr());
        // SAFETY: the driver ends its text with NUL.
        let words = unsafe { CStr::from_ptr(buffer.as_ptr()) }.to_string_lossy().trim().to_owned();
        if !words.is_empty() {
            log::once(&format!("the driver says: {words}"));
        }
    };
    for shader in shaders {
        // SAFETY: writes at most the size of the buffer.
        say(&|to| unsafe { gl.get_shader_info_log(*shader, 512, &mut 0, to) });
    }
    // SAFETY: as above.
    say(&|to| unsafe { gl.get_program_info_log(program, 512, &mut 0, to) });
}
