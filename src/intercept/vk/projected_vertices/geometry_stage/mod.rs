//! A geometry stage of Cupola after a program's vertex shader. It divides triangles or lines and
//! projects the vertices that it emits.
//!
//! The build compiles the arithmetic, `correct::projected::division`, to SPIR-V. The code that
//! reads the corners and writes vertices is made here (`bodies`). The outputs of the vertex shader
//! are declared twice (`declarations`): as an array of the corners' values, and as outputs of this
//! stage.

mod bodies;
mod declarations;

use crate::correct::projected::division::Input;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::projected_vertices::stage_outputs::{OutputPart, StageOutputs};
use crate::intercept::vk::spirv::functions::{Additions, Linked, division, push};
use crate::intercept::vk::spirv::module::{Declarations, HEADER};
use spirv::{AddressingModel, Capability, ExecutionMode, ExecutionModel, MemoryModel, Op};
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

impl Stage<'_> {
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
