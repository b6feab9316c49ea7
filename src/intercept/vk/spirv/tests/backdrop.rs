//! Inputs of other places, in handmade modules.

use super::module;
use crate::intercept::vk::spirv::backdrop;
use crate::intercept::vk::spirv::module::instructions;
use crate::testing::random::Random;
use spirv::{BuiltIn, Decoration, ExecutionModel, Op, StorageClass};

/// A fragment stage with an input 5 of four floats, which has this decoration, and a pointer 9 to one
/// of them. Its function loads the input and one component of it.
fn stage(decoration: &[u32]) -> Vec<u32> {
    let input = StorageClass::Input as u32;
    let point = [ExecutionModel::Fragment as u32, 7, u32::from_le_bytes(*b"go\0\0"), 5];
    let decorated = [&[5], decoration].concat();
    let (pointer, variable, to_float) = ([4, input, 3], [4, 5, input], [9, input, 2]);
    let all: Vec<(u32, &[u32])> = vec![
        (Op::Capability as u32, &[1]),
        (Op::MemoryModel as u32, &[0, 1]),
        (Op::EntryPoint as u32, &point),
        (Op::ExecutionMode as u32, &[7, 7]),
        (Op::Decorate as u32, &decorated),
        (Op::TypeVoid as u32, &[1]),
        (Op::TypeFloat as u32, &[2, 32]),
        (Op::TypeVector as u32, &[3, 2, 4]),
        (Op::TypePointer as u32, &pointer),
        (Op::TypePointer as u32, &to_float),
        (Op::TypeInt as u32, &[11, 32, 0]),
        (Op::Constant as u32, &[11, 10, 0]),
        (Op::Variable as u32, &variable),
        (Op::TypeFunction as u32, &[6, 1]),
        (Op::Function as u32, &[1, 7, 0, 6]),
        (Op::Label as u32, &[8]),
        (Op::Load as u32, &[3, 20, 5]),
        (Op::AccessChain as u32, &[9, 21, 5, 10]),
        (Op::Load as u32, &[2, 22, 21]),
        (Op::Return as u32, &[]),
        (Op::FunctionEnd as u32, &[]),
    ];
    module(40, &all)
}

fn location() -> [u32; 2] {
    [Decoration::Location as u32, 0]
}

/// Returns how many loads of the input the changed stage has, and how many derivatives.
fn loads_and_derivatives(decoration: &[u32]) -> (usize, usize) {
    let words = backdrop(&stage(decoration), "go", 3, 64).expect("it can be followed");
    let all = instructions(&words).expect("a module");
    let load = all.iter().find(|i| i.is(Op::Load) && i.operand(1) == 20).expect("it stays");
    let chain = all.iter().find(|i| i.is(Op::AccessChain) && i.operand(1) == 21).expect("it stays");
    assert_eq!(load.operand(2), chain.operand(2));
    let count = |is: &dyn Fn(&&crate::intercept::vk::spirv::module::Instruction<'_>) -> bool| {
        all.iter().filter(|i| is(i)).count()
    };
    (count(&|i| i.is(Op::Load) && i.operand(2) == 5), count(&|i| i.is(Op::DPdx) || i.is(Op::DPdy)))
}

#[test]
fn an_input_becomes_a_variable_that_is_given_its_value_first() {
    assert_eq!(loads_and_derivatives(&location()), (1, 2), "it is loaded once, by our function");
    let words = backdrop(&stage(&location()), "go", 3, 64).expect("it can be followed");
    let all = instructions(&words).expect("a module");
    let builtin = [Decoration::BuiltIn as u32, BuiltIn::FragCoord as u32];
    let place = all.iter().find(|i| i.is(Op::Decorate) && i.rest(1) == builtin).expect("the place is asked for");
    let point = all.iter().find(|i| i.is(Op::EntryPoint)).expect("an entry point");
    assert!(point.rest(3).contains(&place.operand(0)) && point.rest(3).contains(&5));
}

#[test]
fn the_place_follows_from_the_matrix_and_not_from_derivatives() {
    let builtin = [Decoration::BuiltIn as u32, BuiltIn::FragCoord as u32];
    assert_eq!(loads_and_derivatives(&builtin), (2, 0), "loaded for itself, and as the place of the tile");
}

#[test]
fn constant_and_other_built_in_inputs_stay() {
    assert_eq!(loads_and_derivatives(&[Decoration::Flat as u32]), (1, 0), "the program's own load");
    let builtin = [Decoration::BuiltIn as u32, BuiltIn::SamplePosition as u32];
    assert_eq!(loads_and_derivatives(&builtin), (1, 0), "the program's own load");
}

/// A damaged module does no harm.
#[test]
fn damaged_modules_do_no_harm() {
    let words = stage(&location());
    let mut random = Random::new(3);
    for _ in 0..3000 {
        let mut damaged = words.clone();
        for _ in 0..2 {
            let at = random.below(damaged.len());
            damaged[at] ^= 1 << random.below(32);
        }
        let _ = backdrop(&damaged, "go", 3, 64);
    }
}
