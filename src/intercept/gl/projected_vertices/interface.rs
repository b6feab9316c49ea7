//! Outputs of a stage before rasterisation, found in its text, so that a stage of Cupola can follow
//! it.
//!
//! The outputs become plain variables, which are copied into outputs of Cupola at the end of
//! `main`. The stage of Cupola reads these, and has outputs with the names, qualifiers and
//! locations that the fragment stage expects.

use crate::intercept::gl::shader::source::patch;
use crate::intercept::scene::obstacle::Obstacle;
use std::ops::Range;

/// Stage output, or element of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// Name in the stage itself.
    pub own: String,
    /// Name in the stage of Cupola.
    pub handed: String,
    /// Type.
    pub kind: String,
    /// True if the value is not interpolated.
    pub flat: bool,
}

/// Outputs of a stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interface {
    /// All values. Arrays are listed element by element.
    pub values: Vec<Value>,
    /// Declarations of the outputs of the stage of Cupola.
    pub declarations: Vec<String>,
    /// Texts that replace the declarations in the stage's own text.
    edits: Vec<(Range<usize>, String)>,
}

/// Built-in outputs of the compatibility profile that are passed on if a text names them.
const BUILT_IN: [&str; 5] =
    ["gl_FrontColor", "gl_BackColor", "gl_FrontSecondaryColor", "gl_BackSecondaryColor", "gl_FogFragCoord"];

/// Built-in outputs that cannot be passed on.
const LEFT_OUT: [&str; 5] = ["gl_ClipDistance", "gl_CullDistance", "gl_ClipVertex", "gl_Layer", "gl_ViewportIndex"];

/// Longest array that is passed on element by element.
const LONGEST: usize = 32;

/// Returns the built-in outputs that `bare` names, with their types.
pub fn built_in(bare: &str) -> Vec<(&'static str, &'static str)> {
    let kind = |name: &str| if name == "gl_FogFragCoord" { "float" } else { "vec4" };
    BUILT_IN.into_iter().filter(|name| patch::mentions(bare, name)).map(|name| (name, kind(name))).collect()
}

/// Returns the outputs of `bare`, a stage's text without comments.
///
/// # Errors
/// The reason why the outputs cannot be passed on, for the log.
pub fn read(bare: &str) -> Result<Interface, Obstacle> {
    if LEFT_OUT.iter().any(|name| patch::mentions(bare, name)) {
        return Err("a shader sets clip distances, layers or viewports".into());
    }
    let mut interface = Interface::default();
    for (range, conditional) in statements(bare) {
        let text = &bare[range.clone()];
        let head = text.split(['{', ';']).next().unwrap_or_default();
        let words: Vec<&str> = head.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).collect();
        let hands_on = words.iter().any(|word| *word == "out" || *word == "varying");
        if !hands_on || head.contains('(') && !head.trim_start().starts_with("layout") {
            continue;
        }
        if conditional {
            return Err("a shader's outputs depend on preprocessor conditions".into());
        }
        match text.split_once('{') {
            Some((head, rest)) => interface.block(head, rest, range)?,
            None => interface.plain(text.trim_end().trim_end_matches(';'), range)?,
        }
    }
    Ok(interface)
}

impl Interface {
    /// Adds the elements of `gl_TexCoord` that `bare` names.
    ///
    /// # Errors
    /// The reason why they cannot be passed on, for the log.
    pub fn add_texture_coordinates(&mut self, bare: &str) -> Result<(), Obstacle> {
        for part in bare.split("gl_TexCoord").skip(1) {
            let index = part.trim_start().strip_prefix('[').and_then(|rest| rest.split(']').next());
            let index: usize = index
                .and_then(|index| index.trim().parse().ok())
                .ok_or("a shader uses gl_TexCoord with a computed index")?;
            let name = format!("gl_TexCoord[{index}]");
            if self.values.iter().all(|value| value.own != name) {
                self.values.push(Value { own: name.clone(), handed: name, kind: "vec4".to_owned(), flat: false });
            }
        }
        Ok(())
    }

    /// Returns the stage's text with plain variables instead of its outputs.
    pub fn edited(&self, text: &str) -> String {
        let mut edited = String::with_capacity(text.len());
        let mut end = 0;
        for (range, replacement) in &self.edits {
            edited.push_str(&text[end..range.start]);
            edited.push_str(replacement);
            // Line numbers stay the same.
            edited.extend(text[range.clone()].chars().filter(|c| *c == '\n'));
            end = range.end;
        }
        edited.push_str(&text[end..]);
        edited
    }

    /// Reads a declaration like `flat out vec2 a, b[3];`.
    fn plain(&mut self, text: &str, range: Range<usize>) -> Result<(), Obstacle> {
        let (layout, rest) = layout(text);
        let mut words = rest.split_whitespace();
        let (mut qualifiers, mut kind) = (Vec::new(), "");
        for word in words.by_ref() {
            match word {
                "out" | "varying" | "highp" | "mediump" | "lowp" | "precise" => {}
                "flat" | "smooth" | "noperspective" | "centroid" | "sample" => qualifiers.push(word),
                "invariant" | "patch" => return Err("a shader's outputs have unsupported qualifiers".into()),
                _ => {
                    kind = word;
                    break;
                }
            }
        }
        let names = rest.split_once(kind).map_or("", |(_, names)| names);
        let flat = qualifiers.contains(&"flat");
        let mut own = String::new();
        for name in names.split(',') {
            let (name, size) = array(name)?;
            self.values_of(name, name, kind, size, flat)?;
            let brackets = size.map_or(String::new(), |size| format!("[{size}]"));
            own += &format!("{kind} {name}{brackets}; ");
            let redeclared = name.starts_with("gl_");
            if redeclared {
                return Err("a shader declares built-in outputs".into());
            }
            self.declarations.push(format!("{layout} {} out {kind} {name}{brackets};", qualifiers.join(" ")));
        }
        self.edits.push((range, own));
        Ok(())
    }

    /// Reads a declaration like `out Name { flat int a; vec2 b; } instance;`.
    fn block(&mut self, head: &str, rest: &str, range: Range<usize>) -> Result<(), Obstacle> {
        let (members, tail) = rest.split_once('}').ok_or("a block in a shader has no end")?;
        let (layout, head) = layout(head);
        let name = head.split_whitespace().last().unwrap_or_default();
        let instance = tail.trim().trim_end_matches(';').trim();
        if name == "gl_PerVertex" {
            // A declaration of the built-in block is not needed.
            self.edits.push((range, String::new()));
            return Ok(());
        }
        if instance.contains('[') {
            return Err("a shader outputs arrays of blocks".into());
        }
        let handed = format!("cupola_{name}");
        let mut fields = String::new();
        for member in members.split(';').filter(|member| !member.trim().is_empty()) {
            let (_, member) = self::layout(member);
            let kept = |word: &&str| {
                !["flat", "smooth", "noperspective", "centroid", "sample", "highp", "mediump", "lowp"].contains(word)
            };
            let flat = member.split_whitespace().any(|word| word == "flat");
            let mut words = member.split_whitespace().filter(kept);
            let kind = words.next().unwrap_or_default();
            let names = words.collect::<String>();
            for name in names.split(',') {
                let (name, size) = array(name)?;
                let prefixed =
                    |prefix: &str| if instance.is_empty() { name.to_owned() } else { format!("{prefix}.{name}") };
                self.values_of(&prefixed(instance), &prefixed(&handed), kind, size, flat)?;
                let brackets = size.map_or(String::new(), |size| format!("[{size}]"));
                fields += &format!("{kind} {name}{brackets}; ");
            }
        }
        let (own, after) = match instance {
            "" => (fields, String::new()),
            _ => (format!("struct cupola_struct_{name} {{ {fields} }} {instance};"), handed),
        };
        self.edits.push((range, own));
        self.declarations.push(format!("{layout} out {name} {{ {members} }} {after};"));
        Ok(())
    }

    /// Adds the value of a variable, or the values of an array's elements.
    fn values_of(
        &mut self,
        own: &str,
        handed: &str,
        kind: &str,
        size: Option<usize>,
        flat: bool,
    ) -> Result<(), Obstacle> {
        let whole = ["int", "uint", "ivec2", "ivec3", "ivec4", "uvec2", "uvec3", "uvec4"].contains(&kind);
        let real = kind == "float"
            || ["vec2", "vec3", "vec4", "mat2", "mat3", "mat4"].contains(&kind)
            || kind.strip_prefix("mat").is_some_and(|rest| rest.len() == 3 && rest.as_bytes()[1] == b'x');
        if !whole && !real {
            return Err("a shader outputs structures or double-precision numbers".into());
        }
        let elements = match size {
            None => vec![String::new()],
            Some(size) => (0..size).map(|index| format!("[{index}]")).collect(),
        };
        for element in elements {
            self.values.push(Value {
                own: format!("{own}{element}"),
                handed: format!("{handed}{element}"),
                kind: kind.to_owned(),
                flat: flat || whole,
            });
        }
        Ok(())
    }

    /// Returns the number of components of all values.
    pub fn components(&self) -> usize {
        let digits =
            |kind: &str| kind.bytes().filter(u8::is_ascii_digit).map(|d| usize::from(d - b'0')).collect::<Vec<_>>();
        let of_kind = |kind: &str| match (kind.starts_with("mat"), digits(kind).as_slice()) {
            (true, [size]) => size * size,
            (true, [columns, rows]) => columns * rows,
            (false, [size]) => *size,
            _ => 1,
        };
        self.values.iter().map(|value| of_kind(&value.kind)).sum()
    }
}

/// Splits a declared name into the name and the length of its array.
fn array(text: &str) -> Result<(&str, Option<usize>), Obstacle> {
    let Some((name, rest)) = text.split_once('[') else { return Ok((text.trim(), None)) };
    let size = rest.trim().strip_suffix(']').and_then(|size| size.trim().parse().ok());
    match size.filter(|size| (1..=LONGEST).contains(size)) {
        Some(size) => Ok((name.trim(), Some(size))),
        None => Err("a shader outputs arrays that are too long, or whose length is not a plain number".into()),
    }
}

/// Splits a text into a leading `layout(…)` and the rest.
fn layout(text: &str) -> (&str, &str) {
    let text = text.trim();
    match text.strip_prefix("layout").and_then(|rest| rest.find(')')) {
        Some(end) => text.split_at("layout".len() + end + 1),
        None => ("", text),
    }
}

/// Returns the declarations and definitions at the outermost level, and whether each depends on the
/// preprocessor.
fn statements(bare: &str) -> Vec<(Range<usize>, bool)> {
    let mut found = Vec::new();
    let (mut depth, mut conditions, mut start) = (0usize, 0usize, 0usize);
    let mut offset = 0;
    for line in bare.split_inclusive('\n') {
        if let Some(directive) = line.trim_start().strip_prefix('#') {
            match directive.trim_start() {
                word if word.starts_with("if") => conditions += 1,
                word if word.starts_with("endif") => conditions = conditions.saturating_sub(1),
                _ => {}
            }
            if depth == 0 && bare[start..offset].trim().is_empty() {
                start = offset + line.len();
            }
        } else {
            for (at, c) in line.char_indices() {
                let end = offset + at + 1;
                match c {
                    '{' => depth += 1,
                    '}' => {
                        depth = depth.saturating_sub(1);
                        // A function ends with its brace, a block and a structure with a semicolon.
                        let head = bare[start..end].split('{').next().unwrap_or_default();
                        if depth == 0 && head.trim_end().ends_with(')') {
                            start = end;
                        }
                    }
                    ';' if depth == 0 => {
                        found.push((start..end, conditions > 0));
                        start = end;
                    }
                    _ => {}
                }
            }
        }
        offset += line.len();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::read;

    fn handed(text: &str) -> Vec<(String, String, bool)> {
        let interface = read(text).expect("can be read");
        interface.values.into_iter().map(|value| (value.own, value.kind, value.flat)).collect()
    }

    #[test]
    fn outputs_of_all_kinds_are_found() {
        let text = "#version 330\nin vec3 p;\nout vec3 shade, tint;\nflat out int kind;\nlayout(location = 2) out vec2 at[2];\n\
            uniform mat4 m;\nvoid set(out vec3 v) { v = p; }\nvoid main() { set(shade); }\n";
        let one = |own: &str, kind: &str, flat| (own.to_owned(), kind.to_owned(), flat);
        let expected = [
            one("shade", "vec3", false),
            one("tint", "vec3", false),
            one("kind", "int", true),
            one("at[0]", "vec2", false),
            one("at[1]", "vec2", false),
        ];
        assert_eq!(handed(text), expected);
        let interface = read(text).expect("can be read");
        assert_eq!(interface.components(), 3 + 3 + 1 + 2 + 2);
        let edited = interface.edited(text);
        assert!(edited.contains("vec3 shade; vec3 tint;") && edited.contains("vec2 at[2];"), "{edited}");
        assert!(!edited.contains("out vec3 shade") && edited.contains("void set(out vec3 v)"), "{edited}");
        assert_eq!(edited.matches('\n').count(), text.matches('\n').count());
        assert!(interface.declarations.iter().any(|d| d.trim() == "layout(location = 2)  out vec2 at[2];"));
        assert!(interface.declarations.iter().any(|d| d.trim() == "flat out int kind;"));
    }

    #[test]
    fn blocks_become_structures() {
        let text = "out gl_PerVertex { vec4 gl_Position; };\nout Surface {\n vec3 n;\n flat int id;\n} made;\nvoid main() { made.n = vec3(0); }\n";
        let interface = read(text).expect("can be read");
        assert_eq!(interface.values.len(), 2);
        assert_eq!(
            (interface.values[0].own.as_str(), interface.values[0].handed.as_str()),
            ("made.n", "cupola_Surface.n")
        );
        assert!(interface.values[1].flat);
        let edited = interface.edited(text);
        assert!(edited.contains("struct cupola_struct_Surface { vec3 n; int id;  } made;"), "{edited}");
        assert!(!edited.contains("gl_PerVertex"));
    }

    #[test]
    fn old_varyings_are_outputs() {
        assert_eq!(handed("varying highp vec2 uv;\nvoid main() {}\n").len(), 1);
        assert_eq!(handed("attribute vec4 p;\nvoid main() {}\n").len(), 0);
    }

    #[test]
    fn what_is_not_followed_is_said() {
        for text in [
            "#ifdef A\nout vec3 a;\n#endif\n",
            "out float gl_ClipDistance[1];\n",
            "struct S { vec3 a; };\nout S s;\n",
            "out vec3 a[N];\n",
            "out dvec3 a;\n",
        ] {
            assert!(read(text).is_err(), "{text}");
        }
    }
}
