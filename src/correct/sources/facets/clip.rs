//! Flat polygons cut by planes.

use glam::DVec3;

/// The points with `normal·p ≥ offset`.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfSpace {
    pub normal: DVec3,
    pub offset: f64,
}

impl HalfSpace {
    /// Returns the side of the plane through `point` to which `normal` points.
    pub fn through(point: DVec3, normal: DVec3) -> Self {
        Self { normal, offset: normal.dot(point) }
    }

    /// Returns the other side.
    pub fn opposite(&self) -> Self {
        Self { normal: -self.normal, offset: -self.offset }
    }

    /// Returns the depth of a point inside, in lengths of the normal.
    pub fn depth(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// Returns the part of a convex polygon that is inside (Sutherland & Hodgman 1974); empty if
    /// there is none. Two polygons with a common side get exactly the same points on it.
    pub fn clip(&self, polygon: &[DVec3]) -> Vec<DVec3> {
        let mut inside = Vec::with_capacity(polygon.len() + 1);
        let after = polygon.iter().cycle().skip(1);
        for (&from, &to) in polygon.iter().zip(after) {
            let (depth, next) = (self.depth(from), self.depth(to));
            if depth >= 0.0 {
                inside.push(from);
            }
            if (depth < 0.0 && next > 0.0) || (depth > 0.0 && next < 0.0) {
                // Always from the inner to the outer point, whatever the polygon's direction.
                let ((a, inner), (b, outer)) =
                    if depth > 0.0 { ((from, depth), (to, next)) } else { ((to, next), (from, depth)) };
                inside.push(a + (b - a) * (inner / (inner - outer)));
            }
        }
        if inside.len() < 3 { Vec::new() } else { inside }
    }

    /// Returns the parts of a polygon on both sides that have an area.
    pub fn split(&self, polygon: Vec<DVec3>) -> Vec<Vec<DVec3>> {
        let depths = polygon.iter().map(|&point| self.depth(point));
        let (low, high) = depths.fold((0.0f64, 0.0f64), |(low, high), depth| (low.min(depth), high.max(depth)));
        if low == 0.0 || high == 0.0 {
            return vec![polygon];
        }
        // The same order of points for both, so that both get the same points.
        let ordered = |this: &Self| this.clip(&polygon);
        [ordered(self), ordered(&self.opposite())].into_iter().filter(|part| !part.is_empty()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;

    fn area(polygon: &[DVec3]) -> f64 {
        let fan = polygon.windows(2).skip(1);
        0.5 * fan.map(|pair| (pair[0] - polygon[0]).cross(pair[1] - polygon[0])).sum::<DVec3>().length()
    }

    #[test]
    fn the_parts_of_a_polygon_make_up_the_whole() {
        let mut random = Random::new(8);
        let mut both = 0;
        for _ in 0..2000 {
            let [a, b, c] = [0; 3].map(|_| random.direction());
            let plane = HalfSpace { normal: random.direction(), offset: 0.3 * (random.unit() - 0.5) };
            let parts = plane.split(vec![a, b, c]);
            both += usize::from(parts.len() == 2);
            let sum: f64 = parts.iter().map(|part| area(part)).sum();
            assert!((sum - area(&[a, b, c])).abs() < 1e-12, "{parts:?}");
            // Each part lies on one side.
            for part in &parts {
                let depths = part.iter().map(|&point| plane.depth(point));
                let (low, high) = depths.fold((0.0f64, 0.0f64), |(l, h), d| (l.min(d), h.max(d)));
                assert!(low > -1e-12 || high < 1e-12);
            }
        }
        assert!(both > 500, "{both}");
    }
}
