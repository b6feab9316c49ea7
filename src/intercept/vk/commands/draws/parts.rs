//! Draws that show a scene in a part of the window, between widgets: the hole in the panel, and the
//! measurement that finds the part.

use crate::intercept::scene::viewport::parts::Picture;
use crate::intercept::vk::commands::draws::tiles::{TileDraws, cut_to_tile};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::images::coverage::QueryBlock;
use crate::intercept::vk::state::recording::Event;
use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect, ViewTile};
use ash::vk;
use std::sync::Arc;

/// Makes a part of the panel transparent, before a draw that fills it with a scene. The window is
/// the first colour of the pass.
///
/// # Safety
/// The command buffer is being recorded, within a pass that draws to the atlas.
pub unsafe fn clear_part(device: &Device, buffer: vk::CommandBuffer, layout: &AtlasLayout, part: AtlasRect) {
    let clear = vk::ClearAttachment {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        color_attachment: 0,
        clear_value: vk::ClearValue::default(),
    };
    let rect = vk::ClearRect { rect: part.moved_into(layout.panel).to_vk(), base_array_layer: 0, layer_count: 1 };
    // SAFETY: as promised; the part lies in the window, and the panel in the atlas.
    unsafe { device.driver.functions.cmd_clear_attachments(buffer, &[clear], &[rect]) };
}

/// Repeats a draw on the panel, and counts its samples: all, and those in each arm of a cross. `slot`:
/// the view constants that move nothing.
///
/// # Safety
/// The command buffer is being recorded, in a pass that draws to the atlas and before which the
/// queries were reset; no other query is active.
pub unsafe fn measure(
    tiles: &mut TileDraws<'_>,
    layout: &AtlasLayout,
    slot: usize,
    block: Arc<QueryBlock>,
    issue: &dyn Fn(),
) {
    let (functions, own) = (&tiles.device.driver.functions, tiles.program.scissor);
    let picture = Picture { size: layout.window.into(), samples: 1 };
    let whole = AtlasRect::from(picture.whole());
    let cut = |arm: AtlasRect| {
        let vk::Rect2D { offset, extent } = cut_to_tile(&own, whole, layout.window);
        let (right, bottom) = (offset.x + extent.width as i32, offset.y + extent.height as i32);
        let (x, y) = (offset.x.max(arm.x), offset.y.max(arm.y));
        let (width, height) = (right.min(arm.x + arm.width) - x, bottom.min(arm.y + arm.height) - y);
        AtlasRect { x, y, width, height }.to_vk()
    };
    let without_writes = tiles.variants.without_writes();
    let panel = ViewTile { rect: layout.panel, own_lens: true };
    let areas = std::iter::once(whole).chain(picture.arms().map(AtlasRect::from));
    for (query, area) in (0..).zip(areas) {
        tiles.program.scissor = cut(area);
        // SAFETY: as promised.
        unsafe {
            functions.cmd_begin_query(tiles.buffer, block.pool, query, vk::QueryControlFlags::PRECISE);
            tiles.issue(without_writes.panel, slot, &panel, &[], 0, issue);
            functions.cmd_end_query(tiles.buffer, block.pool, query);
        }
    }
    tiles.program.scissor = own;
    tiles.recording.events.push(Event::Measured(block));
}
