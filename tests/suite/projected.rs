//! What the tests of the methods share that project vertices straight to an output: a camera, a
//! domemaster, the projectors of a planetarium.

use crate::compare::{Report, compare, expect_alike, expect_good, far};
use crate::dialects::{camera_of, shown_by_fisheye, shown_by_projector};
use crate::picture::Picture;
use crate::programs::{Finished, Run, scratch};
use crate::reference::Fisheye;
use crate::rigs::{self, ProjectorRig};
use std::path::PathBuf;

/// The preset `fisheye` in these tests' windows.
pub const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

/// Of two methods' pictures that are weighed: what edges of the cube may be beyond what is around,
/// in 255ths. Both are rounded.
const WEIGHED: u8 = 2;

/// What the Vulkan programs clear their window to.
pub const GREY: [u8; 3] = [64; 3];

/// A camera that shows all kinds of corners and edges, and cells around the antipode.
pub fn run<'a>(program: &'a str, extra: &'a [&'a str], cupola: &'a [&'a str]) -> Run<'a> {
    Run { fov: 90.0, yaw: 33.0, pitch: -17.0, extra, cupola, ..Run::new(program) }
}

/// The cube of the Vulkan programs.
pub fn vk_cube<'a>(extra: &'a [&'a str], cupola: &'a [&'a str]) -> Run<'a> {
    run("vk_cube", extra, cupola)
}

/// An OpenGL program under a rig.
pub fn on_opengl(run: &Run, rig: &str) -> Option<Finished> {
    Some(run.under(rig)?.expect_success().expect_no_gl_errors())
}

/// A Vulkan program under a rig.
pub fn on_vulkan(run: &Run, rig: &str) -> Option<Finished> {
    run.vulkan_under(rig)
}

/// A Vulkan program in the preset `fisheye`.
pub fn vulkan_fisheye(run: &Run) -> Option<Finished> {
    on_vulkan(run, "fisheye")
}

/// How far a picture of the preset `fisheye` is from what it should show.
pub fn against_the_map(run: &Run, picture: &Picture) -> Report {
    compare(picture, shown_by_fisheye(CIRCLE, camera_of(run)))
}

/// One view, and nothing that is flat.
pub fn expect_one_pass(finished: &Finished, what: &str) {
    let statistics = finished.statistics();
    assert_eq!(statistics["views"].as_array().map(Vec::len), Some(1), "{what}: {statistics:#}");
    assert_eq!(statistics["panel_draws"], 0, "{what}: {statistics:#}");
}

/// The projectors of `planetarium-6` in one window, away from the middle of the dome.
pub struct Projectors {
    rig: ProjectorRig,
    size: (usize, usize),
    folder: PathBuf,
}

impl Projectors {
    /// Small pictures, in rows of three.
    pub fn new() -> Self {
        let (size, columns) = ((128, 96), 3);
        let rig = rigs::projectors("planetarium-6", size, columns);
        let rows = rig.projectors.len().div_ceil(columns);
        Self { rig, size: (columns * size.0, rows * size.1), folder: scratch("rig") }
    }

    /// Runs a program by `under` in a window of that size, without blending.
    pub fn unblended(&self, run: &Run, under: impl Fn(&Run, &str) -> Option<Finished>) -> Option<Finished> {
        self.start("unblended.toml", &self.rig.unblended, run, under)
    }

    /// The same where their light is blended.
    pub fn blended(&self, run: &Run, under: impl Fn(&Run, &str) -> Option<Finished>) -> Option<Finished> {
        self.start("blended.toml", &self.rig.blended, run, under)
    }

    fn start(
        &self,
        name: &str,
        text: &str,
        run: &Run,
        under: impl Fn(&Run, &str) -> Option<Finished>,
    ) -> Option<Finished> {
        let file = self.folder.join(name);
        std::fs::write(&file, text).expect("a rig can be written");
        under(&Run { size: self.size, ..run.clone() }, file.to_str().expect("a UTF-8 path"))
    }

    fn pictures(&self) -> impl Iterator<Item = String> {
        self.rig.projectors.iter().map(|projector| format!("capture-{}.png", projector.name))
    }

    /// Each picture without blending is where the exact map has it.
    pub fn expect_good(&self, plain: &Finished, run: &Run, what: &str) {
        for (projector, name) in self.rig.projectors.iter().zip(self.pictures()) {
            let picture = plain.picture(&name);
            let report = compare(&picture, shown_by_projector(projector, &self.rig.dome, camera_of(run)));
            expect_good(&report, &picture, &format!("{what}, {}", projector.name));
        }
    }

    /// The weights are those of the default method, whose pictures are `expected`; a picture is off
    /// where the cube's edges are resampled, and shows there what the other has beside. And a fifth
    /// of the pixels, at least, is darker by 40/255 in a channel.
    pub fn expect_blended(&self, plain: &Finished, blended: &Finished, expected: &Finished) {
        for name in self.pictures() {
            let [plain, found, expected] = [plain, blended, expected].map(|finished| finished.picture(&name));
            let far = far(&found, &expected);
            assert!(far < 0.01, "{name}: {far} of the pixels are off");
            expect_alike(&found, &expected, WEIGHED, &format!("blended, {name}"));
            let is_darker =
                |(a, b): &(&[u8; 3], &[u8; 3])| (0..3).any(|channel| a[channel].saturating_sub(b[channel]) > 40);
            let darker = plain.pixels.iter().zip(&found.pixels).filter(is_darker).count();
            assert!(darker * 5 > found.pixels.len(), "{name}: {darker} pixels are darker");
        }
    }
}
