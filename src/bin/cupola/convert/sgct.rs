//! Conversion of SGCT configurations to rigs.
//!
//! A mirrored viewport without a mesh becomes a mirrored output. A mirrored viewport with a mesh
//! does not: the mesh keeps its place and gets mirrored values. The mesh and the mirrored mask are
//! written to new files.

use super::options::Arguments;
use super::rig::{file_name, heading, mask, quoted};
use super::written::{Written, file_beside, save};
use super::{projector, refuse_to_replace_any};
use crate::failure::Failure;
use cupola::blend::decode;
use cupola::formats::{Grid, bourke, pictures::pfm, png_luma, read_file, sgct};
use cupola::rig::Flip;
use glam::DVec2;
use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

/// Writes a rig for each computer of an SGCT configuration. All pictures have the same eye point.
/// Remarks for the user are added to `notes`.
pub fn rigs(arguments: &Arguments, config: &sgct::Config, notes: &mut Vec<String>) -> Result<Vec<Written>, Failure> {
    let (path, from) = (&*arguments.to, &*arguments.from);
    let file_of = |index: usize, node: &sgct::Node| match config.nodes.len() {
        1 => path.to_owned(),
        _ => file_beside(path, index, &node.address, "toml"),
    };
    for (index, node) in config.nodes.iter().enumerate() {
        let parts = (1..=node.viewports.len()).flat_map(|number| {
            ["pfm", "png", "data"].map(|ending| file_beside(path, 0, &format!("{}-{number}", index + 1), ending))
        });
        refuse_to_replace_any(parts.chain([file_of(index, node)]), arguments.force)?;
    }
    let mut written = Vec::new();
    for (index, node) in config.nodes.iter().enumerate() {
        let mut text = heading(from);
        let left = node.viewports.iter().map(|viewport| viewport.place[0]).min().unwrap_or(0);
        let top = node.viewports.iter().map(|viewport| viewport.place[1]).min().unwrap_or(0);
        let mut outputs = 0;
        for (number, viewport) in node.viewports.iter().enumerate() {
            let name = format!("viewport-{}", number + 1);
            let place = Place { from: Path::new(from), to: path, number: format!("{}-{}", index + 1, number + 1) };
            let Some(keys) = output(viewport, &name, &place, notes)? else { continue };
            let [x, y, width, height] = viewport.place;
            let _ = write!(
                text,
                "\n[[output]]\nname = \"{name}\"\nsize = [{width}, {height}]\nwindow = [{}, {}, {width}, {height}]\n{keys}",
                x - left,
                y - top
            );
            outputs += 1;
        }
        if outputs == 0 {
            notes.push(format!("{from}: no viewport of the computer {:?} can be converted", node.address));
            continue;
        }
        let file = file_of(index, node);
        save(&file, text.as_bytes())?;
        written.push(Written::rig(file, outputs));
    }
    match written.is_empty() {
        true => Err(Failure::usage(format!("{from}: {}", notes.join("; ")))),
        false => Ok(written),
    }
}

/// Keys of the output for a viewport; `None` if it has no counterpart.
fn output(
    viewport: &sgct::Viewport,
    name: &str,
    place: &Place,
    notes: &mut Vec<String>,
) -> Result<Option<String>, Failure> {
    let panorama = panorama(&viewport.projection);
    if let (Some((kind, _)), Some(mesh)) = (&panorama, &viewport.mesh) {
        notes.push(format!("{name} is left out: no rig has the mesh {mesh} in a picture of kind \"{kind}\""));
        return Ok(None);
    }
    // The values of a warp mesh are positions in the picture that would be shown without it.
    let mesh = viewport.mesh.as_deref().filter(|mesh| is_warp_mesh(mesh));
    let shows_places = mesh.is_some() && !matches!(viewport.projection, sgct::Projection::Mirror { .. });
    let anew = shows_places && viewport.mirrored != [false; 2];
    let written = match mesh {
        Some(mesh) if anew => Some(mirrored_mesh(mesh, viewport.mirrored, place)?),
        mesh => mesh.map(str::to_owned),
    };
    let kind = |picture: &str| match &written {
        Some(mesh) => format!("kind = \"mesh\"\nfile = {}\npicture = \"{picture}\"\n", quoted(mesh)),
        None => format!("kind = \"{picture}\"\n"),
    };
    let mut keys = match &viewport.projection {
        sgct::Projection::Fisheye { aperture, tilt } => {
            let kind = kind("domemaster");
            format!("{kind}aperture = {:?}\ntilt = {:?}\n", aperture.to_degrees(), tilt.to_degrees())
        }
        sgct::Projection::Planar { rotation, frustum } => {
            format!("{}{}{}", kind("perspective"), projector::angles(rotation), projector::opening(frustum))
        }
        sgct::Projection::Mirror { tilt, meshes } => mirror(viewport, *tilt, meshes, place)?,
        sgct::Projection::Equirectangular { .. } | sgct::Projection::Cylindrical { .. } => {
            panorama.map_or(String::new(), |(kind, keys)| format!("kind = \"{kind}\"\n{keys}"))
        }
        sgct::Projection::Other(kind) => {
            notes.push(format!("{name}: {kind} is left out"));
            return Ok(None);
        }
    };
    // The mask of a mirror already contains its light.
    if let (Some(mask), false) = (&viewport.mask, matches!(viewport.projection, sgct::Projection::Mirror { .. })) {
        let (size, light) = light_of(mask, if anew { viewport.mirrored } else { [false; 2] }, place)?;
        keys.push_str(&self::mask(&file_beside(place.to, 0, &place.number, "png"), size, light)?);
    }
    let [horizontal, vertical] = viewport.mirrored;
    let flip = Flip { horizontal, vertical };
    if !(flip.is_none() || anew) {
        let _ = writeln!(keys, "flip = \"{}\"", flip.word());
    }
    if let (Some(mesh), None) = (&viewport.mesh, mesh) {
        notes.push(format!(
            "{name}: the mesh {mesh} is left out; convert it and use it in an output with kind = \"mesh\""
        ));
    }
    match viewport.eye {
        Some(sgct::Eye::Left) => keys.push_str("eye = -0.0325\n"),
        Some(sgct::Eye::Right) => keys.push_str("eye = 0.0325\n"),
        None => {}
    }
    Ok(Some(keys))
}

/// Kind and keys of an output for a picture of all directions; `None` for other projections.
fn panorama(projection: &sgct::Projection) -> Option<(&'static str, String)> {
    // From −180° up to 180°.
    let yaw = |yaw: f64| projector::tidy((yaw.to_degrees() + 180.0).rem_euclid(360.0) - 180.0);
    match projection {
        sgct::Projection::Equirectangular { yaw: right } => {
            Some(("equirectangular", format!("yaw = {:?}\n", yaw(*right))))
        }
        sgct::Projection::Cylindrical { yaw: right, heights } => {
            let latitudes = heights.map(|height| projector::tidy(height.atan().to_degrees()));
            Some(("cylindrical", format!("yaw = {:?}\nlatitudes = {latitudes:?}\n", yaw(*right))))
        }
        _ => None,
    }
}

/// Location of the files of a configuration.
struct Place<'a> {
    /// The configuration file. The files that it names are in the same folder.
    from: &'a Path,
    /// The rig file.
    to: &'a Path,
    /// Numbers of computer and viewport, for file names.
    number: String,
}

impl Place<'_> {
    /// The path of a file that the configuration names.
    fn file(&self, name: &str) -> Result<PathBuf, Failure> {
        let folder = self.from.parent().unwrap_or(Path::new(""));
        let path = folder.join(name);
        let refused = |why: &str| Failure::usage(format!("{}: the file {name:?} {why}", self.from.display()));
        let plain = |part| matches!(part, Component::Normal(_) | Component::CurDir);
        if !Path::new(name).components().all(plain) {
            return Err(refused("leads out of the configuration's folder"));
        }
        // If the path cannot be resolved, the file cannot be read either, and reading reports why.
        let resolved =
            |path: &Path| if path.as_os_str().is_empty() { Path::new(".").canonicalize() } else { path.canonicalize() };
        match (resolved(folder), resolved(&path)) {
            (Ok(folder), Ok(found)) if !found.starts_with(&folder) => {
                Err(refused("is a link that leads out of the configuration's folder"))
            }
            _ => Ok(path),
        }
    }
}

/// Keys of an output with a mirror. The meshes of the four faces are combined to one map of
/// directions.
fn mirror(viewport: &sgct::Viewport, tilt: f64, meshes: &[String; 4], place: &Place) -> Result<String, Failure> {
    let [_, _, width, height] = viewport.place;
    let size = (width as u32, height as u32);
    let mut faces = Vec::new();
    for (mesh, axes) in meshes.iter().zip(sgct::mirror_faces(tilt)) {
        let path = place.file(mesh)?;
        let name = path.to_string_lossy();
        faces.push((Grid::Mesh(bourke::read(&name, &read_file(&path)?)?.value.mesh(&name)?), axes));
    }
    let mut values = Vec::with_capacity(size.0 as usize * size.1 as usize);
    let mut light = Vec::with_capacity(values.capacity());
    for (row, column) in (0..size.1).flat_map(|row| (0..size.0).map(move |column| (row, column))) {
        let pixel = DVec2::new(f64::from(column), f64::from(row)) + 0.5;
        // The mesh that is drawn last is visible.
        let shown = faces.iter().rev().find_map(|(mesh, axes)| Some((mesh.sample(pixel, size)?, axes)));
        match shown {
            Some((sample, axes)) => {
                let direction = *axes * (2.0 * sample.value.truncate() - 1.0).extend(-1.0);
                values.push(direction.normalize().as_vec3().to_array());
                light.push(decode(sample.intensity, GAMMA));
            }
            None => {
                values.push([f32::NAN; 3]);
                light.push(0.0);
            }
        }
    }
    if let Some(mask) = &viewport.mask {
        let (of_mask, weights) = light_of(mask, [false; 2], place)?;
        multiply(&mut light, size, &weights, of_mask);
    }
    let map = file_beside(place.to, 0, &place.number, "pfm");
    save(&map, &pfm::write(size.0, &values))?;
    let mask = mask(&file_beside(place.to, 0, &place.number, "png"), size, light)?;
    Ok(format!(
        "kind = \"mesh\"\nfile = {}\nvalues = \"directions\"\n{mask}blend = {{ gamma = {GAMMA} }}\n",
        quoted(&file_name(&map))
    ))
}

/// Writes a mesh with mirrored values and returns its file name.
fn mirrored_mesh(mesh: &str, [across, up]: [bool; 2], place: &Place) -> Result<String, Failure> {
    let path = place.file(mesh)?;
    let mut mesh = bourke::read(&path.to_string_lossy(), &read_file(&path)?)?.value;
    for [_, _, u, v, _] in &mut mesh.nodes {
        *u = if across { 1.0 - *u } else { *u };
        *v = if up { 1.0 - *v } else { *v };
    }
    let to = file_beside(place.to, 0, &place.number, "data");
    save(&to, bourke::write(&mesh).as_bytes())?;
    Ok(file_name(&to))
}

/// Fractions of light of a mask of factors on displayed values, row by row from the top, mirrored.
fn light_of(mask: &str, [across, up]: [bool; 2], place: &Place) -> Result<((u32, u32), Vec<f64>), Failure> {
    let path = place.file(mask)?;
    let ((width, height), weights) = png_luma(&path.to_string_lossy(), &read_file(&path)?)?;
    let turned = |turn: bool, at: u32, count: u32| (if turn { count - 1 - at } else { at }) as usize;
    let weight = |x, y| f64::from(weights[turned(up, y, height) * width as usize + turned(across, x, width)]) / 65535.0;
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    Ok(((width, height), places.map(|(x, y)| decode(weight(x, y), GAMMA)).collect()))
}

/// Multiplies the light of the pixels of a picture by weights that are stretched over it, with
/// bilinear interpolation.
fn multiply(light: &mut [f64], size: (u32, u32), weights: &[f64], of_weights: (u32, u32)) {
    // The two weights next to a pixel, and the share of the second.
    let about = |at: u32, pixels: u32, count: u32| {
        let place = (f64::from(at) + 0.5) * f64::from(count) / f64::from(pixels) - 0.5;
        let place = place.clamp(0.0, f64::from(count - 1));
        let first = place.floor();
        (first as usize, (first as usize + 1).min(count as usize - 1), place - first)
    };
    for (pixel, value) in light.iter_mut().enumerate() {
        let (x, y) = (pixel as u32 % size.0, pixel as u32 / size.0);
        let (left, right, across) = about(x, size.0, of_weights.0);
        let (top, bottom, down) = about(y, size.1, of_weights.1);
        let row = |row: usize| {
            let at = |column: usize| weights[row * of_weights.0 as usize + column];
            at(left) + across * (at(right) - at(left))
        };
        *value *= row(top) + down * (row(bottom) - row(top));
    }
}

/// Exponent of the display's response that is assumed where the file does not contain it.
const GAMMA: f64 = 2.2;

/// True if a file name has the extension of a warp mesh that rigs can use.
fn is_warp_mesh(name: &str) -> bool {
    let ending = Path::new(name).extension().unwrap_or_default();
    ["data", "map"].iter().any(|known| ending.eq_ignore_ascii_case(known))
}
