//! Coverage of draws to the window that sample images of another shape: queries that measure it, and
//! what is known of each kind of draw.

use crate::intercept::vk::state::views::atlas_layout::AtlasRect;
use ash::vk;
use std::collections::HashSet;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

/// Queries that measure one draw: its samples, and those in each arm of a cross.
pub struct QueryBlock {
    pub(in crate::intercept::vk) pool: vk::QueryPool,
    /// True if commands with these queries were submitted.
    pub(in crate::intercept::vk) submitted: AtomicBool,
}

/// Properties that draws of equal coverage have in common.
#[derive(Clone, PartialEq)]
pub struct Signature {
    pub(in crate::intercept::vk) pipeline: vk::Pipeline,
    /// Sampled images that may hold a scene and have not the window's shape.
    pub(in crate::intercept::vk) images: Vec<vk::Image>,
    /// Place and size of the viewport.
    pub(in crate::intercept::vk) viewport: [f32; 4],
    pub(in crate::intercept::vk) scissor: vk::Rect2D,
    /// Size of the window.
    pub(in crate::intercept::vk) window: (u32, u32),
}

/// What is known of the coverage of a kind of draws.
pub(in crate::intercept::vk) enum State {
    /// Nothing; the number of passes that were prepared for a measurement.
    Wanted(Arc<QueryBlock>, u32),
    /// Nothing; the measurement was recorded.
    Measured(Arc<QueryBlock>),
    /// Nothing, and it cannot be measured.
    Unmeasured,
    /// The large rectangle of the window that they fill; `None`: they fill none.
    Known(Option<AtlasRect>),
}

/// Draws to the window that sample images of another shape.
#[derive(Default)]
pub struct Coverage {
    pub(in crate::intercept::vk) kinds: Mutex<Vec<(Signature, State)>>,
    /// Queries that recorded commands may use.
    pub(in crate::intercept::vk) blocks: Mutex<Vec<Arc<QueryBlock>>>,
    /// Images that are shown in a small part of the window.
    pub(in crate::intercept::vk) small: Mutex<HashSet<vk::Image>>,
}
