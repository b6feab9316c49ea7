//! Sizes and places of the views in the atlas.

use crate::error::{Error, ErrorKind, Result};
use crate::geom::{Frustum, pose};
use crate::rig::{Filter, Rig};
use crate::views::arranging::planned_view::PlannedView;
use crate::views::fitting::fit::WIDENING;
use crate::views::placing::atlas;
use crate::views::view_plan::{Request, Tile, View, ViewPlan};

/// Number of texels around the sampled part of a tile.
///
/// At the border of the sampled part, bilinear filtering reads half a texel beyond it, a cubic
/// kernel one and a half. An eighth of a texel is the overlap of views (`correct::shaders`), the
/// rest is for the rounding of 32-bit shaders. Further sampling positions in a pixel need no wider
/// guard: each is sampled in the view that serves it.
fn guard(filter: Filter) -> f64 {
    if filter.is_cubic() { 1.65625 } else { 0.65625 }
}

/// Least widening of the sampled part, as a tangent: about four times the rounding error of f32. It
/// exceeds [`WIDENING`] only if texels are narrower than two millionths.
const ROUNDING: f64 = 4e-7;

/// Number of free texels between tiles.
const GUTTER: u32 = 1;

/// At this part of the requested resolution each view is one texel. If the views still do not fit,
/// the tile of the window is too large.
const LEAST_SCALE: f64 = 1e-5;

/// Sizes the views, scales them down until the atlas holds them, and places them.
/// `sampling_margin`: texels of the guard in addition to those for filters.
pub(crate) fn place(
    rig: &Rig,
    request: &Request,
    sampling_margin: u32,
    planned: &[PlannedView],
    notes: &[String],
) -> Result<ViewPlan> {
    let mut notes = notes.to_vec();
    let limit = request.max_atlas;
    let quality = rig.views.quality;
    let guard = guard(rig.views.filter) + f64::from(sampling_margin);
    let mut scale = 1.0;
    let (mut views, tiles, size) = loop {
        let views: Vec<View> = planned.iter().map(|planned| sized(planned, quality, scale, guard)).collect();
        if let Some((tiles, size)) = pack(request, &views, limit) {
            break (views, tiles, size);
        }
        let largest = views.iter().map(|view| view.tile.width.max(view.tile.height)).max().unwrap_or(0);
        if scale < LEAST_SCALE {
            return Err(too_small(request));
        }
        scale *= if largest > limit { (f64::from(limit) / f64::from(largest)).min(0.98) } else { 0.98 };
    };
    if scale < 1.0 {
        notes.push(format!(
            "the views have {:.1} % of the resolution asked for, in each direction: an atlas of {limit}×{limit} texels has no room for more",
            100.0 * scale
        ));
    }
    let mut tiles = tiles.into_iter();
    let primary = request.primary.then(|| tiles.next()).flatten();
    for view in &mut views {
        if let Some(tile) = tiles.next() {
            view.tile = tile;
        }
    }
    let panel = request.panel.then(|| tiles.next()).flatten().map(|tile| panel(rig, tile));
    let uses = |output: usize| (0..planned.len()).filter(|&view| planned[view].outputs.contains(&output)).collect();
    Ok(ViewPlan {
        output_views: (0..rig.outputs.len()).map(uses).collect(),
        views,
        atlas: size,
        panel,
        primary,
        guard: guard.ceil() as u32,
        sampling_margin,
        notes,
    })
}

fn pack(request: &Request, views: &[View], limit: u32) -> Option<(Vec<Tile>, (u32, u32))> {
    let primary = request.primary.then_some(request.window);
    let panel = request.panel.then_some(request.window);
    let sizes: Vec<(u32, u32)> =
        primary.into_iter().chain(views.iter().map(|view| (view.tile.width, view.tile.height))).chain(panel).collect();
    atlas::pack(&sizes, GUTTER, limit)
}

fn too_small(request: &Request) -> Error {
    let (width, height) = request.window;
    Error::new(
        ErrorKind::Graphics,
        format!(
            "an atlas of {limit}×{limit} texels has no room for {width}×{height} pixels of the program's window beside the views; use a smaller window",
            limit = request.max_atlas
        ),
    )
}

/// Computes one direction of a view. Returns the sampled part, widened by [`WIDENING`], the opening
/// of the tile, and its number of texels.
///
/// From the middle outwards the tile consists of the sampled part (`span`), and of the widening and
/// the guard on either side (`around`). The number of texels is rounded up, so that texels are a
/// little narrower than `density` requires. `texel` is the width with which `span` fills exactly
/// the texels that `around` leaves. Part and opening are then measured from the middle in such
/// texels. A span of 0 (a single direction) has texels of the required width.
fn side(low: f64, high: f64, density: f64, guard: f64) -> ((f64, f64), (f64, f64), u32) {
    let rounding = (ROUNDING - WIDENING / density).max(0.0);
    let (span, around) = (high - low + 2.0 * rounding, 2.0 * (WIDENING + guard));
    // 2^20 is far beyond any atlas: the loop that scales down finds it too large.
    let texels = (span * density + around).max(around + 0.5).ceil().min(1_048_576.0);
    let texel = if span > 0.0 { span / (texels - around) } else { 1.0 / density };
    let middle = 0.5 * (low + high);
    let whole = 0.5 * texel * texels;
    let half = whole - texel * guard;
    ((middle - half, middle + half), (middle - whole, middle + whole), texels as u32)
}

/// Returns the view in its final size, without a place in the atlas.
fn sized(planned: &PlannedView, quality: f64, scale: f64, guard: f64) -> View {
    let extent = planned.fit.extent;
    let (owned, frustum, (width, height)) = match planned.exact {
        Some((width, height)) => {
            let texels = |pixels: u32| (f64::from(pixels) * quality * scale).ceil().clamp(1.0, 1_048_576.0) as u32;
            let (width, height) = (texels(width), texels(height));
            let guard = if planned.program_lens || planned.curved.is_some() { 0 } else { guard.ceil() as u32 };
            let across = extent.width() / f64::from(width) * f64::from(guard);
            let up = extent.height() / f64::from(height) * f64::from(guard);
            let whole = Frustum {
                left: extent.left - across,
                right: extent.right + across,
                bottom: extent.bottom - up,
                top: extent.top + up,
            };
            (extent, whole, (width + 2 * guard, height + 2 * guard))
        }
        None => {
            let density = planned.fit.density * scale;
            let (x, whole_x, width) = side(extent.left, extent.right, density.x, guard);
            let (y, whole_y, height) = side(extent.bottom, extent.top, density.y, guard);
            let frustum = |x: (f64, f64), y: (f64, f64)| Frustum { left: x.0, right: x.1, bottom: y.0, top: y.1 };
            (frustum(x, y), frustum(whole_x, whole_y), (width, height))
        }
    };
    View {
        name: planned.name.clone(),
        rotation: planned.rotation,
        frustum,
        owned,
        tile: Tile { x: 0, y: 0, width, height },
        program_lens: planned.program_lens,
        curved: planned.curved,
        eye: planned.eye,
    }
}

/// Returns the flat panel: a window in front of the viewer.
fn panel(rig: &Rig, tile: Tile) -> View {
    let half = (0.5 * rig.overlay.width).tan();
    let half_up = half * f64::from(tile.height) / f64::from(tile.width);
    let frustum = Frustum { left: -half, right: half, bottom: -half_up, top: half_up };
    View {
        name: "panel".to_owned(),
        rotation: pose::rotation(rig.overlay.yaw, rig.overlay.pitch, 0.0).transpose(),
        frustum,
        owned: frustum,
        tile,
        program_lens: true,
        curved: None,
        eye: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_widened_by_what_rounding_moves_directions() {
        // 64 texels of 1e-9, and 64 of 1e-3: the owned part is wider on either side, by at least
        // 4e-7.
        for (texel, least) in [(1e-9, ROUNDING), (1e-3, WIDENING * 1e-3)] {
            let (low, high) = (0.3, 0.3 + 64.0 * texel);
            let ((from, to), (first, last), texels) = side(low, high, 1.0 / texel, 1.5);
            for beside in [low - from, to - high] {
                assert!((0.99..1.5).contains(&(beside / least)), "{texel}: {beside}");
            }
            assert!(first < from && to < last && texels >= 64, "{texel}: {texels}");
            assert!((last - first) / f64::from(texels) <= texel, "{texel}: no coarser");
        }
    }
}
