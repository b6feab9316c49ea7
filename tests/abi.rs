//! The C interface: the committed header is what the source says, and compiles as C99 and C++17.

use std::path::Path;
use std::process::Command;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A header, its configuration, and the files from which it is generated; modules in them are followed.
const HEADERS: [(&str, &str, &[&str]); 2] = [
    ("cupola.h", "cbindgen.toml", &["version", "status", "rig", "map", "gl/mod"]),
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
    builder.generate().expect("src/ffi is understood").write(&mut text);
    String::from_utf8(text).expect("the header is UTF-8")
}

/// `CUPOLA_WRITE_HEADER=1 cargo test --test abi` writes the headers anew.
#[test]
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
            "include/{name} is not what src/ffi says; write it anew with CUPOLA_WRITE_HEADER=1 cargo test --test abi"
        );
    }
}

/// Compiles `text`; the compiler's messages if it fails.
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

#[test]
fn the_header_is_c99_and_cpp17() {
    assert_eq!(compile("cc", &["-std=c99"], USE), Ok(()));
    assert_eq!(compile("c++", &["-std=c++17"], USE), Ok(()));
}

#[test]
fn a_wrong_use_does_not_compile() {
    let wrong = USE.replace("cupola_rig *rig", "cupola_gl *rig");
    assert!(compile("cc", &["-std=c99"], &wrong).is_err());
    assert!(compile("c++", &["-std=c++17"], &wrong).is_err());
}
