//! Writes archives: a buffer and a region for each projector.

use super::{Archive, Profile, Region, Version, extension};
use crate::error::{Error, ErrorKind, Result};
use crate::formats::camera::Camera;
use crate::formats::pictures::pfm;
use crate::geom::{Frustum, Optics, pose};
use glam::{DVec2, DVec3};
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use zip::write::SimpleFileOptions;

/// Tangent of the widest side that is written for a lens that is no plane.
const WIDEST_PLANE: f64 = 50.0;

/// Returns the bytes of an archive. Each region has a buffer of its own, which it fills; weights
/// and levels are PNG pictures of 16 bits.
///
/// # Errors
/// [`InvalidRig`](ErrorKind::InvalidRig) if the number of weights or levels of a region does not
/// fit their size, a region lacks the camera that the profile needs, or the format cannot describe
/// its lens; [`Internal`](ErrorKind::Internal) if packing fails.
pub fn write(archive: &Archive, version: Version) -> Result<Vec<u8>> {
    let failed = |error: &dyn std::fmt::Display| Error::new(ErrorKind::Internal, format!("packing MPCDI: {error}"));
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let mut put = |name: &str, bytes: &[u8]| {
        zip.start_file(name, SimpleFileOptions::default()).map_err(|error| failed(&error))?;
        zip.write_all(bytes).map_err(|error| failed(&error))
    };
    put("mpcdi.xml", description(archive, version)?.as_bytes())?;
    for (number, region) in archive.regions.iter().enumerate() {
        if let Some(warp) = &region.warp {
            put(&format!("warp-{number}.pfm"), &pfm::write(warp.size().0, warp.values()))?;
        }
        // The picture is white if there are no weights, because the format requires a map.
        let (size, weights) = region.alpha.as_ref().map_or(((1, 1), &[1.0][..]), |alpha| (alpha.size, &alpha.weights));
        put(&format!("alpha-{number}.png"), &picture(region, size, weights)?)?;
        if let Some(beta) = &region.beta {
            put(&format!("beta-{number}.png"), &beta.png(&format!("region {}", region.id))?)?;
        }
    }
    Ok(zip.finish().map_err(|error| failed(&error))?.into_inner())
}

/// Encodes values 0…1 as PNG.
fn picture(region: &Region, size: (u32, u32), values: &[f32]) -> Result<Vec<u8>> {
    let values = values.iter().map(|value| (value.clamp(0.0, 1.0) * 65535.0).round() as u16).collect();
    let picture = image::ImageBuffer::<image::Luma<u16>, Vec<u16>>::from_raw(size.0, size.1, values);
    let picture = picture.ok_or_else(|| {
        Error::new(ErrorKind::InvalidRig, format!("region {}: weights or levels do not fit their size", region.id))
    })?;
    let mut bytes = Cursor::new(Vec::new());
    let written = picture.write_to(&mut bytes, image::ImageFormat::Png);
    written.map_err(|error| Error::new(ErrorKind::Internal, format!("packing MPCDI: {error}")))?;
    Ok(bytes.into_inner())
}

fn description(archive: &Archive, version: Version) -> Result<String> {
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let (profile, points) = (archive.profile.word(), archive.profile.has_points());
    // Only level 3 and colour 2 have black levels.
    let levels = archive.regions.iter().any(|region| region.beta.is_some());
    let attributes = match version {
        Version::One => format!("level=\"{}\" version=\"1.0\"", if levels { 3 } else { 1 }),
        Version::Two => format!("geometry=\"1\" color=\"{}\" version=\"2.0\"", if levels { 2 } else { 1 }),
    };
    // Writing into a string cannot fail.
    let _ = writeln!(text, "<MPCDI profile=\"{profile}\" {attributes}>\n  <display>");
    for (number, region) in archive.regions.iter().enumerate() {
        let (width, height) = region.size;
        let size = format!("Xresolution=\"{width}\" Yresolution=\"{height}\"");
        let camera = match (archive.profile, &region.camera, &region.fisheye) {
            (Profile::Perspective, Some(camera), _) => frustum(camera),
            (Profile::ShaderLamps, Some(camera), _) => format!("{}{}", frustum(camera), frame(camera.offset)),
            (Profile::ShaderLamps, None, Some(optics)) => {
                let camera = nearest_plane(optics, region.size);
                format!("{}{}", frustum(&camera), frame(camera.offset))
            }
            (profile, None, _) if profile.has_cameras() => {
                let message = format!("region {}: profile {} needs its camera", region.id, profile.word());
                return Err(Error::new(ErrorKind::InvalidRig, message));
            }
            _ => String::new(),
        };
        let _ = writeln!(
            text,
            "    <buffer id=\"buffer-{number}\" {size}>\n      <region id=\"{}\" {size} x=\"0\" y=\"0\" xsize=\"1\" ysize=\"1\">{camera}</region>\n    </buffer>",
            escaped(&region.id)
        );
    }
    text.push_str("  </display>\n  <files>\n");
    for (number, region) in archive.regions.iter().enumerate() {
        let gamma = region.alpha.as_ref().map_or(1.0, |alpha| alpha.gamma);
        let warp = region.warp.as_ref().map_or(String::new(), |_| format!("warp-{number}.pfm"));
        let unit =
            if points { "<geometricUnit>m</geometricUnit><originOf3DData>centerOfMass</originOf3DData>" } else { "" };
        let _ = writeln!(
            text,
            "    <fileset region=\"{}\">\n      <geometryWarpFile><path>{warp}</path><interpolation>linear</interpolation>{unit}</geometryWarpFile>\n      \
             <alphaMap><path>alpha-{number}.png</path><componentDepth>1</componentDepth><bitDepth>16</bitDepth><gammaEmbedded>{gamma}</gammaEmbedded></alphaMap>{}\n    </fileset>",
            escaped(&region.id),
            region.beta.as_ref().map_or(String::new(), |beta| {
                let depth = if beta.is_grey() { 1 } else { 3 };
                format!(
                    "\n      <betaMap><path>beta-{number}.png</path><componentDepth>{depth}</componentDepth><bitDepth>16</bitDepth></betaMap>"
                )
            })
        );
    }
    text.push_str("  </files>\n");
    text.push_str(&extension::text(
        archive.dome.as_ref(),
        archive.regions.iter().map(|region| (escaped(&region.id), region.size, region.fisheye.as_ref())),
    )?);
    text.push_str("</MPCDI>\n");
    Ok(text)
}

/// Formats a camera's opening and its rotation, which is relative to a frame if one follows.
fn frustum(camera: &Camera) -> String {
    let [yaw, pitch, roll] = pose::angles(&camera.rotation).map(f64::to_degrees);
    let degrees = |tangent: f64| tangent.atan().to_degrees();
    let Frustum { left, right, bottom, top } = camera.frustum;
    format!(
        "<frustum><yaw>{yaw}</yaw><pitch>{pitch}</pitch><roll>{roll}</roll><rightAngle>{}</rightAngle><leftAngle>{}</leftAngle>\
         <upAngle>{}</upAngle><downAngle>{}</downAngle></frustum>",
        degrees(right),
        degrees(left),
        degrees(top),
        degrees(bottom)
    )
}

/// Returns the opening for readers that do not know fisheyes: the angles of the middles of the
/// sides, as far as a plane permits.
fn nearest_plane(optics: &Optics, size: (u32, u32)) -> Camera {
    let aspect = f64::from(size.0) / f64::from(size.1);
    let side = |x: f64, y: f64| {
        let ray = optics.lens.ray(DVec2::new(x, y), aspect).filter(|ray| ray.z < 0.0);
        let tangent = ray.map_or(f64::INFINITY, |ray| (ray.x * x + ray.y * y) / -ray.z);
        tangent.clamp(-WIDEST_PLANE, WIDEST_PLANE)
    };
    let frustum =
        Frustum { left: -side(-1.0, 0.0), right: side(1.0, 0.0), bottom: -side(0.0, -1.0), top: side(0.0, 1.0) };
    Camera { offset: optics.pose.position, rotation: optics.pose.rotation, frustum }
}

/// Formats the frame of a camera at this position, with the axes of the file: the pitch axis to the
/// right, the yaw axis down, the roll axis forward.
fn frame(DVec3 { x, y, z }: DVec3) -> String {
    let vector =
        |name: &str, [x, y, z]: [f64; 3]| format!("<{name}x>{x}</{name}x><{name}y>{y}</{name}y><{name}z>{z}</{name}z>");
    format!(
        "<coordinateFrame>{}{}{}{}</coordinateFrame>",
        vector("pos", [x, y, z]),
        vector("yaw", [0.0, -1.0, 0.0]),
        vector("pitch", [1.0, 0.0, 0.0]),
        vector("roll", [0.0, 0.0, -1.0])
    )
}

/// Escapes text for an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
