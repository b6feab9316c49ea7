//! The only view of a rig with content: the program's window.

use crate::views::arranging::planned_view::PlannedView;
use crate::views::fitting::fit::Fit;
use crate::views::sampling::output_map::UNIT_FRUSTUM;
use crate::views::view_plan::Request;
use glam::{DMat3, DVec2};

/// Returns the view of the program's window, for this number of outputs.
pub(in crate::views) fn window(request: &Request, outputs: usize) -> PlannedView {
    let (width, height) = request.window;
    let density = DVec2::new(f64::from(width), f64::from(height)) / 2.0;
    PlannedView {
        name: "content".to_owned(),
        rotation: DMat3::IDENTITY,
        fit: Fit { extent: UNIT_FRUSTUM, density },
        exact: Some(request.window),
        program_lens: true,
        curved: None,
        eye: 0.0,
        outputs: (0..outputs).collect(),
    }
}
