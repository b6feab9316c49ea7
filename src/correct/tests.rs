//! The passes, compared with a direct computation of every pixel of several rigs.

use crate::ErrorKind;
use crate::correct::passes::output_pass::{Batch, Plan};
use crate::correct::passes::source::Source;
use crate::correct::plan::blocks;
use crate::correct::plan::builder::build;
use crate::correct::plan::picture::Picture;
use crate::geom::Panorama;
use crate::geom::lenses::panorama::Span;
use crate::rig::{OutputKind, Rig};
use crate::testing::random::Random;
use crate::views::sampling::output_map::UNIT_FRUSTUM;
use crate::views::tests::{fisheye, lens, output, projector, random_rig, request, rig};
use crate::views::{Request, ViewPlan};
use crate::warp::WarpMap;
use glam::{DVec2, DVec3};

/// Returns the batch of each pixel, row by row; panics if a pixel is in two.
fn painted(plan: &Plan, output: usize) -> Vec<Option<usize>> {
    let pass = &plan.passes[output];
    let mut painted = vec![None; (pass.size.0 * pass.size.1) as usize];
    for (index, batch) in pass.batches.iter().enumerate() {
        for rect in &batch.rects {
            for y in rect.y..rect.y + rect.height {
                for x in rect.x..rect.x + rect.width {
                    let pixel = &mut painted[(y * pass.size.0 + x) as usize];
                    assert_eq!(*pixel, None, "pixel {x}, {y} is in two batches");
                    *pixel = Some(index);
                }
            }
        }
    }
    painted
}

/// Checks every pixel of every output against the exact map. Returns the number of pixels that show
/// something, or a description of the error.
fn check(rig: &Rig, plan: &Plan) -> Result<usize, String> {
    let mut lit = 0;
    for (index, pass) in plan.passes.iter().enumerate() {
        let map = WarpMap::new(rig, index, pass.size, Some(UNIT_FRUSTUM)).unwrap();
        let painted = painted(plan, index);
        for (x, y) in (0..pass.size.1).flat_map(|y| (0..pass.size.0).map(move |x| (x, y))) {
            let wrong = |what: String| Err(format!("{what} at pixel {x}, {y} of {}: {rig:?} {plan:?}", pass.name));
            let direction = map.direction(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
            let batch = painted[(y * pass.size.0 + x) as usize].map(|batch| &pass.batches[batch]);
            let (u, v) = pass.source.normalised(pass.size, f64::from(x) + 0.5, f64::from(y) + 0.5);
            let (direction, batch) = match (direction, batch) {
                (None, None) => continue,
                (None, Some(batch)) if batch.edge => continue,
                (None, Some(_)) => return wrong("dark, but in a batch without edge".into()),
                (Some(_), None) => return wrong("lit, but in no batch".into()),
                (Some(direction), Some(batch)) => (direction, batch),
            };
            lit += 1;
            let own = pass.source.direction(u, v).map_or(f64::INFINITY, |own| own.normalize().distance(direction));
            // The pixels of a table are rounded to f32.
            let allowed = if matches!(pass.source, Source::Table(_)) { 1.2e-7 } else { 1e-9 };
            if own > allowed {
                return wrong(format!("the pass sees {own:e} beside the exact direction"));
            }
            let answering = plan.views.output_views[index].iter().copied().find(|&view| {
                let view = &plan.views.views[view];
                let local = view.rotation * direction;
                local.z < 0.0 && view.owned.contains(local.x / -local.z, local.y / -local.z)
            });
            if !answering.is_some_and(|view| batch.views.contains(&view)) || !batch.views.is_sorted() {
                return wrong(format!("view {answering:?} answers, but the batch has {:?}", batch.views));
            }
            if let Source::Projector(projector) = &pass.source {
                for (number, neighbour) in projector.neighbours.iter().enumerate() {
                    let Some(at) = neighbour.picture.evaluate(u, v) else { continue };
                    let deep = at.z > 0.0 && at.x.abs() < 0.999 * at.z && at.y.abs() < 0.999 * at.z;
                    if deep && !batch.neighbours.contains(&number) {
                        return wrong(format!("neighbour {number} overlaps unnoticed"));
                    }
                }
            }
        }
    }
    Ok(lit)
}

/// Six projectors around a tilted dome, overlapping.
fn planetarium(size: (u32, u32)) -> (Rig, Request) {
    let mut rig = rig((0..6)
        .map(|index| {
            let yaw = 60.0 * f64::from(index);
            let out = DVec3::new(yaw.to_radians().sin(), 0.0, -yaw.to_radians().cos());
            projector(&format!("p{index}"), out * -3.0, [yaw, 25.0, 0.0], lens(60.0, 45.0))
        })
        .collect());
    for output in &mut rig.outputs {
        output.blend.overlap = true;
    }
    rig.dome.coverage = 170f64.to_radians();
    (rig, request(&[size; 6]))
}

#[test]
fn every_pixel_of_the_fisheye_is_in_one_right_batch() {
    let rig = rig(vec![fisheye(180.0, 90.0)]);
    let plan = build(&rig, &request(&[(512, 512)])).unwrap();
    let lit = check(&rig, &plan).unwrap();
    assert!((lit as f64 / 205_887.0 - 1.0).abs() < 0.01, "{lit}");
    // A batch per view, one where views meet, one at the rim.
    assert_eq!(plan.passes[0].batches.len(), plan.views.views.len() + 2);
}

#[test]
fn every_pixel_of_overlapping_projectors_is_in_one_right_batch() {
    let (rig, request) = planetarium((640, 400));
    let plan = build(&rig, &request).unwrap();
    assert!(check(&rig, &plan).unwrap() > 600_000);
    for pass in &plan.passes {
        // Six of overlaps, one for each of two views, one of both, two at the rim.
        assert!(pass.batches.len() <= 11, "{} batches", pass.batches.len());
        assert!(pass.batches.iter().any(|batch| batch.edge), "some rays leave the dome");
    }
}

#[test]
fn small_outputs_have_one_shader_for_all_overlaps() {
    let (rig, request) = planetarium((150, 100));
    let plan = build(&rig, &request).unwrap();
    assert!(check(&rig, &plan).unwrap() > 50_000);
    for pass in &plan.passes {
        let overlapping: Vec<_> = pass.batches.iter().filter(|batch| !batch.neighbours.is_empty()).collect();
        assert!(overlapping.len() == 1 && overlapping[0].edge, "{overlapping:?}");
    }
}

#[test]
fn every_pixel_of_random_rigs_is_in_one_right_batch() {
    let mut random = Random::new(3);
    for round in 0..40 {
        let (mut rig, request) = random_rig(&mut random);
        for output in &mut rig.outputs {
            output.blend.overlap = random.unit() < 0.7;
        }
        let plan = build(&rig, &request).unwrap();
        check(&rig, &plan).unwrap_or_else(|error| panic!("{round}: {error}"));
    }
}

#[test]
fn every_pixel_of_the_presets_is_in_one_right_batch() {
    for preset in crate::rig::presets() {
        let rig = crate::rig::load(preset.name).unwrap();
        let sizes = vec![(160, 100); rig.outputs.len()];
        let mut request = request(&sizes);
        (request.primary, request.panel) = (true, true);
        let plan = build(&rig, &request).unwrap();
        check(&rig, &plan).unwrap_or_else(|error| panic!("{}: {error}", preset.name));
        println!("{}\n{}", preset.name, crate::views::report(&plan.views, &rig, &sizes));
    }
}

#[test]
fn the_check_of_batches_notices_what_is_wrong() {
    let (rig, request) = planetarium((200, 150));
    let good = build(&rig, &request).unwrap();
    check(&rig, &good).unwrap();
    let fails = |change: &dyn Fn(&mut Vec<Batch>)| {
        let mut bad = good.clone();
        change(&mut bad.passes[0].batches);
        check(&rig, &bad).is_err()
    };
    assert!(fails(&|batches| drop(batches.pop())), "pixels are missing");
    assert!(fails(&|batches| batches.iter_mut().for_each(|batch| batch.edge = false)), "dark pixels are not reported");
    assert!(fails(&|batches| batches.iter_mut().for_each(|batch| batch.views.clear())), "a view is missing");
    assert!(fails(&|batches| batches.iter_mut().for_each(|batch| batch.neighbours.clear())), "a neighbour is missing");
}

/// Returns the number of lit pixels that no view serves, and the number of lit pixels.
fn holes(plan: &Plan) -> (usize, usize) {
    let (mut holes, mut lit) = (0, 0);
    for (pass, views) in plan.passes.iter().zip(&plan.views.output_views) {
        for (x, y) in (0..pass.size.1).flat_map(|y| (0..pass.size.0).map(move |x| (f64::from(x), f64::from(y)))) {
            let (x, y) = pass.source.normalised(pass.size, x + 0.5, y + 0.5);
            let Some(direction) = pass.source.direction(x, y) else { continue };
            let answers = |&view: &usize| {
                let view = &plan.views.views[view];
                let local = view.rotation * direction;
                local.z < 0.0 && view.owned.contains(local.x / -local.z, local.y / -local.z)
            };
            lit += 1;
            holes += usize::from(!views.iter().any(answers));
        }
    }
    (holes, lit)
}

/// Rigs whose pictures reach beyond the outline of the screen. Views have the resolution for
/// pictures 4096 wide, so that the margin of a view is a small part of a pixel.
#[test]
fn no_pixel_beside_a_silhouette_is_without_a_view() {
    let sphere = "radius = 1.421\nposition = [0.0645, -0.111, -0.1215]\n";
    let rigs = [
        format!(
            "[screen]\nshape = \"sphere\"\n{sphere}[[output]]\nkind = \"projector\"\n\
             position = [16.8474, -24.4004, -4.5592]\nyaw = -105.143\npitch = 54.424\nroll = -338.577\n\
             fov = [13.745, 16.296]\nshift = [0.362, -0.127]\n"
        ),
        "[screen]\nshape = \"sphere\"\nradius = 1.575\nposition = [-0.138, 0.129, -0.015]\n[[output]]\n\
         kind = \"projector\"\nposition = [-2.7068, 29.8765, 0.2563]\nyaw = 84.591\npitch = -84.8\n\
         roll = -234.02\nfov = [22.396, 11.048]\n"
            .to_owned(),
        "[viewer]\nposition = [0.429, -0.411, -0.1935]\n[screen]\nshape = \"cone\"\n\
         position = [0.0195, -0.1245, 0.0645]\nyaw = -206.935\npitch = -13.866\nroll = -231.119\n\
         radii = [1.905, 0.569]\nheights = [-1.336, 1.196]\n[[output]]\nkind = \"projector\"\n\
         position = [-2.2555, 2.8144, 2.691]\nyaw = 39.969\npitch = -38.714\nroll = 75.967\n\
         fov = [40.951, 57.151]\ndistortion = { radial = [-0.027, -0.007, 0.0], tangential = [-0.007, 0.004] }\n"
            .to_owned(),
    ];
    let size = (512, 384);
    for text in rigs {
        let mut rig = crate::rig::parse(&text, "silhouette.toml", std::path::Path::new("")).expect("valid");
        rig.views.quality = 8.0;
        let plan = build(&rig, &request(&[size])).expect("a plan");
        let (holes, lit) = holes(&plan);
        assert!(holes == 0 && lit > 10_000, "{holes} of {lit} pixels: {text}");
    }
}

/// A mirror at a flat angle lights only a sliver of the picture. A part of the sliver lies between
/// the planner's samples, in a cell that therefore gets no view.
#[test]
fn a_sliver_between_the_planners_samples_gets_a_view() {
    let text = "[dome]\nradius = 5\ntilt = -146.08266086875614\n[screen]\nshape = \"sphere\"\n\
        radius = 3.5291004170047744\ncoverage = 235.03470030139053\nyaw = 4.630245552804354\n\
        pitch = 23.512096742964616\nroll = 20.53189032063139\n\
        position = [-0.23286152098629356, -0.17092803150735944, -0.37574316137027197]\n\
        [viewer]\nyaw = -127.84415122847778\npitch = -65.04148106007644\nroll = 101.52135603657865\n\
        [[output]]\nkind = \"projector\"\n\
        position = [-0.5552093139160645, -0.6359894972330413, 5.359316063498888]\n\
        yaw = 17.421805015696172\npitch = 35.24218053668274\nroll = -38.95396990099576\n\
        fov = [116.63587913618228, 76.89468192302522]\n\
        mirror = { center = [-0.6366970500634948, -0.37353861822225326, 3.0349890840305824], \
        radius = 1.0860570646108172 }\n";
    let mut rig = crate::rig::parse(text, "sliver.toml", std::path::Path::new("")).expect("valid");
    rig.views.quality = 8.0;
    let request = request(&[(256, 128)]);
    let plan = build(&rig, &request).expect("a plan");
    let (found, lit) = holes(&plan);
    assert!(found == 0 && lit > 90, "{found} of {lit} pixels");
    let planned = crate::views::plan(&rig, &request).expect("a plan");
    assert!(planned.views.len() < plan.views.views.len(), "the planner finds all of it, so this test shows nothing");
}

#[test]
fn the_planner_knows_all_that_presets_show() {
    for preset in crate::rig::presets() {
        let rig = crate::rig::load(preset.name).expect("a preset");
        let request = request(&vec![(240, 150); rig.outputs.len()]);
        let planned = crate::views::plan(&rig, &request).expect("a plan");
        assert_eq!(build(&rig, &request).expect("a plan").views, planned, "{}", preset.name);
    }
}

/// Directions beyond the views are found pixel by pixel. The planner does not know them, since its
/// views are made narrower here on purpose.
#[test]
fn a_view_is_widened_by_what_pixels_show_beyond_it() {
    let text = "[[output]]\nkind = \"projector\"\nposition = [0.5, 1.0, 3.0]\nfov = [60, 40]\n";
    let rig = crate::rig::parse(text, "widened.toml", std::path::Path::new("")).expect("valid");
    let (request, none) = (request(&[(160, 100)]), crate::cache::Cache::none());
    let plan = build(&rig, &request).expect("a plan");
    let picture = Picture {
        source: plan.passes[0].source.clone(),
        size: (160, 100),
        mask: None,
        flip: rig.outputs[0].flip,
        content: None,
    };
    let beyond = |plan: &ViewPlan| blocks::examine(&rig, 0, &picture, plan, &none).beyond[0];
    assert_eq!(beyond(&plan.views), None, "the planner knows a projector's picture");
    let mut narrow = plan.views.clone();
    let owned = &mut narrow.views[0].owned;
    let whole = *owned;
    owned.right -= 0.1 * whole.width();
    owned.bottom += 0.2 * whole.height();
    let found = beyond(&narrow).expect("pixels beyond it");
    let texel = whole.width() / 160.0;
    assert!((found.right - whole.right).abs() < 2.0 * texel, "{found:?} {whole:?}");
    assert!((found.bottom - whole.bottom).abs() < 2.0 * texel, "{found:?} {whole:?}");
}

#[test]
fn passthrough_has_no_passes_and_a_missing_mask_is_an_error() {
    let mut rig = rig(vec![fisheye(180.0, 90.0)]);
    rig.outputs[0].mask = Some("no/such/mask.png".into());
    assert_eq!(build(&rig, &request(&[(64, 64)])).unwrap_err().kind, ErrorKind::Io);
    rig.outputs.clear();
    rig.passthrough = true;
    assert!(build(&rig, &request(&[])).unwrap().passes.is_empty());
}

#[test]
#[ignore = "only prints times"]
fn times() {
    let dome = (rig(vec![fisheye(180.0, 90.0)]), request(&[(4096, 4096)]));
    for (name, (rig, request)) in [("fisheye at 4096²", dome), ("six projectors at 1080p", planetarium((1920, 1080)))]
    {
        let start = std::time::Instant::now();
        let views = crate::views::plan(&rig, &request).unwrap();
        let planned = start.elapsed();
        let plan = build(&rig, &request).unwrap();
        let rects: Vec<usize> =
            plan.passes.iter().flat_map(|pass| pass.batches.iter().map(|batch| batch.rects.len())).collect();
        println!("{name}: views {planned:?}, views and passes {:?}", start.elapsed() - planned);
        println!("rectangles {rects:?}\n{}", crate::views::report(&views, &rig, &request.output_sizes));
    }
}

/// Distance and incidence: a pixel of the solid angle Ω makes an area of r²·Ω/cos i bright,
/// whatever the screen.
#[test]
fn even_light_is_even_on_every_screen() {
    let (position, fov) = (DVec3::new(0.4, -0.3, 1.0), [60.0f64, 40.0]);
    let screens = [
        "[dome]\nradius = 4\ncoverage = 360\n",
        "[screen]\nshape = \"ellipsoid\"\nradii = [5.5, 3.8, 4.5]\nyaw = 20\n",
        "[screen]\nshape = \"cylinder\"\nradius = 4\nheights = [-6, 6]\n",
        "[screen]\nshape = \"cone\"\nradii = [5, 3]\nheights = [-6, 6]\n",
        "[screen]\nshape = \"plane\"\nposition = [0, 0, -4]\nsize = [40, 40]\nyaw = 30\npitch = 10\n",
    ];
    let size = (48, 32);
    for screen in screens {
        let text = format!(
            "{screen}[[output]]\nkind = \"projector\"\nposition = {:?}\nfov = {fov:?}\neven_light = 1.0\n",
            position.to_array()
        );
        let rig = crate::rig::parse(&text, "even.toml", std::path::Path::new("")).unwrap();
        let plan = build(&rig, &request(&[size])).unwrap();
        let Source::Table(table) = &plan.passes[0].source else { panic!("{screen}: no table") };
        let tangents = fov.map(|angle| (0.5 * angle.to_radians()).tan());
        let (mut levels, mut full) = (Vec::new(), 0);
        for (column, row) in (0..size.1).flat_map(|row| (0..size.0).map(move |column| (column, row))) {
            let part = |index: u32, count: u32| (f64::from(index) + 0.5) / f64::from(count);
            let (across, down) = (part(column, size.0), part(row, size.1));
            let ray = DVec3::new((2.0 * across - 1.0) * tangents[0], (1.0 - 2.0 * down) * tangents[1], -1.0);
            let hit = rig.surface().hit(position, ray).unwrap();
            let (away, towards) = (hit.point - position, ray.normalize());
            // In units of the pixel's tangents. The cube of the length accounts for the slant of
            // the picture's plane and for its distance.
            let solid_angle = ray.length().powi(-3);
            let area = away.length_squared() * solid_angle / hit.normal.dot(towards).abs();
            let weight = table.at(across, down).unwrap().weight;
            match weight < 1.0 {
                true => levels.push(weight / area),
                false => full += 1,
            }
        }
        let mean = levels.iter().sum::<f64>() / levels.len() as f64;
        let worst = levels.iter().map(|level| (level / mean - 1.0).abs()).fold(0.0, f64::max);
        // Areas are differences over a pixel; their error is the square of its size.
        assert!(worst < 2e-3, "{screen}: {worst}");
        assert!(levels.len() > 1_000 && full > 50, "{screen}: {} dimmed, {full} not", levels.len());
    }
}

#[test]
fn a_domemaster_too_narrow_for_its_formula_has_a_table() {
    let planned = |aperture: f64, aside: f64| {
        let mut rig = rig(vec![fisheye(aperture, 30.0)]);
        rig.viewer.position.x = aside;
        matches!(build(&rig, &request(&[(96, 96)])).unwrap().passes[0].source, Source::Table(_))
    };
    assert!(planned(0.0012, 2.0), "pixels of 2e-7 radians");
    assert!(planned(0.012, 4.9) && !planned(0.012, 2.0), "the nearer the screen, the wider they have to be");
    assert!(!planned(0.0012, 0.0), "without an offset the formula is exact");
    assert!(!planned(1.0, 4.0) && !planned(180.0, 4.5));
}

#[test]
fn an_unrolled_picture_too_narrow_for_its_formula_has_a_table() {
    let planned = |width: f64, latitudes: [f64; 2]| {
        let span = Span { width, bottom: latitudes[0], top: latitudes[1] };
        [Panorama::Equirectangular(span), Panorama::Cylindrical(span)].map(|panorama| {
            let rig = rig(vec![output("wall", OutputKind::Panorama { panorama, angles: [0.1, 0.2, 0.3] })]);
            matches!(build(&rig, &request(&[(96, 48)])).unwrap().passes[0].source, Source::Table(_))
        })
    };
    assert_eq!(planned(2e-5, [0.5, 0.7]), [true; 2], "columns of 2e-7 radians");
    assert_eq!(planned(0.1, [0.5, 0.500_001]), [true; 2], "rows of 2e-8");
    assert_eq!(planned(1e-3, [0.5, 0.501]), [false; 2]);
}
