//! Window-space state: what the program has set, and what the driver has.

/// The program's view of its window-space state.
#[derive(Clone, Debug)]
pub struct AppState {
    /// The program's draw framebuffer, 0 = its window.
    pub draw_framebuffer: u32,
    /// The program's read framebuffer.
    pub read_framebuffer: u32,
    /// `glViewport`.
    pub viewport: [i32; 4],
    /// `glScissor`.
    pub scissor: [i32; 4],
    /// `GL_SCISSOR_TEST`.
    pub scissor_test: bool,
    /// `glDrawBuffer` of its window.
    pub draw_buffer: u32,
    /// `glReadBuffer` of its window.
    pub read_buffer: u32,
    /// `glMatrixMode`.
    pub matrix_mode: u32,
}

/// What is really set in the driver, where known; saves redundant calls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriverState {
    /// The real viewport.
    pub viewport: Option<[i32; 4]>,
    /// The real scissor rectangle.
    pub scissor: Option<[i32; 4]>,
    /// Whether the real scissor test is on.
    pub scissor_test: Option<bool>,
}
