//! What the shaders of a draw write: atomic counters and storage [`buffers`], and [`images`]. A
//! draw that is issued several times changes them once: each time begins with the same values, so
//! that those of the last time remain, which is the program's own picture.

pub mod buffers;
pub mod images;

use self::buffers::{Bound, KeptBuffer};
use self::images::{BoundImage, KeptImage};
use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::values::integer;
use crate::intercept::gl::context::errors::drop_errors;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::shader::programs;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::programs::{ChangedBuffer, Program};

/// Runs `work` with the programs whose shaders draw.
fn with_programs<T>(
    share: &ShareGroup,
    shaders: &Shaders,
    work: impl FnOnce(&mut dyn Iterator<Item = &Program>) -> T,
) -> T {
    if shaders.used() != 0 || shaders.bound_pipeline() == 0 {
        return work(&mut shaders.program().into_iter().map(|program| &**program));
    }
    let stages = shaders.stages();
    let names = stages.last_first().into_iter().chain([stages.fragment()]);
    let programs: Vec<_> = names.filter_map(|name| programs::record(share, name)).collect();
    work(&mut programs.iter().map(|program| &**program))
}

/// True if the present shaders may change something.
pub fn any(share: &ShareGroup, shaders: &Shaders) -> bool {
    let changes = |program: &Program| !program.changed_buffers.is_empty() || !program.written_images.is_empty();
    if shaders.used() != 0 || shaders.bound_pipeline() == 0 {
        return shaders.program().is_some_and(|program| changes(program));
    }
    let stages = shaders.stages();
    let mut names = stages.last_first().into_iter().chain([stages.fragment()]);
    names.any(|name| programs::record(share, name).is_some_and(|program| changes(&program)))
}

/// What the present shaders change.
#[derive(Default)]
pub struct Changed {
    buffers: Vec<ChangedBuffer>,
    images: Vec<BoundImage>,
}

impl Changed {
    /// Returns what the present shaders change.
    pub fn present(share: &ShareGroup, driver: &mut Driver, shaders: &Shaders) -> Self {
        if !any(share, shaders) {
            return Self::default();
        }
        let (mut buffers, mut written) = (Vec::new(), Vec::new());
        with_programs(share, shaders, |programs| {
            for program in programs {
                buffers.extend(&program.changed_buffers);
                written.extend(&program.written_images);
            }
        });
        // Stages that share counters may need different parts of them: the largest comes first.
        buffers.sort_unstable_by(|one: &ChangedBuffer, other| other.cmp(one));
        buffers.dedup_by(|next, kept| match (&next, &kept) {
            (ChangedBuffer::Counters { binding: next, .. }, ChangedBuffer::Counters { binding: kept, .. }) => {
                next == kept
            }
            _ => next == kept,
        });
        driver.take_errors();
        let images = written.into_iter().filter_map(|image| images::bound(driver.gl, image)).collect();
        drop_errors(driver.gl);
        Self { buffers, images }
    }

    /// True if they change nothing.
    pub fn is_empty(&self) -> bool {
        self.buffers.is_empty() && self.images.is_empty()
    }
}

/// Values of buffers and images before a draw.
pub struct KeptValues {
    buffers: Vec<KeptBuffer>,
    images: Vec<KeptImage>,
}

impl KeptValues {
    /// Keeps what a draw changes.
    pub fn keep(gl: &Gl, changed: &Changed) -> Self {
        let mut kept = Self { buffers: Vec::new(), images: Vec::new() };
        with_copies(gl, || {
            let bound = changed.buffers.iter().filter_map(|buffer| Bound::of(gl, *buffer));
            kept.buffers.extend(bound.filter_map(|bound| bound.keep(gl)));
            for image in &changed.images {
                match image {
                    BoundImage::Buffer(bound) => kept.buffers.extend(bound.keep(gl)),
                    BoundImage::Texture(texture) => kept.images.extend(KeptImage::keep(gl, *texture)),
                }
            }
        });
        kept
    }

    /// Puts the values back.
    pub fn put_back(&self, gl: &Gl) {
        with_copies(gl, || {
            self.buffers.iter().for_each(|kept| kept.put_back(gl));
            self.images.iter().for_each(|kept| kept.put_back(gl));
        });
    }

    /// Deletes the copies.
    pub fn delete(self, gl: &Gl) {
        self.buffers.into_iter().for_each(|kept| kept.delete(gl));
        self.images.into_iter().for_each(|kept| kept.delete(gl));
    }
}

/// Runs `work`, which copies values. The bindings for copies are restored.
fn with_copies(gl: &Gl, work: impl FnOnce()) {
    let before = [
        (api::GL_COPY_READ_BUFFER, integer(gl, api::GL_COPY_READ_BUFFER_BINDING)),
        (api::GL_COPY_WRITE_BUFFER, integer(gl, api::GL_COPY_WRITE_BUFFER_BINDING)),
    ];
    // SAFETY: the barrier makes the values of earlier draws visible to the copies.
    unsafe { gl.memory_barrier(api::GL_BUFFER_UPDATE_BARRIER_BIT | api::GL_TEXTURE_UPDATE_BARRIER_BIT) };
    work();
    for (target, buffer) in before {
        // SAFETY: a buffer that was bound.
        unsafe { gl.bind_buffer(target, buffer as u32) };
    }
}
