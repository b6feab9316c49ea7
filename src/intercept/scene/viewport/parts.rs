//! Parts of the window between the widgets of a toolkit, which pictures of the scene fill.
//!
//! Rectangles count rows in the direction of the API.

use crate::correct::{LowerLeftRect, Size};
use crate::intercept::scene::viewport;
use crate::runtime::session::ClipRows;

/// Greatest number of parts that are kept.
const MOST_PARTS: usize = 8;

/// Large parts of the window that pictures fill, the latest first.
#[derive(Debug, Default)]
pub struct Parts(Vec<LowerLeftRect>);

impl Parts {
    /// Notes that a picture fills a part of the window. Returns whether this is new.
    pub fn note(&mut self, part: LowerLeftRect) -> bool {
        let new = !self.0.contains(&part);
        if new {
            self.0.truncate(MOST_PARTS - 1);
            self.0.insert(0, part);
        }
        new
    }

    /// Returns a part that has the shape of a picture of this size. `None`: no such part is known.
    pub fn of_shape(&self, picture: impl Into<Size>) -> Option<LowerLeftRect> {
        let picture = picture.into();
        let is_like = |part: &&LowerLeftRect| viewport::has_shape(picture, part.size());
        self.0.iter().find(is_like).copied()
    }

    /// Returns the part that a picture of this size may fill: it has the part's shape, and at least
    /// a quarter of its width.
    pub fn of(&self, picture: impl Into<Size>) -> Option<LowerLeftRect> {
        let picture = picture.into();
        let is_like = |part: &&LowerLeftRect| viewport::has_shape_of_window(picture, part.size());
        self.0.iter().find(is_like).copied()
    }

    /// True if a part has this size.
    pub fn any_of_size(&self, wanted: impl Into<Size>) -> bool {
        let wanted = wanted.into();
        self.0.iter().any(|part| part.size() == wanted)
    }

    /// Forgets all parts.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

/// Part of the panel that a viewport covers: scale and offset of clip coordinates to the right and
/// upwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanelPart {
    scale: [f64; 2],
    offset: [f64; 2],
}

impl Default for PanelPart {
    fn default() -> Self {
        Self { scale: [1.0; 2], offset: [0.0; 2] }
    }
}

impl PanelPart {
    /// Returns the part for a viewport in a picture of this size.
    pub fn of(viewport: LowerLeftRect, Size { width, height }: Size) -> Self {
        let LowerLeftRect { x, y, width: across, height: up } = viewport;
        let part = |length: i32, all: i32| f64::from(length) / f64::from(all.max(1));
        let (scale, start) = ([part(across, width), part(up, height)], [part(x, width), part(y, height)]);
        Self { scale, offset: std::array::from_fn(|i| 2.0 * start[i] + scale[i] - 1.0) }
    }

    /// Returns the place of this part of a picture on the panel, where `picture` has the picture.
    pub fn of_picture_at(self, picture: Self) -> Self {
        Self {
            scale: std::array::from_fn(|i| picture.scale[i] * self.scale[i]),
            offset: std::array::from_fn(|i| picture.scale[i] * self.offset[i] + picture.offset[i]),
        }
    }

    /// Returns the reprojection for this part, from that for the whole panel.
    pub fn reprojection(&self, whole: &ClipRows) -> ClipRows {
        let ([across, up], [right, above]) = (self.scale, self.offset);
        let row = |[x, y, w, q]: [f64; 4]| [x * across, y * up, x * right + y * above + w, q];
        ClipRows { x: row(whole.x), y: row(whole.y), w: row(whole.w), ..*whole }
    }
}

/// Number of arms of the cross that finds the borders of a rectangle.
pub const ARMS: usize = 4;

/// The window, or an image that draws fill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width and height.
    pub size: Size,
    /// Samples per pixel, at least 1.
    pub samples: i64,
}

/// Number of pixels that tell whether a draw fills a picture, where samples cannot be counted.
pub const PROBES: usize = 9;

/// How much of a picture a draw fills, by the number of its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filled {
    /// All, or nearly all.
    Whole,
    /// More than half.
    Large,
    /// At most half.
    Small,
}

impl Picture {
    /// Rectangle of the whole picture.
    pub fn whole(&self) -> LowerLeftRect {
        LowerLeftRect::of_size(self.size)
    }

    /// Number of samples.
    fn all(&self) -> i64 {
        self.size.area() * self.samples
    }

    /// Returns how much of the picture a draw of `samples` samples fills.
    pub fn filled(&self, samples: i64) -> Filled {
        let all = self.all();
        match () {
            () if 10 * samples >= 9 * all => Filled::Whole,
            () if 2 * samples > all => Filled::Large,
            () => Filled::Small,
        }
    }

    /// Returns the rectangles of the arms: from the middle to the left, to the right, downwards and
    /// upwards, one pixel wide. A rectangle of more than half of the picture has the middle in it.
    pub fn arms(&self) -> [LowerLeftRect; ARMS] {
        let (Size { width, height }, [x, y]) = (self.size, self.middle());
        [
            LowerLeftRect::new(0, y, x, 1),
            LowerLeftRect::new(x, y, width - x, 1),
            LowerLeftRect::new(x, 0, 1, y),
            LowerLeftRect::new(x, y, 1, height - y),
        ]
    }

    /// Returns pixels at the corners, at the middles of the borders and in the middle. A draw that
    /// reaches all of them is assumed to fill the picture.
    pub fn probes(&self) -> [LowerLeftRect; PROBES] {
        let (Size { width, height }, [x, y]) = (self.size, self.middle());
        let across = [0, x, (width - 1).max(0)];
        let up = [0, y, (height - 1).max(0)];
        std::array::from_fn(|index| LowerLeftRect::new(across[index % 3], up[index / 3], 1, 1))
    }

    fn middle(&self) -> [i32; 2] {
        [self.size.width / 2, self.size.height / 2]
    }

    /// Returns the rectangle that has `arms` samples in the arms. `None`: a draw with `samples`
    /// samples does not fill this rectangle alone.
    pub fn rectangle(&self, arms: [i64; ARMS], samples: i64) -> Option<LowerLeftRect> {
        let [left, right, below, above] = arms.map(|count| (count / self.samples) as i32);
        let [x, y] = self.middle();
        let rect = LowerLeftRect::new(x - left, y - below, left + right, below + above);
        let area = i64::from(rect.width) * i64::from(rect.height) * self.samples;
        // Rounded corners and thin lines may be left out.
        (50 * (area - samples).abs() <= area && 2 * area > self.all()).then_some(rect)
    }
}

#[cfg(test)]
mod tests {
    use super::{ARMS, ClipRows, Filled, LowerLeftRect, PanelPart, Parts, Picture, Size};

    /// Number of samples in each arm of a draw that fills `rect`.
    fn counted(picture: Picture, rect: LowerLeftRect) -> [i64; ARMS] {
        picture.arms().map(|arm| {
            let common = |a: i32, b: i32, from: i32, to: i32| i64::from((b.min(to) - a.max(from)).max(0));
            common(arm.x, arm.x + arm.width, rect.x, rect.x + rect.width)
                * common(arm.y, arm.y + arm.height, rect.y, rect.y + rect.height)
                * picture.samples
        })
    }

    #[test]
    fn a_cross_finds_a_large_rectangle() {
        for (size, samples, rect) in [
            (Size::new(640, 480), 1, LowerLeftRect::new(0, 0, 500, 480)),
            (Size::new(640, 480), 4, LowerLeftRect::new(139, 20, 501, 457)),
            (Size::new(641, 481), 1, LowerLeftRect::new(60, 33, 481, 400)),
            (Size::new(1, 1), 1, LowerLeftRect::new(0, 0, 1, 1)),
            (Size::new(3, 5), 2, LowerLeftRect::new(0, 0, 3, 5)),
        ] {
            let (picture, samples_drawn) = (Picture { size, samples }, rect.size().area() * samples);
            assert_eq!(picture.rectangle(counted(picture, rect), samples_drawn), Some(rect), "{size:?}");
        }
    }

    #[test]
    fn other_shapes_and_small_parts_are_none() {
        let picture = Picture { size: Size::new(100, 100), samples: 1 };
        let rect = LowerLeftRect::new(10, 10, 80, 80);
        // A disc of that width, and a frame without its middle.
        for samples in [5027, 3000] {
            assert_eq!(picture.rectangle(counted(picture, rect), samples), None);
        }
        assert_eq!(picture.rectangle([0; ARMS], 6400), None);
        let half = LowerLeftRect::new(0, 0, 50, 100);
        assert_eq!(picture.rectangle(counted(picture, half), 5000), None);
    }

    #[test]
    fn samples_tell_how_much_is_filled() {
        let picture = Picture { size: Size::new(10, 10), samples: 4 };
        assert_eq!(
            [360, 359, 201, 200].map(|samples| picture.filled(samples)),
            [Filled::Whole, Filled::Large, Filled::Large, Filled::Small]
        );
    }

    #[test]
    fn parts_are_found_by_shape() {
        let (mut parts, part) = (Parts::default(), LowerLeftRect::new(32, 32, 224, 192));
        assert!(parts.note(part) && !parts.note(part));
        assert_eq!([(224, 192), (112, 96)].map(|size: (u32, u32)| parts.of(size)), [Some(part); 2]);
        assert_eq!(parts.of_shape((28, 24)), Some(part));
        assert_eq!((parts.of((28, 24)), parts.of((256, 192))), (None, None), "too small, and another shape");
        assert!(parts.any_of_size((224, 192)) && !parts.any_of_size((112, 96)));
        for x in 0..20 {
            parts.note(LowerLeftRect::new(x, 0, 300, 100));
        }
        assert_eq!((parts.of((224, 192)), parts.of((300, 100)).map(|part| part.x)), (None, Some(19)));
    }

    #[test]
    fn the_corners_of_a_viewport_are_those_of_its_part() {
        let row = |at: usize| std::array::from_fn(|i| if i == at { 1.0 } else { 0.0 });
        let whole = ClipRows { x: row(0), y: row(1), w: row(2), e: 0.0, curved: false, depth: [0.5, 0.0] };
        let part = PanelPart::of(LowerLeftRect::new(100, 0, 100, 50), Size::new(400, 200)).reprojection(&whole);
        let at = |row: [f64; 4], [x, y]: [f64; 2]| row[0] * x + row[1] * y + row[2];
        for (corner, expected) in [([-1.0, -1.0], [-0.5, -1.0]), ([1.0, 1.0], [0.0, -0.5])] {
            assert_eq!([at(part.x, corner), at(part.y, corner), at(part.w, corner)], [expected[0], expected[1], 1.0]);
        }
    }
}
