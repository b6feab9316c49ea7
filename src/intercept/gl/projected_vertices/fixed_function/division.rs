//! Lines, triangles, quadrilaterals and polygons that are divided on the processor, for one view.
//!
//! The positions of the new vertices lie between the program's own positions. The program of Cupola
//! that replaces the pipeline's vertex stage projects and lights them like all other vertices.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::correct::single;
use crate::intercept::gl::projected_vertices::fixed_function::assembly::{self, Triangle};
use crate::intercept::gl::projected_vertices::fixed_function::substitute;
use crate::intercept::gl::projected_vertices::fixed_function::vertices::{Attribute, Vertices};
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::draw::DrawState;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::projected_vertices::ProjectedVertices;
use crate::intercept::scene::obstacle::Obstacle;
use crate::runtime::session::Division;
use glam::{DVec3, DVec4};

/// A draw for one view.
struct Divided<'a> {
    gl: &'a Gl,
    vertices: &'a Vertices,
    division: Division,
    /// Point at which the viewer sees each vertex, in lens axes.
    seen: Vec<DVec3>,
    /// True if a primitive has the colours, and with lighting the normal, of its provoking vertex.
    flat: bool,
    /// True if polygons are drawn as outlines.
    outlined: bool,
    coarse: u64,
}

/// Draws `vertices` for the view of `reprojection`. The current attribute values are undefined afterwards.
pub fn draw(
    driver: &Driver,
    draw: &DrawState,
    compat: &mut Compat,
    projected: &mut ProjectedVertices,
    vertices: &Vertices,
    division: Division,
    reprojection: &ReprojectionMatrix,
) {
    let clip = *compat.projection.matrix() * compat.projection.model_view(driver.gl);
    let seen = (0..vertices.count())
        .map(|number| {
            let position = vertices.vertex(number).first().map_or([0.0; 4], |position| position.map(f64::from));
            seen(reprojection, clip * DVec4::from(position))
        })
        .collect();
    let (flat, outlined) = (substitute::is_flat(projected), draw.may_outline());
    let mut divided = Divided { gl: driver.gl, vertices, division, seen, flat, outlined, coarse: 0 };
    if assembly::fills(vertices.mode) {
        divided.triangles();
    } else {
        divided.lines();
    }
    projected.count_coarse(divided.coarse);
}

/// Draws `vertices` without division. The current attribute values are undefined afterwards.
pub fn whole(gl: &Gl, vertices: &Result<Vertices, Obstacle>) {
    let Ok(vertices) = vertices else { return };
    // SAFETY: Begin and End of Cupola, around vertices with their attributes.
    unsafe {
        gl.begin(vertices.mode);
        for number in 0..vertices.count() {
            let Some((position, values)) = vertices.vertex(number).split_first() else { continue };
            vertices.attributes.iter().zip(values).for_each(|(attribute, value)| attribute.set(gl, value));
            gl.vertex4fv(position.as_ptr());
        }
        gl.end();
    }
}

/// Returns the point at which the viewer sees a vertex with these clip coordinates of the program:
/// in lens axes and the program's units.
fn seen(reprojection: &ReprojectionMatrix, DVec4 { x, y, z, w }: DVec4) -> DVec3 {
    let q = z + f64::from(reprojection.depth.pole) * w;
    let row = |row: [f32; 4]| {
        let [of_x, of_y, of_w, of_q] = row.map(f64::from);
        of_x * x + of_y * y + of_w * w + of_q * q
    };
    DVec3::new(row(reprojection.x), row(reprojection.y), -row(reprojection.w))
}

impl Divided<'_> {
    fn triangles(&mut self) {
        // SAFETY: Begin and End of Cupola, around vertices only.
        unsafe { self.gl.begin(api::GL_TRIANGLES) };
        assembly::triangles(self.vertices.mode, self.vertices.count(), |triangle| {
            let seen = triangle.corners.map(|corner| self.seen.get(corner).copied().unwrap_or_default());
            let outcome = self.division.triangle(seen, &mut |part| {
                for (corner, weights) in part.iter().enumerate() {
                    let outline = self.outlined.then(|| self.is_outline(&triangle, *weights, part[(corner + 1) % 3]));
                    self.emit(&triangle.corners, triangle.provoking, *weights, outline);
                }
            });
            self.coarse += outcome.coarse as u64;
        });
        // SAFETY: as above.
        unsafe { self.gl.end() };
    }

    fn lines(&mut self) {
        // SAFETY: as for triangles.
        unsafe { self.gl.begin(api::GL_LINES) };
        assembly::lines(self.vertices.mode, self.vertices.count(), |ends| {
            let seen = ends.map(|end| self.seen.get(end).copied().unwrap_or_default());
            let outcome = self.division.line(seen, &mut |part| {
                for second in part {
                    self.emit(&ends, ends[1], DVec3::new(1.0 - second, second, 0.0), None);
                }
            });
            self.coarse += outcome.coarse as u64;
        });
        // SAFETY: as for triangles.
        unsafe { self.gl.end() };
    }

    /// True if the edge between two points of a triangle is part of an outline of the program's
    /// primitive.
    fn is_outline(&self, triangle: &Triangle, from: DVec3, to: DVec3) -> bool {
        // Both points are on the edge opposite a corner if that corner's weight is 0 for both.
        let along = (0..3).find(|corner| from[(corner + 2) % 3] == 0.0 && to[(corner + 2) % 3] == 0.0);
        let flag = self.vertices.attributes.iter().position(|attribute| *attribute == Attribute::EdgeFlag);
        along.is_some_and(|edge| {
            let vertex = self.vertices.vertex(triangle.corners[edge]);
            let flagged = flag.and_then(|flag| vertex.get(1 + flag)).is_none_or(|value| value[0] != 0.0);
            triangle.own_edges[edge] && flagged
        })
    }

    /// Emits a vertex between the vertices with these numbers.
    fn emit(&self, corners: &[usize], provoking: usize, weights: DVec3, outline: Option<bool>) {
        let between = |value: usize| {
            // A sum of two terms is the same in any order. So two triangles get exactly the same
            // vertex on their common edge.
            let mut sum = [0.0f64; 4];
            for (number, weight) in corners.iter().zip(weights.to_array()) {
                let given = self.vertices.vertex(*number).get(value).copied().unwrap_or_default();
                (0..4).for_each(|i| sum[i] += weight * f64::from(given[i]));
            }
            single::values(sum)
        };
        // SAFETY: between Begin and End of Cupola.
        unsafe {
            for (number, attribute) in self.vertices.attributes.iter().enumerate() {
                let colours = matches!(attribute, Attribute::Color | Attribute::SecondaryColor | Attribute::Normal);
                match attribute {
                    Attribute::EdgeFlag => {}
                    _ if self.flat && colours => {
                        let value = self.vertices.vertex(provoking).get(1 + number).copied().unwrap_or_default();
                        attribute.set(self.gl, &value);
                    }
                    _ => attribute.set(self.gl, &between(1 + number)),
                }
            }
            if let Some(outline) = outline {
                self.gl.edge_flag(u8::from(outline));
            }
            self.gl.vertex4fv(between(0).as_ptr());
        }
    }
}
