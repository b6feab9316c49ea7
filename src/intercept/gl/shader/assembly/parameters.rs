//! Parameters of a vertex program in assembly language that flow into its position.

use crate::intercept::gl::state::shader::assembly::{Parameter, ParameterMatrix};
use crate::intercept::gl::state::shader::position_names::Uses;
use crate::intercept::scene::lens;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::RangeInclusive;

/// Greatest length of an array of parameters.
const LONGEST: u32 = 1024;

/// Values that flow into a position.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct ReachedParameters {
    /// Parameters of the program or its environment, and their uses.
    pub parameters: BTreeMap<Parameter, Uses>,
    /// True if fixed-function matrices flow into the position, or parts of the text are not
    /// understood.
    pub others: bool,
}

impl ReachedParameters {
    /// Returns the groups of four consecutive parameters.
    pub fn matrices(&self) -> Vec<ParameterMatrix> {
        let mut found = Vec::new();
        for kind in [Parameter::Environment as fn(u32) -> Parameter, Parameter::Local] {
            let numbers: Vec<u32> =
                (0..LONGEST).filter(|number| self.parameters.contains_key(&kind(*number))).collect();
            found.extend(lens::fours(&numbers).into_iter().map(|first| {
                let uses = (first..first + 4).filter_map(|number| self.parameters.get(&kind(number)));
                let uses = uses.fold(Uses::default(), |all, uses| all.and(*uses));
                ParameterMatrix { first: kind(first), order: uses.order() }
            }));
        }
        found
    }
}

/// Meaning of one operand.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Source {
    Parameter(Parameter),
    /// State of OpenGL.
    State,
    /// A variable, or an attribute of the vertex.
    Name(String),
}

/// Reads `text`, which must have no comments.
pub fn of_position(text: &str) -> ReachedParameters {
    let mut program = Program::default();
    // The body follows the header.
    let body = text.split_once(|c: char| c.is_whitespace()).map_or("", |(_, body)| body);
    body.split(';').for_each(|statement| program.statement(statement.trim()));
    program.reached()
}

#[derive(Default)]
struct Program {
    /// Content of named parameters, one for each element of an array.
    arrays: HashMap<String, Vec<Source>>,
    /// Other names of variables.
    aliases: HashMap<String, String>,
    /// For each variable the values that flow into it.
    into: HashMap<String, Vec<(Source, Uses)>>,
    strange: bool,
}

impl Program {
    fn statement(&mut self, statement: &str) {
        let Some((word, rest)) = statement.split_once(|c: char| c.is_whitespace()) else { return };
        match word {
            "PARAM" => {
                let Some((name, value)) = rest.split_once('=') else { return };
                let name = base(name).to_owned();
                let value = value.trim().trim_start_matches('{').trim_end_matches('}');
                let sources = value.split(',').flat_map(|part| self.elements(part.trim())).collect();
                self.arrays.insert(name, sources);
            }
            "ATTRIB" | "OUTPUT" | "ALIAS" => {
                let Some((name, value)) = rest.split_once('=') else { return };
                self.aliases.insert(name.trim().to_owned(), value.trim().to_owned());
            }
            "TEMP" | "ADDRESS" | "OPTION" => {}
            _ => self.instruction(word, rest),
        }
    }

    fn instruction(&mut self, operation: &str, operands: &str) {
        let mut operands = operands.split(',').map(str::trim);
        let Some(target) = operands.next().map(|target| self.variable(target)) else { return };
        let sources: Vec<&str> = operands.collect();
        for (number, operand) in sources.into_iter().enumerate() {
            let uses = match operation {
                "DP3" | "DP4" | "DPH" => Uses { products: true, factors: false },
                "MUL" => Uses { products: false, factors: true },
                "MAD" => Uses { products: false, factors: number < 2 },
                _ => Uses::default(),
            };
            let found: Vec<_> = self.sources(operand).into_iter().map(|source| (source, uses)).collect();
            self.into.entry(target.clone()).or_default().extend(found);
        }
    }

    /// Returns the variable that `operand` writes, or `result.position`.
    fn variable(&self, operand: &str) -> String {
        let mut name = if operand.starts_with("result.position") { "result.position" } else { base(operand) };
        for _ in 0..8 {
            match self.aliases.get(name) {
                Some(other) => {
                    name = if other.starts_with("result.position") { "result.position" } else { base(other) }
                }
                None => break,
            }
        }
        name.to_owned()
    }

    /// Returns the values that an operand reads.
    fn sources(&mut self, operand: &str) -> Vec<Source> {
        let operand = operand.trim_start_matches(['-', '+', ' ', '|']);
        let name = self.variable(operand);
        let Some(elements) = self.arrays.get(&name) else { return self.elements(operand) };
        let Some((_, index)) = operand.split_once('[') else { return elements.first().cloned().into_iter().collect() };
        let index = index.split(']').next().unwrap_or_default().trim();
        match index.parse::<usize>() {
            Ok(index) => elements.get(index).cloned().into_iter().collect(),
            // The index is an address. All elements may be meant.
            Err(_) => elements.clone(),
        }
    }

    /// Returns the values of `part`, which is an entry of a list of parameters or an operand.
    fn elements(&mut self, part: &str) -> Vec<Source> {
        let range = |prefix: &str| part.strip_prefix(prefix).and_then(numbers);
        if part.starts_with("program.") {
            let found = match (range("program.env"), range("program.local")) {
                (Some(numbers), _) => numbers.map(|n| Source::Parameter(Parameter::Environment(n))).collect(),
                (_, Some(numbers)) => numbers.map(|n| Source::Parameter(Parameter::Local(n))).collect(),
                _ => Vec::new(),
            };
            self.strange |= found.is_empty();
            return found;
        }
        if part.starts_with("state.") {
            let rows = match part.split_once(".row") {
                Some((_, rows)) => numbers(rows).map_or(1, Iterator::count),
                None if part.starts_with("state.matrix") => 4,
                None => 1,
            };
            return vec![Source::State; rows];
        }
        vec![Source::Name(self.variable(part))]
    }

    fn reached(&self) -> ReachedParameters {
        let mut found = ReachedParameters { others: self.strange, ..ReachedParameters::default() };
        let (mut seen, mut open) = (HashSet::new(), vec!["result.position".to_owned()]);
        while let Some(name) = open.pop() {
            for (source, uses) in self.into.get(&name).into_iter().flatten() {
                match source {
                    Source::Parameter(parameter) => {
                        let known = found.parameters.entry(*parameter).or_default();
                        *known = known.and(*uses);
                    }
                    Source::State => found.others = true,
                    Source::Name(name) if seen.insert(name.clone()) => open.push(name.clone()),
                    Source::Name(_) => {}
                }
            }
        }
        found
    }
}

/// Returns a name without index and components.
fn base(operand: &str) -> &str {
    let operand = operand.trim();
    operand.split(['.', '[', ' ']).next().unwrap_or(operand)
}

/// Returns the numbers of `[8]` or `[8..11]`.
fn numbers(brackets: &str) -> Option<RangeInclusive<u32>> {
    let inner = brackets.trim().strip_prefix('[')?.split(']').next()?;
    let (first, last) = inner.split_once("..").unwrap_or((inner, inner));
    let (first, last) = (first.trim().parse().ok()?, last.trim().parse().ok()?);
    (last < LONGEST).then_some(first..=last)
}

#[cfg(test)]
mod tests {
    use super::{Parameter, ParameterMatrix, of_position};
    use crate::intercept::scene::lens::Order;

    fn matrices(body: &str) -> Vec<ParameterMatrix> {
        let found = of_position(&format!("!!ARBvp1.0\n{body}\nEND"));
        assert!(!found.others, "{body}");
        found.matrices()
    }

    #[test]
    fn four_parameters_are_rows_or_columns() {
        let rows = "DP4 result.position.x, m[0], vertex.position; DP4 result.position.y, m[1], vertex.position;\n\
                    DP4 result.position.z, vertex.position, m[2]; DP4 result.position.w, m[3], vertex.position;";
        let matrix = |first, order| ParameterMatrix { first, order };
        let environment = format!("PARAM m[4] = {{ program.env[8..11] }}; {rows}");
        assert_eq!(matrices(&environment), [matrix(Parameter::Environment(8), Order::Rows)]);
        let local = format!("PARAM m[6] = {{ program.local[3..5], program.local[6], {{1,2,3,4}} }}; {rows}");
        assert_eq!(matrices(&local), [matrix(Parameter::Local(3), Order::Rows)]);
        let columns = "OUTPUT p = result.position; TEMP t; ATTRIB v = vertex.position; ALIAS u = t;\n\
                       MUL t, v.x, program.env[0]; MAD u, v.y, program.env[1], t; MAD t, v.z, program.env[2], u;\n\
                       MAD p, v.w, program.env[3], t; DP4 result.color, program.env[4], v;";
        assert_eq!(matrices(columns), [matrix(Parameter::Environment(0), Order::Columns)]);
    }

    #[test]
    fn fixed_function_matrices_and_what_is_not_understood_are_told() {
        for body in [
            "PARAM m[4] = { state.matrix.mvp }; DP4 result.position.x, m[0], vertex.position;",
            "TEMP t; DP4 t.x, state.matrix.projection.row[1], vertex.position; MOV result.position, t;",
            "MOV result.position, program.strange[1];",
        ] {
            assert!(of_position(&format!("!!ARBvp1.0\n{body}\nEND")).others, "{body}");
        }
        for body in
            ["", "PARAM", "MOV", "MOV a", "PARAM a = program.env[99999999999];", "ALIAS a = a; MOV a, a;", ";;,,[["]
        {
            let _ = of_position(&format!("!!ARBvp1.0 {body}"));
        }
    }

    #[test]
    fn other_parameters_do_not_flow() {
        let light = "MOV result.position, vertex.position; DP4 result.color, program.env[0], vertex.color;";
        assert_eq!(matrices(light), []);
    }
}
