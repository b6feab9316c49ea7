//! Full clears: a framebuffer that shows only outputs is cleared before they are drawn.
//!
//! A full clear is the cheapest way to make pixels black. Hardware only records it. llvmpipe takes
//! 0.4 ns per pixel; a rectangle takes 1.2 ns, and a clear with a scissor that excludes pixels
//! takes 2 ns.

use crate::backend::gl::objects::target::Target;
use crate::correct::apart;

/// Black part of a framebuffer from which a full clear pays. If less is black, rectangles fill it,
/// since a clear also writes the other pixels.
const WORTHWHILE: f64 = 0.2;

/// The framebuffer that outputs share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::backend::gl) struct FullClear {
    /// The framebuffer's name.
    framebuffer: u32,
    /// True if the outputs cover the framebuffer.
    covered: bool,
    /// True if much of the outputs is always black.
    dark: bool,
}

impl FullClear {
    /// Returns the full clear for the framebuffer of `targets`, of `size` pixels. `black`: the part
    /// of each output that is black whatever the views show. `None` if one clear cannot serve all
    /// outputs: they overlap, or have several framebuffers.
    pub fn of(targets: &[Target], size: (u32, u32), black: impl Iterator<Item = f64>) -> Option<Self> {
        let framebuffer = targets.first()?.framebuffer;
        let together = targets.iter().all(|target| target.framebuffer == framebuffer);
        if !together || !apart(targets, |one, other| one.viewport.meets(other.viewport)) {
            return None;
        }
        let area = |target: &Target| f64::from(target.viewport.width) * f64::from(target.viewport.height);
        let all = f64::from(size.0) * f64::from(size.1);
        let shown: f64 = targets.iter().map(area).sum();
        let filled: f64 = targets.iter().zip(black).map(|(target, part)| area(target) * part).sum();
        Some(Self { framebuffer, covered: shown >= all, dark: filled > WORTHWHILE * all })
    }

    /// Returns the colour of the clear; `None`: no clear. `cleared`: colour of cleared views that
    /// some draws show.
    pub fn color(&self, cleared: Option<[f32; 3]>) -> Option<[f32; 3]> {
        const BLACK: [f32; 3] = [0.0; 3];
        // Pixels outside all outputs are black.
        cleared.filter(|_| self.covered).or((!self.covered || self.dark || cleared == Some(BLACK)).then_some(BLACK))
    }

    /// True if `targets` are in that framebuffer.
    pub fn serves(&self, targets: &[Target]) -> bool {
        targets.iter().all(|target| target.framebuffer == self.framebuffer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::LowerLeftRect;

    fn at(x: i32, y: i32, width: i32, height: i32) -> Target {
        Target { framebuffer: 3, viewport: LowerLeftRect::new(x, y, width, height) }
    }

    #[test]
    fn pays_where_much_is_black_or_nobody_draws() {
        let (left, right) = (at(0, 0, 50, 40), at(50, 0, 50, 40));
        let worthwhile = |targets: &[Target], black: [f64; 2]| {
            FullClear::of(targets, (100, 40), black.into_iter()).map(|clear| clear.color(None).is_some())
        };
        assert_eq!(worthwhile(&[left, right], [0.0, 0.0]), Some(false));
        assert_eq!(worthwhile(&[left, right], [0.3, 0.0]), Some(false));
        assert_eq!(worthwhile(&[left, right], [0.3, 0.2]), Some(true));
        assert_eq!(worthwhile(&[left], [0.0, 0.0]), Some(true), "half of it belongs to no output");
        assert_eq!(worthwhile(&[], [0.0, 0.0]), None);
    }

    #[test]
    fn what_no_output_shows_is_black() {
        let (black, red) = ([0.0; 3], [1.0, 0.0, 0.0]);
        let of = |width: u32| {
            let clear = FullClear::of(&[at(0, 0, 50, 40)], (width, 40), [0.0].into_iter());
            move |cleared| clear.and_then(|clear| clear.color(cleared))
        };
        assert_eq!([None, Some(red), Some(black)].map(of(50)), [None, Some(red), Some(black)]);
        assert_eq!([None, Some(red), Some(black)].map(of(51)), [Some(black); 3]);
    }

    #[test]
    fn not_where_outputs_overlap_or_are_elsewhere() {
        let (low, high) = (at(0, 0, 50, 40), at(49, 39, 50, 40));
        let of = |targets: &[Target]| FullClear::of(targets, (100, 100), [1.0, 1.0].into_iter());
        assert_eq!(of(&[low, high]), None);
        assert!(of(&[low, at(50, 0, 50, 40)]).is_some_and(|clear| clear.serves(&[low])));
        let elsewhere = Target { framebuffer: 4, ..high };
        assert_eq!(of(&[low, Target { framebuffer: 4, ..at(50, 0, 50, 40) }]), None);
        assert!(of(&[low]).is_some_and(|clear| !clear.serves(&[elsewhere])));
    }
}
