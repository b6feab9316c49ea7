//! Viewports within an image. If a frame draws to a single small one, it may be all of the picture:
//! programs with a dynamic resolution draw to a part of an image. Several small ones are pictures
//! side by side.

use crate::correct::LowerLeftRect;

/// Viewports of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Seen {
    #[default]
    None,
    One(LowerLeftRect),
    Several,
}

/// Viewports of an image, in this frame and in the last one that drew to it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Viewports {
    frame: u64,
    now: Seen,
    before: Seen,
}

impl Viewports {
    /// Notes a viewport that is drawn to in the frame with this number.
    pub fn note(&mut self, viewport: LowerLeftRect, frame: u64) {
        if self.frame != frame {
            *self = Self { frame, now: Seen::None, before: self.now };
        }
        self.now = match self.now {
            Seen::None => Seen::One(viewport),
            Seen::One(known) if known == viewport => Seen::One(known),
            _ => Seen::Several,
        };
    }

    /// True if this frame or the last one has several viewports.
    pub fn are_several(&self) -> bool {
        self.now == Seen::Several || self.before == Seen::Several
    }

    /// True if all drawing of the last frame was to one viewport with the corner of this one, and that
    /// of this frame is.
    pub fn are_only(&self, viewport: LowerLeftRect) -> bool {
        let same_corner = |seen| matches!(seen, Seen::One(known) if (known.x, known.y) == (viewport.x, viewport.y));
        same_corner(self.before) && (self.now == Seen::None || same_corner(self.now))
    }

    /// True if nothing is known of the last frame.
    pub fn are_unknown(&self) -> bool {
        self.before == Seen::None
    }
}

#[cfg(test)]
mod tests {
    use super::Viewports;
    use crate::correct::LowerLeftRect;

    #[test]
    fn one_viewport_is_known_from_the_second_frame_on() {
        let part = |width| LowerLeftRect::new(0, 0, width, width / 2);
        let mut viewports = Viewports::default();
        for frame in 1..5 {
            viewports.note(part(100 + frame), frame as u64);
            viewports.note(part(100 + frame), frame as u64);
            assert_eq!(viewports.are_only(part(100 + frame)), frame > 1, "it may have another size in each frame");
            assert!(!viewports.are_several() && viewports.are_unknown() == (frame == 1));
        }
        assert!(!viewports.are_only(LowerLeftRect::new(100, 0, 100, 50)));
    }

    #[test]
    fn several_viewports_stay_several_for_a_frame() {
        let parts = [0, 50].map(|x| LowerLeftRect::new(x, 0, 50, 50));
        let mut viewports = Viewports::default();
        parts.iter().for_each(|part| viewports.note(*part, 1));
        assert!(viewports.are_several());
        viewports.note(parts[0], 2);
        assert!(viewports.are_several() && !viewports.are_only(parts[0]));
        viewports.note(parts[0], 3);
        assert!(!viewports.are_several() && viewports.are_only(parts[0]));
    }
}
