//! Rust types of the shaders' constants: a struct for each structure of the WGSL sources that the
//! uniform `constants` contains, and an enum with the values of any pass.

use naga::{ArraySize, Handle, Module, ScalarKind, Type, TypeInner};
use std::collections::BTreeMap;
use std::fmt::Write;

/// The types of all passes.
#[derive(Default)]
pub struct Types {
    /// Definition of each struct by its name.
    structs: BTreeMap<String, String>,
    passes: Vec<Pass>,
}

/// The constants of one pass.
struct Pass {
    name: String,
    has_constants: bool,
    /// Path and number of scalars of each member.
    members: Vec<(String, usize)>,
}

impl Types {
    /// Adds the constants of the pass `name`.
    pub fn add(&mut self, name: &str, module: &Module, members: &[(String, usize)]) {
        let constants = module.global_variables.iter().find(|(_, v)| v.name.as_deref() == Some("constants"));
        if let Some((_, variable)) = constants {
            self.define(module, variable.ty, name);
        }
        let (name, members) = (name.to_owned(), members.to_vec());
        self.passes.push(Pass { name, has_constants: constants.is_some(), members });
    }

    /// Returns the name of the Rust type for `ty`, and the statement that appends `value` of that
    /// type to the scalars.
    fn rust(&mut self, module: &Module, ty: Handle<Type>, pass: &str, value: &str) -> (String, String) {
        let floats = |count: usize| (format!("[f32; {count}]"), format!("out.extend({value});"));
        match &module.types[ty].inner {
            TypeInner::Scalar(scalar) if scalar.kind == ScalarKind::Uint => {
                ("u32".to_owned(), format!("out.push({value} as f32);"))
            }
            TypeInner::Scalar(_) => ("f32".to_owned(), format!("out.push({value});")),
            TypeInner::Vector { size, .. } => floats(*size as usize),
            TypeInner::Matrix { columns, rows, .. } => floats(*columns as usize * *rows as usize),
            TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
                let (element, append) = self.rust(module, *base, pass, "element");
                (format!("[{element}; {count}]"), format!("for element in {value} {{ {append} }}"))
            }
            TypeInner::Struct { .. } => (self.define(module, ty, pass), format!("{value}.append_to(out);")),
            other => panic!("shaders: {pass}: a type that constants cannot have: {other:?}"),
        }
    }

    /// Defines the struct for the structure `ty` and returns its name. Each pass has its own
    /// structure `Constants`.
    fn define(&mut self, module: &Module, ty: Handle<Type>, pass: &str) -> String {
        let (TypeInner::Struct { members, .. }, Some(name)) = (&module.types[ty].inner, &module.types[ty].name) else {
            panic!("shaders: {pass}: constants are a structure with a name");
        };
        let name = if name == "Constants" { format!("{pass}Constants") } else { name.clone() };
        let (mut fields, mut appends) = (String::new(), String::new());
        for member in members {
            let field = member.name.as_deref().expect("a member has a name");
            let (rust, append) = self.rust(module, member.ty, pass, &format!("self.{field}"));
            write!(fields, "pub {field}: {rust}, ").expect("writing to a String");
            appends.push_str(&append);
        }
        let text = format!(
            "#[derive(Clone, Copy, Debug, Default, PartialEq)]\npub struct {name} {{ {fields} }}\n\
             impl {name} {{ fn append_to(&self, out: &mut Vec<f32>) {{ {appends} }} }}\n"
        );
        let known = self.structs.entry(name.clone()).or_insert_with(|| text.clone());
        assert_eq!(*known, text, "shaders: two structures {name}");
        name
    }

    /// Returns the types as Rust source.
    pub fn source(&self) -> String {
        let mut out: String = self.structs.values().map(String::as_str).collect();
        let mut arms = [const { String::new() }; 5];
        for Pass { name, has_constants, members } in &self.passes {
            let [variants, pass, shared, scalars, paths] = &mut arms;
            let written = if *has_constants {
                let pattern = format!("Self::{name}(values)");
                write!(variants, "{name}(Box<{name}Constants>), ")
                    .and(write!(shared, "{pattern} => Some(&values.shared_part), "))
                    .and(write!(scalars, "{pattern} => values.append_to(&mut out), "))
                    .and(write!(pass, "Self::{name}(_) => Pass::{name}, "))
            } else {
                write!(variants, "{name}, ")
                    .and(write!(shared, "Self::{name} => None, "))
                    .and(write!(scalars, "Self::{name} => {{}} "))
                    .and(write!(pass, "Self::{name} => Pass::{name}, "))
            };
            written.and(write!(paths, "Pass::{name} => &{members:?}, ")).expect("writing to a String");
        }
        let [variants, pass, shared, scalars, paths] = arms;
        write!(
            out,
            "/// Values of the constants of a pass.\n#[derive(Clone, Debug, PartialEq)]\npub enum Values {{ {variants} }}\n\
             impl Values {{\n\
             /// Returns the pass.\npub fn pass(&self) -> Pass {{ match self {{ {pass} }} }}\n\
             /// Returns the constants that every pass with views has; `None` for black.\n\
             pub fn shared(&self) -> Option<&Shared> {{ match self {{ {shared} }} }}\n\
             /// Returns all scalars in the order of the shader's constant.\n\
             pub fn scalars(&self) -> Vec<f32> {{ let mut out = Vec::new(); match self {{ {scalars} }} out }}\n\
             }}\n\
             /// Returns path and number of scalars of each member, in order.\n\
             pub fn members(pass: Pass) -> &'static [(&'static str, usize)] {{ match pass {{ {paths} }} }}\n"
        )
        .expect("writing to a String");
        out
    }
}
