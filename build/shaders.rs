//! Translates WGSL to GLSL 330 and ESSL 300 (and, in `spirv.rs`, to SPIR-V) at build time. So no
//! shader translator is linked into the injected library.
//!
//! The uniform block is cut out of each text. At run time its values are inserted as a constant
//! (see `src/correct/shaders/glsl.rs`).

use crate::constants::Types;
use naga::back::glsl;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ScalarKind, ShaderStage, TypeInner};
use std::fmt::Write;

/// Name, sources and fragment entry points of each pass.
const PASSES: &[(&str, &[&str], &[&str])] = &[
    ("Fisheye", &["common.wgsl", "fisheye.wgsl"], &["present", "map"]),
    ("Projector", &["common.wgsl", "projector.wgsl"], &["present", "map"]),
    ("Optics", &["common.wgsl", "optics.wgsl"], &["present", "map"]),
    ("Perspective", &["common.wgsl", "perspective.wgsl"], &["present", "map"]),
    ("Panorama", &["common.wgsl", "panorama.wgsl"], &["present", "map"]),
    ("Table", &["common.wgsl", "table.wgsl"], &["present", "map"]),
    ("Mesh", &["common.wgsl", "mesh.wgsl"], &["present", "map"]),
    ("Black", &["black.wgsl"], &["present"]),
];

/// Name and source of the arrangements of the views' pictures. OpenGL has only the first.
const ARRANGEMENTS: [(&str, &str); 3] = [("Atlas", "atlas.wgsl"), ("Layers", "layers.wgsl"), ("Images", "images.wgsl")];

/// Kinds of pictures: true for content; and the source with the position of a direction in them.
const CONTENTS: [(bool, &str); 2] = [(false, "views.wgsl"), (true, "content.wgsl")];

/// Returns Rust source with the generated shader texts, with the SPIR-V modules, and with the types
/// of constants.
pub fn generate() -> [String; 3] {
    let mut types = Types::default();
    let mut out = String::from("static PASSES: &[PassText] = &[\n");
    let mut modules = String::from("static MODULES: &[PassModules] = &[\n");
    for (name, files, entries) in PASSES {
        // The black pass samples no picture.
        let with_pictures = files.len() > 1;
        let ways = ARRANGEMENTS.iter().flat_map(|arrangement| CONTENTS.map(|content| (*arrangement, content)));
        for ((arrangement, file), (content, place)) in ways {
            let first = arrangement == ARRANGEMENTS[0].0;
            if !with_pictures && (content || !first) {
                continue;
            }
            let pictures = [place, file].into_iter().filter(|_| with_pictures);
            let source: String = files.iter().copied().chain(pictures).map(read).collect();
            let module = naga::front::wgsl::parse_str(&source)
                .unwrap_or_else(|e| panic!("shaders: {name}, {file}: {}", e.emit_to_string(&source)));
            let info = Validator::new(ValidationFlags::all(), Capabilities::default())
                .validate(&module)
                .unwrap_or_else(|e| panic!("shaders: {name}, {file}: {}", e.emit_to_string(&source)));
            if first {
                let members = pass((name, content), entries, &module, &info, &mut out);
                if !content {
                    types.add(name, &module, &members);
                }
            }
            // The map is the same for all arrangements; only the first one gets it.
            let entries: Vec<&str> = entries.iter().copied().filter(|entry| first || *entry == "present").collect();
            crate::spirv::pass((name, content), arrangement, &entries, &module, &mut modules);
        }
    }
    out.push_str("];\n");
    modules.push_str("];\n");
    [out, modules, types.source()]
}

/// Returns Rust source with the compute shader that scales counts of queries, as SPIR-V.
pub fn queries() -> String {
    let source = read("queries.wgsl");
    let module = naga::front::wgsl::parse_str(&source)
        .unwrap_or_else(|e| panic!("shaders: queries.wgsl: {}", e.emit_to_string(&source)));
    crate::spirv::compute("tell", &module)
}

fn read(file: &str) -> String {
    std::fs::read_to_string(format!("shaders/{file}")).unwrap_or_else(|e| panic!("shaders/{file}: {e}"))
}

/// Appends the texts of one pass. Returns path and number of scalars of each member of its
/// constants.
fn pass(
    (name, content): (&str, bool),
    entries: &[&str],
    module: &Module,
    info: &ModuleInfo,
    out: &mut String,
) -> Vec<(String, usize)> {
    let constants = module.global_variables.iter().find(|(_, v)| v.name.as_deref() == Some("constants"));
    let mut members = Vec::new();
    let mut constructor = String::new();
    if let Some((_, variable)) = constants {
        walk(module, variable.ty, "", &mut members, &mut constructor);
    }
    writeln!(out, "PassText {{ pass: Pass::{name}, content: {content}, constructor: {constructor:?}, texts: &[")
        .expect("writing to a String");
    for (language, version) in [
        ("Glsl330", glsl::Version::Desktop(330)),
        ("Essl300", glsl::Version::Embedded { version: 300, is_webgl: false }),
    ] {
        let (vertex, _) = emit(module, info, ShaderStage::Vertex, "rectangle", version);
        for entry in entries {
            let (fragment, samplers) = emit(module, info, ShaderStage::Fragment, entry, version);
            let stage = if *entry == "map" { "Map" } else { "Present" };
            writeln!(
                out,
                "StageText {{ language: Language::{language}, stage: Stage::{stage}, vertex: {vertex:?}, fragment: {:?}, samplers: &{samplers:?} }},",
                cut(&fragment)
            )
            .expect("writing to a String");
        }
    }
    out.push_str("]},\n");
    members
}

/// Returns the text of an entry point, and its combined samplers: uniform name and texture name.
fn emit(
    module: &Module,
    info: &ModuleInfo,
    stage: ShaderStage,
    entry: &str,
    version: glsl::Version,
) -> (String, Vec<(String, String)>) {
    // No coordinate adjustment: Cupola sets the direction of y itself.
    let options = glsl::Options { version, writer_flags: glsl::WriterFlags::empty(), ..Default::default() };
    let pipeline = glsl::PipelineOptions { shader_stage: stage, entry_point: entry.to_owned(), multiview: None };
    let mut text = String::new();
    let policies = naga::proc::BoundsCheckPolicies::default();
    let mut writer = glsl::Writer::new(&mut text, module, info, &options, &pipeline, policies)
        .unwrap_or_else(|e| panic!("shaders: {entry}: {e}"));
    let reflection = writer.write().unwrap_or_else(|e| panic!("shaders: {entry}: {e}"));
    // The rectangles are flat, so both interpolations are equal, and `noperspective` saves a
    // division in each pixel. WGSL has a word for it (`linear`), but with this word naga refuses
    // ESSL 300, which has none.
    if !version.is_es() {
        text = text.replace("smooth in ", "noperspective in ").replace("smooth out ", "noperspective out ");
    }
    let mut samplers: Vec<(String, String)> = reflection
        .texture_mapping
        .iter()
        .map(|(uniform, mapping)| {
            (uniform.clone(), module.global_variables[mapping.texture].name.clone().unwrap_or_default())
        })
        .collect();
    samplers.sort();
    (text, samplers)
}

/// Returns the text before the uniform block, the type and name of the constant, and the text after
/// the block.
fn cut(text: &str) -> (String, String, String) {
    let Some(start) = text.find("layout(std140) uniform ") else {
        return (text.to_owned(), String::new(), String::new());
    };
    let open = start + text[start..].find('{').expect("a block opens");
    let close = open + text[open..].find("};").expect("a block closes");
    let declaration = text[open + 1..close].trim().trim_end_matches(';');
    (text[..start].to_owned(), declaration.to_owned(), text[close + 2..].to_owned())
}

/// Lists the scalars of a type in the order of a GLSL constructor, and the constructor itself
/// with `%` for a float and `#` for an unsigned number.
fn walk(
    module: &Module,
    handle: naga::Handle<naga::Type>,
    path: &str,
    members: &mut Vec<(String, usize)>,
    out: &mut String,
) {
    let ty = &module.types[handle];
    match ty.inner {
        TypeInner::Scalar(scalar) => {
            members.push((path.to_owned(), 1));
            out.push(if scalar.kind == ScalarKind::Uint { '#' } else { '%' });
        }
        TypeInner::Vector { size, .. } => {
            members.push((path.to_owned(), size as usize));
            write!(out, "vec{}({})", size as usize, vec!["%"; size as usize].join(",")).expect("writing to a String");
        }
        TypeInner::Matrix { columns, rows, .. } => {
            let count = columns as usize * rows as usize;
            members.push((path.to_owned(), count));
            write!(out, "mat{}x{}({})", columns as usize, rows as usize, vec!["%"; count].join(","))
                .expect("writing to a String");
        }
        TypeInner::Array { base, size: naga::ArraySize::Constant(count), .. } => {
            let mut elements = Vec::new();
            for i in 0..count.get() {
                let mut element = String::new();
                walk(module, base, &format!("{path}[{i}]"), members, &mut element);
                elements.push(element);
            }
            let name = match &module.types[base].inner {
                TypeInner::Vector { size, .. } => format!("vec{}", *size as usize),
                _ => module.types[base].name.clone().expect("a structure has a name"),
            };
            write!(out, "{name}[{}]({})", count, elements.join(",")).expect("writing to a String");
        }
        TypeInner::Struct { members: ref list, .. } => {
            let mut parts = Vec::new();
            for member in list {
                let name = member.name.as_deref().expect("a member has a name");
                let inner = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
                let mut part = String::new();
                walk(module, member.ty, &inner, members, &mut part);
                parts.push(part);
            }
            write!(out, "{}({})", ty.name.as_deref().expect("a structure has a name"), parts.join(","))
                .expect("writing to a String");
        }
        ref other => panic!("shaders: {path}: a type that constants cannot have: {other:?}"),
    }
}
