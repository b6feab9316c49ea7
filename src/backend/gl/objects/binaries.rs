//! Linked programs of shaders as the driver gives them out, kept by their texts and by the driver.
//!
//! Drivers keep what they compile, too, most of them; what is saved beside that is reading the
//! shaders' language.

use crate::backend::gl::driver::api::*;
use crate::cache::{self, Cache, RawBytes};
use crate::error::{Error, Result};

/// Source and destination of linked programs.
#[derive(Default)]
pub(in crate::backend::gl) struct Binaries {
    cache: Cache,
    /// The driver's name and version; empty where it gives out no programs.
    driver: String,
}

impl Binaries {
    /// Kept by `cache`, if the current context `can` give programs out.
    pub fn new(gl: &Gl, cache: Cache, can: bool) -> Self {
        let mut formats = 0;
        if can && gl.has_get_program_binary() && gl.has_program_binary() && gl.has_program_parameteri() {
            // SAFETY: a context is current; one value.
            unsafe { gl.get_integerv(GL_NUM_PROGRAM_BINARY_FORMATS, &mut formats) };
        }
        let driver = || [GL_VENDOR, GL_RENDERER, GL_VERSION].map(|name| gl.text(name)).join("\n");
        Self { cache, driver: if formats > 0 { driver() } else { String::new() } }
    }

    /// True if a program may be asked for after `link` made it, so that it has to say so to the
    /// driver.
    pub fn are_kept(&self) -> bool {
        !self.driver.is_empty()
    }

    /// The program of these texts by `link`, or what was kept of it.
    ///
    /// # Errors
    /// Those of `link`.
    pub fn program(&self, gl: &Gl, texts: [&str; 2], link: impl FnOnce() -> Result<u32>) -> Result<u32> {
        if !self.are_kept() {
            return link();
        }
        let key = (&self.driver, texts);
        self.cache.cached_as::<_, Error>("program", &key, |bytes| load(gl, bytes), |program| store(gl, *program), link)
    }
}

/// A program of what [`store`] wrote; `None` where the driver does not take it, as after it was
/// updated.
fn load(gl: &Gl, bytes: &[u8]) -> Option<u32> {
    let (format, RawBytes(binary)) = cache::decode::<(u32, RawBytes<'_>)>(bytes)?;
    let size = i32::try_from(binary.len()).ok()?;
    let mut linked = 0;
    // SAFETY: a context is current; the driver looks at its binaries before it believes them, and
    // has as many bytes as are said.
    let program = unsafe {
        let program = gl.create_program();
        gl.program_binary(program, format, binary.as_ptr().cast(), size);
        gl.get_programiv(program, GL_LINK_STATUS, &mut linked);
        program
    };
    if linked == 0 {
        // SAFETY: as above. What it does not know is an error that is nobody's.
        unsafe {
            gl.delete_program(program);
            gl.get_error();
        }
        return None;
    }
    Some(program)
}

/// Returns format and bytes of a program; `None` where the driver does not give it out.
fn store(gl: &Gl, program: u32) -> Option<Vec<u8>> {
    let (mut length, mut written, mut format) = (0, 0, 0);
    // SAFETY: a context is current; one value.
    unsafe { gl.get_programiv(program, GL_PROGRAM_BINARY_LENGTH, &mut length) };
    let mut binary = vec![0u8; usize::try_from(length).unwrap_or(0)];
    if binary.is_empty() {
        return None;
    }
    // SAFETY: the driver writes no more bytes than there are.
    unsafe { gl.get_program_binary(program, length, &mut written, &mut format, binary.as_mut_ptr().cast()) };
    let binary = binary.get(..usize::try_from(written).ok()?).filter(|binary| !binary.is_empty())?;
    cache::encode(&(format, RawBytes(binary)))
}
