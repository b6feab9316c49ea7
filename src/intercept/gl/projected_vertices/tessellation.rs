//! The tessellation stages that divide triangles, lines and quadrilaterals. Each edge gets the
//! number of parts that it needs.
//!
//! The number of an edge's parts, and the points between them, depend only on the directions in
//! which the viewer sees its two ends. So they are the same for two primitives that share the edge.
//! All parts of an edge have the same length on the chord between these directions, so an edge
//! close to the viewer needs no more parts. Drivers need not support more than 64 parts. If there
//! are atomic counters, edges that would need more are counted.

use crate::correct::projected::division;
use crate::intercept::gl::projected_vertices::geometry_stage::{CARRIER, COUNTER, Limits, Passing};
use crate::intercept::gl::projected_vertices::interface::{Interface, Value};
use crate::intercept::gl::state::draw::primitives::Patch;
use std::fmt::Write;

/// Name of the outputs of the control stage, followed by a number.
const HANDED: &str = "cupola_handed_";

/// Half the aperture of a fisheye, in radians, above which points around the antipode of its axis
/// are visible: three quarters of the way to the antipode.
const SHOWN_BEHIND: f64 = 0.75 * std::f64::consts::PI;

/// `cupola_parts(a, b)`: number of parts that the edge between two vertices needs.
const PARTS: &str = "bool cupola_coarse_edge = false;
float cupola_parts(vec4 first, vec4 second) {
bool turned = cupola_after(first, second);
vec3 a = normalize(cupola_seen(turned ? second : first));
vec3 b = normalize(cupola_seen(turned ? first : second));
for (int count = 1; count <= 64; count *= 2) {
bool bent = false;
vec3 from = a;
for (int part = 1; part <= count; part++) {
vec3 to = normalize(mix(a, b, float(part) / float(count)));
if (cupola_bent(from, to)) { bent = true; break; }
from = to;
}
if (!bent) return float(count);
}
cupola_coarse_edge = true;
return 64.0;
}
";

/// Returns `interface` with the built-in outputs `built_in` as additional values.
pub fn with_built_in(mut interface: Interface, built_in: &[(&str, &str)], passing: Passing) -> Interface {
    interface.values.extend(built_in.iter().map(|(name, kind)| Value {
        own: (*name).to_owned(),
        handed: (*name).to_owned(),
        kind: (*kind).to_owned(),
        flat: passing.flat && name.ends_with("Color"),
    }));
    interface
}

/// Returns the texts of the control and the evaluation stage for patches, behind a stage with the
/// outputs `interface`. `functions`: Cupola's uniform and the functions that project.
pub fn texts(patch: Patch, interface: &Interface, functions: &str, limits: &Limits) -> [String; 2] {
    let version = if limits.counter.is_some() { "420" } else { "400" };
    let profile = if limits.compatibility { "compatibility" } else { "core" };
    let head = format!("#version {version} {profile}\n");
    [head.clone() + &control(patch, interface, functions, limits), head + &evaluation(patch, interface, functions)]
}

fn control(patch: Patch, interface: &Interface, functions: &str, limits: &Limits) -> String {
    let corners = patch.corners();
    let mut text = control_declarations(corners, interface, limits);
    text.push_str(functions);
    text.push_str(&division::cuts());
    text.push_str(PARTS);
    text.push_str("void main() {\n");
    for number in 0..interface.values.len() {
        let _ = writeln!(text, "{HANDED}{number}[gl_InvocationID] = {CARRIER}{number}[gl_InvocationID];");
    }
    text.push_str("gl_out[gl_InvocationID].gl_Position = gl_in[gl_InvocationID].gl_Position;\nif (gl_InvocationID != 0) return;\n");
    for (number, [from, to]) in patch.edges().iter().enumerate() {
        let _ =
            writeln!(text, "float edge{number} = cupola_parts(gl_in[{from}].gl_Position, gl_in[{to}].gl_Position);");
    }
    if patch != Patch::Lines {
        text.push_str(&inner_parts(corners));
    }
    text.push_str("cupola_low = vec3(1e38);\ncupola_high = vec3(-1e38);\n");
    for corner in 0..corners {
        let _ = writeln!(text, "cupola_span(gl_in[{corner}].gl_Position);");
    }
    text.push_str(&levels(patch, limits));
    text.push_str("}\n");
    text
}

/// Returns the declarations that stand before the functions of the control stage.
fn control_declarations(corners: usize, interface: &Interface, limits: &Limits) -> String {
    let mut text = format!("layout(vertices = {corners}) out;\n");
    if let Some(binding) = limits.counter {
        let _ = writeln!(text, "layout(binding = {binding}, offset = 0) uniform atomic_uint {COUNTER};");
    }
    for (number, value) in interface.values.iter().enumerate() {
        let flat = if value.flat { "flat " } else { "" };
        let _ = writeln!(
            text,
            "{flat}in {kind} {CARRIER}{number}[];\n{flat}out {kind} {HANDED}{number}[];",
            kind = value.kind
        );
    }
    text
}

/// Returns the text that sets `inner`, the number of parts inside a patch.
fn inner_parts(corners: usize) -> String {
    let mut text = String::new();
    // Around a fisheye's antipode the edges may be straight enough while the inside of the patch is
    // not.
    let middle: Vec<String> = (0..corners)
        .map(|corner| {
            let at = format!("gl_in[{corner}].gl_Position");
            format!("{at} / max(length(cupola_seen({at})), 1e-30)")
        })
        .collect();
    let _ = writeln!(text, "vec4 middle = {};\nfloat inner = 1.0;", middle.join(" + "));
    for corner in 0..corners {
        // A path through the patch consists of two of these edges.
        let _ = writeln!(
            text,
            "inner = max(inner, min(64.0, 2.0 * cupola_parts(middle, gl_in[{corner}].gl_Position) - 1.0));"
        );
    }
    // The antipode itself becomes a whole circle, so a patch around it would need an unlimited
    // number of parts.
    let turn = |corner: usize| {
        let next = (corner + 1) % corners;
        format!("cross(cupola_seen(gl_in[{corner}].gl_Position), cupola_seen(gl_in[{next}].gl_Position)).z")
    };
    let signs: Vec<String> = (0..corners).map(|corner| format!("sign({})", turn(corner))).collect();
    let _ = writeln!(
        text,
        "bool around = abs({}) == {corners}.0 && cupola_seen(middle).z > 0.0;\n\
         if (around && cupola_view[5].w != 0.0 && cupola_view[6].z > {SHOWN_BEHIND:?}) {{ inner = 64.0; cupola_coarse_edge = true; }}",
        signs.join(" + ")
    );
    text
}

/// Returns the text that sets the tessellation levels, and counts patches that are too coarse.
fn levels(patch: Patch, limits: &Limits) -> String {
    let mut text = String::new();
    let all: Vec<String> = (0..patch.edges().len()).map(|number| format!("edge{number}")).collect();
    // A patch with straight edges that is beside the picture is left out.
    let _ = writeln!(text, "bool shown = cupola_near() || {} > {}.0;", all.join(" + "), all.len());
    if limits.counter.is_some() {
        let _ = writeln!(text, "if (cupola_coarse_edge) atomicCounterIncrement({COUNTER});");
    }
    match patch {
        Patch::Lines => text.push_str("gl_TessLevelOuter[0] = shown ? 1.0 : 0.0;\ngl_TessLevelOuter[1] = edge0;\n"),
        _ => all.iter().enumerate().for_each(|(number, edge)| {
            let _ = writeln!(text, "gl_TessLevelOuter[{number}] = shown ? {edge} : 0.0;");
        }),
    }
    match patch {
        Patch::Lines => {}
        Patch::Triangles => text.push_str("gl_TessLevelInner[0] = max(inner, max(edge0, max(edge1, edge2)));\n"),
        Patch::Quads => text.push_str(
            "gl_TessLevelInner[0] = max(inner, max(edge1, edge3));\ngl_TessLevelInner[1] = max(inner, max(edge0, edge2));\n",
        ),
    }
    text
}

fn evaluation(patch: Patch, interface: &Interface, functions: &str) -> String {
    let corners = patch.corners();
    let mut text = format!("layout({}) in;\n", patch.layout());
    for (number, value) in interface.values.iter().enumerate() {
        let flat = if value.flat { "flat " } else { "" };
        let _ = writeln!(text, "{flat}in {} {HANDED}{number}[];", value.kind);
    }
    for declaration in &interface.declarations {
        let _ = writeln!(text, "{declaration}");
    }
    text.push_str(functions);
    text.push_str(&division::cuts());
    text.push_str("void main() {\n");
    for (corner, weight) in patch.weights().iter().enumerate().take(corners) {
        let _ = writeln!(
            text,
            "precise float u{corner} = ({weight}) / max(length(cupola_seen(gl_in[{corner}].gl_Position)), 1e-30);"
        );
    }
    let sum = |of: &dyn Fn(usize) -> String| (0..corners).map(of).collect::<Vec<_>>().join(" + ");
    let _ = writeln!(text, "precise float sum = {};", sum(&|corner| format!("u{corner}")));
    for corner in 0..corners {
        let _ = writeln!(text, "u{corner} = u{corner} / sum;");
    }
    for (number, value) in interface.values.iter().enumerate() {
        // A value that is not interpolated comes from the last vertex.
        let value_at = match value.flat {
            true => format!("{HANDED}{number}[{}]", corners - 1),
            false => sum(&|corner| format!("u{corner} * {HANDED}{number}[{corner}]")),
        };
        let _ = writeln!(text, "{} = {value_at};", value.handed);
    }
    let _ = writeln!(
        text,
        "precise vec4 at = {};\ngl_Position = cupola_fix(at);\n}}",
        sum(&|corner| format!("u{corner} * gl_in[{corner}].gl_Position"))
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intercept::gl::projected_vertices::interface;

    const LIMITS: Limits =
        Limits { vertices: 256, components: 1024, shared: true, counter: Some(7), compatibility: false };

    #[test]
    fn values_go_through_both_stages() {
        let interface = interface::read("out vec3 shade;\nflat out int kind;\nvoid main() {}\n").expect("can be read");
        let [control, evaluation] = texts(Patch::Triangles, &interface, "", &LIMITS);
        assert!(control.contains("in vec3 cupola_carried_0[];") && control.contains("out vec3 cupola_handed_0[];"));
        assert!(control.contains("layout(binding = 7, offset = 0)") && control.contains("layout(vertices = 3) out;"));
        assert!(
            evaluation.contains("shade = u0 * cupola_handed_0[0] + u1 * cupola_handed_0[1] + u2 * cupola_handed_0[2];")
        );
        assert!(evaluation.contains("kind = cupola_handed_1[2];"), "{evaluation}");
        for word in ["WIDEST", "OUTSIDE", "NARROWEST"] {
            assert!(!control.contains(word), "{word} is left");
        }
    }

    /// At each corner of a patch the weight of this corner is 1, and each outer level belongs to
    /// the edge that it names.
    #[test]
    fn corners_are_where_opengl_has_them() {
        for (patch, places) in [
            (Patch::Triangles, vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
            (Patch::Lines, vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
            (Patch::Quads, vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]),
        ] {
            for (corner, [x, y, z]) in places.into_iter().enumerate() {
                for (other, weight) in patch.weights().into_iter().enumerate() {
                    let factors = weight.split(" * ").map(|factor| match factor.trim_matches(['(', ')']) {
                        "0.0" => 0.0,
                        "gl_TessCoord.x" => x,
                        "gl_TessCoord.y" => y,
                        "gl_TessCoord.z" => z,
                        "1.0 - gl_TessCoord.x" => 1.0 - x,
                        "1.0 - gl_TessCoord.y" => 1.0 - y,
                        factor => panic!("{factor}"),
                    });
                    let found: f64 = factors.product();
                    assert_eq!(found, f64::from(u8::from(other == corner)), "{patch:?}, corner {corner}: {weight}");
                }
            }
        }
    }
}
