//! The fixed-function pipeline's vertex stage as a shader (OpenGL 2.1, sections 2.11 to 2.14), for
//! one state of its switches.
//!
//! The position is the same as that of the pipeline, for the stages that follow. Values (lights,
//! materials, planes, matrices) come from GLSL's own uniforms.

use crate::backend::gl::driver::api;
use crate::intercept::gl::state::projected_vertices::fixed_pipeline::{Followed, Generated, Lighting, Pipeline};
use std::fmt::Write;

/// Light of one source. The sources are uniforms, which functions of GLSL 1.20 take by value.
const SHARE: &str = "void cupola_light(gl_LightSourceParameters light, vec3 eye, vec3 n, vec3 viewer, float shininess, inout vec4 ambient, inout vec4 diffuse, inout vec4 specular) {
vec3 to = light.position.xyz;
float strength = 1.0;
if (light.position.w != 0.0) {
to = to / light.position.w - eye;
float d = length(to);
strength = 1.0 / (light.constantAttenuation + light.linearAttenuation * d + light.quadraticAttenuation * d * d);
}
to = normalize(to);
if (light.spotCutoff != 180.0) {
float along = dot(-to, normalize(light.spotDirection));
strength *= along < light.spotCosCutoff ? 0.0 : (light.spotExponent == 0.0 ? 1.0 : pow(max(along, 0.0), light.spotExponent));
}
float facing = dot(n, to);
ambient += strength * light.ambient;
if (facing > 0.0) {
float shine = max(dot(n, normalize(to + viewer)), 0.0);
diffuse += strength * facing * light.diffuse;
specular += strength * (shininess == 0.0 ? 1.0 : (shine > 0.0 ? pow(shine, shininess) : 0.0)) * light.specular;
}
}
";

/// Returns the text of the shader, without the projection to a lens.
pub fn text(pipeline: &Pipeline) -> String {
    let mut text = "#version 120\n".to_owned();
    if pipeline.lighting.is_some() {
        text.push_str(SHARE);
    }
    text.push_str("void main() {\nvec4 eye = gl_ModelViewMatrix * gl_Vertex;\nvec3 n = gl_NormalMatrix * gl_Normal;\n");
    if pipeline.rescaled && !pipeline.normalised {
        text.push_str("n *= gl_NormalScale;\n");
    }
    if pipeline.normalised {
        text.push_str("n = normalize(n);\n");
    }
    match &pipeline.lighting {
        Some(lighting) => light(&mut text, lighting),
        None => {
            for side in ["Front", "Back"] {
                let _ = writeln!(
                    text,
                    "gl_{side}Color = clamp(gl_Color, 0.0, 1.0);\ngl_{side}SecondaryColor = clamp(gl_SecondaryColor, 0.0, 1.0);"
                );
            }
        }
    }
    coordinates(&mut text, pipeline);
    match pipeline.fog {
        Some(true) => text.push_str("gl_FogFragCoord = gl_FogCoord;\n"),
        Some(false) => text.push_str("gl_FogFragCoord = abs(eye.z / eye.w);\n"),
        None => {}
    }
    if pipeline.clipped {
        text.push_str("gl_ClipVertex = eye;\n");
    }
    text.push_str("gl_Position = gl_ModelViewProjectionMatrix * gl_Vertex;\n}\n");
    text
}

fn light(text: &mut String, lighting: &Lighting) {
    text.push_str("vec3 at = eye.xyz / eye.w;\n");
    let viewer = if lighting.local_viewer { "normalize(-at)" } else { "vec3(0.0, 0.0, 1.0)" };
    let _ = writeln!(text, "vec3 viewer = {viewer};\nvec4 ambient, diffuse, specular, colour, highlight;");
    let sides: &[(&str, &str, u32)] = match lighting.two_sided {
        true => &[("Front", "n", api::GL_FRONT), ("Back", "-n", api::GL_BACK)],
        false => &[("Front", "n", api::GL_FRONT)],
    };
    for (side, normal, face) in sides {
        let of = |property: u32, name: &str| match lighting.followed {
            Some(followed) if follows(followed, *face, property) => "gl_Color".to_owned(),
            _ => format!("gl_{side}Material.{name}"),
        };
        let (own_ambient, own_diffuse) = (of(api::GL_AMBIENT, "ambient"), of(api::GL_DIFFUSE, "diffuse"));
        let (own_specular, emission) = (of(api::GL_SPECULAR, "specular"), of(api::GL_EMISSION, "emission"));
        text.push_str("ambient = gl_LightModel.ambient;\ndiffuse = vec4(0.0);\nspecular = vec4(0.0);\n");
        for number in (0..8).filter(|number| lighting.lights >> number & 1 != 0) {
            let _ = writeln!(
                text,
                "cupola_light(gl_LightSource[{number}], at, {normal}, viewer, gl_{side}Material.shininess, ambient, diffuse, specular);"
            );
        }
        let _ = writeln!(
            text,
            "colour = {emission} + {own_ambient} * ambient + {own_diffuse} * diffuse;\nhighlight = {own_specular} * specular;"
        );
        if !lighting.separate_specular {
            text.push_str("colour += highlight;\nhighlight = vec4(0.0);\n");
        }
        let _ = writeln!(
            text,
            "gl_{side}Color = clamp(vec4(colour.rgb, {own_diffuse}.a), 0.0, 1.0);\ngl_{side}SecondaryColor = clamp(vec4(highlight.rgb, 0.0), 0.0, 1.0);"
        );
    }
    if !lighting.two_sided {
        text.push_str("gl_BackColor = gl_FrontColor;\ngl_BackSecondaryColor = gl_FrontSecondaryColor;\n");
    }
}

/// True if `property` of `face` follows the current colour.
fn follows(followed: Followed, face: u32, property: u32) -> bool {
    let both = followed.property == api::GL_AMBIENT_AND_DIFFUSE;
    (followed.face == face || followed.face == api::GL_FRONT_AND_BACK)
        && (followed.property == property || both && matches!(property, api::GL_AMBIENT | api::GL_DIFFUSE))
}

fn coordinates(text: &mut String, pipeline: &Pipeline) {
    let made = |wanted: &[Generated]| pipeline.units.iter().flatten().flatten().any(|made| wanted.contains(made));
    if made(&[Generated::Sphere, Generated::Reflection]) {
        text.push_str("vec3 mirrored = reflect(normalize(eye.xyz / eye.w), n);\n");
    }
    if made(&[Generated::Sphere]) {
        text.push_str(
            "vec3 shifted = mirrored + vec3(0.0, 0.0, 1.0);\nvec2 ball = mirrored.xy / max(2.0 * length(shifted), 1e-30) + 0.5;\n",
        );
    }
    for (unit, made) in pipeline.units.iter().enumerate() {
        let Some(made) = made else { continue };
        let parts: Vec<String> = made
            .iter()
            .enumerate()
            .map(|(i, made)| {
                let (letter, axis) = (["s", "t", "r", "q"][i], ["S", "T", "R", "Q"][i]);
                match made {
                    Generated::Object => format!("dot(gl_ObjectPlane{axis}[{unit}], gl_Vertex)"),
                    Generated::Eye => format!("dot(gl_EyePlane{axis}[{unit}], eye)"),
                    // OpenGL defines these modes for these coordinates only. For others the program
                    // gets an error.
                    Generated::Sphere if i < 2 => format!("ball.{}", ["x", "y"][i]),
                    Generated::Reflection if i < 3 => format!("mirrored.{}", ["x", "y", "z"][i]),
                    Generated::Normal if i < 3 => format!("n.{}", ["x", "y", "z"][i]),
                    _ => format!("gl_MultiTexCoord{unit}.{letter}"),
                }
            })
            .collect();
        let _ = writeln!(text, "gl_TexCoord[{unit}] = gl_TextureMatrix[{unit}] * vec4({});", parts.join(", "));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_off_costs_nothing() {
        let text = text(&Pipeline::default());
        for word in ["LightSource", "TexCoord", "FogFragCoord", "ClipVertex", "normalize"] {
            assert!(!text.contains(word), "{word} in {text}");
        }
    }

    #[test]
    fn properties_follow_the_colour_on_their_faces_only() {
        let followed = Some(Followed { face: api::GL_FRONT, property: api::GL_AMBIENT_AND_DIFFUSE });
        let lighting = Lighting { lights: 0b101, two_sided: true, followed, ..Lighting::default() };
        let text = text(&Pipeline { lighting: Some(lighting), ..Pipeline::default() });
        assert!(text.contains("gl_FrontMaterial.emission + gl_Color * ambient + gl_Color * diffuse"), "{text}");
        assert!(text.contains("gl_BackMaterial.ambient * ambient + gl_BackMaterial.diffuse * diffuse"), "{text}");
        assert!(text.contains("gl_LightSource[2]") && !text.contains("gl_LightSource[1]"), "{text}");
    }

    #[test]
    fn coordinates_are_made_one_by_one() {
        let mut pipeline = Pipeline::default();
        pipeline.units[1] = Some([Generated::Sphere, Generated::Eye, Generated::Object, Generated::Given]);
        let text = text(&pipeline);
        assert!(
            text.contains(
                "vec4(ball.x, dot(gl_EyePlaneT[1], eye), dot(gl_ObjectPlaneR[1], gl_Vertex), gl_MultiTexCoord1.q)"
            ),
            "{text}"
        );
    }
}
