//! Buffers of the window that the program draws to and reads from. Front and back buffer are one
//! image in the stand-in.

use crate::backend::gl::driver::api::{self, Gl};

/// Number of draw buffers that Cupola follows: drivers have at most as many.
pub const COUNT: usize = 16;

/// Names of draw buffers, in their order.
pub type DrawBuffers = [u32; COUNT];

/// The program's draw buffers and read buffer of its window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WindowBuffers {
    draw: DrawBuffers,
    read: u32,
}

impl WindowBuffers {
    /// Returns the buffers of a new context, whose window has `buffer`.
    pub fn of_window(buffer: u32) -> Self {
        Self { draw: only(buffer), read: buffer }
    }

    /// Returns the draw buffers.
    pub fn draw(&self) -> &DrawBuffers {
        &self.draw
    }

    /// Returns the read buffer.
    pub fn read(&self) -> u32 {
        self.read
    }

    /// True if the program has chosen no draw buffer.
    pub fn draws_nothing(&self) -> bool {
        self.draw.iter().all(|name| *name == api::GL_NONE)
    }

    /// Sets the draw buffers.
    pub fn set_draw(&mut self, names: DrawBuffers) {
        self.draw = names;
    }

    /// Sets the read buffer.
    pub fn set_read(&mut self, name: u32) {
        self.read = name;
    }

    /// Selects the draw buffers in the stand-in, which must be bound for drawing.
    pub fn draw_to_stand_in(&self, gl: &Gl) {
        select(gl, &of_stand_in(&self.draw));
    }

    /// Selects the read buffer in the stand-in, which must be bound for reading.
    pub fn read_from_stand_in(&self, gl: &Gl) {
        let name = if self.read == api::GL_NONE { api::GL_NONE } else { api::GL_COLOR_ATTACHMENT0 };
        // SAFETY: a buffer that the stand-in has.
        unsafe { gl.read_buffer(name) };
    }

    /// Selects the draw buffers in the window's own framebuffer, which must be bound for drawing.
    pub fn draw_to_window(&self, gl: &Gl, es: bool) {
        match self.draw {
            // Some names are valid only here.
            [first, ref others @ ..] if !es && others.iter().all(|name| *name == api::GL_NONE) => {
                // SAFETY: a buffer that the program has chosen.
                unsafe { gl.draw_buffer(first) };
            }
            names => select(gl, &names),
        }
    }
}

/// Returns the names of one draw buffer.
pub fn only(name: u32) -> DrawBuffers {
    let mut names = [api::GL_NONE; COUNT];
    names[0] = name;
    names
}

/// Returns the names of the stand-in for those of the window.
pub fn of_stand_in(names: &DrawBuffers) -> DrawBuffers {
    let mut translated = [api::GL_NONE; COUNT];
    if let Some(place) = names.iter().position(|name| *name != api::GL_NONE) {
        translated[place] = api::GL_COLOR_ATTACHMENT0;
    }
    translated
}

fn select(gl: &Gl, names: &DrawBuffers) {
    let count = names.iter().rposition(|name| *name != api::GL_NONE).map_or(1, |last| last + 1);
    // SAFETY: `count` names of the array.
    unsafe { gl.draw_buffers(count as i32, names.as_ptr()) };
}

#[cfg(test)]
mod tests {
    use super::{WindowBuffers, api, of_stand_in, only};

    #[test]
    fn the_first_buffer_of_the_window_is_the_image_of_the_stand_in() {
        assert_eq!(of_stand_in(&only(api::GL_BACK)), only(api::GL_COLOR_ATTACHMENT0));
        assert_eq!(of_stand_in(&only(api::GL_NONE)), only(api::GL_NONE));
        let mut second = only(api::GL_NONE);
        second[1] = api::GL_BACK_LEFT;
        assert_eq!(of_stand_in(&second)[..3], [api::GL_NONE, api::GL_COLOR_ATTACHMENT0, api::GL_NONE]);
        let mut buffers = WindowBuffers::of_window(api::GL_BACK);
        buffers.set_draw(second);
        assert!(!buffers.draws_nothing());
        buffers.set_draw(only(api::GL_NONE));
        assert!(buffers.draws_nothing());
    }
}
