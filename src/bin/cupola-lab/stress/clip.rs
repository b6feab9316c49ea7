//! Re-projection of clip coordinates with the f32 operations of patched shaders, compared with f64.

use super::case::pick;
use super::report::Finding;
use crate::random::Random;
use cupola::geom::reprojection::{CameraAdjustment, Intrinsics, MatrixClass, classify, clip_rows};
use cupola::geom::{Face, Frustum};
use glam::{DMat4, DVec3, DVec4};

/// Number of vertices of a case.
const VERTICES: u64 = 2_000;

/// Bound on the error of the depth in normalised device coordinates.
const DEPTH: f64 = 5e-7;
/// Bound on the error of the position in pixels of a view of 2048 texels and 70° to 100°. The
/// random frusta here are very asymmetric, with sides of 0.2 to 1.2; with usual frusta the error is
/// below 3.5e-4.
const POSITION: f64 = 5e-4;

/// A random depth mapping: its name, and (E, F) with the near plane at 1.
fn depth_mapping(random: &mut Random) -> (&'static str, f64, f64) {
    let far = 10f64.powf(random.range(2.0, 9.0));
    let all = [
        ("finite", -(far + 1.0) / (far - 1.0), -2.0 * far / (far - 1.0)),
        ("zero to one", -far / (far - 1.0), -far / (far - 1.0)),
        ("reversed", 1.0 / (far - 1.0), far / (far - 1.0)),
        ("infinite", -1.0, -2.0),
        ("reversed infinite", 0.0, 1.0),
    ];
    pick(random, &all)
}

/// Errors of the worst vertex of one random frustum and view.
pub fn case(random: &mut Random) -> Vec<Finding> {
    let (name, e, f) = depth_mapping(random);
    let program = Frustum {
        left: -random.range(0.2, 1.2),
        right: random.range(0.2, 1.2),
        bottom: -random.range(0.2, 1.2),
        top: random.range(0.2, 1.2),
    };
    let mut matrix = program.projection_matrix(1.0, 2.0);
    (matrix.z_axis.z, matrix.w_axis.z) = (e, f);
    // Rounded to f32, as it reaches the driver.
    let given = DMat4::from_cols_array(&matrix.to_cols_array().map(single));
    let MatrixClass::Perspective(p) = classify(&given) else {
        return vec![finding("clip: projections not recognised", 1.0, 0.0, name)];
    };
    let turn = if random.unit() < 0.5 { pick(random, &Face::ALL).rotation() } else { random.rotation() };
    let view = Frustum::symmetric(random.range(1.2, 1.7), random.range(1.2, 1.7));
    let rows = clip_rows(&p, &CameraAdjustment::NONE, turn, &view);
    let round = |row: [f64; 4]| row.map(|value| value as f32);
    let (rx, ry, rw, e32) = (round(rows.x), round(rows.y), round(rows.w), rows.e as f32);
    let (mut depth, mut position, mut lost) = (0.0f64, 0.0f64, 0u64);
    for _ in 0..VERTICES {
        let (x, y) = (random.range(-0.95, 0.95), random.range(-0.95, 0.95));
        let direction = turn.transpose() * (view.rays() * DVec3::new(x, y, 1.0));
        let eye = direction * 10f64.powf(random.range(0.1, 5.0));
        let clip = (given * eye.extend(1.0)).as_vec4();
        let q = clip.z + e32 * clip.w;
        let dot = |row: &[f32; 4]| row[0] * clip.x + row[1] * clip.y + row[2] * clip.w;
        let (x2, y2, w2) = (dot(&rx), dot(&ry), dot(&rw));
        let z2 = q - e32 * w2;
        let exact = exact(&view, &p, turn * eye);
        depth = greater(depth, f64::from(z2 / w2) - exact.z / exact.w);
        let off = (f64::from(x2 / w2) - exact.x / exact.w).hypot(f64::from(y2 / w2) - exact.y / exact.w);
        position = greater(position, off * 1024.0);
        // A vertex of a sky with z = w. It must not move beyond the far plane.
        let sky = if clip.w == clip.z { w2 } else { (clip.w + e32 * clip.w) - e32 * w2 };
        lost += u64::from(name == "infinite" && sky > w2);
    }
    vec![
        finding("clip: depth, normalised device coordinates", depth, DEPTH, name),
        finding("clip: position, px of 2048", position, POSITION, name),
        finding("clip: sky vertices lost", lost as f64, 0.0, name),
    ]
}

/// The vertex in the clip coordinates of the view, computed in f64.
fn exact(view: &Frustum, p: &Intrinsics, eye: DVec3) -> DVec4 {
    let mut matrix = view.projection_matrix(1.0, 2.0);
    matrix.z_axis.z = p.e;
    matrix.w_axis.z = p.f.unwrap_or(0.0);
    matrix * eye.extend(1.0)
}

/// The greater of two magnitudes; NaN is the greatest.
fn greater(worst: f64, value: f64) -> f64 {
    if value.is_nan() || value.abs() > worst { value.abs() } else { worst }
}

/// Rounded to f32.
pub fn single(value: f64) -> f64 {
    f64::from(value as f32)
}

fn finding(quantity: &'static str, value: f64, bound: f64, name: &str) -> Finding {
    Finding { quantity, value, bound, compared: VERTICES, pixels: false, input: format!("depth mapping: {name}") }
}
