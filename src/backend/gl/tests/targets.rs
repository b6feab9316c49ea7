//! Targets of other sizes and places, and atlases of other formats.

use super::canvas::Canvas;
use super::contexts;
use crate::backend::gl::api::*;
use crate::backend::gl::{GlBackend, Target};
use crate::backend::tests::plans::*;
use crate::backend::tests::present::{noise, one_to_one, place, waves};
use glam::DVec3;

#[test]
fn a_target_of_another_size_and_place() {
    for context in contexts() {
        let gl = &context.gl;
        let plan = fisheye_plan((256, 256), 3.0, DVec3::ZERO);
        let larger = fisheye_plan((512, 512), 3.0, DVec3::ZERO);
        let atlas = waves(plan.views.atlas);
        let mut backend = GlBackend::new(gl, context.is_gles).expect("a backend");
        backend.prepare(gl, &plan, false).expect("shaders");
        let texture = atlas.texture(gl, GL_RGBA8);
        let canvas = Canvas::new(gl, (600, 700));
        let target = Target { framebuffer: canvas.framebuffer, viewport: [50, 100, 512, 512] };
        backend.present(gl, texture, &[target]);
        let shown = canvas.read(gl);
        let mut compared = 0;
        for row in 0..512 {
            for column in 0..512 {
                let direction = fisheye_direction(&larger, (512, 512), column, row);
                let Some((x, y)) = direction.and_then(|d| place(&plan.views.views, d)) else { continue };
                let pixel = shown.at(50 + column, 100 + 511 - row);
                let exact = atlas.bilinear(x, y);
                let error = (0..3).map(|k| (f64::from(pixel[k]) - 255.0 * exact[k]).abs()).fold(0.0, f64::max);
                compared += usize::from(error <= 1.6);
            }
        }
        // All but the seams and the rim.
        assert!(compared > 200_000, "{compared}");
        assert_eq!(shown.at(49, 100), [255, 0, 255, 77], "outside the viewport");
        assert_eq!(shown.at(50, 99), [255, 0, 255, 77], "outside the viewport");
        assert_eq!(shown.at(50, 100), [0, 0, 0, 255], "the corner");
        backend.destroy(gl);
    }
}

#[test]
fn an_srgb_atlas_is_not_decoded() {
    for context in contexts() {
        let plan = one_to_one((64, 64));
        let gl = &context.gl;
        let atlas = noise(plan.views.atlas);
        let mut backend = GlBackend::new(gl, context.is_gles).expect("a backend");
        backend.prepare(gl, &plan, false).expect("shaders");
        let texture = atlas.texture(gl, GL_SRGB8_ALPHA8);
        let canvas = Canvas::new(gl, (64, 64));
        backend.present(gl, texture, &[Target { framebuffer: canvas.framebuffer, viewport: canvas.viewport() }]);
        let shown = canvas.read(gl);
        assert_eq!(shown.at(20, 30)[..3], atlas.at(33, 59)[..3]);
        assert_eq!(shown.at(63, 0)[..3], atlas.at(76, 29)[..3]);
        backend.destroy(gl);
    }
}
