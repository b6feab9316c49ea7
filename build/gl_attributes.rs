//! The commands that set vertices and their attributes between `glBegin` and `glEnd`, found by
//! their names in the registry, so that none is missed.
//!
//! A name like `Vertex3fv` consists of a family, a number of components, their type, and `v` if
//! they come as an array. A command with a family's name but another form (`VertexPointer`,
//! `ColorMask`, …) is of another kind.

use std::fmt::Write;

/// A command as the registry declares it: its method in the table, and its parameters in Rust.
pub struct Declaration {
    /// `glVertex3fv`.
    pub name: String,
    /// `vertex3fv`.
    pub method: String,
    /// Name and type of each parameter.
    pub parameters: Vec<(String, String)>,
}

/// The families, longer names first where one begins with another.
const FAMILIES: [&str; 11] = [
    "VertexAttrib",
    "Vertex",
    "SecondaryColor",
    "Color",
    "Index",
    "Normal",
    "MultiTexCoord",
    "TexCoord",
    "FogCoord",
    "EdgeFlag",
    "EvalCoord",
];

/// The types of components, longer names first.
const TYPES: [&str; 11] = ["ui64", "i64", "ub", "us", "ui", "b", "s", "i", "f", "d", "h"];

/// The parts of a command's name.
struct Form<'a> {
    family: &'a str,
    /// `I`: stays an integer; `L`: stays a double; `P`: packed into one number.
    kind: Option<char>,
    components: usize,
    normalised: bool,
    type_name: &'a str,
    vector: bool,
    /// Suffix of the vendor, or nothing.
    suffix: &'a str,
}

impl<'a> Form<'a> {
    fn parse(name: &'a str) -> Option<Self> {
        let name = name.strip_prefix("gl")?;
        let family = FAMILIES.into_iter().find(|family| name.starts_with(family))?;
        let rest = &name[family.len()..];
        let (kind, rest) = match rest.chars().next() {
            Some(kind @ ('I' | 'L' | 'P')) => (Some(kind), &rest[1..]),
            _ => (None, rest),
        };
        let (components, rest) = match rest.chars().next().and_then(|c| c.to_digit(10)) {
            Some(digit) => (digit as usize, &rest[1..]),
            None => (1, rest),
        };
        let (normalised, rest) = rest.strip_prefix('N').map_or((false, rest), |rest| (true, rest));
        // Only edge flags name no type; fixed-point numbers (`x`) are OpenGL ES 1.
        let type_name = TYPES.into_iter().find(|t| rest.starts_with(t));
        let type_name = if family == "EdgeFlag" { type_name.or(Some("")) } else { type_name }?;
        let rest = &rest[type_name.len()..];
        let (vector, suffix) = rest.strip_prefix('v').map_or((false, rest), |rest| (true, rest));
        let vendor = suffix.chars().all(|c| c.is_ascii_uppercase());
        vendor.then_some(Self { family, kind, components, normalised, type_name, vector, suffix })
    }

    /// Returns the name of the command that takes the same components as an array.
    fn vector_name(&self) -> String {
        let kind = self.kind.map(String::from).unwrap_or_default();
        let digit = if matches!(self.family, "FogCoord" | "Index" | "EdgeFlag") {
            String::new()
        } else {
            self.components.to_string()
        };
        let normalised = if self.normalised { "N" } else { "" };
        format!("gl{}{kind}{digit}{normalised}{}v{}", self.family, self.type_name, self.suffix)
    }

    /// Returns the length of the array; packed components are one number.
    fn length(&self) -> usize {
        if self.kind == Some('P') { 1 } else { self.components }
    }

    /// Returns the variant of `Sets`.
    fn sets(&self) -> &'static str {
        // True if the numbers are the coordinates themselves.
        let plain = self.kind.is_none() && !self.normalised && self.type_name != "h";
        match self.family {
            "Vertex" if plain => "Position",
            "Vertex" | "EvalCoord" => "Vertex",
            "VertexAttrib" if plain => "Generic",
            "VertexAttrib" => "ConvertedGeneric",
            "MultiTexCoord" => "TextureUnit",
            "TexCoord" => "Texture",
            "SecondaryColor" => "SecondaryColor",
            "Color" => "Color",
            "Normal" => "Normal",
            "FogCoord" => "Fog",
            "Index" => "Index",
            _ => "EdgeFlag",
        }
    }
}

/// True if this is one of these commands.
pub fn is_attribute(name: &str) -> bool {
    Form::parse(name).is_some()
}

/// Returns one invocation of the macro `attribute_commands`, with two tables. `declarations` must
/// contain all commands for which [`is_attribute`] is true.
///
/// A row of the first table has name, parameters, the command that takes the same components as an
/// array, the attribute that is set, the parameters before the components (a unit, an index), and
/// the components. The second table has the commands that take an array. A row has position and
/// type of the parameters before the array, the position of the array, and whether its components
/// are the numbers themselves.
pub fn generate(declarations: &[Declaration]) -> String {
    let mut commands = String::new();
    let mut arrays = String::new();
    for declaration in declarations {
        let Some(form) = Form::parse(&declaration.name) else { continue };
        let Declaration { name, method, parameters } = declaration;
        let vector_name = form.vector_name();
        let vector = declarations.iter().find(|d| d.name == vector_name);
        let vector = vector.unwrap_or_else(|| panic!("the registry has {name} without {vector_name}"));
        let before = vector.parameters.len() - 1;
        let join = |parts: Vec<String>| parts.join(", ");
        let typed = join(parameters.iter().map(|(name, kind)| format!("{name}: {kind}")).collect());
        let prefix = join(parameters[..before].iter().map(|(name, _)| name.clone()).collect());
        let components = if form.vector {
            let (name, kind) = &parameters[before];
            format!("array::<{}, {}>({name})", kind.trim_start_matches("*const "), form.length())
        } else {
            format!("[{}]", join(parameters[before..].iter().map(|(name, _)| name.clone()).collect()))
        };
        let (sets, vector) = (form.sets(), &vector.method);
        writeln!(commands, "        {name:?} {method}({typed}) as {vector} = {sets} [{prefix}] {components};")
            .expect("writing to a String");
        if form.vector {
            let places = parameters[..before].iter().enumerate().map(|(place, (_, kind))| format!("{place}: {kind}"));
            let plain = form.kind.is_none() && form.type_name != "h";
            writeln!(arrays, "        {method}({}) {before} {plain};", join(places.collect()))
                .expect("writing to a String");
        }
    }
    format!("attribute_commands! {{\n    {{\n{commands}    }}\n    {{\n{arrays}    }}\n}}\n")
}
