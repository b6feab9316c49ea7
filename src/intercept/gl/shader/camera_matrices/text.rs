//! Text of a stage with a choice at each use of a 4×4 matrix: the program's matrix or one of
//! Cupola.
//!
//! A matrix `m` becomes `(chosen[i]>0.5?matrices[i]:m)`. The program's own uniform remains active,
//! so all answers to the program stay the same.

use crate::intercept::gl::shader::source::head::Head;
use crate::intercept::gl::shader::source::text::brackets::behind;
use crate::intercept::gl::shader::source::text::tokens::{self, is_name};
use crate::intercept::gl::state::shader::camera_matrices::Names;
use std::collections::HashMap;

/// Greatest number of matrices of a stage that are followed.
const MOST: usize = 8;

/// Words that may stand before a use. If another name stands there, it is a type, and the word is a
/// variable that the text declares.
const BEFORE: [&str; 2] = ["return", "else"];

/// Matrix of the program for which a text has a choice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    /// Name of the matrix in OpenGL.
    pub name: String,
    /// True if the text computes its inverse.
    pub inverted: bool,
}

/// Spelling of a matrix in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Spelling<'a> {
    /// Instance of a block, or a structure.
    instance: Option<&'a str>,
    name: &'a str,
}

/// Returns `source` with its choices, and the matrices, in the order of Cupola's arrays. `None`:
/// the text uses no matrix that can be replaced. `wanted` returns whether the matrix with this name
/// is to be replaced.
pub fn with_choices(
    source: &str,
    es_context: bool,
    names: Names,
    wanted: impl Fn(&str) -> bool,
) -> Option<(String, Vec<Named>)> {
    let bare = tokens::bare(source);
    // Continued lines and names made by macros are not understood.
    if !source.contains("mat4") || !bare.is_ascii() || bare.contains('\\') || bare.contains("##") {
        return None;
    }
    let head = Head::of(source, &bare, es_context)?;
    let (words, defined) = words_and_definitions(&bare);
    let mut found = Declared::default();
    found.read(&words);
    let mut matrices: Vec<(Spelling<'_>, String)> = std::mem::take(&mut found.matrices).into_iter().collect();
    matrices.retain(|(spelling, _)| wanted(spelling.name) && !found.hidden(spelling, &words));
    matrices.sort_by(|a, b| a.1.cmp(&b.1));
    let place = |word: &str| word.as_ptr() as usize - bare.as_ptr() as usize;
    let mut uses: Vec<(usize, usize, usize)> = Vec::new();
    let mut used: Vec<Named> = Vec::new();
    for (spelling, name) in matrices {
        let of_words = spelling.uses(&words).filter(|at| !found.declarations.iter().any(|range| range.contains(at)));
        let of_words = of_words.map(|at| (&words, at));
        let all: Vec<_> = of_words.chain(spelling.uses(&defined).map(|at| (&defined, at))).collect();
        if all.is_empty() || used.len() == MOST {
            continue;
        }
        let inverted = all.iter().any(|(list, at)| is_inverted(list, *at));
        for (list, at) in all {
            let last = list[at + spelling.length() - 1];
            uses.push((place(list[at]), place(last) + last.len(), used.len()));
        }
        used.push(Named { name, inverted });
    }
    uses.sort_unstable();
    if uses.first().is_none_or(|(start, ..)| *start < head.length()) {
        return None;
    }
    let mut text = String::new();
    let mut end = head.length();
    for (start, behind, number) in uses {
        let own = &source[start..behind];
        text.push_str(&source[end..start]);
        text.push_str(&format!("({}[{number}]>0.5?{}[{number}]:{own})", names.chosen, names.matrices));
        end = behind;
    }
    text.push_str(&source[end..]);
    let count = used.len();
    let declarations = head.uniform("mat4", &format!("{}[{count}]", names.matrices), None)
        + &head.uniform("float", &format!("{}[{count}]", names.chosen), None);
    Some((head.declaring(&declarations, &text), used))
}

/// Returns the words of a text, and separately the words of its macros.
fn words_and_definitions(bare: &str) -> (Vec<&str>, Vec<&str>) {
    let (mut words, mut defined) = (Vec::new(), Vec::new());
    for line in bare.lines() {
        match line.trim_start().strip_prefix('#').map(str::trim_start) {
            Some(directive) => {
                let body = directive.strip_prefix("define").unwrap_or_default();
                tokens::words(body, &mut defined);
                defined.push(";");
            }
            None => tokens::words(line, &mut words),
        }
    }
    (words, defined)
}

impl<'a> Spelling<'a> {
    /// Number of words.
    fn length(&self) -> usize {
        if self.instance.is_some() { 3 } else { 1 }
    }

    /// Returns the places at which the words use the matrix.
    fn uses<'w>(&self, words: &'w [&'a str]) -> impl Iterator<Item = usize> + use<'w, 'a> {
        let Self { instance, name } = *self;
        (0..words.len()).filter(move |at| {
            let member = *at > 0 && words[at - 1] == ".";
            !member
                && match instance {
                    None => words[*at] == name,
                    Some(instance) => words[*at] == instance && words.get(at + 1..at + 3) == Some(&[".", name]),
                }
        })
    }
}

/// Declarations in a text.
#[derive(Default)]
struct Declared<'a> {
    /// Matrices that the program sets: spelling in the text, and name in OpenGL.
    matrices: HashMap<Spelling<'a>, String>,
    /// Members of structures that are matrices.
    structures: HashMap<&'a str, Vec<&'a str>>,
    /// Ranges of words that declare the matrices.
    declarations: Vec<std::ops::Range<usize>>,
}

impl<'a> Declared<'a> {
    fn read(&mut self, words: &[&'a str]) {
        let mut start = 0;
        while start < words.len() {
            let end = words[start..].iter().position(|word| matches!(*word, ";" | "{")).map(|length| start + length);
            let Some(end) = end else { return };
            let behind_braces = if words[end] == "{" { behind(words, end) } else { None };
            let statement = &words[start..end];
            let next = match behind_braces {
                None if words[end] == "{" => return,
                None => {
                    self.variables(start, end, words);
                    end + 1
                }
                Some(closed) if statement.contains(&"struct") => {
                    let name = statement.last().copied().unwrap_or_default();
                    self.structures.insert(name, members(&words[end + 1..closed - 1]));
                    // Variables that follow in this statement are ignored.
                    closed + words[closed..].iter().position(|word| *word == ";").map_or(0, |length| length + 1)
                }
                Some(closed) if statement.contains(&"uniform") => {
                    let behind = words[closed..].iter().position(|word| *word == ";").map_or(closed, |n| closed + n);
                    let instance = words[closed..behind].first().copied();
                    let block = statement.last().copied().unwrap_or_default();
                    // Arrays of blocks are ignored.
                    if behind - closed <= 1 {
                        for name in members(&words[end + 1..closed - 1]) {
                            let called = if instance.is_some() { format!("{block}.{name}") } else { name.to_owned() };
                            self.matrices.insert(Spelling { instance, name }, called);
                        }
                    }
                    self.declarations.push(start..behind);
                    behind + 1
                }
                // A function.
                Some(closed) => closed,
            };
            start = next;
        }
    }

    /// Reads a statement outside of functions and blocks.
    fn variables(&mut self, start: usize, end: usize, words: &[&'a str]) {
        let statement = &words[start..end];
        let Some(uniform) = statement.iter().position(|word| *word == "uniform") else { return };
        let is_type = |word: &&str| is_matrix(word) || self.structures.contains_key(*word);
        let Some(kind) = statement.iter().skip(uniform).position(is_type).map(|at| uniform + at) else { return };
        for variable in statement[kind + 1..].split(|word| *word == ",") {
            let &[name] = variable else { continue };
            if is_matrix(statement[kind]) {
                self.matrices.insert(Spelling { instance: None, name }, name.to_owned());
            }
            for member in self.structures.get(statement[kind]).into_iter().flatten() {
                self.matrices.insert(Spelling { instance: Some(name), name: member }, format!("{name}.{member}"));
            }
        }
        self.declarations.push(start..end);
    }

    /// True if the text declares another variable with the same name.
    fn hidden(&self, spelling: &Spelling<'a>, words: &[&'a str]) -> bool {
        let name = spelling.instance.unwrap_or(spelling.name);
        (1..words.len()).any(|at| {
            words[at] == name
                && (is_name(words[at - 1]) && !BEFORE.contains(&words[at - 1]))
                && !self.declarations.iter().any(|range| range.contains(&at))
        })
    }
}

/// True if the word at `at` is part of an argument of `inverse`.
fn is_inverted(words: &[&str], at: usize) -> bool {
    let mut closed = 0;
    for place in (1..at).rev() {
        match words[place] {
            ";" | "{" | "}" => return false,
            ")" => closed += 1,
            "(" if closed > 0 => closed -= 1,
            "(" if words[place - 1] == "inverse" => return true,
            _ => {}
        }
    }
    false
}

fn is_matrix(word: &str) -> bool {
    matches!(word, "mat4" | "mat4x4")
}

/// Names of the matrices among the members of a block or a structure.
fn members<'a>(words: &[&'a str]) -> Vec<&'a str> {
    let mut found = Vec::new();
    for statement in words.split(|word| *word == ";") {
        let Some(kind) = statement.iter().position(|word| is_matrix(word)) else { continue };
        let variables = statement[kind + 1..].split(|word| *word == ",");
        found.extend(variables.filter_map(|variable| match variable {
            [name] => Some(*name),
            _ => None,
        }));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{Named, with_choices};
    use crate::intercept::gl::state::shader::camera_matrices::Names;

    const NAMES: Names = Names { matrices: "ours", chosen: "on" };

    fn rewritten(source: &str) -> (String, Vec<String>) {
        let (text, matrices) = with_choices(source, false, NAMES, |_| true).expect("a matrix");
        (text, matrices.into_iter().map(|matrix| matrix.name).collect())
    }

    #[test]
    fn what_is_inverted_is_told() {
        let source = "uniform mat4 a, b, c;\nvoid main() { gl_FragColor = inverse(f(a) * b) * c[0]; }\n";
        let (_, matrices) = with_choices(source, false, NAMES, |_| true).expect("matrices");
        let named = |name: &str, inverted| Named { name: name.to_owned(), inverted };
        assert_eq!(matrices, [named("a", true), named("b", true), named("c", false)]);
    }

    #[test]
    fn each_use_becomes_a_choice_and_lines_stay() {
        let source =
            "#version 330\nuniform mat4 a, b; // a\nout vec4 c;\nvoid main() { c = b * (a * vec4(1)) + s.a; }\n";
        let (text, names) = rewritten(source);
        assert_eq!(names, ["a", "b"]);
        let expected = "#version 330\nuniform mat4 ours[2];\nuniform float on[2];\n#line 2\nuniform mat4 a, b; // a\n\
                        out vec4 c;\nvoid main() { c = (on[1]>0.5?ours[1]:b) * ((on[0]>0.5?ours[0]:a) * vec4(1)) + s.a; }\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn members_of_blocks_and_structures_have_their_names() {
        let source = "#version 330\nlayout(std140) uniform B { vec4 v; layout(row_major) mat4 m; } b;\n\
                      uniform C { mat4 n; };\nstruct S { mat4 o; float p; };\nuniform S s;\n\
                      #define O s.o\nvoid main() { gl_FragColor = b.m * n * O * b.v; }\n";
        let (text, names) = rewritten(source);
        assert_eq!(names, ["B.m", "n", "s.o"]);
        assert!(text.contains("#define O (on[2]>0.5?ours[2]:s.o)\n"), "{text}");
        assert!(text.contains("= (on[0]>0.5?ours[0]:b.m) * (on[1]>0.5?ours[1]:n) * O * b.v"), "{text}");
    }

    #[test]
    fn names_that_mean_something_else_somewhere_stay() {
        for source in [
            "uniform mat4 m;\nvec4 f(mat4 m) { return m[0]; }\nvoid main() { gl_FragColor = f(mat4(1)); }\n",
            "uniform mat4 m[3];\nvoid main() { gl_FragColor = m[0][0]; }\n",
            "uniform mat4 m;\nvoid main() { }\n",
            "mat4 m;\nvoid main() { gl_FragColor = m[0]; }\n",
            "#define A \\\n mat4 m;\nuniform mat4 m;\nvoid main() { gl_FragColor = m[0]; }\n",
        ] {
            assert_eq!(with_choices(source, false, NAMES, |_| true), None, "{source}");
        }
        let used = "uniform mat4 m;\nvoid main() { gl_FragColor = m[0]; }\n";
        assert_eq!(with_choices(used, false, NAMES, |name| name != "m"), None);
        assert!(with_choices(used, false, NAMES, |_| true).is_some());
    }
}
