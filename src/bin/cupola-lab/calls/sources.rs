//! Shader sources for programs.

/// Sources of vertex shaders.
pub const VERTEX: [&str; 4] = [
    "#version 430 compatibility\nlayout(location = 0) uniform mat4 u0; layout(location = 7) uniform vec4 u1; in vec4 \
     colour; out vec4 c; void main() { c = colour + u1; gl_Position = u0 * gl_Vertex; }",
    "#version 430\nlayout(location = 0) uniform mat4 u0; layout(location = 7) uniform vec4 u1; in vec4 position; in vec4 colour; out vec4 c; void main() { c = colour \
     + u1; gl_Position = u0 * position; }",
    "#version 430\nlayout(location = 0) uniform vec4 u0; in vec4 position; out vec4 c; void main() { c = u0; gl_Position = \
     position; }",
    "#version 300 es\nuniform mat4 u0; uniform vec4 u1; in vec4 position; out vec4 c; void main() { c = u1; gl_Position = \
     u0 * position; }",
];
pub const FRAGMENT: [&str; 4] = [
    "#version 430 compatibility\nin vec4 c; void main() { gl_FragColor = c; }",
    "#version 330\nin vec4 c; out vec4 f; layout(std140) uniform block { vec4 b; }; void main() { f = c + b; }",
    "#version 430\nin vec4 c; layout(location = 0) out vec4 f; layout(location = 1) out vec4 g; layout(location = 40) \
     uniform vec4 u3[3]; layout(location = 9) uniform sampler2D u2; void main() { f = c; g = u3[1] + texture(u2, c.xy); }",
    "#version 300 es\nprecision highp float; in vec4 c; out vec4 f; void main() { f = c; }",
];
/// Sources of other stages, and an empty one.
pub const OTHERS: [&str; 4] = [
    "#version 330\nlayout(triangles) in; layout(triangle_strip, max_vertices = 3) out; in vec4 c[]; void main() { for (int i \
     = 0; i < 3; i++) { gl_Position = gl_in[i].gl_Position; EmitVertex(); } EndPrimitive(); }",
    "#version 430\nlayout(local_size_x = 1) in; layout(std430) buffer s { vec4 v[]; }; void main() { v[0] = vec4(1); }",
    "#version 330\nvoid main() { nothing; }",
    "no shader",
];
/// All sources.
pub const ALL: [&str; 12] = [
    VERTEX[0],
    VERTEX[1],
    VERTEX[2],
    VERTEX[3],
    FRAGMENT[0],
    FRAGMENT[1],
    FRAGMENT[2],
    FRAGMENT[3],
    OTHERS[0],
    OTHERS[1],
    OTHERS[2],
    OTHERS[3],
];

/// Formats a source for a file.
pub fn line(source: &str) -> String {
    source.replace('\n', "\\n").replace(' ', "\\s")
}
