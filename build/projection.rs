//! Compiles the GLSL of `src/correct/projected/projection.rs` and
//! `src/correct/projected/division.rs` to SPIR-V functions. They are inserted into a Vulkan
//! program's shader, or into a shader stage of Cupola behind it.
//!
//! naga makes a complete module. Only the code that one function needs is kept, in three parts for
//! three sections of another module. The positions of ids are stored with the parts, since ids get
//! new numbers there.

#[allow(dead_code, reason = "the library uses the rest")]
#[path = "../src/correct/projected/division.rs"]
mod division;
#[path = "../src/geom/division/rule.rs"]
mod rule;
#[allow(dead_code, reason = "the library uses the rest")]
#[path = "../src/correct/projected/projection.rs"]
mod texts;

use naga::back::spv;
use naga::front::glsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use spirv::{Decoration, Op};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Returns Rust source with the functions for views, with those for views and lenses, and with
/// those that divide primitives.
pub fn generate() -> String {
    let mut out = String::new();
    let fix = |curved: bool| functions(&texts::vulkan_functions(0, 0, curved), "cupola_fix", &[]);
    let divided = |input| {
        let text = [texts::vulkan_functions(0, 0, true), division::vulkan_division(input)].concat();
        functions(&text, "cupola_divided", &division::STAGE_FUNCTIONS)
    };
    let all = [
        ("VIEWS", fix(false)),
        ("LENSES", fix(true)),
        ("TRIANGLES", divided(division::Input::Triangles)),
        ("LINES", divided(division::Input::Lines)),
    ];
    for (name, functions) in all {
        writeln!(out, "static {name}: Functions = {functions};").expect("writing to a String");
    }
    out
}

/// An instruction: its opcode, and the words after the first.
type Instruction = (Op, Vec<u32>);

/// Returns the code of a text that `root` needs, as Rust source. The functions `open` are left out:
/// the module into which the code is inserted defines them.
fn functions(text: &str, root: &str, open: &[&str]) -> String {
    let call = if open.is_empty() { "" } else { "cupola_divided();" };
    let main = format!("void main() {{ {call} gl_Position = cupola_fix(position); }}");
    let text = format!("#version 450\n{text}layout(location = 0) in vec4 position;\n{main}\n");
    let all = compile(&text);
    let (head, bodies) = all.split_at(all.iter().position(|i| i.0 == Op::Function).expect("there are functions"));
    let bodies: Vec<&[Instruction]> = bodies.split_inclusive(|i| i.0 == Op::FunctionEnd).collect();
    let named = |name: &str| {
        let names = |i: &&Instruction| i.0 == Op::Name && i.1[1..] == words_of(name);
        head.iter().find(names).expect("naga writes names").1[0]
    };
    let (fix, root) = (named("cupola_fix"), named(root));
    let open: Vec<u32> = open.iter().map(|name| named(name)).collect();

    // Needed are the functions that it calls, then their types, constants and variables.
    let mut needed = BTreeSet::from([root, fix]);
    let mut kept = BTreeSet::new();
    let is_new = |needed: &BTreeSet<u32>, kept: &BTreeSet<u32>, function: u32| {
        needed.contains(&function) && !kept.contains(&function) && !open.contains(&function)
    };
    while let Some(body) = bodies.iter().position(|body| is_new(&needed, &kept, body[0].1[1])) {
        kept.insert(bodies[body][0].1[1]);
        needed.extend(bodies[body].iter().flat_map(all_ids));
    }
    let kept_bodies: Vec<&Instruction> =
        bodies.iter().filter(|body| kept.contains(&body[0].1[1])).flat_map(|body| body.iter()).collect();
    let mut globals = Vec::new();
    for instruction in head.iter().rev() {
        if is_global(instruction.0) && needed.contains(&instruction.1[result(instruction.0)]) {
            needed.extend(all_ids(instruction));
            globals.insert(0, instruction);
        }
    }
    // A declaration that is not kept here would be missing in programs.
    let made_within = kept_bodies.iter().flat_map(|i| result_within(i));
    let made = globals.iter().map(|i| i.1[result(i.0)]).chain(made_within).chain(open.iter().copied());
    let made: BTreeSet<u32> = made.collect();
    let import = head.iter().find(|i| i.0 == Op::ExtInstImport).expect("naga imports GLSL's functions").1[0];
    let missing: Vec<&u32> = needed.iter().filter(|id| !made.contains(id) && **id != import).collect();
    assert!(missing.is_empty(), "projection: nothing declares the ids {missing:?}");
    let decorates = |i: &&Instruction| matches!(i.0, Op::Decorate | Op::MemberDecorate) && needed.contains(&i.1[0]);
    let given: Vec<&Instruction> = head.iter().filter(decorates).collect();
    let variable = given.iter().find(|i| i.1[1] == Decoration::DescriptorSet as u32).expect("the block has a set").1[0];

    // Shaders of several passes must compute equal depths.
    let rounded =
        |i: &&&Instruction| matches!(i.0, Op::FAdd | Op::FSub | Op::FMul | Op::FDiv | Op::Dot | Op::VectorTimesScalar);
    let exact = |i: &&Instruction| (Op::Decorate, vec![i.1[1], Decoration::NoContraction as u32]);
    let exact: Vec<Instruction> = kept_bodies.iter().filter(rounded).map(exact).collect();
    let decorations = given.into_iter().chain(&exact).collect();
    let bound = 1 + needed.iter().max().expect("there are ids");
    let float4 = kept_bodies.iter().find(|i| i.0 == Op::Function && i.1[1] == fix).expect("it is kept").1[0];
    format!(
        "Functions {{ decorations: {}, globals: {}, bodies: {}, import: {import}, variable: {variable}, fix: {fix}, root: {root}, open: &{open:?}, vector: {float4}, bound: {bound} }}",
        part(decorations),
        part(globals),
        part(kept_bodies)
    )
}

/// Returns the instructions of a module for a GLSL vertex shader.
fn compile(text: &str) -> Vec<Instruction> {
    let module = glsl::Frontend::default()
        .parse(&glsl::Options::from(naga::ShaderStage::Vertex), text)
        .unwrap_or_else(|e| panic!("projection: {}", e.emit_to_string(text)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|e| panic!("projection: {}", e.emit_to_string(text)));
    // Names identify the functions. No coordinate adjustment: Cupola sets the direction of y
    // itself.
    let options = spv::Options { lang_version: (1, 0), flags: spv::WriterFlags::DEBUG, ..Default::default() };
    let words = spv::write_vec(&module, &info, &options, None).unwrap_or_else(|e| panic!("projection: {e}"));
    let (mut all, mut rest) = (Vec::new(), &words[5..]);
    while let Some(first) = rest.first() {
        let (instruction, behind) = rest.split_at((first >> 16) as usize);
        rest = behind;
        all.push((Op::from_u32(first & 0xffff).expect("naga writes known opcodes"), instruction[1..].to_vec()));
    }
    all
}

/// Returns a literal string as words.
fn words_of(text: &str) -> Vec<u32> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize((text.len() / 4 + 1) * 4, 0);
    bytes.chunks(4).map(|four| u32::from_le_bytes(four.try_into().expect("four"))).collect()
}

fn is_type(op: Op) -> bool {
    (Op::TypeVoid as u32..=Op::TypeForwardPointer as u32).contains(&(op as u32))
}

/// True if it declares a type, a constant or a variable.
fn is_global(op: Op) -> bool {
    let constant = matches!(op, Op::Constant | Op::ConstantTrue | Op::ConstantFalse | Op::ConstantNull);
    is_type(op) || constant || matches!(op, Op::ConstantComposite | Op::Variable)
}

/// Returns the index of a declaration's result among its operands.
fn result(op: Op) -> usize {
    usize::from(!is_type(op))
}

/// Returns the id that an instruction of a function defines, if it defines one.
fn result_within((op, operands): &Instruction) -> Option<u32> {
    match op {
        Op::Label => Some(operands[0]),
        Op::Store | Op::FunctionEnd | Op::Branch | Op::BranchConditional | Op::SelectionMerge | Op::LoopMerge => None,
        Op::Return | Op::ReturnValue | Op::Unreachable => None,
        _ => Some(operands[1]),
    }
}

/// Returns the indices of the operands that are ids.
fn ids((op, operands): &Instruction) -> Vec<usize> {
    let count = operands.len();
    let but = |literals: &[usize]| (0..count).filter(|i| !literals.contains(i)).collect();
    match op {
        Op::TypeFloat | Op::TypeInt | Op::Decorate | Op::MemberDecorate | Op::SelectionMerge => vec![0],
        Op::TypeVector | Op::Constant | Op::LoopMerge => vec![0, 1],
        Op::TypePointer => but(&[1]),
        Op::Variable | Op::Function => but(&[2]),
        Op::CompositeExtract => vec![0, 1, 2],
        Op::VectorShuffle => vec![0, 1, 2, 3],
        Op::ExtInst => but(&[3]),
        // Only without operands for memory access.
        Op::Load if count == 3 => but(&[]),
        Op::Store if count == 2 => but(&[]),
        Op::TypeVoid
        | Op::TypeBool
        | Op::TypeArray
        | Op::TypeStruct
        | Op::TypeFunction
        | Op::ConstantNull
        | Op::ConstantComposite => but(&[]),
        Op::FunctionParameter | Op::FunctionEnd | Op::FunctionCall | Op::Label | Op::Branch | Op::Return => but(&[]),
        Op::ReturnValue | Op::AccessChain | Op::CompositeConstruct | Op::Select => but(&[]),
        Op::BranchConditional if count == 3 => but(&[]),
        Op::FAdd | Op::FSub | Op::FMul | Op::FDiv | Op::FNegate | Op::Dot | Op::VectorTimesScalar => but(&[]),
        Op::FOrdEqual | Op::FOrdNotEqual => but(&[]),
        Op::Phi | Op::LogicalOr | Op::LogicalAnd | Op::LogicalNot | Op::LogicalEqual | Op::LogicalNotEqual => but(&[]),
        Op::IAdd | Op::ISub | Op::IMul | Op::SNegate | Op::IEqual | Op::INotEqual | Op::Bitcast => but(&[]),
        Op::SLessThan | Op::SLessThanEqual | Op::SGreaterThan | Op::SGreaterThanEqual => but(&[]),
        Op::ShiftLeftLogical | Op::ShiftRightArithmetic | Op::BitwiseAnd | Op::BitwiseOr | Op::Not => but(&[]),
        Op::All | Op::Any | Op::ConvertSToF | Op::ConstantTrue | Op::ConstantFalse | Op::Unreachable => but(&[]),
        Op::FOrdLessThan | Op::FOrdLessThanEqual | Op::FOrdGreaterThan | Op::FOrdGreaterThanEqual => but(&[]),
        _ => panic!("projection: which operands of {op:?} {operands:?} are ids?"),
    }
}

fn all_ids(instruction: &Instruction) -> Vec<u32> {
    ids(instruction).into_iter().map(|i| instruction.1[i]).collect()
}

/// Returns instructions as Rust source: their words, and the positions of ids among the words.
fn part(instructions: Vec<&Instruction>) -> String {
    let (mut words, mut places) = (Vec::new(), Vec::new());
    for instruction in instructions {
        let (op, operands) = instruction;
        words.push((operands.len() as u32 + 1) << 16 | *op as u32);
        places.extend(ids(instruction).into_iter().map(|i| words.len() + i));
        words.extend(operands);
    }
    format!("Part {{ words: &{words:?}, ids: &{places:?} }}")
}
