//! Rigs in which a planner may leave a part without a view: at rims, borders and corners.

use crate::views::sampling::cone::Cone;
use crate::views::tests::verify::answering;
use crate::views::tests::*;
use crate::warp::WarpMap;

/// The picture ends without a rim of the screen where rays become parallel to the wall of a cone.
#[test]
fn near_the_horizon_of_a_cone_no_direction_is_without_a_view() {
    let text = "[screen]\nshape = \"cone\"\nradii = [6, 4.8]\nheights = [-3, 3]\n\
                [viewer]\nposition = [1.44, -1.08, 2.4]\n[[output]]\nkind = \"equirectangular\"\n";
    let rig = crate::rig::parse(text, "cone.toml", std::path::Path::new("")).unwrap();
    let size = (3840, 2160);
    let plan = plan(&rig, &request(&[size])).unwrap();
    let map = WarpMap::new(&rig, 0, size, None).unwrap();
    let mut shown = 0;
    for (x, y) in (1990..2030).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
        let Some(direction) = map.direction(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)) else { continue };
        assert!(answering(&plan, 0, direction).is_some(), "column {x}, row {y}");
        shown += 1;
    }
    assert!(shown > 100_000 && shown < 40 * size.0, "{shown}");
}

/// The same for a plane: found by `cupola-lab stress` (seed 10324).
#[test]
fn near_the_horizon_of_a_plane_no_direction_is_without_a_view() {
    let text = "[screen]\nshape = \"plane\"\nsize = [11, 7.3]\nyaw = -23\nposition = [0, 0, -4.4]\n[views]\nquality = 8\n\
                [viewer]\nyaw = -94\npitch = 79.5\nroll = 163\n[[output]]\nkind = \"cylindrical\"\nlatitudes = [-48, 89]\n";
    let mut shown = 0;
    for turn in 0..4 {
        let output = format!("width = 288\nyaw = {}\npitch = 40.5\nroll = -149.5\n", 90 * turn - 41);
        let rig = crate::rig::parse(&(text.to_owned() + &output), "plane.toml", std::path::Path::new("")).unwrap();
        let size = (451, 512);
        let plan = plan(&rig, &request(&[size])).unwrap();
        let map = WarpMap::new(&rig, 0, size, None).unwrap();
        for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
            let Some(direction) = map.direction(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)) else { continue };
            assert!(answering(&plan, 0, direction).is_some(), "turn {turn}, column {x}, row {y}");
            shown += 1;
        }
    }
    assert!(shown > 100_000, "{shown}");
}

/// Half of the picture is a little too wide for one view, which only the finest samples show. Found
/// by `cupola-lab stress` (seed 20451), as a picture with one view that needs two.
#[test]
fn a_half_that_turns_out_too_wide_for_a_view_is_not_left_out() {
    let text = "[dome]\ntilt = 55.24\n[screen]\nshape = \"cone\"\nradii = [7.681984279083114, 6.350391077178101]\n\
                heights = [-6.203468619614638, 5.833357204954986]\nyaw = -10.383262676688645\n\
                pitch = -70.45714481953537\nroll = 61.69780493258523\n\
                position = [-0.369201417067837, 0.32377168065229234, 0.9300123905017869]\n\
                [viewer]\nyaw = 175.96341901062232\npitch = 87.6621961030742\nroll = -74.7472501578763\n\
                [[output]]\nkind = \"projector\"\nyaw = -109.45037610813405\npitch = -67.55435240652753\n\
                roll = 82.72545034966203\n\
                position = [0.8881619149878764, 0.9265430081400121, -0.7763288393663637]\n\
                fisheye = { projection = \"orthographic\", size = [0.9643032434864932, 1.329519099790732] }\n";
    let rig = crate::rig::parse(text, "half.toml", std::path::Path::new("")).unwrap();
    for size in [(512, 512), (256, 256)] {
        let plan = plan(&rig, &request(&[size])).unwrap();
        let map = WarpMap::new(&rig, 0, size, None).unwrap();
        let places = (0..size.0 * size.1).map(|i| DVec2::new(f64::from(i % size.0), f64::from(i / size.0)) + 0.5);
        let shown: Vec<DVec3> = places.filter_map(|place| map.direction(place)).collect();
        let without = shown.iter().filter(|direction| answering(&plan, 0, **direction).is_none()).count();
        assert!(shown.len() > 20_000 && without == 0, "{without} of {} pixels of {size:?}", shown.len());
    }
}

/// Pixels that are two million times as high as they are wide, found by `cupola-lab stress` (seed
/// 20075) before such rigs were refused.
#[test]
fn what_no_view_can_show_is_said_and_leaves_the_others_alone() {
    let text = "[dome]\ntilt = 5.939462340701425\ncoverage = 338.0065766511442\n[viewer]\nyaw = 162.32071945669628\n\
                pitch = -15.244128572900536\nroll = -40.18925855138025\n[[output]]\nname = \"sliver\"\n\
                kind = \"cylindrical\"\nlatitudes = [52.63765739926686, 73.99254228715695]\n\
                yaw = 62.492429498690456\npitch = -89.40341173761003\nroll = -152.59696422331015\n";
    let mut rig = parse(text, "sliver.toml", std::path::Path::new("")).expect("valid");
    let OutputKind::Panorama { panorama: crate::geom::Panorama::Cylindrical(span), .. } = &mut rig.outputs[0].kind
    else {
        panic!("a cylindrical picture");
    };
    span.width = 8.6e-8;
    // All faces of all cubes leave the output to their neighbours, which costs nothing; a dedicated
    // view shows it.
    let own = plan(&rig, &request(&[(256, 501)])).expect("a plan");
    assert_eq!(own.views.iter().map(|view| view.name.as_str()).collect::<Vec<_>>(), ["sliver"]);
    rig.views.method = ViewMethod::Cube;
    let refused = plan(&rig, &request(&[(256, 501)])).expect_err("nothing could be shown");
    assert!(refused.kind == ErrorKind::InvalidRig && refused.message.contains("output sliver: no"), "{refused:?}");
    // Beside another output some of the cubes have a face for it.
    rig.outputs.push(fisheye(180.0, 90.0));
    let mut without = 0;
    for step in 0..18 {
        rig.outputs[1].kind = OutputKind::Domemaster { aperture: 3.0, tilt: f64::from(step) * PI / 9.0 };
        let both = plan(&rig, &request(&[(256, 501), (64, 64)])).expect("a plan");
        let said = both.notes.iter().any(|note| note.contains("output sliver: no"));
        assert_eq!(said, both.output_views[0].is_empty(), "{:?}", both.notes);
        assert!(!both.output_views[1].is_empty());
        without += u32::from(said);
    }
    assert!((1..18).contains(&without), "{without}");
}

/// Less than a pixel of the screen lies in the picture's corner, and the sides of two cells of the
/// viewer's cube cross there. Found by `cupola-lab stress` (seed 1931).
#[test]
fn a_single_lit_pixel_has_a_view() {
    let text = "[dome]\nradius = 5\ntilt = -44.08227529026583\ncoverage = 180\n[viewer]\nyaw = -36.818994007683756\n\
                pitch = -80.7842387684694\nroll = 56.446945476010995\n[[output]]\nkind = \"projector\"\n\
                position = [-0.3296994734392009, 2.7832416626351417, 3.520634048660253]\nyaw = -16.389457199918827\n\
                pitch = -27.65941795227797\nroll = -155.7615980499405\nfov = [74.04237457150788, 29.119736731036152]\n\
                shift = [-0.9847542977372852, 0.0953843683399409]\n";
    let rig = parse(text, "corner.toml", std::path::Path::new("")).expect("valid");
    let size = (512, 64);
    let map = WarpMap::new(&rig, 0, size, None).expect("valid");
    let centres = (0..size.0 * size.1).map(|i| DVec2::new(f64::from(i % size.0), f64::from(i / size.0)) + 0.5);
    let lit: Vec<DVec3> = centres.filter_map(|pixel| map.direction(pixel)).collect();
    assert_eq!(lit.len(), 1);
    let views = plan(&rig, &request(&[size])).expect("can be planned").views;
    assert!(views.iter().any(|view| crate::views::sampling::cone::Cone::of(view).contains(lit[0])), "{views:?}");
}

/// The rim of the dome crosses faces at their borders, where rounding decides which face shows it.
/// Found by `cupola-lab stress` (seed 10837), as a picture without any view.
#[test]
fn a_cubemap_that_is_turned_anyhow_has_a_view_for_every_pixel() {
    let mut random = Random::new(3);
    for round in 0..24 {
        let mut angles = || [random.range(-180.0, 180.0), random.range(-90.0, 90.0), random.range(-180.0, 180.0)];
        let ([yaw, pitch, roll], [x, y, z]) = (angles(), angles());
        let text = format!(
            "[dome]\ntilt = {y}\ncoverage = 190\n[viewer]\nyaw = {x}\npitch = {y}\nroll = {z}\n\
             [[output]]\nkind = \"cubemap\"\nyaw = {yaw}\npitch = {pitch}\nroll = {roll}\n"
        );
        let rig = parse(&text, "cube.toml", std::path::Path::new("")).expect("valid");
        let size = [(64, 64), (96, 16), (167, 40)][round % 3];
        let plan = plan(&rig, &request(&[size])).expect("can be planned");
        let map = WarpMap::new(&rig, 0, size, None).expect("a map");
        for index in 0..size.0 * size.1 {
            let pixel = DVec2::new(f64::from(index % size.0), f64::from(index / size.0)) + 0.5;
            let direction = map.direction(pixel).expect("all directions are shown");
            assert!(answering(&plan, 0, direction).is_some(), "{round}: {pixel} of {text}");
        }
    }
}

/// The picture's sides cut off a lens's circle. Its content ends there, and views meet there, too.
#[test]
fn a_circle_that_the_picture_cuts_off_is_shown_completely() {
    let text = "[screen]\nshape = \"ellipsoid\"\nradii = [5.5, 4.8, 6]\nyaw = 20\n[viewer]\nposition = [2.16, -1.62, 3.6]\n\
        [[output]]\nkind = \"projector\"\nposition = [0.36, 0.45, 4.4631]\nyaw = -4\npitch = -5\n\
        fisheye = { projection = \"equisolid\", aperture = 180, size = [1, 1.2] }\n";
    let rig = crate::rig::parse(text, "cut.toml", std::path::Path::new("")).expect("valid");
    let size = (1920, 1080);
    let views = plan(&rig, &request(&[size])).expect("a plan").views;
    let cones: Vec<Cone> = views.iter().map(Cone::of).collect();
    let map = WarpMap::new(&rig, 0, size, None).expect("a map");
    let gaps = |cones: &[Cone]| {
        let places =
            (1056..size.1).flat_map(|y| (0..size.0).map(move |x| DVec2::new(f64::from(x), f64::from(y)) + 0.5));
        let directions = places.filter_map(|place| map.direction(place));
        directions.filter(|direction| !cones.iter().any(|cone| cone.contains(*direction))).count()
    };
    assert_eq!(gaps(&cones), 0);
    assert!(gaps(&cones[1..]) > 100, "a view that is missing is not noticed");
}
