//! The constants of a pass. The only place where f64 becomes f32: every coefficient is folded
//! in f64 and rounded once.

use crate::blend::code_of;
use crate::correct::passes::facets::FacetCorner;
use crate::correct::passes::output_pass::{Batch, OutputPass, Plan};
use crate::correct::passes::rectangle::PixelRect;
use crate::correct::passes::source::Source;
use crate::correct::shaders::draws::FLOATS;
use crate::correct::shaders::glsl::{Pass, text_of};
use crate::correct::shaders::response::encoding_polynomial;
use crate::correct::shaders::{uniforms_optics, uniforms_panorama, uniforms_projector};
use crate::error::{Error, ErrorKind, Result};
use crate::geom::division::rule::EDGE_SHARE;
use crate::geom::fisheye::{MOST_COEFFICIENTS, RadialForm, sine_cosine_polynomials};
use crate::geom::picture_map::LEAST_AHEAD;
use crate::geom::reprojection::ClipRows;
use crate::geom::{Frustum, PictureLens, PictureMap};
use crate::rig::{Blend, DomeAngle, Filter, RESPONSE_STEPS, RampShape, Transfer};
use crate::views::{View, ViewPlan};
use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

/// Most views that one batch may sample.
pub const MAX_VIEWS: usize = 8;
/// Most other projectors that may overlap one batch.
pub const MAX_NEIGHBOURS: usize = 12;
/// Most ramps in dome angles of one output.
pub const MAX_RAMPS: usize = 8;

/// How far, in texels, a view also answers for beyond its own part: nothing falls between two
/// views by rounding. What filters need beside it is in the guard (`views::layout`).
const OVERHANG: f64 = 0.125;

/// How far a view of a plan also answers, texels.
fn overhang(views: &ViewPlan) -> f64 {
    OVERHANG + f64::from(views.reach)
}

/// The rows of a re-projection as patched shaders take them: x, y, w, and (E, depth factor, depth offset, 1 for rows to
/// the axes of a curved picture's lens, otherwise 0).
pub fn clip_rows(rows: &ClipRows) -> [f32; 16] {
    let mut out = [0.0; 16];
    for (four, row) in out.chunks_exact_mut(4).zip([
        &rows.x,
        &rows.y,
        &rows.w,
        &[rows.e, rows.depth[0], rows.depth[1], f64::from(u8::from(rows.curved))],
    ]) {
        for (value, exact) in four.iter_mut().zip(row) {
            *value = *exact as f32;
        }
    }
    out
}

/// The lens of an output's own picture as patched shaders take it: (viewer, 1 − |viewer|²), (lens, 1 for a fisheye),
/// (scale, offset, of a fisheye half the aperture), (limit, error, half of the width, half of the height). The last three are in pixels: what the middle of
/// an edge may be off before it is cut (0: nothing is divided), and the picture's size. A fisheye's point is its direction in the picture times the angle from the axis
/// times scale; its limit is the angle from which on there is no picture. A pinhole's is tangent times scale minus offset;
/// its limit is the least part of a direction along the axis.
pub fn picture_lens(map: &PictureMap, pixels: DVec2, max_error: f64) -> [f32; 16] {
    let (fisheye, scale, offset, limit) = match map.lens {
        PictureLens::Fisheye { aperture, circle, .. } => {
            // A fisheye's picture is not moved: there is room for half of its aperture.
            (1.0, circle * 2.0 / aperture, DVec2::new(0.5 * aperture, 0.0), map.limit())
        }
        PictureLens::Pinhole(frustum) => {
            let ((half_x, half_y), (middle_x, middle_y)) = (frustum.half_size(), frustum.middle());
            let half = DVec2::new(half_x, half_y);
            (0.0, 1.0 / half, DVec2::new(middle_x, middle_y) / half, LEAST_AHEAD)
        }
    };
    let inside = (1.0 - map.viewer.length_squared()).max(0.0);
    let vectors = [
        map.viewer.extend(inside),
        map.position.extend(fisheye),
        DVec4::new(scale.x, scale.y, offset.x, offset.y),
        DVec4::new(limit, EDGE_SHARE * max_error, 0.5 * pixels.x, 0.5 * pixels.y),
    ];
    std::array::from_fn(|i| vectors[i / 4][i % 4] as f32)
}

/// What lies between vertices, for the driver that gets it as one.
pub fn between_vertices(value: [f64; 4]) -> [f32; 4] {
    value.map(|part| part as f32)
}

/// A length in pixels as viewports take it; exact below 2^24.
pub fn pixels(length: i32) -> f32 {
    length as f32
}

/// A matrix column by column, rounded once.
pub fn matrix(exact: &DMat4) -> [f32; 16] {
    exact.to_cols_array().map(|value| value as f32)
}

/// The values that specialise a pass's shader.
#[derive(Clone, Debug, PartialEq)]
pub struct Constants {
    pass: Pass,
    values: Vec<f32>,
    base: DMat3,
}

impl Constants {
    fn new(pass: Pass) -> Self {
        let count = text_of(pass).members.iter().map(|m| m.2).sum();
        Self { pass, values: vec![0.0; count], base: DMat3::IDENTITY }
    }

    /// The constants of the pass that shows nothing.
    pub fn black() -> Self {
        Self::new(Pass::Black)
    }

    /// Which pass they are for.
    pub fn pass(&self) -> Pass {
        self.pass
    }

    /// Viewer axes → what the views' transforms take: corners of triangles bring their directions so.
    pub(in crate::correct) fn base(&self) -> DMat3 {
        self.base
    }

    /// The scalars in the order of the shader's constant.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The scalars of the member at `path` (`shared_part.views[0].scale`); empty where there is none.
    pub fn member(&self, path: &str) -> &[f32] {
        match text_of(self.pass).members.iter().find(|m| m.0 == path) {
            Some(&(_, first, count)) => &self.values[first..first + count],
            None => &[],
        }
    }

    pub(super) fn set(&mut self, path: &str, values: &[f64]) -> Result<()> {
        let member = text_of(self.pass).members.iter().find(|m| m.0 == path && m.2 == values.len());
        let Some(&(_, first, count)) = member else {
            return Err(Error::new(
                ErrorKind::Internal,
                format!("The {:?} shader has no constant {path} of {} numbers.", self.pass, values.len()),
            ));
        };
        for (to, from) in self.values[first..first + count].iter_mut().zip(values) {
            *to = *from as f32;
            if !to.is_finite() {
                return Err(Error::new(
                    ErrorKind::Internal,
                    format!("The {:?} shader's constant {path} is {from:e}, which no f32 holds.", self.pass),
                ));
            }
        }
        Ok(())
    }

    pub(super) fn set_flag(&mut self, path: &str, flag: bool) -> Result<()> {
        self.set(path, &[f64::from(u8::from(flag))])
    }

    pub(super) fn set_matrix(&mut self, path: &str, matrix: DMat3) -> Result<()> {
        self.set(path, &matrix.to_cols_array())
    }
}

/// A view as the shaders take it.
struct Placement {
    /// View axes → (x, y, z) with `max(|x|, |y|) ≤ z` where the view answers.
    transform: DMat3,
    /// Atlas coordinates (0…1) = scale·(x, y)/z + offset.
    scale: DVec2,
    offset: DVec2,
}

impl Placement {
    /// `part` of the opening of `view` answers; texels beyond it, too, up to `overhang`.
    fn new(view: &View, part: &Frustum, overhang: f64, views: &ViewPlan) -> Self {
        let atlas = views.picture_size(view);
        let tile = DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height));
        let origin = DVec2::new(f64::from(view.tile.x), f64::from(view.tile.y));
        let atlas = DVec2::new(f64::from(atlas.0), f64::from(atlas.1));
        let opening = DVec2::new(view.frustum.width(), view.frustum.height());
        let corner = DVec2::new(view.frustum.left, view.frustum.bottom);
        let centre = DVec2::new(part.left + part.right, part.bottom + part.top) / 2.0;
        let half = DVec2::new(part.width(), part.height()) / 2.0 + overhang * opening / tile;
        let transform = DMat3::from_cols(
            DVec3::new(1.0 / half.x, 0.0, 0.0),
            DVec3::new(0.0, 1.0 / half.y, 0.0),
            DVec3::new(centre.x / half.x, centre.y / half.y, -1.0),
        );
        let texels = tile / opening;
        let middle = origin + (centre - corner) * texels;
        Self { transform, scale: half * texels / atlas, offset: middle / atlas }
    }

    /// View axes → atlas coordinates less the offset, and 1, times a positive factor in front.
    fn scaled(&self) -> DMat3 {
        DMat3::from_diagonal(self.scale.extend(1.0)) * self.transform
    }
}

/// The constants of one batch of an output; `panel`: the flat panel is shown where the plan has one.
///
/// # Errors
/// [`ErrorKind::Internal`] where the plan has more views, neighbours or ramps in one batch than
/// [`MAX_VIEWS`], [`MAX_NEIGHBOURS`], [`MAX_RAMPS`], an index that is out of range, or a value that is not finite.
pub fn constants(plan: &Plan, pass: &OutputPass, batch: &Batch, panel: bool) -> Result<Constants> {
    let mut out = Constants::new(match &pass.source {
        _ if batch.facets.is_some() => Pass::Mesh,
        Source::Fisheye { .. } => Pass::Fisheye,
        Source::Projector(_) => Pass::Projector,
        Source::Optics(_) => Pass::Optics,
        Source::Panorama { panorama, .. } if panorama.is_circular() => Pass::Fisheye,
        Source::Panorama { .. } => Pass::Panorama,
        Source::Perspective { .. } => Pass::Perspective,
        Source::Table(_) => Pass::Table,
    });
    let panel = plan.views.panel.as_ref().filter(|_| panel);
    let base = views(&mut out, plan, pass, batch, panel)?;
    out.base = base;
    shared(&mut out, pass, batch)?;
    let pictured = samples_program_lens(plan, batch) || own_picture(plan, batch).is_some();
    let filter = if pictured { Filter::Bilinear } else { pass.filter };
    out.set_flag("shared_part.cubic", filter.is_cubic())?;
    out.set_flag("shared_part.four_places", filter.has_four_places())?;
    match &pass.source {
        // Its corners have it all.
        _ if batch.facets.is_some() => {}
        Source::Fisheye { aperture, rotation, offset } => {
            circular(&mut out, ["sine", "cosine"], *aperture)?;
            out.set_matrix("rotation", turned(base, *rotation))?;
            out.set("shift", &(base * *offset).to_array())?;
            out.set_matrix("dome", pass.dome_rotation * *rotation)?;
        }
        Source::Panorama { panorama, rotation, offset } => {
            uniforms_panorama::set(&mut out, panorama)?;
            if panorama.is_circular() {
                out.set_flag("off_centre", *offset != DVec3::ZERO)?;
            }
            out.set_matrix("rotation", turned(base, *rotation))?;
            out.set("shift", &(base * *offset).to_array())?;
            out.set_matrix("dome", pass.dome_rotation * *rotation)?;
        }
        Source::Projector(source) => uniforms_projector::set(&mut out, source, batch, base)?,
        Source::Optics(source) => uniforms_optics::set(&mut out, source, batch, base)?,
        Source::Perspective { matrix } => {
            out.set_matrix("matrix", base * *matrix)?;
            out.set_matrix("dome", pass.dome_rotation * *matrix)?;
        }
        Source::Table(table) => {
            out.set_matrix("rotation", turned(base, table.axes()))?;
            out.set("half_size", &[0.5 * f64::from(pass.size.0), 0.5 * f64::from(pass.size.1)])?;
            out.set("step", &[f64::from(table.step())])?;
        }
    }
    Ok(out)
}

/// From a source's axes (→ viewer axes) to `base`: exactly the identity where that is these axes, so that compilers leave it out.
fn turned(base: DMat3, axes: DMat3) -> DMat3 {
    if base == axes.transpose() { DMat3::IDENTITY } else { base * axes }
}

/// Whether a batch samples a view with the program's own lens.
fn samples_program_lens(plan: &Plan, batch: &Batch) -> bool {
    batch.views.iter().filter_map(|&index| plan.views.views.get(index)).any(|view| view.program_lens)
}

/// Whether a batch shows one view 1:1: each pixel's centre is exactly a texel's centre, so that the
/// nearest texel is what a perfect bilinear filter would give.
pub fn copies_texels(plan: &Plan, pass: &OutputPass, batch: &Batch) -> bool {
    if let Some((_, view)) = own_picture(plan, batch) {
        return (view.tile.width, view.tile.height) == pass.size;
    }
    let (Source::Perspective { matrix }, [index]) = (&pass.source, batch.views.as_slice()) else { return false };
    let Some(view) = plan.views.views.get(*index) else { return false };
    if pass.filter != Filter::Bilinear && !samples_program_lens(plan, batch) {
        return false;
    }
    let placement = Placement::new(view, &view.owned, overhang(&plan.views), &plan.views);
    let map = placement.scaled() * view.rotation * *matrix;
    let (width, height) = (f64::from(pass.size.0), f64::from(pass.size.1));
    let atlas = plan.views.picture_size(view);
    let atlas = DVec2::new(f64::from(atlas.0), f64::from(atlas.1));
    // Where the centres of the bottom left pixel and of the others in the corners are in the atlas, in texels.
    let place = |column: f64, row: f64| {
        let at = map * DVec3::new((2.0 * column + 1.0) / width - 1.0, (2.0 * row + 1.0) / height - 1.0, 1.0);
        (at.truncate() / at.z + placement.offset) * atlas
    };
    let first = place(0.0, 0.0);
    let whole = (first - DVec2::splat(0.5) - (first - DVec2::splat(0.5)).round()).abs().max_element() < EXACT;
    let corners = [(width - 1.0, 0.0), (0.0, height - 1.0), (width - 1.0, height - 1.0)];
    whole && corners.iter().all(|&(x, y)| (place(x, y) - first - DVec2::new(x, y)).abs().max_element() < EXACT)
}

/// Texels by which a copy may miss a texel's centre.
const EXACT: f64 = 1e-3;

/// The corners of a rectangle of an output, counter-clockwise from the bottom left: clip coordinates (x, y), then the
/// source's coordinates (x, y, 0, 0).
pub fn rectangle(pass: &OutputPass, rect: &PixelRect) -> [[f32; FLOATS]; 4] {
    let (width, height) = (f64::from(pass.size.0), f64::from(pass.size.1));
    let (scale_x, scale_y) = source_scale(pass);
    let left = 2.0 * f64::from(rect.x) / width - 1.0;
    let right = 2.0 * (f64::from(rect.x) + f64::from(rect.width)) / width - 1.0;
    let top = 1.0 - 2.0 * f64::from(rect.y) / height;
    let bottom = 1.0 - 2.0 * (f64::from(rect.y) + f64::from(rect.height)) / height;
    [(left, bottom), (right, bottom), (right, top), (left, top)]
        .map(|(x, y)| [x as f32, y as f32, (x * scale_x) as f32, (y * scale_y) as f32, 0.0, 0.0])
}

/// A corner of triangles over an output: clip coordinates (x, y), direction in `base` and weight.
pub fn facet_corner(pass: &OutputPass, corner: &FacetCorner, base: DMat3) -> [f32; FLOATS] {
    let place = 2.0 * corner.place / DVec2::new(f64::from(pass.size.0), f64::from(pass.size.1)) - 1.0;
    let direction = base * corner.direction;
    [place.x, -place.y, direction.x, direction.y, direction.z, corner.weight].map(|value| value as f32)
}

/// The source's coordinates at the right and the top side of an output.
fn source_scale(pass: &OutputPass) -> (f64, f64) {
    let (width, height) = (f64::from(pass.size.0), f64::from(pass.size.1));
    match &pass.source {
        // Pixels from the middle.
        Source::Table(_) => (0.5 * width, 0.5 * height),
        // A fisheye's circle is inscribed: the unit of its coordinates is half the shorter side.
        source if source.is_circular() => (width / width.min(height), height / width.min(height)),
        _ => (1.0, 1.0),
    }
}

/// The unit direction (viewer axes) that `view` shows at a point of the atlas (0…1): the inverse of what the shaders do.
pub fn direction_at(view: &View, atlas: (u32, u32), point: DVec2) -> [f32; 3] {
    let texel = point * DVec2::new(f64::from(atlas.0), f64::from(atlas.1));
    let inside = texel - DVec2::new(f64::from(view.tile.x), f64::from(view.tile.y));
    let part = inside / DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height));
    let tangent = DVec2::new(view.frustum.left, view.frustum.bottom)
        + part * DVec2::new(view.frustum.width(), view.frustum.height());
    (view.rotation.transpose() * tangent.extend(-1.0)).normalize().as_vec3().to_array()
}

/// Sets what has to do with views; returns viewer axes → base.
fn views(out: &mut Constants, plan: &Plan, pass: &OutputPass, batch: &Batch, panel: Option<&View>) -> Result<DMat3> {
    limit("views", batch.views.len(), MAX_VIEWS)?;
    if let Some((index, view)) = own_picture(plan, batch) {
        return one_to_one(out, plan, pass, (index, view), panel).map(|()| DMat3::IDENTITY);
    }
    let mut placements = Vec::with_capacity(batch.views.len());
    for &index in &batch.views {
        let view = plan.views.views.get(index).ok_or_else(|| {
            Error::new(ErrorKind::Internal, format!("A batch samples view {index}, which the plan does not have."))
        })?;
        let placement = Placement::new(view, &view.owned, overhang(&plan.views), &plan.views);
        placements.push((index, view.rotation, placement));
    }
    let base = match placements.as_slice() {
        [(index, rotation, placement)] if !batch.edge && panel.is_none() => {
            out.set("shared_part.sole_number", &[*index as f64 + 1.0])?;
            out.set("shared_part.sole_offset", &placement.offset.to_array())?;
            return Ok(placement.scaled() * *rotation);
        }
        [(_, rotation, placement)] => placement.transform * *rotation,
        // The source's own axes: what turns them comes into the views' matrices, and rounds once less.
        _ => pass.source.axes().transpose(),
    };
    let back = base.inverse();
    out.set("shared_part.view_count", &[placements.len() as f64])?;
    for (i, (index, rotation, placement)) in placements.iter().enumerate() {
        // A product with its own inverse is the identity only up to rounding.
        let sole = placements.len() == 1;
        let transform = if sole { DMat3::IDENTITY } else { placement.transform * *rotation * back };
        view(out, &format!("shared_part.views[{i}]"), transform, placement, index + 1)?;
        let last = i + 1 == placements.len() && !batch.edge;
        out.set_flag(&format!("shared_part.views[{i}].last_resort"), last)?;
    }
    set_panel(out, plan, panel, back)?;
    Ok(base)
}

/// The view of a batch that shows the output's own picture.
fn own_picture<'a>(plan: &'a Plan, batch: &Batch) -> Option<(usize, &'a View)> {
    let [index] = batch.views.as_slice() else { return None };
    plan.views.views.get(*index).filter(|view| view.curved.is_some()).map(|view| (*index, view))
}

/// Sets the place of an output's own picture in the atlas.
fn one_to_one(
    out: &mut Constants,
    plan: &Plan,
    pass: &OutputPass,
    (index, view): (usize, &View),
    panel: Option<&View>,
) -> Result<()> {
    let atlas = plan.views.picture_size(view);
    let atlas = DVec2::new(f64::from(atlas.0), f64::from(atlas.1));
    let half = 0.5 * DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height));
    let middle = DVec2::new(f64::from(view.tile.x), f64::from(view.tile.y)) + half;
    // Source coordinates over −1…1 across the output.
    let (unit_x, unit_y) = source_scale(pass);
    // A mirrored picture has its rows in the other order.
    let up = view.rotation.determinant().signum();
    let scale = half / atlas / DVec2::new(unit_x, up * unit_y);
    let place = middle / atlas;
    out.set_flag("shared_part.one_to_one", true)?;
    out.set("shared_part.own_scale", &scale.to_array())?;
    out.set("shared_part.sole_offset", &place.to_array())?;
    out.set("shared_part.sole_number", &[index as f64 + 1.0])?;
    set_panel(out, plan, panel, DMat3::IDENTITY)
}

/// Sets the panel, if it is shown; `back`: base → viewer axes.
fn set_panel(out: &mut Constants, plan: &Plan, panel: Option<&View>, back: DMat3) -> Result<()> {
    let Some(panel) = panel else { return Ok(()) };
    let placement = Placement::new(panel, &panel.frustum, 0.0, &plan.views);
    view(out, "shared_part.panel", placement.transform * panel.rotation * back, &placement, 0)?;
    out.set_flag("shared_part.with_panel", true)
}

fn view(out: &mut Constants, path: &str, transform: DMat3, placement: &Placement, number: usize) -> Result<()> {
    out.set_matrix(&format!("{path}.transform"), transform)?;
    out.set(&format!("{path}.scale"), &placement.scale.to_array())?;
    out.set(&format!("{path}.offset"), &placement.offset.to_array())?;
    out.set(&format!("{path}.number"), &[number as f64])
}

/// Sets what every source has: edge, ramps, mask, response, black level.
fn shared(out: &mut Constants, pass: &OutputPass, batch: &Batch) -> Result<()> {
    // Corners of triangles have them in their weights.
    let ramps = if batch.facets.is_some() { &[] } else { pass.ramps.as_slice() };
    limit("ramps", ramps.len(), MAX_RAMPS)?;
    out.set_flag("shared_part.edge", batch.edge)?;
    for (i, ramp) in ramps.iter().enumerate() {
        let span = ramp.full - ramp.zero;
        // Equal ends are a step.
        let span = if span.abs() < 1e-6 { 1e-6f64.copysign(span) } else { span };
        let angle = if ramp.angle == DomeAngle::Azimuth { 1.0 } else { 0.0 };
        out.set(&format!("shared_part.ramps[{i}]"), &[angle, ramp.zero, 1.0 / span, shape(ramp.shape)])?;
    }
    out.set("shared_part.ramp_count", &[ramps.len() as f64])?;
    let masked = pass.mask.is_some() && batch.masked;
    out.set_flag("shared_part.with_mask", masked)?;
    let from_source = match (&batch.facets, &pass.source) {
        (Some(facets), _) => facets.is_weighted(),
        (None, Source::Table(table)) => table.is_weighted(),
        (None, _) => !ramps.is_empty() || !batch.neighbours.is_empty(),
    };
    let weighted = from_source || pass.lift > 0.0 || masked;
    out.set_flag("shared_part.weighted", weighted)?;
    // Only a power of light is a power of its code.
    out.set_flag("shared_part.in_light", weighted && (pass.lift > 0.0 || !pass.transfer.is_plain()))?;
    let (kind, gammas) = match &pass.transfer {
        Transfer::Power => (0.0, [pass.gamma; 3]),
        Transfer::Powers(gammas) => (0.0, *gammas),
        Transfer::Srgb => (1.0, [pass.gamma; 3]),
        Transfer::Measured(_) => (2.0, [pass.gamma; 3]),
    };
    out.set("shared_part.response", &[kind])?;
    out.set("shared_part.gamma", &gammas)?;
    for step in 0..RESPONSE_STEPS {
        // Where nothing was measured, a straight line: what is divided by must not be 0.
        let codes = match &pass.transfer {
            Transfer::Measured(responses) => [0, 1, 2].map(|channel: usize| responses[channel].codes()[step + 1]),
            _ => [(step + 1) as f64 / RESPONSE_STEPS as f64; 3],
        };
        out.set(&format!("shared_part.codes[{step}]"), &[codes[0], codes[1], codes[2], 0.0])?;
    }
    out.set("shared_part.lift", &[pass.lift])?;
    out.set("shared_part.dither", &[pass.dither])?;
    let encoding = encoding_polynomial(pass.gamma);
    out.set("shared_part.encoding[0]", &encoding[..4])?;
    out.set("shared_part.encoding[1]", &encoding[4..])?;
    let display = Blend { gamma: pass.gamma, transfer: pass.transfer.clone(), ..Blend::default() };
    out.set_flag("shared_part.with_black", pass.black.is_some())?;
    out.set("shared_part.black", &[0, 1, 2].map(|channel| code_of(pass.black_level, &display, channel)))
}

/// A ramp's shape as the shaders take it: 0 = smoothstep, negative = cosine, else the power.
pub(super) fn shape(shape: RampShape) -> f64 {
    match shape {
        RampShape::Smoothstep => 0.0,
        RampShape::Cosine => -1.0,
        RampShape::Power(power) => power,
    }
}

/// The polynomials of an angle of `aperture/2` times a coordinate: sin(angle)/coordinate and cos(angle), over the
/// coordinate's square.
pub(super) fn circular(out: &mut Constants, names: [&str; 2], aperture: f64) -> Result<()> {
    let half = aperture / 2.0;
    let fitted = sine_cosine_polynomials(aperture);
    for (name, coefficients, factor) in [(names[0], &fitted.sine, half), (names[1], &fitted.cosine, 1.0)] {
        let powers = std::iter::successors(Some(factor), |power| Some(power * half * half));
        let scaled: Vec<f64> =
            coefficients.iter().zip(powers).map(|(coefficient, power)| coefficient * power).collect();
        polynomial(out, name, &scaled)?;
    }
    Ok(())
}

/// Sets what a fisheye's point of the disc is seen by.
pub(super) fn radial(out: &mut Constants, form: &RadialForm) -> Result<()> {
    polynomial(out, "sine", &form.sine)?;
    polynomial(out, "cosine", &form.cosine)?;
    out.set("root", &[form.squeeze, form.sine_root, form.cosine_root])
}

/// Sets a polynomial, the constant first.
fn polynomial(out: &mut Constants, name: &str, coefficients: &[f64]) -> Result<()> {
    limit("polynomial coefficients", coefficients.len(), MOST_COEFFICIENTS)?;
    let mut padded = [0.0; MOST_COEFFICIENTS];
    padded[..coefficients.len()].copy_from_slice(coefficients);
    out.set(&format!("{name}[0]"), &padded[..4])?;
    out.set(&format!("{name}[1]"), &padded[4..])
}

pub(super) fn limit(what: &str, count: usize, most: usize) -> Result<()> {
    if count <= most {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Internal, format!("A batch has {count} {what}; the shaders take {most}.")))
}
