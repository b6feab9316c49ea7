//! Choices between matrices of the program and those of Cupola, in handmade modules.

use super::module;
use crate::intercept::vk::spirv::module::instructions;
use crate::intercept::vk::spirv::{Memory, camera_matrices};
use crate::testing::random::Random;
use spirv::{Decoration, ExecutionModel, Op, StorageClass};

/// A stage whose function does `body`. Id 15: a block in set 1 at binding 2 with a vector, a
/// row-major matrix, and two column-major ones. Ids 12 and 13: constants 1 and 2. Ids 16, 17 and
/// 18: types of pointers to a matrix of the block, to a column of it, and to an output vector.
fn stage(model: ExecutionModel, body: &[(u32, &[u32])]) -> Vec<u32> {
    let (uniform, output) = (StorageClass::Uniform as u32, StorageClass::Output as u32);
    let point = [model as u32, 7, u32::from_le_bytes(*b"go\0\0"), 19];
    let member = |number: u32, kind: Decoration, value: u32| [10, number, kind as u32, value];
    let offsets =
        [member(0, Decoration::Offset, 0), member(1, Decoration::Offset, 16), member(2, Decoration::Offset, 80)];
    let strides = [member(1, Decoration::MatrixStride, 16), member(2, Decoration::MatrixStride, 16)];
    let mut all: Vec<(u32, &[u32])> = vec![
        (Op::Capability as u32, &[1]),
        (Op::MemoryModel as u32, &[0, 1]),
        (Op::EntryPoint as u32, &point),
        (Op::Decorate as u32, &[15, Decoration::DescriptorSet as u32, 1]),
        (Op::Decorate as u32, &[15, Decoration::Binding as u32, 2]),
        (Op::Decorate as u32, &[9, Decoration::ArrayStride as u32, 64]),
        (Op::Decorate as u32, &[19, Decoration::BuiltIn as u32, 0]),
        (Op::MemberDecorate as u32, &[10, 1, Decoration::RowMajor as u32]),
    ];
    all.extend(offsets.iter().chain(&strides).map(|words| (Op::MemberDecorate as u32, &words[..])));
    let (of_block, of_matrix, of_column) = ([14, uniform, 10], [16, uniform, 4], [17, uniform, 3]);
    let (of_output, result) = ([18, output, 3], [18, 19, output]);
    let (block, variable) = ([10, 3, 4, 9], [14, 15, uniform]);
    all.extend([
        (Op::TypeVoid as u32, &[1][..]),
        (Op::TypeFloat as u32, &[2, 32]),
        (Op::TypeVector as u32, &[3, 2, 4]),
        (Op::TypeMatrix as u32, &[4, 3, 4]),
        (Op::TypeInt as u32, &[11, 32, 1]),
        (Op::Constant as u32, &[11, 12, 1]),
        (Op::Constant as u32, &[11, 13, 2]),
        (Op::TypeArray as u32, &[9, 4, 13]),
        (Op::TypeStruct as u32, &block),
        (Op::TypePointer as u32, &of_block),
        (Op::TypePointer as u32, &of_matrix),
        (Op::TypePointer as u32, &of_column),
        (Op::TypePointer as u32, &of_output),
        (Op::Variable as u32, &variable),
        (Op::Variable as u32, &result),
        (Op::TypeFunction as u32, &[6, 1]),
        (Op::Function as u32, &[1, 7, 0, 6]),
        (Op::Label as u32, &[8]),
    ]);
    all.extend(body);
    all.extend([(Op::Return as u32, &[][..]), (Op::FunctionEnd as u32, &[])]);
    module(60, &all)
}

/// The row-major matrix, and a column of the second column-major one.
const WHOLE: (u32, &[u32]) = (Op::AccessChain as u32, &[16, 30, 15, 12]);
const LOAD: (u32, &[u32]) = (Op::Load as u32, &[4, 31, 30]);
const COLUMN: (u32, &[u32]) = (Op::AccessChain as u32, &[17, 32, 15, 13, 12, 13]);
const LOAD_COLUMN: (u32, &[u32]) = (Op::Load as u32, &[3, 33, 32]);

#[test]
fn loads_are_of_variables_that_are_given_their_values_first() {
    let words = stage(ExecutionModel::Fragment, &[WHOLE, LOAD, COLUMN, LOAD_COLUMN]);
    let chosen = camera_matrices(&words, ExecutionModel::Fragment, "go", 3, 208).expect("followed").expect("matrices");
    let places: Vec<_> = chosen.matrices.iter().map(|(m, _)| (m.memory, m.offset, m.row_major)).collect();
    let memory = Memory::Buffer { set: 1, binding: 2 };
    assert_eq!(places, [(memory, 16, true), (memory, 80 + 64, false)]);
    let all = instructions(&chosen.words).expect("a module");
    let class = |kind: u32| all.iter().find(|i| i.is(Op::TypePointer) && i.operand(0) == kind).map(|i| i.operand(1));
    let private = Some(StorageClass::Private as u32);
    let load = all.iter().find(|i| i.is(Op::Load) && i.operand(1) == 31).expect("it stays");
    let variable = all.iter().find(|i| i.is(Op::Variable) && i.operand(1) == load.operand(2)).expect("ours");
    assert_eq!(class(variable.operand(0)), private);
    let column = all.iter().find(|i| i.is(Op::AccessChain) && i.operand(1) == 32).expect("it stays");
    assert_eq!((class(column.operand(0)), column.rest(3)), (private, &[13][..]), "the column stays");
    assert_ne!(column.operand(2), load.operand(2), "each matrix has its own");
    let point = all.iter().find(|i| i.is(Op::EntryPoint)).expect("an entry point");
    let selects = all.iter().filter(|i| i.is(Op::Select)).count();
    assert!(point.operand(1) != 7 && selects == 8 && !chosen.inverts);
}

#[test]
fn matrices_of_the_position_and_those_that_are_handed_on_are_left() {
    let store: (u32, &[u32]) = (Op::Store as u32, &[19, 33]);
    let words = stage(ExecutionModel::Vertex, &[WHOLE, LOAD, COLUMN, LOAD_COLUMN, store]);
    let chosen = camera_matrices(&words, ExecutionModel::Vertex, "go", 3, 208).expect("followed").expect("a matrix");
    assert_eq!(chosen.matrices.iter().map(|(m, _)| m.offset).collect::<Vec<_>>(), [16]);
    let call: (u32, &[u32]) = (Op::FunctionCall as u32, &[1, 40, 7, 30]);
    let words = stage(ExecutionModel::Fragment, &[WHOLE, LOAD, call]);
    assert!(matches!(camera_matrices(&words, ExecutionModel::Fragment, "go", 3, 208), Ok(None)));
}

/// A damaged module does no harm.
#[test]
fn damaged_modules_do_no_harm() {
    let words = stage(ExecutionModel::Fragment, &[WHOLE, LOAD, COLUMN, LOAD_COLUMN]);
    let mut random = Random::new(6);
    for _ in 0..3000 {
        let mut damaged = words.clone();
        for _ in 0..2 {
            let at = random.below(damaged.len());
            damaged[at] ^= 1 << random.below(32);
        }
        let _ = camera_matrices(&damaged, ExecutionModel::Fragment, "go", 3, 208);
    }
}
