//! Outputs of a stage for the next one: variables with locations, and the built-in ones.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::spirv::module::{Declarations, Instruction, instructions, string};
use spirv::{BuiltIn, Capability, Decoration, ExecutionModel, Op, StorageClass};
use std::collections::HashSet;

/// A scalar or vector of 32-bit numbers within a variable.
pub struct OutputPart {
    /// Indices of the members, elements and columns on the path to it.
    pub path: Vec<u32>,
    /// Its type.
    pub kind: u32,
    /// True if it is not interpolated, but taken from the provoking vertex.
    pub flat: bool,
    /// True if it is a vector of several numbers.
    pub vector: bool,
}

/// A variable with locations.
pub struct Variable {
    /// Its id.
    pub id: u32,
    /// Type of the variable.
    pub pointee: u32,
    /// The numbers in it.
    pub leaves: Vec<OutputPart>,
}

/// Outputs of a vertex shader.
pub struct StageOutputs<'a> {
    /// Its module.
    pub declared: Declarations<'a>,
    /// Variables that have locations and are read.
    pub variables: Vec<Variable>,
    /// `gl_Position`, or the block with it: the variable, and the member if it is a block.
    pub position: (u32, Option<u32>),
    /// `gl_ClipDistance`, if it is set.
    pub distances: Option<Distances>,
    /// Number of scalars that have locations or are distances.
    pub components: u32,
    /// The first location from which on all are free.
    pub locations: u32,
    /// True if the fragment shader reads the number of the primitive.
    pub number: bool,
}

/// `gl_ClipDistance`.
pub struct Distances {
    /// The variable, and the member if it is a block.
    pub place: (u32, Option<u32>),
    /// Its type.
    pub kind: u32,
    /// Its elements.
    pub leaves: Vec<OutputPart>,
}

/// Greatest length of an array and size of a structure that are followed.
const LONGEST: u32 = 64;
/// Greatest number of types on the way through a variable.
const MOST_STEPS: usize = 1024;
/// Greatest depth of nested structures.
const DEEPEST: usize = 8;
/// `PerVertexKHR`, `BaryCoordKHR` and `BaryCoordNoPerspKHR`: the fragment shader interpolates by
/// itself.
const INTERPOLATES: ([u32; 1], [u32; 2]) = ([5285], [5286, 5287]);

/// A location between stages, and a component.
type ChunkOffset = (u32, u32);

/// A number that is passed between stages, with all locations that it takes.
struct Number {
    leaf: OutputPart,
    places: Vec<ChunkOffset>,
}

/// An entry point: words of a module, stage, name.
pub type Entry<'a> = (&'a [u32], ExecutionModel, &'a str);

/// Returns the variables that an entry point lists.
fn interface(all: &[Instruction<'_>], (_, model, name): &Entry<'_>) -> Option<Vec<u32>> {
    let named =
        |i: &&Instruction<'_>| i.is(Op::EntryPoint) && i.operand(0) == *model as u32 && string(i.rest(2)).0 == *name;
    let point = all.iter().find(named)?;
    Some(point.rest(2 + string(point.rest(2)).1).to_vec())
}

/// Returns the outputs of the vertex shader `vertex` that `fragment` reads, if there is a fragment
/// shader. Outputs that it does not read would only take space.
///
/// # Errors
/// The reason why a stage between them cannot pass on an output, for the log.
pub fn stage_outputs<'a>(vertex: Entry<'a>, fragment: Option<Entry<'_>>) -> Result<StageOutputs<'a>, Obstacle> {
    let all = instructions(vertex.0).ok_or("a shader that is not SPIR-V")?;
    let variables = interface(&all, &vertex).ok_or("a shader without its entry point")?;
    let declared = Declarations::new(&all);
    let has = |capability: Capability| all.iter().any(|i| i.is(Op::Capability) && i.operand(0) == capability as u32);
    // A part of a primitive may be culled where the complete primitive is not.
    if has(Capability::CullDistance) {
        return Err("a shader sets cull distances".into());
    }
    let clips = has(Capability::ClipDistance);
    let asked = fragment.map_or(Ok(Asked::default()), |fragment| asked(&fragment))?;
    let mut made = StageOutputs {
        declared,
        variables: Vec::new(),
        position: (0, None),
        distances: None,
        components: 0,
        locations: 0,
        number: asked.number,
    };
    for id in variables {
        let Some((class, pointee)) = made.declared.pointee(id) else { continue };
        if class != StorageClass::Output as u32 {
            continue;
        }
        match built_in(&made.declared, id, pointee)? {
            Some(found) => {
                made.position = found.position.map_or(made.position, |member| (id, member));
                if let Some((member, kind)) = found.distances.filter(|_| clips) {
                    let mut walk = Walk { location: Some(0), ..Walk::new(&made.declared) };
                    walk.enter(kind)?;
                    let leaves: Vec<OutputPart> = walk.found.into_iter().map(|number| number.leaf).collect();
                    made.components += leaves.len() as u32;
                    made.distances = Some(Distances { place: (id, member), kind, leaves });
                }
            }
            None => {
                let mut numbers = numbers(&made.declared, id, pointee)?;
                let read = |number: &Number| number.places.iter().any(|place| asked.read.contains(place));
                if !numbers.iter().any(read) {
                    continue;
                }
                for number in &mut numbers {
                    number.leaf.flat |= number.places.iter().any(|place| asked.flat.contains(place));
                }
                for (location, _) in numbers.iter().flat_map(|number| &number.places) {
                    made.locations = made.locations.max(location.saturating_add(1));
                    made.components += 1;
                }
                let leaves = numbers.into_iter().map(|number| number.leaf).collect();
                made.variables.push(Variable { id, pointee, leaves });
            }
        }
    }
    if made.position.0 == 0 { Err("a shader that writes no gl_Position".into()) } else { Ok(made) }
}

/// Inputs of a fragment shader.
#[derive(Default)]
struct Asked {
    /// Variables that it reads.
    read: HashSet<ChunkOffset>,
    /// Variables that are not interpolated.
    flat: HashSet<ChunkOffset>,
    number: bool,
}

fn asked(fragment: &Entry<'_>) -> Result<Asked, Obstacle> {
    let all = instructions(fragment.0).ok_or("a shader that is not SPIR-V")?;
    let declared = Declarations::new(&all);
    let mut asked = Asked::default();
    for id in interface(&all, fragment).ok_or("a shader without its entry point")? {
        let Some((class, pointee)) = declared.pointee(id) else { continue };
        if class != StorageClass::Input as u32 {
            continue;
        }
        if let Some(kind) = declared.number(id, None, Decoration::BuiltIn) {
            asked.number |= kind == BuiltIn::PrimitiveId as u32;
            if INTERPOLATES.1.contains(&kind) {
                return Err("a shader interpolates by itself".into());
            }
            continue;
        }
        if INTERPOLATES.0.iter().any(|kind| declared.has(id, *kind)) {
            return Err("a shader interpolates by itself".into());
        }
        for number in numbers(&declared, id, pointee)? {
            if number.leaf.flat {
                asked.flat.extend(&number.places);
            }
            asked.read.extend(number.places);
        }
    }
    Ok(asked)
}

/// Built-in variables; each with the member, if the variable is a block.
#[derive(Default)]
struct BuiltIns {
    /// `gl_Position`.
    position: Option<Option<u32>>,
    /// `gl_ClipDistance`, and its type.
    distances: Option<(Option<u32>, u32)>,
}

/// `None` for a variable with locations.
fn built_in(declared: &Declarations<'_>, id: u32, pointee: u32) -> Result<Option<BuiltIns>, Obstacle> {
    let mut found = None;
    let mut note = |member: Option<u32>, kind: u32, built_in: u32| {
        let found = found.get_or_insert_with(BuiltIns::default);
        let is = |known: BuiltIn| built_in == known as u32;
        if is(BuiltIn::Position) {
            found.position = Some(member);
        } else if is(BuiltIn::ClipDistance) {
            found.distances = Some((member, kind));
        } else if !is(BuiltIn::PointSize) && !is(BuiltIn::CullDistance) {
            return Err(Obstacle::from("a shader sets layers, viewports or other built-in values"));
        }
        Ok(())
    };
    if let Some(built_in) = declared.number(id, None, Decoration::BuiltIn) {
        note(None, pointee, built_in)?;
    } else if let Some(block) = declared.get(pointee, Op::TypeStruct) {
        for (member, kind) in (0..).zip(block.rest(1)) {
            if let Some(built_in) = declared.number(pointee, Some(member), Decoration::BuiltIn) {
                note(Some(member), *kind, built_in)?;
            }
        }
    }
    Ok(found)
}

/// Returns the numbers of a variable with locations.
fn numbers(declared: &Declarations<'_>, id: u32, pointee: u32) -> Result<Vec<Number>, Obstacle> {
    let number = |kind| declared.number(id, None, kind);
    let mut walk = Walk {
        location: number(Decoration::Location),
        component: number(Decoration::Component).unwrap_or(0),
        flat: declared.decoration(id, None, Decoration::Flat).is_some(),
        ..Walk::new(declared)
    };
    if declared.decoration(id, None, Decoration::Patch).is_some() {
        return Err("a shader has outputs that cannot be followed".into());
    }
    walk.enter(pointee)?;
    Ok(walk.found)
}

/// A walk through the parts of a variable.
struct Walk<'a> {
    declared: &'a Declarations<'a>,
    /// Location of the next number.
    location: Option<u32>,
    component: u32,
    flat: bool,
    path: Vec<u32>,
    found: Vec<Number>,
    steps: usize,
}

impl<'a> Walk<'a> {
    fn new(declared: &'a Declarations<'a>) -> Self {
        Self { declared, location: None, component: 0, flat: false, path: Vec::new(), found: Vec::new(), steps: 0 }
    }

    fn enter(&mut self, kind: u32) -> Result<(), Obstacle> {
        self.steps += 1;
        if self.steps > MOST_STEPS {
            return Err("a shader has more outputs than can be followed".into());
        }
        const UNKNOWN: &str = "a shader has outputs that cannot be followed, such as numbers of 16 or 64 bits";
        let declared = self.declared;
        let instruction = declared.by_id.get(&kind).copied().ok_or(UNKNOWN)?;
        let scalar = |id: u32| {
            let float = declared.get(id, Op::TypeFloat).filter(|float| float.operand(1) == 32);
            let int = declared.get(id, Op::TypeInt).filter(|int| int.operand(1) == 32);
            float.map(|_| false).or(int.map(|_| true))
        };
        let members = instruction.rest(1);
        match Op::from_u32(instruction.opcode) {
            Some(Op::TypeFloat | Op::TypeInt) => self.leaf(kind, scalar(kind).ok_or(UNKNOWN)?, 1),
            Some(Op::TypeVector) => {
                self.leaf(kind, scalar(instruction.operand(1)).ok_or(UNKNOWN)?, instruction.operand(2))
            }
            Some(Op::TypeMatrix | Op::TypeArray) => {
                let count = instruction.operand(2);
                let count = match declared.get(count, Op::Constant) {
                    Some(length) if instruction.is(Op::TypeArray) => length.operand(2),
                    _ if instruction.is(Op::TypeMatrix) => count,
                    _ => return Err("a shader has an output array whose length is specialised".into()),
                };
                self.each(0..count, |_| instruction.operand(1))
            }
            Some(Op::TypeStruct) => {
                let (component, flat) = (self.component, self.flat);
                for (member, member_kind) in (0..).zip(members) {
                    let number = |decoration| declared.number(kind, Some(member), decoration);
                    self.location = number(Decoration::Location).or(self.location);
                    self.component = number(Decoration::Component).unwrap_or(0);
                    self.flat = flat || declared.decoration(kind, Some(member), Decoration::Flat).is_some();
                    self.each(member..member + 1, |_| *member_kind)?;
                }
                (self.component, self.flat) = (component, flat);
                Ok(())
            }
            _ => Err(UNKNOWN.into()),
        }
    }

    fn each(&mut self, range: std::ops::Range<u32>, kind: impl Fn(u32) -> u32) -> Result<(), Obstacle> {
        if range.end > LONGEST || self.path.len() >= DEEPEST {
            return Err("a shader has more outputs than can be followed".into());
        }
        for index in range {
            self.path.push(index);
            self.enter(kind(index))?;
            self.path.pop();
        }
        Ok(())
    }

    fn leaf(&mut self, kind: u32, whole: bool, count: u32) -> Result<(), Obstacle> {
        let location = self.location.ok_or("a shader has an output without a location")?;
        let places = (self.component..self.component.saturating_add(count).min(4)).map(|c| (location, c)).collect();
        let leaf = OutputPart { path: self.path.clone(), kind, flat: self.flat || whole, vector: count > 1 };
        self.found.push(Number { leaf, places });
        if self.found.len() > LONGEST as usize {
            return Err("a shader has more outputs than can be followed".into());
        }
        self.location = Some(location.saturating_add(1));
        Ok(())
    }
}
