//! Numbers that the sources state: hooked functions and subcommands.

use super::source::Source;

/// Number of functions of OpenGL, or of Vulkan, that have a hook, without those of GLX, EGL and the
/// loader. Taken from the test beside the table of hooks; `None` in a version without that test.
pub fn hooked(sources: &[Source], api: &str) -> Option<usize> {
    let path = match api {
        "OpenGL" => "src/intercept/gl/entry/table.rs",
        _ => "src/intercept/vk/layer/table.rs",
    };
    let table = sources.iter().find(|source| source.path == path)?;
    table.text.split_once("assert_eq!(table().len(), ")?.1.split(')').next()?.parse().ok()
}

/// Number of the subcommands that `cupola --help` lists, `help` left out.
pub fn subcommands(sources: &[Source]) -> Option<usize> {
    let main = sources.iter().find(|source| source.path == "src/bin/cupola/main.rs")?;
    let listed = main.text.split_once("enum Command {\n")?.1.split("\n}").next()?;
    let variants = listed.lines().filter(|line| line.trim_start().starts_with(char::is_uppercase)).count();
    Some(variants - listed.matches("hide = true").count())
}
