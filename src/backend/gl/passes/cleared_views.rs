//! Draws that would show only the colour of cleared views. They need not be issued.

use crate::correct::shaders::constants::Constants;
use crate::correct::{Footprints, LowerLeftRect, TexelSpan};

/// Views that contain one colour in every texel, or in all texels outside a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearedViews<'a> {
    /// Bit i stands for view i of the plan. Views from number 64 on are never included.
    pub views: u64,
    /// Red, green and blue as they are stored: multiples of 1/255.
    pub color: [f32; 3],
    /// For each view, the texels of the atlas that may have another colour. Views beyond the list
    /// may have another colour everywhere.
    pub touched: &'a [TexelSpan],
}

/// Effect of a draw on the single colour of cleared views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::backend::gl) enum Shows {
    /// The colour is shown unchanged.
    Same,
    /// Black stays black. Other colours change: they are weighted, or the picture has a rim.
    Black,
    /// Another colour is shown.
    Other,
}

/// One draw call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::backend::gl) struct Draw {
    pub program: u32,
    /// Index of the first index, number of indices.
    pub first: i32,
    pub count: i32,
    /// Views that the draw samples, one bit each.
    pub views: u64,
    pub shows: Shows,
    /// True if the batch shows its view 1:1. Texels are then copied if the target has the size of
    /// the output.
    pub nearest: bool,
}

/// If the part that still has to be drawn is larger, a clear of the whole output does not pay.
const WORTHWHILE: f64 = 0.7;

/// Returns the part of an output of `size` pixels in which draws that can be narrowed still have to
/// run. Outside it they show the colour of the cleared views. `None` if the part is not known, or
/// if the clear saves little.
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
    /// True if the draw shows this colour unchanged.
    fn keeps(&self, color: [f32; 3]) -> bool {
        match self.shows {
            Shows::Same => true,
            Shows::Black => color == [0.0; 3],
            Shows::Other => false,
        }
    }

    /// True if the draw shows the cleared colour wherever its views contain it.
    pub fn narrows(&self, cleared: &ClearedViews) -> bool {
        self.views != 0 && self.keeps(cleared.color)
    }

    /// True if the draw shows only the colour of the cleared views. A draw without views shows
    /// black.
    pub fn shows_cleared(&self, cleared: &ClearedViews) -> bool {
        self.keeps(cleared.color) && self.views & !cleared.views == 0
    }
}

/// Returns the effect of a draw with these constants on a single colour.
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
