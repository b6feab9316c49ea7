//! Reasons why drawing is shown flat, or not drawn once per view.

use std::borrow::Cow;

/// Reason that keeps an image from being drawn once per view.
pub const SHOWN_SMALL: &str = "it is shown in less than half of the window: make it larger, or close what is beside it";

/// Reason that keeps a draw, a pass or a program from being drawn once per view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// Everything is flat already, and the reason for that was reported.
    AlreadyFlat,
    /// A reason, for the log and the statistics.
    Reason(Cow<'static, str>),
}

impl Obstacle {
    /// The reason, if there is one to report.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::AlreadyFlat => None,
            Self::Reason(reason) => Some(reason),
        }
    }
}

impl From<&'static str> for Obstacle {
    fn from(reason: &'static str) -> Self {
        Self::Reason(Cow::Borrowed(reason))
    }
}

impl From<String> for Obstacle {
    fn from(reason: String) -> Self {
        Self::Reason(Cow::Owned(reason))
    }
}

#[cfg(test)]
mod tests {
    use super::Obstacle;

    #[test]
    fn a_program_that_is_flat_already_has_nothing_to_report() {
        assert_eq!(Obstacle::AlreadyFlat.reason(), None);
        assert_eq!(Obstacle::from("shader objects").reason(), Some("shader objects"));
        assert_eq!(Obstacle::from(String::new()).reason(), Some(""), "an empty reason is a reason");
    }
}
