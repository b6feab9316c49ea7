//! Backgrounds: fragment shaders of draws that fill the program's picture before the scene.
//!
//! In a view, such a draw fills the tile as it fills the program's picture. Each fragment gets the
//! inputs of another place: of the direction that it shows, as the program's lens sees it. Inputs are
//! linear over a triangle without perspective, so their values at that place follow from the value
//! and the derivatives here. A function of Cupola, which becomes the entry point's function, gives
//! these values to variables that replace the inputs.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::spirv::frag_coord::{chains, private_pointers};
use crate::intercept::vk::spirv::functions::{Additions, push};
use crate::intercept::vk::spirv::module::{BOUND, Declarations, Instruction, instructions, string};
use crate::intercept::vk::spirv::splice::{Entry, MOST_IDS, entry_point, put_into};
use spirv::{BuiltIn, Decoration, ExecutionModel, FunctionControl, Op, SelectionControl, StorageClass};
use std::collections::HashMap;

/// Number of vectors of four floats in the view constants: three columns of the matrix from window
/// coordinates to directions, the lens, half of the tile's size with its centre, and the divisor of
/// heights with a number that is not 0 if inputs are replaced.
pub const BACKDROP_VECTORS: usize = 6;

/// Smallest divisor.
const LEAST: f32 = 1e-4;

/// Numbers of functions of GLSL.
const MAX: u32 = 40;
const CLAMP: u32 = 43;
const LENGTH: u32 = 66;

/// An input that is replaced.
struct Replaced {
    input: u32,
    /// Its type, and a pointer to a variable of this type.
    kind: u32,
    variable: u32,
    is_place: bool,
}

/// Returns `words` with inputs that can be replaced. The vectors of the view constants are at
/// `offset` in the uniform block at binding 0 of `set`.
///
/// # Errors
/// What the shader does that cannot be followed.
pub fn backdrop(words: &[u32], entry: &str, set: u32, offset: u32) -> Result<Vec<u32>, Obstacle> {
    let all = instructions(words).ok_or("a shader that is not SPIR-V")?;
    let declared = Declarations::new(&all);
    let (point, main) = entry_point(&all, ExecutionModel::Fragment, entry)?;
    if all.iter().filter(|i| i.is(Op::EntryPoint)).count() > 1 || words[BOUND] > MOST_IDS {
        return Err("several entry points in a module, or too many ids".into());
    }
    let interface = point.rest(2 + string(point.rest(2)).1);
    let mut additions = Additions::new(words[BOUND], &declared);
    let mut replaced = Vec::new();
    for input in interface {
        replaced.extend(to_replace(&mut additions, &declared, *input)?);
    }
    let mut found = Vec::new();
    for Replaced { input, .. } in &replaced {
        found.extend(chains(&all, *input)?);
    }
    let pointers = private_pointers(&mut additions, &declared, &found)?;
    let given = replaced.iter().find(|input| input.is_place).map(|input| input.input);
    let place = given.unwrap_or_else(|| frag_coord(&mut additions));
    let added = given.is_none().then_some(place);
    let (wrapper, block) = wrapper(&mut additions, &replaced, place, main, (set, offset));
    let variables = replaced.iter().map(|input| input.variable).chain([block]).collect();
    let entry = Entry { point, main, wrapper: Some(wrapper), variables, inputs: added.into_iter().collect() };
    let ours: HashMap<u32, u32> = replaced.iter().map(|input| (input.input, input.variable)).collect();
    let change = |_: &mut Additions<'_>, i: &Instruction<'_>, _: &mut Vec<u32>| {
        let mut operands = i.operands.to_vec();
        let chain = i.is(Op::AccessChain) || i.is(Op::InBoundsAccessChain);
        if let Some(variable) = ours.get(&i.operand(2)).filter(|_| chain || i.is(Op::Load)) {
            operands[2] = *variable;
            if let Some(pointer) = pointers.get(&i.operand(0)).filter(|_| chain) {
                operands[0] = *pointer;
            }
        }
        operands
    };
    Ok(put_into(additions, words, &all, &entry, change))
}

/// Returns the replacement of a variable of the entry point's interface; `None` if it stays.
///
/// # Errors
/// It is an input of a type that is not replaced.
fn to_replace(
    to: &mut Additions<'_>,
    declared: &Declarations<'_>,
    variable: u32,
) -> Result<Option<Replaced>, Obstacle> {
    let Some((class, kind)) = declared.pointee(variable).filter(|(class, _)| *class == StorageClass::Input as u32)
    else {
        return Ok(None);
    };
    let builtin = declared.number(variable, None, Decoration::BuiltIn);
    let is_place = builtin == Some(BuiltIn::FragCoord as u32);
    if builtin.is_some() && !is_place || declared.has(variable, Decoration::Flat as u32) {
        return Ok(None);
    }
    let element = declared.get(kind, Op::TypeVector).map_or(kind, |vector| vector.operand(1));
    if declared.get(element, Op::TypeFloat).is_none_or(|float| float.operand(1) != 32) {
        return Err(format!("a shader with an input of class {class} that is no vector of floats").into());
    }
    let [pointer, made] = [to.id(), to.id()];
    push(&mut to.globals, Op::TypePointer, &[pointer, StorageClass::Private as u32, kind]);
    push(&mut to.globals, Op::Variable, &[pointer, made, StorageClass::Private as u32]);
    Ok(Some(Replaced { input: variable, kind, variable: made, is_place }))
}

/// Returns a new variable with the driver's window coordinates.
fn frag_coord(to: &mut Additions<'_>) -> u32 {
    let float = to.kind(Op::TypeFloat, &[32]);
    let vector = to.kind(Op::TypeVector, &[float, 4]);
    let [pointer, variable] = [to.id(), to.id()];
    push(&mut to.globals, Op::TypePointer, &[pointer, StorageClass::Input as u32, vector]);
    push(&mut to.globals, Op::Variable, &[pointer, variable, StorageClass::Input as u32]);
    let builtin = [variable, Decoration::BuiltIn as u32, BuiltIn::FragCoord as u32];
    push(&mut to.decorations, Op::Decorate, &builtin);
    variable
}

/// Types and constants of Cupola's function.
struct Types {
    float: u32,
    pair: u32,
    triple: u32,
    vector: u32,
    import: u32,
}

/// Appends an instruction with a result to the functions. Returns the result.
fn value(to: &mut Additions<'_>, op: Op, kind: u32, operands: &[u32]) -> u32 {
    let id = to.id();
    push(&mut to.bodies, op, &[&[kind, id], operands].concat());
    id
}

fn constant(to: &mut Additions<'_>, kind: u32, bits: u32) -> u32 {
    let id = to.id();
    push(&mut to.globals, Op::Constant, &[kind, id, bits]);
    id
}

/// Adds the block of the view constants. Returns the variable, the type of a pointer to a member, and
/// the indices of the members.
fn block(to: &mut Additions<'_>, vector: u32, (set, offset): (u32, u32)) -> (u32, u32, [u32; BACKDROP_VECTORS]) {
    let int = to.kind(Op::TypeInt, &[32, 0]);
    let uniform = StorageClass::Uniform as u32;
    let [structure, of_block, member, variable] = std::array::from_fn(|_| to.id());
    let indices = std::array::from_fn(|index| constant(to, int, index as u32));
    push(&mut to.globals, Op::TypeStruct, &[&[structure], &[vector; BACKDROP_VECTORS][..]].concat());
    push(&mut to.globals, Op::TypePointer, &[of_block, uniform, structure]);
    push(&mut to.globals, Op::TypePointer, &[member, uniform, vector]);
    push(&mut to.globals, Op::Variable, &[of_block, variable, uniform]);
    push(&mut to.decorations, Op::Decorate, &[structure, Decoration::Block as u32]);
    for index in 0..BACKDROP_VECTORS as u32 {
        let at = [structure, index, Decoration::Offset as u32, offset + 16 * index];
        push(&mut to.decorations, Op::MemberDecorate, &at);
    }
    push(&mut to.decorations, Op::Decorate, &[variable, Decoration::DescriptorSet as u32, set]);
    push(&mut to.decorations, Op::Decorate, &[variable, Decoration::Binding as u32, 0]);
    (variable, member, indices)
}

/// Returns a function that sets Cupola's variables and calls `main`, and the variable of the view
/// constants.
fn wrapper(to: &mut Additions<'_>, replaced: &[Replaced], place: u32, main: u32, constants: (u32, u32)) -> (u32, u32) {
    let void = to.kind(Op::TypeVoid, &[]);
    let function = to.kind(Op::TypeFunction, &[void]);
    let float = to.kind(Op::TypeFloat, &[32]);
    let bool = to.kind(Op::TypeBool, &[]);
    let [pair, triple, vector] = [2, 3, 4].map(|count| to.kind(Op::TypeVector, &[float, count]));
    let types = Types { float, pair, triple, vector, import: to.glsl() };
    let zero = constant(to, float, 0);
    let (block, member, indices) = block(to, vector, constants);
    let limits = limits(to, &types);
    let [made, label, moved, end, called] = std::array::from_fn(|_| to.id());
    push(&mut to.bodies, Op::Function, &[void, made, FunctionControl::NONE.bits(), function]);
    push(&mut to.bodies, Op::Label, &[label]);
    let given = indices.map(|index| {
        let at = value(to, Op::AccessChain, member, &[block, index]);
        value(to, Op::Load, vector, &[at])
    });
    let inputs: Vec<u32> = replaced.iter().map(|input| value(to, Op::Load, input.kind, &[input.input])).collect();
    for (input, loaded) in replaced.iter().zip(&inputs) {
        push(&mut to.bodies, Op::Store, &[input.variable, *loaded]);
    }
    let here = value(to, Op::Load, vector, &[place]);
    let switch = value(to, Op::CompositeExtract, float, &[given[5], 1]);
    let moves = value(to, Op::FOrdNotEqual, bool, &[switch, zero]);
    push(&mut to.bodies, Op::SelectionMerge, &[end, SelectionControl::NONE.bits()]);
    push(&mut to.bodies, Op::BranchConditional, &[moves, moved, end]);
    push(&mut to.bodies, Op::Label, &[moved]);
    let there = place_in_tile(to, &types, &given, here, limits);
    let here = value(to, Op::VectorShuffle, pair, &[here, here, 0, 1]);
    let way = value(to, Op::FSub, pair, &[there, here]);
    let way = [0, 1].map(|axis| value(to, Op::CompositeExtract, float, &[way, axis]));
    for (input, loaded) in replaced.iter().zip(&inputs) {
        let mut result = *loaded;
        if input.is_place {
            // The other two components are those of the driver.
            result = value(to, Op::VectorShuffle, vector, &[there, *loaded, 0, 1, 4, 5]);
        } else {
            for (axis, derivative) in [Op::DPdx, Op::DPdy].into_iter().enumerate() {
                let slope = value(to, derivative, input.kind, &[*loaded]);
                let scaled = if input.kind == float { Op::FMul } else { Op::VectorTimesScalar };
                let step = value(to, scaled, input.kind, &[slope, way[axis]]);
                result = value(to, Op::FAdd, input.kind, &[result, step]);
            }
        }
        push(&mut to.bodies, Op::Store, &[input.variable, result]);
    }
    push(&mut to.bodies, Op::Branch, &[end]);
    push(&mut to.bodies, Op::Label, &[end]);
    push(&mut to.bodies, Op::FunctionCall, &[void, called, main]);
    push(&mut to.bodies, Op::Return, &[]);
    push(&mut to.bodies, Op::FunctionEnd, &[]);
    (made, block)
}

/// Returns the constants of [`place_in_tile`]: the smallest divisor, and the corners of a picture.
fn limits(to: &mut Additions<'_>, types: &Types) -> [u32; 3] {
    let [least, low, high] = [LEAST, -1.0, 1.0].map(|number| constant(to, types.float, number.to_bits()));
    let corner = |to: &mut Additions<'_>, number: u32| {
        let id = to.id();
        push(&mut to.globals, Op::ConstantComposite, &[types.pair, id, number, number]);
        id
    };
    [least, corner(to, low), corner(to, high)]
}

/// Returns the place in the tile that shows what the program's picture has in the direction of the
/// place `here`. Beyond the picture it has the colours of the border; beyond its left and right
/// sides, directions of equal elevation have equal heights. The same rule as for OpenGL
/// (`backend/gl/passes/backdrop.rs`).
fn place_in_tile(
    to: &mut Additions<'_>,
    types: &Types,
    given: &[u32; BACKDROP_VECTORS],
    here: u32,
    [least, low, high]: [u32; 3],
) -> u32 {
    let &Types { float, pair, triple, vector, import } = types;
    let part = |to: &mut Additions<'_>, of: u32, index: u32| value(to, Op::CompositeExtract, float, &[of, index]);
    let glsl = |to: &mut Additions<'_>, kind: u32, function: u32, of: &[u32]| {
        value(to, Op::ExtInst, kind, &[&[import, function], of].concat())
    };
    let [x, y] = [0, 1].map(|axis| part(to, here, axis));
    let across = value(to, Op::VectorTimesScalar, vector, &[given[0], x]);
    let down = value(to, Op::VectorTimesScalar, vector, &[given[1], y]);
    let sum = value(to, Op::FAdd, vector, &[across, down]);
    let sum = value(to, Op::FAdd, vector, &[sum, given[2]]);
    let direction = value(to, Op::VectorShuffle, triple, &[sum, sum, 0, 1, 2]);
    let length = glsl(to, float, LENGTH, &[direction]);
    let [right, up, ahead] = [0, 1, 2].map(|axis| {
        let component = part(to, direction, axis);
        value(to, Op::FDiv, float, &[component, length])
    });
    let level = value(to, Op::CompositeConstruct, pair, &[right, ahead]);
    let level = glsl(to, float, LENGTH, &[level]);
    let nearest = part(to, given[5], 0);
    let beside = value(to, Op::FMul, float, &[nearest, level]);
    let depth_of_height = glsl(to, float, MAX, &[ahead, beside]);
    let mut axes = [0; 2];
    for (axis, (component, depth)) in [(right, ahead), (up, depth_of_height)].into_iter().enumerate() {
        let depth = glsl(to, float, MAX, &[depth, least]);
        let [scale, centre] = [0, 1].map(|number| part(to, given[3], 2 * axis as u32 + number));
        let slope = value(to, Op::FDiv, float, &[component, depth]);
        let scaled = value(to, Op::FMul, float, &[scale, slope]);
        axes[axis] = value(to, Op::FSub, float, &[scaled, centre]);
    }
    let place = value(to, Op::CompositeConstruct, pair, &axes);
    let place = glsl(to, pair, CLAMP, &[place, low, high]);
    let half = value(to, Op::VectorShuffle, pair, &[given[4], given[4], 0, 1]);
    let centre = value(to, Op::VectorShuffle, pair, &[given[4], given[4], 2, 3]);
    let scaled = value(to, Op::FMul, pair, &[place, half]);
    value(to, Op::FAdd, pair, &[scaled, centre])
}
