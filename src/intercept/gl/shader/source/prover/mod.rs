//! Proves from a vertex shader's text where its vertices are: `gl_Position` is a product of one
//! attribute and matrices that the program sets.
//!
//! A text of another form, or one that is not understood, is not proven: after a wrong proof a part
//! of the picture would be missing. All names between the attribute and `gl_Position` must be
//! declared once, and written once, unconditionally and in `main`. All branches of conditional
//! compilation are examined.

mod declarations;

use crate::intercept::gl::shader::source::prover::declarations::{Declarations, Function, Global};
use crate::intercept::gl::shader::source::text::brackets::behind;
use crate::intercept::gl::shader::source::text::tokens::{self, Tokens, is_name, number};
use std::cell::Cell;

/// PositionArray that has the positions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PositionArray {
    /// `gl_Vertex`.
    Conventional,
    /// A named attribute of the program.
    Named(String),
}

/// Matrix of the product.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Factor {
    /// A uniform, by its name in OpenGL.
    Uniform(String),
    /// `GL_MODELVIEW`.
    ModelView,
    /// `GL_PROJECTION`.
    Projection,
}

/// `gl_Position = factors[0] · factors[1] · … · (attribute)`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Proof {
    /// Matrices, from the left.
    pub factors: Vec<Factor>,
    /// PositionArray.
    pub attribute: PositionArray,
    /// Number of components that are used, 2…4. The others are 0, 0, 1.
    pub components: usize,
}

/// Greatest number of matrices, since rounding errors add up.
const MOST_FACTORS: usize = 8;

/// Greatest number of steps. It also limits the depth of recursion.
const MOST_STEPS: u32 = 64;

/// Words of shaders whose draws have other effects than visible ones, or other targets.
const EFFECTS: [&str; 12] = [
    "gl_PointSize",
    "gl_Layer",
    "gl_ViewportIndex",
    "gl_ViewportMask",
    "gl_PositionPerViewNV",
    "buffer",
    "inout",
    "imageStore",
    "atomic_uint",
    "image2D",
    "uimageBuffer",
    "subroutine",
];

/// Returns the proof for a vertex shader, if there is one. `es_context`: low precisions prevent a
/// proof.
pub fn prove(source: &str, es_context: bool) -> Option<Proof> {
    let bare = tokens::bare(source);
    let Tokens { words, macros } = tokens::split(&bare)?;
    let effects = |word: &&str| EFFECTS.contains(word) || word.starts_with("imageAtomic");
    let coarse = |word: &&str| es_context && matches!(*word, "mediump" | "lowp");
    if words.iter().chain(&macros).any(|word| effects(word) || coarse(word)) {
        return None;
    }
    let declarations = declarations::read(&words)?;
    let mut mains = declarations.functions.iter().filter(|f| f.name == "main");
    let (main, None) = (mains.next()?, mains.next()) else { return None };
    let text = Text { words: &words, macros: &macros, declarations: &declarations, main, steps: Cell::new(0) };
    if text.gives_back_arguments() {
        return None;
    }
    let (start, end) = text.written("gl_Position", false)?;
    match text.product(start, end)? {
        Value { factors, position: Some((attribute, components)) } if factors.len() <= MOST_FACTORS => {
            Some(Proof { factors, attribute, components })
        }
        _ => None,
    }
}

/// Product of matrices, and of a position if it ends with one.
struct Value {
    factors: Vec<Factor>,
    position: Option<(PositionArray, usize)>,
}

struct Text<'a> {
    words: &'a [&'a str],
    macros: &'a [&'a str],
    declarations: &'a Declarations<'a>,
    main: &'a Function<'a>,
    steps: Cell<u32>,
}

impl<'a> Text<'a> {
    fn word(&self, at: usize) -> &'a str {
        self.words.get(at).copied().unwrap_or_default()
    }

    /// True if a function may change its arguments.
    fn gives_back_arguments(&self) -> bool {
        self.declarations.functions.iter().any(|f| self.words[f.parameters.clone()].contains(&"out"))
    }

    /// Returns the places at which functions use `name` as a variable.
    fn uses(&self, name: &'a str) -> impl Iterator<Item = usize> + '_ {
        let ranges = self.declarations.functions.iter().flat_map(|f| [f.parameters.clone(), f.body.clone()]);
        ranges.flatten().filter(move |at| self.words[*at] == name && self.word(at.wrapping_sub(1)) != ".")
    }

    /// True if the word at `at` is declared there: it follows a type, or a comma outside of
    /// parentheses.
    fn declares(&self, at: usize) -> bool {
        let before = self.word(at - 1);
        if before == "," {
            let statement = self.words[..at].iter().rposition(|word| matches!(*word, ";" | "{" | "}")).unwrap_or(0);
            let count = |bracket: &str| self.words[statement..at].iter().filter(|word| **word == bracket).count();
            return count("(") == count(")");
        }
        is_name(before) && !matches!(before, "return" | "else" | "case" | "do")
    }

    /// True if the word at `at`, or a part of it, is assigned to.
    fn writes(&self, at: usize) -> bool {
        let mut after = at + 1;
        loop {
            match self.word(after) {
                "." => after += 2,
                "[" => match behind(self.words, after) {
                    Some(next) => after = next,
                    None => return true,
                },
                word => {
                    let step = matches!(word, "++" | "--") || matches!(self.word(at.wrapping_sub(1)), "++" | "--");
                    let assigns = word.ends_with('=') && !matches!(word, "==" | "!=" | "<=" | ">=");
                    return step || assigns;
                }
            }
        }
    }

    /// True if `name` has the same meaning everywhere: no function declares a variable of this
    /// name, or writes to it.
    fn is_constant(&self, name: &'a str) -> bool {
        !self.macros.contains(&name) && self.uses(name).all(|at| !self.declares(at) && !self.writes(at))
    }

    /// Returns the only expression that is assigned to `name`, at the outermost level of `main`:
    /// its first word, and the semicolon after it. `local`: `name` is a variable of `main` itself.
    fn written(&self, name: &'a str, local: bool) -> Option<(usize, usize)> {
        if self.macros.contains(&name) {
            return None;
        }
        let mut written = self.uses(name).filter(|at| self.writes(*at));
        let (at, None) = (written.next()?, written.next()) else { return None };
        let declared: Vec<usize> = self.uses(name).filter(|at| self.declares(*at)).collect();
        let typed = |at: usize| matches!(self.word(at - 1), "vec4" | "mat4");
        let fits = match declared[..] {
            [] => !local,
            [declared] => local && declared <= at && typed(declared) && self.outermost(declared),
            _ => false,
        };
        let mut first = at;
        while matches!(self.word(first - 1), "vec4" | "mat4" | "highp" | "mediump" | "lowp" | "const") {
            first -= 1;
        }
        let begins = matches!(self.word(first - 1), ";" | "{" | "}");
        if !fits || !begins || self.word(at + 1) != "=" || !self.outermost(at) {
            return None;
        }
        let length = self.words[at..self.main.body.end].iter().position(|word| *word == ";")?;
        Some((at + 2, at + length))
    }

    /// True if a place is in `main`, outside of all other braces and parentheses.
    fn outermost(&self, at: usize) -> bool {
        if !self.main.body.contains(&at) {
            return false;
        }
        let before = &self.words[self.main.body.start..at];
        let count = |bracket: &str| before.iter().filter(|word| **word == bracket).count();
        count("{") == count("}") && count("(") == count(")")
    }

    /// Returns the product of the words `start..end`: factors with `*` between them.
    fn product(&self, start: usize, end: usize) -> Option<Value> {
        let mut value = Value { factors: Vec::new(), position: None };
        let mut at = start;
        loop {
            let (next, after) = self.factor(at, end)?;
            if value.position.is_some() {
                // The product of a row vector and a matrix is not supported.
                return None;
            }
            value.factors.extend(next.factors);
            value.position = next.position;
            if value.factors.len() > MOST_FACTORS {
                return None;
            }
            match self.word(after) {
                _ if after == end => return Some(value),
                "*" => at = after + 1,
                _ => return None,
            }
        }
    }

    /// Returns the factor at `at`, and the index after it.
    fn factor(&self, at: usize, end: usize) -> Option<(Value, usize)> {
        let word = self.word(at);
        self.steps.set(self.steps.get() + 1);
        if self.steps.get() > MOST_STEPS {
            return None;
        }
        let one = |factors: Vec<Factor>, position, length: usize| {
            let after = at + length;
            (after <= end).then_some((Value { factors, position }, after))
        };
        match word {
            "(" => {
                let after = behind(self.words, at).filter(|after| *after <= end)?;
                Some((self.product(at + 1, after - 1)?, after))
            }
            "vec4" => {
                let after = behind(self.words, at + 1).filter(|after| *after <= end)?;
                Some((Value { factors: Vec::new(), position: Some(self.point(at + 2, after - 1)?) }, after))
            }
            "ftransform" if self.is_built_in(word) => {
                let closed = self.word(at + 1) == "(" && self.word(at + 2) == ")";
                let position = Some((PositionArray::Conventional, 4));
                closed.then(|| one(vec![Factor::Projection, Factor::ModelView], position, 3))?
            }
            "gl_Vertex" if self.is_built_in(word) => one(Vec::new(), Some((PositionArray::Conventional, 4)), 1),
            "gl_ModelViewProjectionMatrix" if self.is_built_in(word) => {
                one(vec![Factor::Projection, Factor::ModelView], None, 1)
            }
            "gl_ModelViewMatrix" if self.is_built_in(word) => one(vec![Factor::ModelView], None, 1),
            "gl_ProjectionMatrix" if self.is_built_in(word) => one(vec![Factor::Projection], None, 1),
            _ if !is_name(word) => None,
            _ => match self.declarations.globals.get(word) {
                Some(Global::Matrix) if self.is_constant(word) => one(vec![Factor::Uniform(word.to_owned())], None, 1),
                Some(Global::Attribute(4)) if self.is_constant(word) => {
                    one(Vec::new(), Some((PositionArray::Named(word.to_owned()), 4)), 1)
                }
                Some(Global::Block(block)) if self.is_constant(word) => {
                    let member = self.word(at + 2);
                    let known = self.word(at + 1) == "." && self.declarations.members.contains(&(*block, member));
                    known.then(|| one(vec![Factor::Uniform(format!("{block}.{member}"))], None, 3))?
                }
                Some(_) => None,
                None => {
                    let (start, semicolon) = self.written(word, true)?;
                    // An expression that comes later, or that contains the name itself, is not its
                    // value.
                    (semicolon < at)
                        .then(|| self.product(start, semicolon))?
                        .and_then(|v| one(v.factors, v.position, 1))
                }
            },
        }
    }

    /// True if a built-in name has the meaning that OpenGL defines.
    fn is_built_in(&self, word: &'a str) -> bool {
        let own =
            self.declarations.globals.contains_key(word) || self.declarations.functions.iter().any(|f| f.name == word);
        !own && self.is_constant(word)
    }

    /// Returns the attribute in `vec4(…)` of the words `start..end`, and the number of its
    /// components. The forms are `(a, 1.0)`, `(a.xyz, 1.0)`, `(a.xy, 0.0, 1.0)`, `(a.x, a.y, a.z,
    /// 1.0)`.
    fn point(&self, start: usize, end: usize) -> Option<(PositionArray, usize)> {
        let mut name = None;
        let (mut components, mut constants) = (0, Vec::new());
        for part in self.words[start..end].split(|word| *word == ",") {
            match *part {
                [word] if number(word).is_some() => constants.push(number(word)?),
                [word, ref rest @ ..] if constants.is_empty() && *name.get_or_insert(word) == word => {
                    let swizzle = match *rest {
                        [] => "",
                        [".", swizzle] => swizzle,
                        _ => return None,
                    };
                    components += self.taken(word, swizzle, components)?;
                }
                _ => return None,
            }
        }
        let rest: &[f64] = match components {
            2 => &[0.0, 1.0],
            3 => &[1.0],
            4 => &[],
            _ => return None,
        };
        let name = name.filter(|name| constants == rest && self.is_constant(name))?;
        let attribute = match name {
            "gl_Vertex" if self.is_built_in(name) => PositionArray::Conventional,
            _ => PositionArray::Named(name.to_owned()),
        };
        Some((attribute, components))
    }

    /// Returns the number of components of `name.swizzle`, if they are the components that follow
    /// the first `before` ones.
    fn taken(&self, name: &str, swizzle: &str, before: usize) -> Option<usize> {
        let size = match (name, self.declarations.globals.get(name)) {
            ("gl_Vertex", None) => 4,
            (_, Some(Global::Attribute(size))) => *size,
            _ => return None,
        };
        match swizzle {
            "" => (before == 0).then_some(size),
            _ => "xyzw"
                .get(before..before + swizzle.len())
                .filter(|part| *part == swizzle && before + part.len() <= size)
                .map(str::len),
        }
    }
}

#[cfg(test)]
mod tests;
