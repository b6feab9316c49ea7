//! Screens of triangles, as OBJ files for rigs.

use crate::failure::Failure;
use cupola::rig::Rig;
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::PathBuf;

/// A folder with the meshes: `ball.obj` is a sphere of radius 1; `boards.obj` also has triangles
/// inside it, which hide parts of it. The folder is removed when this is dropped.
pub struct Folder(PathBuf);

impl Folder {
    /// Creates a folder and writes the meshes into it.
    pub fn new() -> Result<Self, Failure> {
        let folder = std::env::temp_dir().join(format!("cupola-lab-{}", std::process::id()));
        let failed = |error: std::io::Error| Failure::new(format!("{} cannot be written: {error}", folder.display()));
        std::fs::create_dir_all(&folder).map_err(failed)?;
        let this = Self(folder.clone());
        let ball = ball(24);
        std::fs::write(folder.join("boards.obj"), format!("{ball}{BOARDS}")).map_err(failed)?;
        std::fs::write(folder.join("ball.obj"), ball).map_err(failed)?;
        Ok(this)
    }

    /// The rig of a file with this text.
    pub fn rig(&self, text: &str) -> cupola::Result<Rig> {
        cupola::rig::parse(text, "lab.toml", &self.0)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder that cannot be removed does no harm.
        _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Three triangles, whose fronts are seen from the middle.
const BOARDS: &str = "v -0.2 -0.3 -0.6\nv 0.3 -0.2 -0.6\nv 0 0.3 -0.7\nf -3 -2 -1\n\
                      v 0.5 0.1 0.5\nv 0.4 0.15 0.6\nv 0.6 0.4 0.3\nf -1 -2 -3\n\
                      v -0.6 0.2 0.1\nv -0.5 0.25 0.5\nv -0.55 0.6 0.2\nf -1 -2 -3\n";

/// A sphere of radius 1 as an OBJ file with `rings` rings of faces, which are counter-clockwise
/// seen from inside.
fn ball(rings: u32) -> String {
    let mut text = String::from("v 0 1 0\n");
    let around = 2 * rings;
    // Writing to a String cannot fail.
    for ring in 1..rings {
        for step in 0..around {
            let (polar, azimuth) = (PI * f64::from(ring) / f64::from(rings), PI * f64::from(step) / f64::from(rings));
            let (x, y, z) = (polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin());
            _ = writeln!(text, "v {x:?} {y:?} {z:?}");
        }
    }
    text += "v 0 -1 0\n";
    let corner = |ring: u32, step: u32| match ring {
        0 => 1,
        _ if ring == rings => 2 + (rings - 1) * around,
        _ => 2 + (ring - 1) * around + step % around,
    };
    for ring in 0..rings {
        for step in 0..around {
            let [a, b] = [corner(ring, step), corner(ring, step + 1)];
            let [c, d] = [corner(ring + 1, step), corner(ring + 1, step + 1)];
            // Faces at the poles have no area. The reader skips them.
            _ = writeln!(text, "f {a} {c} {b}\nf {b} {c} {d}");
        }
    }
    text
}
