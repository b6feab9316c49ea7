//! Rigs that `cupola convert` makes of its own exports: they cost no more than the rig they were made
//! from, and show the same picture.

mod convert;

use convert::{convert, file};
use std::path::{Path, PathBuf};

/// Number of views of a rig, and texels for each pixel of its outputs.
fn planned(rig: &cupola::rig::Rig) -> (usize, f64) {
    let sizes: Vec<(u32, u32)> = rig.outputs.iter().map(|output| output.size.expect("a size")).collect();
    let request = cupola::views::Request {
        output_sizes: sizes.clone(),
        window: sizes[0],
        panel: false,
        primary: false,
        max_atlas: 16384,
    };
    let plan = cupola::correct::build(rig, &request).unwrap().views;
    (plan.views.len(), cupola::views::report(&plan, rig, &sizes).texels_per_pixel)
}

/// Planned cost of a rig whose outputs have `size` pixels, in texels, and its number of views.
fn cost_at(rig: &cupola::rig::Rig, size: (u32, u32)) -> (f64, usize) {
    let request = cupola::views::Request {
        output_sizes: vec![size; rig.outputs.len()],
        window: size,
        panel: false,
        primary: false,
        max_atlas: 16384,
    };
    let plan = cupola::views::plan(rig, &request).unwrap();
    (cupola::views::cost(&plan, rig), plan.views.len())
}

/// Text of a preset whose outputs have `size` pixels, without the cells that were found for it.
fn preset_of(name: &str, size: (u32, u32)) -> String {
    let text = cupola::rig::presets().iter().find(|found| found.name == name).unwrap().text;
    let text = match text.split_once("cells = [") {
        Some((before, rest)) => format!("{before}{}", rest.split_once("\n]\n").unwrap().1),
        None => text.to_owned(),
    };
    let sized = |line: &str| match line.starts_with("size = ") {
        true => format!("size = [{}, {}]\n", size.0, size.1),
        false => format!("{line}\n"),
    };
    text.lines().map(sized).collect()
}

/// Rigs in which a part of the picture misses the screen, so that only an import's pixels tell where
/// it ends.
const OTHERS: [(&str, (u32, u32)); 3] =
    [("planetarium-2", (240, 135)), ("planetarium-2", (480, 270)), ("planetarium-2", (640, 360))];

#[test]
fn an_imported_dome_costs_no_more_at_any_size() {
    let sizes = [(240, 135), (480, 270), (640, 360), (960, 540)];
    costs_no_more(sizes.map(|size| ("planetarium-6", size)).into_iter().chain(OTHERS));
}

#[test]
fn an_imported_large_dome_costs_no_more() {
    costs_no_more([("planetarium-6", (1920, 1080))].into_iter());
}

/// An archive tells the dome that it was made for.
fn costs_no_more(rigs: impl Iterator<Item = (&'static str, (u32, u32))>) {
    for (preset, size) in rigs {
        let source = file(&format!("sized-{preset}-{}.toml", size.0));
        std::fs::write(&source, preset_of(preset, size)).unwrap();
        let original = cupola::rig::load(source.to_str().unwrap()).unwrap();
        let (exported, imported) = (source.with_extension("mpcdi"), source.with_extension("imported.toml"));
        convert(source.to_str().unwrap(), &exported, &[]);
        convert(exported.to_str().unwrap(), &imported, &[]);
        let again = cupola::rig::load(imported.to_str().unwrap()).unwrap();
        assert!((again.dome.tilt - original.dome.tilt).abs() < 1e-9, "{:?}", again.dome);
        let [(cost, views), (found, found_views)] = [&original, &again].map(|rig| cost_at(rig, size));
        let what = format!("{preset} {size:?}");
        println!("{what}: {found_views} of {views} views, cost {:.4}", found / cost);
        let most = if preset == "planetarium-6" { 1.02 } else { 1.05 };
        assert!(found / cost < most, "{what}: {found} instead of {cost}");
    }
}

/// Nodes of a warp mesh, so that the map between them is nearly exact.
const NODES: &str = "321x181";

/// Exports a rig to warp meshes of Bourke's format, and returns their files, one for each output.
fn meshes_of(source: &Path, original: &cupola::rig::Rig) -> Vec<PathBuf> {
    let exported = source.with_extension("data");
    convert(source.to_str().unwrap(), &exported, &["--nodes", NODES]);
    let stem = exported.file_stem().unwrap().to_str().unwrap().to_owned();
    let of = |output: &cupola::rig::Output| match original.outputs.len() {
        1 => exported.clone(),
        _ => exported.with_file_name(format!("{stem}-{}.data", output.name)),
    };
    original.outputs.iter().map(of).collect()
}

/// Writes a rig with the warp meshes of a rig's outputs, as an operator does.
fn rig_of_meshes(source: &Path, original: &cupola::rig::Rig) -> PathBuf {
    let dome = &original.dome;
    let mut text = format!(
        "[dome]\nradius = {:?}\ntilt = {:?}\ncoverage = {:?}\n",
        dome.radius,
        dome.tilt.to_degrees(),
        dome.coverage.to_degrees()
    );
    for (output, mesh) in original.outputs.iter().zip(meshes_of(source, original)) {
        let (name, (width, height)) = (&output.name, output.size.expect("a size"));
        let mesh = mesh.file_name().unwrap().to_str().unwrap();
        text +=
            &format!("[[output]]\nname = \"{name}\"\nkind = \"mesh\"\nfile = \"{mesh}\"\nsize = [{width}, {height}]\n");
    }
    let rig = source.with_extension("meshes.toml");
    std::fs::write(&rig, text).unwrap();
    rig
}

/// Converts a configuration of SGCT with the warp meshes of a rig's outputs, one below the other.
fn rig_of_sgct(source: &Path, original: &cupola::rig::Rig) -> PathBuf {
    let (aperture, tilt) = (original.dome.coverage.to_degrees(), original.dome.tilt.to_degrees());
    let (width, height) = original.outputs[0].size.expect("a size");
    let count = original.outputs.len();
    let viewport = |(index, mesh): (usize, PathBuf)| {
        serde_json::json!({
            "pos": { "x": 0, "y": (count - 1 - index) as f64 / count as f64 },
            "size": { "x": 1, "y": 1.0 / count as f64 },
            "mesh": mesh.file_name().unwrap().to_str().unwrap(),
            "projection": { "type": "FisheyeProjection", "fov": aperture, "tilt": tilt }
        })
    };
    let viewports: Vec<_> = meshes_of(source, original).into_iter().enumerate().map(viewport).collect();
    let window = serde_json::json!({
        "pos": { "x": 0, "y": 0 }, "size": { "x": width, "y": height as usize * count }, "viewports": viewports
    });
    let config = serde_json::json!({ "nodes": [{ "address": "a", "windows": [window] }] });
    let (from, rig) = (source.with_extension("json"), source.with_extension("sgct.toml"));
    std::fs::write(&from, config.to_string()).unwrap();
    let answer = convert(from.to_str().unwrap(), &rig, &[]);
    assert_eq!(answer["notes"].to_string(), "[]");
    rig
}

/// Exports a rig to files of a kind that hold whole rigs, and makes a rig of them. VIOSO's files do
/// not have the dome's tilt, which the operator adds.
fn rig_of_set(source: &Path, original: &cupola::rig::Rig, kind: &str) -> PathBuf {
    let (exported, imported) = (source.with_extension(kind), source.with_extension(format!("{kind}.toml")));
    convert(source.to_str().unwrap(), &exported, &[]);
    convert(exported.to_str().unwrap(), &imported, &[]);
    let text = std::fs::read_to_string(&imported).unwrap();
    let tilt = format!("tilt = {:?}", original.dome.tilt.to_degrees());
    std::fs::write(&imported, text.replace("tilt = 0.0", &tilt)).unwrap();
    imported
}

/// Every so many pixels are compared in each direction.
const STEP: usize = 2;

/// Greatest difference, in 255ths, between what two rigs show of a scene whose colours are
/// 0.5 + 0.5 · direction.
fn difference(one: &cupola::rig::Rig, other: &cupola::rig::Rig) -> f64 {
    let (mut compared, mut alone, mut worst) = (0, 0, 0.0f64);
    for output in 0..one.outputs.len() {
        let size = one.outputs[output].size.expect("a size");
        let map = |rig| cupola::warp::WarpMap::new(rig, output, size, None).unwrap();
        let maps = [map(one), map(other)];
        for (x, y) in (0..size.1).step_by(STEP).flat_map(|y| (0..size.0).step_by(STEP).map(move |x| (x, y))) {
            let pixel = glam::DVec2::new(f64::from(x), f64::from(y)) + 0.5;
            match [0, 1].map(|index: usize| maps[index].direction(pixel)) {
                [Some(expected), Some(found)] => {
                    compared += 1;
                    worst = worst.max((expected - found).abs().max_element() * 127.5);
                }
                [None, None] => {}
                _ => alone += 1,
            }
        }
    }
    assert!(compared > 50_000 && 100 * alone < compared, "{compared} pixels, {alone} in one of the rigs only");
    worst
}

#[test]
fn an_imported_planetarium_needs_no_more_views_than_the_rig_it_was_made_from() {
    needs_no_more_views("planetarium-6");
}

#[test]
fn an_imported_mirror_needs_no_more_views_than_the_rig_it_was_made_from() {
    needs_no_more_views("idome");
}

fn needs_no_more_views(preset: &str) {
    let source = file(&format!("{preset}-original.toml"));
    // No file has the cells that were found for a preset.
    std::fs::write(&source, preset_of(preset, (640, 360))).unwrap();
    let original = cupola::rig::load(source.to_str().unwrap()).unwrap();
    let (views, texels) = planned(&original);
    for kind in ["mpcdi", "vwf", "data", "sgct"] {
        let imported = match kind {
            "data" => rig_of_meshes(&source, &original),
            "sgct" => rig_of_sgct(&source, &original),
            _ => rig_of_set(&source, &original, kind),
        };
        let found = cupola::rig::load(imported.to_str().unwrap()).unwrap();
        let (found_views, found_texels) = planned(&found);
        let worst = difference(&original, &found);
        println!(
            "{preset} by {kind}: {found_views} of {views} views, {found_texels:.3} of {texels:.3} texels a pixel, \
             {worst:.4} of 255"
        );
        assert!(10 * found_views <= 11 * views, "{preset} by {kind}: {found_views} views instead of {views}");
        assert!(found_texels <= 1.1 * texels, "{preset} by {kind}: {found_texels} texels instead of {texels}");
        assert!(worst <= 0.01, "{preset} by {kind}: {worst} of 255");
        // Negative control: the picture of a viewer who has turned by half a degree.
        let mut turned = original.clone();
        turned.viewer.yaw += 0.5f64.to_radians();
        assert!(difference(&turned, &found) > 0.5, "{preset} by {kind}: another viewer is not noticed");
    }
}
