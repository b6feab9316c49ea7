//! Pictures of black, compared with the formula for each pixel.

use super::Driver;
use super::picture::Picture;
use super::plans::{fisheye_direction, fisheye_plan};
use super::present::worst;
use crate::blend::code_of;
use crate::correct::BlackPicture;
use crate::correct::{Mask, Plan};
use crate::rig::{Blend, Flip, Levels, Rig};
use crate::views::Request;
use glam::{DVec2, DVec3};

/// Returns codes that differ as much as possible between pixels and channels.
fn codes(count: u32) -> Vec<[u16; 4]> {
    (0..count).map(|i| [i * 4_099 % 65_536, i * 911 % 30_000, i * 77 % 4_000, 65_535].map(|code| code as u16)).collect()
}

/// A pixel shows `black + (1 − black) · displayed`, where `displayed` is the weighted value.
pub fn black_is_raised_pixel_by_pixel(driver: &dyn Driver) {
    let size = (200, 160);
    let mut plan = fisheye_plan(size, 3.0, DVec3::ZERO);
    let pass = &mut plan.passes[0];
    pass.gamma = 1.8;
    let weights: Vec<u16> = (0..size.0 * size.1).map(|i| (i * 2_011 % 65_536) as u16).collect();
    pass.mask = Some(Mask { width: size.0, height: size.1, weights: weights.clone() });
    let codes = codes(size.0 * size.1);
    let atlas = Picture::new(plan.views.atlas, |_, _| [255, 128, 64, 255]);
    let weighed = driver.show(&plan, false, &atlas);
    plan.passes[0].black = Some(BlackPicture { width: size.0, height: size.1, codes: codes.clone() });
    let shown = driver.show(&plan, false, &atlas);
    let exact = |c: u32, r: u32, with: bool| {
        if fisheye_direction(&plan, size, c, r).is_none() {
            return Some([0.0; 3]);
        }
        let pixel = (r * size.0 + c) as usize;
        let weight = (f64::from(weights[pixel]) / 65535.0).powf(1.0 / 1.8);
        Some(std::array::from_fn(|k| {
            let black = if with { f64::from(codes[pixel][k]) / 65535.0 } else { 0.0 };
            black + (1.0 - black) * [255.0, 128.0, 64.0][k] / 255.0 * weight
        }))
    };
    let found = worst(&shown, |c, r| exact(c, r, true));
    // Half floats in OpenGL ES without 16-bit textures cost a tenth of a code.
    assert!(found <= 0.75, "{found}");
    assert!(worst(&weighed, |c, r| exact(c, r, false)) <= 0.75);
    // Negative controls: upside down, and without the picture of black.
    assert!(worst(&shown, |c, r| exact(c, size.1 - 1 - r, true)) > 50.0);
    assert!(worst(&shown, |c, r| exact(c, r, false)) > 50.0);
}

const SIZE: (u32, u32) = (96, 64);

fn planned(rig: &Rig) -> Plan {
    let output_sizes = vec![SIZE; rig.outputs.len()];
    let request = Request { output_sizes, window: SIZE, panel: false, primary: false, max_atlas: 8192 };
    crate::correct::build(rig, &request).expect("a plan")
}

/// The whole way from the rig file: in linear light or as displayed, coarser than the output, with
/// a black mask, mirrored.
pub fn a_rigs_picture_of_black_is_shown(driver: &dyn Driver) {
    let name = format!("cupola-blacks-{}-{:?}", std::process::id(), std::thread::current().id());
    let folder = std::env::temp_dir().join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    let coarse = |x: u32, y: u32| [0.05 * x as f32, 0.02 * y as f32, 0.3 - 0.04 * x as f32];
    let values = (0..SIZE.1 / 16).flat_map(|y| (0..SIZE.0 / 16).map(move |x| coarse(x, y))).collect();
    let levels = Levels { size: (SIZE.0 / 16, SIZE.1 / 16), values };
    std::fs::write(folder.join("black.pfm"), crate::formats::pictures::pfm::write(levels.size.0, &levels.values))
        .expect("there");
    let mask = image::GrayImage::from_fn(SIZE.0, SIZE.1, |x, _| image::Luma([if x < SIZE.0 / 2 { 0 } else { 255 }]));
    mask.save(folder.join("mask.png")).expect("a picture");
    for (word, light) in [("displayed", false), ("light", true)] {
        let text = format!(
            "[[output]]\nkind = \"perspective\"\nfov = [80.0, 60.0]\nmask = {{ image = \"mask.png\" }}\n\
             black = {{ image = \"black.pfm\", values = \"{word}\" }}\n"
        );
        let mut rig = crate::rig::parse(&text, "test", &folder).unwrap_or_else(|error| panic!("{error}"));
        for flip in
            [(false, false), (true, false), (true, true)].map(|(horizontal, vertical)| Flip { horizontal, vertical })
        {
            rig.outputs[0].flip = flip;
            let plan = planned(&rig);
            let atlas = Picture::new(plan.views.atlas, |_, _| [255, 128, 64, 255]);
            let shown = driver.show(&plan, false, &atlas);
            let exact = |c: u32, r: u32| {
                let place = flip.pixel(DVec2::new(f64::from(c), f64::from(r)) + 0.5, SIZE);
                let at = place / DVec2::new(f64::from(SIZE.0), f64::from(SIZE.1));
                let encoded = |value: [f32; 3]| {
                    let code = |k: usize| code_of(f64::from(value[k]), &Blend::default(), k) as f32;
                    if light { [0, 1, 2].map(code) } else { value }
                };
                let values = levels.values.iter().map(|value| encoded(*value)).collect();
                let black = Levels { size: levels.size, values }.at(at);
                let weight = if at.x < 0.5 { 0.0 } else { 1.0 };
                Some([0, 1, 2].map(|k| black[k] + (1.0 - black[k]) * [255.0, 128.0, 64.0][k] / 255.0 * weight))
            };
            // Texture filters have weights in steps of 1/256: an error of up to 0.002 of the
            // difference of two texels.
            let found = worst(&shown, exact);
            assert!(found <= 0.9, "{word}, {flip:?}: {found}");
            assert!(worst(&shown, |c, r| exact(SIZE.0 - 1 - c, r)) > 50.0, "{word}, {flip:?}");
        }
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}
