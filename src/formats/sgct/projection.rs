//! Contents of viewports: flat pictures, fisheyes, mirrors, pictures of all directions.

use super::key::Key;
use crate::error::Result;
use crate::geom::{Frustum, pose};
use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4};

/// Greatest angle of a side of a viewport's opening, degrees.
const WIDEST: f64 = 89.5;

/// Content of a viewport.
#[derive(Clone, Debug, PartialEq)]
pub enum Projection {
    /// A flat picture seen from the eye point.
    Planar {
        /// Rotation from its axes to those of the configuration.
        rotation: DMat3,
        /// Opening of the picture.
        frustum: Frustum,
    },
    /// An equidistant fisheye picture around the eye point.
    Fisheye {
        /// Angle from rim to rim, radians.
        aperture: f64,
        /// Angle from straight up to the circle's centre, towards the front, radians.
        tilt: f64,
    },
    /// A picture for a spherical mirror: four faces of a cube, each through a warp mesh of its own.
    Mirror {
        /// Angle by which the cube is turned up less than 45°, radians.
        tilt: f64,
        /// Files of the meshes in the order in which they are drawn, later ones over earlier ones.
        meshes: [String; 4],
    },
    /// A picture of all directions around the eye point, with longitude and latitude in equal
    /// steps.
    Equirectangular {
        /// Angle by which its middle lies to the right, radians.
        yaw: f64,
    },
    /// A picture of all directions around the eye point, as on the wall of a cylinder.
    Cylindrical {
        /// Angle by which its middle lies to the right, radians.
        yaw: f64,
        /// Heights of its lower and its upper edge, in radii of the cylinder.
        heights: [f64; 2],
    },
    /// Another kind, with SGCT's name.
    Other(String),
}

/// Angle by which SGCT turns the cube, from which it takes pictures of all directions, around the
/// vertical axis. The formula of its fisheye turns the picture back; those of the equirectangular
/// and of the cylindrical picture do not.
const TURN: f64 = FRAC_PI_4;

/// Least height of a cylinder's lower edge. Below it, SGCT shows the cube's lower face in places,
/// which it does not draw.
const LOWEST: f64 = -FRAC_1_SQRT_2;
/// Greatest height of a cylinder's lower edge: a rig's latitudes end at 89°.
const HIGHEST: f64 = 50.0;

/// Keys of a mirror's meshes in the order in which they are drawn. The face called bottom is the
/// one straight ahead, which a tilt of 0 turns up by 45°.
const MIRROR_MESHES: [&str; 4] = ["bottom", "left", "right", "top"];

/// Rotations from the axes of each of these faces to those of the configuration; a face is seen
/// along −z, 90° wide and high.
pub fn mirror_faces(tilt: f64) -> [DMat3; 4] {
    let up = DMat3::from_rotation_x(FRAC_PI_4 - tilt);
    let faces = [
        DMat3::IDENTITY,
        DMat3::from_rotation_y(FRAC_PI_2),
        DMat3::from_rotation_y(-FRAC_PI_2),
        DMat3::from_rotation_x(FRAC_PI_2),
    ];
    faces.map(|face| up * face)
}

pub(super) fn projection(key: &Key, viewer: DVec3, notes: &mut Vec<String>) -> Result<Projection> {
    let kind = key.required("type")?.text()?;
    Ok(match kind.as_str() {
        "PlanarProjection" => {
            let frustum = frustum(&key.required("fov")?, notes)?;
            let rotation = key.optional("orientation").map_or(Ok(DMat3::IDENTITY), |key| orientation(&key))?;
            if key.optional("offset").map_or(Ok(DVec3::ZERO), |key| key.vector())? == DVec3::ZERO {
                Projection::Planar { rotation, frustum }
            } else {
                // The plane is moved and the eye is not, which changes the opening.
                let distance = key.optional("distance").map_or(Ok(10.0), |key| key.number(1e-6, 1e6))?;
                let offset = key.required("offset")?.vector()?;
                let corner = |x: f64, y: f64| rotation * (DVec3::new(x, y, -1.0) * distance) + offset;
                let (low, high) = ((frustum.left, frustum.bottom), (frustum.right, frustum.top));
                plane(key, [corner(low.0, low.1), corner(low.0, high.1), corner(high.0, high.1)])?
            }
        }
        "ProjectionPlane" => {
            let corner = |name| key.required(name).and_then(|key| key.vector()).map(|corner: DVec3| corner - viewer);
            plane(key, [corner("lowerleft")?, corner("upperleft")?, corner("upperright")?])?
        }
        "FisheyeProjection" => Projection::Fisheye {
            aperture: key.optional("fov").map_or(Ok(180.0), |key| key.number(1e-3, 360.0))?.to_radians(),
            tilt: key.optional("tilt").map_or(Ok(0.0), |key| key.number(-180.0, 180.0))?.to_radians(),
        },
        "SphericalMirrorProjection" => {
            let meshes = key.required("mesh")?;
            let file = |name| meshes.required(name).and_then(|file| file.text());
            let [ahead, left, right, top] = MIRROR_MESHES.map(file);
            Projection::Mirror {
                tilt: key.optional("tilt").map_or(Ok(0.0), |key| key.number(-180.0, 180.0))?.to_radians(),
                meshes: [ahead?, left?, right?, top?],
            }
        }
        "EquirectangularProjection" => Projection::Equirectangular { yaw: TURN },
        "CylindricalProjection" => {
            let rotation = key.optional("rotation").map_or(Ok(0.0), |key| key.number(-360.0, 360.0))?.to_radians();
            let low = key.optional("heightoffset").map_or(Ok(0.0), |key| key.number(-1e6, 1e6))?;
            match (LOWEST..=HIGHEST).contains(&low) {
                true => Projection::Cylindrical { yaw: -TURN - rotation, heights: [low, low + 1.0] },
                false => Projection::Other(format!("{kind} with heightoffset {low}, which is not from -0.7 to 50,")),
            }
        }
        _ => Projection::Other(kind),
    })
}

/// Flat picture in a rectangle, given by its lower left, upper left and upper right corner as seen
/// from the eye.
fn plane(key: &Key, [low, upper, right]: [DVec3; 3]) -> Result<Projection> {
    let flat = || key.wrong("its plane has no area or goes through the eye point");
    let x = (right - upper).try_normalize().ok_or_else(flat)?;
    let y = (upper - low).try_normalize().ok_or_else(flat)?;
    let z = x.cross(y).try_normalize().ok_or_else(flat)?;
    if x.dot(y).abs() > 1e-4 {
        return Err(key.wrong("its plane is no rectangle"));
    }
    let rotation = DMat3::from_cols(x, z.cross(x), z);
    let distance = -low.dot(z);
    if distance.is_nan() || distance <= 0.0 {
        return Err(flat());
    }
    let picture = |point: DVec3| rotation.transpose() * point / distance;
    let (low, high) = (picture(low), picture(right));
    let frustum = Frustum { left: low.x, right: high.x, bottom: low.y, top: high.y };
    Ok(Projection::Planar { rotation, frustum })
}

/// Reads an opening: whole angles, or the angles of the four sides. Each side's angle counts away
/// from the middle: `left` and `right` together are the field of view.
fn frustum(key: &Key, notes: &mut Vec<String>) -> Result<Frustum> {
    let angle = |name| key.required(name)?.number(-WIDEST, WIDEST);
    let whole = |name| Ok(0.5 * key.required(name)?.number(1e-3, 2.0 * WIDEST)?);
    let [left, right, bottom, top] = if key.optional("hfov").is_some() {
        let (across, up) = (whole("hfov")?, whole("vfov")?);
        [-across, across, -up, up]
    } else {
        for (name, other) in [("left", "right of"), ("down", "above")] {
            let degrees = angle(name)?;
            if degrees < 0.0 {
                notes.push(format!(
                    "{}: {}.{name}: {degrees} is taken as SGCT takes it: this side lies {}° {other} the middle. If it \
                     should lie on its own side, remove the sign",
                    key.name, key.path, -degrees
                ));
            }
        }
        [-angle("left")?, angle("right")?, -angle("down")?, angle("up")?]
    };
    if !(left < right && bottom < top) {
        return Err(key.wrong(
            "left and right, or down and up, add up to no angle above 0; each counts away from the middle, so that \
             a picture around the middle has four positive angles",
        ));
    }
    let tangent = |degrees: f64| degrees.to_radians().tan();
    Ok(Frustum { left: tangent(left), right: tangent(right), bottom: tangent(bottom), top: tangent(top) })
}

/// Reads a rotation: three angles in degrees, or a quaternion.
fn orientation(key: &Key) -> Result<DMat3> {
    if key.optional("w").is_some() {
        let part = |name| key.required(name)?.number(-1e6, 1e6);
        let quaternion = DQuat::from_xyzw(part("x")?, part("y")?, part("z")?, part("w")?);
        if quaternion.length() < 1e-6 {
            return Err(key.wrong("is no turn: the quaternion's length is 0"));
        }
        return Ok(DMat3::from_quat(quaternion.normalize()));
    }
    let angle = |name| Ok::<_, crate::Error>(key.required(name)?.number(-360.0, 360.0)?.to_radians());
    Ok(pose::rotation(angle("yaw")?, angle("pitch")?, angle("roll")?))
}
