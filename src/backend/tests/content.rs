//! Content, a picture that is already projected, compared with its directions in f64.

use super::Driver;
use super::flips::OUTPUTS;
use super::picture::Picture;
use super::rigs::read;
use crate::correct::{Plan, build};
use crate::geom::lenses::panorama::STRIP_FACES;
use crate::geom::{ContentMap, ContentPicture, Panorama};
use crate::rig::{Method, Rig};
use crate::views::Request;
use crate::warp::WarpMap;
use glam::{DVec2, DVec3};

const SIZE: (u32, u32) = (122, 81);

/// One content of each kind and of each curve. None equals its mirror image.
const KINDS: [&str; 11] = [
    "domemaster,aperture=190,tilt=20,roll=15",
    "domemaster,aperture=360,yaw=30",
    "domemaster,aperture=220,projection=equisolid,tilt=50",
    "domemaster,aperture=300,projection=stereographic,tilt=90",
    "domemaster,aperture=170,projection=orthographic,tilt=70,yaw=10",
    "domemaster,aperture=200,projection=polynomial,coefficients=1,-0.05,0.002,0",
    "equirectangular,yaw=40,pitch=25,roll=10",
    "equirectangular,width=200,latitudes=-30,70,region=0.1,0.2,0.6,0.7",
    "cylindrical,yaw=-70,stereo=top-bottom",
    "cubemap,yaw=20,pitch=50",
    "flat,width=100,yaw=10,pitch=30,roll=5,stereo=side-by-side",
];

/// Returns the plan of a rig for content in a window, and the rig whose exact maps are those around
/// the content.
fn planned(text: &str, content: &str, window: (u32, u32)) -> (Plan, Rig) {
    let rig = read(text).with_content_override(content).unwrap_or_else(|error| panic!("{error}"));
    let output_sizes = vec![SIZE; rig.outputs.len()];
    let request = Request { output_sizes, window, panel: false, primary: false, max_atlas: 16384 };
    let plan = build(&rig, &request).unwrap_or_else(|error| panic!("{text}, {content}: {error}"));
    assert_eq!(plan.views.views.len(), 1);
    (plan, rig.around_content().into_owned())
}

fn centre(index: usize) -> DVec2 {
    let (column, row) = (index as u32 % SIZE.0, index as u32 / SIZE.0);
    DVec2::new(f64::from(column), f64::from(row)) + 0.5
}

/// Returns the direction that the picture shows at a place of the window, in viewer axes: the
/// inverse of [`ContentMap::place`].
fn direction_at(map: &ContentMap, place: DVec2) -> Option<DVec3> {
    let at = 2.0 * (place - map.region.origin) / map.region.size - 1.0;
    let direction = match &map.picture {
        ContentPicture::Directions(panorama) => panorama.direction(at.clamp(DVec2::NEG_ONE, DVec2::ONE), 1.0)?,
        ContentPicture::Flat { half } => (at * *half).extend(-1.0),
    };
    Some(map.rotation.transpose() * direction)
}

/// Returns the angle of a pixel of the picture in a window.
fn pixel_angle(map: &ContentMap, window: (u32, u32)) -> f64 {
    let size = map.region.size * DVec2::new(f64::from(window.0), f64::from(window.1));
    match &map.picture {
        ContentPicture::Directions(panorama) => panorama.pixel((size.x as u32, size.y as u32)),
        ContentPicture::Flat { half } => 2.0 * half.x / size.x,
    }
}

/// Every source and method of outputs samples every kind of content at the place that f64 gives.
pub fn places_are_those_of_f64(driver: &dyn Driver) {
    let window = (8000, 6000);
    let mut worst = 0.0f64;
    let others = [("a mirror", include_str!("../../rig/presets/idome.toml"))];
    for (number, (name, text)) in OUTPUTS.iter().chain(&others).enumerate() {
        // All kinds for one output, all outputs for one kind, and each pair in one of three runs.
        let kinds = KINDS.iter().enumerate().filter(|(kind, _)| number == 0 || *kind == 0 || (kind + number) % 3 == 0);
        for (_, content) in kinds {
            let (plan, rig) = planned(text, content, window);
            for (output, pass) in plan.passes.iter().enumerate() {
                // Interpolated methods have errors of their own.
                let exact_method = rig.outputs[output].method == Method::Fragment;
                if !exact_method {
                    continue;
                }
                let map = pass.content.as_ref().expect("content");
                let exact = WarpMap::new(&rig, output, SIZE, None).expect("a map");
                let angle = pixel_angle(map, window);
                let (mut shown, mut dark) = (0, 0);
                let direction_of = |pixel| exact.direction(pixel).filter(|d| map.place(*d).is_some());
                for (index, pixel) in driver.map(&plan, output).into_iter().enumerate() {
                    let direction = direction_of(centre(index));
                    let found = pixel.view.and_then(|_| direction_at(map, DVec2::from(pixel.atlas.map(f64::from))));
                    match (direction, found) {
                        (Some(direction), Some(found)) => {
                            shown += 1;
                            let error = direction.angle_between(found) / angle;
                            worst = worst.max(error);
                            assert!(error < 0.005, "{name}, {content}, {output}: {error} pixels at {}", centre(index));
                        }
                        (None, None) => dark += 1,
                        // At the very rim, rounding may decide.
                        _ => {
                            let beside = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
                            let near = beside.iter().filter(|by| direction_of(centre(index) + 0.01 * **by).is_some());
                            let near = near.count();
                            assert!(near != 0 && near != 4, "{name}, {content}, {output}: {}", centre(index));
                        }
                    }
                }
                assert!(shown + dark > SIZE.0 * SIZE.1 - 40, "{name}, {content}: {shown} {dark}");
            }
        }
    }
    println!("content: at most {worst} pixels");
    assert!(worst > 1e-6, "nothing was compared");
}

/// Returns a colour that varies smoothly with the direction.
fn colour(direction: DVec3) -> DVec3 {
    let d = direction.normalize();
    0.5 + 0.4 * DVec3::new((6.0 * d.x).sin(), (6.0 * d.y).sin(), (6.0 * d.z).sin())
}

/// Returns the window with a picture of all directions in the region, and `outside` around it.
fn window_of(map: &ContentMap, plan: &Plan, outside: u8) -> Picture {
    let (width, height) = plan.views.atlas;
    let size = DVec2::new(f64::from(width), f64::from(height));
    Picture::new((width, height), |x, y| {
        let at = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / size;
        let inside = (at - map.region.origin) / map.region.size;
        let direction = (inside.cmpge(DVec2::ZERO).all() && inside.cmple(DVec2::ONE).all())
            .then(|| direction_at(map, at))
            .flatten();
        let [r, g, b] = direction.map_or([outside; 3], |d| (255.0 * colour(d)).round().to_array().map(|v| v as u8));
        [r, g, b, 255]
    })
}

/// A picture that continues at another side is shown without a seam. No filter reads texels outside
/// the picture.
pub fn content_goes_on_across_its_seams(driver: &dyn Driver) {
    let around = "[[output]]\nkind = \"equirectangular\"\nyaw = 170.0\npitch = 20.0\n";
    for (content, seams) in [
        ("equirectangular,yaw=30,pitch=25", true),
        ("equirectangular,width=359.9,yaw=30,pitch=25", false),
        ("cubemap,yaw=20,pitch=50", true),
    ] {
        for (filter, bound) in [("bilinear", 2.5), ("catmull-rom", 2.5), ("bilinear-4", 2.5)] {
            let text = format!("[views]\nfilter = \"{filter}\"\n{around}");
            // Coarse, so that half a texel is several codes.
            let window = if content.starts_with("cubemap") { (384, 80) } else { (200, 130) };
            let (plan, rig) = planned(&text, content, window);
            let map = plan.passes[0].content.clone().expect("content");
            let shown = driver.show(&plan, false, &window_of(&map, &plan, 0));
            let same = shown == driver.show(&plan, false, &window_of(&map, &plan, 255));
            assert!(same, "{content}, {filter}: a texel outside the picture is read");
            let exact = WarpMap::new(&rig, 0, SIZE, None).expect("a map");
            let mut worst = (0.0f64, DVec3::ZERO);
            for index in 0..(SIZE.0 * SIZE.1) as usize {
                let Some(direction) = exact.direction(centre(index)).filter(|d| map.place(*d).is_some()) else {
                    continue;
                };
                // Around a pole, the last row of a panorama is not continuous.
                let local = map.rotation * direction;
                if is_pole(&map, local) {
                    continue;
                }
                let pixel = shown.at(index as u32 % SIZE.0, SIZE.1 - 1 - index as u32 / SIZE.0);
                let wrong = (255.0 * colour(direction) - DVec3::new(pixel[0].into(), pixel[1].into(), pixel[2].into()))
                    .abs()
                    .max_element();
                if wrong > worst.0 {
                    worst = (wrong, local);
                }
            }
            println!("{content}, {filter}: {worst:?}");
            assert_eq!(worst.0 < bound, seams, "{content}, {filter}: {worst:?}");
        }
    }
}

/// True if a direction in the picture's axes is within two rows of a pole of an unrolled picture,
/// or of a corner of a cube, where three faces meet.
fn is_pole(map: &ContentMap, local: DVec3) -> bool {
    let direction = local.normalize();
    match &map.picture {
        ContentPicture::Directions(Panorama::CubeStrip) => {
            let nearest = STRIP_FACES.iter().map(|[right, up, _]| {
                let along = |axis: &DVec3| direction.dot(*axis).abs();
                along(right).min(along(up))
            });
            nearest.fold(1.0, f64::min) > 0.55
        }
        _ => direction.y.abs() > (2.0 * std::f64::consts::PI / 100.0).cos(),
    }
}
