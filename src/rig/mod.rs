//! What stands where: the dome, the viewer, the program's camera, the outputs.
//!
//! Types here are validated and in radians where they are angles. [`load`] and [`parse`] read
//! them from TOML in metres and degrees; `docs/rig-file.md` describes the file key by key.
//!
//! The way of a rig: `reader` takes typed values out of the parsed TOML and remembers
//! their lines, `schema` knows the keys and single values' ranges, `validate` knows what
//! values must satisfy together. All of them add to one list of problems, so that one look at
//! the message mends the whole file.

mod black;
mod blend;
mod calibration;
mod camera;
mod flip;
mod layout;
mod mask;
mod method;
mod one_line;
mod presets;
mod problems;
mod reader;
mod response;
mod schema;
mod surface;
mod validate;
mod viewer;

use crate::error::{Error, ErrorKind, Result};
use crate::geom::PixelRect;
use glam::DVec3;
use std::borrow::Cow;
use std::io::Read;
use std::path::{Path, PathBuf};

pub use crate::formats::Levels;
pub use black::{Black, BlackValues};
pub use blend::{AngleRamp, Blend, DomeAngle, RampShape};
pub use calibration::{Calibration, CalibrationValues};
pub use flip::Flip;
pub use mask::read_mask;
pub use method::{Divider, Method};
pub use presets::{Preset, presets};
pub use response::{RESPONSE_STEPS, Response, Transfer};

/// Longest rig file, bytes.
const LONGEST_RIG: u64 = 1 << 20;

/// Everything a rig file says.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Rig {
    /// Name: the preset's, or the file's.
    pub name: String,
    /// The program's own framebuffer is left alone (preset `identity`); `outputs` is empty then.
    pub passthrough: bool,
    /// The dome: what domemasters and angles of ramps are measured from, and the screen where
    /// `screen` says no other.
    pub dome: Dome,
    /// What light falls on; `None` = the dome itself. [`Rig::surface`] has either.
    pub screen: Option<crate::geom::Screen>,
    /// The correct point of view.
    pub viewer: Viewer,
    /// Adaptation of the program's own camera.
    pub camera: Camera,
    /// Choice of the views.
    pub views: Views,
    /// Where flat (orthographic) drawing appears.
    pub overlay: Overlay,
    /// The outputs.
    pub outputs: Vec<Output>,
}

impl Rig {
    /// The rig whose outputs are not mirrored.
    pub fn upright(&self) -> Cow<'_, Self> {
        if self.outputs.iter().all(|output| output.flip.is_none()) {
            return Cow::Borrowed(self);
        }
        let mut upright = self.clone();
        upright.outputs.iter_mut().for_each(|output| output.flip = Flip::default());
        Cow::Owned(upright)
    }
}

/// A spherical dome, centred at the origin.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Dome {
    /// Radius, metres, > 0.
    pub radius: f64,
    /// Angle from straight up to the dome's pole, towards the front, radians: 0 = zenith up, π/2 =
    /// pole straight ahead.
    pub tilt: f64,
    /// Opening angle of the cap that is screen, radians, 0 < coverage ≤ 2π.
    pub coverage: f64,
}

/// The correct point of view.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Viewer {
    /// Metres from the dome's centre.
    pub position: DVec3,
    /// Right-positive, radians.
    pub yaw: f64,
    /// Up-positive, radians.
    pub pitch: f64,
    /// Clockwise-positive as the viewer sees it, radians.
    pub roll: f64,
}

/// Adaptation of the program's own camera.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Camera {
    /// Factor on the tangents of every direction that the program draws, > 0.
    pub zoom: f64,
    /// Motion of the eye along the program's camera axes, in the program's units.
    pub shift: DVec3,
    /// The program's units in a metre of the dome, > 0: how far apart the eyes of stereo outputs
    /// are for the program.
    pub units_per_meter: f64,
    /// The camera is turned right by this, radians.
    pub yaw: f64,
    /// The camera is turned up by this, radians.
    pub pitch: f64,
    /// The camera is rolled clockwise by this, radians.
    pub roll: f64,
    /// The opening of the program's own lens, horizontal and vertical, radians, less than π: for
    /// draws of which the program's matrices tell none.
    pub lens: Option<[f64; 2]>,
}

/// Choice of views for outputs that do not say so themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum ViewMethod {
    /// The cheaper of the others.
    Auto,
    /// Faces of one rotated cube, shared by all outputs.
    Cube,
    /// One tight off-axis view for each output.
    Single,
}

/// Choice of the views.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Views {
    /// Which family of views.
    pub method: ViewMethod,
    /// Factor on the resolution of the views in each direction, 0.1…8; 1 = as many texels as output
    /// pixels.
    pub quality: f64,
    /// Filter with which the correction samples the views.
    pub filter: Filter,
    /// Resource that the planner saves where it cannot save both.
    pub favour: Favour,
    /// Resolution of a domemaster's views.
    pub resolution: Resolution,
    /// One view for each of these vectors, viewer axes, any lengths: it shows the directions with
    /// which the vector has the greatest scalar product. Empty = as `method` says.
    pub cells: Vec<DVec3>,
    /// Which pictures that a program draws off screen are drawn once per view.
    pub duplicate: Duplicate,
}

impl Default for Views {
    fn default() -> Self {
        Self {
            method: ViewMethod::Auto,
            quality: 1.0,
            filter: Filter::Bilinear,
            favour: Favour::Balanced,
            resolution: Resolution::Nominal,
            cells: Vec::new(),
            duplicate: Duplicate::Auto,
        }
    }
}

/// Size of a domemaster's pixel that gets a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Resolution {
    /// Its nominal pixel: aperture over diameter, in every direction.
    Nominal,
    /// Each of its pixels, which are narrower along the circles around its centre: θ / sin θ as
    /// sharp there, at the angle θ from the centre.
    Full,
}

/// Which pictures that a program draws off screen are drawn once per view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Duplicate {
    /// Those that are seen to be the scene's, on their way to the window.
    Auto,
    /// None: what is shown of them is flat.
    Never,
    /// All that perspective draws reach, whatever their shape and use.
    Always,
}

/// Filter with which the correction samples the views: a kernel, at the middle of an output's pixel
/// or at four places of it (rotated grid, a quarter of them at each), whose mean is shown.
///
/// Sharper than bilinear is worth its time only with anti-aliased views, four places with `quality`
/// above 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize)]
pub enum Filter {
    /// The 2×2 nearest texels.
    #[default]
    Bilinear,
    /// The 4×4 nearest texels, cubic (Catmull & Rom 1974).
    CatmullRom,
    /// Bilinear at four places.
    Bilinear4,
    /// Catmull-Rom at four places.
    CatmullRom4,
}

impl Filter {
    /// The four places of a pixel, in pixels from its middle: a grid that is rotated so that edges
    /// along rows and columns meet four different distances.
    pub const FOUR_PLACES: [[f64; 2]; 4] = [[0.125, 0.375], [-0.375, 0.125], [-0.125, -0.375], [0.375, -0.125]];

    /// Whether the kernel is Catmull-Rom's.
    pub fn is_cubic(self) -> bool {
        matches!(self, Self::CatmullRom | Self::CatmullRom4)
    }

    /// Whether four places of a pixel are sampled.
    pub fn has_four_places(self) -> bool {
        matches!(self, Self::Bilinear4 | Self::CatmullRom4)
    }
}

/// Resource that the planner saves: each view costs the program's draws once more, each texel costs
/// shading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Favour {
    /// As for a program of about a thousand draws in a frame.
    Balanced,
    /// Fewer views: for programs of many draws.
    Processor,
    /// Fewer texels: for programs of few draws and costly shading.
    Graphics,
    /// As for a program of so many draws in a frame; what `Balanced` becomes once they are known.
    /// No word of rig files.
    Draws(u32),
}

/// Where flat drawing appears: a window in front of the viewer, as wide as `width` says and with
/// the window's aspect.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Overlay {
    /// Direction of its centre, right-positive, radians from the viewer's forward direction.
    pub yaw: f64,
    /// Direction of its centre, up-positive, radians.
    pub pitch: f64,
    /// Angle that its width fills, radians, 0 < width < π.
    pub width: f64,
}

/// One picture that is presented.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Output {
    /// Name, unique in the rig; letters, digits, `-`, `_`, `.`.
    pub name: String,
    /// Kind.
    pub kind: OutputKind,
    /// Method that makes its picture from the views.
    pub method: Method,
    /// Its own resolution (width, height in pixels), used off screen; `None` = that of its place in
    /// the window.
    pub size: Option<(u32, u32)>,
    /// Its place in the window. `None` = the
    /// planner's grid.
    pub window: Option<PixelRect>,
    /// Blending into its neighbours.
    pub blend: Blend,
    /// A grey image that is multiplied in, absolute path.
    pub mask: Option<PathBuf>,
    /// Values for black, pixel by pixel.
    pub black: Option<std::sync::Arc<Black>>,
    /// Distance of the output's eye to the right of the viewer's position, metres (stereo).
    pub eye: f64,
    /// Mirroring of the finished picture; everything else refers to the picture before it.
    pub flip: Flip,
}

/// Kinds of outputs.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum OutputKind {
    /// An equidistant fisheye picture, circle inscribed and centred.
    Domemaster {
        /// Opening angle, radians, 0 < aperture ≤ 2π.
        aperture: f64,
        /// Angle from straight up to the circle's centre, towards the front, radians (π/2: the
        /// centre is straight ahead).
        tilt: f64,
    },
    /// A picture of all directions from the dome's centre, in other projections than a
    /// domemaster's.
    Panorama {
        /// Its projection.
        panorama: crate::geom::Panorama,
        /// Direction of its middle relative to the viewer, radians: right-positive, up-positive,
        /// clockwise-positive.
        angles: [f64; 3],
    },
    /// A pinhole projector, anywhere inside or outside the dome.
    Projector {
        /// Where its lens is, metres from the dome's centre.
        position: DVec3,
        /// Aim, radians: right-positive, up-positive, clockwise-positive.
        angles: [f64; 3],
        /// Its opening, lens shift included (tangents).
        frustum: crate::geom::Frustum,
    },
    /// A projector with a lens that is no ideal pinhole, or before a mirror.
    Optics {
        /// Place, lens and mirror, in metres from the dome's centre.
        optics: Box<crate::geom::Optics>,
        /// Part by which small pixels are dimmed for the larger ones' sake, 0…1.
        even_light: f64,
    },
    /// Calibration of each pixel from a file.
    Mesh(std::sync::Arc<Calibration>),
    /// A flat perspective picture as the viewer would see it through a window.
    Perspective {
        /// Aim relative to the viewer, radians: right-positive, up-positive, clockwise-positive.
        angles: [f64; 3],
        /// Its opening; `None` = the program's own lens, whatever it is (preset
        /// `identity-captured`).
        frustum: Option<crate::geom::Frustum>,
    },
}

impl OutputKind {
    /// Whether the output lights the screen from a place of its own.
    pub fn is_projector(&self) -> bool {
        matches!(self, Self::Projector { .. } | Self::Optics { .. })
    }

    /// Whether the picture is a circle inscribed in the output, black around it.
    pub fn is_circular(&self) -> bool {
        match self {
            Self::Domemaster { .. } => true,
            Self::Panorama { panorama, .. } => panorama.is_circular(),
            _ => false,
        }
    }
}

/// Reads a rig: `name_or_path` is a preset's name (see [`presets()`]) or else the path of a TOML
/// file.
///
/// A name that is also a file in the working directory means the preset; write `./name` for the
/// file.
///
/// # Errors
/// [`ErrorKind::Io`] if there is no such preset and no readable file, [`ErrorKind::InvalidRig`]
/// with every problem of the file (file, line, key, reason, remedy; one per line) if it is no valid
/// rig.
pub fn load(name_or_path: &str) -> Result<Rig> {
    if let Some(preset) = presets::find(name_or_path) {
        return parse(preset.text, preset.name, Path::new(""));
    }
    let path = Path::new(name_or_path);
    let mut text = Vec::new();
    // It may be a pipe, whose length is not known. `parse` refuses what is too long.
    std::fs::File::open(path)
        .and_then(|file| file.take(LONGEST_RIG + 1).read_to_end(&mut text))
        .map_err(|error| Error::new(ErrorKind::Io, unreadable(name_or_path, &error)))?;
    if text.len() as u64 > LONGEST_RIG {
        return Err(too_long(name_or_path));
    }
    let text = String::from_utf8(text).map_err(|error| {
        let line = 1 + error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count();
        let message = format!("{name_or_path}:{line}: the file is not UTF-8 text; save it as UTF-8");
        Error::new(ErrorKind::InvalidRig, message)
    })?;
    parse(&text, name_or_path, path.parent().unwrap_or(Path::new("")))
}

/// Reads a rig from TOML text. `file_name` stands in messages and, without directory and extension,
/// is the rig's name where the text gives none; paths in the text are relative to `directory`
/// (empty: the working directory).
///
/// # Errors
/// [`ErrorKind::InvalidRig`] with every problem of the text, as [`load`].
pub fn parse(text: &str, file_name: &str, directory: &Path) -> Result<Rig> {
    if text.len() as u64 > LONGEST_RIG {
        return Err(too_long(file_name));
    }
    let mut problems = problems::Problems::new(text);
    let rig = schema::read(text, file_name, directory, &mut problems);
    // Values that are missing because they were refused would only raise further, misleading
    // problems.
    if let Some(rig) = rig.as_ref().filter(|_| problems.is_empty()) {
        validate::check(rig, &mut problems);
    }
    match rig {
        Some(rig) if problems.is_empty() => Ok(rig),
        _ => Err(Error::new(ErrorKind::InvalidRig, problems.message(file_name))),
    }
}

fn too_long(file_name: &str) -> Error {
    Error::new(ErrorKind::InvalidRig, format!("{file_name}: is longer than {LONGEST_RIG} bytes; no rig is"))
}

/// Why `name_or_path` is neither a preset nor a readable file, and what was perhaps meant.
fn unreadable(name_or_path: &str, error: &std::io::Error) -> String {
    let names: Vec<&str> = presets().iter().map(|preset| preset.name).collect();
    let file = format!("the rig {name_or_path:?} is no preset, and reading it as a file failed: {error}");
    match problems::closest(name_or_path, &names) {
        Some(name) => format!("{file}; did you mean the preset `{name}`?"),
        None => format!("{file}; presets are {}", names.join(", ")),
    }
}
