//! Shaders without their writes to buffers and images.
//!
//! A draw is issued into several tiles, but its shaders have to write once. In all other tiles they
//! have no writes, and nothing that only served a write: a shader that still read what another one
//! writes would need a barrier. An atomic instruction returns 0 there, as at its first time.

use crate::intercept::vk::spirv::compute::Pointers;
use crate::intercept::vk::spirv::module::{Declarations, HEADER, Instruction, instructions};
use spirv::{Decoration, Op, StorageClass};
use std::collections::{HashMap, HashSet};

/// Returns the words of a shader without its writes to buffers and images; `None` if it has none,
/// or if `words` are no module.
pub fn without_writes(words: &[u32]) -> Option<Vec<u32>> {
    let all = instructions(words)?;
    if !all.iter().any(allows_writes) {
        return None;
    }
    let declared = Declarations::new(&all);
    let pointers = Pointers::of(&all, &declared);
    let first = all.iter().position(|i| i.is(Op::Function))?;
    let mut kept: Vec<bool> = all.iter().enumerate().map(|(index, i)| index < first || !writes(i, &pointers)).collect();
    if kept.iter().all(|kept| *kept) {
        return None;
    }
    // What an atomic instruction returned is a constant with the same id.
    let constants = all.iter().zip(&kept).filter(|(i, kept)| !**kept && returns(i));
    let constants: Vec<u32> =
        constants.flat_map(|(i, _)| [3 << 16 | Op::ConstantNull as u32, i.operand(0), i.operand(1)]).collect();
    remove_unused(&all, first, &mut kept);
    let mut changed = words.get(..HEADER)?.to_vec();
    let removed = all.iter().zip(&kept).filter(|(i, kept)| !**kept && is_pure(i));
    let removed: HashSet<u32> = removed.map(|(i, _)| i.operand(1)).collect();
    let named = [Op::Name, Op::Decorate, Op::DecorateId, Op::DecorateString];
    for (index, i) in all.iter().enumerate() {
        if index == first {
            changed.extend(&constants);
        }
        let of_removed = index < first && named.iter().any(|op| i.is(*op)) && removed.contains(&i.operand(0));
        if kept[index] && !of_removed {
            changed.extend(&words[i.offset..=i.offset + i.operands.len()]);
        }
    }
    Some(changed)
}

/// True if a shader with this instruction may write to a buffer or an image. Most shaders have none.
fn allows_writes(i: &Instruction<'_>) -> bool {
    let shared = [StorageClass::StorageBuffer, StorageClass::PhysicalStorageBuffer];
    match Op::from_u32(i.opcode) {
        Some(Op::ImageWrite | Op::ImageTexelPointer) => true,
        Some(Op::TypePointer) => shared.iter().any(|class| i.operand(1) == *class as u32),
        Some(Op::Decorate) => i.operand(1) == Decoration::BufferBlock as u32,
        _ => false,
    }
}

/// True if an instruction writes to a buffer or an image.
fn writes(i: &Instruction<'_>, pointers: &Pointers) -> bool {
    let shared = |pointer| pointers.in_buffer(pointer) || pointers.class(pointer) == Some(StorageClass::Image as u32);
    match Op::from_u32(i.opcode) {
        Some(Op::Store | Op::CopyMemory | Op::CopyMemorySized) => pointers.in_buffer(i.operand(0)),
        Some(Op::ImageWrite) => true,
        Some(Op::AtomicStore) => shared(i.operand(0)),
        Some(Op::AtomicFAddEXT | Op::AtomicFMaxEXT | Op::AtomicFMinEXT) => shared(i.operand(2)),
        Some(op) if (Op::AtomicExchange as u32..=Op::AtomicXor as u32).contains(&(op as u32)) => shared(i.operand(2)),
        _ => false,
    }
}

/// True if an instruction that writes returns a value.
fn returns(i: &Instruction<'_>) -> bool {
    let not = [Op::Store, Op::CopyMemory, Op::CopyMemorySized, Op::ImageWrite, Op::AtomicStore];
    !not.iter().any(|op| i.is(*op))
}

/// True if an instruction does nothing but compute its result: type, result, operands.
fn is_pure(i: &Instruction<'_>) -> bool {
    match Op::from_u32(i.opcode) {
        // Operands after the pointer may say that the memory is volatile.
        Some(Op::Load) => i.operands.len() == 3,
        Some(Op::ImageTexelPointer | Op::AccessChain | Op::InBoundsAccessChain | Op::CopyObject) => true,
        Some(Op::ImageFetch | Op::ImageRead | Op::CompositeConstruct | Op::CompositeExtract | Op::Select) => true,
        Some(op) => {
            let code = op as u32;
            // Conversions, arithmetic, and operations on bits.
            (Op::ConvertFToU as u32..=Op::Bitcast as u32).contains(&code)
                || (Op::SNegate as u32..=Op::Dot as u32).contains(&code)
                || (Op::ShiftRightLogical as u32..=Op::BitCount as u32).contains(&code)
        }
        None => false,
    }
}

/// Removes instructions of functions that only compute what nothing uses any more, and that
/// something used before.
fn remove_unused(all: &[Instruction<'_>], first: usize, kept: &mut [bool]) {
    // Words that are no ids may count as uses: then something is kept that could be removed.
    let mut uses = HashMap::<u32, usize>::new();
    let body = || all.iter().enumerate().skip(first);
    for (_, i) in body().filter(|(index, _)| kept[*index]) {
        i.operands.iter().for_each(|word| *uses.entry(*word).or_default() += 1);
    }
    let results: HashMap<u32, usize> =
        body().filter(|(_, i)| is_pure(i)).map(|(index, i)| (i.operand(1), index)).collect();
    let mut unused: Vec<u32> =
        body().filter(|(index, _)| !kept[*index]).flat_map(|(_, i)| i.operands.to_vec()).collect();
    while let Some(id) = unused.pop() {
        let Some(index) = results.get(&id).copied().filter(|index| kept[*index]) else { continue };
        // The instruction itself names its result once.
        if uses.get(&id).copied() != Some(1) {
            continue;
        }
        kept[index] = false;
        for word in all[index].operands {
            uses.entry(*word).and_modify(|count| *count -= 1);
            unused.push(*word);
        }
    }
}
