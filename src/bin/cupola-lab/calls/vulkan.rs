//! Episodes of Vulkan commands. The player skips forbidden commands, so that any list of lines may
//! be played, and any part of one.

use crate::environment::Environment;
use crate::random::Random;
use clap::ValueEnum;
use std::fmt::Write;

/// Position of Khronos' validation layer while commands are played with Cupola.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Validation {
    /// Between Cupola and the driver: it sees Cupola's calls.
    Below,
    /// Between the program and Cupola: it sees Cupola's answers.
    Above,
    /// Not loaded.
    Off,
}

const LAYER: &str = "VK_LAYER_KHRONOS_validation";
const OWN: &str = "VK_LAYER_CUPOLA_dome";
/// Folder with the description of the validation layer.
const DESCRIPTIONS: &str = "/usr/share/vulkan/explicit_layer.d";

fn set(name: &str, value: &str) -> (String, Option<String>) {
    (name.to_owned(), Some(value.to_owned()))
}

impl Validation {
    /// Variables of the player without Cupola.
    pub fn plain(self) -> Environment {
        if self == Self::Off { Environment::new() } else { vec![set("VK_INSTANCE_LAYERS", LAYER), synchronisation()] }
    }

    /// Variables of the player with Cupola, after those of the rig.
    pub fn with_cupola(self, rig: &Environment) -> Environment {
        let own = rig.iter().find(|(name, _)| name == "VK_ADD_LAYER_PATH").and_then(|(_, folder)| folder.clone());
        match self {
            Self::Off => Environment::new(),
            Self::Below => vec![set("VK_INSTANCE_LAYERS", &format!("{OWN}:{LAYER}")), synchronisation()],
            // The loader orders layers by the folders of their descriptions, not by this list.
            Self::Above => vec![
                set("VK_INSTANCE_LAYERS", &format!("{LAYER}:{OWN}")),
                set("VK_LAYER_PATH", &format!("{DESCRIPTIONS}:{}", own.unwrap_or_default())),
                ("VK_ADD_LAYER_PATH".to_owned(), None),
                synchronisation(),
            ],
        }
    }
}

/// Makes the layer check synchronisation, too.
fn synchronisation() -> (String, Option<String>) {
    set("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT")
}

/// A kind of line: its word, the number of numbers that follow, and its weight.
type Line = (&'static str, usize, usize);

/// Lines inside of a pass.
const IN_PASS: [Line; 11] = [
    ("draw", 3, 14),
    ("pipeline", 1, 10),
    ("push", 2, 8),
    ("set", 2, 6),
    ("indexed", 3, 5),
    ("indirect", 2, 4),
    ("viewport", 1, 3),
    ("vertices", 2, 3),
    ("scissor", 1, 2),
    ("clear-part", 3, 2),
    ("query", 1, 2),
];

/// Lines outside of passes.
const OUTSIDE: [Line; 20] = [
    ("write-set", 4, 6),
    ("copy", 3, 6),
    ("write-matrix", 3, 5),
    ("blit", 3, 5),
    ("ask", 1, 4),
    ("present", 0, 4),
    ("dispatch", 2, 3),
    ("clear", 3, 3),
    ("submit", 0, 3),
    ("again", 0, 3),
    ("resolve", 3, 2),
    ("to-buffer", 3, 2),
    ("from-buffer", 3, 2),
    ("buffers", 3, 2),
    ("update", 3, 2),
    ("image", 2, 1),
    ("ways", 1, 1),
    ("fill", 3, 1),
    ("levels", 1, 1),
    ("swapchain", 1, 1),
];

/// Number of the window among the images.
const WINDOW: usize = 8;

/// Number of objects that can be read: images, the window, buffers, queries.
const ASKED: usize = WINDOW + 3;

/// Limit of the numbers in a line; the player reduces them as it needs.
const NUMBERS: usize = 256;

/// Lines of an episode. `followed`: without commands that make a program flat.
pub fn lines(seed: u64, calls: usize, followed: bool) -> Vec<String> {
    let context = if followed { "context followed" } else { "context vulkan" };
    let mut writer = Writer { random: Random::new(seed), lines: vec![context.to_owned()] };
    while writer.lines.len() < calls {
        if writer.one_in(3) { writer.pass() } else { writer.any(&OUTSIDE) }
    }
    writer.lines.push("end".to_owned());
    writer.lines.extend((0..ASKED).map(|what| format!("ask {what}")));
    writer.lines
}

struct Writer {
    random: Random,
    lines: Vec<String>,
}

impl Writer {
    fn one_in(&mut self, count: usize) -> bool {
        self.random.below(count) == 0
    }

    fn line(&mut self, word: &str, numbers: usize) {
        let mut line = word.to_owned();
        for _ in 0..numbers {
            write!(line, " {}", self.random.below(NUMBERS)).expect("writing to a String");
        }
        self.lines.push(line);
    }

    fn any(&mut self, among: &[Line]) {
        let total = among.iter().map(|(_, _, weight)| weight).sum();
        let mut at = self.random.below(total);
        for (word, numbers, weight) in among {
            if at < *weight {
                return self.line(word, *numbers);
            }
            at -= weight;
        }
    }

    /// Writes a pass, usually to the window, which is often shown after it.
    fn pass(&mut self) {
        let target = if self.one_in(2) { WINDOW } else { self.random.below(WINDOW) };
        let others: Vec<String> = (0..5).map(|_| self.random.below(NUMBERS).to_string()).collect();
        self.lines.push(format!("pass {target} {}", others.join(" ")));
        self.line("pipeline", 1);
        for _ in 0..self.random.below(12) {
            self.any(&IN_PASS);
        }
        self.line("end", 0);
        if target == WINDOW && !self.one_in(3) {
            self.line("present", 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::lines;

    #[test]
    fn episodes_follow_from_their_seeds() {
        assert_eq!(lines(3, 200, true), lines(3, 200, true));
        assert_ne!(lines(3, 200, true), lines(4, 200, true));
        assert!(lines(3, 200, true).len() > 200);
    }
}
