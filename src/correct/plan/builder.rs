//! Construction of a frame's passes from a rig.

use crate::blend::Weights;
use crate::cache::Cache;
use crate::correct::passes::black::BlackPicture;
use crate::correct::passes::facets::Facets;
use crate::correct::passes::mask;
use crate::correct::passes::output_pass::{Batch, OutputPass, Plan};
use crate::correct::passes::source::Source;
use crate::correct::plan::blocks;
use crate::correct::plan::needs::Examined;
use crate::correct::plan::picture::Picture;
use crate::correct::sources::surface_sample::SurfaceSampler;
use crate::correct::sources::{facets, output_source};
use crate::error::Result;
use crate::geom::ContentMap;
use crate::geom::rectangle::PixelRect;
use crate::rig::{Flip, Method, Output, Rig};
use crate::views::planner::Planning;
use crate::views::{Request, ViewPlan};
use std::sync::Arc;

/// Plans the views and the passes of `rig`: deterministic, and without a graphics API; it reads the
/// masks' files.
///
/// A rig with `passthrough` has no passes. Every pixel whose centre shows something is in exactly
/// one batch, and the batch's views contain the one that answers for the pixel; but blocks of
/// pixels that a mask makes black are in none, if nothing is added to the output's black.
///
/// # Errors
///
/// Those of [`views::plan`](crate::views::plan) and [`WarpMap::new`](crate::warp::WarpMap::new);
/// [`Io`](crate::ErrorKind::Io) or [`InvalidRig`](crate::ErrorKind::InvalidRig) if a mask cannot be
/// read.
pub fn build(rig: &Rig, request: &Request) -> Result<Plan> {
    build_with(rig, request, &Cache::none())
}

/// As [`build`]; `cache` may know which views are chosen and what is in tables, or keeps it.
///
/// # Errors
/// As [`build`].
pub fn build_with(rig: &Rig, request: &Request, cache: &Cache) -> Result<Plan> {
    let flips = rig.outputs.iter().map(|output| output.flip);
    let upright = rig.upright();
    let content = (0..rig.outputs.len()).map(|index| rig.content_map(index, request.window)).collect::<Vec<_>>();
    let rig = &*upright.around_content();
    // What is outside of the window is not drawn; its size only has to be one.
    let sizes: Vec<_> = request.output_sizes.iter().map(|&(width, height)| (width.max(1), height.max(1))).collect();
    let sizes = sizes.as_slice();
    let domes = dome_meshes(rig, sizes)?;
    let mut planning = Planning::new(rig, request, sampling_margin(rig, &domes), cache)?;
    let mut views = planning.place()?;
    let pictures = pictures(rig, sizes, flips.zip(content), cache)?;
    let examine = |views: &ViewPlan| -> Vec<Examined> {
        let pictures = pictures.iter().zip(&request.output_sizes).enumerate();
        let examined = pictures.map(|(index, (picture, size))| match size {
            (0, 0) => Examined::default(),
            _ => blocks::examine(rig, index, picture, views, cache),
        });
        examined.collect()
    };
    let mut examined = examine(&views);
    // The planner knows an output between its samples only; here every pixel has been asked for.
    for _ in 0..MOST_REPAIRS {
        if !complete(&mut planning, &views, &examined) {
            break;
        }
        views = planning.place()?;
        examined = examine(&views);
    }
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
        let batches = by_method(rig, index, sizes, batches, &picture, &views, &domes)?;
        passes.push(pass(rig, index, picture, batches, lift));
    }
    Ok(Plan { views, passes })
}

/// The batches of an output as its method makes them.
fn by_method(
    rig: &Rig,
    index: usize,
    sizes: &[(u32, u32)],
    batches: Vec<Batch>,
    picture: &Picture,
    views: &ViewPlan,
    domes: &[Option<Arc<Facets>>],
) -> Result<Vec<Batch>> {
    let &Picture { ref source, size, .. } = picture;
    Ok(match rig.outputs[index].method {
        Method::Fragment | Method::Vertex | Method::Primitive { .. } => batches,
        Method::Table { .. } => match source {
            Source::Table(table) if table.step() > 1 => only_lit(batches, source, size),
            _ => batches,
        },
        Method::Mesh { max_error } => {
            meshed(only_lit(batches, source, size), &SurfaceSampler::new(rig, index, sizes)?, max_error)
        }
        Method::CubeMesh { .. } => with_dome(batches, &views.output_views[index], domes[index].clone()),
    })
}

/// The pass of an output. `lift`: greatest black of the light that overlaps, which outputs that
/// know where it does are lifted to.
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
        // A table has them in its weights.
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

/// Views are completed at most so often. What a view that is new cannot show either is found when
/// it is examined.
const MOST_REPAIRS: usize = 3;

/// Widens views by what was found beyond them, and adds views for what none of them can show.
/// Returns whether there was anything.
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

/// Views have at most so many texels around what outputs sample, however wrong a mesh is.
const MOST_REACH: f64 = 64.0;
/// Texels for a pixel's error: views have one for each pixel in their middle, and 1/cos² of the
/// angle from it, here 60°.
const TEXELS_PER_PIXEL: f64 = 4.0;

/// Returns the greatest distance at which an output samples a view beside the exact place, texels.
fn sampling_margin(rig: &Rig, domes: &[Option<Arc<Facets>>]) -> u32 {
    // An output's own picture is not sampled beside its place.
    let sampling = rig.outputs.iter().zip(domes).filter(|(output, _)| !output.method.projects_vertices());
    let errors = sampling.map(|(output, dome)| {
        output.method.max_error().unwrap_or_else(|| dome.as_ref().map_or(0.0, |dome| dome.error))
    });
    let texels = TEXELS_PER_PIXEL * rig.views.quality * errors.fold(0.0, f64::max);
    texels.ceil().min(MOST_REACH) as u32
}

/// The meshes of the dome for the outputs that are made so.
fn dome_meshes(rig: &Rig, sizes: &[(u32, u32)]) -> Result<Vec<Option<Arc<Facets>>>> {
    let outputs = rig.outputs.iter().enumerate();
    outputs
        .map(|(index, output)| match output.method {
            Method::CubeMesh { density } => {
                let sampler = SurfaceSampler::new(rig, index, sizes)?;
                Ok(Some(Arc::new(facets::dome_facets(rig, index, &sampler, density))))
            }
            _ => Ok(None),
        })
        .collect()
}

/// The batches without pixels that show nothing.
fn only_lit(batches: Vec<Batch>, source: &Source, size: (u32, u32)) -> Vec<Batch> {
    batches.into_iter().map(|batch| facets::lit_parts::only_lit(batch, source, size)).collect()
}

/// The batches, drawn as triangles with a greatest error in pixels.
fn meshed(batches: Vec<Batch>, sampler: &SurfaceSampler, max_error: f64) -> Vec<Batch> {
    let meshed = |batch: Batch| {
        let facets = Some(Arc::new(Facets::within(sampler, &batch.rects, max_error)));
        // The weights are in the corners.
        Batch { facets, neighbours: Vec::new(), ..batch }
    };
    batches.into_iter().map(meshed).collect()
}

/// The batches as one, drawn as the triangles of a dome that samples any of `views`.
fn with_dome(batches: Vec<Batch>, views: &[usize], facets: Option<Arc<Facets>>) -> Vec<Batch> {
    let masked = batches.iter().any(|batch| batch.masked);
    let rects: Vec<PixelRect> = batches.into_iter().flat_map(|batch| batch.rects).collect();
    let whole = Batch { views: views.to_vec(), neighbours: Vec::new(), edge: false, masked, rects, facets };
    if whole.rects.is_empty() { Vec::new() } else { vec![whole] }
}
