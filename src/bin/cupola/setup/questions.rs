//! Questions on a terminal, for values that the options leave open.

use super::monitors::{Monitor, Monitors};
use super::options::Arguments;
use super::places::{Place, Room, field_of_throw};
use super::text::{Kind, Output};
use crate::failure::Failure;
use std::io::{BufRead, Write};

/// Size of an output without a known monitor or size.
const USUAL_SIZE: (u32, u32) = (1920, 1080);

/// A user to ask, or none.
pub struct Questions<'a> {
    user: Option<(Box<dyn BufRead + 'a>, Box<dyn Write + 'a>)>,
    /// True if a question was asked.
    has_asked: bool,
}

impl<'a> Questions<'a> {
    /// Asks a user who reads `output` and types into `input`.
    pub fn of(input: impl BufRead + 'a, output: impl Write + 'a) -> Self {
        Self { user: Some((Box::new(input), Box::new(output))), has_asked: false }
    }

    /// Asks nobody: values without a default have to be options.
    pub fn none() -> Self {
        Self { user: None, has_asked: false }
    }

    /// Monitors of the projectors.
    pub fn monitors(&mut self, arguments: &Arguments, found: &Monitors) -> Result<Monitors, Failure> {
        let chosen = |names: &[String]| -> Result<Vec<Monitor>, String> {
            let named = |name: &String| {
                let listed = || found.0.iter().map(|monitor| monitor.name.as_str()).collect::<Vec<_>>().join(", ");
                found.0.iter().find(|monitor| monitor.name == *name).cloned().ok_or_else(|| {
                    format!(
                        "there is no monitor {name:?}; {}",
                        if found.0.is_empty() { "none is known".to_owned() } else { listed() }
                    )
                })
            };
            names.iter().map(named).collect()
        };
        if !arguments.monitors.is_empty() {
            let monitors = chosen(&arguments.monitors).map_err(|why| Failure::usage(format!("--monitors: {why}")))?;
            return Ok(Monitors(monitors));
        }
        if found.0.len() < 2 {
            return Ok(found.clone());
        }
        for monitor in &found.0 {
            self.tell(&monitor.words())?;
        }
        let all = found.0.iter().map(|monitor| monitor.name.clone()).collect::<Vec<_>>().join(",");
        let answer = self.ask("Monitors of the projectors, separated by commas", Some(&all), |text| {
            chosen(&text.split(',').map(|name| name.trim().to_owned()).collect::<Vec<_>>())
        })?;
        Ok(answer.map_or_else(|| found.clone(), Monitors))
    }

    /// Dome and audience.
    pub fn room(&mut self, arguments: &Arguments) -> Result<Room, Failure> {
        let diameter = match arguments.diameter {
            Some(given) => given,
            None => self
                .ask("Diameter of the dome in metres", None, number(0.2, 200.0))?
                .ok_or_else(|| missing("--diameter METRES"))?,
        };
        let mut angle = |given: Option<f64>, question, default: &str, range: (f64, f64)| match given {
            Some(given) => Ok(given),
            None => {
                let answer = self.ask(question, Some(default), number(range.0, range.1))?;
                Ok::<f64, Failure>(answer.unwrap_or_else(|| default.parse().unwrap_or_default()))
            }
        };
        let tilt = angle(
            arguments.tilt,
            "Tilt of the dome to the front in degrees (90: pole straight ahead)",
            "0",
            (-180.0, 180.0),
        )?;
        let coverage = angle(arguments.coverage, "Opening angle of the dome in degrees", "180", (1.0, 360.0))?;
        Ok(Room { radius: diameter / 2.0, tilt, coverage, seat: arguments.seat.unwrap_or_default() })
    }

    /// Outputs, on their monitors.
    pub fn outputs(
        &mut self,
        arguments: &Arguments,
        room: &Room,
        monitors: &Monitors,
        notes: &mut Vec<String>,
    ) -> Result<Vec<Output>, Failure> {
        let mut kinds = Vec::new();
        let count = self.count(arguments, monitors)?;
        for index in 0..count {
            let given = arguments.places.get(index).cloned();
            let place = match given {
                Some(place) => place,
                None => self.place(index, count, room)?,
            };
            let place = place.completed(index, count, room);
            let pose = place.pose(room).ok_or_else(|| {
                Failure::usage(format!("projector {}: it stands at the place that it aims at", index + 1))
            })?;
            kinds.push((place.size, Kind::Projector(place, pose)));
        }
        if kinds.is_empty() {
            kinds.push((None, Kind::Fisheye));
        }
        Ok(on_monitors(kinds, monitors, notes))
    }

    /// Number of projectors; 0 for a fisheye lens.
    fn count(&mut self, arguments: &Arguments, monitors: &Monitors) -> Result<usize, Failure> {
        if arguments.fisheye {
            return Ok(0);
        }
        if let Some(count) = arguments.projectors {
            return Ok(count.into());
        }
        if !arguments.places.is_empty() {
            return Ok(arguments.places.len());
        }
        let default = monitors.0.len().max(1).to_string();
        let answer =
            self.ask("Number of projectors (0: one fisheye lens in the dome's centre)", Some(&default), |text| {
                text.parse::<usize>().ok().filter(|count| *count <= 64).ok_or_else(|| "expected 0 to 64".to_owned())
            })?;
        answer.ok_or_else(|| missing("--fisheye, --projectors N or --projector PLACE"))
    }

    /// Description of one projector.
    fn place(&mut self, index: usize, count: usize, room: &Room) -> Result<Place, Failure> {
        let usual = Place::default().completed(index, count, room);
        self.tell(&format!("Projector {} of {count}:", index + 1))?;
        let mut ask = |question, default: Option<f64>, least, most| {
            let default = default.map(|number| format!("{number}"));
            self.ask(question, default.as_deref(), number(least, most))
        };
        let azimuth =
            ask("  it stands at the azimuth, degrees (0: front, 90: right, 180: back)", usual.azimuth, -360.0, 360.0)?;
        let distance = ask("  its horizontal distance from the dome's centre, metres", usual.distance, 0.0, 1000.0)?;
        let height = ask("  height of its lens above the dome's centre, metres", usual.height, -1000.0, 1000.0)?;
        let throw = ask("  its throw ratio (distance over width of a flat picture)", Some(0.6), 0.05, 50.0)?;
        Ok(Place { azimuth, distance, height, fov: throw.map(field_of_throw), ..Place::default() })
    }

    /// Asks a user who has answered other questions whether the patterns of the new rig, which is
    /// written already, are shown.
    pub fn shows_patterns(&mut self) -> bool {
        if !self.has_asked {
            return false;
        }
        let question = "Show the patterns with the projectors' numbers now? A key closes them (yes, no)";
        let answer = self.ask(question, Some("yes"), |text| match text {
            "yes" | "y" => Ok(true),
            "no" | "n" => Ok(false),
            _ => Err("expected yes or no".to_owned()),
        });
        // A user who has gone wants no patterns.
        matches!(answer, Ok(Some(true)))
    }

    /// Prints a message, if there is a user.
    fn tell(&mut self, words: &str) -> Result<(), Failure> {
        match &mut self.user {
            Some((_, output)) => writeln!(output, "{words}").map_err(|error| gone(&error.to_string())),
            None => Ok(()),
        }
    }

    /// Asks until the answer can be read. `None` if there is no user.
    fn ask<T>(
        &mut self,
        question: &str,
        default: Option<&str>,
        read: impl Fn(&str) -> Result<T, String>,
    ) -> Result<Option<T>, Failure> {
        let Some((input, output)) = &mut self.user else { return Ok(None) };
        self.has_asked = true;
        loop {
            let offered = default.map_or(String::new(), |default| format!(" [{default}]"));
            write!(output, "{question}{offered}: ").and_then(|()| output.flush()).map_err(|e| gone(&e.to_string()))?;
            let mut line = String::new();
            if input.read_line(&mut line).map_err(|error| gone(&error.to_string()))? == 0 {
                return Err(gone("the input ended"));
            }
            let answer = match line.trim() {
                "" => default.unwrap_or_default(),
                text => text,
            };
            match read(answer) {
                Ok(value) => return Ok(Some(value)),
                Err(why) => writeln!(output, "  {why}").map_err(|error| gone(&error.to_string()))?,
            }
        }
    }
}

fn gone(why: &str) -> Failure {
    Failure::usage(format!("the questions were not answered: {why}; nothing was written"))
}

fn missing(option: &str) -> Failure {
    Failure::usage(format!("{option} is needed, because there is no terminal to ask on"))
}

/// Reads a number in a range.
fn number(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> {
    move |text| {
        let read = text.parse::<f64>().ok().filter(|number| (least..=most).contains(number));
        read.ok_or_else(|| {
            let hint = if text.contains(',') { "; the decimal sign is a point" } else { "" };
            format!("{text:?}: expected a number from {least} to {most}{hint}")
        })
    }
}

/// Gives each output the monitor of its number, if there are enough.
fn on_monitors(kinds: Vec<(Option<(u32, u32)>, Kind)>, monitors: &Monitors, notes: &mut Vec<String>) -> Vec<Output> {
    let enough = monitors.0.len() >= kinds.len();
    if !monitors.0.is_empty() && !enough {
        notes.push(format!(
            "there are {} monitors for {} outputs; the outputs share the program's window in a grid",
            monitors.0.len(),
            kinds.len()
        ));
    }
    let used = Monitors(monitors.0.iter().take(kinds.len()).cloned().collect());
    let windows = if enough { used.windows() } else { None };
    if enough && windows.is_none() && !used.0.is_empty() {
        notes
            .push("monitors show the same part of the desktop; place them side by side and run setup again".to_owned());
    }
    let output = |(index, (size, kind)): (usize, (Option<(u32, u32)>, Kind))| {
        let monitor = windows.as_ref().and(used.0.get(index));
        let usual = if matches!(kind, Kind::Fisheye) { None } else { Some(USUAL_SIZE) };
        Output {
            kind,
            size: size.or(monitor.map(|monitor| monitor.size)).or(usual),
            window: windows.as_ref().map(|windows| windows[index]),
            monitor: monitor.map(|monitor| monitor.name.clone()),
        }
    };
    kinds.into_iter().enumerate().map(output).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn arguments(line: &[&str]) -> Arguments {
        Line::parse_from(["setup", "dome.toml"].iter().chain(line)).arguments
    }

    fn two() -> Monitors {
        let monitor = |name: &str, x| Monitor { name: name.into(), size: (1920, 1200), corner: (x, 0), primary: false };
        Monitors(vec![monitor("DP-1", 0), monitor("DP-2", 1920)])
    }

    #[test]
    fn what_is_open_is_asked_until_it_can_be_read() {
        let (mut words, arguments, mut notes) = (Vec::new(), arguments(&["--tilt", "20"]), Vec::new());
        let typed = "DP-3\nDP-2,DP-1\n8,5\n8.5\n\n2\n\n\n\n0.5\n10\n3\n0.2\n\nmaybe\nno\n\n";
        let mut questions = Questions::of(typed.as_bytes(), &mut words);
        let monitors = questions.monitors(&arguments, &two()).unwrap();
        let room = questions.room(&arguments).unwrap();
        let outputs = questions.outputs(&arguments, &room, &monitors, &mut notes).unwrap();
        assert!(!questions.shows_patterns() && questions.shows_patterns());
        // The input has ended.
        assert!(!questions.shows_patterns());
        drop(questions);
        let words = String::from_utf8(words).unwrap();
        assert!(words.contains("no monitor \"DP-3\"; DP-1, DP-2") && words.contains("decimal sign"), "{words}");
        assert_eq!((room.radius, room.tilt, room.coverage), (4.25, 20.0, 180.0));
        assert_eq!(outputs[0].window, Some([1920, 0, 1920, 1200]));
        let Kind::Projector(place, _) = &outputs[0].kind else { panic!("a projector") };
        assert!((place.fov.unwrap() - 90.0).abs() < 1e-9 && place.azimuth == Some(180.0));
        let Kind::Projector(place, _) = &outputs[1].kind else { panic!("a projector") };
        assert_eq!((place.azimuth, place.distance, place.height), (Some(10.0), Some(3.0), Some(0.2)));
        assert!(notes.is_empty(), "{notes:?}");
    }

    #[test]
    fn nobody_is_asked_without_a_terminal() {
        let mut questions = Questions::none();
        let why = questions.room(&arguments(&[])).unwrap_err();
        assert!(why.message.contains("--diameter") && why.code == 2, "{why:?}");
        let given = arguments(&["--diameter", "8"]);
        let room = questions.room(&given).unwrap();
        let why = questions.outputs(&given, &room, &two(), &mut Vec::new()).err().expect("no outputs");
        assert!(why.message.contains("--projectors"), "{why:?}");
        let why = Questions::of("".as_bytes(), Vec::new()).room(&arguments(&[])).unwrap_err();
        assert!(why.message.contains("input ended"), "{why:?}");
    }

    #[test]
    fn outputs_without_monitors_share_the_window() {
        let mut notes = Vec::new();
        let given = arguments(&["--diameter", "8", "--projectors", "3"]);
        let mut questions = Questions::none();
        let room = questions.room(&given).unwrap();
        let outputs = questions.outputs(&given, &room, &two(), &mut notes).unwrap();
        assert!(!questions.shows_patterns());
        assert!(outputs.iter().all(|output| output.window.is_none() && output.size == Some(USUAL_SIZE)));
        assert!(notes[0].contains("2 monitors for 3 outputs"), "{notes:?}");
    }
}
