//! The GLSL of a geometry stage that divides triangles and lines: `geom::Division` in 32 bits.
//!
//! One run of the stage can emit only few vertices. So several runs share a primitive, and each
//! takes another path at the first cuts. A part for which no vertices are left is emitted
//! undivided. The build also makes SPIR-V of the texts (`build/projection.rs`). So this file uses
//! nothing of the library but the rule's numbers.

use super::rule::{EDGE_SHARE, NARROWEST, OUTSIDE, WIDEST, WIDTH_SQUARED};

/// Kinds of primitives that are divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// Triangles, strips and fans of them.
    Triangles,
    /// Lines, strips and loops.
    Lines,
}

impl Input {
    /// Returns the number of vertices of a primitive.
    pub fn corners(self) -> u32 {
        match self {
            Self::Triangles => 3,
            Self::Lines => 2,
        }
    }
}

/// Greatest number of cuts of a primitive: each takes two bits of a number.
const DEEPEST: usize = 14;
/// Greatest number of steps of a run, far more than its vertices allow.
const STEPS: usize = 8192;

/// `cupola_cuts(a, b)`: true if the edge between two vertices (clip coordinates of the program)
/// must be cut, because a straight line would be too far from the curve. The ends are sorted first,
/// so that both triangles of an edge get the same result to the bit. An edge with a NaN is not cut:
/// drivers also run the stage for invalid primitives.
const CUTS: &str = "vec3 cupola_seen(vec4 c) {
float q = c.z + cupola_view[3].x * c.w;
vec4 p = vec4(c.xyw, q);
return vec3(dot(cupola_view[0], p), dot(cupola_view[1], p), -dot(cupola_view[2], p));
}
bool cupola_after(vec4 a, vec4 b) {
return a.x > b.x || (a.x == b.x && (a.y > b.y || (a.y == b.y && a.w > b.w)));
}
bool cupola_outside(vec2 from, vec2 to, vec2 middle) {
if (cupola_view[5].w != 0.0) {
vec2 unit = cupola_view[6].xy * cupola_view[6].z;
return min(min(length(from / unit), length(to / unit)), length(middle / unit)) > OUTSIDE;
}
vec2 low = min(min(from, to), middle);
vec2 high = max(max(from, to), middle);
return max(low.x, low.y) > OUTSIDE || min(high.x, high.y) < -OUTSIDE;
}
bool cupola_bent(vec3 a, vec3 b) {
vec3 sum = a + b;
float l = length(sum);
vec2 scale = cupola_view[6].xy * cupola_view[7].zw;
float widest = min(WIDEST, sqrt(WIDTH_SQUARED * cupola_view[7].y / max(scale.x, scale.y)));
if (distance(a, b) > widest) return true;
vec3 from = cupola_place(a);
vec3 to = cupola_place(b);
if (from.z + to.z == 0.0) return false;
if (from.z * to.z == 0.0) {
vec2 seen = from.z > 0.0 ? from.xy : to.xy;
return !cupola_outside(seen, seen, seen) && distance(a, b) > NARROWEST;
}
vec3 middle = cupola_place(sum / l);
if (middle.z == 0.0) return true;
if (cupola_outside(from.xy, to.xy, middle.xy)) return false;
vec2 off = (middle.xy - 0.5 * (from.xy + to.xy)) * cupola_view[7].zw;
return dot(off, off) > cupola_view[7].y * cupola_view[7].y;
}
bool cupola_cuts(vec4 first, vec4 second) {
bool turned = cupola_after(first, second);
vec3 a = normalize(cupola_seen(turned ? second : first));
vec3 b = normalize(cupola_seen(turned ? first : second));
return cupola_bent(a, b);
}
float cupola_middle(vec4 a, vec4 b) {
float from = length(cupola_seen(a));
float to = length(cupola_seen(b));
return from + to > 0.0 ? from / (from + to) : 0.5;
}
vec4 cupola_halfway(vec4 first, vec4 second) {
bool turned = cupola_after(first, second);
vec4 a = turned ? second : first;
vec4 b = turned ? first : second;
return mix(a, b, cupola_middle(a, b));
}
vec3 cupola_low, cupola_high;
void cupola_span(vec4 c) {
vec3 at = cupola_place(normalize(cupola_seen(c)));
if (at.z == 0.0) at.xy *= 1e30;
cupola_low = min(cupola_low, at);
cupola_high = max(cupola_high, at);
}
bool cupola_near() {
return max(cupola_low.x, cupola_low.y) <= OUTSIDE && min(cupola_high.x, cupola_high.y) >= -OUTSIDE && cupola_high.z > 0.0;
}
";

/// Parts of triangles: their corners, and the weights of the primitive's corners in them.
const TRIANGLES: &str = "struct cupola_part { vec4 a; vec4 b; vec4 c; vec3 u; vec3 v; vec3 w; int deep; };
cupola_part cupola_parts[4];
cupola_part cupola_of(int start, vec4 a, vec3 u, vec4 b, vec3 v, vec4 c, vec3 w, int deep) {
if (start == 0) return cupola_part(a, b, c, u, v, w, deep);
if (start == 1) return cupola_part(c, a, b, w, u, v, deep);
return cupola_part(b, c, a, v, w, u, deep);
}
int cupola_divide(cupola_part t) {
bool ab = cupola_cuts(t.a, t.b);
bool bc = cupola_cuts(t.b, t.c);
bool ca = cupola_cuts(t.c, t.a);
int count = int(ab) + int(bc) + int(ca);
if (count == 0 || t.deep >= DEEPEST) { cupola_parts[0] = t; return count == 0 ? 1 : -1; }
int start = 0;
if (!ab && bc) start = 1;
else if (ca && !bc) start = 2;
if (start == 1) t = cupola_part(t.b, t.c, t.a, t.v, t.w, t.u, t.deep);
if (start == 2) t = cupola_part(t.c, t.a, t.b, t.w, t.u, t.v, t.deep);
int deep = t.deep + 1;
vec4 p = cupola_halfway(t.a, t.b);
vec3 f = mix(t.u, t.v, cupola_middle(t.a, t.b));
if (count == 1) {
cupola_parts[0] = cupola_of(start, t.a, t.u, p, f, t.c, t.w, deep);
cupola_parts[1] = cupola_of(start, p, f, t.b, t.v, t.c, t.w, deep);
return 2;
}
vec4 q = cupola_halfway(t.b, t.c);
vec3 g = mix(t.v, t.w, cupola_middle(t.b, t.c));
if (count == 2) {
cupola_parts[0] = cupola_of(start, t.a, t.u, p, f, t.c, t.w, deep);
cupola_parts[1] = cupola_of(start, p, f, t.b, t.v, q, g, deep);
cupola_parts[2] = cupola_of(start, p, f, q, g, t.c, t.w, deep);
return 3;
}
vec4 r = cupola_halfway(t.c, t.a);
vec3 h = mix(t.w, t.u, cupola_middle(t.c, t.a));
cupola_parts[0] = cupola_of(start, t.a, t.u, p, f, r, h, deep);
cupola_parts[1] = cupola_of(start, p, f, t.b, t.v, q, g, deep);
cupola_parts[2] = cupola_of(start, r, h, q, g, t.c, t.w, deep);
cupola_parts[3] = cupola_of(start, p, f, q, g, r, h, deep);
return 4;
}
void cupola_show(cupola_part t) {
cupola_low = vec3(1e38);
cupola_high = vec3(-1e38);
cupola_span(t.a);
cupola_span(t.b);
cupola_span(t.c);
if (!cupola_near()) return;
cupola_emit(t.a, t.u);
cupola_emit(t.b, t.v);
cupola_emit(t.c, t.w);
EndPrimitive();
cupola_left--;
}
cupola_part cupola_whole() {
return cupola_part(gl_in[0].gl_Position, gl_in[1].gl_Position, gl_in[2].gl_Position, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0), 0);
}
";

/// Parts of lines, in the same form.
const LINES: &str = "struct cupola_part { vec4 a; vec4 b; vec3 u; vec3 v; int deep; };
cupola_part cupola_parts[4];
int cupola_divide(cupola_part t) {
if (!cupola_cuts(t.a, t.b)) { cupola_parts[0] = t; return 1; }
if (t.deep >= DEEPEST) { cupola_parts[0] = t; return -1; }
vec4 p = cupola_halfway(t.a, t.b);
vec3 f = mix(t.u, t.v, cupola_middle(t.a, t.b));
cupola_parts[0] = cupola_part(t.a, p, t.u, f, t.deep + 1);
cupola_parts[1] = cupola_part(p, t.b, f, t.v, t.deep + 1);
return 2;
}
void cupola_show(cupola_part t) {
cupola_low = vec3(1e38);
cupola_high = vec3(-1e38);
cupola_span(t.a);
cupola_span(t.b);
if (!cupola_near()) return;
cupola_emit(t.a, t.u);
cupola_emit(t.b, t.v);
EndPrimitive();
cupola_left--;
}
cupola_part cupola_whole() {
return cupola_part(gl_in[0].gl_Position, gl_in[1].gl_Position, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), 0);
}
";

/// Path of a run through the parts of its primitive: to the first part that is fine enough, then to
/// the next, each time from the top. There is no list of pending parts, because drivers on
/// processors turn every access to a list into a chain of comparisons.
///
/// `path` has two bits for each cut: the index of the part that is followed. `counts` has the
/// number of parts of each cut, less one. `known` cuts are on the path, and `part` is the part
/// after `level` of them. `pending` parts beside the path wait; a part is cut only while there is
/// room for all of them. After a part is shown, `path` is incremented as a number whose digits have
/// the bases in `counts`: last digits at their maximum are dropped, and the one before grows.
///
/// The first `TURNS` cuts are not incremented: there the number of the run selects the part, and a
/// run whose number has no part ends.
const MAIN: &str = "void main() {
cupola_part part = cupola_whole();
int path = RUN;
int counts = 0;
int level = 0;
int known = TURNS;
int pending = 0;
for (int step = 0; step < STEPS; step++) {
int count = cupola_divide(part);
int digit = (path >> (2 * level)) & 3;
if (level < known) {
if (level < TURNS && digit >= abs(count)) return;
part = cupola_parts[digit];
level++;
} else if (count > 1 && pending + count <= cupola_left) {
counts |= (count - 1) << (2 * level);
pending += count - 1;
part = cupola_parts[0];
level++;
known = level;
} else {
if (count != 1) { COUNT }
cupola_show(part);
while (known > TURNS && ((path >> (2 * known - 2)) & 3) == ((counts >> (2 * known - 2)) & 3)) {
known--;
path &= ~(3 << (2 * known));
counts &= ~(3 << (2 * known));
}
if (known == TURNS) return;
path += 1 << (2 * known - 2);
pending--;
part = cupola_whole();
level = 0;
}
}
}
";

/// Returns the functions that decide on cuts: `cupola_bent(a, b)` for the edge between two
/// directions, `cupola_cuts` for the edge between two vertices, and `cupola_near` for the span of
/// the points given to `cupola_span`.
pub fn cuts() -> String {
    let replace: [(&str, &str); 4] = [
        ("WIDEST", &format!("{WIDEST:?}")),
        ("WIDTH_SQUARED", &format!("{:?}", WIDTH_SQUARED / EDGE_SHARE)),
        ("OUTSIDE", &format!("{OUTSIDE:?}")),
        ("NARROWEST", &format!("{NARROWEST:?}")),
    ];
    with_values(CUTS, &replace)
}

fn with_values(text: &str, replace: &[(&str, &str)]) -> String {
    replace.iter().fold(text.to_owned(), |text, (word, value)| text.replace(word, value))
}

/// Returns the parts of a primitive and the path through them, `main`. The text before it has to
/// define `cupola_left`, the number of parts that a run may still emit, and `cupola_emit(c, u)`.
/// That function emits a vertex at `c`, with the corners' values weighted by `u`. `shared`: sixteen
/// runs share a primitive. `count`: statement for a part that is emitted although it is not fine
/// enough.
pub fn division(input: Input, shared: bool, count: &str) -> String {
    let replace: [(&str, &str); 5] = [
        ("DEEPEST", &DEEPEST.to_string()),
        ("STEPS", &STEPS.to_string()),
        ("TURNS", if shared { "2" } else { "0" }),
        ("RUN", if shared { "gl_InvocationID" } else { "0" }),
        ("COUNT", count),
    ];
    let parts = match input {
        Input::Triangles => TRIANGLES,
        Input::Lines => LINES,
    };
    with_values(&[parts, MAIN].concat(), &replace)
}

/// Placeholders for the functions of a geometry stage of Vulkan, in the order of
/// [`STAGE_FUNCTIONS`]: number of its invocation, number of parts that it may emit, corner of its
/// primitive, emission of a vertex, end of a primitive, and count of a part that is emitted
/// although it is not fine enough. The translated text replaces them with the functions of the
/// stage.
const OWN: &str = "int cupola_left = 0;
int cupola_run() { return 0; }
int cupola_room() { return 0; }
vec4 cupola_corner(int i) { return vec4(float(i)); }
void cupola_emit(vec4 c, vec3 u) {}
void cupola_end() {}
void cupola_count() {}
";

/// Functions that a geometry stage of Vulkan defines itself.
pub const STAGE_FUNCTIONS: [&str; 6] =
    ["cupola_run", "cupola_room", "cupola_corner", "cupola_emit", "cupola_end", "cupola_count"];

/// Code before the division in a geometry stage of Vulkan. Primitives without a lens, and those
/// that the lens need not divide, are emitted unchanged.
const UNDIVIDED: &str = "void cupola_divided() {
cupola_left = cupola_room();
if (cupola_view[3].w == 0.0 || cupola_view[7].y == 0.0) {
if (cupola_run() == 0) cupola_undivided(cupola_whole());
return;
}
";

/// `cupola_undivided` for triangles, and for lines.
const WHOLE_TRIANGLE: &str = "void cupola_undivided(cupola_part t) {
cupola_emit(t.a, t.u);
cupola_emit(t.b, t.v);
cupola_emit(t.c, t.w);
cupola_end();
}
";
const WHOLE_LINE: &str = "void cupola_undivided(cupola_part t) {
cupola_emit(t.a, t.u);
cupola_emit(t.b, t.v);
cupola_end();
}
";

/// Returns the geometry stage of Vulkan, `cupola_divided`. The text before it has to contain the
/// functions of `projection::vulkan_functions` with lenses.
pub fn vulkan_division(input: Input) -> String {
    let whole = if input == Input::Triangles { WHOLE_TRIANGLE } else { WHOLE_LINE };
    let divided = division(input, true, "cupola_count();")
        .replace("void main() {\n", &[whole, UNDIVIDED].concat())
        .replace("EndPrimitive()", "cupola_end()")
        .replace("gl_InvocationID", "cupola_run()");
    let corners = (0..3)
        .fold(divided, |text, i| text.replace(&format!("gl_in[{i}].gl_Position"), &format!("cupola_corner({i})")));
    format!("{OWN}{}{corners}", cuts())
}
