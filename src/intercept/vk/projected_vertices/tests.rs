//! Outputs of shaders, and the stage that divides, with handmade modules.

use crate::correct::projected::division::Input;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::projected_vertices::{Limits, divide, stage_outputs};
use crate::intercept::vk::spirv::module::{BOUND, Declarations, Instruction, instructions};
use crate::intercept::vk::spirv::tests::module;
use crate::testing::random::Random;
use spirv::{Decoration, ExecutionModel, Op, StorageClass};
use std::collections::HashSet;

/// Types of [`interface`]: four floats, an unsigned integer, two floats.
const VECTOR: u32 = 3;
const NUMBER: u32 = 4;
const PAIR: u32 = 5;

/// A handmade stage with the entry point "go". Its variables have these types, locations and
/// components; the last item is true for a flat variable.
fn interface(model: ExecutionModel, variables: &[(u32, u32, u32, bool)]) -> Vec<u32> {
    let vertex = model == ExecutionModel::Vertex;
    let class = if vertex { StorageClass::Output } else { StorageClass::Input } as u32;
    const POSITION: u32 = 30;
    let mut named = vec![model as u32, 7, u32::from_le_bytes(*b"go\0\0")];
    named.extend((20..).take(variables.len()));
    let mut all: Vec<(u32, Vec<u32>)> = vec![(Op::Capability as u32, vec![1]), (Op::MemoryModel as u32, vec![0, 1])];
    let mut decorations = Vec::new();
    let mut declared = Vec::new();
    for (id, (kind, location, component, flat)) in (20..).zip(variables) {
        let mut decorate = |what: Decoration, with: &[u32]| {
            decorations.push((Op::Decorate as u32, [&[id, what as u32], with].concat()));
        };
        decorate(Decoration::Location, &[*location]);
        decorate(Decoration::Component, &[*component]);
        if *flat {
            decorate(Decoration::Flat, &[]);
        }
        declared.push((Op::Variable as u32, vec![10 + kind, id, class]));
    }
    if vertex {
        named.push(POSITION);
        let position = [POSITION, Decoration::BuiltIn as u32, spirv::BuiltIn::Position as u32];
        decorations.push((Op::Decorate as u32, position.to_vec()));
        declared.push((Op::Variable as u32, vec![10 + VECTOR, POSITION, class]));
    }
    all.push((Op::EntryPoint as u32, named));
    all.extend(decorations);
    all.extend([
        (Op::TypeVoid as u32, vec![1]),
        (Op::TypeFloat as u32, vec![2, 32]),
        (Op::TypeVector as u32, vec![VECTOR, 2, 4]),
        (Op::TypeInt as u32, vec![NUMBER, 32, 0]),
        (Op::TypeVector as u32, vec![PAIR, 2, 2]),
    ]);
    all.extend([VECTOR, NUMBER, PAIR].map(|kind| (Op::TypePointer as u32, vec![10 + kind, class, kind])));
    all.extend(declared);
    all.extend([
        (Op::TypeFunction as u32, vec![6, 1]),
        (Op::Function as u32, vec![1, 7, 0, 6]),
        (Op::Label as u32, vec![8]),
        (Op::Return as u32, vec![]),
        (Op::FunctionEnd as u32, vec![]),
    ]);
    let all: Vec<(u32, &[u32])> = all.iter().map(|(op, operands)| (*op, &operands[..])).collect();
    module(40, &all)
}

/// A vertex shader, and a fragment shader that reads all of its outputs. The output at location 2
/// is flat.
fn pair() -> [Vec<u32>; 2] {
    let variables = |flat| [(VECTOR, 0, 0, false), (NUMBER, 1, 3, flat), (PAIR, 2, 1, flat)];
    [interface(ExecutionModel::Vertex, &variables(false)), interface(ExecutionModel::Fragment, &variables(true))]
}

/// Returns the dividing stage between the two, for a device with these limits.
fn divided(input: Input, limits: &Limits) -> Result<Vec<u32>, Obstacle> {
    counting(input, limits, true)
}

/// Returns the dividing stage, with or without the counter.
fn counting(input: Input, limits: &Limits, counts: bool) -> Result<Vec<u32>, Obstacle> {
    let [vertex, fragment] = pair();
    let fragment = (&fragment[..], ExecutionModel::Fragment, "go");
    divide(input, &stage_outputs((&vertex, ExecutionModel::Vertex, "go"), Some(fragment))?, 0, 4, counts, limits)
}

/// A device with the smallest limits that Vulkan allows.
const LEAST: Limits = Limits { vertices: 256, all_components: 1024, components: [64, 64], runs: 32 };

#[test]
fn what_is_handed_on_is_what_is_read() {
    let [vertex, fragment] = pair();
    let vertex = (&vertex[..], ExecutionModel::Vertex, "go");
    let all = stage_outputs(vertex, Some((&fragment, ExecutionModel::Fragment, "go"))).expect("it is followed");
    let flat: Vec<bool> = all.variables.iter().flat_map(|v| &v.leaves).map(|leaf| leaf.flat).collect();
    assert_eq!((all.components, all.locations, &flat[..]), (7, 3, &[false, true, true][..]));
    // It is enough to read one of the two floats.
    let some = interface(ExecutionModel::Fragment, &[(PAIR, 2, 2, false)]);
    let some = stage_outputs(vertex, Some((&some, ExecutionModel::Fragment, "go"))).expect("it is followed");
    assert_eq!((some.variables.len(), some.components, some.variables[0].leaves[0].flat), (1, 2, false));
    assert_eq!(stage_outputs(vertex, None).expect("it is followed").components, 0, "depths alone");
    assert!(stage_outputs(vertex, Some((&fragment, ExecutionModel::Fragment, "no"))).is_err());
}

#[test]
fn a_stage_that_divides_declares_nothing_twice() {
    for input in [Input::Triangles, Input::Lines] {
        let words = divided(input, &LEAST).expect("there is room");
        let all = instructions(&words).expect("a module");
        let unique = [Op::TypeVoid, Op::TypeBool, Op::TypeInt, Op::TypeFloat, Op::TypeVector, Op::TypeFunction];
        let mut seen = HashSet::new();
        for i in all.iter().filter(|i| unique.iter().any(|op| i.is(*op))) {
            assert!(seen.insert((i.opcode, i.operands[1..].to_vec())), "{i:?}");
        }
        let mut functions = HashSet::new();
        for i in all.iter().filter(|i| i.is(Op::Function)) {
            assert!(i.operand(1) < words[BOUND] && functions.insert(i.operand(1)), "{i:?}");
        }
        let mut called = all.iter().filter(|i| i.is(Op::FunctionCall)).map(|i| i.operand(2));
        assert!(called.all(|function| functions.contains(&function)), "every function that is called is there");
        assert_eq!(all.iter().filter(|i| i.is(Op::EmitVertex)).count(), 1);
    }
}

/// Apart from vertices, only the counter is written: once, at its binding.
#[test]
fn a_stage_counts_by_its_own_number_or_not_at_all() {
    for input in [Input::Triangles, Input::Lines] {
        for counts in [true, false] {
            let words = counting(input, &LEAST, counts).expect("there is room");
            let all = instructions(&words).expect("a module");
            let declared = Declarations::new(&all);
            let added: Vec<_> = all.iter().filter(|i| i.is(Op::AtomicIAdd)).collect();
            assert_eq!(added.len(), usize::from(counts));
            let bound = |id: &u32| declared.number(*id, None, Decoration::Binding);
            let variables = all.iter().filter(|i| i.is(Op::Variable)).map(|i| i.operand(1));
            let bindings: HashSet<u32> = variables.filter_map(|id| bound(&id)).collect();
            assert_eq!(bindings, if counts { HashSet::from([0, 1]) } else { HashSet::from([0]) });
            for i in added {
                let place = all.iter().find(|place| place.is(Op::AccessChain) && place.operand(1) == i.operand(2));
                assert_eq!(bound(&place.expect("an element of a block").operand(2)), Some(1));
            }
        }
    }
}

#[test]
fn a_stage_is_as_large_as_the_device_allows() {
    let vertices = |input, limits: &Limits| {
        let words = divided(input, limits).expect("there is room");
        let all = instructions(&words).expect("a module");
        let is_count = |i: &&Instruction<'_>| {
            i.is(Op::ExecutionMode) && i.operand(1) == spirv::ExecutionMode::OutputVertices as u32
        };
        all.iter().find(is_count).map(|i| i.operand(2)).expect("it is said")
    };
    // Eleven components each.
    assert_eq!(vertices(Input::Triangles, &LEAST), 93);
    assert_eq!(vertices(Input::Lines, &Limits { vertices: 31, ..LEAST }), 30);
    assert!(divided(Input::Triangles, &Limits { vertices: 11, ..LEAST }).is_err(), "fewer than four parts");
    assert!(divided(Input::Triangles, &Limits { runs: 8, ..LEAST }).is_err());
    assert!(divided(Input::Triangles, &Limits { components: [64, 8], ..LEAST }).is_err());
}

/// Damaged shaders do no harm.
#[test]
fn damaged_shaders_are_divided_or_refused() {
    let [vertex, fragment] = pair();
    let mut random = Random::new(7);
    for _ in 0..3000 {
        let mut damaged = [vertex.clone(), fragment.clone()];
        for words in &mut damaged {
            let at = random.below(words.len());
            words[at] ^= 1 << random.below(32);
        }
        let entries =
            ((&damaged[0][..], ExecutionModel::Vertex, "go"), (&damaged[1][..], ExecutionModel::Fragment, "go"));
        if let Ok(stage_outputs) = stage_outputs(entries.0, Some(entries.1)) {
            let _ = divide(Input::Triangles, &stage_outputs, 0, 1, false, &LEAST);
        }
    }
}
