//! Images and buffers that a shader reads and writes.

mod without_writes;

pub use without_writes::without_writes;

use crate::intercept::vk::spirv::module::{Declarations, Instruction, instructions};
use crate::intercept::vk::spirv::texels::DescriptorPlace;
use spirv::{Decoration, Dim, Op, StorageClass};
use std::collections::{BTreeSet, HashMap};

/// Kind of a compute shader's writes to buffers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum BufferWrites {
    /// Nothing.
    #[default]
    Nothing,
    /// Sums and other results of atomic instructions.
    Sums,
    /// Values at positions.
    Places,
}

/// Images and buffers that a shader reads and writes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ComputeUse {
    /// Descriptors of the images that it samples, fetches from or loads.
    pub read: Vec<DescriptorPlace>,
    /// Descriptors of the images that it stores to.
    pub written: Vec<DescriptorPlace>,
    /// True if it changes images by atomic instructions.
    pub image_atomics: bool,
    /// Kind of its writes to buffers.
    pub buffers: BufferWrites,
}

/// Greatest number of steps in the search for the origins of a value.
const MOST_STEPS: usize = 256;

/// Greatest depth of chains of pointers, or of calls, that is followed.
const DEEPEST: usize = 16;

/// Returns the images and buffers that a shader reads and writes; in doubt, all that it can. `None`
/// if `words` are no module.
pub fn compute_use(words: &[u32]) -> Option<ComputeUse> {
    let all = instructions(words)?;
    let declared = Declarations::new(&all);
    let (read, written) = images(&all, &declared);
    Some(ComputeUse {
        read: read.into_iter().collect(),
        written: written.into_iter().collect(),
        image_atomics: all.iter().any(|i| i.is(Op::ImageTexelPointer)),
        buffers: buffers(&all, &declared),
    })
}

/// Returns an image variable's descriptor, and whether shaders can store to it.
fn image(declared: &Declarations<'_>, variable: u32) -> Option<(DescriptorPlace, bool)> {
    let (class, mut kind) = declared.pointee(variable)?;
    if class != StorageClass::UniformConstant as u32 {
        return None;
    }
    for _ in 0..DEEPEST {
        let array = declared.get(kind, Op::TypeArray).or_else(|| declared.get(kind, Op::TypeRuntimeArray));
        let sampled = declared.get(kind, Op::TypeSampledImage);
        match array.or(sampled) {
            Some(of) => kind = of.operand(1),
            None => break,
        }
    }
    // Operands: type, dimension, depth, layers, samples, whether it is sampled.
    let of_image = declared.get(kind, Op::TypeImage).filter(|image| image.operand(2) != Dim::DimBuffer as u32)?;
    let number = |kind| declared.number(variable, None, kind).unwrap_or(0);
    Some(((number(Decoration::DescriptorSet), number(Decoration::Binding)), of_image.operand(6) == 2))
}

fn images(
    all: &[Instruction<'_>],
    declared: &Declarations<'_>,
) -> (BTreeSet<DescriptorPlace>, BTreeSet<DescriptorPlace>) {
    let variables: Vec<u32> = all
        .iter()
        .take_while(|i| !i.is(Op::Function))
        .filter(|i| i.is(Op::Variable) && image(declared, i.operand(1)).is_some())
        .map(|i| i.operand(1))
        .collect();
    let from = Origins::of(all);
    let (mut read, mut written) = (BTreeSet::new(), BTreeSet::new());
    let mut note = |used: u32, writes: Option<bool>| {
        let found = from.variables(used, &variables).unwrap_or_else(|| variables.clone());
        for variable in found {
            let Some((place, stored)) = image(declared, variable) else { continue };
            let may = |kind| declared.decoration(variable, None, kind).is_none();
            if writes != Some(true) && (!stored || may(Decoration::NonReadable)) {
                read.insert(place);
            }
            if writes != Some(false) && stored && may(Decoration::NonWritable) {
                written.insert(place);
            }
        }
    };
    for i in all.iter().skip_while(|i| !i.is(Op::Function)) {
        match Op::from_u32(i.opcode) {
            Some(Op::ImageWrite) => note(i.operand(0), Some(true)),
            Some(Op::ImageTexelPointer) => note(i.operand(2), None),
            Some(Op::ImageRead | Op::ImageSparseRead | Op::ImageFetch | Op::ImageSparseFetch) => {
                note(i.operand(2), Some(false));
            }
            // All instructions that sample or gather.
            Some(op)
                if (Op::ImageSampleImplicitLod as u32..=Op::ImageDrefGather as u32).contains(&(op as u32))
                    || (Op::ImageSparseSampleImplicitLod as u32..=Op::ImageSparseDrefGather as u32)
                        .contains(&(op as u32)) =>
            {
                note(i.operand(2), Some(false));
            }
            _ => {}
        }
    }
    (read, written)
}

/// Origins of images and of pointers to them.
struct Origins {
    from: HashMap<u32, u32>,
    arguments: HashMap<u32, Vec<u32>>,
}

impl Origins {
    fn of(all: &[Instruction<'_>]) -> Self {
        let (mut from, mut arguments) = (HashMap::new(), HashMap::<u32, Vec<u32>>::new());
        let mut parameters: HashMap<u32, Vec<u32>> = HashMap::new();
        let mut function = 0;
        for i in all {
            match Op::from_u32(i.opcode) {
                Some(Op::Function) => function = i.operand(1),
                Some(Op::FunctionParameter) => parameters.entry(function).or_default().push(i.operand(1)),
                Some(
                    Op::Load
                    | Op::Image
                    | Op::CopyObject
                    | Op::SampledImage
                    | Op::AccessChain
                    | Op::InBoundsAccessChain,
                ) => _ = from.insert(i.operand(1), i.operand(2)),
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

    /// Returns the variables of `known` that a value comes from; `None` if it may come from another
    /// one.
    fn variables(&self, id: u32, known: &[u32]) -> Option<Vec<u32>> {
        let (mut open, mut found) = (vec![(id, DEEPEST)], Vec::new());
        let mut left = MOST_STEPS;
        while let Some((id, depth)) = open.pop() {
            left = left.checked_sub(1)?;
            if known.contains(&id) {
                found.push(id);
                continue;
            }
            let depth = depth.checked_sub(1)?;
            match (self.from.get(&id), self.arguments.get(&id)) {
                (Some(from), _) => open.push((*from, depth)),
                (None, Some(arguments)) => open.extend(arguments.iter().map(|argument| (*argument, depth))),
                (None, None) => return None,
            }
        }
        Some(found)
    }
}

/// Storage classes of the pointers of a module.
struct Pointers(HashMap<u32, u32>);

impl Pointers {
    fn of(all: &[Instruction<'_>], declared: &Declarations<'_>) -> Self {
        let pointers = all.iter().filter(|i| i.operands.len() > 1);
        Self(
            pointers
                .filter_map(|i| Some((i.operand(1), declared.get(i.operand(0), Op::TypePointer)?.operand(1))))
                .collect(),
        )
    }

    /// Returns the storage class of a pointer.
    fn class(&self, pointer: u32) -> Option<u32> {
        self.0.get(&pointer).copied()
    }

    /// True if a pointer points into a buffer.
    fn in_buffer(&self, pointer: u32) -> bool {
        let buffers = [StorageClass::StorageBuffer, StorageClass::Uniform, StorageClass::PhysicalStorageBuffer];
        self.class(pointer).is_some_and(|class| buffers.iter().any(|known| *known as u32 == class))
    }
}

/// Returns the kind of writes through pointers into buffers, or to images of buffers.
fn buffers(all: &[Instruction<'_>], declared: &Declarations<'_>) -> BufferWrites {
    let pointers = Pointers::of(all, declared);
    let in_buffer = |pointer| pointers.in_buffer(pointer);
    let of_buffers = declared
        .by_id
        .values()
        .any(|i| i.is(Op::TypeImage) && (i.operand(2), i.operand(6)) == (Dim::DimBuffer as u32, 2));
    let written = |i: &Instruction<'_>| match Op::from_u32(i.opcode) {
        Some(Op::Store | Op::CopyMemory | Op::CopyMemorySized) if in_buffer(i.operand(0)) => BufferWrites::Places,
        Some(Op::ImageWrite) if of_buffers => BufferWrites::Places,
        Some(Op::AtomicStore) if in_buffer(i.operand(0)) => BufferWrites::Sums,
        Some(op)
            if (Op::AtomicExchange as u32..=Op::AtomicXor as u32).contains(&(op as u32)) && in_buffer(i.operand(2)) =>
        {
            BufferWrites::Sums
        }
        Some(Op::AtomicFAddEXT | Op::AtomicFMaxEXT | Op::AtomicFMinEXT) if in_buffer(i.operand(2)) => {
            BufferWrites::Sums
        }
        _ => BufferWrites::Nothing,
    };
    all.iter().skip_while(|i| !i.is(Op::Function)).map(written).max().unwrap_or_default()
}
