//! Commands that set vertices and their attributes, as they are recorded and played back.
//!
//! The rows come from the registry (`build/gl_attributes.rs`).

use crate::backend::gl::driver::api::Gl;

macro_rules! attribute_commands {
    ({ $( $commands:tt )* }
     { $( $vector:ident ($($place:literal: $kind:ty),*) $start:literal $plain:literal; )* }) => {
        /// A command that can be played back.
        #[derive(Clone, Copy, Debug)]
        #[allow(non_camel_case_types, missing_docs)] // Each is the OpenGL command of its name.
        #[repr(u16)]
        pub enum Command {
            $( $vector, )*
            materialfv,
            materialiv,
        }

        /// By the number of a command: calls the driver with its words.
        static PLAY: &[unsafe fn(&Gl, *const u64)] = &[
            // SAFETY: as `play` is promised.
            $( |gl, words| unsafe { gl.$vector($( *words.add($place) as $kind, )* words.add($start).cast()) }, )*
            // SAFETY: as above.
            |gl, words| unsafe { gl.materialfv(*words as u32, *words.add(1) as u32, words.add(2).cast()) },
            // SAFETY: as above.
            |gl, words| unsafe { gl.materialiv(*words as u32, *words.add(1) as u32, words.add(2).cast()) },
        ];

        /// By the number of a command: whether its components are numbers as they are, neither
        /// packed nor of 16 bits nor for integers of shaders.
        static PLAIN: &[bool] = &[$( $plain, )* true, true];
    };
}

include!(concat!(env!("OUT_DIR"), "/gl_attributes.rs"));

/// Calls the driver with a command that was recorded.
///
/// # Safety
/// The context of `gl` must be current; `words` must be what was recorded for the command of this
/// number.
pub unsafe fn play(gl: &Gl, number: u16, words: *const u64) {
    if let Some(command) = PLAY.get(usize::from(number)) {
        // SAFETY: as promised.
        unsafe { command(gl, words) };
    }
}

/// True if the components of the command of this number are numbers as they are.
pub fn is_plain(number: u16) -> bool {
    PLAIN.get(usize::from(number)).copied().unwrap_or(false)
}
