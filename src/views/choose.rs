//! Which outputs get a view of their own, and which share a cube.

use super::axes::{self, Aimed, facing, mean_direction};
use super::fit::Fit;
use super::partition::{Partition, Task};
use super::samples::{COARSE, FINE, Samples};
use super::sight::{Sample, Sight, UNIT_FRUSTUM, lens_rotation};
use crate::error::{Error, ErrorKind, Result};
use crate::geom::pose;
use crate::rig::{Favour, OutputKind, Rig, ViewMethod};
use glam::{DMat3, DVec2, DVec3};

/// What a view costs beside its texels, in texels: submitting the program's draws once more.
///
/// A thousand draws at 1–2 µs are 1–2 ms. In that time a graphics card shades 5–10 million texels
/// with an overdraw of 2, and a software rasteriser about 0.3 million: 2²⁰ lies between.
const TEXELS_PER_VIEW: f64 = 1_048_576.0;

/// The same for a rig that favours one or the other: 16 times as many draws, or as few.
fn view_cost(favour: Favour) -> f64 {
    match favour {
        Favour::Balanced => TEXELS_PER_VIEW,
        Favour::Processor => 16.0 * TEXELS_PER_VIEW,
        Favour::Graphics => TEXELS_PER_VIEW / 16.0,
    }
}

/// At quality 1 no view gets more texels than this for each pixel of the outputs that it serves.
///
/// Where a projector's light grazes the screen close to its lens, or a lens crams a large part of its picture into a
/// point, pixels shrink without bound, and a view as fine as the finest of them would fit into no atlas. The bar leaves
/// alone what is merely oblique: a 90° × 60° lens at 0.9 radii needs 7.
const MOST_TEXELS_PER_PIXEL: f64 = 64.0;

/// A view before it has a place and its final size.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    /// Name for people.
    pub name: String,
    /// Viewer axes → view axes.
    pub rotation: DMat3,
    /// The sampled part and the resolution it needs.
    pub fit: Fit,
    /// The sampled part is exactly so many pixels, one texel each at quality 1.
    pub exact: Option<(u32, u32)>,
    /// Drawn with the program's own projection.
    pub program_lens: bool,
    /// How far to the right of the viewer's position it is seen from, metres.
    pub eye: f64,
    /// The outputs that sample it.
    pub outputs: Vec<usize>,
}

/// The views of a rig, and remarks for people.
#[derive(Clone, Debug, Default)]
pub(crate) struct Arrangement {
    /// In order of precedence.
    pub views: Vec<Wanted>,
    /// What was left out, and why.
    pub notes: Vec<String>,
}

impl Arrangement {
    /// In texels, if a view costs `per_view` beside its own.
    fn cost(&self, per_view: f64) -> f64 {
        self.views.iter().map(|view| view.fit.texels() + per_view).sum()
    }
}

/// An output, sampled at two levels.
struct Seen {
    coarse: Samples,
    fine: Samples,
    single: Option<Wanted>,
}

/// Chooses the views for outputs of the given sizes.
pub(crate) fn arrange(rig: &Rig, sights: &[Sight]) -> Result<Arrangement> {
    let quality = rig.views.quality;
    let method = rig.views.method;
    let mut notes = Vec::new();
    let mut seen = Vec::new();
    for (index, (output, sight)) in rig.outputs.iter().zip(sights).enumerate() {
        let mut this = Seen { coarse: Samples::new(sight, COARSE), fine: Samples::new(sight, FINE), single: None };
        if this.fine.is_empty() {
            notes.push(format!("output {} shows nothing: no ray of it meets the dome's screen", output.name));
        } else {
            this.single = own_view(&output.kind, index, sight, method).or_else(|| {
                let needed = method != ViewMethod::Cube;
                needed
                    .then(|| axes::tightest(&all(&this.coarse), &all(&this.fine), quality))
                    .flatten()
                    .map(Wanted::from)
            });
            if let Some(single) = &mut this.single {
                single.name.clone_from(&output.name);
                single.outputs = vec![index];
            } else if method == ViewMethod::Single {
                return Err(no_single_view(&output.name, &this.fine));
            }
        }
        seen.push(this);
    }

    // What an eye sees from another place is another view: only outputs of the same eye share views.
    let mut eyes: Vec<f64> = Vec::new();
    for output in &rig.outputs {
        if !eyes.contains(&output.eye) {
            eyes.push(output.eye);
        }
    }
    let mut arrangement = Arrangement::default();
    for eye in eyes {
        let mut of_eye = best(rig, &seen, sights, eye);
        for view in &mut of_eye.views {
            view.eye = eye;
            view.name = free_name(&view.name, &arrangement.views);
        }
        arrangement.views.append(&mut of_eye.views);
        arrangement.notes.append(&mut of_eye.notes);
    }
    notes.append(&mut arrangement.notes);
    notes.extend(arrangement.views.iter_mut().filter_map(|view| limit(view, sights, quality)));
    arrangement.notes = notes;
    Ok(arrangement)
}

/// The cheapest arrangement for the outputs of one eye.
fn best(rig: &Rig, seen: &[Seen], sights: &[Sight], eye: f64) -> Arrangement {
    let of_eye = |index: usize| rig.outputs[index].eye == eye;
    // Always alone: what needs no resampling then, or is drawn with the program's own lens.
    let alone = |index: usize| seen[index].single.as_ref().is_some_and(|single| single.exact.is_some());
    let is_circle = |index: usize| sights[index].is_circular();
    let arrangements: Vec<Arrangement> = match rig.views.method {
        ViewMethod::Cube => vec![mixed(rig, seen, of_eye, alone)],
        ViewMethod::Single => vec![mixed(rig, seen, of_eye, |_| true)],
        ViewMethod::Auto => vec![
            mixed(rig, seen, of_eye, |_| true),
            mixed(rig, seen, of_eye, |index| alone(index) || !is_circle(index)),
            mixed(rig, seen, of_eye, alone),
        ],
    };
    let cost = |arrangement: &Arrangement| arrangement.cost(view_cost(rig.views.favour));
    arrangements.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or_default()
}

impl From<Aimed> for Wanted {
    fn from(aimed: Aimed) -> Self {
        Self {
            name: String::new(),
            rotation: aimed.rotation,
            fit: aimed.fit,
            exact: None,
            program_lens: false,
            eye: 0.0,
            outputs: Vec::new(),
        }
    }
}

/// The view of a perspective output: its own picture, texel for pixel.
fn own_view(kind: &OutputKind, index: usize, sight: &Sight, method: ViewMethod) -> Option<Wanted> {
    let OutputKind::Perspective { angles, frustum } = kind else { return None };
    if method == ViewMethod::Cube && frustum.is_some() {
        return None;
    }
    let (width, height) = sight.size;
    let extent = frustum.unwrap_or(UNIT_FRUSTUM);
    let rotation = match frustum {
        Some(_) => pose::rotation(angles[0], angles[1], angles[2]).transpose(),
        None => DMat3::IDENTITY,
    };
    let density = DVec2::new(f64::from(width) / extent.width(), f64::from(height) / extent.height());
    Some(Wanted {
        name: String::new(),
        rotation,
        fit: Fit { extent, density },
        exact: Some((width, height)),
        program_lens: frustum.is_none(),
        eye: 0.0,
        outputs: vec![index],
    })
}

/// Of the outputs that `chosen` names: views of their own for those that `alone` names and that can have one; a cube
/// for the others.
fn mixed(rig: &Rig, seen: &[Seen], chosen: impl Fn(usize) -> bool, alone: impl Fn(usize) -> bool) -> Arrangement {
    let mut arrangement = Arrangement::default();
    let mut sharing = Vec::new();
    for (index, this) in seen.iter().enumerate().filter(|(index, _)| chosen(*index)) {
        match &this.single {
            Some(single) if alone(index) => arrangement.views.push(single.clone()),
            _ if !this.fine.is_empty() => sharing.push(index),
            _ => {}
        }
    }
    share_equals(&mut arrangement.views);
    if !sharing.is_empty() {
        let coarse: Vec<&Samples> = sharing.iter().map(|&index| &seen[index].coarse).collect();
        let fine: Vec<&Samples> = sharing.iter().map(|&index| &seen[index].fine).collect();
        let task = Task {
            coarse: &coarse,
            fine: &fine,
            quality: rig.views.quality,
            pixel: finest_pixel(&coarse),
            view_cost: view_cost(rig.views.favour),
        };
        add_parts(&mut arrangement, task.best(&frames(rig, &sharing, &coarse)), &sharing);
    }
    arrangement
}

/// Makes a view coarser that is finer than [`MOST_TEXELS_PER_PIXEL`] allows; what to tell people then.
fn limit(view: &mut Wanted, sights: &[Sight], quality: f64) -> Option<String> {
    let pixels = |&output: &usize| f64::from(sights[output].size.0) * f64::from(sights[output].size.1);
    let asked = view.fit.texels() / (quality * quality) / view.outputs.iter().map(pixels).sum::<f64>();
    if view.exact.is_some() || asked <= MOST_TEXELS_PER_PIXEL {
        return None;
    }
    let scale = (MOST_TEXELS_PER_PIXEL / asked).sqrt();
    view.fit.density *= scale;
    Some(format!(
        "view {} has {:.1} % of the resolution asked for, in each direction: the smallest of its outputs' pixels \
         would take {asked:.0} texels for each pixel",
        view.name,
        100.0 * scale,
    ))
}

/// Every sample of an output.
fn all(samples: &Samples) -> Vec<Sample> {
    samples.iter().copied().collect()
}

/// Merges views that are the same in everything but the outputs.
fn share_equals(views: &mut Vec<Wanted>) {
    let mut kept: Vec<Wanted> = Vec::with_capacity(views.len());
    for view in views.drain(..) {
        let same = |other: &&mut Wanted| {
            other.rotation == view.rotation
                && other.fit.extent == view.fit.extent
                && other.fit.density == view.fit.density
                && other.exact == view.exact
                && other.program_lens == view.program_lens
        };
        match kept.iter_mut().find(same) {
            Some(other) => other.outputs.extend(view.outputs),
            None => kept.push(view),
        }
    }
    *views = kept;
}

/// Frames (local → viewer axes) around which cubes are tried: the viewer's, the domemasters', and
/// one that looks at the middle of everything seen.
fn frames(rig: &Rig, sharing: &[usize], samples: &[&Samples]) -> Vec<DMat3> {
    let middle: DVec3 = samples.iter().map(|samples| mean_direction(&all(samples))).sum();
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

/// The size of the finest pixel in radians.
fn finest_pixel(samples: &[&Samples]) -> f64 {
    samples
        .iter()
        .flat_map(|samples| samples.iter())
        .map(|sample| {
            let spread = &sample.spread;
            (0.5 * (spread.x_axis.x + spread.y_axis.y + spread.z_axis.z)).sqrt()
        })
        .fold(f64::INFINITY, f64::min)
}

fn add_parts(arrangement: &mut Arrangement, partition: Partition, sharing: &[usize]) {
    for part in partition.parts {
        let name = free_name(&direction_name(part.towards), &arrangement.views);
        let outputs = part.outputs.iter().map(|&index| sharing[index]).collect();
        arrangement.views.push(Wanted { name, outputs, ..Wanted::from(part.aimed) });
    }
    for direction in partition.skipped {
        arrangement
            .notes
            .push(format!("no view {}: nothing that the outputs show lies there", direction_name(direction)));
    }
}

/// A direction in words: `front`, `up`, `front-left` …
fn direction_name(direction: DVec3) -> String {
    // A third of the way to the next axis counts as between the two.
    const SHARE: f64 = 0.38;
    let word = |part: f64, positive: &'static str, negative: &'static str| {
        (part.abs() > SHARE).then_some(if part > 0.0 { positive } else { negative })
    };
    let words =
        [word(direction.y, "up", "down"), word(-direction.z, "front", "back"), word(direction.x, "right", "left")];
    words.into_iter().flatten().collect::<Vec<_>>().join("-")
}

fn free_name(name: &str, views: &[Wanted]) -> String {
    let taken = |candidate: &str| views.iter().any(|view| view.name == candidate);
    if !taken(name) {
        return name.to_owned();
    }
    let numbered = |number: usize| format!("{name}-{number}");
    (2..=views.len() + 2).map(numbered).find(|candidate| !taken(candidate)).unwrap_or_else(|| numbered(views.len() + 3))
}

fn no_single_view(name: &str, samples: &Samples) -> Error {
    let middle = mean_direction(&all(samples));
    let widest = samples.iter().map(|sample| sample.direction.angle_between(middle)).fold(0.0, f64::max);
    Error::new(
        ErrorKind::InvalidRig,
        format!(
            "[views] method = \"single\": output {name} sees directions up to {:.0}° from their middle, and one \
             perspective view can show 83° at most; use method = \"auto\" or \"cube\", or a narrower output",
            widest.to_degrees(),
        ),
    )
}
