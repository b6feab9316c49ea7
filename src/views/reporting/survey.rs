//! Survey of a plan, pixel by pixel of the outputs.

use crate::error::Result;
use crate::rig::Rig;
use crate::views::reporting::answers::Answers;
use crate::views::sampling::output_map::OutputMap;
use crate::views::sampling::sample::Sample;
use crate::views::view_plan::ViewPlan;
use glam::{DVec2, DVec3};

/// A pixel of an output, and the view that it samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surveyed {
    /// Index of the output.
    pub output: usize,
    /// The direction that the pixel's centre shows, viewer axes, unit length.
    pub direction: DVec3,
    /// Index of the view that the pixel samples.
    pub view: usize,
    /// Texels per pixel in the direction with the fewest. A domemaster's pixels have the size that
    /// the planner uses (`[views] resolution`). `None` in views with the program's own lens, except
    /// for content, and in views with projected vertices.
    pub texels_per_pixel: Option<f64>,
}

/// Surveys pixels of one output.
pub struct Surveyor<'a> {
    answers: Answers<'a>,
    output: usize,
    output_map: OutputMap,
}

impl<'a> Surveyor<'a> {
    /// Makes a surveyor for output `output` of `rig` with `size` pixels. `plan` contains its views.
    ///
    /// # Errors
    /// Those of [`WarpMap::new`](crate::warp::WarpMap::new).
    pub fn new(plan: &'a ViewPlan, rig: &Rig, output: usize, size: (u32, u32)) -> Result<Self> {
        let output_map = OutputMap::new(&rig.around_content(), output, size)?;
        Ok(Self { answers: Answers::new(plan, rig, output), output, output_map })
    }

    /// Returns the survey of a pixel position (from the top left, centres at +½); `None` where
    /// nothing is shown.
    pub fn at(&self, pixel: DVec2) -> Option<Surveyed> {
        let sample = self.output_map.sample(pixel)?;
        let view = self.answers.view(&sample)?;
        Some(self.surveyed(pixel, &sample, view))
    }

    /// As [`Surveyor::at`], for the view with this index, whichever view the pixel samples; `None`
    /// also if the plan has no such view.
    pub fn in_view(&self, pixel: DVec2, view: usize) -> Option<Surveyed> {
        let sample = self.output_map.sample(pixel)?;
        self.answers.has(view).then(|| self.surveyed(pixel, &sample, view))
    }

    fn surveyed(&self, pixel: DVec2, sample: &Sample, view: usize) -> Surveyed {
        let texels_per_pixel = self.answers.texels_per_pixel(view, sample, pixel, &self.output_map);
        Surveyed { output: self.output, direction: sample.direction, view, texels_per_pixel }
    }
}

/// Calls `visit` for pixels of all outputs that show something, row by row and evenly spread: every
/// pixel of an output with at most `most` pixels, otherwise about `most` of them. Sizes beyond the
/// rig's outputs are ignored, and so are outputs without pixels.
pub fn survey(plan: &ViewPlan, rig: &Rig, sizes: &[(u32, u32)], most: u32, mut visit: impl FnMut(&Surveyed)) {
    let outputs = rig.outputs.iter().zip(sizes).zip(&plan.output_views);
    for (output, ((_, &size), _)) in outputs.enumerate() {
        if size.0 == 0 || size.1 == 0 {
            continue;
        }
        let Ok(surveyor) = Surveyor::new(plan, rig, output, size) else { continue };
        let step = (f64::from(size.0) * f64::from(size.1) / f64::from(most.max(1))).sqrt().max(1.0);
        let (columns, rows) = (steps(size.0, step), steps(size.1, step));
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let pixel = DVec2::new(centre(column, columns, size.0), centre(row, rows, size.1));
            if let Some(surveyed) = surveyor.at(pixel) {
                visit(&surveyed);
            }
        }
    }
}

/// Returns the number of steps of a length along a side.
fn steps(pixels: u32, step: f64) -> u32 {
    (f64::from(pixels) / step).round().clamp(1.0, f64::from(pixels)) as u32
}

/// Returns the centre of the pixel in the middle of a step.
fn centre(index: u32, steps: u32, pixels: u32) -> f64 {
    ((f64::from(index) + 0.5) * f64::from(pixels) / f64::from(steps)).floor() + 0.5
}
