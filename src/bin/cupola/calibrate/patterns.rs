//! Patterns for a camera.

use super::Arguments;
use crate::failure::Failure;
use crate::map::native_size;
use crate::terminal;
use cupola::calibrate::gray::{Codes, Picture};
use cupola::calibrate::light::LEVELS;
use cupola::geom::PixelRect;
use cupola::rig::Rig;
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;

/// Patterns of all projectors of a rig, in the order in which they are photographed.
pub struct Patterns<'a> {
    rig: &'a Rig,
    /// Numbers of the projectors in the rig, with their codes.
    outputs: Vec<(usize, Codes)>,
    /// Size in pixels of the rig's window.
    window: (u32, u32),
    /// Places of the outputs in the window.
    places: Vec<PixelRect>,
    /// Grey pictures follow the codes of each output.
    light: bool,
}

/// A picture to photograph.
#[derive(Clone, Copy)]
enum Shown {
    Code(Picture),
    Grey(u8),
}

/// A picture of one output to photograph; the others are black.
pub struct Pattern {
    /// Number of the output in the rig.
    pub output: usize,
    /// Name of the picture's file, and of its photograph's, without ending.
    pub name: String,
    codes: Codes,
    shown: Shown,
}

impl<'a> Patterns<'a> {
    /// Patterns of a rig, as large as the arguments say.
    ///
    /// # Errors
    /// The rig has no projectors.
    pub fn new(rig: &'a Rig, arguments: &Arguments) -> Result<Self, Failure> {
        let projectors = (0..rig.outputs.len()).filter(|output| rig.outputs[*output].kind.is_projector());
        let outputs: Vec<_> =
            projectors.map(|output| (output, Codes::new(native_size(rig, output), arguments.cell))).collect();
        if outputs.is_empty() {
            return Err(Failure::usage(format!("the rig {} has no outputs of kind = \"projector\"", rig.name)));
        }
        let window = arguments.size.or_else(|| rig.extent()).unwrap_or((1920, 1200));
        Ok(Self { rig, outputs, window, places: rig.layout(window), light: arguments.light })
    }

    /// Projectors with their codes.
    pub fn outputs(&self) -> &[(usize, Codes)] {
        &self.outputs
    }

    /// Number of pictures.
    pub fn count(&self) -> usize {
        self.outputs.iter().map(|(_, codes)| shown(codes, self.light).len()).sum()
    }

    /// All pictures in their order.
    pub fn all(&self) -> impl Iterator<Item = Pattern> {
        let of_output = |(output, codes): &(usize, Codes)| {
            let (output, codes) = (*output, *codes);
            shown(&codes, self.light).into_iter().map(move |shown| (output, codes, shown))
        };
        (1..).zip(self.outputs.iter().flat_map(of_output)).map(|(number, (output, codes, shown))| Pattern {
            output,
            name: format!("{number:04}-{}-{}", self.rig.outputs[output].name, shown.name()),
            codes,
            shown,
        })
    }

    /// Size of a pattern in pixels: that of the window, or of an output that is not in it.
    pub fn size(&self, pattern: &Pattern) -> (u32, u32) {
        if self.rig.outputs[pattern.output].shown { self.window } else { native_size(self.rig, pattern.output) }
    }

    /// Grey values of a pattern, row by row from the top.
    pub fn values(&self, pattern: &Pattern) -> Vec<u8> {
        let (width, height) = self.size(pattern);
        let native = native_size(self.rig, pattern.output);
        let place = match self.rig.outputs[pattern.output].shown {
            true => self.places[pattern.output],
            false => PixelRect::new(0, 0, width, height),
        };
        // In a window of another size an output has other pixels than its own.
        let scaled = |at: u32, place: u32, native: u32| {
            let middle = (2 * u64::from(at) + 1) * u64::from(native) / (2 * u64::from(place.max(1)));
            middle as u32
        };
        let value = |x: u32, y: u32| {
            let inside = x >= place.x && y >= place.y && x - place.x < place.width && y - place.y < place.height;
            if !inside {
                return 0;
            }
            let pixel = (scaled(x - place.x, place.width, native.0), scaled(y - place.y, place.height, native.1));
            pattern.shown.value(&pattern.codes, pixel)
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| value(x, y)).collect()
    }
}

/// Pictures of an output in their order.
fn shown(codes: &Codes, light: bool) -> Vec<Shown> {
    // White and black are the first two codes.
    let greys = LEVELS.into_iter().filter(|level| light && !matches!(level, 0 | 255)).map(Shown::Grey);
    codes.pictures().into_iter().map(Shown::Code).chain(greys).collect()
}

impl Shown {
    fn value(self, codes: &Codes, pixel: (u32, u32)) -> u8 {
        match self {
            Self::Code(picture) => 255 * u8::from(codes.is_white(picture, pixel)),
            Self::Grey(level) => level,
        }
    }

    fn name(self) -> String {
        match self {
            Self::Grey(level) => format!("grey-{level:03}"),
            Self::Code(Picture::White) => "white".to_owned(),
            Self::Code(Picture::Black) => "black".to_owned(),
            Self::Code(Picture::Bit { axis, bit, inverse }) => {
                format!("{}{bit}{}", ["x", "y"][axis.min(1)], if inverse { "-inverse" } else { "" })
            }
        }
    }
}

/// Writes the patterns to a folder.
pub fn write(arguments: &Arguments, rig: &Rig, folder: &Path) -> Result<ExitCode, Failure> {
    let patterns = Patterns::new(rig, arguments)?;
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::usage(format!("the folder {} cannot be created: {error}", folder.display())))?;
    let count = patterns.count();
    let bar = terminal::progress(count as u64, "patterns");
    for pattern in patterns.all() {
        let (file, (width, height)) = (folder.join(format!("{}.png", pattern.name)), patterns.size(&pattern));
        image::save_buffer(&file, &patterns.values(&pattern), width, height, image::ColorType::L8)
            .map_err(|error| Failure::new(format!("{} cannot be written: {error}", file.display())))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let (folder, (width, height)) = (folder.display(), patterns.window);
    if arguments.json {
        println!("{:#}", json!({ "folder": folder.to_string(), "patterns": count, "window": [width, height] }));
    } else {
        println!("{folder}: {count} patterns of {width} × {height} pixels; photograph them in this order");
    }
    let apart = patterns.outputs.iter().map(|(output, _)| &rig.outputs[*output]).filter(|output| !output.shown);
    for output in apart {
        eprintln!("cupola: the patterns of {} are for its own window or monitor", output.name);
    }
    Ok(ExitCode::SUCCESS)
}
