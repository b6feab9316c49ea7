//! A program's window as an already projected picture: its kinds, and the one-line form of the
//! command line and the environment.

use crate::error::{Error, ErrorKind, Result};
use crate::geom::{ContentMap, ContentPicture, Panorama, Region, pose};
use crate::rig::reading::problems::Problems;
use crate::rig::{Method, OutputKind, Rig, schema, validate};
use glam::{DVec2, DVec3};
use std::borrow::Cow;

/// Picture that the program's window shows, if it is not drawn in views.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Content {
    /// Kind of the picture.
    pub kind: ContentKind,
    /// Direction of its middle relative to the viewer, radians: right-positive, up-positive,
    /// clockwise-positive.
    pub angles: [f64; 3],
    /// Part of the window that it fills; `None` = the largest centred part of its shape.
    pub region: Option<Region>,
    /// Arrangement of the pictures of two eyes in it.
    pub stereo: Stereo,
}

/// Kinds of already projected pictures.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum ContentKind {
    /// Directions from the dome's centre.
    Directions(Panorama),
    /// A plane in front of the viewer.
    Flat {
        /// Angle of its width, radians, 0 < width < π.
        width: f64,
    },
}

/// Arrangement of the pictures of two eyes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub enum Stereo {
    /// One picture for both.
    #[default]
    None,
    /// The left eye's picture is the left half.
    SideBySide,
    /// The left eye's picture is the upper half.
    TopBottom,
}

impl Stereo {
    /// Words of rig files.
    pub(in crate::rig) const WORDS: [(&'static str, Self); 3] =
        [("none", Self::None), ("side-by-side", Self::SideBySide), ("top-bottom", Self::TopBottom)];

    /// Word in rig files.
    pub fn word(self) -> &'static str {
        Self::WORDS.iter().find(|(_, stereo)| *stereo == self).map_or("none", |(word, _)| word)
    }

    /// Part of the picture for an eye, and the number of pictures across and above each other. An
    /// eye in the middle gets the left or upper one.
    fn part(self, eye: f64) -> (Region, DVec2) {
        let right = if eye > 0.0 { 0.5 } else { 0.0 };
        let half = |x, y, size| (Region { origin: DVec2::new(x, y), size: 1.0 / size }, size);
        match self {
            Self::None => (Region::WHOLE, DVec2::ONE),
            Self::SideBySide => half(right, 0.0, DVec2::new(2.0, 1.0)),
            Self::TopBottom => half(0.0, 0.5 - right, DVec2::new(1.0, 2.0)),
        }
    }
}

impl Content {
    /// Makes the map into a window of this size in pixels, for an eye at `eye` metres to the right
    /// of the viewer.
    fn map(&self, window: (u32, u32), eye: f64) -> ContentMap {
        let pixels = DVec2::new(f64::from(window.0.max(1)), f64::from(window.1.max(1)));
        let window = pixels.x / pixels.y;
        let (part, pictures) = self.stereo.part(eye);
        let picture = |half| match &self.kind {
            ContentKind::Directions(panorama) => ContentPicture::Directions(panorama.clone()),
            ContentKind::Flat { .. } => ContentPicture::Flat { half },
        };
        let aspect = picture(DVec2::ONE).aspect().map(|aspect| aspect * pictures.x / pictures.y);
        let fitting = || aspect.map_or(Region::WHOLE, |aspect| Region::fitting(aspect, window));
        let region = self.region.unwrap_or_else(fitting).part(&part).of_whole_pixels(pixels);
        let half = match self.kind {
            ContentKind::Flat { width } => {
                let half = (0.5 * width).tan();
                DVec2::new(half, half * region.size.y / (region.size.x * window))
            }
            ContentKind::Directions(_) => DVec2::ONE,
        };
        let [yaw, pitch, roll] = self.angles;
        ContentMap { picture: picture(half), rotation: pose::rotation(yaw, pitch, roll).transpose(), region }
    }
}

impl Rig {
    /// Map from directions to places of the program's window for output `index`, in a window of
    /// this size in pixels. `None` if the program's picture is drawn in views. Directions are those
    /// of [`Self::around_content`].
    pub fn content_map(&self, index: usize, window: (u32, u32)) -> Option<ContentMap> {
        let eye = self.outputs.get(index).map_or(0.0, |output| output.eye);
        self.content.as_ref().map(|content| content.map(window, eye))
    }

    /// Rig whose viewer sees content correctly. Pictures of directions are seen from the dome's
    /// centre, whatever the viewer's position, and are sampled as they are.
    pub fn around_content(&self) -> Cow<'_, Self> {
        let Some(content) = &self.content else { return Cow::Borrowed(self) };
        let mut rig = self.with_views_for(Method::projects_vertices);
        rig.views.quality = 1.0;
        rig.outputs.iter_mut().for_each(|output| output.eye = 0.0);
        if matches!(content.kind, ContentKind::Directions(_)) {
            rig.viewer.position = DVec3::ZERO;
        }
        Cow::Owned(rig)
    }

    /// Returns the same rig with the content of `text`, in the form
    /// `domemaster,aperture=200,stereo=side-by-side`: the kind, then keys of a rig file's
    /// `[content]`, degrees. `none` removes the content.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for unknown kinds and keys, for values that are missing,
    /// unreadable or out of range, and for rigs that cannot show content.
    pub fn with_content_override(&self, text: &str) -> Result<Self> {
        if text.trim() == "none" {
            return Ok(Self { content: None, ..self.clone() });
        }
        let wrong = |why: String| Error::new(ErrorKind::InvalidArgument, format!("content {text:?}: {why}"));
        let toml = toml_of(text).map_err(wrong)?;
        let mut problems = Problems::new(&toml);
        let content = schema::content(&toml, &self.dome, &mut problems);
        let rig = Self { content, ..self.clone() };
        if problems.is_empty() {
            validate::check(&rig, &mut problems);
        }
        if problems.is_empty() { Ok(rig) } else { Err(wrong(problems.reasons())) }
    }

    /// Returns the reason why an output of this kind cannot show content; `None` if it can.
    pub(in crate::rig) fn refuses_content(kind: &OutputKind) -> Option<&'static str> {
        let own_lens = matches!(kind, OutputKind::Perspective { frustum: None, .. });
        own_lens
            .then_some("has the program's own lens, so it cannot show [content]; expected fov = [horizontal, vertical]")
    }
}

/// Converts `kind,key=1,2,key=word` to a TOML table `content`.
fn toml_of(text: &str) -> std::result::Result<String, String> {
    let mut parts = text.split(',').map(str::trim);
    let kind = parts.next().unwrap_or_default();
    let mut entries = vec![("kind", vec![kind])];
    for part in parts {
        match (part.split_once('='), entries.last_mut()) {
            (Some((key, value)), _) => entries.push((key.trim(), vec![value.trim()])),
            (None, Some((_, values))) if values[0] != kind => values.push(part),
            _ => return Err(format!("{part:?} has no key before it; expected for example domemaster,aperture=180")),
        }
    }
    let is_name = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c));
    let value = |text: &str| match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(format!("{number:?}")),
        _ if is_name(text) => Ok(format!("\"{text}\"")),
        _ => Err(format!("{text:?} is neither a number nor a word")),
    };
    let mut toml = String::from("[content]\n");
    for (key, values) in entries {
        if !is_name(key) {
            return Err(format!("{key:?} is not a key"));
        }
        let values: Vec<String> = values.into_iter().map(value).collect::<std::result::Result<_, _>>()?;
        let values = if values.len() == 1 { values.concat() } else { format!("[{}]", values.join(", ")) };
        toml.push_str(&format!("{key} = {values}\n"));
    }
    Ok(toml)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Projection;

    fn region(x: f64, y: f64, width: f64, height: f64) -> Region {
        Region { origin: DVec2::new(x, y), size: DVec2::new(width, height) }
    }

    #[test]
    fn content_is_read_from_one_line() {
        let rig = crate::rig::load("planetarium-6").expect("a preset");
        let content = |text: &str| rig.with_content_override(text).expect(text).content.expect("content");
        // The dome's own aperture and tilt, as for an output.
        let plain = content("domemaster");
        let ContentKind::Directions(Panorama::Fisheye(lens)) = &plain.kind else { panic!("{plain:?}") };
        assert_eq!((lens.aperture, &lens.projection), (rig.dome.coverage, &Projection::Equidistant));
        assert!((plain.angles[1] - (std::f64::consts::FRAC_PI_2 - rig.dome.tilt)).abs() < 1e-15);
        let more = content("domemaster, aperture=200, projection=equisolid, tilt=10, stereo=top-bottom");
        assert_eq!((more.stereo, more.angles[1].to_degrees().round()), (Stereo::TopBottom, 80.0));
        let placed = content("equirectangular,region=0.1,0.2,0.5,0.6,yaw=-90");
        // From the top left to the bottom left.
        let expected = region(0.1, 1.0 - 0.2 - 0.6, 0.5, 0.6);
        assert!(placed.region.is_some_and(|found| found.origin.distance(expected.origin) < 1e-15), "{placed:?}");
        assert_eq!(content("flat,width=90").kind, ContentKind::Flat { width: std::f64::consts::FRAC_PI_2 });
        let back = rig.with_content_override("domemaster").expect("content").with_content_override("none");
        assert_eq!(back.expect("none"), rig);
        for (wrong, why) in [
            ("fisheye", "is not one of"),
            ("", "neither a number nor a word"),
            ("domemaster,180", "has no key before it"),
            ("domemaster,apertura=180", "aperture"),
            ("domemaster,aperture=400", "out of range"),
            ("cubemap,aperture=180", "domemaster"),
            ("equirectangular,region=0.5,0,0.6,1", "region"),
            ("domemaster,projection=measured", "measured"),
            ("flat,width=nan", "not a number"),
            ("flat,wi dth=3", "not a key"),
        ] {
            let refused = rig.with_content_override(wrong).expect_err(wrong);
            assert_eq!(refused.kind, ErrorKind::InvalidArgument);
            assert!(refused.message.contains(why), "{}", refused.message);
        }
        let own_lens = crate::rig::load("identity-captured").expect("a preset");
        assert!(own_lens.with_content_override("domemaster").is_err_and(|e| e.message.contains("program's own lens")));
    }

    #[test]
    fn each_eye_has_its_half() {
        let rig = crate::rig::load("fisheye").expect("a preset");
        let map = |text: &str, window, eye| {
            let mut rig = rig.with_content_override(text).expect(text);
            rig.outputs[0].eye = eye;
            rig.content_map(0, window).expect("content").region
        };
        assert_eq!(map("domemaster", (400, 200), 0.0), region(0.25, 0.0, 0.5, 1.0));
        let side = "domemaster,stereo=side-by-side";
        assert_eq!(map(side, (400, 200), -0.03), region(0.0, 0.0, 0.5, 1.0));
        assert_eq!(map(side, (400, 200), 0.03), region(0.5, 0.0, 0.5, 1.0));
        assert_eq!(map(side, (400, 200), 0.0), map(side, (400, 200), -0.03));
        let stacked = "equirectangular,stereo=top-bottom";
        assert_eq!(map(stacked, (200, 200), -0.03), region(0.0, 0.5, 1.0, 0.5));
        assert_eq!(map(stacked, (200, 200), 0.03), region(0.0, 0.0, 1.0, 0.5));
    }
}
