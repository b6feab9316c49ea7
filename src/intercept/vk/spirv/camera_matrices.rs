//! 4×4 matrices of a shader that may be functions of the program's camera. Each becomes a choice
//! between the program's matrix and one of Cupola's.
//!
//! A function of Cupola, which becomes the entry point's function, gives each matrix a variable:
//! with the value of the program's block, or with that of the view constants. A number in the view
//! constants chooses. Loads of the matrix, or of a part of it, become loads of the variable.

use crate::intercept::scene::eye;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::spirv::dependence::PositionLoads;
use crate::intercept::vk::spirv::functions::{Additions, push};
use crate::intercept::vk::spirv::module::{BOUND, Declarations, Instruction, instructions};
use crate::intercept::vk::spirv::reflect::{Matrix, Memory};
use crate::intercept::vk::spirv::splice::{Entry, MOST_IDS, entry_point, put_into};
use crate::runtime::session::ViewMatrix;
use spirv::{Decoration, ExecutionModel, FunctionControl, Op, StorageClass};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Greatest number of matrices of one stage that are examined.
pub const MOST_CAMERAS: usize = 4;

/// Size in bytes of the matrices of both stages, with the numbers that choose between them.
pub const CAMERA_BYTES: u32 = 2 * (MOST_CAMERAS as u32 * 64 + 16);

/// Number of GLSL's function for the inverse.
const INVERSE: u32 = 34;

/// A shader with choices.
pub struct Chosen {
    /// Its words.
    pub words: Vec<u32>,
    /// Its matrices, in the order of Cupola's, and the kinds of view matrix that their names
    /// suggest.
    pub matrices: Vec<(Matrix, Option<ViewMatrix>)>,
    /// True if it computes an inverse.
    pub inverts: bool,
}

/// A matrix of the program: the variable, and the path of members and elements to it.
type Place = (u32, Vec<u32>);

/// A chain of indices that leads to a matrix or into it.
struct Chain {
    place: Place,
    /// Ids of the indices that lead to the matrix.
    to_matrix: Vec<u32>,
    /// Ids of the indices within the matrix.
    rest: Vec<u32>,
}

/// A matrix that is examined.
struct Found {
    matrix: Matrix,
    /// Its type.
    kind: u32,
    variable: u32,
    /// The members of structures that lead to it.
    members: Vec<u32>,
    /// Kind of view matrix that its name suggests.
    called: Option<ViewMatrix>,
    indices: Vec<u32>,
    class: u32,
}

/// Returns `words` with a choice for each 4×4 matrix; `None` if there is no such matrix. In a
/// vertex stage, matrices that may flow into the position are left out. The matrices of Cupola lie
/// at `offset` in the uniform block at binding 0 of `set`. The numbers that choose follow them.
///
/// # Errors
/// What the shader does that cannot be followed, for the log.
pub fn camera_matrices(
    words: &[u32],
    model: ExecutionModel,
    entry: &str,
    set: u32,
    offset: u32,
) -> Result<Option<Chosen>, Obstacle> {
    let all = instructions(words).ok_or("a shader that is not SPIR-V")?;
    let declared = Declarations::new(&all);
    let (chains, found) = chains(&all, &declared);
    let found = to_choose(&all, &declared, model, &chains, found);
    if found.is_empty() {
        return Ok(None);
    }
    let (point, main) = entry_point(&all, model, entry)?;
    if all.iter().filter(|i| i.is(Op::EntryPoint)).count() > 1 {
        return Err("several entry points in a module with matrices of the camera".into());
    }
    if words[BOUND] > MOST_IDS {
        return Err("a shader with too many ids".into());
    }
    let glsl = declared.imported("GLSL.std.450");
    let inverts = all.iter().any(|i| i.is(Op::ExtInst) && Some(i.operand(2)) == glsl && i.operand(3) == INVERSE);
    let mut additions = Additions::new(words[BOUND], &declared);
    let variables: Vec<u32> = found.iter().map(|(_, found)| private(&mut additions, found.kind)).collect();
    let ours: HashMap<&Place, u32> = found.iter().map(|(place, _)| place).zip(variables.iter().copied()).collect();
    let pointers = private_pointers(&mut additions, &declared, &all, &chains, &ours);
    let block = block(&mut additions, (set, offset));
    let wrapper = wrapper(&mut additions, &found, &variables, &block, main);
    let named = variables.iter().copied().chain([block.variable]).collect();
    let entry = Entry { point, main, wrapper: Some(wrapper), variables: named, inputs: Vec::new() };
    let change = |_: &mut Additions<'_>, i: &Instruction<'_>, _: &mut Vec<u32>| {
        let mut operands = i.operands.to_vec();
        let of = |id: u32| chains.get(&id).and_then(|chain| Some((chain, *ours.get(&chain.place)?)));
        if i.is(Op::Load)
            && let Some((_, variable)) = of(i.operand(2)).filter(|(chain, _)| chain.rest.is_empty())
        {
            operands[2] = variable;
        }
        if is_chain(i)
            && let Some((chain, variable)) = of(i.operand(1)).filter(|(chain, _)| !chain.rest.is_empty())
            && let Some(pointer) = pointers.get(&i.operand(0))
        {
            operands = [&[*pointer, i.operand(1), variable], &chain.rest[..]].concat();
        }
        operands
    };
    let matrices = found.iter().map(|(_, found)| (found.matrix, found.called)).collect();
    Ok(Some(Chosen { words: put_into(additions, words, &all, &entry, change), matrices, inverts }))
}

/// Returns the matrices that get a choice. Matrices that are passed on by pointer are left out, and
/// so are matrices that may flow into the position.
fn to_choose(
    all: &[Instruction<'_>],
    declared: &Declarations<'_>,
    model: ExecutionModel,
    chains: &HashMap<u32, Chain>,
    mut found: BTreeMap<Place, Found>,
) -> Vec<(Place, Found)> {
    if model == ExecutionModel::Vertex {
        // Any of the matrices may make the position.
        let Some(loads) = PositionLoads::of(all, declared) else { return Vec::new() };
        found.retain(|_, found| !loads.contain(found.variable, &found.members));
    }
    for place in handed_on(all, chains) {
        found.remove(&place);
    }
    found.into_iter().take(MOST_CAMERAS).collect()
}

fn is_chain(i: &Instruction<'_>) -> bool {
    i.is(Op::AccessChain) || i.is(Op::InBoundsAccessChain)
}

/// Returns the chains of a module by their results, and the matrices that they lead to.
fn chains(all: &[Instruction<'_>], declared: &Declarations<'_>) -> (HashMap<u32, Chain>, BTreeMap<Place, Found>) {
    let (mut chains, mut found) = (HashMap::new(), BTreeMap::new());
    let mut indices: HashMap<u32, (u32, Vec<u32>)> = HashMap::new();
    for i in all.iter().filter(|i| is_chain(i)) {
        let (base, before) = indices.get(&i.operand(2)).cloned().unwrap_or((i.operand(2), Vec::new()));
        let path = [&before[..], i.rest(3)].concat();
        indices.insert(i.operand(1), (base, path.clone()));
        let Some((numbers, of_matrix)) = matrix_at(declared, base, &path) else { continue };
        let count = numbers.len();
        let place = (base, numbers);
        let chain = Chain { place: place.clone(), to_matrix: path[..count].to_vec(), rest: path[count..].to_vec() };
        found.entry(place).or_insert(Found { indices: chain.to_matrix.clone(), ..of_matrix });
        chains.insert(i.operand(1), chain);
    }
    (chains, found)
}

/// Returns the matrix at the end of constant indices into a block, with the values of these
/// indices.
fn matrix_at(declared: &Declarations<'_>, variable: u32, path: &[u32]) -> Option<(Vec<u32>, Found)> {
    let (class, mut kind) = declared.pointee(variable)?;
    let number = |kind| declared.number(variable, None, kind).unwrap_or(0);
    let memory = if class == StorageClass::PushConstant as u32 {
        Memory::Push
    } else if [StorageClass::Uniform as u32, StorageClass::StorageBuffer as u32].contains(&class) {
        Memory::Buffer { set: number(Decoration::DescriptorSet), binding: number(Decoration::Binding) }
    } else {
        return None;
    };
    let (mut offset, mut numbers, mut members) = (0u32, Vec::new(), Vec::new());
    let (mut stride, mut row_major, mut called) = (16, false, None);
    for index in path {
        let number = declared.get(*index, Op::Constant)?.operand(2);
        if let Some(block) = declared.get(kind, Op::TypeStruct) {
            let member = Some(number);
            offset = offset.checked_add(declared.number(kind, member, Decoration::Offset)?)?;
            stride = declared.number(kind, member, Decoration::MatrixStride).unwrap_or(16);
            row_major = declared.decoration(kind, member, Decoration::RowMajor).is_some();
            let within = kind;
            kind = *block.rest(1).get(number as usize)?;
            members.push(number);
            called = eye::view_matrix_called(declared.name(within, member));
        } else {
            // An array of blocks has several descriptors.
            let array = declared.get(kind, Op::TypeArray).filter(|_| !numbers.is_empty())?;
            let element = declared.number(kind, None, Decoration::ArrayStride)?;
            offset = offset.checked_add(element.checked_mul(number)?)?;
            kind = array.operand(1);
        }
        numbers.push(number);
        if let Some(matrix) = declared.get(kind, Op::TypeMatrix) {
            let fits = matrix.operand(2) == 4 && declared.is_vec4(matrix.operand(1));
            let matrix = Matrix { memory, offset, stride, row_major, rank: 0 };
            return fits
                .then_some((numbers, Found { matrix, kind, variable, members, called, indices: Vec::new(), class }));
        }
    }
    None
}

/// Returns the matrices whose pointers are used for more than loads.
fn handed_on(all: &[Instruction<'_>], chains: &HashMap<u32, Chain>) -> HashSet<Place> {
    let mut handed = HashSet::new();
    for i in all {
        let used = match Op::from_u32(i.opcode) {
            Some(Op::FunctionCall) => i.rest(3),
            Some(Op::ExtInst) => i.rest(4),
            Some(Op::CopyObject | Op::Phi | Op::Select | Op::PtrAccessChain | Op::InBoundsPtrAccessChain) => i.rest(2),
            Some(Op::CopyMemory | Op::CopyMemorySized | Op::Store) => i.rest(0),
            _ => continue,
        };
        handed.extend(used.iter().filter_map(|id| chains.get(id)).map(|chain| chain.place.clone()));
    }
    handed
}

/// Adds a variable of Cupola.
fn private(to: &mut Additions<'_>, kind: u32) -> u32 {
    let [pointer, variable] = std::array::from_fn(|_| to.id());
    let class = StorageClass::Private as u32;
    push(&mut to.globals, Op::TypePointer, &[pointer, class, kind]);
    push(&mut to.globals, Op::Variable, &[pointer, variable, class]);
    variable
}

/// Returns, for the types of chains into matrices, the same types for Cupola's variables.
fn private_pointers(
    to: &mut Additions<'_>,
    declared: &Declarations<'_>,
    all: &[Instruction<'_>],
    chains: &HashMap<u32, Chain>,
    ours: &HashMap<&Place, u32>,
) -> HashMap<u32, u32> {
    let mut made = HashMap::new();
    for i in all.iter().filter(|i| is_chain(i)) {
        let into = chains.get(&i.operand(1)).is_some_and(|chain| ours.contains_key(&chain.place));
        let Some(pointer) = declared.get(i.operand(0), Op::TypePointer).filter(|_| into) else { continue };
        made.entry(i.operand(0)).or_insert_with(|| {
            let id = to.id();
            push(&mut to.globals, Op::TypePointer, &[id, StorageClass::Private as u32, pointer.operand(2)]);
            id
        });
    }
    made
}

/// The block with Cupola's matrices: columns, and numbers that choose.
struct Block {
    variable: u32,
    /// Type of a pointer to four floats.
    member: u32,
    int: u32,
    vector: u32,
    /// Indices of the block's members.
    members: [u32; 2],
}

fn block(to: &mut Additions<'_>, (set, offset): (u32, u32)) -> Block {
    let float = to.kind(Op::TypeFloat, &[32]);
    let vector = to.kind(Op::TypeVector, &[float, 4]);
    let int = to.kind(Op::TypeInt, &[32, 0]);
    let [structure, array, count, of_block, member, variable, zero, one] = std::array::from_fn(|_| to.id());
    let uniform = StorageClass::Uniform as u32;
    push(&mut to.globals, Op::Constant, &[int, count, 4 * MOST_CAMERAS as u32]);
    push(&mut to.globals, Op::TypeArray, &[array, vector, count]);
    push(&mut to.globals, Op::TypeStruct, &[structure, array, vector]);
    push(&mut to.globals, Op::TypePointer, &[of_block, uniform, structure]);
    push(&mut to.globals, Op::TypePointer, &[member, uniform, vector]);
    push(&mut to.globals, Op::Constant, &[int, zero, 0]);
    push(&mut to.globals, Op::Constant, &[int, one, 1]);
    push(&mut to.globals, Op::Variable, &[of_block, variable, uniform]);
    push(&mut to.decorations, Op::Decorate, &[array, Decoration::ArrayStride as u32, 16]);
    push(&mut to.decorations, Op::Decorate, &[structure, Decoration::Block as u32]);
    for (number, offset) in [(0, offset), (1, offset + MOST_CAMERAS as u32 * 64)] {
        push(&mut to.decorations, Op::MemberDecorate, &[structure, number, Decoration::Offset as u32, offset]);
    }
    push(&mut to.decorations, Op::Decorate, &[variable, Decoration::DescriptorSet as u32, set]);
    push(&mut to.decorations, Op::Decorate, &[variable, Decoration::Binding as u32, 0]);
    Block { variable, member, int, vector, members: [zero, one] }
}

/// Returns a function that sets Cupola's variables and calls `main`.
fn wrapper(to: &mut Additions<'_>, found: &[(Place, Found)], variables: &[u32], block: &Block, main: u32) -> u32 {
    let void = to.kind(Op::TypeVoid, &[]);
    let function = to.kind(Op::TypeFunction, &[void]);
    let float = to.kind(Op::TypeFloat, &[32]);
    let bool = to.kind(Op::TypeBool, &[]);
    let bools = to.kind(Op::TypeVector, &[bool, 4]);
    let half = to.id();
    push(&mut to.globals, Op::Constant, &[float, half, 0.5f32.to_bits()]);
    let columns: Vec<u32> = (0..4 * found.len() as u32)
        .map(|number| {
            let id = to.id();
            push(&mut to.globals, Op::Constant, &[block.int, id, number]);
            id
        })
        .collect();
    let pointers: Vec<u32> = found
        .iter()
        .map(|(_, found)| {
            let id = to.id();
            push(&mut to.globals, Op::TypePointer, &[id, found.class, found.kind]);
            id
        })
        .collect();
    let [made, label, called] = std::array::from_fn(|_| to.id());
    push(&mut to.bodies, Op::Function, &[void, made, FunctionControl::NONE.bits(), function]);
    push(&mut to.bodies, Op::Label, &[label]);
    let value = |to: &mut Additions<'_>, op: Op, kind: u32, operands: &[u32]| {
        let id = to.id();
        push(&mut to.bodies, op, &[&[kind, id], operands].concat());
        id
    };
    let at = value(to, Op::AccessChain, block.member, &[block.variable, block.members[1]]);
    let choices = value(to, Op::Load, block.vector, &[at]);
    for (number, (_, found)) in found.iter().enumerate() {
        let at = value(to, Op::AccessChain, pointers[number], &[&[found.variable], &found.indices[..]].concat());
        let own = value(to, Op::Load, found.kind, &[at]);
        let choice = value(to, Op::CompositeExtract, float, &[choices, number as u32]);
        let chosen = value(to, Op::FOrdGreaterThan, bool, &[choice, half]);
        let chosen = value(to, Op::CompositeConstruct, bools, &[chosen; 4]);
        let made: Vec<u32> = (0..4)
            .map(|column| {
                let index = columns[4 * number + column];
                let at = value(to, Op::AccessChain, block.member, &[block.variable, block.members[0], index]);
                let ours = value(to, Op::Load, block.vector, &[at]);
                let own = value(to, Op::CompositeExtract, block.vector, &[own, column as u32]);
                value(to, Op::Select, block.vector, &[chosen, ours, own])
            })
            .collect();
        let matrix = value(to, Op::CompositeConstruct, found.kind, &made);
        push(&mut to.bodies, Op::Store, &[variables[number], matrix]);
    }
    push(&mut to.bodies, Op::FunctionCall, &[void, called, main]);
    push(&mut to.bodies, Op::Return, &[]);
    push(&mut to.bodies, Op::FunctionEnd, &[]);
    made
}
