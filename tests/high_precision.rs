//! The exact map against directions that were computed with 60 decimal digits, independently of
//! this project. Rays and intersections were written in Python with mpmath, with the same numbers
//! as in the rigs here.

use cupola::rig::parse;
use cupola::warp::exact_direction;
use glam::{DVec2, DVec3};
use std::path::Path;

const PROJECTOR: &str = "[viewer]\nposition = [1, -0.5, 2]\nyaw = 30\npitch = 10\nroll = -5\n[[output]]\nkind = \"projector\"\n\
    position = [0.3, 1.2, 2.5]\nyaw = 20\npitch = -10\nroll = 5\nfov = [60, 40]\nshift = [0.1, -0.2]\n";
const MIRROR: &str = "[dome]\nradius = 1.5\ncoverage = 360\n[viewer]\nposition = [0.1, 0.2, 0.3]\n[[output]]\nkind = \"projector\"\n\
    position = [0, -1.29, -0.64]\nyaw = 180\npitch = 24\nfov = [23.65, 13.44]\n\
    mirror = { center = [0, -0.92, 0.43], radius = 0.32 }\n";

/// Screen, pixel, direction in the viewer's axes.
type Known = (&'static str, [f64; 2], [f64; 3]);

const KNOWN: [Known; 12] = [
    ("sphere", [123.5, 987.5], [-0.664963715892749, -0.385494471404455, -0.639700921574065]),
    ("ellipsoid", [123.5, 987.5], [-0.664682584107771, -0.386031171827036, -0.639669443354660]),
    ("cylinder", [123.5, 987.5], [-0.667985986652739, -0.379685887399758, -0.640026053020519]),
    ("cone", [123.5, 987.5], [-0.648260298149340, -0.416376063160959, -0.637486909567490]),
    ("plane", [123.5, 987.5], [-0.684465430314594, -0.346678845795718, -0.641343006964297]),
    ("sphere", [1800.5, 40.5], [0.365383269375159, 0.108815855755490, -0.924475081328275]),
    ("ellipsoid", [1800.5, 40.5], [0.367110749842473, 0.059839154464261, -0.928250490408219]),
    ("cylinder", [1800.5, 40.5], [0.363690580629083, 0.142212937206049, -0.920600153189705]),
    ("cone", [1800.5, 40.5], [0.355525997238632, 0.247721337132365, -0.901241035692910]),
    ("plane", [1800.5, 40.5], [0.366975433962248, 0.064831942351070, -0.927968668716357]),
    ("mirror", [800.5, 300.5], [0.164269900097262, -0.071100413495091, -0.983849648636855]),
    ("mirror", [1100.5, 700.5], [-0.187023396150440, -0.644676125134393, -0.741225298390483]),
];

fn rig_with(screen: &str) -> String {
    match screen {
        "sphere" => format!("[dome]\nradius = 5\ncoverage = 360\n{PROJECTOR}"),
        "ellipsoid" => format!(
            "[screen]\nshape = \"ellipsoid\"\nradii = [6, 4, 5]\nposition = [0.2, 0.1, -0.3]\nyaw = 20\npitch = -10\n{PROJECTOR}"
        ),
        "cylinder" => format!(
            "[screen]\nshape = \"cylinder\"\nradius = 4\nheights = [-20, 20]\nposition = [0.5, 0, -1]\npitch = -30\n{PROJECTOR}"
        ),
        "cone" => {
            format!("[screen]\nshape = \"cone\"\nradii = [12, 0.04]\nheights = [-20, 9.9]\nroll = 10\n{PROJECTOR}")
        }
        "plane" => format!(
            "[screen]\nshape = \"plane\"\nsize = [40, 40]\nposition = [0, 0, -3]\nyaw = 15\npitch = 5\n{PROJECTOR}"
        ),
        _ => MIRROR.to_owned(),
    }
}

#[test]
fn agrees_with_sixty_digits() {
    for (screen, [x, y], expected) in KNOWN {
        let rig = parse(&rig_with(screen), "known.toml", Path::new("")).expect("valid");
        let pixel = DVec2::new(x, y);
        let found = exact_direction(&rig, 0, (1920, 1080), pixel).expect("shown");
        let expected = DVec3::from_array(expected);
        assert!(found.distance(expected) < 2e-15, "{screen} {pixel}: {found} is not {expected}");
        // Negative control: an offset of a hundred-thousandth of a pixel is detected.
        let aside = exact_direction(&rig, 0, (1920, 1080), pixel + 1e-5).expect("shown");
        assert!(aside.distance(expected) > 1e-10);
    }
}
