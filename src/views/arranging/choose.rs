//! Choice between dedicated views and a shared cube for each output.

use crate::error::{Error, ErrorKind, Result};
use crate::geom::pose;
use crate::rig::{OutputKind, Rig, ViewMethod};
use crate::views::arranging::cost::PlannerOptions;
use crate::views::arranging::dedicated::{OutputSamples, dedicated_within};
use crate::views::arranging::partition::{Partition, Task, WideCell, diagram};
use crate::views::arranging::planned_view::{Arrangement, PlannedView};
use crate::views::fitting::axes::facing;
use crate::views::sampling::effort::Effort;
use crate::views::sampling::output_map::{OutputMap, lens_rotation};
use crate::views::sampling::sample::mean_direction;
use crate::views::sampling::samples::Samples;
use crate::views::view_plan::LEFT_OUT;
use glam::{DMat3, DVec3};

/// At quality 1 no view gets more texels than this for each pixel of the outputs that it serves.
///
/// Pixels shrink without limit where a projector's light grazes the screen close to its lens, or
/// where a lens maps a large part of its picture to a point. A view with the resolution of the
/// smallest pixels would not fit into any atlas. The limit does not affect pictures that are only
/// oblique: a 90° × 60° lens at 0.9 radii needs 7.
pub(super) const MOST_TEXELS_PER_PIXEL: f64 = 64.0;

/// Chooses the views for outputs of the given sizes.
pub(crate) fn arrange(rig: &Rig, output_maps: &[OutputMap]) -> Result<Arrangement> {
    arrange_within(rig, output_maps, &mut Effort::of_plan(rig))
}

/// As [`arrange`], with what `effort` permits.
fn arrange_within(rig: &Rig, output_maps: &[OutputMap], effort: &mut Effort) -> Result<Arrangement> {
    let options = PlannerOptions::of(rig);
    let mut notes = Vec::new();
    let mut sampled = Vec::new();
    for (index, (output, output_map)) in rig.outputs.iter().zip(output_maps).enumerate() {
        let this = OutputSamples::new(rig, index, output_map, effort);
        if effort.is_spent() {
            return Err(too_much_work(&output.name, index, effort.most()));
        }
        let single = rig.views.method == ViewMethod::Single && rig.views.cells.is_empty();
        if output_map.size == (0, 0) {
            notes.push(format!("output {} has no views: it lies outside of the window", output.name));
        } else if this.fine.is_empty() {
            notes.push(format!("output {} shows nothing: no ray of it meets the dome's screen", output.name));
        } else if this.fine.iter().any(|sample| output_map.is_widened(sample)) {
            notes.push(format!(
                "output {}: some pixels of its calibration are far narrower than the others; the resolution of the views \
                 does not follow these pixels",
                output.name
            ));
        }
        if single && !this.fine.is_empty() && this.own(&options).is_empty() {
            return Err(no_single_view(&output.name, &this.fine));
        }
        sampled.push(this);
    }

    // Eyes at different positions need different views, so only outputs of the same eye share
    // views.
    let mut eyes: Vec<f64> = Vec::new();
    for output in &rig.outputs {
        if !eyes.contains(&output.eye) {
            eyes.push(output.eye);
        }
    }
    let mut arrangement = Arrangement::default();
    for eye in eyes {
        let mut of_eye = best(rig, &sampled, output_maps, eye)?;
        for view in &mut of_eye.views {
            view.eye = eye;
            view.name = free_name(&view.name, &arrangement.views);
        }
        arrangement.views.append(&mut of_eye.views);
        arrangement.notes.append(&mut of_eye.notes);
    }
    notes.append(&mut arrangement.notes);
    notes.extend(arrangement.views.iter_mut().filter_map(|view| limit(view, output_maps, options.quality)));
    arrangement.notes = notes;
    Ok(arrangement)
}

/// Returns the cheapest arrangement for the outputs of one eye.
fn best(rig: &Rig, sampled: &[OutputSamples], output_maps: &[OutputMap], eye: f64) -> Result<Arrangement> {
    let options = PlannerOptions::of(rig);
    let of_eye = |index: usize| rig.outputs[index].eye == eye;
    // These outputs always have a dedicated view: it needs no resampling, or is drawn with the
    // program's own lens.
    let is_dedicated = |index: usize| sampled[index].is_exact();
    let is_circle = |index: usize| output_maps[index].is_circular();
    let ways: &[&dyn Fn(usize) -> bool] = match rig.views.method {
        _ if !rig.views.cells.is_empty() => &[&is_dedicated],
        ViewMethod::Cube => &[&is_dedicated],
        ViewMethod::Single => &[&|_| true],
        ViewMethod::Auto => &[&|_| true, &|index| is_dedicated(index) || !is_circle(index), &is_dedicated],
    };
    // Ways with dedicated views for the same outputs are the same.
    let mut tried: Vec<Vec<bool>> = Vec::new();
    let mut cheapest: Option<((usize, f64), Arrangement)> = None;
    let mut refused = None;
    // Outputs that show something but have no view.
    let without = |arrangement: &Arrangement| -> Vec<usize> {
        let has_one = |index: &usize| arrangement.views.iter().any(|view| view.outputs.contains(index));
        (0..sampled.len())
            .filter(|&index| of_eye(index) && !sampled[index].fine.is_empty())
            .filter(|i| !has_one(i))
            .collect()
    };
    // Among equal costs the first way counts. The last way is tried first, since it needs no
    // dedicated views and may cost less than these can.
    for way in ways.iter().rev() {
        let wanted: Vec<bool> = (0..sampled.len()).map(|index| of_eye(index) && way(index)).collect();
        let most = cheapest.as_ref().filter(|((without, _), _)| *without == 0);
        let most = most.map_or(f64::INFINITY, |((_, cost), _)| *cost);
        let Some(own) = dedicated_within(&options, sampled, &wanted, most) else { continue };
        if !tried.contains(&own) {
            match mixed(rig, sampled, of_eye, |index| own[index]) {
                Ok(arrangement) => {
                    let cost = (without(&arrangement).len(), arrangement.cost(&options));
                    if cheapest.as_ref().is_none_or(|(other, _)| cost <= *other) {
                        cheapest = Some((cost, arrangement));
                    }
                }
                Err(error) => refused = Some(error),
            }
            tried.push(own);
        }
    }
    let Some((_, mut arrangement)) = cheapest else { return refused.map_or_else(|| Ok(Arrangement::default()), Err) };
    let outputs = without(&arrangement);
    if !outputs.is_empty() && arrangement.views.is_empty() {
        return Err(without_view(rig, &outputs));
    }
    arrangement.notes.extend(outputs.iter().map(|output| without_view(rig, &[*output]).message));
    Ok(arrangement)
}

/// Returns the views of the outputs for which `chosen` is true: dedicated views where
/// `is_dedicated` is true, shared cells for the others.
fn mixed(
    rig: &Rig,
    sampled: &[OutputSamples],
    chosen: impl Fn(usize) -> bool,
    is_dedicated: impl Fn(usize) -> bool,
) -> Result<Arrangement> {
    let options = PlannerOptions::of(rig);
    let mut arrangement = Arrangement::default();
    let mut sharing = Vec::new();
    for (index, this) in sampled.iter().enumerate().filter(|(index, _)| chosen(*index)) {
        if is_dedicated(index) {
            arrangement.views.extend(this.own(&options).iter().cloned());
        } else if !this.fine.is_empty() {
            sharing.push(index);
        }
    }
    share_equals(&mut arrangement.views);
    if !sharing.is_empty() {
        let coarse: Vec<&Samples> = sharing.iter().map(|&index| &sampled[index].coarse).collect();
        let fine: Vec<&Samples> = sharing.iter().map(|&index| &sampled[index].fine).collect();
        let task = Task::new(&options, &coarse, &fine);
        let partition = if rig.views.cells.is_empty() {
            task.best(&frames(rig, &sharing, &coarse)).ok_or_else(|| without_view(rig, &sharing))?
        } else {
            let cells = diagram(&rig.views.cells);
            if let Some(wide) = cells.iter().position(|cell| !task.texels(cell).is_finite()) {
                return Err(too_wide_cell(wide));
            }
            task.partition(&cells).map_err(|WideCell(wide)| too_wide_cell(wide))?
        };
        add_parts(&mut arrangement, partition, &sharing);
    }
    Ok(arrangement)
}

fn without_view(rig: &Rig, outputs: &[usize]) -> Error {
    let names: Vec<&str> = outputs.iter().map(|&index| rig.outputs[index].name.as_str()).collect();
    Error::new(
        ErrorKind::InvalidRig,
        format!(
            "output {}: no perspective view can show it: its directions form a strip that is far too narrow, or less than \
             a pixel; make the output show more, or remove it",
            names.join(", ")
        ),
    )
}

/// Error for output `name`, which spends what `others` outputs before it have left.
fn too_much_work(name: &str, others: usize, most: u64) -> Error {
    let before = if others > 0 { format!(", together with the {others} outputs before it") } else { String::new() };
    Error::new(
        ErrorKind::InvalidRig,
        format!(
            "output {name}: directions change so unevenly over its picture that the planner would need more than \
             {most} samples of it{before}, which is its limit; use a mesh or a calibration with fewer or smoother \
             faces, or fewer outputs"
        ),
    )
}

fn too_wide_cell(index: usize) -> Error {
    Error::new(
        ErrorKind::InvalidRig,
        format!(
            "[views] cells: in the cell of cells[{index}] the outputs show directions more than 83° from every axis, too \
             wide for one perspective view; use more cells (`cupola-lab cells` finds some), or remove the key"
        ),
    )
}

/// Reduces the resolution of a view to the limit of [`MOST_TEXELS_PER_PIXEL`]. Returns a note for
/// the user if it did.
fn limit(view: &mut PlannedView, output_maps: &[OutputMap], quality: f64) -> Option<String> {
    let pixels = |&output: &usize| f64::from(output_maps[output].size.0) * f64::from(output_maps[output].size.1);
    let asked = view.fit.texels() / (quality * quality) / view.outputs.iter().map(pixels).sum::<f64>();
    if view.exact.is_some() || asked <= MOST_TEXELS_PER_PIXEL {
        return None;
    }
    let scale = (MOST_TEXELS_PER_PIXEL / asked).sqrt();
    view.fit.density *= scale;
    Some(format!(
        "view {} has {:.1} % of the resolution asked for, in each direction: the smallest pixels of its outputs \
         would need {asked:.0} texels for each pixel",
        view.name,
        100.0 * scale,
    ))
}

/// Merges views that are the same in everything but the outputs.
fn share_equals(views: &mut Vec<PlannedView>) {
    let mut kept: Vec<PlannedView> = Vec::with_capacity(views.len());
    for view in views.drain(..) {
        let same = |other: &&mut PlannedView| {
            other.rotation == view.rotation
                && other.fit.extent == view.fit.extent
                && other.fit.density == view.fit.density
                && other.exact == view.exact
                && other.program_lens == view.program_lens
                && other.curved == view.curved
        };
        match kept.iter_mut().find(same) {
            Some(other) => other.outputs.extend(view.outputs),
            None => kept.push(view),
        }
    }
    *views = kept;
}

/// Returns the frames (local → viewer axes) for which cubes are tried: those of domemasters and
/// panoramas, the viewer's, and one that looks at the middle of all samples.
pub(in crate::views) fn frames(rig: &Rig, sharing: &[usize], samples: &[&Samples]) -> Vec<DMat3> {
    let middle: DVec3 = samples.iter().map(|samples| mean_direction(samples.iter())).sum();
    let lenses = sharing.iter().filter_map(|&index| match rig.outputs[index].kind {
        OutputKind::Domemaster { tilt, .. } => Some(lens_rotation(tilt)),
        OutputKind::Panorama { angles: [yaw, pitch, roll], .. } => Some(pose::rotation(yaw, pitch, roll)),
        _ => None,
    });
    let mut frames: Vec<DMat3> = Vec::new();
    for frame in lenses.chain([DMat3::IDENTITY, facing(middle)]) {
        if !frames.iter().any(|other| other.abs_diff_eq(frame, 1e-6)) {
            frames.push(frame);
        }
    }
    frames
}

fn add_parts(arrangement: &mut Arrangement, partition: Partition, sharing: &[usize]) {
    for part in partition.parts {
        let name = free_name(&direction_name(part.towards), &arrangement.views);
        let outputs = part.outputs.iter().map(|&index| sharing[index]).collect();
        arrangement.views.push(PlannedView { name, outputs, ..PlannedView::from(part.oriented) });
    }
    for direction in partition.skipped {
        arrangement.notes.push(format!("{LEFT_OUT}{}: no output shows directions there", direction_name(direction)));
    }
}

/// Returns a direction in words: `front`, `up`, `front-left` …
pub(super) fn direction_name(direction: DVec3) -> String {
    // From about a third of the way to the next axis, both words count.
    const SHARE: f64 = 0.38;
    let word = |part: f64, positive: &'static str, negative: &'static str| {
        (part.abs() > SHARE).then_some(if part > 0.0 { positive } else { negative })
    };
    let words =
        [word(direction.y, "up", "down"), word(-direction.z, "front", "back"), word(direction.x, "right", "left")];
    words.into_iter().flatten().collect::<Vec<_>>().join("-")
}

pub(super) fn free_name(name: &str, views: &[PlannedView]) -> String {
    let taken = |candidate: &str| views.iter().any(|view| view.name == candidate);
    if !taken(name) {
        return name.to_owned();
    }
    let numbered = |number: usize| format!("{name}-{number}");
    (2..=views.len() + 2).map(numbered).find(|candidate| !taken(candidate)).unwrap_or_else(|| numbered(views.len() + 3))
}

fn no_single_view(name: &str, samples: &Samples) -> Error {
    let middle = mean_direction(samples.iter());
    let widest = samples.iter().map(|sample| sample.direction.angle_between(middle)).fold(0.0, f64::max);
    Error::new(
        ErrorKind::InvalidRig,
        format!(
            "[views] method = \"single\": output {name} shows directions up to {:.0}° from their middle, but one \
             perspective view can show at most 83°; use method = \"auto\" or \"cube\", or a narrower output",
            widest.to_degrees(),
        ),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;
    use crate::views::tests::{fisheye, lens, projector, rig};

    /// Returns the cheapest arrangement of all ways, each planned completely; the first of equals.
    fn exhaustive(rig: &Rig, sampled: &[OutputSamples], output_maps: &[OutputMap]) -> Arrangement {
        let ways: [&dyn Fn(usize) -> bool; 3] = [&|_| true, &|index| !output_maps[index].is_circular(), &|_| false];
        let options = PlannerOptions::of(rig);
        let own = |index: usize| !sampled[index].own(&options).is_empty();
        let planned =
            |way: &&dyn Fn(usize) -> bool| mixed(rig, sampled, |_| true, |i| way(i) && own(i)).expect("a plan");
        let arrangements: Vec<Arrangement> = ways.iter().map(planned).collect();
        arrangements.into_iter().min_by(|a, b| a.cost(&options).total_cmp(&b.cost(&options))).expect("three")
    }

    #[test]
    fn a_rig_that_needs_too_many_samples_is_refused_with_the_output_that_does() {
        let outputs = (0..64).map(|index| {
            let around = f64::from(index) / 64.0 * 360.0;
            projector(&format!("p{index}"), DVec3::new(0.0, 0.4, 2.0), [around, 30.0, 0.0], lens(70.0, 45.0))
        });
        let mut rig = rig(outputs.collect());
        rig.viewer.position = DVec3::new(0.0, 0.0, 3.0);
        let maps: Vec<OutputMap> = (0..64).map(|i| OutputMap::new(&rig, i, (1920, 1080)).expect("a map")).collect();
        let mut effort = Effort::of_plan(&rig);
        for (index, map) in maps.iter().enumerate() {
            OutputSamples::new(&rig, index, map, &mut effort);
        }
        let needed = effort.most() - effort.left();
        assert!(8 * needed < effort.most(), "64 projectors need {needed}");
        // A part of what is needed is refused, and as much as is needed is not.
        rig.outputs.truncate(3);
        let error = arrange_within(&rig, &maps[..3], &mut Effort::of(needed / 64)).expect_err("too little");
        assert!(error.kind == ErrorKind::InvalidRig && error.message.starts_with("output p"), "{error}");
        assert!(error.message.contains("fewer outputs"), "{error}");
        assert!(arrange_within(&rig, &maps[..3], &mut Effort::of(needed)).is_ok());
    }

    #[test]
    fn what_is_not_planned_would_have_cost_more() {
        let mut random = Random::new(11);
        let (mut shared, mut unplanned) = (0, 0);
        for round in 0u32..24 {
            let count = 1 + round % 5;
            let mut outputs: Vec<_> = (0..count)
                .map(|index| {
                    let yaw = f64::from(index) * 360.0 / f64::from(count) + random.range(-5.0, 5.0);
                    let (width, height) = (random.range(30.0, 110.0), random.range(30.0, 70.0));
                    projector("p", random.vector(-0.5, 0.5), [yaw, random.range(0.0, 60.0), 0.0], lens(width, height))
                })
                .collect();
            if round % 3 == 0 {
                outputs.push(outputs[0].clone());
            }
            if round % 4 == 0 {
                outputs.push(fisheye(180.0, random.range(0.0, 90.0)));
            }
            let rig = rig(outputs);
            let side = [40, 200, 700][round as usize % 3];
            let output_map = |index: usize| OutputMap::new(&rig, index, (side, side)).expect("a map");
            let output_maps: Vec<OutputMap> = (0..rig.outputs.len()).map(output_map).collect();
            let sampled = || -> Vec<OutputSamples> {
                let maps = output_maps.iter().enumerate();
                maps.map(|(i, map)| OutputSamples::new(&rig, i, map, &mut Effort::of_plan(&rig))).collect()
            };
            let (quick, whole) = (sampled(), sampled());
            let best = best(&rig, &quick, &output_maps, 0.0).expect("a plan");
            assert_eq!(format!("{best:?}"), format!("{:?}", exhaustive(&rig, &whole, &output_maps)), "{rig:?}");
            shared += usize::from(best.views.iter().any(|view| view.outputs.len() > 1));
            unplanned += quick.iter().filter(|sampled| !sampled.is_planned()).count();
        }
        assert!(shared > 3 && unplanned > 3, "{shared} share views, {unplanned} outputs were not planned for alone");
    }
}
