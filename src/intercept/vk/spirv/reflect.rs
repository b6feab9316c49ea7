//! Locations of a shader's 4×4 matrices.

use crate::intercept::scene::flat_program::MissingLens;
use crate::intercept::scene::lens;
use crate::intercept::vk::spirv::addresses::{Address, addresses};
use crate::intercept::vk::spirv::dependence::PositionLoads;
use crate::intercept::vk::spirv::module::{Declarations, Instruction, instructions};
use spirv::{BuiltIn, Decoration, Op, StorageClass};
use std::collections::{BTreeMap, HashSet};

/// The memory that a matrix is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Memory {
    /// Push constants.
    Push,
    /// A buffer, by set and binding.
    Buffer {
        /// Descriptor set.
        set: u32,
        /// Binding in the set; the first one of an array of descriptors.
        binding: u32,
    },
    /// A buffer whose address is in push constants.
    PushedAddress {
        /// Offset of the address in bytes.
        at: u32,
    },
    /// A buffer whose address is in a buffer.
    AddressInBuffer {
        /// Descriptor set.
        set: u32,
        /// Binding in the set.
        binding: u32,
        /// Offset of the address in bytes.
        at: u32,
    },
    /// Attributes of vertices or instances, one for each column.
    Attribute {
        /// Location of the first column.
        location: u32,
        /// True if it is declared as a matrix. If not, four vectors may be its columns.
        declared: bool,
    },
}

impl Memory {
    /// Returns the memory at an address that is in this memory; `None` if that is not followed.
    fn at_address(self, at: u32) -> Option<Self> {
        match self {
            Self::Push => Some(Self::PushedAddress { at }),
            Self::Buffer { set, binding } => Some(Self::AddressInBuffer { set, binding, at }),
            _ => None,
        }
    }

    /// Reason why a draw whose matrix is here has no lens, if it cannot be read.
    pub fn if_unreadable(self) -> MissingLens {
        match self {
            Self::Push | Self::Buffer { .. } => MissingLens::OfDevice,
            Self::PushedAddress { .. } | Self::AddressInBuffer { .. } => MissingLens::Address,
            Self::Attribute { .. } => MissingLens::Attribute,
        }
    }

    /// True if a matrix is here. False: only vectors that may be a matrix.
    pub fn has_matrix(self) -> bool {
        !matches!(self, Self::Attribute { declared: false, .. })
    }
}

/// A 4×4 matrix of 32-bit floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Matrix {
    /// Memory that it is in.
    pub memory: Memory,
    /// Offset in bytes.
    pub offset: u32,
    /// Distance of two columns, or of two rows, in bytes.
    pub stride: u32,
    /// True if rows follow each other, not columns.
    pub row_major: bool,
    /// Rank of its name: the lower, the higher its priority.
    pub rank: u8,
}

/// Greatest number of matrices of one shader that are examined.
const MOST: usize = 16;

/// Greatest depth of nested blocks. No program is known to need more.
const DEEPEST: usize = 4;

/// Returns the matrices in a shader's uniform blocks, storage blocks and push constants, and at
/// addresses that these hold, the likeliest first. Of arrays, only the first element is taken.
/// `of_position`: only matrices that may flow into the shader's `Position`.
pub fn matrices(words: &[u32], of_position: bool) -> Vec<Matrix> {
    let Some(all) = instructions(words) else { return Vec::new() };
    let declared = Declarations::new(&all);
    let loads = if of_position { PositionLoads::of(&all, &declared) } else { None };
    let mut found = Vec::new();
    for (variable, mut pointee) in globals(&all, &declared) {
        let Some(memory) = memory(&declared, variable) else { continue };
        if let Some(array) = declared.get(pointee, Op::TypeArray) {
            pointee = array.operand(1);
        }
        let name = declared.name(variable, None);
        let loaded = Loaded { loads: loads.as_ref(), variable };
        members(&declared, pointee, &Within { memory, offset: 0, name, path: Vec::new() }, &loaded, &mut found);
    }
    for Address { id, pointee, variable, at } in addresses(&all, &declared) {
        let Some(memory) = memory(&declared, variable).and_then(|memory| memory.at_address(at)) else { continue };
        let loaded = Loaded { loads: loads.as_ref(), variable: id };
        members(&declared, pointee, &Within { memory, offset: 0, name: "", path: Vec::new() }, &loaded, &mut found);
    }
    found.sort_by_key(|matrix| matrix.rank);
    let mut seen = HashSet::new();
    found.retain(|matrix| seen.insert(*matrix));
    found.truncate(MOST);
    found
}

/// Variables outside of functions, and the types that they point at.
fn globals<'a>(all: &'a [Instruction<'_>], declared: &'a Declarations<'_>) -> impl Iterator<Item = (u32, u32)> + 'a {
    let globals = all.iter().take_while(|i| !i.is(Op::Function)).filter(|i| i.is(Op::Variable));
    globals.filter_map(|i| Some((i.operand(1), declared.pointee(i.operand(1))?.1)))
}

/// Returns the memory of a variable; `None` if it is no block of the program.
fn memory(declared: &Declarations<'_>, variable: u32) -> Option<Memory> {
    let (class, _) = declared.pointee(variable)?;
    if class == StorageClass::PushConstant as u32 {
        return Some(Memory::Push);
    }
    let place = |kind| declared.number(variable, None, kind).unwrap_or(0);
    [StorageClass::Uniform as u32, StorageClass::StorageBuffer as u32]
        .contains(&class)
        .then(|| Memory::Buffer { set: place(Decoration::DescriptorSet), binding: place(Decoration::Binding) })
}

/// Returns the matrices among the attributes of a vertex shader. Four vectors at consecutive ones of
/// `locations`, which are attributes of instances, may be a matrix. `of_position`: as for
/// [`matrices`].
pub fn attribute_matrices(words: &[u32], of_position: bool, locations: &[u32]) -> Vec<Matrix> {
    let Some(all) = instructions(words) else { return Vec::new() };
    let declared = Declarations::new(&all);
    let loads = if of_position { PositionLoads::of(&all, &declared) } else { None };
    let matrix = |location, rank, declared| Matrix {
        memory: Memory::Attribute { location, declared },
        offset: 0,
        stride: 16,
        row_major: false,
        rank,
    };
    let (mut found, mut vectors) = (Vec::new(), BTreeMap::new());
    for (variable, kind) in globals(&all, &declared) {
        let is_input = declared.pointee(variable).is_some_and(|(class, _)| class == StorageClass::Input as u32);
        let flows = loads.as_ref().is_none_or(|loads| loads.reach(variable));
        let location = declared.number(variable, None, Decoration::Location).filter(|_| is_input && flows);
        let Some(location) = location else { continue };
        let rank = lens::rank(declared.name(variable, None));
        if declared.is_mat4(kind) {
            found.push(matrix(location, rank, true));
        } else if declared.is_vec4(kind) && locations.contains(&location) {
            vectors.insert(location, rank);
        }
    }
    let places: Vec<u32> = vectors.keys().copied().collect();
    found.extend(lens::fours(&places).into_iter().map(|first| {
        let ranks = (first..).map_while(|location| vectors.get(&location)).take(4);
        matrix(first, ranks.copied().min().unwrap_or_default(), false)
    }));
    found
}

/// Returns the reason why a shader in which no matrix was found has no lens.
pub fn missing_lens(words: &[u32]) -> MissingLens {
    let Some(all) = instructions(words) else { return MissingLens::default() };
    let declared = Declarations::new(&all);
    let Some(loads) = PositionLoads::of(&all, &declared) else { return MissingLens::default() };
    let reached = || all.iter().skip_while(|i| !i.is(Op::Function)).filter(|i| loads.reach(i.operand(1)));
    let multiplies = |i: &Instruction<'_>| {
        let [matrix, vector] = [Op::MatrixTimesMatrix, Op::MatrixTimesVector].map(|op| i.is(op));
        (matrix && declared.is_mat4(i.operand(0)))
            || ((vector || i.is(Op::VectorTimesMatrix)) && declared.is_vec4(i.operand(0)))
    };
    let storage = StorageClass::StorageBuffer as u32;
    let is_stored = |variable| declared.pointee(variable).is_some_and(|(class, _)| class == storage);
    if reached().any(|i| declared.address(i.operand(0)).is_some()) {
        MissingLens::Address
    } else if reached().any(multiplies) {
        MissingLens::Composed
    } else if globals(&all, &declared).any(|(variable, _)| is_stored(variable) && loads.contain(variable, &[])) {
        MissingLens::Stored
    } else {
        MissingLens::NoMatrix
    }
}

/// True if no data of the program flow into the position of a vertex shader without attributes: its
/// positions are numbers in the shader.
pub fn has_fixed_position(words: &[u32]) -> bool {
    let Some(all) = instructions(words) else { return false };
    let declared = Declarations::new(&all);
    let Some(loads) = PositionLoads::of(&all, &declared) else { return false };
    let image = StorageClass::UniformConstant as u32;
    let is_image = |variable| declared.pointee(variable).is_some_and(|(class, _)| class == image);
    !loads.any() && !globals(&all, &declared).any(|(variable, _)| is_image(variable) && loads.reach(variable))
}

/// True if a fragment shader uses its position on the screen.
pub fn asks_place(words: &[u32]) -> bool {
    let place = [Decoration::BuiltIn as u32, BuiltIn::FragCoord as u32];
    let asks = |i: &Instruction<'_>| i.is(Op::Decorate) && i.rest(1) == place;
    instructions(words).is_some_and(|all| all.iter().any(asks))
}

/// Parts of a variable that are loaded for the position.
struct Loaded<'a> {
    /// `None`: every part may be loaded.
    loads: Option<&'a PositionLoads>,
    variable: u32,
}

impl Loaded<'_> {
    fn contains(&self, path: &[u32]) -> bool {
        self.loads.is_none_or(|loads| loads.contain(self.variable, path))
    }

    /// Returns the matrices among the elements of an array of `vec4`, by the index of the first
    /// element, and whether the elements are rows.
    fn fours(&self, path: &[u32]) -> Vec<(u32, bool)> {
        self.loads.map(|loads| loads.fours(self.variable, path)).unwrap_or_default()
    }
}

/// Position in a block.
struct Within<'a> {
    memory: Memory,
    offset: u32,
    /// Name of the enclosing member, used for members without a name.
    name: &'a str,
    /// The path of members to this position.
    path: Vec<u32>,
}

fn members(declared: &Declarations<'_>, id: u32, within: &Within<'_>, loaded: &Loaded<'_>, found: &mut Vec<Matrix>) {
    let Some(block) = declared.get(id, Op::TypeStruct).filter(|_| within.path.len() < DEEPEST) else { return };
    for (member, &kind) in block.rest(1).iter().enumerate() {
        let mut path = within.path.clone();
        path.push(member as u32);
        let member = Some(member as u32);
        let offset = declared.number(id, member, Decoration::Offset).unwrap_or(0);
        let Some(offset) = within.offset.checked_add(offset) else { continue };
        let (given, mut kind) = (kind, kind);
        for _ in 0..DEEPEST {
            let array = declared.get(kind, Op::TypeArray).or_else(|| declared.get(kind, Op::TypeRuntimeArray));
            kind = array.map_or(kind, |array| array.operand(1));
        }
        let own = declared.name(id, member);
        let name = if own.is_empty() { within.name } else { own };
        if declared.get(kind, Op::TypeMatrix).is_some() {
            if declared.is_mat4(kind) && loaded.contains(&path) {
                found.push(Matrix {
                    memory: within.memory,
                    offset,
                    stride: declared.number(id, member, Decoration::MatrixStride).unwrap_or(16),
                    row_major: declared.decoration(id, member, Decoration::RowMajor).is_some(),
                    rank: lens::rank(name),
                });
            }
        } else if declared.is_vec4(kind) {
            // Languages other than GLSL store a matrix as four elements of an array.
            let stride = declared.number(given, None, Decoration::ArrayStride).unwrap_or(16);
            for (first, row_major) in loaded.fours(&path) {
                let Some(offset) = first.checked_mul(stride).and_then(|bytes| offset.checked_add(bytes)) else {
                    continue;
                };
                found.push(Matrix { memory: within.memory, offset, stride, row_major, rank: lens::rank(name) });
            }
        } else {
            members(declared, kind, &Within { memory: within.memory, offset, name, path }, loaded, found);
        }
    }
}
