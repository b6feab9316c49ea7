//! The opening of a pinhole: `fov` and `shift`, `angles`, or the program's own `lens`.

use crate::geom::Frustum;
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
