//! Tests that the correction restores all state of the program.

use super::canvas::{Canvas, Picture};
use super::{contexts, headless};
use crate::backend::gl::driver::api::*;
use crate::backend::gl::driver::headless::{Api, Headless};
use crate::backend::gl::{GlBackend, Target, gpu_map};
use crate::backend::tests::plans::*;
use glam::DVec3;

/// Integer state of every context.
const INTEGERS: &[u32] = &[
    GL_CURRENT_PROGRAM,
    GL_VERTEX_ARRAY_BINDING,
    GL_ARRAY_BUFFER_BINDING,
    GL_ELEMENT_ARRAY_BUFFER_BINDING,
    GL_PIXEL_PACK_BUFFER_BINDING,
    GL_PIXEL_UNPACK_BUFFER_BINDING,
    GL_UNIFORM_BUFFER_BINDING,
    GL_DRAW_FRAMEBUFFER_BINDING,
    GL_READ_FRAMEBUFFER_BINDING,
    GL_RENDERBUFFER_BINDING,
    GL_ACTIVE_TEXTURE,
    GL_VIEWPORT,
    GL_SCISSOR_BOX,
    GL_BLEND_SRC_RGB,
    GL_BLEND_DST_ALPHA,
    GL_BLEND_EQUATION_RGB,
    GL_DEPTH_FUNC,
    GL_DEPTH_WRITEMASK,
    GL_STENCIL_FUNC,
    GL_STENCIL_WRITEMASK,
    GL_CULL_FACE_MODE,
    GL_FRONT_FACE,
    GL_UNPACK_ALIGNMENT,
    GL_UNPACK_ROW_LENGTH,
    GL_UNPACK_SKIP_ROWS,
    GL_UNPACK_SKIP_PIXELS,
    GL_PACK_ALIGNMENT,
    GL_PACK_ROW_LENGTH,
    GL_DRAW_BUFFER0,
    GL_DRAW_BUFFER1,
    GL_READ_BUFFER,
    GL_TRANSFORM_FEEDBACK_BUFFER_BINDING,
];

/// Integer state of desktop OpenGL only.
const DESKTOP_INTEGERS: &[u32] = &[
    GL_POLYGON_MODE,
    GL_LOGIC_OP_MODE,
    GL_UNPACK_SWAP_BYTES,
    GL_UNPACK_LSB_FIRST,
    GL_PRIMITIVE_RESTART_INDEX,
    GL_CLIP_ORIGIN,
    GL_CLIP_DEPTH_MODE,
    GL_PROVOKING_VERTEX,
];

const SWITCHES: &[u32] = &[
    GL_BLEND,
    GL_DEPTH_TEST,
    GL_STENCIL_TEST,
    GL_CULL_FACE,
    GL_SCISSOR_TEST,
    GL_DITHER,
    GL_POLYGON_OFFSET_FILL,
    GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_SAMPLE_COVERAGE,
    GL_RASTERIZER_DISCARD,
];

const DESKTOP_SWITCHES: &[u32] = &[
    GL_COLOR_LOGIC_OP,
    GL_FRAMEBUFFER_SRGB,
    GL_MULTISAMPLE,
    GL_SAMPLE_MASK,
    GL_SAMPLE_SHADING,
    GL_PRIMITIVE_RESTART,
    GL_POLYGON_SMOOTH,
    GL_LINE_SMOOTH,
    GL_DEPTH_CLAMP,
    GL_CLIP_DISTANCE0,
    GL_CLIP_DISTANCE1,
    GL_CLIP_DISTANCE5,
    GL_CLIP_DISTANCE7,
    GL_TEXTURE_CUBE_MAP_SEAMLESS,
];

const COMPATIBILITY_SWITCHES: &[u32] =
    &[GL_ALPHA_TEST, GL_POLYGON_STIPPLE, GL_LIGHTING, GL_FOG, GL_TEXTURE_2D, GL_VERTEX_PROGRAM_TWO_SIDE];

/// All state that is compared, by name.
pub fn snapshot(context: &Headless, api: Api) -> Vec<(String, Vec<i32>)> {
    let gl = &context.gl;
    let mut all = Vec::new();
    let desktop = !context.is_gles;
    // Contexts without a surface share one framebuffer 0 in Mesa, whose draw buffer the context of
    // another test may change at any time.
    let mut bound = 0;
    // SAFETY: a context is current; writes one integer.
    unsafe { gl.get_integerv(GL_DRAW_FRAMEBUFFER_BINDING, &mut bound) };
    let is_shared = |name| bound == 0 && name == GL_DRAW_BUFFER0;
    // SAFETY: a context is current, the names are its own, and no value has more than 16 parts.
    unsafe {
        let integers = INTEGERS.iter().chain(if desktop { DESKTOP_INTEGERS } else { &[] });
        for &name in integers.filter(|name| !is_shared(**name)) {
            let mut values = vec![-7; 16];
            gl.get_integerv(name, values.as_mut_ptr());
            all.push((format!("{name:#x}"), values));
        }
        let more = if desktop { DESKTOP_SWITCHES } else { &[] };
        let most = if api == Api::Compatibility { COMPATIBILITY_SWITCHES } else { &[] };
        for &name in SWITCHES.iter().chain(more).chain(most) {
            all.push((format!("switch {name:#x}"), vec![gl.is_enabled(name).into()]));
        }
        let active = all.iter().find(|(n, _)| *n == format!("{GL_ACTIVE_TEXTURE:#x}")).map_or(0, |(_, v)| v[0]);
        for unit in 0..4 {
            gl.active_texture(GL_TEXTURE0 + unit);
            for name in [GL_TEXTURE_BINDING_2D, GL_TEXTURE_BINDING_CUBE_MAP, GL_SAMPLER_BINDING] {
                let mut value = 0;
                gl.get_integerv(name, &mut value);
                all.push((format!("unit {unit} {name:#x}"), vec![value]));
            }
        }
        gl.active_texture(active as u32);
        for i in 0..4 {
            let mut mask = [9; 4];
            gl.get_booleani_v(GL_COLOR_WRITEMASK, i, mask.as_mut_ptr());
            all.push((format!("mask {i}"), mask.map(i32::from).to_vec()));
            all.push((format!("blend {i}"), vec![gl.is_enabledi(GL_BLEND, i).into()]));
        }
        if desktop {
            for i in 0..4 {
                let mut viewport = [0.0f32; 4];
                gl.get_floati_v(GL_VIEWPORT, i, viewport.as_mut_ptr());
                all.push((format!("viewport {i}"), viewport.map(|v| (v * 16.0) as i32).to_vec()));
                all.push((format!("scissor {i}"), vec![gl.is_enabledi(GL_SCISSOR_TEST, i).into()]));
            }
        }
        let mut color = [0.0f32; 4];
        gl.get_floatv(GL_COLOR_CLEAR_VALUE, color.as_mut_ptr());
        all.push(("clear".into(), color.map(|v| (v * 1000.0) as i32).to_vec()));
        assert_eq!(gl.get_error(), GL_NO_ERROR, "the test asks for something that {api:?} does not know");
    }
    all
}

/// Sets all state to unusual values that would spoil Cupola's drawing.
pub fn spoil(context: &Headless, api: Api) {
    let gl = &context.gl;
    let desktop = !context.is_gles;
    // SAFETY: a context is current, and every call is one that it knows.
    unsafe {
        for &name in SWITCHES.iter().chain(if desktop { DESKTOP_SWITCHES } else { &[] }) {
            gl.enable(name);
        }
        gl.disable(GL_DITHER);
        if api == Api::Compatibility {
            for &name in COMPATIBILITY_SWITCHES {
                gl.enable(name);
            }
            gl.alpha_func(GL_NEVER, 0.0);
            gl.polygon_stipple([0u8; 128].as_ptr());
            gl.polygon_mode(GL_FRONT, GL_POINT);
            gl.polygon_mode(GL_BACK, GL_LINE);
        }
        if desktop {
            if api == Api::Core {
                gl.polygon_mode(GL_FRONT_AND_BACK, GL_LINE);
            }
            gl.logic_op(GL_XOR);
            gl.clip_control(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
            gl.pixel_storei(GL_UNPACK_SWAP_BYTES, 1);
            gl.pixel_storei(GL_UNPACK_LSB_FIRST, 1);
            gl.primitive_restart_index(3);
            gl.sample_maski(0, 0);
            gl.viewport_indexedf(1, 1.5, 2.5, 30.0, 40.0);
            gl.disablei(GL_SCISSOR_TEST, 2);
        }
        gl.disablei(GL_BLEND, 1);
        gl.color_maski(0, 0, 1, 0, 0);
        gl.color_maski(2, 1, 0, 0, 1);
        gl.blend_func(GL_ZERO, GL_DST_COLOR);
        gl.depth_func(GL_NEVER);
        gl.stencil_func(GL_NEVER, 1, 3);
        gl.cull_face(GL_FRONT_AND_BACK);
        gl.scissor(1, 2, 3, 4);
        if desktop {
            gl.viewport_indexedf(0, 3.0, 5.0, 7.0, 11.0);
        } else {
            gl.viewport(3, 5, 7, 11);
        }
        gl.pixel_storei(GL_UNPACK_ALIGNMENT, 8);
        gl.pixel_storei(GL_UNPACK_ROW_LENGTH, 77);
        gl.pixel_storei(GL_UNPACK_SKIP_ROWS, 3);
        gl.pixel_storei(GL_UNPACK_SKIP_PIXELS, 5);
        let mut names = [0; 4];
        for (target, of) in [(GL_ARRAY_BUFFER, 0), (GL_PIXEL_UNPACK_BUFFER, 1), (GL_UNIFORM_BUFFER, 2)] {
            gl.gen_buffers(1, &mut names[of]);
            gl.bind_buffer(target, names[of]);
            gl.buffer_data(target, 64, std::ptr::null(), GL_STATIC_DRAW);
        }
        gl.gen_vertex_arrays(1, names.as_mut_ptr());
        gl.bind_vertex_array(names[0]);
        for unit in 0..4 {
            gl.active_texture(GL_TEXTURE0 + unit);
            gl.gen_textures(2, names.as_mut_ptr());
            gl.bind_texture(GL_TEXTURE_2D, names[0]);
            gl.bind_texture(GL_TEXTURE_CUBE_MAP, names[1]);
            gl.gen_samplers(1, names.as_mut_ptr());
            gl.bind_sampler(unit, names[0]);
        }
        gl.active_texture(GL_TEXTURE3);
        gl.gen_framebuffers(2, names.as_mut_ptr());
        gl.bind_framebuffer(GL_DRAW_FRAMEBUFFER, names[0]);
        gl.bind_framebuffer(GL_READ_FRAMEBUFFER, names[1]);
        gl.clear_color(0.1, 0.2, 0.3, 0.4);
        assert_eq!(gl.get_error(), GL_NO_ERROR, "{api:?}");
    }
}

#[test]
fn odd_state_spoils_nothing_and_is_put_back() {
    for api in [Api::Core, Api::Compatibility, Api::Es3] {
        let context = headless(api);
        let gl = &context.gl;
        let mut plan = fisheye_plan((128, 96), 3.0, DVec3::ZERO);
        plan.passes[0].mask = Some(crate::correct::Mask { width: 3, height: 1, weights: vec![65_535; 3] });
        let atlas = Picture::new(plan.views.atlas, |x, y| [(x * 5) as u8, (y * 3) as u8, 99, 255]);
        let texture = atlas.texture(gl, GL_RGBA8);
        let show = || {
            let canvas = Canvas::new(gl, (128, 96));
            let mut backend = GlBackend::new(gl, context.is_gles).expect("a backend");
            (Target { framebuffer: canvas.framebuffer, viewport: canvas.viewport() }, canvas, {
                backend.prepare(gl, &plan, false).expect("shaders");
                backend
            })
        };
        let (target, canvas, backend) = show();
        backend.present(gl, texture, &[target]);
        let expected = canvas.read(gl);
        let fresh = Canvas::new(gl, (128, 96));
        let plain = snapshot(&context, api);
        spoil(&context, api);
        let before = snapshot(&context, api);
        assert_ne!(plain, before);

        let mut again = GlBackend::new(gl, context.is_gles).expect("a backend");
        again.prepare(gl, &plan, false).expect("shaders");
        assert_eq!(snapshot(&context, api), before, "{api:?}: prepare");
        again.present(gl, texture, &[Target { framebuffer: fresh.framebuffer, viewport: fresh.viewport() }]);
        assert_eq!(snapshot(&context, api), before, "{api:?}: present");
        let map = gpu_map(gl, context.is_gles, &plan, 0).expect("the map");
        assert!(map[128 * 48 + 64].view.is_some());
        assert_eq!(snapshot(&context, api), before, "{api:?}: map");
        again.destroy(gl);
        assert_eq!(snapshot(&context, api), before, "{api:?}: destroy");
        assert_eq!(again.errors(), 0);

        // SAFETY: a context is current.
        unsafe {
            gl.bind_buffer(GL_PIXEL_PACK_BUFFER, 0);
            gl.pixel_storei(GL_PACK_ALIGNMENT, 4);
        }
        assert_eq!(fresh.read(gl), expected, "{api:?}");
    }
}

#[test]
fn errors_of_the_program_are_handed_over_and_ours_do_not_arise() {
    for context in contexts() {
        let gl = &context.gl;
        let plan = fisheye_plan((64, 64), 3.0, DVec3::ZERO);
        let texture = Picture::new(plan.views.atlas, |_, _| [1; 4]).texture(gl, GL_RGBA8);
        let canvas = Canvas::new(gl, (64, 64));
        let mut backend = GlBackend::new(gl, context.is_gles).expect("a backend");
        let target = Target { framebuffer: canvas.framebuffer, viewport: canvas.viewport() };
        backend.present(gl, texture, &[target]);
        assert_eq!(canvas.read(gl).at(0, 0), [255, 0, 255, 77], "drawn before anything was prepared");
        // SAFETY: a context is current; the calls are wrong on purpose.
        unsafe { gl.line_width(-1.0) };
        backend.prepare(gl, &plan, false).expect("shaders");
        assert_eq!(backend.present(gl, texture, &[target]), GL_INVALID_VALUE, "taken by prepare, given by present");
        // SAFETY: as above.
        unsafe { gl.enable(0xdead) };
        assert_eq!(backend.present(gl, texture, &[target]), GL_INVALID_ENUM);
        assert_eq!(backend.present(gl, texture, &[target]), GL_NO_ERROR);
        assert_eq!(backend.errors(), 0);
        // SAFETY: a context is current.
        assert_eq!(unsafe { gl.get_error() }, GL_NO_ERROR);
        // Negative control: an error of Cupola is counted, and the program does not see it.
        backend.present(gl, texture, &[Target { framebuffer: 4_711_000, ..target }]);
        assert!(backend.errors() > 0);
        // SAFETY: a context is current.
        assert_eq!(unsafe { gl.get_error() }, GL_NO_ERROR);
        backend.destroy(gl);
    }
}

#[test]
fn a_display_list_that_is_being_compiled_stays_the_programs_own() {
    let context = headless(Api::Compatibility);
    let gl = &context.gl;
    let plan = fisheye_plan((64, 64), 3.0, DVec3::ZERO);
    let canvas = Canvas::new(gl, (64, 64));
    let mut backend = GlBackend::new(gl, false).expect("a backend");
    backend.prepare(gl, &plan, false).expect("shaders");
    // SAFETY: a context is current.
    unsafe {
        gl.new_list(1, GL_COMPILE);
        backend.present(gl, 0, &[Target { framebuffer: canvas.framebuffer, viewport: canvas.viewport() }]);
        gl.end_list();
        gl.call_list(1);
        assert_eq!(gl.get_error(), GL_NO_ERROR);
    }
    assert_eq!(canvas.read(gl).at(32, 32), [255, 0, 255, 77]);
    backend.destroy(gl);
}

/// An operator who moves a slider makes many rough corrections before an exact one.
#[test]
fn rough_corrections_leave_no_programs_of_earlier_ones() {
    let context = headless(Api::Core);
    let gl = &context.gl;
    let plan = fisheye_plan((256, 256), 3.0, DVec3::ZERO);
    let mut backend = GlBackend::new(gl, false).expect("a backend");
    backend.prepare(gl, &plan, false).expect("shaders");
    let programs = backend.programs();
    let mut most = 0;
    for step in 1..=8 {
        let mut rough = plan.clone();
        rough.passes[0].black_level = 0.01 * f64::from(step);
        backend.prepare_rough(gl, &rough, false).expect("shaders");
        most = most.max(backend.programs().len());
    }
    assert!(most > programs.len() && most <= 2 * programs.len(), "{most} programs, {} before", programs.len());
    // The exact correction is still there.
    let linked = backend.linked();
    backend.prepare(gl, &plan, false).expect("shaders");
    assert_eq!(backend.linked(), linked);
    backend.destroy(gl);
    assert_eq!(backend.errors(), 0);
}

#[test]
fn preparing_again_compiles_only_what_is_new() {
    let context = headless(Api::Core);
    let gl = &context.gl;
    let plan = fisheye_plan((256, 256), 3.0, DVec3::ZERO);
    let mut backend = GlBackend::new(gl, false).expect("a backend");
    backend.prepare(gl, &plan, false).expect("shaders");
    let programs = backend.programs();
    backend.prepare(gl, &plan, false).expect("shaders");
    assert_eq!(backend.programs(), programs);
    let mut other = plan.clone();
    other.passes[0].black_level = 0.1;
    backend.prepare(gl, &other, false).expect("shaders");
    assert_ne!(backend.programs(), programs);
    assert_eq!(backend.programs().len(), programs.len(), "programs that no batch needs are kept");
    // After a failed preparation the former correction stays in use.
    let (former, mut broken) = (backend.programs(), plan);
    broken.passes[0].batches[0].views = vec![99];
    assert!(backend.prepare(gl, &broken, false).is_err());
    assert_eq!(backend.programs(), former);
    backend.destroy(gl);
}

/// A backend replaces another one, as after a change of the rig.
#[test]
fn programs_are_inherited_and_given_back_where_preparing_fails() {
    let context = headless(Api::Core);
    let gl = &context.gl;
    let plan = fisheye_plan((256, 256), 3.0, DVec3::ZERO);
    let mut old = GlBackend::new(gl, false).expect("a backend");
    old.prepare(gl, &plan, false).expect("shaders");
    let programs = old.programs();
    let mut broken = plan.clone();
    broken.passes[0].batches[0].views = vec![99];
    let mut failing = GlBackend::new(gl, false).expect("a backend");
    failing.inherit(&mut old);
    assert!(failing.prepare(gl, &broken, false).is_err());
    old.inherit(&mut failing);
    failing.destroy(gl);
    assert_eq!(old.programs(), programs);
    let mut new = GlBackend::new(gl, false).expect("a backend");
    new.inherit(&mut old);
    new.prepare(gl, &plan, false).expect("shaders");
    old.destroy(gl);
    assert_eq!((new.programs(), new.linked()), (programs.clone(), 0));
    // SAFETY: a context is current.
    assert!(programs.iter().all(|program| unsafe { gl.is_program(*program) } != 0));
    new.destroy(gl);
}

/// Programs of the next plan are made while the present one is in use.
#[test]
fn programs_of_the_next_plan_are_made_ahead() {
    for api in [Api::Core, Api::Compatibility, Api::Es3] {
        let context = headless(api);
        let gl = &context.gl;
        let plan = fisheye_plan((256, 256), 3.0, DVec3::ZERO);
        let mut next = plan.clone();
        next.passes[0].black_level = 0.1;
        let mut old = GlBackend::new(gl, context.is_gles).expect("a backend");
        old.prepare(gl, &plan, false).expect("shaders");
        let programs = old.programs();
        let before = snapshot(&context, api);
        old.look_ahead(&next, false).expect("texts");
        let mut made = 0;
        while old.make_ahead(gl).expect("a shader") {
            made += 1;
        }
        assert!(made > 0 && old.programs().len() == programs.len() + made, "{made}");
        assert_eq!(snapshot(&context, api), before);
        let mut new = GlBackend::new(gl, context.is_gles).expect("a backend");
        new.inherit(&mut old);
        new.prepare(gl, &next, false).expect("shaders");
        assert_eq!(new.linked(), 0);
        assert_eq!(new.programs().len(), programs.len(), "programs of the old plan are kept");
        // Control: a backend that inherits nothing links as many programs as were made, and those
        // that both plans need.
        let mut other = GlBackend::new(gl, context.is_gles).expect("a backend");
        other.prepare(gl, &next, false).expect("shaders");
        assert!(other.linked() >= made as u64);
        for mut backend in [old, new, other] {
            backend.destroy(gl);
            assert_eq!(backend.errors(), 0);
        }
    }
}
