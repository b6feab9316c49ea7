//! Questions about its state that OpenGL answers, found by asking.

use super::arguments::SLOTS;
use super::registry::Registry;

/// Parts of the names of state that is left out, with the reason.
const LEFT_OUT: [(&str, &str); 10] = [
    ("INFO_LOG_LENGTH", "texts are the driver's"),
    ("TIMESTAMP", "the time"),
    ("CURRENT_TIME", "the time"),
    ("MEMORY_INFO", "the driver's memory"),
    ("GPU_MEMORY", "the same"),
    ("TEXTURE_FREE_MEMORY", "the same"),
    ("VBO_FREE_MEMORY", "the same"),
    ("RENDERBUFFER_FREE_MEMORY", "the same"),
    ("PROGRAM_BINARY", "binaries of programs are a known limit"),
    ("DEBUG_", "messages are those of the driver's work, which is another"),
];

/// State whose value is a name: suffix of the state's name, and kind of the names.
const NAMES: [(&str, char); 23] = [
    ("ELEMENT_ARRAY_BUFFER_BINDING", 'b'),
    ("FRAMEBUFFER_BINDING", 'f'),
    ("RENDERBUFFER_BINDING", 'r'),
    ("TRANSFORM_FEEDBACK_BINDING", 'x'),
    ("TRANSFORM_FEEDBACK_BUFFER_BINDING", 'b'),
    ("BUFFER_BINDING", 'b'),
    ("TEXTURE_BUFFER_DATA_STORE_BINDING", 'b'),
    ("VERTEX_ARRAY_BINDING", 'v'),
    ("VERTEX_BINDING_BUFFER", 'b'),
    ("SAMPLER_BINDING", 'a'),
    ("PROGRAM_PIPELINE_BINDING", 'g'),
    ("CURRENT_PROGRAM", 'p'),
    ("ACTIVE_PROGRAM", 'p'),
    ("VERTEX_SHADER", 'p'),
    ("FRAGMENT_SHADER", 'p'),
    ("GEOMETRY_SHADER", 'p'),
    ("COMPUTE_SHADER", 'p'),
    ("LIST_INDEX", 'l'),
    ("LIST_BASE", 'l'),
    ("CURRENT_QUERY", 'q'),
    ("OBJECT_NAME", 't'),
    ("IMAGE_BINDING_NAME", 't'),
    ("VERTEX_PROGRAM_BINDING", 'o'),
];

/// Kind of the names that state of these names has as its value.
pub fn names_in(state: &[String]) -> Option<char> {
    state.iter().find_map(|state| {
        let state = state.trim_end_matches("_EXT").trim_end_matches("_ARB").trim_end_matches("_OES");
        let of_texture = state.contains("TEXTURE_BINDING") || state.ends_with("D_BINDING");
        let named = NAMES.iter().find(|(end, _)| state.ends_with(end)).map(|(_, letter)| *letter);
        named.or_else(|| of_texture.then_some('t'))
    })
}

/// Commands that are asked for every value, the alternatives for the text before the value, and the
/// text after it.
const QUESTIONS: [(&[&str], &[&str], &str); 16] = [
    (&["glGetIntegerv", "glGetDoublev"], &[""], "&s"),
    // The first one of several viewports counts.
    (&["glGetIntegeri_v", "glGetInteger64i_v"], &[""], "0 &s"),
    (&["glGetTexParameterfv"], &["0xde1 "], "&s"),
    (&["glGetTexLevelParameteriv"], &["0xde1 0 "], "&s"),
    (&["glGetTexParameteriv"], &["0x8513 "], "&s"),
    (&["glGetTexEnvfv"], &["0x2300 "], "&s"),
    (&["glGetTexEnviv"], &["0x8500 ", "0x8861 "], "&s"),
    (&["glGetTexGendv"], &["0x2000 ", "0x2001 ", "0x2002 ", "0x2003 "], "&s"),
    (
        &["glGetBufferParameteriv"],
        &["0x8892 ", "0x8893 ", "0x88eb ", "0x88ec ", "0x8a11 ", "0x8f36 ", "0x8f37 ", "0x8c8e "],
        "&s",
    ),
    (&["glGetFramebufferAttachmentParameteriv"], &ATTACHMENTS, "&s"),
    (&["glGetFramebufferParameteriv"], &["0x8ca9 "], "&s"),
    (&["glGetRenderbufferParameteriv"], &["0x8d41 "], "&s"),
    (&["glGetQueryiv"], &["0x8914 ", "0x8c2f ", "0x8c87 ", "0x8c88 ", "0x8d6a "], "&s"),
    (&["glGetVertexAttribiv", "glGetVertexAttribdv"], &["0 ", "1 ", "2 "], "&s"),
    (&["glGetLightfv"], &["0x4000 ", "0x4001 "], "&s"),
    (&["glGetMaterialfv"], &["0x404 ", "0x405 "], "&s"),
];

/// Attachments of the framebuffers for reading and drawing.
const ATTACHMENTS: [&str; 16] = [
    "0x8ca8 0x8ce0 ",
    "0x8ca9 0x8ce0 ",
    "0x8ca8 0x8ce1 ",
    "0x8ca9 0x8ce1 ",
    "0x8ca8 0x8d00 ",
    "0x8ca9 0x8d00 ",
    "0x8ca8 0x8d20 ",
    "0x8ca9 0x8d20 ",
    "0x8ca8 0x402 ",
    "0x8ca9 0x402 ",
    "0x8ca8 0x405 ",
    "0x8ca9 0x405 ",
    "0x8ca8 0x1801 ",
    "0x8ca9 0x1801 ",
    "0x8ca8 0x1802 ",
    "0x8ca9 0x1802 ",
];

/// Commands that ask an object for every value: the letter of the object's kind, and the text
/// before the value.
const OF_OBJECTS: [(&str, char, &str); 10] = [
    ("glGetSamplerParameterfv", 'a', ""),
    ("glGetProgramiv", 'p', ""),
    ("glGetShaderiv", 's', ""),
    ("glGetProgramPipelineiv", 'g', ""),
    ("glGetNamedBufferParameteriv", 'b', ""),
    ("glGetTextureParameterfv", 't', ""),
    ("glGetNamedRenderbufferParameteriv", 'r', ""),
    ("glGetNamedFramebufferParameteriv", 'f', ""),
    ("glGetNamedFramebufferAttachmentParameteriv", 'f', "0x8ce0 "),
    ("glGetVertexArrayiv", 'v', ""),
];

/// A question for each existing value; OpenGL refuses most of them.
pub fn candidates(registry: &Registry) -> Vec<String> {
    let mut lines = Vec::new();
    let left_out = |names: &[String]| LEFT_OUT.iter().any(|(part, _)| names.iter().any(|name| name.contains(part)));
    let values = || registry.values.iter().filter(|(_, names)| !left_out(names));
    let mut each = |command: &str, before: &str, after: &str| {
        for (value, names) in values() {
            let kind = names_in(names).map_or(String::new(), |letter| format!("?{letter}"));
            // Names are whole numbers.
            if kind.is_empty() || !command.ends_with("Doublev") {
                lines.push(format!("v{kind} {command} {before}{value:#x} {after}"));
            }
        }
    };
    for (commands, places, after) in QUESTIONS {
        for (place, command) in places.iter().flat_map(|place| commands.iter().map(move |command| (place, command))) {
            each(command, place, after);
        }
    }
    for slot in 0..2 {
        for (command, letter, place) in OF_OBJECTS {
            each(command, &format!("%{letter}{slot} {place}"), "&s");
        }
    }
    for (value, _) in values() {
        lines.push(format!("b glIsEnabled {value:#x}"));
        lines.push(format!("b glIsEnabledi {value:#x} 0"));
        lines.push(format!("v?P glGetPointerv {value:#x} &s"));
    }
    lines.extend(objects());
    lines
}

/// Questions about objects and other state without a value of the registry.
fn objects() -> Vec<String> {
    let mut lines = vec!["v glGetPolygonStipple &s".to_owned(), "p glGetString 0x1f03".to_owned()];
    let kinds = [
        ("Texture", 't'),
        ("Buffer", 'b'),
        ("Framebuffer", 'f'),
        ("Renderbuffer", 'r'),
        ("VertexArray", 'v'),
        ("Query", 'q'),
        ("Sampler", 'a'),
        ("TransformFeedback", 'x'),
        ("ProgramPipeline", 'g'),
        ("Program", 'p'),
        ("Shader", 's'),
        ("List", 'l'),
        ("Sync", 'y'),
    ];
    for (name, letter) in kinds {
        lines.extend((0..SLOTS).map(|slot| format!("b glIs{name} %{letter}{slot}")));
    }
    for plane in 0..6 {
        lines.push(format!("v glGetClipPlane {:#x} &s", 0x3000 + plane));
    }
    for map in (0x0D90..0x0D9A).chain(0x0DB0..0x0DB9) {
        for query in 0x0A00..0x0A03 {
            lines.push(format!("v glGetMapdv {map:#x} {query:#x} &s"));
        }
    }
    for slot in 0..SLOTS {
        lines.push(format!("v glGetAttachedShaders %p{slot} 8 &s &u"));
        lines.push(format!("v glGetProgramInfoLog %p{slot} 64 &u &u"));
        for index in 0..4 {
            lines.push(format!("v glGetActiveUniform %p{slot} {index} 64 &s &s &s &s"));
            lines.push(format!("v glGetActiveAttrib %p{slot} {index} 64 &s &s &s &s"));
        }
        // The shaders choose these locations; the driver chooses the others.
        for location in [0, 40] {
            lines.push(format!("v glGetUniformfv %p{slot} {location} &s"));
        }
        for name in ["u0", "u1", "u2", "u3"] {
            lines.push(format!("s glGetUniformLocation %p{slot} '{name}"));
        }
        lines.push(format!("i glGetAttribLocation %p{slot} 'position"));
    }
    for target in [0x8CA8, 0x8CA9] {
        lines.push(format!("i glCheckFramebufferStatus {target:#x}"));
    }
    lines
}
