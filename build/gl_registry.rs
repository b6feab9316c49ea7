//! Translates the OpenGL API, as the Khronos registry describes it, to a typed table of pointers,
//! the enums, and the map of aliases (`glDrawArraysEXT` → `glDrawArrays`).

use super::gl_arrays;
use super::gl_attributes::{self, Declaration};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Commands outside the core versions that Cupola calls if a driver has them.
const EXTRA: &[&str] = &[
    "glBindBufferOffsetEXT",
    "glCheckNamedFramebufferStatusEXT",
    "glClearColorIiEXT",
    "glClearColorIuiEXT",
    "glClearDepthdNV",
    "glClearNamedBufferDataEXT",
    "glClearNamedBufferSubDataEXT",
    "glDeleteObjectARB",
    "glDeleteProgramsARB",
    "glDiscardFramebufferEXT",
    "glFramebufferDrawBufferEXT",
    "glFramebufferDrawBuffersEXT",
    "glFramebufferReadBufferEXT",
    "glGetInfoLogARB",
    "glGetNamedFramebufferAttachmentParameterivEXT",
    "glGetObjectParameterivARB",
    "glGetProgramEnvParameterfvARB",
    "glGetProgramLocalParameterfvARB",
    "glGetProgramStringARB",
    "glGetProgramivARB",
    "glMakeBufferResidentNV",
    "glMakeNamedBufferResidentNV",
    "glMapNamedBufferEXT",
    "glMapNamedBufferRangeEXT",
    "glMatrixFrustumEXT",
    "glMatrixLoadIdentityEXT",
    "glMatrixLoaddEXT",
    "glMatrixLoadfEXT",
    "glMatrixMultdEXT",
    "glMatrixMultfEXT",
    "glMatrixOrthoEXT",
    "glMatrixPopEXT",
    "glMatrixPushEXT",
    "glMatrixRotatedEXT",
    "glMatrixRotatefEXT",
    "glMatrixScaledEXT",
    "glMatrixScalefEXT",
    "glMatrixTranslatedEXT",
    "glMatrixTranslatefEXT",
    "glNamedBufferDataEXT",
    "glNamedBufferStorageEXT",
    "glNamedBufferSubDataEXT",
    "glNamedCopyBufferSubDataEXT",
    "glNamedFramebufferRenderbufferEXT",
    "glNamedFramebufferTexture1DEXT",
    "glNamedFramebufferTexture2DEXT",
    "glNamedFramebufferTexture3DEXT",
    "glNamedFramebufferTextureEXT",
    "glNamedFramebufferTextureLayerEXT",
    "glNamedProgramStringEXT",
    "glPrimitiveRestartIndexNV",
    "glPrimitiveRestartNV",
    "glProgramLocalParameter4fvARB",
    "glProgramStringARB",
    "glTextureBufferEXT",
    "glTextureBufferRangeEXT",
    "glUnmapNamedBufferEXT",
];

/// Returns three Rust sources. The first has `Gl` (table and one method per command), constants,
/// `ALIASES`, and the names of commands outside the core profile and outside OpenGL ES. The second
/// has the commands between `glBegin` and `glEnd`, the third those that change vertex arrays.
pub fn generate() -> [String; 3] {
    let text = std::str::from_utf8(khronos_api::GL_XML).expect("the registry is UTF-8");
    let document = roxmltree::Document::parse(text).expect("the registry is well-formed XML");
    let root = document.root_element();
    let wanted = wanted_commands(root);
    let mut out = String::new();
    enums(root, &mut out);
    let commands = declarations(root, |name, alias| {
        let family = gl_attributes::is_attribute(name) || gl_arrays::is_array_state(name);
        wanted.contains(name) || EXTRA.contains(&name) || (!alias && family)
    });
    table(&commands, &mut out);
    core_commands(root, &commands, &mut out);
    aliases(root, &mut out);
    outside(root, &commands, &mut out);
    let declarations: Vec<Declaration> = commands.into_iter().map(|(declaration, _)| declaration).collect();
    [out, gl_attributes::generate(&declarations), gl_arrays::generate(&declarations)]
}

fn wanted_commands<'a>(root: roxmltree::Node<'a, '_>) -> BTreeSet<&'a str> {
    let mut wanted = BTreeSet::new();
    for feature in root.children().filter(|n| n.has_tag_name("feature")) {
        if !matches!(feature.attribute("api"), Some("gl" | "gles2")) {
            continue;
        }
        for require in feature.children().filter(|n| n.has_tag_name("require")) {
            for command in require.children().filter(|n| n.has_tag_name("command")) {
                wanted.insert(command.attribute("name").expect("a command has a name"));
            }
        }
    }
    wanted
}

/// Returns the version (10 · major + minor) in which each command came to an API's core profile,
/// without commands that a later version removed.
fn core_versions<'a>(root: roxmltree::Node<'a, '_>, api: &str) -> BTreeMap<&'a str, u32> {
    let mut versions = BTreeMap::new();
    let mut removed = BTreeSet::new();
    for feature in root.children().filter(|n| n.has_tag_name("feature") && n.attribute("api") == Some(api)) {
        let number = feature.attribute("number").expect("a feature has a version").replace('.', "");
        let number = number.parse().expect("a version is two digits");
        for part in feature.children() {
            for command in part.children().filter(|n| n.has_tag_name("command")) {
                let name = command.attribute("name").expect("a command has a name");
                if part.has_tag_name("remove") {
                    removed.insert(name);
                } else {
                    versions.entry(name).or_insert(number);
                }
            }
        }
    }
    versions.retain(|name, _| !removed.contains(name));
    versions
}

/// Writes the method that returns a command of the core profile that a driver lacks.
fn core_commands(root: roxmltree::Node, commands: &[(Declaration, String)], out: &mut String) {
    let (gl, es) = (core_versions(root, "gl"), core_versions(root, "gles2"));
    let checks = |versions: &BTreeMap<&str, u32>| -> String {
        let core = commands.iter().filter_map(|(command, _)| Some((command, versions.get(&*command.name)?)));
        core.map(|(Declaration { name, method, .. }, version)| {
            format!("            if version >= {version} && self.{method}.is_null() {{ return Some(\"{name}\"); }}\n")
        })
        .collect()
    };
    writeln!(
        out,
        "impl Gl {{\n    /// A command that the core profile of this version (10 · major + minor) has and the driver lacks.\n    \
         pub fn missing_command(&self, is_gles: bool, version: u32) -> Option<&'static str> {{\n        if is_gles {{\n{}        \
         }} else {{\n{}        }}\n        None\n    }}\n}}",
        checks(&es),
        checks(&gl)
    )
    .expect("writing to a String");
}

/// Returns the commands of an API's versions and extensions, by their core names. `extensions` is
/// the registry's word for extensions of this API.
fn commands_of(root: roxmltree::Node, api: &str, extensions: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for part in root.descendants().filter(|n| n.has_tag_name("require") || n.has_tag_name("remove")) {
        let of = part.parent().expect("it lies in a version or an extension");
        let is_of_api = if of.has_tag_name("feature") {
            of.attribute("api") == Some(api)
        } else {
            of.attribute("supported").is_some_and(|apis| apis.split('|').any(|api| api == extensions))
        };
        for command in part.children().filter(|n| is_of_api && n.has_tag_name("command")) {
            let name = command.attribute("name").expect("a command has a name");
            if part.has_tag_name("require") {
                found.insert(name);
            } else {
                found.remove(name);
            }
        }
    }
    let aliases: BTreeMap<String, String> = alias_pairs(root).into_iter().collect();
    let core_name = |mut name: String| {
        while let Some(target) = aliases.get(&name) {
            name = target.clone();
        }
        name
    };
    found.into_iter().map(|name| core_name(name.to_owned())).collect()
}

/// Writes the commands that the core profile of OpenGL does not have, and those that OpenGL ES does
/// not have.
fn outside(root: roxmltree::Node, commands: &[(Declaration, String)], out: &mut String) {
    for (table, api, extensions) in [("OUTSIDE_CORE", "gl", "glcore"), ("OUTSIDE_ES", "gles2", "gles2")] {
        let inside = commands_of(root, api, extensions);
        let names: BTreeSet<&str> = commands.iter().map(|(declaration, _)| &*declaration.name).collect();
        let names: Vec<&str> = names.into_iter().filter(|name| !inside.contains(*name)).collect();
        writeln!(out, "const {table}: [&str; {}] = {names:?};", names.len()).expect("writing to a String");
    }
}

fn enums(root: roxmltree::Node, out: &mut String) {
    let mut seen = BTreeSet::new();
    for group in root.children().filter(|n| n.has_tag_name("enums")) {
        for item in group.children().filter(|n| n.has_tag_name("enum")) {
            if matches!(item.attribute("api"), Some(api) if api != "gl") {
                continue;
            }
            let (Some(name), Some(value)) = (item.attribute("name"), item.attribute("value")) else { continue };
            let parsed = match value.strip_prefix("0x") {
                Some(hex) => u64::from_str_radix(hex, 16).ok(),
                None => value.parse::<u64>().ok(),
            };
            if let Some(number) = parsed.filter(|v| *v <= u64::from(u32::MAX))
                && seen.insert(name)
            {
                writeln!(out, "pub const {name}: u32 = {number};").expect("writing to a String");
            }
        }
    }
}

/// Returns the commands that are `wanted` (by name, and by whether they are aliases), each with the
/// type of its result.
fn declarations(root: roxmltree::Node, wanted: impl Fn(&str, bool) -> bool) -> Vec<(Declaration, String)> {
    let list = root.children().find(|n| n.has_tag_name("commands")).expect("the registry lists commands");
    let mut found = Vec::new();
    for command in list.children().filter(|n| n.has_tag_name("command")) {
        let proto = command.children().find(|n| n.has_tag_name("proto")).expect("a command has a prototype");
        let name = child_text(proto, "name");
        let alias = command.children().any(|n| n.has_tag_name("alias"));
        if !wanted(&name, alias) {
            continue;
        }
        let result = rust_type(&declaration(proto));
        let parameters: Vec<(String, String)> = command
            .children()
            .filter(|n| n.has_tag_name("param"))
            .map(|p| (format!("p_{}", snake_case(&child_text(p, "name"))), rust_type(&declaration(p))))
            .collect();
        let method = snake_case(name.strip_prefix("gl").expect("a GL command begins with gl"));
        found.push((Declaration { name, method, parameters }, result));
    }
    found
}

fn table(commands: &[(Declaration, String)], out: &mut String) {
    let mut fields = String::new();
    let mut loads = String::new();
    let mut methods = String::new();
    for (Declaration { name, method, parameters }, result) in commands {
        let types = parameters.iter().map(|p| p.1.as_str()).collect::<Vec<_>>().join(", ");
        let typed = parameters.iter().map(|p| format!("{}: {}", p.0, p.1)).collect::<Vec<_>>().join(", ");
        let names = parameters.iter().map(|p| p.0.as_str()).collect::<Vec<_>>().join(", ");
        let arrow = if result == "()" { String::new() } else { format!(" -> {result}") };
        let absent = match result.as_str() {
            "()" => "",
            r if r.starts_with('*') => " std::ptr::null_mut::<c_void>().cast()",
            _ => " 0",
        };
        writeln!(fields, "    {method}: *const c_void,").expect("writing to a String");
        writeln!(loads, "            {method}: load(c\"{name}\"),").expect("writing to a String");
        writeln!(
            methods,
            "    #[inline] pub unsafe fn {method}(&self, {typed}){arrow} {{\n        \
             if self.{method}.is_null() {{ return{absent}; }}\n        \
             let f: unsafe extern \"system\" fn({types}){arrow} = unsafe {{ std::mem::transmute(self.{method}) }};\n        \
             unsafe {{ f({names}) }}\n    }}\n    \
             #[inline] pub fn has_{method}(&self) -> bool {{ !self.{method}.is_null() }}"
        )
        .expect("writing to a String");
    }
    write!(
        out,
        "pub struct Gl {{\n{fields}}}\nimpl Gl {{\n    \
         pub fn load(mut load: impl FnMut(&std::ffi::CStr) -> *const c_void) -> Self {{\n        Self {{\n{loads}        }}\n    }}\n{methods}}}\n"
    )
    .expect("writing to a String");
}

/// Returns each alias with the name of the command for which it is an alias.
fn alias_pairs(root: roxmltree::Node) -> Vec<(String, String)> {
    let list = root.children().find(|n| n.has_tag_name("commands")).expect("the registry lists commands");
    let mut pairs = Vec::new();
    for command in list.children().filter(|n| n.has_tag_name("command")) {
        let proto = command.children().find(|n| n.has_tag_name("proto")).expect("a command has a prototype");
        if let Some(alias) = command.children().find(|n| n.has_tag_name("alias")) {
            let target = alias.attribute("name").expect("an alias has a name").to_owned();
            pairs.push((child_text(proto, "name"), target));
        }
    }
    pairs.sort();
    pairs
}

fn aliases(root: roxmltree::Node, out: &mut String) {
    let pairs = alias_pairs(root);
    writeln!(out, "pub static ALIASES: [(&str, &str); {}] = [", pairs.len()).expect("writing to a String");
    for (alias, target) in &pairs {
        writeln!(out, "    ({alias:?}, {target:?}),").expect("writing to a String");
    }
    out.push_str("];\n");
}

fn child_text(node: roxmltree::Node, tag: &str) -> String {
    let child = node.children().find(|n| n.has_tag_name(tag)).expect("the registry names everything");
    child.text().unwrap_or_default().trim().to_owned()
}

/// Returns the C declaration without the declared name.
fn declaration(node: roxmltree::Node) -> String {
    let mut text = String::new();
    for part in node.children() {
        if !part.has_tag_name("name") {
            text.push_str(part.text().unwrap_or_default());
            text.push(' ');
        }
    }
    text
}

fn rust_type(declaration: &str) -> String {
    let constant = declaration.contains("const");
    let stars = declaration.matches('*').count();
    let base = declaration.replace(['*', ','], " ");
    let base = base.split_whitespace().find(|w| !matches!(*w, "const" | "struct")).unwrap_or("void");
    let scalar = match base {
        "void" | "GLvoid" | "_cl_context" | "_cl_event" => "c_void",
        "GLenum" | "GLbitfield" | "GLuint" | "GLhandleARB" => "u32",
        "GLint" | "GLsizei" | "GLfixed" | "GLclampx" => "i32",
        "GLboolean" | "GLubyte" => "u8",
        "GLchar" | "GLcharARB" => "c_char",
        "GLbyte" => "i8",
        "GLshort" => "i16",
        "GLushort" | "GLhalfNV" | "GLhalf" => "u16",
        "GLfloat" | "GLclampf" => "f32",
        "GLdouble" | "GLclampd" => "f64",
        "GLintptr" | "GLsizeiptr" | "GLintptrARB" | "GLsizeiptrARB" | "GLvdpauSurfaceNV" => "isize",
        "GLint64" | "GLint64EXT" => "i64",
        "GLuint64" | "GLuint64EXT" => "u64",
        "GLsync"
        | "GLeglImageOES"
        | "GLDEBUGPROC"
        | "GLDEBUGPROCARB"
        | "GLDEBUGPROCKHR"
        | "GLDEBUGPROCAMD"
        | "GLVULKANPROCNV"
        | "GLeglClientBufferEXT" => {
            return "*const c_void".to_owned();
        }
        other => panic!("the registry has a type that this build script does not know: {other}"),
    };
    match (stars, scalar) {
        (0, "c_void") => "()".to_owned(),
        (0, _) => scalar.to_owned(),
        (1, _) if constant => format!("*const {scalar}"),
        (1, _) => format!("*mut {scalar}"),
        _ if constant => format!("*const *const {scalar}"),
        _ => format!("*mut *mut {scalar}"),
    }
}

/// `DrawElementsBaseVertex` → `draw_elements_base_vertex`, `Uniform4fv` → `uniform4fv`.
fn snake_case(name: &str) -> String {
    let letters: Vec<char> = name.chars().collect();
    let mut out = String::new();
    for (i, c) in letters.iter().enumerate() {
        let after_lower = i > 0 && (letters[i - 1].is_lowercase() || letters[i - 1].is_ascii_digit());
        let before_lower =
            i > 0 && letters[i - 1].is_uppercase() && letters.get(i + 1).is_some_and(|n| n.is_lowercase());
        if c.is_uppercase() && (after_lower || before_lower) {
            out.push('_');
        }
        out.extend(c.to_lowercase());
    }
    out
}
