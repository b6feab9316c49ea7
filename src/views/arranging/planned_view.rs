//! Planned views, which have no tile yet, and the cost of an arrangement of them.

use crate::geom::PictureMap;
use crate::views::arranging::cost::PlannerOptions;
use crate::views::fitting::axes::OrientedView;
use crate::views::fitting::fit::Fit;
use glam::DMat3;

/// A view before it has a tile and its final size.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct PlannedView {
    /// Name in messages.
    pub name: String,
    /// Viewer axes → view axes.
    pub rotation: DMat3,
    /// The sampled part and its resolution.
    pub fit: Fit,
    /// Size of the sampled part in pixels, one texel each at quality 1.
    pub exact: Option<(u32, u32)>,
    /// True if the view is drawn with the program's own projection.
    pub program_lens: bool,
    /// Map by which vertices are projected directly to the output's pixels.
    pub curved: Option<PictureMap>,
    /// Distance of the eye to the right of the viewer's position, metres.
    pub eye: f64,
    /// Indices of the outputs that sample the view.
    pub outputs: Vec<usize>,
}

/// The views of a rig, and remarks for the user.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Arrangement {
    /// The views, in order of precedence.
    pub views: Vec<PlannedView>,
    /// Remarks: what was left out, and why.
    pub notes: Vec<String>,
}

impl Arrangement {
    /// Returns the cost in texels.
    pub fn cost(&self, options: &PlannerOptions) -> f64 {
        cost(options, &self.views)
    }
}

/// Returns the cost of views together, in texels.
pub(crate) fn cost(options: &PlannerOptions, views: &[PlannedView]) -> f64 {
    views.iter().map(|view| view.fit.texels() + options.texels_per_draw_set()).sum()
}

impl From<OrientedView> for PlannedView {
    fn from(oriented: OrientedView) -> Self {
        Self {
            name: String::new(),
            rotation: oriented.rotation,
            fit: oriented.fit,
            exact: None,
            program_lens: false,
            curved: None,
            eye: 0.0,
            outputs: Vec::new(),
        }
    }
}
