//! The order of the rooms inside the large folders, and the uses against it.
//!
//! A file may use the rooms below its own in the list. `tests/architecture.rs` uses this file too.

use super::uses::Uses;

/// A folder whose rooms have an order.
pub struct Order {
    /// The folder.
    pub folder: &'static str,
    /// Rooms of the folder, from the top to the ground.
    pub rooms: &'static [&'static str],
    /// Number of uses that still run from a lower room to a higher one.
    pub most_against: usize,
    /// Number of files of the largest remaining circle of uses.
    pub largest_circle: usize,
}

/// Folders with an order inside.
pub const ORDERS: [Order; 5] = [
    Order {
        folder: "src/intercept",
        rooms: &["gl", "vk", "inspection", "scene", "process"],
        most_against: 0,
        largest_circle: 3,
    },
    Order {
        folder: "src/intercept/gl",
        rooms: &[
            "entry",
            "frame",
            "compat",
            "app_state",
            "draw",
            "framebuffer",
            "offscreen",
            "per_view",
            "projected_vertices",
            "shader",
            "queries",
            "vertex_input",
            "context",
            "state",
        ],
        most_against: 0,
        largest_circle: 3,
    },
    Order {
        folder: "src/intercept/vk",
        rooms: &[
            "layer",
            "submit",
            "queries",
            "commands",
            "descriptors",
            "swapchain",
            "offscreen",
            "pipelines",
            "projected_vertices",
            "state",
            "spirv",
        ],
        most_against: 0,
        largest_circle: 0,
    },
    Order {
        folder: "src/correct",
        rooms: &["rough", "shaders", "plan", "sources", "passes", "projected"],
        most_against: 0,
        largest_circle: 0,
    },
    Order {
        folder: "src/views",
        rooms: &["reporting", "placing", "arranging", "fitting", "sampling"],
        most_against: 0,
        largest_circle: 0,
    },
];

/// The uses inside `order.folder` that run from a lower room to a higher one, as `file → file`.
pub fn against_the_order(uses: &Uses, order: &Order) -> Vec<String> {
    let room = |path: &str| {
        let inner = path.strip_prefix(order.folder)?.trim_start_matches('/');
        order.rooms.iter().position(|room| inner.split('/').next() == Some(room))
    };
    let mut found = Vec::new();
    for (file, targets) in uses.files.iter().zip(&uses.of) {
        for target in targets.iter().map(|target| &uses.files[*target]) {
            if let (Some(own), Some(other)) = (room(file), room(target))
                && other < own
            {
                found.push(format!("{file} → {target}"));
            }
        }
    }
    found
}

/// Rooms of a folder that are not in the order's list.
pub fn unlisted(uses: &Uses, order: &Order) -> Vec<String> {
    let rooms = uses.files.iter().filter_map(|file| {
        let (room, _) = file.strip_prefix(order.folder)?.trim_start_matches('/').split_once('/')?;
        (!order.rooms.contains(&room) && room != "tests").then(|| room.to_owned())
    });
    rooms.collect::<std::collections::BTreeSet<_>>().into_iter().collect()
}
