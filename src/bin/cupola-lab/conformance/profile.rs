//! Tests in the profiles of piglit.

use crate::failure::Failure;
use std::collections::HashMap;
use std::path::Path;
use std::process::Command;

/// A test of piglit.
#[derive(Clone, Debug, PartialEq)]
pub struct Test {
    pub name: String,
    /// Program in piglit's folder `bin`, and its arguments.
    pub command: Vec<String>,
}

/// Reads the tests of a profile that draw to windows of GLX.
pub fn read(piglit: &Path, profile: &str) -> Result<Vec<Test>, Failure> {
    let file = piglit.join(format!("tests/{profile}.xml.gz"));
    let failure = |why: &str| Failure::new(format!("{}: {why}", file.display()));
    let output = Command::new("gzip").args(["--decompress", "--stdout"]).arg(&file).output();
    let output = output.map_err(|error| Failure::new(format!("gzip cannot be started: {error}")))?;
    if !output.status.success() {
        return Err(failure(String::from_utf8_lossy(&output.stderr).trim()));
    }
    parse(&String::from_utf8_lossy(&output.stdout)).map_err(|why| failure(&why))
}

fn parse(text: &str) -> Result<Vec<Test>, String> {
    let document = roxmltree::Document::parse(text).map_err(|error| error.to_string())?;
    let tests = document.descendants().filter(|node| node.has_tag_name("Test"));
    Ok(tests.filter_map(|node| test(&node)).collect())
}

fn test(node: &roxmltree::Node) -> Option<Test> {
    let option = |name: &str| {
        let is_it = |node: &roxmltree::Node| node.has_tag_name("option") && node.attribute("name") == Some(name);
        node.children().find(is_it)?.attribute("value")
    };
    let mut command = words(option("command")?);
    // Piglit itself adds -fbo to most tests, which then draw nothing into their windows.
    command.retain(|word| word != "-auto" && word != "-fbo");
    if node.attribute("type") == Some("gl_builtin")
        && let Some(file) = command.get_mut(1)
    {
        *file = format!("tests/{file}");
    }
    command.push("-auto".to_owned());
    let platforms = |name: &str| option(name).map(words);
    let glx = |list: &[String]| list.iter().any(|name| name == "glx" || name == "mixed_glx_egl");
    if platforms("require_platforms").is_some_and(|list| !glx(&list)) {
        return None;
    }
    if platforms("exclude_platforms").is_some_and(|list| list.iter().any(|name| name == "mixed_glx_egl")) {
        return None;
    }
    Some(Test { name: node.attribute("name")?.to_owned(), command })
}

/// Strings of a list in Python's format: `['a', 'b c']`.
fn words(list: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut rest = list;
    while let Some(start) = rest.find(['\'', '"']) {
        let quote = &rest[start..=start];
        let Some(length) = rest[start + 1..].find(quote) else { break };
        words.push(rest[start + 1..][..length].to_owned());
        rest = &rest[start + length + 2..];
    }
    words
}

/// Takes `count` tests, the same ones in each run: first one of each group, then a second one, and
/// so on. A group has the tests of one program, or the shader tests of one folder. Where a round
/// is not complete, the groups are taken in even steps.
pub fn sample(tests: Vec<Test>, count: usize) -> Vec<Test> {
    let mut sizes: HashMap<String, usize> = HashMap::new();
    let mut rounds: Vec<Vec<Test>> = Vec::new();
    for test in tests {
        let rank = sizes.entry(group(&test)).or_default();
        if rounds.len() <= *rank {
            rounds.push(Vec::new());
        }
        rounds[*rank].push(test);
        *rank += 1;
    }
    let mut taken = Vec::new();
    for round in rounds {
        let wanted = round.len().min(count - taken.len());
        let step = |index: usize| round[index * round.len() / wanted].clone();
        taken.extend((0..wanted).map(step));
    }
    taken
}

fn group(test: &Test) -> String {
    let shader = test.command.get(1).and_then(|file| file.strip_suffix(".shader_test"));
    match shader.and_then(|file| file.rsplit_once('/')) {
        Some((folder, _)) => folder.to_owned(),
        None => test.command[0].clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROFILE: &str = r#"<?xml version='1.0' encoding='utf-8'?><PiglitTestList>
        <Test type="gl" name="spec@a@b"><option name="command" value="['a-b', 'it''s', '-fbo']" /></Test>
        <Test type="gl_builtin" name="constants"><option name="command" value="['built-in', 'spec/x.txt']" /></Test>
        <Test type="gl" name="spec@gbm"><option name="command" value="['gbm']" />
            <option name="require_platforms" value="['gbm']" /></Test>
        <Test type="gl" name="glx@x"><option name="command" value="['glx-x', '-auto']" />
            <option name="require_platforms" value="['glx', 'mixed_glx_egl']" /></Test>
        </PiglitTestList>"#;

    #[test]
    fn tests_draw_to_windows_of_glx() {
        let tests = parse(PROFILE).unwrap();
        let commands: Vec<String> = tests.iter().map(|test| test.command.join(" ")).collect();
        assert_eq!(commands, ["a-b it s -auto", "built-in tests/spec/x.txt -auto", "glx-x -auto"]);
    }

    fn of(program: &str, argument: usize) -> Test {
        Test { name: format!("{program} {argument}"), command: vec![program.to_owned(), argument.to_string()] }
    }

    #[test]
    fn samples_begin_with_one_of_each_group() {
        let tests: Vec<Test> = (0..40).map(|number| of(if number < 30 { "a" } else { "b" }, number)).collect();
        let names =
            |count: usize| -> Vec<String> { sample(tests.clone(), count).into_iter().map(|test| test.name).collect() };
        assert_eq!(names(3), ["a 0", "b 30", "a 1"]);
        assert_eq!(names(1), ["a 0"]);
        assert_eq!(names(1000).len(), 40);
    }

    #[test]
    fn shader_tests_of_a_folder_are_a_group() {
        let shader = |file: &str| group(&Test { name: String::new(), command: vec!["s".into(), file.into()] });
        assert_eq!(shader("tests/a/b.shader_test"), shader("tests/a/c.shader_test"));
        assert_ne!(shader("tests/a/b.shader_test"), shader("tests/b/b.shader_test"));
    }
}
