//! Programs whose window is already projected: the outputs show the pixels of the program's own
//! picture.

use crate::harness::{note, tests};
use crate::picture::Picture;
use crate::programs::{Finished, Run, scratch};
use crate::reference::{Dome, Fisheye, Opening, Projector, Turn, Vector, normalised};

tests! {
    opengl_programs_are_warped_as_they_are,
    vulkan_programs_are_warped_as_they_are,
    outputs_in_a_window_share_the_content,
    a_whole_circle_is_the_programs_own_picture,
    each_eye_gets_its_half,
    a_headless_window_is_as_large_as_the_outputs_need,
    wrong_content_is_refused,
}

/// A projector in a tilted dome. The viewer is not in the dome's centre.
const PROJECTOR: &str = "[dome]\nradius = 4.0\ntilt = 30.0\ncoverage = 200.0\n[viewer]\nposition = [0.5, -0.4, 1.0]\n\
    [[output]]\nkind = \"projector\"\nposition = [0.0, -0.5, 1.2]\npitch = 35.0\nfov = [100.0, 80.0]\n";

/// Direction from the dome's centre to the point that a pixel of the projector lights, in a window
/// of 256 × 256.
fn projected(x: f64, y: f64) -> Option<Vector> {
    let (viewer, turn) = ([0.5, -0.4, 1.0], Turn::default());
    let dome = Dome { radius: 4.0, tilt: 30.0, coverage: 200.0, viewer, viewer_turn: turn, camera_turn: turn };
    let (tangent_x, tangent_y) = (50.0_f64.to_radians().tan(), 40.0_f64.to_radians().tan());
    let projector = Projector {
        name: "projector".to_owned(),
        position: [0.0, -0.5, 1.2],
        turn: Turn { yaw: 0.0, pitch: 35.0, roll: 0.0 },
        opening: Opening { left: -tangent_x, right: tangent_x, bottom: -tangent_y, top: tangent_y },
        width: 256.0,
        height: 256.0,
    };
    let point = projector.hit(&dome, x, y)?;
    (dome.within_screen(point) > 0.0).then(|| normalised(point))
}

/// Part of the window that holds a content's picture: x, y, width and height in pixels from the top
/// left.
#[derive(Clone, Copy)]
struct Part([f64; 4]);

/// Kinds of content, computed here independently of Cupola.
#[derive(Clone, Copy)]
enum Content {
    /// Equidistant fisheye, in degrees.
    Domemaster { aperture: f64, tilt: f64 },
    /// Picture of all directions. Its middle is turned.
    Equirectangular(Turn),
}

impl Content {
    /// Place of a direction, as parts of the picture from the top left.
    fn place(self, direction: Vector) -> Option<[f64; 2]> {
        match self {
            Self::Domemaster { aperture, tilt } => {
                let axis = Turn { yaw: 0.0, pitch: 90.0 - tilt, roll: 0.0 };
                let [x, y, z] = axis.inward(direction);
                let radius = 2.0 * x.hypot(y).atan2(-z) / aperture.to_radians();
                let (cosine, sine) = (x / x.hypot(y), y / x.hypot(y));
                (radius <= 1.0).then_some([0.5 + 0.5 * radius * cosine, 0.5 - 0.5 * radius * sine])
            }
            Self::Equirectangular(turn) => {
                let [x, y, z] = turn.inward(direction);
                let (longitude, latitude) = (x.atan2(-z).to_degrees(), y.atan2(x.hypot(z)).to_degrees());
                Some([0.5 + longitude / 360.0, 0.5 - latitude / 180.0])
            }
        }
    }
}

/// Colour of the picture at a place, in pixels from the top left: the weighted mean of the four
/// nearest pixels of the part.
fn bilinear(picture: &Picture, [x, y]: [f64; 2], Part([left, top, width, height]): Part, wraps: bool) -> Vector {
    let pixel = |column: f64, row: f64| {
        let within = column - left;
        let column = if wraps { within.rem_euclid(width) } else { within.clamp(0.0, width - 1.0) } + left;
        picture.at(column as usize, row.clamp(top, top + height - 1.0) as usize)
    };
    let (column, row) = ((x - 0.5).floor(), (y - 0.5).floor());
    let (right, down) = (x - 0.5 - column, y - 0.5 - row);
    std::array::from_fn(|channel| {
        let value = |x: f64, y: f64| f64::from(pixel(column + x, row + y)[channel]);
        (value(0.0, 0.0) * (1.0 - right) + value(1.0, 0.0) * right) * (1.0 - down)
            + (value(0.0, 1.0) * (1.0 - right) + value(1.0, 1.0) * right) * down
    })
}

/// Expected picture.
struct Expected<'a> {
    /// The program's own picture.
    plain: &'a Picture,
    content: Content,
    part: Part,
    /// Direction from the dome's centre for a pixel of the output.
    direction: &'a dyn Fn(f64, f64) -> Option<Vector>,
}

impl Expected<'_> {
    fn place(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let Part([left, top, width, height]) = self.part;
        let [across, down] = self.content.place((self.direction)(x, y)?)?;
        Some([left + across * width, top + down * height])
    }

    /// Greatest difference of a channel, in 255ths.
    fn worst(&self, shown: &Picture, what: &str) -> f64 {
        let (mut compared, mut lit, mut worst) = (0, 0, 0.0f64);
        for (row, column) in (0..shown.height).flat_map(|row| (0..shown.width).map(move |column| (row, column))) {
            let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
            let beside = [(0.02, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.0, -0.02)];
            let beside = beside.map(|(by_x, by_y)| self.place(x + by_x, y + by_y).is_some());
            let found = shown.at(column, row);
            match self.place(x, y) {
                // At the rim rounding decides whether a pixel is black.
                _ if beside.contains(&true) && beside.contains(&false) => {}
                None => assert_eq!(found, [0; 3], "{what}: {x}, {y} shows something"),
                Some(place) => {
                    compared += 1;
                    let wraps = matches!(self.content, Content::Equirectangular(_));
                    let expected = bilinear(self.plain, place, self.part, wraps);
                    lit += usize::from(found != [0; 3]);
                    for (found, expected) in found.into_iter().zip(expected) {
                        worst = worst.max((f64::from(found) - expected).abs());
                    }
                }
            }
        }
        assert!(compared * 4 > shown.pixels.len() && lit * 8 > compared, "{what}: {compared} compared, {lit} lit");
        worst
    }

    fn expect(&self, shown: &Picture, what: &str) {
        let worst = self.worst(shown, what);
        note(format!("{what}: at most {worst:.2} of 255"));
        assert!(worst <= 2.0, "{what}: {worst} of 255");
        // Negative control: the content turned by three degrees.
        let content = match self.content {
            Content::Domemaster { aperture, tilt } => Content::Domemaster { aperture, tilt: tilt + 3.0 },
            Content::Equirectangular(turn) => Content::Equirectangular(Turn { yaw: turn.yaw + 3.0, ..turn }),
        };
        let turned = Expected { content, ..*self }.worst_of_lit(shown);
        assert!(turned > 4.0, "{what}: {turned} of 255, turned");
    }

    /// As [`Self::worst`], without the check of the black pixels.
    fn worst_of_lit(&self, shown: &Picture) -> f64 {
        let mut worst = 0.0f64;
        for (row, column) in (0..shown.height).flat_map(|row| (0..shown.width).map(move |column| (row, column))) {
            let Some(place) = self.place(column as f64 + 0.5, row as f64 + 0.5) else { continue };
            let expected = bilinear(self.plain, place, self.part, false);
            for (found, expected) in shown.at(column, row).into_iter().zip(expected) {
                worst = worst.max((f64::from(found) - expected).abs());
            }
        }
        worst
    }
}

fn rig_file(text: &str) -> String {
    let file = scratch("content").join("rig.toml");
    std::fs::write(&file, text).expect("a file can be written");
    file.display().to_string()
}

/// Runs the program with content, and checks that each draw is issued once.
fn with_content(run: &Run, content: &str, rig: &str, vulkan: bool) -> Option<Finished> {
    let options = ["--content", content, "--frames", "3"];
    let run = Run { cupola: if vulkan { &options } else { &options[..2] }, ..run.clone() };
    let finished = if vulkan { run.vulkan_under(rig)? } else { run.under(rig)?.expect_success().expect_no_gl_errors() };
    let statistics = finished.statistics();
    assert_eq!(statistics["views"].as_array().map(Vec::len), Some(1), "{statistics}");
    if !vulkan {
        let number = |value: &serde_json::Value| value.as_u64().unwrap_or_default();
        let issued = number(&statistics["views"][0]["draws_issued"]) + number(&statistics["panel_draws"]);
        assert_eq!(issued, number(&statistics["draws_seen"]), "{statistics}");
    }
    assert_eq!(statistics["duplicated_draws"].as_u64().unwrap_or(0), 0, "{statistics}");
    assert!(!finished.words().contains("flat"), "{}", finished.words());
    Some(finished)
}

const WHOLE: Part = Part([0.0, 0.0, 256.0, 256.0]);
const WIDE: Part = Part([0.0, 64.0, 256.0, 128.0]);

fn opengl_programs_are_warped_as_they_are() {
    let rig = rig_file(PROJECTOR);
    let turn = Turn { yaw: 150.0, pitch: 10.0, roll: 0.0 };
    for (program, extra, words, content, part) in [
        ("core330_mvp", &[][..], "domemaster", Content::Domemaster { aperture: 200.0, tilt: 30.0 }, WHOLE),
        (
            "post_process",
            &[],
            "domemaster,aperture=230,tilt=60",
            Content::Domemaster { aperture: 230.0, tilt: 60.0 },
            WHOLE,
        ),
        ("hud", &[], "equirectangular,yaw=150,pitch=10", Content::Equirectangular(turn), WIDE),
        ("gles3", &[], "equirectangular,yaw=150,pitch=10,region=0,0,1,1", Content::Equirectangular(turn), WHOLE),
        (
            "camera_matrices",
            &["--mode", "sky_all"],
            "domemaster,region=0.5,0.25,0.5,0.75",
            Content::Domemaster { aperture: 200.0, tilt: 30.0 },
            Part([128.0, 64.0, 128.0, 192.0]),
        ),
    ] {
        let run = Run { extra, ..Run::new(program) };
        let Some(plain) = run.under("identity") else { return };
        let plain = &plain.expect_success().picture("capture.png");
        let Some(finished) = with_content(&run, words, &rig, false) else { return };
        let expected = Expected { plain, content, part, direction: &projected };
        expected.expect(&finished.picture("capture.png"), &format!("{program}, {words}"));
    }
}

fn vulkan_programs_are_warped_as_they_are() {
    let rig = rig_file(PROJECTOR);
    let turn = Turn { yaw: 150.0, pitch: 10.0, roll: 0.0 };
    for (program, extra, words, content, part) in [
        ("vk_cube", &[][..], "domemaster", Content::Domemaster { aperture: 200.0, tilt: 30.0 }, WHOLE),
        (
            "vk_later_passes",
            &["--mode", "sky"],
            "equirectangular,yaw=150,pitch=10",
            Content::Equirectangular(turn),
            WIDE,
        ),
    ] {
        let run = Run { extra, cupola: &["--frames", "3"], ..Run::new(program) };
        let Some(plain) = run.vulkan_under("identity-captured") else { return };
        let plain = &plain.picture("capture.png");
        let Some(finished) = with_content(&run, words, &rig, true) else { return };
        let expected = Expected { plain, content, part, direction: &projected };
        expected.expect(&finished.picture("capture.png"), &format!("{program}, {words}"));
    }
}

fn outputs_in_a_window_share_the_content() {
    let rig = "[dome]\ntilt = 20.0\n[[output]]\nkind = \"domemaster\"\nname = \"dome\"\nwindow = [0, 0, 128, 128]\n\
        [[output]]\nkind = \"equirectangular\"\nname = \"all\"\nwindow = [128, 0, 160, 90]\n";
    let turn = Turn { yaw: 30.0, pitch: -10.0, roll: 0.0 };
    let run = Run { size: (288, 180), ..Run::new("core330_mvp") };
    let Some(plain) = run.under("identity") else { return };
    let plain = &plain.expect_success().picture("capture.png");
    let Some(finished) = with_content(&run, "equirectangular,yaw=30,pitch=-10", &rig_file(rig), false) else { return };
    let fisheye = Fisheye { width: 128.0, height: 128.0, aperture: 180.0, tilt: 20.0 };
    let dome = |x: f64, y: f64| (fisheye.inside_by(x, y) >= 0.0).then(|| fisheye.direction(x, y));
    let all = |x: f64, y: f64| {
        let (longitude, latitude) = ((x / 160.0 - 0.5) * 360.0, (0.5 - y / 90.0) * 180.0);
        Some(Turn { yaw: longitude, pitch: latitude, roll: 0.0 }.outward([0.0, 0.0, -1.0]))
    };
    let (content, part) = (Content::Equirectangular(turn), Part([0.0, 18.0, 288.0, 144.0]));
    for (name, direction) in [("dome", &dome as &dyn Fn(f64, f64) -> Option<Vector>), ("all", &all)] {
        let expected = Expected { plain, content, part, direction };
        expected.expect(&finished.picture(&format!("capture-{name}.png")), name);
    }
}

/// A domemaster that is shown on a domemaster is the picture that the program drew. Places are
/// exact to a few thousandths of a pixel, so that colours may be rounded differently.
fn a_whole_circle_is_the_programs_own_picture() {
    let run = Run::new("hud");
    let Some(plain) = run.under("identity") else { return };
    let plain = plain.expect_success().picture("capture.png");
    let rig = rig_file("[[output]]\nkind = \"domemaster\"\n");
    let Some(finished) = with_content(&run, "domemaster", &rig, false) else { return };
    let cut = Picture::from_fn(256, 256, |x, y| {
        let inside = (x as f64 - 127.5).hypot(y as f64 - 127.5) <= 128.0;
        if inside { plain.at(x, y) } else { [0; 3] }
    });
    let (count, worst) = finished.picture("capture.png").difference(&cut);
    assert!(worst <= 2, "{count} pixels differ, by {worst} at most");
    assert!(plain.difference(&cut).1 > 50, "the corners of the program's picture are black");
}

fn each_eye_gets_its_half() {
    let rig = "[[output]]\nkind = \"domemaster\"\nname = \"left\"\neye = -0.03\nwindow = [0, 0, 128, 128]\n\
        [[output]]\nkind = \"domemaster\"\nname = \"right\"\neye = 0.03\nwindow = [128, 0, 128, 128]\n";
    let run = Run::new("hud");
    let Some(plain) = run.under("identity") else { return };
    let plain = &plain.expect_success().picture("capture.png");
    let content = "domemaster,stereo=side-by-side,region=0,0,1,1";
    let Some(finished) = with_content(&run, content, &rig_file(rig), false) else { return };
    let fisheye = Fisheye { width: 128.0, height: 128.0, aperture: 180.0, tilt: 0.0 };
    let direction = &|x: f64, y: f64| (fisheye.inside_by(x, y) >= 0.0).then(|| fisheye.direction(x, y));
    for (name, left) in [("left", 0.0), ("right", 128.0)] {
        let (content, part) = (Content::Domemaster { aperture: 180.0, tilt: 0.0 }, Part([left, 0.0, 128.0, 256.0]));
        let expected = Expected { plain, content, part, direction };
        expected.expect(&finished.picture(&format!("capture-{name}.png")), name);
    }
}

/// Cupola itself makes a window larger if it is on a screen that is not visible.
fn a_headless_window_is_as_large_as_the_outputs_need() {
    let rig = "[[output]]\nkind = \"domemaster\"\nname = \"a\"\nsize = [200, 150]\n\
        [[output]]\nkind = \"domemaster\"\nname = \"b\"\nsize = [180, 170]\n";
    let run = Run { cupola: &["--headless"], ..Run::new("core330_mvp") };
    let Some(finished) = run.under(&rig_file(rig)) else { return };
    let picture = finished.expect_success().picture("capture-a.png");
    assert_eq!((picture.width, picture.height), (200, 170));
}

fn wrong_content_is_refused() {
    for (rig, content, why) in
        [("fisheye", "fisheye", "\"domemaster\""), ("identity", "domemaster", "passthrough = true has none")]
    {
        let run = Run { cupola: &["--content", content], ..Run::new("core330_mvp") };
        let Some(finished) = run.under(rig) else { return };
        assert_eq!(finished.status(), 2, "{}", finished.words());
        assert!(finished.words().contains(why), "{}", finished.words());
    }
}
