//! Entry of the shaders' map for a pixel.

use crate::correct::passes::output_pass::Plan;
use crate::correct::shaders::uniforms::direction_at;
use glam::DVec2;

/// Result of the shaders for one pixel of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapPixel {
    /// Unit direction in viewer axes of the atlas point that is sampled; NaN where nothing is
    /// shown.
    pub direction: [f32; 3],
    /// Place in the atlas, 0…1 from its first row.
    pub atlas: [f32; 2],
    /// Index of the sampled view; `None` where nothing is shown.
    pub view: Option<usize>,
    /// Product of all weights, linear light, 0…1.
    pub weight: f32,
}

impl MapPixel {
    /// Makes it from the values that [`crate::correct::shaders::glsl::Stage::Map`] writes for
    /// `plan`, whose views are as the shaders got them. Only the step from the atlas back to the
    /// direction is computed in f64.
    pub fn new(plan: &Plan, [x, y, number, weight]: [f32; 4]) -> Self {
        // Whole numbers far below 2^24 are exact.
        let index = (number as usize).checked_sub(1);
        let direction = index.and_then(|i| plan.views.views.get(i)).map(|view| {
            let point = DVec2::new(f64::from(x), f64::from(y));
            direction_at(view, plan.views.atlas, point)
        });
        Self { direction: direction.unwrap_or([f32::NAN; 3]), atlas: [x, y], view: index, weight }
    }
}
