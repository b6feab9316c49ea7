//! The passes of a frame: their types, and how they are built from a rig.

use crate::blend::{Border, Weights};
use crate::cache::Cache;
use crate::correct::plan::blocks;
use crate::correct::shaders::black::BlackPicture;
use crate::correct::sources::facets::{self, Facets};
pub use crate::correct::sources::optics::{Light, OpticsSource};
use crate::correct::sources::surface_sample::Shown;
use crate::correct::sources::table::Table;
use crate::correct::sources::{mask, output_source, ray_form};
use crate::error::Result;
use crate::geom::pencil::RimForms;
use crate::geom::screen::Bounds;
use crate::geom::{Panorama, Pencil, QuadraticForm};
use crate::rig::{AngleRamp, Filter, Flip, Method, Rig, Transfer};
use crate::views::{self, Request, ViewPlan};
use glam::{DMat3, DVec3};
pub use ray_form::Way;
use std::sync::Arc;

/// Everything a backend needs to correct a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The views and the atlas.
    pub views: ViewPlan,
    /// A pass for each output, in the rig's order.
    pub passes: Vec<OutputPass>,
}

/// A rectangle of an output in pixels, from the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRect {
    /// Left edge.
    pub x: u32,
    /// Top edge.
    pub y: u32,
    /// Width.
    pub width: u32,
    /// Height.
    pub height: u32,
}

/// One output's correction. Pixels in no batch are black. All but the mask and the picture of black is that of the picture before it is mirrored.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputPass {
    /// The output's name.
    pub name: String,
    /// The output's resolution in pixels.
    pub size: (u32, u32),
    /// Output pixel (normalised, see [`Batch`]) → ray.
    pub source: Source,
    /// Rectangles that share a shader.
    pub batches: Vec<Batch>,
    /// Weight image at the output's resolution or any other; linear light, 0…1, row 0 at the top; mirrored as the picture is.
    pub mask: Option<Mask>,
    /// Ramps in dome angles, multiplied in.
    pub ramps: Vec<AngleRamp>,
    /// Viewer axes → dome axes turned so that the pole is +y and the front −z; for ramps in dome
    /// angles of outputs other than projectors (those have [`ProjectorSource::dome_direction`]).
    pub dome_rotation: DMat3,
    /// How the views are sampled; a view with the program's own lens has no guard and is sampled bilinearly.
    pub filter: Filter,
    /// Exponent of the display's response, for [`Transfer::Power`].
    pub gamma: f64,
    /// How light follows from encoded values.
    pub transfer: Transfer,
    /// Linear light added to black (`out = level + (1 − level)·x`).
    pub black_level: f64,
    /// What black is raised to in each pixel, displayed values, in place of the level; mirrored as the picture is.
    pub black: Option<BlackPicture>,
    /// The most light that remains anywhere when all outputs show black, as a part of white; each output adds its share of
    /// what a point has less. 0 = nothing is added.
    pub lift: f64,
    /// A step of the display's codes, by which values are dithered; 0 = they are not.
    pub dither: f64,
    /// How the picture is mirrored as it is drawn.
    pub flip: Flip,
}

/// How an output's map is interpolated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Approximation {
    /// Between the entries of a table.
    Table {
        /// How far apart they are, pixels, at least 2.
        step: u32,
        /// Greatest error at a pixel's centre, pixels.
        error: f64,
    },
    /// Between the corners of triangles.
    Triangles {
        /// How many there are.
        count: usize,
        /// Greatest error that was measured between corners, pixels.
        error: f64,
    },
}

impl OutputPass {
    /// The rectangles that are filled whatever they show.
    pub(in crate::correct) fn filled(&self) -> impl Iterator<Item = &PixelRect> {
        let filled = self.batches.iter().filter(|batch| batch.facets.as_ref().is_none_or(|facets| facets.fills));
        filled.flat_map(|batch| &batch.rects)
    }

    /// Which part of the output, 0…1, is black before its batches are drawn, and mostly after it.
    pub fn black_part(&self) -> f64 {
        let filled: f64 = self.filled().map(|rect| f64::from(rect.width) * f64::from(rect.height)).sum();
        1.0 - filled / (f64::from(self.size.0) * f64::from(self.size.1)).max(1.0)
    }

    /// How the map is interpolated, and what that errs; `None` where each pixel has its own.
    pub fn approximation(&self) -> Option<Approximation> {
        let facets: Vec<&Facets> = self.batches.iter().filter_map(|batch| batch.facets.as_deref()).collect();
        match &self.source {
            _ if !facets.is_empty() => Some(Approximation::Triangles {
                count: facets.iter().map(|facets| facets.triangles.len()).sum(),
                error: facets.iter().map(|facets| facets.error).fold(0.0, f64::max),
            }),
            Source::Table(table) if table.step() > 1 => {
                Some(Approximation::Table { step: table.step(), error: table.error() })
            }
            _ => None,
        }
    }
}

/// A weight image.
#[derive(Clone, Debug, PartialEq)]
pub struct Mask {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Weights, 16 bit, row by row from the top.
    pub weights: Vec<u16>,
}

/// How a pixel of an output becomes a direction. `(x, y)` are the pixel's normalised
/// coordinates: −1…1 from left to right and from bottom to top, at pixel centres, scaled so for
/// [`Source::Fisheye`] that the inscribed circle is the unit circle.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// `v = rotation·(q·S(|q|²), −C(|q|²)) + offset` with `q = (x, y)·aperture/2`, in viewer axes (metres per dome radius).
    Fisheye {
        /// Whole opening angle, radians.
        aperture: f64,
        /// Lens axes → viewer axes.
        rotation: DMat3,
        /// Minus the viewer's position over the dome's radius, in viewer axes.
        offset: DVec3,
    },
    /// Viewer direction by the closed form, in viewer axes.
    Projector(Box<ProjectorSource>),
    /// `v = matrix·(x, y, 1)`, in viewer axes.
    Perspective {
        /// Homogeneous pixel → direction.
        matrix: DMat3,
    },
    /// `v = rotation·u + offset`, in viewer axes (metres per dome radius), with u the panorama's unit direction. `(x, y)`
    /// are scaled as for [`Source::Fisheye`] if the panorama is a circle.
    Panorama {
        /// How the picture shows directions.
        panorama: Panorama,
        /// Picture axes → viewer axes.
        rotation: DMat3,
        /// As for [`Source::Fisheye`].
        offset: DVec3,
    },
    /// Viewer direction by following the ray through a lens, and perhaps by way of a mirror.
    Optics(Box<OpticsSource>),
    /// Viewer direction and weight of each pixel, computed beforehand. The weight has everything in it but
    /// the mask: a pass with a table has no ramps and no neighbours of its own.
    Table(Arc<Table>),
}

/// The forms of a projector.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectorSource {
    /// Its rays and what they light, in the axes of the surface.
    pub pencil: Pencil,
    /// Viewer direction, viewer axes.
    pub direction: QuadraticForm,
    /// The part of the surface that is screen.
    pub bounds: Bounds,
    /// Whether a pixel's point is there; `None` = the whole surface is screen.
    pub rim: Option<RimForms>,
    /// From the dome's centre to the point, times a positive factor, dome axes turned so that the pole is +y and the front −z; for ramps in dome angles.
    pub dome_direction: QuadraticForm,
    /// For every projector that can overlap this one: its homogeneous picture coordinates (`x/z`, `y/z` in −1…1, `z > 0` in front) of this pixel's hit, and its ramp.
    pub neighbours: Vec<Neighbour>,
    /// This projector's own claim on points.
    pub border: Border,
    /// How the forms are computed.
    pub way: Way,
}

impl ProjectorSource {
    /// The same, computed in the cheapest way that is exact enough for pictures of `size`; `None` if none is.
    pub fn settled(mut self, size: (u32, u32)) -> Option<Self> {
        self.way = ray_form::way(&self, size)?;
        Some(self)
    }

    /// Viewer direction at normalised coordinates, any length; `None` where the ray does not end on the screen.
    pub fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let direction = self.pencil.evaluate(&self.direction, x, y)?;
        self.rim.as_ref().is_none_or(|rim| rim.allow(&self.pencil, x, y)).then_some(direction)
    }
}

/// Another projector, as seen from a pixel's hit on the screen.
#[derive(Clone, Debug, PartialEq)]
pub struct Neighbour {
    /// Index of the output.
    pub output: usize,
    /// Its homogeneous picture coordinates.
    pub picture: QuadraticForm,
    /// Its claim on points.
    pub border: Border,
}

/// Rectangles of one output that the same specialised shader draws.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Indices of the views that its pixels sample, in order of precedence.
    pub views: Vec<usize>,
    /// Indices into the output's neighbours whose pictures overlap here; empty = no blending from overlap.
    pub neighbours: Vec<usize>,
    /// Some pixels show nothing (rim of a circle, off the screen): the shader must test.
    pub edge: bool,
    /// The output's mask, if it has one, is not white there.
    pub masked: bool,
    /// Where.
    pub rects: Vec<PixelRect>,
    /// Triangles that are drawn in place of the rectangles; what their corners say is shown, not what the output's
    /// source does.
    pub facets: Option<Arc<Facets>>,
}

/// Plans the views and the passes of `rig`: deterministic, and without a graphics API; it reads the masks' files.
///
/// A rig with `passthrough` has no passes. Every pixel whose centre shows something is in exactly
/// one batch, and the batch's views contain the one that answers for the pixel; but blocks of pixels that a
/// mask makes black are in none, if nothing is added to the output's black.
///
/// # Errors
///
/// Those of [`views::plan`] and [`WarpMap::new`](crate::warp::WarpMap::new); [`Io`](crate::ErrorKind::Io) or [`InvalidRig`](crate::ErrorKind::InvalidRig) if a mask cannot be read.
pub fn build(rig: &Rig, request: &Request) -> Result<Plan> {
    build_with(rig, request, &Cache::none())
}

/// As [`build`]; `cache` may know which views are chosen and what is in tables, or keeps it.
///
/// # Errors
/// As [`build`].
pub fn build_with(rig: &Rig, request: &Request, cache: &Cache) -> Result<Plan> {
    let flips = rig.outputs.iter().map(|output| output.flip);
    let rig = &*rig.upright();
    // What is outside of the window is not drawn; its size only has to be one.
    let sizes: Vec<_> = request.output_sizes.iter().map(|&(width, height)| (width.max(1), height.max(1))).collect();
    let sizes = sizes.as_slice();
    let domes = dome_meshes(rig, sizes)?;
    let views = views::plan_with_reach(rig, request, reach(rig, &domes), cache)?;
    let mut passes = Vec::new();
    let lift = match rig.outputs.iter().any(|output| output.blend.contrast.is_some()) {
        true => Weights::new(rig, sizes)?.greatest_black(),
        false => 0.0,
    };
    if !rig.passthrough {
        for (index, ((output, &size), flip)) in rig.outputs.iter().zip(sizes).zip(flips).enumerate() {
            let source = output_source::of(rig, index, sizes, cache)?;
            // A table has them in its weights.
            let ramps = if matches!(source, Source::Table(_)) { Vec::new() } else { output.blend.ramps.clone() };
            let mask = output.mask.as_deref().map(mask::load).transpose()?;
            let batches = match request.output_sizes[index] {
                (0, 0) => Vec::new(),
                _ => {
                    let picture = blocks::Picture { source: &source, size, mask: mask.as_ref(), flip };
                    blocks::batches(rig, index, &picture, &views, cache)
                }
            };
            let batches = match output.method {
                Method::Fragment | Method::Vertex | Method::Primitive { .. } => batches,
                Method::Table { .. } => match &source {
                    Source::Table(table) if table.step() > 1 => only_lit(batches, &source, size),
                    _ => batches,
                },
                Method::Mesh { max_error } => {
                    meshed(only_lit(batches, &source, size), &Shown::new(rig, index, sizes)?, max_error)
                }
                Method::CubeMesh { .. } => with_dome(batches, &views.output_views[index], domes[index].clone()),
            };
            // Meshes and coarse tables do not know how many pictures meet at their pixels.
            let knows_black = match &source {
                Source::Table(table) => table.step() == 1,
                _ => output.method == Method::Fragment || output.method.projects_vertices(),
            };
            passes.push(OutputPass {
                name: output.name.clone(),
                size,
                batches,
                lift: if knows_black && output.blend.overlap { lift } else { 0.0 },
                source,
                mask: mask.map(|mask| mask.flipped(flip)),
                ramps,
                dome_rotation: output_source::dome_axes(rig),
                filter: rig.views.filter,
                gamma: output.blend.gamma,
                transfer: output.blend.transfer.clone(),
                black_level: output.blend.black_level,
                black: output.black.as_deref().map(|black| BlackPicture::of(black, &output.blend, flip)),
                dither: output.blend.dither.map_or(0.0, |bits| 1.0 / (f64::from(bits).exp2() - 1.0)),
                flip,
            });
        }
    }
    Ok(Plan { views, passes })
}

/// Views have at most so many texels around what outputs sample, however wrong a mesh is.
const MOST_REACH: f64 = 64.0;
/// Texels for a pixel's error: views have one for each pixel in their middle, and 1/cos² of the angle from it, here 60°.
const TEXELS_PER_PIXEL: f64 = 4.0;

/// How far beside its exact place an output may sample a view, texels.
fn reach(rig: &Rig, domes: &[Option<Arc<Facets>>]) -> u32 {
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
                let shown = Shown::new(rig, index, sizes)?;
                Ok(Some(Arc::new(facets::dome_facets(rig, index, &shown, density))))
            }
            _ => Ok(None),
        })
        .collect()
}

/// The batches without pixels that show nothing.
fn only_lit(batches: Vec<Batch>, source: &Source, size: (u32, u32)) -> Vec<Batch> {
    batches.into_iter().map(|batch| facets::rims::only_lit(batch, source, size)).collect()
}

/// The batches, drawn as triangles with a greatest error in pixels.
fn meshed(batches: Vec<Batch>, shown: &Shown, max_error: f64) -> Vec<Batch> {
    let meshed = |batch: Batch| {
        let facets = Some(Arc::new(Facets::within(shown, &batch.rects, max_error)));
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
