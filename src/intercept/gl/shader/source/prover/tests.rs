//! Texts that are proven, and texts that must not be proven.

use crate::intercept::gl::shader::source::prover::Factor;
use crate::intercept::gl::shader::source::prover::PositionArray;
use crate::intercept::gl::shader::source::prover::Proof;
use crate::intercept::gl::shader::source::prover::prove;

fn proof(factors: &[&str], attribute: &str, components: usize) -> Option<Proof> {
    let factor = |name: &&str| match *name {
        "MV" => Factor::ModelView,
        "P" => Factor::Projection,
        name => Factor::Uniform(name.to_owned()),
    };
    let attribute = match attribute {
        "" => PositionArray::Conventional,
        name => PositionArray::Named(name.to_owned()),
    };
    Some(Proof { factors: factors.iter().map(factor).collect(), attribute, components })
}

const HEAD: &str = "uniform mat4 p, v; uniform float t; attribute vec2 a2; attribute vec3 a; attribute vec4 a4;\n";

/// Returns the proof for a `main` with these statements.
fn of(statements: &str) -> Option<Proof> {
    prove(&format!("{HEAD}void main() {{ {statements} }}"), false)
}

#[test]
fn products_of_matrices_and_an_attribute_are_proven() {
    let whole = proof(&["p", "v"], "a", 3);
    for statements in [
        "gl_Position = p * v * vec4(a, 1.0);",
        "gl_Position = p * (v * vec4(a.xyz, 1));",
        "mat4 m = p * v; gl_Position = (m) * vec4(a.x, a.y, a.z, 1.0f);",
        "vec4 eye = v * vec4(a, 1.0); float f = length(eye.xyz); gl_Position = p * eye;",
        "vec4 eye; eye = v * vec4(a, 1.0); gl_Position = p * eye; eyes = eye; fog = gl_Position.z;",
        "if (t > 0.5) { t2 = 1.0; } gl_Position = p * v * vec4(a, 1.); if (gl_Position.w < 1.0) u = a;",
    ] {
        assert_eq!(of(statements), whole, "{statements}");
    }
    assert_eq!(of("gl_Position = p * a4;"), proof(&["p"], "a4", 4));
    assert_eq!(of("gl_Position = p * vec4(a2, 0.0, 1.0);"), proof(&["p"], "a2", 2));
    assert_eq!(of("gl_Position = p * vec4(a.xy, 0.0, 1.0);"), proof(&["p"], "a", 2));
    assert_eq!(of("gl_Position = a4;"), proof(&[], "a4", 4));
}

#[test]
fn names_of_the_fixed_function_pipeline_are_proven() {
    for statements in ["gl_Position = ftransform();", "gl_Position = gl_ModelViewProjectionMatrix * gl_Vertex;"] {
        assert_eq!(of(statements), proof(&["P", "MV"], "", 4), "{statements}");
    }
    let statements = "vec4 e = gl_ModelViewMatrix * vec4(gl_Vertex.xyz, 1.0); gl_Position = gl_ProjectionMatrix * e;";
    assert_eq!(of(statements), proof(&["P", "MV"], "", 3));
}

#[test]
fn blocks_and_dialects_are_proven() {
    let text = "#version 330\nlayout(std140) uniform Camera { vec4 unused; mat4 p; } camera;\n\
        uniform Free { mat4 v; };\n#ifdef OLD\nattribute vec3 a;\n#else\nlayout(location = 0) in vec3 a;\n#endif\n\
        out gl_PerVertex { vec4 gl_Position; }; out vec3 shade;\n\
        void main() { shade = a; gl_Position = camera.p * v * vec4(a, 1.0); }";
    assert_eq!(prove(text, false), proof(&["Camera.p", "v"], "a", 3));
}

#[test]
fn everything_else_is_not() {
    for statements in [
        // Another form of position.
        "gl_Position = p * vec4(a + t, 1.0);",
        "gl_Position = p * vec4(a * t, 1.0);",
        "gl_Position = p * vec4(a, t);",
        "gl_Position = p * vec4(a, 0.5);",
        "gl_Position = p * vec4(a.zyx, 1.0);",
        "gl_Position = p * vec4(a.xy, 1.0, 1.0);",
        "gl_Position = p * vec4(a2, 1.0, 1.0);",
        "gl_Position = p * vec4(a2, a.z, 1.0);",
        "gl_Position = vec4(a, 1.0) * p;",
        "gl_Position = p * a4 * p;",
        "gl_Position = p * a4 + a4;",
        "gl_Position = p[0] * a4;",
        "gl_Position = p * t * a4;",
        "gl_Position = p * f(a4);",
        "gl_Position = p;",
        "gl_Position = q * a4;",
        // Positions that are written again, or only under a condition.
        "gl_Position = p * a4; gl_Position.y = -gl_Position.y;",
        "gl_Position = p * a4; gl_Position *= 2.0;",
        "gl_Position = p * a4; gl_Position[1] += 2.0;",
        "if (t > 0.0) { gl_Position = p * a4; }",
        "if (t > 0.0) gl_Position = p * a4;",
        "for (int i = 0; i < 2; i++) gl_Position = p * a4;",
        "if (t > 0.0) t2 = 1.0; else gl_Position = p * a4;",
        "vec4 e = v * a4; e.x += t; gl_Position = p * e;",
        "vec4 e = v * a4; if (t > 0.0) e = a4; gl_Position = p * e;",
        "vec4 e = v * a4; e[0]++; gl_Position = p * e;",
        "vec4 e; gl_Position = p * e; e = v * a4;",
        "vec4 e; gl_Position = p * e;",
        "vec4 e = e; gl_Position = p * e;",
        // Names with another meaning.
        "vec4 a4 = vec4(t); gl_Position = p * a4;",
        "vec4 x, a4; a4 = vec4(t); gl_Position = p * a4;",
        "mat4 p = mat4(t); gl_Position = p * a4;",
        "{ vec4 e = a4; } vec4 e = v * a4; gl_Position = p * e;",
        "mat3 e = p * v; gl_Position = e * a4;",
        // Other effects.
        "gl_Position = p * a4; gl_PointSize = 9.0;",
        "gl_Position = p * a4; gl_Layer = 1;",
        "",
        "gl_Position = p *",
    ] {
        assert_eq!(of(statements), None, "{statements}");
    }
}

#[test]
fn macros_functions_and_branches_may_hide_the_truth() {
    let main = "void main() { gl_Position = p * a4; }";
    let text = |before: &str| format!("{HEAD}{before}\n{main}");
    assert!(prove(&text("#define PI 3.14159\nfloat f(float x) { return x * PI; }"), false).is_some());
    for before in [
        "#define a4 (a4 + vec4(t))",
        "#define shift gl_Position",
        "#define p v",
        "#define mat4 mat3",
        "void f(inout vec4 x) { x = vec4(0.0); }",
        "void f(out vec4 x) { x = vec4(0.0); }",
        "void f() { gl_Position = vec4(0.0); }",
        "float f(vec4 a4) { return a4.x; }",
        "void main() { }",
        "#ifdef TWICE\nuniform vec4 a4;\n#endif",
    ] {
        assert_eq!(prove(&text(before), false), None, "{before}");
    }
    let own = format!("{HEAD}vec4 ftransform() {{ return a4; }} void main() {{ gl_Position = ftransform(); }}");
    assert_eq!(prove(&own, false), None);
    let branches = format!("{HEAD}void main() {{\n#ifdef A\nif (t > 0.0)\n#endif\ngl_Position = p * a4; }}");
    assert_eq!(prove(&branches, false), None);
}

#[test]
fn coarse_numbers_of_opengl_es_are_not_exact_enough() {
    let text = format!("precision mediump float;\n{HEAD}void main() {{ gl_Position = p * a4; }}");
    assert!(prove(&text, false).is_some() && prove(&text, true).is_none());
}

/// If a text is cut, or two of its words are exchanged, nothing fails.
#[test]
fn damaged_texts_do_no_harm() {
    let text = format!(
        "{HEAD}uniform B {{ mat4 m; }} b; void main() {{ vec4 e = b.m * (v * vec4(a, 1.0)); gl_Position = p * e; }}"
    );
    assert!(prove(&text, false).is_some());
    for end in 0..text.len() {
        assert!(prove(&text[..end], false).is_none(), "{}", &text[..end]);
    }
    let marks: Vec<usize> = text.match_indices([' ', '(', ')', ';', '{', '}', ',', '*', '.']).map(|m| m.0).collect();
    for (i, mark) in marks.iter().enumerate() {
        for other in [";", "}", "(", "=", "*", ".", ",", "[", "e"] {
            let mut damaged = text.clone();
            damaged.replace_range(mark..&(mark + 1), other);
            _ = prove(&damaged, i % 2 == 0);
        }
    }
}
