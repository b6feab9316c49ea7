//! Tests that draw, on whatever driver Vulkan finds.

mod alike;
mod canvas;
mod faults;
mod formats;

use super::gpu_map;
use crate::backend::tests::picture::Picture;
use crate::backend::tests::{Driver, run_all_cases};
use crate::backend::vk::driver::headless::Headless;
use crate::correct::Plan;
use crate::correct::shaders::map::MapPixel;

run_all_cases!([crate::backend::vk::tests::headless()]);

fn headless() -> Headless {
    Headless::new(&[]).expect("a Vulkan driver (Mesa's lavapipe will do)")
}

impl Driver for Headless {
    fn map(&self, plan: &Plan, output: usize) -> Vec<MapPixel> {
        let mut map = gpu_map(self, plan, output).expect("the map");
        // On Vulkan the atlas' first row is the top one; tests count rows as the plan does.
        map.iter_mut().for_each(|pixel| pixel.atlas[1] = 1.0 - pixel.atlas[1]);
        map
    }

    fn show_each(&self, plan: &Plan, panel: bool, atlases: &[Picture]) -> Vec<Picture> {
        canvas::show_each(self, plan, panel, atlases)
    }
}
