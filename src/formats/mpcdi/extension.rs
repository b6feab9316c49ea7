//! Extensions: the dome, in Cupola's own `CupolaDome`, and lenses that MPCDI itself cannot
//! describe, in Christie's `BufferExtension`: fisheyes and squeezed (anamorphic) pictures.
//!
//! A fisheye's radius is f1·θ + f3·θ³ + f5·θ⁵ + f7·θ⁷ in half widths of the picture. Its offsets
//! are those of the picture from the axis, in half widths and half heights, as for plane lenses. An
//! anamorphic ratio is the height of a pixel divided by its width. The unit of θ is not defined and
//! differs between writers. The angle of the squeeze has only a name: its public description says
//! that it is not 0 if the lens is turned in its mount, but not what it turns, from where and in
//! which direction.

use super::Dome;
use super::document::{Reader, named};
use crate::error::{Error, ErrorKind, Result};
use crate::formats::reading::text::shown;
use crate::geom::{Circle, FisheyeLens, Lens, Optics, Projection};
use glam::DVec2;
use roxmltree::Node;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::ops::RangeInclusive;

/// Name of the extension with lenses.
pub(super) const NAME: &str = "BufferExtension";

/// Name of the extension with the dome, which only Cupola writes.
pub(super) const DOME: &str = "CupolaDome";

/// Range of the radius at the rim of a fisheye of 180°, in half widths of the picture. It is
/// narrower than the ratio 57 between a degree and a radian, so at most one of the two units fits a
/// lens that is nearly equidistant.
const RIM: RangeInclusive<f64> = 0.1..=4.0;

/// Lens of a region, as the extension describes it.
pub(super) enum Described {
    /// No lens.
    Plain,
    /// A fisheye, and the position of its circle in the picture.
    Fisheye(FisheyeLens, Circle),
    /// A fisheye whose numbers cannot be understood; a note says so.
    Unclear,
}

/// Lens of the region `id`, whose picture has `size` pixels.
pub(super) fn lens(
    reader: &Reader,
    root: Node,
    id: &str,
    size: (u32, u32),
    notes: &mut Vec<String>,
) -> Result<Described> {
    let ours = |node: &Node| reader.attribute(*node, "Name").is_ok_and(|name| name == NAME);
    let mut regions = named(root, "extension").filter(ours).flat_map(|extension| named(extension, "region"));
    let Some(region) = regions.find(|region| reader.attribute(*region, "id").is_ok_and(|of| of == id)) else {
        return Ok(Described::Plain);
    };
    let title = format!("{}: region {}", reader.name, shown(id));
    let anamorphic = named(region, "anamorphic").next();
    let Some(fisheye) = named(region, "fisheye").next() else {
        if anamorphic.is_some() {
            notes.push(format!("{title}: its anamorphic ratio is not taken over; the angles of its sides count"));
        }
        return Ok(Described::Plain);
    };
    let number = |node: Node, name: &str, absent: f64, allowed: RangeInclusive<f64>| {
        let Some(word) = reader.text(node, name) else { return Ok(absent) };
        let number = word.parse::<f64>().ok().filter(|number| allowed.contains(number));
        let range = format!("{} to {}", allowed.start(), allowed.end());
        number.ok_or_else(|| reader.wrong(node, format!("{name} = {} is no number from {range}", shown(word))))
    };
    let factor = |name| number(fisheye, name, 0.0, -1e6..=1e6);
    let factors = [factor("f1")?, factor("f3")?, factor("f5")?, factor("f7")?];
    let offset = |name| number(fisheye, name, 0.0, -4.0..=4.0);
    let center = -DVec2::new(offset("horizontalOffset")?, offset("verticalOffset")?);
    let (mut ratio, mut skew) = (1.0, 0.0);
    if let Some(anamorphic) = anamorphic {
        ratio = number(anamorphic, "ratio", 1.0, 0.01..=100.0)?;
        skew = number(anamorphic, "angle", 0.0, -360.0..=360.0)?;
    }
    // Only Cupola's own archives contain it, in radians.
    let known = reader.text(fisheye, "aperture").is_some();
    let aperture = number(fisheye, "aperture", 180.0, 1e-3..=360.0)?.to_radians();
    let Some(Understood { lens, rim, unit }) = understood(factors, aperture, known) else {
        notes.push(format!(
            "{title}: its fisheye is not taken over: whether the angle is in radians or in degrees, 90° from its axis would lie {:.4} or \
             {:.4} half widths from it, or the radius does not grow up to there",
            radius(&factors, 0.5 * aperture),
            radius(&factors, (0.5 * aperture).to_degrees())
        ));
        return Ok(Described::Unclear);
    };
    if !known {
        notes.push(format!(
            "{title}: the angle of its fisheye is taken as {unit}, which puts 90° from the axis at {rim:.4} half widths; the aperture, \
             which is not said, as 180°"
        ));
    }
    if skew != 0.0 {
        notes.push(skew_note(&title, rim * 0.5 * f64::from(size.0), ratio, skew));
    }
    let aspect = f64::from(size.0) / f64::from(size.1);
    let circle = Circle::Placed { center, half: DVec2::new(rim, rim * aspect / ratio) };
    Ok(Described::Fisheye(lens, circle))
}

/// Note about the angle `skew` of an anamorphic lens, degrees, whose rim has a radius of `rim`
/// pixels.
fn skew_note(title: &str, rim: f64, ratio: f64, skew: f64) -> String {
    // Axes turned by δ move the rim by up to ‖R·D·Rᵀ − D‖ = |1 − 1/ratio| · |sin δ| radii, with D =
    // diag(1, 1/ratio).
    let turned = rim * (1.0 - 1.0 / ratio).abs() * skew.to_radians().sin().abs();
    format!(
        "{title}: the angle of its anamorphic lens, {skew}, is not taken over: no public text says what it turns, or which way; \
         if it turns the axes of the squeeze, by degrees, the rim lies up to {turned:.1} pixels elsewhere"
    )
}

/// A fisheye whose unit was found.
struct Understood {
    lens: FisheyeLens,
    /// Radius of the rim, half widths of the picture.
    rim: f64,
    /// Unit of the angle in the file.
    unit: &'static str,
}

/// Makes a fisheye of these factors, with the unit of the angle that fits. `known`: the file
/// contains its aperture, and the unit is the radian.
fn understood(factors: [f64; 4], aperture: f64, known: bool) -> Option<Understood> {
    let units = [("radians", 1.0), ("degrees", 180.0 / PI)];
    units.iter().find_map(|(word, unit)| {
        let mut power = *unit;
        let scaled = factors.map(|factor| {
            let scaled = factor * power;
            power *= unit * unit;
            scaled
        });
        let rim = radius(&scaled, 0.5 * aperture);
        let lens = FisheyeLens { projection: Projection::Polynomial(scaled), aperture };
        let fits = lens.is_monotone() && (known && *unit == 1.0 || RIM.contains(&rim));
        fits.then_some(Understood { lens, rim, unit: word })
    })
}

/// Radius at an angle.
fn radius([f1, f3, f5, f7]: &[f64; 4], angle: f64) -> f64 {
    let square = angle * angle;
    angle * (f1 + square * (f3 + square * (f5 + square * f7)))
}

/// Reads the dome.
pub(super) fn dome(reader: &Reader, extension: Node) -> Result<Dome> {
    let number = |name: &str, allowed: RangeInclusive<f64>| {
        let word = reader.text(extension, name).ok_or_else(|| reader.wrong(extension, format!("has no {name}")))?;
        let number = word.parse::<f64>().ok().filter(|number| allowed.contains(number));
        let range = format!("{} to {}", allowed.start(), allowed.end());
        number.ok_or_else(|| reader.wrong(extension, format!("{name} = {} is no number from {range}", shown(word))))
    };
    Ok(Dome {
        radius: number("radius", 1e-6..=1e6)?,
        tilt: number("tilt", -180.0..=180.0)?.to_radians(),
        coverage: number("coverage", 1e-3..=360.0)?.to_radians(),
    })
}

/// Text of the dome's extension, in metres and degrees.
fn dome_text(dome: &Dome) -> String {
    let Dome { radius, tilt, coverage } = dome;
    // Without rounding errors in the last digits.
    let degrees = |angle: &f64| (angle.to_degrees() * 1e9).round() / 1e9;
    format!(
        "    <extension Name=\"{DOME}\" hasExternalFiles=\"false\">\n      <radius>{radius}</radius><tilt>{}</tilt>\
         <coverage>{}</coverage>\n    </extension>\n",
        degrees(tilt),
        degrees(coverage)
    )
}

/// Text of the extensions for a dome, and for regions of these names, sizes and projectors; empty
/// if there is no dome and none has a fisheye.
///
/// # Errors
/// [`ErrorKind::InvalidRig`] for a fisheye that is neither equidistant nor a polynomial.
pub(super) fn text<'a>(
    dome: Option<&Dome>,
    regions: impl Iterator<Item = (String, (u32, u32), Option<&'a Optics>)>,
) -> Result<String> {
    let mut text = String::new();
    for (number, (id, size, optics)) in regions.enumerate() {
        let Some(Optics { lens: Lens::Fisheye { lens, circle }, .. }) = optics else { continue };
        let factors = match lens.projection {
            Projection::Equidistant => [1.0, 0.0, 0.0, 0.0],
            Projection::Polynomial(factors) => factors,
            _ => {
                let why = "MPCDI has no words for its lens; expected an equidistant fisheye, or a polynomial";
                return Err(Error::new(ErrorKind::InvalidRig, format!("region {id}: {why}")));
            }
        };
        let aspect = f64::from(size.0) / f64::from(size.1);
        let center = circle.to_picture(DVec2::ZERO, aspect);
        let half = circle.to_picture(DVec2::ONE, aspect) - center;
        let scale = half.x / radius(&factors, 0.5 * lens.aperture);
        let [f1, f3, f5, f7] = factors.map(|factor| factor * scale);
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "      <buffer id=\"buffer-{number}\"><region id=\"{id}\"><fisheye><horizontalOffset>{}</horizontalOffset>\
             <verticalOffset>{}</verticalOffset><f1>{f1}</f1><f3>{f3}</f3><f5>{f5}</f5><f7>{f7}</f7><aperture>{}</aperture></fisheye>\
             <anamorphic><ratio>{}</ratio><angle>0</angle></anamorphic></region></buffer>",
            -center.x,
            -center.y,
            lens.aperture.to_degrees(),
            half.x * aspect / half.y
        );
    }
    if !text.is_empty() {
        text = format!("    <extension Name=\"{NAME}\" hasExternalFiles=\"false\">\n{text}    </extension>\n");
    }
    text.push_str(&dome.map_or(String::new(), dome_text));
    Ok(if text.is_empty() { text } else { format!("  <extensionSet>\n{text}  </extensionSet>\n") })
}
