//! Episodes: random calls in one context.

use super::arguments::{Caller, SLOTS};
use super::registry::{Command, Registry};
use super::{rules, sources};
use clap::ValueEnum;

/// Slot of the display list that is called between Begin and End. It has vertices only: errors of
/// other commands there are a known limit, and so are lists with a Begin of their own.
const LIST_OF_VERTICES: usize = SLOTS - 1;

/// A kind of context.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    Compatibility,
    Core,
    Es3,
    Es2,
}

impl Kind {
    /// Word in the first line of a file.
    pub fn word(self) -> &'static str {
        match self {
            Self::Compatibility => "compatibility",
            Self::Core => "core",
            Self::Es3 => "es3",
            Self::Es2 => "es2",
        }
    }
}

/// Commands that are called, with a weight for each family.
pub struct Vocabulary<'a> {
    registry: &'a Registry,
    /// Families of commands, with the sum of the weights up to each.
    families: Vec<(u32, Vec<&'a Command>)>,
}

impl<'a> Vocabulary<'a> {
    /// Selects the commands of an API.
    pub fn new(registry: &'a Registry, kind: Kind) -> Self {
        let (api, mut names) = match kind {
            Kind::Compatibility => ("gl", registry.desktop.clone()),
            Kind::Core => ("glcore", registry.desktop.clone()),
            Kind::Es3 | Kind::Es2 => ("gles2", registry.es.clone()),
        };
        for extension in rules::EXTENSIONS.split_whitespace() {
            let extension = registry.extensions.get(&format!("GL_{extension}"));
            if let Some(extension) = extension.filter(|extension| extension.supported.split('|').any(|s| s == api)) {
                names.extend(extension.commands.iter().cloned());
            }
        }
        names.retain(|name| !rules::LEFT_OUT.iter().any(|(beginning, _)| rules::begins(name, beginning)));
        let mut families: std::collections::BTreeMap<String, Vec<&Command>> = std::collections::BTreeMap::new();
        for command in names.iter().filter_map(|name| registry.commands.get(name)) {
            families.entry(family(&command.name)).or_default().push(command);
        }
        let mut sum = 0;
        let families = families.into_iter().map(|(name, commands)| {
            sum += rules::WEIGHTS
                .iter()
                .find(|(beginning, _)| name.starts_with(beginning))
                .map_or(4, |(_, weight)| *weight);
            (sum, commands)
        });
        Self { registry, families: families.collect() }
    }

    /// Number of commands.
    pub fn len(&self) -> usize {
        self.families.iter().map(|(_, commands)| commands.len()).sum()
    }

    fn command(&self, caller: &mut Caller) -> &'a Command {
        let total = self.families.last().map_or(1, |(sum, _)| *sum);
        let at = caller.random.below(total as usize) as u32;
        let index = self.families.partition_point(|(sum, _)| *sum <= at);
        let members = &self.families[index].1;
        members[caller.random.below(members.len())]
    }
}

/// Name of a command without the suffix for numbers and types.
fn family(name: &str) -> String {
    let name = name.trim_end_matches(|c: char| c.is_ascii_uppercase());
    let end = name.find(|c: char| c.is_ascii_digit()).unwrap_or(name.len());
    name[..end].trim_end_matches(['v', 'f', 'i', 'd', 's', 'b', 'u']).to_owned()
}

/// Lines of an episode.
pub fn lines(vocabulary: &Vocabulary, seed: u64, kind: Kind, calls: usize) -> Vec<String> {
    let mut writer = Writer {
        caller: Caller::new(seed, vocabulary.registry),
        vocabulary,
        lines: vec![format!("context {}", kind.word())],
        list: None,
        in_primitive: false,
        kind,
    };
    writer.names();
    while writer.lines.len() < calls {
        writer.step();
    }
    writer.line("ask");
    writer.lines
}

struct Writer<'v, 'a> {
    caller: Caller<'a>,
    vocabulary: &'v Vocabulary<'a>,
    lines: Vec<String>,
    /// Slot of the list that is being compiled.
    list: Option<usize>,
    /// True between Begin and End.
    in_primitive: bool,
    kind: Kind,
}

impl Writer<'_, '_> {
    fn line(&mut self, line: impl Into<String>) {
        self.lines.push(line.into());
    }

    fn is_es(&self) -> bool {
        matches!(self.kind, Kind::Es3 | Kind::Es2)
    }

    /// Gives each slot a name.
    fn names(&mut self) {
        let kinds = [
            ("Textures", 't'),
            ("Buffers", 'b'),
            ("Framebuffers", 'f'),
            ("Renderbuffers", 'r'),
            ("VertexArrays", 'v'),
            ("Queries", 'q'),
            ("Samplers", 'a'),
            ("TransformFeedbacks", 'x'),
            ("ProgramPipelines", 'g'),
        ];
        for (name, letter) in kinds {
            let slots: Vec<String> = (0..SLOTS).map(|slot| format!("{letter}{slot}")).collect();
            self.line(format!("v glGen{name} {SLOTS} >{}", slots.join(",")));
        }
        for slot in 0..SLOTS {
            if !self.is_es() {
                self.line(format!("n=l{slot} glGenLists 1"));
                self.line(format!("v glNewList %l{slot} 0x1300"));
                self.line("v glEndList");
            }
            self.program(slot);
        }
        if self.kind == Kind::Core {
            self.line("v glBindVertexArray %v0");
        }
    }

    fn step(&mut self) {
        match self.caller.random.below(100) {
            0 => self.line("ask"),
            1 if self.list.is_none() => {
                self.line("ask");
                self.line("swap");
                self.line("ask");
            }
            2..5 if !self.is_es() => self.primitive(),
            5..7 if self.list.is_none() && !self.is_es() => self.list(),
            7..9 => {
                let slot = self.caller.random.below(SLOTS);
                self.program(slot);
            }
            9..12 => self.arrays(),
            12..15 => self.framebuffer(),
            15..18 => self.query(),
            18..20 => self.window(),
            _ => self.call(),
        }
    }

    fn call(&mut self) {
        let command = self.vocabulary.command(&mut self.caller);
        if let Some(slot) = self.list
            && command.name.starts_with("glCallList")
        {
            // A list that calls itself would never end.
            if slot > 0 && slot != LIST_OF_VERTICES {
                let called = self.caller.random.below(slot);
                self.line(format!("v glCallList %l{called}"));
            }
            return;
        }
        if ["glCallList", "glArrayElement"].iter().any(|name| command.name.starts_with(name)) && self.in_primitive {
            return;
        }
        let line = self.caller.call(command);
        self.line(line);
    }

    fn calls(&mut self, most: usize) {
        for _ in 0..self.caller.random.below(most + 1) {
            self.call();
        }
    }

    fn named(&mut self, name: &str) {
        if let Some(command) = self.vocabulary.registry.commands.get(name) {
            let line = self.caller.call(command);
            self.line(line);
        }
    }

    /// Writes Begin and End. No forbidden command follows elements and lists, because Cupola does
    /// not refuse all of them. In a display list there are vertices only: Mesa 22.3 loses
    /// attributes that no vertex follows.
    fn primitive(&mut self) {
        const VERTICES: [&str; 3] = ["glVertex2f", "glVertex3fv", "glVertex4d"];
        const COMMANDS: [&str; 9] = [
            "glVertex2f",
            "glVertex3fv",
            "glColor4f",
            "glNormal3f",
            "glTexCoord2f",
            "glMaterialfv",
            "glVertex4d",
            "glVertexAttrib4f",
            "glEdgeFlag",
        ];
        let has_lists = self.caller.one_in(4);
        self.named("glBegin");
        for _ in 0..self.caller.random.below(10) {
            if self.list.is_some() {
                let name = self.caller.pick(&VERTICES);
                self.named(name);
            } else if !self.caller.one_in(6) {
                let name = self.caller.pick(&COMMANDS);
                self.named(name);
            } else if !has_lists {
                self.in_primitive = true;
                self.call();
                self.in_primitive = false;
            } else if self.caller.one_in(2) {
                self.line(format!("v glCallList %l{LIST_OF_VERTICES}"));
            } else {
                self.named("glArrayElement");
            }
        }
        self.line("v glEnd");
    }

    fn list(&mut self) {
        let slot = self.caller.random.below(SLOTS);
        self.line(format!("v glNewList %l{slot} 0x1300"));
        self.list = Some(slot);
        for _ in 0..self.caller.random.below(20) {
            if slot == LIST_OF_VERTICES {
                self.named("glVertex3fv");
            } else {
                self.step();
            }
        }
        self.list = None;
        self.line("v glEndList");
        if self.caller.one_in(2) {
            self.line(format!("v glCallList %l{slot}"));
        }
    }

    fn program(&mut self, slot: usize) {
        let which = if self.is_es() { 3 } else { self.caller.random.below(3) };
        self.line(format!("n=p{slot} glCreateProgram"));
        let mut parts = vec![(0x8B31, sources::VERTEX[which]), (0x8B30, sources::FRAGMENT[which])];
        if self.caller.one_in(4) {
            parts.push((self.caller.pick(&[0x8DD9, 0x91B9, 0x8B30]), self.caller.pick(&sources::OTHERS)));
        }
        for (kind, source) in parts {
            let shader = self.caller.random.below(SLOTS);
            self.line(format!("n=s{shader} glCreateShader {kind:#x}"));
            self.line(format!("v glShaderSource %s{shader} 1 *{} 0", sources::line(source)));
            self.line(format!("v glCompileShader %s{shader}"));
            self.line(format!("v glAttachShader %p{slot} %s{shader}"));
            if self.caller.one_in(2) {
                self.line(format!("v glDeleteShader %s{shader}"));
            }
        }
        self.line(format!("v glLinkProgram %p{slot}"));
        if self.caller.one_in(2) {
            self.line(format!("v glUseProgram %p{slot}"));
        }
    }

    fn arrays(&mut self) {
        let buffer = self.caller.random.below(SLOTS);
        if self.caller.one_in(2) {
            self.named("glBindVertexArray");
        }
        self.line(format!("v glBindBuffer 0x8892 %b{buffer}"));
        self.line("v glBufferData 0x8892 1024 ~0 0x88e4");
        match self.caller.random.below(3) {
            0 if !self.is_es() => {
                self.line("v glVertexPointer 2 0x1406 8 @a0");
                self.line("v glEnableClientState 0x8074");
            }
            1 => {
                self.line("v glVertexAttribPointer 0 4 0x1406 0 16 @a0");
                self.line("v glEnableVertexAttribArray 0");
            }
            _ => {
                self.line("v glVertexAttribFormat 0 4 0x1406 0 0");
                self.line(format!("v glBindVertexBuffer 0 %b{buffer} 0 16"));
                self.line("v glEnableVertexAttribArray 0");
            }
        }
        self.calls(4);
        let name = self.caller.pick(&[
            "glDrawArrays",
            "glDrawElements",
            "glDrawArraysInstanced",
            "glDrawRangeElements",
            "glMultiDrawArrays",
        ]);
        self.named(name);
    }

    fn framebuffer(&mut self) {
        let (framebuffer, texture) = (self.caller.random.below(SLOTS), self.caller.random.below(SLOTS));
        self.line(format!("v glBindTexture 0xde1 %t{texture}"));
        self.line("v glTexImage2D 0xde1 0 0x8058 16 16 0 0x1908 0x1401 @u0");
        self.line(format!("v glBindFramebuffer 0x8d40 %f{framebuffer}"));
        self.line(format!("v glFramebufferTexture2D 0x8d40 0x8ce0 0xde1 %t{texture} 0"));
        self.calls(6);
        if self.caller.one_in(2) {
            self.line("v glBindFramebuffer 0x8d40 0");
        }
    }

    fn query(&mut self) {
        let query = self.caller.random.below(SLOTS);
        let target = self.caller.pick(&[0x8914, 0x8C2F, 0x8C87, 0x8C88]);
        self.line(format!("v glBeginQuery {target:#x} %q{query}"));
        self.calls(6);
        self.line(format!("v glEndQuery {target:#x}"));
    }

    /// Writes draws to the window.
    fn window(&mut self) {
        self.line("v glBindFramebuffer 0x8d40 0");
        match self.caller.random.below(3) {
            0 => self.named("glClear"),
            1 if !self.is_es() => self.named("glRectf"),
            _ => self.line("v glReadPixels 0 0 8 8 0x1908 0x1401 @p0"),
        }
    }
}
