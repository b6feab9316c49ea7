//! What flows into `gl_Position`: only a matrix among it can be the lens.
//!
//! Engines give every shader a block with all matrices of the camera, also those of a full-screen pass, and such a pass
//! is no scene. The names that may flow into the position are collected from the text, with everything that is in
//! doubt: all branches of conditional compilation, variables of one name as one variable, all words of a statement into
//! each variable that it writes, all words of a function's body into its value, and all conditions into every variable.

use crate::backend::gl::driver::api;
use crate::intercept::gl::shader::elements::{self, Usage};
use crate::intercept::gl::shader::prover::tokens::{self, is_name};
use crate::intercept::gl::state::shader::position_names::PositionNames;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Functions of the language that write to their arguments.
const WRITING: [&str; 6] = ["frexp", "imulExtended", "modf", "uaddCarry", "umulExtended", "usubBorrow"];

/// Stages before rasterisation, the last one first.
const GEOMETRY_STAGES: [u32; 4] =
    [api::GL_GEOMETRY_SHADER, api::GL_TESS_EVALUATION_SHADER, api::GL_TESS_CONTROL_SHADER, api::GL_VERTEX_SHADER];

/// What flows into the position of these shaders: what the last stage says, and all that is in the stages before it.
/// `None` where that is unknown.
pub fn position_names(sources: &HashMap<u32, Arc<str>>, shaders: &[(u32, u32)]) -> Option<PositionNames> {
    let of_kind = |kind| shaders.iter().filter(move |s| s.1 == kind).map(|s| Some(&**sources.get(&s.0)?));
    let mut names = None;
    for kind in GEOMETRY_STAGES {
        let texts: Vec<&str> = of_kind(kind).collect::<Option<_>>()?;
        names = match names {
            _ if texts.is_empty() => names,
            None => Some(of_stage(texts)?),
            Some(names) => Some(texts.into_iter().try_fold(names, with_all_of)?),
        };
    }
    Some(names.unwrap_or_default())
}

/// Those of a stage in `texts`, which are one shader each; `None` where a text is not understood, and any name may flow
/// into the position.
fn of_stage<'a>(texts: impl IntoIterator<Item = &'a str>) -> Option<PositionNames> {
    let mut whole = String::new();
    for text in texts {
        whole.push_str(&tokens::bare(text).replace("\\\r\n", " ").replace("\\\n", " "));
        whole.push('\n');
    }
    if !whole.is_ascii() {
        return None;
    }
    let mut text = Text::default();
    for line in whole.lines() {
        match line.trim_start().strip_prefix('#') {
            Some(directive) => text.directive(directive.trim_start())?,
            None => tokens::words(line, &mut text.words),
        }
    }
    text.arrays = elements::arrays(&text.words);
    text.words = elements::joined_in_bodies(&whole, &text.words, &text.arrays);
    for words in text.macros.values_mut() {
        *words = elements::joined(&whole, words, &text.arrays);
    }
    text.functions();
    Some(text.position_names())
}

/// `names` and every name in `text`, a stage before theirs.
fn with_all_of(mut names: PositionNames, text: &str) -> Option<PositionNames> {
    let bare = tokens::bare(text);
    if !bare.is_ascii() || bare.contains("##") || bare.contains("include") {
        return None;
    }
    let mut words = Vec::new();
    bare.lines().for_each(|line| tokens::words(line, &mut words));
    names.add(words.into_iter().filter(|word| is_name(word)));
    Some(names)
}

#[derive(Default)]
struct Function<'a> {
    parameters: Vec<&'a str>,
    writes_arguments: bool,
}

#[derive(Default)]
struct Text<'a> {
    words: Vec<&'a str>,
    /// What macros stand for, with their parameters.
    macros: HashMap<&'a str, Vec<&'a str>>,
    /// Uniforms that are arrays.
    arrays: HashSet<&'a str>,
    functions: HashMap<&'a str, Function<'a>>,
}

impl<'a> Text<'a> {
    /// `None`: names or statements may come from it that are not seen.
    fn directive(&mut self, text: &'a str) -> Option<()> {
        if let Some(rest) = text.strip_prefix("define") {
            let mut words = Vec::new();
            tokens::words(rest, &mut words);
            let hides = |word: &&str| assigns(word) || matches!(*word, "{" | "}" | ";" | "#");
            let (name, words) = words.split_first()?;
            if words.iter().any(hides) {
                return None;
            }
            self.macros.entry(name).or_default().extend(words);
        }
        (!text.starts_with("include")).then_some(())
    }

    /// Finds the functions: a name, parentheses and an opening brace.
    fn functions(&mut self) {
        for (start, end) in statements(&self.words) {
            let header = &self.words[start..end];
            let opens = self.words.get(end) == Some(&"{");
            let Some(open) = header.iter().position(|word| *word == "(").filter(|open| opens && *open > 1) else {
                continue;
            };
            let arguments = &header[open + 1..];
            let last = |at: usize| arguments.get(at + 1).is_none_or(|word| matches!(*word, "," | ")" | "["));
            let function = self.functions.entry(header[open - 1]).or_default();
            function.parameters.extend(
                arguments.iter().enumerate().filter(|(at, word)| is_name(word) && last(*at)).map(|(_, word)| word),
            );
            function.writes_arguments |= arguments.iter().any(|word| matches!(*word, "out" | "inout"));
        }
    }

    fn position_names(&self) -> PositionNames {
        let flow = self.flow();
        let reached = flow.reached();
        let stands_for = |word: &str| match self.macros.get(word)?[..] {
            [element] | ["(", element, ")"] => elements::parts(element).map(|_| element),
            _ => None,
        };
        let is_written = |name: &str| flow.into.contains_key(name);
        let usage = Usage::new(&self.words, &self.arrays, stands_for);
        let elements = usage.elements(&self.arrays, &reached, |name| !is_written(name));
        let names = reached.iter().map(|name| elements::parts(name).map_or(*name, |(array, _)| array).to_owned());
        PositionNames::new(names.collect(), elements)
    }

    /// What a word may call: itself, and what macros make of it.
    fn called(&self, word: &'a str) -> Vec<&'a str> {
        let mut found = vec![word];
        let mut next = 0;
        while let Some(word) = found.get(next) {
            for inner in self.macros.get(word).into_iter().flatten().filter(|word| is_name(word)) {
                if !found.contains(inner) {
                    found.push(inner);
                }
            }
            next += 1;
        }
        found
    }

    fn flow(&self) -> Flow<'a> {
        let mut flow = Flow::default();
        for (name, words) in &self.macros {
            flow.add(name, words.iter().copied().filter(|word| is_name(word)));
        }
        let (mut depth, mut body_of, mut after_for) = (0usize, None, false);
        for (start, end) in statements(&self.words) {
            let words = &self.words[start..end];
            let names = || words.iter().copied().filter(|word| is_name(word));
            if depth == 0 {
                body_of = words.iter().position(|word| *word == "(").filter(|at| *at > 0).map(|at| words[at - 1]);
            } else if let Some(function) = body_of {
                flow.add(function, names());
            }
            for at in (0..words.len()).filter(|at| assigns(words[*at])) {
                for target in written(&words[..at]) {
                    flow.add(target, names());
                }
            }
            let calls = words.windows(2).filter(|pair| is_name(pair[0]) && pair[1] == "(");
            for word in calls.flat_map(|pair| self.called(pair[0])) {
                let function = self.functions.get(word);
                for parameter in function.into_iter().flat_map(|f| &f.parameters) {
                    flow.add(parameter, names());
                }
                if WRITING.contains(&word) || function.is_some_and(|f| f.writes_arguments) {
                    names().filter(|name| !self.functions.contains_key(name)).for_each(|name| flow.add(name, names()));
                }
            }
            let controls = names().any(|name| matches!(name, "for" | "if" | "switch" | "while"));
            // The condition of a loop comes behind the first semicolon of `for`.
            if controls || after_for {
                flow.conditions.extend(names());
            }
            after_for = names().any(|name| name == "for");
            match self.words.get(end) {
                Some(&"{") => depth += 1,
                Some(&"}") => depth = depth.saturating_sub(1),
                _ => {}
            }
        }
        flow
    }
}

/// From each name to those that may flow into it.
#[derive(Default)]
struct Flow<'a> {
    into: HashMap<&'a str, HashSet<&'a str>>,
    conditions: HashSet<&'a str>,
}

impl<'a> Flow<'a> {
    fn add(&mut self, target: &'a str, sources: impl Iterator<Item = &'a str>) {
        self.into.entry(target).or_default().extend(sources);
    }

    /// All that flows into a position.
    fn reached(&self) -> HashSet<&'a str> {
        let mut found: HashSet<&'a str> =
            ["gl_Position", "gl_out"].into_iter().chain(self.conditions.iter().copied()).collect();
        let mut open: Vec<&'a str> = found.iter().copied().collect();
        while let Some(name) = open.pop() {
            for source in self.into.get(name).into_iter().flatten() {
                if found.insert(source) {
                    open.push(source);
                }
            }
        }
        found
    }
}

fn assigns(word: &str) -> bool {
    word.ends_with('=') && !matches!(word, "==" | "!=" | "<=" | ">=")
}

/// The names of the variable, and of its members, that ends `words`: `a[i].b` is `a` and `b`.
fn written<'a>(words: &[&'a str]) -> Vec<&'a str> {
    let mut names = Vec::new();
    let mut at = words.len();
    while at > 0 {
        at -= 1;
        match words[at] {
            closing @ ("]" | ")") => {
                let opening = if closing == "]" { "[" } else { "(" };
                let mut depth = 1;
                while at > 0 && depth > 0 {
                    at -= 1;
                    depth += i32::from(words[at] == closing) - i32::from(words[at] == opening);
                }
            }
            word if is_name(word) => {
                names.push(word);
                if at == 0 || words[at - 1] != "." {
                    break;
                }
                at -= 1;
            }
            _ => break,
        }
    }
    names
}

/// Where statements begin and end: at semicolons and braces, which belong to none.
fn statements<'w>(words: &'w [&str]) -> impl Iterator<Item = (usize, usize)> + 'w {
    let mut start = 0;
    std::iter::from_fn(move || {
        let rest = words.get(start..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|word| matches!(*word, ";" | "{" | "}")).unwrap_or(rest.len());
        let statement = (start, start + length);
        start += length + 1;
        Some(statement)
    })
}

#[cfg(test)]
mod tests {
    use super::{of_stage, with_all_of};
    use crate::intercept::gl::state::shader::position_names::Choice;
    use crate::intercept::lens::Order;

    fn flows(text: &str, name: &str) -> bool {
        of_stage([text]).expect("understood").contain(name)
    }

    #[test]
    fn matrices_of_the_position_flow_into_it() {
        for text in [
            "uniform mat4 m; in vec4 p; void main() { gl_Position = m * p; }",
            "uniform mat4 m; in vec4 p; void main() { vec4 a; a = m * p; vec4 b = a; gl_Position.xyz = b.xyz; }",
            "uniform B { mat4 m; } b; in vec4 p; void main() { gl_Position = b.m * p; }",
            "uniform mat4 m[2]; in vec4 p; vec4 f(vec4 v) { return m[1] * v; } void main() { gl_Position = f(p); }",
            "uniform mat4 m; in vec4 p; void f(vec4 v) { gl_Position = v; } void main() { f(m * p); }",
            "uniform mat4 m; in vec4 p; void f(out vec4 v) { v = m * p; } void main() { vec4 a; f(a); gl_Position = a; }",
            "#define M m\nuniform mat4 m; in vec4 p; void main() { gl_Position = M * p; }",
            "#define F(x) g(x)\nuniform mat4 m; in vec4 p; void g(vec4 v) { gl_Position = v; }\nvoid main() { F(m * p); }",
            "#ifdef A\n#else\nuniform mat4 m;\n#endif\nin vec4 p; void main() {\n#if 1\ngl_Position = m * p;\n#endif\n}",
            "uniform mat4 m; in vec4 p; void main() { float w = 0.0; if (m[0][0] > 1.0) { w = 1.0; } gl_Position = p * w; }",
            "uniform mat4 m; in vec4 p; void main() { vec4 a[2]; for (int i = 0; i < int(m[0][0]); i++) a[i] = p; gl_Position = a[0]; }",
            "uniform mat4 m; in vec4 p; struct S { vec4 q; } s; void main() { s.q = m * p; gl_Position = s.q; }",
            "uniform mat4 m; in vec4 p; void main() { float a, b = m[0][0]; modf(b, a); gl_Position = p * a; }",
            "uniform mat4 m; in vec4 p; vec4 g; void f() { g = m * p; } void main() { f(); gl_Position = g; }",
        ] {
            assert!(flows(text, "B.m[0]"), "{text}");
        }
    }

    #[test]
    fn other_matrices_do_not() {
        for text in [
            "uniform mat4 m; in vec2 p; void main() { gl_Position = vec4(p, 0.0, 1.0); }",
            "layout(std140) uniform B { mat4 m; mat4 n; }; in vec2 p; out vec4 v;\nvoid main() { vec4 a = m * n * vec4(p, 0, 1); v = a; gl_Position = vec4(p, 0., 1.); }",
            "uniform mat4 m; in vec2 p; out vec4 v; vec4 f(vec4 q) { return m * q; } void main() { v = f(vec4(p, 0, 1)); gl_Position = vec4(p, 0, 1); }",
            "uniform mat4 m; out vec2 v; void main() { v = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2); gl_Position = vec4(v * 2.0 - 1.0, 0.0, 1.0); }",
        ] {
            assert!(!flows(text, "m"), "{text}");
        }
    }

    /// `uniform vec4 m[…]` and a body; the groups of four that flow into the position.
    fn fours(declared: &str, body: &str) -> Vec<(u32, Order)> {
        let text = format!("{declared}\nin vec4 v; in vec3 n; out vec3 s;\nvoid main() {{ {body} }}");
        let names = of_stage([&*text]).expect("understood");
        assert!(names.contain("m[0]"), "{text}");
        names.elements("m[0]").expect("an array").fours().collect()
    }

    #[test]
    fn four_vectors_are_columns_or_rows_by_their_use() {
        let sum = "vec4 t = v.yyyy * m[1]; t = m[0] * v.xxxx + t; t = m[2]*v.zzzz + t; gl_Position = t + m[3];";
        assert_eq!(fours("uniform vec4 m[4];", sum), [(0, Order::Columns)]);
        let products = "gl_Position.x = dot(m[5], v); gl_Position.y = dot(v, m[6].xyzw); gl_Position.zw = vec2(dot((m[7]), v), dot(v, m [ 8 ]));";
        assert_eq!(fours("uniform highp vec4 m[32];", products), [(5, Order::Rows)]);
        let lit = format!("s = vec3(dot(m[20], v), m[21].x, m[22].x) * m[23].xyz; {products}");
        assert_eq!(
            fours("layout(std140) uniform B { vec4 t; vec4 m[32]; };", &lit),
            [(5, Order::Rows)],
            "other elements"
        );
        let built = "gl_Position = mat4(m[0], m[1], m[2], m[3]) * v;";
        assert_eq!(fours("uniform vec4[4] m;", built), [(0, Order::Either)]);
        let both = format!("{sum} gl_Position.x += dot(m[3], v);");
        assert_eq!(fours("uniform vec4 m[4];", &both), [(0, Order::Either)]);
        let defined = "#define a m[2]\n#define b m[3]\n#define c (m[4])\n#define d m[5]\nuniform vec4 m[8];";
        let products = "gl_Position = vec4(dot(a, v), dot(b, v), dot(c, v), dot(d, v));";
        assert_eq!(fours(defined, products), [(2, Order::Rows)]);
    }

    #[test]
    fn elements_that_are_chosen_by_a_variable_are_known_by_its_name() {
        let others = |body: &str| {
            let text = format!("uniform mat4 m[4]; uniform int i; in vec4 v; void main() {{ {body} }}");
            let names = of_stage([&*text]).expect("understood");
            names.elements("m[0]").expect("an array").others.clone().map(|(choice, _)| choice)
        };
        let by_uniform = Some(Choice::ByUniform("i".to_owned()));
        assert_eq!(others("gl_Position = m[i] * v;"), by_uniform);
        assert_eq!(others("gl_Position = m[2] * v;"), None);
        assert_eq!(others("vec4 w = m[i] * v; gl_Position = m[1] * w;"), by_uniform);
        for unknown in [
            "gl_Position = m[i + 1] * v;",
            "int i = gl_VertexID; gl_Position = m[i] * v;",
            "gl_Position = m[i] * m[gl_VertexID] * v;",
            "mat4 all[4] = m; gl_Position = all[1] * v;",
        ] {
            assert_eq!(others(unknown), Some(Choice::Unknown), "{unknown}");
        }
    }

    #[test]
    fn of_an_array_of_structures_only_the_elements_that_are_named_flow() {
        let text =
            "struct S { vec4 e; mat4 m; }; uniform S all[4]; in vec4 v; void main() { gl_Position = all[2].m * v; }";
        assert_eq!([1, 2].map(|number| flows(text, &format!("all[{number}].m"))), [false, true]);
        let text = text.replace("all[2]", "all[gl_InstanceID]");
        assert_eq!([1, 2].map(|number| flows(&text, &format!("all[{number}].m"))), [true, true]);
    }

    #[test]
    fn what_is_not_understood_flows() {
        for text in [
            "#include <matrices>\nvoid main() { gl_Position = place(); }",
            "#define SET gl_Position = m * p\nuniform mat4 m; in vec4 p; void main() { SET; }",
            "uniform mat4 é; void main() {}",
        ] {
            assert_eq!(of_stage([text]), None, "{text}");
        }
    }

    #[test]
    fn a_stage_before_counts_as_a_whole() {
        let last = "layout(triangles) in; void main() { gl_Position = gl_in[0].gl_Position; EmitVertex(); }";
        let names = of_stage([last]).and_then(|names| with_all_of(names, "uniform mat4 m; void main() {}"));
        assert!(names.expect("understood").contain("m"));
    }
}
