//! The splice that lets a program's own shader draw into a view.
//!
//! The last stage before rasterisation gets an epilogue that re-projects `gl_Position` (`geom::reprojection`).
//! All words of the program stay as they are, known or not; a function, its types and a uniform block are
//! put in, and the entry point leads to a function of ours that calls the program's.

use super::module::{Declarations, HEADER, Instruction, instructions, string};
use spirv::{BuiltIn, Decoration, ExecutionMode, ExecutionModel, FunctionControl, Op, StorageClass};

/// The first version in which an entry point names all variables that it uses.
const NAMES_ALL: u32 = 0x0001_0400;

/// Rows of the block: x, y, w, and (E, depth factor, depth offset, unused).
const ROWS: u32 = 4;

/// `words` with the epilogue, or why there is none. The rows are a uniform block at binding 0 of `set`.
///
/// # Errors
/// For people: what the shader does that cannot be followed.
pub fn splice(words: &[u32], model: ExecutionModel, entry: &str, set: u32) -> Result<Vec<u32>, &'static str> {
    let all = instructions(words).ok_or("a shader that is not SPIR-V")?;
    let declared = Declarations::new(&all);
    let is_entry = |i: &Instruction<'_>| i.is(Op::EntryPoint) && i.operand(0) == model as u32;
    let named = |i: &&Instruction<'_>| is_entry(i) && string(i.rest(2)).0 == entry;
    let point = all.iter().find(named).ok_or("a shader without its entry point")?;
    let main = point.operand(1);
    if main == 0 {
        return Err("a shader without its entry point");
    }
    if all.iter().any(|i| i.is(Op::EntryPoint) && i.operand(1) == main && i.offset != point.offset) {
        return Err("entry points that share a function");
    }
    if all.iter().any(|i| i.is(Op::ExecutionMode) && (i.operand(0), i.operand(1)) == (main, ExecutionMode::Xfb as u32))
    {
        return Err("a shader whose output is captured");
    }
    let interface = 2 + string(point.rest(2)).1;
    let position = position(&declared, point.rest(interface)).ok_or("a shader that writes no gl_Position")?;
    let mut parts = Parts::new(words[3], &declared);
    let emits = model == ExecutionModel::Geometry;
    let fix = parts.epilogue(&declared, position, set, (!emits).then_some(main));
    Ok(parts.put_into(words, &all, &Entry { point, main, wrapper: (!emits).then_some(fix), fix }))
}

/// Where `gl_Position` is: the variable, and the member where it is a block.
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

/// The entry point and where it leads.
struct Entry<'a> {
    point: &'a Instruction<'a>,
    main: u32,
    /// Our function that takes the program's place; `None`: ours is called at each vertex that is emitted.
    wrapper: Option<u32>,
    fix: u32,
}

/// What is put in.
struct Parts {
    next: u32,
    void: u32,
    variable: u32,
    decorations: Vec<u32>,
    globals: Vec<u32>,
    functions: Vec<u32>,
}

impl Parts {
    fn new(bound: u32, declared: &Declarations<'_>) -> Self {
        let mut parts = Self {
            next: bound,
            void: 0,
            variable: 0,
            decorations: Vec::new(),
            globals: Vec::new(),
            functions: Vec::new(),
        };
        parts.void = parts.kind(declared, Op::TypeVoid, &[]);
        parts
    }

    fn id(&mut self) -> u32 {
        self.next += 1;
        self.next - 1
    }

    /// The module's own type of this kind, which must be the only one, or a new one.
    fn kind(&mut self, declared: &Declarations<'_>, op: Op, operands: &[u32]) -> u32 {
        declared.find(op, operands).unwrap_or_else(|| {
            let id = self.id();
            push(&mut self.globals, op, &[&[id], operands].concat());
            id
        })
    }

    /// A type that may be there more than once.
    fn new_kind(&mut self, op: Op, operands: &[u32]) -> u32 {
        let id = self.id();
        push(&mut self.globals, op, &[&[id], operands].concat());
        id
    }

    fn constant(&mut self, kind: u32, value: u32) -> u32 {
        let id = self.id();
        push(&mut self.globals, Op::Constant, &[kind, id, value]);
        id
    }

    fn decorate(&mut self, id: u32, kind: Decoration, operands: &[u32]) {
        push(&mut self.decorations, Op::Decorate, &[&[id, kind as u32], operands].concat());
    }

    /// An instruction of our function with a result.
    fn compute(&mut self, op: Op, kind: u32, operands: &[u32]) -> u32 {
        let id = self.id();
        push(&mut self.functions, op, &[&[kind, id], operands].concat());
        if matches!(op, Op::FAdd | Op::FSub | Op::FMul | Op::Dot) {
            // Shaders of several passes must give equal depths.
            self.decorate(id, Decoration::NoContraction, &[]);
        }
        id
    }

    /// The function that re-projects; before that it calls `main`, if one is given.
    fn epilogue(&mut self, declared: &Declarations<'_>, position: Position, set: u32, main: Option<u32>) -> u32 {
        let (uniform, output) = (StorageClass::Uniform as u32, StorageClass::Output as u32);
        let function = self.kind(declared, Op::TypeFunction, &[self.void]);
        let float = self.kind(declared, Op::TypeFloat, &[32]);
        let vec4 = self.kind(declared, Op::TypeVector, &[float, 4]);
        let int = self.kind(declared, Op::TypeInt, &[32, 0]);
        let bool = self.kind(declared, Op::TypeBool, &[]);
        let count = self.constant(int, ROWS);
        let rows = self.new_kind(Op::TypeArray, &[vec4, count]);
        let block = self.new_kind(Op::TypeStruct, &[rows]);
        let block_pointer = self.new_kind(Op::TypePointer, &[uniform, block]);
        let row_pointer = self.new_kind(Op::TypePointer, &[uniform, vec4]);
        let vec4_pointer = self.new_kind(Op::TypePointer, &[output, vec4]);
        let indices: [u32; ROWS as usize] = std::array::from_fn(|i| self.constant(int, i as u32));
        let member = position.member.map(|member| self.constant(int, member));
        self.variable = self.id();
        push(&mut self.globals, Op::Variable, &[block_pointer, self.variable, uniform]);
        self.decorate(rows, Decoration::ArrayStride, &[16]);
        self.decorate(block, Decoration::Block, &[]);
        push(&mut self.decorations, Op::MemberDecorate, &[block, 0, Decoration::Offset as u32, 0]);
        self.decorate(self.variable, Decoration::DescriptorSet, &[set]);
        self.decorate(self.variable, Decoration::Binding, &[0]);

        let fix = self.id();
        push(&mut self.functions, Op::Function, &[self.void, fix, FunctionControl::NONE.bits(), function]);
        let label = self.id();
        push(&mut self.functions, Op::Label, &[label]);
        if let Some(main) = main {
            self.compute(Op::FunctionCall, self.void, &[main]);
        }
        let place = match member {
            Some(member) => self.compute(Op::AccessChain, vec4_pointer, &[position.variable, member]),
            None => position.variable,
        };
        let clip = self.compute(Op::Load, vec4, &[place]);
        let [x, y, z, w] = std::array::from_fn(|i| self.compute(Op::CompositeExtract, float, &[clip, i as u32]));
        let [row_x, row_y, row_w, rest] = indices.map(|index| {
            let place = self.compute(Op::AccessChain, row_pointer, &[self.variable, indices[0], index]);
            self.compute(Op::Load, vec4, &[place])
        });
        let [e, factor, offset] = std::array::from_fn(|i| self.compute(Op::CompositeExtract, float, &[rest, i as u32]));
        let turned = self.compute(Op::FMul, float, &[e, w]);
        let q = self.compute(Op::FAdd, float, &[z, turned]);
        let terms = self.compute(Op::CompositeConstruct, vec4, &[x, y, w, q]);
        let [new_x, new_y, new_w] = [row_x, row_y, row_w].map(|row| self.compute(Op::Dot, float, &[row, terms]));
        let back = self.compute(Op::FMul, float, &[e, new_w]);
        let depth = self.compute(Op::FSub, float, &[q, back]);
        let depth = self.compute(Op::FMul, float, &[factor, depth]);
        let moved = self.compute(Op::FMul, float, &[offset, new_w]);
        let depth = self.compute(Op::FAdd, float, &[depth, moved]);
        let farthest = self.compute(Op::FOrdEqual, bool, &[z, w]);
        let new_z = self.compute(Op::Select, float, &[farthest, new_w, depth]);
        let new = self.compute(Op::CompositeConstruct, vec4, &[new_x, new_y, new_z, new_w]);
        push(&mut self.functions, Op::Store, &[place, new]);
        push(&mut self.functions, Op::Return, &[]);
        push(&mut self.functions, Op::FunctionEnd, &[]);
        fix
    }

    /// The whole module.
    fn put_into(mut self, words: &[u32], all: &[Instruction<'_>], entry: &Entry<'_>) -> Vec<u32> {
        let mut out = words[..HEADER].to_vec();
        let (mut decorated, mut declared) = (false, false);
        for instruction in all {
            let opcode = instruction.opcode;
            let begins_types = (Op::TypeVoid as u32..=Op::TypeForwardPointer as u32).contains(&opcode)
                || [Op::Line as u32, Op::NoLine as u32].contains(&opcode);
            if begins_types && !std::mem::replace(&mut decorated, true) {
                out.append(&mut self.decorations);
            }
            if instruction.is(Op::Function) && !std::mem::replace(&mut declared, true) {
                out.append(&mut self.globals);
            }
            let emits = instruction.is(Op::EmitVertex) || instruction.is(Op::EmitStreamVertex);
            if emits && entry.wrapper.is_none() {
                let result = self.id();
                push(&mut out, Op::FunctionCall, &[self.void, result, entry.fix]);
            }
            let mut operands = instruction.operands.to_vec();
            if instruction.offset == entry.point.offset {
                operands[1] = entry.wrapper.unwrap_or(entry.main);
                if words[1] >= NAMES_ALL {
                    operands.push(self.variable);
                }
            }
            let mode = instruction.is(Op::ExecutionMode) || instruction.is(Op::ExecutionModeId);
            if let (true, Some(wrapper)) = (mode && instruction.operand(0) == entry.main, entry.wrapper) {
                operands[0] = wrapper;
            }
            out.push((operands.len() as u32 + 1) << 16 | opcode);
            out.extend(operands);
        }
        out.append(&mut self.functions);
        out[3] = self.next;
        out
    }
}

fn push(to: &mut Vec<u32>, op: Op, operands: &[u32]) {
    to.push((operands.len() as u32 + 1) << 16 | op as u32);
    to.extend(operands);
}
