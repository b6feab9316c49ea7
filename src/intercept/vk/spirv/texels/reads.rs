//! Instructions that read images by texel coordinates or query their sizes, and the images that
//! they read.

use crate::intercept::vk::spirv::module::{Declarations, Instruction};
use spirv::{Decoration, Dim, ImageOperands, Op, StorageClass};
use std::collections::HashMap;

/// A descriptor: set and binding.
pub type DescriptorPlace = (u32, u32);

/// An instruction that reads an image by texel coordinates or queries its size.
pub(super) struct Read {
    pub(super) is_fetch: bool,
    /// Index of the image.
    pub(super) picture: usize,
    /// Type of the coordinates, or of the size.
    pub(super) kind: u32,
    /// Index of the operand that is added to the coordinates.
    pub(super) offset: Option<usize>,
}

/// Operands that are added to the coordinates.
pub(super) const OFFSETS: ImageOperands = ImageOperands::CONST_OFFSET.union(ImageOperands::OFFSET);

/// Returns the index of the offset of a fetch. It comes after the bias, the level and the two
/// gradients.
fn offset_index(fetch: &Instruction<'_>) -> Option<usize> {
    let given = ImageOperands::from_bits_truncate(fetch.operand(4));
    let before = given & (ImageOperands::BIAS | ImageOperands::LOD | ImageOperands::GRAD);
    let gradients = usize::from(given.contains(ImageOperands::GRAD));
    given.intersects(OFFSETS).then_some(5 + before.bits().count_ones() as usize + gradients)
}

/// Instructions of a shader that read two-dimensional images by texel coordinates or query their
/// size.
#[derive(Default)]
pub(super) struct Reads {
    /// Reads by the offset of the instruction.
    pub(super) places: HashMap<usize, Read>,
    pub(super) pictures: Vec<DescriptorPlace>,
    /// True if any read is of an unknown image.
    pub(super) unknown: bool,
    /// True if any fetch is of an unknown image.
    pub(super) unknown_fetch: bool,
}

impl Reads {
    /// Finds the reads of a shader.
    pub(super) fn of(all: &[Instruction<'_>], declared: &Declarations<'_>) -> Self {
        let mut reads = Self::default();
        let is_read =
            |i: &&Instruction<'_>| i.is(Op::ImageFetch) || i.is(Op::ImageQuerySizeLod) || i.is(Op::ImageQuerySize);
        if !all.iter().any(|i| is_read(&i)) {
            return reads;
        }
        let pairs: Vec<u32> = declared
            .by_id
            .iter()
            .filter(|(_, i)| i.is(Op::TypeVector) && i.operand(2) == 2)
            .filter(|(_, i)| declared.get(i.operand(1), Op::TypeInt).is_some_and(|int| int.operand(1) == 32))
            .map(|(id, _)| *id)
            .collect();
        // A result's type comes before the result.
        let typed: HashMap<u32, u32> = all
            .iter()
            .filter(|i| i.operands.len() > 1 && pairs.contains(&i.operand(0)))
            .map(|i| (i.operand(1), i.operand(0)))
            .collect();
        let sources = Sources::of(all);
        for i in all.iter().filter(is_read) {
            let is_fetch = i.is(Op::ImageFetch);
            let kind =
                if is_fetch { typed.get(&i.operand(3)) } else { pairs.iter().find(|kind| **kind == i.operand(0)) };
            // Images of one or three dimensions, and layers, are not views.
            let Some(kind) = kind.copied() else { continue };
            let variable = sources.variable(i.operand(2), DEEPEST);
            let place = variable.and_then(|variable| place_of(declared, variable));
            if let Some(Place::Other) = place {
                continue;
            }
            let offset = offset_index(i).filter(|_| is_fetch);
            let is_pair = |index: usize| i.operands.get(index).is_some_and(|id| typed.contains_key(id));
            let (Some(Place::Plain(place)), true) = (place, offset.is_none_or(is_pair)) else {
                reads.unknown = true;
                reads.unknown_fetch |= is_fetch;
                continue;
            };
            let known = reads.pictures.iter().position(|known| *known == place);
            let picture = known.unwrap_or(reads.pictures.len());
            if known.is_none() {
                reads.pictures.push(place);
            }
            reads.places.insert(i.offset, Read { is_fetch, picture, kind, offset });
        }
        reads
    }
}

/// Descriptor of a variable that holds an image.
enum Place {
    Plain(DescriptorPlace),
    /// Not an image of a view: it has several samples, is an attachment, or is written.
    Other,
}

fn place_of(declared: &Declarations<'_>, variable: u32) -> Option<Place> {
    let (class, mut kind) = declared.pointee(variable)?;
    if class != StorageClass::UniformConstant as u32 {
        return None;
    }
    if let Some(sampled) = declared.get(kind, Op::TypeSampledImage) {
        kind = sampled.operand(1);
    }
    // Operands: type, dimension, depth, layers, samples, whether it is sampled.
    let image = declared.get(kind, Op::TypeImage)?;
    let plain =
        (image.operand(2), image.operand(4), image.operand(5), image.operand(6)) == (Dim::Dim2D as u32, 0, 0, 1);
    let number = |kind| declared.number(variable, None, kind).unwrap_or(0);
    Some(if plain {
        Place::Plain((number(Decoration::DescriptorSet), number(Decoration::Binding)))
    } else {
        Place::Other
    })
}

/// Greatest depth of calls that is followed.
const DEEPEST: usize = 4;

/// Origins of images.
struct Sources {
    /// From a value that is loaded, or taken from a loaded one, to its source.
    from: HashMap<u32, u32>,
    /// Arguments that calls give to a parameter.
    arguments: HashMap<u32, Vec<u32>>,
}

impl Sources {
    pub(super) fn of(all: &[Instruction<'_>]) -> Self {
        let (mut from, mut arguments) = (HashMap::new(), HashMap::<u32, Vec<u32>>::new());
        let mut parameters: HashMap<u32, Vec<u32>> = HashMap::new();
        let mut function = 0;
        for i in all {
            match Op::from_u32(i.opcode) {
                Some(Op::Function) => function = i.operand(1),
                Some(Op::FunctionParameter) => parameters.entry(function).or_default().push(i.operand(1)),
                Some(Op::Load | Op::Image | Op::CopyObject) => _ = from.insert(i.operand(1), i.operand(2)),
                _ => {}
            }
        }
        for i in all.iter().filter(|i| i.is(Op::FunctionCall)) {
            let parameters = parameters.get(&i.operand(2)).into_iter().flatten();
            for (parameter, argument) in parameters.zip(i.rest(3)) {
                arguments.entry(*parameter).or_default().push(*argument);
            }
        }
        Self { from, arguments }
    }

    /// Returns the variable that a value or pointer comes from; `None` if there are several, or if
    /// it is a part of a variable.
    fn variable(&self, id: u32, depth: usize) -> Option<u32> {
        let mut id = id;
        for _ in 0..DEEPEST {
            match self.from.get(&id) {
                Some(from) => id = *from,
                None => break,
            }
        }
        let Some(arguments) = self.arguments.get(&id) else { return Some(id) };
        let depth = depth.checked_sub(1)?;
        let mut all = arguments.iter().map(|argument| self.variable(*argument, depth));
        let first = all.next()??;
        all.all(|other| other == Some(first)).then_some(first)
    }
}
