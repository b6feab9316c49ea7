//! Binaries of linked shader programs, cached by the shaders' texts and by the driver.
//!
//! Most drivers have a cache of their own. This cache also saves the parsing of the shaders.

use crate::backend::gl::driver::api::*;
use crate::cache::{self, Cache, RawBytes};
use crate::error::{Error, Result};

/// Cache of program binaries for one driver.
#[derive(Default)]
pub(in crate::backend::gl) struct Binaries {
    cache: Cache,
    /// The driver's name and version; empty if it offers no program binaries.
    driver: String,
}

impl Binaries {
    /// Makes a cache of binaries on `cache`. `can`: the current context supports program binaries.
    pub fn new(gl: &Gl, cache: Cache, can: bool) -> Self {
        let mut formats = 0;
        if can && gl.has_get_program_binary() && gl.has_program_binary() && gl.has_program_parameteri() {
            // SAFETY: a context is current; one value.
            unsafe { gl.get_integerv(GL_NUM_PROGRAM_BINARY_FORMATS, &mut formats) };
        }
        let driver = || [GL_VENDOR, GL_RENDERER, GL_VERSION].map(|name| gl.text(name)).join("\n");
        Self { cache, driver: if formats > 0 { driver() } else { String::new() } }
    }

    /// True if programs are cached. The function that links then has to set the driver's hint that
    /// the binary will be read.
    pub fn are_kept(&self) -> bool {
        !self.driver.is_empty()
    }

    /// Returns the program of these texts, from the cache or made by `link`.
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

/// Makes a program of the data that [`store`] wrote; `None` if the driver refuses it, for example
/// after an update.
fn load(gl: &Gl, bytes: &[u8]) -> Option<u32> {
    let (format, RawBytes(binary)) = cache::decode::<(u32, RawBytes<'_>)>(bytes)?;
    let size = i32::try_from(binary.len()).ok()?;
    let mut linked = 0;
    // SAFETY: a context is current; the driver checks a binary before it uses it, and `size` is the
    // number of its bytes.
    let program = unsafe {
        let program = gl.create_program();
        gl.program_binary(program, format, binary.as_ptr().cast(), size);
        gl.get_programiv(program, GL_LINK_STATUS, &mut linked);
        program
    };
    if linked == 0 {
        // SAFETY: as above. The error of an unknown format is cleared, so that the program does not
        // see it.
        unsafe {
            gl.delete_program(program);
            gl.get_error();
        }
        return None;
    }
    Some(program)
}

/// Returns format and bytes of a program's binary; `None` if the driver offers none.
fn store(gl: &Gl, program: u32) -> Option<Vec<u8>> {
    let (mut length, mut written, mut format) = (0, 0, 0);
    // SAFETY: a context is current; one value.
    unsafe { gl.get_programiv(program, GL_PROGRAM_BINARY_LENGTH, &mut length) };
    let mut binary = vec![0u8; usize::try_from(length).unwrap_or(0)];
    if binary.is_empty() {
        return None;
    }
    // SAFETY: the driver writes at most `length` bytes.
    unsafe { gl.get_program_binary(program, length, &mut written, &mut format, binary.as_mut_ptr().cast()) };
    let binary = binary.get(..usize::try_from(written).ok()?).filter(|binary| !binary.is_empty())?;
    cache::encode(&(format, RawBytes(binary)))
}
