//! Events of a Wayland compositor.

use super::BUFFERS;
use wayland_client::globals::GlobalListContents;
use wayland_client::protocol::{
    wl_buffer, wl_callback, wl_compositor, wl_keyboard, wl_output, wl_pointer, wl_registry, wl_seat, wl_shm,
    wl_shm_pool, wl_surface,
};
use wayland_client::{Connection, Dispatch, Proxy, QueueHandle, WEnum, delegate_noop};
use wayland_protocols::wp::viewporter::client::{wp_viewport, wp_viewporter};
use wayland_protocols::xdg::shell::client::{xdg_surface, xdg_toplevel, xdg_wm_base};
use wayland_protocols::xdg::xdg_output::zv1::client::zxdg_output_manager_v1::ZxdgOutputManagerV1;
use wayland_protocols::xdg::xdg_output::zv1::client::zxdg_output_v1::{self, ZxdgOutputV1};

/// What the compositor has reported.
#[derive(Default)]
pub struct Events {
    pub outputs: Vec<Output>,
    /// Size that the compositor proposes for the window, in its own units.
    pub proposed: (i32, i32),
    pub is_configured: bool,
    pub is_closed: bool,
    pub is_pressed: bool,
    /// True if the display has taken a picture, and is not asked about another one.
    pub is_shown: bool,
    /// For each buffer, true if the compositor reads it.
    pub is_read: [bool; BUFFERS],
}

/// A monitor.
pub struct Output {
    pub output: wl_output::WlOutput,
    /// Number of the global object.
    pub number: u32,
    pub name: String,
    /// Pixels of the current mode.
    pub size: (u32, u32),
    /// True if the monitor stands on its side.
    pub is_turned: bool,
}

impl Output {
    /// Width and height as they are seen.
    pub fn seen(&self) -> (u32, u32) {
        if self.is_turned { (self.size.1, self.size.0) } else { self.size }
    }
}

impl Events {
    /// Binds a monitor, which then reports its name and mode.
    pub fn bind_output(
        &mut self,
        registry: &wl_registry::WlRegistry,
        number: u32,
        version: u32,
        handle: &QueueHandle<Self>,
    ) {
        // Monitors have names here since version 4.
        let output = registry.bind(number, version.min(4), handle, number);
        self.outputs.push(Output { output, number, name: String::new(), size: (0, 0), is_turned: false });
    }
}

impl Dispatch<wl_registry::WlRegistry, GlobalListContents> for Events {
    fn event(
        events: &mut Self,
        registry: &wl_registry::WlRegistry,
        event: wl_registry::Event,
        _: &GlobalListContents,
        _: &Connection,
        handle: &QueueHandle<Self>,
    ) {
        match event {
            wl_registry::Event::Global { name, interface, version }
                if interface == wl_output::WlOutput::interface().name =>
            {
                events.bind_output(registry, name, version, handle);
            }
            wl_registry::Event::GlobalRemove { name } => events.outputs.retain(|output| output.number != name),
            _ => {}
        }
    }
}

impl Dispatch<wl_output::WlOutput, u32> for Events {
    fn event(
        events: &mut Self,
        _: &wl_output::WlOutput,
        event: wl_output::Event,
        number: &u32,
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        let Some(output) = events.outputs.iter_mut().find(|output| output.number == *number) else { return };
        match event {
            wl_output::Event::Name { name } => output.name = name,
            wl_output::Event::Mode { flags: WEnum::Value(flags), width, height, .. }
                if flags.contains(wl_output::Mode::Current) =>
            {
                output.size = (width.max(0) as u32, height.max(0) as u32);
            }
            wl_output::Event::Geometry { transform: WEnum::Value(transform), .. } => {
                use wl_output::Transform as T;
                output.is_turned = matches!(transform, T::_90 | T::_270 | T::Flipped90 | T::Flipped270);
            }
            _ => {}
        }
    }
}

impl Dispatch<ZxdgOutputV1, u32> for Events {
    fn event(
        events: &mut Self,
        _: &ZxdgOutputV1,
        event: zxdg_output_v1::Event,
        number: &u32,
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        let output = events.outputs.iter_mut().find(|output| output.number == *number);
        if let (Some(output), zxdg_output_v1::Event::Name { name }) = (output, event) {
            output.name = name;
        }
    }
}

impl Dispatch<xdg_wm_base::XdgWmBase, ()> for Events {
    fn event(
        _: &mut Self,
        shell: &xdg_wm_base::XdgWmBase,
        event: xdg_wm_base::Event,
        (): &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        if let xdg_wm_base::Event::Ping { serial } = event {
            shell.pong(serial);
        }
    }
}

impl Dispatch<xdg_surface::XdgSurface, ()> for Events {
    fn event(
        events: &mut Self,
        surface: &xdg_surface::XdgSurface,
        event: xdg_surface::Event,
        (): &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        if let xdg_surface::Event::Configure { serial } = event {
            surface.ack_configure(serial);
            events.is_configured = true;
        }
    }
}

impl Dispatch<xdg_toplevel::XdgToplevel, ()> for Events {
    fn event(
        events: &mut Self,
        _: &xdg_toplevel::XdgToplevel,
        event: xdg_toplevel::Event,
        (): &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        match event {
            xdg_toplevel::Event::Configure { width, height, .. } => events.proposed = (width, height),
            xdg_toplevel::Event::Close => events.is_closed = true,
            _ => {}
        }
    }
}

impl Dispatch<wl_buffer::WlBuffer, usize> for Events {
    fn event(
        events: &mut Self,
        _: &wl_buffer::WlBuffer,
        event: wl_buffer::Event,
        number: &usize,
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        if let wl_buffer::Event::Release = event {
            events.is_read[*number] = false;
        }
    }
}

impl Dispatch<wl_callback::WlCallback, ()> for Events {
    fn event(
        events: &mut Self,
        _: &wl_callback::WlCallback,
        _: wl_callback::Event,
        (): &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        events.is_shown = true;
    }
}

impl Dispatch<wl_seat::WlSeat, ()> for Events {
    fn event(
        _: &mut Self,
        seat: &wl_seat::WlSeat,
        event: wl_seat::Event,
        (): &(),
        _: &Connection,
        handle: &QueueHandle<Self>,
    ) {
        let wl_seat::Event::Capabilities { capabilities: WEnum::Value(has) } = event else { return };
        if has.contains(wl_seat::Capability::Keyboard) {
            seat.get_keyboard(handle, ());
        }
        if has.contains(wl_seat::Capability::Pointer) {
            seat.get_pointer(handle, ());
        }
    }
}

impl Dispatch<wl_keyboard::WlKeyboard, ()> for Events {
    fn event(
        events: &mut Self,
        _: &wl_keyboard::WlKeyboard,
        event: wl_keyboard::Event,
        (): &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        let pressed = WEnum::Value(wl_keyboard::KeyState::Pressed);
        events.is_pressed |= matches!(event, wl_keyboard::Event::Key { state, .. } if state == pressed);
    }
}

impl Dispatch<wl_pointer::WlPointer, ()> for Events {
    fn event(
        events: &mut Self,
        pointer: &wl_pointer::WlPointer,
        event: wl_pointer::Event,
        (): &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        match event {
            // The pointer would be a part of the picture.
            wl_pointer::Event::Enter { serial, .. } => pointer.set_cursor(serial, None, 0, 0),
            wl_pointer::Event::Button { state: WEnum::Value(wl_pointer::ButtonState::Pressed), .. } => {
                events.is_pressed = true;
            }
            _ => {}
        }
    }
}

delegate_noop!(Events: wl_compositor::WlCompositor);
delegate_noop!(Events: wl_shm_pool::WlShmPool);
delegate_noop!(Events: wp_viewporter::WpViewporter);
delegate_noop!(Events: wp_viewport::WpViewport);
delegate_noop!(Events: ZxdgOutputManagerV1);
delegate_noop!(Events: ignore wl_shm::WlShm);
delegate_noop!(Events: ignore wl_surface::WlSurface);
