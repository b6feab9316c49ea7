//! The geometry stage that divides triangles and lines: `correct::projected::division` with the
//! stage outputs of the program's own shaders. If there are atomic counters, primitives that could
//! not be divided finely enough are counted.

use crate::correct::projected::division::{Input, cuts, division};
use crate::intercept::gl::projected_vertices::interface::Interface;
use std::fmt::Write;

/// Limits of the context.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// `GL_MAX_GEOMETRY_OUTPUT_VERTICES`.
    pub vertices: usize,
    /// `GL_MAX_GEOMETRY_TOTAL_OUTPUT_COMPONENTS`.
    pub components: usize,
    /// True if several invocations of the stage may share a primitive (OpenGL 4.0).
    pub shared: bool,
    /// Binding of the counter of primitives that are too coarse. `None`: there is no counter.
    pub counter: Option<u32>,
    /// True for the compatibility profile.
    pub compatibility: bool,
}

/// Values that the stage passes on in addition to the outputs of the stage before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Passing {
    /// True if the fragment stage uses the number of the primitive.
    pub number: bool,
    /// True if a primitive has the built-in colours of its last vertex.
    pub flat: bool,
}

/// Name of the counter of primitives that are too coarse.
pub const COUNTER: &str = "cupola_coarse";

/// Name of the carrier variables, followed by a number.
pub const CARRIER: &str = "cupola_carried_";

/// Returns the text of the stage for primitives of `input`, behind a stage with the outputs
/// `interface` and the built-in outputs `built_in`. `functions`: Cupola's uniform and the functions
/// that project. `None`: the context allows too few vertices.
pub fn text(
    input: Input,
    interface: &Interface,
    built_in: &[(&str, &str)],
    passing: Passing,
    functions: &str,
    limits: &Limits,
) -> Option<String> {
    let (name, corners, strip) = match input {
        Input::Triangles => ("triangles", 3, "triangle_strip"),
        Input::Lines => ("lines", 2, "line_strip"),
    };
    let components = 4
        + interface.components()
        + built_in.iter().map(|(_, kind)| 4.min(kind.len())).sum::<usize>()
        + usize::from(passing.number);
    let parts = limits.vertices.min(limits.components / components) / corners;
    if parts < 4 {
        return None;
    }
    let runs = if limits.shared { ", invocations = 16" } else { "" };
    let version = match (limits.counter, limits.shared) {
        (Some(_), _) => "420",
        (None, true) => "400",
        (None, false) => "150",
    };
    let profile = if limits.compatibility { "compatibility" } else { "core" };
    let mut text = format!("#version {version} {profile}\nlayout({name}{runs}) in;\n");
    let _ = writeln!(text, "layout({strip}, max_vertices = {}) out;", parts * corners);
    if let Some(binding) = limits.counter {
        let _ = writeln!(text, "layout(binding = {binding}, offset = 0) uniform atomic_uint {COUNTER};");
    }
    for (number, value) in interface.values.iter().enumerate() {
        let flat = if value.flat { "flat " } else { "" };
        let _ = writeln!(text, "{flat}in {} {CARRIER}{number}[];", value.kind);
    }
    for declaration in &interface.declarations {
        let _ = writeln!(text, "{declaration}");
    }
    let _ = writeln!(text, "int cupola_left = {parts};");
    text.push_str(functions);
    text.push_str(&cuts());
    text.push_str(&emitter(interface, built_in, passing, corners));
    let count = limits.counter.map_or(String::new(), |_| format!("atomicCounterIncrement({COUNTER});"));
    text.push_str(&division(input, limits.shared, &count));
    Some(text)
}

/// Returns `cupola_emit(c, u)`, which emits a vertex at `c`. The weights `u` of the corners give
/// its values.
fn emitter(interface: &Interface, built_in: &[(&str, &str)], passing: Passing, corners: usize) -> String {
    let mut text = "void cupola_emit(vec4 c, vec3 u) {\n".to_owned();
    let mixed = |of: &dyn Fn(usize) -> String| {
        let terms: Vec<String> = (0..corners).map(|i| format!("u.{} * {}", ["x", "y", "z"][i], of(i))).collect();
        terms.join(" + ")
    };
    for (number, value) in interface.values.iter().enumerate() {
        let carried = |i: usize| format!("{CARRIER}{number}[{i}]");
        // A value that is not interpolated comes from the last vertex.
        let value_at = if value.flat { carried(corners - 1) } else { mixed(&carried) };
        let _ = writeln!(text, "{} = {value_at};", value.handed);
    }
    for (name, _) in built_in {
        let of = |i: usize| format!("gl_in[{i}].{name}");
        let value = if passing.flat && name.ends_with("Color") { of(corners - 1) } else { mixed(&of) };
        let _ = writeln!(text, "{name} = {value};");
    }
    if passing.number {
        text.push_str("gl_PrimitiveID = gl_PrimitiveIDIn;\n");
    }
    text.push_str("gl_Position = cupola_fix(c);\nEmitVertex();\n}\n");
    text
}

/// Returns the declarations and copies for the end of the stage before. They copy the outputs of
/// its `main` into the carrier variables.
pub fn carriers(interface: &Interface, out: &str) -> (String, String) {
    let (mut declarations, mut copies) = (String::new(), String::new());
    for (number, value) in interface.values.iter().enumerate() {
        let flat = if value.flat { "flat " } else { "" };
        let _ = writeln!(declarations, "{flat}{out} {} {CARRIER}{number};", value.kind);
        let _ = write!(copies, " {CARRIER}{number} = {};", value.own);
    }
    (declarations, copies)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intercept::gl::projected_vertices::interface;

    const LIMITS: Limits =
        Limits { vertices: 256, components: 1024, shared: true, counter: Some(15), compatibility: false };

    #[test]
    fn a_stage_is_as_large_as_the_context_allows() {
        let interface = interface::read("out vec3 shade;\nflat out int kind;\nvoid main() {}\n").expect("can be read");
        let text = text(Input::Triangles, &interface, &[], Passing::default(), "", &LIMITS).expect("there is room");
        // There are 8 components: 128 vertices, 42 triangles.
        assert!(text.contains("max_vertices = 126)") && text.contains("int cupola_left = 42;"), "{text}");
        assert!(text.contains("flat in int cupola_carried_1[];") && text.contains("kind = cupola_carried_1[2];"));
        assert!(
            text.contains("shade = u.x * cupola_carried_0[0] + u.y * cupola_carried_0[1] + u.z * cupola_carried_0[2];")
        );
        for word in ["WIDEST", "OUTSIDE", "NARROWEST", "DEEPEST", "STEPS", "TURNS", "RUN", "COUNT"] {
            assert!(!text.contains(word), "{word} is left");
        }
        let (declarations, copies) = carriers(&interface, "out");
        assert_eq!(declarations, "out vec3 cupola_carried_0;\nflat out int cupola_carried_1;\n");
        assert_eq!(copies, " cupola_carried_0 = shade; cupola_carried_1 = kind;");
    }

    #[test]
    fn too_many_values_leave_no_room() {
        let interface = interface::read("out mat4 m[8];\nvoid main() {}\n").expect("can be read");
        assert_eq!(text(Input::Triangles, &interface, &[], Passing::default(), "", &LIMITS), None);
    }
}
