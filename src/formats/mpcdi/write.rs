//! Archives of our own: version 1.0, a buffer and a region for each projector.

use super::{Alpha, Archive, Region};
use crate::error::{Error, ErrorKind, Result};
use crate::formats::pfm;
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use zip::write::SimpleFileOptions;

/// The bytes of an archive. Each region has a buffer of its own that it fills; weights are PNG of 16 bits.
///
/// # Errors
/// [`InvalidRig`](ErrorKind::InvalidRig) if the weights of a region are not as many as its alpha's size says,
/// [`Internal`](ErrorKind::Internal) if packing fails.
pub fn write(archive: &Archive) -> Result<Vec<u8>> {
    let failed = |error: &dyn std::fmt::Display| Error::new(ErrorKind::Internal, format!("packing MPCDI: {error}"));
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let mut put = |name: &str, bytes: &[u8]| {
        zip.start_file(name, SimpleFileOptions::default()).map_err(|error| failed(&error))?;
        zip.write_all(bytes).map_err(|error| failed(&error))
    };
    put("mpcdi.xml", description(archive).as_bytes())?;
    for (number, region) in archive.regions.iter().enumerate() {
        put(&format!("warp-{number}.pfm"), &pfm::write(region.warp.size().0, region.warp.values()))?;
        put(&format!("alpha-{number}.png"), &picture(region)?)?;
    }
    Ok(zip.finish().map_err(|error| failed(&error))?.into_inner())
}

/// The weights of a region as PNG; white where it has none, since the format asks for a map.
fn picture(region: &Region) -> Result<Vec<u8>> {
    let white = || Alpha { size: (1, 1), weights: vec![1.0], gamma: 1.0 };
    let alpha = region.alpha.clone().unwrap_or_else(white);
    let values = alpha.weights.iter().map(|weight| (weight.clamp(0.0, 1.0) * 65535.0).round() as u16).collect();
    let picture = image::ImageBuffer::<image::Luma<u16>, Vec<u16>>::from_raw(alpha.size.0, alpha.size.1, values);
    let picture = picture.ok_or_else(|| {
        Error::new(ErrorKind::InvalidRig, format!("region {}: the weights do not fit their size", region.id))
    })?;
    let mut bytes = Cursor::new(Vec::new());
    let written = picture.write_to(&mut bytes, image::ImageFormat::Png);
    written.map_err(|error| Error::new(ErrorKind::Internal, format!("packing MPCDI: {error}")))?;
    Ok(bytes.into_inner())
}

fn description(archive: &Archive) -> String {
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let (profile, points) = (archive.profile.word(), archive.profile.has_points());
    // Writing into a string cannot fail.
    let _ = writeln!(text, "<MPCDI profile=\"{profile}\" level=\"1\" version=\"1.0\">\n  <display>");
    for (number, region) in archive.regions.iter().enumerate() {
        let (width, height) = region.size;
        let size = format!("Xresolution=\"{width}\" Yresolution=\"{height}\"");
        let _ = writeln!(
            text,
            "    <buffer id=\"buffer-{number}\" {size}>\n      <region id=\"{}\" {size} x=\"0\" y=\"0\" xsize=\"1\" ysize=\"1\"/>\n    </buffer>",
            escaped(&region.id)
        );
    }
    text.push_str("  </display>\n  <files>\n");
    for (number, region) in archive.regions.iter().enumerate() {
        let gamma = region.alpha.as_ref().map_or(1.0, |alpha| alpha.gamma);
        let unit =
            if points { "<geometricUnit>m</geometricUnit><originOf3DData>centerOfMass</originOf3DData>" } else { "" };
        let _ = writeln!(
            text,
            "    <fileset region=\"{}\">\n      <geometryWarpFile><path>warp-{number}.pfm</path><interpolation>linear</interpolation>{unit}</geometryWarpFile>\n      \
             <alphaMap><path>alpha-{number}.png</path><componentDepth>1</componentDepth><bitDepth>16</bitDepth><gammaEmbedded>{gamma}</gammaEmbedded></alphaMap>\n    </fileset>",
            escaped(&region.id)
        );
    }
    text.push_str("  </files>\n</MPCDI>\n");
    text
}

/// Text in an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
