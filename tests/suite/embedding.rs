//! A program that draws its own views, through the C interface.

use crate::compare::{Shown, compare, expect_good, expect_similar};
use crate::dialects::{shown_by_fisheye, shown_by_window};
use crate::harness::tests;
use crate::picture::Picture;
use crate::programs::{
    Finished, embedding, embedding_of_first_version, validated, validated_of_first_version, watched,
};
use crate::reference::{Fisheye, ProgramCamera};

tests! {
    the_c_interface_without_a_window,
    a_program_of_the_first_version,
    a_program_of_a_later_version,
    a_shader_of_the_program_s_own_projects_to_the_picture,
    the_vulkan_example_without_cupola,
    the_vulkan_example_of_the_first_version,
    the_vulkan_example_in_every_arrangement,
    the_vulkan_example_with_multiview,
    the_vulkan_example_with_other_rigs,
    the_validation_layer_is_heard,
}

/// `embed` judges status codes, error texts, kept state and exact directions itself; its pictures
/// are judged here.
fn the_c_interface_without_a_window() {
    let Some(finished) = embedding("embed", &["256", "33", "-17"], &[]) else { return };
    expect_pictures_of_embed(&finished.expect_success());
}

/// The same program, compiled with the headers of 0.1 as they were first published: all of it has
/// to work and to look as it did.
fn a_program_of_the_first_version() {
    let Some(finished) = embedding_of_first_version("embed", &["256", "33", "-17"]) else { return };
    let first = finished.expect_success();
    expect_pictures_of_embed(&first);
    let Some(finished) = embedding("embed", &["256", "33", "-17"], &[]) else { return };
    let current = finished.expect_success();
    for file in ["views.ppm", "callback.ppm", "moved.ppm"] {
        assert_eq!(first.picture(file).difference(&current.picture(file)), (0, 0), "{file}");
    }
    // The two programs are not one file.
    let headers = ["include/cupola.h", "tests/abi/0.1/cupola.h"]
        .map(|path| std::fs::read_to_string(format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))).expect("a header"));
    assert!(headers[0].contains("cupola_abi_version") && !headers[1].contains("cupola_abi_version"));
}

/// A program of a later version, whose structs are larger.
fn a_program_of_a_later_version() {
    let Some(finished) = embedding("embed_versions", &["256", "33", "-17"], &[]) else { return };
    let picture = finished.expect_success().picture("later.ppm");
    let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
    expect_good(&compare(&picture, shown_by_fisheye(circle, CAMERA)), &picture, "embed_versions later.ppm");
}

fn expect_pictures_of_embed(finished: &Finished) {
    let camera = CAMERA;
    for (file, size) in [("views.ppm", 256), ("callback.ppm", 192)] {
        let picture = finished.picture(file);
        assert_eq!((picture.width, picture.height), (size, size));
        let circle = Fisheye { width: size as f64, height: size as f64, aperture: 180.0, tilt: 90.0 };
        expect_good(&compare(&picture, shown_by_fisheye(circle, camera)), &picture, &format!("embed {file}"));
    }
    // The viewer has moved in the preset's dome of 5 m: each pixel is the same point of the dome,
    // seen from there.
    let picture = finished.picture("moved.ppm");
    let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
    let moved = |[right, up, backward]: [f64; 3]| {
        move |x: f64, y: f64| match circle.inside_by(x, y) {
            ..0.0 => shown_by_fisheye(circle, camera)(x, y),
            _ => {
                let [a, b, c] = circle.direction(x, y);
                let seen = [5.0 * a - right, 5.0 * b - up, 5.0 * c - backward];
                let length = seen.iter().map(|part| part * part).sum::<f64>().sqrt();
                Shown::Direction(camera.to_world(seen.map(|part| part / length)))
            }
        }
    };
    expect_good(&compare(&picture, moved([2.0, -0.5, 1.0])), &picture, "embed moved.ppm");
    // Negative control: the old viewer's picture is another one.
    assert!(!compare(&picture, moved([0.0; 3])).good());
}

/// A program whose shader projects to the picture itself, with the library's functions in its text.
fn a_shader_of_the_program_s_own_projects_to_the_picture() {
    let Some(finished) = embedding("embed_vertex", &["256", "33", "-17"], &[]) else { return };
    let finished = finished.expect_success();
    let shown = |aperture: f64| shown_by_fisheye(Fisheye { width: 256.0, height: 256.0, aperture, tilt: 90.0 }, CAMERA);
    for file in ["vertex.ppm", "fragment.ppm"] {
        let picture = finished.picture(file);
        expect_good(&compare(&picture, shown(180.0)), &picture, &format!("embed_vertex {file}"));
        // Negative control: a lens of another opening.
        assert!(!compare(&picture, shown(176.0)).good(), "{file}");
    }
}

const CAMERA: ProgramCamera = ProgramCamera { yaw: 33.0, pitch: -17.0 };

/// For `vk_dome`: a domemaster of 256 × 256 pixels.
const DOMEMASTER: [&str; 10] =
    ["--yaw", "33", "--pitch", "-17", "--size", "256x256", "--frames", "5", "--picture", "dome.ppm"];

fn vulkan(options: &[&str]) -> Option<Picture> {
    Some(validated("vk_dome", &[&DOMEMASTER[..], options].concat())?.picture("dome.ppm"))
}

/// Without Cupola: the example draws what the reference says that it draws.
fn the_vulkan_example_without_cupola() {
    let options = ["--yaw", "33", "--pitch", "-17", "--size", "256x192", "--picture", "plain.ppm"];
    let Some(finished) = validated("vk_plain", &options) else { return };
    let picture = finished.picture("plain.ppm");
    expect_good(&compare(&picture, shown_by_window((256, 192), 75.0, CAMERA)), &picture, "vk_plain");
}

/// The same example, compiled with the headers of 0.1 as they were first published.
fn the_vulkan_example_of_the_first_version() {
    for views in ["atlas", "layers", "images"] {
        let options = ["--views", views, "--one-by-one", "--own-images"];
        let Some(current) = vulkan(&options) else { return };
        let all = [&DOMEMASTER[..], &options].concat();
        let Some(first) = validated_of_first_version("vk_dome", &all) else { return };
        assert_eq!(first.picture("dome.ppm").difference(&current), (0, 0), "{views}");
    }
}

/// However the views lie in memory, and whoever made the images: what f64 predicts, and what OpenGL
/// shows.
fn the_vulkan_example_in_every_arrangement() {
    let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
    let forms: [&[&str]; 6] = [
        &["--views", "atlas"],
        &["--views", "atlas", "--own-images"],
        &["--views", "layers", "--one-by-one"],
        &["--views", "layers", "--one-by-one", "--own-images"],
        &["--views", "images"],
        &["--views", "images", "--own-images"],
    ];
    let opengl = embedding("embed", &["256", "33", "-17"], &[]).map(|run| run.expect_success().picture("views.ppm"));
    for form in forms {
        let Some(picture) = vulkan(form) else { return };
        expect_good(&compare(&picture, shown_by_fisheye(circle, CAMERA)), &picture, &format!("vk_dome {form:?}"));
        // Layers are drawn at more than the planned resolution, so that their texels are other
        // ones.
        if let Some(opengl) = opengl.as_ref().filter(|_| form[1] != "layers") {
            expect_similar(&picture, opengl, 1, 1.0, &format!("vk_dome {form:?} against OpenGL"));
        }
    }
}

/// Drawn all at once. Mesa's lavapipe draws triangles that it has to clip into a wrong view, as
/// without Cupola.
fn the_vulkan_example_with_multiview() {
    let Some(at_once) = vulkan(&["--views", "layers"]) else { return };
    let Some(one_by_one) = vulkan(&["--views", "layers", "--one-by-one"]) else { return };
    let (differing, _) = at_once.difference(&one_by_one);
    assert!(differing * 10 < at_once.pixels.len(), "{differing} pixels differ");
}

/// Projectors, tables, masks and pictures of black, whose values the first command buffer copies.
fn the_vulkan_example_with_other_rigs() {
    let masked = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/rigs/masked-fisheye.toml");
    let black = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("black.toml");
    let picture = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/rigs/doorway.png");
    let text = format!(
        "[[output]]\nkind = \"domemaster\"\nflip = \"both\"\nblack = {{ image = {picture:?}, values = \"light\" }}\n"
    );
    std::fs::write(&black, text).unwrap();
    for rig in ["planetarium-6", "idome", masked, black.to_str().unwrap()] {
        let options = |views: &'static str| ["--rig", rig, "--views", views, "--one-by-one"];
        let Some(atlas) = vulkan(&options("atlas")) else { return };
        let Some(images) = vulkan(&options("images")) else { return };
        let Some(layers) = vulkan(&options("layers")) else { return };
        expect_similar(&images, &atlas, 1, 1e-3, &format!("{rig}, images against an atlas"));
        // Layers have texels of their own: a third of the pixels are off by 1/255, a few of them by
        // 2/255.
        expect_similar(&layers, &atlas, 2, 0.5, &format!("{rig}, layers against an atlas"));
        let lit = atlas.pixels.iter().filter(|pixel| **pixel != [0; 3]).count();
        assert!(lit * 10 > atlas.pixels.len(), "{rig}: {lit} pixels are lit");
    }
}

/// Control: when the layer has something to say, it is heard. No device takes so wide an image.
fn the_validation_layer_is_heard() {
    let Some(finished) = watched("vk_plain", &["--size", "100000x16"]) else { return };
    assert!(finished.messages().contains("VUID-VkImageCreateInfo"), "{}", finished.messages());
}
