//! Draws of a pass that share one classification, and the state of the frame that is being
//! submitted.

use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::process::small_window::SmallWindow;
use crate::intercept::scene::camera::Cameras;
use crate::intercept::scene::eye::Eye;
use crate::intercept::scene::flat_program::{FlatProgram, MissingLens, MissingLenses};
use crate::intercept::scene::frame_order::FrameOrder;
use crate::intercept::scene::lens::Told;
use crate::intercept::scene::to_window::Area;
use crate::intercept::scene::viewport::parts::PanelPart;
use crate::intercept::vk::spirv::Matrix;
use crate::intercept::vk::state::pipelines::MatrixStage;
use crate::intercept::vk::state::recording::draw_parameters::IndirectDraw;
use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect};
use crate::intercept::vk::state::views::view_constants::{ChunkOffset, SlotParts};
use crate::runtime::session::{CameraFunction, Intrinsics, ViewMatrix};
use ash::vk;
use glam::{DMat4, Mat4};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The value of a matrix, or its location in a buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MatrixValue {
    /// Its numbers in the order of memory, column by column.
    Known(Mat4),
    /// In a buffer, at an offset.
    Buffer(vk::Buffer, u64),
    /// Behind an address, at an offset from it. The address is in a buffer, at an offset.
    AtAddress(vk::Buffer, u64, u64),
}

/// A matrix that may be the projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatrixSource {
    /// Its declaration in a shader.
    pub(in crate::intercept::vk) matrix: Matrix,
    /// Its value or location.
    pub(in crate::intercept::vk) value: MatrixValue,
}

/// Class of a group's draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::intercept::vk) enum DrawClass {
    Scene(Intrinsics),
    Flat,
    Behind,
    /// A picture of the scene that covers each view.
    Screen,
    /// A background, which fills each view with what the program's picture has there through this
    /// lens.
    Backdrop(Intrinsics),
}

/// A matrix that may be a function of the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSource {
    /// The matrix; `None` if it cannot be read.
    pub(in crate::intercept::vk) source: Option<MatrixSource>,
    /// Kind of view matrix that its name suggests. The matrix itself must only rotate and
    /// translate.
    pub(in crate::intercept::vk) called: Option<ViewMatrix>,
    pub(in crate::intercept::vk) stage: MatrixStage,
    pub(in crate::intercept::vk) inverted: bool,
}

impl DrawFacts {
    /// Returns the parts of view constants that its shaders read.
    pub fn slot_parts(&self) -> SlotParts {
        match (self.cameras.is_empty(), self.pictures.is_empty()) {
            (false, _) => SlotParts::Cameras,
            (true, _) if self.backdrop => SlotParts::Backdrop,
            (true, false) => SlotParts::Factors,
            (true, true) => SlotParts::Place,
        }
    }
}

/// The layout of an image that shaders read.
#[derive(Clone)]
pub struct ShownLayout(pub(in crate::intercept::vk) Arc<AtlasLayout>);

impl PartialEq for ShownLayout {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl std::fmt::Debug for ShownLayout {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{:?}", self.0.window)
    }
}

/// Facts that draws of a group have in common.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawFacts {
    /// Matrices that may contain the lens, the likeliest first.
    pub(in crate::intercept::vk) sources: Vec<MatrixSource>,
    /// Reason why they have no lens, if no matrix can be read.
    pub(in crate::intercept::vk) missing_lens: MissingLens,
    /// True if y grows upwards in clip coordinates (viewport of negative height).
    pub(in crate::intercept::vk) y_up: bool,
    /// True if they are issued to the views, in addition to the panel.
    pub(in crate::intercept::vk) in_views: bool,
    /// True if they draw to an image that holds a scene on its way to the window.
    pub(in crate::intercept::vk) off_screen: bool,
    /// True if they use the depth test. Without a readable matrix, they may have the lens that the
    /// rig gives.
    pub(in crate::intercept::vk) deep: bool,
    /// Viewport of the program, if fragments get the coordinates of its window.
    pub(in crate::intercept::vk) viewport: Option<Area>,
    /// Layouts of the images that they read by texel coordinates, if each view has its own image.
    pub(in crate::intercept::vk) pictures: Vec<Option<ShownLayout>>,
    /// Matrices that may be functions of the camera, in the order of each stage.
    pub(in crate::intercept::vk) cameras: Vec<CameraSource>,
    /// True for draws that compute the complete picture from its pixels, if they are flat and have
    /// the inverse of a camera matrix.
    pub(in crate::intercept::vk) sky: bool,
    /// True for draws that bring the scene from an off-screen image to the complete picture, if
    /// they are flat.
    pub(in crate::intercept::vk) screen: bool,
    /// The part of the window that such draws fill, between widgets; `None`: all of it.
    pub(in crate::intercept::vk) part: Option<AtlasRect>,
    /// True for draws that fill the picture before the scene is drawn there: a background.
    pub(in crate::intercept::vk) fills: bool,
    /// True if the inputs of their fragments can be those of another place.
    pub(in crate::intercept::vk) backdrop: bool,
}

/// Draws that share a lens.
pub struct DrawGroup {
    /// Location of their view constants.
    pub(in crate::intercept::vk) constants: ChunkOffset,
    /// Positions of the views.
    pub(in crate::intercept::vk) layout: Arc<AtlasLayout>,
    /// Facts that they share.
    pub(in crate::intercept::vk) facts: DrawFacts,
    /// Number of its draws.
    pub(in crate::intercept::vk) draws: u64,
    /// Number of times that a draw was not issued to a view, as only other machines show it.
    pub(in crate::intercept::vk) elsewhere: u64,
    /// Parameters in memory, for draws that are left out where they are out of sight.
    pub(in crate::intercept::vk) indirect: Vec<IndirectDraw>,
    /// Slots of view constants with which it is in sight, one bit for each. Slots from 63 on are
    /// always in sight.
    pub(in crate::intercept::vk) in_sight: u64,
    /// Draw class that was written last, with its lens, and [`Cameras::adjustments`] then.
    pub(in crate::intercept::vk) last: Option<(DrawClass, u64)>,
    pub(in crate::intercept::vk) matrices: Vec<(u8, DMat4)>,
    pub(in crate::intercept::vk) lens: Option<(Told, &'static str)>,
    /// Matrices of its shaders that are functions of the camera.
    pub(in crate::intercept::vk) cameras: CameraFunctions,
}

/// Matrices of a group that are functions of the camera.
#[derive(Default)]
pub struct CameraFunctions {
    /// Values of the matrices, and the number of changes of the cameras, at the last search for
    /// functions.
    pub(in crate::intercept::vk) seen: Option<(Vec<Option<DMat4>>, u64)>,
    /// Dependence of each matrix on a camera, and that camera.
    pub(in crate::intercept::vk) functions: Vec<Option<(CameraFunction, Intrinsics)>>,
    /// Projection and view matrix, if they are separate.
    pub(in crate::intercept::vk) eye: Option<Eye>,
}

impl DrawGroup {
    /// Returns a group without draws.
    pub fn new(constants: ChunkOffset, layout: Arc<AtlasLayout>, facts: DrawFacts) -> Self {
        Self {
            constants,
            layout,
            facts,
            draws: 0,
            elsewhere: 0,
            indirect: Vec::new(),
            in_sight: 0,
            last: None,
            matrices: Vec::new(),
            lens: None,
            cameras: CameraFunctions::default(),
        }
    }

    /// Returns the reason why its draws have no lens, if they have none.
    pub fn missing_lens(&self) -> MissingLens {
        if self.matrices.is_empty() { self.facts.missing_lens } else { MissingLens::NoPerspective }
    }

    /// Returns the number of its slots of view constants: for the views, the panel and the primary
    /// view.
    pub(in crate::intercept::vk) fn slots(&self) -> u32 {
        2 + if self.facts.in_views { self.layout.views.len() as u32 } else { 0 }
    }

    /// True if a part of it may be visible with a slot of view constants.
    pub(in crate::intercept::vk) fn is_in_sight(&self, slot: u32) -> bool {
        self.in_sight >> slot.min(63) & 1 == 1
    }

    /// True if draws are issued onto the panel. They are not if all views have the program's own
    /// lens.
    pub fn is_on_panel(&self) -> bool {
        !self.facts.off_screen && !self.layout.shows_own_lens()
    }

    /// Returns the number of slots that draws are issued with, and the number of those in which
    /// they are in sight.
    pub(in crate::intercept::vk) fn times(&self) -> [u32; 2] {
        let (panel, own) = (self.slots() - 2, self.slots() - 1);
        let panel = self.is_on_panel().then_some(panel);
        let issued = (0..self.slots() - 2).chain(panel).chain(self.layout.primary.map(|_| own));
        [issued.clone().count(), issued.filter(|slot| self.is_in_sight(*slot)).count()].map(|times| times as u32)
    }

    /// True if a draw with these facts belongs to the group.
    pub fn takes(&self, layout: &Arc<AtlasLayout>, facts: &DrawFacts) -> bool {
        Arc::ptr_eq(&self.layout, layout) && self.facts == *facts
    }
}

/// Counts for the statistics.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// Draws of the program to its window.
    pub(in crate::intercept::vk) seen: u64,
    /// Flat draws.
    pub(in crate::intercept::vk) flat: u64,
    /// Draws that were issued to each view.
    pub(in crate::intercept::vk) in_views: u64,
    /// Draws of these that went to images of off-screen scenes.
    pub(in crate::intercept::vk) duplicated: u64,
    /// Number of times that a draw was left out of a view or the panel, because it is out of sight
    /// there, or because only other machines show the view.
    pub(in crate::intercept::vk) left_out: u64,
    /// Number of draws by the way in which their lens was found.
    pub(in crate::intercept::vk) found: BTreeMap<&'static str, u64>,
    /// Number of draws without a lens, by the reason.
    pub(in crate::intercept::vk) missing: MissingLenses,
}

/// State of the frame that is being submitted.
#[derive(Default)]
pub struct Frame {
    pub(in crate::intercept::vk) cameras: Cameras,
    pub(in crate::intercept::vk) layout: Option<Arc<AtlasLayout>>,
    /// Matrices that show a part of the panel in each view, for flat drawing behind the scene.
    pub(in crate::intercept::vk) behind: Vec<ReprojectionMatrix>,
    /// This part; `None`: the matrices are not computed yet.
    pub(in crate::intercept::vk) behind_part: Option<PanelPart>,
    /// The lens for which samples were counted last, and their number.
    pub(in crate::intercept::vk) sampled: Option<(Intrinsics, f64)>,
    pub(in crate::intercept::vk) order: FrameOrder,
    /// Test whether none of the program's draws is recognised as a scene.
    pub(in crate::intercept::vk) flat_program: FlatProgram,
    pub(in crate::intercept::vk) small_window: SmallWindow,
    /// Counts for the statistics.
    pub(in crate::intercept::vk) counts: Counts,
}

impl Frame {
    /// The lenses that the views are drawn with.
    pub fn cameras(&self) -> &Cameras {
        &self.cameras
    }

    /// The message for a program without a scene, if there was one.
    pub fn flat_note(&self) -> Option<&str> {
        self.flat_program.note()
    }

    /// Counts for the statistics.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }
}
