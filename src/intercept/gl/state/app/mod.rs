//! The app state: the state that the program has set, as the program would read it.
//!
//! [`attribute_stack`] holds the part that `glPushAttrib` saves, [`window_arrays`] the viewports
//! and scissors by index, [`window_buffers`] the buffers of the window.

pub mod attribute_stack;
pub mod window_arrays;
pub mod window_buffers;

use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::state::app::attribute_stack::{ATTRIBUTE_DEPTH, Pushed, SavedAppState};
use crate::intercept::gl::state::app::window_arrays::{Viewport, WindowArrays};
use crate::intercept::gl::state::app::window_buffers::WindowBuffers;

/// State that the program has set, as the program would read it.
pub struct AppState {
    /// The program's draw framebuffer, 0 = its window.
    draw_framebuffer: u32,
    /// The program's read framebuffer.
    read_framebuffer: u32,
    /// The first viewport, in whole pixels.
    viewport: LowerLeftRect,
    /// The first scissor.
    scissor: LowerLeftRect,
    /// The first scissor test.
    scissor_test: bool,
    /// Viewports and scissors, if they differ by their index or have fractions.
    arrays: Option<Box<WindowArrays>>,
    /// `glDrawBuffers` and `glReadBuffer` of the program's window.
    buffers: WindowBuffers,
    /// `glMatrixMode`.
    matrix_mode: u32,
    /// Stack of `glPushAttrib`.
    attribute_stack: Vec<Pushed>,
    /// True if `glRenderMode` is not `GL_RENDER`.
    picking: bool,
    /// `GL_RASTERIZER_DISCARD`.
    discard: bool,
    /// True while transform feedback is recording.
    feedback: bool,
    /// True once the program has switched on a vertex program in assembly language. The
    /// fixed-function matrices may then have no meaning.
    assembly: bool,
}

impl Default for AppState {
    fn default() -> Self {
        Self {
            draw_framebuffer: 0,
            read_framebuffer: 0,
            viewport: LowerLeftRect::default(),
            scissor: LowerLeftRect::default(),
            scissor_test: false,
            arrays: None,
            buffers: WindowBuffers::of_window(api::GL_BACK),
            matrix_mode: api::GL_MODELVIEW,
            attribute_stack: Vec::new(),
            picking: false,
            discard: false,
            feedback: false,
            assembly: false,
        }
    }
}

impl AppState {
    /// Returns the program's draw framebuffer, 0 = its window.
    pub fn draw_framebuffer(&self) -> u32 {
        self.draw_framebuffer
    }

    /// Returns the program's read framebuffer, 0 = its window.
    pub fn read_framebuffer(&self) -> u32 {
        self.read_framebuffer
    }

    /// Returns the first viewport, in whole pixels.
    pub fn viewport(&self) -> LowerLeftRect {
        self.viewport
    }

    /// Returns the first scissor.
    pub fn scissor(&self) -> LowerLeftRect {
        self.scissor
    }

    /// Returns the first scissor test.
    pub fn scissor_test(&self) -> bool {
        self.scissor_test
    }

    /// Returns the buffers of the program's window.
    pub fn buffers(&self) -> &WindowBuffers {
        &self.buffers
    }

    /// The buffers of the program's window, to be changed.
    pub fn buffers_mut(&mut self) -> &mut WindowBuffers {
        &mut self.buffers
    }

    /// Returns `glMatrixMode`.
    pub fn matrix_mode(&self) -> u32 {
        self.matrix_mode
    }

    /// True if `glRenderMode` is not `GL_RENDER`.
    pub fn picking(&self) -> bool {
        self.picking
    }

    /// True if `GL_RASTERIZER_DISCARD` is on.
    pub fn discard(&self) -> bool {
        self.discard
    }

    /// True while transform feedback is recording.
    pub fn feedback(&self) -> bool {
        self.feedback
    }

    /// True once the program has switched on a vertex program in assembly language.
    pub fn assembly(&self) -> bool {
        self.assembly
    }

    /// The program binds a draw framebuffer.
    pub fn bind_draw_framebuffer(&mut self, name: u32) {
        self.draw_framebuffer = name;
    }

    /// The program binds a read framebuffer.
    pub fn bind_read_framebuffer(&mut self, name: u32) {
        self.read_framebuffer = name;
    }

    /// `glMatrixMode`.
    pub fn set_matrix_mode(&mut self, mode: u32) {
        self.matrix_mode = mode;
    }

    /// `glRenderMode`.
    pub fn set_render_mode(&mut self, mode: u32) {
        self.picking = mode != api::GL_RENDER;
    }

    /// `glEnable` and `glDisable` of switches other than the scissor test.
    pub fn note_switch(&mut self, switch: u32, on: bool) {
        match switch {
            api::GL_RASTERIZER_DISCARD => self.discard = on,
            api::GL_VERTEX_PROGRAM_ARB => self.assembly |= on,
            _ => {}
        }
    }

    /// Notes whether transform feedback is recording.
    pub fn note_feedback(&mut self, recording: bool) {
        self.feedback = recording;
    }

    /// True if the driver's attribute stack has room for one more entry, beside the program's
    /// entries and `own` entries of Cupola.
    pub fn can_push(&self, own: usize) -> bool {
        self.attribute_stack.len() + own < ATTRIBUTE_DEPTH
    }

    /// `glPushAttrib`, if the stack has room.
    pub fn push(&mut self, pushed: Pushed) {
        self.attribute_stack.push(pushed);
    }

    /// `glPopAttrib`.
    pub fn pop(&mut self) -> Option<Pushed> {
        self.attribute_stack.pop()
    }

    /// Viewports and scissors, if they differ by their index or have fractions.
    pub fn arrays(&self) -> Option<&WindowArrays> {
        self.arrays.as_deref()
    }

    /// Viewports and scissors by their index.
    pub fn all_arrays(&self) -> WindowArrays {
        let alike = || WindowArrays::alike(self.viewport, self.scissor, self.scissor_test);
        self.arrays.as_deref().cloned().unwrap_or_else(alike)
    }

    /// A viewport by its index.
    pub fn viewport_at(&self, index: usize) -> Viewport {
        self.arrays.as_ref().map_or(self.viewport.into(), |arrays| arrays.viewports[index])
    }

    /// A scissor by its index.
    pub fn scissor_at(&self, index: usize) -> LowerLeftRect {
        self.arrays.as_ref().map_or(self.scissor, |arrays| arrays.scissors[index])
    }

    /// A scissor test by its index.
    pub fn scissor_test_at(&self, index: usize) -> bool {
        self.arrays.as_ref().map_or(self.scissor_test, |arrays| arrays.tests >> index & 1 != 0)
    }

    /// Changes viewports and scissors by their index.
    pub fn change_arrays(&mut self, change: impl FnOnce(&mut WindowArrays)) {
        let mut arrays = self.all_arrays();
        change(&mut arrays);
        self.viewport = arrays.viewports[0].rounded();
        self.scissor = arrays.scissors[0];
        self.scissor_test = arrays.tests & 1 != 0;
        let alike = WindowArrays::alike(self.viewport, self.scissor, self.scissor_test);
        self.arrays = (arrays != alike).then(|| Box::new(arrays));
    }

    /// `glViewport`: all viewports.
    pub fn set_viewport(&mut self, rect: LowerLeftRect) {
        match self.arrays {
            Some(_) => self.change_arrays(|arrays| arrays.viewports = [Viewport::from(rect); window_arrays::COUNT]),
            None => self.viewport = rect,
        }
    }

    /// `glScissor`: all scissors.
    pub fn set_scissor(&mut self, rect: LowerLeftRect) {
        match self.arrays {
            Some(_) => self.change_arrays(|arrays| arrays.scissors = [rect; window_arrays::COUNT]),
            None => self.scissor = rect,
        }
    }

    /// `glEnable` and `glDisable` of `GL_SCISSOR_TEST`: all scissor tests.
    pub fn set_scissor_test(&mut self, on: bool) {
        match self.arrays {
            Some(_) => self.change_arrays(|arrays| arrays.tests = if on { u16::MAX } else { 0 }),
            None => self.scissor_test = on,
        }
    }

    /// Returns the state that `glPushAttrib` saves.
    pub fn saved(&self) -> SavedAppState {
        SavedAppState {
            arrays: self.all_arrays(),
            draw_buffers: (self.draw_framebuffer == 0).then(|| *self.buffers.draw()),
            read_buffer: (self.read_framebuffer == 0).then(|| self.buffers.read()),
            matrix_mode: self.matrix_mode,
        }
    }

    /// `glPopAttrib`: restores the groups of `mask`.
    pub fn restore(&mut self, mask: u32, saved: &SavedAppState) {
        self.change_arrays(|arrays| {
            if mask & api::GL_VIEWPORT_BIT != 0 {
                arrays.viewports = saved.arrays.viewports;
            }
            if mask & api::GL_SCISSOR_BIT != 0 {
                arrays.scissors = saved.arrays.scissors;
            }
            if mask & (api::GL_SCISSOR_BIT | api::GL_ENABLE_BIT) != 0 {
                arrays.tests = saved.arrays.tests;
            }
        });
        if mask & api::GL_TRANSFORM_BIT != 0 {
            self.matrix_mode = saved.matrix_mode;
        }
        if let (Some(names), 0) = (saved.draw_buffers, self.draw_framebuffer)
            && mask & api::GL_COLOR_BUFFER_BIT != 0
        {
            self.buffers.set_draw(names);
        }
        if let (Some(name), 0) = (saved.read_buffer, self.read_framebuffer)
            && mask & api::GL_PIXEL_MODE_BIT != 0
        {
            self.buffers.set_read(name);
        }
    }
}
