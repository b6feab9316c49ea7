//! The constants of a batch, with which the shaders of its pass are specialised.

use crate::blend::code_of;
use crate::correct::passes::facets::FacetCorner;
use crate::correct::passes::output_pass::{Batch, OutputPass, Plan};
use crate::correct::passes::source::Source;
use crate::correct::shaders::constants::{
    Constants, FisheyeConstants, MAX_RAMPS, MAX_VIEWS, MeshConstants, PerspectiveConstants, Shared, TableConstants,
    Values, View as ShaderView, limit,
};
use crate::correct::shaders::polynomials::{circular, shape, two_vectors};
use crate::correct::shaders::response::encoding_polynomial;
use crate::correct::shaders::{uniforms_content, uniforms_optics, uniforms_panorama, uniforms_projector};
use crate::correct::single;
use crate::error::{Error, ErrorKind, Result};
use crate::geom::Frustum;
use crate::geom::rectangle::PixelRect;
use crate::rig::{Blend, DomeAngle, Filter, RESPONSE_STEPS, Transfer};
use crate::views::{View, ViewPlan};
use glam::{DMat3, DVec2, DVec3};

/// Numbers per vertex: clip coordinates (x, y), the source's coordinates: (x, y, 0, 0) or a
/// direction and a weight.
pub const FLOATS: usize = 6;
/// Number of the source's coordinates among them, the last ones.
pub const SOURCE_FLOATS: usize = 4;

/// Overlap between neighbouring views, in texels, so that rounding leaves no gap. The guard
/// contains the additional texels for filters (`views::placing::layout`).
const OVERLAP: f64 = 0.125;

/// Returns the overlap of the views of a plan, texels.
fn overlap(views: &ViewPlan) -> f64 {
    OVERLAP + f64::from(views.sampling_margin)
}

/// Transform of a view for the shaders.
struct Placement {
    /// View axes → (x, y, z) with `max(|x|, |y|) ≤ z` where the view is sampled.
    transform: DMat3,
    /// Atlas coordinates (0…1) = scale·(x, y)/z + offset.
    scale: DVec2,
    offset: DVec2,
}

impl Placement {
    /// Makes the transform. `part`: part of the opening of `view` that is sampled, widened by
    /// `overlap` texels.
    fn new(view: &View, part: &Frustum, overlap: f64, views: &ViewPlan) -> Self {
        let atlas = views.picture_size(view);
        let tile = DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height));
        let origin = DVec2::new(f64::from(view.tile.x), f64::from(view.tile.y));
        let atlas = DVec2::new(f64::from(atlas.0), f64::from(atlas.1));
        let opening = DVec2::new(view.frustum.width(), view.frustum.height());
        let corner = DVec2::new(view.frustum.left, view.frustum.bottom);
        let centre = DVec2::new(part.left + part.right, part.bottom + part.top) / 2.0;
        let half = DVec2::new(part.width(), part.height()) / 2.0 + overlap * opening / tile;
        let transform = DMat3::from_cols(
            DVec3::new(1.0 / half.x, 0.0, 0.0),
            DVec3::new(0.0, 1.0 / half.y, 0.0),
            DVec3::new(centre.x / half.x, centre.y / half.y, -1.0),
        );
        let texels = tile / opening;
        let middle = origin + (centre - corner) * texels;
        Self { transform, scale: half * texels / atlas, offset: middle / atlas }
    }

    /// Returns the matrix from view axes to (atlas coordinates minus the offset, 1), up to a factor
    /// that is positive in front of the view.
    fn scaled(&self) -> DMat3 {
        DMat3::from_diagonal(self.scale.extend(1.0)) * self.transform
    }
}

/// Returns the constants of one batch of an output; `panel`: the flat panel is shown where the plan
/// has one.
///
/// # Errors
/// [`ErrorKind::Internal`] where the plan has more views, neighbours or ramps in one batch than
/// [`MAX_VIEWS`], [`MAX_NEIGHBOURS`](crate::correct::shaders::constants::MAX_NEIGHBOURS),
/// [`MAX_RAMPS`], an index that is out of range, or a value that is not finite.
pub fn constants(plan: &Plan, pass: &OutputPass, batch: &Batch, panel: bool) -> Result<Constants> {
    let panel = plan.views.panel.as_ref().filter(|_| panel);
    let (base, shared_part) = views(plan, pass, batch, panel)?;
    let pictured = pass.content.is_none() && samples_program_lens(plan, batch) || own_picture(plan, batch).is_some();
    let filter = if pictured { Filter::Bilinear } else { pass.filter };
    let shared_part = Shared {
        cubic: filter.is_cubic().into(),
        four_places: filter.has_four_places().into(),
        ..shared(shared_part, pass, batch)?
    };
    let values = match &pass.source {
        // The corners of facets contain direction and weight.
        _ if batch.facets.is_some() => Values::Mesh(Box::new(MeshConstants { shared_part })),
        Source::Fisheye { aperture, rotation, offset } => {
            let (sine, cosine) = circular(*aperture)?;
            Values::Fisheye(Box::new(FisheyeConstants {
                shared_part,
                sine,
                cosine,
                rotation: single::matrix3(turned(base, *rotation)),
                shift: single::values((base * *offset).to_array()),
                dome: single::matrix3(pass.dome_rotation * *rotation),
                ..FisheyeConstants::default()
            }))
        }
        Source::Panorama { panorama, rotation, offset } => {
            let axes = uniforms_panorama::Axes {
                rotation: turned(base, *rotation),
                shift: base * *offset,
                dome: pass.dome_rotation * *rotation,
                off_centre: *offset != DVec3::ZERO,
            };
            uniforms_panorama::values(panorama, &axes, shared_part)?
        }
        Source::Projector(source) => uniforms_projector::values(source, batch, base, shared_part)?,
        Source::Optics(source) => uniforms_optics::values(source, batch, base, shared_part)?,
        Source::Perspective { matrix } => Values::Perspective(Box::new(PerspectiveConstants {
            shared_part,
            matrix: single::matrix3(base * *matrix),
            dome: single::matrix3(pass.dome_rotation * *matrix),
        })),
        Source::Table(table) => Values::Table(Box::new(TableConstants {
            shared_part,
            rotation: single::matrix3(turned(base, table.axes())),
            half_size: single::values([0.5 * f64::from(pass.size.0), 0.5 * f64::from(pass.size.1)]),
            step: single::value(f64::from(table.step())),
        })),
    };
    Constants::new(values, base)
}

/// Returns the matrix from a source's axes to `base`. `axes`: source axes → viewer axes. The result
/// is exactly the identity if `base` is the source's axes, so that compilers drop it.
fn turned(base: DMat3, axes: DMat3) -> DMat3 {
    if base == axes.transpose() { DMat3::IDENTITY } else { base * axes }
}

/// True if a batch samples a view with the program's own lens.
fn samples_program_lens(plan: &Plan, batch: &Batch) -> bool {
    batch.views.iter().filter_map(|&index| plan.views.views.get(index)).any(|view| view.program_lens)
}

/// True if a batch shows one view 1:1: each pixel's centre is exactly a texel's centre, so that the
/// nearest texel is what a perfect bilinear filter would give.
pub fn copies_texels(plan: &Plan, pass: &OutputPass, batch: &Batch) -> bool {
    if let Some((_, view)) = own_picture(plan, batch) {
        return (view.tile.width, view.tile.height) == pass.size;
    }
    let (&Source::Perspective { matrix }, [index], None) = (&pass.source, batch.views.as_slice(), &pass.content) else {
        return false;
    };
    let Some(view) = plan.views.views.get(*index) else { return false };
    if pass.filter != Filter::Bilinear && !samples_program_lens(plan, batch) {
        return false;
    }
    let placement = Placement::new(view, &view.owned, overlap(&plan.views), &plan.views);
    let map = placement.scaled() * view.rotation * matrix;
    let (width, height) = (f64::from(pass.size.0), f64::from(pass.size.1));
    let atlas = plan.views.picture_size(view);
    let atlas = DVec2::new(f64::from(atlas.0), f64::from(atlas.1));
    // Place of a pixel's centre in the atlas, in texels.
    let place = |column: f64, row: f64| {
        let at = map * DVec3::new((2.0 * column + 1.0) / width - 1.0, (2.0 * row + 1.0) / height - 1.0, 1.0);
        (at.truncate() / at.z + placement.offset) * atlas
    };
    let first = place(0.0, 0.0);
    let whole = (first - DVec2::splat(0.5) - (first - DVec2::splat(0.5)).round()).abs().max_element() < EXACT;
    let corners = [(width - 1.0, 0.0), (0.0, height - 1.0), (width - 1.0, height - 1.0)];
    whole && corners.iter().all(|&(x, y)| (place(x, y) - first - DVec2::new(x, y)).abs().max_element() < EXACT)
}

/// Greatest distance of a copy from a texel's centre, texels.
const EXACT: f64 = 1e-3;

/// Returns the corners of a rectangle of an output, counter-clockwise from the bottom left: clip
/// coordinates (x, y), then the source's coordinates (x, y, 0, 0).
pub fn rectangle(pass: &OutputPass, rect: &PixelRect) -> [[f32; FLOATS]; 4] {
    let (width, height) = (f64::from(pass.size.0), f64::from(pass.size.1));
    let (scale_x, scale_y) = source_scale(pass);
    let left = 2.0 * f64::from(rect.x) / width - 1.0;
    let right = 2.0 * (f64::from(rect.x) + f64::from(rect.width)) / width - 1.0;
    let top = 1.0 - 2.0 * f64::from(rect.y) / height;
    let bottom = 1.0 - 2.0 * (f64::from(rect.y) + f64::from(rect.height)) / height;
    [(left, bottom), (right, bottom), (right, top), (left, top)]
        .map(|(x, y)| single::values([x, y, x * scale_x, y * scale_y, 0.0, 0.0]))
}

/// Returns a corner of triangles over an output: clip coordinates (x, y), direction in `base` and
/// weight.
pub fn facet_corner(pass: &OutputPass, corner: &FacetCorner, base: DMat3) -> [f32; FLOATS] {
    let place = 2.0 * corner.place / DVec2::new(f64::from(pass.size.0), f64::from(pass.size.1)) - 1.0;
    let direction = base * corner.direction;
    single::values([place.x, -place.y, direction.x, direction.y, direction.z, corner.weight])
}

/// Returns the source's coordinates at the right and the top side of an output.
fn source_scale(pass: &OutputPass) -> (f64, f64) {
    let (width, height) = (f64::from(pass.size.0), f64::from(pass.size.1));
    match &pass.source {
        // The unit is a pixel, from the middle.
        Source::Table(_) => (0.5 * width, 0.5 * height),
        // A fisheye's circle is inscribed: the unit of its coordinates is half the shorter side.
        source if source.is_circular() => (width / width.min(height), height / width.min(height)),
        _ => (1.0, 1.0),
    }
}

/// Returns the unit direction (viewer axes) that `view` shows at a point of the atlas (0…1): the
/// inverse of the shaders' computation.
pub fn direction_at(view: &View, atlas: (u32, u32), point: DVec2) -> [f32; 3] {
    let texel = point * DVec2::new(f64::from(atlas.0), f64::from(atlas.1));
    let inside = texel - DVec2::new(f64::from(view.tile.x), f64::from(view.tile.y));
    let part = inside / DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height));
    let tangent = DVec2::new(view.frustum.left, view.frustum.bottom)
        + part * DVec2::new(view.frustum.width(), view.frustum.height());
    (view.rotation.transpose() * tangent.extend(-1.0)).normalize().as_vec3().to_array()
}

/// Returns the matrix viewer axes → base, and the part of the constants that depends on views.
fn views(plan: &Plan, pass: &OutputPass, batch: &Batch, panel: Option<&View>) -> Result<(DMat3, Shared)> {
    if let Some((content, view)) = pass.content.as_ref().zip(plan.views.views.first()) {
        let (rotation, content) = (content.rotation, uniforms_content::values(content, view, &plan.views));
        return Ok((rotation, Shared { content, ..Shared::default() }));
    }
    limit("views", batch.views.len(), MAX_VIEWS)?;
    if let Some((index, view)) = own_picture(plan, batch) {
        return Ok((DMat3::IDENTITY, one_to_one(plan, pass, (index, view), panel)));
    }
    let mut placements = Vec::with_capacity(batch.views.len());
    for &index in &batch.views {
        let view = plan.views.views.get(index).ok_or_else(|| {
            Error::new(ErrorKind::Internal, format!("A batch samples view {index}, which the plan does not have."))
        })?;
        let placement = Placement::new(view, &view.owned, overlap(&plan.views), &plan.views);
        placements.push((index, view.rotation, placement));
    }
    let mut out = Shared::default();
    let base = match placements.as_slice() {
        [(index, rotation, placement)] if !batch.edge && panel.is_none() => {
            let scaled = placement.scaled() * *rotation;
            if batch.facets.as_ref().is_some_and(|facets| facets.is_rough) {
                out.sole_number = number(0);
                return Ok((moved(placement.offset) * scaled, out));
            }
            out.sole_number = number(*index);
            out.sole_offset = single::values(placement.offset.to_array());
            return Ok((scaled, out));
        }
        [(_, rotation, placement)] => placement.transform * *rotation,
        // Base is the source's own axes. Their rotation goes into the views' matrices, which saves
        // one rounding.
        _ => pass.source.axes().transpose(),
    };
    let back = base.inverse();
    out.view_count = placements.len() as u32;
    for (i, (index, rotation, placement)) in placements.iter().enumerate() {
        // A product with its own inverse is the identity only up to rounding.
        let sole = placements.len() == 1;
        let transform = if sole { DMat3::IDENTITY } else { placement.transform * *rotation * back };
        out.views[i] = shader_view(transform, placement, number(*index));
        out.views[i].last_resort = (i + 1 == placements.len() && !batch.edge).into();
    }
    set_panel(&mut out, plan, panel, back);
    Ok((base, out))
}

/// Returns the matrix that adds an offset to homogeneous coordinates.
fn moved(offset: DVec2) -> DMat3 {
    DMat3::from_cols(DVec3::X, DVec3::Y, offset.extend(1.0))
}

/// Returns the number of a view in the shaders: its index plus one.
fn number(index: usize) -> f32 {
    single::value(index as f64 + 1.0)
}

/// Returns the view of a batch that shows the output's own picture.
fn own_picture<'a>(plan: &'a Plan, batch: &Batch) -> Option<(usize, &'a View)> {
    let [index] = batch.views.as_slice() else { return None };
    plan.views.views.get(*index).filter(|view| view.curved.is_some()).map(|view| (*index, view))
}

/// Returns the constants for an output's own picture in the atlas.
fn one_to_one(plan: &Plan, pass: &OutputPass, (index, view): (usize, &View), panel: Option<&View>) -> Shared {
    let atlas = plan.views.picture_size(view);
    let atlas = DVec2::new(f64::from(atlas.0), f64::from(atlas.1));
    let half = 0.5 * DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height));
    let middle = DVec2::new(f64::from(view.tile.x), f64::from(view.tile.y)) + half;
    // Source coordinates for a unit of −1…1 across the output.
    let (unit_x, unit_y) = source_scale(pass);
    // A mirrored picture has its rows in the other order.
    let up = view.rotation.determinant().signum();
    let scale = half / atlas / DVec2::new(unit_x, up * unit_y);
    let place = middle / atlas;
    let mut out = Shared {
        one_to_one: 1,
        own_scale: single::values(scale.to_array()),
        sole_offset: single::values(place.to_array()),
        sole_number: number(index),
        ..Shared::default()
    };
    set_panel(&mut out, plan, panel, DMat3::IDENTITY);
    out
}

/// Sets the panel, if it is shown; `back`: base → viewer axes.
fn set_panel(out: &mut Shared, plan: &Plan, panel: Option<&View>, back: DMat3) {
    let Some(panel) = panel else { return };
    let placement = Placement::new(panel, &panel.frustum, 0.0, &plan.views);
    out.panel = shader_view(placement.transform * panel.rotation * back, &placement, 0.0);
    out.with_panel = 1;
}

fn shader_view(transform: DMat3, placement: &Placement, number: f32) -> ShaderView {
    ShaderView {
        transform: single::matrix3(transform),
        scale: single::values(placement.scale.to_array()),
        offset: single::values(placement.offset.to_array()),
        number,
        last_resort: 0,
    }
}

/// Adds the constants that every source has: edge, ramps, mask, response, black level.
fn shared(out: Shared, pass: &OutputPass, batch: &Batch) -> Result<Shared> {
    // The weights at the corners of triangles include the ramps.
    let ramps = if batch.facets.is_some() { &[] } else { pass.ramps.as_slice() };
    limit("ramps", ramps.len(), MAX_RAMPS)?;
    let mut shader_ramps = [[0.0; 4]; MAX_RAMPS];
    for (to, ramp) in shader_ramps.iter_mut().zip(ramps) {
        let span = ramp.full - ramp.zero;
        // Equal ends are a step.
        let span = if span.abs() < 1e-6 { 1e-6f64.copysign(span) } else { span };
        let angle = if ramp.angle == DomeAngle::Azimuth { 1.0 } else { 0.0 };
        *to = single::values([angle, ramp.zero, 1.0 / span, shape(ramp.shape)]);
    }
    let masked = pass.mask.is_some() && batch.masked;
    let from_source = match (&batch.facets, &pass.source) {
        (Some(facets), _) => facets.is_weighted(),
        (None, Source::Table(table)) => table.is_weighted(),
        (None, _) => !ramps.is_empty() || !batch.neighbours.is_empty(),
    };
    let weighted = from_source || pass.lift > 0.0 || masked;
    let (response, gammas) = match &pass.transfer {
        Transfer::Power => (0, [pass.gamma; 3]),
        Transfer::Powers(gammas) => (0, *gammas),
        Transfer::Srgb => (1, [pass.gamma; 3]),
        Transfer::Measured(_) => (2, [pass.gamma; 3]),
    };
    let mut shader_codes = [[0.0; 4]; RESPONSE_STEPS];
    for (step, to) in shader_codes.iter_mut().enumerate() {
        // Without a measurement the curve is a straight line: a divisor must not be 0.
        let codes = match &pass.transfer {
            Transfer::Measured(responses) => [0, 1, 2].map(|channel: usize| responses[channel].codes()[step + 1]),
            _ => [(step + 1) as f64 / RESPONSE_STEPS as f64; 3],
        };
        *to = single::values([codes[0], codes[1], codes[2], 0.0]);
    }
    let display = Blend { gamma: pass.gamma, transfer: pass.transfer.clone(), ..Blend::default() };
    Ok(Shared {
        edge: batch.edge.into(),
        ramps: shader_ramps,
        ramp_count: ramps.len() as u32,
        with_mask: masked.into(),
        weighted: weighted.into(),
        // Only with a power response is a factor on light a factor on codes.
        in_light: (weighted && (pass.lift > 0.0 || !pass.transfer.is_plain())).into(),
        response,
        gamma: single::values(gammas),
        codes: shader_codes,
        lift: single::value(pass.lift),
        dither: single::value(pass.dither),
        encoding: two_vectors(encoding_polynomial(pass.gamma)),
        with_black: pass.black.is_some().into(),
        black: single::values([0, 1, 2].map(|channel| code_of(pass.black_level, &display, channel))),
        ..out
    })
}
