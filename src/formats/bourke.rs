//! Paul Bourke's warp mesh: a text file with the mesh's type, its columns and rows, and a line `x y
//! u v i` for each node, row by row from the bottom.
//! x and y are half heights of the output from its middle, u and v parts of the input picture from
//! the bottom left, i is a factor on the displayed value. A negative i, or u or v outside 0…1,
//! removes the node and the cells around it. Type 2 is a grid; in type 1, polar, the last column is
//! followed by the first.

use super::grid::{Mesh, Node};
use crate::error::Result;
use crate::formats::reading::input::Noted;
use crate::formats::reading::text::Lines;
use glam::{DVec2, DVec3};
use std::fmt::Write;

/// Greatest distance of u or v outside 0…1 that counts as rounding.
const ROUNDING: f64 = 1e-6;
/// Greatest number of columns and of rows.
const LONGEST_SIDE: usize = 1 << 14;

/// Arrangement of a mesh's columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrangement {
    /// Type 1: columns go around, and the last is followed by the first.
    Polar,
    /// Type 2: columns go across.
    Rectangular,
}

/// A warp mesh as it is in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct WarpMesh {
    /// Type of the mesh.
    pub arrangement: Arrangement,
    /// Number of nodes in a row, at least 2.
    pub columns: usize,
    /// Number of rows, at least 2.
    pub rows: usize,
    /// Values `[x, y, u, v, i]` of each node, row by row.
    pub nodes: Vec<[f64; 5]>,
}

impl WarpMesh {
    /// Makes the mesh that is drawn; values are (u, v, 0). `name` is the file's, for messages.
    ///
    /// # Errors
    /// Errors of [`Mesh::new`].
    pub fn mesh(&self, name: &str) -> Result<Mesh> {
        let used = |value: f64| (-ROUNDING..=1.0 + ROUNDING).contains(&value);
        let node = |[x, y, u, v, i]: &[f64; 5]| {
            (*i >= 0.0 && used(*u) && used(*v)).then(|| Node {
                position: DVec2::new(*x, *y),
                value: DVec3::new(u.clamp(0.0, 1.0), v.clamp(0.0, 1.0), 0.0),
                intensity: i.min(1.0),
            })
        };
        let nodes: Vec<Option<Node>> = self.nodes.iter().map(node).collect();
        Mesh::from_grid(name, self.columns, self.rows, &nodes, self.arrangement == Arrangement::Polar)
    }
}

/// Reads a warp mesh; words are separated by blanks or tabs. `name` is the file's, for messages.
///
/// Lines without i (it is 1 then) and i above 1 (drawn as 1) are accepted with a note.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) with the line and the reason.
pub fn read(name: &str, bytes: &[u8]) -> Result<Noted<WarpMesh>> {
    let mut lines = Lines::new(name, bytes)?;
    let first = lines.expect("the mesh's type, 1 (polar) or 2 (rectangular)")?;
    let arrangement = match first {
        "1" => Arrangement::Polar,
        "2" => Arrangement::Rectangular,
        _ => {
            return Err(lines.wrong(format!(
                "{} is no type of mesh; expected 1 (polar) or 2 (rectangular)",
                crate::formats::reading::text::shown(first)
            )));
        }
    };
    let size: Vec<&str> = lines.expect("columns and rows of the mesh")?.split_whitespace().collect();
    let [columns, rows] = size[..] else {
        return Err(lines.wrong(format!("has {} words; expected columns and rows of the mesh", size.len())));
    };
    let columns = lines.count(columns, "the mesh's columns", 2, LONGEST_SIDE)?;
    let rows = lines.count(rows, "the mesh's rows", 2, LONGEST_SIDE)?;
    // Allocates as nodes are found, not as many as the header promises.
    let mut nodes = Vec::new();
    let (mut without_intensity, mut too_bright) = (0, 0);
    while nodes.len() < columns * rows {
        let line = lines.expect(&format!("{columns} × {rows} nodes, not {}", nodes.len()))?;
        let mut numbers = [0.0, 0.0, 0.0, 0.0, 1.0];
        let mut words = 0;
        for word in line.split_whitespace() {
            match numbers.get_mut(words) {
                Some(number) => *number = lines.number(word, "a node: x y u v intensity")?,
                None => return Err(lines.wrong("has more than five numbers; expected a node: x y u v intensity")),
            }
            words += 1;
        }
        match words {
            5 => too_bright += usize::from(numbers[4] > 1.0),
            4 => without_intensity += 1,
            _ => return Err(lines.wrong(format!("has {words} numbers; expected a node: x y u v intensity"))),
        }
        nodes.push(numbers);
    }
    if lines.next().is_some() {
        return Err(lines.wrong(format!("stands after the last of {columns} × {rows} nodes")));
    }
    let mut notes = Vec::new();
    if without_intensity > 0 {
        notes.push(format!("{name}: {without_intensity} nodes have no intensity; they were given 1"));
    }
    if too_bright > 0 {
        notes.push(format!("{name}: {too_bright} nodes have an intensity above 1; they are drawn with 1"));
    }
    Ok(Noted { value: WarpMesh { arrangement, columns, rows, nodes }, notes })
}

/// Formats a warp mesh. The numbers are exact to nine decimals, the intensity to six.
pub fn write(mesh: &WarpMesh) -> String {
    let kind = if mesh.arrangement == Arrangement::Polar { 1 } else { 2 };
    let mut text = format!("{kind}\n{} {}\n", mesh.columns, mesh.rows);
    for [x, y, u, v, i] in &mesh.nodes {
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{x:.9} {y:.9} {u:.9} {v:.9} {i:.6}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(nodes: &str) -> String {
        format!("2\n2 2\n{nodes}")
    }

    #[test]
    fn tabs_blanks_and_windows_lines_are_read() {
        let text = "2\r\n2\t2\r\n-1.5\t-1\t0\t0\t1\r\n1.5 -1  1 0\t0.5\r\n\r\n-1.5 1 0 1 1\r\n1.5 1 0.9999 1e0 -1\r\n";
        let mesh = read("a.data", text.as_bytes()).unwrap();
        assert_eq!(mesh.notes, Vec::<String>::new());
        assert_eq!(mesh.value.nodes[1], [1.5, -1.0, 1.0, 0.0, 0.5]);
        assert_eq!(mesh.value.nodes[3], [1.5, 1.0, 0.9999, 1.0, -1.0]);
        assert!(mesh.value.mesh("a.data").unwrap().triangles().is_empty(), "its only cell has a hidden corner");
    }

    #[test]
    fn rows_begin_at_the_bottom_and_nodes_outside_the_picture_are_not_used() {
        let plain = read("a", text("-1 -1 0 0 1\n1 -1 1 0 1\n-1 1 0 1 1\n1 1 1 1.0000001 1\n").as_bytes()).unwrap();
        let sample = plain.value.mesh("a").unwrap().sample(DVec2::new(0.0, -0.5)).unwrap();
        assert!(sample.value.distance(DVec3::new(0.5, 0.25, 0.0)) < 1e-7, "{sample:?}");
        let outside = read("a", text("-1 -1 0 0 1\n1 -1 1 0 1\n-1 1 0 1 1\n1 1 1 1.01 1\n").as_bytes()).unwrap();
        assert_eq!(outside.value.mesh("a").unwrap().sample(DVec2::ZERO), None);
    }

    #[test]
    fn a_polar_mesh_is_closed() {
        let mut polar = WarpMesh { arrangement: Arrangement::Polar, columns: 8, rows: 3, nodes: Vec::new() };
        for row in 0..3 {
            for column in 0..8 {
                let at = DVec2::from_angle(f64::from(column) / 8.0 * std::f64::consts::TAU) * f64::from(row) / 2.0;
                polar.nodes.push([at.x, at.y, 0.5 + 0.5 * at.x, 0.5 + 0.5 * at.y, 1.0]);
            }
        }
        let between_last_and_first = DVec2::from_angle(-0.3) * 0.7;
        let sample = |mesh: &WarpMesh| mesh.mesh("a").unwrap().sample(between_last_and_first);
        let found = sample(&polar).unwrap().value;
        assert!(found.distance((0.5 + 0.5 * between_last_and_first).extend(0.0)) < 1e-12);
        polar.arrangement = Arrangement::Rectangular;
        assert_eq!(sample(&polar), None);
    }

    #[test]
    fn what_is_written_is_read_back() {
        let nodes = (0..12).map(|i| f64::from(i) / 7.0).map(|x| [x - 1.0, x, 0.1 * x, 0.5, 1.0 - x]).collect();
        let mesh = WarpMesh { arrangement: Arrangement::Polar, columns: 4, rows: 3, nodes };
        let back = read("a", write(&mesh).as_bytes()).unwrap().value;
        assert_eq!((back.arrangement, back.columns, back.rows), (mesh.arrangement, 4, 3));
        for (found, expected) in back.nodes.iter().flatten().zip(mesh.nodes.iter().flatten()) {
            assert!((found - expected).abs() <= 5e-7);
        }
    }

    #[track_caller]
    fn refused(text: &str, why: &str) {
        let message = read("a.data", text.as_bytes()).unwrap_err().message;
        assert!(message.starts_with("a.data") && message.contains(why), "{message}");
    }

    #[test]
    fn damaged_files_are_refused_with_the_line() {
        refused("", "ends after line 0; expected the mesh's type");
        refused("3\n", "a.data:1: \"3\" is no type");
        refused("2\n100\n", "a.data:2: has 1 words");
        refused("2\n1 2\n", "a.data:2: \"1\" does not fit");
        refused("2\n4000000000 2\n", "a.data:2");
        refused("2\n16384 16384\n0 0 0 0 1\n", "ends after line 3");
        refused(&text("0 0 0 0 1\n0 0 nan 0 1\n"), "a.data:4: \"nan\"");
        refused(&text("0 0 0\n"), "a.data:3: has 3 numbers");
        refused(&text("0 0 0 0 1 1\n"), "more than five");
        refused(&text(&"0 0 0 0 1\n".repeat(5)), "a.data:7: stands after");
    }
}
