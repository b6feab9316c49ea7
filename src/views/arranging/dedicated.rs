//! Dedicated views of outputs.

use crate::geom::pose;
use crate::rig::{OutputKind, Rig, ViewMethod};
use crate::views::arranging::cost::PlannerOptions;
use crate::views::arranging::partition::Task;
use crate::views::arranging::planned_view::{PlannedView, cost};
use crate::views::arranging::projected;
use crate::views::fitting::axes;
use crate::views::fitting::fit::{Fit, Patch};
use crate::views::sampling::effort::Effort;
use crate::views::sampling::output_map::{OutputMap, UNIT_FRUSTUM};
use crate::views::sampling::sample::mean_direction;
use crate::views::sampling::samples::{COARSE, FINE, Samples};
use glam::{DMat3, DVec2, DVec3};
use std::cell::OnceCell;

/// An output that shows directions farther than this from their middle (cosine of 65°) may get two
/// views.
const NARROW: f64 = 0.4226;

/// An output, sampled at two levels.
pub(crate) struct OutputSamples {
    pub coarse: Samples,
    pub fine: Samples,
    /// A view that is fixed by the output's kind.
    given: Option<PlannedView>,
    /// The one or two tight dedicated views, made when they are first needed; empty if there can be
    /// none.
    tight: OnceCell<Vec<PlannedView>>,
    /// The output's index and name.
    output: (usize, String),
}

impl OutputSamples {
    /// Samples output `index` of `rig`, as far as `effort` permits.
    pub fn new(rig: &Rig, index: usize, output_map: &OutputMap, effort: &mut Effort) -> Self {
        let [coarse, fine] = [COARSE, FINE].map(|fineness| Samples::new(output_map, fineness, effort));
        let output = &rig.outputs[index];
        let given = || {
            projected::view(rig, index, output_map.size)
                .or_else(|| own_view(&output.kind, index, output_map, rig.views.method))
        };
        let given = (!fine.is_empty()).then(given).flatten();
        let given = given.map(|view| PlannedView { name: output.name.clone(), outputs: vec![index], ..view });
        Self { coarse, fine, given, tight: OnceCell::new(), output: (index, output.name.clone()) }
    }

    /// Returns the dedicated views that the output can have, named after it.
    pub fn own(&self, options: &PlannerOptions) -> &[PlannedView] {
        match &self.given {
            Some(given) => std::slice::from_ref(given),
            None if self.fine.is_empty() || options.method == ViewMethod::Cube || options.given_cells => &[],
            None => self.tight.get_or_init(|| {
                let mut views = tight_views(options, self);
                let ((index, name), several) = (&self.output, views.len() > 1);
                for (number, view) in (1..).zip(&mut views) {
                    view.name = if several { format!("{name}-{number}") } else { name.clone() };
                    view.outputs = vec![*index];
                }
                views
            }),
        }
    }

    /// True if the tight views have been planned.
    #[cfg(test)]
    pub fn is_planned(&self) -> bool {
        self.tight.get().is_some()
    }

    /// True if the output needs no resampling, or is drawn with the program's own lens.
    pub fn is_exact(&self) -> bool {
        self.given.as_ref().is_some_and(|given| given.exact.is_some())
    }

    /// True if all directions of the output lie so near to `middle` that it certainly can have a
    /// dedicated view.
    fn has_narrow_picture(&self, middle: DVec3) -> bool {
        !self.fine.is_empty() && self.fine.iter().all(|sample| sample.direction.dot(middle) > NARROW)
    }
}

/// Returns for each output whether dedicated views are `wanted` for it and possible. `None` if
/// these views are found to cost more than `most` texels together. Views are costly to plan, so
/// planning stops as soon as that is certain.
pub(crate) fn dedicated_within(
    options: &PlannerOptions,
    sampled: &[OutputSamples],
    wanted: &[bool],
    most: f64,
) -> Option<Vec<bool>> {
    // Outputs with the same picture share a view.
    let mut middles: Vec<DVec3> = Vec::new();
    let mut counted = Vec::new();
    for (this, wanted) in sampled.iter().zip(wanted) {
        let middle = mean_direction(this.coarse.iter());
        counted.push(*wanted && this.has_narrow_picture(middle) && !middles.contains(&middle));
        middles.push(middle);
    }
    let mut least = counted.iter().filter(|counted| **counted).count() as f64 * options.texels_per_draw_set();
    let mut own = vec![false; sampled.len()];
    for (index, this) in sampled.iter().enumerate().filter(|(index, _)| wanted[*index]) {
        if least > most {
            return None;
        }
        let views = this.own(options);
        own[index] = !views.is_empty();
        if counted[index] {
            least += cost(options, views) - options.texels_per_draw_set();
        }
    }
    Some(own)
}

/// Returns the view of a perspective output: its own picture, one texel per pixel.
pub(crate) fn own_view(
    kind: &OutputKind,
    index: usize,
    output_map: &OutputMap,
    method: ViewMethod,
) -> Option<PlannedView> {
    let OutputKind::Perspective { angles: [yaw, pitch, roll], frustum } = *kind else { return None };
    if method == ViewMethod::Cube && frustum.is_some() {
        return None;
    }
    let (width, height) = output_map.size;
    let extent = frustum.unwrap_or(UNIT_FRUSTUM);
    let rotation = match frustum {
        Some(_) => pose::rotation(yaw, pitch, roll).transpose(),
        None => DMat3::IDENTITY,
    };
    let density = DVec2::new(f64::from(width) / extent.width(), f64::from(height) / extent.height());
    Some(PlannedView {
        name: String::new(),
        rotation,
        fit: Fit { extent, density },
        exact: Some((width, height)),
        program_lens: frustum.is_none(),
        curved: None,
        eye: 0.0,
        outputs: vec![index],
    })
}

/// Returns the tight view of an output, or two views if that is cheaper. One view has everywhere
/// the resolution that the far end of a wide picture needs; halves need less. With `method =
/// "single"` there is one view.
fn tight_views(options: &PlannerOptions, sampled: &OutputSamples) -> Vec<PlannedView> {
    let quality = options.quality;
    let samples = Patch::of(&sampled.coarse);
    let single = axes::tightest(&samples, &Patch::of(&sampled.fine), quality);
    let middle = samples.middle();
    let least = sampled.coarse.iter().map(|sample| sample.direction.dot(middle)).fold(1.0, f64::min);
    let one: Vec<PlannedView> = single.map(PlannedView::from).into_iter().collect();
    // Two views cost at least as much as submitting the draws twice.
    let cheap = !one.is_empty() && cost(options, &one) <= 2.0 * options.texels_per_draw_set();
    if options.method == ViewMethod::Single || least > NARROW || cheap {
        return one;
    }
    let (coarse, fine) = ([&sampled.coarse], [&sampled.fine]);
    let task = Task::new(options, &coarse, &fine);
    let two: Vec<PlannedView> = task
        .halves(middle)
        .map(|partition| partition.parts.into_iter().map(|part| PlannedView::from(part.oriented)).collect())
        .unwrap_or_default();
    if one.is_empty() || !two.is_empty() && cost(options, &two) < cost(options, &one) { two } else { one }
}
