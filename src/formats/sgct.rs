//! Configurations of SGCT (JSON): the computers of a cluster, their windows, and the contents of
//! the viewports.
//!
//! The geometry and the names of other files are read. SGCT's settings for synchronisation, buffers
//! and tracking are not. Its axes are those of Cupola: x right, y up, z backward; yaw to the right,
//! pitch up, roll clockwise.
//!
//! A window with `mirrorx` or `mirrory` is drawn without mirroring, as one picture. Then each
//! viewport's mesh, or its rectangle, is drawn at its usual place, but samples the mirrored place
//! *of the window*; each mask samples the mirrored place of its viewport. So a viewport shows the
//! picture of the viewport at its mirrored place (itself, if it is the only one). In a mesh only
//! the sampled places change.

mod key;
mod projection;
mod unread;
mod viewports;

use crate::error::Result;
use crate::formats::reading::input::{LONGEST_DOCUMENT, Noted, invalid};
use glam::DVec3;
use key::Key;
use serde_json::Value;
use viewports::{mirrored_viewports, viewports_of};

pub use projection::{Projection, mirror_faces};
pub use viewports::{Eye, Viewport};

/// Greatest number of computers, of a computer's windows, and of a computer's viewports: the same
/// as the outputs of a rig.
const MOST: usize = 64;

/// Explains why a configuration has no viewports.
fn no_viewports(root: &Key) -> String {
    let windows = |node: &Value| node.get("windows").and_then(Value::as_array).cloned().unwrap_or_default();
    let nodes = root.value.get("nodes").and_then(Value::as_array);
    let mut windows = nodes.into_iter().flatten().flat_map(windows);
    match windows.find_map(|window| window.get("mpcdi").and_then(Value::as_str).map(str::to_owned)) {
        Some(file) => format!("takes its viewports from the archive {file}; convert that file itself"),
        None => "has no viewports; expected nodes[].windows[].viewports[]".to_owned(),
    }
}

/// A configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Position of the eye point, metres.
    pub viewer: DVec3,
    /// Computers with their viewports.
    pub nodes: Vec<Node>,
}

/// A computer.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Address of the computer.
    pub address: String,
    /// Viewports, window by window.
    pub viewports: Vec<Viewport>,
}

/// Reads a configuration. `name` is the file's, for messages.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) with the key and the reason.
pub fn read(name: &str, bytes: &[u8]) -> Result<Noted<Config>> {
    if bytes.len() > LONGEST_DOCUMENT {
        return Err(invalid(name, format!("is longer than {LONGEST_DOCUMENT} bytes, the limit for configurations")));
    }
    let root: Value =
        serde_json::from_slice(bytes).map_err(|error| invalid(name, format!("this is no JSON: {error}")))?;
    let root = Key { name, path: String::new(), value: &root };
    let mut notes = Vec::new();
    let users = root.list("users")?;
    if users.len() > 1 {
        notes.push(format!("{name}: only the first of {} users is taken", users.len()));
    }
    let viewer = match users.first().map(|user| user.optional("pos")) {
        Some(Some(position)) => position.vector()?,
        _ => DVec3::ZERO,
    };
    let mut nodes = Vec::new();
    let mut pixels = 0;
    for node in root.list("nodes")? {
        let address = node.optional("address").map(|address| address.text()).transpose()?.unwrap_or_default();
        let mut viewports = Vec::new();
        for window in node.list("windows")? {
            let of_window = viewports_of(&window, viewer, viewports.len(), &mut pixels, &mut notes)?;
            let flag = |name| window.optional(name).map_or(Ok(false), |flag| flag.truth());
            match [flag("mirrorx")?, flag("mirrory")?] {
                [false, false] => viewports.extend(of_window.into_iter().map(|(_, viewport)| viewport)),
                mirrored => viewports.extend(mirrored_viewports(&window, &of_window, mirrored, &mut notes)),
            }
        }
        nodes.push(Node { address, viewports });
    }
    if nodes.iter().all(|node| node.viewports.is_empty()) {
        return Err(match notes.is_empty() {
            true => invalid(name, no_viewports(&root)),
            false => invalid(name, format!("nothing of it can be shown: {}", notes.join("; "))),
        });
    }
    notes.extend(unread::line(root.value).map(|line| format!("{name}: {line}")));
    Ok(Noted { value: Config { viewer, nodes }, notes })
}

#[cfg(test)]
mod tests;
