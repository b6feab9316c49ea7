//! A picture of the views on the sphere of directions: two halves with equal areas, coloured by
//! sharpness.

use super::figures::Figures;
use crate::canvas::{Canvas, Color, Letters};
use crate::failure::Failure;
use cupola::geom::Frustum;
use cupola::geom::cube::Face;
use cupola::rig::Rig;
use cupola::views::{Request, View, ViewPlan, survey};
use glam::{DMat3, DVec2, DVec3};
use std::path::Path;

const RADIUS: f64 = 380.0;
const TOP: f64 = 120.0;
const SIZE: (usize, usize) = (1680, 1040);
/// Number of pixels of each output that are examined for the colours.
const SURVEYED: u32 = 3 << 20;
/// A little more than half the width of an outline, in radians near the centre of a half.
const INSET: f64 = 0.0065;
/// Number of texels per pixel from which on the colour stays the same.
const SHARPEST: f64 = 3.0;

const GROUND: Color = [0.075, 0.085, 0.11];
const SPHERE: Color = [0.13, 0.145, 0.18];
const GRID: Color = [0.30, 0.33, 0.40];
const INK: Color = [0.90, 0.92, 0.95];
const FAINT: Color = [0.60, 0.64, 0.70];
const JUMP: Color = [1.00, 0.25, 0.25];
/// Colours of the outlines of views, used in turn.
const OUTLINES: [Color; 8] = [
    [1.00, 0.47, 0.36],
    [0.40, 0.76, 1.00],
    [1.00, 0.82, 0.30],
    [0.80, 0.56, 1.00],
    [0.55, 0.95, 0.60],
    [1.00, 0.60, 0.85],
    [0.60, 0.95, 0.95],
    [0.95, 0.95, 0.95],
];

/// One half of the sphere: Lambert's equal-area projection around `face`.
struct Half {
    face: Face,
    /// Viewer axes → right, up and backward axis of this picture.
    axes: DMat3,
    centre: DVec2,
}

impl Half {
    fn new(face: Face, index: usize) -> Self {
        let x = 0.25 * SIZE.0 as f64 + 0.5 * SIZE.0 as f64 * index as f64;
        Self { face, axes: face.rotation(), centre: DVec2::new(x, TOP + RADIUS) }
    }

    /// Position of a direction (unit length) in the picture; `None` if it is in the other half.
    fn place(&self, direction: DVec3) -> Option<DVec2> {
        let local = self.axes * direction;
        // Both halves show directions on the rim.
        (local.z <= 1e-9).then(|| {
            let scale = RADIUS / (1.0 - local.z).max(1.0).sqrt();
            self.centre + DVec2::new(local.x, -local.y) * scale
        })
    }

    fn name(&self) -> &'static str {
        match self.face {
            Face::Front => "front half: straight ahead in the centre, up is up",
            Face::Back => "back half: straight behind in the centre, up is up",
            Face::Up => "upper half: zenith in the centre, front at the bottom",
            Face::Down => "lower half: nadir in the centre, front at the top",
            Face::Left => "left half: left in the centre, up is up",
            Face::Right => "right half: right in the centre, up is up",
        }
    }
}

/// Draws the plan and writes it to a PNG file.
pub fn write(file: &Path, rig: &Rig, request: &Request, plan: &ViewPlan, figures: &Figures) -> Result<(), Failure> {
    let canvas = draw(rig, request, plan, figures);
    let (width, height) = (canvas.width as u32, canvas.height as u32);
    image::save_buffer(file, &canvas.bytes(), width, height, image::ExtendedColorType::Rgb8)
        .map_err(|error| Failure::new(format!("{} cannot be written: {error}", file.display())))
}

fn draw(rig: &Rig, request: &Request, plan: &ViewPlan, figures: &Figures) -> Canvas {
    let mut canvas = Canvas::new(SIZE.0, SIZE.1, GROUND);
    let mut middles = vec![DVec3::ZERO; plan.views.len()];
    let mut seen = Vec::new();
    survey(plan, rig, &request.output_sizes, SURVEYED, |pixel| {
        middles[pixel.view] += pixel.direction;
        seen.push((pixel.direction, pixel.texels_per_pixel.unwrap_or(1.0) as f32));
    });
    let face = Face::of(middles.iter().sum());
    let opposite = Face::of(face.rotation().transpose() * DVec3::Z);
    let halves = [Half::new(face, 0), Half::new(opposite, 1)];
    for half in &halves {
        ball(&mut canvas, half);
        shade(&mut canvas, half, &seen);
        grid(&mut canvas, half);
        for (view, color) in plan.views.iter().zip(OUTLINES.iter().cycle()) {
            outline(&mut canvas, half, view, *color);
        }
        for ((view, middle), color) in plan.views.iter().zip(&middles).zip(OUTLINES.iter().cycle()) {
            let place = half.place(middle.normalize_or_zero()).filter(|_| middle.length_squared() > 0.0);
            if let Some(place) = place {
                canvas.label(&view.name, place.to_array(), *color);
            }
        }
        for (direction, _) in &figures.jumps {
            cross(&mut canvas, half, *direction);
        }
        let width = half.name().chars().count() as i64 * 8;
        let below = (half.centre.y + RADIUS + 14.0) as i64;
        canvas.text(half.name(), half.centre.x as i64 - width / 2, below, Letters::Small, FAINT);
    }
    words(&mut canvas, plan, figures);
    legend(&mut canvas);
    if !figures.jumps.is_empty() {
        let words = "crosses: the light must change abruptly between outputs there";
        canvas.text(words, 552, SIZE.1 as i64 - 52, Letters::Small, JUMP);
    }
    canvas
}

/// Draws the sphere where nothing is sampled.
fn ball(canvas: &mut Canvas, half: &Half) {
    for_disc(half, |x, y, distance| canvas.blend(x, y, SPHERE, (RADIUS + 0.5 - distance).clamp(0.0, 1.0) as f32));
}

/// Calls `visit` for the pixels of a half, with their distance from its centre.
fn for_disc(half: &Half, mut visit: impl FnMut(i64, i64, f64)) {
    let reach = RADIUS as i64 + 2;
    let (x, y) = (half.centre.x as i64, half.centre.y as i64);
    for (y, x) in (y - reach..=y + reach).flat_map(|y| (x - reach..=x + reach).map(move |x| (y, x))) {
        let distance = DVec2::new(x as f64 + 0.5, y as f64 + 0.5).distance(half.centre);
        if distance < RADIUS + 1.0 {
            visit(x, y, distance);
        }
    }
}

/// Colours the sampled directions by sharpness; by the lowest one where several outputs sample a
/// direction.
fn shade(canvas: &mut Canvas, half: &Half, seen: &[(DVec3, f32)]) {
    // The grid is up to twice as fine as the picture, so that borders are smooth. It is coarser if
    // few pixels were examined, so that on average four of them fall into a cell.
    let scale = (seen.len() as f64 / (4.0 * std::f64::consts::PI * RADIUS * RADIUS)).sqrt().clamp(0.02, 2.0);
    let side = (scale * (2.0 * RADIUS + 4.0)).ceil() as usize;
    let origin = half.centre - RADIUS - 2.0;
    let cell_at = |place: DVec2| {
        let at = ((place - origin) * scale).clamp(DVec2::ZERO, DVec2::splat(side as f64 - 1.0));
        at.y as usize * side + at.x as usize
    };
    let mut sharpness = vec![f32::INFINITY; side * side];
    for (direction, texels) in seen {
        if let Some(place) = half.place(*direction) {
            let cell = &mut sharpness[cell_at(place)];
            *cell = cell.min(*texels);
        }
    }
    let filled: Vec<f32> = (0..side * side).map(|cell| filled(&sharpness, side, cell)).collect();
    for_disc(half, |x, y, distance| {
        if distance > RADIUS {
            return;
        }
        for (u, v) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
            let texels = filled[cell_at(DVec2::new(x as f64 + u, y as f64 + v))];
            if texels.is_finite() {
                // Each of the four samples covers a part of the remaining area.
                canvas.blend(x, y, color_of(f64::from(texels)), 0.75);
            }
        }
    });
}

/// The value of a cell, or of its neighbours where no direction fell into it.
fn filled(sharpness: &[f32], side: usize, cell: usize) -> f32 {
    if sharpness[cell].is_finite() {
        return sharpness[cell];
    }
    let (x, y) = (cell % side, cell / side);
    let finite = |dx: usize, dy: usize| {
        let (x, y) = ((x + dx).checked_sub(1)?, (y + dy).checked_sub(1)?);
        (x < side && y < side).then(|| sharpness[y * side + x]).filter(|value| value.is_finite())
    };
    let around: Vec<f32> = [(0, 1), (2, 1), (1, 0), (1, 2)].into_iter().filter_map(|(x, y)| finite(x, y)).collect();
    // At the border of the sampled area only one side has values: this is not a hole.
    if around.len() >= 2 { around.into_iter().fold(f32::INFINITY, f32::min) } else { f32::INFINITY }
}

/// Colour of a number of texels per pixel: dark blue for one, then green, yellow for many.
fn color_of(texels: f64) -> Color {
    const STOPS: [Color; 5] =
        [[0.23, 0.22, 0.50], [0.18, 0.38, 0.56], [0.13, 0.55, 0.55], [0.34, 0.72, 0.40], [0.90, 0.86, 0.25]];
    if texels < 0.999 {
        return [0.75, 0.10, 0.12];
    }
    let at = ((texels - 1.0) / (SHARPEST - 1.0)).clamp(0.0, 1.0) as f32 * (STOPS.len() - 1) as f32;
    let index = (at as usize).min(STOPS.len() - 2);
    let part = at - index as f32;
    std::array::from_fn(|channel| STOPS[index][channel] * (1.0 - part) + STOPS[index + 1][channel] * part)
}

/// Draws circles of equal pitch and yaw, every 30°, and the rim.
fn grid(canvas: &mut Canvas, half: &Half) {
    let direction = |yaw: f64, pitch: f64| {
        let (yaw, pitch) = (yaw.to_radians(), pitch.to_radians());
        DVec3::new(yaw.sin() * pitch.cos(), pitch.sin(), -yaw.cos() * pitch.cos())
    };
    for step in 0..12 {
        let yaw = 30.0 * f64::from(step);
        curve(canvas, half, 120, 1.0, GRID, |t| direction(yaw, 180.0 * t - 90.0));
        if step < 5 {
            curve(canvas, half, 240, 1.0, GRID, |t| direction(360.0 * t, 30.0 * f64::from(step) - 60.0));
        }
    }
    let back = half.axes.transpose();
    curve(canvas, half, 360, 1.5, GRID, |t| {
        let (sine, cosine) = (t * std::f64::consts::TAU).sin_cos();
        back * DVec3::new(cosine, sine, 0.0)
    });
}

/// Draws the four sides of the sampled part of a view. They are arcs of great circles, moved
/// inwards by half the width of a line, so that the outlines of neighbouring views lie side by
/// side.
fn outline(canvas: &mut Canvas, half: &Half, view: &View, color: Color) {
    if view.program_lens {
        return;
    }
    let owned = moved_inwards(&view.owned);
    let corner = |index: usize| {
        let (x, y) = [
            (owned.left, owned.bottom),
            (owned.right, owned.bottom),
            (owned.right, owned.top),
            (owned.left, owned.top),
        ][index % 4];
        DVec2::new(x, y)
    };
    let to_viewer = view.rotation.transpose();
    for side in 0..4 {
        curve(canvas, half, 160, 2.5, color, |t| {
            (to_viewer * corner(side).lerp(corner(side + 1), t).extend(-1.0)).normalize()
        });
    }
}

/// The opening with its sides moved inwards by [`INSET`] radians, less if the opening is narrow.
fn moved_inwards(opening: &Frustum) -> Frustum {
    let side = |low: f64, high: f64| {
        let by = |at: f64| (INSET * (1.0 + at * at)).min(0.25 * (high - low));
        (low + by(low), high - by(high))
    };
    let ((left, right), (bottom, top)) = (side(opening.left, opening.right), side(opening.bottom, opening.top));
    Frustum { left, right, bottom, top }
}

/// Draws the part of a curve of directions, `at(0…1)`, that lies in this half.
fn curve(canvas: &mut Canvas, half: &Half, steps: u32, width: f64, color: Color, at: impl Fn(f64) -> DVec3) {
    let mut before = None;
    for step in 0..=steps {
        let place = half.place(at(f64::from(step) / f64::from(steps)));
        if let (Some(from), Some(to)) = (before, place) {
            let (from, to): (DVec2, DVec2) = (from, to);
            canvas.line(from.to_array(), to.to_array(), width, color);
        }
        before = place;
    }
}

/// Draws a cross where the light must change abruptly.
fn cross(canvas: &mut Canvas, half: &Half, direction: DVec3) {
    let Some(place) = half.place(direction) else { return };
    for (color, width) in [(GROUND, 6.0), (JUMP, 3.0)] {
        for arm in [DVec2::new(9.0, 9.0), DVec2::new(9.0, -9.0)] {
            canvas.line((place - arm).to_array(), (place + arm).to_array(), width, color);
        }
    }
}

fn words(canvas: &mut Canvas, plan: &ViewPlan, figures: &Figures) {
    let report = &figures.report;
    let title = format!("{}: {} view{}", figures.rig, plan.views.len(), if plan.views.len() == 1 { "" } else { "s" });
    canvas.text(&title, 40, 28, Letters::Large, INK);
    let mut line = format!(
        "{:.2} texels drawn per pixel, {:.2} of them sampled",
        report.texels_per_pixel,
        figures.sampled_per_pixel()
    );
    if let Some(least) = figures.least {
        line += &format!("; at least {least:.3} texels per pixel in {} directions", figures.directions);
    }
    canvas.text(&line, 40, 64, Letters::Small, FAINT);
}

/// Draws the legend of the colours.
fn legend(canvas: &mut Canvas) {
    let (left, top, width) = (40i64, SIZE.1 as i64 - 72, 480i64);
    for x in 0..width {
        let texels = 1.0 + (SHARPEST - 1.0) * (x as f64 + 0.5) / width as f64;
        (0..16).for_each(|y| canvas.blend(left + x, top + y, color_of(texels), 1.0));
    }
    for tick in 0..=4 {
        let texels = 1.0 + (SHARPEST - 1.0) * f64::from(tick) / 4.0;
        let x = left + width * i64::from(tick) / 4;
        canvas.text(&format!("{texels}"), x - 4, top + 20, Letters::Small, FAINT);
    }
    let words = "lowest number of texels per pixel; red: fewer than one; grey: not sampled by an output";
    canvas.text(words, left + width + 32, top, Letters::Small, FAINT);
}
