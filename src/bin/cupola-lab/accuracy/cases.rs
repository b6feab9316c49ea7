//! The screens, lenses and positions that are compared, as rig files.

/// A combination of a screen and a lens.
pub struct Row {
    /// Name of the screen.
    pub screen: &'static str,
    /// Name of the lens or the kind of picture.
    pub lens: &'static str,
    screen_text: &'static str,
    output_text: &'static str,
    /// Distances of the projector from the centre in radii; empty for pictures without a projector.
    distances: &'static [f64],
}

/// A rig file.
pub struct Case {
    /// Text of the file.
    pub text: String,
    /// True if the projector is outside the screen.
    pub outside: bool,
}

/// "Radius" of every screen. Distances are given in radii.
const RADIUS: f64 = 5.0;
/// Distances of viewers from the centre in radii.
const VIEWERS: [f64; 4] = [0.0, 0.3, 0.6, 0.9];
const NEAR: &[f64] = &[0.0, 0.3, 0.6, 0.9];
const NEAR_AND_FAR: &[f64] = &[0.0, 0.3, 0.6, 0.9, 2.0, 10.0, 1e3, 1e6];

const SCREENS: [(&str, &str, &[f64]); 8] = [
    ("sphere", "[dome]\nradius = 5\ntilt = 30\ncoverage = 360\n", NEAR_AND_FAR),
    ("dome of 170°", "[dome]\nradius = 5\ntilt = 60\ncoverage = 170\n", NEAR_AND_FAR),
    (
        "sphere, a part around",
        "[screen]\nshape = \"sphere\"\nradius = 5\ncoverage = 250\nazimuth = [-110, 140]\npitch = -20\n",
        NEAR_AND_FAR,
    ),
    ("ellipsoid", "[screen]\nshape = \"ellipsoid\"\nradii = [5.5, 4.8, 6]\nyaw = 20\n", NEAR_AND_FAR),
    ("cylinder", "[screen]\nshape = \"cylinder\"\nradius = 5\nheights = [-3, 3]\n", NEAR_AND_FAR),
    ("cone", "[screen]\nshape = \"cone\"\nradii = [6, 4.8]\nheights = [-3, 3]\n", NEAR_AND_FAR),
    ("plane", "[screen]\nshape = \"plane\"\nposition = [0, 0, -5]\nsize = [9, 5]\nyaw = 10\n", NEAR_AND_FAR),
    ("mesh", "[screen]\nshape = \"mesh\"\nfile = \"ball.obj\"\nscale = 5\n", NEAR),
];

/// Lenses of projectors. `FOV` is replaced by an opening that the screen fills from the projector's
/// distance.
const LENSES: [(&str, &str, bool); 9] = [
    ("pinhole", "FOV\n", true),
    ("pinhole, shifted", "FOV\nshift = [0.3, -0.4]\n", true),
    ("pinhole, keystone", "FOV\nkeystone = [[-0.8, -1], [0.9, -0.9], [1, 1], [-1, 0.8]]\n", true),
    ("Brown–Conrady", "FOV\ndistortion = { radial = [-0.08, 0.01, 0], tangential = [0.002, -0.001] }\n", true),
    ("fisheye, equidistant", "fisheye = { aperture = 180 }\n", false),
    (
        "fisheye, equisolid, squeezed",
        "fisheye = { projection = \"equisolid\", aperture = 180, size = [1, 1.2] }\n",
        false,
    ),
    ("fisheye, stereographic", "fisheye = { projection = \"stereographic\", aperture = 170 }\n", false),
    ("fisheye, orthographic", "fisheye = { projection = \"orthographic\", aperture = 170 }\n", false),
    (
        "fisheye, measured",
        "fisheye = { projection = \"measured\", aperture = 160, measured = [[20, 0.25], [40, 0.49], [60, 0.72], [85, 1]] }\n",
        false,
    ),
];

/// Pictures of all directions.
const PICTURES: [(&str, &str); 9] = [
    ("domemaster 180°", "kind = \"domemaster\"\naperture = 180\n"),
    ("domemaster 360°", "kind = \"domemaster\"\naperture = 360\n"),
    ("domemaster, equisolid", "kind = \"domemaster\"\nprojection = \"equisolid\"\naperture = 220\n"),
    ("domemaster, stereographic", "kind = \"domemaster\"\nprojection = \"stereographic\"\naperture = 200\n"),
    ("domemaster, orthographic", "kind = \"domemaster\"\nprojection = \"orthographic\"\naperture = 170\n"),
    (
        "domemaster, polynomial",
        "kind = \"domemaster\"\nprojection = \"polynomial\"\ncoefficients = [1, -0.05, 0.002, 0]\naperture = 180\n",
    ),
    ("equirectangular", "kind = \"equirectangular\"\n"),
    ("cylindrical", "kind = \"cylindrical\"\nlatitudes = [-50, 60]\n"),
    ("cubemap", "kind = \"cubemap\"\n"),
];

const MIRROR: &str = "kind = \"projector\"\nposition = [0, -4.3, -2.1]\nyaw = 180\npitch = 24\nfov = [23, 13.5]\n\
                      mirror = { center = [0, -3.1, 1.4], radius = 1.05 }\n";

/// All combinations.
pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for (screen, screen_text, distances) in SCREENS {
        for (lens, output_text, narrow) in LENSES {
            // Most rays of a wide picture would miss a distant screen.
            let distances = if narrow { distances } else { NEAR };
            rows.push(Row { screen, lens, screen_text, output_text, distances });
        }
        rows.push(Row { screen, lens: "spherical mirror", screen_text, output_text: MIRROR, distances: &[] });
        if screen != "plane" {
            let picture = |(lens, output_text)| Row { screen, lens, screen_text, output_text, distances: &[] };
            rows.extend(PICTURES.map(picture));
        }
    }
    rows
}

impl Row {
    /// The rigs of this combination.
    pub fn cases(&self) -> Vec<Case> {
        let viewer = |part: f64| {
            let [x, y, z] = [0.48, -0.36, 0.8].map(|axis| axis * part * RADIUS);
            format!("{}[viewer]\nposition = [{x:?}, {y:?}, {z:?}]\n[[output]]\n", self.screen_text)
        };
        let placed = |head: &str, distance: f64| {
            let [x, y, z] = [0.08, 0.1, 0.9918].map(|axis: f64| axis * distance * RADIUS);
            let (yaw, pitch) = (-4.0, -5.0);
            let half = if distance > 1.0 { (0.8 / distance).atan().to_degrees() } else { 30.0 };
            let fov = format!("fov = [{:?}, {:?}]", 2.0 * half, 1.1 * half);
            let text = format!(
                "{head}kind = \"projector\"\nposition = [{x:?}, {y:?}, {z:?}]\nyaw = {yaw:?}\npitch = {pitch:?}\n{}",
                self.output_text.replace("FOV", &fov)
            );
            Case { text, outside: distance > 1.0 }
        };
        let of_viewer = |part: f64| -> Vec<Case> {
            let head = viewer(part);
            match self.distances {
                [] => vec![Case { text: head + self.output_text, outside: false }],
                distances => distances.iter().map(|distance| placed(&head, *distance)).collect(),
            }
        };
        VIEWERS.into_iter().flat_map(of_viewer).collect()
    }
}
