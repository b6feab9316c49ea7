//! Viewports of a window: their places, files and eyes.

use super::MOST;
use super::key::Key;
use super::projection::{Projection, projection};
use crate::error::Result;
use crate::formats::reading::input::MOST_PIXELS_TOGETHER;
use glam::DVec3;

/// Greatest width and height of a viewport, pixels: the greatest texture of today's graphics
/// hardware.
const LARGEST: f64 = 16384.0;

/// A part of a window.
#[derive(Clone, Debug, PartialEq)]
pub struct Viewport {
    /// Rectangle on the desktop: x, y, width, height in pixels from the top left.
    pub place: [i64; 4],
    /// Content.
    pub projection: Projection,
    /// File of its warp mesh.
    pub mesh: Option<String>,
    /// File of its blend mask.
    pub mask: Option<String>,
    /// Eye to which it belongs, if it is for one eye.
    pub eye: Option<Eye>,
    /// Mirroring along x and along y: the picture and the mask are mirrored, the mesh samples
    /// mirrored places.
    pub mirrored: [bool; 2],
}

/// An eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Eye {
    /// Left eye.
    Left,
    /// Right eye.
    Right,
}

/// Reads the viewports of a window with their parts of it, after `before` others of the computer;
/// `pixels` counts the pixels of all. Remarks for the user are added to `notes`.
pub(super) fn viewports_of(
    window: &Key,
    viewer: DVec3,
    before: usize,
    pixels: &mut u64,
    notes: &mut Vec<String>,
) -> Result<Vec<(Part, Viewport)>> {
    let position = window.optional("pos").map_or(Ok([0.0; 2]), |position| position.pair())?;
    let size = window.required("size")?.pair()?;
    let mut viewports = Vec::new();
    for key in window.list("viewports")? {
        let part = part(&key)?;
        let projection = projection(&key.required("projection")?, viewer, notes)?;
        let viewport = viewport(&key, part, position, size, projection)?;
        let [_, _, width, height] = viewport.place;
        viewports.push((part, viewport));
        *pixels += width.unsigned_abs() * height.unsigned_abs();
        if before + viewports.len() > MOST || *pixels > MOST_PIXELS_TOGETHER {
            let most = format!("at most {MOST} for a computer, with {MOST_PIXELS_TOGETHER} pixels altogether");
            return Err(key.wrong(format!("is one viewport too many; expected {most}")));
        }
    }
    Ok(viewports)
}

/// Viewports of a mirrored window: each shows the picture at its mirrored place.
pub(super) fn mirrored_viewports(
    window: &Key,
    of_window: &[(Part, Viewport)],
    mirrored: [bool; 2],
    notes: &mut Vec<String>,
) -> Vec<Viewport> {
    let mut viewports = Vec::new();
    for (number, (part, viewport)) in of_window.iter().enumerate() {
        let there = part.mirrored(mirrored);
        match of_window.iter().find(|(other, _)| other.is_at(&there)) {
            Some((_, shown)) => viewports.push(Viewport {
                projection: shown.projection.clone(),
                eye: shown.eye,
                mirrored,
                ..viewport.clone()
            }),
            None => notes.push(format!(
                "{}: {}.viewports[{number}] is left out: no viewport lies at its place in the mirrored window",
                window.name, window.path
            )),
        }
    }
    viewports
}

/// A part of a window, 0…1 from its bottom left.
#[derive(Clone, Copy)]
pub(super) struct Part {
    low: [f64; 2],
    size: [f64; 2],
}

impl Part {
    fn mirrored(&self, along: [bool; 2]) -> Self {
        let low = |k: usize| if along[k] { 1.0 - self.low[k] - self.size[k] } else { self.low[k] };
        Self { low: [low(0), low(1)], size: self.size }
    }

    /// True if both are at the same place, within the precision of thirds as people write them.
    fn is_at(&self, other: &Self) -> bool {
        (0..2).all(|k| (self.low[k] - other.low[k]).abs() < 1e-3 && (self.size[k] - other.size[k]).abs() < 1e-3)
    }
}

/// Reads the rectangle of a viewport in its window.
fn part(key: &Key) -> Result<Part> {
    let low = key.optional("pos").map_or(Ok([0.0; 2]), |key| key.pair())?;
    let size = key.optional("size").map_or(Ok([1.0; 2]), |key| key.pair())?;
    Ok(Part { low, size })
}

/// Reads a viewport of a window at `position` with `size` pixels.
fn viewport(
    key: &Key,
    Part { low, size: part }: Part,
    position: [f64; 2],
    size: [f64; 2],
    projection: Projection,
) -> Result<Viewport> {
    let width = (part[0] * size[0]).round();
    let height = (part[1] * size[1]).round();
    let left = position[0] + (low[0] * size[0]).round();
    // Parts of a window count from its bottom, windows from the desktop's top.
    let top = position[1] + size[1] - (low[1] * size[1]).round() - height;
    let pixels = [left, top, width, height];
    let sized = |side: f64| (1.0..=LARGEST).contains(&side);
    if !(sized(width) && sized(height) && pixels.iter().all(|number| number.abs() <= 1e6)) {
        return Err(key.wrong("has a place that no screen has"));
    }
    let file = |what| key.optional(what).map(|file| file.text()).transpose();
    let eye = match file("eye")?.as_deref() {
        Some("left") => Some(Eye::Left),
        Some("right") => Some(Eye::Right),
        _ => None,
    };
    Ok(Viewport {
        place: pixels.map(|number| number as i64),
        projection,
        mesh: file("mesh")?,
        mask: file("blendmask")?,
        eye,
        mirrored: [false; 2],
    })
}
