//! Where in an atlas and in a window everything is, from the top left as Vulkan counts.

use crate::error::{Error, ErrorKind, Result};
use crate::rig::Rig;
use crate::runtime::session::{Extras, Session};

/// A rectangle: x, y of the top left corner, width, height.
pub type Rect = [i32; 4];

/// A rig at work in a window.
pub struct Layout {
    /// The plan.
    pub session: Session,
    /// Size of the window and of the program's picture.
    pub window: (u32, u32),
    /// Size of the atlas.
    pub atlas: (u32, u32),
    /// The panel, as large as the window.
    pub panel: Rect,
    /// The views, and whether they are drawn with the program's own lens.
    pub views: Vec<(Rect, bool)>,
    /// Where each output is in the window.
    pub outputs: Vec<Rect>,
}

impl Layout {
    /// Plans `rig` in a window of `size` pixels, on a device whose images are up to `max_atlas` wide and high.
    ///
    /// # Errors
    /// Those of the planner.
    pub fn new(rig: &Rig, size: (u32, u32), max_atlas: u32) -> Result<Self> {
        let session = Session::new(rig, size, false, max_atlas, Extras { panel: true, ..Extras::default() })?;
        let atlas = session.plan().views.atlas;
        let panel = session.panel().ok_or_else(|| Error::new(ErrorKind::Internal, "the plan has no panel"))?;
        let views = (0..session.views().len()).map(|index| session.tile(index));
        let views = views.map(|(tile, own)| (from_top(tile, atlas.1), own)).collect();
        let outputs = session.viewports().map(|rect| from_top(rect, size.1)).collect();
        Ok(Self { window: size, atlas, panel: from_top(panel, atlas.1), views, outputs, session })
    }

    /// The panel and the texels around it, which the filter reaches at its border.
    pub fn glass(&self) -> Rect {
        let [x, y, width, height] = self.panel;
        let (left, top) = ((x - 1).max(0), (y - 1).max(0));
        let (right, bottom) = (x + width + 1, y + height + 1);
        [left, top, right.min(self.atlas.0 as i32) - left, bottom.min(self.atlas.1 as i32) - top]
    }

    /// Names of the views and the panel, and where they are in the atlas.
    pub fn tiles(&self) -> impl Iterator<Item = (&str, [u32; 4])> {
        let names = self.session.views().iter().map(|view| view.name.as_str()).chain(["panel"]);
        let rects = self.views.iter().map(|(rect, _)| *rect).chain([self.panel]);
        names.zip(rects.map(|rect| rect.map(|length| length.max(0) as u32)))
    }
}

/// A rectangle counted from the bottom of a picture, counted from its top.
fn from_top([x, y, width, height]: Rect, picture: u32) -> Rect {
    [x, picture as i32 - y - height, width, height]
}

#[cfg(test)]
mod tests {
    use super::Layout;

    #[test]
    fn the_panel_is_as_large_as_the_window_and_everything_inside() {
        let rig = crate::rig::load("planetarium-6").expect("a preset");
        let layout = Layout::new(&rig, (900, 420), 16384).expect("a plan");
        assert_eq!(layout.panel[2..], [900, 420]);
        assert_eq!(layout.outputs.len(), 6);
        for tile in layout.views.iter().map(|view| &view.0).chain([&layout.panel]) {
            assert!(tile[0] >= 0 && tile[1] >= 0, "{tile:?}");
            assert!(tile[0] + tile[2] <= layout.atlas.0 as i32 && tile[1] + tile[3] <= layout.atlas.1 as i32);
        }
    }
}
