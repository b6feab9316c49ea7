//! `cupola-lab calls`: compares the answers to random OpenGL calls and Vulkan commands with and
//! without Cupola.

mod arguments;
mod compare;
mod episode;
mod minimise;
mod player;
mod questions;
mod registry;
mod rules;
mod sources;
mod vulkan;

use crate::display::Server;
use crate::environment::{self, Environment};
use crate::failure::Failure;
use compare::{Difference, Outcome, Pair};
use episode::{Kind, Vocabulary};
use player::Player;
use registry::Registry;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use vulkan::Validation;

/// Compare the answers of OpenGL and Vulkan to random calls with and without Cupola
///
/// Legal and illegal calls of all entry points of OpenGL go to two contexts in the same order. The
/// errors and answers of each call are compared, and all state that can be queried. With --vulkan
/// legal commands go to two devices, and the contents of images, buffers and the window are
/// compared. The exit code is 1 if an answer differs.
#[derive(clap::Args)]
pub struct Arguments {
    /// Program that plays calls (tests/apps/player.c, tests/apps/vulkan/player.c)
    #[arg(long, value_name = "FILE")]
    player: PathBuf,
    /// Rig to compare with
    #[arg(long, value_name = "FILE|PRESET", default_value = "identity-captured")]
    rig: String,
    /// Seed of the first episode; the seeds of the following ones are the following numbers
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Number of episodes, each in a context of its own
    #[arg(long, value_name = "N", default_value_t = 20)]
    episodes: u64,
    /// Number of calls of an episode
    #[arg(long, value_name = "N", default_value_t = 1000)]
    calls: usize,
    /// Kinds of contexts, taken in turn [default: compatibility,core,compatibility,es3]
    #[arg(long, value_delimiter = ',', value_name = "KIND")]
    kinds: Vec<Kind>,
    /// Play commands of Vulkan
    #[arg(long, conflicts_with = "kinds")]
    vulkan: bool,
    /// Leave out commands that make a program flat on Vulkan: the frame in which Cupola notices
    /// them differs
    #[arg(long, requires = "vulkan")]
    followed: bool,
    /// Place of Vulkan's validation layer, whose messages are compared
    #[arg(long, value_name = "PLACE", default_value = "below", requires = "vulkan")]
    validation: Validation,
    /// Play these files instead of random calls
    #[arg(long, value_name = "FILE", num_args = 1..)]
    replay: Vec<PathBuf>,
    /// Folder for files of calls
    #[arg(long, value_name = "DIR", default_value = "out/calls")]
    folder: PathBuf,
    /// Do not let Mesa draw anything: more calls per second, but results of queries and feedback mean
    /// nothing
    #[arg(long, conflicts_with = "vulkan")]
    no_drawing: bool,
    /// Set an environment variable for the player with Cupola
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Play the files once for each of these variables, set in a new player with Cupola, and name
    /// those with which an answer differs
    #[arg(long, value_name = "NAME=VALUE", requires = "replay")]
    in_turn: Vec<String>,
    /// Do not look for the shortest list of calls
    #[arg(long)]
    keep: bool,
}

/// Number of trials for the shortest list.
const TRIALS: usize = 1500;

/// Number of lines that an episode may lose.
const MOST_LINES_LEFT_OUT: usize = 12;

/// Number of questions that may crash the driver.
const CRASHES: usize = 100;

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let failure = |path: &Path, error: std::io::Error| Failure::usage(format!("{}: {error}", path.display()));
    std::fs::create_dir_all(&arguments.folder).map_err(|error| failure(&arguments.folder, error))?;
    let folder = arguments.folder.canonicalize().map_err(|error| failure(&arguments.folder, error))?;
    // Each player has its own server, so that their windows lie in the same place.
    let [server, second] = [Server::start((640, 480), &folder)?, Server::start((640, 480), &folder)?];
    let registry = Registry::read()?;
    let questions = folder.join("questions.txt");
    let program = arguments.player.canonicalize().map_err(|error| failure(&arguments.player, error))?;
    let mut ours = environment::of_rig(&arguments.rig, &folder)?;
    let mut plain = Environment::new();
    if arguments.vulkan {
        plain = arguments.validation.plain();
        ours.extend(arguments.validation.with_cupola(&ours));
    }
    if arguments.no_drawing {
        let variable = ("GALLIUM_NOOP".to_owned(), Some("true".to_owned()));
        plain.push(variable.clone());
        ours.push(variable);
    }
    for variable in &arguments.set {
        ours.push(setting("--set", variable)?);
    }
    let mut pair = Pair {
        plain: Player::new(&program, &questions, &server, &plain),
        ours: Player::new(&program, &questions, &second, &ours),
        file: folder.join("calls.txt"),
    };
    let default = [Kind::Compatibility, Kind::Core, Kind::Compatibility, Kind::Es3];
    let kinds = match &arguments.kinds[..] {
        _ if arguments.vulkan => &[],
        [] => &default[..],
        kinds => kinds,
    };
    let vocabularies: Vec<Vocabulary> = kinds.iter().map(|kind| Vocabulary::new(&registry, *kind)).collect();
    if !arguments.vulkan {
        find_questions(&registry, &vocabularies, kinds, &questions, &mut pair)?;
    }
    let mut report = Report { folder, ..Report::default() };
    if !arguments.in_turn.is_empty() {
        let player = |ours: &Environment| Player::new(&program, &questions, &second, ours);
        return replay_in_turn(arguments, &report.folder, &mut pair, &ours, player);
    }
    report.replay(&mut pair, arguments)?;
    let episodes = if arguments.replay.is_empty() { arguments.episodes } else { 0 };
    for seed in arguments.seed..arguments.seed + episodes {
        if arguments.vulkan {
            let lines = vulkan::lines(seed, arguments.calls, arguments.followed);
            report.play(&mut pair, &lines, &format!("seed {seed}, Vulkan"), arguments.keep)?;
            continue;
        }
        let index = (seed % kinds.len() as u64) as usize;
        let (kind, vocabulary) = (kinds[index], &vocabularies[index]);
        let mut lines = episode::lines(vocabulary, seed, kind, arguments.calls);
        lines.retain(|line| !rules::crashes_mesa(line, !arguments.no_drawing));
        report.play(&mut pair, &lines, &format!("seed {seed}, {}", kind.word()), arguments.keep)?;
    }
    for (kind, vocabulary) in kinds.iter().zip(&vocabularies) {
        println!("{}: {} commands", kind.word(), vocabulary.len());
    }
    Ok(report.print())
}

/// Replays the lists with each variable of `--in-turn`, one at a time.
fn replay_in_turn(
    arguments: &Arguments,
    folder: &Path,
    pair: &mut Pair,
    ours: &Environment,
    player: impl Fn(&Environment) -> Player,
) -> Result<ExitCode, Failure> {
    let mut differs = false;
    for variable in &arguments.in_turn {
        let mut ours = ours.clone();
        ours.push(setting("--in-turn", variable)?);
        pair.ours = player(&ours);
        let mut report = Report { folder: folder.to_owned(), ..Report::default() };
        report.replay(pair, arguments)?;
        if !report.differences.is_empty() {
            println!("different with {variable}");
            differs = true;
        }
    }
    Ok(if differs { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Environment variable of an option.
fn setting(option: &str, variable: &str) -> Result<(String, Option<String>), Failure> {
    let (name, value) =
        variable.split_once('=').ok_or_else(|| Failure::usage(format!("{option} {variable}: no value")))?;
    Ok((name.to_owned(), Some(value.to_owned())))
}

/// Writes the questions that OpenGL answers in one of the kinds of contexts.
fn find_questions(
    registry: &Registry,
    vocabularies: &[Vocabulary],
    kinds: &[Kind],
    questions: &Path,
    pair: &mut Pair,
) -> Result<(), Failure> {
    let failure = |error: std::io::Error| Failure::new(format!("{}: {error}", questions.display()));
    std::fs::write(questions, "").map_err(failure)?;
    let candidates = questions::candidates(registry);
    let mut answered = vec![false; candidates.len()];
    for (index, kind) in kinds.iter().enumerate() {
        if kinds[..index].contains(kind) {
            continue;
        }
        let mut lines = episode::lines(&vocabularies[index], 0, *kind, 0);
        lines.pop();
        let first = lines.len();
        lines.extend_from_slice(&candidates);
        let mut answers = pair.play_plain(&lines)?;
        for _ in 0..CRASHES {
            // Some drivers crash instead of refusing.
            let Some(line) = answers.crash().filter(|line| *line > first) else { break };
            lines[line - 1] = "#".to_owned();
            answers = pair.play_plain(&lines)?;
        }
        if !answers.ended {
            return Err(Failure::new(format!("the questions end the player: {:?}", answers.lines.last())));
        }
        for answer in &answers.lines {
            let mut words = answer.split(' ');
            let line: usize = words.next().and_then(|word| word.parse().ok()).unwrap_or(0);
            if line > first && words.next() == Some("0") {
                answered[line - first - 1] = true;
            }
        }
    }
    let kept: Vec<&str> =
        candidates.iter().zip(&answered).filter(|(_, answered)| **answered).map(|(line, _)| line.as_str()).collect();
    println!("{} questions", kept.len());
    std::fs::write(questions, kept.join("\n") + "\n").map_err(failure)?;
    // It has read the empty file.
    pair.plain.stop();
    Ok(())
}

/// Results.
#[derive(Default)]
struct Report {
    folder: PathBuf,
    calls: usize,
    episodes: usize,
    /// Number of lines that were left out when episodes were played again.
    left_out: usize,
    /// Number of crashes of the driver without Cupola, by call.
    crashes: BTreeMap<String, usize>,
    /// Number of differences and first file, by kind.
    differences: BTreeMap<String, (usize, String)>,
    /// Number of answers that differ from run to run, usually also without Cupola.
    unsteady: BTreeMap<String, usize>,
}

impl Report {
    /// Plays the files of the option `--replay`.
    fn replay(&mut self, pair: &mut Pair, arguments: &Arguments) -> Result<(), Failure> {
        for file in &arguments.replay {
            let text = std::fs::read_to_string(file)
                .map_err(|error| Failure::usage(format!("{}: {error}", file.display())))?;
            let lines: Vec<String> = text.lines().map(str::to_owned).collect();
            self.play(pair, &lines, &file.display().to_string(), arguments.keep)?;
        }
        Ok(())
    }

    /// Plays an episode. After a crash of the driver it is played without that line. Calls that
    /// differ as earlier ones did are counted; if anything else differs after them, the episode is
    /// played without them.
    fn play(&mut self, pair: &mut Pair, lines: &[String], name: &str, keep: bool) -> Result<(), Failure> {
        self.episodes += 1;
        let mut lines = lines.to_vec();
        for _ in 0..MOST_LINES_LEFT_OUT {
            let (known, outcome) = pair.compare_knowing(&lines, |kind| self.differences.contains_key(kind))?;
            for difference in &known {
                if let Some((count, _)) = self.differences.get_mut(&difference.kind) {
                    *count += 1;
                }
            }
            if !known.is_empty() && !matches!(outcome, Outcome::Same) {
                for difference in known.iter().rev() {
                    lines.remove(difference.line - 1);
                }
                self.left_out += known.len();
                continue;
            }
            let played = match outcome {
                Outcome::Same => {
                    self.calls += lines.len();
                    return Ok(());
                }
                Outcome::Crashed(line) => {
                    let call = lines.get(line.wrapping_sub(1)).map_or("", String::as_str);
                    let count = self.crashes.entry(compare::command(call).to_owned()).or_default();
                    *count += 1;
                    if *count == 1 {
                        let file = self.folder.join(format!("crash-{}.calls", compare::command(call)));
                        let lines = lines[..line.min(lines.len())].join("\n");
                        std::fs::write(&file, format!("# {name}\n{lines}\n"))
                            .map_err(|error| Failure::new(format!("{}: {error}", file.display())))?;
                    }
                    line
                }
                Outcome::Different(difference) => {
                    self.found(pair, &lines, name, keep, &difference)?;
                    self.calls += difference.line;
                    return Ok(());
                }
            };
            if played < 2 || played > lines.len() {
                return Ok(());
            }
            // A list that is still being compiled would crash at its next end.
            let ends_list = lines[played - 1].ends_with(" glEndList");
            let begin = lines[..played].iter().rposition(|line| line.contains(" glNewList ")).filter(|_| ends_list);
            let first = begin.unwrap_or(played - 1);
            lines.drain(first..played);
            self.left_out += played - first;
        }
        Ok(())
    }

    fn found(
        &mut self,
        pair: &mut Pair,
        lines: &[String],
        name: &str,
        keep: bool,
        difference: &Difference,
    ) -> Result<(), Failure> {
        // Finds the question that differs.
        let mut lines: Vec<String> = lines.iter().take(difference.line).cloned().collect();
        if lines.last().is_some_and(|line| line == "ask") {
            lines.insert(lines.len() - 1, "each".to_owned());
        }
        // Some differences appear only in the first context of a process.
        let warm = pair.compare(&lines)?;
        let is_warm = matches!(warm, Outcome::Different(_));
        let again = if is_warm { warm } else { pair.compare_anew(&lines)? };
        let Outcome::Different(mut difference) = again else {
            self.keep(&format!("unsteady-{}", self.unsteady.len() + 1), name, difference, &lines)?;
            *self.unsteady.entry(format!("{}, with Cupola", difference.kind)).or_default() += 1;
            return Ok(());
        };
        let is_steady = |answers: &player::Answers| answers.lines.contains(&difference.plain);
        if !is_steady(&pair.play_plain(&lines)?) || !is_steady(&pair.play_plain(&lines)?) {
            self.keep(&format!("unsteady-{}", self.unsteady.len() + 1), name, &difference, &lines)?;
            *self.unsteady.entry(difference.kind).or_default() += 1;
            return Ok(());
        }
        if let Some((count, _)) = self.differences.get_mut(&difference.kind) {
            *count += 1;
            return Ok(());
        }
        if !keep {
            lines = minimise::minimise(&lines, TRIALS, |lines| {
                let outcome = if is_warm { pair.compare(lines)? } else { pair.compare_anew(lines)? };
                Ok::<_, Failure>(matches!(outcome, Outcome::Different(found) if found.kind == difference.kind))
            })?;
            if let Outcome::Different(found) = pair.compare_anew(&lines)? {
                difference = found;
            }
        }
        let (file, text) = self.keep(&(self.differences.len() + 1).to_string(), name, &difference, &lines)?;
        println!("{text}");
        self.differences.insert(difference.kind, (1, file.display().to_string()));
        Ok(())
    }

    /// Writes lines to a file. Returns its name, and the text.
    fn keep(
        &self,
        stem: &str,
        name: &str,
        difference: &Difference,
        lines: &[String],
    ) -> Result<(PathBuf, String), Failure> {
        let file = self.folder.join(format!("{stem}.calls"));
        let text = format!(
            "# {name}: {}\n#  without Cupola {}\n#  with Cupola    {}\n{}\n",
            difference.kind,
            difference.plain,
            difference.ours,
            lines.join("\n")
        );
        std::fs::write(&file, &text).map_err(|error| Failure::new(format!("{}: {error}", file.display())))?;
        Ok((file, text))
    }

    fn print(&self) -> ExitCode {
        println!("{} calls in {} episodes", self.calls, self.episodes);
        if self.left_out > 0 {
            println!("{} lines left out after crashes and known differences", self.left_out);
        }
        for (call, count) in &self.crashes {
            println!("without Cupola the driver crashed {count} times in {call}");
        }
        for (kind, count) in &self.unsteady {
            println!("not the same in each run, {count} times: {kind}");
        }
        for (kind, (count, file)) in &self.differences {
            println!("different {count} times: {kind} ({file})");
        }
        if self.differences.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}
