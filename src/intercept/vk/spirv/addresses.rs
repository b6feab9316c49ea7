//! Addresses of buffers that a shader loads from the program's blocks.

use crate::intercept::vk::spirv::module::{Declarations, Instruction};
use spirv::{Decoration, Op};
use std::collections::HashMap;

/// An address that a shader loads.
pub struct Address {
    /// Id of the address in the shader.
    pub id: u32,
    /// Type of what it points at.
    pub pointee: u32,
    /// Variable that it is loaded from.
    pub variable: u32,
    /// Offset in the variable, in bytes.
    pub at: u32,
}

/// Greatest number of instructions between the load of an address and its use.
const MOST_STEPS: usize = 8;

/// Returns the addresses that are loaded from variables outside of functions at constant offsets.
pub fn addresses(all: &[Instruction<'_>], declared: &Declarations<'_>) -> Vec<Address> {
    let mut origins = Origins::default();
    let body = || all.iter().skip_while(|i| !i.is(Op::Function));
    body().for_each(|i| origins.add(i));
    let address = |i: &Instruction<'_>| {
        let made = i.is(Op::Load) || i.is(Op::ConvertUToPtr) || i.is(Op::Bitcast);
        let pointee = declared.address(i.operand(0)).filter(|_| made)?;
        let (variable, at) = origins.place(declared, i.operand(1))?;
        Some(Address { id: i.operand(1), pointee, variable, at })
    };
    body().filter_map(address).collect()
}

/// Origins of the values of a shader.
#[derive(Default)]
struct Origins<'a> {
    /// From a loaded or converted value to the pointer or value that it is made from.
    from: HashMap<u32, u32>,
    /// Access chains: what they point into, and their indices.
    chains: HashMap<u32, (u32, &'a [u32])>,
    /// Values that are stored through pointers; `None` if there are several.
    stored: HashMap<u32, Option<u32>>,
}

impl<'a> Origins<'a> {
    fn add(&mut self, i: &Instruction<'a>) {
        match Op::from_u32(i.opcode) {
            Some(Op::Load | Op::ConvertUToPtr | Op::Bitcast | Op::CopyObject) => {
                self.from.insert(i.operand(1), i.operand(2));
            }
            Some(Op::AccessChain | Op::InBoundsAccessChain) => {
                let indices = i.operands.get(3..).unwrap_or_default();
                self.chains.insert(i.operand(1), (i.operand(2), indices));
            }
            Some(Op::Store) => {
                let value = Some(i.operand(1));
                let kept = self.stored.entry(i.operand(0)).or_insert(value);
                *kept = kept.filter(|known| Some(*known) == value);
            }
            _ => {}
        }
    }

    /// Returns the variable outside of functions, and the offset in it, that the value `id` comes
    /// from.
    fn place(&self, declared: &Declarations<'_>, mut id: u32) -> Option<(u32, u32)> {
        for _ in 0..MOST_STEPS {
            if let Some((base, indices)) = self.chains.get(&id) {
                let (_, kind) = declared.pointee(*base)?;
                return Some((*base, offset(declared, kind, indices)?));
            }
            let next = self.from.get(&id).or_else(|| self.stored.get(&id)?.as_ref())?;
            id = *next;
        }
        None
    }
}

/// Returns the offset of the member of `kind` that constant indices choose; `None` if an index
/// chooses something else than a member.
fn offset(declared: &Declarations<'_>, mut kind: u32, indices: &[u32]) -> Option<u32> {
    let mut bytes = 0u32;
    for index in indices {
        let block = declared.get(kind, Op::TypeStruct)?;
        let member = declared.get(*index, Op::Constant)?.operand(2);
        bytes = bytes.checked_add(declared.number(kind, Some(member), Decoration::Offset)?)?;
        kind = block.rest(1).get(member as usize).copied()?;
    }
    Some(bytes)
}
