//! Coverage of draws to the window that sample an image of another shape. Such a draw may show a
//! scene between the widgets of a toolkit, or something like a map in a corner.
//!
//! Occlusion queries measure this once for each kind of draw. They are reset when a pass to the
//! window begins, and read when they have run.

use crate::intercept::scene::viewport::parts::{ARMS, Picture};
use crate::intercept::vk::offscreen::scene_graph::{self, Cover};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::images::Images;
use crate::intercept::vk::state::images::coverage::{QueryBlock, Signature, State};
use crate::intercept::vk::state::images::scene_graph::Made;
use crate::intercept::vk::state::recording::Recording;
use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect};
use crate::lock::Lock;
use ash::vk;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Greatest number of kinds of draws. Of more the oldest are forgotten.
const GREATEST: usize = 64;

/// Number of passes in which a kind of draw may be missing before it is not looked for any more.
const PATIENCE: u32 = 600;

/// Number of queries of a measurement.
const QUERIES: u32 = 1 + ARMS as u32;

/// What a draw to the window shows of images of another shape.
pub enum Shown {
    /// Nothing, as far as is known.
    Nothing,
    /// A scene, in this large part of the window.
    Part(AtlasRect),
    /// A picture in a small part of the window.
    Small,
    /// It is not known, and will be measured.
    Unknown,
    /// It is measured now, with these queries.
    Measured(Arc<QueryBlock>),
}

impl Shown {
    /// The part of the window that gets a scene.
    pub fn part(&self) -> Option<AtlasRect> {
        if let Self::Part(part) = self { Some(*part) } else { None }
    }

    /// The queries that measure the draw.
    pub fn queries(&self) -> Option<Arc<QueryBlock>> {
        if let Self::Measured(block) = self { Some(Arc::clone(block)) } else { None }
    }

    /// Returns the result of the draw, which samples `image`, if that matters. `cover`: the area that
    /// the draw covers.
    pub fn made(&self, device: &Device, image: vk::Image, cover: Cover) -> Option<Made> {
        match self {
            _ if device.images.is_window_shaped(image) => cover.made(device, image, Made::Window),
            Self::Part(_) => Some(Made::Window),
            Self::Small => Some(Made::Elsewhere),
            Self::Unknown | Self::Measured(_) => None,
            Self::Nothing => cover.made(device, image, Made::Window),
        }
    }

    /// True if the draw is flat, at least until more is known.
    pub fn is_flat(&self) -> bool {
        matches!(self, Self::Small | Self::Unknown | Self::Measured(_))
    }
}

/// What has to be known of a draw before it is measured.
pub struct Measurable {
    pub(in crate::intercept::vk) pipeline: vk::Pipeline,
    pub(in crate::intercept::vk) viewport: vk::Viewport,
    pub(in crate::intercept::vk) scissor: vk::Rect2D,
    /// True if the viewport shows the main picture.
    pub(in crate::intercept::vk) main_picture: bool,
    /// True if its samples may be counted: it can be repeated, and depends on no place in the window.
    pub(in crate::intercept::vk) repeats: bool,
}

/// Determines what a draw of a few vertices to the window shows. Its repetition must change nothing.
pub fn look(device: &Device, recording: &Recording, layout: &AtlasLayout, draw: &Measurable) -> Shown {
    let images = images(device, recording);
    // A pass over a scene of the window's shape may sample other pictures, too.
    let of_window =
        || scene_graph::pictures(device, recording).iter().any(|image| device.images.is_window_shaped(*image));
    if images.is_empty() || of_window() || layout.views.iter().any(|view| view.own_lens) {
        return Shown::Nothing;
    }
    let coverage = &device.images.coverage;
    if !draw.main_picture {
        return small(device, images);
    }
    if !draw.repeats || !device.role.counts_samples {
        return Shown::Nothing;
    }
    let vk::Viewport { x, y, width, height, .. } = draw.viewport;
    let (viewport, scissor, window) = ([x, y, width, height], draw.scissor, layout.window);
    let signature = Signature { pipeline: draw.pipeline, images, viewport, scissor, window };
    let mut kinds = coverage.kinds.locked();
    let Some((_, state)) = kinds.iter_mut().find(|(known, _)| *known == signature) else {
        if kinds.len() >= GREATEST {
            kinds.remove(0);
        }
        let state = block(device).map_or(State::Unmeasured, |block| State::Wanted(block, 0));
        kinds.push((signature, state));
        return Shown::Unknown;
    };
    let ready = |block: &Arc<QueryBlock>| {
        recording.counting == 0 && recording.measures.iter().any(|known| Arc::ptr_eq(known, block))
    };
    match state {
        State::Wanted(block, _) if ready(block) => {
            let block = Arc::clone(block);
            *state = State::Measured(Arc::clone(&block));
            Shown::Measured(block)
        }
        State::Wanted(..) | State::Measured(_) => Shown::Unknown,
        State::Unmeasured => Shown::Nothing,
        State::Known(None) => small(device, signature.images),
        State::Known(Some(part)) => shown(device, layout, &signature.images, *part),
    }
}

/// Notes that images are shown in a small part of the window.
fn small(device: &Device, images: Vec<vk::Image>) -> Shown {
    device.images.coverage.small.locked().extend(images);
    Shown::Small
}

/// Returns what a draw shows that fills this `part` of the window.
fn shown(device: &Device, layout: &AtlasLayout, images: &[vk::Image], part: AtlasRect) -> Shown {
    let sizes = images.iter().filter_map(|image| device.images.size(*image));
    if !sizes.into_iter().any(|size| device.images.may_fill_part(size, part, layout)) {
        return Shown::Nothing;
    }
    if device.images.note_part(part.into()) {
        device.scene_graph.look_again();
    }
    Shown::Part(part)
}

/// Returns the images that the next draw can sample, that passes may draw to, and that have another
/// shape than the window.
fn images(device: &Device, recording: &Recording) -> Vec<vk::Image> {
    let views = scene_graph::views_by(device, recording, |set| device.descriptors.pictures(set));
    let images = views.into_iter().filter_map(|view| device.images.of(view));
    images.filter(|image| device.images.may_be_shown_in_part(*image)).collect()
}

/// Makes the queries of a measurement; `None` if the driver refuses them.
fn block(device: &Device) -> Option<Arc<QueryBlock>> {
    let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::OCCLUSION).query_count(QUERIES);
    // SAFETY: the device is live.
    let pool = unsafe { device.driver.functions.create_query_pool(&info, None) }.ok()?;
    let block = Arc::new(QueryBlock { pool, submitted: false.into() });
    device.images.coverage.blocks.locked().push(Arc::clone(&block));
    Some(block)
}

/// Resets the queries for the draws that have to be measured in the pass to the window that begins.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass.
pub unsafe fn prepare(device: &Device, buffer: vk::CommandBuffer) {
    let mut ready = Vec::new();
    for (_, state) in device.images.coverage.kinds.locked().iter_mut() {
        match state {
            State::Wanted(_, passes) if *passes > PATIENCE => *state = State::Unmeasured,
            State::Wanted(block, passes) => {
                *passes += 1;
                // SAFETY: as promised; the queries are Cupola's.
                unsafe { device.driver.functions.cmd_reset_query_pool(buffer, block.pool, 0, QUERIES) };
                ready.push(Arc::clone(block));
            }
            _ => {}
        }
    }
    if !ready.is_empty() {
        device.recordings.with(buffer, |recording| recording.measures.append(&mut ready));
    }
}

/// Reads the results of measurements that have ended, and destroys queries that nothing uses.
pub fn take_results(device: &Device) {
    let coverage = &device.images.coverage;
    for (signature, state) in coverage.kinds.locked().iter_mut() {
        let State::Measured(block) = state else { continue };
        if let Some(counts) = results(device, block) {
            *state = State::Known(rectangle(signature.window, counts));
        } else if !block.submitted.load(Ordering::Relaxed) && Arc::strong_count(block) == 2 {
            // The commands were recorded anew before they ran.
            *state = State::Wanted(Arc::clone(block), 0);
        }
    }
    let unused: Vec<_> = coverage.blocks.locked().extract_if(.., |block| Arc::strong_count(block) == 1).collect();
    unused.iter().for_each(|block| destroy(device, block));
}

/// Returns the number of samples of a draw, and the numbers in the arms of the cross, if they are
/// there.
fn results(device: &Device, block: &QueryBlock) -> Option<[i64; QUERIES as usize]> {
    let mut counts = [0_i64; QUERIES as usize];
    let submitted = block.submitted.load(Ordering::Relaxed);
    let functions = &device.driver.functions;
    let flags = vk::QueryResultFlags::TYPE_64;
    // SAFETY: the queries are Cupola's, and were reset by the submitted commands.
    submitted.then(|| unsafe { functions.get_query_pool_results(block.pool, 0, &mut counts, flags) })?.ok()?;
    Some(counts)
}

/// Returns the large rectangle of a window that a draw fills, by its samples and those in the arms
/// of a cross. `None`: it fills none.
fn rectangle(window: (u32, u32), [all, arms @ ..]: [i64; QUERIES as usize]) -> Option<AtlasRect> {
    let [left, right, up, down] = arms;
    // In a filled rectangle the number of samples per pixel follows from the counts. Of other shapes
    // it makes no large rectangle.
    let samples = ((left + right) * (up + down) + all / 2).checked_div(all)?.max(1);
    let picture = Picture { size: window.into(), samples };
    picture.rectangle(arms, all).map(AtlasRect::from)
}

fn destroy(device: &Device, block: &QueryBlock) {
    // SAFETY: queries of Cupola that no commands use any more.
    unsafe { device.driver.functions.destroy_query_pool(block.pool, None) };
}

impl Images {
    /// Forgets what is known of draws that sample an image.
    pub(super) fn forget_coverage(&self, image: vk::Image) {
        self.coverage.kinds.locked().retain(|(signature, _)| !signature.images.contains(&image));
        self.coverage.small.locked().remove(&image);
    }

    /// Destroys all queries of measurements, before the device is destroyed.
    pub(super) fn clear_coverage(&self, device: &Device) {
        self.coverage.kinds.locked().clear();
        self.coverage.blocks.locked().drain(..).for_each(|block| destroy(device, &block));
    }
}

#[cfg(test)]
mod tests {
    use super::{AtlasRect, rectangle};

    #[test]
    fn a_rectangle_is_found_with_any_number_of_samples() {
        let part = AtlasRect { x: 32, y: 24, width: 224, height: 192 };
        for samples in [1, 2, 4, 8] {
            let counts = [224 * 192, 96, 128, 104, 88].map(|count| count * samples);
            assert_eq!(rectangle((256, 256), counts), Some(part), "{samples}");
        }
    }

    #[test]
    fn other_shapes_and_small_rectangles_are_none() {
        for counts in [
            // Nothing, a disc, a frame without its middle, and half of a rectangle's pixels.
            [0; 5],
            [39408, 112, 112, 112, 112],
            [224 * 192, 0, 0, 0, 0],
            [224 * 96, 96, 128, 104, 88],
            [128 * 128, 64, 64, 64, 64],
        ] {
            assert_eq!(rectangle((256, 256), counts), None, "{counts:?}");
        }
    }
}
