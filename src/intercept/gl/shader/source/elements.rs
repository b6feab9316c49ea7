//! Elements of arrays of uniforms. A word like `m[2]` is one name, so the flow from different
//! elements is distinguished.

use crate::intercept::gl::shader::source::text::brackets::behind;
use crate::intercept::gl::shader::source::text::tokens::is_name;
use crate::intercept::gl::state::shader::position_names::{Choice, Elements, Uses};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;

/// Number of words of an element: `m [ 2 ]`.
const WORDS: usize = 4;

/// Names of uniforms, and of members of uniform and storage blocks, that are arrays.
pub fn arrays<'a>(words: &[&'a str]) -> HashSet<&'a str> {
    let mut found = HashSet::new();
    let (mut depth, mut in_block, mut start) = (0usize, false, 0);
    for (end, word) in words.iter().enumerate() {
        if !matches!(*word, ";" | "{" | "}") {
            continue;
        }
        let statement = &words[start..end];
        let uniform = depth == 0 && statement.iter().any(|word| matches!(*word, "uniform" | "buffer"));
        if *word == ";" && (uniform || (in_block && depth == 1)) {
            let beside = |pair: &&[&'a str]| pair[1] == "[" && is_name(pair[0]);
            found.extend(statement.windows(2).filter(beside).map(|pair| pair[0]));
            // Type with brackets: `vec4[4] m`.
            let behind = |pair: &&[&'a str]| pair[0] == "]" && is_name(pair[1]);
            found.extend(statement.windows(2).filter(behind).map(|pair| pair[1]));
        }
        match *word {
            "{" => {
                in_block |= uniform;
                depth += 1;
            }
            "}" => {
                depth = depth.saturating_sub(1);
                in_block &= depth > 0;
            }
            _ => {}
        }
        start = end + 1;
    }
    found
}

/// Returns the ranges of words of all function bodies.
fn bodies(words: &[&str]) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let (mut depth, mut start, mut body) = (0usize, 0, None);
    for (at, word) in words.iter().enumerate() {
        match *word {
            "{" => {
                // A function has a name and parentheses. `layout(…)` begins with its parentheses.
                let function = words[start..at].iter().position(|word| *word == "(").is_some_and(|open| open > 1);
                if depth == 0 && function {
                    body = Some(at + 1);
                }
                depth += 1;
            }
            "}" => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    found.extend(body.take().map(|body| body..at));
                }
            }
            ";" => {}
            _ => continue,
        }
        start = at + 1;
    }
    found
}

/// Returns `words`, which are parts of `text`. In functions each element of one of the `arrays`
/// becomes one word.
pub fn joined_in_bodies<'a>(text: &'a str, words: &[&'a str], arrays: &HashSet<&str>) -> Vec<&'a str> {
    let mut found = Vec::with_capacity(words.len());
    let mut copied = 0;
    for body in bodies(words) {
        found.extend_from_slice(&words[copied..body.start]);
        copied = body.end;
        found.extend(joined(text, &words[body], arrays));
    }
    found.extend_from_slice(&words[copied..]);
    found
}

/// Returns `words`, which are parts of `text`. Each element of one of the `arrays` becomes one
/// word.
pub fn joined<'a>(text: &'a str, words: &[&'a str], arrays: &HashSet<&str>) -> Vec<&'a str> {
    let mut found = Vec::with_capacity(words.len());
    let mut at = 0;
    while at < words.len() {
        let element = words.get(at..at + WORDS).filter(|element| {
            arrays.contains(element[0]) && element[1] == "[" && number(element[2]).is_some() && element[3] == "]"
        });
        let whole = element.and_then(|element| {
            let place = |word: &str| word.as_ptr() as usize - text.as_ptr() as usize;
            text.get(place(element[0])..=place(element[3]))
        });
        found.push(whole.unwrap_or(words[at]));
        at += if whole.is_some() { WORDS } else { 1 };
    }
    found
}

/// Returns the array and the number of an element that is one word.
pub fn parts(word: &str) -> Option<(&str, u32)> {
    let (array, number_and_bracket) = word.split_once('[')?;
    Some((array.trim(), number(number_and_bracket.strip_suffix(']')?.trim())?))
}

fn number(word: &str) -> Option<u32> {
    word.trim_end_matches(['u', 'U']).parse().ok()
}

/// Uses of the elements of arrays in a text.
#[derive(Default)]
pub struct Usage<'a> {
    /// Uses of elements, and of arrays whose elements are chosen in other ways.
    uses: HashMap<&'a str, Uses>,
    /// Name between the brackets; `None`: more than a name.
    indices: HashMap<&'a str, Option<&'a str>>,
}

impl<'a> Usage<'a> {
    /// Reads the words of a text. `stands_for` returns the element that a macro means.
    pub fn new(words: &[&'a str], arrays: &HashSet<&str>, stands_for: impl Fn(&'a str) -> Option<&'a str>) -> Self {
        let mut usage = Self::default();
        for at in bodies(words).into_iter().flatten() {
            let word = words[at];
            let word = stands_for(word).unwrap_or(word);
            let is_array = arrays.contains(word);
            let mut after = at + 1;
            if is_array {
                let index = match words.get(at + 1..at + WORDS) {
                    Some(["[", index, "]"]) if is_name(index) => Some(*index),
                    _ => None,
                };
                after = behind(words, after).unwrap_or(after);
                usage
                    .indices
                    .entry(word)
                    .and_modify(|known| *known = known.filter(|_| *known == index))
                    .or_insert(index);
            }
            if is_array || parts(word).is_some() {
                let uses = usage.uses.entry(word).or_default();
                *uses = uses.and(uses_at(words, at, after));
            }
        }
        usage
    }

    /// Returns the known elements among the names `reached`. `is_uniform`: true if the text does
    /// not write to the name.
    pub fn elements(
        &self,
        arrays: &HashSet<&str>,
        reached: &HashSet<&str>,
        is_uniform: impl Fn(&str) -> bool,
    ) -> HashMap<String, Elements> {
        let uses = |name: &str| self.uses.get(name).copied().unwrap_or_default();
        let mut found: HashMap<String, Elements> = HashMap::new();
        for name in reached {
            if let Some((array, number)) = parts(name) {
                let numbers: &mut BTreeMap<u32, Uses> = &mut found.entry(array.to_owned()).or_default().numbers;
                let known = numbers.entry(number).or_default();
                *known = known.and(uses(name));
            } else if arrays.contains(name) {
                let index = self.indices.get(name).copied().flatten().filter(|index| is_uniform(index));
                let choice = index.map_or(Choice::Unknown, |index| Choice::ByUniform(index.to_owned()));
                found.entry((*name).to_owned()).or_default().others = Some((choice, uses(name)));
            }
        }
        found
    }
}

/// Returns the uses of the vector whose first word is at `at` and that ends before `after`.
fn uses_at(words: &[&str], at: usize, after: usize) -> Uses {
    let swizzle = words.get(after).filter(|word| **word == ".").and_then(|_| words.get(after + 1));
    let after = if swizzle.is_some() { after + 2 } else { after };
    if swizzle.is_some_and(|swizzle| swizzle.len() < 2) {
        return Uses::default();
    }
    let before = at.checked_sub(1).and_then(|before| words.get(before));
    let products = called(words, at) == Some("dot");
    let factors =
        !products && (before == Some(&"*") || words.get(after).is_some_and(|word| matches!(*word, "*" | "*=")));
    Uses { products, factors }
}

/// Returns the function that has the word at `at` in its arguments.
fn called<'a>(words: &[&'a str], at: usize) -> Option<&'a str> {
    let mut depth = 0;
    for place in (0..at).rev() {
        match words[place] {
            ";" | "{" | "}" => return None,
            ")" => depth += 1,
            "(" if depth > 0 => depth -= 1,
            "(" => {
                let name = words.get(place.checked_sub(1)?)?;
                if is_name(name) {
                    return Some(name);
                }
            }
            _ => {}
        }
    }
    None
}
