//! Cost of a plan, as text and as JSON.

use crate::rig::Rig;
use crate::views::reporting::answers::Answers;
use crate::views::sampling::output_map::OutputMap;
use crate::views::view_plan::{Tile, ViewPlan};
use glam::DVec2;
use serde::Serialize;
use std::fmt;

/// Greatest number of pixels of an output, in each direction, from which shares are computed.
const GRID: u32 = 256;

/// One view of a [`Report`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ViewReport {
    /// Name in messages.
    pub name: String,
    /// Width of the tile in texels.
    pub width: u32,
    /// Height of the tile in texels.
    pub height: u32,
    /// Horizontal opening, degrees.
    pub horizontal_degrees: f64,
    /// Vertical opening, degrees.
    pub vertical_degrees: f64,
    /// True if the view is drawn with the program's own lens; the openings have no meaning then.
    pub program_lens: bool,
    /// Part of the output's lit pixels that sample this view, for each output.
    pub coverage: Vec<OutputShare>,
}

/// Share of an output that a view shows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutputShare {
    /// The output's name.
    pub output: String,
    /// Part of its lit pixels, 0…1; exact to about 1/256 of the picture's width.
    pub share: f64,
}

/// Cost of a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The views, in order of precedence.
    pub views: Vec<ViewReport>,
    /// Number of texels of all views.
    pub view_texels: u64,
    /// Number of pixels of all outputs that can show something: the circle of a domemaster, every
    /// pixel of the others.
    pub output_pixels: u64,
    /// `view_texels / output_pixels`; 0 without outputs.
    pub texels_per_pixel: f64,
    /// Width and height of the atlas in texels.
    pub atlas: (u32, u32),
    /// Part of the atlas that tiles fill, the panel and the program's own picture included.
    pub atlas_use: f64,
    /// Remarks: what was left out or scaled down, and why.
    pub notes: Vec<String>,
}

/// Returns the cost of `plan`, made for `rig` with outputs of `sizes` pixels. Sizes beyond the
/// rig's outputs are ignored.
pub fn report(plan: &ViewPlan, rig: &Rig, sizes: &[(u32, u32)]) -> Report {
    let outputs: Vec<_> =
        rig.outputs.iter().zip(sizes).enumerate().filter(|(_, (_, size))| size.0 > 0 && size.1 > 0).collect();
    let mut coverage: Vec<Vec<OutputShare>> = vec![Vec::new(); plan.views.len()];
    let seen = rig.around_content();
    for (&(index, (output, &size)), sampled) in outputs.iter().zip(&plan.output_views) {
        let Ok(output_map) = OutputMap::new(&seen, index, size) else { continue };
        let shares = shares(&Answers::new(plan, rig, index), &output_map, sampled);
        for (&view, share) in sampled.iter().zip(shares) {
            coverage[view].push(OutputShare { output: output.name.clone(), share });
        }
    }
    let degrees = |low: f64, high: f64| (high.atan() - low.atan()).to_degrees();
    let views: Vec<ViewReport> = plan
        .views
        .iter()
        .zip(coverage)
        .map(|(view, coverage)| ViewReport {
            name: view.name.clone(),
            width: view.tile.width,
            height: view.tile.height,
            horizontal_degrees: degrees(view.frustum.left, view.frustum.right),
            vertical_degrees: degrees(view.frustum.bottom, view.frustum.top),
            program_lens: view.program_lens,
            coverage,
        })
        .collect();
    let area = |width: u32, height: u32| u64::from(width) * u64::from(height);
    let view_texels: u64 = views.iter().map(|view| area(view.width, view.height)).sum();
    let output_pixels: u64 = outputs
        .iter()
        .map(|(_, (output, size))| match &output.kind {
            kind if kind.is_circular() => {
                let diameter = f64::from(size.0.min(size.1));
                (0.25 * std::f64::consts::PI * diameter * diameter).round() as u64
            }
            _ => area(size.0, size.1),
        })
        .sum();
    let others = plan.primary.iter().chain(plan.panel.as_ref().map(|panel| &panel.tile));
    let used = view_texels + others.map(Tile::area).sum::<u64>();
    let part = |of: u64, whole: u64| if whole > 0 { of as f64 / whole as f64 } else { 0.0 };
    Report {
        views,
        view_texels,
        output_pixels,
        texels_per_pixel: part(view_texels, output_pixels),
        atlas: plan.atlas,
        atlas_use: part(used, area(plan.atlas.0, plan.atlas.1)),
        notes: plan.notes.clone(),
    }
}

/// Returns, for each of the views `sampled`, the part of the lit pixels that it serves.
fn shares(answers: &Answers, output_map: &OutputMap, sampled: &[usize]) -> Vec<f64> {
    let mut counts = vec![0u32; sampled.len()];
    let mut lit = 0u32;
    let (columns, rows) = (output_map.size.0.min(GRID), output_map.size.1.min(GRID));
    let step =
        DVec2::new(f64::from(output_map.size.0) / f64::from(columns), f64::from(output_map.size.1) / f64::from(rows));
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let at = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5) * step;
        let Some(sample) = output_map.sample(at) else { continue };
        lit += 1;
        let answering = answers.view(&sample);
        if let Some(index) = sampled.iter().position(|view| Some(*view) == answering) {
            counts[index] += 1;
        }
    }
    counts.into_iter().map(|count| f64::from(count) / f64::from(lit.max(1))).collect()
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let millions = |texels: u64| texels as f64 / 1e6;
        writeln!(
            f,
            "{} {}, {:.2} million texels for {:.2} million output pixels ({:.2} each), atlas {}×{} ({:.0} % used)",
            self.views.len(),
            if self.views.len() == 1 { "view" } else { "views" },
            millions(self.view_texels),
            millions(self.output_pixels),
            self.texels_per_pixel,
            self.atlas.0,
            self.atlas.1,
            100.0 * self.atlas_use
        )?;
        for view in &self.views {
            write!(f, "  {:<16} {:>5}×{:<5} ", view.name, view.width, view.height)?;
            if view.program_lens {
                write!(f, "as the program draws it")?;
            } else {
                write!(f, "{:5.1}° × {:5.1}°", view.horizontal_degrees, view.vertical_degrees)?;
            }
            for share in &view.coverage {
                write!(f, "  {} {:.1} %", share.output, 100.0 * share.share)?;
            }
            writeln!(f)?;
        }
        self.notes.iter().try_for_each(|note| writeln!(f, "  {note}"))
    }
}
