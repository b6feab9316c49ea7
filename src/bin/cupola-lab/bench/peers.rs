//! Correction methods of other programs, rebuilt from their formulas. Error and cost are those of
//! the formula, not of the program around it.

use super::scenes::Scene;
use crate::failure::Failure;
use crate::trial::gl::Sampling;
use cupola::formats::{Mesh, Node};
use cupola::geom::cube::Face;
use cupola::geom::{Fisheye, pose};
use cupola::rig::OutputKind;
use cupola::warp::WarpMap;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_4, PI};

/// A mesh as another program draws it.
pub struct Peer {
    /// Name of the program and of the method.
    pub name: String,
    /// Positions are −1…1 over the output; the meaning of the values depends on `sampling`.
    pub mesh: Mesh,
    /// Colouring of fragments.
    pub sampling: Sampling,
    /// Number of texels of its views divided by the number of output pixels, where the program
    /// defines it.
    pub texels: Option<f64>,
}

/// A formula in the shader of another program.
pub struct Formula {
    /// Name of the program and of the method.
    pub name: String,
    /// Its shader. The coordinate is the position in the output, 0…1 from the bottom left.
    pub sampling: Sampling,
    /// Number of texels of its views divided by the number of output pixels.
    pub texels: Option<f64>,
}

/// The map of a domemaster of the scene's dome. Its size is 1 × 1, so that pixel positions are
/// fractions of the picture.
pub fn domemaster(scene: &Scene) -> Result<WarpMap, Failure> {
    let mut rig = scene.rig.clone();
    rig.outputs.truncate(1);
    rig.outputs[0].kind = OutputKind::Domemaster { aperture: rig.dome.coverage, tilt: rig.dome.tilt };
    rig.outputs[0].flip = cupola::rig::Flip::default();
    Ok(WarpMap::new(&rig, 0, (1, 1), None)?)
}

/// A mesh over a grid of `columns` × `rows` cells. `node` gets positions in the output, 0…1 from
/// the bottom left.
pub fn grid_mesh(columns: u32, rows: u32, node: impl Fn(DVec2) -> Option<Node>) -> Mesh {
    let part = |index: u32, count: u32| f64::from(index) / f64::from(count);
    let places = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (column, row)));
    let nodes: Vec<_> = places.map(|(x, y)| node(DVec2::new(part(x, columns), part(y, rows)))).collect();
    Mesh::from_grid("a grid", columns as usize + 1, rows as usize + 1, &nodes, false).unwrap_or_else(|_| empty())
}

/// A mesh without triangles.
fn empty() -> Mesh {
    Mesh::new("nothing", Vec::new(), Vec::new()).expect("a mesh without triangles is valid")
}

/// The meshes of other programs for a scene. `side` is the width in texels of a cube face as fine
/// as the output.
pub fn meshes(scene: &Scene, exact: &WarpMap, side: u32) -> Vec<Peer> {
    let pixels = f64::from(scene.size.0) * f64::from(scene.size.1);
    let mut peers = Vec::new();
    if scene.is_fisheye() {
        let open_scene_graph = grid_mesh(50, 50, |part| {
            // Outside of the circle the direction of the rim is used, so that cells at the rim are
            // wrong.
            let at = 2.0 * part - 1.0;
            let inside = at / at.length().max(1.0);
            let value = Fisheye { aperture: PI }.direction(inside.x, inside.y)?;
            Some(Node { position: at, value, intensity: 1.0 })
        });
        let texels = Some(6.0 * 512.0 * 512.0 / pixels);
        let name = "OpenSceneGraph: 50×50, faces of 512²".into();
        peers.push(Peer { name, mesh: open_scene_graph, sampling: Sampling::Cube(512), texels });
        for level in [4, 6] {
            let mesh = flattened_cube(level);
            let name = format!("Bourke and Felinto: cube of {} triangles, flattened", mesh.triangles().len());
            let texels = Some(4.0 * f64::from(side) * f64::from(side) / pixels);
            peers.push(Peer { name, mesh, sampling: Sampling::Cube(side), texels });
        }
    } else if let Ok(content) = domemaster(scene) {
        let picture = |at: DVec2| {
            let size = DVec2::new(f64::from(scene.size.0), f64::from(scene.size.1));
            let place = content.pixel(exact.hit(DVec2::new(at.x, 1.0 - at.y) * size)?)?;
            let value = DVec3::new(place.x, 1.0 - place.y, 0.0);
            Some(Node { position: 2.0 * at - 1.0, value, intensity: 1.0 })
        };
        let master = 2 * side;
        let bourke = grid_mesh(99, 59, picture);
        let (name, sampling) =
            ("Bourke's mesh: 100×60 nodes over a domemaster".into(), Sampling::Picture(master, master));
        peers.push(Peer { name, mesh: bourke, sampling: sampling.clone(), texels: None });
        for pitch in [8, 16] {
            let name = format!("Stellarium: lattice of {pitch} pixels over a domemaster");
            let mesh = lattice(scene.size, pitch, picture);
            peers.push(Peer { name, mesh, sampling: sampling.clone(), texels: None });
        }
    }
    peers
}

/// A lattice of triangles whose odd rows are shifted by half a step.
fn lattice(size: (u32, u32), pitch: u32, node: impl Fn(DVec2) -> Option<Node>) -> Mesh {
    let (columns, rows) = (size.0.div_ceil(pitch) + 1, size.1.div_ceil(pitch) + 1);
    let mut numbers = Vec::new();
    let mut nodes = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let shift = if row % 2 == 1 && column > 0 && column + 1 < columns { 0.5 } else { 0.0 };
            let at = |index: f64, extent: u32| (index * f64::from(pitch) / f64::from(extent)).min(1.0);
            let found = node(DVec2::new(at(f64::from(column) - shift, size.0), at(f64::from(row), size.1)));
            numbers.push(found.is_some().then_some(nodes.len() as u32));
            nodes.extend(found);
        }
    }
    let at = |column: u32, row: u32| numbers[(row * columns + column) as usize];
    let mut triangles = Vec::new();
    for (row, column) in (1..rows).flat_map(|row| (1..columns).map(move |column| (row, column))) {
        let [a, b, c, d] = [at(column - 1, row - 1), at(column, row - 1), at(column, row), at(column - 1, row)];
        let both = if row % 2 == 1 { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] };
        triangles.extend(both.into_iter().filter_map(|[a, b, c]| Some([a?, b?, c?])));
    }
    Mesh::new("a lattice", nodes, triangles).unwrap_or_else(|_| empty())
}

/// A cube turned by 45° whose triangles are split into four `level` times. It is inflated to a
/// sphere and flattened to the circle of a fisheye.
fn flattened_cube(level: u32) -> Mesh {
    let lens = Fisheye { aperture: PI };
    let turned = pose::rotation(FRAC_PI_4, 0.0, 0.0);
    let (mut nodes, mut triangles) = (Vec::new(), Vec::new());
    let cells = 1_u32 << level;
    for face in Face::ALL {
        let rotation: DMat3 = turned * face.rotation();
        let corner = |x: u32, y: u32| {
            let at = |index: u32| 2.0 * f64::from(index) / f64::from(cells) - 1.0;
            rotation * DVec3::new(at(x), at(y), -1.0)
        };
        for (x, y) in (0..cells).flat_map(|y| (0..cells).map(move |x| (x, y))) {
            let corners = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
            // A triangle is in the picture completely or not at all. A cell at the rim of the
            // picture is split along the diagonal that keeps one triangle.
            let ahead = |triangle: &[usize; 3]| triangle.iter().all(|&i| -corners[i].z >= -1e-9);
            let kept = [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]].map(|split| split.into_iter().filter(ahead));
            let [first, second] = kept.map(Iterator::collect::<Vec<_>>);
            for triangle in if first.len() >= second.len() { first } else { second } {
                let start = nodes.len() as u32;
                for value in triangle.map(|index: usize| corners[index]) {
                    nodes.push(Node { position: lens.point(value), value, intensity: 1.0 });
                }
                triangles.push([start, start + 1, start + 2]);
            }
        }
    }
    Mesh::new("a cube", nodes, triangles).unwrap_or_else(|_| empty())
}

/// The formulas of other programs for a scene. `side` is as for [`meshes`].
pub fn formulas(scene: &Scene, side: u32) -> Vec<Formula> {
    let pixels = f64::from(scene.size.0) * f64::from(scene.size.1);
    match &scene.rig.outputs[0].kind {
        OutputKind::Domemaster { aperture, .. } => {
            let half = 0.5 * aperture;
            let body = format!(
                "vec2 p = 2.0 * at.xy - 1.0; float r = length(p); float a = {half:.9} * r;\n\
                 return vec3(sin(a) * p / max(r, 1e-9), -cos(a));"
            );
            vec![Formula {
                name: "SGCT: sine and cosine, four whole faces".into(),
                sampling: Sampling::Formula(body, Box::new(Sampling::Cube(side))),
                texels: Some(4.0 * f64::from(side) * f64::from(side) / pixels),
            }]
        }
        OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } => {
            // From the axes of the lens to those of the dome, whose pole is straight ahead. The
            // radius is 1.
            let rays = pose::rotation(*yaw, *pitch, *roll);
            let row = |index: usize| {
                let row = rays.row(index);
                format!("{:.9} * x + {:.9} * y - {:.9}", row.x, row.y, row.z)
            };
            let DVec3 { x, y, z } = *position / scene.rig.dome.radius;
            let body = format!(
                "float x = mix({:.9}, {:.9}, at.x), y = mix({:.9}, {:.9}, at.y);\n\
                 vec3 d = normalize(vec3({}, {}, {})), o = vec3({x:.9}, {y:.9}, {z:.9});\n\
                 float b = dot(o, d); vec3 v = o + d * (sqrt(b * b - dot(o, o) + 1.0) - b);\n\
                 float r = length(v), theta = acos(-v.z / r), phi = acos(v.x / (r * sin(theta)));\n\
                 if (v.y < 0.0) phi = -phi;\n\
                 return vec3(0.5 + theta / {:.9} * vec2(cos(phi), sin(phi)), 0.0);",
                frustum.left,
                frustum.right,
                frustum.bottom,
                frustum.top,
                row(0),
                row(1),
                row(2),
                scene.rig.dome.coverage
            );
            vec![Formula {
                name: "recipe of 2014: two arc cosines, over a domemaster".into(),
                sampling: Sampling::Formula(body, Box::new(Sampling::Picture(2 * side, 2 * side))),
                texels: None,
            }]
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flattened_cube_covers_the_circle_and_becomes_exact() {
        let error = |level: u32| {
            let mesh = flattened_cube(level);
            let lens = Fisheye { aperture: PI };
            let mut worst = 0.0f64;
            for i in 0..1000 {
                let at = DVec2::from_angle(f64::from(i)) * 0.9 * (f64::from(i) / 1000.0).sqrt();
                let found = mesh.sample(at).expect("covered").value.normalize();
                worst = worst.max(found.distance(lens.direction(at.x, at.y).expect("inside")));
            }
            worst
        };
        let (coarse, fine) = (error(3), error(5));
        assert!((12.0..20.0).contains(&(coarse / fine)), "{coarse} {fine}");
    }

    #[test]
    fn a_lattice_has_no_holes() {
        let node = |part: DVec2| Some(Node { position: 2.0 * part - 1.0, value: part.extend(0.0), intensity: 1.0 });
        let mesh = lattice((100, 70), 16, node);
        for (x, y) in (0..100).flat_map(|x| (0..70).map(move |y| (x, y))) {
            let part = DVec2::new((f64::from(x) + 0.5) / 100.0, (f64::from(y) + 0.5) / 70.0);
            let found = mesh.sample(2.0 * part - 1.0).unwrap_or_else(|| panic!("a hole at {x}, {y}"));
            assert!(found.value.truncate().distance(part) < 1e-9);
        }
    }
}
