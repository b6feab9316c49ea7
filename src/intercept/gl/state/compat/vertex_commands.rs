//! Commands that set vertices and their attributes, as they are recorded and played back.
//!
//! The rows of the macro come from OpenGL's registry (`build/gl_attributes.rs`).

use crate::backend::gl::driver::api::Gl;

macro_rules! attribute_commands {
    ({ $( $commands:tt )* }
     { $( $vector:ident ($($place:literal: $kind:ty),*) $start:literal $plain:literal; )* }) => {
        /// A command that can be played back.
        #[derive(Clone, Copy, Debug)]
        #[allow(non_camel_case_types, missing_docs)] // Each is the OpenGL command of its name.
        #[repr(u16)]
        pub enum VertexCommand {
            $( $vector, )*
            materialfv,
            materialiv,
        }

        /// Functions by the number of a command. They call the driver with the command's recorded
        /// words.
        static PLAY: &[unsafe fn(&Gl, *const u64)] = &[
            // SAFETY: as the caller of `play` promises.
            $( |gl, words| unsafe { gl.$vector($( *words.add($place) as $kind, )* words.add($start).cast()) }, )*
            // SAFETY: as above.
            |gl, words| unsafe { gl.materialfv(*words as u32, *words.add(1) as u32, words.add(2).cast()) },
            // SAFETY: as above.
            |gl, words| unsafe { gl.materialiv(*words as u32, *words.add(1) as u32, words.add(2).cast()) },
        ];

        /// Flags by the number of a command: true if its components are plain numbers. Packed
        /// numbers, half floats and integers for shaders are not plain.
        static PLAIN: &[bool] = &[$( $plain, )* true, true];
    };
}

include!(concat!(env!("OUT_DIR"), "/gl_attributes.rs"));

/// Calls the driver with a recorded command.
///
/// # Safety
/// The context of `gl` must be current; `words` must be the words that were recorded for the
/// command of this number.
pub unsafe fn play(gl: &Gl, number: u16, words: *const u64) {
    if let Some(command) = PLAY.get(usize::from(number)) {
        // SAFETY: as promised.
        unsafe { command(gl, words) };
    }
}

/// True if the components of the command of this number are plain numbers.
pub fn is_plain(number: u16) -> bool {
    PLAIN.get(usize::from(number)).copied().unwrap_or(false)
}
