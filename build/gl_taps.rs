//! The calls of OpenGL that may change a picture, each with what it may change.

use super::gl_arrays;
use super::gl_attributes::{self, Declaration};
use std::fmt::Write;

#[path = "../src/intercept/gl/unchanged/calls.rs"]
#[allow(dead_code)]
mod calls;

/// One invocation of the macro `taps`: how many there are, and for each its name, a name for our function, its number, its
/// parameters, what it answers, its kind, and the arguments that count. `commands` are all of the registry, with what they answer.
pub fn generate(commands: &[(Declaration, String)]) -> String {
    let mut rows = String::new();
    let mut count = 0;
    for (Declaration { name, method, parameters }, answer) in commands {
        let points: Vec<bool> = parameters.iter().map(|(_, kind)| kind.starts_with('*')).collect();
        let kind = calls::kind(name, &points);
        // Attributes and arrays all have hooks.
        if kind == calls::Kind::Nothing || gl_attributes::is_attribute(name) || gl_arrays::is_array_state(name) {
            continue;
        }
        let typed = parameters.iter().map(|(name, kind)| format!("{name}: {kind}")).collect::<Vec<_>>().join(", ");
        let counts = !matches!(kind, calls::Kind::Change | calls::Kind::Never | calls::Kind::Pixels);
        let noted = parameters.iter().filter(|_| counts).map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
        writeln!(rows, "    {name:?} tap_{method} {count}({typed}) -> {answer} = Kind::{kind:?}, [{noted}];")
            .expect("writing to a String");
        count += 1;
    }
    format!("taps! {{\n    {count}\n{rows}}}\n")
}
