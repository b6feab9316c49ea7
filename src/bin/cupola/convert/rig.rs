//! Writing of rigs from calibrations and from configurations of other programs.

use super::options::Values;
use super::source::Channel;
use super::written::{Written, file_beside, raster, save};
use super::{projector, refuse_to_replace_any};
use crate::failure::Failure;
use cupola::blend::decode;
use cupola::formats::{Raster, mpcdi, pictures::pfm};
use cupola::geom::Optics;
use cupola::rig::Dome;
use glam::DVec3;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Fails if a map, a mask or a picture of black exists that the rig's parts would replace.
pub fn refuse_to_replace_parts(path: &Path, channels: &[Channel], force: bool) -> Result<(), Failure> {
    for (index, channel) in channels.iter().enumerate() {
        let maps = ["pfm", "png"].map(|ending| file_beside(path, index, &channel.name, ending));
        let map = usize::from(!channel.has_map());
        let black = channel.black.is_some().then(|| black_file(path, channel, index));
        refuse_to_replace_any(maps.into_iter().skip(map).chain(black), force)?;
    }
    Ok(())
}

/// The picture of an output's black.
fn black_file(path: &Path, channel: &Channel, index: usize) -> PathBuf {
    file_beside(path, index, &format!("{}-black", label(channel, index)), "png")
}

/// Writes a rig with an output for each channel, and a map and weights for each output to separate
/// files. Channels of which only the projector is known become projectors; with `projectors`, all
/// channels whose projector is known.
pub fn from_channels(path: &Path, from: &str, channels: &[Channel], projectors: bool) -> Result<Vec<Written>, Failure> {
    let mut text = heading(from);
    let mut written = Vec::new();
    let mut outputs = String::new();
    let mut radius = None;
    for (index, channel) in channels.iter().enumerate() {
        let known = if channel.has_map() { Some(raster(channel)?) } else { None };
        if let (Some((map, _)), Values::Points) = (&known, channel.values) {
            radius = radius.or_else(|| mean_distance(map));
        }
        let name = if channel.name.is_empty() { format!("output-{}", index + 1) } else { harmless(&channel.name) };
        let (width, height) = channel.size;
        let _ = write!(outputs, "\n[[output]]\nname = {}\nsize = [{width}, {height}]\n", quoted(&name));
        let beside = |ending: &str| file_beside(path, index, &channel.name, ending);
        let black_file = black_file(path, channel, index);
        match (channel.described_projector(), known) {
            (Some((optics, alpha)), known) if projectors || known.is_none() => {
                outputs.push_str(&described_projector(channel, optics, alpha, &beside("png"))?);
            }
            (_, Some((map, weights))) => {
                let file = beside("pfm");
                save(&file, &pfm::write(width, map.values()))?;
                let values = channel.values.words();
                let _ =
                    writeln!(outputs, "kind = \"mesh\"\nfile = {}\nvalues = \"{values}\"", quoted(&file_name(&file)));
                let light = |weight: &f32| decode(f64::from(*weight), channel.gamma);
                outputs.push_str(&mask(&beside("png"), channel.size, weights.iter().map(light).collect())?);
                let _ = writeln!(outputs, "blend = {{ {} }}", display(channel));
                written.push(Written::map(file, channel.values));
            }
            (_, None) => return Err(Failure::usage(format!("{name} has neither a map nor a projector"))),
        }
        if let Some(black) = &channel.black {
            save(&black_file, &black.png(&name)?)?;
            let _ = writeln!(outputs, "black = {{ image = {} }}", quoted(&file_name(&black_file)));
        }
    }
    let dome = channels.first().and_then(|channel| channel.dome.as_ref());
    text.push_str(&dome_section(dome, radius));
    text.push_str(&outputs);
    save(path, text.as_bytes())?;
    written.push(Written::rig(path.to_owned(), channels.len()));
    Ok(written)
}

/// The dome: that of the file, or one through the points that it has.
fn dome_section(dome: Option<&Dome>, radius: Option<f64>) -> String {
    match dome {
        Some(dome) => format!(
            "\n[dome]\nradius = {}\ntilt = {}\ncoverage = {}\n",
            dome.radius,
            projector::tidy(dome.tilt.to_degrees()),
            projector::tidy(dome.coverage.to_degrees())
        ),
        None => format!(
            "\n[dome]\nradius = {:.4} # metres{}\ntilt = 0.0 # degrees; not in the file\n\
             coverage = 180.0 # degrees; not in the file\n",
            radius.unwrap_or(5.0),
            if radius.is_some() { ": the points' mean distance from the origin" } else { "; not in the file" },
        ),
    }
}

/// Name of a channel, or its number if it has no name.
fn label(channel: &Channel, index: usize) -> String {
    if channel.name.is_empty() { (index + 1).to_string() } else { channel.name.clone() }
}

/// Keys of a projector that a calibration describes. Weights in the calibration replace blending
/// with neighbours.
fn described_projector(
    channel: &Channel,
    optics: &Optics,
    alpha: Option<&mpcdi::Alpha>,
    file: &Path,
) -> Result<String, Failure> {
    let aspect = f64::from(channel.size.0) / f64::from(channel.size.1);
    let mut keys = format!("kind = \"projector\"\n{}", projector::keys(optics, aspect)?);
    let mut blend = display(channel);
    if let Some(alpha) = alpha {
        let light = |weight: &f32| decode(f64::from(*weight), alpha.gamma);
        keys.push_str(&mask(file, alpha.size, alpha.weights.iter().map(light).collect())?);
        blend.push_str(", overlap = false");
    }
    let _ = writeln!(keys, "blend = {{ {blend} }}");
    Ok(keys)
}

/// Keys of `blend` that describe the display.
fn display(channel: &Channel) -> String {
    let level =
        if channel.black_level > 0.0 { format!(", black_level = {:?}", channel.black_level) } else { String::new() };
    format!("gamma = {}{level}", channel.gamma)
}

/// Writes fractions of light as a picture and returns the key that refers to it. Writes nothing if
/// all fractions are 1.
pub fn mask(file: &Path, size: (u32, u32), light: Vec<f64>) -> Result<String, Failure> {
    if light.iter().all(|light| (light - 1.0).abs() <= 1e-4) {
        return Ok(String::new());
    }
    save(file, &mask_picture(size, &light)?)?;
    Ok(format!("mask = {{ image = {} }}\n", quoted(&file_name(file))))
}

/// The first line of a rig file: where the rig comes from.
pub fn heading(from: &str) -> String {
    let name = Path::new(from).file_name().unwrap_or_default().to_string_lossy().replace(char::is_control, "");
    format!("# Converted from {name} by `cupola convert`.\n")
}

/// Text as a TOML string.
pub fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            _ if character.is_control() => drop(write!(quoted, "\\u{:04X}", u32::from(character))),
            _ => quoted.push(character),
        }
    }
    quoted.push('"');
    quoted
}

/// A name from a file, reduced to the characters that rigs allow.
fn harmless(name: &str) -> String {
    let kept: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' }).collect();
    kept.trim_start_matches(['-', '.']).chars().take(64).collect()
}

/// The last part of a path.
pub fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Mean distance of the points of a map from the origin.
fn mean_distance(map: &Raster) -> Option<f64> {
    let distances = map.values().iter().map(|value| DVec3::from_array(value.map(f64::from)).length());
    let (sum, count) = distances.filter(|distance| distance.is_finite()).fold((0.0, 0.0), |(s, n), d| (s + d, n + 1.0));
    (count > 0.0 && sum > 0.0).then(|| sum / count)
}

/// Fractions of light as a grey PNG picture with 16 bits.
fn mask_picture((width, height): (u32, u32), light: &[f64]) -> Result<Vec<u8>, Failure> {
    let values = light.iter().map(|light| (light.clamp(0.0, 1.0) * 65535.0).round() as u16).collect();
    let picture: Option<image::ImageBuffer<image::Luma<u16>, Vec<u16>>> =
        image::ImageBuffer::from_raw(width, height, values);
    let picture = picture.ok_or_else(|| Failure::new("an output has no pixels"))?;
    let mut bytes = std::io::Cursor::new(Vec::new());
    let written = picture.write_to(&mut bytes, image::ImageFormat::Png);
    written.map_err(|error| Failure::new(format!("a mask cannot be compressed: {error}")))?;
    Ok(bytes.into_inner())
}
