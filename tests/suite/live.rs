//! The rig's file changes while a program runs with the rig.

use crate::compare::{expect_alike, expect_identical, expect_similar, far};
use crate::harness::{note, tests};
use crate::picture::Picture;
use crate::programs::{Finished, Run, scratch};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

tests! {
    ramps_follow_the_file,
    content_follows_the_file,
    content_follows_the_file_on_vulkan,
    the_viewer_follows_the_file,
    the_camera_follows_the_file,
    ramps_follow_the_file_on_vulkan,
    the_camera_follows_the_file_on_vulkan,
    the_viewer_follows_the_file_over_the_views_of_a_vulkan_window,
    directions_without_a_view_are_black,
    scenes_off_screen_follow_the_file_on_vulkan,
    a_file_with_a_mistake_changes_nothing,
    methods_that_project_vertices_need_a_new_start,
    methods_follow_the_file,
    the_stage_that_divides_follows_the_file,
    lists_get_views_where_primitives_are_divided_later,
    methods_follow_the_file_on_vulkan,
    a_vulkan_window_that_is_not_made_anew_stays_as_it_is,
}

const RIG: &str =
    "[[output]]\nkind = \"domemaster\"\n[output.blend]\nramps = [{ angle = \"polar\", zero = 90, full = 80 }]\n";

/// Text in the log after the file was read again.
const FOLLOWED: &str = "windows follow it (1)";
const FOLLOWED_TWICE: &str = "windows follow it (2)";
const REFUSED: &str = "the rig stays as it was";

/// Time between two changes of the same rig.
const WHILE: Duration = Duration::from_secs(1);

/// Longest time that a program may take to notice a change of its rig.
const LONGEST_WAIT: Duration = Duration::from_secs(60);
const POLL: Duration = Duration::from_millis(20);

/// Number of frames of a run, and of the frames after the change was noticed.
const FRAMES: usize = 20;

/// Whether a condition becomes true within [`LONGEST_WAIT`].
fn becomes_true(is_true: impl Fn() -> bool) -> bool {
    (0..LONGEST_WAIT.as_millis() / POLL.as_millis()).any(|_| {
        std::thread::sleep(POLL);
        is_true()
    })
}

/// A program and the rig with which it starts. The rig is a file that only this test uses.
struct Case<'a> {
    run: Run<'a>,
    vulkan: bool,
    name: &'a str,
    /// Changes of the file before the program starts.
    start: fn(&Path),
}

impl<'a> Case<'a> {
    fn opengl(run: Run<'a>, name: &'a str) -> Self {
        Self { run, vulkan: false, name, start: |_| () }
    }

    fn vulkan(run: Run<'a>, name: &'a str) -> Self {
        Self { vulkan: true, ..Self::opengl(run, name) }
    }

    fn rig(&self) -> PathBuf {
        let file = scratch("live").join(format!("{}.toml", self.name));
        std::fs::write(&file, RIG).expect("a rig file");
        (self.start)(&file);
        file
    }

    /// Runs the program with [`FRAMES`] frames. The program ends by itself.
    fn under(&self, run: Run, file: &Path) -> Option<Finished> {
        let run = Run { frames: FRAMES, cupola_frames: 0, ..run };
        let rig = file.to_string_lossy();
        if self.vulkan { run.vulkan_under(&rig) } else { run.under(&rig) }
    }

    /// Changes the rig after the program has drawn some frames. The program ends some frames after
    /// its log contains `message`. `None` if there is no display.
    fn changed_meanwhile(&self, change: fn(&Path), message: &'static str) -> Option<Finished> {
        let (file, directory) = (self.rig(), scratch(self.name));
        let (changing, watched) = (file.clone(), directory.clone());
        let helper = std::thread::spawn(move || {
            let begun = becomes_true(|| watched.join("begun").exists());
            change(&changing);
            let noticed = becomes_true(|| {
                std::fs::read_to_string(watched.join("stderr.log")).is_ok_and(|words| words.contains(message))
            });
            std::fs::write(watched.join("end"), "").expect("a file that ends the program");
            begun && noticed
        });
        let environment = [("APP_WAIT", ".")];
        let run = Run { environment: &environment, directory: Some(&directory), ..self.run.clone() };
        let finished = self.under(run, &file);
        let noticed = helper.join().expect("changes the file");
        let finished = finished?;
        assert!(noticed, "{}: the change was not noticed\n{}", self.run.program, finished.words());
        Some(finished)
    }

    /// Runs the program with a rig that has these changes from the start. Enough frames are drawn
    /// for the views to be planned for the number of draws.
    fn started_with(&self, change: fn(&Path)) -> Option<Finished> {
        let file = self.rig();
        change(&file);
        self.under(self.run.clone(), &file)
    }

    /// Checks that a program whose rig changes shows the picture of the changed rig.
    fn follows(&self, change: fn(&Path)) -> Option<Finished> {
        self.follows_as(change, expect_identical)
    }

    /// As [`Self::follows`], with `expect` as the comparison.
    fn follows_as(&self, change: fn(&Path), expect: fn(&Picture, &Picture, &str)) -> Option<Finished> {
        let found = self.changed_meanwhile(change, FOLLOWED)?;
        let (expected, before) = (self.started_with(change)?, self.started_with(|_| ())?);
        let picture = expected.picture("capture.png");
        expect(&found.picture("capture.png"), &picture, self.run.program);
        // Negative control: the change is visible.
        assert!(before.picture("capture.png").difference(&picture).0 > 1_000);
        Some(found)
    }
}

fn tuned(file: &Path, changes: &[&str]) {
    let status = Command::new(env!("CARGO_BIN_EXE_cupola")).arg("tune").arg(file).args(changes).status();
    assert!(status.expect("runs").success(), "{changes:?}");
}

fn ramps(file: &Path) {
    tuned(file, &["output.*.blend.ramps=[{ angle = \"polar\", zero = 70, full = 20 }]"]);
}

fn content(file: &Path) {
    tuned(file, &["content.kind=\"domemaster\"", "content.aperture=150"]);
}

fn camera(file: &Path) {
    tuned(file, &["camera.zoom=1.4", "camera.yaw=25", "camera.roll=10"]);
}

fn viewer(file: &Path) {
    tuned(file, &["viewer.yaw=30", "viewer.position=[0.5, 0.3, -1.0]", "output.output-1.blend.black_level=0.05"]);
}

fn lower_viewer(file: &Path) {
    tuned(file, &["viewer.yaw=30", "viewer.position=[0.3, -1.0, -0.2]"]);
}

fn mistake(file: &Path) {
    std::fs::write(file, "[[output]]\nkind = \"domemaster\"\naperture = 1000\n").expect("writes");
}

fn fragment(file: &Path) {
    tuned(file, &["output.*.method=\"fragment\""]);
}

fn vertex(file: &Path) {
    tuned(file, &["output.*.method=\"vertex\""]);
}

fn primitive(file: &Path) {
    tuned(file, &["output.*.method=\"primitive\""]);
}

fn tessellation(file: &Path) {
    tuned(file, &["output.*.method=\"primitive-tessellation\"", "output.*.max_error=8"]);
}

fn geometry(file: &Path) {
    tuned(file, &["output.*.method=\"primitive\"", "output.*.max_error=8"]);
}

fn fragment_and_primitive(file: &Path) {
    fragment(file);
    std::thread::sleep(WHILE);
    primitive(file);
}

fn ramps_follow_the_file() {
    Case::opengl(Run::new("core330_mvp"), "ramps").follows(ramps);
}

fn content_follows_the_file() {
    Case::opengl(Run::new("core330_mvp"), "content").follows(content);
}

fn content_follows_the_file_on_vulkan() {
    Case::vulkan(Run { extra: &["--way", "clear"], ..Run::new("vk_scenes") }, "content").follows(content);
}

fn the_viewer_follows_the_file() {
    Case::opengl(Run::new("immediate"), "viewer").follows(viewer);
}

/// The stand-in image stays; only the transforms of the views are new.
fn the_camera_follows_the_file() {
    for program in ["core330_mvp", "immediate", "passes"] {
        Case::opengl(Run::new(program), &format!("camera-{program}")).follows(camera);
    }
}

fn ramps_follow_the_file_on_vulkan() {
    Case::vulkan(Run::new("vk_cube"), "vulkan").follows(ramps);
}

/// The program has recorded its commands before the change, and makes no new swapchain.
fn the_camera_follows_the_file_on_vulkan() {
    Case::vulkan(Run { extra: &["--once"], ..Run::new("vk_cube") }, "camera-on-vulkan").follows(camera);
}

/// The program makes no new swapchain, so its window keeps its views. The viewer is lower, so the
/// old views show all that it sees.
fn the_viewer_follows_the_file_over_the_views_of_a_vulkan_window() {
    let case = Case::vulkan(Run::new("vk_cube"), "viewer-on-vulkan");
    let alike = |found: &Picture, expected: &Picture, what: &str| expect_alike(found, expected, 8, what);
    if let Some(found) = case.follows_as(lower_viewer, alike) {
        assert!(found.words().contains("over the views that the window has"), "{}", found.words());
    }
}

/// Directions that the old views do not show are black, not the texels beside a view.
fn directions_without_a_view_are_black() {
    let case = Case::vulkan(Run::new("vk_cube"), "higher-viewer");
    let alike_or_black = |found: &Picture, expected: &Picture, what: &str| {
        // Light of 0.05 has the value 65.
        let is_black = |pixel: &[u8; 3]| pixel.iter().all(|value| *value <= 66);
        let lit = found.pixels.iter().zip(&expected.pixels);
        let (black, shown): (Vec<_>, Vec<_>) = lit.partition(|(found, _)| is_black(found));
        let lost = black.iter().filter(|(_, expected)| !is_black(expected)).count();
        assert!((200..6_000).contains(&lost), "{what}: {lost} pixels are black");
        let is_far = |(found, expected): &&(&[u8; 3], &[u8; 3])| (0..3).any(|c| found[c].abs_diff(expected[c]) > 12);
        let off = shown.iter().filter(is_far).count();
        assert!(off < 40, "{what}: {off} of {} pixels differ", shown.len());
    };
    case.follows_as(viewer, alike_or_black);
}

/// Other views: the program makes a new swapchain and keeps the images to which it draws its scene.
fn scenes_off_screen_follow_the_file_on_vulkan() {
    for way in ["post", "chain", "blit"] {
        let extra = ["--way", way];
        Case::vulkan(Run { extra: &extra, ..Run::new("vk_scenes") }, way).follows(viewer);
    }
}

fn a_file_with_a_mistake_changes_nothing() {
    let case = Case::opengl(Run::new("core330_mvp"), "mistake");
    let Some(found) = case.changed_meanwhile(mistake, REFUSED) else { return };
    let Some(expected) = case.started_with(|_| ()) else { return };
    expect_identical(&found.picture("capture.png"), &expected.picture("capture.png"), "as before");
    let words = found.words();
    assert!(words.contains("aperture") && words.contains(":3:"), "{words}");
}

/// Number of views at the end.
fn views(finished: &Finished) -> usize {
    finished.statistics()["views"].as_array().map_or(0, Vec::len)
}

/// Checks that the picture and the number of views stay, and that the log gives the reason once.
fn stays(case: &Case, change: fn(&Path), why: &str) -> Option<()> {
    let found = case.changed_meanwhile(change, FOLLOWED)?;
    let expected = case.started_with(|_| ())?;
    expect_identical(&found.picture("capture.png"), &expected.picture("capture.png"), why);
    assert_eq!(found.words().matches(why).count(), 1, "{}", found.words());
    assert_eq!(views(&found), views(&expected));
    Some(())
}

/// Message in the log about a program whose shaders do not contain the lenses of outputs.
const NOT_PROJECTED: &str = "vertices are projected after a new start: outputs that ask for it are made by method";
const NOT_DIVIDED: &str = "primitives are divided after a new start: outputs that ask for it are made by method";
/// Message in the log if the change applies only to the next swapchain. `vk_cube` never makes one.
const NEXT_SWAPCHAIN: &str = "a window follows when the program makes its next swapchain";

/// Shaders and lists that were made for views cannot project vertices.
fn methods_that_project_vertices_need_a_new_start() {
    for change in [vertex as fn(&Path), primitive] {
        let opengl = Case::opengl(Run::new("core330_mvp"), "later");
        if stays(&opengl, change, NOT_PROJECTED).is_none() {
            return;
        }
    }
    for (change, why) in [(vertex as fn(&Path), NOT_PROJECTED), (primitive, NOT_DIVIDED)] {
        if stays(&Case::vulkan(Run::new("vk_cube"), "later"), change, why).is_none() {
            return;
        }
    }
}

/// If vertices are projected from the start, the primitives between them may be divided later, with
/// shaders and with the fixed-function pipeline.
fn methods_follow_the_file() {
    for program in ["core330_mvp", "immediate"] {
        let case = Case { start: vertex, ..Case::opengl(Run::new(program), "divided") };
        let Some(found) = case.follows(primitive) else { return };
        assert_eq!(views(&found), 1, "{program}");
        assert!(!found.words().contains("instead"), "{program}: {}", found.words());
        let case = Case { start: primitive, ..Case::opengl(Run::new(program), "views") };
        let Some(found) = case.follows(fragment) else { return };
        assert!(views(&found) > 1, "{program}");
        there_and_back(&case);
    }
}

/// The stage that divides is the one that the file gives now.
fn the_stage_that_divides_follows_the_file() {
    let case = Case { start: tessellation, ..Case::opengl(Run::new("core330_mvp"), "stage") };
    let Some(found) = case.changed_meanwhile(geometry, FOLLOWED) else { return };
    let (Some(expected), Some(before)) = (case.started_with(geometry), case.started_with(|_| ())) else { return };
    let picture = expected.picture("capture.png");
    expect_identical(&found.picture("capture.png"), &picture, "the stage");
    let (differ, worst) = before.picture("capture.png").difference(&picture);
    note(format_args!("{differ} pixels differ between the stages, the worst by {worst}/255"));
    assert!(differ > 20, "both stages give the same picture");
}

/// From divided primitives to views and back to divided primitives.
fn there_and_back(case: &Case) -> Option<()> {
    let found = case.changed_meanwhile(fragment_and_primitive, FOLLOWED_TWICE)?;
    let expected = case.started_with(|_| ())?;
    expect_identical(&found.picture("capture.png"), &expected.picture("capture.png"), "there and back");
    assert_eq!(views(&found), 1);
    Some(())
}

/// Lists that the driver compiled earlier cannot be divided. The window then gets views.
fn lists_get_views_where_primitives_are_divided_later() {
    let case = Case { start: vertex, ..Case::opengl(Run::new("display_list"), "lists") };
    let Some(found) = case.changed_meanwhile(primitive, FOLLOWED) else { return };
    let Some(expected) = case.started_with(fragment) else { return };
    let far = far(&found.picture("capture.png"), &expected.picture("capture.png"));
    assert!(far < 0.001, "{far} of the pixels are off");
    expect_alike(&found.picture("capture.png"), &expected.picture("capture.png"), 1, "lists");
    assert_eq!(found.words().matches("by method \"fragment\" instead").count(), 1, "{}", found.words());
}

/// Shaders with lenses and shaders without them round a few pixels differently.
fn expect_rounded(found: &Picture, expected: &Picture, what: &str) {
    expect_similar(found, expected, 1, 0.001, what);
}

/// A device that was created for division can change to views and back, with a new swapchain each
/// time. A device that was created for the method `vertex` gets views if primitives are to be
/// divided.
fn methods_follow_the_file_on_vulkan() {
    let case = |extra, start, name| {
        let run = Run { extra, ..Run::new("vk_scenes") };
        Case { start, ..Case::vulkan(run, name) }
    };
    let (direct, off_screen) = (&["--way", "clear"], &["--way", "post"]);
    for extra in [direct, off_screen] {
        let Some(found) = case(extra, primitive, "views").follows_as(fragment, expect_rounded) else { return };
        assert!(views(&found) > 1);
    }
    if there_and_back(&case(off_screen, primitive, "back")).is_none() {
        return;
    }
    let Some(found) = case(direct, vertex, "vertices").changed_meanwhile(primitive, FOLLOWED) else { return };
    let Some(expected) = case(direct, fragment, "vertices").started_with(|_| ()) else { return };
    expect_rounded(&found.picture("capture.png"), &expected.picture("capture.png"), "vertex, then primitive");
    assert_eq!(found.words().matches(NOT_DIVIDED).count(), 1, "{}", found.words());
}

/// A program that makes no new swapchain keeps its picture.
fn a_vulkan_window_that_is_not_made_anew_stays_as_it_is() {
    let case = Case { start: primitive, ..Case::vulkan(Run::new("vk_cube"), "kept") };
    stays(&case, fragment, NEXT_SWAPCHAIN);
}
