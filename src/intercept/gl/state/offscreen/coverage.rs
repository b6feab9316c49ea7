//! Flat draws to the window that sample followed images, and flat draws into such images.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::{LowerLeftRect, Size};
use crate::intercept::gl::state::offscreen::images::Set;

/// Flat draws to the window that sample followed images, and flat draws into such images.
#[derive(Default)]
pub struct Coverage(pub(in crate::intercept::gl) Vec<Kind>);

/// Properties that draws of equal coverage have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::intercept::gl) struct Signature {
    pub(in crate::intercept::gl) program: u32,
    pub(in crate::intercept::gl) sampled: Set,
    pub(in crate::intercept::gl) viewport: LowerLeftRect,
}

pub(in crate::intercept::gl) struct Kind {
    pub(in crate::intercept::gl) signature: Signature,
    pub(in crate::intercept::gl) state: State,
}

pub(in crate::intercept::gl) enum State {
    /// Not measured yet.
    New,
    /// Name of the query, and the whole picture.
    Measured(u32, Picture),
    /// Number of samples of a draw that fills a large part of the picture. Its borders are to be
    /// measured.
    Large(i64, Picture),
    /// Queries of the four arms of a cross, and number of samples of the draw.
    Crossed([u32; ARMS], i64, Picture),
    /// The rectangle that such draws fill. `None`: they fill no large rectangle.
    Known(Option<LowerLeftRect>),
}

/// Number of arms of the cross that finds the borders of a rectangle.
pub(in crate::intercept::gl) const ARMS: usize = 4;

/// The measurement of one draw.
#[derive(Clone, Copy)]
pub struct Measure {
    /// Index of the draw's kind in the list.
    pub(in crate::intercept::gl) kind: usize,
    /// What is measured.
    pub(in crate::intercept::gl) what: Measured,
}

/// What is measured of a draw.
#[derive(Clone, Copy)]
pub(in crate::intercept::gl) enum Measured {
    /// The number of samples that it draws in this picture.
    Samples(Picture),
    /// The borders of the rectangle that it fills.
    Borders,
}

/// The window, or an image that draws fill.
#[derive(Clone, Copy)]
pub struct Picture {
    /// Width and height.
    pub(in crate::intercept::gl) size: Size,
    /// Samples per pixel, at least 1.
    pub(in crate::intercept::gl) samples: i64,
}

impl Picture {
    /// Rectangle of the whole picture.
    pub(in crate::intercept::gl) fn whole(&self) -> LowerLeftRect {
        LowerLeftRect::of_size(self.size)
    }

    /// Number of samples.
    fn all(&self) -> i64 {
        self.size.area() * self.samples
    }

    /// Returns the rectangles of the arms: from the middle to the left, to the right, downwards and
    /// upwards, one pixel wide. A rectangle of more than half of the picture has the middle in it.
    pub(in crate::intercept::gl) fn arms(&self) -> [LowerLeftRect; ARMS] {
        let (Size { width, height }, [x, y]) = (self.size, self.middle());
        [
            LowerLeftRect::new(0, y, x, 1),
            LowerLeftRect::new(x, y, width - x, 1),
            LowerLeftRect::new(x, 0, 1, y),
            LowerLeftRect::new(x, y, 1, height - y),
        ]
    }

    fn middle(&self) -> [i32; 2] {
        [self.size.width / 2, self.size.height / 2]
    }

    /// Returns the rectangle that has `arms` samples in the arms. `None`: a draw with `samples`
    /// samples does not fill this rectangle alone.
    fn rectangle(&self, arms: [i64; ARMS], samples: i64) -> Option<LowerLeftRect> {
        let [left, right, below, above] = arms.map(|count| (count / self.samples) as i32);
        let [x, y] = self.middle();
        let rect = LowerLeftRect::new(x - left, y - below, left + right, below + above);
        let area = rect.size().area() * self.samples;
        // Rounded corners and thin lines may be left out.
        (50 * (area - samples).abs() <= area && 2 * area > self.all()).then_some(rect)
    }
}

impl Coverage {
    /// Forgets all kinds, as images have other indices in the list or the window has another size.
    pub fn clear(&mut self, gl: &Gl) {
        for kind in self.0.drain(..) {
            kind.destroy(gl);
        }
    }

    /// Reads the results of measurements. Calls `found` with the images that are shown, and with the
    /// large part of the window that they fill, if they do. Returns true if there are any results.
    pub fn take_results(&mut self, gl: &Gl, mut found: impl FnMut(Set, Option<LowerLeftRect>)) -> bool {
        let mut any = false;
        for kind in &mut self.0 {
            let state = match kind.state {
                State::Measured(query, picture) => {
                    let (samples, all) = (take_result(gl, query), picture.all());
                    if 10 * samples >= 9 * all {
                        State::Known(Some(picture.whole()))
                    } else if kind.signature.sampled != 0 && 2 * samples > all {
                        State::Large(samples, picture)
                    } else {
                        State::Known(None)
                    }
                }
                State::Crossed(queries, samples, picture) => {
                    State::Known(picture.rectangle(queries.map(|query| take_result(gl, query)), samples))
                }
                _ => continue,
            };
            if let State::Known(part) = state {
                found(kind.signature.sampled, part);
            }
            kind.state = state;
            any = true;
        }
        any
    }
}

/// Returns the result of a query, and deletes it.
fn take_result(gl: &Gl, query: u32) -> i64 {
    let mut samples = 0;
    // SAFETY: a query of Cupola that has ended; writes one integer.
    unsafe {
        gl.get_query_objectuiv(query, api::GL_QUERY_RESULT, &mut samples);
        gl.delete_queries(1, &query);
    }
    i64::from(samples)
}

impl Kind {
    pub(in crate::intercept::gl) fn destroy(&self, gl: &Gl) {
        let queries: &[u32] = match &self.state {
            State::Measured(query, _) => std::slice::from_ref(query),
            State::Crossed(queries, ..) => queries,
            _ => return,
        };
        // SAFETY: objects of Cupola.
        unsafe { gl.delete_queries(queries.len() as i32, queries.as_ptr()) };
    }
}

#[cfg(test)]
mod tests {
    use super::{ARMS, LowerLeftRect, Picture};

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
        let whole = |size: (u32, u32)| LowerLeftRect::of_size(size);
        for (size, samples, rect) in [
            ((640, 480), 1, LowerLeftRect::new(0, 0, 500, 480)),
            ((640, 480), 4, LowerLeftRect::new(139, 20, 501, 457)),
            ((641, 481), 1, LowerLeftRect::new(60, 33, 481, 400)),
            ((1, 1), 1, whole((1, 1))),
            ((3, 5), 2, whole((3, 5))),
        ] {
            let (picture, samples_drawn) =
                (Picture { size: size.into(), samples }, i64::from(rect.width * rect.height) * samples);
            assert_eq!(picture.rectangle(counted(picture, rect), samples_drawn), Some(rect), "{size:?}");
        }
    }

    #[test]
    fn other_shapes_and_small_parts_are_none() {
        let picture = Picture { size: (100, 100).into(), samples: 1 };
        let rect = LowerLeftRect::new(10, 10, 80, 80);
        // A disc of that width, and a frame without its middle.
        for samples in [5027, 3000] {
            assert_eq!(picture.rectangle(counted(picture, rect), samples), None);
        }
        assert_eq!(picture.rectangle([0; ARMS], 6400), None);
        let half = LowerLeftRect::new(0, 0, 50, 100);
        assert_eq!(picture.rectangle(counted(picture, half), 5000), None);
    }
}
