//! Adds the reprojection functions, which the build compiles to SPIR-V (`build/projection.rs`), to
//! a program's module. All ids get new numbers. Types that must be unique in a module are taken
//! from the program's module if it has them.

use crate::correct::projected::division::Input;
use crate::intercept::vk::spirv::module::{Declarations, Instruction, instructions_of};
use spirv::{Decoration, Op};
use std::collections::HashMap;

/// Instructions, and the positions of ids among their words.
struct Part {
    words: &'static [u32],
    ids: &'static [usize],
}

/// The function `cupola_fix` of `correct::projected::projection`, and everything that it needs.
pub struct Functions {
    decorations: Part,
    globals: Part,
    bodies: Part,
    /// Id of the import of GLSL's own functions.
    import: u32,
    /// The uniform block with the view constants.
    variable: u32,
    fix: u32,
    /// The main function: `cupola_fix`, or a function that calls it.
    root: u32,
    /// Functions that the module has to define: those of
    /// `correct::projected::division::STAGE_FUNCTIONS`, or none.
    open: &'static [u32],
    /// Parameter and result type of `cupola_fix`.
    vector: u32,
    /// All ids are below this number.
    bound: u32,
}

include!(concat!(env!("OUT_DIR"), "/projection_spirv.rs"));

/// Returns the functions for views; `lenses`: also for outputs whose lens constants follow the
/// reprojection matrix.
pub fn functions(lenses: bool) -> &'static Functions {
    if lenses { &LENSES } else { &VIEWS }
}

/// Returns the functions that divide: `cupola_divided`.
pub fn division(input: Input) -> &'static Functions {
    match input {
        Input::Triangles => &TRIANGLES,
        Input::Lines => &LINES,
    }
}

/// Additions to a module, by section.
pub struct Additions<'a> {
    declared: &'a Declarations<'a>,
    next: u32,
    /// New types among those that must be unique in a module.
    made: HashMap<(u32, Vec<u32>), u32>,
    /// Added after the extensions.
    pub imports: Vec<u32>,
    /// Added before the types.
    pub decorations: Vec<u32>,
    /// Added before the functions.
    pub globals: Vec<u32>,
    /// Added at the end.
    pub bodies: Vec<u32>,
}

/// Ids of the functions in the program's module.
pub struct Linked {
    /// The uniform block with the view constants.
    pub variable: u32,
    /// The function that reprojects.
    pub fix: u32,
    /// The main function.
    pub root: u32,
    /// The functions that the module has to define.
    pub open: Vec<u32>,
    /// Type of four floats: parameter and result of the reprojection.
    pub vector: u32,
}

impl<'a> Additions<'a> {
    /// Returns empty additions, for a module with ids below `bound`.
    pub fn new(bound: u32, declared: &'a Declarations<'a>) -> Self {
        let (made, [imports, decorations, globals, bodies]) = (HashMap::new(), Default::default());
        Self { declared, next: bound, made, imports, decorations, globals, bodies }
    }

    /// Returns a new id.
    pub fn id(&mut self) -> u32 {
        self.next += 1;
        self.next - 1
    }

    /// Returns the first number that is not used as an id.
    pub fn bound(&self) -> u32 {
        self.next
    }

    /// Returns a type that must be unique in a module: the module's own, or a new one.
    pub fn kind(&mut self, op: Op, operands: &[u32]) -> u32 {
        let key = (op as u32, operands.to_vec());
        if let Some(id) = self.declared.find(op, operands).or_else(|| self.made.get(&key).copied()) {
            return id;
        }
        let id = self.id();
        push(&mut self.globals, op, &[&[id], operands].concat());
        self.made.insert(key, id);
        id
    }

    /// Returns the import of GLSL's own functions: the module's, or a new one.
    pub fn glsl(&mut self) -> u32 {
        self.declared.imported("GLSL.std.450").unwrap_or_else(|| {
            let import = self.id();
            let name = [0x4c53_4c47, 0x6474_732e, 0x3035_342e, 0];
            push(&mut self.imports, Op::ExtInstImport, &[&[import], &name[..]].concat());
            import
        })
    }

    /// Adds `functions`. Their block is in set `set`.
    pub fn link(&mut self, functions: &Functions, set: u32) -> Linked {
        let mut ids = vec![0; functions.bound as usize];
        let calls = functions.bodies.instructions().iter().any(|i| i.is(Op::ExtInst));
        if let Some(place) = ids.get_mut(functions.import as usize).filter(|_| calls) {
            *place = self.glsl();
        }
        for instruction in functions.globals.instructions() {
            let operands = self.renumbered(&functions.globals, &instruction, &mut ids);
            match Op::from_u32(instruction.opcode) {
                Some(
                    op
                    @ (Op::TypeVoid | Op::TypeBool | Op::TypeInt | Op::TypeFloat | Op::TypeVector | Op::TypeFunction),
                ) => {
                    let kind = self.kind(op, operands.get(1..).unwrap_or_default());
                    if let Some(place) = ids.get_mut(instruction.operand(0) as usize) {
                        *place = kind;
                    }
                }
                _ => push_code(&mut self.globals, instruction.opcode, &operands),
            }
        }
        for instruction in functions.decorations.instructions() {
            let mut operands = self.renumbered(&functions.decorations, &instruction, &mut ids);
            if let [_, kind, number] = &mut operands[..]
                && *kind == Decoration::DescriptorSet as u32
            {
                *number = set;
            }
            push_code(&mut self.decorations, instruction.opcode, &operands);
        }
        for instruction in functions.bodies.instructions() {
            let operands = self.renumbered(&functions.bodies, &instruction, &mut ids);
            push_code(&mut self.bodies, instruction.opcode, &operands);
        }
        let at = |id: u32| ids.get(id as usize).copied().unwrap_or(0);
        Linked {
            variable: at(functions.variable),
            fix: at(functions.fix),
            root: at(functions.root),
            open: functions.open.iter().map(|id| at(*id)).collect(),
            vector: at(functions.vector),
        }
    }

    /// Returns the operands of an instruction of Cupola with their ids in this module.
    fn renumbered(&mut self, part: &Part, instruction: &Instruction<'_>, ids: &mut [u32]) -> Vec<u32> {
        let mut operands = instruction.operands.to_vec();
        let first = instruction.offset + 1;
        for (place, operand) in (first..).zip(&mut operands) {
            if part.ids.binary_search(&place).is_err() {
                continue;
            }
            let Some(id) = ids.get_mut(*operand as usize) else { continue };
            if *id == 0 {
                *id = self.id();
            }
            *operand = *id;
        }
        operands
    }
}

impl Part {
    fn instructions(&self) -> Vec<Instruction<'static>> {
        instructions_of(self.words, 0).unwrap_or_default()
    }
}

/// Appends an instruction.
pub fn push(to: &mut Vec<u32>, op: Op, operands: &[u32]) {
    push_code(to, op as u32, operands);
}

/// Appends an instruction by its number.
pub fn push_code(to: &mut Vec<u32>, opcode: u32, operands: &[u32]) {
    to.push((operands.len() as u32 + 1) << 16 | opcode);
    to.extend(operands);
}
