//! Results about the light: a mask for each output, and keys of the rig.

use super::written::{Changes, number, numbers};
use crate::convert;
use crate::failure::Failure;
use crate::map::native_size;
use cupola::calibrate::light::{Found, Lit};
use cupola::rig::{self, Rig};
use glam::DVec2;
use std::path::Path;
use toml_edit::{Array, InlineTable, Value};

/// Number of pixels of an output, in each direction, for one of its mask: light changes slowly.
const COARSER: u32 = 8;

/// Writes the masks beside the rig file `out`, and returns the keys that name them.
///
/// # Errors
/// A file exists already, or cannot be written.
pub fn masks(rig: &Rig, light: &Found, out: &Path, replace: bool) -> Result<Vec<Changes>, Failure> {
    let stem = out.file_stem().unwrap_or_default().to_string_lossy();
    let file = |lit: &Lit| out.with_file_name(format!("{stem}-{}-light.png", rig.outputs[lit.output].name));
    light.outputs.iter().try_for_each(|lit| convert::refuse_to_replace(&file(lit), replace))?;
    let mut all = Vec::new();
    for (index, lit) in light.outputs.iter().enumerate() {
        let file = file(lit);
        let (size, values) = mask(rig, light, index)?;
        let picture = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(size.0, size.1, values);
        let written = picture.map(|picture| picture.save(&file));
        if let Some(Err(error)) = written {
            return Err(Failure::new(format!("{} cannot be written: {error}", file.display())));
        }
        let image = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        all.push(changes(rig, lit, &image));
    }
    Ok(all)
}

/// Mask of an output: the dimming that evens out its light, times the mask that it has.
fn mask(rig: &Rig, light: &Found, index: usize) -> Result<((u32, u32), Vec<u16>), Failure> {
    let output = light.outputs[index].output;
    let (width, height) = native_size(rig, output);
    let own = rig.outputs[output].mask.as_deref().map(rig::read_mask).transpose()?;
    let coarse = (width.div_ceil(COARSER), height.div_ceil(COARSER));
    let size = own.as_ref().map_or(coarse, |(size, _)| *size);
    let part = |at: u32, of: u32| (f64::from(at) + 0.5) / f64::from(of);
    let places = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y)));
    let values = places.enumerate().map(|(at, (x, y))| {
        let pixel = DVec2::new(part(x, size.0) * f64::from(width), part(y, size.1) * f64::from(height));
        let before = own.as_ref().map_or(f64::from(u16::MAX), |(_, values)| f64::from(values[at]));
        (before * light.dimming(index, pixel)).round() as u16
    });
    Ok((size, values.collect()))
}

/// Keys of an output.
fn changes(rig: &Rig, lit: &Lit, image: &str) -> Changes {
    let output = &rig.outputs[lit.output];
    let points: Array = lit.response.iter().map(|point| numbers(point)).collect();
    let transfer: InlineTable = [("measured", Value::Array(points))].into_iter().collect();
    let mut keys =
        vec![(vec!["blend", "transfer"], Value::InlineTable(transfer)), (vec!["mask", "image"], Value::from(image))];
    // Without overlap no blacks add up.
    keys.extend(
        lit.contrast
            .filter(|_| output.blend.overlap)
            .map(|contrast| (vec!["blend", "contrast"], number(contrast.round()))),
    );
    // The mask evens out the light, and the response has its own exponents.
    Changes { name: output.name.clone(), removed: vec![vec!["even_light"], vec!["blend", "gamma"]], keys }
}
