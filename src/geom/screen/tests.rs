use super::*;
use crate::geom::Sphere;
use crate::testing::random::Random;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Triangles of the unit sphere, `n` by `2n` pairs, counter-clockwise as seen from inside.
fn ball(n: u32) -> Vec<Triangle> {
    // The numbers are the same on both sides of the seam and at the poles, so that corners that
    // triangles share are equal.
    let point = |i: u32, j: u32| {
        let (polar, around) = (PI * f64::from(i) / f64::from(n), PI * f64::from(j % (2 * n)) / f64::from(n));
        if i == 0 || i == n {
            return DVec3::Y * (1.0 - 2.0 * f64::from(i / n));
        }
        DVec3::new(polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin())
    };
    let cell = |i: u32, j: u32| [point(i, j), point(i, j + 1), point(i + 1, j), point(i + 1, j + 1)];
    (0..n).flat_map(|i| (0..2 * n).map(move |j| cell(i, j))).flat_map(|[a, b, c, d]| [[a, c, b], [b, c, d]]).collect()
}

fn mesh(triangles: Vec<Triangle>, faces: Faces) -> Mesh {
    Mesh::new(triangles, faces).expect("usable")
}

#[test]
fn hits_lie_on_the_surface_on_the_ray_and_on_its_inside() {
    let mut random = Random::new(71);
    let ellipsoid = Ellipsoid { radii: DVec3::new(6.0, 4.0, 5.0), region: Region::ALL };
    let cylinder = Cone { heights: [-1.0, 3.0], radii: [5.0, 5.0], azimuth: None };
    let cone = Cone { heights: [-2.0, 4.0], radii: [5.0, 1.0], azimuth: None };
    type Equation<'a> = &'a dyn Fn(DVec3) -> f64;
    let surfaces: [(&dyn Surface, Equation); 3] = [
        (&ellipsoid, &|p| (p / DVec3::new(6.0, 4.0, 5.0)).length() - 1.0),
        (&cylinder, &|p| p.x.hypot(p.z) / 5.0 - 1.0),
        (&cone, &|p| p.x.hypot(p.z) / (5.0 - (p.y + 2.0) * 4.0 / 6.0) - 1.0),
    ];
    for (surface, equation) in surfaces {
        let mut seen = 0;
        for _ in 0..20_000 {
            let origin = random.vector(-1.0, 1.0);
            let direction = random.direction() * 10f64.powf(random.range(-100.0, 100.0));
            let Some(hit) = surface.hit(origin, direction) else { continue };
            let path = hit.point - origin;
            assert!(equation(hit.point).abs() < 1e-13, "{hit:?}");
            assert!(path.normalize().distance(direction.normalize()) < 1e-13, "{hit:?}");
            assert!(path.dot(hit.normal) < 0.0 && (hit.normal.length() - 1.0).abs() < 1e-14, "lit from inside");
            // Along the surface the equation does not change.
            let across = hit.normal.any_orthonormal_vector() * 1e-6;
            assert!(equation(hit.point + across).abs() < 1e-11, "the normal is perpendicular to the surface");
            seen += 1;
        }
        assert!(seen > 5_000, "{seen}");
    }
}

#[test]
fn from_afar_a_cone_is_hit_as_exactly() {
    let mut random = Random::new(72);
    let cone = Cone { heights: [-2.0, 4.0], radii: [5.0, 3.0], azimuth: None };
    for distance in [10.0, 1e3, 1e6] {
        for _ in 0..2_000 {
            let around = random.range(0.0, 2.0 * PI);
            let height = random.range(-1.9, 3.9);
            let radius = 5.0 - (height + 2.0) / 3.0;
            let target = DVec3::new(around.sin() * radius, height, around.cos() * radius);
            // From the other side, so that the ray leaves the inside at the target.
            let towards = DVec3::new(-target.x, random.range(-1.0, 1.0), -target.z).normalize();
            let origin = target + towards * distance;
            let hit = cone.hit(origin, target - origin).expect("the target is on the ray");
            assert!(
                hit.point.distance(target) < 4e-15 * (distance + 10.0),
                "{distance} {}",
                hit.point.distance(target)
            );
        }
    }
}

#[test]
fn regions_and_rims() {
    let dome = Ellipsoid { radii: DVec3::splat(2.0), region: Region { polar: FRAC_PI_2, azimuth: Some([-1.0, 0.5]) } };
    let towards = |azimuth: f64, up: f64| DVec3::new(azimuth.sin(), up, -azimuth.cos());
    for (azimuth, up, lit) in
        [(0.0, 0.3, true), (0.49, 0.3, true), (0.51, 0.3, false), (-1.01, 0.3, false), (0.0, -0.1, false)]
    {
        assert_eq!(dome.hit(DVec3::ZERO, towards(azimuth, up)).is_some(), lit, "{azimuth} {up}");
        assert!(dome.unbounded_hit(DVec3::ZERO, towards(azimuth, up)).is_some());
    }
    // A range that includes the back.
    let back = Region { polar: PI, azimuth: Some([3.0, 3.5]) };
    assert!(
        back.contains(towards(PI, 0.0)) && back.contains(towards(-PI + 0.1, 0.0)) && !back.contains(towards(2.9, 0.0))
    );
    let cylinder = Cone { heights: [0.0, 1.0], radii: [1.0, 1.0], azimuth: Some([-FRAC_PI_4, FRAC_PI_4]) };
    assert!(cylinder.hit(DVec3::ZERO, towards(0.7, 0.5)).is_some());
    assert!(
        cylinder.hit(DVec3::ZERO, towards(0.7, 1.1)).is_none()
            && cylinder.hit(DVec3::ZERO, towards(0.8, 0.5)).is_none()
    );
    assert!(cylinder.hit(DVec3::ZERO, DVec3::Y).is_none(), "along the axis");
    let wall = Plane { size: glam::DVec2::new(4.0, 2.0) };
    let eye = DVec3::new(0.0, 0.0, 1.0);
    assert!(wall.hit(eye, DVec3::new(1.9, 0.9, -1.0)).is_some() && wall.hit(eye, DVec3::new(2.1, 0.0, -1.0)).is_none());
    assert!(
        wall.unbounded_hit(eye, DVec3::new(2.1, 0.0, -1.0)).is_some() && wall.unbounded_hit(eye, DVec3::Z).is_none()
    );
    assert!(
        wall.hit(eye, DVec3::X).is_none()
            && wall.hit(eye, DVec3::ZERO).is_none()
            && wall.hit(eye, DVec3::NAN).is_none()
    );
}

#[test]
fn the_apex_ends_a_cone() {
    let cone = Cone { heights: [0.0, 2.0], radii: [2.0, 0.0], azimuth: None };
    assert!(cone.hit(DVec3::new(0.0, 0.5, 0.0), DVec3::new(0.1, 1.0, 0.0)).is_some_and(|hit| hit.point.y < 2.0));
    // Above the apex there is only the other half of the double cone.
    assert_eq!(cone.unbounded_hit(DVec3::new(0.0, 5.0, 0.0), DVec3::new(1.0, 0.1, 0.0)), None);
}

#[test]
fn a_fine_mesh_is_nearly_its_sphere_and_has_no_holes() {
    let mut random = Random::new(73);
    let n = 48;
    let mesh = mesh(ball(n), Faces::Front);
    let sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };
    // A chord over a step of π/n sags by (π/n)²/8, in both directions.
    let sagitta = (PI / f64::from(n)).powi(2) / 4.0;
    for case in 0..20_000 {
        let origin = random.direction() * random.range(0.0, 0.9);
        let target = match case % 3 {
            0 => random.direction(),
            // Exactly through edges and corners.
            1 => mesh.triangles()[case % mesh.triangles().len()][case % 3],
            _ => {
                let [a, b, _] = mesh.triangles()[case % mesh.triangles().len()];
                a.lerp(b, 0.5)
            }
        };
        let hit = mesh.hit(origin, target - origin).expect("a closed mesh has no holes");
        let exact = sphere.far_hit(origin, target - origin).expect("inside");
        assert!(hit.point.distance(exact) < sagitta / 0.1 + 1e-12, "{}", hit.point.distance(exact));
        assert!(hit.normal.dot(-hit.point) > 0.9);
    }
    // The tree finds the same as a test of every triangle.
    for _ in 0..300 {
        let (origin, direction) = (random.vector(-2.0, 2.0), random.direction());
        let ray = super::mesh::by_every_triangle(&mesh, origin, direction);
        assert_eq!(mesh.hit(origin, direction).map(|hit| hit.point), ray);
    }
}

#[test]
fn a_mesh_hides_itself_and_has_two_sides() {
    // A wall at −3 and a smaller one in front of it at −2, both facing the origin.
    let wall = |z: f64, s: f64| {
        let [a, b, c, d] = [(-s, -s), (s, -s), (s, s), (-s, s)].map(|(x, y)| DVec3::new(x, y, z));
        [[a, b, c], [a, c, d]]
    };
    let both: Vec<Triangle> = wall(-3.0, 3.0).into_iter().chain(wall(-2.0, 0.5)).collect();
    let front = mesh(both.clone(), Faces::Front);
    let depth = |x: f64| front.hit(DVec3::ZERO, DVec3::new(x, 0.0, -3.0)).map(|hit| hit.point.z);
    assert_eq!((depth(0.0), depth(0.74), depth(0.76), depth(3.1)), (Some(-2.0), Some(-2.0), Some(-3.0), None));
    // From behind, the large wall stops the light. Its back is dark, or lit if backs are screen.
    let behind = DVec3::new(0.0, 0.0, -5.0);
    assert_eq!(front.hit(behind, DVec3::Z), None);
    for faces in [Faces::Back, Faces::Both] {
        let hit = mesh(both.clone(), faces).hit(behind, DVec3::Z).expect("the back is screen");
        assert_eq!((hit.point.z, hit.normal), (-3.0, DVec3::NEG_Z));
    }
    assert_eq!(mesh(both, Faces::Back).hit(DVec3::ZERO, DVec3::NEG_Z), None);
}

#[test]
fn meshes_that_are_none_are_refused() {
    let flat = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
    let none = Err(MeshProblem::NoSurface);
    assert_eq!(Mesh::new(vec![], Faces::Front), none);
    assert_eq!(Mesh::new(vec![flat], Faces::Front), none);
    assert_eq!(Mesh::new(vec![[DVec3::ZERO, DVec3::X, DVec3::NAN]], Faces::Front), none);
}

#[test]
fn a_posed_screen_is_the_same_screen_elsewhere() {
    let pose = Pose::new(DVec3::new(1.0, 2.0, 3.0), 0.5, -0.3, 0.2);
    let cone = Cone { heights: [-1.0, 1.0], radii: [2.0, 1.0], azimuth: None };
    let screen = Screen { pose, shape: Shape::Cone(cone) };
    let (origin, direction) = (DVec3::new(0.1, 0.2, 0.0), DVec3::new(0.3, 0.2, -1.0));
    let local = cone.hit(origin, direction).expect("inside");
    let there = screen.hit(pose.point_to_parent(origin), pose.direction_to_parent(direction)).expect("the same");
    assert!(there.point.distance(pose.point_to_parent(local.point)) < 1e-14);
    assert!(there.normal.distance(pose.direction_to_parent(local.normal)) < 1e-14);
}

#[test]
fn triangles_that_all_lie_in_one_place_are_refused() {
    let mut random = Random::new(74);
    let mut corner = || DVec3::new(random.range(-2.0, 2.0), random.range(-2.0, 2.0), -3.0);
    let fan: Vec<Triangle> = (0..20_000).map(|_| [DVec3::NEG_Z * 3.0, corner(), corner()]).collect();
    let same = vec![[DVec3::ZERO, DVec3::X, DVec3::Y]; 20_000];
    for triangles in [fan, same] {
        let found = Mesh::new(triangles, Faces::Both);
        assert!(matches!(found, Err(MeshProblem::Layers(layers)) if layers > 1_000.0), "{found:?}");
    }
    // Many triangles are accepted if they form a surface or are scattered.
    assert!(Mesh::new(ball(100), Faces::Front).is_ok());
    let small = |at: DVec3| [at, at + DVec3::X * 0.02, at + DVec3::Y * 0.02];
    let scattered = mesh((0..20_000).map(|_| small(random.vector(-1.0, 1.0))).collect(), Faces::Both);
    assert_eq!(scattered.rims().len(), 2_000, "an even choice of 60,000");
}

#[test]
fn rims_are_the_edges_of_single_triangles_in_the_same_order_always() {
    let (a, b, c, d) = (DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0));
    let square = mesh(vec![[a, b, c], [b, d, c]], Faces::Both);
    let middles = |mesh: &Mesh| mesh.rims().iter().map(|rim| rim(0.5)).collect::<Vec<_>>();
    let found = middles(&square);
    let expected = [(a + b) / 2.0, (b + d) / 2.0, (d + c) / 2.0, (c + a) / 2.0];
    assert!(expected.iter().all(|edge| found.iter().any(|rim| rim.distance(*edge) < 1e-8)) && found.len() == 4);
    assert_eq!(middles(&mesh(vec![[a, b, c], [b, d, c]], Faces::Both)), found);
}

#[test]
fn rays_graze_a_surface_along_its_contours() {
    let mut random = Random::new(75);
    let ellipsoid = Ellipsoid { radii: DVec3::new(6.0, 4.0, 5.0), region: Region::ALL };
    let cylinder = Cone { heights: [-1.0, 3.0], radii: [5.0, 5.0], azimuth: None };
    let cone = Cone { heights: [-2.0, 4.0], radii: [5.0, 1.0], azimuth: None };
    let surfaces: [&dyn Surface; 3] = [&ellipsoid, &cylinder, &cone];
    for surface in surfaces {
        let mut grazed = 0;
        for _ in 0..400 {
            let from = random.direction() * random.range(0.0, 60.0);
            for contour in surface.contours(from) {
                let (part, inset) = (random.range(0.0, 1.0), 1e-5);
                let (point, within) = (contour(part, 0.0), contour(part, inset));
                // Just within the contour the ray still hits this point, almost grazing. Beyond the
                // contour it misses, or hits the other side.
                let hit = surface.unbounded_hit(from, within - from).expect("just within");
                assert!(hit.point.distance(within) < 1e-6, "{from} {part}: {hit:?} {within}");
                let slope = hit.normal.dot((point - from).normalize()).abs();
                assert!(slope < 1e-2 && point.distance(within) < 1e-3, "{from} {part}: {slope}");
                let beyond = contour(part, -0.01);
                let hit = surface.unbounded_hit(from, beyond - from);
                assert!(hit.is_none_or(|hit| hit.point.distance(beyond) > 1e-3), "{from} {part}: {hit:?}");
                grazed += 1;
            }
        }
        assert!(grazed > 200 && surface.contours(DVec3::new(0.1, 0.2, 0.3)).is_empty(), "{grazed}");
    }
}
