//! Description of a rig as text and as JSON.

use super::numbers::{degrees, meters, number};
use super::remarks::{costly, remarks};
use super::words;
use cupola::geom::PixelRect;
use cupola::geom::{Frustum, Lens, Optics};
use cupola::rig::{
    Blend, Camera, Content, ContentKind, DomeAngle, Output, OutputKind, Rig, Stereo, Transfer, ViewMethod,
};
use cupola::views::{self, View, ViewPlan};
use serde_json::{Value, json};
use std::fmt::Write;

/// Description of the rig as text, one line for each part.
pub fn words(rig: &Rig, window: (u32, u32), plan: &ViewPlan) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = describe(&mut text, rig, window, plan);
    text
}

fn describe(text: &mut String, rig: &Rig, window: (u32, u32), plan: &ViewPlan) -> std::fmt::Result {
    writeln!(text, "{} is a valid rig.", rig.name)?;
    if rig.passthrough {
        return writeln!(text, "The program's own picture is not changed.");
    }
    let dome = &rig.dome;
    writeln!(
        text,
        "dome      radius {} m, pole {}, {} of it is screen",
        number(dome.radius),
        upwards(dome.tilt),
        degrees(dome.coverage)
    )?;
    if let Some(screen) = &rig.screen {
        writeln!(text, "screen    {}, {}", words::screen(screen), meters(screen.pose.position.to_array()))?;
    }
    let viewer = &rig.viewer;
    let place = match viewer.position.to_array() {
        [0.0, 0.0, 0.0] => "in the dome's centre".to_owned(),
        [x, y, z] => format!("{} m from the dome's centre {}", number(viewer.position.length()), meters([x, y, z])),
    };
    writeln!(text, "viewer    {place}{}", aim([viewer.yaw, viewer.pitch, viewer.roll]))?;
    match &rig.content {
        Some(content) => writeln!(text, "content   {}", content_words(content))?,
        None => {
            writeln!(text, "camera    {}", camera(&rig.camera))?;
            let overlay = &rig.overlay;
            let (width, aim) = (degrees(overlay.width), aim([overlay.yaw, overlay.pitch, 0.0]));
            writeln!(text, "overlay   flat drawing fills {width}{aim}")?;
        }
    }
    describe_outputs(text, rig, window)?;
    describe_views(text, rig, plan)?;
    let sizes = rig.sizes(window);
    let report = views::report(plan, rig, &sizes);
    let (drawn, shown, ratio) = (report.view_texels, report.output_pixels, report.texels_per_pixel);
    if shown > 0 {
        writeln!(text, "cost      {drawn} texels drawn for {shown} pixels shown, {ratio:.2} each")?;
    }
    for note in plan.remarks() {
        writeln!(text, "note      {note}")?;
    }
    for note in jumps(rig, &sizes).into_iter().chain(all_remarks(rig, window, &report)) {
        writeln!(text, "note      {note}")?;
    }
    Ok(())
}

fn describe_outputs(text: &mut String, rig: &Rig, window: (u32, u32)) -> std::fmt::Result {
    writeln!(text, "outputs   {} in a window of {} × {} pixels", rig.outputs.len(), window.0, window.1)?;
    for (output, PixelRect { x, y, width, height }) in rig.outputs.iter().zip(rig.layout(window)) {
        writeln!(text, "  {:14} {}", output.name, kind(&output.kind))?;
        match (output.shown, output.size) {
            (false, size) => {
                let (width, height) = size.unwrap_or_default();
                let place = output.own_window.as_ref().map_or("published only".to_owned(), words::own_window);
                writeln!(text, "  {:14} {width} × {height} pixels, {place}", "")?;
            }
            (true, size) => {
                let native = size.map_or(String::new(), |(w, h)| format!("; {w} × {h} off screen"));
                writeln!(text, "  {:14} {width} × {height} pixels at ({x}, {y}) in the window{native}", "")?;
            }
        }
        let extras = extras(output);
        if !extras.is_empty() {
            writeln!(text, "  {:14} {extras}", "")?;
        }
    }
    Ok(())
}

fn describe_views(text: &mut String, rig: &Rig, plan: &ViewPlan) -> std::fmt::Result {
    let method = match rig.views.method {
        ViewMethod::Auto => "the cheapest arrangement",
        ViewMethod::Cube => "faces of one cube",
        ViewMethod::Single => "one for each output",
    };
    if rig.content.is_some() {
        return writeln!(
            text,
            "views     none; the program's window is shown, {} × {} pixels",
            plan.atlas.0, plan.atlas.1
        );
    }
    writeln!(
        text,
        "views     {} ({method}, quality {}) in an atlas of {} × {} texels",
        plan.views.len(),
        number(rig.views.quality),
        plan.atlas.0,
        plan.atlas.1
    )?;
    for view in &plan.views {
        writeln!(text, "  {:14} {}", view.name, view_words(view))?;
    }
    Ok(())
}

/// All remarks about a rig in a window.
fn all_remarks(rig: &Rig, window: (u32, u32), report: &views::Report) -> Vec<String> {
    let sizes = rig.sizes(window);
    let mut all = remarks(rig, &sizes);
    all.extend(rig.too_small(window, &sizes));
    all.extend(costly(rig, report, &sizes));
    all
}

/// Descriptions of the places where the light must change abruptly between outputs.
fn jumps(rig: &Rig, sizes: &[(u32, u32)]) -> Vec<String> {
    // For a rig whose weights cannot be computed, the planner has reported the error.
    cupola::blend::crossings(rig, sizes).unwrap_or_default().iter().map(|crossing| words::jump(rig, crossing)).collect()
}

fn view_words(view: &View) -> String {
    let tile = format!("{} × {} texels", view.tile.width, view.tile.height);
    if view.program_lens {
        format!("as the program draws it, {tile}")
    } else {
        format!("{}, {tile}", opening(&view.owned))
    }
}

fn kind(kind: &OutputKind) -> String {
    match kind {
        OutputKind::Domemaster { aperture, tilt } => {
            format!("domemaster of {}, its centre {}", degrees(*aperture), upwards(*tilt))
        }
        OutputKind::Panorama { panorama, angles } => format!("{}{}", words::panorama(panorama), aim(*angles)),
        OutputKind::Projector { position, angles, frustum } => {
            format!("projector {}{}, {}", meters(position.to_array()), aim(*angles), opening(frustum))
        }
        OutputKind::Optics { optics, .. } => special(optics),
        OutputKind::Mesh(calibration) => words::calibration(calibration),
        OutputKind::Perspective { angles, frustum: Some(frustum) } => {
            format!("perspective picture{}, {}", aim(*angles), opening(frustum))
        }
        OutputKind::Perspective { angles, frustum: None } => {
            format!("perspective picture{}, through the program's own lens", aim(*angles))
        }
    }
}

/// Description of a projector with a special lens or a mirror.
fn special(optics: &Optics) -> String {
    let lens = match &optics.lens {
        Lens::Pinhole { frustum, distortion, keystone } => {
            let bent = if distortion.is_none() { "" } else { ", a lens that distorts" };
            let keystone = if *keystone == glam::DMat3::IDENTITY { "" } else { ", keystone" };
            format!("{}{bent}{keystone}", opening(frustum))
        }
        Lens::Fisheye { lens, .. } => {
            format!("a fisheye lens of {}, {}", degrees(lens.aperture), words::projection(lens))
        }
    };
    let mirror = optics.mirror.map_or(String::new(), |mirror| {
        format!(", before a mirror of radius {} m {}", number(mirror.radius), meters(mirror.center.to_array()))
    });
    format!("projector {}, {lens}{mirror}", meters(optics.pose.position.to_array()))
}

/// Description of blending, mask, black level and flip of an output; empty if there is none.
fn extras(output: &Output) -> String {
    let Blend { overlap, ramp, ramps, gamma, transfer, black_level, contrast, dither, .. } = &output.blend;
    let mut parts = Vec::new();
    if output.eye != 0.0 {
        let side = if output.eye < 0.0 { "left" } else { "right" };
        parts.push(format!("for an eye {} mm to the {side} of the viewer's place", number(1e3 * output.eye.abs())));
    }
    match (output.flip.horizontal, output.flip.vertical) {
        (false, false) => {}
        (true, false) => parts.push("mirrored left to right".to_owned()),
        (false, true) => parts.push("mirrored top to bottom".to_owned()),
        (true, true) => parts.push("mirrored both ways".to_owned()),
    }
    let plain = parts.len();
    if *overlap {
        parts.push(format!("blended where projectors overlap (ramp {} %)", number(ramp * 100.0)));
    }
    for ramp in ramps {
        let angle = match ramp.angle {
            DomeAngle::Polar => "from the pole",
            DomeAngle::Azimuth => "around the pole",
        };
        parts.push(format!("fades from {} to {} {angle}", degrees(ramp.full), degrees(ramp.zero)));
    }
    if let Some(mask) = &output.mask {
        parts.push(format!("masked by {}", mask.display()));
    }
    if let Some(black) = &output.black {
        parts.push(format!("black raised by {}", black.file.display()));
    }
    if *black_level > 0.0 {
        parts.push(format!("black raised by {} %", number(black_level * 100.0)));
    }
    if let Some(contrast) = contrast {
        parts.push(format!("black evened out for a contrast of {}", number(*contrast)));
    }
    if let Some(bits) = dither {
        parts.push(format!("dithered for {bits} bits"));
    }
    if parts.len() > plain {
        parts.push(match transfer {
            Transfer::Power => format!("gamma {}", number(*gamma)),
            Transfer::Powers([red, green, blue]) => {
                format!("gamma {} red, {} green, {} blue", number(*red), number(*green), number(*blue))
            }
            Transfer::Srgb => "response of sRGB".to_owned(),
            Transfer::Measured(_) => "measured response".to_owned(),
        });
    }
    parts.join(", ")
}

fn camera(camera: &Camera) -> String {
    if *camera == Camera::default() {
        return "as the program has it".to_owned();
    }
    let mut parts = Vec::new();
    if camera.zoom != 1.0 {
        parts.push(format!("everything {} times as large", number(camera.zoom)));
    }
    let [x, y, z] = camera.shift.to_array();
    if [x, y, z] != [0.0; 3] {
        parts.push(format!("moved by ({}, {}, {}) in the program's units", number(x), number(y), number(z)));
    }
    let aim = aim([camera.yaw, camera.pitch, camera.roll]);
    if !aim.is_empty() {
        parts.push(format!("turned{aim}"));
    }
    if let Some([width, height]) = camera.lens {
        parts.push(format!("{} × {} where the program does not tell its lens", degrees(width), degrees(height)));
    }
    if camera.units_per_meter != 1.0 {
        parts.push(format!("{} units of the program in a metre", number(camera.units_per_meter)));
    }
    parts.join(", ")
}

/// Description of what the program's window shows.
fn content_words(content: &Content) -> String {
    let picture = match &content.kind {
        ContentKind::Directions(panorama) => words::panorama(panorama),
        ContentKind::Flat { width } => format!("flat picture, {} wide", degrees(*width)),
    };
    let eyes = match content.stereo {
        Stereo::None => "",
        Stereo::SideBySide => ", the left eye's in its left half",
        Stereo::TopBottom => ", the left eye's in its upper half",
    };
    let part = if content.region.is_some() { "a part of the program's window" } else { "the program's window" };
    format!("{part} is shown as it is: {picture}{}{eyes}", aim(content.angles))
}

/// The word of rig files for the kind of content.
fn content_kind(content: &Content) -> &'static str {
    match &content.kind {
        ContentKind::Directions(panorama) => words::kind(panorama),
        ContentKind::Flat { .. } => "flat",
    }
}

/// Description of angles such as `, 10° to the right, 5° up`; empty for straight ahead.
fn aim([yaw, pitch, roll]: [f64; 3]) -> String {
    let word = |angle: f64, positive, negative| match angle {
        0.0 => String::new(),
        _ => format!(", {} {}", degrees(angle.abs()), if angle > 0.0 { positive } else { negative }),
    };
    word(yaw, "to the right", "to the left") + &word(pitch, "up", "down") + &word(roll, "clockwise", "counterclockwise")
}

/// Description of an angle from the zenith towards the front.
fn upwards(tilt: f64) -> String {
    match tilt.to_degrees().round() as i64 {
        _ if tilt == 0.0 => "straight up".to_owned(),
        90 if (tilt.to_degrees() - 90.0).abs() < 1e-9 => "straight ahead".to_owned(),
        _ => {
            format!("{} from the zenith towards the {}", degrees(tilt.abs()), if tilt > 0.0 { "front" } else { "back" })
        }
    }
}

fn opening(frustum: &Frustum) -> String {
    let [left, right, bottom, top] =
        [frustum.left, frustum.right, frustum.bottom, frustum.top].map(|side| degrees(side.atan()));
    format!("from {left} to {right} across and {bottom} to {top} upwards")
}

/// The rig and its views as JSON: metres, degrees, pixels from the top left, texels from the bottom
/// left.
pub fn json(rig: &Rig, window: (u32, u32), plan: &ViewPlan) -> Value {
    let angles = |[yaw, pitch, roll]: [f64; 3]| json!({ "yaw": yaw.to_degrees(), "pitch": pitch.to_degrees(), "roll": roll.to_degrees() });
    let (viewer, camera) = (&rig.viewer, &rig.camera);
    let outputs: Vec<Value> = rig
        .outputs
        .iter()
        .zip(rig.layout(window))
        .zip(&plan.output_views)
        .map(|((output, place), views)| {
            let kind = match &output.kind {
                OutputKind::Domemaster { .. } => "domemaster",
                OutputKind::Projector { .. } | OutputKind::Optics { .. } => "projector",
                OutputKind::Mesh(_) => "mesh",
                OutputKind::Perspective { .. } => "perspective",
                OutputKind::Panorama { panorama, .. } => words::kind(panorama),
            };
            let views: Vec<&str> = views.iter().map(|view| plan.views[*view].name.as_str()).collect();
            json!({
                "name": output.name, "kind": kind, "size": output.size, "window": output.shown.then_some(place), "eye": output.eye, "views": views,
                "flip": output.flip.word(), "mask": output.mask, "black": output.black.as_ref().map(|black| &black.file),
            })
        })
        .collect();
    json!({
        "valid": true,
        "name": rig.name,
        "passthrough": rig.passthrough,
        "window": [window.0, window.1],
        "dome": {
            "radius": rig.dome.radius,
            "tilt": rig.dome.tilt.to_degrees(),
            "coverage": rig.dome.coverage.to_degrees(),
        },
        "screen": rig.screen.as_ref().map(words::screen),
        "viewer": { "position": viewer.position.to_array(), "angles": angles([viewer.yaw, viewer.pitch, viewer.roll]) },
        "camera": {
            "zoom": camera.zoom,
            "move": camera.shift.to_array(),
            "angles": angles([camera.yaw, camera.pitch, camera.roll]),
        },
        "content": rig.content.as_ref().map(|content| json!({
            "kind": content_kind(content),
            "angles": angles(content.angles),
            "stereo": content.stereo.word(),
            "region": content.region.map(|region| {
                [region.origin.x, 1.0 - region.origin.y - region.size.y, region.size.x, region.size.y]
            }),
        })),
        "outputs": outputs,
        "atlas": [plan.atlas.0, plan.atlas.1],
        "views": plan.views.iter().map(view).collect::<Vec<_>>(),
        "notes": plan.notes,
        "jumps": jumps(rig, &rig.sizes(window)),
        "remarks": all_remarks(rig, window, &views::report(plan, rig, &rig.sizes(window))),
    })
}

/// A view as JSON: axes as rows, tangents, texels of the atlas from the bottom left.
pub fn view(view: &View) -> Value {
    json!({
        "name": view.name,
        "axes": view.rotation.transpose().to_cols_array_2d(),
        "tangents": [view.frustum.left, view.frustum.right, view.frustum.bottom, view.frustum.top],
        "tile": [view.tile.x, view.tile.y, view.tile.width, view.tile.height],
        "program_lens": view.program_lens,
    })
}
