//! Keys of a rig for its views: arrangement, resolution, filter and number.

use glam::DVec3;

/// Choice of the views.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum ViewMethod {
    /// The cheaper one of the others.
    Auto,
    /// Faces of one rotated cube, shared by all outputs.
    Cube,
    /// One tight off-axis view for each output.
    Single,
}

/// Choice of the views.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Views {
    /// Family of views.
    pub method: ViewMethod,
    /// Factor on the resolution of the views in each direction, 0.1…8; 1 = as many texels as output
    /// pixels.
    pub quality: f64,
    /// Filter with which the correction samples the views.
    pub filter: Filter,
    /// Resource that the planner saves if it cannot save both.
    pub favour: Favour,
    /// Resolution of a domemaster's views.
    pub resolution: Resolution,
    /// Directions of the views, in viewer axes, of any lengths. Each view shows the directions
    /// whose scalar product with its vector is the greatest. Empty = as `method` determines.
    pub cells: Vec<DVec3>,
    /// Choice of the off-screen images that are drawn once per view.
    pub duplicate: Duplicate,
    /// Number of frames that a program draws of a view before the one that counts, if the views are
    /// drawn in turn. Effects that mix it with earlier frames then use frames of the same view.
    /// 0…60.
    pub warm_up: usize,
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
            warm_up: 0,
        }
    }
}

/// Pixels of a domemaster that get a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Resolution {
    /// Nominal pixels: aperture divided by diameter, in every direction.
    Nominal,
    /// All pixels. They are narrower along the circles around the centre: there the picture is
    /// sharper by θ / sin θ, at the angle θ from the centre.
    Full,
}

/// Choice of the program's off-screen images that are drawn once per view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Duplicate {
    /// Images that are found to show the scene on its way to the window.
    Auto,
    /// No images: their contents are shown flat.
    Never,
    /// All images to which perspective draws are issued, whatever their shape and use.
    Always,
    /// No images: each frame of the program draws one view, in the program's own images, until all
    /// are complete.
    InTurn,
}

/// Filter with which the correction samples the views: a kernel, at the middle of an output's pixel
/// or at four places of it (a rotated grid), whose mean is shown.
///
/// A sharper filter than bilinear is worth its time only with anti-aliased views, and four places
/// only with `quality` above 1.
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

    /// True if the kernel is that of Catmull and Rom.
    pub fn is_cubic(self) -> bool {
        matches!(self, Self::CatmullRom | Self::CatmullRom4)
    }

    /// True if four places of a pixel are sampled.
    pub fn has_four_places(self) -> bool {
        matches!(self, Self::Bilinear4 | Self::CatmullRom4)
    }
}

/// Resource that the planner saves: each view costs the program's draws once more, and each texel
/// costs shading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Favour {
    /// As for a program of about a thousand draws in a frame.
    Balanced,
    /// Fewer views: for programs of many draws.
    Processor,
    /// Fewer texels: for programs of few draws and costly shading.
    Graphics,
    /// As for a program with this number of draws in a frame. `Balanced` becomes this once the
    /// number is known. Rig files have no word for it.
    Draws(u32),
}
