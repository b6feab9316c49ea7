//! Window coordinates of fragments, in handmade modules.

use super::module;
use crate::intercept::vk::spirv::frag_coord;
use crate::intercept::vk::spirv::module::instructions;
use crate::testing::random::Random;
use spirv::{BuiltIn, Decoration, ExecutionModel, Op, StorageClass};

/// A fragment stage with an input 5 of four floats, which has this decoration. Its function does `body`.
/// Ids: a pointer to input floats 9, a number 10.
pub(super) fn fragment_stage(decoration: &[u32], body: &[(u32, &[u32])]) -> Vec<u32> {
    let input = StorageClass::Input as u32;
    let decorated = [&[5], decoration].concat();
    let point = [ExecutionModel::Fragment as u32, 7, u32::from_le_bytes(*b"go\0\0"), 5];
    let (pointer, variable, to_float) = ([4, input, 3], [4, 5, input], [9, input, 2]);
    let mut all: Vec<(u32, &[u32])> = vec![
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
    ];
    all.extend(body);
    all.extend([(Op::Return as u32, &[][..]), (Op::FunctionEnd as u32, &[])]);
    module(40, &all)
}

/// A fragment stage whose function does `body`, with FragCoord as the input.
fn stage(body: &[(u32, &[u32])]) -> Vec<u32> {
    fragment_stage(&[Decoration::BuiltIn as u32, BuiltIn::FragCoord as u32], body)
}

const LOAD: (u32, &[u32]) = (Op::Load as u32, &[3, 20, 5]);
const CHAIN: (u32, &[u32]) = (Op::AccessChain as u32, &[9, 21, 5, 10]);
const LOAD_PART: (u32, &[u32]) = (Op::Load as u32, &[2, 22, 21]);

#[test]
fn loads_are_of_a_variable_that_is_given_its_value_first() {
    let words = stage(&[LOAD, CHAIN, LOAD_PART]);
    let changed = frag_coord(&words, "go", 3, 64).expect("it can be followed").expect("it asks");
    let all = instructions(&changed).expect("a module");
    let point = all.iter().find(|i| i.is(Op::EntryPoint)).expect("an entry point");
    let mode = all.iter().find(|i| i.is(Op::ExecutionMode)).expect("a mode");
    assert!(point.operand(1) != 7 && mode.operand(0) == point.operand(1), "both name the function of ours");
    let of_driver: Vec<_> = all.iter().filter(|i| i.is(Op::Load) && i.operand(2) == 5).collect();
    let wrapper = all.iter().find(|i| i.is(Op::Function) && i.operand(1) == point.operand(1)).expect("it is there");
    assert!(of_driver.len() == 1 && of_driver[0].offset > wrapper.offset, "only our function asks the driver");
    let load = all.iter().find(|i| i.is(Op::Load) && i.operand(1) == 20).expect("it stays");
    let chain = all.iter().find(|i| i.is(Op::AccessChain) && i.operand(1) == 21).expect("it stays");
    assert_eq!(load.operand(2), chain.operand(2));
    let private = StorageClass::Private as u32;
    let class = |kind: u32| all.iter().find(|i| i.is(Op::TypePointer) && i.operand(0) == kind).map(|i| i.operand(1));
    let variable = all.iter().find(|i| i.is(Op::Variable) && i.operand(1) == load.operand(2)).expect("ours");
    assert_eq!([class(variable.operand(0)), class(chain.operand(0))], [Some(private); 2]);
    assert!(all.iter().any(|i| i.is(Op::MemberDecorate) && i.rest(1) == [0, Decoration::Offset as u32, 64]));
}

#[test]
fn what_does_not_ask_is_left() {
    let mut words = stage(&[]);
    let place = words.iter().position(|word| *word == BuiltIn::FragCoord as u32).expect("the decoration");
    words[place] = BuiltIn::PointCoord as u32;
    assert_eq!(frag_coord(&words, "go", 3, 64), Ok(None));
}

#[test]
fn pointers_that_are_handed_on_are_refused() {
    let call: (u32, &[u32]) = (Op::FunctionCall as u32, &[1, 23, 7, 5]);
    let call_with_part: (u32, &[u32]) = (Op::FunctionCall as u32, &[1, 23, 7, 21]);
    let interpolated: (u32, &[u32]) = (Op::ExtInst as u32, &[3, 24, 30, 76, 5]);
    let copied: (u32, &[u32]) = (Op::CopyObject as u32, &[4, 25, 5]);
    for body in [&[LOAD, call][..], &[CHAIN, call_with_part], &[interpolated], &[copied]] {
        assert!(frag_coord(&stage(body), "go", 3, 64).is_err());
    }
    // A literal number with the value of the variable's id is not the variable.
    let number: (u32, &[u32]) = (Op::Constant as u32, &[11, 26, 5]);
    assert!(frag_coord(&stage(&[LOAD, number]), "go", 3, 64).is_ok());
}

/// A damaged module does no harm.
#[test]
fn damaged_modules_do_no_harm() {
    let words = stage(&[LOAD, CHAIN, LOAD_PART]);
    let mut random = Random::new(2);
    for _ in 0..3000 {
        let mut damaged = words.clone();
        for _ in 0..2 {
            let at = random.below(damaged.len());
            damaged[at] ^= 1 << random.below(32);
        }
        let _ = frag_coord(&damaged, "go", 3, 64);
    }
}
