//! Surface on which a rig's light falls, and the point from which it is viewed.

use crate::geom::screen::{Ellipsoid, Region, Screen, Shape};
use crate::geom::{Pose, pose};
use crate::rig::{Dome, Output, Rig};
use glam::DVec3;

impl Dome {
    /// The dome as a screen: a cap of a sphere around the origin, whose pole leans to the front by
    /// the tilt.
    pub fn screen(&self) -> Screen {
        let region = Region { polar: 0.5 * self.coverage, azimuth: None };
        let pose = Pose { position: DVec3::ZERO, rotation: pose::rotation(0.0, -self.tilt, 0.0) };
        Screen { pose, shape: Shape::Ellipsoid(Ellipsoid { radii: DVec3::splat(self.radius), region }) }
    }
}

impl Rig {
    /// Returns the surface on which the light falls.
    pub fn surface(&self) -> Screen {
        self.screen.clone().unwrap_or_else(|| self.dome.screen())
    }

    /// Returns the position and the axes of the viewer.
    pub fn viewer_pose(&self) -> Pose {
        let viewer = &self.viewer;
        Pose::new(viewer.position, viewer.yaw, viewer.pitch, viewer.roll)
    }

    /// Returns the position and the axes of the eye of an output.
    pub fn eye(&self, output: &Output) -> Pose {
        let viewer = self.viewer_pose();
        Pose { position: viewer.point_to_parent(DVec3::X * output.eye), ..viewer }
    }
}
