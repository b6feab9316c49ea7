//! A picture of the dome before and after the calibration, so that people see what it changed.

use crate::canvas::{Canvas, Letters};
use crate::failure::Failure;
use crate::map::native_size;
use crate::pattern::draw::{Part, Pattern};
use crate::terminal;
use cupola::blend::{Picture, simulate};
use cupola::rig::Rig;
use std::path::Path;

/// Width and height of each half of the picture, pixels.
const SIDE: usize = 1024;
/// Distance of the grid's lines, degrees.
const STEP: f64 = 10.0;

/// Draws the dome's grid twice as the real projectors show it, and writes it to `file`: left with
/// pictures for the rig `before`, right with pictures for the rig `after`, which is taken as real.
///
/// # Errors
/// The file cannot be written, or a rig needs the program's lens.
pub fn write(file: &Path, before: &Rig, after: &Rig) -> Result<(), Failure> {
    let spinner = terminal::spinner("drawing the dome before and after");
    let mut both = Canvas::new(2 * SIDE, SIDE, [0.0; 3]);
    for (half, (rig, title)) in [(before, "before"), (after, "after")].into_iter().enumerate() {
        both.paste(&dome(rig, after)?, half * SIDE, 0);
        both.heading(title, [(half as f64 + 0.5) * SIDE as f64, 20.0], Letters::Large, [1.0; 3]);
    }
    spinner.finish_and_clear();
    image::save_buffer(file, &both.bytes(), both.width as u32, both.height as u32, image::ColorType::Rgb8)
        .map_err(|error| Failure::new(format!("{} cannot be written: {error}", file.display())))
}

/// The dome as the viewer sees it, if the projectors of the rig `real` show grids that were drawn
/// for the rig `drawn`.
fn dome(drawn: &Rig, real: &Rig) -> Result<Canvas, Failure> {
    let sizes: Vec<(u32, u32)> = (0..drawn.outputs.len()).map(|output| native_size(drawn, output)).collect();
    let pattern = Pattern::new(drawn, &sizes, &[Part::Dome], STEP, &[])?;
    let picture = |(output, &(width, height)): (usize, &(u32, u32))| {
        let bytes = pattern.draw(output).bytes();
        Picture { width, height, rgb: bytes.iter().map(|value| f32::from(*value) / 255.0).collect() }
    };
    let pictures: Vec<Picture> = sizes.iter().enumerate().map(picture).collect();
    let light = simulate(real, &pictures, SIDE as u32)?.rgb;
    let mut canvas = Canvas::new(SIDE, SIDE, [0.0; 3]);
    canvas.fill(|x, y| std::array::from_fn(|channel| light[3 * (y * SIDE + x) + channel].min(1.0)));
    Ok(canvas)
}
