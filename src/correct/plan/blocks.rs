//! Rectangles of an output and the shader of each, found from the needs of its blocks.

use crate::cache::Cache;
use crate::correct::passes::mask::Mask;
use crate::correct::passes::output_pass::Batch;
use crate::correct::passes::source::Source;
use crate::correct::plan::examiner::Examiner;
use crate::correct::plan::needs::{self, Examined, Needs};
use crate::correct::plan::picture::Picture;
use crate::correct::plan::rectangles::{self, BLOCK};
use crate::geom::rectangle::PixelSpan;
use crate::rig::Rig;
use crate::views::{View, ViewPlan};

/// Greatest number of batches of an output that differ only in their neighbours and in the view
/// that they sample.
const MOST_OVERLAPS: usize = 6;
/// Least part of the blocks with overlapping pictures for such a batch. A shader for fewer blocks
/// costs more time to compile than it saves.
const LEAST_PART: f64 = 0.02;
/// Least number of blocks of such a batch. A software driver compiles a shader for overlapping
/// pictures in a tenth of a second; in that time it draws these blocks (12,288 pixels at about a
/// nanosecond) eight thousand times.
const LEAST_BLOCKS: usize = 48;

/// A class of blocks that share a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Class {
    /// One view everywhere.
    Plain(u32),
    /// Several views.
    Mixed,
    /// These neighbours overlap. `view`: the only view; `None` if there are several.
    Overlap { neighbours: u128, view: Option<u32> },
    /// Some pixels show nothing.
    Edge,
    /// Some pixels show nothing, and pictures overlap.
    EdgeOverlap,
}

/// Examines the blocks of output `index` of `rig`. Takes the result from `cache`, or stores it
/// there.
pub(in crate::correct) fn examine(
    rig: &Rig,
    index: usize,
    picture: &Picture,
    plan: &ViewPlan,
    cache: &Cache,
) -> Examined {
    let &Picture { size, flip, .. } = picture;
    let output_views = &plan.output_views[index];
    let examiner = Examiner::new(rig, picture, plan, output_views);
    let views: Vec<&View> = output_views.iter().map(|&view| &plan.views[view]).collect();
    let key = (&picture.source, size, examiner.filter, flip, &picture.content, &views);
    needs::cached(&key, examiner.blocks(), views.len(), cache, || examiner.all())
}

/// Returns a mask for output `index` of `rig` that is also black where no view shows the pixel's
/// direction; `None` if there is no such pixel.
pub(in crate::correct) fn mask_of_served(rig: &Rig, index: usize, picture: &Picture, plan: &ViewPlan) -> Option<Mask> {
    let served = Examiner::new(rig, picture, plan, &plan.output_views[index]).served();
    let is_complete = served.iter().all(|served| *served);
    (!is_complete).then(|| Mask::of_pixels(&served, picture.size, picture.mask.as_ref()))
}

/// Returns the batches of output `index` of `rig`, whose blocks have been `examined`.
///
/// The result is conservative. A batch lists every view that one of its pixels' centres samples,
/// and every neighbour whose picture reaches into it (except by a part of a pixel, where its weight
/// is 0). Blocks that show nothing, or that the mask makes black, are in no batch.
pub(in crate::correct) fn batches(
    rig: &Rig,
    index: usize,
    picture: &Picture,
    plan: &ViewPlan,
    examined: Examined,
) -> Vec<Batch> {
    let Picture { source, mask, .. } = picture;
    let (size, mask) = (picture.size, mask.as_ref());
    let output_views = &plan.output_views[index];
    let mut needs = examined.needs;
    // If light is added to black, masked pixels are not black.
    let output = &rig.outputs[index];
    let darkening = mask.filter(|_| output.blend.black_level == 0.0 && output.black.is_none());
    if let Some(mask) = darkening {
        needs_of_masked(&mut needs, mask, size);
    }
    // Shaders do not read a mask where it is white.
    let faded = |index: usize| mask.is_some_and(|mask| !mask.is_white(block_at(index, size), size));
    let (kinds, numbers) = kinds_of_blocks(&needs, faded);
    let mut rects = rectangles::merge(&numbers, BLOCK, size, kinds.len());
    if let Some(mask) = darkening {
        let faded = rects.iter_mut().zip(&kinds).filter(|(_, kind)| kind.faded);
        faded.flat_map(|(rects, _)| rects).for_each(|rect| *rect = mask.trimmed(*rect, size));
    }
    let neighbours = match source {
        Source::Projector(projector) => projector.neighbours.len(),
        _ => 0,
    };
    kinds
        .into_iter()
        .zip(rects)
        .map(|(BlockKind { needs, faded, .. }, rects)| Batch {
            views: (0..output_views.len())
                .filter(|&bit| needs.views >> bit.min(63) & 1 == 1)
                .map(|bit| output_views[bit])
                .collect(),
            neighbours: (0..neighbours).filter(|&bit| needs.neighbours >> bit.min(127) & 1 == 1).collect(),
            edge: needs.dark,
            masked: faded,
            rects,
            facets: None,
        })
        .collect()
}

/// Blocks that one batch draws.
struct BlockKind {
    class: Class,
    /// True if a mask is not white there.
    faded: bool,
    /// Combined needs of these blocks.
    needs: Needs,
}

/// Returns the kinds of blocks that show something, and the index of each block's kind.
/// `faded(index)`: a mask is not white in the block.
fn kinds_of_blocks(needs: &[Needs], faded: impl Fn(usize) -> bool) -> (Vec<BlockKind>, Vec<Option<usize>>) {
    let classes = with_fewer_overlaps(needs.iter().map(classify).collect());
    let mut kinds: Vec<BlockKind> = Vec::new();
    let numbers = needs.iter().zip(classes).enumerate().map(|(index, (needs, class))| {
        let (class, faded) = (class?, faded(index));
        let number = kinds.iter().position(|kind| (kind.class, kind.faded) == (class, faded)).unwrap_or_else(|| {
            kinds.push(BlockKind { class, faded, needs: Needs::default() });
            kinds.len() - 1
        });
        kinds[number].needs = kinds[number].needs.and(needs);
        Some(number)
    });
    let numbers = numbers.collect();
    (kinds, numbers)
}

/// Returns the block with this index, row by row.
fn block_at(index: usize, size: (u32, u32)) -> PixelSpan {
    let (columns, index) = (size.0.div_ceil(BLOCK), index as u32);
    let (x, y) = (index % columns * BLOCK, index / columns * BLOCK);
    PixelSpan::new(x, y, (x + BLOCK).min(size.0), (y + BLOCK).min(size.1))
}

/// Removes the needs of blocks that the mask makes black.
fn needs_of_masked(needs: &mut [Needs], mask: &Mask, size: (u32, u32)) {
    for (index, needs) in needs.iter_mut().enumerate() {
        if needs.lit && mask.is_black(block_at(index, size), size) {
            *needs = Needs { dark: true, ..Needs::default() };
        }
    }
}

fn classify(needs: &Needs) -> Option<Class> {
    needs.lit.then(|| match (needs.dark, needs.neighbours != 0) {
        (true, true) => Class::EdgeOverlap,
        (true, false) => Class::Edge,
        (false, true) => Class::Overlap { neighbours: needs.neighbours, view: needs.only_view() },
        (false, false) => needs.only_view().map_or(Class::Mixed, Class::Plain),
    })
}

/// Keeps the most frequent overlaps apart, since each neighbour and the choice of a view cost time
/// in every pixel, and unites the others, since each shader costs time to compile.
fn with_fewer_overlaps(mut classes: Vec<Option<Class>>) -> Vec<Option<Class>> {
    let mut overlaps: Vec<(u128, Option<u32>, usize)> = Vec::new();
    for class in &classes {
        if let Some(Class::Overlap { neighbours, view }) = *class {
            match overlaps.iter_mut().find(|entry| (entry.0, entry.1) == (neighbours, view)) {
                Some(entry) => entry.2 += 1,
                None => overlaps.push((neighbours, view, 1)),
            }
        }
    }
    overlaps.sort_by_key(|&(neighbours, view, count)| (std::cmp::Reverse(count), neighbours, view));
    let total: usize = overlaps.iter().map(|overlap| overlap.2).sum();
    let is_frequent = |count: usize| count >= LEAST_BLOCKS && count as f64 >= LEAST_PART * total as f64;
    let frequent = overlaps.iter().filter(|overlap| is_frequent(overlap.2)).count();
    let rare = &overlaps[frequent.min(MOST_OVERLAPS - 1)..];
    // The edge needs a shader for all neighbours anyway. If one of the two sets is small, this
    // shader serves both.
    let edge = classes.iter().filter(|class| **class == Some(Class::EdgeOverlap)).count();
    let few: usize = rare.iter().map(|overlap| overlap.2).sum();
    let with_edge = edge > 0 && edge.min(few) < LEAST_BLOCKS;
    // A single rare overlap keeps its class.
    if rare.len() > 1 || with_edge {
        let union = rare.iter().fold(0, |union, (neighbours, ..)| union | neighbours);
        let united = if with_edge { Class::EdgeOverlap } else { Class::Overlap { neighbours: union, view: None } };
        for class in &mut classes {
            if let Some(Class::Overlap { neighbours, view }) = *class
                && rare.iter().any(|other| (other.0, other.1) == (neighbours, view))
            {
                *class = Some(united);
            }
        }
    }
    classes
}
