//! Tests of matrix classification and of reprojection, among them emulations of an f32 pipeline.

use super::*;
use crate::geom::pose::rotation;
use crate::testing::random::Random;
use glam::{DMat4, DVec3, DVec4};

/// Kinds of depth mapping that programs use: (E, F) for near 1 and a ratio far/near.
fn depth_mappings() -> Vec<(&'static str, f64, f64)> {
    let mut all = vec![("infinite", -1.0, -2.0), ("reversed infinite", 0.0, 1.0)];
    for far in [1e2f64, 1e4, 1e6, 1e9] {
        all.push(("finite", -(far + 1.0) / (far - 1.0), -2.0 * far / (far - 1.0)));
        all.push(("zero to one", -far / (far - 1.0), -far / (far - 1.0)));
        all.push(("reversed", 1.0 / (far - 1.0), far / (far - 1.0)));
    }
    all
}

fn lens(random: &mut Random, e: f64, f: f64) -> Intrinsics {
    let (a, c) = (random.range(0.5, 4.0), random.range(0.5, 4.0));
    Intrinsics { a, b: random.range(-0.5, 0.5), c, d: random.range(-0.5, 0.5), e, f: Some(f) }
}

fn matrix_of(p: &Intrinsics) -> DMat4 {
    DMat4::from_cols(
        DVec4::new(p.a, 0.0, 0.0, 0.0),
        DVec4::new(0.0, p.c, 0.0, 0.0),
        DVec4::new(p.b, p.d, p.e, -1.0),
        DVec4::new(0.0, 0.0, p.f.unwrap_or(0.0), 0.0),
    )
}

/// The matrix of a view, with its own lens and the program's depth.
fn view_matrix(frustum: &Frustum, p: &Intrinsics) -> DMat4 {
    let mut matrix = frustum.projection_matrix(1.0, 2.0);
    matrix.z_axis.z = p.e;
    matrix.w_axis.z = p.f.unwrap_or(0.0);
    matrix
}

fn rounded(m: DMat4) -> DMat4 {
    m.as_mat4().as_dmat4()
}

/// A product as a program forms it: every operation in f32.
fn product_f32(a: DMat4, b: DMat4) -> DMat4 {
    let (a, b) = (a.to_cols_array().map(|x| x as f32), b.to_cols_array().map(|x| x as f32));
    let entry = |i: usize| (0..4).map(|k| a[4 * k + i % 4] * b[4 * (i / 4) + k]).sum::<f32>();
    DMat4::from_cols_array(&std::array::from_fn(|i| f64::from(entry(i))))
}

fn perspective(class: MatrixClass) -> Intrinsics {
    match class {
        MatrixClass::Perspective(p) => p,
        other => panic!("not classified as a perspective: {other:?}"),
    }
}

#[test]
fn the_unrotated_view_is_the_identity_to_the_bit() {
    let mut random = Random::new(10);
    for _ in 0..5_000 {
        let p = lens(&mut random, -1.001, -0.2);
        let rows = clip_rows(&p, &CameraAdjustment::NONE, DMat3::IDENTITY, &p.frustum());
        let bits = [rows.x, rows.y, rows.w].map(|row| row.map(f64::to_bits));
        let one_at = |index: usize| std::array::from_fn(|i| if i == index { 1.0f64.to_bits() } else { 0 });
        assert_eq!(bits, [one_at(0), one_at(1), one_at(2)]);
        assert_eq!(rows.matrix(), DMat4::IDENTITY);
    }
    // Negative control: a lens that is different by 1e-9 is not the identity.
    let p = lens(&mut random, -1.0, -0.2);
    let other = Intrinsics { a: p.a * (1.0 + 1e-9), ..p };
    assert_ne!(clip_rows(&p, &CameraAdjustment::NONE, DMat3::IDENTITY, &other.frustum()).x, [1.0, 0.0, 0.0, 0.0]);
}

#[test]
fn agrees_with_unprojecting_turning_and_projecting() {
    let mut random = Random::new(11);
    for round in 0..3_000 {
        // Depth values for which the general inverse of the matrix is still accurate.
        let p = lens(&mut random, -1.2, -2.1);
        let own = lens(&mut random, 0.0, 0.0).frustum();
        let camera = if round % 3 == 0 {
            CameraAdjustment::NONE
        } else {
            CameraAdjustment {
                zoom: random.range(0.3, 3.0),
                shift: random.vector(-2.0, 2.0),
                rotation: random.rotation(),
            }
        };
        let turn = random.rotation();
        let rows = clip_rows(&p, &camera, turn, &own);
        let adjusted = DMat4::from_mat3(turn * camera.rotation)
            * DMat4::from_scale(DVec3::new(camera.zoom, camera.zoom, 1.0))
            * DMat4::from_translation(-camera.shift);
        let expected = view_matrix(&own, &p) * adjusted * matrix_of(&p).inverse();
        let found = rows.matrix();
        assert!(found.abs_diff_eq(expected, 1e-12), "{found}\n{expected}");
        // The row form gives the same as the matrix.
        let c = DVec4::new(random.unit(), random.unit(), random.unit(), random.unit());
        let q = c.z + rows.e * c.w;
        let dot = |r: &[f64; 4]| r[0] * c.x + r[1] * c.y + r[2] * c.w + r[3] * q;
        let w = dot(&rows.w);
        assert!(DVec4::new(dot(&rows.x), dot(&rows.y), q - rows.e * w, w).distance(found * c) < 1e-12);
    }
}

#[test]
fn the_camera_adjustment_does_what_it_says() {
    let p = Intrinsics { a: 1.5, b: 0.1, c: 2.0, d: -0.2, e: -1.0, f: Some(-0.2) };
    let view = Frustum::symmetric(1.5, 1.5);
    let seen = |camera: &CameraAdjustment, p: &Intrinsics, eye: DVec3| {
        let clip = matrix_of(p) * eye.extend(1.0);
        let result = clip_rows(p, camera, DMat3::IDENTITY, &view).matrix() * clip;
        // Back to a direction in the view's axes.
        view.rays() * DVec3::new(result.x / result.w, result.y / result.w, 1.0)
    };
    let eye = DVec3::new(0.3, -0.2, -2.0);
    let zoomed = seen(&CameraAdjustment { zoom: 3.0, ..CameraAdjustment::NONE }, &p, eye);
    assert!(zoomed.distance(DVec3::new(0.45, -0.3, -1.0)) < 1e-14, "tangents are multiplied");
    let shift = DVec3::new(0.0, 0.0, -1.0);
    let moved = CameraAdjustment { shift, ..CameraAdjustment::NONE };
    assert!(seen(&moved, &p, eye).distance(DVec3::new(0.3, -0.2, -1.0)) < 1e-14, "the eye is one unit nearer");
    let unknown = Intrinsics { f: None, ..p };
    let without = clip_rows(&unknown, &moved, DMat3::IDENTITY, &view).matrix();
    let plain = clip_rows(&p, &CameraAdjustment::NONE, DMat3::IDENTITY, &view).matrix();
    assert_eq!(without, plain, "without F the shift is ignored");
    // The camera is yawed to the right: a point ahead of it is to the right of the viewer.
    let turned = CameraAdjustment { rotation: rotation(0.4, 0.0, 0.0), ..CameraAdjustment::NONE };
    let ahead = seen(&turned, &p, DVec3::new(0.0, 0.0, -1.0));
    assert!(ahead.distance(DVec3::new(0.4f64.tan(), 0.0, -1.0)) < 1e-14);
}

/// Bounds: depth ≤ 5e-7 (rms 6e-8) in NDC, position ≤ 3.5e-4 px in a view of 2048, no sky lost.
#[test]
fn f32_depth_and_position_are_as_accurate_as_a_program_s_own() {
    let mut random = Random::new(12);
    for (name, e, f) in depth_mappings() {
        let (mut worst_depth, mut worst_position, mut squares, mut count, mut lost) = (0.0f64, 0.0f64, 0.0, 0.0, 0);
        for face in crate::geom::Face::ALL {
            // The program's matrix, as it reaches the driver: f32.
            let frustum = Frustum::symmetric(1.2, 0.8);
            let given = rounded(view_matrix(&frustum, &Intrinsics { a: 0.0, b: 0.0, c: 0.0, d: 0.0, e, f: Some(f) }));
            let p = perspective(classify(&given));
            let target = Frustum::symmetric(1.6, 1.6);
            let rows = clip_rows(&p, &CameraAdjustment::NONE, face.rotation(), &target);
            let round = |row: [f64; 4]| row.map(|x| x as f32);
            let (rx, ry, rw, e32) = (round(rows.x), round(rows.y), round(rows.w), rows.e as f32);
            for _ in 0..3_000 {
                let (x, y) = (random.range(-0.95, 0.95), random.range(-0.95, 0.95));
                let direction = face.rotation().transpose() * (target.rays() * DVec3::new(x, y, 1.0));
                let eye = direction * 10f64.powf(random.range(0.1, 5.0));
                let c = (given * eye.extend(1.0)).as_vec4();
                let q = c.z + e32 * c.w;
                let dot = |r: &[f32; 4]| r[0] * c.x + r[1] * c.y + r[2] * c.w;
                let (x2, y2, w2) = (dot(&rx), dot(&ry), dot(&rw));
                let z2 = q - e32 * w2;
                // The reference is computed in f64 throughout.
                let exact = view_matrix(&target, &p) * (face.rotation() * eye).extend(1.0);
                let depth_error = f64::from(z2 / w2) - exact.z / exact.w;
                worst_depth = worst_depth.max(depth_error.abs());
                (squares, count) = (squares + depth_error * depth_error, count + 1.0);
                let off = (f64::from(x2 / w2) - exact.x / exact.w).hypot(f64::from(y2 / w2) - exact.y / exact.w);
                worst_position = worst_position.max(off * 1024.0);
                // A sky vertex: z = w.
                let z_sky = if c.w == c.z { w2 } else { (c.w + e32 * c.w) - e32 * w2 };
                if name == "infinite" && z_sky > w2 {
                    lost += 1;
                }
            }
        }
        assert!(worst_depth <= 5e-7, "{name} {e}: depth {worst_depth:e}");
        assert!((squares / count).sqrt() <= 6e-8, "{name} {e}: depth rms {:e}", (squares / count).sqrt());
        assert!(worst_position <= 3.5e-4, "{name} {e}: {worst_position:e} px at 2048");
        assert_eq!(lost, 0, "{name}: sky vertices beyond the far plane");
    }
}

#[test]
fn bare_projections_are_taken_bit_for_bit() {
    let mut random = Random::new(13);
    for (_, e, f) in depth_mappings() {
        for _ in 0..200 {
            let p = lens(&mut random, e, f);
            for mut given in [p, perspective(classify(&rounded(matrix_of(&p))))] {
                assert_eq!(classify(&matrix_of(&given)), MatrixClass::Perspective(given));
                // Left-handed: z and w grow forward; the window shows the same.
                let mut left_handed = matrix_of(&given);
                left_handed.z_axis = -left_handed.z_axis;
                assert_eq!(classify(&left_handed), MatrixClass::Perspective(given));
                // Upside down: the lens is that of the window's picture.
                let mut upside_down = matrix_of(&given);
                upside_down.y_axis = -upside_down.y_axis;
                given.f = Some(given.f.unwrap_or(0.0));
                assert_eq!(classify(&upside_down), MatrixClass::Perspective(given));
            }
        }
    }
}

#[test]
fn lenses_are_recovered_from_f32_products() {
    let mut random = Random::new(14);
    for exponent in [0.0, 2.0, 4.0, 6.0] {
        let (mut worst, mut worst_offset, mut with_offset) = (0.0f64, 0.0f64, 0);
        for round in 0..4_000 {
            let p = perspective(classify(&rounded(matrix_of(&lens(&mut random, -1.0002, -0.20002)))));
            let mirror = if round % 4 == 0 { DVec3::new(-1.0, 1.0, 1.0) } else { DVec3::ONE };
            let scale = 10f64.powf(random.range(-3.0, 3.0));
            let model = DMat4::from_translation(random.direction() * 10f64.powf(exponent))
                * DMat4::from_mat3(random.rotation() * DMat3::from_diagonal(mirror * scale));
            let found = perspective(classify(&product_f32(matrix_of(&p), model)));
            let relative = ((found.a - p.a) / p.a).abs().max(((found.c - p.c) / p.c).abs());
            let absolute = (found.b - p.b).abs().max((found.d - p.d).abs()).max((found.e - p.e).abs());
            worst = worst.max(relative).max(absolute);
            if let (Some(found), Some(f)) = (found.f, p.f) {
                with_offset += 1;
                worst_offset = worst_offset.max(((found - f) / f).abs());
            }
        }
        assert!(worst <= 5.5e-7, "|t| = 1e{exponent}: {worst:e}");
        assert!(worst_offset <= 3e-3, "|t| = 1e{exponent}: F {worst_offset:e}");
        match exponent as i32 {
            0 => assert_eq!(with_offset, 4_000, "F is well determined near the origin"),
            6 => assert!(with_offset < 100, "F is not determined far away"),
            _ => {}
        }
    }
}

#[test]
fn everything_else_is_refused() {
    let mut random = Random::new(15);
    let mut accepted = [0, 0];
    for _ in 0..4_000 {
        let p = rounded(matrix_of(&lens(&mut random, -1.002, -0.2)));
        for (index, excess) in [1e-2, 1e-4].into_iter().enumerate() {
            let scale = DMat3::from_diagonal(DVec3::new(1.0 + excess, 1.0, 1.0));
            let model = DMat4::from_mat3(random.rotation() * scale * random.rotation());
            match classify(&product_f32(p, model)) {
                MatrixClass::Perspective(_) => accepted[index] += 1,
                MatrixClass::Stretched { e, .. } => assert!((e + 1.002).abs() < 1e-6, "{e}"),
                other => panic!("{other:?}"),
            }
        }
        let affine = DMat4::from_mat3(random.rotation() * 3.0);
        assert_eq!(classify(&affine), MatrixClass::Affine);
    }
    // A scale along the camera's own axes is another lens, not an error; a few of the random scales
    // are of this kind.
    assert!(accepted[0] <= 20 && accepted[1] <= 400, "{accepted:?} of 4000 non-uniform scales accepted");
    let p = matrix_of(&lens(&mut random, -1.002, -0.2));
    let with = |change: fn(&mut DMat4)| {
        let mut matrix = p;
        change(&mut matrix);
        classify(&matrix)
    };
    assert_eq!(with(|m| m.x_axis.x = f64::NAN), MatrixClass::Other);
    assert_eq!(with(|m| m.y_axis.y = f64::INFINITY), MatrixClass::Other);
    assert_eq!(with(|m| m.x_axis.x = 0.0), MatrixClass::Other, "singular");
    assert_eq!(with(|m| m.y_axis.x = 0.3), MatrixClass::Stretched { e: -1.002, f: Some(-0.2) }, "skewed");
    let parallel = with(|m| m.x_axis.y = m.x_axis.x * 1e9);
    assert_eq!(parallel, MatrixClass::Other, "rows of x and y are parallel but for rounding");
    assert_eq!(with(|m| m.x_axis.z = 0.3), MatrixClass::Other, "oblique near plane");
    assert_eq!(classify(&DMat4::ZERO), MatrixClass::Other);
    assert_eq!(classify(&p.transpose()), MatrixClass::Other, "a projection is not its transpose");
    let orthographic = DMat4::from_scale(DVec3::new(0.1, 0.2, -0.01));
    assert_eq!(classify(&orthographic), MatrixClass::Affine);
}

/// A view's depth with wider planes is that of a lens which has those planes.
#[test]
fn widened_planes_are_those_of_a_wider_lens() {
    let frustum = Frustum { left: -1.0, right: 0.8, bottom: -0.5, top: 1.0 };
    let turn = rotation(0.7, -0.3, 0.2);
    let camera = CameraAdjustment::NONE;
    for (near, far) in [(1.0, 1.5), (0.1, 100.0), (0.01, 1e6)] {
        let matrix = Frustum { left: -0.4, right: 0.4, bottom: -0.3, top: 0.3 }.projection_matrix(near, far);
        let MatrixClass::Perspective(p) = classify(&matrix) else { panic!("a projection") };
        let rows = clip_rows(&p, &camera, turn, &frustum).widened(&p, &camera, &frustum);
        let wider = frustum.projection_matrix(near / 3f64.sqrt(), far * 3f64.sqrt());
        let expected = wider * glam::DMat4::from_mat3(turn);
        let got = rows.matrix() * matrix;
        for (got, expected) in got.to_cols_array().into_iter().zip(expected.to_cols_array()) {
            assert!((got - expected).abs() <= 1e-9 * far.max(1.0), "{near} {far}: {got} {expected}");
        }
    }
}

/// A turned view does not cut points that a tight near plane lets through straight ahead (an
/// earlier version did).
#[test]
fn a_turned_view_loses_nothing_to_a_tight_near_plane() {
    let frustum = Frustum { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 };
    let turn = rotation(45f64.to_radians(), 0.0, 0.0);
    let camera = CameraAdjustment::NONE;
    let matrix = Frustum { left: -0.3, right: 0.3, bottom: -0.3, top: 0.3 }.projection_matrix(10.0, 12.0);
    let MatrixClass::Perspective(p) = classify(&matrix) else { panic!("a projection") };
    let tight = clip_rows(&p, &camera, turn, &frustum);
    let clip = |rows: &ClipRows, depth: f64| {
        let c = matrix * glam::DVec4::new(0.1, 0.0, -depth, 1.0);
        rows.matrix() * c
    };
    let lost = |c: glam::DVec4| c.z.abs() > c.w;
    assert!(lost(clip(&tight, 10.5)), "the negative control");
    let rows = tight.widened(&p, &camera, &frustum);
    for depth in [10.0, 10.5, 11.0, 12.0] {
        assert!(!lost(clip(&rows, depth)), "{depth}");
    }
}

/// The depth of a point in the program's own picture follows from its depth in a view, for any
/// planes.
#[test]
fn the_own_depth_follows_from_a_view_s() {
    let frustum = Frustum { left: -1.0, right: 0.8, bottom: -0.5, top: 1.0 };
    let turn = rotation(0.7, -0.3, 0.2);
    let camera = CameraAdjustment { zoom: 1.7, rotation: rotation(-0.4, 0.1, 0.0), ..CameraAdjustment::NONE };
    let finite = |near, far| Frustum { left: -0.4, right: 0.6, bottom: -0.3, top: 0.3 }.projection_matrix(near, far);
    let reversed = |mut m: DMat4| {
        (m.z_axis.z, m.w_axis.z) = (0.0, 0.1);
        m
    };
    for matrix in [finite(1.0, 1.5), finite(0.1, 100.0), finite(0.01, 1e6), reversed(finite(0.1, 10.0))] {
        let MatrixClass::Perspective(p) = classify(&matrix) else { panic!("a projection") };
        let rows = clip_rows(&p, &camera, turn, &frustum).widened(&p, &camera, &frustum);
        for eye in [DVec3::new(0.2, -0.1, -1.1), DVec3::new(-0.4, 0.3, -3.0), DVec3::new(9.0, 1.0, -70.0)] {
            let own = matrix * eye.extend(1.0);
            let view = rows.matrix() * own;
            let got = rows.own_depth(view.z / view.w, view.w / own.w);
            assert!((got - own.z / own.w).abs() < 1e-12, "{eye}: {got} for {}", own.z / own.w);
        }
    }
}

/// A reversed infinite depth (1 at the near plane, 0 at infinity) stays reversed and infinite.
#[test]
fn widening_keeps_a_reversed_infinite_depth_in_its_range() {
    let p = Intrinsics { a: 2.0, b: 0.0, c: 2.0, d: 0.0, e: 0.0, f: Some(0.1) };
    let frustum = Frustum { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 };
    let rows = clip_rows(&p, &CameraAdjustment::NONE, DMat3::IDENTITY, &frustum).widened(
        &p,
        &CameraAdjustment::NONE,
        &frustum,
    );
    let [scale, offset] = rows.depth;
    assert!(scale > 0.0 && scale < 1.0, "nearer things get the depths that the program's near plane had: {scale}");
    assert!(offset.abs() < 1e-15, "infinity stays at depth 0: {offset}");
}
