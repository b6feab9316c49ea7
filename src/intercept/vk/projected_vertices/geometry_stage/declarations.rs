//! Declarations of the stage: types and constants, and each output of the vertex shader as an array
//! of the corners' values and as an output of this stage.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::projected_vertices::geometry_stage::{Interface, MISSING, MOST_TYPES, Pair, Stage};
use crate::intercept::vk::spirv::functions::push;
use spirv::{BuiltIn, Decoration, Op, StorageClass};

impl<'a> Stage<'a> {
    pub(super) fn float(&mut self) -> u32 {
        self.to.kind(Op::TypeFloat, &[32])
    }

    pub(super) fn vector(&mut self, length: u32) -> u32 {
        let float = self.float();
        self.to.kind(Op::TypeVector, &[float, length])
    }

    pub(super) fn int(&mut self) -> u32 {
        self.to.kind(Op::TypeInt, &[32, 1])
    }

    pub(super) fn pointer(&mut self, class: StorageClass, kind: u32) -> u32 {
        self.to.kind(Op::TypePointer, &[class as u32, kind])
    }

    /// Returns a constant of type `int`.
    pub(super) fn number(&mut self, value: u32) -> u32 {
        if let Some(id) = self.numbers.get(&value) {
            return *id;
        }
        let (int, id) = (self.int(), self.to.id());
        push(&mut self.to.globals, Op::Constant, &[int, id, value]);
        self.numbers.insert(value, id);
        id
    }

    pub(super) fn variable(&mut self, class: StorageClass, kind: u32) -> u32 {
        let (pointer, id) = (self.pointer(class, kind), self.to.id());
        push(&mut self.to.globals, Op::Variable, &[pointer, id, class as u32]);
        id
    }

    pub(super) fn decorate(&mut self, id: u32, member: Option<u32>, decoration: Decoration, operands: &[u32]) {
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
    pub(super) fn copy(&mut self, id: u32) -> Result<u32, Obstacle> {
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

    /// Declares the variables of the stage.
    pub(super) fn declare(&mut self) -> Result<Interface<'a>, Obstacle> {
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
}
