//! `FragCoord` of the program's fragment shaders, in the coordinates of the program's window.
//!
//! Loads of the built-in variable become loads of a variable of Cupola. A function of Cupola, which
//! becomes the entry point's function, sets that variable: it subtracts an offset from the driver's
//! value and multiplies by a scale, both from the view constants. Then it calls the program's
//! function. [`backdrop`]: inputs of another place.

pub mod backdrop;

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::spirv::functions::{Additions, push};
use crate::intercept::vk::spirv::module::{BOUND, Declarations, Instruction, instructions, string};
use crate::intercept::vk::spirv::splice::{Entry, MOST_IDS, entry_point, put_into};
use spirv::{BuiltIn, Decoration, ExecutionModel, FunctionControl, Op, StorageClass};
use std::collections::{BTreeSet, HashMap, HashSet};

/// Returns `words` with window coordinates of the program; `None` if the shader does not use them.
/// The offset and the scale are four floats at `offset` in the uniform block at binding 0 of `set`.
///
/// # Errors
/// What the shader does that cannot be followed, for the log.
pub fn frag_coord(words: &[u32], entry: &str, set: u32, offset: u32) -> Result<Option<Vec<u32>>, Obstacle> {
    let all = instructions(words).ok_or("a shader that is not SPIR-V")?;
    let declared = Declarations::new(&all);
    let (point, main) = entry_point(&all, ExecutionModel::Fragment, entry)?;
    let interface = 2 + string(point.rest(2)).1;
    let asks = |id: &u32| declared.number(*id, None, Decoration::BuiltIn) == Some(BuiltIn::FragCoord as u32);
    let Some(given) = point.rest(interface).iter().copied().find(asks) else { return Ok(None) };
    let vector = match declared.pointee(given) {
        Some((class, kind)) if class == StorageClass::Input as u32 && declared.is_vec4(kind) => kind,
        _ => return Err("a shader whose FragCoord is no vector of four floats".into()),
    };
    if all.iter().filter(|i| i.is(Op::EntryPoint)).count() > 1 {
        return Err("several entry points in a module that uses its position on the screen".into());
    }
    if words[BOUND] > MOST_IDS {
        return Err("a shader with too many ids".into());
    }
    let chains = chains(&all, given)?;
    let mut additions = Additions::new(words[BOUND], &declared);
    let ours = variables(&mut additions, vector, (set, offset));
    let pointers = private_pointers(&mut additions, &declared, &chains)?;
    let wrapper = wrapper(&mut additions, given, main, vector, &ours);
    let entry =
        Entry { point, main, wrapper: Some(wrapper), variables: vec![ours.block, ours.place], inputs: Vec::new() };
    let change = |_: &mut Additions<'_>, i: &Instruction<'_>, _: &mut Vec<u32>| {
        let mut operands = i.operands.to_vec();
        let chain = i.is(Op::AccessChain) || i.is(Op::InBoundsAccessChain);
        if (chain || i.is(Op::Load)) && i.operand(2) == given {
            operands[2] = ours.place;
            if let Some(pointer) = pointers.get(&i.operand(0)).filter(|_| chain) {
                operands[0] = *pointer;
            }
        }
        operands
    };
    Ok(Some(put_into(additions, words, &all, &entry, change)))
}

/// Returns results and types of the access chains into the variable.
///
/// # Errors
/// The variable, or a part of it, is used for more than loads.
fn chains(all: &[Instruction<'_>], given: u32) -> Result<Vec<(u32, u32)>, Obstacle> {
    let is_chain = |i: &&Instruction<'_>| i.is(Op::AccessChain) || i.is(Op::InBoundsAccessChain);
    let chains: Vec<(u32, u32)> =
        all.iter().filter(|i| is_chain(i) && i.operand(2) == given).map(|i| (i.operand(1), i.operand(0))).collect();
    let parts: HashSet<u32> = chains.iter().map(|(result, _)| *result).collect();
    let is_ours = |id: &u32| *id == given || parts.contains(id);
    for i in all {
        // Operands that may be pointers. Literal numbers that only look like ids are left out.
        let pointers = match Op::from_u32(i.opcode) {
            Some(Op::AccessChain | Op::InBoundsAccessChain) if parts.contains(&i.operand(2)) => i.rest(2),
            Some(Op::FunctionCall) => i.rest(3),
            Some(Op::ExtInst) => i.rest(4),
            Some(Op::CopyObject | Op::Phi | Op::Select | Op::PtrAccessChain | Op::InBoundsPtrAccessChain) => i.rest(2),
            Some(Op::CopyMemory | Op::CopyMemorySized | Op::Store) => i.rest(0),
            _ => continue,
        };
        if pointers.iter().any(is_ours) {
            return Err("a shader that passes FragCoord on by a pointer".into());
        }
    }
    Ok(chains)
}

/// Variables of Cupola.
struct Ours {
    /// The block of the view constants. Only one of its members is declared here.
    block: u32,
    /// Type of a pointer to this member.
    member: u32,
    /// Index of the member.
    zero: u32,
    /// Variable that replaces the program's `FragCoord`.
    place: u32,
}

fn variables(to: &mut Additions<'_>, vector: u32, (set, offset): (u32, u32)) -> Ours {
    let int = to.kind(Op::TypeInt, &[32, 0]);
    let [structure, of_block, member, of_place, block, place, zero] = std::array::from_fn(|_| to.id());
    push(&mut to.globals, Op::TypeStruct, &[structure, vector]);
    push(&mut to.globals, Op::TypePointer, &[of_block, StorageClass::Uniform as u32, structure]);
    push(&mut to.globals, Op::TypePointer, &[member, StorageClass::Uniform as u32, vector]);
    push(&mut to.globals, Op::TypePointer, &[of_place, StorageClass::Private as u32, vector]);
    push(&mut to.globals, Op::Constant, &[int, zero, 0]);
    push(&mut to.globals, Op::Variable, &[of_block, block, StorageClass::Uniform as u32]);
    push(&mut to.globals, Op::Variable, &[of_place, place, StorageClass::Private as u32]);
    push(&mut to.decorations, Op::Decorate, &[structure, Decoration::Block as u32]);
    push(&mut to.decorations, Op::MemberDecorate, &[structure, 0, Decoration::Offset as u32, offset]);
    push(&mut to.decorations, Op::Decorate, &[block, Decoration::DescriptorSet as u32, set]);
    push(&mut to.decorations, Op::Decorate, &[block, Decoration::Binding as u32, 0]);
    Ours { block, member, zero, place }
}

/// Returns, for each pointer type of the chains, which points to input, the same type for Cupola's
/// variable.
///
/// # Errors
/// A type is not known.
fn private_pointers(
    to: &mut Additions<'_>,
    declared: &Declarations<'_>,
    chains: &[(u32, u32)],
) -> Result<HashMap<u32, u32>, Obstacle> {
    let kinds: BTreeSet<u32> = chains.iter().map(|(_, kind)| *kind).collect();
    let private = |kind: u32| {
        let pointer = declared.get(kind, Op::TypePointer).ok_or("a shader with a pointer that is not known")?;
        let made = to.id();
        push(&mut to.globals, Op::TypePointer, &[made, StorageClass::Private as u32, pointer.operand(2)]);
        Ok((kind, made))
    };
    kinds.into_iter().map(private).collect()
}

/// Returns a function that sets Cupola's variable and calls `main`.
fn wrapper(to: &mut Additions<'_>, given: u32, main: u32, vector: u32, ours: &Ours) -> u32 {
    let void = to.kind(Op::TypeVoid, &[]);
    let function = to.kind(Op::TypeFunction, &[void]);
    let float = to.kind(Op::TypeFloat, &[32]);
    let pair = to.kind(Op::TypeVector, &[float, 2]);
    let [made, label, at, constants, driver, offset, scale, corner, moved, scaled, result, called] =
        std::array::from_fn(|_| to.id());
    let code = &mut to.bodies;
    push(code, Op::Function, &[void, made, FunctionControl::NONE.bits(), function]);
    push(code, Op::Label, &[label]);
    push(code, Op::AccessChain, &[ours.member, at, ours.block, ours.zero]);
    push(code, Op::Load, &[vector, constants, at]);
    push(code, Op::Load, &[vector, driver, given]);
    push(code, Op::VectorShuffle, &[pair, offset, constants, constants, 0, 1]);
    push(code, Op::VectorShuffle, &[pair, scale, constants, constants, 2, 3]);
    push(code, Op::VectorShuffle, &[pair, corner, driver, driver, 0, 1]);
    push(code, Op::FSub, &[pair, moved, corner, offset]);
    push(code, Op::FMul, &[pair, scaled, moved, scale]);
    // The first two components are those of `scaled`, the others are those of `driver`.
    push(code, Op::VectorShuffle, &[vector, result, scaled, driver, 0, 1, 4, 5]);
    push(code, Op::Store, &[ours.place, result]);
    push(code, Op::FunctionCall, &[void, called, main]);
    push(code, Op::Return, &[]);
    push(code, Op::FunctionEnd, &[]);
    made
}
