//! Shared parts of the tests of methods that project vertices directly to an output: a camera, a
//! domemaster, the projectors of a planetarium.

use crate::compare::{RESAMPLED, Report, compare, expect_alike, expect_good, far};
use crate::dialects::{camera_of, shown_by_fisheye, shown_by_projector};
use crate::picture::Picture;
use crate::programs::{Finished, Run, scratch};
use crate::reference::Fisheye;
use crate::rigs::{self, ProjectorRig};
use std::path::PathBuf;

/// The preset `fisheye` in these tests' windows.
pub const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

/// Colour to which the Vulkan programs clear their window.
pub const GREY: [u8; 3] = [64; 3];

/// A camera that shows all kinds of corners and edges, and cells around the antipode.
pub fn run<'a>(program: &'a str, extra: &'a [&'a str], cupola: &'a [&'a str]) -> Run<'a> {
    Run { fov: 90.0, yaw: 33.0, pitch: -17.0, extra, cupola, ..Run::new(program) }
}

/// A run of the Vulkan programs' cube.
pub fn vk_cube<'a>(extra: &'a [&'a str], cupola: &'a [&'a str]) -> Run<'a> {
    run("vk_cube", extra, cupola)
}

/// Runs an OpenGL program under a rig.
pub fn on_opengl(run: &Run, rig: &str) -> Option<Finished> {
    Some(run.under(rig)?.expect_success().expect_no_gl_errors())
}

/// Runs a Vulkan program under a rig.
pub fn on_vulkan(run: &Run, rig: &str) -> Option<Finished> {
    run.vulkan_under(rig)
}

/// Runs a Vulkan program with the preset `fisheye`.
pub fn vulkan_fisheye(run: &Run) -> Option<Finished> {
    on_vulkan(run, "fisheye")
}

/// Compares a picture of the preset `fisheye` with the prediction.
pub fn against_the_map(run: &Run, picture: &Picture) -> Report {
    compare(picture, shown_by_fisheye(CIRCLE, camera_of(run)))
}

/// Checks that there is one view and nothing is flat.
pub fn expect_one_pass(finished: &Finished, what: &str) {
    let statistics = finished.statistics();
    assert_eq!(statistics["views"].as_array().map(Vec::len), Some(1), "{what}: {statistics:#}");
    assert_eq!(statistics["panel_draws"], 0, "{what}: {statistics:#}");
}

/// The projectors of `planetarium-6`, which are not in the middle of the dome, with their outputs
/// in one window.
pub struct Projectors {
    rig: ProjectorRig,
    size: (usize, usize),
    folder: PathBuf,
}

impl Projectors {
    /// The rig with small pictures, in rows of three.
    pub fn new() -> Self {
        let (size, columns) = ((128, 96), 3);
        let rig = rigs::projectors("planetarium-6", size, columns);
        let rows = rig.projectors.len().div_ceil(columns);
        Self { rig, size: (columns * size.0, rows * size.1), folder: scratch("rig") }
    }

    /// Runs a program with `under` in a window of that size, without blending.
    pub fn unblended(&self, run: &Run, under: impl Fn(&Run, &str) -> Option<Finished>) -> Option<Finished> {
        self.start("unblended.toml", &self.rig.unblended, run, under)
    }

    /// As [`Self::unblended`], with blending.
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

    /// Checks that each picture without blending agrees with the exact map.
    pub fn expect_good(&self, plain: &Finished, run: &Run, what: &str) {
        for (projector, name) in self.rig.projectors.iter().zip(self.pictures()) {
            let picture = plain.picture(&name);
            let report = compare(&picture, shown_by_projector(projector, &self.rig.dome, camera_of(run)));
            expect_good(&report, &picture, &format!("{what}, {}", projector.name));
        }
    }

    /// Checks that the blend weights are those of the default method, whose pictures are
    /// `expected`. Pictures may differ where the cube's edges are resampled, but only by what the
    /// other picture has beside. At least a fifth of the pixels must be darker by 40/255 in a
    /// channel.
    pub fn expect_blended(&self, plain: &Finished, blended: &Finished, expected: &Finished) {
        for name in self.pictures() {
            let [plain, found, expected] = [plain, blended, expected].map(|finished| finished.picture(&name));
            let far = far(&found, &expected);
            assert!(far < 0.01, "{name}: {far} of the pixels are off");
            expect_alike(&found, &expected, RESAMPLED, &format!("blended, {name}"));
            let is_darker =
                |(a, b): &(&[u8; 3], &[u8; 3])| (0..3).any(|channel| a[channel].saturating_sub(b[channel]) > 40);
            let darker = plain.pixels.iter().zip(&found.pixels).filter(is_darker).count();
            assert!(darker * 5 > found.pixels.len(), "{name}: {darker} pixels are darker");
        }
    }
}
