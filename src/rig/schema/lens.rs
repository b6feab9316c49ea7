//! Lenses: the opening of a pinhole (`fov` and `shift`, `angles`, or the program's own `lens`), its
//! `distortion`, and `fisheye`.

use super::OPENING;
use crate::geom::lens::{Distortion, FisheyeLens, Projection};
use crate::geom::{Frustum, Lens};
use crate::rig::problems::Problems;
use crate::rig::reader::{Allowed, Section};

/// Widest opening of a pinhole in degrees; at 180° its picture would be infinitely large.
const WIDEST_PINHOLE: f64 = 179.0;

const FIELD_OF_VIEW: Allowed = Allowed::closed(
    0.01,
    WIDEST_PINHOLE,
    "[horizontal, vertical] opening in degrees (a pinhole stays below 180; kind = \"domemaster\" shows more)",
);
const SIDE: Allowed = Allowed::closed(
    -WIDEST_PINHOLE / 2.0,
    WIDEST_PINHOLE / 2.0,
    "an angle in degrees from the lens axis, negative to the left and below",
);
const SHIFT: Allowed =
    Allowed::closed(-2.0, 2.0, "[right, up] as parts of the picture's width and height (0.5 = half a picture)");

/// The opening of a perspective output; `Some(None)` = the program's own.
pub(super) fn perspective_frustum(section: &mut Section, problems: &mut Problems) -> Option<Option<Frustum>> {
    if !section.has("lens") {
        return frustum(section, problems).map(Some);
    }
    section.choice("lens", &[("program", ())], problems)?;
    let own: Vec<&str> = ["fov", "angles", "shift"].into_iter().filter(|key| section.has(key)).collect();
    if own.is_empty() {
        return Some(None);
    }
    let why = format!("the program's lens has its own opening; leave out either `lens` or {}", own.join(", "));
    problems.add(&section.path("lens"), why);
    frustum(section, problems).map(Some)
}

/// The opening of a pinhole, from `fov` and `shift` or from `angles`.
pub(super) fn frustum(section: &mut Section, problems: &mut Problems) -> Option<Frustum> {
    let fov = section.numbers::<2>("fov", &FIELD_OF_VIEW, problems);
    let shift = section.numbers::<2>("shift", &SHIFT, problems);
    let angles = section.section("angles", problems);
    let path = section.path("fov");
    match (section.has("fov"), angles) {
        (false, None) if section.has("angles") => None,
        (false, None) => {
            problems.add(
                &path,
                "is missing; expected fov = [horizontal, vertical] in degrees, or angles = { left, right, bottom, top }",
            );
            None
        }
        (true, Some(_)) => {
            problems.add(&section.path("angles"), "say the opening a second time, after `fov`; leave out one of them");
            None
        }
        (true, None) => {
            let ([horizontal, vertical], [right, up]) = (fov?, shift.unwrap_or([0.0; 2]));
            let half = |degrees: f64| (degrees.to_radians() / 2.0).tan();
            let (width, height) = (2.0 * half(horizontal), 2.0 * half(vertical));
            Some(Frustum {
                left: (right - 0.5) * width,
                right: (right + 0.5) * width,
                bottom: (up - 0.5) * height,
                top: (up + 0.5) * height,
            })
        }
        (false, Some(angles)) => {
            if section.has("shift") {
                problems.add(&section.path("shift"), "goes with `fov`; `angles` say the shift themselves");
            }
            sides(angles, problems)
        }
    }
}

/// The opening of a pinhole from the angles of its four sides.
fn sides(mut section: Section, problems: &mut Problems) -> Option<Frustum> {
    let [left, right, bottom, top] =
        ["left", "right", "bottom", "top"].map(|key| section.required_number(key, &SIDE, problems));
    let complete = ["left", "right", "bottom", "top"].iter().all(|key| section.has(key));
    let mut ordered = true;
    for (low, high, low_key, high_key) in [(left, right, "left", "right"), (bottom, top, "bottom", "top")] {
        if complete && high - low < 0.01 {
            problems.add(
                &section.path(high_key),
                format!("{high} is not above {low_key} = {low}; {low_key} is negative where it lies on its own side of the lens axis"),
            );
            ordered = false;
        }
    }
    section.finish(&[], problems);
    let tangent = |degrees: f64| degrees.to_radians().tan();
    let frustum = Frustum { left: tangent(left), right: tangent(right), bottom: tangent(bottom), top: tangent(top) };
    (complete && ordered).then_some(frustum)
}

/// The lens of a projector.
pub(super) fn projector_lens(section: &mut Section, problems: &mut Problems) -> Option<Lens> {
    let fisheye_section = section.section("fisheye", problems);
    let distortion_section = section.section("distortion", problems);
    let Some(fisheye_section) = fisheye_section else {
        let distortion = distortion_section.map_or(Distortion::default(), |section| distortion(section, problems));
        return frustum(section, problems).map(|frustum| Lens::Pinhole { frustum, distortion });
    };
    // Asked for, so that they are not called unknown as well.
    section.numbers::<2>("fov", &FIELD_OF_VIEW, problems);
    section.numbers::<2>("shift", &SHIFT, problems);
    section.section("angles", problems);
    for key in ["fov", "angles", "shift", "distortion"] {
        if section.has(key) {
            problems.add(&section.path(key), "belongs to a pinhole; leave it out, or `fisheye`");
        }
    }
    fisheye(fisheye_section, problems).map(Lens::Fisheye)
}

fn distortion(mut section: Section, problems: &mut Problems) -> Distortion {
    let allowed = Allowed::closed(-100.0, 100.0, "coefficients of Brown and Conrady over tangents");
    let radial = section.numbers::<3>("radial", &allowed, problems).unwrap_or_default();
    let tangential = section.numbers::<2>("tangential", &allowed, problems).unwrap_or_default();
    section.finish(&[], problems);
    Distortion { radial, tangential }
}

fn fisheye(mut section: Section, problems: &mut Problems) -> Option<FisheyeLens> {
    let projections = [
        ("equidistant", Projection::Equidistant),
        ("equisolid", Projection::Equisolid),
        ("stereographic", Projection::Stereographic),
        ("orthographic", Projection::Orthographic),
        ("polynomial", Projection::Polynomial([0.0; 4])),
    ];
    let given = section.has("projection");
    let chosen = section.choice("projection", &projections, problems);
    let mut projection = if given { chosen? } else { Projection::Equidistant };
    let allowed = Allowed::closed(-1e6, 1e6, "[f1, f3, f5, f7], factors of the angle's powers in radians");
    let coefficients = section.numbers::<4>("coefficients", &allowed, problems);
    match (&mut projection, coefficients) {
        (Projection::Polynomial(own), Some(coefficients)) => *own = coefficients,
        (Projection::Polynomial(_), None) => {
            problems
                .add(&section.path("coefficients"), "is missing; expected [f1, f3, f5, f7] of the angle in radians");
        }
        (_, Some(_)) => problems.add(&section.path("coefficients"), "goes with projection = \"polynomial\""),
        (_, None) => {}
    }
    let aperture = section.number("aperture", &OPENING, 180.0, problems).to_radians();
    let lens = FisheyeLens { projection, aperture };
    let widest = projection.widest();
    if aperture > widest {
        let why = format!("is more than this projection can show; expected at most {}", widest.to_degrees().round());
        problems.add(&section.path("aperture"), why);
    } else if coefficients.is_some() && !lens.is_monotone() {
        let why = "the radius does not grow over the whole aperture; expected coefficients of a curve that rises";
        problems.add(&section.path("coefficients"), why);
    }
    section.finish(&[], problems);
    Some(lens)
}
