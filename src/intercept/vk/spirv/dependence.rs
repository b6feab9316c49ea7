//! Values that flow into `Position`. Only a matrix among them can contain the lens.
//!
//! Ids and variables of all functions are followed. Each variable is followed as one value. Only
//! blocks that the program fills are followed member by member. In doubt a value counts as flowing:
//! this includes all conditions, in every function, and all arguments of a call.

use crate::intercept::scene::lens;
use crate::intercept::vk::spirv::module::{Declarations, Instruction};
use spirv::{BuiltIn, Decoration, Op, StorageClass};
use std::collections::{BTreeMap, HashMap, HashSet};

/// A member of the program's blocks: the variable, and the path of members to it.
type Member = (u32, Vec<u32>);

/// Members of the program's blocks that may flow into the position.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct PositionLoads {
    members: HashSet<Member>,
    /// Elements of arrays that are loaded by a constant index. The value is true if the element is
    /// only used in scalar products.
    elements: HashMap<Member, BTreeMap<u32, bool>>,
    /// All ids that may flow into the position.
    ids: HashSet<u32>,
}

impl PositionLoads {
    /// True if the loaded members include the member at `path` of a variable, or a part of it. All
    /// elements of an array count as one.
    pub fn contain(&self, variable: u32, path: &[u32]) -> bool {
        self.members.iter().any(|(of, loaded)| *of == variable && loaded.iter().zip(path).all(|(a, b)| a == b))
    }

    /// True if any member of the program's blocks is loaded.
    pub fn any(&self) -> bool {
        !self.members.is_empty()
    }

    /// True if the value with this id, or of this variable, may flow into the position.
    pub fn reach(&self, id: u32) -> bool {
        self.ids.contains(&id)
    }

    /// Returns the groups of four consecutive loaded elements of an array, by the index of the
    /// first element. Such a group is a matrix if the elements are `vec4`. A run of consecutive
    /// elements is divided into groups from its first element on, and again from its last element
    /// back. `true`: the elements are rows, because they are used in scalar products.
    pub fn fours(&self, variable: u32, path: &[u32]) -> Vec<(u32, bool)> {
        let Some(elements) = self.elements.get(&(variable, path.to_vec())) else { return Vec::new() };
        let numbers: Vec<u32> = elements.keys().copied().collect();
        let by_rows = |first: u32| elements.range(first..=first + 3).all(|(_, products_only)| *products_only);
        lens::fours(&numbers).into_iter().map(|first| (first, by_rows(first))).collect()
    }

    /// Returns the loads of a module; `None` if it writes through pointers that cannot be followed,
    /// or has no position.
    pub fn of(all: &[Instruction<'_>], declared: &Declarations<'_>) -> Option<Self> {
        let open = positions(all, declared);
        let (into, chains, products) = (HashMap::new(), HashMap::new(), products(all));
        let pointers = pointers(all, declared);
        let mut flow = Flow { declared, into, chains, products, pointers, open };
        if flow.open.is_empty() {
            return None;
        }
        flow.read(all)?;
        Some(flow.loads())
    }
}

/// Variables that hold a position, alone or in a block.
fn positions(all: &[Instruction<'_>], declared: &Declarations<'_>) -> Vec<u32> {
    let is_position = |i: &&Instruction<'_>, at| i.rest(at) == [Decoration::BuiltIn as u32, BuiltIn::Position as u32];
    let alone = all.iter().filter(|i| i.is(Op::Decorate) && is_position(i, 1)).map(|i| i.operand(0));
    let blocks: HashSet<u32> = all
        .iter()
        .filter(|i| i.is(Op::MemberDecorate) && is_position(i, 2))
        .map(|i| i.operand(0))
        .chain(alone)
        .collect();
    let output = |variable: &&Instruction<'_>| {
        let (class, mut pointee) = declared.pointee(variable.operand(1)).unwrap_or_default();
        if let Some(array) = declared.get(pointee, Op::TypeArray) {
            pointee = array.operand(1);
        }
        class == StorageClass::Output as u32 && (blocks.contains(&pointee) || blocks.contains(&variable.operand(1)))
    };
    let globals = all.iter().take_while(|i| !i.is(Op::Function)).filter(|i| i.is(Op::Variable));
    globals.filter(output).map(|i| i.operand(1)).collect()
}

/// Returns the pointers whose values are used only in scalar products.
fn products(all: &[Instruction<'_>]) -> HashSet<u32> {
    let loads: HashMap<u32, u32> =
        all.iter().filter(|i| i.is(Op::Load)).map(|i| (i.operand(1), i.operand(2))).collect();
    let (mut products, mut others) = (HashSet::new(), HashSet::new());
    for i in all.iter().skip_while(|i| !i.is(Op::Function)) {
        let used = i.operands.iter().filter_map(|id| loads.get(id));
        if i.is(Op::Dot) {
            products.extend(used);
        } else if !i.is(Op::Load) {
            others.extend(used);
        }
    }
    &products - &others
}

/// Returns the ids of addresses of buffers that a shader loads, and the types of what they point at.
fn pointers(all: &[Instruction<'_>], declared: &Declarations<'_>) -> HashMap<u32, u32> {
    let made = |i: &&Instruction<'_>| i.is(Op::Load) || i.is(Op::ConvertUToPtr) || i.is(Op::Bitcast);
    let pointer = |i: &Instruction<'_>| Some((i.operand(1), declared.address(i.operand(0))?));
    all.iter().skip_while(|i| !i.is(Op::Function)).filter(made).filter_map(pointer).collect()
}

/// Greatest number of indices of an access chain, as for all of SPIR-V.
const MOST_INDICES: usize = 255;

struct Flow<'a> {
    declared: &'a Declarations<'a>,
    /// From each id to the ids that may flow into it.
    into: HashMap<u32, Vec<u32>>,
    /// Access chains: what they point into, and the indices within it.
    chains: HashMap<u32, (u32, Vec<u32>)>,
    /// Pointers whose values are used only in scalar products.
    products: HashSet<u32>,
    /// Addresses in the shader, as ids of their values, and the types of what they point at.
    pointers: HashMap<u32, u32>,
    /// Ids that flow into the position and are not followed yet.
    open: Vec<u32>,
}

impl Flow<'_> {
    fn add(&mut self, target: u32, sources: &[u32]) {
        self.into.entry(target).or_default().extend(sources);
    }

    /// Returns the variable, parameter or result that a pointer points into, and the indices within
    /// it.
    fn root(&self, pointer: u32) -> (u32, Vec<u32>) {
        self.chains.get(&pointer).cloned().unwrap_or((pointer, Vec::new()))
    }

    /// Adds an access chain. `None`: it comes behind a chain that begins with it, so that they may
    /// be a circle, or is longer than SPIR-V allows.
    fn add_chain(&mut self, chain: u32, base: u32, indices: &[u32], bases: &mut HashSet<u32>) -> Option<()> {
        bases.insert(base);
        let (root, mut path) = self.root(base);
        path.extend(indices);
        if bases.contains(&chain) || path.len() > MOST_INDICES {
            return None;
        }
        self.chains.insert(chain, (root, path));
        Some(())
    }

    fn read(&mut self, all: &[Instruction<'_>]) -> Option<()> {
        let mut parameters: HashMap<u32, Vec<u32>> = HashMap::new();
        let mut bases = HashSet::new();
        let mut function = 0;
        for i in all {
            match Op::from_u32(i.opcode) {
                Some(Op::Function) => function = i.operand(1),
                Some(Op::FunctionParameter) => parameters.entry(function).or_default().push(i.operand(1)),
                Some(Op::AccessChain | Op::InBoundsAccessChain | Op::CopyObject) if function != 0 => {
                    self.add_chain(i.operand(1), i.operand(2), i.rest(3), &mut bases)?;
                }
                _ => {}
            }
        }
        let mut followed: HashSet<u32> = parameters.values().flatten().copied().collect();
        followed.extend(all.iter().filter(|i| i.is(Op::Variable)).map(|i| i.operand(1)));
        for i in all.iter().skip_while(|i| !i.is(Op::Function)) {
            match Op::from_u32(i.opcode)? {
                Op::Function => function = i.operand(1),
                Op::FunctionParameter | Op::Label | Op::FunctionEnd | Op::Line | Op::NoLine => {}
                // Already in `chains`.
                Op::AccessChain | Op::InBoundsAccessChain | Op::CopyObject => {}
                Op::Branch | Op::SelectionMerge | Op::LoopMerge | Op::Return | Op::Kill | Op::Unreachable => {}
                Op::BranchConditional | Op::Switch => self.open.push(i.operand(0)),
                Op::ReturnValue => self.add(function, i.operands),
                Op::Store | Op::CopyMemory => {
                    let (root, path) = self.root(i.operand(0));
                    if !followed.contains(&root) {
                        return None;
                    }
                    self.add(root, &path);
                    self.add(root, &i.operands[1..2.min(i.operands.len())]);
                }
                Op::CompositeExtract => self.add(i.operand(1), &i.operands[2..3.min(i.operands.len())]),
                Op::CompositeInsert | Op::VectorShuffle => {
                    self.add(i.operand(1), i.operands.get(2..4).unwrap_or_default());
                }
                Op::FunctionCall => {
                    let parameters = parameters.get(&i.operand(2)).map_or(&[][..], |parameters| parameters);
                    self.read_call(i, parameters);
                }
                Op::Variable => self.add(i.operand(1), i.rest(3)),
                Op::ExtInst => {
                    self.add(i.operand(1), i.rest(4));
                    // Some of these functions write to one of their operands.
                    for operand in i.rest(4) {
                        let (root, _) = self.root(*operand);
                        if followed.contains(&root) {
                            self.add(root, i.rest(4));
                        }
                    }
                }
                _ => self.add(i.operand(1), i.rest(2)),
            }
        }
        Some(())
    }

    /// Reads a call of a function with these parameters.
    fn read_call(&mut self, i: &Instruction<'_>, parameters: &[u32]) {
        self.add(i.operand(1), i.rest(2));
        for (parameter, argument) in parameters.iter().zip(i.rest(3)) {
            self.add(*parameter, &[*argument]);
            // The function may write to its argument.
            let (root, _) = self.root(*argument);
            self.add(root, &[*parameter]);
        }
    }

    /// Follows all values that flow into the position back to members of the program's blocks.
    fn loads(mut self) -> PositionLoads {
        let mut loads = PositionLoads::default();
        let mut seen = HashSet::new();
        while let Some(id) = self.open.pop() {
            if !seen.insert(id) {
                continue;
            }
            let (root, path) = self.root(id);
            if let Some(kind) = self.pointers.get(&root).filter(|_| root != id) {
                loads.members.insert((root, self.members(*kind, &path).0));
            }
            let class = self.declared.pointee(root).map_or(u32::MAX, |pointee| pointee.0);
            if [StorageClass::PushConstant, StorageClass::Uniform, StorageClass::StorageBuffer]
                .iter()
                .any(|block| *block as u32 == class)
            {
                let kind = self.declared.pointee(root).map_or(0, |pointee| pointee.1);
                let (members, element) = self.members(kind, &path);
                if let Some(element) = element {
                    let products_only = self.products.contains(&id);
                    let elements = loads.elements.entry((root, members.clone())).or_default();
                    *elements.entry(element).or_insert(true) &= products_only;
                }
                loads.members.insert((root, members));
            } else if root != id {
                self.open.push(root);
            }
            self.open.extend(path);
            self.open.extend(self.into.get(&id).into_iter().flatten());
        }
        loads.ids = seen;
        loads
    }

    /// Returns the constant `indices` that choose members of structures, from the type `kind` on; an
    /// unknown index ends the list. If the last index is that of an array element and is known, it
    /// is returned, too.
    fn members(&self, mut kind: u32, indices: &[u32]) -> (Vec<u32>, Option<u32>) {
        let constant = |id: u32| self.declared.get(id, Op::Constant).map(|constant| constant.operand(2));
        let (mut path, mut element) = (Vec::new(), None);
        for index in indices {
            if let Some(block) = self.declared.get(kind, Op::TypeStruct) {
                let Some(member) = constant(*index) else { break };
                path.push(member);
                element = None;
                kind = block.operand(1 + member as usize);
            } else if let Some(array) =
                self.declared.get(kind, Op::TypeArray).or_else(|| self.declared.get(kind, Op::TypeRuntimeArray))
            {
                kind = array.operand(1);
                element = constant(*index);
            } else {
                break;
            }
        }
        (path, element)
    }
}
