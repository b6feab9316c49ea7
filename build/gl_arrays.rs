//! The commands that change vertex arrays, found by their names in the registry, so that none is
//! missed.

use super::gl_attributes::{self, Declaration};
use std::fmt::Write;

/// Beginnings of their names, without `gl`.
const BEGINNINGS: [&str; 17] = [
    "BindVertexArray",
    "BindVertexBuffer",
    "ClientAttribDefault",
    "DeleteVertexArrays",
    "DisableClientState",
    "DisableVertexA",
    "EnableClientState",
    "EnableVertexA",
    "InterleavedArrays",
    "PopClientAttrib",
    "PushClientAttrib",
    "VertexArray",
    "VertexAttrib",
    "VertexBindingDivisor",
    "VertexFormat",
    "VertexPointer",
    "VertexBuffer",
];

/// Commands whose arguments give the state after the call. The file
/// `src/intercept/gl/vertex_input/vertex_array_commands.rs` has a hook for each.
const NOTED: [&str; 14] = [
    "glBindVertexArray",
    "glBindVertexArrayAPPLE",
    "glBindVertexBuffer",
    "glDeleteVertexArrays",
    "glDisableClientState",
    "glDisableVertexAttribArray",
    "glEnableClientState",
    "glEnableVertexAttribArray",
    "glInterleavedArrays",
    "glPopClientAttrib",
    "glVertexArrayVertexBuffer",
    "glVertexAttribDivisor",
    "glVertexAttribPointer",
    "glVertexPointer",
];

/// True if a command changes vertex arrays.
pub fn is_array_state(name: &str) -> bool {
    let Some(rest) = name.strip_prefix("gl") else { return false };
    // Values of attributes are no arrays.
    let value = gl_attributes::is_attribute(name) || rest.starts_with("VertexAttribs");
    !value && BEGINNINGS.iter().any(|beginning| rest.starts_with(beginning))
}

/// Returns one invocation of the macro `array_commands`: the names of the [`NOTED`] commands, and a
/// row for each other command, with its parameter that names an object, or `all`. `declarations`
/// must contain all commands for which [`is_array_state`] is true.
pub fn generate(declarations: &[Declaration]) -> String {
    let mut rows = String::new();
    for Declaration { name, method, parameters } in declarations.iter().filter(|d| is_array_state(&d.name)) {
        if NOTED.contains(&name.as_str()) {
            continue;
        }
        let typed = parameters.iter().map(|(name, kind)| format!("{name}: {kind}")).collect::<Vec<_>>().join(", ");
        let object = parameters.first().map(|(name, _)| name.as_str()).filter(|name| *name == "p_vaobj");
        writeln!(rows, "    {name:?} {method}({typed}) of {};", object.unwrap_or("all")).expect("writing to a String");
    }
    format!("array_commands! {{\n    {NOTED:?}\n{rows}}}\n")
}
