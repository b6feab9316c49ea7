//! The description: its regions, and the files of each.

use super::archive::LONGEST_DESCRIPTION;
use super::extension::Described;
use super::{Dome, Profile};
use crate::error::{Error, Result};
use crate::formats::camera::Camera;
use crate::formats::mpcdi::extension;
use crate::formats::reading::input::{checked_size, invalid};
use crate::formats::reading::text::shown;
use crate::geom::{Frustum, Lens, Optics, Pose, pose};
use glam::{DMat3, DVec3};
use roxmltree::{Document, Node, ParsingOptions};

/// Greatest number of nodes of the description.
const MOST_NODES: u32 = 100_000;
/// Greatest number of regions.
const MOST_REGIONS: usize = 256;
/// Greatest number of attributes of an element. The parser compares each with all before it.
const MOST_ATTRIBUTES: usize = 256;
/// Greatest number of namespaces. The parser gives each element a list of the valid ones.
const MOST_NAMESPACES: usize = 64;

/// Content of the description.
pub(super) struct Description {
    pub(super) profile: Profile,
    pub(super) regions: Vec<DescribedRegion>,
    pub(super) dome: Option<Dome>,
    pub(super) notes: Vec<String>,
}

/// A region and the names of its files.
pub(super) struct DescribedRegion {
    pub(super) id: String,
    pub(super) size: (u32, u32),
    /// Values x, y, width and height in the whole picture, 0…1 from the bottom left.
    pub(super) place: [f64; 4],
    /// Name of the warp file; `None` if the file describes only the projector.
    pub(super) warp: Option<String>,
    /// Name of the file of weights, and its gamma.
    pub(super) alpha: Option<(String, f64)>,
    /// Name of the file of black levels.
    pub(super) beta: Option<String>,
    pub(super) camera: Option<Camera>,
    /// A projector with a fisheye lens.
    pub(super) fisheye: Option<Optics>,
    /// True if it has a lens that is not understood.
    pub(super) unclear: bool,
    /// Rotation from the axes of the frame (x right, y up, z backward) to those of the file.
    pub(super) axes: DMat3,
}

/// Greatest angle of a side of a frustum, degrees.
const WIDEST: f64 = 89.5;

/// Reads the description `text` of the archive `name`; `file` is the description's own name, for
/// messages with a line.
pub(super) fn read(name: &str, file: &str, text: &str) -> Result<Description> {
    bounded(name, text)?;
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text.trim_start_matches('\u{feff}'), options)
        .map_err(|error| invalid(name, format!("the description is not XML: {error}")))?;
    let reader = Reader { name, file, document: &document };
    let root = document.root_element();
    if root.tag_name().name() != "MPCDI" {
        let what = match root.tag_name().name() {
            "Cluster" => "is a configuration of an old SGCT; convert it to JSON with SGCT's own converter first",
            _ => "is no description; expected <MPCDI>",
        };
        return Err(reader.wrong(root, what));
    }
    let word = reader.attribute(root, "profile")?;
    let profile = Profile::ALL.into_iter().find(|profile| profile.word().eq_ignore_ascii_case(word));
    let profile =
        profile.ok_or_else(|| reader.wrong(root, format!("profile {} is not one of 2d, 3d, a3, sl", shown(word))))?;
    let version = reader.attribute(root, "version")?;
    if !["1", "2"].contains(&version.split('.').next().unwrap_or_default()) {
        return Err(reader.wrong(root, format!("version {}; expected 1.0 or 2.0", shown(version))));
    }
    let count = named(root, "region").take(4 * MOST_REGIONS).count();
    if count >= 4 * MOST_REGIONS {
        return Err(reader.wrong(root, format!("has {count} regions or more; expected 1 to {MOST_REGIONS}")));
    }
    let (mut regions, mut notes) = (Vec::new(), Vec::new());
    for region in named(root, "region").filter(|region| region.ancestors().any(|a| a.tag_name().name() == "display")) {
        let region = reader.region(root, region, profile, &mut notes)?;
        if region.warp.is_none() && region.camera.is_none() && region.fisheye.is_none() {
            notes.push(format!(
                "{name}: region {} is left out: neither a map nor a lens of it is known",
                shown(&region.id)
            ));
        }
        regions.push(region);
    }
    if regions.is_empty() || regions.len() > MOST_REGIONS {
        let why = format!("has {} regions; expected 1 to {MOST_REGIONS}", regions.len());
        return Err(reader.wrong(root, why));
    }
    let mut dome = None;
    for extension in named(root, "extension") {
        let called = reader.attribute(extension, "Name").unwrap_or_default();
        if called == extension::DOME {
            dome = Some(extension::dome(&reader, extension)?);
        } else if called != extension::NAME {
            notes.push(format!("{name}: the extension {} was not taken over", shown(called)));
        }
    }
    regions.retain(|region| region.warp.is_some() || region.camera.is_some() || region.fisheye.is_some());
    if regions.is_empty() {
        return Err(invalid(name, notes.join("; ")));
    }
    Ok(Description { profile, regions, dome, notes })
}

/// Refuses texts that would take the parser long, before they are parsed.
fn bounded(name: &str, text: &str) -> Result<()> {
    let refused = |what: String| Err(invalid(name, format!("the description has {what}")));
    if text.len() as u64 > LONGEST_DESCRIPTION {
        return refused(format!("{} bytes; expected at most {LONGEST_DESCRIPTION}", text.len()));
    }
    // No element begins within the attributes of another.
    let quotes = |part: &str| part.bytes().filter(|byte| matches!(byte, b'"' | b'\'')).count();
    if text.split('<').any(|part| quotes(part) > 2 * MOST_ATTRIBUTES) {
        return refused(format!("an element with too many attributes; expected at most {MOST_ATTRIBUTES}"));
    }
    if text.matches("xmlns").count() > MOST_NAMESPACES {
        return refused(format!("too many namespaces; expected at most {MOST_NAMESPACES}"));
    }
    Ok(())
}

/// All elements called `name` below `node`.
pub(super) fn named<'a, 'input, 'n>(
    node: Node<'a, 'input>,
    name: &'n str,
) -> impl Iterator<Item = Node<'a, 'input>> + use<'a, 'input, 'n> {
    node.descendants().filter(move |node| node.is_element() && node.tag_name().name().eq_ignore_ascii_case(name))
}

/// Document, and methods that read its values.
pub(super) struct Reader<'a, 'input> {
    pub(super) name: &'a str,
    file: &'a str,
    document: &'a Document<'input>,
}

impl Reader<'_, '_> {
    /// Error of an element, with its line.
    pub(super) fn wrong(&self, node: Node, why: impl std::fmt::Display) -> Error {
        let line = self.document.text_pos_at(node.range().start).row;
        invalid(&format!("{}:{line}", self.file), format!("<{}> {why}", node.tag_name().name()))
    }

    /// Value of an attribute; its case is ignored.
    pub(super) fn attribute<'n>(&self, node: Node<'n, '_>, name: &str) -> Result<&'n str> {
        let found = node.attributes().find(|attribute| attribute.name().eq_ignore_ascii_case(name));
        found.map(|attribute| attribute.value().trim()).ok_or_else(|| self.wrong(node, format!("has no {name}")))
    }

    /// Number in an attribute.
    fn number(&self, node: Node, name: &str) -> Result<f64> {
        let word = self.attribute(node, name)?;
        let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| self.wrong(node, format!("{name} = {} is no number", shown(word))))
    }

    /// Text of the first element called `name` below `node`.
    pub(super) fn text<'n>(&self, node: Node<'n, '_>, name: &str) -> Option<&'n str> {
        named(node, name).next().and_then(|node| node.text()).map(str::trim).filter(|text| !text.is_empty())
    }

    fn region(&self, root: Node, region: Node, profile: Profile, notes: &mut Vec<String>) -> Result<DescribedRegion> {
        let id = self.attribute(region, "id")?;
        let pixels = |name: &str| {
            let word = self.attribute(region, name)?;
            word.parse::<u64>()
                .map_err(|_| self.wrong(region, format!("{name} = {} is not a number of pixels", shown(word))))
        };
        let size = checked_size(self.name, pixels("Xresolution")?, pixels("Yresolution")?)?;
        let mut place = [0.0; 4];
        for (value, name) in place.iter_mut().zip(["x", "y", "xsize", "ysize"]) {
            *value = self.number(region, name)?;
        }
        let files = named(root, "fileset").find(|set| self.attribute(*set, "region").is_ok_and(|of| of == id));
        let files = files.ok_or_else(|| self.wrong(region, format!("{} has no fileset", shown(id))))?;
        let warp = named(files, "geometryWarpFile").next();
        let warp = warp.and_then(|warp| self.text(warp, "path"));
        // Programs that send maps directly to the projectors describe only the projectors'
        // positions.
        if warp.is_none() && profile != Profile::ShaderLamps {
            return Err(self.wrong(files, "has no geometryWarpFile with a path"));
        }
        let alpha = match named(files, "alphaMap").next() {
            Some(map) if warp.is_some() || self.text(map, "path").is_some() => {
                let path = self.text(map, "path").ok_or_else(|| self.wrong(map, "has no path"))?.to_owned();
                let gamma = self.text(map, "gammaEmbedded").map_or(Ok(1.0), str::parse::<f64>);
                let gamma = gamma.ok().filter(|gamma| (0.1..=10.0).contains(gamma));
                Some((path, gamma.ok_or_else(|| self.wrong(map, "gammaEmbedded is not within 0.1 to 10"))?))
            }
            _ => None,
        };
        let beta = match named(files, "betaMap").next() {
            Some(map) => Some(self.text(map, "path").ok_or_else(|| self.wrong(map, "has no path"))?.to_owned()),
            None => None,
        };
        let frame = named(region, "coordinateFrame").next().or_else(|| named(files, "coordinateFrame").next());
        let frustum = named(region, "frustum").next();
        let (offset, axes) = frame.map_or(Ok((DVec3::ZERO, DMat3::IDENTITY)), |frame| self.frame(frame))?;
        let lens = match profile {
            Profile::ShaderLamps => extension::lens(self, root, id, size, notes)?,
            _ => Described::Plain,
        };
        let unclear = matches!(lens, Described::Unclear);
        let (mut camera, mut fisheye) = (None, None);
        match (frustum, lens) {
            (Some(frustum), Described::Plain) => {
                let (rotation, frustum) = (self.turn(frustum)?, self.opening(frustum)?);
                camera = Some(Camera { offset, rotation, frustum });
            }
            // The angles of a plane have no meaning there, and their values are arbitrary.
            (Some(frustum), Described::Fisheye(lens, circle)) => {
                let pose = Pose { position: offset, rotation: self.turn(frustum)? };
                fisheye = Some(Optics { pose, lens: Lens::Fisheye { lens, circle }, mirror: None });
            }
            (None, _) | (_, Described::Unclear) => {}
        }
        let warp = warp.map(str::to_owned);
        Ok(DescribedRegion { id: id.to_owned(), size, place, warp, alpha, beta, camera, fisheye, unclear, axes })
    }

    /// Angle of a frustum, degrees.
    fn angle(&self, element: Node, name: &'static str) -> Result<f64> {
        let word = self.text(element, name).ok_or_else(|| self.wrong(element, format!("has no {name}")))?;
        let number = word.parse::<f64>().ok().filter(|number| number.abs() <= 360.0);
        number.ok_or_else(|| self.wrong(element, format!("{name} = {} is no angle", shown(word))))
    }

    /// Rotation of a frustum within its frame.
    fn turn(&self, element: Node) -> Result<DMat3> {
        let radians = |name| Ok::<_, Error>(self.angle(element, name)?.to_radians());
        Ok(pose::rotation(radians("yaw")?, radians("pitch")?, radians("roll")?))
    }

    /// Opening of a frustum.
    fn opening(&self, element: Node) -> Result<Frustum> {
        let side = |name| self.angle(element, name);
        let sides = [side("leftAngle")?, side("rightAngle")?, side("downAngle")?, side("upAngle")?];
        let [left, right, bottom, top] = sides;
        if !(left < right && bottom < top && sides.iter().all(|side| side.abs() <= WIDEST)) {
            return Err(self.wrong(
                element,
                format!("opens from {left}° to {right}° and from {bottom}° to {top}°; expected angles within ±{WIDEST}, left and down below right and up"),
            ));
        }
        let [left, right, bottom, top] = sides.map(|side| side.to_radians().tan());
        Ok(Frustum { left, right, bottom, top })
    }

    /// Position and axes of a frame: its pitch axis points to the right, its yaw axis down, its
    /// roll axis forward. The position is along these axes; the rotation leads from them to the
    /// axes of the file.
    fn frame(&self, element: Node) -> Result<(DVec3, DMat3)> {
        let vector = |prefix: &str| {
            let part = |axis: &str| {
                let name = format!("{prefix}{axis}");
                let word = self.text(element, &name).unwrap_or_default();
                let number = word.parse::<f64>().ok().filter(|number| number.abs() <= 1e9);
                number.ok_or_else(|| self.wrong(element, format!("{name} = {} is no number", shown(word))))
            };
            Ok::<_, Error>(DVec3::new(part("x")?, part("y")?, part("z")?))
        };
        let (right, down, forward) = (vector("pitch")?, vector("yaw")?, vector("roll")?);
        let axes = DMat3::from_cols(right, -down, -forward);
        if !(axes.transpose() * axes).abs_diff_eq(DMat3::IDENTITY, 1e-3) || axes.determinant() < 0.0 {
            return Err(self.wrong(element, "its axes are not of length 1 and at right angles to each other"));
        }
        Ok((axes.transpose() * vector("pos")?, axes))
    }
}
