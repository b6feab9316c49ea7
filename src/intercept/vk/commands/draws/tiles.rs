//! A draw into a tile of the atlas: viewport and scissor, pipeline, view constants and descriptor
//! sets.

use crate::correct::single::pixels;
use crate::intercept::scene;
use crate::intercept::vk::commands::bound_state::set_window;
use crate::intercept::vk::commands::draws::rebind::rebind;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::pipelines::{Pipeline, Variants};
use crate::intercept::vk::state::recording::Recording;
use crate::intercept::vk::state::recording::draw_parameters::IndirectDraw;
use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect, ViewTile};
use crate::intercept::vk::state::views::view_constants::ChunkOffset;
use ash::vk;
use std::sync::Arc;

/// Copies of one of the program's descriptor sets, one for each view. In a view, shaders read that
/// view's copy of an off-screen scene, and the atlas copies of attachments.
pub struct PerViewSet {
    /// Number of the set.
    pub(in crate::intercept::vk) number: u32,
    /// One copy for each view.
    pub(in crate::intercept::vk) sets: Arc<[vk::DescriptorSet]>,
    /// Dynamic offsets of the program's set.
    pub(in crate::intercept::vk) dynamic: Vec<u32>,
    /// True if the set has attachments. The program's own set then fits no pass that draws to the
    /// atlas.
    pub(in crate::intercept::vk) attachments: bool,
}

/// Viewport and scissor of the program for a draw.
pub struct ProgramWindow {
    pub(in crate::intercept::vk) viewport: vk::Viewport,
    pub(in crate::intercept::vk) scissor: vk::Rect2D,
}

impl ProgramWindow {
    /// Returns those that commands set, or those of the pipeline, or the whole window.
    pub fn of(recording: &Recording, pipeline: &Pipeline, layout: &AtlasLayout) -> Self {
        let (width, height) = (pixels(layout.window.0 as i32), pixels(layout.window.1 as i32));
        let viewport = vk::Viewport { x: 0.0, y: 0.0, width, height, min_depth: 0.0, max_depth: 1.0 };
        let scissor = vk::Extent2D { width: layout.window.0, height: layout.window.1 }.into();
        Self {
            viewport: pipeline.viewport.or(recording.graphics.viewport).unwrap_or(viewport),
            scissor: pipeline.scissor.or(recording.graphics.scissor).unwrap_or(scissor),
        }
    }
}

impl ProgramWindow {
    /// True if the scissor cuts nothing of the viewport in an image of this size.
    pub fn is_uncut(&self, (width, height): (u32, u32)) -> bool {
        let Self { viewport: v, scissor: s } = self;
        let axis = |(start, length): (f32, f32), size: u32, offset: i32, extent: u32| {
            let (start, end) = (f64::from(start), f64::from(start) + f64::from(length));
            let (start, end) = (start.min(end).max(0.0), start.max(end).min(size.into()));
            f64::from(offset) <= start && end <= f64::from(offset) + f64::from(extent)
        };
        axis((v.x, v.width), width, s.offset.x, s.extent.width)
            && axis((v.y, v.height), height, s.offset.y, s.extent.height)
    }
}

/// Draws into the tiles of an atlas.
pub struct TileDraws<'a> {
    pub(in crate::intercept::vk) device: &'a Device,
    pub(in crate::intercept::vk) buffer: vk::CommandBuffer,
    pub(in crate::intercept::vk) recording: &'a mut Recording,
    pub(in crate::intercept::vk) pipeline: &'a Pipeline,
    pub(in crate::intercept::vk) variants: &'a Variants,
    pub(in crate::intercept::vk) constants: ChunkOffset,
    pub(in crate::intercept::vk) program: ProgramWindow,
    /// Size of the program's window.
    pub(in crate::intercept::vk) window: (u32, u32),
    /// The part of the program's window that fills all of each view; `None`: its viewport.
    pub(in crate::intercept::vk) part: Option<AtlasRect>,
    /// True if the viewport is a part of an image off screen. It is the same part of each view's image.
    pub(in crate::intercept::vk) spreads: bool,
    /// The draw's parameters in memory, if the device reads them from there.
    pub(in crate::intercept::vk) indirect: Option<IndirectDraw>,
}

impl TileDraws<'_> {
    /// Issues the draw into a tile with the pipeline `by`, the view constants of `slot` and the set
    /// copies for `view`. `issue` records the program's own draw.
    ///
    /// # Safety
    /// The command buffer is being recorded, in a pass that draws to the atlas.
    pub unsafe fn issue(
        &mut self,
        by: vk::Pipeline,
        slot: usize,
        tile: &ViewTile,
        sets: &[PerViewSet],
        view: usize,
        issue: &dyn Fn(),
    ) {
        // SAFETY: as promised; the parameters are those of this recording.
        unsafe {
            self.begin(by, slot, tile);
            self.bind(sets, view);
            match &self.indirect {
                Some(draw) => {
                    let chunks = &self.recording.constants.chunks;
                    draw.issue(&self.device.driver, self.buffer, chunks, slot as u32);
                }
                None => issue(),
            }
        }
    }

    /// Binds the pipeline and the view constants, and sets viewport and scissor.
    ///
    /// # Safety
    /// The command buffer is being recorded.
    unsafe fn begin(&mut self, by: vk::Pipeline, slot: usize, tile: &ViewTile) {
        let (device, buffer) = (self.device, self.buffer);
        let ProgramWindow { viewport, scissor } = &self.program;
        let (viewport, scissor) = match tile.own_lens {
            true => (move_to_tile(viewport, tile.rect), cut_to_tile(scissor, tile.rect, self.window)),
            false => {
                let (width, height) = (self.window.0 as i32, self.window.1 as i32);
                let whole = self.spreads.then_some(AtlasRect { x: 0, y: 0, width, height });
                let spread = self.part.or(whole).map(|part| spread(viewport, part, tile.rect));
                (spread.unwrap_or_else(|| fill_tile(viewport, tile.rect)), tile.rect.to_vk())
            }
        };
        // SAFETY: as promised.
        unsafe {
            let graphics = vk::PipelineBindPoint::GRAPHICS;
            let functions = &device.driver.functions;
            if self.recording.graphics.current != by {
                functions.cmd_bind_pipeline(buffer, graphics, by);
                self.recording.graphics.current = by;
            }
            set_window(device, buffer, &viewport, &scissor, self.pipeline.with_count);
            self.recording.graphics.disturbed = true;
            let chunk = self.recording.constants.chunks.get(self.constants.chunk);
            if let (Some(layout), Some(chunk)) = (&self.pipeline.layout, chunk) {
                let offset = self.constants.slot(slot as u32);
                let set = [chunk.set(layout.counts)];
                functions.cmd_bind_descriptor_sets(buffer, graphics, layout.handle, layout.ours, &set, &[offset]);
                self.recording.graphics.displace_from(layout.ours);
            }
        }
    }

    /// Binds the copies of the program's sets for a view.
    ///
    /// # Safety
    /// The command buffer is being recorded.
    unsafe fn bind(&mut self, sets: &[PerViewSet], view: usize) {
        let Some(layout) = &self.pipeline.layout else { return };
        for PerViewSet { number, sets, dynamic, .. } in sets {
            let Some(set) = sets.get(view) else { continue };
            let (functions, graphics) = (&self.device.driver.functions, vk::PipelineBindPoint::GRAPHICS);
            // SAFETY: as promised; the set has the layout of the program's set, which the program
            // bound under this number.
            unsafe {
                functions.cmd_bind_descriptor_sets(self.buffer, graphics, layout.handle, *number, &[*set], dynamic);
            }
        }
    }

    /// Binds the program's own sets again in place of their copies.
    ///
    /// # Safety
    /// The command buffer is being recorded.
    pub unsafe fn unbind(&mut self, sets: &[PerViewSet]) {
        let Some(first) = sets.first().map(|set| set.number) else { return };
        self.recording.graphics.displace_from(first);
        // SAFETY: as promised.
        unsafe { rebind(self.device, self.buffer, self.recording, self.pipeline) };
    }
}

/// True if a viewport shows the main picture of an image of this size.
pub fn is_main(viewport: &vk::Viewport, (width, height): (u32, u32)) -> bool {
    let area = f64::from(width) * f64::from(height);
    scene::viewport::is_main(viewport.width.into(), viewport.height.abs().into(), area)
}

/// True if a viewport is as large as an image of this size.
pub fn is_whole(viewport: &vk::Viewport, (width, height): (u32, u32)) -> bool {
    let corner = [viewport.x, viewport.y + viewport.height.min(0.0)];
    corner == [0.0; 2] && [viewport.width, viewport.height.abs()] == [width, height].map(|n| pixels(n as i32))
}

/// Returns a viewport moved to a tile.
pub fn move_to_tile(viewport: &vk::Viewport, tile: AtlasRect) -> vk::Viewport {
    vk::Viewport { x: viewport.x + pixels(tile.x), y: viewport.y + pixels(tile.y), ..*viewport }
}

/// Returns a viewport that fills a tile, with the same vertical orientation.
fn fill_tile(viewport: &vk::Viewport, AtlasRect { x, y, width, height }: AtlasRect) -> vk::Viewport {
    let (y, height) = if viewport.height < 0.0 { (y + height, -height) } else { (y, height) };
    vk::Viewport { x: pixels(x), y: pixels(y), width: pixels(width), height: pixels(height), ..*viewport }
}

/// Returns the viewport in which a part of the program's window fills a tile.
fn spread(viewport: &vk::Viewport, part: AtlasRect, tile: AtlasRect) -> vk::Viewport {
    let scale = |tile: i32, part: i32| pixels(tile) / pixels(part.max(1));
    let (across, down) = (scale(tile.width, part.width), scale(tile.height, part.height));
    vk::Viewport {
        x: pixels(tile.x) + (viewport.x - pixels(part.x)) * across,
        y: pixels(tile.y) + (viewport.y - pixels(part.y)) * down,
        width: viewport.width * across,
        height: viewport.height * down,
        ..*viewport
    }
}

/// Returns a scissor moved to a tile and clipped to the tile's part of the window.
pub fn cut_to_tile(scissor: &vk::Rect2D, tile: AtlasRect, window: (u32, u32)) -> vk::Rect2D {
    let axis = |offset: i32, extent: u32, window: u32, tile: i32| {
        let end = i64::from(offset) + i64::from(extent);
        let end = end.clamp(0, i64::from(window)) as i32;
        let start = offset.clamp(0, end);
        (tile + start, (end - start) as u32)
    };
    let (x, width) = axis(scissor.offset.x, scissor.extent.width, window.0, tile.x);
    let (y, height) = axis(scissor.offset.y, scissor.extent.height, window.1, tile.y);
    vk::Rect2D { offset: vk::Offset2D { x, y }, extent: vk::Extent2D { width, height } }
}

#[cfg(test)]
mod tests {
    use super::{ProgramWindow, cut_to_tile, fill_tile, spread};
    use crate::intercept::vk::state::views::atlas_layout::AtlasRect;
    use ash::vk;

    #[test]
    fn a_scissor_is_cut_at_the_window_and_moved() {
        let scissor =
            |x, y, width, height| vk::Rect2D { offset: vk::Offset2D { x, y }, extent: vk::Extent2D { width, height } };
        let tile = AtlasRect { x: 1000, y: 10, width: 200, height: 100 };
        assert_eq!(cut_to_tile(&scissor(20, 30, 50, 40), tile, (200, 100)), scissor(1020, 40, 50, 40));
        assert_eq!(cut_to_tile(&scissor(150, 0, 5000, u32::MAX), tile, (200, 100)), scissor(1150, 10, 50, 100));
        assert_eq!(cut_to_tile(&scissor(300, 0, 10, 10), tile, (200, 100)).extent.width, 0);
    }

    #[test]
    fn a_scissor_that_cuts_the_viewport_is_noticed() {
        let viewport = vk::Viewport { x: -10.0, y: 90.0, width: 200.0, height: -90.0, min_depth: 0.0, max_depth: 1.0 };
        let uncut = |x, y, width, height| {
            let scissor = vk::Rect2D { offset: vk::Offset2D { x, y }, extent: vk::Extent2D { width, height } };
            ProgramWindow { viewport, scissor }.is_uncut((160, 100))
        };
        assert!(uncut(0, 0, 160, 90) && uncut(-20, 0, i32::MAX as u32, u32::MAX));
        assert!(!uncut(1, 0, 159, 90) && !uncut(0, 0, 159, 90) && !uncut(0, 0, 160, 89) && !uncut(0, 1, 160, 90));
    }

    #[test]
    fn a_part_of_the_window_fills_the_tile() {
        let (part, tile) = (
            AtlasRect { x: 20, y: 30, width: 100, height: 50 },
            AtlasRect { x: 1000, y: 500, width: 200, height: 200 },
        );
        let given = vk::Viewport { x: 20.0, y: 30.0, width: 100.0, height: 50.0, min_depth: 0.25, max_depth: 1.0 };
        let window = vk::Viewport { x: 0.0, y: 90.0, width: 150.0, height: -90.0, ..given };
        let place = |v: vk::Viewport| [v.x, v.y, v.width, v.height, v.min_depth];
        assert_eq!(place(spread(&given, part, tile)), place(fill_tile(&given, tile)));
        assert_eq!(place(spread(&window, part, tile)), [960.0, 740.0, 300.0, -360.0, 0.25]);
    }

    #[test]
    fn an_upside_down_viewport_stays_so() {
        let given = vk::Viewport { x: 0.0, y: 90.0, width: 50.0, height: -90.0, min_depth: 0.25, max_depth: 1.0 };
        let filled = fill_tile(&given, AtlasRect { x: 100, y: 200, width: 30, height: 40 });
        assert_eq!((filled.y, filled.height, filled.min_depth), (240.0, -40.0, 0.25));
    }
}
