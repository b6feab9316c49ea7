//! Draws that show nothing but the colour of views that hold a single one. They need not be issued.

use crate::correct::shaders::constants::Constants;
use crate::correct::{Footprints, LowerLeftRect, TexelSpan};

/// Views that hold one colour in every texel, or in all but a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearedViews<'a> {
    /// Bit i: the plan's view i. Views from number 64 on are none of them.
    pub views: u64,
    /// Red, green and blue as they are stored: multiples of 1/255.
    pub color: [f32; 3],
    /// For each view the texels of the atlas that may hold something else; views beyond the list
    /// may everywhere.
    pub touched: &'a [TexelSpan],
}

/// Effect of a draw on the colour of views that hold a single one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::backend::gl) enum Shows {
    /// It is shown as it is.
    Same,
    /// Black stays black: other colours are weighted, or have a rim.
    Black,
    /// Another one.
    Other,
}

/// One draw call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::backend::gl) struct Draw {
    pub program: u32,
    /// First index, number of indices.
    pub first: i32,
    pub count: i32,
    /// The views that it samples, a bit each.
    pub views: u64,
    pub shows: Shows,
    /// The batch shows its view 1:1: texels are taken as they are, where the target is as large as
    /// the output.
    pub nearest: bool,
}

/// A part of an output that is larger is not worth a clear of all of it.
const WORTHWHILE: f64 = 0.7;

/// The part of an output of `size` pixels outside of which draws that can be
/// narrowed show the colour of the views; `None` where that is not known, or saves little.
pub(in crate::backend::gl) fn part(
    cleared: &ClearedViews,
    draws: &[Draw],
    footprints: Option<&Footprints>,
    size: (u32, u32),
) -> Option<LowerLeftRect> {
    let footprints = footprints.filter(|_| draws.iter().any(|draw| draw.narrows(cleared)))?;
    let part = footprints.sampling(cleared.touched);
    let all = f64::from(size.0) * f64::from(size.1);
    (f64::from(part.width) * f64::from(part.height) < WORTHWHILE * all).then_some(part)
}

impl Draw {
    /// True if what shows a colour shows that same colour.
    fn keeps(&self, color: [f32; 3]) -> bool {
        match self.shows {
            Shows::Same => true,
            Shows::Black => color == [0.0; 3],
            Shows::Other => false,
        }
    }

    /// True if it shows the colour of views wherever they hold it.
    pub fn narrows(&self, cleared: &ClearedViews) -> bool {
        self.views != 0 && self.keeps(cleared.color)
    }

    /// True if it shows the colour of these views and nothing else. What shows nothing at all is
    /// black.
    pub fn shows_cleared(&self, cleared: &ClearedViews) -> bool {
        self.keeps(cleared.color) && self.views & !cleared.views == 0
    }
}

/// Returns the effect on a single colour of a draw with these constants.
pub(in crate::backend::gl) fn shows(constants: &Constants) -> Shows {
    // Only the pass that shows black has no views.
    let Some(shared) = constants.shared() else { return Shows::Black };
    if shared.with_panel != 0 || shared.with_black != 0 || shared.black != [0.0; 3] || shared.lift != 0.0 {
        Shows::Other
    } else if shared.weighted != 0 || shared.edge != 0 {
        Shows::Black
    } else {
        Shows::Same
    }
}
