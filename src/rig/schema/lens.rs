//! Lenses: the opening of a pinhole (`fov` and `shift`, `angles`, or the program's own `lens`), its
//! `distortion` and `keystone`, and fisheyes.

use super::OPENING;
use crate::geom::lenses::lens::Distortion;
use crate::geom::{Circle, Curve, FisheyeLens, Frustum, Lens, Projection, homography};
use crate::rig::reading::allowed::Allowed;
use crate::rig::reading::problems::Problems;
use crate::rig::reading::reader::Section;
use glam::{DMat3, DVec2};
use std::sync::Arc;

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
const ANGLES: &str = "{ left = …, right = …, bottom = …, top = … } in degrees, in place of `fov`";
const SHIFT: Allowed =
    Allowed::closed(-2.0, 2.0, "[right, up] as parts of the picture's width and height (0.5 = half a picture)");

/// Reads the opening of a perspective output; `Some(None)` = the program's own.
pub(super) fn perspective_frustum(section: &mut Section, problems: &mut Problems) -> Option<Option<Frustum>> {
    let own = section.choice("lens", &[("program", ())], problems);
    if !section.has("lens") {
        return frustum(section, problems).map(Some);
    }
    own?;
    let own: Vec<&str> = ["fov", "angles", "shift"].into_iter().filter(|key| section.has(key)).collect();
    if own.is_empty() {
        return Some(None);
    }
    let why = format!("the program's lens has its own opening; leave out either `lens` or {}", own.join(", "));
    problems.add(&section.path("lens"), why);
    frustum(section, problems).map(Some)
}

/// Reads the opening of a pinhole, from `fov` and `shift` or from `angles`.
pub(super) fn frustum(section: &mut Section, problems: &mut Problems) -> Option<Frustum> {
    let fov = section.numbers::<2>("fov", &FIELD_OF_VIEW, problems);
    let [right, up] = section.numbers_or("shift", &SHIFT, [0.0; 2], problems);
    section.note_value("angles", &[], ANGLES, problems);
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
            problems.add(&section.path("angles"), "set the opening a second time, after `fov`; leave out one of them");
            None
        }
        (true, None) => {
            let [horizontal, vertical] = fov?;
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
                problems.add(&section.path("shift"), "needs `fov`; `angles` already contain the shift");
            }
            sides(angles, problems)
        }
    }
}

/// Reads the opening of a pinhole from the angles of its four sides.
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

/// Reads the lens of a projector.
pub(super) fn projector_lens(section: &mut Section, problems: &mut Problems) -> Option<Lens> {
    let fisheye_section = section.section("fisheye", problems);
    let distortion_section = section.section("distortion", problems);
    let Some(fisheye_section) = fisheye_section else {
        let distortion = distortion_section.map_or(Distortion::default(), |section| distortion(section, problems));
        let keystone = keystone(section, problems);
        return frustum(section, problems).map(|frustum| Lens::Pinhole { frustum, distortion, keystone });
    };
    // Reads the key, so that it is not reported as unknown as well.
    section.numbers::<2>("fov", &FIELD_OF_VIEW, problems);
    section.note_value("angles", &[], ANGLES, problems);
    section.section("angles", problems);
    section.know("shift", problems);
    section.know("keystone", problems);
    for key in ["fov", "angles", "shift", "distortion", "keystone"] {
        if section.has(key) {
            problems.add(&section.path(key), "belongs to a pinhole; leave it out, or `fisheye`");
        }
    }
    let mut section = fisheye_section;
    let lens = fisheye(&mut section, 180.0, problems);
    let circle = circle(&mut section, problems);
    section.finish(&[], problems);
    lens.map(|lens| Lens::Fisheye { lens, circle })
}

/// Returns the place of the circle of a projector's fisheye.
fn circle(section: &mut Section, problems: &mut Problems) -> Circle {
    let is_centered = !section.has("center");
    let center = section.checked_numbers("center", &SHIFT, [0.0; 2], problems);
    let allowed = Allowed::closed(0.01, 100.0, "[width, height] of the circle as parts of the picture's");
    let size = section.numbers::<2>("size", &allowed, problems);
    match (center, size) {
        (center, Some(size)) => Circle::Placed {
            center: 2.0 * DVec2::from_array(center.unwrap_or_default()),
            half: DVec2::from_array(size),
        },
        (Some(_), None) if !is_centered => {
            problems.add(&section.path("center"), "needs `size`, too: [width, height] as parts of the picture's");
            Circle::Inscribed
        }
        (_, None) => Circle::Inscribed,
    }
}

/// Distortion by the projector itself, from the positions of the four corners.
fn keystone(section: &mut Section, problems: &mut Problems) -> DMat3 {
    let allowed = Allowed::closed(
        -2.0,
        2.0,
        "a corner's x or y in the unbent picture, -1 to 1 from the left and from the bottom",
    );
    let Some(corners) = section.number_pairs("keystone", &allowed, problems) else { return DMat3::IDENTITY };
    let as_points: Option<[DVec2; 4]> = <[[f64; 2]; 4]>::try_from(corners).ok().map(|c| c.map(DVec2::from_array));
    as_points.and_then(homography::from_corners).unwrap_or_else(|| {
        let why =
            "is no convex quadrilateral; expected four corners [x, y]: bottom left, bottom right, top right, top left";
        problems.add(&section.path("keystone"), why);
        DMat3::IDENTITY
    })
}

fn distortion(mut section: Section, problems: &mut Problems) -> Distortion {
    let allowed = Allowed::closed(-100.0, 100.0, "coefficients of Brown and Conrady over tangents");
    let radial = section.numbers_or("radial", &allowed, [0.0; 3], problems);
    let tangential = section.numbers_or("tangential", &allowed, [0.0; 2], problems);
    section.finish(&[], problems);
    Distortion { radial, tangential }
}

/// Reads the lens of a fisheye. Its aperture is `aperture` degrees if the file has no other.
pub(super) fn fisheye(section: &mut Section, aperture: f64, problems: &mut Problems) -> Option<FisheyeLens> {
    let measured = Measured { curve: measured(section, problems), word: Some(("measured", usize::MAX)) };
    any_fisheye(section, aperture, measured, problems)
}

/// As [`fisheye`], for outputs that need a projection with a formula.
pub(super) fn formula_fisheye(section: &mut Section, aperture: f64, problems: &mut Problems) -> Option<FisheyeLens> {
    any_fisheye(section, aperture, Measured::default(), problems)
}

/// A measured projection, if one is possible.
#[derive(Default)]
struct Measured {
    curve: Option<Arc<Curve>>,
    word: Option<(&'static str, usize)>,
}

fn any_fisheye(
    section: &mut Section,
    aperture: f64,
    measured: Measured,
    problems: &mut Problems,
) -> Option<FisheyeLens> {
    let projections = [
        ("equidistant", Projection::Equidistant),
        ("equisolid", Projection::Equisolid),
        ("stereographic", Projection::Stereographic),
        ("orthographic", Projection::Orthographic),
        ("polynomial", Projection::Polynomial([0.0; 4])),
    ];
    let words: Vec<(&'static str, usize)> =
        projections.iter().enumerate().map(|(index, (word, _))| (*word, index)).chain(measured.word).collect();
    let equidistant = 0;
    let chosen = section.checked_choice("projection", &words, equidistant, problems)?;
    let mut projection = match projections.get(chosen) {
        Some((_, projection)) => projection.clone(),
        None => Projection::Measured(measured.curve?),
    };
    if section.has("measured") && !matches!(projection, Projection::Measured(_)) {
        problems.add(&section.path("measured"), "needs projection = \"measured\"");
    }
    let allowed = Allowed::closed(-1e6, 1e6, "[f1, f3, f5, f7], factors of the angle's powers in radians");
    let coefficients = section.numbers::<4>("coefficients", &allowed, problems);
    match (&mut projection, coefficients) {
        (Projection::Polynomial(own), Some(coefficients)) => *own = coefficients,
        (Projection::Polynomial(_), None) => {
            problems
                .add(&section.path("coefficients"), "is missing; expected [f1, f3, f5, f7] of the angle in radians");
        }
        (_, Some(_)) => problems.add(&section.path("coefficients"), "needs projection = \"polynomial\""),
        (_, None) => {}
    }
    let aperture = section.number("aperture", &OPENING, aperture, problems).to_radians();
    let widest = projection.widest();
    let lens = FisheyeLens { projection, aperture };
    if aperture > widest {
        let why = format!("is more than this projection can show; expected at most {}", widest.to_degrees().round());
        problems.add(&section.path("aperture"), why);
    } else if coefficients.is_some() && !lens.is_monotone() {
        let why = "the radius does not grow over the whole aperture; expected coefficients of a curve that rises";
        problems.add(&section.path("coefficients"), why);
    }
    Some(lens)
}

/// Reads a measured curve: angles in degrees, radii in any unit.
fn measured(section: &mut Section, problems: &mut Problems) -> Option<Arc<Curve>> {
    let path = section.path("measured");
    let allowed =
        Allowed::closed(0.0, 1e6, "an angle in degrees from the axis, or its radius in the picture in any unit");
    let Some(nodes) = section.number_pairs("measured", &allowed, problems) else {
        if section.is_text("projection", "measured") && !section.has("measured") {
            problems.add(&path, "is missing; expected [[angle, radius], …], angles in degrees from the axis");
        }
        return None;
    };
    let nodes: Vec<[f64; 2]> = nodes.into_iter().map(|[angle, radius]| [angle.to_radians(), radius]).collect();
    let curve = Curve::new(&nodes);
    if curve.is_none() {
        problems.add(
            &path,
            "does not rise; expected [[angle, radius], …], both growing from node to node, one node at least",
        );
    }
    curve.map(Arc::new)
}
