//! Monitors, as `xrandr` lists them.

use crate::canvas::{Canvas, Letters};
use crate::window::presenter::{Filled, Presenter};
use cupola::rig::WindowSwaps;
use serde_json::json;
use std::path::Path;
use std::process::{Command, Stdio};

/// Width and height of the window with a monitor's name, pixels.
const NAME: (u32, u32) = (400, 120);

/// A monitor with a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Monitor {
    /// Name of the connector, such as `DP-1`.
    pub name: String,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Position of the upper left corner on the desktop, pixels.
    pub corner: (i64, i64),
    /// True if the desktop has its panel there.
    pub primary: bool,
}

/// Monitors in the order of `xrandr`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Monitors(pub Vec<Monitor>);

impl Monitors {
    /// No monitors, for machines without a display.
    pub fn none() -> Self {
        Self(Vec::new())
    }

    /// Finds the monitors of this display, or those in a file with the output of `xrandr --query`.
    /// The error says why there are none.
    pub fn find(file: Option<&Path>) -> Result<Self, String> {
        let listed = match file {
            Some(file) => std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?,
            None => ask()?,
        };
        let found = listed.lines().filter_map(monitor).collect::<Vec<_>>();
        if found.is_empty() { Err("xrandr lists no connected monitor".to_owned()) } else { Ok(Self(found)) }
    }

    /// Rectangle of each monitor in a window that spans all of them: `[x, y, width, height]`.
    /// `None` if two of them show the same part of the desktop.
    pub fn windows(&self) -> Option<Vec<[i64; 4]>> {
        let left = self.0.iter().map(|monitor| monitor.corner.0).min()?;
        let top = self.0.iter().map(|monitor| monitor.corner.1).min()?;
        let windows: Vec<[i64; 4]> = self.0.iter().map(|monitor| monitor.window((left, top))).collect();
        let apart = |a: &[i64; 4], b: &[i64; 4]| (0..2).any(|i| a[i] + a[i + 2] <= b[i] || b[i] + b[i + 2] <= a[i]);
        let all_apart = windows.iter().enumerate().all(|(i, a)| windows[..i].iter().all(|b| apart(a, b)));
        all_apart.then_some(windows)
    }

    /// Shows on each monitor its name in the middle, as long as the result lives. Names that cannot
    /// be shown are left out: they are only a help.
    pub fn show_names(&self) -> Vec<Presenter> {
        let shown = |monitor: &Monitor| {
            let middle = |axis: usize| {
                let (corner, size) = [(monitor.corner.0, monitor.size.0), (monitor.corner.1, monitor.size.1)][axis];
                i16::try_from(corner + (i64::from(size) - i64::from([NAME.0, NAME.1][axis])) / 2).ok()
            };
            let filled = Filled::Picture { x: middle(0)?, y: middle(1)? };
            let mut presenter = Presenter::open(None, &filled, WindowSwaps::default()).ok()?;
            let mut picture = Canvas::new(NAME.0 as usize, NAME.1 as usize, [0.1, 0.1, 0.2]);
            let centre = [f64::from(NAME.0) / 2.0, f64::from(NAME.1) / 2.0];
            picture.heading(&monitor.name, centre, Letters::Large, [1.0, 1.0, 1.0]);
            let rgba: Vec<u8> =
                picture.bytes().chunks(3).flat_map(|pixel| [pixel[0], pixel[1], pixel[2], 255]).collect();
            presenter.show(NAME, &rgba).ok()?;
            Some(presenter)
        };
        self.0.iter().filter_map(shown).collect()
    }

    /// Description as JSON.
    pub fn json(&self) -> serde_json::Value {
        let each = |monitor: &Monitor| {
            json!({
                "name": monitor.name,
                "size": [monitor.size.0, monitor.size.1],
                "corner": [monitor.corner.0, monitor.corner.1],
                "primary": monitor.primary,
            })
        };
        self.0.iter().map(each).collect()
    }
}

impl Monitor {
    fn window(&self, origin: (i64, i64)) -> [i64; 4] {
        [self.corner.0 - origin.0, self.corner.1 - origin.1, self.size.0.into(), self.size.1.into()]
    }

    /// Name, size and position in words.
    pub fn words(&self) -> String {
        let ((width, height), (x, y)) = (self.size, self.corner);
        let primary = if self.primary { ", the desktop's main monitor" } else { "" };
        format!("{}: {width} × {height} at {x}, {y}{primary}", self.name)
    }
}

fn ask() -> Result<String, String> {
    if std::env::var_os("DISPLAY").is_none() {
        return Err("there is no X display (DISPLAY is not set), so no monitors are known".to_owned());
    }
    let output = Command::new("xrandr").arg("--query").stdin(Stdio::null()).output();
    let output = output.map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => {
            "the monitors are not known: xrandr is not installed (Debian and Ubuntu: package x11-xserver-utils)".into()
        }
        _ => format!("the monitors are not known: xrandr cannot be started: {error}"),
    })?;
    if !output.status.success() {
        let words = String::from_utf8_lossy(&output.stderr);
        return Err(format!("the monitors are not known: xrandr: {}", words.trim()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Reads a line such as `DP-1 connected primary 1920x1080+0+0 (normal …`. Monitors that are
/// switched off have no geometry.
fn monitor(line: &str) -> Option<Monitor> {
    let (name, rest) = line.split_once(" connected ")?;
    let (primary, rest) = rest.strip_prefix("primary ").map_or((false, rest), |rest| (true, rest));
    let geometry = rest.split_whitespace().next()?;
    let signs = |c: char| c == '+' || c == '-';
    let (size, corner) = geometry.split_at(geometry.find(signs)?);
    let (width, height) = size.split_once('x')?;
    let second = corner[1..].find(signs)? + 1;
    let (x, y) = corner.split_at(second);
    let number = |text: &str| text.strip_prefix('+').unwrap_or(text).parse::<i64>().ok();
    Some(Monitor {
        name: name.to_owned(),
        size: (width.parse().ok()?, height.parse().ok()?),
        corner: (number(x)?, number(y)?),
        primary,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LISTED: &str = "\
Screen 0: minimum 320 x 200, current 5760 x 1200, maximum 16384 x 16384
eDP-1 connected primary 1920x1080+0+0 (normal left inverted right x axis y axis) 344mm x 193mm
   1920x1080     60.02*+  59.97
DP-1 connected 1920x1200+1920+0 (normal left inverted right x axis y axis) 518mm x 324mm
DP-2 connected (normal left inverted right x axis y axis)
DP-3 disconnected (normal left inverted right x axis y axis)
HDMI-1 connected 1920x1200+3840+-10 left (normal left) 0mm x 0mm
";

    #[test]
    fn lists_of_xrandr_are_read() {
        let found: Vec<_> = LISTED.lines().filter_map(monitor).collect();
        let names: Vec<_> = found.iter().map(|monitor| (monitor.name.as_str(), monitor.primary)).collect();
        assert_eq!(names, [("eDP-1", true), ("DP-1", false), ("HDMI-1", false)]);
        assert_eq!((found[2].size, found[2].corner), ((1920, 1200), (3840, -10)));
    }

    #[test]
    fn windows_begin_at_the_upper_left_monitor() {
        let mut monitors = Monitors(LISTED.lines().filter_map(monitor).skip(1).collect());
        assert_eq!(monitors.windows(), Some(vec![[0, 10, 1920, 1200], [1920, 0, 1920, 1200]]));
        monitors.0[1].corner = (1930, 0);
        assert_eq!(monitors.windows(), None, "mirrored monitors have no places of their own");
        assert_eq!(Monitors::none().windows(), None);
    }
}
