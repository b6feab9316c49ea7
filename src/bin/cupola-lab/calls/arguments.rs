//! Random arguments: mostly such that a call has an effect, sometimes wrong ones.

use super::registry::{Command, Parameter, Registry};
use super::rules;
use crate::random::Random;
use std::fmt::Write;

/// Generator of calls as lines of text.
pub struct Caller<'a> {
    pub random: Random,
    registry: &'a Registry,
}

const SIZES: [i32; 20] = [0, 1, 1, 2, 2, 3, 4, 4, 4, 5, 8, 8, 16, 16, 17, 32, 32, 64, 64, -1];
const PLACES: [i32; 16] = [0, 0, 0, 0, 1, 2, 3, 4, 8, 16, 31, 48, 60, 64, -3, 100];
const NUMBERS: [i32; 16] = [0, 0, 0, 1, 1, 1, 2, 2, 3, 4, 5, 7, 8, 16, -1, 255];
const REALS: [f64; 16] = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.5, 0.25, 0.75, -1.0, 2.0, -0.5, 4.0, 16.0, 64.0, 100_000.0];

impl<'a> Caller<'a> {
    pub fn new(seed: u64, registry: &'a Registry) -> Self {
        Self { random: Random::new(seed), registry }
    }

    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.random.below(from.len())]
    }

    pub fn one_in(&mut self, count: usize) -> bool {
        self.random.below(count) == 0
    }

    /// Makes a call with random arguments.
    pub fn call(&mut self, command: &Command) -> String {
        let mut line = self.result(command);
        if self.one_in(10) {
            line.push('-');
        }
        write!(line, " {}", command.name).expect("writing to a String");
        for parameter in &command.parameters {
            let argument = self.argument(command, parameter);
            write!(line, " {argument}").expect("writing to a String");
        }
        match self.names_in(command, &line) {
            Some(letter) => line.replacen(' ', &format!("?{letter} "), 1),
            None => line,
        }
    }

    /// Kind of names that a call writes.
    fn names_in(&self, command: &Command, line: &str) -> Option<char> {
        let name = &*command.name;
        let asks = name.starts_with("glGet")
            && line.contains("&s")
            && command.parameters.iter().any(|p| p.group == "GetPName" || p.name == "pname" || p.group == "TypeEnum");
        let values = line.split(' ').filter_map(|word| u32::from_str_radix(word.strip_prefix("0x")?, 16).ok());
        let mut names = values.filter_map(|value| {
            let index = self.registry.values.binary_search_by_key(&value, |(value, _)| *value).ok()?;
            super::questions::names_in(&self.registry.values[index].1)
        });
        names.next().filter(|_| asks)
    }

    fn result(&mut self, command: &Command) -> String {
        let name = &*command.name;
        let made = [
            ("glCreateProgram", 'p'),
            ("glCreateShaderProgram", 'p'),
            ("glCreateProgramObject", 'p'),
            ("glCreateShader", 's'),
            ("glCreateShaderObject", 's'),
            ("glGenLists", 'l'),
            ("glFenceSync", 'y'),
        ];
        let plain = name.trim_end_matches(|c: char| c.is_ascii_uppercase()).trim_end_matches('v');
        if let Some((_, letter)) = made.iter().find(|(name, _)| *name == plain) {
            return format!("n={letter}{}", self.random.below(SLOTS));
        }
        match &*command.result {
            "void" => "v",
            "GLboolean" => "b",
            "pointer" => "p",
            // Handles of the extension are names.
            "GLhandleARB" => "p",
            // The driver chooses the location.
            // Triangles without area have the front or the back ahead by the direction of the window's rows.
            _ if name == "glRenderMode" => "s",
            _ if name.ends_with("Location") => "s",
            _ => "i",
        }
        .to_owned()
    }

    /// Slot of a kind of names.
    fn slot(&mut self, letter: char) -> String {
        if self.one_in(12) {
            return (if self.one_in(4) { "4000000" } else { "0" }).to_owned();
        }
        format!("%{letter}{}", self.random.below(SLOTS))
    }

    /// List of slots, long enough for each number of names that a call requests.
    fn slots(&mut self, letter: char) -> String {
        let list: Vec<String> = (0..LIST).map(|_| format!("{letter}{}", self.random.below(SLOTS))).collect();
        list.join(",")
    }

    fn reals(&mut self, letter: char, count: usize) -> String {
        let list: Vec<String> = (0..count).map(|_| self.pick(&REALS).to_string()).collect();
        format!("[{letter}{}", list.join(","))
    }

    /// Value of a group, or sometimes any other value.
    pub fn value(&mut self, group: &str, command: &str) -> u32 {
        for _ in 0..8 {
            let value = match self.registry.groups.get(group) {
                Some(values) if !values.is_empty() && !self.one_in(16) => self.pick(values),
                _ => self.random_value(),
            };
            if !self.is_left_out(command, value) {
                return value;
            }
        }
        0
    }

    fn random_value(&mut self) -> u32 {
        if self.one_in(8) {
            self.pick(&NUMBERS) as u32
        } else {
            self.registry.values[self.random.below(self.registry.values.len())].0
        }
    }

    fn is_left_out(&self, command: &str, value: u32) -> bool {
        rules::VALUES_LEFT_OUT
            .iter()
            .any(|(beginning, name, _)| command.starts_with(beginning) && self.registry.value(name) == Some(value))
    }

    fn argument(&mut self, command: &Command, parameter: &Parameter) -> String {
        if parameter.pointers > 0 {
            return self.pointer(command, parameter);
        }
        match &*parameter.base {
            // Fractions of the window's viewport would be rounded.
            "GLfloat" if command.name.starts_with("glViewport") => format!("f{}", self.pick(&PLACES)),
            "GLfloat" | "GLclampf" => format!("f{}", self.pick(&REALS)),
            "GLdouble" | "GLclampd" => format!("d{}", self.pick(&REALS)),
            "GLenum" => self.enumerant(command, parameter),
            "GLbitfield" => self.bits(parameter),
            "GLboolean" => self.random.below(2).to_string(),
            "GLsync" => format!("%y{}", self.random.below(SLOTS)),
            "GLDEBUGPROC" | "GLDEBUGPROCARB" | "GLDEBUGPROCKHR" => "&c".to_owned(),
            "GLintptr" | "GLsizeiptr" | "GLintptrARB" | "GLsizeiptrARB" => {
                self.pick(&[0, 0, 4, 16, 16, 64, 64, 256, 1024, 1024, -4, 3]).to_string()
            }
            _ => self.whole(command, parameter),
        }
    }

    fn bits(&mut self, parameter: &Parameter) -> String {
        let members = self.registry.groups.get(&parameter.group).cloned().unwrap_or_default();
        if members.is_empty() || self.one_in(10) {
            return self.pick(&[0u32, 1, 2, 3, 0xf, 0x4000, 0x4100, 0xffff_ffff]).to_string();
        }
        let mut all = 0;
        for _ in 0..1 + self.random.below(3) {
            all |= self.pick(&members);
        }
        format!("{all:#x}")
    }

    fn enumerant(&mut self, command: &Command, parameter: &Parameter) -> String {
        let group = match (&*parameter.name, &*parameter.group) {
            ("texture" | "texunit" | "target", "TextureUnit") => {
                let units = if self.one_in(16) { 200 } else { 4 };
                return format!("{:#x}", 0x84C0 + self.random.below(units));
            }
            ("target", "") if command.name.contains("Buffer") => "BufferTargetARB",
            ("target", "") if command.name.contains("Query") => "QueryTarget",
            ("target", "") if command.name.contains("Framebuffer") => "FramebufferTarget",
            ("target" | "textarget", "TextureTarget") if !self.one_in(6) => {
                return format!(
                    "{:#x}",
                    self.pick(&[0x0DE1, 0x0DE1, 0x0DE1, 0x0DE0, 0x806F, 0x8513, 0x8C1A, 0x84F5, 0x8515])
                );
            }
            ("target", "BufferTargetARB") if self.one_in(2) => {
                return format!("{:#x}", self.pick(&[0x8892, 0x8893, 0x8A11, 0x88EB, 0x88EC]));
            }
            ("internalformat", _) if !self.one_in(4) => {
                return format!(
                    "{:#x}",
                    self.pick(&[
                        0x8058, 0x8058, 0x8051, 0x1908, 0x1907, 0x8229, 0x881A, 0x8814, 0x81A6, 0x88F0, 0x8C43, 0x8D7C
                    ])
                );
            }
            ("format", "PixelFormat") if !self.one_in(4) => {
                return format!("{:#x}", self.pick(&[0x1908, 0x1908, 0x1907, 0x1903, 0x80E1, 0x1902, 0x84F9, 0x8D99]));
            }
            ("type", "PixelType") if !self.one_in(4) => {
                return format!("{:#x}", self.pick(&[0x1401, 0x1401, 0x1406, 0x1403, 0x84FA]));
            }
            ("type", "") => "VertexPointerType",
            ("attachment", _) if !self.one_in(4) => {
                return format!("{:#x}", self.pick(&[0x8CE0, 0x8CE0, 0x8CE1, 0x8D00, 0x8D20, 0x821A]));
            }
            ("attachment", "") => "FramebufferAttachment",
            ("mode", "PrimitiveType" | "BeginMode") => {
                let modes = if self.one_in(16) { 20 } else { 10 };
                return self.random.below(modes).to_string();
            }
            (_, group) => group,
        };
        format!("{:#x}", self.value(group, &command.name))
    }

    fn whole(&mut self, command: &Command, parameter: &Parameter) -> String {
        let (name, of) = (&*parameter.name, &*command.name);
        if matches!(&*parameter.base, "GLuint" | "GLhandleARB" | "GLint")
            && let Some(letter) = letter(of, name)
        {
            return self.slot(letter);
        }
        let from: &[i32] = match name {
            // Names that lists of Cupola keep apart are not neighbours.
            "range" if of == "glDeleteLists" => &[0, 1, 1, 1, -1],
            "width" | "height" | "depth" | "srcWidth" | "srcHeight" | "srcDepth" | "w" | "h" => &SIZES,
            "x" | "y" | "z" | "left" | "bottom" | "xoffset" | "yoffset" | "zoffset" => &PLACES,
            _ if name.starts_with("src") || name.starts_with("dst") => &PLACES,
            "level" | "lod" | "levels" | "maxlevel" | "minlevel" => &[0, 0, 0, 0, 1, 1, 2, 3, -1, 40],
            "border" => &[0, 0, 0, 0, 0, 0, 1, -1],
            "n" | "count" | "numAttachments" | "propCount" | "uniformCount" | "drawcount" | "primcount" | "range"
                if !of.contains("Draw") =>
            {
                &[0, 1, 1, 1, 2, 2, 3, 4, 4, -1]
            }
            "count" | "instancecount" | "primcount" | "drawcount" => &[0, 1, 3, 3, 4, 4, 6, 8, -1],
            // Mesa 22.3 trusts other values and reads beyond.
            "start" => &[0],
            "end" => &[16, 64],
            "first" if of.contains("Draw") => &[0, 0, 0, 1, 2, 4, -1],
            "basevertex" | "baseinstance" => &[0, 0, 1, 2, 8],
            "bufSize" | "bufsize" | "maxLength" | "maxCount" => &[0, 1, 5, 16, 64, 64, -1],
            "stride" if of.starts_with("glMap") => &[1, 2, 3, 4, 8],
            "ustride" | "vstride" => &[1, 2, 3, 4, 8, 16],
            "order" | "uorder" | "vorder" => &[1, 2, 3, 4, 0, -1, 40],
            "un" | "vn" | "i1" | "i2" | "j1" | "j2" => &[1, 2, 3, 5],
            "stride" => &[0, 0, 0, 4, 8, 12, 16, 32, -1],
            "size" if of.contains("Pointer") || of.contains("Format") || of.contains("Offset") => {
                &[1, 2, 3, 4, 4, 0, 5, 0x80E1]
            }
            "size" => &[0, 16, 64, 64, 256, 1024, -1],
            "mapsize" => &[0, 1, 2, 3, 4, 16, 256, -1],
            "imageSize" | "length" | "len" => &[0, 1, 4, 16, 64, 128, 256, -1],
            "samples" => &[0, 0, 1, 2, 4, 4, 64, -1],
            // Mesa 22.3 adds such a number to the count without noticing the overflow.
            "first" if of.contains("Array") || of.starts_with("glBind") => &[0, 0, 1, 2, 80],
            "index" | "unit" | "first" | "attribindex" | "bindingindex" | "stream" | "drawbuffer" | "buf" => {
                &[0, 0, 0, 0, 1, 1, 2, 3, 7, 15, 16, 80, -1]
            }
            "location" => &[0, 0, 0, 40, 41, -1, -1, 1000],
            "num_groups_x" | "num_groups_y" | "num_groups_z" => &[0, 1, 2, 70000],
            "ref" | "mask" | "s" | "stencil" => &[0, 1, 1, 2, 3, 15, 255, -1],
            "divisor" | "relativeoffset" | "offset" => &[0, 0, 0, 1, 4, 16, 64],
            "param" | "internalformat" | "value" if !self.one_in(3) => return self.some_value(command),
            "base" => &[0],
            _ if of.starts_with("glViewport") || of.starts_with("glScissor") => &PLACES,
            _ => &NUMBERS,
        };
        self.pick(from).to_string()
    }

    /// Value that a parameter of textures, buffers, … may have.
    fn some_value(&mut self, command: &Command) -> String {
        let of = &*command.name;
        let groups: &[&str] = if of.contains("Tex") || of.contains("Sampler") {
            &[
                "TextureMinFilter",
                "TextureMagFilter",
                "TextureWrapMode",
                "DepthFunction",
                "TextureEnvMode",
                "InternalFormat",
            ]
        } else {
            &["FogMode", "Boolean", "ClampColorModeARB"]
        };
        if self.one_in(3) {
            return self.pick(&NUMBERS).to_string();
        }
        let group = self.pick(groups);
        self.value(group, of).to_string()
    }

    fn pointer(&mut self, command: &Command, parameter: &Parameter) -> String {
        let (name, of) = (&*parameter.name, &*command.name);
        let makes = of.starts_with("glGen") || (of.starts_with("glCreate") && !of.contains("Shader"));
        match (&*parameter.base, parameter.is_const, parameter.pointers) {
            ("GLuint", false, 1) if makes => match letter(of, name) {
                Some(letter) => format!(">{}", self.slots(letter)),
                None => "&s".to_owned(),
            },
            ("GLuint", true, 1) if letter(of, name).is_some() => {
                let letter = letter(of, name).expect("just asked for");
                format!("[n{}", self.slots(letter))
            }
            (_, false, 1) if parameter.base == "void" => {
                let reads = ["glGetTex", "glReadPixels", "glGetCompressed"].iter().any(|begin| of.starts_with(begin));
                if reads || of.contains("PolygonStipple") { "@p0".to_owned() } else { "&u".to_owned() }
            }
            (_, false, _) => self.output(of, name),
            (base, true, count) if count > 1 || matches!(base, "GLchar" | "GLcharARB") => {
                self.texts(command, parameter)
            }
            ("GLfloat", true, 1) if of.starts_with("glViewport") => {
                let list: Vec<String> = (0..16).map(|_| self.pick(&PLACES).to_string()).collect();
                format!("[f{}", list.join(","))
            }
            ("GLfloat" | "GLclampf", true, 1) => self.short_reals('f', parameter),
            ("GLdouble" | "GLclampd", true, 1) => self.short_reals('d', parameter),
            ("GLenum", true, 1) => self.enums(of),
            // The driver reads arrays in the player's memory as the call demands.
            ("GLint", true, 1) if name == "first" => {
                let list: Vec<String> = (0..16).map(|_| self.pick(&NUMBERS).to_string()).collect();
                format!("[i{}", list.join(","))
            }
            ("GLint" | "GLuint", true, 1)
                if parameter.length.is_empty() || parameter.length.starts_with("COMPSIZE") =>
            {
                let list: Vec<String> = (0..16)
                    .map(|_| if self.one_in(3) { self.some_value(command) } else { self.pick(&NUMBERS).to_string() })
                    .collect();
                format!("[i{}", list.join(","))
            }
            ("void", true, 1) if of.contains("Pointer") || of.contains("InterleavedArrays") => {
                format!("@a{}", self.pick(&[0, 0, 4, 16]))
            }
            ("void", true, 1) if of == "glCallLists" => format!("[n{}", self.slots('l')),
            ("void", true, 1) if of.contains("Indirect") => format!("@i{}", self.pick(&[0, 0, 4, 16])),
            ("void", true, 1) if name == "indices" => format!("@e{}", self.pick(&[0, 0, 4, 16])),
            ("void", true, 1) if name == "pixels" || of.contains("Image") => {
                if of.contains("TexImage") && self.one_in(4) { "0".to_owned() } else { "@u0".to_owned() }
            }
            ("GLubyte", true, 1) if name == "bitmap" || name == "mask" => "@u0".to_owned(),
            ("void", true, 1) if (of.contains("BufferData") || of.contains("Storage")) && self.one_in(3) => {
                "0".to_owned()
            }
            _ => format!("~{}", self.pick(&[0, 4, 16, 64])),
        }
    }

    /// List of enums for a command.
    fn enums(&mut self, of: &str) -> String {
        let group = if of.contains("DrawBuffers") {
            "DrawBufferMode"
        } else if of.contains("Invalidate") || of.contains("Discard") {
            "FramebufferAttachment"
        } else {
            "ProgramResourceProperty"
        };
        let own = [0x8CE0, 0x8CE1, 0, 0x8CE2, 0x0405, 0x1800, 0x1801];
        let list: Vec<String> = (0..LIST)
            .map(|_| if self.one_in(2) { self.pick(&own) } else { self.value(group, of) }.to_string())
            .collect();
        format!("[i{}", list.join(","))
    }

    fn short_reals(&mut self, letter: char, parameter: &Parameter) -> String {
        match parameter.length.parse::<usize>() {
            Ok(count @ 1..=4) => self.reals(letter, count),
            _ if parameter.length.starts_with("count") || parameter.length == "mapsize" => "~0".to_owned(),
            _ => self.reals(letter, 16),
        }
    }

    fn output(&mut self, of: &str, name: &str) -> String {
        let area = match of {
            "glFeedbackBuffer" | "glSelectBuffer" => "&f",
            _ if of.starts_with("glGetQueryObject") || of.starts_with("glGetQueryBuffer") => "&u",
            _ if of.starts_with("glGetPixelMap") => "@p0",
            _ if name == "infoLog" => "&u",
            _ => "&s",
        };
        area.to_owned()
    }

    fn texts(&mut self, command: &Command, parameter: &Parameter) -> String {
        let of = &*command.name;
        if matches!(&*parameter.base, "GLchar" | "GLcharARB") && parameter.pointers == 1 {
            return format!(
                "'{}",
                self.pick(&["u0", "u1", "position", "colour", "block", "gl_Position", "nothing", ""])
            );
        }
        if of.contains("ShaderSource") || of.contains("ShaderProgram") {
            let source = self.pick(&super::sources::ALL);
            return format!("*{}", super::sources::line(source));
        }
        if parameter.base == "void" {
            // These lists contain places of indices.
            return "[l0,0,0,0,0,0,0,0".to_owned();
        }
        "*u0^u1^position^colour^block".to_owned()
    }
}

/// Number of names of each kind that calls use.
pub const SLOTS: usize = 4;
/// Length of lists of names.
const LIST: usize = 8;

/// Kind of names that a parameter takes.
fn letter(command: &str, parameter: &str) -> Option<char> {
    Some(match parameter {
        "texture" | "textures" | "origtexture" | "srcName" | "dstName" => 't',
        "buffer" | "buffers" | "readBuffer" | "writeBuffer"
            if !command.starts_with("glClear") || command.contains("NamedBuffer") =>
        {
            'b'
        }
        "framebuffer" | "framebuffers" | "readFramebuffer" | "drawFramebuffer" => 'f',
        "renderbuffer" | "renderbuffers" => 'r',
        "array" | "arrays" | "vaobj" => 'v',
        "id" | "ids" if command.contains("TransformFeedback") => 'x',
        "id" | "ids" if command.contains("Quer") || command.contains("ConditionalRender") => 'q',
        "list" | "lists" => 'l',
        "sampler" | "samplers" => 'a',
        "xfb" => 'x',
        "pipeline" | "pipelines" => 'g',
        "program" | "programs" | "programObj" | "containerObj" => {
            if command.ends_with("ProgramsARB") || command == "glBindProgramARB" || command == "glIsProgramARB" {
                'o'
            } else {
                'p'
            }
        }
        "shader" | "shaders" | "shaderObj" | "attachedObj" => 's',
        "obj" => 'p',
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::{Caller, Registry};

    #[test]
    fn each_command_has_arguments() {
        let Ok(registry) = Registry::read() else { panic!("the registry cannot be read") };
        let mut caller = Caller::new(1, &registry);
        for command in registry.commands.values() {
            let line = caller.call(command);
            assert_eq!(line.split(' ').count(), 2 + command.parameters.len(), "{line}");
        }
    }
}
