//! Tests that draw, on whatever driver EGL finds without a window.

mod canvas;
mod state;
mod targets;
mod unsampled_areas;

use super::driver::api::{GL_NO_ERROR, GL_RGBA8};
use super::driver::headless::{Api, Headless};
use super::{GlBackend, MapPixel, Target, gpu_map};
use crate::backend::tests::{Driver, run_all_cases};
use crate::correct::Plan;
use canvas::{Canvas, Picture};

run_all_cases!(crate::backend::gl::tests::contexts());

impl Driver for Headless {
    fn map(&self, plan: &Plan, output: usize) -> Vec<MapPixel> {
        gpu_map(&self.gl, self.is_gles, plan, output).expect("the map")
    }

    fn show_each(&self, plan: &Plan, panel: bool, atlases: &[Picture]) -> Vec<Picture> {
        let gl = &self.gl;
        let mut backend = GlBackend::new(gl, self.is_gles).expect("a backend");
        backend.prepare(gl, plan, panel).expect("shaders");
        let shown = |atlas: &Picture| {
            let texture = atlas.texture(gl, GL_RGBA8);
            let canvas = Canvas::new(gl, plan.passes[0].size);
            let target = Target { framebuffer: canvas.framebuffer, viewport: canvas.viewport() };
            assert_eq!(backend.present(gl, texture, &[target]), GL_NO_ERROR);
            canvas.read(gl)
        };
        let pictures = atlases.iter().map(shown).collect();
        backend.destroy(gl);
        assert_eq!(backend.errors(), 0);
        pictures
    }
}

fn headless(api: Api) -> Headless {
    Headless::new(api).expect("a driver that draws without a window (Mesa's llvmpipe will do)")
}

/// Returns one context of each kind, made current in turn.
fn contexts() -> impl Iterator<Item = Headless> {
    [Api::Core, Api::Compatibility, Api::Es3].into_iter().map(headless)
}
