//! Key figures of a plan, as text and as JSON.

use crate::check::{describe, words};
use cupola::blend;
use cupola::correct::{self, Approximation, Plan};
use cupola::rig::Rig;
use cupola::views::{self, Report, Request, ViewPlan};
use glam::DVec3;
use serde_json::{Value, json};
use std::fmt;

/// Number of pixels in each output that are examined for the lowest resolution.
const SURVEYED: u32 = 1 << 18;

/// Key figures of a plan.
pub struct Figures {
    /// Name of the rig.
    pub rig: String,
    window: (u32, u32),
    /// Report of the library.
    pub report: Report,
    /// Number of texels of each view that no output samples.
    pub hidden: Vec<u64>,
    /// Lowest number of texels per pixel found; `None` if only the program's own lens is used.
    pub least: Option<f64>,
    /// Number of directions that were examined for it.
    pub directions: u64,
    seconds: f64,
    /// Places where the light must change abruptly between outputs: direction in the viewer's axes,
    /// and description.
    pub jumps: Vec<(DVec3, String)>,
    /// Outputs whose maps are interpolated.
    approximations: Vec<(String, Approximation)>,
}

impl Figures {
    /// The figures of `plan`, which was made for `rig` and `request` in `seconds`.
    pub fn of(rig: &Rig, request: &Request, plan: &Plan, seconds: f64) -> Self {
        let report = views::report(&plan.views, rig, &request.output_sizes);
        let hidden =
            correct::unsampled_areas(plan).iter().map(|tiles| tiles.iter().map(views::Tile::area).sum()).collect();
        let (mut least, mut directions) = (f64::INFINITY, 0);
        views::survey(&plan.views, rig, &request.output_sizes, SURVEYED, |seen| {
            if let Some(density) = seen.texels_per_pixel {
                least = least.min(density);
                directions += 1;
            }
        });
        let least = (directions > 0).then_some(least);
        // A rig whose weights cannot be computed has no plan.
        let crossings = blend::crossings(rig, &request.output_sizes).unwrap_or_default();
        let viewer = rig.viewer_pose();
        let direction = |point: DVec3| viewer.point_to_local(point).normalize_or_zero();
        let jumps = crossings.iter().map(|crossing| (direction(crossing.point), words::jump(rig, crossing))).collect();
        let approximations = plan.passes.iter().filter_map(|pass| Some((pass.name.clone(), pass.approximation()?)));
        Self {
            rig: rig.name.clone(),
            window: request.window,
            report,
            hidden,
            least,
            directions,
            seconds,
            jumps,
            approximations: approximations.collect(),
        }
    }

    /// Number of texels drawn for each pixel, without those that no output samples.
    pub fn sampled_per_pixel(&self) -> f64 {
        let sampled = self.report.view_texels - self.hidden.iter().sum::<u64>();
        if self.report.output_pixels > 0 { sampled as f64 / self.report.output_pixels as f64 } else { 0.0 }
    }

    /// The figures as JSON.
    pub fn json(&self, plan: &ViewPlan) -> Value {
        let views: Vec<Value> = plan
            .views
            .iter()
            .zip(&self.report.views)
            .zip(&self.hidden)
            .map(|((view, report), hidden)| {
                let mut view = describe::view(view);
                view["hidden_texels"] = json!(hidden);
                view["coverage"] = json!(report.coverage);
                view
            })
            .collect();
        json!({
            "rig": self.rig,
            "window": [self.window.0, self.window.1],
            "views": views,
            "view_texels": self.report.view_texels,
            "hidden_texels": self.hidden.iter().sum::<u64>(),
            "output_pixels": self.report.output_pixels,
            "texels_per_pixel": self.report.texels_per_pixel,
            "sampled_texels_per_pixel": self.sampled_per_pixel(),
            "least_texels_per_pixel": self.least,
            "directions": self.directions,
            "atlas": [self.report.atlas.0, self.report.atlas.1],
            "atlas_use": self.report.atlas_use,
            "milliseconds": 1e3 * self.seconds,
            "interpolated": self.approximations.iter().map(|(output, how)| match how {
                Approximation::Table { step, error } => json!({ "output": output, "step": step, "error_pixels": error }),
                Approximation::Triangles { count, error } => {
                    json!({ "output": output, "triangles": count, "error_pixels": error })
                }
            }).collect::<Vec<_>>(),
            "notes": self.report.notes,
            "jumps": self.jumps.iter().map(|(direction, words)| {
                json!({ "direction": direction.to_array(), "words": words })
            }).collect::<Vec<_>>(),
        })
    }
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let report = &self.report;
        let millions = |texels: u64| texels as f64 / 1e6;
        let (width, height) = self.window;
        writeln!(f, "{} in a window of {width} × {height} pixels", self.rig)?;
        for (view, hidden) in report.views.iter().zip(&self.hidden) {
            write!(f, "  {:<16} {:>5} × {:<5} ", view.name, view.width, view.height)?;
            if view.program_lens {
                write!(f, "as the program draws it")?;
            } else {
                let part = 100.0 * *hidden as f64 / (f64::from(view.width) * f64::from(view.height));
                write!(f, "{:5.1}° × {:5.1}°, {part:4.1} % hidden", view.horizontal_degrees, view.vertical_degrees)?;
            }
            for share in &view.coverage {
                write!(f, "  {} {:.1} %", share.output, 100.0 * share.share)?;
            }
            writeln!(f)?;
        }
        writeln!(
            f,
            "drawn      {:.2} million texels for {:.2} million pixels: {:.3} each, {:.3} without the hidden ones",
            millions(report.view_texels),
            millions(report.output_pixels),
            report.texels_per_pixel,
            self.sampled_per_pixel()
        )?;
        if let Some(least) = self.least {
            writeln!(f, "sharpness  at least {least:.3} texels per pixel, in {} directions", self.directions)?;
        }
        for (output, how) in &self.approximations {
            match how {
                Approximation::Table { step, error } => {
                    writeln!(f, "method     {output}: a table every {step} pixels, at most {error:.3} pixels wrong")?;
                }
                Approximation::Triangles { count, error } => {
                    writeln!(f, "method     {output}: {count} triangles, at most {error:.3} pixels wrong")?;
                }
            }
        }
        let (width, height) = report.atlas;
        writeln!(f, "atlas      {width} × {height} texels, {:.0} % used", 100.0 * report.atlas_use)?;
        writeln!(f, "planned    in {:.0} ms", 1e3 * self.seconds)?;
        report.notes.iter().try_for_each(|note| writeln!(f, "note       {note}"))?;
        self.jumps.iter().try_for_each(|(_, words)| writeln!(f, "jump       {words}"))
    }
}
