//! Keys of a rig for its views: their arrangement, resolution, filter and number.

use glam::DVec3;

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
    /// Family of views.
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
    /// Choice of the off-screen images that are drawn once per view.
    pub duplicate: Duplicate,
    /// Frames that a program draws of a view before the one that counts, where the views are drawn
    /// in turn: what it mixes with earlier frames is then that view's. 0…60.
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

/// Size of a domemaster's pixel that gets a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Resolution {
    /// Its nominal pixel: aperture over diameter, in every direction.
    Nominal,
    /// Each of its pixels, which are narrower along the circles around its centre: θ / sin θ as
    /// sharp there, at the angle θ from the centre.
    Full,
}

/// Choice of the images, among those that a program draws off screen, that are drawn once per view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Duplicate {
    /// Those that are seen to be the scene's, on their way to the window.
    Auto,
    /// None: what is shown of them is flat.
    Never,
    /// All that perspective draws reach, whatever their shape and use.
    Always,
    /// None: each frame of the program draws one view, in the program's own images, until all are
    /// complete.
    InTurn,
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

    /// True if the kernel is Catmull-Rom's.
    pub fn is_cubic(self) -> bool {
        matches!(self, Self::CatmullRom | Self::CatmullRom4)
    }

    /// True if four places of a pixel are sampled.
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
