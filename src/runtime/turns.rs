//! Views in turn: choice of the view that the program draws in its current frame.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Position in the round of the views. Contexts of a program share it.
#[derive(Debug)]
pub struct Turns {
    /// Number of the program's frames since the round began.
    frame: AtomicUsize,
    views: usize,
    /// Number of the program's frames for each view.
    repeats: usize,
}

/// Result of a program's frame in the round of the views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EndOfTurn {
    /// View that was drawn, if its picture counts; `None` for a warm-up frame.
    pub view: Option<usize>,
    /// True if all views are drawn.
    pub is_last: bool,
}

impl Turns {
    /// Turns of `views` views (at least 1), each with `warm_up` frames before the one that counts.
    pub fn new(views: usize, warm_up: usize) -> Self {
        Self { frame: AtomicUsize::new(0), views: views.max(1), repeats: warm_up + 1 }
    }

    /// Number of the program's frames in a round.
    pub fn frames(&self) -> usize {
        self.views * self.repeats
    }

    /// View that is drawn in this frame of the program.
    pub fn view(&self) -> usize {
        self.frame.load(Ordering::Relaxed) / self.repeats
    }

    /// Ends a frame of the program.
    pub fn end_frame(&self) -> EndOfTurn {
        let frame = self.frame.load(Ordering::Relaxed);
        let next = frame + 1;
        let is_last = next >= self.frames();
        self.frame.store(if is_last { 0 } else { next }, Ordering::Relaxed);
        EndOfTurn { view: next.is_multiple_of(self.repeats).then_some(frame / self.repeats), is_last }
    }
}

#[cfg(test)]
mod tests {
    use super::{EndOfTurn, Turns};

    #[test]
    fn each_view_counts_once_in_a_round_and_after_its_warm_up() {
        let turns = Turns::new(2, 2);
        let rounds: Vec<(usize, EndOfTurn)> =
            (0..2 * turns.frames()).map(|_| (turns.view(), turns.end_frame())).collect();
        let views: Vec<usize> = rounds.iter().map(|(view, _)| *view).collect();
        assert_eq!(views, [0, 0, 0, 1, 1, 1, 0, 0, 0, 1, 1, 1]);
        let counted: Vec<_> = rounds.iter().map(|(_, end)| end.view).collect();
        assert_eq!(counted[..6], [None, None, Some(0), None, None, Some(1)]);
        assert_eq!(rounds.iter().filter(|(_, end)| end.is_last).count(), 2);
        assert!(rounds[5].1.is_last);
    }
}
