//! Functions of the stage: they read the corners, write vertices and count.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::projected_vertices::geometry_stage::{Interface, MISSING, Pair, Stage};
use crate::intercept::vk::projected_vertices::stage_outputs::OutputPart;
use crate::intercept::vk::spirv::functions::{Linked, push};
use spirv::{Decoration, FunctionControl, Op, Scope, StorageClass};

impl Stage<'_> {
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
    pub(super) fn bodies(
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
    pub(super) fn count(&mut self, linked: &Linked, set: Option<u32>) -> Result<(), Obstacle> {
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
}
