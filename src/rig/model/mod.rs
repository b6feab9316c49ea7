//! The rig: what stands where, in radians and metres.
//!
//! The parts are files of their own; `camera`, `viewer`, `method` and `content` can also be written
//! on a command line, and are read from there.

pub mod black;
pub mod blend;
pub mod calibration;
pub mod camera;
pub mod content;
pub mod flip;
pub mod method;
pub mod nodes;
pub mod overrides;
pub mod response;
pub mod surface;
pub mod viewer;
pub mod views;

use crate::geom::PixelRect;
use crate::rig::{Black, Blend, Calibration, Content, Flip, Method, Node, Views};
use glam::DVec3;
use std::borrow::Cow;
use std::path::PathBuf;

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
    /// Screen on which the light falls; `None` = the dome itself. [`Rig::surface`] returns either.
    pub screen: Option<crate::geom::Screen>,
    /// The correct point of view.
    pub viewer: Viewer,
    /// Adaptation of the program's own camera.
    pub camera: Camera,
    /// The program's window is already projected; `None` = the program is drawn in views.
    pub content: Option<Content>,
    /// Choice of the views.
    pub views: Views,
    /// Panel on which flat (orthographic) drawing appears.
    pub overlay: Overlay,
    /// The outputs that the window shows.
    pub outputs: Vec<Output>,
    /// Outputs that have no place in the window: they are drawn for those who read published
    /// frames. Each has a `size`.
    pub beside: Vec<Output>,
}

impl Rig {
    /// The rig with all outputs in `outputs`, those beside the window last: what is planned.
    pub fn with_all_outputs(&self) -> Cow<'_, Self> {
        if self.beside.is_empty() {
            return Cow::Borrowed(self);
        }
        let mut all = self.clone();
        all.outputs.append(&mut all.beside);
        Cow::Owned(all)
    }

    /// True if the rig itself asks for published pictures.
    pub fn publishes(&self) -> bool {
        !self.beside.is_empty() || self.outputs.iter().any(|output| output.publish)
    }

    /// The outputs whose pictures are published if some are, by their place in [`Rig::outputs`]:
    /// all where none is chosen. Those beside the window follow them.
    pub fn published_outputs(&self) -> impl Iterator<Item = usize> + '_ {
        let all = !self.publishes();
        self.outputs
            .iter()
            .enumerate()
            .filter(move |(_, output)| output.here && (all || output.publish))
            .map(|(index, _)| index)
    }

    /// The same rig with one more output beside the window: a domemaster of `side` × `side` pixels,
    /// which shows what the dome covers. Its name is `domemaster`, with a number where an output
    /// has that name.
    pub fn with_domemaster(mut self, side: u32) -> Self {
        let is_taken = |name: &str| self.outputs.iter().chain(&self.beside).any(|output| output.name == name);
        let names = std::iter::once("domemaster".to_owned()).chain((2..).map(|number| format!("domemaster-{number}")));
        let Some(name) = names.into_iter().find(|name| !is_taken(name)) else { return self };
        self.beside.push(Output {
            name,
            kind: OutputKind::Domemaster { aperture: self.dome.coverage, tilt: self.dome.tilt },
            method: Method::Fragment,
            size: Some((side, side)),
            window: None,
            blend: Blend::default(),
            mask: None,
            black: None,
            eye: 0.0,
            flip: Flip::default(),
            publish: true,
            shown: false,
            own_window: None,
            node: None,
            here: true,
        });
        self
    }

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

/// Where the window of an output is that has one of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnWindow {
    /// X screen, such as `:0.1`; `None` = that of the program.
    pub display: Option<String>,
    /// Monitor that it fills, as `xrandr` calls it.
    pub monitor: Option<String>,
    /// It fills the screen.
    pub fullscreen: bool,
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
    /// Answers to the program's questions about its projection matrix are so wide that planes made
    /// of them leave out nothing that views can show.
    pub answer_wide: bool,
}

/// Panel on which flat drawing appears: a window in front of the viewer, as wide as `width` says
/// and with the window's aspect.
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
    /// Its finished pictures are published. Where no output says so, all are, if publishing is
    /// asked for.
    #[serde(skip)]
    pub publish: bool,
    /// It has a place in the window.
    #[serde(skip)]
    pub shown: bool,
    /// A window of its own, which `cupola run` opens for it; `shown` is false then.
    #[serde(skip)]
    pub own_window: Option<OwnWindow>,
    /// The machine that shows it, where there are several.
    #[serde(skip)]
    pub node: Option<Node>,
    /// This machine shows it. Others are planned as well, so that all machines have the same views.
    #[serde(skip)]
    pub here: bool,
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
        /// Position of its lens, metres from the dome's centre.
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
    /// True if the output lights the screen from a place of its own.
    pub fn is_projector(&self) -> bool {
        matches!(self, Self::Projector { .. } | Self::Optics { .. })
    }

    /// True if the picture is a circle inscribed in the output, black around it.
    pub fn is_circular(&self) -> bool {
        match self {
            Self::Domemaster { .. } => true,
            Self::Panorama { panorama, .. } => panorama.is_circular(),
            _ => false,
        }
    }
}
