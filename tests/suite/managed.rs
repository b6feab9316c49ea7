//! Windows under a window manager, which puts them into frames and keeps to their size hints.

use crate::display;
use crate::finished::Finished;
use crate::harness::tests;
use crate::programs::{Run, built, library, vulkan_apps};
use std::collections::HashMap;
use std::path::Path;
use std::process::Command;
use x11rb::connection::Connection;
use x11rb::errors::ReplyOrIdError;
use x11rb::properties::WmSizeHints;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    ChangeWindowAttributesAux, ConfigureWindowAux, ConnectionExt as _, CreateWindowAux, EventMask, PropMode, Window,
    WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

tests! {
    a_window_of_one_size_gets_the_wanted_one,
}

/// A window manager. Each window has only the size that it has when it appears.
struct Manager {
    connection: RustConnection,
    root: Window,
    frames: HashMap<Window, Window>,
}

impl Manager {
    fn new(display: &str) -> Self {
        let (connection, number) = x11rb::connect(Some(display)).expect("an X server");
        let root = connection.setup().roots[number].root;
        let redirect = ChangeWindowAttributesAux::new().event_mask(EventMask::SUBSTRUCTURE_REDIRECT);
        connection.change_window_attributes(root, &redirect).expect("sent").check().expect("no other manager");
        Self { connection, root, frames: HashMap::new() }
    }

    /// Manages windows until the X server ends.
    fn run(mut self) {
        while let Ok(event) = self.connection.wait_for_event() {
            // A window may be gone before its event is handled.
            let _ = match event {
                Event::MapRequest(request) => self.map(request.window),
                Event::ConfigureRequest(request) => self.configure(request.window, (request.width, request.height)),
                _ => Ok(()),
            };
        }
    }

    fn map(&mut self, window: Window) -> Result<(), ReplyOrIdError> {
        let connection = &self.connection;
        let place = connection.get_geometry(window)?.reply()?;
        let frame = connection.generate_id()?;
        let looks = CreateWindowAux::new().override_redirect(1).event_mask(EventMask::SUBSTRUCTURE_REDIRECT);
        let (width, height, class) = (place.width, place.height, WindowClass::INPUT_OUTPUT);
        connection.create_window(0, frame, self.root, place.x, place.y, width, height, 0, class, 0, &looks)?;
        connection.reparent_window(window, frame, 0, 0)?;
        let state = connection.intern_atom(false, b"WM_STATE")?.reply()?.atom;
        connection.change_property32(PropMode::REPLACE, window, state, state, &[1, 0])?;
        let only = Some((i32::from(width), i32::from(height)));
        WmSizeHints { min_size: only, max_size: only, ..WmSizeHints::default() }
            .set_normal_hints(connection, window)?;
        connection.map_window(frame)?;
        connection.map_window(window)?;
        connection.flush()?;
        self.frames.insert(window, frame);
        Ok(())
    }

    fn configure(&self, window: Window, (width, height): (u16, u16)) -> Result<(), ReplyOrIdError> {
        let hints = WmSizeHints::get_normal_hints(&self.connection, window)?.reply()?.unwrap_or_default();
        let least = hints.min_size.unwrap_or((1, 1));
        let most = hints.max_size.unwrap_or((i32::MAX, i32::MAX));
        let width = i32::from(width).clamp(least.0, most.0) as u32;
        let height = i32::from(height).clamp(least.1, most.1) as u32;
        let size = ConfigureWindowAux::new().width(width).height(height);
        for window in [Some(&window), self.frames.get(&window)].into_iter().flatten() {
            self.connection.configure_window(*window, &size)?;
        }
        self.connection.flush()?;
        Ok(())
    }
}

fn a_window_of_one_size_gets_the_wanted_one() {
    gets_the_wanted_size(&built().join("immediate"));
    if let Some(vulkan) = vulkan_apps() {
        gets_the_wanted_size(&vulkan.join("vk_cube"));
    }
}

/// The window of a program gets the size that `--size` says, although it has another size only.
fn gets_the_wanted_size(program: &Path) {
    let Some(display) = display::own(24) else { return };
    let manager = Manager::new(&display.name);
    let thread = std::thread::spawn(|| manager.run());
    let run = Run { frames: 0, size: (96, 96), ..Run::new("a program") };
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.env("CUPOLA_LIBRARY", library()).args(["run", "--rig", "fisheye", "--size", "200x150", "--frames", "8"]);
    command.args(["--capture", "capture.png", "--"]).arg(program);
    let place = display::place();
    command.args(run.arguments(&place));
    let finished = Finished::on(&display, command, run.program, "fisheye").expect_success();
    let picture = finished.picture("capture.png");
    assert_eq!((picture.width, picture.height), (200, 150));
    display.kill();
    thread.join().expect("the window manager ends with its X server");
}
