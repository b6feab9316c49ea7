//! The rules of `docs/architecture.md` that a machine can check: which module uses which, where
//! `unsafe` and OpenGL are allowed, how long a file may be, which names the library exports.

#[path = "../src/bin/cupola-lab/structure/circles.rs"]
mod circles;
#[path = "architecture/parts.rs"]
mod parts;
#[path = "../src/bin/cupola-lab/structure/rules.rs"]
mod rules;
#[path = "../src/bin/cupola-lab/structure/source.rs"]
mod source;
#[path = "../src/bin/cupola-lab/structure/uses.rs"]
mod uses;

use circles::circles;
use source::{Source, code_of};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;
use uses::Uses;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Each module of the library, and the other modules that it may name. Each may also name `error`
/// and `lock`.
const MAY_USE: [(&str, &[&str]); 24] = [
    ("error", &[]),
    ("system", &[]),
    ("testing", &[]),
    ("fence", &[]),
    ("lock", &[]),
    ("message", &[]),
    ("digest", &[]),
    ("cache", &["digest"]),
    ("geom", &["digest"]),
    ("formats", &["digest", "geom"]),
    ("rig", &["geom", "formats"]),
    ("views", &["cache", "geom", "rig", "warp"]),
    ("warp", &["geom", "formats", "rig"]),
    ("blend", &["geom", "rig", "warp"]),
    ("calibrate", &["geom", "rig", "blend"]),
    ("correct", &["cache", "digest", "geom", "rig", "views", "warp", "blend"]),
    ("backend", &["cache", "correct"]),
    ("ring", &["system"]),
    ("nodes", &["system"]),
    ("runtime", &["cache", "fence", "system", "geom", "rig", "views", "warp", "blend", "correct", "backend"]),
    (
        "intercept",
        &[
            "cache", "digest", "fence", "message", "system", "rig", "ring", "nodes", "views", "correct", "backend",
            "runtime",
        ],
    ),
    ("ffi", &["cache", "fence", "message", "geom", "rig", "views", "warp", "correct", "backend", "runtime"]),
    ("preload", &["fence", "intercept"]),
    ("clock", &[]),
];

/// Folders in which `unsafe` is allowed. `system` wraps the few system calls that the standard
/// library lacks.
const MAY_BE_UNSAFE: [&str; 9] = [
    "src/ffi/",
    "src/intercept/",
    "src/backend/gl/",
    "src/backend/null/",
    "src/backend/vk/",
    "src/preload/",
    "src/clock/",
    "src/system/",
    "src/bin/cupola-lab/trial/",
];

/// Folders that may name OpenGL itself, that is, its constants and the table of its functions: the
/// backend, the interception, the C interface, the runtime, and the laboratory's timing and its
/// reader of Khronos' registry.
const MAY_KNOW_GL: [&str; 7] = [
    "src/backend/gl/",
    "src/backend/null/",
    "src/intercept/gl/",
    "src/ffi/",
    "src/runtime/",
    "src/bin/cupola-lab/trial/",
    "src/bin/cupola-lab/calls/registry.rs",
];

/// Folders that may also name the modules `backend::gl` and `intercept::gl`: the commands and the
/// preload library, which start them, and a test that compares both backends.
const MAY_START_GL: [&str; 3] = ["src/bin/", "src/preload/", "src/backend/vk/tests/"];

/// Folders that may name Vulkan: the backend, the interception, the C interface, the runtime, and
/// the laboratory's timing.
const MAY_KNOW_VULKAN: [&str; 5] =
    ["src/backend/vk/", "src/intercept/vk/", "src/ffi/", "src/runtime/", "src/bin/cupola-lab/trial/"];

/// Crates that only the command uses.
const COMMAND_ONLY: [&str; 9] =
    ["clap", "exr", "httparse", "indicatif", "jpeg_encoder", "noto_sans_mono_bitmap", "pipewire", "rosc", "x11rb"];

/// Files in which f64 may become f32: the values that shaders get, and the pixels of the picture
/// that the simulation writes.
const MAY_ROUND: [&str; 2] = ["src/correct/single.rs", "src/blend/simulation.rs"];

const LONGEST_FILE: usize = 600;

/// Greatest number of Rust files of a folder in `src`, without those of its subfolders.
const MOST_FILES: usize = 12;

/// Folders with more files, and their number. It may only shrink.
const MORE_FILES: [(&str, usize); 4] =
    [("src/backend/tests", 14), ("src/correct/shaders", 13), ("src/intercept/gl/offscreen", 14), ("src/rig/model", 14)];

/// Rooms that depend on their arguments alone, and what they may therefore not use: state of the
/// process. So they can be tested without a process.
const WITHOUT: [(&str, &[&str]); 1] = [("src/intercept/scene", &["src/intercept/process", "src/runtime/cache.rs"])];

/// Rooms with one door: others use the exports of their `mod.rs`, and cannot name the modules
/// inside.
const DOORS: [&str; 3] = [
    "src/intercept/gl/projected_vertices",
    "src/intercept/gl/shader/source/prover",
    "src/intercept/vk/projected_vertices",
];

/// Names that `libcupola.so` may export, besides `cupola_*`.
const ENTRY_POINTS: [&str; 3] = ["__glx_Main", "__egl_Main", "vkNegotiateLoaderLayerInterfaceVersion"];

/// The text files below the given folders.
fn sources(folders: &[&str], extensions: &[&str]) -> Vec<Source> {
    let sources = source::sources(Path::new(ROOT), folders, extensions).expect("files can be read");
    assert!(!sources.is_empty(), "no files below {folders:?}");
    sources
}

/// Whether the code contains `word` as a whole word.
fn has_word(code: &str, word: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(word).any(|(start, _)| {
        !code[..start].chars().next_back().is_some_and(part)
            && !code[start + word.len()..].chars().next().is_some_and(part)
    })
}

/// The modules of the library that the code names by `crate::…` or `cupola::…`, lists in braces
/// included.
fn named_modules(code: &str, prefix: &str) -> BTreeSet<String> {
    let mut modules = BTreeSet::new();
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    for (start, _) in code.match_indices(prefix) {
        let boundary =
            code[..start].chars().next_back().is_none_or(|c| !c.is_alphanumeric() && c != '_' && c != ':' && c != '$');
        if !boundary {
            continue;
        }
        let rest = &code[start + prefix.len()..];
        let Some(list) = rest.strip_prefix('{') else {
            modules.insert(word(rest));
            continue;
        };
        let (mut depth, mut item) = (1, String::new());
        for c in list.chars() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if depth == 0 || (depth == 1 && c == ',') {
                modules.insert(word(item.trim()));
                item.clear();
            } else {
                item.push(c);
            }
            if depth == 0 {
                break;
            }
        }
    }
    modules
}

/// Whether the code has a test attribute. It has no effect in a file that uses the harness of
/// `tests/harness`.
fn is_lost_test(code: &str) -> bool {
    code.contains("#[test]") || code.contains("#[ignore")
}

/// Names of OpenGL in the code: its constants, the table of its functions, and the modules that use
/// it.
#[derive(Debug, Default, PartialEq)]
struct OpenGl {
    constant: bool,
    table: bool,
    module: bool,
}

impl OpenGl {
    fn of(code: &str) -> Self {
        let part = |c: char| c.is_alphanumeric() || c == '_';
        let constant = code.split(|c| !part(c)).any(|word| {
            word.strip_prefix("GL_").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_uppercase()))
        });
        let module = ["backend::", "intercept::"].iter().any(|prefix| {
            let starts = code.match_indices(prefix);
            starts.into_iter().any(|(start, _)| named_modules(&code[start..], prefix).contains("gl"))
        });
        Self { constant, table: has_word(code, "Gl"), module }
    }

    /// First of these names that the file at `path` may not have.
    fn violation(&self, path: &str) -> Option<&'static str> {
        let within = |places: &[&str]| places.iter().any(|place| path.starts_with(place));
        if within(&MAY_KNOW_GL) {
            return None;
        }
        // The options of the command have a value `Gl`, which is not the table. The command's code
        // is safe and so cannot call a function of the table.
        let table = self.table && !path.starts_with("src/bin/");
        let module = self.module && !within(&MAY_START_GL);
        let names =
            [(self.constant, "a constant of OpenGL"), (table, "OpenGL's functions"), (module, "a module of OpenGL")];
        names.into_iter().find_map(|(named, what)| named.then_some(what))
    }
}

/// The modules that a file declares so that other folders can name them: `pub mod`, or `pub(in …)
/// mod`.
fn open_modules(code: &str) -> Vec<&str> {
    let declared = code.lines().filter_map(|line| line.trim().split_once("mod "));
    let open = declared.filter(|(before, _)| before.starts_with("pub"));
    open.map(|(_, rest)| rest.trim_end_matches(|c: char| !c.is_alphanumeric() && c != '_')).collect()
}

/// Folders with more than `most` files. An exception in `more` may have exactly its number of files.
fn crowded(paths: &[&str], most: usize, more: &[(&str, usize)]) -> Vec<String> {
    let mut numbers = BTreeMap::<&str, usize>::new();
    for folder in paths.iter().filter_map(|path| Some(path.rsplit_once('/')?.0)) {
        *numbers.entry(folder).or_default() += 1;
    }
    let exception = |folder: &str| more.iter().find(|(other, _)| *other == folder).map(|(_, number)| *number);
    let large = numbers.iter().filter_map(|(folder, number)| {
        let allowed = exception(folder).unwrap_or(most);
        (*number > allowed).then(|| format!("{folder} has {number} files, more than {allowed}"))
    });
    let smaller = more.iter().filter_map(|(folder, allowed)| {
        let number = numbers.get(folder).copied().unwrap_or(0);
        (number < *allowed).then(|| format!("{folder} has only {number} files: lower its number {allowed} in the list"))
    });
    large.chain(smaller).collect()
}

/// Uses of a room that run to a file or a folder that it may not use.
fn forbidden(uses: &Uses, room: &str, places: &[&str]) -> Vec<String> {
    let within = |path: &str, place: &str| {
        path.strip_prefix(place).is_some_and(|rest| rest.is_empty() || rest.starts_with(['/', '.']))
    };
    let of_room = uses.files.iter().zip(&uses.of).filter(|(file, _)| within(file, room));
    let targets = of_room.flat_map(|(file, targets)| targets.iter().map(move |target| (file, &uses.files[*target])));
    let found = targets.filter(|(_, target)| places.iter().any(|place| within(target, place)));
    found.map(|(file, target)| format!("{file} → {target}")).collect()
}

fn report(findings: &[String]) {
    assert!(findings.is_empty(), "\n{}\n", findings.join("\n"));
}

#[test]
fn modules_use_only_what_they_may() {
    let all: BTreeSet<&str> = MAY_USE.iter().map(|(module, _)| *module).collect();
    let mut findings = Vec::new();
    for source in sources(&["src"], &["rs"]) {
        let inner = source.path.trim_start_matches("src/");
        let own = inner.split(['/', '.']).next().unwrap_or_default();
        let code = source.code_without_tests();
        if own == "lib" {
            continue;
        }
        let mut named = named_modules(&code, "crate::");
        let allowed: Vec<&str> = if own == "bin" {
            named = named_modules(&code, "cupola::");
            all.iter().copied().filter(|module| !["intercept", "ffi", "preload", "fence"].contains(module)).collect()
        } else {
            named.extend(named_modules(&code, "cupola::"));
            let Some((_, allowed)) = MAY_USE.iter().find(|(module, _)| *module == own) else {
                findings.push(format!("{}: the table of this test does not know the module {own}", source.path));
                continue;
            };
            [&allowed[..], &[own, "error", "lock"]].concat()
        };
        for module in named.iter().filter(|module| all.contains(module.as_str())) {
            if !allowed.contains(&module.as_str()) {
                findings.push(format!("{} uses {module}, which {own} may not", source.path));
            }
        }
    }
    report(&findings);
}

#[test]
fn words_stand_only_where_they_may() {
    let mut findings = Vec::new();
    let mut complain = |path: &str, what: &str| findings.push(format!("{path}: {what}"));
    let (mut opengl, mut vulkan) = (OpenGl::default(), false);
    for source in sources(&["src", "build", "tests"], &["rs"]) {
        let code = code_of(&source.text);
        let path = source.path.as_str();
        let within = |places: &[&str]| places.iter().any(|place| path.starts_with(place));
        for word in ["todo", "unimplemented", "dbg"] {
            if code.contains(&format!("{word}!")) && has_word(&code, word) {
                complain(path, &format!("{word}! is not allowed in a finished file"));
            }
        }
        if has_word(&code, "unsafe") && !within(&MAY_BE_UNSAFE) {
            complain(path, "unsafe code is not allowed in this folder");
        }
        let own_harness = within(&["tests/suite/", "tests/cli_run.rs"]);
        if own_harness && is_lost_test(&code) {
            complain(path, "#[test] has no effect here: add the function to the list of `tests!`");
        }
        if !path.starts_with("src/") {
            continue;
        }
        let names = OpenGl::of(&code);
        if let Some(what) = names.violation(path) {
            complain(path, &format!("{what} is named, which is not allowed in this folder"));
        }
        opengl.constant |= names.constant;
        opengl.table |= names.table;
        opengl.module |= names.module;
        let names_vulkan = has_word(&code, "ash");
        vulkan |= names_vulkan;
        if names_vulkan && !within(&MAY_KNOW_VULKAN) {
            complain(path, "Vulkan is named, which is not allowed in this folder");
        }
        if COMMAND_ONLY.iter().any(|name| code.contains(&format!("{name}::"))) && !path.starts_with("src/bin/") {
            complain(path, "a crate of the command is named in the library");
        }
        let exact =
            ["src/calibrate/", "src/geom/", "src/rig/", "src/views/", "src/warp/", "src/blend/", "src/correct/"];
        if within(&exact) && !within(&MAY_ROUND) && source.code_without_tests().contains(" as f32") {
            complain(path, &format!("f64 becomes f32 outside {MAY_ROUND:?}"));
        }
    }
    report(&findings);
    // If no file has a name any more, the rule about that name tests nothing.
    assert_eq!(opengl, OpenGl { constant: true, table: true, module: true }, "no file in src names one of these");
    assert!(vulkan, "no file in src names Vulkan");
}

#[test]
fn files_are_short() {
    let folders = ["src", "build", "tests", "shaders", "examples", "scripts", "docs"];
    let findings: Vec<String> = sources(&folders, &["rs", "c", "h", "wgsl", "toml", "md", "sh"])
        .iter()
        .map(|source| (source.text.lines().count(), &source.path))
        .filter(|(lines, _)| *lines > LONGEST_FILE)
        .map(|(lines, path)| format!("{path} has {lines} lines, more than {LONGEST_FILE}"))
        .collect();
    report(&findings);
}

#[test]
fn folders_are_small() {
    let sources = sources(&["src"], &["rs"]);
    let paths: Vec<&str> = sources.iter().map(|source| source.path.as_str()).collect();
    report(&crowded(&paths, MOST_FILES, &MORE_FILES));
}

/// The compiler refuses a use of a private module from outside, so it is enough to look at the
/// declarations.
#[test]
fn rooms_have_one_door() {
    let mut findings = Vec::new();
    for room in DOORS {
        let sources = sources(&[room], &["rs"]);
        let door = format!("{room}/mod.rs");
        match sources.iter().find(|source| source.path == door) {
            None => findings.push(format!("{door} is missing")),
            Some(source) => findings.extend(
                open_modules(&code_of(&source.text)).iter().map(|name| format!("{door}: {name} is not private")),
            ),
        }
    }
    report(&findings);
}

/// Inside the large folders, too, a file uses only files of lower rooms. `ORDERS` records how many
/// uses still break this order, and how many files use each other in a circle. Neither number may
/// grow.
#[test]
fn rooms_use_only_rooms_below_them() {
    let uses = Uses::between(&sources(&["src"], &["rs"]), "src");
    let mut findings = Vec::new();
    for order in &rules::ORDERS {
        let own = uses.within(order.folder);
        findings.extend(
            rules::unlisted(&own, order).iter().map(|room| format!("{}: the order has no room {room}", order.folder)),
        );
        let against = rules::against_the_order(&own, order);
        if against.len() > order.most_against {
            let (all, folder) = (against.join("\n    "), order.folder);
            findings.push(format!(
                "{folder}: {} uses are against the order, at most {} are allowed:\n    {all}",
                against.len(),
                order.most_against
            ));
        }
        if let Some(largest) = circles(&own).first().filter(|circle| circle.len() > order.largest_circle) {
            let (all, folder) = (largest.join("\n    "), order.folder);
            findings.push(format!("{folder}: {} files use each other in a circle:\n    {all}", largest.len()));
        }
    }
    report(&findings);
}

#[test]
fn rooms_of_decisions_use_nothing_of_the_process() {
    let sources = sources(&["src"], &["rs"]);
    let uses = Uses::between(&sources, "src");
    for (room, places) in WITHOUT {
        for place in [room].iter().chain(places) {
            assert!(sources.iter().any(|source| source.path.starts_with(place)), "{place} is missing");
        }
        report(&forbidden(&uses, room, places));
    }
}

#[test]
fn rooms_change_only_their_own_parts() {
    let sources = sources(&["src/intercept"], &["rs"]);
    let findings = parts::FOLDERS.iter().flat_map(|(folder, parts)| {
        [parts::foreign_uses(&sources, folder, parts), parts::unused(&sources, folder, parts)].concat()
    });
    report(&findings.collect::<Vec<_>>());
}

/// The check of parts finds fields that a foreign room names or sets. It does not find methods,
/// fields of the owner, and open fields.
#[test]
fn the_owners_of_parts_are_checked() {
    let file = |path: &str, text: &str| Source { path: path.into(), text: text.into() };
    let sources = [
        file(
            "x/draw/a.rs",
            "ctx.frame.count += 1; ctx.frame.note(); ctx.driver.gl.flush(); frame::x(); my_frame.count;",
        ),
        file("x/draw/b.rs", "f(&frame.lens); ctx.driver.gl = other; // ctx.frame.count"),
        file("x/frame/c.rs", "ctx.frame.count = 1; let same = ctx.driver.id == 1;"),
        file("x/state/d.rs", "self.frame.count = 1;"),
    ];
    let part = |name, owners, open| parts::Part { name, owners, open };
    let all = [part("frame", &["frame"], &[]), part("driver", &[], &["gl", "id", "gone"])];
    let found = parts::foreign_uses(&sources, "x", &all);
    let expected = ["x/draw/a.rs: sets frame.count", "x/draw/b.rs: names frame.lens", "x/draw/b.rs: sets driver.gl"];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    assert!(found.iter().zip(expected).all(|(found, start)| found.starts_with(start)), "{found:?}");
    assert_eq!(parts::unused(&sources, "x", &all), ["x: no room names driver.gone: remove it from the list"]);
}

#[test]
fn the_library_exports_its_interface_only() {
    // `cargo test` builds the library in `deps`. Only `cargo build` puts it beside the command.
    let library = Path::new(env!("CARGO_BIN_EXE_cupola")).with_file_name("deps/libcupola.so");
    let names = exported_names(&library);
    for name in ["__glx_Main", "__egl_Main"] {
        assert!(names.contains(name), "{} does not export {name}", library.display());
    }
    report(&unwanted(&names));

    let preload = Path::new(env!("CARGO_BIN_EXE_cupola")).with_file_name("examples/libcupola_preload.so");
    // Only `cargo build --example cupola_preload` builds it.
    assert!(preload.exists() || std::env::var_os("CUPOLA_REQUIRE_GL").is_none(), "{} is missing", preload.display());
    if preload.exists() {
        report(&unwanted(&exported_names(&preload)));
    } else {
        println!("SKIP: {} is not built", preload.display());
    }
}

fn exported_names(library: &Path) -> BTreeSet<String> {
    let output = Command::new("nm").args(["-D", "--defined-only"]).arg(library).output().expect("nm can be started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.lines().filter_map(|line| line.split_whitespace().last()).map(str::to_owned).collect()
}

fn unwanted(names: &BTreeSet<String>) -> Vec<String> {
    let wanted = |name: &str| name.starts_with("cupola_") || ENTRY_POINTS.contains(&name);
    names.iter().filter(|name| !wanted(name)).map(|name| format!("{name} is exported")).collect()
}

/// Test of the checks themselves: each finds what it should, and nothing else.
#[test]
fn the_checks_find_violations() {
    let code = code_of("a // unsafe\n/* unwrap() */ \"unsafe \\\" Gl\" r#\"unsafe \"x\" \"# '\"' b");
    assert!(!has_word(&code, "unsafe") && !has_word(&code, "Gl") && !has_word(&code, "unwrap"));
    assert!(code.starts_with('a') && code.ends_with('b'));
    assert!(has_word("x = unsafe {", "unsafe") && !has_word("#![forbid(unsafe_code)]", "unsafe"));
    let modules = named_modules(
        "use crate::{geom::{Pose, Frustum}, rig, views::Plan}; crate::error::Error; x::crate::no",
        "crate::",
    );
    assert_eq!(modules.into_iter().collect::<Vec<_>>(), ["error", "geom", "rig", "views"]);
    assert!(is_lost_test("#[test]\nfn lost() {}") && !is_lost_test("tests! { found }"));
    let violation = |path: &str, code: &str| OpenGl::of(&code_of(code)).violation(path);
    for code in
        ["gl.Enable(GL_BLEND)", "use api::GL_BLEND;", "fn draw(gl: &Gl)", "use crate::backend::gl::driver::headless;"]
    {
        assert!(violation("src/correct/plan.rs", code).is_some(), "{code}");
        assert_eq!(violation("src/backend/gl/state.rs", code), None, "{code}");
    }
    for code in
        ["use crate::backend::{vk, gl::headless};", "use crate::{error, backend::gl};", "crate::intercept::gl::x()"]
    {
        assert!(violation("src/backend/vk/device.rs", code).is_some(), "{code}");
        assert_eq!(violation("src/bin/cupola/map.rs", code), None, "{code}");
    }
    assert!(violation("src/bin/cupola/map.rs", "gl.Enable(GL_BLEND)").is_some());
    for code in ["// GL_BLEND, Gl", "\"GL_BLEND\"", "AGL_B GL_ MAY_KNOW_GL", "GlBackend", "crate::backend::vk::gl::x()"]
    {
        assert_eq!(violation("src/correct/plan.rs", code), None, "{code}");
    }
    let door = code_of("mod a;\npub mod b;\n#[cfg(test)]\npub(in crate::x) mod c; // pub mod d;\npub use a::modern;");
    assert_eq!(open_modules(&door), ["b", "c"]);
    let paths = ["a/x.rs", "a/y.rs", "a/b/x.rs", "a/b/y.rs", "a/b/z.rs"];
    assert_eq!(crowded(&paths, 2, &[]).len(), 1, "files of subfolders do not count");
    assert!(crowded(&paths, 2, &[("a/b", 3)]).is_empty());
    assert!(crowded(&paths, 2, &[("a/b", 4)])[0].contains("lower"), "an exception shrinks with its folder");
    assert_eq!(unwanted(&BTreeSet::from(["cupola_x".into(), "__egl_Main".into(), "dlsym".into()])).len(), 1);
}

/// The check of rooms finds a use against the order, a circle, and a use through a re-export (`pub
/// use`).
#[test]
fn the_order_of_rooms_finds_violations() {
    let file = |path: &str, text: &str| Source { path: path.into(), text: text.into() };
    let sources = [
        file("src/lib.rs", "pub mod a;\npub mod b;"),
        file("src/a/mod.rs", "pub mod top;\npub use crate::a::top::Door;"),
        file("src/a/top.rs", "use crate::b::{ground::X, other as y}; // use crate::b;\npub struct Door;"),
        file("src/b/mod.rs", "pub mod ground;\npub mod other;"),
        file("src/b/ground.rs", "fn f() { super::other::g(); }\n#[cfg(test)]\nmod tests { use crate::a::top; }"),
        file("src/b/other.rs", "use crate::a::Door;"),
    ];
    let uses = Uses::between(&sources, "src");
    let of = |path: &str| -> Vec<&str> {
        let index = uses.files.iter().position(|file| file == path).expect("a file");
        uses.of[index].iter().map(|target| &*uses.files[*target]).collect()
    };
    assert_eq!(of("src/a/top.rs"), ["src/b/ground.rs", "src/b/other.rs"]);
    assert_eq!(of("src/b/ground.rs"), ["src/b/other.rs"]);
    assert_eq!(of("src/b/other.rs"), ["src/a/top.rs"]);
    assert_eq!(circles(&uses), [["src/a/top.rs", "src/b/ground.rs", "src/b/other.rs"]]);
    let order = rules::Order { folder: "src", rooms: &["a"], most_against: 0, largest_circle: 0 };
    assert_eq!(rules::unlisted(&uses, &order), ["b"]);
    let order = rules::Order { folder: "src", rooms: &["a", "b"], most_against: 0, largest_circle: 0 };
    assert_eq!(rules::against_the_order(&uses, &order), ["src/b/other.rs → src/a/top.rs"]);
    assert_eq!(forbidden(&uses, "src/a", &["src/b/ground.rs", "src/c"]), ["src/a/top.rs → src/b/ground.rs"]);
    assert_eq!(forbidden(&uses, "src/b", &["src/a"]), ["src/b/other.rs → src/a/top.rs"]);
    assert!(forbidden(&uses, "src/a", &["src/b/gr"]).is_empty(), "a part of a name is no folder");
}
