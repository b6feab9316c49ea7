//! Tests of the splice and of the search for matrices, on handmade modules.

mod backdrop;
mod camera_matrices;
mod compute;
mod elsewhere;
mod frag_coord;
mod texels;

use crate::correct::Arrangement;
use crate::correct::shaders::constants::Constants;
use crate::correct::shaders::glsl::Stage;
use crate::correct::shaders::spirv::{VERTEX_ENTRY, specialise};
use crate::intercept::vk::spirv::module::{Declarations, instructions};
use crate::intercept::vk::spirv::{Memory, matrices, splice};
use crate::testing::random::Random;
use spirv::{Decoration, ExecutionModel, Op, StorageClass};
use std::collections::HashSet;

fn vertex_shader() -> &'static [u32] {
    specialise(&Constants::black(), Arrangement::Atlas, Stage::Present).vertex
}

fn spliced(set: u32, lenses: bool) -> Vec<u32> {
    let entry = VERTEX_ENTRY.to_str().expect("a name");
    splice(vertex_shader(), ExecutionModel::Vertex, entry, set, lenses).expect("it writes gl_Position")
}

#[test]
fn all_words_of_the_program_stay_and_no_id_is_made_twice() {
    for lenses in [false, true] {
        all_words_stay(lenses);
    }
}

fn all_words_stay(lenses: bool) {
    let (before, after) = (vertex_shader(), spliced(3, lenses));
    let all = instructions(&after).expect("a module");
    let kept: HashSet<Vec<u32>> = all.iter().map(|i| [&[i.opcode], i.operands].concat()).collect();
    let changed = instructions(before)
        .expect("a module")
        .iter()
        .filter(|i| !kept.contains(&[&[i.opcode], i.operands].concat()))
        .count();
    assert_eq!(changed, 1, "the entry point");
    let mut results = HashSet::new();
    for i in &all {
        let types = (Op::TypeVoid as u32..=Op::TypeForwardPointer as u32).contains(&i.opcode);
        let result = match Op::from_u32(i.opcode) {
            _ if types => 0,
            Some(Op::Constant | Op::ConstantNull | Op::ConstantComposite | Op::Variable | Op::Function) => 1,
            Some(Op::Load | Op::FMul | Op::FAdd | Op::Dot | Op::ExtInst | Op::AccessChain | Op::FunctionCall) => 1,
            Some(Op::Label) => 0,
            _ => continue,
        };
        let id = i.operand(result);
        assert!(id < after[3] && results.insert(id), "id {id} of {i:?}");
    }
}

#[test]
fn types_that_must_be_unique_are() {
    let after = spliced(0, true);
    let all = instructions(&after).expect("a module");
    let unique = [Op::TypeVoid, Op::TypeBool, Op::TypeInt, Op::TypeFloat, Op::TypeVector, Op::TypeFunction];
    let mut seen = HashSet::new();
    for i in all.iter().filter(|i| unique.iter().any(|op| i.is(*op))) {
        assert!(seen.insert((i.opcode, &i.operands[1..])), "{i:?}");
    }
}

#[test]
fn the_rows_are_where_the_layout_has_them() {
    let after = spliced(5, true);
    let all = instructions(&after).expect("a module");
    let declared = Declarations::new(&all);
    let ours = all.iter().filter(|i| i.is(Op::Variable)).map(|i| i.operand(1));
    let mut ours = ours.filter(|id| declared.number(*id, None, Decoration::DescriptorSet) == Some(5));
    let id = ours.next().expect("the block");
    assert_eq!(declared.number(id, None, Decoration::Binding), Some(0));
    assert_eq!(declared.pointee(id).map(|p| p.0), Some(StorageClass::Uniform as u32));
}

/// GLSL's own functions are imported once, in the module's section for imports, whether the program
/// imports them or not.
#[test]
fn functions_of_glsl_are_imported_once() {
    let entry = VERTEX_ENTRY.to_str().expect("a name");
    let given = vertex_shader();
    let mut without = given[..5].to_vec();
    for i in instructions(given).expect("a module").iter().filter(|i| !i.is(Op::ExtInstImport)) {
        without.extend(&given[i.offset..=i.offset + i.operands.len()]);
    }
    assert!(without.len() < given.len(), "there was one");
    for words in [given, &without] {
        let after = splice(words, ExecutionModel::Vertex, entry, 0, true).expect("it writes gl_Position");
        let all = instructions(&after).expect("a module");
        let imports: Vec<_> = all.iter().filter(|i| i.is(Op::ExtInstImport)).collect();
        assert_eq!(imports.len(), 1);
        let model = all.iter().find(|i| i.is(Op::MemoryModel)).expect("a module has one");
        assert!(imports[0].offset < model.offset);
        let used = all.iter().filter(|i| i.is(Op::ExtInst)).map(|i| i.operand(2));
        assert!(used.clone().count() > 5 && used.into_iter().all(|set| set == imports[0].operand(0)));
        assert_eq!(crate::intercept::vk::spirv::module::string(imports[0].rest(1)).0, "GLSL.std.450");
    }
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let words = vertex_shader();
    let refused = |words: &[u32], entry: &str| splice(words, ExecutionModel::Vertex, entry, 0, true).is_err();
    assert!(refused(words, "no such entry"));
    assert!(refused(&[], "main") && refused(&[1, 2, 3, 4, 5, 6], "main"));
    assert!(refused(&words[..6], VERTEX_ENTRY.to_str().expect("a name")), "cut off within an instruction");
    let mut zero = words.to_vec();
    zero[5] = 0;
    assert!(refused(&zero, VERTEX_ENTRY.to_str().expect("a name")), "an instruction without length");
    let mut endless = words.to_vec();
    endless[3] = u32::MAX;
    assert!(refused(&endless, VERTEX_ENTRY.to_str().expect("a name")), "no number is left for an id");
}

/// A damaged module does no harm.
#[test]
fn damaged_modules_do_no_harm() {
    let words = vertex_shader();
    let mut random = Random::new(1);
    for _ in 0..3000 {
        let mut damaged = words.to_vec();
        for _ in 0..3 {
            let at = random.below(damaged.len());
            damaged[at] ^= 1 << random.below(32);
        }
        let _ = splice(&damaged, ExecutionModel::Vertex, "rectangle_down", 1, true);
        let _ = matrices(&damaged, true);
    }
}

/// Returns the words of a module with these instructions.
pub(in crate::intercept::vk) fn module(bound: u32, all: &[(u32, &[u32])]) -> Vec<u32> {
    let mut words = vec![spirv::MAGIC_NUMBER, 0x0001_0300, 0, bound, 0];
    for (opcode, operands) in all {
        words.push((operands.len() as u32 + 1) << 16 | opcode);
        words.extend(*operands);
    }
    words
}

/// A handmade stage with a `gl_Position` outside of a block, as id 5. Its types begin with `first`,
/// and its function is 7.
fn loose_position(points: &[[u32; 4]], first: (u32, &[u32])) -> Vec<u32> {
    let output = StorageClass::Output as u32;
    let builtin = [5, Decoration::BuiltIn as u32, spirv::BuiltIn::Position as u32];
    let mut all: Vec<(u32, &[u32])> = vec![(Op::Capability as u32, &[1]), (Op::MemoryModel as u32, &[0, 1])];
    all.extend(points.iter().map(|point| (Op::EntryPoint as u32, &point[..])));
    all.extend([(Op::Decorate as u32, &builtin[..]), first]);
    let pointer = [4, output, 3];
    let variable = [4, 5, output];
    all.extend([
        (Op::TypeVoid as u32, &[1][..]),
        (Op::TypeFloat as u32, &[2, 32]),
        (Op::TypeVector as u32, &[3, 2, 4]),
        (Op::TypePointer as u32, &pointer),
        (Op::Variable as u32, &variable),
        (Op::TypeFunction as u32, &[6, 1]),
        (Op::Function as u32, &[1, 7, 0, 6]),
        (Op::Label as u32, &[8]),
        (Op::Return as u32, &[]),
        (Op::FunctionEnd as u32, &[]),
    ]);
    module(40, &all)
}

/// Types of extensions may come before all others. Decorations must be inserted before them.
#[test]
fn decorations_stand_before_types_whatever_the_first_is() {
    // OpTypeAccelerationStructureKHR, an unneeded second OpTypeVoid, an unknown number.
    for first in [5341, 6090] {
        let words =
            loose_position(&[[ExecutionModel::Vertex as u32, 7, u32::from_le_bytes(*b"go\0\0"), 5]], (first, &[30]));
        let after = splice(&words, ExecutionModel::Vertex, "go", 2, false).expect("a loose position");
        let all = instructions(&after).expect("a module");
        let at = all.iter().position(|i| i.opcode == first).expect("it stays");
        let is_decoration =
            |i: &&crate::intercept::vk::spirv::module::Instruction<'_>| i.is(Op::Decorate) || i.is(Op::MemberDecorate);
        assert!(all[..at].iter().filter(is_decoration).count() > 3, "ours are there");
        assert_eq!(all[at..].iter().filter(is_decoration).count(), 0);
    }
}

#[test]
fn several_geometry_shaders_in_a_module_are_refused() {
    let point = |main: u32, name: &[u8; 4]| [ExecutionModel::Geometry as u32, main, u32::from_le_bytes(*name), 5];
    let types = (Op::TypeBool as u32, &[30][..]);
    let one = loose_position(&[point(7, b"go\0\0")], types);
    assert!(splice(&one, ExecutionModel::Geometry, "go", 2, false).is_ok());
    let two = loose_position(&[point(7, b"go\0\0"), point(9, b"on\0\0")], types);
    assert_eq!(
        splice(&two, ExecutionModel::Geometry, "go", 2, false),
        Err("several geometry shaders in one module".into())
    );
}

/// A handmade block with an array of structures with matrices.
#[test]
fn matrices_are_found_in_nested_blocks() {
    let mut words = vec![spirv::MAGIC_NUMBER, 0x0001_0300, 0, 40, 0];
    let mut put = |op: Op, operands: &[u32]| {
        words.push((operands.len() as u32 + 1) << 16 | op as u32);
        words.extend(operands);
    };
    let text = |text: &str| -> Vec<u32> {
        let mut bytes = text.as_bytes().to_vec();
        bytes.resize((text.len() / 4 + 1) * 4, 0);
        bytes.chunks(4).map(|four| u32::from_le_bytes(four.try_into().expect("four"))).collect()
    };
    let (uniform, push) = (StorageClass::Uniform as u32, StorageClass::PushConstant as u32);
    put(Op::MemberName, &[&[6, 1], &text("mvp")[..]].concat());
    put(Op::MemberDecorate, &[6, 0, Decoration::Offset as u32, 0]);
    put(Op::MemberDecorate, &[6, 1, Decoration::Offset as u32, 64]);
    put(Op::MemberDecorate, &[6, 1, Decoration::MatrixStride as u32, 16]);
    put(Op::MemberDecorate, &[6, 1, Decoration::RowMajor as u32]);
    put(Op::MemberDecorate, &[8, 1, Decoration::Offset as u32, 32]);
    put(Op::Decorate, &[10, Decoration::DescriptorSet as u32, 2]);
    put(Op::Decorate, &[10, Decoration::Binding as u32, 7]);
    put(Op::TypeFloat, &[1, 32]);
    put(Op::TypeVector, &[2, 1, 4]);
    put(Op::TypeMatrix, &[3, 2, 4]);
    put(Op::TypeInt, &[4, 32, 0]);
    put(Op::Constant, &[4, 5, 9]);
    put(Op::TypeStruct, &[6, 2, 3]);
    put(Op::TypeArray, &[7, 6, 5]);
    put(Op::TypeStruct, &[8, 2, 7]);
    put(Op::TypePointer, &[9, uniform, 8]);
    put(Op::Variable, &[9, 10, uniform]);
    put(Op::TypePointer, &[11, push, 6]);
    put(Op::Variable, &[11, 12, push]);
    let found = matrices(&words, false);
    let places: Vec<_> = found.iter().map(|m| (m.memory, m.offset, m.row_major, m.rank)).collect();
    assert_eq!(
        places,
        [(Memory::Buffer { set: 2, binding: 7 }, 96, true, 0), (Memory::Push, 64, true, 0)],
        "the first element of the array, and the push constant"
    );
}

/// Two matrices in a block. `through`: index of the matrix that flows through a function's
/// parameter into the position. The other one flows into an output of the program's own.
fn two_matrices(through: u32) -> Vec<u32> {
    let mut words = vec![spirv::MAGIC_NUMBER, 0x0001_0300, 0, 60, 0];
    let mut put = |op: Op, operands: &[u32]| {
        words.push((operands.len() as u32 + 1) << 16 | op as u32);
        words.extend(operands);
    };
    let (uniform, output, local) =
        (StorageClass::Uniform as u32, StorageClass::Output as u32, StorageClass::Function as u32);
    put(Op::MemberDecorate, &[25, 0, Decoration::Offset as u32, 0]);
    put(Op::MemberDecorate, &[25, 1, Decoration::Offset as u32, 64]);
    put(Op::Decorate, &[28, Decoration::BuiltIn as u32, spirv::BuiltIn::Position as u32]);
    put(Op::TypeVoid, &[20]);
    put(Op::TypeFunction, &[21, 20]);
    put(Op::TypeFloat, &[22, 32]);
    put(Op::TypeVector, &[23, 22, 4]);
    put(Op::TypeMatrix, &[24, 23, 4]);
    put(Op::TypeStruct, &[25, 24, 24]);
    put(Op::TypePointer, &[26, uniform, 25]);
    put(Op::TypePointer, &[27, output, 23]);
    put(Op::Variable, &[27, 28, output]);
    put(Op::Variable, &[27, 29, output]);
    put(Op::Variable, &[26, 30, uniform]);
    put(Op::TypeInt, &[31, 32, 0]);
    put(Op::Constant, &[31, 32, 0]);
    put(Op::Constant, &[31, 33, 1]);
    put(Op::TypePointer, &[34, uniform, 24]);
    put(Op::TypePointer, &[35, local, 23]);
    put(Op::TypeFunction, &[36, 23, 24]);
    put(Op::Constant, &[22, 37, 0]);
    put(Op::ConstantComposite, &[23, 38, 37, 37, 37, 37]);
    // vec4 f(mat4 m) { return m * constant; }
    put(Op::Function, &[23, 40, 0, 36]);
    put(Op::FunctionParameter, &[24, 41]);
    put(Op::Label, &[42]);
    put(Op::MatrixTimesVector, &[23, 43, 41, 38]);
    put(Op::ReturnValue, &[43]);
    put(Op::FunctionEnd, &[]);
    put(Op::Function, &[20, 44, 0, 21]);
    put(Op::Label, &[45]);
    put(Op::Variable, &[35, 46, local]);
    put(Op::AccessChain, &[34, 47, 30, 32 + through]);
    put(Op::Load, &[24, 48, 47]);
    put(Op::FunctionCall, &[23, 49, 40, 48]);
    put(Op::Store, &[46, 49]);
    put(Op::Load, &[23, 50, 46]);
    put(Op::Store, &[28, 50]);
    put(Op::AccessChain, &[34, 51, 30, 33 - through]);
    put(Op::Load, &[24, 52, 51]);
    put(Op::MatrixTimesVector, &[23, 53, 52, 38]);
    put(Op::Store, &[29, 53]);
    put(Op::Return, &[]);
    put(Op::FunctionEnd, &[]);
    words
}

#[test]
fn only_matrices_of_the_position_are_found_where_it_is_asked_for() {
    let offsets = |words: &[u32], of_position| -> HashSet<u32> {
        matrices(words, of_position).iter().map(|matrix| matrix.offset).collect()
    };
    for through in [0, 1] {
        let words = two_matrices(through);
        assert_eq!(offsets(&words, false), HashSet::from([0, 64]));
        assert_eq!(offsets(&words, true), HashSet::from([64 * through]));
    }
    // A pointer that cannot be followed: every matrix of the shader may flow into the position.
    let mut words = two_matrices(0);
    words.extend([(3 << 16) | Op::Store as u32, 59, 53]);
    assert_eq!(offsets(&words, true), HashSet::from([0, 64]));
    // Pointers that begin with each other, found by the fuzzer, and one with too many indices.
    let chain = |words: &mut Vec<u32>, result: u32, base: u32| {
        words.extend([(5 << 16) | Op::AccessChain as u32, 34, result, base, 32]);
    };
    let mut circle = two_matrices(0);
    chain(&mut circle, 54, 55);
    chain(&mut circle, 55, 54);
    circle.extend([(3 << 16) | Op::Store as u32, 54, 53]);
    assert_eq!(offsets(&circle, true), HashSet::from([0, 64]));
    let mut long = two_matrices(0);
    (100..1000).for_each(|number| chain(&mut long, number + 1, if number == 100 { 30 } else { number }));
    assert_eq!(offsets(&long, true), HashSet::from([0, 64]));
}

/// A block with an array of `vec4`. The elements from `first` on flow into the position, one for
/// each item of `products`: into a scalar product if the item is true, otherwise into a sum.
fn elements_of_an_array(first: u32, products: &[bool]) -> Vec<u32> {
    let mut words = vec![spirv::MAGIC_NUMBER, 0x0001_0300, 0, 200, 0];
    let mut put = |op: Op, operands: &[u32]| {
        words.push((operands.len() as u32 + 1) << 16 | op as u32);
        words.extend(operands);
    };
    let (uniform, output) = (StorageClass::Uniform as u32, StorageClass::Output as u32);
    put(Op::MemberDecorate, &[25, 0, Decoration::Offset as u32, 32]);
    put(Op::Decorate, &[24, Decoration::ArrayStride as u32, 16]);
    put(Op::Decorate, &[28, Decoration::BuiltIn as u32, spirv::BuiltIn::Position as u32]);
    put(Op::TypeVoid, &[20]);
    put(Op::TypeFunction, &[21, 20]);
    put(Op::TypeFloat, &[22, 32]);
    put(Op::TypeVector, &[23, 22, 4]);
    put(Op::TypeInt, &[31, 32, 0]);
    (0..32).for_each(|number| put(Op::Constant, &[31, 32 + number, number]));
    put(Op::TypeArray, &[24, 23, 32 + 31]);
    put(Op::TypeStruct, &[25, 24]);
    put(Op::TypePointer, &[26, uniform, 25]);
    put(Op::TypePointer, &[27, output, 23]);
    put(Op::TypePointer, &[29, uniform, 23]);
    put(Op::Variable, &[27, 28, output]);
    put(Op::Variable, &[26, 30, uniform]);
    put(Op::Function, &[20, 70, 0, 21]);
    put(Op::Label, &[71]);
    for (number, product) in (0..).zip(products) {
        let id = 72 + 4 * number;
        put(Op::AccessChain, &[29, id, 30, 32, 32 + first + number]);
        put(Op::Load, &[23, id + 1, id]);
        match product {
            true => put(Op::Dot, &[22, id + 2, id + 1, id + 1]),
            false => put(Op::FAdd, &[23, id + 2, id + 1, id + 1]),
        }
        put(Op::Store, &[28, id + 2]);
    }
    put(Op::Return, &[]);
    put(Op::FunctionEnd, &[]);
    words
}

#[test]
fn four_elements_of_an_array_are_a_matrix() {
    let found = |first, products: &[bool]| -> Vec<(u32, u32, bool)> {
        let words = elements_of_an_array(first, products);
        matrices(&words, true).iter().map(|matrix| (matrix.offset, matrix.stride, matrix.row_major)).collect()
    };
    assert_eq!(found(0, &[false; 4]), [(32, 16, false)]);
    assert_eq!(found(3, &[true; 4]), [(32 + 3 * 16, 16, true)]);
    assert_eq!(found(0, &[true, true, false, true]), [(32, 16, false)], "what goes into a sum is no row");
    assert_eq!(found(5, &[true; 3]), [], "three are none");
    // Groups from the first element on, and from the last one back: elements before or after a
    // matrix may flow into the position, too.
    assert_eq!(found(1, &[false; 6]), [(48, 16, false), (80, 16, false)]);
    assert_eq!(found(0, &[false; 8]), [(32, 16, false), (96, 16, false)]);
    assert!(matrices(&elements_of_an_array(0, &[false; 4]), false).is_empty(), "not where all may flow");
}
