//! Commands, groups of values and values of Khronos' registry of OpenGL.

use crate::failure::Failure;
use roxmltree::{Document, Node};
use std::collections::{BTreeMap, BTreeSet};

/// A command of OpenGL.
#[derive(Clone, Debug)]
pub struct Command {
    pub name: String,
    /// Type of the result.
    pub result: String,
    pub parameters: Vec<Parameter>,
}

/// A parameter of a command.
#[derive(Clone, Debug)]
pub struct Parameter {
    pub name: String,
    /// Type, for example `GLenum` or `void`.
    pub base: String,
    /// Number of stars in the type.
    pub pointers: usize,
    pub is_const: bool,
    /// Name of the group of its permitted values, or empty.
    pub group: String,
    /// Length if it is an array, or empty.
    pub length: String,
}

/// An extension of OpenGL.
#[derive(Clone, Debug, Default)]
pub struct Extension {
    /// APIs for which it is defined: `gl|glcore|gles2`.
    pub supported: String,
    pub commands: Vec<String>,
}

/// Values in order, each with its names.
pub type Values = Vec<(u32, Vec<String>)>;

/// Contents of the registry.
pub struct Registry {
    /// Commands by their names.
    pub commands: BTreeMap<String, Command>,
    /// Values of each group, by its name.
    pub groups: BTreeMap<String, Vec<u32>>,
    /// Each value that is no bit field, with its names.
    pub values: Values,
    /// Values by their names.
    names: BTreeMap<String, u32>,
    /// Commands of all versions of OpenGL.
    pub desktop: BTreeSet<String>,
    /// Commands of all versions of OpenGL ES 2 and 3.
    pub es: BTreeSet<String>,
    /// Extensions with their commands, by their names.
    pub extensions: BTreeMap<String, Extension>,
}

impl Registry {
    /// Reads the registry.
    pub fn read() -> Result<Self, Failure> {
        let wrong = |error: &dyn std::fmt::Display| Failure::new(format!("the registry of OpenGL: {error}"));
        let text = std::str::from_utf8(khronos_api::GL_XML).map_err(|error| wrong(&error))?;
        let document = Document::parse(text).map_err(|error| wrong(&error))?;
        let root = document.root_element();
        let (names, values) = enumerants(root);
        let groups = groups(root, &names);
        let list = children(root, "commands").flat_map(|commands| children(commands, "command"));
        let commands = list.filter_map(command).map(|command| (command.name.clone(), command)).collect();
        let of = |api: &str| -> BTreeSet<String> {
            children(root, "feature").filter(|f| f.attribute("api") == Some(api)).flat_map(required).collect()
        };
        let extensions = children(root, "extensions").flat_map(|extensions| children(extensions, "extension"));
        let extensions = extensions.filter_map(|e| {
            let supported = e.attribute("supported").unwrap_or_default().to_owned();
            Some((e.attribute("name")?.to_owned(), Extension { supported, commands: required(e).collect() }))
        });
        let (desktop, es, extensions) = (of("gl"), of("gles2"), extensions.collect());
        Ok(Self { commands, groups, values, names, desktop, es, extensions })
    }

    /// Value of this name.
    pub fn value(&self, name: &str) -> Option<u32> {
        self.names.get(name).copied()
    }
}

fn children<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name(tag))
}

/// Commands that a version or an extension requires.
fn required<'a>(of: Node<'a, '_>) -> impl Iterator<Item = String> + 'a {
    let commands = of.descendants().filter(|node| {
        node.has_tag_name("command") && node.parent().is_some_and(|parent| parent.has_tag_name("require"))
    });
    commands.filter_map(|command| command.attribute("name").map(str::to_owned)).collect::<Vec<_>>().into_iter()
}

fn enumerants(root: Node) -> (BTreeMap<String, u32>, Values) {
    let mut names = BTreeMap::new();
    let mut values: BTreeMap<u32, Vec<String>> = BTreeMap::new();
    for block in children(root, "enums") {
        for item in children(block, "enum") {
            let (Some(name), Some(text)) = (item.attribute("name"), item.attribute("value")) else { continue };
            let number = match text.strip_prefix("0x") {
                Some(digits) => u32::from_str_radix(digits, 16),
                None => text.parse(),
            };
            let Ok(number) = number else { continue };
            names.insert(name.to_owned(), number);
            if block.attribute("type") != Some("bitmask") && number > 0xff {
                values.entry(number).or_default().push(name.to_owned());
            }
        }
    }
    (names, values.into_iter().collect())
}

fn groups(root: Node, names: &BTreeMap<String, u32>) -> BTreeMap<String, Vec<u32>> {
    let all = children(root, "groups").flat_map(|groups| children(groups, "group"));
    all.filter_map(|group| {
        let members = children(group, "enum").filter_map(|item| names.get(item.attribute("name")?).copied());
        let members: BTreeSet<u32> = members.collect();
        Some((group.attribute("name")?.to_owned(), members.into_iter().collect()))
    })
    .collect()
}

/// Words of the declaration without the declared name, and that name.
fn declaration(node: Node) -> Option<(String, String)> {
    let name = children(node, "name").next()?.text()?.trim().to_owned();
    let parts = node.children().filter(|part| !part.has_tag_name("name")).filter_map(|part| part.text());
    Some((parts.collect::<Vec<_>>().join(" "), name))
}

fn base(words: &str) -> String {
    let words = words.replace('*', " ");
    words.split_whitespace().find(|word| !matches!(*word, "const" | "struct")).unwrap_or("void").to_owned()
}

fn command(node: Node) -> Option<Command> {
    let (words, name) = declaration(children(node, "proto").next()?)?;
    let result = if words.contains('*') { "pointer".to_owned() } else { base(&words) };
    let parameters = children(node, "param").filter_map(|parameter| {
        let (words, name) = declaration(parameter)?;
        let text = |attribute: &str| parameter.attribute(attribute).unwrap_or_default().to_owned();
        Some(Parameter {
            name,
            base: base(&words),
            pointers: words.matches('*').count(),
            is_const: words.contains("const"),
            group: text("group"),
            length: text("len"),
        })
    });
    Some(Command { name, result, parameters: parameters.collect() })
}
