//! Wavefront OBJ: the corners and faces of a model. Everything else in the format (normals,
//! textures, materials, groups, curves) is ignored.

use crate::error::Result;
use crate::formats::reading::input::invalid;
use crate::formats::reading::text::{Lines, shown};
use glam::DVec3;

/// Reads the triangles of the OBJ file `bytes` called `name`, in the file's unit, corners in the
/// file's order. Faces with more than three corners are divided into fans from their first corner.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) with file and line if a corner or a face cannot be
/// used, or if there are no faces or more than `most` triangles.
pub fn read(name: &str, bytes: &[u8], most: usize) -> Result<Vec<[DVec3; 3]>> {
    let mut lines = Lines::new(name, bytes)?;
    let mut corners: Vec<DVec3> = Vec::new();
    let mut triangles = Vec::new();
    while let Some(line) = lines.next() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut axis = |axis| match words.next() {
                    Some(word) => lines.number(word, axis),
                    None => Err(lines.wrong(format!("a corner has no {axis}; expected `v x y z`"))),
                };
                corners.push(DVec3::new(axis("an x")?, axis("a y")?, axis("a z")?));
                if corners.len() > 3 * most {
                    return Err(
                        lines.wrong(format!("there are more than {} corners; expected a coarser model", 3 * most))
                    );
                }
            }
            Some("f") => {
                let face = words.map(|word| corner(&lines, word, &corners)).collect::<Result<Vec<_>>>()?;
                if face.len() < 3 {
                    return Err(lines.wrong(format!("a face has {} corners; expected 3 or more", face.len())));
                }
                triangles.extend(face[1..].windows(2).map(|pair| [face[0], pair[0], pair[1]]));
                if triangles.len() > most {
                    return Err(lines.wrong(format!("there are more than {most} triangles; expected a coarser model")));
                }
            }
            _ => {}
        }
    }
    if triangles.is_empty() {
        return Err(invalid(name, "has no faces; expected a Wavefront OBJ file with `v` and `f` lines"));
    }
    Ok(triangles)
}

/// Corner for a word of a face: `7`, `7/2`, `7/2/5`, `7//5`; negative numbers count back from the
/// last corner.
fn corner(lines: &Lines, word: &str, corners: &[DVec3]) -> Result<DVec3> {
    let number: Option<i64> = word.split('/').next().and_then(|number| number.parse().ok());
    let index = number.and_then(|number| match number {
        1.. => usize::try_from(number - 1).ok(),
        0 => None,
        _ => usize::try_from(number.checked_add(corners.len() as i64)?).ok(),
    });
    index.and_then(|index| corners.get(index).copied()).ok_or_else(|| {
        lines.wrong(format!("{} is no corner; expected 1 to {}, the corners so far", shown(word), corners.len()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_faces_of_every_notation() {
        let text = "# a wall\nmtllib x.mtl\no wall\nv 0 0 0\nv 1 0 0 1.0\nv 1.0 1e0 0\nvn 0 0 1\nv 0 1 0\n\nf 1/1 2//1 3/1/1 4\nf -4 -2 -1\n";
        let [x, y] = [DVec3::X, DVec3::Y];
        let both = [[DVec3::ZERO, x, x + y], [DVec3::ZERO, x + y, y]];
        assert_eq!(read("wall.obj", text.as_bytes(), 9).expect("good"), [both[0], both[1], both[1]]);
    }

    #[test]
    fn says_what_is_wrong_and_where() {
        let refused = |text: &str, words: &[&str]| {
            let message = read("a.obj", text.as_bytes(), 2).expect_err(text).to_string();
            assert!(words.iter().all(|word| message.contains(word)), "{message}");
        };
        refused("v 0 0 0\nv 1 x 0\n", &["a.obj:2", "\"x\""]);
        refused("v 0 0 nan\n", &["a.obj:1"]);
        refused("v 0 0\n", &["a.obj:1", "z"]);
        refused("v 0 0 0\nf 1 1 2\n", &["a.obj:2", "\"2\""]);
        refused("v 0 0 0\nf 1 1 0\n", &["a.obj:2"]);
        refused("v 0 0 0\nf 1 1 -9223372036854775808\n", &["a.obj:2"]);
        refused("v 0 0 0\nf 1 1\n", &["2 corners"]);
        refused("v 0 0 0\n", &["no faces"]);
        refused("v 0 0 0\nf 1 1 1 1 1\n", &["more than 2 triangles"]);
    }
}
