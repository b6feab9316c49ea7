//! Closing parts of the atlas: only their depth changes.

use super::canvas::{Canvas, Picture};
use super::headless;
use super::state::{snapshot, spoil};
use crate::backend::gl::driver::api::*;
use crate::backend::gl::driver::headless::{Api, Headless};
use crate::backend::gl::{GlBackend, KnownState};
use crate::correct::Tile;

const SIZE: (u32, u32) = (64, 48);
const AREAS: [Tile; 3] = [
    Tile { x: 3, y: 5, width: 10, height: 7 },
    Tile { x: 40, y: 1, width: 24, height: 47 },
    Tile { x: 13, y: 5, width: 1, height: 1 },
];

/// A framebuffer with depth and stencil, cleared to `depth` and 5.
fn canvas(gl: &Gl, depth: f32) -> Canvas {
    let canvas = Canvas::new(gl, SIZE);
    // SAFETY: a context is current.
    unsafe {
        let mut buffer = 0;
        gl.gen_renderbuffers(1, &mut buffer);
        gl.bind_renderbuffer(GL_RENDERBUFFER, buffer);
        gl.renderbuffer_storage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, SIZE.0 as i32, SIZE.1 as i32);
        gl.bind_framebuffer(GL_FRAMEBUFFER, canvas.framebuffer);
        gl.framebuffer_renderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, buffer);
        gl.clear_bufferfi(GL_DEPTH_STENCIL, 0, depth, 5);
    }
    canvas
}

/// Checks every depth and stencil value of the bound framebuffer; OpenGL ES cannot read them.
fn expect_depths(context: &Headless, what: &str, expected: impl Fn(bool) -> f32) {
    if context.is_gles {
        return;
    }
    let gl = &context.gl;
    let pixels = (SIZE.0 * SIZE.1) as usize;
    let (mut depths, mut stencils) = (vec![0.5f32; pixels], vec![0u8; pixels]);
    // SAFETY: a context is current; the arrays hold the whole picture.
    unsafe {
        let (width, height) = (SIZE.0 as i32, SIZE.1 as i32);
        gl.bind_buffer(GL_PIXEL_PACK_BUFFER, 0);
        gl.pixel_storei(GL_PACK_ALIGNMENT, 1);
        gl.read_pixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, depths.as_mut_ptr().cast());
        gl.read_pixels(0, 0, width, height, GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, stencils.as_mut_ptr().cast());
        assert_eq!(gl.get_error(), GL_NO_ERROR, "{what}");
    }
    for (index, (depth, stencil)) in depths.iter().zip(&stencils).enumerate() {
        let (x, y) = (index as u32 % SIZE.0, index as u32 / SIZE.0);
        let inside = |t: &Tile| (t.x..t.x + t.width).contains(&x) && (t.y..t.y + t.height).contains(&y);
        let expected = expected(AREAS.iter().any(inside));
        // Two steps of 24 bits.
        assert!((depth - expected).abs() < 1.2e-7, "{what}: {depth} for {expected} at {x}, {y}");
        assert_eq!(*stencil, 5, "{what}: at {x}, {y}");
    }
}

fn prepared(context: &Headless) -> GlBackend {
    let mut backend = GlBackend::new(&context.gl, context.is_gles).expect("a backend");
    backend.prepare_unsampled(&context.gl, &AREAS, SIZE).expect("a shader");
    backend
}

fn bind(gl: &Gl, canvas: &Canvas) {
    // SAFETY: a context is current.
    unsafe { gl.bind_framebuffer(GL_FRAMEBUFFER, canvas.framebuffer) };
}

#[test]
fn the_areas_get_the_depth_farthest_from_the_clear_value_whatever_else_is_set() {
    let texels: u64 = AREAS.iter().map(Tile::area).sum();
    for api in [Api::Core, Api::Compatibility, Api::Es3] {
        let context = headless(api);
        let gl = &context.gl;
        let cases = [(1.0, 0.0, [0.0, 1.0]), (0.0, 1.0, [0.0, 1.0]), (1.0, 0.25, [0.75, 0.25]), (0.7, 0.0, [1.0, 0.0])];
        let canvases: Vec<Canvas> = cases.iter().map(|case| canvas(gl, case.0)).collect();
        spoil(&context, api);
        for ((cleared, nearest, range), canvas) in cases.into_iter().zip(&canvases) {
            bind(gl, canvas);
            // SAFETY: a context is current.
            unsafe { gl.depth_rangef(range[0], range[1]) };
            let before = snapshot(&context, api);
            let mut backend = prepared(&context);
            assert_eq!(backend.close_unsampled(gl, cleared, &KnownState::default()), texels);
            assert_eq!(snapshot(&context, api), before, "{api:?}");
            let what = format!("{api:?}, cleared to {cleared}");
            expect_depths(&context, &what, |inside| if inside { nearest } else { cleared });
            backend.destroy(gl);
            assert_eq!(backend.errors(), 0, "{what}");
        }
        // SAFETY: a context is current.
        unsafe { gl.pixel_storei(GL_PACK_ALIGNMENT, 4) };
        assert_eq!(canvases[0].read(gl), Picture::new(SIZE, |_, _| [255, 0, 255, 77]), "{api:?}: the colours changed");
    }
}

#[test]
fn nothing_is_closed_where_depth_is_not_written_or_samples_are_counted() {
    for api in [Api::Core, Api::Compatibility, Api::Es3] {
        let context = headless(api);
        let gl = &context.gl;
        let canvas = canvas(gl, 1.0);
        bind(gl, &canvas);
        let mut backend = prepared(&context);
        let mut query = 0;
        // SAFETY: a context is current; the query is begun and ended in order.
        unsafe {
            gl.depth_mask(0);
            assert_eq!(backend.close_unsampled(gl, 1.0, &KnownState::default()), 0, "{api:?}");
            gl.depth_mask(1);
            gl.gen_queries(1, &mut query);
            gl.begin_query(GL_ANY_SAMPLES_PASSED, query);
            assert_eq!(backend.close_unsampled(gl, 1.0, &KnownState::default()), 0, "{api:?}");
            gl.end_query(GL_ANY_SAMPLES_PASSED);
        }
        expect_depths(&context, "nothing is closed", |_| 1.0);
        backend.prepare_unsampled(gl, &[], SIZE).expect("nothing to do");
        assert_eq!(backend.close_unsampled(gl, 1.0, &KnownState::default()), 0, "{api:?}");
        backend.destroy(gl);
        assert_eq!(backend.errors(), 0, "{api:?}");
    }
}
