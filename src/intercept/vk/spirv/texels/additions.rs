//! Additions of Cupola to a shader that reads images by texel coordinates: types, the uniform
//! block, and functions that convert texels and sizes.

use crate::intercept::vk::spirv::functions::{Additions, push};
use spirv::{BuiltIn, Decoration, FunctionControl, Op, StorageClass};

/// Greatest number of images of one shader that are followed.
pub const MOST_PICTURES: usize = 8;

/// Numbers of functions of GLSL's own set.
const FLOOR: u32 = 8;
const FRACTION: u32 = 10;

/// Types and variables of Cupola.
pub(super) struct Ours {
    pub(super) int: u32,
    pub(super) int_pair: u32,
    pair: u32,
    vector: u32,
    /// Type of a pointer to four floats of the block.
    member: u32,
    pub(super) block: u32,
    /// Constants with the indices of the block's members.
    members: [u32; 2],
    /// Variable with the driver's position of the fragment.
    pub(super) place: u32,
    half: u32,
    glsl: u32,
}

impl Ours {
    /// Declares them. `given`: the shader's own variable with the position of the fragment.
    pub(super) fn new(to: &mut Additions<'_>, (set, offset): (u32, u32), given: Option<u32>) -> Self {
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
    pub(super) fn texel(&self, to: &mut Additions<'_>) -> u32 {
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
    pub(super) fn size(&self, to: &mut Additions<'_>) -> u32 {
        let (made, given, picture) = self.begin(to);
        let [factor, _] = self.halves(to, &[self.members[1], picture]);
        let size = Self::value(to, Op::ConvertSToF, self.pair, &[given]);
        let size = Self::value(to, Op::FDiv, self.pair, &[size, factor]);
        let size = Self::value(to, Op::FAdd, self.pair, &[size, self.half]);
        self.rounded_down(to, size);
        made
    }
}
