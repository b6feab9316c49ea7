//! Keys of projectors in a rig file.

use crate::failure::Failure;
use cupola::geom::{Frustum, Lens, Optics, Projection, pose};
use glam::{DMat3, DVec2};

/// Keys for position, orientation and lens of a projector without a mirror. `aspect` is the width
/// of its picture divided by the height.
///
/// # Errors
/// Fails for lenses that no calibration file describes.
pub fn keys(optics: &Optics, aspect: f64) -> Result<String, Failure> {
    let [x, y, z] = optics.pose.position.to_array().map(tidy);
    let aim = angles(&optics.pose.rotation);
    let lens = match &optics.lens {
        Lens::Pinhole { frustum, distortion, keystone } if distortion.is_none() && *keystone == DMat3::IDENTITY => {
            opening(frustum)
        }
        Lens::Fisheye { lens, circle } => {
            let center = circle.to_picture(DVec2::ZERO, aspect);
            let half = circle.to_picture(DVec2::ONE, aspect) - center;
            let projection = match &lens.projection {
                Projection::Equidistant => "\"equidistant\"".to_owned(),
                Projection::Polynomial(factors) => format!("\"polynomial\", coefficients = {factors:?}"),
                _ => return Err(unknown()),
            };
            format!(
                "fisheye = {{ projection = {projection}, aperture = {:?}, size = {:?}, center = {:?} }}\n",
                tidy(lens.aperture.to_degrees()),
                half.to_array(),
                (0.5 * center).to_array()
            )
        }
        Lens::Pinhole { .. } => return Err(unknown()),
    };
    Ok(format!("position = [{x:?}, {y:?}, {z:?}]\n{aim}{lens}"))
}

fn unknown() -> Failure {
    Failure::new("the calibration has a lens that cannot be written to a rig")
}

/// Keys for an orientation.
pub fn angles(rotation: &DMat3) -> String {
    let [yaw, pitch, roll] = pose::angles(rotation).map(|angle| tidy(angle.to_degrees()));
    format!("yaw = {yaw:?}\npitch = {pitch:?}\nroll = {roll:?}\n")
}

/// Keys for the opening of a flat picture.
pub fn opening(frustum: &Frustum) -> String {
    let Frustum { left, right, bottom, top } = *frustum;
    let [left, right, bottom, top] = [left, right, bottom, top].map(|side| tidy(side.atan().to_degrees()));
    format!("angles = {{ left = {left:?}, right = {right:?}, bottom = {bottom:?}, top = {top:?} }}\n")
}

/// Rounded to nine decimal places, without rounding errors in the last digits.
pub fn tidy(number: f64) -> f64 {
    (number * 1e9).round() / 1e9 + 0.0
}
