//! Events for a program by its X server, as if they came from the keyboard and the mouse of that
//! server (XTEST).

use super::{Event, keys};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use x11rb::CURRENT_TIME;
use x11rb::connection::Connection;
use x11rb::errors::ReplyError;
use x11rb::protocol::res::{ClientIdMask, ClientIdSpec, ConnectionExt as _};
use x11rb::protocol::xkb::{BoolCtrl, ConnectionExt as _, ID, PerClientFlag};
use x11rb::protocol::xproto::{
    AutoRepeatMode, BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ChangeKeyboardControlAux, ConnectionExt as _,
    CreateWindowAux, InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, MOTION_NOTIFY_EVENT, MapState, Window,
    WindowClass,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

/// Selection of the server. Only its owner may send events to the server's programs, or receive
/// them in a window.
pub const OWNER: &[u8] = b"CUPOLA_INPUT";

/// Number of levels at which a program's window may lie within those of a window manager.
const DEEPEST: u32 = 4;

/// Makes the selection [`OWNER`] that of `window`. `false`: another window has it.
///
/// # Errors
/// Those of the connection.
pub fn own(connection: &RustConnection, window: Window) -> Result<bool, ReplyError> {
    let selection = connection.intern_atom(false, OWNER)?.reply()?.atom;
    // Two that ask at the same time would both find it free.
    connection.grab_server()?;
    let is_free = connection.get_selection_owner(selection)?.reply()?.owner == x11rb::NONE;
    if is_free {
        connection.set_selection_owner(window, selection, CURRENT_TIME)?;
    }
    connection.ungrab_server()?;
    Ok(is_free)
}

/// Window of the program: its position on the screen, and its width and height.
struct Target {
    window: Window,
    corner: (i16, i16),
    size: (u16, u16),
}

/// X server of a program.
pub struct Screen {
    connection: RustConnection,
    name: String,
    root: Window,
    process: u32,
    /// Codes of the keys by the symbol that they have without modifiers.
    codes: HashMap<u32, Option<u8>>,
    window: Option<Window>,
    /// True if the server repeated held keys before.
    repeats: bool,
    /// Messages for the user.
    said: Vec<String>,
}

impl Screen {
    /// Connects to the server on which this process shows its windows.
    ///
    /// # Errors
    /// A message, if there is no server or it does not accept events.
    pub fn open(process: u32) -> Result<Self, String> {
        let name = display_of(process).ok_or("it has no X server (the variable DISPLAY)")?;
        let failed = |error: &dyn std::fmt::Display| format!("its X server {name}: {error}");
        let (connection, number) = x11rb::connect(Some(&name)).map_err(|error| failed(&error))?;
        let root = connection.setup().roots.get(number).map(|screen| screen.root);
        let root = root.ok_or_else(|| failed(&"there is no such screen"))?;
        let keyboard = u16::from(ID::USE_CORE_KBD);
        let begin = || -> Result<_, ReplyError> {
            connection.xtest_get_version(2, 2)?.reply()?;
            let window = connection.generate_id().map_err(|_| x11rb::errors::ConnectionError::UnknownError)?;
            let looks = CreateWindowAux::new();
            connection.create_window(0, window, root, 0, 0, 1, 1, 0, WindowClass::INPUT_ONLY, 0, &looks)?.check()?;
            let is_ours = own(&connection, window)?;
            let repeats = is_ours && connection.xkb_use_extension(1, 0)?.reply()?.supported && {
                let enabled = connection.xkb_get_controls(keyboard)?.reply()?.enabled_controls;
                u32::from(enabled & BoolCtrl::REPEAT_KEYS) != 0
            };
            if repeats {
                // The server repeats keys in its own time, in different frames on each node.
                let off = ChangeKeyboardControlAux::new().auto_repeat_mode(AutoRepeatMode::OFF);
                connection.change_keyboard_control(&off)?.check()?;
                // If this process is killed, the server switches the repetition on again.
                let (reset, keys) = (PerClientFlag::AUTO_RESET_CONTROLS, BoolCtrl::REPEAT_KEYS);
                connection.xkb_per_client_flags(keyboard, reset, reset, keys, keys, keys)?.reply()?;
            }
            let (least, most) = (connection.setup().min_keycode, connection.setup().max_keycode);
            let map = connection.get_keyboard_mapping(least, most - least + 1)?.reply()?;
            let mut codes = HashMap::new();
            for (code, symbols) in (least..=most).zip(map.keysyms.chunks(map.keysyms_per_keycode.max(1).into())) {
                if let Entry::Vacant(free) = codes.entry(symbols[0]) {
                    free.insert(Some(code));
                }
            }
            Ok((is_ours, repeats, codes))
        };
        let (is_ours, repeats, codes) = begin().map_err(|error| failed(&error))?;
        if !is_ours {
            return Err(failed(
                &"another node, or the window of cupola input, uses it already; each needs an X server of its own \
                  (--headless)",
            ));
        }
        Ok(Self { connection, name, root, process, codes, window: None, repeats, said: Vec::new() })
    }

    /// Sends events to the program, and waits until it has them. Returns messages for the user.
    ///
    /// # Errors
    /// A message, if the events did not reach the program.
    pub fn give(&mut self, events: &[Event]) -> Result<Vec<String>, String> {
        self.try_to_give(events).map_err(|error| format!("its X server {}: {error}", self.name))?;
        Ok(std::mem::take(&mut self.said))
    }

    fn try_to_give(&mut self, events: &[Event]) -> Result<(), ReplyError> {
        let Some(Target { window, corner, size }) = self.target()? else {
            let words = format!(
                "it has no visible window on the X server {}; events of keyboard and mouse are lost until it has one",
                self.name
            );
            self.said.push(words);
            return Ok(());
        };
        if events.iter().any(|event| matches!(event, Event::Key { .. })) {
            self.focus(window)?;
        }
        let fake = |kind: u8, detail: u8, root: Window, x: i16, y: i16| {
            self.connection.xtest_fake_input(kind, detail, CURRENT_TIME, root, x, y, 0).map(|sent| sent.ignore_error())
        };
        for event in events {
            match *event {
                Event::Key { symbol, is_down } => match self.codes.get(&symbol).copied() {
                    Some(Some(code)) => {
                        let kind = if is_down { KEY_PRESS_EVENT } else { KEY_RELEASE_EVENT };
                        fake(kind, code, x11rb::NONE, 0, 0)?;
                    }
                    // Already reported.
                    Some(None) => {}
                    None => {
                        self.codes.insert(symbol, None);
                        self.said.push(format!(
                            "the keyboard of the X server {} has no key for {} without a modifier",
                            self.name,
                            keys::name(symbol)
                        ));
                    }
                },
                Event::Button { number, is_down } => {
                    let kind = if is_down { BUTTON_PRESS_EVENT } else { BUTTON_RELEASE_EVENT };
                    fake(kind, number, x11rb::NONE, 0, 0)?;
                }
                Event::Place { x, y } => {
                    let at = |corner: i16, part: f64, size: u16| {
                        let inside = (part * f64::from(size)).min(f64::from(size) - 1.0).max(0.0) as i32;
                        i16::try_from(i32::from(corner) + inside).unwrap_or(i16::MAX)
                    };
                    fake(MOTION_NOTIFY_EVENT, 0, self.root, at(corner.0, x, size.0), at(corner.1, y, size.1))?;
                }
                Event::Shift { x, y } => {
                    let pixels = |number: i32| number.clamp(-0x7fff, 0x7fff) as i16;
                    // The detail 1: relative to where the pointer is.
                    fake(MOTION_NOTIFY_EVENT, 1, x11rb::NONE, pixels(x), pixels(y))?;
                }
            }
        }
        // After the first answer the server has made the events, and begins to write them to its
        // clients. It reads the second question when it has written to all.
        for _ in 0..2 {
            self.connection.get_input_focus()?.reply()?;
        }
        // Errors of requests that came too late for a window, and notices of keyboards.
        while self.connection.poll_for_event()?.is_some() {}
        Ok(())
    }

    /// Returns the program's window, with its present position and size.
    fn target(&mut self) -> Result<Option<Target>, ReplyError> {
        for is_known in [true, false] {
            if !is_known {
                self.window = self.find_window()?;
            }
            let Some(window) = self.window else { continue };
            let size = self.connection.get_geometry(window)?;
            let corner = self.connection.translate_coordinates(window, self.root, 0, 0)?;
            if let (Ok(size), Ok(corner)) = (size.reply(), corner.reply()) {
                let (corner, size) = ((corner.dst_x, corner.dst_y), (size.width, size.height));
                return Ok(Some(Target { window, corner, size }));
            }
        }
        Ok(None)
    }

    /// Finds the largest visible window of the program. If the server does not know the owners of
    /// windows, it is the largest of all.
    fn find_window(&self) -> Result<Option<Window>, ReplyError> {
        let all = ClientIdSpec { client: 0, mask: ClientIdMask::LOCAL_CLIENT_PID };
        let clients = self.connection.res_query_client_ids(&[all])?.reply().map(|reply| reply.ids).unwrap_or_default();
        let own = |client: u32| self.connection.setup().resource_id_base == client;
        let is_known = clients.iter().any(|client| !own(client.spec.client) && !client.value.is_empty());
        let ours = clients.iter().filter(|client| client.value.first() == Some(&self.process));
        let ours: Vec<u32> = ours.map(|client| self.client(client.spec.client)).collect();
        let mut found: Option<(u32, Window)> = None;
        let mut level = self.connection.query_tree(self.root)?.reply()?.children;
        for _ in 0..DEEPEST {
            let mut below = Vec::new();
            for window in level {
                let (looks, size) =
                    (self.connection.get_window_attributes(window)?, self.connection.get_geometry(window)?);
                // It may have been closed meanwhile.
                let (Ok(looks), Ok(size)) = (looks.reply(), size.reply()) else { continue };
                if looks.map_state != MapState::VIEWABLE {
                    continue;
                }
                if !is_known || ours.contains(&self.client(window)) {
                    let area = u32::from(size.width) * u32::from(size.height);
                    if looks.class == WindowClass::INPUT_OUTPUT && found.is_none_or(|(largest, _)| area > largest) {
                        found = Some((area, window));
                    }
                } else if let Ok(tree) = self.connection.query_tree(window)?.reply() {
                    below.extend(tree.children);
                }
            }
            level = below;
        }
        Ok(found.map(|(_, window)| window))
    }

    /// Returns the client that owns this resource.
    fn client(&self, id: u32) -> u32 {
        id & !self.connection.setup().resource_id_mask
    }

    /// Gives the keyboard focus to the program.
    fn focus(&self, window: Window) -> Result<(), ReplyError> {
        let now = self.connection.get_input_focus()?.reply()?.focus;
        // A window of a toolkit may have given it to one of its parts.
        if self.client(now) != self.client(window) {
            self.connection.set_input_focus(InputFocus::PARENT, window, CURRENT_TIME)?.ignore_error();
        }
        Ok(())
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        if self.repeats {
            let on = ChangeKeyboardControlAux::new().auto_repeat_mode(AutoRepeatMode::ON);
            // The server may have ended.
            let _ = self.connection.change_keyboard_control(&on).map(|sent| sent.check());
        }
    }
}

/// Returns the name of a process's X server, from its environment.
fn display_of(process: u32) -> Option<String> {
    let variables = std::fs::read(format!("/proc/{process}/environ")).ok()?;
    let value = variables.split(|byte| *byte == 0).find_map(|variable| variable.strip_prefix(b"DISPLAY="))?;
    String::from_utf8(value.to_vec()).ok().filter(|name| !name.is_empty())
}
