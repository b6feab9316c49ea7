//! Images and buffers that compute shaders read and write, in handmade modules.

use super::module;
use crate::intercept::vk::spirv::module::instructions;
use crate::intercept::vk::spirv::{BufferWrites, ComputeUse, compute_use, without_writes};
use crate::testing::random::Random;
use spirv::{Decoration, Dim, ExecutionModel, Op, StorageClass};

/// A compute stage whose function does `body`. Id 20: sampled image of type 5, binding 1. Ids 21
/// and 22: stored images of type 6, bindings 2 and 3; 22 is never read. Id 23: base of a chain to a
/// word of a buffer at binding 4, with a pointer of type 13.
fn stage(body: &[(u32, &[u32])]) -> Vec<u32> {
    let (constant, buffer) = (StorageClass::UniformConstant as u32, StorageClass::StorageBuffer as u32);
    let point = [ExecutionModel::GLCompute as u32, 30, u32::from_le_bytes(*b"go\0\0")];
    let (sampled, stored) = ([5, 2, Dim::Dim2D as u32, 0, 0, 0, 1, 0], [6, 2, Dim::Dim2D as u32, 0, 0, 0, 2, 4]);
    let binding = |id: u32, binding: u32| [id, Decoration::Binding as u32, binding];
    let bindings = [binding(20, 1), binding(21, 2), binding(22, 3), binding(23, 4)];
    let pointers = [[8, constant, 5], [9, constant, 6], [12, buffer, 11], [13, buffer, 10]];
    let variables = [[8, 20, constant], [9, 21, constant], [9, 22, constant], [12, 23, buffer]];
    let mut all: Vec<(u32, &[u32])> = vec![
        (Op::Capability as u32, &[1]),
        (Op::MemoryModel as u32, &[0, 1]),
        (Op::EntryPoint as u32, &point),
        (Op::Decorate as u32, &[22, Decoration::NonReadable as u32]),
    ];
    all.extend(bindings.iter().map(|operands| (Op::Decorate as u32, &operands[..])));
    all.extend([
        (Op::TypeVoid as u32, &[1][..]),
        (Op::TypeFloat as u32, &[2, 32]),
        (Op::TypeVector as u32, &[3, 2, 4]),
        (Op::TypeImage as u32, &sampled),
        (Op::TypeImage as u32, &stored),
        (Op::TypeInt as u32, &[10, 32, 0]),
        (Op::TypeStruct as u32, &[11, 10]),
    ]);
    all.extend(pointers.iter().map(|operands| (Op::TypePointer as u32, &operands[..])));
    all.extend(variables.iter().map(|operands| (Op::Variable as u32, &operands[..])));
    all.extend([
        (Op::Constant as u32, &[10, 24, 0][..]),
        (Op::TypeFunction as u32, &[7, 1]),
        (Op::Function as u32, &[1, 30, 0, 7]),
        (Op::Label as u32, &[31]),
    ]);
    all.extend(body);
    all.extend([(Op::Return as u32, &[][..]), (Op::FunctionEnd as u32, &[])]);
    module(60, &all)
}

const LOADS: [(u32, &[u32]); 3] =
    [(Op::Load as u32, &[5, 40, 20]), (Op::Load as u32, &[6, 41, 21]), (Op::Load as u32, &[6, 42, 22])];
const FETCH: (u32, &[u32]) = (Op::ImageFetch as u32, &[3, 43, 40, 24]);
const READ: (u32, &[u32]) = (Op::ImageRead as u32, &[3, 44, 41, 24]);
const CHAIN: (u32, &[u32]) = (Op::AccessChain as u32, &[13, 45, 23, 24]);
const STORE: (u32, &[u32]) = (Op::Store as u32, &[45, 24]);
const ADD: (u32, &[u32]) = (Op::AtomicIAdd as u32, &[10, 46, 45, 24, 24, 24]);

/// Stores to the image that is loaded here.
const fn write(image: &'static [u32]) -> (u32, &'static [u32]) {
    (Op::ImageWrite as u32, image)
}

fn used(body: &[(u32, &[u32])]) -> ComputeUse {
    compute_use(&stage(&[&LOADS[..], body].concat())).expect("a module")
}

#[test]
fn images_that_are_read_and_written() {
    let expected = |read: &[u32], written: &[u32]| ComputeUse {
        read: read.iter().map(|binding| (0, *binding)).collect(),
        written: written.iter().map(|binding| (0, *binding)).collect(),
        ..ComputeUse::default()
    };
    assert_eq!(used(&[]), expected(&[], &[]));
    assert_eq!(used(&[FETCH, write(&[42, 24, 43])]), expected(&[1], &[3]));
    assert_eq!(used(&[READ, write(&[41, 24, 44])]), expected(&[2], &[2]));
    let unknown = [write(&[50, 24, 43])];
    assert_eq!(used(&unknown), expected(&[], &[2, 3]), "it may be any that can be written");
    let unknown = (Op::ImageRead as u32, &[3, 44, 50, 24][..]);
    assert_eq!(used(&[unknown]), expected(&[1, 2], &[]), "it may be any that can be read");
}

#[test]
fn buffers_that_are_written() {
    assert_eq!(used(&[FETCH, CHAIN]).buffers, BufferWrites::Nothing);
    assert_eq!(used(&[CHAIN, ADD]).buffers, BufferWrites::Sums);
    assert_eq!(used(&[CHAIN, ADD, STORE]).buffers, BufferWrites::Places);
    assert!(used(&[(Op::ImageTexelPointer as u32, &[13, 47, 21, 24, 24])]).image_atomics);
}

/// Opcodes and operands of the function's body.
fn body(words: &[u32]) -> Vec<(u32, Vec<u32>)> {
    let all = instructions(words).expect("a module");
    let body = all.iter().skip_while(|i| !i.is(Op::Label)).skip(1);
    body.map(|i| (i.opcode, i.operands.to_vec())).collect()
}

#[test]
fn shaders_without_their_writes() {
    let reads = [&LOADS[..], &[FETCH, READ, CHAIN]].concat();
    assert_eq!(without_writes(&stage(&reads)), None, "it writes nothing");
    let writing = stage(&[&reads[..], &[STORE, write(&[42, 24, 43])]].concat());
    let quiet = without_writes(&writing).expect("it writes");
    assert_eq!(body(&quiet), body(&stage(&[LOADS[1], READ])), "the other instructions only served the writes");
    assert_eq!(without_writes(&quiet), None);
    // The result of an atomic instruction becomes a constant. Nothing needs the pointer any more.
    let quiet = without_writes(&stage(&[CHAIN, ADD])).expect("it writes");
    assert_eq!(body(&quiet), body(&stage(&[])));
    let all = instructions(&quiet).expect("a module");
    let at = |op: Op| all.iter().position(|i| i.is(op)).expect("such an instruction");
    assert_eq!(all[at(Op::ConstantNull)].operands, [10, 46]);
    assert!(at(Op::ConstantNull) < at(Op::Function));
    // What only serves a write is removed with it, but not what something else uses.
    let load = (Op::Load as u32, &[10, 50, 45][..]);
    let sum = |from: &'static [u32]| (Op::IAdd as u32, from);
    let chained = [CHAIN, load, sum(&[10, 51, 50, 24]), (Op::Store as u32, &[45, 51])];
    assert_eq!(body(&without_writes(&stage(&chained)).expect("it writes")), body(&stage(&[])));
    let used = [&chained[..], &[sum(&[10, 52, 50, 50])]].concat();
    let left = [CHAIN, load, sum(&[10, 52, 50, 50])];
    assert_eq!(body(&without_writes(&stage(&used)).expect("it writes")), body(&stage(&left)));
}

/// A damaged module does no harm.
#[test]
fn damaged_modules_do_no_harm() {
    let words = stage(&[&LOADS[..], &[FETCH, READ, CHAIN, ADD, STORE, write(&[42, 24, 43])]].concat());
    let mut random = Random::new(7);
    for _ in 0..3000 {
        let mut damaged = words.clone();
        for _ in 0..2 {
            let at = random.below(damaged.len());
            damaged[at] ^= 1 << random.below(32);
        }
        let _ = compute_use(&damaged);
        let _ = without_writes(&damaged);
    }
}
