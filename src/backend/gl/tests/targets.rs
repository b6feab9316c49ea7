//! Targets of other sizes and places, and atlases of other formats.

use super::canvas::Canvas;
use super::contexts;
use crate::backend::gl::driver::api::*;
use crate::backend::gl::{ClearedViews, GlBackend, KnownState, Target};
use crate::backend::tests::picture::Picture;
use crate::backend::tests::plans::*;
use crate::backend::tests::present::{noise, one_to_one, place, waves};
use crate::correct::{LowerLeftRect, Plan};
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
        let target = Target { framebuffer: canvas.framebuffer, viewport: LowerLeftRect::new(50, 100, 512, 512) };
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
        // All pixels except the seams and the rim.
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

/// Two fisheye pictures, each with black corners.
fn two_fisheyes() -> Plan {
    let mut plan = fisheye_plan((64, 64), 3.0, DVec3::ZERO);
    plan.views.output_views.push(plan.views.output_views[0].clone());
    let mut other = plan.passes[0].clone();
    other.batches[0].rects[0].width = 30;
    plan.passes.push(other);
    plan
}

#[test]
fn an_own_framebuffer_shows_the_same_and_black_around_it() {
    let plan = two_fisheyes();
    // Side by side with a strip outside both, covering everything, and overlapping.
    let places = [
        ((140, 64), [[0, 0, 64, 64], [76, 0, 64, 64]]),
        ((128, 64), [[0, 0, 64, 64], [64, 0, 64, 64]]),
        ((96, 64), [[0, 0, 64, 64], [32, 0, 64, 64]]),
    ];
    for context in contexts() {
        let gl = &context.gl;
        for (size, viewports) in places {
            for color in [None, Some([0, 0, 0]), Some([51, 102, 204])] {
                // Cleared views are a picture of one colour.
                let atlas = match color {
                    None => waves(plan.views.atlas),
                    Some([r, g, b]) => Picture::new(plan.views.atlas, |_, _| [r, g, b, 255]),
                };
                let texture = atlas.texture(gl, GL_RGBA8);
                let color = color.map(|color| color.map(|c| f32::from(c) / 255.0));
                let show = |owned: bool, cleared: Option<&ClearedViews<'_>>| {
                    let mut backend = GlBackend::new(gl, context.is_gles).expect("a backend");
                    backend.prepare(gl, &plan, false).expect("shaders");
                    let canvas = Canvas::new(gl, size);
                    let targets =
                        viewports.map(|viewport| Target { framebuffer: canvas.framebuffer, viewport: viewport.into() });
                    if owned {
                        backend.own_framebuffer(&targets, size);
                    }
                    backend.present_changed(gl, texture, &targets, cleared, &KnownState::default());
                    backend.destroy(gl);
                    assert_eq!(backend.errors(), 0);
                    canvas.read(gl)
                };
                let plain = show(false, None);
                let cleared = color.map(|color| ClearedViews { views: u64::MAX, color, touched: &[] });
                for cleared in [None, cleared.as_ref()] {
                    let owned = show(true, cleared);
                    let inside = |x: u32| viewports.iter().any(|v| (v[0]..v[0] + v[2]).contains(&(x as i32)));
                    for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
                        let expected = if inside(x) { plain.at(x, y) } else { [0, 0, 0, 255] };
                        assert_eq!(owned.at(x, y), expected, "{x}, {y} of {size:?} with {color:?}, {cleared:?}");
                    }
                }
            }
        }
    }
}
