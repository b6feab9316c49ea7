//! A geometry stage of Cupola after a program's vertex shader. It divides triangles or lines and
//! projects the vertices that it emits.
//!
//! The build compiles the arithmetic, `correct::projected::division`, to SPIR-V. The code that
//! reads the corners and writes vertices is made here. The outputs of the vertex shader are
//! declared twice: as an array of the corners' values, and as outputs of this stage.

use crate::correct::projected::division::Input;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::spirv::functions::{Additions, Linked, division, push};
use crate::intercept::vk::spirv::module::{Declarations, HEADER};
use crate::intercept::vk::spirv::stage_outputs::{OutputPart, StageOutputs};
use spirv::{
    AddressingModel, BuiltIn, Capability, Decoration, ExecutionMode, ExecutionModel, FunctionControl, MemoryModel, Op,
    Scope, StorageClass,
};
use std::collections::HashMap;

/// Limits of a device for a geometry stage.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Vertices that one invocation emits.
    pub vertices: u32,
    /// Components of all emitted vertices.
    pub all_components: u32,
    /// Components of an input vertex, and of an output vertex.
    pub components: [u32; 2],
    /// Invocations for a primitive.
    pub runs: u32,
}

/// Invocations that share a primitive.
const RUNS: u32 = 16;
/// Components of a vertex for its built-in position.
const POSITION: u32 = 4;
/// Further components that a corner may have: the point size, and one distance of each kind.
const BESIDE: u32 = 4;
/// Greatest number of types that are copied. Each may be part of another.
const MOST_TYPES: usize = 256;
/// Smallest number of parts for which division is useful.
const FEWEST: u32 = 4;
/// Version 1.0, which every device accepts.
const VERSION: u32 = 0x0001_0000;
/// The name of the stage's entry point.
pub const ENTRY: &std::ffi::CStr = c"main";

/// Returns the words of the stage. The view constants are at binding 0 of `set`. With `counts`, a
/// counter is at binding 1, which counts the parts that are not fine enough. `provoking`: the
/// corner that gives a primitive the values that are not interpolated.
///
/// # Errors
/// The limit of the device that is exceeded, or the output of the shader that cannot be followed,
/// for the log.
pub fn divide(
    input: Input,
    stage_outputs: &StageOutputs<'_>,
    provoking: u32,
    set: u32,
    counts: bool,
    limits: &Limits,
) -> Result<Vec<u32>, Obstacle> {
    let corners = input.corners();
    let emitted = POSITION + stage_outputs.components + u32::from(stage_outputs.number);
    // Each location needs four components of the device's limit.
    let needed = (emitted + BESIDE).max(stage_outputs.locations.saturating_mul(4));
    let room = limits.vertices.min(limits.all_components / emitted) / corners;
    if room < FEWEST || limits.runs < RUNS || limits.components.iter().any(|limit| needed > *limit) {
        return Err("a shader has more outputs than the geometry shaders of the device allow".into());
    }
    let none = Declarations::default();
    let mut additions = Additions::new(1, &none);
    let linked = additions.link(division(input), set);
    let mut stage = Stage { to: additions, stage_outputs, corners, copied: HashMap::new(), numbers: HashMap::new() };
    let interface = stage.declare()?;
    stage.bodies(&linked, &interface, provoking, room)?;
    stage.count(&linked, counts.then_some(set))?;
    Ok(stage.module(&linked, &interface, input, room))
}

/// The stage while it is made.
struct Stage<'a> {
    to: Additions<'a>,
    stage_outputs: &'a StageOutputs<'a>,
    corners: u32,
    /// Types of the vertex shader, with their ids here.
    copied: HashMap<u32, u32>,
    /// Constants.
    numbers: HashMap<u32, u32>,
}

/// The stage's variables.
struct Interface<'a> {
    /// The corners' `gl_Position`, or their blocks.
    corner: u32,
    position: u32,
    run: u32,
    /// The number of the primitive, as input and as output.
    number: Option<[u32; 2]>,
    /// Outputs of the vertex shader.
    pairs: Vec<Pair<'a>>,
}

/// A variable of the vertex shader.
struct Pair<'a> {
    /// Input variable, with the values of the corners.
    from: u32,
    /// The member of the input, if the corners have blocks.
    member: Option<u32>,
    /// Output variable of this stage.
    to: u32,
    leaves: &'a [OutputPart],
}

impl Interface<'_> {
    fn all(&self) -> impl Iterator<Item = u32> + '_ {
        let numbers = self.number.iter().flatten().copied();
        let from = self.pairs.iter().map(|pair| pair.from).filter(|from| *from != self.corner);
        let to = self.pairs.iter().map(|pair| pair.to);
        [self.corner, self.position, self.run].into_iter().chain(from).chain(to).chain(numbers)
    }
}

const MISSING: &str = "a shader has outputs that cannot be followed";

impl<'a> Stage<'a> {
    fn float(&mut self) -> u32 {
        self.to.kind(Op::TypeFloat, &[32])
    }

    fn vector(&mut self, length: u32) -> u32 {
        let float = self.float();
        self.to.kind(Op::TypeVector, &[float, length])
    }

    fn int(&mut self) -> u32 {
        self.to.kind(Op::TypeInt, &[32, 1])
    }

    fn pointer(&mut self, class: StorageClass, kind: u32) -> u32 {
        self.to.kind(Op::TypePointer, &[class as u32, kind])
    }

    /// Returns a constant of type `int`.
    fn number(&mut self, value: u32) -> u32 {
        if let Some(id) = self.numbers.get(&value) {
            return *id;
        }
        let (int, id) = (self.int(), self.to.id());
        push(&mut self.to.globals, Op::Constant, &[int, id, value]);
        self.numbers.insert(value, id);
        id
    }

    fn variable(&mut self, class: StorageClass, kind: u32) -> u32 {
        let (pointer, id) = (self.pointer(class, kind), self.to.id());
        push(&mut self.to.globals, Op::Variable, &[pointer, id, class as u32]);
        id
    }

    fn decorate(&mut self, id: u32, member: Option<u32>, decoration: Decoration, operands: &[u32]) {
        let (op, to) = match member {
            Some(member) => (Op::MemberDecorate, vec![id, member]),
            None => (Op::Decorate, vec![id]),
        };
        push(&mut self.to.decorations, op, &[&to[..], &[decoration as u32], operands].concat());
    }

    /// Copies a decoration of the vertex shader, if it exists.
    fn decorate_as(&mut self, from: u32, member: Option<u32>, to: u32, decoration: Decoration) {
        if let Some(operands) = self.stage_outputs.declared.decoration(from, member, decoration) {
            self.decorate(to, member, decoration, operands);
        }
    }

    /// Copies a type of the vertex shader.
    fn copy(&mut self, id: u32) -> Result<u32, Obstacle> {
        // A type that is being copied has no number yet. A type that contains itself is damage.
        if let Some(known) = self.copied.get(&id) {
            return if *known == 0 { Err(MISSING.into()) } else { Ok(*known) };
        }
        if self.copied.len() > MOST_TYPES {
            return Err(MISSING.into());
        }
        self.copied.insert(id, 0);
        let declared = &self.stage_outputs.declared;
        let given = declared.by_id.get(&id).copied().ok_or(MISSING)?;
        let copied = match Op::from_u32(given.opcode) {
            Some(op @ (Op::TypeFloat | Op::TypeInt)) => self.to.kind(op, given.rest(1)),
            Some(op @ (Op::TypeVector | Op::TypeMatrix)) => {
                let part = self.copy(given.operand(1))?;
                self.to.kind(op, &[part, given.operand(2)])
            }
            Some(Op::TypeArray) => {
                let length = declared.get(given.operand(2), Op::Constant).ok_or(MISSING)?.operand(2);
                let (part, length) = (self.copy(given.operand(1))?, self.number(length));
                self.to.kind(Op::TypeArray, &[part, length])
            }
            Some(Op::TypeStruct) => {
                let members: Result<Vec<u32>, _> = given.rest(1).iter().map(|member| self.copy(*member)).collect();
                let made = self.to.id();
                push(&mut self.to.globals, Op::TypeStruct, &[&[made], &members?[..]].concat());
                self.decorate_as(id, None, made, Decoration::Block);
                for member in 0..given.rest(1).len() as u32 {
                    for decoration in [Decoration::Location, Decoration::Component, Decoration::BuiltIn] {
                        self.decorate_as(id, Some(member), made, decoration);
                    }
                }
                made
            }
            _ => return Err(MISSING.into()),
        };
        self.copied.insert(id, copied);
        Ok(copied)
    }

    /// Returns the corners' input variable for a variable of the vertex shader.
    fn corners_of(&mut self, variable: u32, pointee: u32) -> Result<u32, Obstacle> {
        let (kind, count) = (self.copy(pointee)?, self.number(self.corners));
        let array = self.to.kind(Op::TypeArray, &[kind, count]);
        let made = self.variable(StorageClass::Input, array);
        for decoration in [Decoration::Location, Decoration::Component, Decoration::BuiltIn] {
            self.decorate_as(variable, None, made, decoration);
        }
        Ok(made)
    }

    fn declare(&mut self) -> Result<Interface<'a>, Obstacle> {
        let stage_outputs = self.stage_outputs;
        let (_, pointee) = stage_outputs.declared.pointee(stage_outputs.position.0).ok_or(MISSING)?;
        let corner = self.corners_of(stage_outputs.position.0, pointee)?;
        let (vector, int) = (self.vector(4), self.int());
        let position = self.variable(StorageClass::Output, vector);
        self.decorate(position, None, Decoration::BuiltIn, &[BuiltIn::Position as u32]);
        let run = self.variable(StorageClass::Input, int);
        self.decorate(run, None, Decoration::BuiltIn, &[BuiltIn::InvocationId as u32]);
        let number = stage_outputs.number.then(|| {
            [StorageClass::Input, StorageClass::Output].map(|class| {
                let id = self.variable(class, int);
                self.decorate(id, None, Decoration::BuiltIn, &[BuiltIn::PrimitiveId as u32]);
                id
            })
        });
        let mut pairs = Vec::new();
        for variable in &stage_outputs.variables {
            let from = self.corners_of(variable.id, variable.pointee)?;
            let kind = self.copy(variable.pointee)?;
            let to = self.variable(StorageClass::Output, kind);
            for decoration in [Decoration::Location, Decoration::Component] {
                self.decorate_as(variable.id, None, to, decoration);
            }
            pairs.push(Pair { from, member: None, to, leaves: &variable.leaves });
        }
        if let Some(distances) = &stage_outputs.distances {
            let (variable, member) = distances.place;
            let from = match variable == stage_outputs.position.0 {
                true => corner,
                false => self.corners_of(variable, distances.kind)?,
            };
            let kind = self.copy(distances.kind)?;
            let to = self.variable(StorageClass::Output, kind);
            self.decorate(to, None, Decoration::BuiltIn, &[BuiltIn::ClipDistance as u32]);
            pairs.push(Pair { from, member, to, leaves: &distances.leaves });
        }
        Ok(Interface { corner, position, run, number, pairs })
    }

    /// Adds an instruction of a function, with a result of type `kind`.
    fn made(&mut self, op: Op, kind: u32, operands: &[u32]) -> u32 {
        let id = self.to.id();
        push(&mut self.to.bodies, op, &[&[kind, id], operands].concat());
        id
    }

    /// Begins the function `id`; returns its parameters.
    fn function(&mut self, id: u32, result: u32, parameters: &[u32]) -> Vec<u32> {
        let kind = self.to.kind(Op::TypeFunction, &[&[result], parameters].concat());
        push(&mut self.to.bodies, Op::Function, &[result, id, FunctionControl::NONE.bits(), kind]);
        let given = parameters.iter().map(|kind| self.made(Op::FunctionParameter, *kind, &[])).collect();
        let label = self.to.id();
        push(&mut self.to.bodies, Op::Label, &[label]);
        given
    }

    /// Ends a function.
    fn end(&mut self, result: Option<u32>) {
        match result {
            Some(result) => push(&mut self.to.bodies, Op::ReturnValue, &[result]),
            None => push(&mut self.to.bodies, Op::Return, &[]),
        }
        push(&mut self.to.bodies, Op::FunctionEnd, &[]);
    }

    /// Loads a value of type `kind` from an input variable.
    fn load(&mut self, kind: u32, variable: u32, path: &[u32]) -> u32 {
        let pointer = self.pointer(StorageClass::Input, kind);
        let place = self.made(Op::AccessChain, pointer, &[&[variable], path].concat());
        self.made(Op::Load, kind, &[place])
    }

    /// Adds the functions that the arithmetic calls, in the order of
    /// `correct::projected::division::STAGE_FUNCTIONS`.
    fn bodies(
        &mut self,
        linked: &Linked,
        interface: &Interface<'_>,
        provoking: u32,
        room: u32,
    ) -> Result<(), Obstacle> {
        let [run, left, corner, emit, end, _] = linked.open[..] else { return Err(MISSING.into()) };
        let (void, int, vector, weights) =
            (self.to.kind(Op::TypeVoid, &[]), self.int(), self.vector(4), self.vector(3));
        self.function(run, int, &[]);
        let value = self.made(Op::Load, int, &[interface.run]);
        self.end(Some(value));

        let room = self.number(room);
        self.function(left, int, &[]);
        self.end(Some(room));

        let member = self.stage_outputs.position.1.map(|member| self.number(member));
        let index = self.function(corner, vector, &[int]);
        let value = self.load(vector, interface.corner, &[&index[..], member.as_slice()].concat());
        self.end(Some(value));

        let given = self.function(emit, void, &[vector, weights]);
        let [at, weights] = given[..] else { return Err(MISSING.into()) };
        let float = self.float();
        let weights: Vec<u32> =
            (0..self.corners).map(|i| self.made(Op::CompositeExtract, float, &[weights, i])).collect();
        for pair in &interface.pairs {
            for leaf in pair.leaves {
                self.hand_on(pair, leaf, &weights, provoking)?;
            }
        }
        let projected = self.made(Op::FunctionCall, vector, &[linked.fix, at]);
        push(&mut self.to.bodies, Op::Store, &[interface.position, projected]);
        if let Some([from, to]) = interface.number {
            let number = self.made(Op::Load, int, &[from]);
            push(&mut self.to.bodies, Op::Store, &[to, number]);
        }
        push(&mut self.to.bodies, Op::EmitVertex, &[]);
        self.end(None);

        self.function(end, void, &[]);
        push(&mut self.to.bodies, Op::EndPrimitive, &[]);
        self.end(None);
        Ok(())
    }

    /// Adds the function that is called for a part that is not fine enough. It increments the
    /// counter in `set`, if there is one.
    fn count(&mut self, linked: &Linked, set: Option<u32>) -> Result<(), Obstacle> {
        let [.., count] = linked.open[..] else { return Err(MISSING.into()) };
        let (void, int) = (self.to.kind(Op::TypeVoid, &[]), self.int());
        let counter = set.map(|set| {
            // Version 1.0 has no other storage buffers.
            let block = self.to.id();
            push(&mut self.to.globals, Op::TypeStruct, &[block, int]);
            self.decorate(block, None, Decoration::BufferBlock, &[]);
            self.decorate(block, Some(0), Decoration::Offset, &[0]);
            let counter = self.variable(StorageClass::Uniform, block);
            self.decorate(counter, None, Decoration::DescriptorSet, &[set]);
            self.decorate(counter, None, Decoration::Binding, &[1]);
            counter
        });
        self.function(count, void, &[]);
        if let Some(counter) = counter {
            let pointer = self.pointer(StorageClass::Uniform, int);
            let [none, one] = [0, 1].map(|value| self.number(value));
            let device = self.number(Scope::Device as u32);
            let place = self.made(Op::AccessChain, pointer, &[counter, none]);
            self.made(Op::AtomicIAdd, int, &[place, device, none, one]);
        }
        self.end(None);
        Ok(())
    }

    /// Computes one output from the corners: by their weights, or from the provoking vertex.
    fn hand_on(&mut self, pair: &Pair<'_>, leaf: &OutputPart, weights: &[u32], provoking: u32) -> Result<(), Obstacle> {
        let kind = self.copy(leaf.kind)?;
        let path: Vec<u32> = leaf.path.iter().map(|index| self.number(*index)).collect();
        let member = pair.member.map(|member| self.number(member));
        let at = |stage: &mut Self, corner: u32| {
            let corner = stage.number(corner);
            stage.load(kind, pair.from, &[&[corner], member.as_slice(), &path[..]].concat())
        };
        let value = if leaf.flat {
            at(self, provoking)
        } else {
            let scale = if leaf.vector { Op::VectorTimesScalar } else { Op::FMul };
            let mut sum = None;
            for (corner, weight) in (0..).zip(weights) {
                let value = at(self, corner);
                let part = self.made(scale, kind, &[value, *weight]);
                sum = Some(sum.map_or(part, |sum| self.made(Op::FAdd, kind, &[sum, part])));
            }
            sum.ok_or(MISSING)?
        };
        let place = match path.is_empty() {
            true => pair.to,
            false => {
                let pointer = self.pointer(StorageClass::Output, kind);
                self.made(Op::AccessChain, pointer, &[&[pair.to], &path[..]].concat())
            }
        };
        push(&mut self.to.bodies, Op::Store, &[place, value]);
        Ok(())
    }

    /// Returns the complete module.
    fn module(self, linked: &Linked, interface: &Interface<'_>, input: Input, room: u32) -> Vec<u32> {
        let mut to = self.to;
        let mut words = vec![spirv::MAGIC_NUMBER, VERSION, 0, to.bound(), 0];
        debug_assert_eq!(words.len(), HEADER);
        push(&mut words, Op::Capability, &[Capability::Geometry as u32]);
        if self.stage_outputs.distances.is_some() {
            push(&mut words, Op::Capability, &[Capability::ClipDistance as u32]);
        }
        words.append(&mut to.imports);
        push(&mut words, Op::MemoryModel, &[AddressingModel::Logical as u32, MemoryModel::GLSL450 as u32]);
        // "main" and its terminator, in two words.
        let mut point = vec![ExecutionModel::Geometry as u32, linked.root, u32::from_le_bytes(*b"main"), 0];
        point.extend(interface.all());
        push(&mut words, Op::EntryPoint, &point);
        let (taken, strip) = match input {
            Input::Triangles => (ExecutionMode::Triangles, ExecutionMode::OutputTriangleStrip),
            Input::Lines => (ExecutionMode::InputLines, ExecutionMode::OutputLineStrip),
        };
        let vertices = room * self.corners;
        let modes: [(ExecutionMode, &[u32]); 4] = [
            (taken, &[]),
            (strip, &[]),
            (ExecutionMode::Invocations, &[RUNS]),
            (ExecutionMode::OutputVertices, &[vertices]),
        ];
        for (mode, operands) in modes {
            push(&mut words, Op::ExecutionMode, &[&[linked.root, mode as u32], operands].concat());
        }
        words.append(&mut to.decorations);
        words.append(&mut to.globals);
        words.append(&mut to.bodies);
        words
    }
}
