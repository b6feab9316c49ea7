//! Rectangles in an atlas and in a window. The origin is the top left corner, as in Vulkan.

use crate::correct::projected::matrices::LensConstants;
use crate::correct::single::pixels;
use crate::correct::{LowerLeftRect, PixelRect, Plan, Size, UpperLeftRect};
use crate::error::{Error, ErrorKind, Result};
use crate::intercept::scene::to_window::Area;
use crate::intercept::scene::viewport::parts::PanelPart;
use crate::intercept::vk::state::views::vertices::VertexProcessing;
use crate::rig::Rig;
use crate::runtime::session::{Extras, Session};
use ash::vk;
use std::sync::{Arc, Mutex};

/// A rectangle of an atlas or a window. Its origin is the top left corner, as in Vulkan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtlasRect {
    /// Left edge.
    pub x: i32,
    /// Upper edge.
    pub y: i32,
    pub(in crate::intercept::vk) width: i32,
    pub(in crate::intercept::vk) height: i32,
}

/// Converts a tile of the session. Its distance from the bottom there becomes its distance from the
/// top here.
impl From<LowerLeftRect> for AtlasRect {
    fn from(LowerLeftRect { x, y, width, height }: LowerLeftRect) -> Self {
        Self { x, y, width, height }
    }
}

impl From<AtlasRect> for LowerLeftRect {
    fn from(AtlasRect { x, y, width, height }: AtlasRect) -> Self {
        Self { x, y, width, height }
    }
}

impl From<AtlasRect> for Area {
    fn from(AtlasRect { x, y, width, height }: AtlasRect) -> Self {
        Self { origin: [x, y].map(pixels).into(), size: [width, height].map(pixels).into() }
    }
}

impl AtlasRect {
    /// Returns this rectangle of a window, moved to the window's `tile`.
    pub fn moved_into(self, tile: Self) -> Self {
        Self { x: tile.x + self.x, y: tile.y + self.y, ..self }
    }

    /// Returns the rectangle as a type of Vulkan.
    pub fn to_vk(self) -> vk::Rect2D {
        let extent = vk::Extent2D { width: self.width.max(0) as u32, height: self.height.max(0) as u32 };
        vk::Rect2D { offset: vk::Offset2D { x: self.x, y: self.y }, extent }
    }

    /// Its upper left corner, for copies.
    pub fn offset(self) -> vk::Offset3D {
        vk::Offset3D { x: self.x, y: self.y, z: 0 }
    }

    /// Returns the middle part, half as wide and half as high.
    pub fn middle(self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        Self { x: self.x + (self.width - width) / 2, y: self.y + (self.height - height) / 2, width, height }
    }

    /// Its size, for copies.
    pub fn extent(self) -> vk::Extent3D {
        vk::Extent3D { width: self.width.max(0) as u32, height: self.height.max(0) as u32, depth: 1 }
    }

    /// Returns the rectangle as texels of the atlas. Negative values, which are not in the atlas,
    /// become 0.
    fn to_pixels(self) -> PixelRect {
        let [x, y, width, height] = [self.x, self.y, self.width, self.height].map(|length| length.max(0) as u32);
        PixelRect { x, y, width, height }
    }

    /// Number of texels.
    pub fn area(self) -> f64 {
        f64::from(self.width) * f64::from(self.height)
    }
}

/// The tile of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewTile {
    /// Its rectangle in the atlas.
    pub rect: AtlasRect,
    /// True if the view is drawn with the program's own lens, and therefore in the program's window
    /// space.
    pub own_lens: bool,
}

impl ViewTile {
    fn of(session: &Session, index: usize) -> Self {
        let (rect, own_lens) = session.tile(index);
        Self { rect: rect.into(), own_lens }
    }

    /// True if the view has the program's own lens and the size of its window.
    fn is_window(&self, (width, height): (u32, u32)) -> bool {
        self.own_lens && (self.rect.width, self.rect.height) == (width as i32, height as i32)
    }
}

/// Layout of a rig in a window, or in an image of another size on its way to the window.
pub struct AtlasLayout {
    /// The running rig.
    pub session: Arc<Session>,
    /// Its plan, with the tiles at their positions in this atlas.
    pub plan: Plan,
    /// Version of the rig's file that it was made from; 0: the version at the start.
    pub version: u64,
    /// Size of the program's picture: the size of the window, or of the image.
    pub window: (u32, u32),
    /// Number of its pixels divided by the number of the window's pixels that it fills.
    pub pixels: f64,
    /// The part of the window that it fills, between widgets; `None`: all of the window.
    pub part: Option<AtlasRect>,
    /// True if all tiles are as large as the program's picture.
    pub even: bool,
    /// Layouts for this window for images of other sizes, and even layouts.
    pub(in crate::intercept::vk) of_images: Mutex<Vec<Arc<Self>>>,
    /// Size of the atlas.
    pub atlas: (u32, u32),
    /// The panel, as large as the window.
    pub panel: AtlasRect,
    /// A tile with the program's own picture, beside the views, if the program may read its window.
    pub primary: Option<AtlasRect>,
    /// True if the program may read its own picture, or if its shaders write in it.
    pub read: bool,
    /// The tiles of the views.
    pub views: Vec<ViewTile>,
    /// For each view, the lens of its output's picture, in the form for shaders; empty if all views
    /// are perspective ones.
    pub lenses: Vec<LensConstants>,
    /// Rectangles of the outputs in the window.
    pub outputs: Vec<UpperLeftRect>,
}

impl AtlasLayout {
    /// Plans `rig` in a window of `size` pixels, on a device with images of up to `max_atlas`
    /// texels in width and height. `read`: the program may read its own picture. `vertices`: how
    /// shaders can process vertices if the rig requests it.
    ///
    /// # Errors
    /// The errors of the planner.
    pub fn new(rig: &Rig, size: (u32, u32), max_atlas: u32, read: bool, vertices: VertexProcessing) -> Result<Self> {
        let plan = match vertices {
            VertexProcessing::Views => Session::new,
            VertexProcessing::Projected => Session::undivided,
            VertexProcessing::Divided => Session::projecting,
        };
        let mut session = plan(rig, size, false, max_atlas, Extras { panel: true, ..Extras::default() })?;
        if read && !(0..session.views().len()).any(|index| ViewTile::of(&session, index).is_window(size)) {
            session = session.with(Extras { primary: true, ..session.extras() })?;
        }
        Self::of(session, size, read)
    }

    /// Returns a layout of the same window for another rig, over the same views; `None` if these
    /// cannot serve it.
    ///
    /// # Errors
    /// As for [`Session::over`].
    pub fn over(&self, rig: &Rig) -> Result<Option<Self>> {
        self.session.over(rig)?.map(|session| Self::of(session, self.window, self.read)).transpose()
    }

    /// Returns a layout that shows another rig roughly over these views; `None` if these cannot serve
    /// it.
    pub fn roughly_over(&self, rig: &Rig) -> Option<Self> {
        Self::of(self.session.roughly_over(rig)?, self.window, self.read).ok()
    }

    fn of(session: Session, window: (u32, u32), read: bool) -> Result<Self> {
        let plan = upside_down(session.plan());
        let panel = session.panel().ok_or_else(|| Error::new(ErrorKind::Internal, "the plan has no panel"))?;
        Ok(Self {
            even: false,
            window,
            pixels: 1.0,
            part: None,
            of_images: Mutex::default(),
            version: 0,
            atlas: plan.views.atlas,
            panel: panel.into(),
            primary: session.primary().map(AtlasRect::from),
            read,
            views: (0..session.views().len()).map(|index| ViewTile::of(&session, index)).collect(),
            lenses: session.lenses(),
            outputs: session.viewports_from_top((0, 0)),
            session: Arc::new(session),
            plan,
        })
    }

    /// True if both layouts are for the same window and have the same views.
    pub fn has_views_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.session, &other.session)
    }

    /// Returns the rectangles of all parts of the program's picture.
    pub fn pictures(&self) -> impl Iterator<Item = AtlasRect> {
        self.views.iter().map(|view| view.rect).chain(self.primary).chain([self.panel])
    }

    /// True if every view has the program's own lens, so that nothing is shown on the panel.
    pub fn shows_own_lens(&self) -> bool {
        self.views.iter().all(|view| view.own_lens)
    }

    /// Returns the part of the panel on which its flat drawing is shown.
    pub fn panel_part(&self) -> PanelPart {
        let of = |part: AtlasRect| {
            let window = Size::from(self.session.window());
            let below = window.height - part.y - part.height;
            PanelPart::of(LowerLeftRect { y: below, ..part.into() }, window)
        };
        self.part.map_or_else(PanelPart::default, of)
    }

    /// Returns the rectangle of the program's own picture, pixel by pixel, if it is drawn.
    pub fn own(&self) -> Option<AtlasRect> {
        let own = self.views.iter().find(|view| view.is_window(self.window)).map(|view| view.rect);
        self.primary.or(own)
    }

    /// True if outputs of this machine sample a view, or if the view is the program's own picture.
    pub fn is_needed(&self, view: usize) -> bool {
        let own = || self.views.get(view).is_some_and(|view| Some(view.rect) == self.own());
        view >= 64 || self.session.needed() >> view & 1 == 1 || own()
    }

    /// Returns the rectangle in which the program's picture is shown flat: the panel. If the
    /// program's own lens shows everything and the panel nothing, it is the view with that lens.
    pub fn flat_place(&self) -> AtlasRect {
        self.own().filter(|_| self.shows_own_lens()).unwrap_or(self.panel)
    }

    /// Returns the panel and the texels around it, which the filter reads at its border.
    pub fn panel_with_border(&self) -> AtlasRect {
        let AtlasRect { x, y, width, height } = self.panel;
        let (left, top) = ((x - 1).max(0), (y - 1).max(0));
        let (right, bottom) = (x + width + 1, y + height + 1);
        let (width, height) = (right.min(self.atlas.0 as i32) - left, bottom.min(self.atlas.1 as i32) - top);
        AtlasRect { x: left, y: top, width, height }
    }

    /// Returns the names of the views and the panel, and their rectangles in the atlas.
    pub fn tiles(&self) -> impl Iterator<Item = (&str, PixelRect)> {
        let names = self.session.views().iter().map(|view| view.name.as_str()).chain(["panel"]);
        let rects = self.views.iter().map(|view| view.rect).chain([self.panel]);
        names.zip(rects.map(AtlasRect::to_pixels))
    }
}

/// Returns the plan with its tiles mirrored: their distance from the bottom of the atlas becomes
/// the distance from the top. So the tile with the program's own lens can be at the origin, where
/// it is rasterised exactly as in the program. At larger coordinates, rounding differs.
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
    use crate::correct::LowerLeftRect;
    use crate::intercept::vk::state::views::vertices::VertexProcessing;

    #[test]
    fn the_panel_is_as_large_as_the_window_and_everything_inside() {
        let rig = crate::rig::load("planetarium-6").expect("a preset");
        let layout = AtlasLayout::new(&rig, (900, 420), 16384, false, VertexProcessing::Divided).expect("a plan");
        assert_eq!((layout.panel.width, layout.panel.height), (900, 420));
        assert_eq!(layout.outputs.len(), 6);
        for tile in layout.views.iter().map(|view| view.rect).chain([layout.panel]) {
            assert!(tile.x >= 0 && tile.y >= 0, "{tile:?}");
            assert!(tile.x + tile.width <= layout.atlas.0 as i32 && tile.y + tile.height <= layout.atlas.1 as i32);
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
                VertexProcessing::Divided,
            )
        };
        let own = |rig: &str, read| layout(rig, read).expect("a plan").own();
        assert_eq!(own("fisheye", false), None);
        assert_eq!(own("fisheye", true), Some(LowerLeftRect::of_size((90, 42)).into()));
        assert_eq!(own("identity-captured", false), Some(LowerLeftRect::of_size((90, 42)).into()));
        assert_eq!(layout("identity-captured", true).expect("a plan").primary, None, "a view shows it already");
    }
}
