//! domeprojection.com's warp mesh: a text file with a line `x;y;u;v;column;row` for each node, in
//! any order.
//!
//! x and y are parts of the output's width and height from the top left, u and v parts of the input
//! picture, from the left and from the top. Lines that begin with a letter or a comment sign are
//! headings.

use super::grid::{Grid, MOST_NODES, Mesh, Node};
use crate::error::Result;
use crate::formats::reading::input::{Noted, invalid};
use crate::formats::reading::text::Lines;
use glam::{DVec2, DVec3};

/// Greatest number of a column or a row.
const LONGEST_SIDE: usize = 1 << 14;
/// Values of a line, for messages.
const NODE: &str = "a node: x;y;u;v;column;row";

/// Reads a warp mesh; values are (u, v, 0) with v from the bottom. `name` is the file's, for
/// messages.
///
/// Nodes that are missing in the grid are accepted with a note; cells beside them are not drawn.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) with the line and the reason.
pub fn read(name: &str, bytes: &[u8]) -> Result<Noted<Grid>> {
    let mut lines = Lines::new(name, bytes)?;
    let mut nodes = Vec::new();
    let (mut columns, mut rows) = (0, 0);
    while let Some(line) = lines.next() {
        if nodes.is_empty() && line.starts_with(|first: char| first.is_alphabetic() || "#/;\"'".contains(first)) {
            continue;
        }
        let words: Vec<&str> = line.split(';').map(str::trim).collect();
        // A semicolon may end the line too.
        let [x, y, u, v, column, row] = words.strip_suffix(&[""]).unwrap_or(&words)[..] else {
            return Err(lines.wrong(format!("has {} values; expected {NODE}", words.len())));
        };
        let column = lines.count(column, "the node's column", 0, LONGEST_SIDE)?;
        let row = lines.count(row, "the node's row", 0, LONGEST_SIDE)?;
        (columns, rows) = (columns.max(column + 1), rows.max(row + 1));
        let number = |word| lines.number(word, NODE);
        let position = DVec2::new(2.0 * number(x)? - 1.0, 1.0 - 2.0 * number(y)?);
        let value = DVec3::new(number(u)?, 1.0 - number(v)?, 0.0);
        nodes.push((column, row, Node { position, value, intensity: 1.0 }));
        if nodes.len() > MOST_NODES {
            return Err(lines.wrong(format!("is one node too many; expected at most {MOST_NODES}")));
        }
    }
    if columns < 2 || rows < 2 || columns * rows > MOST_NODES {
        return Err(invalid(
            name,
            format!(
                "has {columns} columns and {rows} rows; expected at least 2 of each and at most {MOST_NODES} nodes"
            ),
        ));
    }
    let mut grid = vec![None; columns * rows];
    for (column, row, node) in nodes {
        if grid[row * columns + column].replace(node).is_some() {
            return Err(invalid(name, format!("has the node of column {column} and row {row} twice")));
        }
    }
    let missing = grid.iter().filter(|node| node.is_none()).count();
    let notes =
        (missing > 0).then(|| format!("{name}: {missing} nodes are missing; the cells beside them are not drawn"));
    let mesh = Mesh::from_grid(name, columns, rows, &grid, false)?;
    Ok(Noted { value: Grid::Stretched(mesh), notes: notes.into_iter().collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOUR: &str = "0;0;0.1;0.2;0;0\n1;0;0.9;0.2;1;0\n1;1;0.9;0.6;1;1\n0;1;0.1;0.6;0;1\n";

    #[test]
    fn nodes_are_put_in_their_places_whatever_their_order() {
        for text in [FOUR.to_owned(), format!("\u{feff}# x;y;u;v;column;row\r\n{}", FOUR.replace('\n', ";\r\n"))] {
            let grid = read("a.csv", text.as_bytes()).unwrap().value;
            // Samples the top left quarter of an output of another aspect.
            let sample = grid.sample(DVec2::new(25.0, 5.0), (100, 20)).unwrap();
            assert!(sample.value.distance(DVec3::new(0.3, 0.7, 0.0)) < 1e-12, "{sample:?}");
            assert_eq!(sample.intensity, 1.0);
        }
    }

    #[test]
    fn a_missing_node_is_told() {
        let text = "0;0;0;0;0;0\n.5;0;.5;0;1;0\n1;0;1;0;2;0\n0;1;0;1;0;1\n.5;1;.5;1;1;1\n";
        let read = read("a.csv", text.as_bytes()).unwrap();
        assert!(read.notes[0].contains("1 nodes are missing"), "{:?}", read.notes);
        assert!(read.value.sample(DVec2::new(0.2, 0.5), (1, 1)).is_some());
        assert!(read.value.sample(DVec2::new(0.8, 0.5), (1, 1)).is_none());
    }

    #[test]
    fn damaged_files_are_refused_with_the_line() {
        for (text, why) in [
            ("", "a.csv: has 0 columns"),
            ("0;0;0;0;0\n", "a.csv:1: has 5 values"),
            ("0;0;0;nan;0;0\n", "a.csv:1: \"nan\""),
            ("0;0;0;0;0;0\nheading\n", "a.csv:2: has 1 values"),
            ("0;0;0;0;-1;0\n", "a.csv:1: \"-1\" does not fit"),
            ("0;0;0;0;16384;16384\n", "at most"),
            (&format!("{FOUR}{FOUR}"), "twice"),
        ] {
            let message = read("a.csv", text.as_bytes()).unwrap_err().message;
            assert!(message.contains(why), "{message}");
        }
    }
}
