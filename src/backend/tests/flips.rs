//! Mirrored pictures, compared with the same pictures that are not mirrored.

use super::Driver;
use super::picture::Picture;
use super::present::waves;
use super::rigs::{self, exact, read};
use crate::correct::Plan;
use crate::rig::{Flip, Rig};
use glam::DVec3;
use std::sync::Arc;

/// One side is odd, so that its middle is a pixel. No pixel's centre lies where two faces meet.
const SIZE: (u32, u32) = (322, 203);

/// An output of each source and each method. None equals its mirror image.
pub(super) const OUTPUTS: [(&str, &str); 11] = [
    (
        "a domemaster",
        "[dome]\ntilt = 40.0\n[viewer]\nyaw = 20.0\nposition = [1.0, 0.5, -0.8]\n[[output]]\nkind = \"domemaster\"\n\
        [output.blend]\nramps = [{ angle = \"azimuth\", zero = 100.0, full = 20.0 }]\n",
    ),
    ("a panorama", "[[output]]\nkind = \"equirectangular\"\nyaw = 20.0\nroll = 10.0\nwidth = 200.0\n"),
    ("faces", "[[output]]\nkind = \"cubemap\"\nyaw = 20.0\n"),
    (
        "a window",
        "[[output]]\nkind = \"perspective\"\nyaw = 20.0\nroll = 10.0\nfov = [80.0, 60.0]\nshift = [0.1, 0.2]\n",
    ),
    (
        "projectors that overlap",
        "[dome]\ntilt = 60.0\ncoverage = 150.0\n[viewer]\nposition = [0.3, -0.4, 0.2]\n\
        [[output]]\nkind = \"projector\"\nposition = [0.0, 0.0, 3.0]\npitch = -8.0\nroll = 4.0\nfov = [60.0, 40.0]\n\
        [output.blend]\nblack_level = 0.01\n\
        [[output]]\nkind = \"projector\"\nposition = [0.0, 0.0, 3.0]\nyaw = 30.0\nfov = [60.0, 40.0]\nflip = \"both\"\n",
    ),
    (
        "a lens",
        "[[output]]\nkind = \"projector\"\nposition = [0.0, 0.5, 1.0]\npitch = 60.0\nroll = 9.0\n\
        fisheye = { projection = \"equisolid\", aperture = 150.0, size = [1.1, 1.4], center = [0.05, -0.1] }\n",
    ),
    (
        "a table of all pixels",
        "[screen]\nshape = \"cylinder\"\nradius = 4.0\nheights = [-1.0, 2.0]\nazimuth = [-70.0, 60.0]\n\
        [[output]]\nkind = \"projector\"\nposition = [0.0, 0.5, 1.0]\nfov = [100.0, 70.0]\nroll = 5.0\n\
        distortion = { radial = [-0.05, 0.0, 0.0] }\n",
    ),
    (
        "a coarse table",
        "[[output]]\nkind = \"projector\"\nposition = [0.0, 0.5, 1.0]\nfov = [70.0, 50.0]\nroll = 5.0\nmethod = \"table\"\n",
    ),
    (
        "a mesh",
        "[[output]]\nkind = \"projector\"\nposition = [0.0, 0.5, 1.0]\nfov = [70.0, 50.0]\nroll = 5.0\nmethod = \"mesh\"\n",
    ),
    (
        "a mesh of the dome",
        "[dome]\ntilt = 30.0\n[[output]]\nkind = \"domemaster\"\naperture = 170.0\nmethod = \"cube-mesh\"\n",
    ),
    (COPIED, "[[output]]\nkind = \"domemaster\"\naperture = 170.0\nmethod = \"vertex\"\n"),
];

/// Output whose vertices are projected directly: each of its pixels is one texel.
const COPIED: &str = "a copy";

const FLIPS: [Flip; 3] = [
    Flip { horizontal: true, vertical: false },
    Flip { horizontal: false, vertical: true },
    Flip { horizontal: true, vertical: true },
];

fn planned(rig: &Rig) -> Arc<Plan> {
    rigs::planned(rig, SIZE)
}

/// Returns the greatest difference between two pictures of one size, without the `rim` pixels that
/// differ most, and the number of pixels that differ.
fn difference(found: &Picture, expected: &Picture, rim: usize) -> (u8, usize) {
    let apart = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).map(|k| a[k].abs_diff(b[k])).max().unwrap_or(0);
    let mut counts = [0usize; 256];
    found.pixels.iter().zip(&expected.pixels).for_each(|pair| counts[usize::from(apart(pair))] += 1);
    let differing = counts[1..].iter().sum();
    let mut beyond = 0;
    let is_kept = |step: &u8| {
        beyond += counts[usize::from(*step)];
        beyond > rim
    };
    ((0..=255).rev().find(is_kept).unwrap_or(0), differing)
}

/// Returns the mirrored picture. Its first row is the bottom one, which makes no difference.
fn mirrored(picture: &Picture, flip: Flip) -> Picture {
    Picture { size: picture.size, pixels: flip.items(&picture.pixels, picture.size.0 as usize) }
}

/// Rounding differs in a mirrored rectangle: interpolated places move by parts of 2⁻²³. So a code
/// may change by one, and a pixel on a rim may show nothing. Apart from such pixels, a copy is the
/// same to the bit.
pub fn a_mirrored_output_shows_the_mirrored_picture(driver: &dyn Driver) {
    for (name, text) in OUTPUTS {
        let rig = read(text);
        let plan = planned(&rig);
        let atlas = waves(plan.views.atlas);
        let plain = driver.show(&plan, false, &atlas);
        for flip in FLIPS {
            let mut turned = rig.clone();
            turned.outputs[0].flip = flip;
            let plan = planned(&turned);
            let shown = driver.show(&plan, false, &atlas);
            let (most, differing) = difference(&shown, &mirrored(&plain, flip), 2);
            let (bound, number) = if name == COPIED { (0, 3) } else { (1, 4000) };
            assert!(most <= bound && differing < number, "{name}, {flip:?}: {most}, {differing} pixels");
            // Negative control: the comparison notices a picture that is not mirrored, or wrongly.
            let other = Flip { horizontal: !flip.horizontal, ..flip };
            for wrong in [Flip::default(), other] {
                let (most, differing) = difference(&shown, &mirrored(&plain, wrong), 2);
                assert!(most > 40 && differing > 10_000, "{name}, {flip:?}: {most}, {differing} pixels");
            }
        }
    }
}

/// The map of a mirrored output equals the exact map, which is mirrored in f64.
pub fn a_mirrored_map_is_the_exact_one(driver: &dyn Driver) {
    for (name, text) in &OUTPUTS[..7] {
        let mut rig = read(text);
        for flip in FLIPS {
            rig.outputs[0].flip = flip;
            let plan = planned(&rig);
            let map = driver.map(&plan, 0);
            let found = |x: u32, y: u32| {
                let pixel = &map[(y * SIZE.0 + x) as usize];
                pixel.view.map(|_| DVec3::from_array(pixel.direction.map(f64::from)))
            };
            let error = exact(&rig, 0, SIZE).compare(1, found);
            assert!(error.max < 0.01 && error.ghosts + error.uncovered <= 2, "{name}, {flip:?}: {error:?}");
            // Negative control: the map that is not mirrored.
            rig.outputs[0].flip = Flip::default();
            let plain = exact(&rig, 0, SIZE).compare(3, found);
            assert!(plain.max > 5.0 || plain.ghosts > 100, "{name}, {flip:?}: {plain:?}");
        }
    }
}

/// The four sample places of a pixel are those of the finished picture, and lie in the views.
pub fn a_mirrored_picture_of_four_places_is_nearly_the_same(driver: &dyn Driver) {
    let mut rig = read(&format!("[views]\nfilter = \"bilinear-4\"\nquality = 2.0\n{}", OUTPUTS[0].1));
    let plain = planned(&rig);
    let atlas = waves(plain.views.atlas);
    let plain = driver.show(&plain, false, &atlas);
    rig.outputs[0].flip = FLIPS[0];
    let shown = driver.show(&planned(&rig), false, &atlas);
    // `waves` are drawn on the atlas, so they are not continuous where two views meet.
    let (inside, _) = difference(&shown, &mirrored(&plain, FLIPS[0]), 1500);
    assert!(inside <= 2, "{inside}");
}

/// A mask belongs to the picture before it is mirrored.
pub fn a_mask_is_mirrored_with_its_picture(driver: &dyn Driver) {
    let folder =
        std::env::temp_dir().join(format!("cupola-flips-{}-{:?}", std::process::id(), std::thread::current().id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let mask = image::GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        image::Luma([(40 + x * 160 / SIZE.0 + y * 50 / SIZE.1) as u8])
    });
    mask.save(folder.join("mask.png")).expect("a picture");
    let text = format!("{}mask = {{ image = \"mask.png\" }}\n", OUTPUTS[3].1);
    let mut rig = crate::rig::parse(&text, "test", &folder).unwrap_or_else(|error| panic!("{error}"));
    let plan = planned(&rig);
    let atlas = Picture::new(plan.views.atlas, |_, _| [255, 200, 100, 255]);
    let plain = driver.show(&plan, false, &atlas);
    for flip in FLIPS {
        rig.outputs[0].flip = flip;
        let shown = driver.show(&planned(&rig), false, &atlas);
        let (most, _) = difference(&shown, &mirrored(&plain, flip), 0);
        assert!(most <= 1, "{flip:?}: {most}");
        assert!(difference(&shown, &plain, 0).0 > 10, "{flip:?}: the mask is even");
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}
