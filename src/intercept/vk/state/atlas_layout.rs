//! Where in an atlas and in a window everything is, from the top left as Vulkan counts.

use crate::correct::Plan;
use crate::correct::projected::matrices::LensConstants;
use crate::error::{Error, ErrorKind, Result};
use crate::intercept::vk::state::vertices::VertexProcessing;
use crate::rig::Rig;
use crate::runtime::session::{Extras, Session};
use ash::vk;

/// A rectangle: x, y of the top left corner, width, height.
pub type Rect = [i32; 4];

/// A tile as Vulkan takes rectangles.
pub fn rectangle([x, y, width, height]: Rect) -> vk::Rect2D {
    let extent = vk::Extent2D { width: width.max(0) as u32, height: height.max(0) as u32 };
    vk::Rect2D { offset: vk::Offset2D { x, y }, extent }
}

/// A rig at work in a window.
pub struct AtlasLayout {
    /// The rig at work.
    pub session: Session,
    /// Its plan, with the tiles where they are in this atlas.
    pub plan: Plan,
    /// Which state of the rig's file it is of; 0 = the first.
    pub version: u64,
    /// Size of the window and of the program's picture.
    pub window: (u32, u32),
    /// Size of the atlas.
    pub atlas: (u32, u32),
    /// The panel, as large as the window.
    pub panel: Rect,
    /// A tile with the program's own picture beside the views, where the program may read its window.
    pub primary: Option<Rect>,
    /// The program may read its own picture.
    pub read: bool,
    /// The views, and whether they are drawn with the program's own lens.
    pub views: Vec<(Rect, bool)>,
    /// For each view the lens of its picture, as shaders take it; empty where all views are perspective ones.
    pub lenses: Vec<LensConstants>,
    /// Where each output is in the window.
    pub outputs: Vec<Rect>,
}

impl AtlasLayout {
    /// Plans `rig` in a window of `size` pixels, on a device whose images are up to `max_atlas` wide and high. `read`: the
    /// program may read its own picture. `vertices`: what shaders do with vertices where the rig says so.
    ///
    /// # Errors
    /// Those of the planner.
    pub fn new(rig: &Rig, size: (u32, u32), max_atlas: u32, read: bool, vertices: VertexProcessing) -> Result<Self> {
        let plan = match vertices {
            VertexProcessing::Views => Session::new,
            VertexProcessing::Projected => Session::undivided,
            VertexProcessing::DivisionStatistics => Session::projecting,
        };
        let mut session = plan(rig, size, false, max_atlas, Extras { panel: true, ..Extras::default() })?;
        if read && !(0..session.views().len()).any(|index| is_own(session.tile(index), size)) {
            session = session.with(Extras { primary: true, ..session.extras() })?;
        }
        let plan = upside_down(session.plan());
        let atlas = plan.views.atlas;
        let panel = session.panel().ok_or_else(|| Error::new(ErrorKind::Internal, "the plan has no panel"))?;
        let views: Vec<(Rect, bool)> = (0..session.views().len()).map(|index| session.tile(index)).collect();
        let outputs = session.viewports_from_top((0, 0));
        let primary = session.primary();
        let lenses = session.lenses();
        Ok(Self { window: size, version: 0, atlas, panel, primary, read, views, lenses, outputs, session, plan })
    }

    /// Whether every view has the program's own lens, so that nothing is shown on the panel.
    pub fn shows_own_lens(&self) -> bool {
        self.views.iter().all(|(_, own)| *own)
    }

    /// Where the program's own picture is, texel by texel, if it is drawn.
    pub fn own(&self) -> Option<Rect> {
        let own = self.views.iter().find(|view| is_own(**view, self.window)).map(|view| view.0);
        self.primary.or(own)
    }

    /// The panel and the texels around it, which the filter reaches at its border.
    pub fn panel_with_border(&self) -> Rect {
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

/// Whether a tile is drawn with the program's own lens and as large as its window.
fn is_own((tile, own): (Rect, bool), (width, height): (u32, u32)) -> bool {
    own && (tile[2], tile[3]) == (width as i32, height as i32)
}

/// The plan whose tiles begin as many rows below the atlas' top as those of `plan` begin above its bottom. So what is
/// drawn with the program's own lens can be at the origin, and is rasterised as the program rasterises it, to the byte:
/// elsewhere coordinates are larger, and rounded otherwise.
fn upside_down(plan: &Plan) -> Plan {
    let mut plan = plan.clone();
    let views = &mut plan.views;
    let height = views.atlas.1;
    let panel = views.panel.as_mut().map(|panel| &mut panel.tile);
    for tile in views.views.iter_mut().map(|view| &mut view.tile).chain(panel).chain(&mut views.primary) {
        tile.y = height - tile.y - tile.height;
    }
    plan
}

#[cfg(test)]
mod tests {
    use super::AtlasLayout;
    use crate::intercept::vk::state::vertices::VertexProcessing;

    #[test]
    fn the_panel_is_as_large_as_the_window_and_everything_inside() {
        let rig = crate::rig::load("planetarium-6").expect("a preset");
        let layout =
            AtlasLayout::new(&rig, (900, 420), 16384, false, VertexProcessing::DivisionStatistics).expect("a plan");
        assert_eq!(layout.panel[2..], [900, 420]);
        assert_eq!(layout.outputs.len(), 6);
        for tile in layout.views.iter().map(|view| &view.0).chain([&layout.panel]) {
            assert!(tile[0] >= 0 && tile[1] >= 0, "{tile:?}");
            assert!(tile[0] + tile[2] <= layout.atlas.0 as i32 && tile[1] + tile[3] <= layout.atlas.1 as i32);
        }
    }

    #[test]
    fn the_programs_own_picture_is_at_the_origin_where_it_is_read() {
        let layout = |rig: &str, read| {
            AtlasLayout::new(
                &crate::rig::load(rig).expect("a preset"),
                (90, 42),
                16384,
                read,
                VertexProcessing::DivisionStatistics,
            )
        };
        let own = |rig: &str, read| layout(rig, read).expect("a plan").own();
        assert_eq!(own("fisheye", false), None);
        assert_eq!(own("fisheye", true), Some([0, 0, 90, 42]));
        assert_eq!(own("identity-captured", false), Some([0, 0, 90, 42]));
        assert_eq!(layout("identity-captured", true).expect("a plan").primary, None, "a view shows it already");
    }
}
