//! Construction of a frame's passes from a rig.

use crate::blend::Weights;
use crate::cache::Cache;
use crate::correct::passes::black::BlackPicture;
use crate::correct::passes::facets::Facets;
use crate::correct::passes::mask;
use crate::correct::passes::output_pass::{Batch, OutputPass, Plan};
use crate::correct::passes::source::Source;
use crate::correct::plan::needs::Examined;
use crate::correct::plan::picture::Picture;
use crate::correct::plan::{blocks, by_method};
use crate::correct::sources::output_source;
use crate::error::Result;
use crate::geom::ContentMap;
use crate::rig::{Flip, Method, Output, Rig};
use crate::views::planner::Planning;
use crate::views::{Request, ViewPlan};
use std::sync::Arc;

/// Plans the views and the passes of `rig`. The result is deterministic and needs no graphics API.
/// Reads the files of masks.
///
/// A rig with `passthrough` has no passes. Every pixel whose centre shows something is in exactly
/// one batch, and the batch's views include the view that the pixel samples. Blocks that a mask
/// makes black are in no batch, unless light is added to the output's black.
///
/// # Errors
///
/// Those of [`views::plan`](crate::views::plan) and [`WarpMap::new`](crate::warp::WarpMap::new);
/// [`Io`](crate::ErrorKind::Io) or [`InvalidRig`](crate::ErrorKind::InvalidRig) if a mask cannot be
/// read.
pub fn build(rig: &Rig, request: &Request) -> Result<Plan> {
    build_with(rig, request, &Cache::none())
}

/// As [`build`]; takes the choice of views and tables from `cache`, or stores them there.
///
/// # Errors
/// As [`build`].
pub fn build_with(rig: &Rig, request: &Request, cache: &Cache) -> Result<Plan> {
    let flips = rig.outputs.iter().map(|output| output.flip);
    let upright = rig.upright();
    let content = (0..rig.outputs.len()).map(|index| rig.content_map(index, request.window)).collect::<Vec<_>>();
    let rig = &*upright.around_content();
    // An output outside the window is not drawn; its size only has to be valid.
    let sizes: Vec<_> = request.output_sizes.iter().map(|&(width, height)| (width.max(1), height.max(1))).collect();
    let sizes = sizes.as_slice();
    let domes = by_method::dome_meshes(rig, sizes)?;
    let mut planning = Planning::new(rig, request, by_method::sampling_margin(rig, &domes), cache)?;
    let mut views = planning.place()?;
    let pictures = pictures(rig, sizes, flips.zip(content), cache)?;
    let mut examined = examine(rig, request, &pictures, &views, cache);
    // The planner only samples an output. Here every pixel was examined.
    for _ in 0..MOST_REPAIRS {
        if !complete(&mut planning, &views, &examined) {
            break;
        }
        views = planning.place()?;
        examined = examine(rig, request, &pictures, &views, cache);
    }
    finished(rig, request, sizes, (pictures, examined), (views, &domes))
}

/// Passes of `rig` over views that were planned for another rig of as many outputs, and for
/// `request`. `views` lists for each output all views that it may sample. Takes tables from
/// `cache`, or stores them there.
///
/// Pixels whose directions no view shows are black.
///
/// # Errors
/// As [`build`], without those of the views.
pub(in crate::correct) fn build_over(rig: &Rig, request: &Request, views: ViewPlan, cache: &Cache) -> Result<Plan> {
    let flips = rig.outputs.iter().map(|output| output.flip);
    let rig = &*rig.upright();
    let sizes: Vec<_> = request.output_sizes.iter().map(|&(width, height)| (width.max(1), height.max(1))).collect();
    let sizes = sizes.as_slice();
    let domes = by_method::dome_meshes(rig, sizes)?;
    let mut pictures = pictures(rig, sizes, flips.zip(std::iter::repeat(None)), cache)?;
    // Other machines show their outputs over views of their own.
    let mut request = request.clone();
    let outputs = request.output_sizes.iter_mut().zip(&rig.outputs);
    outputs.filter(|(_, output)| !output.here).for_each(|(size, _)| *size = (0, 0));
    let request = &request;
    let examined = examine(rig, request, &pictures, &views, cache);
    for (index, (picture, examined)) in pictures.iter_mut().zip(&examined).enumerate() {
        if !examined.unseen.is_empty() || examined.beyond.iter().any(Option::is_some) {
            picture.mask = blocks::mask_of_served(rig, index, picture, &views).or(picture.mask.take());
        }
    }
    finished(rig, request, sizes, (pictures, examined), (views, &domes))
}

/// Examines the pictures of all outputs. An output that is not shown needs nothing.
fn examine(rig: &Rig, request: &Request, pictures: &[Picture], views: &ViewPlan, cache: &Cache) -> Vec<Examined> {
    let pictures = pictures.iter().zip(&request.output_sizes).enumerate();
    let examined = pictures.map(|(index, (picture, size))| match size {
        (0, 0) => Examined::default(),
        _ => blocks::examine(rig, index, picture, views, cache),
    });
    examined.collect()
}

/// Makes the passes of outputs whose pictures have been examined.
fn finished(
    rig: &Rig,
    request: &Request,
    sizes: &[(u32, u32)],
    (pictures, examined): (Vec<Picture>, Vec<Examined>),
    (views, domes): (ViewPlan, &[Option<Arc<Facets>>]),
) -> Result<Plan> {
    let lift = match rig.outputs.iter().any(|output| output.blend.contrast.is_some()) {
        true => Weights::new(rig, sizes)?.greatest_black(),
        false => 0.0,
    };
    let mut passes = Vec::new();
    for (index, (picture, examined)) in pictures.into_iter().zip(examined).enumerate() {
        let batches = match request.output_sizes[index] {
            (0, 0) => Vec::new(),
            _ => blocks::batches(rig, index, &picture, &views, examined),
        };
        let batches = by_method::batches_of(rig, index, sizes, batches, &picture, &views, domes)?;
        passes.push(pass(rig, index, picture, batches, lift));
    }
    Ok(Plan { views, passes })
}

/// Returns the pass of an output. `lift`: greatest black of overlapping light. Outputs that know
/// where pictures overlap raise their black to it.
fn pass(rig: &Rig, index: usize, picture: Picture, batches: Vec<Batch>, lift: f64) -> OutputPass {
    let output = &rig.outputs[index];
    let Picture { source, size, mask, flip, content } = picture;
    // Meshes and coarse tables do not know how many pictures meet at their pixels.
    let knows_black = match &source {
        Source::Table(table) => table.step() == 1,
        _ => output.method == Method::Fragment || output.method.projects_vertices(),
    };
    OutputPass {
        name: output.name.clone(),
        here: output.here,
        size,
        batches,
        lift: if knows_black && output.blend.overlap { lift } else { 0.0 },
        // The weights of a table include the ramps.
        ramps: if matches!(source, Source::Table(_)) { Vec::new() } else { output.blend.ramps.clone() },
        source,
        mask: mask.map(|mask| mask.flipped(flip)),
        dome_rotation: output_source::dome_axes(rig),
        filter: rig.views.filter,
        gamma: output.blend.gamma,
        transfer: output.blend.transfer.clone(),
        black_level: output.blend.black_level,
        black: output.black.as_deref().map(|black| BlackPicture::of(black, &output.blend, flip)),
        dither: output.blend.dither.map_or(0.0, |bits| 1.0 / (f64::from(bits).exp2() - 1.0)),
        flip,
        content,
    }
}

/// Returns the parts of each output's picture that are known before there are views. A rig that
/// corrects nothing has no pictures.
fn pictures(
    rig: &Rig,
    sizes: &[(u32, u32)],
    given: impl Iterator<Item = (Flip, Option<ContentMap>)>,
    cache: &Cache,
) -> Result<Vec<Picture>> {
    let outputs = if rig.passthrough { &[] } else { rig.outputs.as_slice() };
    let described = outputs.iter().zip(sizes).zip(given).enumerate();
    let picture = |(index, ((output, &size), (flip, content))): (usize, ((&Output, _), _))| {
        let source = output_source::of(rig, index, sizes, cache)?;
        let mask = output.mask.as_deref().map(mask::load).transpose()?;
        Ok(Picture { source, size, mask, flip, content })
    };
    described.map(picture).collect()
}

/// Greatest number of times that views are completed. Each time, the new views are examined for
/// directions that they cannot show either.
const MOST_REPAIRS: usize = 3;

/// Widens views to include the directions found beyond them, and adds views for directions that no
/// view can show. Returns true if anything changed.
fn complete(planning: &mut Planning<'_>, views: &ViewPlan, examined: &[Examined]) -> bool {
    let mut changed = false;
    for (views, examined) in views.output_views.iter().zip(examined) {
        for (&view, beyond) in views.iter().zip(&examined.beyond) {
            changed |= beyond.as_ref().is_some_and(|extent| planning.widen(view, extent));
        }
    }
    for (output, examined) in examined.iter().enumerate().filter(|(_, examined)| !examined.unseen.is_empty()) {
        changed |= planning.add(output, &examined.unseen);
    }
    changed
}
