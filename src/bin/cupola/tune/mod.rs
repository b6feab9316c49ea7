//! `cupola tune`: changes keys of a rig file, also while a program runs with it.

mod remove;

use crate::failure::Failure;
use cupola::rig;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use toml_edit::{DocumentMut, Item, Table, TableLike, Value};

/// Change keys of a rig file. Programs that run with this file apply the change within a second.
///
/// The rest of the file and its comments are kept. If a change would make the rig invalid, the file
/// is not changed.
#[derive(clap::Args)]
pub struct Arguments {
    /// Rig file
    file: PathBuf,
    /// Keys with their new values, in quotes, for example 'viewer.position=[0,0,1]' or
    /// 'output.NAME.blend.ramp=0.3'; 'output.*.eye=0' changes all outputs
    #[arg(required = true, value_name = "KEY=VALUE")]
    changes: Vec<String>,
    /// Print as JSON whether the file was changed
    #[arg(long)]
    json: bool,
}

pub use remove::without;

/// Keys that name files relative to the rig file.
pub const FILES: [&str; 2] = ["file", "image"];

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let file = arguments.file.display();
    let failed = |error: std::io::Error| Failure::new(format!("{file}: {error}"));
    let text = rig::text_of_file(&arguments.file).map_err(|error| {
        let hint = if arguments.file.extension().is_none() {
            "; write a preset to a file with `cupola check PRESET --print > my.toml`"
        } else {
            ""
        };
        Failure::usage(format!("{file}: {error}{hint}"))
    })?;
    let changed = changed(&text, &arguments.changes).map_err(|why| Failure::usage(format!("{file}: {why}")))?;
    let folder = arguments.file.parent().unwrap_or(Path::new(""));
    rig::parse(&changed, &file.to_string(), folder).map_err(|error| Failure::usage(error.message))?;
    if changed != text {
        replace(&arguments.file, &changed).map_err(failed)?;
    }
    if arguments.json {
        println!("{:#}", serde_json::json!({ "file": arguments.file, "changed": changed != text }));
    }
    Ok(ExitCode::SUCCESS)
}

/// Writes a file in place of the one of this name: readers see the old content or the new content,
/// but no partial content.
pub fn replace(path: &Path, text: &str) -> std::io::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}", std::process::id()));
    let temporary = path.with_file_name(name);
    let written = std::fs::File::create_new(&temporary).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()
    });
    written.and_then(|()| std::fs::rename(&temporary, path)).inspect_err(|_| {
        // The file may not exist.
        _ = std::fs::remove_file(&temporary);
    })
}

/// The text with all changes applied.
///
/// # Errors
/// Description of the mistake in a change.
pub fn changed(text: &str, changes: &[String]) -> Result<String, String> {
    let mut document: DocumentMut = text.parse().map_err(|error| format!("the file is not valid TOML: {error}"))?;
    for change in changes {
        let (key, value) = change.split_once('=').ok_or_else(|| {
            format!("{change:?} is not a change; expected KEY=VALUE, for example 'viewer.position=[0,0,1]'")
        })?;
        let value = value_of(value.trim()).map_err(|why| format!("{}: {why}", key.trim()))?;
        match of_output(document.as_table(), key.trim()) {
            Some((name, rest)) => outputs(&mut document, name, &rest, &value)?,
            None => set(document.as_table_mut(), &key.trim().split('.').collect::<Vec<_>>(), &value)?,
        }
    }
    Ok(document.to_string())
}

/// A value as a rig file has it; text may lack its quotes.
fn value_of(text: &str) -> Result<Value, String> {
    match text.parse::<Value>() {
        Ok(value) => Ok(value),
        Err(error) if text.starts_with(['[', '{', '"', '\'']) => {
            Err(format!("{text} is not valid TOML: {}", error.message().replace('\n', ", ")))
        }
        Err(_) => Ok(text.into()),
    }
}

/// Name of an output, and the path in it; `None` if the key is of no output. Names may contain dots.
fn of_output<'a>(document: &Table, key: &'a str) -> Option<(&'a str, Vec<&'a str>)> {
    let key = key.strip_prefix("output.")?;
    let all = document.get("output").and_then(Item::as_array_of_tables);
    let names = all.into_iter().flatten().enumerate().map(|(index, output)| name_of(output, index));
    let known = names.filter(|name| key.strip_prefix(name.as_str()).is_some_and(|rest| rest.starts_with('.')));
    let length = known.map(|name| name.len()).max().or_else(|| key.find('.'))?;
    Some((&key[..length], key[length + 1..].split('.').collect()))
}

/// Name of the output with this index, from 0: `output-1` if the first one has none.
pub fn name_of_output(output: &Item, index: usize) -> String {
    output.as_table_like().map_or(String::new(), |table| name_of(table, index))
}

fn name_of(output: &dyn TableLike, index: usize) -> String {
    output.get("name").and_then(Item::as_str).map_or(format!("output-{}", index + 1), str::to_owned)
}

/// Sets a key of the output with this name (`output-N` for the N-th output without a name), or of
/// all outputs for `*`.
pub fn outputs(document: &mut DocumentMut, name: &str, path: &[&str], value: &Value) -> Result<(), String> {
    let all = document.get_mut("output").and_then(Item::as_array_of_tables_mut);
    let all = all.ok_or("there is no [[output]] in the file")?;
    let mut found = false;
    for (index, output) in all.iter_mut().enumerate() {
        if name == "*" || name == name_of(output, index) {
            set(output, path, value)?;
            found = true;
        }
    }
    if found { Ok(()) } else { Err(format!("there is no output {name:?}")) }
}

/// Sets a key. Missing tables are created.
pub fn set(table: &mut dyn TableLike, path: &[&str], value: &Value) -> Result<(), String> {
    match path {
        [] | [""] => Err("a key has no name; expected KEY=VALUE".to_owned()),
        [key] => {
            match table.get_mut(key).and_then(Item::as_value_mut) {
                // Text around the old value, such as a comment, is kept.
                Some(old) => {
                    let decor = old.decor().clone();
                    *old = value.clone();
                    *old.decor_mut() = decor;
                }
                None => drop(table.insert(key, Item::Value(value.clone()))),
            }
            Ok(())
        }
        [key, rest @ ..] => {
            let inner = table.entry(key).or_insert(Item::Table(Table::new()));
            let inner = inner.as_table_like_mut().ok_or_else(|| format!("{key} is not a table"))?;
            set(inner, rest, value)
        }
    }
}

/// Makes names of files absolute, for a rig file in another folder.
pub fn name_files_absolutely(table: &mut dyn TableLike, folder: &Path) {
    for (key, item) in table.iter_mut() {
        if let Some(name) = item.as_str().filter(|_| FILES.contains(&key.get())) {
            let path = folder.join(name);
            if let (Some(path), Some(value)) = (path.to_str(), item.as_value_mut()) {
                *value = Value::from(path);
            }
        } else if let Some(tables) = item.as_array_of_tables_mut() {
            tables.iter_mut().for_each(|inner| name_files_absolutely(inner, folder));
        } else if let Some(inner) = item.as_table_like_mut() {
            name_files_absolutely(inner, folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIG: &str = "# mine\n[viewer]\nposition = [0.0, 0.0, 0.0] # the middle\n\n[[output]]\nname = \"left\"\nblend = { ramp = 0.2 }\n\n[[output]]\nkind = \"projector\"\n";

    fn tuned(changes: &[&str]) -> Result<String, String> {
        changed(RIG, &changes.iter().map(|change| (*change).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn only_what_is_named_changes() {
        let text = tuned(&["viewer.position=[0,0,1]", "output.left.blend.ramp=0.3"]).expect("good");
        assert_eq!(text, RIG.replace("[0.0, 0.0, 0.0]", "[0,0,1]").replace("ramp = 0.2", "ramp = 0.3"));
        let text =
            tuned(&["output.*.blend.black_level=0.01", "camera.zoom=2", "output.output-2.eye = 0.03"]).expect("good");
        assert!(text.contains("blend = { ramp = 0.2 , black_level = 0.01 }") || text.contains("black_level = 0.01 }"));
        assert!(text.contains("[output.blend]\nblack_level = 0.01") && text.contains("[camera]\nzoom = 2"), "{text}");
        assert!(text.contains("eye = 0.03") && text.starts_with("# mine"), "{text}");
    }

    #[test]
    fn names_of_outputs_may_contain_dots() {
        let text = RIG.replace("left", "left.up");
        let found = changed(&text, &["output.left.up.blend.ramp=0.3".to_owned()]).expect("good");
        assert_eq!(found, text.replace("ramp = 0.2", "ramp = 0.3"));
        assert!(changed(&text, &["output.left.blend.ramp=0.3".to_owned()]).is_err());
        let texts = tuned(&["output.left.node=beamer-1", "output.left.display=\":0.1\""]).expect("good");
        assert!(texts.contains("node = \"beamer-1\"") && texts.contains("display = \":0.1\""), "{texts}");
    }

    #[test]
    fn what_is_not_there_is_refused() {
        for bad in
            ["viewer.position", "output.right.eye=0", "viewer.position.x=1", "=3", "views.cells=[[0, 1", "name='x"]
        {
            assert!(tuned(&[bad]).is_err(), "{bad}");
        }
        assert!(changed("a = [", &["b=1".to_owned()]).is_err());
    }
}
