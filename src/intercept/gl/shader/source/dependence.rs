//! Names that flow into `gl_Position`. Only a matrix among them can be the lens.
//!
//! Engines give every shader a block with all matrices of the camera, even the shaders of a
//! full-screen pass, which is no scene. So the names that may flow into the position are collected
//! from the text. In all cases of doubt a name is included:
//!
//! - All branches of conditional compilation count.
//! - Variables with the same name are one variable.
//! - All words of a statement flow into each variable that it writes.
//! - All words of a function's body flow into its value.
//! - All conditions flow into every variable.

use crate::backend::gl::driver::api;
use crate::intercept::gl::shader::source::elements::{self, Usage};
use crate::intercept::gl::shader::source::text::brackets::behind;
use crate::intercept::gl::shader::source::text::tokens::{self, is_name};
use crate::intercept::gl::state::shader::position_names::PositionNames;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Functions of the language that write to their arguments.
const WRITING: [&str; 6] = ["frexp", "imulExtended", "modf", "uaddCarry", "umulExtended", "usubBorrow"];

/// Stages before rasterisation, the last one first.
const GEOMETRY_STAGES: [u32; 4] =
    [api::GL_GEOMETRY_SHADER, api::GL_TESS_EVALUATION_SHADER, api::GL_TESS_CONTROL_SHADER, api::GL_VERTEX_SHADER];

/// Returns the names that flow into the position of these shaders: in the last stage by its text,
/// in the stages before it all names. `None`: not known.
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

/// Returns the names of a stage with these `texts`, one for each shader. `None`: a text is not
/// understood, and any name may flow into the position.
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

/// Returns `names` and every name in `text`, a stage before the others.
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
    /// Words of each macro, with its parameters.
    macros: HashMap<&'a str, Vec<&'a str>>,
    /// Uniforms that are arrays.
    arrays: HashSet<&'a str>,
    functions: HashMap<&'a str, Function<'a>>,
}

impl<'a> Text<'a> {
    /// Reads a directive. `None`: it may add names or statements that Cupola does not see.
    fn directive(&mut self, text: &'a str) -> Option<()> {
        if let Some(rest) = text.strip_prefix("define") {
            let mut words = Vec::new();
            tokens::words(rest, &mut words);
            let hides = |word: &&str| assigns(word) || matches!(*word, "{" | "}" | ";" | "#");
            let (name, words) = words.split_first()?;
            if without_layouts(words).iter().any(hides) {
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

    /// Returns the words that a call of `word` may mean: the word itself, and the words of macros.
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
            // The condition of a loop follows the first semicolon of `for`.
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

/// Returns the words outside `layout(…)`, where `=` is no assignment.
fn without_layouts<'a>(words: &[&'a str]) -> Vec<&'a str> {
    let (mut found, mut at) = (Vec::new(), 0);
    while let Some(word) = words.get(at) {
        let end = if *word == "layout" { behind(words, at + 1) } else { None };
        if end.is_none() {
            found.push(*word);
        }
        at = end.unwrap_or(at + 1);
    }
    found
}

/// For each name the names that may flow into it.
#[derive(Default)]
struct Flow<'a> {
    into: HashMap<&'a str, HashSet<&'a str>>,
    conditions: HashSet<&'a str>,
}

impl<'a> Flow<'a> {
    fn add(&mut self, target: &'a str, sources: impl Iterator<Item = &'a str>) {
        self.into.entry(target).or_default().extend(sources);
    }

    /// Returns all names that flow into a position.
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

/// Returns the names of the variable at the end of `words`, and of its members: for `a[i].b` the
/// names `a` and `b`.
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

/// Returns the start and end of each statement. Semicolons and braces separate statements and are
/// part of none.
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
mod tests;
