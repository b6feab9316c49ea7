//! A window in which the driver shows finished pictures. A driver swaps it as it swaps windows of
//! programs: after so many refreshes of the display, and together with the other windows of a swap
//! group.

use super::{GLX_DRAWABLE_TYPE, GLX_RGBA_TYPE, Glx, Handle, connect, graphics};
use crate::backend::gl::driver::api::{self, Gl};
use crate::error::Result;
use std::ffi::{CStr, c_int, c_uint, c_ulong, c_void};
use std::ptr::null_mut;

const GLX_WINDOW_BIT: c_int = 1;
const GLX_DOUBLEBUFFER: c_int = 5;
const GLX_VISUAL_ID: c_int = 0x800B;

/// A window that another connection to the X server made. It shows pictures pixel for pixel.
pub struct Window {
    glx: &'static Glx,
    display: Handle,
    window: c_ulong,
    size: (u32, u32),
    gl: Box<Gl>,
    framebuffer: u32,
    texture: u32,
    /// Size of the texture.
    kept: (u32, u32),
}

impl Window {
    /// Makes a context for a window of `size` pixels on a display (`None`: that of `DISPLAY`) whose
    /// pixels have the visual `visual`, and makes it current on this thread. Like [`super::driver`],
    /// for processes that may end when the X server goes away.
    ///
    /// # Errors
    /// There is no GLX, or no context that can draw to such windows and has framebuffer objects.
    pub fn new(display: Option<&str>, window: u32, visual: u32, size: (u32, u32)) -> Result<Self> {
        let (glx, display) = connect(display)?;
        let window = c_ulong::from(window);
        let config = config(glx, display, visual)
            .ok_or_else(|| graphics("the X display has no GLX for windows with two buffers"))?;
        // SAFETY: display and configuration are valid, and the window has the configuration's visual.
        let is_current = unsafe {
            let context = (glx.create_context)(display, config, GLX_RGBA_TYPE, null_mut(), 1);
            !context.is_null() && (glx.make_current)(display, window, window, context) != 0
        };
        if !is_current {
            return Err(graphics("GLX cannot make a context for the window"));
        }
        // SAFETY: the name ends with a zero.
        let gl = Gl::load(|name| unsafe { (glx.get_proc_address)(name.as_ptr()) });
        let (mut framebuffer, mut texture) = (0, 0);
        // SAFETY: the context is current; one name is written to each.
        unsafe {
            gl.gen_framebuffers(1, &mut framebuffer);
            gl.gen_textures(1, &mut texture);
        }
        if framebuffer == 0 || texture == 0 {
            return Err(graphics("the driver has no framebuffer objects"));
        }
        Ok(Self { glx, display, window, size, gl: Box::new(gl), framebuffer, texture, kept: (0, 0) })
    }

    /// A function of GLX; `None` if the driver lacks it.
    fn function(&self, name: &CStr) -> Option<*const c_void> {
        // SAFETY: the name ends with a zero.
        Some(unsafe { (self.glx.get_proc_address)(name.as_ptr()) }).filter(|function| !function.is_null())
    }

    /// Lets each swap wait for `refreshes` refreshes of the display. Returns false if the driver has
    /// no such setting.
    pub fn set_interval(&self, refreshes: u32) -> bool {
        let Some(function) = self.function(c"glXSwapIntervalEXT") else { return false };
        // SAFETY: the function has this type in GLX_EXT_swap_control.
        unsafe {
            let set: unsafe extern "C" fn(Handle, c_ulong, c_int) = std::mem::transmute(function);
            set(self.display, self.window, refreshes.min(c_int::MAX as u32) as c_int);
        }
        true
    }

    /// Joins a swap group. Returns false if the driver has none, or refuses.
    pub fn join_group(&self, group: u32) -> bool {
        let Some(function) = self.function(c"glXJoinSwapGroupNV") else { return false };
        // SAFETY: the function has this type in GLX_NV_swap_group.
        unsafe {
            let join: unsafe extern "C" fn(Handle, c_ulong, c_uint) -> c_int = std::mem::transmute(function);
            join(self.display, self.window, group) != 0
        }
    }

    /// Binds a swap group to a barrier. Returns false if the driver has none, or refuses.
    pub fn bind_barrier(&self, group: u32, barrier: u32) -> bool {
        let Some(function) = self.function(c"glXBindSwapBarrierNV") else { return false };
        // SAFETY: the function has this type in GLX_NV_swap_group.
        unsafe {
            let bind: unsafe extern "C" fn(Handle, c_uint, c_uint) -> c_int = std::mem::transmute(function);
            bind(self.display, group, barrier) != 0
        }
    }

    /// Shows a picture with red, green, blue and one more byte for each pixel, rows from the top. It
    /// is not scaled: what does not fit into the window is left out on the right and below. Returns
    /// when the driver has taken the swap.
    ///
    /// # Errors
    /// The driver reports an error, for example of memory. `rgba` is shorter than the size says.
    pub fn show(&mut self, size: (u32, u32), rgba: &[u8]) -> Result<()> {
        if (rgba.len() as u64) < u64::from(size.0) * u64::from(size.1) * 4 {
            return Err(graphics("the picture is incomplete"));
        }
        let (gl, (width, height)) = (&self.gl, (size.0 as c_int, size.1 as c_int));
        let (window_width, window_height) = (self.size.0 as c_int, self.size.1 as c_int);
        let (across, down) = (width.min(window_width), height.min(window_height));
        // SAFETY: the context is current on the thread that made it, which alone has this value;
        // the picture has as many bytes as the size says.
        let error = unsafe {
            gl.bind_texture(api::GL_TEXTURE_2D, self.texture);
            let (target, format, kind) = (api::GL_TEXTURE_2D, api::GL_RGBA, api::GL_UNSIGNED_BYTE);
            if self.kept == size {
                gl.tex_sub_image2_d(target, 0, 0, 0, width, height, format, kind, rgba.as_ptr().cast());
            } else {
                gl.tex_image2_d(target, 0, api::GL_RGBA8 as i32, width, height, 0, format, kind, rgba.as_ptr().cast());
                let (framebuffer, point) = (api::GL_READ_FRAMEBUFFER, api::GL_COLOR_ATTACHMENT0);
                gl.bind_framebuffer(framebuffer, self.framebuffer);
                gl.framebuffer_texture2_d(framebuffer, point, target, self.texture, 0);
                self.kept = size;
            }
            gl.clear(api::GL_COLOR_BUFFER_BIT);
            let (left, top, bottom) = (0, window_height, window_height - down);
            let (mask, filter) = (api::GL_COLOR_BUFFER_BIT, api::GL_NEAREST);
            gl.blit_framebuffer(0, 0, across, down, left, top, across, bottom, mask, filter);
            let error = gl.get_error();
            (self.glx.swap_buffers)(self.display, self.window);
            error
        };
        match error {
            api::GL_NO_ERROR => Ok(()),
            error => Err(graphics(format!("the driver reports error {error:#x} while it shows a picture"))),
        }
    }
}

/// A configuration with two buffers for windows of a visual.
fn config(glx: &Glx, display: Handle, visual: u32) -> Option<Handle> {
    let wanted = [GLX_DRAWABLE_TYPE, GLX_WINDOW_BIT, GLX_DOUBLEBUFFER, 1, 0];
    let mut count = 0;
    // SAFETY: the display is open, the list ends with 0, `count` is written.
    let configs = unsafe { (glx.choose_config)(display, (glx.default_screen)(display), wanted.as_ptr(), &mut count) };
    if configs.is_null() {
        return None;
    }
    let of = |config: Handle| {
        let mut value = 0;
        // SAFETY: a configuration of the display; `value` is written.
        unsafe { (glx.config_value)(display, config, GLX_VISUAL_ID, &mut value) };
        value as u32
    };
    // SAFETY: the list has `count` entries, and is Xlib's to free.
    unsafe {
        let found = (0..count.max(0) as usize).map(|index| *configs.add(index)).find(|config| of(*config) == visual);
        (glx.free)(configs.cast());
        found
    }
}
