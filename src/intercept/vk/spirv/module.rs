//! The words of a SPIR-V module, instruction by instruction. Unknown instructions are skipped.

use spirv::{Decoration, Op, StorageClass};
use std::collections::HashMap;

/// An instruction.
#[derive(Clone, Copy, Debug)]
pub struct Instruction<'a> {
    /// Offset of its first word in the module.
    pub offset: usize,
    /// Its opcode, known or not.
    pub opcode: u32,
    /// The words after the first one.
    pub operands: &'a [u32],
}

impl Instruction<'_> {
    /// True if the instruction is `op`.
    pub fn is(&self, op: Op) -> bool {
        self.opcode == op as u32
    }

    /// The operands from `index` on.
    pub fn rest(&self, index: usize) -> &[u32] {
        self.operands.get(index..).unwrap_or_default()
    }

    /// Operand `index`, or 0 if there is none: no id is 0.
    pub fn operand(&self, index: usize) -> u32 {
        self.operands.get(index).copied().unwrap_or(0)
    }
}

/// Words of the header.
pub const HEADER: usize = 5;

/// Word of the header that is greater than all ids.
pub const BOUND: usize = 3;

/// Returns the instructions of a module; `None` if `words` are no module in the byte order of this
/// machine.
pub fn instructions(words: &[u32]) -> Option<Vec<Instruction<'_>>> {
    if words.len() < HEADER || words.first() != Some(&spirv::MAGIC_NUMBER) {
        return None;
    }
    instructions_of(words, HEADER)
}

/// Returns the instructions from the word `offset` on; `None` if the last one does not end with the
/// words.
pub fn instructions_of(words: &[u32], mut offset: usize) -> Option<Vec<Instruction<'_>>> {
    let mut found = Vec::new();
    while let Some(&first) = words.get(offset) {
        let end = offset.checked_add((first >> 16) as usize).filter(|end| *end > offset)?;
        found.push(Instruction { offset, opcode: first & 0xffff, operands: words.get(offset + 1..end)? });
        offset = end;
    }
    Some(found)
}

/// Reads a literal string at the start of `words`. Returns it with the number of its words.
pub fn string(words: &[u32]) -> (String, usize) {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0).collect();
    let length = (bytes.len() / 4 + 1).min(words.len());
    (String::from_utf8_lossy(&bytes).into_owned(), length)
}

/// An id, or a member of one.
type ChunkOffset = (u32, Option<u32>);

/// Declarations of a module before its functions.
#[derive(Default)]
pub struct Declarations<'a> {
    /// Types, constants and variables by their id.
    pub by_id: HashMap<u32, Instruction<'a>>,
    /// Decorations: kind, operands.
    decorations: HashMap<ChunkOffset, Vec<(u32, &'a [u32])>>,
    /// Names.
    names: HashMap<ChunkOffset, String>,
    /// Imported sets of instructions.
    imports: Vec<(u32, String)>,
}

impl<'a> Declarations<'a> {
    /// Reads the declarations.
    pub fn new(instructions: &[Instruction<'a>]) -> Self {
        let mut all = Self::default();
        for instruction in instructions {
            let operands = instruction.operands;
            match Op::from_u32(instruction.opcode) {
                Some(Op::Decorate) if operands.len() >= 2 => {
                    let to = all.decorations.entry((operands[0], None)).or_default();
                    to.push((operands[1], &operands[2..]));
                }
                Some(Op::MemberDecorate) if operands.len() >= 3 => {
                    let to = all.decorations.entry((operands[0], Some(operands[1]))).or_default();
                    to.push((operands[2], &operands[3..]));
                }
                Some(Op::Name) if operands.len() >= 2 => {
                    all.names.insert((operands[0], None), string(&operands[1..]).0);
                }
                Some(Op::MemberName) if operands.len() >= 3 => {
                    all.names.insert((operands[0], Some(operands[1])), string(&operands[2..]).0);
                }
                Some(Op::ExtInstImport) if operands.len() >= 2 => {
                    all.imports.push((operands[0], string(&operands[1..]).0));
                }
                Some(Op::Function) => break,
                // The type of constants and variables comes before their id.
                Some(Op::Variable | Op::Constant | Op::SpecConstant) => {
                    all.by_id.insert(instruction.operand(1), *instruction);
                }
                Some(op) if (Op::TypeVoid as u32..=Op::TypeForwardPointer as u32).contains(&(op as u32)) => {
                    all.by_id.insert(instruction.operand(0), *instruction);
                }
                _ => {}
            }
        }
        all
    }

    /// Returns the operands of a decoration of an id, or of one of its members.
    pub fn decoration(&self, id: u32, member: Option<u32>, kind: Decoration) -> Option<&'a [u32]> {
        let list = self.decorations.get(&(id, member))?;
        list.iter().find(|(decoration, _)| *decoration == kind as u32).map(|(_, operands)| *operands)
    }

    /// True if an id has the decoration with this number.
    pub fn has(&self, id: u32, decoration: u32) -> bool {
        self.decorations.get(&(id, None)).is_some_and(|list| list.iter().any(|(known, _)| *known == decoration))
    }

    /// Returns the first operand of a decoration.
    pub fn number(&self, id: u32, member: Option<u32>, kind: Decoration) -> Option<u32> {
        self.decoration(id, member, kind)?.first().copied()
    }

    /// Returns the name of an id, or of one of its members; empty if it was stripped.
    pub fn name(&self, id: u32, member: Option<u32>) -> &str {
        self.names.get(&(id, member)).map_or("", String::as_str)
    }

    /// Returns the declaration of `id`, if it is an `op`.
    pub fn get(&self, id: u32, op: Op) -> Option<Instruction<'a>> {
        self.by_id.get(&id).copied().filter(|instruction| instruction.is(op))
    }

    /// Returns the storage class of a variable, and the type that its pointer points at.
    pub fn pointee(&self, variable: u32) -> Option<(u32, u32)> {
        let pointer = self.get(self.get(variable, Op::Variable)?.operand(0), Op::TypePointer)?;
        Some((pointer.operand(1), pointer.operand(2)))
    }

    /// Returns the type that addresses of a type point at; `None` if the type is none of addresses.
    pub fn address(&self, kind: u32) -> Option<u32> {
        let pointer = self.get(kind, Op::TypePointer)?;
        (pointer.operand(1) == StorageClass::PhysicalStorageBuffer as u32).then(|| pointer.operand(2))
    }

    /// True if the type is a matrix of four `vec4`.
    pub fn is_mat4(&self, id: u32) -> bool {
        self.get(id, Op::TypeMatrix).is_some_and(|matrix| matrix.operand(2) == 4 && self.is_vec4(matrix.operand(1)))
    }

    /// Returns the id of a set of instructions, if it is imported.
    pub fn imported(&self, name: &str) -> Option<u32> {
        self.imports.iter().find(|(_, known)| known == name).map(|(id, _)| *id)
    }

    /// Returns the id of a type with exactly these operands.
    pub fn find(&self, op: Op, operands: &[u32]) -> Option<u32> {
        self.by_id.iter().find(|(_, i)| i.is(op) && i.rest(1) == operands).map(|(id, _)| *id)
    }

    /// True if the type is a vector of four 32-bit floats.
    pub fn is_vec4(&self, id: u32) -> bool {
        self.get(id, Op::TypeVector).is_some_and(|vector| {
            vector.operand(2) == 4
                && self.get(vector.operand(1), Op::TypeFloat).is_some_and(|float| float.operand(1) == 32)
        })
    }
}
