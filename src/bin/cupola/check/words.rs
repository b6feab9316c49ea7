//! Descriptions of screens, lenses and abrupt changes of the light.

use super::numbers::{degrees, number};
use cupola::blend::Crossing;
use cupola::geom::screen::{Screen, Shape};
use cupola::geom::{FisheyeLens, Panorama, Projection};
use cupola::rig::{Calibration, CalibrationValues, OwnWindow, Rig};

/// Description of the shape and size of a screen.
pub fn screen(screen: &Screen) -> String {
    let around = |azimuth: Option<[f64; 2]>| match azimuth {
        Some([from, to]) => format!(", from {} to {} around its axis", degrees(from), degrees(to)),
        None => String::new(),
    };
    match &screen.shape {
        Shape::Ellipsoid(ellipsoid) => {
            let [x, y, z] = ellipsoid.radii.to_array();
            let shape = match x == y && y == z {
                true => format!("sphere of radius {} m", number(x)),
                false => format!("ellipsoid of radii {}, {} and {} m", number(x), number(y), number(z)),
            };
            format!("{shape}, {} of it{}", degrees(2.0 * ellipsoid.region.polar), around(ellipsoid.region.azimuth))
        }
        Shape::Cone(cone) => {
            let [bottom, top] = cone.radii;
            let shape = match bottom == top {
                true => format!("cylinder of radius {} m", number(bottom)),
                false => format!("cone of radius {} m below and {} m above", number(bottom), number(top)),
            };
            let [from, to] = cone.heights;
            format!("{shape}, from {} to {} m along its axis{}", number(from), number(to), around(cone.azimuth))
        }
        Shape::Plane(plane) => format!("plane of {} × {} m", number(plane.size.x), number(plane.size.y)),
        Shape::Mesh(mesh) => format!("{} triangles", mesh.triangles().len()),
    }
}

/// Description of a calibration: its file and the meaning of its values.
pub fn calibration(calibration: &Calibration) -> String {
    let values = match calibration.values {
        CalibrationValues::Domemaster { aperture, .. } => {
            format!("places in a domemaster of {}", degrees(aperture))
        }
        CalibrationValues::Perspective { .. } => "places in a flat picture".to_owned(),
        CalibrationValues::Points => "points of the screen".to_owned(),
        CalibrationValues::Directions => "directions".to_owned(),
    };
    format!("as {} says: {values}", calibration.file.display())
}

/// Name of the projection of a fisheye.
pub fn projection(lens: &FisheyeLens) -> &'static str {
    match lens.projection {
        Projection::Equidistant => "equidistant",
        Projection::Equisolid => "equisolid",
        Projection::Stereographic => "stereographic",
        Projection::Orthographic => "orthographic",
        Projection::Polynomial(_) => "a polynomial",
        Projection::Measured(_) => "measured",
    }
}

/// The `kind` in a rig file of an output that shows a panorama.
pub fn kind(panorama: &Panorama) -> &'static str {
    match panorama {
        Panorama::Fisheye(_) => "domemaster",
        Panorama::Equirectangular(_) => "equirectangular",
        Panorama::Cylindrical(_) => "cylindrical",
        Panorama::CubeStrip => "cubemap",
    }
}

/// Description of a panorama.
pub fn panorama(panorama: &Panorama) -> String {
    let kind = kind(panorama);
    match panorama {
        Panorama::Fisheye(lens) => format!("{kind} of {}, {}", degrees(lens.aperture), projection(lens)),
        Panorama::Equirectangular(span) | Panorama::Cylindrical(span) => {
            let (bottom, top) = (degrees(span.bottom), degrees(span.top));
            format!("{kind} picture, {} across and {bottom} to {top} upwards", degrees(span.width))
        }
        Panorama::CubeStrip => "six faces of a cube, side by side".to_owned(),
    }
}

/// Place of an output that has a window of its own.
pub fn own_window(own: &OwnWindow) -> String {
    let on = own.display.as_ref().map_or(String::new(), |display| format!(" on {display}"));
    match &own.monitor {
        Some(monitor) => format!("in a window of its own{on}, monitor {monitor}"),
        None if own.fullscreen => format!("in a window of its own{on}, the whole screen"),
        None => format!("in a window of its own{on}"),
    }
}

/// Description of a place where the light of two outputs must change abruptly.
pub fn jump(rig: &Rig, crossing: &Crossing) -> String {
    let [first, second] = crossing.outputs.map(|index| rig.outputs[index].name.as_str());
    let (polar, azimuth) = (degrees(crossing.polar), degrees(crossing.azimuth));
    format!(
        "the light of {first} and {second} meets abruptly {polar} from the pole, {azimuth} around it: their borders \
         cross there, and no third output covers the place"
    )
}
