//! The C interface: the committed headers agree with the source, compile as C99 and C++17, and keep
//! every declaration that was published.

#![deny(dead_code)]

mod harness;

use harness::{missing, tests};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

tests! {
    the_committed_headers_are_in_sync,
    the_header_is_c99_and_cpp17,
    a_wrong_use_does_not_compile,
    the_documentation_has_the_versions,
    what_was_published_stays_as_it_is,
    a_change_of_what_was_published_is_seen,
    each_published_function_is_called_by_a_program_of_that_version,
}

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Name of a header, its configuration, and the source files from which it is generated. A module
/// that one of these files declares belongs to it.
const HEADERS: [(&str, &str, &[&str]); 2] = [
    ("cupola.h", "cbindgen.toml", &["version", "status", "rig", "log", "map", "gl/mod"]),
    ("cupola_vk.h", "cbindgen_vk.toml", &["vk/mod"]),
];

fn header(config: &str, files: &[&str]) -> String {
    let root = Path::new(ROOT);
    let path = root.join("include").join(config);
    let config = cbindgen::Config::from_file(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut builder = cbindgen::Builder::new().with_config(config);
    for file in files {
        builder = builder.with_src(root.join(format!("src/ffi/{file}.rs")));
    }
    let mut text = Vec::new();
    builder.generate().expect("src/ffi can be parsed").write(&mut text);
    String::from_utf8(text).expect("the header is UTF-8")
}

/// `CUPOLA_WRITE_HEADER=1 cargo test --test abi` writes the headers again.
fn the_committed_headers_are_in_sync() {
    for (name, config, files) in HEADERS {
        let path = Path::new(ROOT).join("include").join(name);
        let generated = header(config, files);
        if std::env::var_os("CUPOLA_WRITE_HEADER").is_some() {
            std::fs::write(&path, &generated).expect("include/ is writable");
        }
        let committed = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("include/{name}: {error}"));
        assert!(
            committed == generated,
            "include/{name} does not agree with src/ffi; write it again with CUPOLA_WRITE_HEADER=1 cargo test --test abi"
        );
    }
}

/// Compiles `text`. If that fails, returns the compiler's messages.
fn compile(compiler: &str, arguments: &[&str], text: &str) -> Result<(), String> {
    let extension = if compiler == "c++" { "cpp" } else { "c" };
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let file = directory.join(format!("header-{}-{}.{extension}", arguments[0].trim_start_matches('-'), text.len()));
    std::fs::write(&file, text).expect("the target directory is writable");
    let output = Command::new(compiler)
        .args(arguments)
        .args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "-I"])
        .arg(Path::new(ROOT).join("include"))
        .arg(&file)
        .output()
        .unwrap_or_else(|error| panic!("{compiler}: {error}"));
    if output.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&output.stderr).into_owned()) }
}

const USE: &str = "#include <cupola.h>\nint use(void);\nint use(void) { cupola_rig *rig = 0; return cupola_rig_load(\"fisheye\", &rig) == CUPOLA_OK; }\n";

/// Header of Vulkan itself.
const VULKAN: &str = "/usr/include/vulkan/vulkan_core.h";

/// Whether the header of Vulkan is installed. Without it the test counts as ignored.
fn has_vulkan() -> bool {
    let exists = Path::new(VULKAN).exists();
    if !exists {
        missing("no header of Vulkan (Debian: libvulkan-dev)");
    }
    exists
}

/// Program text with a log callback and structs of both headers.
const CALLBACK: &str = r#"
#ifdef __cplusplus
extern "C"
#endif
void hear(cupola_log_level level, const char *message, void *user);
int use(void);
int use(void)
{
    cupola_gl_view view;
    cupola_vk_view other;
    view.struct_size = sizeof view;
    other.struct_size = sizeof other;
    return cupola_set_log_callback(hear, &view) == CUPOLA_OK && view.struct_size < other.struct_size &&
           cupola_abi_version() == CUPOLA_ABI_VERSION;
}
"#;

fn the_header_is_c99_and_cpp17() {
    assert_eq!(compile("cc", &["-std=c99"], USE), Ok(()));
    assert_eq!(compile("c++", &["-std=c++17"], USE), Ok(()));
    if !has_vulkan() {
        return;
    }
    for order in [["cupola.h", "cupola_vk.h"], ["cupola_vk.h", "cupola.h"]] {
        let both = order.map(|header| format!("#include <{header}>\n")).concat() + CALLBACK;
        assert_eq!(compile("cc", &["-std=c99"], &both), Ok(()));
        assert_eq!(compile("c++", &["-std=c++17"], &both), Ok(()));
    }
}

fn a_wrong_use_does_not_compile() {
    let wrong = USE.replace("cupola_rig *rig", "cupola_gl *rig");
    assert!(compile("cc", &["-std=c99"], &wrong).is_err());
    assert!(compile("c++", &["-std=c++17"], &wrong).is_err());
}

fn the_documentation_has_the_versions() {
    let header = std::fs::read_to_string(Path::new(ROOT).join("include/cupola.h")).expect("a header");
    let number = |name: &str| {
        let line = header.lines().find_map(|line| line.strip_prefix(&format!("#define {name} "))).expect(name);
        line.parse::<u32>().expect("a number")
    };
    let row = format!("| {} | {} |", number("CUPOLA_ABI_VERSION"), number("CUPOLA_API_VERSION"));
    let page = std::fs::read_to_string(Path::new(ROOT).join("docs/embedding.md")).expect("the page");
    assert!(page.contains(&row), "docs/embedding.md has no row {row}");
}

/// Folder with the headers of the first published version, with which programs were compiled.
const FIRST_VERSION: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/abi/0.1");

/// Declarations of a header.
struct Declared {
    /// Functions, types without a body and types of functions, each on one line.
    statements: BTreeSet<String>,
    /// Fields of structs: name of the struct, name of the field.
    fields: Vec<(String, String)>,
    /// Constants: macros and values of enumerations.
    constants: Vec<String>,
}

fn declared(text: &str) -> Declared {
    let mut found = Declared { statements: BTreeSet::new(), fields: Vec::new(), constants: Vec::new() };
    let mut code = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("/*") {
        code.push_str(before);
        rest = after.split_once("*/").expect("the comment ends").1;
    }
    code.push_str(rest);
    let (mut body, mut only_cpp) = (String::new(), false);
    for line in code.lines() {
        if let Some(directive) = line.strip_prefix('#') {
            only_cpp = directive.starts_with("ifdef __cplusplus") || (only_cpp && !directive.starts_with("endif"));
            let name = directive.strip_prefix("define ").and_then(|define| define.split_once(' '));
            found.constants.extend(name.map(|(name, _)| name.to_owned()));
        } else if !only_cpp {
            body.push_str(line);
            body.push('\n');
        }
    }
    let mut lines = body.lines();
    let mut statement = String::new();
    while let Some(line) = lines.next() {
        if let Some(start) = line.strip_suffix('{') {
            let words: Vec<&str> = start.split_whitespace().collect();
            let ["typedef", kind, name] = words[..] else { panic!("not understood: {line}") };
            for inner in lines.by_ref().take_while(|line| !line.starts_with('}')) {
                let inner = inner.trim().trim_end_matches([',', ';']);
                let last = |text: &str| text.rsplit([' ', '*']).next().unwrap_or_default().to_owned();
                match kind {
                    _ if inner.is_empty() => {}
                    "struct" => found.fields.push((name.into(), last(inner.split('[').next().unwrap_or_default()))),
                    _ => found.constants.push(inner.split(' ').next().unwrap_or_default().to_owned()),
                }
            }
            continue;
        }
        statement.push_str(line);
        statement.push(' ');
        if let Some(whole) = statement.trim_end().strip_suffix(';') {
            found.statements.insert(whole.split_whitespace().collect::<Vec<_>>().join(" "));
            statement.clear();
        }
    }
    found
}

/// Returns offset and size of each field and the value of each constant, as the compiler prints
/// them for the headers in `folder`.
fn layout(folder: &Path, header: &str, declared: &Declared) -> String {
    let mut text = format!("#include <stddef.h>\n#include <stdio.h>\n#include <{header}>\nint main(void) {{\n");
    for (name, field) in &declared.fields {
        text += &format!(
            "printf(\"{name}.{field} %zu %zu\\n\", offsetof({name}, {field}), sizeof((({name} *)0)->{field}));\n"
        );
    }
    for constant in &declared.constants {
        text += &format!("printf(\"{constant} %lld\\n\", (long long)({constant}));\n");
    }
    text += "return 0; }\n";
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let name = format!("layout-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let source = program.with_extension("c");
    std::fs::write(&source, text).expect("the target directory is writable");
    let made = Command::new("cc").arg("-I").arg(folder).arg("-o").arg(&program).arg(&source).output();
    let made = made.expect("cc can be started");
    assert!(made.status.success(), "{header}: {}", String::from_utf8_lossy(&made.stderr));
    let output = Command::new(&program).output().expect("the program can be started");
    let _ = (std::fs::remove_file(&program), std::fs::remove_file(&source));
    String::from_utf8(output.stdout).expect("the output is UTF-8")
}

fn what_was_published_stays_as_it_is() {
    for header in ["cupola.h", "cupola_vk.h"] {
        if header == "cupola_vk.h" && !has_vulkan() {
            continue;
        }
        let (first, now) = (Path::new(FIRST_VERSION), Path::new(ROOT).join("include"));
        let read = |folder: &Path| std::fs::read_to_string(folder.join(header)).expect("a header");
        let published = declared(&read(first));
        let missing: Vec<_> = published.statements.difference(&declared(&read(&now)).statements).cloned().collect();
        assert!(missing.is_empty(), "{header} lacks {missing:#?}");
        let (before, after) = (layout(first, header, &published), layout(&now, header, &published));
        assert_eq!(before, after, "{header}");
        // The checks above compared enough declarations.
        let (functions, fields) = if header == "cupola.h" { (20, 30) } else { (14, 50) };
        assert!(published.statements.len() > functions && published.fields.len() > fields, "{header}");
    }
}

fn a_change_of_what_was_published_is_seen() {
    let text = std::fs::read_to_string(Path::new(FIRST_VERSION).join("cupola.h")).expect("a header");
    let published = declared(&text);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("changed-header");
    std::fs::create_dir_all(&folder).expect("the target directory is writable");
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        let text = text.replacen(from, to, 1);
        std::fs::write(folder.join("cupola.h"), &text).expect("the target directory is writable");
        let same = declared(&text).statements.is_superset(&published.statements);
        same && layout(&folder, "cupola.h", &published) == layout(Path::new(FIRST_VERSION), "cupola.h", &published)
    };
    assert!(changed("int32_t x;", "int32_t x; "), "control");
    assert!(!changed("  uint32_t width;", "  uint64_t width;"));
    assert!(!changed("  uint64_t errors;", "  uint32_t added;\n  uint64_t errors;"));
    assert!(!changed("CUPOLA_IO = 3", "CUPOLA_IO = 13"));
    assert!(!changed("#define CUPOLA_RAMP_POWER 2", "#define CUPOLA_RAMP_POWER 3"));
    assert!(!changed("double yaw,", "float yaw,"));
    assert!(!changed("enum cupola_status cupola_rig_free(struct cupola_rig *rig);", ""));
}

/// C programs that the suite also compiles with the headers of the first published version.
const FIRST_PROGRAMS: [&str; 4] =
    ["tests/apps/embed.c", "tests/apps/embed_vertex.c", "tests/apps/vulkan/project.c", "examples/c/vk_dome.c"];

/// Names of the functions that a header declares.
fn functions(header: &str) -> Vec<String> {
    let statements = declared(header).statements.into_iter();
    let names = statements.filter_map(|statement| {
        let (start, _) = statement.split_once('(')?;
        let name = start.rsplit([' ', '*']).next()?;
        name.starts_with("cupola_").then(|| name.to_owned())
    });
    names.collect()
}

/// The functions of `header` that no program of `texts` calls.
fn uncalled(header: &str, texts: &[String]) -> Vec<String> {
    let calls = |text: &String, name: &str| {
        text.match_indices(&format!("{name}(")).any(|(at, _)| {
            let before = text[..at].chars().next_back();
            !before.is_some_and(|letter| letter.is_ascii_alphanumeric() || letter == '_')
        })
    };
    functions(header).into_iter().filter(|name| !texts.iter().any(|text| calls(text, name))).collect()
}

fn each_published_function_is_called_by_a_program_of_that_version() {
    let read = |path: &str| std::fs::read_to_string(Path::new(ROOT).join(path)).expect("a file");
    let texts = FIRST_PROGRAMS.map(read);
    for (header, least) in [("cupola.h", 20), ("cupola_vk.h", 14)] {
        let header = read(&format!("tests/abi/0.1/{header}"));
        assert!(functions(&header).len() >= least, "{:?}", functions(&header));
        assert_eq!(uncalled(&header, &texts), [""; 0]);
    }
    // Control: a function that no program calls is found, also if
    // other names begin with its name.
    let added = "enum cupola_status cupola_rig(struct cupola_rig *rig);\nenum cupola_status load(void);\n\
                 enum cupola_status cupola_rig_save(void);\n";
    assert_eq!(uncalled(added, &texts), ["cupola_rig", "cupola_rig_save"]);
}

fn main() -> std::process::ExitCode {
    harness::run(tests())
}
