//! Fragment shaders that read images by texel coordinates or query their sizes. In each view they
//! get the texels and sizes of the program's images.
//!
//! In a view, an image of the scene has the size of the view, not the size that the program chose.
//! Coordinates of fetches are scaled to the size of the view, and sizes are scaled back. The
//! fragment's offset from the corner of its texel is added to the coordinates. So a shader that
//! fetches at its own position gets its own texel, whichever image is larger.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::spirv::functions::{Additions, push, push_code};
use crate::intercept::vk::spirv::module::{Declarations, Instruction, instructions, string};
use crate::intercept::vk::spirv::splice::{Entry, MOST_IDS, entry_point, put_into};
use spirv::{BuiltIn, Decoration, Dim, ExecutionModel, FunctionControl, ImageOperands, Op, StorageClass};
use std::collections::HashMap;

/// Greatest number of images of one shader that are followed.
pub const MOST_PICTURES: usize = 8;

/// Numbers of functions of GLSL's own set.
const FLOOR: u32 = 8;
const FRACTION: u32 = 10;

/// A descriptor: set and binding.
pub type DescriptorPlace = (u32, u32);

/// A shader in which fetches and sizes are changed.
pub struct Followed {
    /// Its words.
    pub words: Vec<u32>,
    /// Descriptors of the images that it fetches from or whose size it queries, in the order of
    /// their factors.
    pub pictures: Vec<DescriptorPlace>,
}

/// Returns `words` with fetches at the program's texels; `None` if the shader reads only by texture
/// coordinates. The uniform block at binding 0 of `set` has four floats at `offset`, those of
/// [`frag_coord`](super::frag_coord). Four more floats follow for each image: the factors from its
/// texels to those of a view, and from pixels of the program to its texels.
///
/// # Errors
/// What the shader does that cannot be followed, for the log.
pub fn texels(words: &[u32], entry: &str, set: u32, offset: u32) -> Result<Option<Followed>, Obstacle> {
    let all = instructions(words).ok_or("a shader that is not SPIR-V")?;
    let declared = Declarations::new(&all);
    let reads = Reads::of(&all, &declared);
    if reads.places.is_empty() && !reads.unknown {
        return Ok(None);
    }
    let (point, main) = entry_point(&all, ExecutionModel::Fragment, entry)?;
    let interface = point.rest(2 + string(point.rest(2)).1);
    let asks = |id: &u32| declared.number(*id, None, Decoration::BuiltIn) == Some(BuiltIn::FragCoord as u32);
    let given = interface.iter().copied().find(asks);
    let fetches = reads.unknown_fetch || reads.places.values().any(|place| place.is_fetch);
    if given.is_none() && !fetches {
        return Ok(None);
    }
    if all.iter().filter(|i| i.is(Op::EntryPoint)).count() > 1 {
        return Err("several entry points in a module that reads images by texel coordinates".into());
    }
    if reads.unknown || reads.pictures.len() > MOST_PICTURES {
        return Err("a shader that reads images by texel coordinates in a way that cannot be followed".into());
    }
    if words[3] > MOST_IDS {
        return Err("a shader with too many ids".into());
    }
    let mut additions = Additions::new(words[3], &declared);
    let ours = Ours::new(&mut additions, (set, offset), given);
    let numbers: Vec<u32> = (0..reads.pictures.len() as u32)
        .map(|number| {
            let id = additions.id();
            push(&mut additions.globals, Op::Constant, &[ours.int, id, number]);
            id
        })
        .collect();
    let scaling =
        Scaling { numbers, pair: ours.int_pair, texel: ours.texel(&mut additions), size: ours.size(&mut additions) };
    let inputs = given.is_none().then_some(ours.place).into_iter().collect();
    let entry = Entry { point, main, wrapper: None, variables: vec![ours.block], inputs };
    let change = |to: &mut Additions<'_>, i: &Instruction<'_>, out: &mut Vec<u32>| match reads.places.get(&i.offset) {
        None => i.operands.to_vec(),
        Some(read) if read.is_fetch => scaling.of_fetch(to, i, read, out),
        Some(read) => scaling.of_size(to, i, read, out),
    };
    let words = put_into(additions, words, &all, &entry, change);
    Ok(Some(Followed { words, pictures: reads.pictures }))
}

/// Ids for the changes of reads.
struct Scaling {
    /// Constants with the indices of the images.
    numbers: Vec<u32>,
    /// The type of two signed integers.
    pair: u32,
    /// The function from a texel of the program to a texel of a view.
    texel: u32,
    /// The function from the size of a view's image to the size of the program's.
    size: u32,
}

impl Scaling {
    /// Returns the operands of a fetch at the program's texel. The instructions that compute them
    /// go to `out`.
    fn of_fetch(&self, to: &mut Additions<'_>, i: &Instruction<'_>, read: &Read, out: &mut Vec<u32>) -> Vec<u32> {
        let mut operands = i.operands.to_vec();
        let given = match read.offset {
            // The offset is in texels of the program, too.
            Some(index) => {
                let sum = to.id();
                push(out, Op::IAdd, &[self.pair, sum, operands[3], operands.remove(index)]);
                operands[4] &= !OFFSETS.bits();
                sum
            }
            None => self.signed(to, read, operands[3], out),
        };
        let made = to.id();
        self.call(to, read, (self.texel, given, made), out);
        operands[3] = made;
        operands
    }

    /// As [`of_fetch`](Self::of_fetch), for a query of the size. The result is computed before the
    /// program's own query, whose result is not used.
    fn of_size(&self, to: &mut Additions<'_>, i: &Instruction<'_>, read: &Read, out: &mut Vec<u32>) -> Vec<u32> {
        let mut operands = i.operands.to_vec();
        let (asked, unused) = (to.id(), to.id());
        let mut query = operands.clone();
        query[1] = asked;
        push_code(out, i.opcode, &query);
        let given = self.signed(to, read, asked, out);
        self.call(to, read, (self.size, given, operands[1]), out);
        operands[1] = unused;
        operands
    }

    /// Converts the two integers of a read to signed ones.
    fn signed(&self, to: &mut Additions<'_>, read: &Read, id: u32, out: &mut Vec<u32>) -> u32 {
        if read.kind == self.pair {
            return id;
        }
        let cast = to.id();
        push(out, Op::Bitcast, &[self.pair, cast, id]);
        cast
    }

    /// Computes `result`, of the read's type, with a function of two signed integers.
    fn call(
        &self,
        to: &mut Additions<'_>,
        read: &Read,
        (function, given, result): (u32, u32, u32),
        out: &mut Vec<u32>,
    ) {
        let called = if read.kind == self.pair { result } else { to.id() };
        push(out, Op::FunctionCall, &[self.pair, called, function, given, self.numbers[read.picture]]);
        if called != result {
            push(out, Op::Bitcast, &[read.kind, result, called]);
        }
    }
}

/// An instruction that reads an image by texel coordinates or queries its size.
struct Read {
    is_fetch: bool,
    /// Index of the image.
    picture: usize,
    /// Type of the coordinates, or of the size.
    kind: u32,
    /// Index of the operand that is added to the coordinates.
    offset: Option<usize>,
}

/// Operands that are added to the coordinates.
const OFFSETS: ImageOperands = ImageOperands::CONST_OFFSET.union(ImageOperands::OFFSET);

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
struct Reads {
    /// Reads by the offset of the instruction.
    places: HashMap<usize, Read>,
    pictures: Vec<DescriptorPlace>,
    /// True if any read is of an unknown image.
    unknown: bool,
    /// True if any fetch is of an unknown image.
    unknown_fetch: bool,
}

impl Reads {
    fn of(all: &[Instruction<'_>], declared: &Declarations<'_>) -> Self {
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
    fn of(all: &[Instruction<'_>]) -> Self {
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

/// Types and variables of Cupola.
struct Ours {
    int: u32,
    int_pair: u32,
    pair: u32,
    vector: u32,
    /// Type of a pointer to four floats of the block.
    member: u32,
    block: u32,
    /// Constants with the indices of the block's members.
    members: [u32; 2],
    /// Variable with the driver's position of the fragment.
    place: u32,
    half: u32,
    glsl: u32,
}

impl Ours {
    fn new(to: &mut Additions<'_>, (set, offset): (u32, u32), given: Option<u32>) -> Self {
        let float = to.kind(Op::TypeFloat, &[32]);
        let int = to.kind(Op::TypeInt, &[32, 1]);
        let [pair, vector] = [2, 4].map(|count| to.kind(Op::TypeVector, &[float, count]));
        let int_pair = to.kind(Op::TypeVector, &[int, 2]);
        let [structure, array, count, of_block, member, block, zero, one, half, half_pair] =
            std::array::from_fn(|_| to.id());
        push(&mut to.globals, Op::Constant, &[int, count, MOST_PICTURES as u32]);
        push(&mut to.globals, Op::TypeArray, &[array, vector, count]);
        push(&mut to.globals, Op::TypeStruct, &[structure, vector, array]);
        let uniform = StorageClass::Uniform as u32;
        push(&mut to.globals, Op::TypePointer, &[of_block, uniform, structure]);
        push(&mut to.globals, Op::TypePointer, &[member, uniform, vector]);
        push(&mut to.globals, Op::Constant, &[int, zero, 0]);
        push(&mut to.globals, Op::Constant, &[int, one, 1]);
        push(&mut to.globals, Op::Constant, &[float, half, 0.5f32.to_bits()]);
        push(&mut to.globals, Op::ConstantComposite, &[pair, half_pair, half, half]);
        push(&mut to.globals, Op::Variable, &[of_block, block, uniform]);
        push(&mut to.decorations, Op::Decorate, &[array, Decoration::ArrayStride as u32, 16]);
        push(&mut to.decorations, Op::Decorate, &[structure, Decoration::Block as u32]);
        for (number, offset) in [(0, offset), (1, offset + 16)] {
            push(&mut to.decorations, Op::MemberDecorate, &[structure, number, Decoration::Offset as u32, offset]);
        }
        push(&mut to.decorations, Op::Decorate, &[block, Decoration::DescriptorSet as u32, set]);
        push(&mut to.decorations, Op::Decorate, &[block, Decoration::Binding as u32, 0]);
        let place = given.unwrap_or_else(|| {
            let [pointer, place] = std::array::from_fn(|_| to.id());
            let input = StorageClass::Input as u32;
            push(&mut to.globals, Op::TypePointer, &[pointer, input, vector]);
            push(&mut to.globals, Op::Variable, &[pointer, place, input]);
            let builtin = [place, Decoration::BuiltIn as u32, BuiltIn::FragCoord as u32];
            push(&mut to.decorations, Op::Decorate, &builtin);
            place
        });
        let glsl = to.glsl();
        Self { int, int_pair, pair, vector, member, block, members: [zero, one], place, half: half_pair, glsl }
    }

    /// Begins a function of two integers and of an image's index. Returns the function and these
    /// parameters.
    fn begin(&self, to: &mut Additions<'_>) -> (u32, u32, u32) {
        let function = to.kind(Op::TypeFunction, &[self.int_pair, self.int_pair, self.int]);
        let [made, given, picture, label] = std::array::from_fn(|_| to.id());
        push(&mut to.bodies, Op::Function, &[self.int_pair, made, FunctionControl::NONE.bits(), function]);
        push(&mut to.bodies, Op::FunctionParameter, &[self.int_pair, given]);
        push(&mut to.bodies, Op::FunctionParameter, &[self.int, picture]);
        push(&mut to.bodies, Op::Label, &[label]);
        (made, given, picture)
    }

    /// Adds an instruction with a result of this type.
    fn value(to: &mut Additions<'_>, op: Op, kind: u32, operands: &[u32]) -> u32 {
        let made = to.id();
        push(&mut to.bodies, op, &[&[kind, made], operands].concat());
        made
    }

    /// Loads four floats from the block. Returns the first two and the last two.
    fn halves(&self, to: &mut Additions<'_>, indices: &[u32]) -> [u32; 2] {
        let at = Self::value(to, Op::AccessChain, self.member, &[&[self.block], indices].concat());
        let all = Self::value(to, Op::Load, self.vector, &[at]);
        [[0, 1], [2, 3]].map(|[x, y]| Self::value(to, Op::VectorShuffle, self.pair, &[all, all, x, y]))
    }

    fn rounded_down(&self, to: &mut Additions<'_>, value: u32) -> u32 {
        let down = Self::value(to, Op::ExtInst, self.pair, &[self.glsl, FLOOR, value]);
        let result = Self::value(to, Op::ConvertFToS, self.int_pair, &[down]);
        push(&mut to.bodies, Op::ReturnValue, &[result]);
        push(&mut to.bodies, Op::FunctionEnd, &[]);
        result
    }

    /// Adds the function from a texel of the program to a texel of a view.
    fn texel(&self, to: &mut Additions<'_>) -> u32 {
        let (made, given, picture) = self.begin(to);
        let [offset, scale] = self.halves(to, &[self.members[0]]);
        let of_driver = Self::value(to, Op::Load, self.vector, &[self.place]);
        let corner = Self::value(to, Op::VectorShuffle, self.pair, &[of_driver, of_driver, 0, 1]);
        let moved = Self::value(to, Op::FSub, self.pair, &[corner, offset]);
        let own = Self::value(to, Op::FMul, self.pair, &[moved, scale]);
        let [factor, texels] = self.halves(to, &[self.members[1], picture]);
        let own = Self::value(to, Op::FMul, self.pair, &[own, texels]);
        let beside = Self::value(to, Op::ExtInst, self.pair, &[self.glsl, FRACTION, own]);
        let texel = Self::value(to, Op::ConvertSToF, self.pair, &[given]);
        let texel = Self::value(to, Op::FAdd, self.pair, &[texel, beside]);
        let texel = Self::value(to, Op::FMul, self.pair, &[texel, factor]);
        self.rounded_down(to, texel);
        made
    }

    /// Adds the function from the size of a view's image to the size of the program's image.
    fn size(&self, to: &mut Additions<'_>) -> u32 {
        let (made, given, picture) = self.begin(to);
        let [factor, _] = self.halves(to, &[self.members[1], picture]);
        let size = Self::value(to, Op::ConvertSToF, self.pair, &[given]);
        let size = Self::value(to, Op::FDiv, self.pair, &[size, factor]);
        let size = Self::value(to, Op::FAdd, self.pair, &[size, self.half]);
        self.rounded_down(to, size);
        made
    }
}
