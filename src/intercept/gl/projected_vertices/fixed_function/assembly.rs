//! Assembly of lines and triangles from vertices of Begin/End or of arrays (OpenGL 2.1, section
//! 2.6.1).

use crate::backend::gl::driver::api;

/// A triangle of a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Numbers of its vertices. Their order determines the front side.
    pub corners: [usize; 3],
    /// Vertex whose colour the triangle has if colours are flat.
    pub provoking: usize,
    /// True for each corner if the edge that begins there is an edge of the primitive.
    pub own_edges: [bool; 3],
}

impl Triangle {
    /// Returns a triangle whose last vertex is the provoking one.
    fn new(a: usize, b: usize, c: usize) -> Self {
        Self { corners: [a, b, c], provoking: c, own_edges: [true; 3] }
    }

    /// Returns the two triangles of a quadrilateral, divided as gallium's drivers do.
    fn quadrilateral([a, b, c, d]: [usize; 4]) -> [Self; 2] {
        [
            Self { corners: [a, b, d], provoking: d, own_edges: [true, false, true] },
            Self { corners: [b, c, d], provoking: d, own_edges: [true, true, false] },
        ]
    }
}

/// True if primitives of `mode` are triangles, or are divided into triangles.
pub fn fills(mode: u32) -> bool {
    matches!(mode, api::GL_TRIANGLES..=api::GL_POLYGON)
}

/// Calls `each` for the triangles of `count` vertices. Incomplete triangles are left out.
pub fn triangles(mode: u32, count: usize, mut each: impl FnMut(Triangle)) {
    match mode {
        api::GL_TRIANGLES => (0..count / 3).for_each(|i| each(Triangle::new(3 * i, 3 * i + 1, 3 * i + 2))),
        api::GL_TRIANGLE_STRIP => (0..count.saturating_sub(2)).for_each(|i| {
            let odd = i & 1;
            each(Triangle::new(i + odd, i + 1 - odd, i + 2));
        }),
        api::GL_TRIANGLE_FAN => (1..count.saturating_sub(1)).for_each(|i| each(Triangle::new(0, i, i + 1))),
        api::GL_QUADS => (0..count / 4)
            .flat_map(|i| Triangle::quadrilateral([4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3]))
            .for_each(each),
        api::GL_QUAD_STRIP => (0..(count / 2).saturating_sub(1))
            .flat_map(|i| Triangle::quadrilateral([2 * i + 2, 2 * i, 2 * i + 1, 2 * i + 3]))
            .for_each(each),
        api::GL_POLYGON => {
            let last = count.saturating_sub(2);
            (1..=last).for_each(|i| {
                let own_edges = [i == 1, true, i == last];
                each(Triangle { corners: [0, i, i + 1], provoking: 0, own_edges });
            });
        }
        _ => {}
    }
}

/// Calls `each` for the two ends of each line of `count` vertices. The second end is the provoking
/// vertex.
pub fn lines(mode: u32, count: usize, mut each: impl FnMut([usize; 2])) {
    match mode {
        api::GL_LINES => (0..count / 2).for_each(|i| each([2 * i, 2 * i + 1])),
        api::GL_LINE_STRIP | api::GL_LINE_LOOP => {
            (1..count).for_each(|i| each([i - 1, i]));
            if mode == api::GL_LINE_LOOP && count > 1 {
                each([count - 1, 0]);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners(mode: u32, count: usize) -> Vec<[usize; 3]> {
        let mut all = Vec::new();
        triangles(mode, count, |triangle| all.push(triangle.corners));
        all
    }

    #[test]
    fn strips_turn_every_other_triangle() {
        assert_eq!(corners(api::GL_TRIANGLE_STRIP, 5), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
        assert_eq!(corners(api::GL_TRIANGLE_FAN, 4), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(corners(api::GL_TRIANGLES, 8), [[0, 1, 2], [3, 4, 5]]);
    }

    /// Seen from the front, the corners of a quadrilateral and of its triangles run
    /// counterclockwise.
    #[test]
    fn quadrilaterals_keep_their_side_and_their_provoking_vertex() {
        // The vertices of a strip alternate between its two sides.
        let places = [[0.0, 0.0], [0.0, -1.0], [1.0, 0.0], [1.0, -1.0], [2.0, 0.0], [2.0, -1.0]];
        let area = |corners: [usize; 3]| {
            let [a, b, c] = corners.map(|corner: usize| places[corner]);
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        let mut count = 0;
        triangles(api::GL_QUAD_STRIP, 6, |triangle| {
            assert!(area(triangle.corners) > 0.0, "{triangle:?}");
            assert_eq!(triangle.provoking, 3 + count / 2 * 2);
            count += 1;
        });
        assert_eq!(count, 4);
        assert_eq!(corners(api::GL_QUADS, 7), [[0, 1, 3], [1, 2, 3]]);
    }

    #[test]
    fn only_own_edges_are_drawn_as_outlines() {
        for (mode, count) in [(api::GL_QUADS, 4), (api::GL_POLYGON, 7), (api::GL_TRIANGLES, 3)] {
            let mut edges = Vec::new();
            triangles(mode, count, |triangle| {
                edges.extend((0..3).filter(|i| triangle.own_edges[*i]).map(|i| triangle.corners[i]));
            });
            edges.sort_unstable();
            assert_eq!(edges, (0..count).collect::<Vec<_>>(), "each edge once");
        }
    }

    #[test]
    fn loops_close() {
        let mut all = Vec::new();
        lines(api::GL_LINE_LOOP, 3, |ends| all.push(ends));
        assert_eq!(all, [[0, 1], [1, 2], [2, 0]]);
        all.clear();
        lines(api::GL_LINES, 5, |ends| all.push(ends));
        assert_eq!(all, [[0, 1], [2, 3]]);
    }
}
