//! The splice, which makes a program's own shader draw into a view.
//!
//! The last stage before rasterisation gets an epilogue that reprojects `gl_Position`
//! (`correct::projected::projection`). All words of the program stay unchanged, known or not.
//! Functions, their types and a uniform block are added. The entry point then refers to a function
//! of Cupola that calls the program's.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::spirv::functions::{Additions, functions, push, push_code};
use crate::intercept::vk::spirv::module::{BOUND, Declarations, HEADER, Instruction, instructions, string};
use spirv::{BuiltIn, Decoration, ExecutionMode, ExecutionModel, FunctionControl, Op, StorageClass};

/// The first SPIR-V version in which an entry point lists all variables that it uses.
const NAMES_ALL: u32 = 0x0001_0400;

/// Greatest bound of a module's ids: 256 times the bound that every driver accepts. Ids of Cupola
/// follow the bound.
pub const MOST_IDS: u32 = 1 << 30;

/// Returns `words` with the epilogue, or the reason why there is none. The view constants are a
/// uniform block at binding 0 of `set`. With `lenses`, the lens of a picture follows them.
///
/// # Errors
/// What the shader does that cannot be followed, for the log.
pub fn splice(words: &[u32], model: ExecutionModel, entry: &str, set: u32, lenses: bool) -> Result<Vec<u32>, Obstacle> {
    let all = instructions(words).ok_or("a shader that is not SPIR-V")?;
    let declared = Declarations::new(&all);
    let is_entry = |i: &Instruction<'_>| i.is(Op::EntryPoint) && i.operand(0) == model as u32;
    let (point, main) = entry_point(&all, model, entry)?;
    // Vertices are emitted in functions that both entry points may call.
    if model == ExecutionModel::Geometry && all.iter().any(|i| is_entry(i) && i.offset != point.offset) {
        return Err("several geometry shaders in one module".into());
    }
    if all.iter().any(|i| i.is(Op::ExecutionMode) && (i.operand(0), i.operand(1)) == (main, ExecutionMode::Xfb as u32))
    {
        return Err("a shader whose output is captured".into());
    }
    let interface = 2 + string(point.rest(2)).1;
    let position = position(&declared, point.rest(interface)).ok_or("a shader that writes no gl_Position")?;
    if words[BOUND] > MOST_IDS {
        return Err("a shader with too many ids".into());
    }
    let mut additions = Additions::new(words[BOUND], &declared);
    let linked = additions.link(functions(lenses), set);
    let emits = model == ExecutionModel::Geometry;
    let void = additions.kind(Op::TypeVoid, &[]);
    let epilogue = epilogue(&mut additions, position, (linked.fix, linked.vector), (!emits).then_some(main));
    let entry = Entry {
        point,
        main,
        wrapper: (!emits).then_some(epilogue),
        variables: vec![linked.variable],
        inputs: Vec::new(),
    };
    let at_vertices = emits.then_some(AtVertices { epilogue, void });
    Ok(put_into(additions, words, &all, &entry, |additions, instruction, out| {
        let emitted = instruction.is(Op::EmitVertex) || instruction.is(Op::EmitStreamVertex);
        if let Some(AtVertices { epilogue, void }) = at_vertices.filter(|_| emitted) {
            let result = additions.id();
            push(out, Op::FunctionCall, &[void, result, epilogue]);
        }
        instruction.operands.to_vec()
    }))
}

/// Returns the entry point of this name, and its function. The function belongs to no other entry
/// point.
///
/// # Errors
/// The reason why there is none.
pub fn entry_point<'a>(
    all: &'a [Instruction<'a>],
    model: ExecutionModel,
    entry: &str,
) -> Result<(&'a Instruction<'a>, u32), Obstacle> {
    let is_entry =
        |i: &&Instruction<'_>| i.is(Op::EntryPoint) && i.operand(0) == model as u32 && string(i.rest(2)).0 == entry;
    let point = all.iter().find(is_entry).ok_or("a shader without its entry point")?;
    let main = point.operand(1);
    if main == 0 {
        return Err("a shader without its entry point".into());
    }
    if all.iter().any(|i| i.is(Op::EntryPoint) && i.operand(1) == main && i.offset != point.offset) {
        return Err("entry points that share a function".into());
    }
    Ok((point, main))
}

/// Location of `gl_Position`: the variable, and the member if the variable is a block.
#[derive(Clone, Copy)]
struct Position {
    variable: u32,
    member: Option<u32>,
}

fn position(declared: &Declarations<'_>, interface: &[u32]) -> Option<Position> {
    let is_position = |id, member| declared.number(id, member, Decoration::BuiltIn) == Some(BuiltIn::Position as u32);
    interface.iter().find_map(|&variable| {
        let (class, pointee) = declared.pointee(variable)?;
        if class != StorageClass::Output as u32 {
            return None;
        }
        if declared.is_vec4(pointee) && is_position(variable, None) {
            return Some(Position { variable, member: None });
        }
        let block = declared.get(pointee, Op::TypeStruct)?;
        let members = block.rest(1).iter().zip(0u32..);
        let mut places =
            members.filter(|(kind, member)| declared.is_vec4(**kind) && is_position(pointee, Some(*member)));
        places.next().map(|(_, member)| Position { variable, member: Some(member) })
    })
}

/// The entry point and its function.
pub struct Entry<'a> {
    /// Its instruction.
    pub point: &'a Instruction<'a>,
    /// The program's function.
    pub main: u32,
    /// Function of Cupola that replaces it. `None` if Cupola's function is called at each emitted
    /// vertex.
    pub wrapper: Option<u32>,
    /// Variables of Cupola that the entry point lists.
    pub variables: Vec<u32>,
    /// Those of `variables` that are inputs. They are listed in all versions of SPIR-V.
    pub inputs: Vec<u32>,
}

/// A call of Cupola's function at each emitted vertex.
#[derive(Clone, Copy)]
struct AtVertices {
    epilogue: u32,
    void: u32,
}

/// Returns a function that replaces `gl_Position` by the result of `fix`, a `vector`. It calls
/// `main` first, if there is one.
fn epilogue(to: &mut Additions<'_>, position: Position, (fix, vector): (u32, u32), main: Option<u32>) -> u32 {
    let void = to.kind(Op::TypeVoid, &[]);
    let function = to.kind(Op::TypeFunction, &[void]);
    let int = to.kind(Op::TypeInt, &[32, 0]);
    let [pointer, member, made] = std::array::from_fn(|_| to.id());
    let [label, called, place, old, new] = std::array::from_fn(|_| to.id());
    push(&mut to.globals, Op::TypePointer, &[pointer, StorageClass::Output as u32, vector]);
    push(&mut to.globals, Op::Constant, &[int, member, position.member.unwrap_or(0)]);
    let code = &mut to.bodies;
    push(code, Op::Function, &[void, made, FunctionControl::NONE.bits(), function]);
    push(code, Op::Label, &[label]);
    if let Some(main) = main {
        push(code, Op::FunctionCall, &[void, called, main]);
    }
    let place = match position.member {
        Some(_) => {
            push(code, Op::AccessChain, &[pointer, place, position.variable, member]);
            place
        }
        None => position.variable,
    };
    push(code, Op::Load, &[vector, old, place]);
    push(code, Op::FunctionCall, &[vector, new, fix, old]);
    push(code, Op::Store, &[place, new]);
    push(code, Op::Return, &[]);
    push(code, Op::FunctionEnd, &[]);
    made
}

/// True if an instruction comes before types, constants and variables (sections 1 to 8 of a
/// module).
fn before_types(instruction: &Instruction<'_>) -> bool {
    let head = [
        Op::Capability,
        Op::Extension,
        Op::ExtInstImport,
        Op::MemoryModel,
        Op::EntryPoint,
        Op::ExecutionMode,
        Op::ExecutionModeId,
        Op::String,
        Op::SourceExtension,
        Op::Source,
        Op::SourceContinued,
        Op::Name,
        Op::MemberName,
        Op::ModuleProcessed,
        Op::Decorate,
        Op::MemberDecorate,
        Op::DecorationGroup,
        Op::GroupDecorate,
        Op::GroupMemberDecorate,
        Op::DecorateId,
        Op::DecorateString,
        Op::MemberDecorateString,
    ];
    head.iter().any(|op| instruction.is(*op))
}

/// Returns the complete module. `change` returns the operands of each instruction of the program,
/// and may insert other instructions before it.
pub fn put_into(
    mut additions: Additions<'_>,
    words: &[u32],
    all: &[Instruction<'_>],
    entry: &Entry<'_>,
    change: impl Fn(&mut Additions<'_>, &Instruction<'_>, &mut Vec<u32>) -> Vec<u32>,
) -> Vec<u32> {
    let mut out = words[..HEADER].to_vec();
    let (mut imported, mut decorated, mut declared) = (false, false, false);
    for instruction in all {
        if instruction.is(Op::MemoryModel) && !std::mem::replace(&mut imported, true) {
            out.append(&mut additions.imports);
        }
        if !before_types(instruction) && !std::mem::replace(&mut decorated, true) {
            out.append(&mut additions.decorations);
        }
        if instruction.is(Op::Function) && !std::mem::replace(&mut declared, true) {
            out.append(&mut additions.globals);
        }
        let mut operands = change(&mut additions, instruction, &mut out);
        if instruction.offset == entry.point.offset {
            operands[1] = entry.wrapper.unwrap_or(entry.main);
            operands.extend(&entry.inputs);
            if words[1] >= NAMES_ALL {
                operands.extend(&entry.variables);
            }
        }
        let mode = instruction.is(Op::ExecutionMode) || instruction.is(Op::ExecutionModeId);
        if let (true, Some(wrapper)) = (mode && instruction.operand(0) == entry.main, entry.wrapper) {
            operands[0] = wrapper;
        }
        push_code(&mut out, instruction.opcode, &operands);
    }
    out.append(&mut additions.bodies);
    out[BOUND] = additions.bound();
    out
}
