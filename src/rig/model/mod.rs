//! The rig: its parts and their positions, in radians and metres.
//!
//! Each part has its own file. `camera`, `viewer`, `method` and `content` also have a form for the
//! command line, which is read there.

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

/// Contents of a rig file.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Rig {
    /// Name: the preset's, or the file's.
    pub name: String,
    /// True if Cupola leaves the program's own framebuffer alone (preset `identity`); `outputs` is
    /// empty then.
    pub passthrough: bool,
    /// The dome: the reference of domemasters and of angles of ramps, and the screen if `screen`
    /// names no other.
    pub dome: Dome,
    /// Screen on which the light falls; `None` = the dome itself. [`Rig::surface`] returns either.
    pub screen: Option<crate::geom::Screen>,
    /// Point from which the picture is right, and its direction.
    pub viewer: Viewer,
    /// Adaptation of the program's own camera.
    pub camera: Camera,
    /// Already projected picture in the program's window; `None` = the program is drawn in views.
    pub content: Option<Content>,
    /// Choice of the views.
    pub views: Views,
    /// Panel on which flat (orthographic) drawing appears.
    pub overlay: Overlay,
    /// How the program's windows are swapped.
    pub window: WindowSwaps,
    /// Outputs that the window shows.
    pub outputs: Vec<Output>,
    /// Outputs without a place in the window: they are drawn for readers of published frames. Each
    /// has a `size`.
    pub beside: Vec<Output>,
}

impl Rig {
    /// Rig with all outputs in `outputs`, those beside the window last, as they are planned.
    pub fn with_all_outputs(&self) -> Cow<'_, Self> {
        if self.beside.is_empty() {
            return Cow::Borrowed(self);
        }
        let mut all = self.clone();
        all.outputs.append(&mut all.beside);
        Cow::Owned(all)
    }

    /// True if the views that are planned for `other` are those of this rig: both differ only in the
    /// light of their outputs and in the program's camera.
    pub fn has_views_of(&self, other: &Self) -> bool {
        let mut other = other.clone();
        let (own, others) =
            (self.outputs.iter().chain(&self.beside), other.outputs.iter_mut().chain(&mut other.beside));
        for (own, other) in own.zip(others) {
            (other.blend, other.black) = (own.blend.clone(), own.black.clone());
        }
        other.camera = self.camera;
        other.name.clone_from(&self.name);
        *self == other
    }

    /// True if the rig itself requests published pictures.
    pub fn publishes(&self) -> bool {
        !self.beside.is_empty() || self.outputs.iter().any(|output| output.publish)
    }

    /// Indices in [`Rig::outputs`] of the outputs whose pictures are published, if any are: all
    /// outputs if none is chosen. The pictures of outputs beside the window follow them.
    pub fn published_outputs(&self) -> impl Iterator<Item = usize> + '_ {
        let all = !self.publishes();
        self.outputs
            .iter()
            .enumerate()
            .filter(move |(_, output)| output.here && (all || output.publish))
            .map(|(index, _)| index)
    }

    /// Returns the same rig with one more output beside the window: a domemaster of `side` × `side`
    /// pixels, which shows what the dome covers. Its name is `domemaster`, followed by a number if
    /// an output has that name.
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

    /// Rig without mirrored outputs.
    pub fn upright(&self) -> Cow<'_, Self> {
        if self.outputs.iter().all(|output| output.flip.is_none()) {
            return Cow::Borrowed(self);
        }
        let mut upright = self.clone();
        upright.outputs.iter_mut().for_each(|output| output.flip = Flip::default());
        Cow::Owned(upright)
    }
}

/// How the program's windows are swapped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct WindowSwaps {
    /// Least number of refreshes of the display between two swaps, 0…16; 0 = a swap does not wait.
    /// `None` = as the program asks.
    pub interval: Option<u32>,
    /// Swap group of the driver (`GLX_NV_swap_group`) that the windows join, from 1. Windows of
    /// Vulkan join the present barrier, which has no number.
    pub group: Option<u32>,
    /// Barrier that this group is bound to, from 1.
    pub barrier: Option<u32>,
}

/// Position of an output's own window.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnWindow {
    /// X screen, such as `:0.1`; `None` = that of the program.
    pub display: Option<String>,
    /// Name of the monitor that it fills, as in `xrandr`.
    pub monitor: Option<String>,
    /// True if it fills the screen.
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

/// Point from which the picture on the screen is right, and its direction.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Viewer {
    /// Position relative to the dome's centre, metres.
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
    /// Shift of the eye along the program's camera axes, in the program's units.
    pub shift: DVec3,
    /// Number of the program's units in a metre of the dome, > 0. It determines the distance of the
    /// eyes of stereo outputs in the program.
    pub units_per_meter: f64,
    /// Angle by which the camera is turned right, radians.
    pub yaw: f64,
    /// Angle by which the camera is turned up, radians.
    pub pitch: f64,
    /// Angle by which the camera is rolled clockwise, radians.
    pub roll: f64,
    /// Opening of the program's own lens, horizontal and vertical, radians, less than π: for draws
    /// whose matrices do not contain it.
    pub lens: Option<[f64; 2]>,
    /// True if answers to the program's questions about its projection matrix are so wide that
    /// culling planes made of them leave out nothing that views can show.
    pub answer_wide: bool,
}

/// Panel on which flat drawing appears: a window in front of the viewer, with the angle `width` and
/// the window's aspect.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Overlay {
    /// Direction of its centre, right-positive, radians from the viewer's forward direction.
    pub yaw: f64,
    /// Direction of its centre, up-positive, radians.
    pub pitch: f64,
    /// Angle of its width, radians, 0 < width < π.
    pub width: f64,
}

/// A picture that one device shows.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Output {
    /// Name, unique in the rig; letters, digits, `-`, `_`, `.`.
    pub name: String,
    /// Kind.
    pub kind: OutputKind,
    /// Method that makes its picture from the views.
    pub method: Method,
    /// Resolution of its own (width, height in pixels), used off screen; `None` = that of its
    /// rectangle in the window.
    pub size: Option<(u32, u32)>,
    /// Rectangle in the window; `None` = a cell of the planner's grid.
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
    /// True if its finished pictures are published. If no output sets it, all outputs are published
    /// once publishing is requested.
    #[serde(skip)]
    pub publish: bool,
    /// True if it has a place in the window.
    #[serde(skip)]
    pub shown: bool,
    /// A window of its own, which `cupola run` opens for it; `shown` is false then.
    #[serde(skip)]
    pub own_window: Option<OwnWindow>,
    /// Machine that shows it, if there are several.
    #[serde(skip)]
    pub node: Option<Node>,
    /// True if this machine shows it. Outputs of other machines are planned as well, so that all
    /// machines have the same views.
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
    /// A picture of all directions from the dome's centre, in another projection than a
    /// domemaster's.
    Panorama {
        /// Projection of the picture.
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
        /// Opening, lens shift included (tangents).
        frustum: crate::geom::Frustum,
    },
    /// A projector whose lens is no ideal pinhole, or that stands before a mirror.
    Optics {
        /// Position, lens and mirror, in metres from the dome's centre.
        optics: Box<crate::geom::Optics>,
        /// Degree to which small pixels are dimmed to the light of the larger ones, 0…1.
        even_light: f64,
    },
    /// Calibration of each pixel from a file.
    Mesh(std::sync::Arc<Calibration>),
    /// A flat perspective picture as the viewer would see it through a window.
    Perspective {
        /// Aim relative to the viewer, radians: right-positive, up-positive, clockwise-positive.
        angles: [f64; 3],
        /// Opening; `None` = the program's own lens, whatever it is (preset `identity-captured`).
        frustum: Option<crate::geom::Frustum>,
    },
}

impl OutputKind {
    /// True if the output lights the screen from a position of its own.
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
