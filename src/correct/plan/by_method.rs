//! Differences of the methods besides the default one: batches of tables and meshes, meshes of a
//! dome, and how far they sample from the exact place.

use crate::correct::passes::facets::Facets;
use crate::correct::passes::output_pass::Batch;
use crate::correct::passes::source::Source;
use crate::correct::plan::picture::Picture;
use crate::correct::sources::facets;
use crate::correct::sources::surface_sample::SurfaceSampler;
use crate::error::Result;
use crate::geom::rectangle::PixelRect;
use crate::rig::{Method, Rig};
use crate::views::ViewPlan;
use std::sync::Arc;

/// Returns the batches of output `index` for its method. `batches`: those of the default method.
///
/// # Errors
/// As [`WarpMap::new`](crate::warp::WarpMap::new).
pub(super) fn batches_of(
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

/// Returns the meshes of the dome for outputs of the method `cube-mesh`.
///
/// # Errors
/// As [`WarpMap::new`](crate::warp::WarpMap::new).
pub fn dome_meshes(rig: &Rig, sizes: &[(u32, u32)]) -> Result<Vec<Option<Arc<Facets>>>> {
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

/// Greatest sampling margin in texels, however inexact a mesh is.
const MOST_REACH: f64 = 64.0;
/// Texels per pixel of an error: one in the middle of a view, and 1/cos² at an angle from it, here
/// 60°.
const TEXELS_PER_PIXEL: f64 = 4.0;

/// Returns the greatest distance between the sampled and the exact place in a view, texels.
pub fn sampling_margin(rig: &Rig, domes: &[Option<Arc<Facets>>]) -> u32 {
    // A picture with projected vertices is sampled at exact places.
    let sampling = rig.outputs.iter().zip(domes).filter(|(output, _)| !output.method.projects_vertices());
    let errors = sampling.map(|(output, dome)| {
        output.method.max_error().unwrap_or_else(|| dome.as_ref().map_or(0.0, |dome| dome.error))
    });
    let texels = TEXELS_PER_PIXEL * rig.views.quality * errors.fold(0.0, f64::max);
    texels.ceil().min(MOST_REACH) as u32
}

/// Returns the batches without pixels that show nothing.
fn only_lit(batches: Vec<Batch>, source: &Source, size: (u32, u32)) -> Vec<Batch> {
    batches.into_iter().map(|batch| facets::lit_parts::only_lit(batch, source, size)).collect()
}

/// Returns the batches, drawn as triangles with a greatest error in pixels.
fn meshed(batches: Vec<Batch>, sampler: &SurfaceSampler, max_error: f64) -> Vec<Batch> {
    let meshed = |batch: Batch| {
        let facets = Some(Arc::new(Facets::within(sampler, &batch.rects, max_error)));
        // The weights are in the corners.
        Batch { facets, neighbours: Vec::new(), ..batch }
    };
    batches.into_iter().map(meshed).collect()
}

/// Returns the batches as one, drawn as the triangles of a dome that samples any of `views`.
fn with_dome(batches: Vec<Batch>, views: &[usize], facets: Option<Arc<Facets>>) -> Vec<Batch> {
    let masked = batches.iter().any(|batch| batch.masked);
    let rects: Vec<PixelRect> = batches.into_iter().flat_map(|batch| batch.rects).collect();
    let whole = Batch { views: views.to_vec(), neighbours: Vec::new(), edge: false, masked, rects, facets };
    if whole.rects.is_empty() { Vec::new() } else { vec![whole] }
}
