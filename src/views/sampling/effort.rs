//! Limit of the work and the memory for one plan.

use crate::rig::Rig;

/// Greatest number of places at which the outputs of one plan are sampled, about 800 MB. There are
/// fewer where each ray is tested with many triangles, so that all take at most about two minutes of
/// one processor.
pub(crate) const MOST_PLACES: u64 = 1 << 23;
/// Number of triangles whose tests take as long as the rest of a sample.
const TRIANGLES: f64 = 64.0;

/// Number of places that a plan may still sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    left: u64,
    /// Effort of each place.
    each: u64,
}

impl Effort {
    /// Effort for a new plan of a rig.
    pub fn of_plan(rig: &Rig) -> Self {
        Self { left: MOST_PLACES, each: 1 + (rig.surface().tested() / TRIANGLES) as u64 }
    }

    /// Effort of up to `places`.
    #[cfg(test)]
    pub fn of(places: u64) -> Self {
        Self { left: places, each: 1 }
    }

    /// Greatest number of places.
    pub fn most(&self) -> u64 {
        MOST_PLACES / self.each
    }

    /// Number of places that are left.
    #[cfg(test)]
    pub fn left(&self) -> u64 {
        self.left
    }

    /// Takes `places` from what is left. Returns false if there were too few.
    pub fn take(&mut self, places: u64) -> bool {
        let effort = places.saturating_mul(self.each);
        let enough = effort < self.left;
        self.left = self.left.saturating_sub(effort);
        enough
    }

    /// True if nothing is left.
    pub fn is_spent(&self) -> bool {
        self.left == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::screen::{Faces, Mesh, Shape};
    use crate::geom::{Pose, Screen};
    use glam::DVec3;
    use std::sync::Arc;

    #[test]
    fn a_ray_through_many_triangles_leaves_fewer_places() {
        let mut rig = crate::rig::load("fisheye").expect("a preset");
        assert_eq!(Effort::of_plan(&rig).most(), MOST_PLACES);
        let triangle = |index: u32| {
            let corner = |x, y| DVec3::new(x, y, -3.0 - 1e-3 * f64::from(index));
            [corner(-4.0, -4.0), corner(4.0, -4.0), corner(0.0, 5.0)]
        };
        let mesh = Mesh::new((0..400).map(triangle).collect(), Faces::Both).expect("a surface");
        let pose = Pose::new(DVec3::ZERO, 0.0, 0.0, 0.0);
        rig.screen = Some(Screen { pose, shape: Shape::Mesh(Arc::new(mesh)) });
        let most = Effort::of_plan(&rig).most();
        assert!(most < MOST_PLACES / 5 && most > MOST_PLACES / 10, "{most}");
    }
}
