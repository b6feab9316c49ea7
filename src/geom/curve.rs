//! Measured curves.

/// Rising curve through the origin and measured nodes. It is a piecewise cubic with a continuous
/// first derivative, and it rises everywhere (Fritsch and Carlson, *Monotone piecewise cubic
/// interpolation*, 1980). The slope at an inner node is the harmonic mean of the slopes of the two
/// chords beside it, which is within the bound of that paper.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Curve {
    /// Abscissa, ordinate and slope of each node. The first node is the origin.
    nodes: Vec<[f64; 3]>,
}

impl Curve {
    /// Returns the curve through (0, 0) and `points`, which may begin with (0, 0). Returns `None`
    /// if there is no other point, or unless both numbers of each point are finite and greater than
    /// those of the point before.
    pub fn new(points: &[[f64; 2]]) -> Option<Self> {
        let given = points.strip_prefix(&[[0.0, 0.0]]).unwrap_or(points);
        let mut nodes = vec![[0.0; 3]];
        for &[x, y] in given {
            let [before_x, before_y, _] = nodes[nodes.len() - 1];
            if !(x > before_x && y > before_y && x.is_finite() && y.is_finite()) {
                return None;
            }
            nodes.push([x, y, 0.0]);
        }
        let chords: Vec<f64> =
            nodes.windows(2).map(|pair| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])).collect();
        let (first, last) = (*chords.first()?, *chords.last()?);
        for (index, node) in nodes.iter_mut().enumerate() {
            let before = index.checked_sub(1).and_then(|index| chords.get(index));
            // A lens is symmetric about its axis: at the origin the curve is straight.
            node[2] = match (before, chords.get(index)) {
                (Some(a), Some(b)) => 2.0 * a * b / (a + b),
                (None, _) => first,
                (_, None) => last,
            };
        }
        Some(Self { nodes })
    }

    /// Returns the abscissa of the last node.
    pub fn end(&self) -> f64 {
        self.nodes.last().map_or(0.0, |node| node[0])
    }

    /// Returns value and slope at `x`. Beyond the last node the curve continues as a straight line.
    pub fn at(&self, x: f64) -> (f64, f64) {
        let next = self.nodes.partition_point(|node| node[0] < x);
        let Some(&[x1, y1, slope1]) = self.nodes.get(next) else {
            let [end, value, slope] = self.nodes[self.nodes.len() - 1];
            return (value + slope * (x - end), slope);
        };
        let Some(&[x0, y0, slope0]) = next.checked_sub(1).map(|before| &self.nodes[before]) else {
            return (y1 + slope1 * (x - x1), slope1);
        };
        let (width, t) = (x1 - x0, (x - x0) / (x1 - x0));
        let chord = (y1 - y0) / width;
        // Hermite cubic in powers of t.
        let (b, c) = (3.0 * chord - 2.0 * slope0 - slope1, slope0 + slope1 - 2.0 * chord);
        (y0 + width * t * (slope0 + t * (b + t * c)), slope0 + t * (2.0 * b + t * 3.0 * c))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goes_through_its_nodes_and_rises() {
        let points = [[0.2, 0.21], [0.5, 0.5], [0.9, 0.85], [1.2, 0.86], [1.5, 1.0]];
        let curve = Curve::new(&points).expect("rising");
        let mut before = (0.0, -1.0);
        for [x, y] in points {
            assert!((curve.at(x).0 - y).abs() < 1e-15);
        }
        for step in 0..=2_000 {
            let x = f64::from(step) / 1_000.0;
            let (y, slope) = curve.at(x);
            assert!(y > before.1 && slope > 0.0, "{x}");
            let difference = (curve.at(x + 1e-6).0 - curve.at(x - 1e-6).0) / 2e-6;
            assert!((difference - slope).abs() < 1e-4, "{x}: {difference} {slope}");
            before = (x, y);
        }
        assert_eq!(curve.end(), 1.5);
    }

    #[test]
    fn a_straight_line_stays_straight_and_what_falls_is_refused() {
        let line = Curve::new(&[[0.0, 0.0], [0.5, 1.0], [2.0, 4.0]]).expect("rising");
        assert!((line.at(1.3).0 - 2.6).abs() < 1e-15 && (line.at(3.0).0 - 6.0).abs() < 1e-15);
        for bad in [&[][..], &[[0.0, 0.0]], &[[1.0, 1.0], [2.0, 1.0]], &[[1.0, 1.0], [1.0, 2.0]], &[[f64::NAN, 1.0]]] {
            assert_eq!(Curve::new(bad), None, "{bad:?}");
        }
    }
}
