//! The keys of a profile: the programs to which it applies, and facts about them.

use super::{table, viewer, views};
use crate::rig::reading::problems::Problems;
use crate::rig::reading::reader::Section;
use crate::rig::{Defaults, Profile};

/// Environment variables that Cupola itself sets, or with which the program would bypass it.
const RESERVED: [&str; 5] = ["CUPOLA", "LD_", "__GLX_VENDOR", "__EGL_VENDOR", "VK_"];

/// Reads the profile in `text`. `None` if it is not TOML at all. Otherwise the result is usable
/// only if no problem was added.
pub(in crate::rig) fn profile(text: &str, name: &str, problems: &mut Problems) -> Option<Profile> {
    let table = table(text, problems)?;
    let mut root = Section::new(&table, String::new());
    let executables = root.texts("executables", "names of programs, such as [\"minetest\"]", problems);
    let libraries = root.texts("libraries", "prefixes of library names, such as [\"libvtkRendering\"]", problems);
    if !root.has("executables") && !root.has("libraries") {
        problems.add("executables", "is missing, and `libraries` too; expected at least one of them");
    }
    let hint = root.text("hint", "what to do in the program, in one line", problems).map(str::to_owned);
    let environment = root.section("environment", problems);
    let environment = environment.map_or_else(Vec::new, |section| section.all_texts("a variable's value", problems));
    for (variable, _) in &environment {
        if RESERVED.iter().any(|reserved| variable.starts_with(reserved)) {
            problems.add(&format!("environment.{variable}"), "is set by `cupola run` itself; remove it here");
        }
    }
    if executables.is_empty() && root.has("libraries") && !environment.is_empty() {
        problems.add("environment", "needs `executables`: which libraries a program loads is known after its start");
    }
    let usual = Defaults::default();
    let camera = viewer::camera(root.section("camera", problems), &usual.camera, problems);
    let overlay = views::overlay(root.section("overlay", problems), usual.overlay, problems);
    let mut defaults = Defaults { camera, overlay, ..usual };
    if let Some(mut section) = root.section("views", problems) {
        defaults.duplicate = views::duplicate(&mut section, usual.duplicate, problems);
        defaults.favour = views::favour(&mut section, usual.favour, problems);
        section.finish(&[], problems);
    }
    let elsewhere = ["dome", "screen", "viewer", "content", "window", "output"].map(|key| (key, "the rig file"));
    root.finish(&elsewhere, problems);
    Some(Profile { name: name.to_owned(), file: None, executables, libraries, hint, environment, defaults })
}
