//! Declarations in a shader's text outside of its functions, and the ranges of its functions.

use crate::intercept::gl::shader::source::text::brackets::behind;
use crate::intercept::gl::shader::source::text::tokens::is_name;
use std::collections::HashMap;
use std::ops::Range;

/// Meaning of a name outside of functions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Global<'a> {
    /// An attribute with this number of components.
    Attribute(usize),
    /// A 4×4 matrix of floats that the program sets.
    Matrix,
    /// The instance of a uniform block, with the name of the block.
    Block(&'a str),
    /// Anything else.
    Other,
}

/// A function.
#[derive(Debug)]
pub struct Function<'a> {
    /// Name.
    pub name: &'a str,
    /// Range of the words between its parentheses.
    pub parameters: Range<usize>,
    /// Range of the words between its braces; empty for a prototype.
    pub body: Range<usize>,
}

/// Declarations at the outermost level of a text.
#[derive(Debug, Default)]
pub struct Declarations<'a> {
    /// Names and their meanings.
    pub globals: HashMap<&'a str, Global<'a>>,
    /// Functions, in the order of the text.
    pub functions: Vec<Function<'a>>,
    /// 4×4 matrices of blocks with instances: name of the block, name of the member.
    pub members: Vec<(&'a str, &'a str)>,
}

/// Reads the declarations of `words`. `None`: the text is not understood.
pub fn read<'a>(words: &[&'a str]) -> Option<Declarations<'a>> {
    let mut found = Declarations::default();
    let mut start = 0;
    while start < words.len() {
        start = found.statement(words, start)?;
    }
    Some(found)
}

/// Words before a type that have no meaning here.
const QUALIFIERS: [&str; 17] = [
    "attribute",
    "in",
    "uniform",
    "varying",
    "out",
    "const",
    "flat",
    "smooth",
    "noperspective",
    "centroid",
    "invariant",
    "precise",
    "highp",
    "mediump",
    "lowp",
    "sample",
    "patch",
];

impl<'a> Declarations<'a> {
    /// Reads one declaration. Returns the index after it.
    fn statement(&mut self, words: &[&'a str], start: usize) -> Option<usize> {
        let mut at = start;
        let (mut attribute, mut uniform) = (false, false);
        loop {
            match *words.get(at)? {
                ";" => return Some(at + 1),
                "layout" => at = behind(words, at + 1)?,
                "precision" | "struct" => return self.skip(words, at),
                word if QUALIFIERS.contains(&word) => {
                    attribute |= matches!(word, "attribute" | "in");
                    uniform |= word == "uniform";
                    at += 1;
                }
                word if is_name(word) => break,
                _ => return None,
            }
        }
        let (kind, after) = (words[at], at + 1);
        match *words.get(after)? {
            "{" => self.block(words, kind, after, uniform),
            // A statement like `invariant gl_Position;`.
            ";" => Some(after + 1),
            "," => self.skip(words, at),
            "[" => self.skip(words, at),
            name if is_name(name) && words.get(after + 1) == Some(&"(") => self.function(words, name, after + 1),
            _ => {
                let global = match kind {
                    "mat4" if uniform => Global::Matrix,
                    "vec2" if attribute => Global::Attribute(2),
                    "vec3" if attribute => Global::Attribute(3),
                    "vec4" if attribute => Global::Attribute(4),
                    _ => Global::Other,
                };
                self.variables(words, after, &global)
            }
        }
    }

    /// Reads the names of a declaration from the first one on. Returns the index after them.
    fn variables(&mut self, words: &[&'a str], start: usize, global: &Global<'a>) -> Option<usize> {
        let mut at = start;
        loop {
            let name = *words.get(at).filter(|word| is_name(word))?;
            let plain = matches!(*words.get(at + 1)?, "," | ";");
            // A matrix may have an initial value, which the driver knows.
            let initialised = words[at + 1] == "=" && *global == Global::Matrix;
            self.declare(name, if plain || initialised { global.clone() } else { Global::Other });
            at += 1;
            loop {
                match *words.get(at)? {
                    ";" => return Some(at + 1),
                    "," => break,
                    "(" | "[" | "{" => at = behind(words, at)?,
                    _ => at += 1,
                }
            }
            at += 1;
        }
    }

    fn declare(&mut self, name: &'a str, global: Global<'a>) {
        // Branches of conditional compilation may declare the same name twice, in two dialects.
        let known = self.globals.entry(name).or_insert_with(|| global.clone());
        if *known != global {
            *known = Global::Other;
        }
    }

    /// Skips a statement that is not needed, up to its semicolon. Its names may have any meaning.
    fn skip(&mut self, words: &[&'a str], start: usize) -> Option<usize> {
        let mut at = start;
        loop {
            match *words.get(at)? {
                ";" => return Some(at + 1),
                "(" | "[" | "{" => at = behind(words, at)?,
                word => {
                    if is_name(word) {
                        self.declare(word, Global::Other);
                    }
                    at += 1;
                }
            }
        }
    }

    fn function(&mut self, words: &[&'a str], name: &'a str, open: usize) -> Option<usize> {
        let after = behind(words, open)?;
        let (body, end) = match *words.get(after)? {
            ";" => (after..after, after + 1),
            "{" => {
                let end = behind(words, after)?;
                (after + 1..end - 1, end)
            }
            _ => return None,
        };
        self.functions.push(Function { name, parameters: open + 1..after - 1, body });
        Some(end)
    }

    /// Reads a block like `uniform Name { … } instance;`.
    fn block(&mut self, words: &[&'a str], name: &'a str, open: usize, uniform: bool) -> Option<usize> {
        let close = behind(words, open)?;
        let instance = *words.get(close)?;
        let named = is_name(instance);
        let mut members = Declarations::default();
        let mut at = open + 1;
        while at < close - 1 {
            at = members.member(words, at)?;
        }
        for (member, global) in members.globals {
            let global = if uniform { global } else { Global::Other };
            match (named, global == Global::Matrix) {
                (false, _) => self.declare(member, global),
                (true, true) => self.members.push((name, member)),
                (true, false) => {}
            }
        }
        if named {
            let array = words.get(close + 1) == Some(&"[");
            self.declare(instance, if uniform && !array { Global::Block(name) } else { Global::Other });
        }
        self.end(words, close)
    }

    /// Reads a member of a block like a uniform, with any qualifiers.
    fn member(&mut self, words: &[&'a str], start: usize) -> Option<usize> {
        let mut at = start;
        while words.get(at) == Some(&"layout") || words.get(at).is_some_and(|word| QUALIFIERS.contains(word)) {
            at = if words[at] == "layout" { behind(words, at + 1)? } else { at + 1 };
        }
        let global = if words.get(at) == Some(&"mat4") { Global::Matrix } else { Global::Other };
        self.variables(words, at + 1, &global)
    }

    fn end(&self, words: &[&str], start: usize) -> Option<usize> {
        words[start..].iter().position(|word| *word == ";").map(|offset| start + offset + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::{Global, read};
    use crate::intercept::gl::shader::source::text::tokens::split;

    #[test]
    fn globals_of_every_kind() {
        let text = "precision highp float; layout(location = 0) in vec3 a, b; attribute highp vec4 c;\n\
            uniform mat4 m, n[2], o = mat4(1.0); uniform vec3 v; struct S { vec4 m; } s;\n\
            layout(std140) uniform Camera { mat4 p; vec4 q; } camera; uniform Loose { layout(row_major) mat4 r; };\n\
            invariant gl_Position; const float x = f(1, 2); out gl_PerVertex { vec4 gl_Position; };\n\
            float f(float y); float f(float y) { if (y > 0.0) { return 1.0; } return y; } void main(void) { }";
        let tokens = split(text).expect("plain");
        let found = read(&tokens.words).expect("understood");
        for name in ["a", "b"] {
            assert_eq!(found.globals[name], Global::Attribute(3));
        }
        assert_eq!(found.globals["c"], Global::Attribute(4));
        for name in ["m", "o", "r"] {
            assert_eq!(found.globals[name], Global::Matrix, "{name}");
        }
        for name in ["n", "v", "x", "s"] {
            assert_eq!(found.globals[name], Global::Other, "{name}");
        }
        assert_eq!(found.globals["camera"], Global::Block("Camera"));
        assert_eq!(found.members, [("Camera", "p")]);
        let functions: Vec<_> = found.functions.iter().map(|f| (f.name, f.body.len())).collect();
        assert_eq!(functions, [("f", 0), ("f", 14), ("main", 0)]);
    }

    #[test]
    fn two_dialects_of_one_declaration_are_one_and_two_kinds_are_none() {
        let tokens =
            split("#if A\nin vec3 a; in vec3 b;\n#else\nattribute vec3 a; uniform mat4 b;\n#endif").expect("plain");
        let found = read(&tokens.words).expect("understood");
        assert_eq!((&found.globals["a"], &found.globals["b"]), (&Global::Attribute(3), &Global::Other));
    }

    #[test]
    fn what_is_cut_short_is_not_understood() {
        for text in ["uniform mat4", "void main() {", "layout(", "a + b;", "uniform B { mat4 m;"] {
            let tokens = split(text).expect("plain");
            assert!(read(&tokens.words).is_none(), "{text}");
        }
    }
}
