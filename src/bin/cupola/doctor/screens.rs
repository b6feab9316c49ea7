//! Screens, monitors and graphics cards, and the ability to swap outputs together.

use crate::launch::Environment;
use crate::launch::probe::{self, Way};
use crate::window::wayland;
use cupola::backend::vk::driver::headless::Headless;
use std::path::Path;
use x11rb::connection::Connection;
use x11rb::protocol::randr::ConnectionExt as _;
use x11rb::protocol::xproto::{ConnectionExt as _, Screen};
use x11rb::rust_connection::RustConnection;

/// Returns a line for each X screen, with its monitors: the names for the keys `display` and
/// `monitor` of outputs.
pub fn screens(display: Option<&str>) -> Vec<String> {
    let Ok((connection, _)) = x11rb::connect(display) else { return Vec::new() };
    let name = display.map(str::to_owned).or_else(|| std::env::var("DISPLAY").ok()).unwrap_or_default();
    let server = name.rsplit_once('.').filter(|(server, _)| server.contains(':')).map_or(&*name, |(server, _)| server);
    let describe = |(number, screen): (usize, &Screen)| {
        let (width, height) = (screen.width_in_pixels, screen.height_in_pixels);
        let monitors = monitors(&connection, screen).unwrap_or_default();
        let monitors = if monitors.is_empty() { "no monitors".to_owned() } else { monitors.join(", ") };
        format!("{server}.{number}: {width}x{height} pixels of {} bits; {monitors}", screen.root_depth)
    };
    connection.setup().roots.iter().enumerate().map(describe).collect()
}

/// Returns a line for the Wayland compositor of the environment, with the names of its monitors.
pub fn compositor() -> Option<String> {
    let socket = std::env::var("WAYLAND_DISPLAY").ok().filter(|socket| !socket.is_empty())?;
    Some(match wayland::monitors(&socket) {
        Ok(monitors) if monitors.is_empty() => format!("{socket}: no monitors"),
        Ok(monitors) => format!("{socket}: {}", monitors.join(", ")),
        Err(failure) => failure.message,
    })
}

/// Names and positions of the monitors of a screen.
fn monitors(connection: &RustConnection, screen: &Screen) -> Option<Vec<String>> {
    let monitors = connection.randr_get_monitors(screen.root, true).ok()?.reply().ok()?.monitors;
    let describe = |monitor: &x11rb::protocol::randr::MonitorInfo| {
        let name = connection.get_atom_name(monitor.name).ok()?.reply().ok()?.name;
        let name = String::from_utf8_lossy(&name).into_owned();
        Some(format!("{name} {}x{}+{}+{}", monitor.width, monitor.height, monitor.x, monitor.y))
    };
    Some(monitors.iter().filter_map(describe).collect())
}

/// Returns a line for each graphics card with a kernel driver, from the kernel's folder of cards.
pub fn cards(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    let is_card = |name: &&String| {
        name.strip_prefix("card").is_some_and(|number| !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()))
    };
    let read = |path: &str| std::fs::read_to_string(folder.join(path)).map(|text| text.trim().to_owned());
    let describe = |card: &String| {
        let number = |file: &str| read(&format!("{card}/device/{file}")).unwrap_or_else(|_| "unknown".to_owned());
        let driver = std::fs::read_link(folder.join(format!("{card}/device/driver")));
        let driver = driver.ok().and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
        let is_connected = |name: &&String| read(&format!("{name}/status")).is_ok_and(|status| status == "connected");
        let connectors: Vec<&str> = names
            .iter()
            .filter(|name| name.starts_with(&format!("{card}-")))
            .filter(is_connected)
            .filter_map(|name| name.split_once('-').map(|(_, connector)| connector))
            .collect();
        let connectors = if connectors.is_empty() { "nothing".to_owned() } else { connectors.join(", ") };
        format!(
            "{card}: vendor {}, device {}, driver {}; connected: {connectors}",
            number("vendor"),
            number("device"),
            driver.as_deref().unwrap_or("unknown")
        )
    };
    let found: Vec<String> = names.iter().filter(is_card).map(describe).collect();
    if found.is_empty() { vec!["the kernel drives none; the processor draws".to_owned()] } else { found }
}

/// Reports whether the drivers can swap windows of several screens and machines at the same time.
pub fn swap_groups(display: &Environment, device: Option<&Headless>) -> String {
    let glx = probe::ask(Way::Glx, display).map(|answer| answer.extensions).unwrap_or_default();
    let glx = glx.iter().any(|name| name == "GLX_NV_swap_group");
    let vulkan = device.is_some_and(|device| device.api.has_extension(c"VK_NV_present_barrier"));
    let is = |there: bool| if there { "is there" } else { "is missing" };
    let words = format!("GLX_NV_swap_group {}, VK_NV_present_barrier {}", is(glx), is(vulkan));
    match (glx, vulkan) {
        (true, true) => format!("{words}; windows join with window.swap_group in the rig"),
        (true, false) => format!("{words}; windows of OpenGL join one with window.swap_group in the rig"),
        (false, true) => format!("{words}; windows of Vulkan join it with window.swap_group in the rig"),
        (false, false) => format!("{words}: displays begin to show a frame at different moments"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cards_are_listed_with_what_is_connected() {
        let folder = std::env::temp_dir().join(format!("cupola-cards-{}", std::process::id()));
        let write = |file: &str, text: &str| {
            let path = folder.join(file);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            std::fs::write(path, text).expect("written");
        };
        write("card0/device/vendor", "0x10de\n");
        write("card0/device/device", "0x2204\n");
        write("card0-DP-1/status", "connected\n");
        write("card0-DP-2/status", "disconnected\n");
        write("renderD128/x", "");
        std::os::unix::fs::symlink("/x/drivers/nouveau", folder.join("card0/device/driver")).expect("a link");
        let listed = cards(&folder);
        std::fs::remove_dir_all(&folder).expect("removed");
        assert_eq!(listed, ["card0: vendor 0x10de, device 0x2204, driver nouveau; connected: DP-1"]);
        assert_eq!(cards(&folder).len(), 1);
    }
}
