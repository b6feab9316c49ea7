use super::{of_stage, with_all_of};
use crate::intercept::gl::state::shader::position_names::Choice;
use crate::intercept::scene::lens::Order;

fn flows(text: &str, name: &str) -> bool {
    of_stage([text]).expect("understood").contain(name)
}

#[test]
fn matrices_of_the_position_flow_into_it() {
    for text in [
        "uniform mat4 m; in vec4 p; void main() { gl_Position = m * p; }",
        "uniform mat4 m; in vec4 p; void main() { vec4 a; a = m * p; vec4 b = a; gl_Position.xyz = b.xyz; }",
        "uniform B { mat4 m; } b; in vec4 p; void main() { gl_Position = b.m * p; }",
        "uniform mat4 m[2]; in vec4 p; vec4 f(vec4 v) { return m[1] * v; } void main() { gl_Position = f(p); }",
        "uniform mat4 m; in vec4 p; void f(vec4 v) { gl_Position = v; } void main() { f(m * p); }",
        "uniform mat4 m; in vec4 p; void f(out vec4 v) { v = m * p; } void main() { vec4 a; f(a); gl_Position = a; }",
        "#define M m\nuniform mat4 m; in vec4 p; void main() { gl_Position = M * p; }",
        "#define F(x) g(x)\nuniform mat4 m; in vec4 p; void g(vec4 v) { gl_Position = v; }\nvoid main() { F(m * p); }",
        "#ifdef A\n#else\nuniform mat4 m;\n#endif\nin vec4 p; void main() {\n#if 1\ngl_Position = m * p;\n#endif\n}",
        "uniform mat4 m; in vec4 p; void main() { float w = 0.0; if (m[0][0] > 1.0) { w = 1.0; } gl_Position = p * w; }",
        "uniform mat4 m; in vec4 p; void main() { vec4 a[2]; for (int i = 0; i < int(m[0][0]); i++) a[i] = p; gl_Position = a[0]; }",
        "uniform mat4 m; in vec4 p; struct S { vec4 q; } s; void main() { s.q = m * p; gl_Position = s.q; }",
        "uniform mat4 m; in vec4 p; void main() { float a, b = m[0][0]; modf(b, a); gl_Position = p * a; }",
        "uniform mat4 m; in vec4 p; vec4 g; void f() { g = m * p; } void main() { f(); gl_Position = g; }",
    ] {
        assert!(flows(text, "B.m[0]"), "{text}");
    }
}

#[test]
fn other_matrices_do_not() {
    for text in [
        "uniform mat4 m; in vec2 p; void main() { gl_Position = vec4(p, 0.0, 1.0); }",
        "layout(std140) uniform B { mat4 m; mat4 n; }; in vec2 p; out vec4 v;\nvoid main() { vec4 a = m * n * vec4(p, 0, 1); v = a; gl_Position = vec4(p, 0., 1.); }",
        "uniform mat4 m; in vec2 p; out vec4 v; vec4 f(vec4 q) { return m * q; } void main() { v = f(vec4(p, 0, 1)); gl_Position = vec4(p, 0, 1); }",
        "uniform mat4 m; out vec2 v; void main() { v = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2); gl_Position = vec4(v * 2.0 - 1.0, 0.0, 1.0); }",
    ] {
        assert!(!flows(text, "m"), "{text}");
    }
}

/// Returns the groups of four vectors that flow into the position, for a declaration of uniforms
/// and a body.
fn fours(declared: &str, body: &str) -> Vec<(u32, Order)> {
    let text = format!("{declared}\nin vec4 v; in vec3 n; out vec3 s;\nvoid main() {{ {body} }}");
    let names = of_stage([&*text]).expect("understood");
    assert!(names.contain("m[0]"), "{text}");
    names.elements("m[0]").expect("an array").fours().collect()
}

#[test]
fn four_vectors_are_columns_or_rows_by_their_use() {
    let sum = "vec4 t = v.yyyy * m[1]; t = m[0] * v.xxxx + t; t = m[2]*v.zzzz + t; gl_Position = t + m[3];";
    assert_eq!(fours("uniform vec4 m[4];", sum), [(0, Order::Columns)]);
    let products = "gl_Position.x = dot(m[5], v); gl_Position.y = dot(v, m[6].xyzw); gl_Position.zw = vec2(dot((m[7]), v), dot(v, m [ 8 ]));";
    assert_eq!(fours("uniform highp vec4 m[32];", products), [(5, Order::Rows)]);
    let lit = format!("s = vec3(dot(m[20], v), m[21].x, m[22].x) * m[23].xyz; {products}");
    assert_eq!(fours("layout(std140) uniform B { vec4 t; vec4 m[32]; };", &lit), [(5, Order::Rows)], "other elements");
    let built = "gl_Position = mat4(m[0], m[1], m[2], m[3]) * v;";
    assert_eq!(fours("uniform vec4[4] m;", built), [(0, Order::Either)]);
    let both = format!("{sum} gl_Position.x += dot(m[3], v);");
    assert_eq!(fours("uniform vec4 m[4];", &both), [(0, Order::Either)]);
    let last = "gl_Position = m[4294967292] + m[4294967293] + m[4294967294] + m[4294967295] * v;";
    assert_eq!(fours("uniform vec4 m[4];", last), [(u32::MAX - 3, Order::Columns)]);
    let defined = "#define a m[2]\n#define b m[3]\n#define c (m[4])\n#define d m[5]\nuniform vec4 m[8];";
    let products = "gl_Position = vec4(dot(a, v), dot(b, v), dot(c, v), dot(d, v));";
    assert_eq!(fours(defined, products), [(2, Order::Rows)]);
}

/// The form of Unity's shaders after translation by HLSLcc. One source has the texts of both
/// stages.
#[test]
fn macros_of_layouts_are_understood() {
    let text = "#ifdef VERTEX\n#version 330\n#define HLSLCC_ENABLE_UNIFORM_BUFFERS 1\n#if HLSLCC_ENABLE_UNIFORM_BUFFERS\n\
        #define UNITY_UNIFORM\n#else\n#define UNITY_UNIFORM uniform\n#endif\n\
        #define UNITY_LOCATION(x) layout(location = x)\n#define UNITY_BINDING(x) layout(binding = x, std140)\n\
        uniform vec4 unity_LightPosition[8];\nuniform vec4 hlslcc_mtx4x4unity_MatrixVP[4];\n\
        UNITY_BINDING(0) uniform UnityPerDraw {\n\tUNITY_UNIFORM vec4 hlslcc_mtx4x4unity_ObjectToWorld[4];\n\
        \tUNITY_UNIFORM vec4 hlslcc_mtx4x4unity_WorldToObject[4];\n};\n\
        in vec4 in_POSITION0;\nout vec3 vs_TEXCOORD0;\nvec4 u_xlat0;\nvec4 u_xlat1;\nvoid main()\n{\n\
        u_xlat0 = in_POSITION0.yyyy * hlslcc_mtx4x4unity_ObjectToWorld[1];\n\
        u_xlat0 = hlslcc_mtx4x4unity_ObjectToWorld[0] * in_POSITION0.xxxx + u_xlat0;\n\
        u_xlat0 = hlslcc_mtx4x4unity_ObjectToWorld[2] * in_POSITION0.zzzz + u_xlat0;\n\
        u_xlat0 = u_xlat0 + hlslcc_mtx4x4unity_ObjectToWorld[3];\n\
        u_xlat1 = u_xlat0.yyyy * hlslcc_mtx4x4unity_MatrixVP[1];\n\
        u_xlat1 = hlslcc_mtx4x4unity_MatrixVP[0] * u_xlat0.xxxx + u_xlat1;\n\
        u_xlat1 = hlslcc_mtx4x4unity_MatrixVP[2] * u_xlat0.zzzz + u_xlat1;\n\
        gl_Position = hlslcc_mtx4x4unity_MatrixVP[3] * u_xlat0.wwww + u_xlat1;\n\
        vs_TEXCOORD0.x = dot(unity_LightPosition[0].xyz, hlslcc_mtx4x4unity_WorldToObject[0].xyz);\n\
        return;\n}\n#endif\n#ifdef FRAGMENT\nout vec4 SV_Target0;\nvoid main() { SV_Target0 = vec4(1.0); }\n#endif\n";
    let names = of_stage([text]).expect("understood");
    for array in ["hlslcc_mtx4x4unity_MatrixVP[0]", "UnityPerDraw.hlslcc_mtx4x4unity_ObjectToWorld[0]"] {
        assert!(names.contain(array), "{array}");
        let elements = names.elements(array).expect("an array");
        assert_eq!(elements.fours().collect::<Vec<_>>(), [(0, Order::Columns)], "{array}");
    }
    for array in ["unity_LightPosition[0]", "UnityPerDraw.hlslcc_mtx4x4unity_WorldToObject[0]"] {
        assert!(!names.contain(array), "{array}");
    }
    assert_eq!(of_stage(["#define A(x) layout(location = x) a = b\nvoid main() { A(0); }"]), None);
}

#[test]
fn elements_that_are_chosen_by_a_variable_are_known_by_its_name() {
    let others = |body: &str| {
        let text = format!("uniform mat4 m[4]; uniform int i; in vec4 v; void main() {{ {body} }}");
        let names = of_stage([&*text]).expect("understood");
        names.elements("m[0]").expect("an array").others.clone().map(|(choice, _)| choice)
    };
    let by_uniform = Some(Choice::ByUniform("i".to_owned()));
    assert_eq!(others("gl_Position = m[i] * v;"), by_uniform);
    assert_eq!(others("gl_Position = m[2] * v;"), None);
    assert_eq!(others("vec4 w = m[i] * v; gl_Position = m[1] * w;"), by_uniform);
    for unknown in [
        "gl_Position = m[i + 1] * v;",
        "int i = gl_VertexID; gl_Position = m[i] * v;",
        "gl_Position = m[i] * m[gl_VertexID] * v;",
        "mat4 all[4] = m; gl_Position = all[1] * v;",
    ] {
        assert_eq!(others(unknown), Some(Choice::Unknown), "{unknown}");
    }
}

#[test]
fn of_an_array_of_structures_only_the_elements_that_are_named_flow() {
    let text = "struct S { vec4 e; mat4 m; }; uniform S all[4]; in vec4 v; void main() { gl_Position = all[2].m * v; }";
    assert_eq!([1, 2].map(|number| flows(text, &format!("all[{number}].m"))), [false, true]);
    let text = text.replace("all[2]", "all[gl_InstanceID]");
    assert_eq!([1, 2].map(|number| flows(&text, &format!("all[{number}].m"))), [true, true]);
}

#[test]
fn what_is_not_understood_flows() {
    for text in [
        "#include <matrices>\nvoid main() { gl_Position = place(); }",
        "#define SET gl_Position = m * p\nuniform mat4 m; in vec4 p; void main() { SET; }",
        "uniform mat4 é; void main() {}",
    ] {
        assert_eq!(of_stage([text]), None, "{text}");
    }
}

#[test]
fn a_stage_before_counts_as_a_whole() {
    let last = "layout(triangles) in; void main() { gl_Position = gl_in[0].gl_Position; EmitVertex(); }";
    let names = of_stage([last]).and_then(|names| with_all_of(names, "uniform mat4 m; void main() {}"));
    assert!(names.expect("understood").contain("m"));
}
