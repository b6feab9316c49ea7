//! Inputs of other places, in handmade modules.

use super::frag_coord::fragment_stage;
use crate::intercept::vk::spirv::backdrop;
use crate::intercept::vk::spirv::module::instructions;
use crate::testing::random::Random;
use spirv::{BuiltIn, Decoration, Op};

/// A fragment stage that loads its input, which has this decoration, and one component of it.
fn stage(decoration: &[u32]) -> Vec<u32> {
    let load: [(u32, &[u32]); 3] =
        [(Op::Load as u32, &[3, 20, 5]), (Op::AccessChain as u32, &[9, 21, 5, 10]), (Op::Load as u32, &[2, 22, 21])];
    fragment_stage(decoration, &load)
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
