//! Tests of matrices outside of blocks, and of the reasons why there is no lens.

use super::{module, two_matrices, vertex_shader};
use crate::intercept::scene::flat_program::MissingLens;
use crate::intercept::vk::spirv::{Memory, attribute_matrices, matrices, missing_lens};
use spirv::{Decoration, Op, StorageClass};

/// A shader with an address in push constants, at byte 8, of a structure with a vector and two
/// matrices, of which the second one makes the position. It has a third one as attribute 3.
/// `by_variable`: it stores the address in a variable first. `of_attribute`: the attribute makes the
/// position.
fn shader(by_variable: bool, of_attribute: bool) -> Vec<u32> {
    let mut words = vec![spirv::MAGIC_NUMBER, 0x0001_0300, 0, 80, 0];
    let mut put = |op: Op, operands: &[u32]| {
        words.push((operands.len() as u32 + 1) << 16 | op as u32);
        words.extend(operands);
    };
    let [push, buffer, output, input, local] = [
        StorageClass::PushConstant,
        StorageClass::PhysicalStorageBuffer,
        StorageClass::Output,
        StorageClass::Input,
        StorageClass::Function,
    ]
    .map(|class| class as u32);
    for (member, offset) in [0, 16, 80].into_iter().enumerate() {
        put(Op::MemberDecorate, &[9, member as u32, Decoration::Offset as u32, offset]);
    }
    put(Op::MemberDecorate, &[11, 0, Decoration::Offset as u32, 8]);
    put(Op::Decorate, &[14, Decoration::BuiltIn as u32, spirv::BuiltIn::Position as u32]);
    put(Op::Decorate, &[16, Decoration::Location as u32, 3]);
    put(Op::TypeVoid, &[1]);
    put(Op::TypeFunction, &[2, 1]);
    put(Op::TypeFloat, &[3, 32]);
    put(Op::TypeVector, &[4, 3, 4]);
    put(Op::TypeMatrix, &[5, 4, 4]);
    put(Op::TypeInt, &[6, 32, 0]);
    put(Op::Constant, &[6, 7, 0]);
    put(Op::Constant, &[6, 8, 2]);
    put(Op::TypeStruct, &[9, 4, 5, 5]);
    put(Op::TypePointer, &[10, buffer, 9]);
    put(Op::TypeStruct, &[11, 10]);
    put(Op::TypePointer, &[12, push, 11]);
    put(Op::TypePointer, &[13, output, 4]);
    put(Op::Variable, &[13, 14, output]);
    put(Op::TypePointer, &[15, input, 5]);
    put(Op::Variable, &[15, 16, input]);
    put(Op::Variable, &[12, 17, push]);
    put(Op::TypePointer, &[18, push, 10]);
    put(Op::TypePointer, &[19, buffer, 5]);
    put(Op::TypePointer, &[20, local, 10]);
    put(Op::Function, &[1, 30, 0, 2]);
    put(Op::Label, &[31]);
    put(Op::Variable, &[20, 32, local]);
    put(Op::AccessChain, &[18, 33, 17, 7]);
    put(Op::Load, &[10, 34, 33]);
    put(Op::Store, &[32, 34]);
    put(Op::Load, &[10, 35, 32]);
    put(Op::AccessChain, &[19, 36, if by_variable { 35 } else { 34 }, 8]);
    put(Op::Load, &[5, 37, 36]);
    put(Op::Load, &[5, 38, 16]);
    put(Op::CompositeExtract, &[4, 39, 38, 0]);
    put(Op::MatrixTimesVector, &[4, 40, if of_attribute { 38 } else { 37 }, 41]);
    put(Op::Store, &[14, 40]);
    put(Op::Return, &[]);
    put(Op::FunctionEnd, &[]);
    words
}

#[test]
fn the_matrix_at_an_address_is_found() {
    for by_variable in [false, true] {
        let found = matrices(&shader(by_variable, false), true);
        let places: Vec<_> = found.iter().map(|matrix| (matrix.memory, matrix.offset)).collect();
        assert_eq!(places, [(Memory::PushedAddress { at: 8 }, 80)], "{by_variable}");
        assert!(attribute_matrices(&shader(by_variable, false), true, &[]).is_empty());
    }
}

#[test]
fn the_matrix_that_is_an_attribute_is_found() {
    let words = shader(false, true);
    assert!(matrices(&words, true).is_empty());
    let found: Vec<_> = attribute_matrices(&words, true, &[]).iter().map(|matrix| matrix.memory).collect();
    assert_eq!(found, [Memory::Attribute { location: 3, declared: true }]);
}

#[test]
fn four_vectors_of_instances_may_be_a_matrix() {
    let (input, output) = (StorageClass::Input as u32, StorageClass::Output as u32);
    let mut all = vec![(Op::Decorate, vec![5, Decoration::BuiltIn as u32, spirv::BuiltIn::Position as u32])];
    all.extend((0..4).map(|n| (Op::Decorate, vec![10 + n, Decoration::Location as u32, 2 + n])));
    all.extend([
        (Op::TypeVoid, vec![1]),
        (Op::TypeFloat, vec![2, 32]),
        (Op::TypeVector, vec![3, 2, 4]),
        (Op::TypePointer, vec![4, output, 3]),
        (Op::Variable, vec![4, 5, output]),
        (Op::TypePointer, vec![6, input, 3]),
        (Op::TypeFunction, vec![7, 1]),
    ]);
    all.extend((0..4).map(|n| (Op::Variable, vec![6, 10 + n, input])));
    all.extend([(Op::Function, vec![1, 30, 0, 7]), (Op::Label, vec![31])]);
    all.extend((0..4).map(|n| (Op::Load, vec![3, 40 + n, 10 + n])));
    all.extend((0..3).map(|n| (Op::FAdd, vec![3, 50 + n, if n == 0 { 40 } else { 49 + n }, 41 + n])));
    all.extend([(Op::Store, vec![5, 52]), (Op::Return, vec![]), (Op::FunctionEnd, vec![])]);
    let all: Vec<_> = all.iter().map(|(op, operands)| (*op as u32, &operands[..])).collect();
    let words = module(60, &all);
    let found: Vec<_> = attribute_matrices(&words, true, &[2, 3, 4, 5]).iter().map(|matrix| matrix.memory).collect();
    assert_eq!(found, [Memory::Attribute { location: 2, declared: false }]);
    assert!(!found[0].has_matrix() && Memory::Push.has_matrix());
    assert!(attribute_matrices(&words, true, &[2, 3, 4]).is_empty());
}

/// A shader that loads its position from a storage buffer.
fn stored_position() -> Vec<u32> {
    let (storage, output) = (StorageClass::StorageBuffer as u32, StorageClass::Output as u32);
    let all: [(Op, &[u32]); 17] = [
        (Op::Decorate, &[5, Decoration::BuiltIn as u32, spirv::BuiltIn::Position as u32]),
        (Op::TypeVoid, &[1]),
        (Op::TypeFloat, &[2, 32]),
        (Op::TypeVector, &[3, 2, 4]),
        (Op::TypePointer, &[4, output, 3]),
        (Op::Variable, &[4, 5, output]),
        (Op::TypeFunction, &[6, 1]),
        (Op::TypeStruct, &[7, 3]),
        (Op::TypePointer, &[8, storage, 7]),
        (Op::Variable, &[8, 9, storage]),
        (Op::TypePointer, &[10, storage, 3]),
        (Op::Function, &[1, 20, 0, 6]),
        (Op::Label, &[21]),
        (Op::AccessChain, &[10, 22, 9, 30]),
        (Op::Load, &[3, 23, 22]),
        (Op::Store, &[5, 23]),
        (Op::FunctionEnd, &[]),
    ];
    module(40, &all.map(|(op, operands)| (op as u32, operands)))
}

#[test]
fn a_shader_tells_why_there_is_no_lens() {
    assert_eq!(missing_lens(vertex_shader()), MissingLens::NoMatrix);
    assert_eq!(missing_lens(&two_matrices(0)), MissingLens::Composed);
    assert_eq!(missing_lens(&shader(true, false)), MissingLens::Address);
    assert_eq!(missing_lens(&stored_position()), MissingLens::Stored);
    assert_eq!(missing_lens(&[1, 2]), MissingLens::NoMatrix);
}
