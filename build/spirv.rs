//! WGSL → SPIR-V for Vulkan, at build time.
//!
//! The uniform block of a pass becomes a private variable with a constant initialiser. Each of its
//! scalars is a marker: a number that occurs nowhere else in the module. The positions of the
//! markers are stored, and the values are inserted there at run time (see
//! `src/correct/shaders/spirv.rs`).

use naga::back::spv;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, ArraySize, Expression, Handle, Literal, Module, ScalarKind, Span, Type, TypeInner};
use std::fmt::Write;

/// Bits of the first marker of either kind: unusual numbers that no shader contains.
const FLOAT_MARKER: u32 = 0x7134_5000;
const UINT_MARKER: u32 = 0x9a34_5000;

/// First word of SPIR-V's instruction that defines a 32-bit constant: length 4, opcode 43.
const OP_CONSTANT: u32 = 4 << 16 | 43;

/// Opcodes of other instructions.
const OP_EXTENSION: u32 = 10;
const OP_TYPE_POINTER: u32 = 32;
const OP_VARIABLE: u32 = 59;
const OP_DECORATE: u32 = 71;

/// Appends the modules of one pass over one arrangement of the views' pictures as Rust source.
pub fn pass((name, content): (&str, bool), arrangement: &str, entries: &[&str], module: &Module, out: &mut String) {
    let vertex = emit(module, "rectangle_down").0;
    write!(
        out,
        "PassModules {{ pass: Pass::{name}, content: {content}, arrangement: Arrangement::{arrangement}, vertex: &{vertex:?}, fragments: &["
    )
    .expect("writing to a String");
    for entry in entries {
        let (words, slots) = emit(module, entry);
        let stage = if *entry == "map" { "Map" } else { "Present" };
        write!(out, "FragmentModule {{ stage: Stage::{stage}, words: &{words:?}, slots: &{slots:?} }},")
            .expect("writing to a String");
    }
    out.push_str("]},\n");
}

/// Returns a module with a compute shader as Rust source. Its buffers are declared as in Vulkan
/// 1.0.
pub fn compute(entry: &str, module: &Module) -> String {
    // naga's declarations need an extension in Vulkan 1.0: they have the storage class
    // StorageBuffer, in place of Uniform with the decoration BufferBlock.
    const STORAGE_BUFFER: u32 = 12;
    const UNIFORM: u32 = 2;
    const BLOCK: u32 = 2;
    const BUFFER_BLOCK: u32 = 3;
    let given = emit(module, entry).0;
    let (header, mut rest) = given.split_at(5);
    let mut words = header.to_vec();
    while let Some(first) = rest.first() {
        let (instruction, behind) = rest.split_at((first >> 16) as usize);
        rest = behind;
        let mut instruction = instruction.to_vec();
        match (first & 0xffff, &mut instruction[..]) {
            (OP_EXTENSION, _) => continue,
            (OP_TYPE_POINTER, [_, _, class, ..]) | (OP_VARIABLE, [_, _, _, class, ..]) if *class == STORAGE_BUFFER => {
                *class = UNIFORM;
            }
            (OP_DECORATE, [_, _, decoration]) if *decoration == BLOCK => *decoration = BUFFER_BLOCK,
            _ => {}
        }
        words.extend(instruction);
    }
    format!("static WORDS: &[u32] = &{words:?};")
}

/// Returns the words of one entry point, and for each scalar of the constants its position and
/// whether it is unsigned.
fn emit(module: &Module, entry: &str) -> (Vec<u32>, Vec<(usize, bool)>) {
    let mut module = module.clone();
    module.entry_points.retain(|point| point.name == entry);
    let mut markers = Vec::new();
    fill_constants(&mut module, &mut markers);
    naga::compact::compact(&mut module, naga::compact::KeepUnused::No);
    let info = Validator::new(ValidationFlags::all(), Capabilities::default())
        .validate(&module)
        .unwrap_or_else(|e| panic!("shaders: {entry} as SPIR-V: {e:?}"));
    // No coordinate adjustment: Cupola sets the direction of y itself.
    let options = spv::Options { lang_version: (1, 0), flags: spv::WriterFlags::empty(), ..Default::default() };
    let words = spv::write_vec(&module, &info, &options, None).unwrap_or_else(|e| panic!("shaders: {entry}: {e}"));
    let slots = if module.global_variables.iter().any(|(_, v)| v.space == AddressSpace::Private) {
        markers.into_iter().map(|(bits, unsigned)| (place(&words, bits, entry), unsigned)).collect()
    } else {
        Vec::new()
    };
    (words, slots)
}

/// Turns the uniform `constants`, if there is one, into a private variable whose initialiser has a
/// marker for each scalar.
fn fill_constants(module: &mut Module, markers: &mut Vec<(u32, bool)>) {
    let found = module.global_variables.iter().find(|(_, v)| v.name.as_deref() == Some("constants"));
    let Some((variable, ty)) = found.map(|(handle, v)| (handle, v.ty)) else { return };
    let initialiser = marked(module, ty, markers);
    let variable = module.global_variables.get_mut(variable);
    variable.space = AddressSpace::Private;
    variable.binding = None;
    variable.init = Some(initialiser);
}

/// Returns a constant of type `ty` made of new markers, in the order of a GLSL constructor.
fn marked(module: &mut Module, ty: Handle<Type>, markers: &mut Vec<(u32, bool)>) -> Handle<Expression> {
    let number = markers.len() as u32;
    let parts: Vec<Handle<Expression>> = match module.types[ty].inner.clone() {
        TypeInner::Scalar(scalar) => {
            let unsigned = scalar.kind == ScalarKind::Uint;
            let bits = if unsigned { UINT_MARKER } else { FLOAT_MARKER } + number;
            markers.push((bits, unsigned));
            let literal = if unsigned { Literal::U32(bits) } else { Literal::F32(f32::from_bits(bits)) };
            return module.global_expressions.append(Expression::Literal(literal), Span::UNDEFINED);
        }
        TypeInner::Vector { size, scalar } => {
            let scalar = anonymous(module, TypeInner::Scalar(scalar));
            (0..size as usize).map(|_| marked(module, scalar, markers)).collect()
        }
        TypeInner::Matrix { columns, rows, scalar } => {
            let column = anonymous(module, TypeInner::Vector { size: rows, scalar });
            (0..columns as usize).map(|_| marked(module, column, markers)).collect()
        }
        TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
            (0..count.get()).map(|_| marked(module, base, markers)).collect()
        }
        TypeInner::Struct { members, .. } => members.iter().map(|member| marked(module, member.ty, markers)).collect(),
        other => panic!("shaders: a type that constants cannot have: {other:?}"),
    };
    module.global_expressions.append(Expression::Compose { ty, components: parts }, Span::UNDEFINED)
}

fn anonymous(module: &mut Module, inner: TypeInner) -> Handle<Type> {
    module.types.insert(Type { name: None, inner }, Span::UNDEFINED)
}

/// Returns the position of the value of the constant with these bits, which must be the only one.
fn place(words: &[u32], bits: u32, entry: &str) -> usize {
    let mut found = None;
    let mut at = 5;
    while at < words.len() {
        if words[at] == OP_CONSTANT && words[at + 3] == bits {
            assert!(found.replace(at + 3).is_none(), "shaders: {entry}: two constants {bits:#x}");
        }
        at += (words[at] >> 16) as usize;
    }
    found.unwrap_or_else(|| panic!("shaders: {entry}: no constant {bits:#x}"))
}
