//! The GLSL that takes a program's clip coordinates to a view, or to an output's picture.
//!
//! It is `geom::reprojection` and `geom::PictureMap` in 32 bits. It uses no built-in functions of
//! angles, since drivers may round them freely. The texts serve every version: `PRECISION` before
//! each type becomes `highp` or nothing. The build also makes SPIR-V of them
//! (`build/projection.rs`). So this file uses nothing of the library.

/// Name of the uniform that carries the rows of the re-projection.
pub const UNIFORM: &str = "cupola_view";

/// Number of vectors of the uniform that hold the rows of a view.
pub const ROWS: i32 = 4;
/// Number of vectors that follow and hold its lens: (viewer, 1 − |viewer|²), (lens, 1 for a
/// fisheye), (scale, offset), (limit, …).
pub const LENS: i32 = 4;

/// `cupola_place(u)`: place in the picture of the unit direction `u` from the viewer (lens axes),
/// and 1. If that place is beyond the picture: the unit direction in the picture to it, and 0.
///
/// The angle is that of atan2, computed by octant and polynomial, with a relative error of 1.7e-8.
const PLACE: &str = "PRECISION float cupola_angle(PRECISION float y, PRECISION float x) {
PRECISION float a = abs(x);
PRECISION float t = min(a, y) / max(max(a, y), 1e-30);
PRECISION float s = t * t;
PRECISION float p = -0.33333153 + s * (0.19993772 + s * (-0.14211052 + s * (0.10665993 + s * (-0.07552189 + s * (0.04321156 + s * (-0.01636774 + s * 0.00292065))))));
PRECISION float r = t + t * s * p;
if (y > a) r = 1.57079632679 - r;
return x < 0.0 ? 3.14159265359 - r : r;
}
PRECISION vec3 cupola_place(PRECISION vec3 u) {
PRECISION float along = dot(cupola_view[4].xyz, u);
PRECISION vec3 ray = cupola_view[4].xyz - cupola_view[5].xyz + u * (sqrt(along * along + cupola_view[4].w) - along);
PRECISION float h = length(ray.xy);
PRECISION vec2 aside = h > 0.0 ? ray.xy / h : vec2(1.0, 0.0);
if (cupola_view[5].w != 0.0) {
PRECISION float angle = cupola_angle(h, -ray.z);
return angle > cupola_view[7].x ? vec3(aside, 0.0) : vec3(aside * angle * cupola_view[6].xy, 1.0);
}
if (-ray.z <= cupola_view[7].x * length(ray)) return vec3(aside, 0.0);
return vec3(ray.xy / -ray.z * cupola_view[6].xy - cupola_view[6].zw, 1.0);
}
";

/// `cupola_project(v, q, sky)`: clip coordinates in the output's picture of a vertex at `v` (lens
/// axes, the program's units). Depth and w follow from the distance, so that interpolated values
/// are right to second order in the size of a triangle. `q`: the program's depth without its part
/// of w. `sky`: the vertex lies at the far plane.
///
/// A vertex beyond the picture is a point at infinity. Edges to it leave the picture in its
/// direction, and a triangle with only such vertices is beyond the far plane.
const PROJECT: &str = "PRECISION vec4 cupola_project(PRECISION vec3 v, PRECISION float q, bool sky) {
PRECISION float m = max(max(abs(v.x), abs(v.y)), max(abs(v.z), 1e-30));
PRECISION vec3 u = v / m;
PRECISION float l = max(length(u), 1e-30);
PRECISION float d = m * l;
PRECISION vec3 at = cupola_place(u / l);
if (at.z == 0.0) return vec4(at.xy * d, 1e-5 * d, -1e-6 * d);
PRECISION float z = cupola_view[3].y * (q - cupola_view[3].x * d) + cupola_view[3].z * d;
return vec4(at.xy * d, sky ? d : z, d);
}
";

/// The function that re-projects; `cupola_view` holds the rows for x, y, w and (E, depth factor,
/// depth offset, curved).
const FIX: &str = "PRECISION vec4 cupola_fix(PRECISION vec4 c) {
PRECISION float q = c.z + cupola_view[3].x * c.w;
PRECISION float w = dot(cupola_view[2].xyz, c.xyw) + cupola_view[2].w * q;
PRECISION vec4 r = vec4(dot(cupola_view[0].xyz, c.xyw) + cupola_view[0].w * q, dot(cupola_view[1].xyz, c.xyw) + cupola_view[1].w * q, cupola_view[3].y * (q - cupola_view[3].x * w) + cupola_view[3].z * w, w);
if (c.z == c.w) r.z = w;
CURVEDreturn r;
}
";

/// Branch for rows that lead to a lens, for views that are projected to outputs.
const CURVED: &str = "if (cupola_view[3].w != 0.0) return cupola_project(vec3(r.x, r.y, -r.w), q, c.z == c.w);
";

/// Returns the function `cupola_fix`, which re-projects by `cupola_view`. The text before it has to
/// define `cupola_view`. `es`: for OpenGL ES. `curved`: some views have a lens to which vertices
/// are projected.
fn body(es: bool, curved: bool) -> String {
    let (lens, hook) = if curved { ([PLACE, PROJECT].concat(), CURVED) } else { (String::new(), "") };
    let fix = FIX.replace("CURVED", hook);
    format!("{lens}{fix}").replace("PRECISION ", precision(es))
}

/// Returns the uniform of Cupola, and the function `cupola_fix`, which re-projects with it. `es`:
/// for OpenGL ES. `curved`: some views have a lens to which vertices are projected.
pub fn functions(es: bool, curved: bool) -> String {
    format!("uniform {}vec4 {UNIFORM}[{}];\n{}", precision(es), vectors(curved), body(es, curved))
}

/// Returns the same in the GLSL of Vulkan: the vectors are a uniform block of descriptor set `set`
/// at `binding`.
pub fn vulkan_functions(set: u32, binding: u32, curved: bool) -> String {
    let block = format!("layout(std140, set = {set}, binding = {binding}) uniform cupola_block");
    format!("{block} {{ vec4 {UNIFORM}[{}]; }};\n{}", vectors(curved), body(false, curved))
}

/// Number of vectors of `cupola_view`.
fn vectors(curved: bool) -> i32 {
    if curved { ROWS + LENS } else { ROWS }
}

fn precision(es: bool) -> &'static str {
    if es { "highp " } else { "" }
}
