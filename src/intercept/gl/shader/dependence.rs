//! What flows into `gl_Position`: only a matrix among it can be the lens.
//!
//! Engines give every shader a block with all matrices of the camera, also those of a full-screen pass, and such a pass
//! is no scene. The names that may flow into the position are collected from the text, with everything that is in
//! doubt: all branches of conditional compilation, variables of one name as one variable, all words of a statement into
//! each variable that it writes, all words of a function's body into its value, and all conditions into every variable.

use crate::backend::gl::driver::api;
use crate::intercept::gl::shader::prover::tokens::{self, is_name};
use crate::intercept::gl::state::shader::uniforms::PositionNames;
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
    text.functions();
    Some(PositionNames::new(text.flow().reached()))
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
    macros: HashMap<&'a str, Vec<&'a str>>,
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
            self.macros.entry(name).or_default().extend(words.iter().filter(|word| is_name(word)));
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

    /// What a word may call: itself, and what macros make of it.
    fn called(&self, word: &'a str) -> Vec<&'a str> {
        let mut found = vec![word];
        let mut next = 0;
        while let Some(word) = found.get(next) {
            for inner in self.macros.get(word).into_iter().flatten() {
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
            flow.add(name, words.iter().copied());
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
    fn reached(&self) -> HashSet<String> {
        let mut found: HashSet<&str> =
            ["gl_Position", "gl_out"].into_iter().chain(self.conditions.iter().copied()).collect();
        let mut open: Vec<&str> = found.iter().copied().collect();
        while let Some(name) = open.pop() {
            for source in self.into.get(name).into_iter().flatten() {
                if found.insert(source) {
                    open.push(source);
                }
            }
        }
        found.into_iter().map(str::to_owned).collect()
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
