//! Programs that draw their own views and use the C interface.

use crate::compare::{Shown, compare, expect_good, expect_identical, expect_similar};
use crate::dialects::{shown_by_fisheye, shown_by_window};
use crate::harness::{note, tests};
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

/// `embed` itself checks status codes, error texts, unchanged state and exact directions. This test
/// checks its pictures.
fn the_c_interface_without_a_window() {
    let Some(finished) = embedding("embed", &["256", "33", "-17"], &[]) else { return };
    expect_pictures_of_embed(&finished.expect_success());
}

/// Programs that are compiled with the published headers of version 0.1. They must work and look
/// the same.
fn a_program_of_the_first_version() {
    let programs: [(&str, &[&str]); 2] =
        [("embed", &["views.ppm", "callback.ppm", "moved.ppm"]), ("embed_vertex", &["vertex.ppm", "fragment.ppm"])];
    for (program, files) in programs {
        let options = ["256", "33", "-17"];
        let Some(first) = embedding_of_first_version(program, &options) else { return };
        let Some(current) = embedding(program, &options, &[]) else { return };
        let (first, current) = (first.expect_success(), current.expect_success());
        match program {
            "embed" => expect_pictures_of_embed(&first),
            _ => expect_pictures_of_embed_vertex(&first),
        }
        for file in files {
            expect_identical(&first.picture(file), &current.picture(file), &format!("{program} 0.1, {file}"));
        }
    }
    // Control: the two headers differ.
    let headers = ["include/cupola.h", "tests/abi/0.1/cupola.h"]
        .map(|path| std::fs::read_to_string(format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))).expect("a header"));
    assert!(headers[0].contains("cupola_abi_version") && !headers[1].contains("cupola_abi_version"));
}

/// A program of a later version with larger structs.
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
    // The viewer has moved in the preset's dome of 5 m. Each pixel is the same point of the dome,
    // seen from the new position.
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
    // Negative control: the picture for the old position differs.
    assert!(!compare(&picture, moved([0.0; 3])).good());
}

/// A program whose own shader projects to the output, with the library's functions in its text.
fn a_shader_of_the_program_s_own_projects_to_the_picture() {
    let Some(finished) = embedding("embed_vertex", &["256", "33", "-17"], &[]) else { return };
    expect_pictures_of_embed_vertex(&finished.expect_success());
}

fn expect_pictures_of_embed_vertex(finished: &Finished) {
    let shown = |aperture: f64| shown_by_fisheye(Fisheye { width: 256.0, height: 256.0, aperture, tilt: 90.0 }, CAMERA);
    for file in ["vertex.ppm", "fragment.ppm"] {
        let picture = finished.picture(file);
        expect_good(&compare(&picture, shown(180.0)), &picture, &format!("embed_vertex {file}"));
        // Negative control: a lens with another opening angle.
        assert!(!compare(&picture, shown(176.0)).good(), "{file}");
    }
}

const CAMERA: ProgramCamera = ProgramCamera { yaw: 33.0, pitch: -17.0 };

/// Options of `vk_dome` for a domemaster of 256 × 256 pixels.
const DOMEMASTER: [&str; 10] =
    ["--yaw", "33", "--pitch", "-17", "--size", "256x256", "--frames", "5", "--picture", "dome.ppm"];

fn vulkan(options: &[&str]) -> Option<Picture> {
    Some(validated("vk_dome", &[&DOMEMASTER[..], options].concat())?.picture("dome.ppm"))
}

/// Without Cupola the example draws the predicted picture.
fn the_vulkan_example_without_cupola() {
    let options = ["--yaw", "33", "--pitch", "-17", "--size", "256x192", "--picture", "plain.ppm"];
    let Some(finished) = validated("vk_plain", &options) else { return };
    let picture = finished.picture("plain.ppm");
    expect_good(&compare(&picture, shown_by_window((256, 192), 75.0, CAMERA)), &picture, "vk_plain");
}

/// The same example, compiled with the published headers of version 0.1.
fn the_vulkan_example_of_the_first_version() {
    for views in ["atlas", "layers", "images"] {
        let options = ["--views", views, "--one-by-one", "--own-images"];
        let Some(current) = vulkan(&options) else { return };
        let all = [&DOMEMASTER[..], &options].concat();
        let Some(first) = validated_of_first_version("vk_dome", &all) else { return };
        assert_eq!(first.picture("dome.ppm").difference(&current), (0, 0), "{views}");
    }
}

/// For each arrangement of the views in memory, with images of the program or of Cupola, the
/// picture is the predicted one and equals that of OpenGL.
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
        // Layers have more than the planned resolution, so that their texels differ. Of the other
        // pictures 6 pixels were found to differ.
        if let Some(opengl) = opengl.as_ref().filter(|_| form[1] != "layers") {
            expect_similar(&picture, opengl, 1, 2e-4, &format!("vk_dome {form:?} against OpenGL"));
        }
    }
}

/// Draws all layers at once. Mesa's lavapipe draws triangles that it has to clip into a wrong view,
/// also without Cupola.
fn the_vulkan_example_with_multiview() {
    let Some(at_once) = vulkan(&["--views", "layers"]) else { return };
    let Some(one_by_one) = vulkan(&["--views", "layers", "--one-by-one"]) else { return };
    let (differing, _) = at_once.difference(&one_by_one);
    note(format_args!("{differing} pixels differ if all layers are drawn at once"));
    // 2956 pixels were found to differ.
    let most = 3200;
    assert!(differing < most, "{differing} pixels differ");
    // Control: a quarter of the picture shows what another quarter has to show.
    let swapped = Picture::from_fn(256, 256, |x, y| match (x, y) {
        (..128, ..128) => one_by_one.at(x + 128, y + 128),
        _ => one_by_one.at(x, y),
    });
    let (differing, _) = swapped.difference(&one_by_one);
    assert!(differing > 3 * most, "{differing} pixels differ for a wrong quarter");
}

/// Projectors, tables, masks and pictures of black. The first command buffer copies their values.
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
        // Layers have other texels: a third of the pixels differ by 1/255, a few of them by 2/255.
        expect_similar(&layers, &atlas, 2, 0.5, &format!("{rig}, layers against an atlas"));
        let lit = atlas.pixels.iter().filter(|pixel| **pixel != [0; 3]).count();
        assert!(lit * 10 > atlas.pixels.len(), "{rig}: {lit} pixels are lit");
    }
}

/// Control: messages of the validation layer are noticed. No device supports an image of this
/// width.
fn the_validation_layer_is_heard() {
    let Some(finished) = watched("vk_plain", &["--size", "100000x16"]) else { return };
    assert!(finished.messages().contains("VUID-VkImageCreateInfo"), "{}", finished.messages());
}
