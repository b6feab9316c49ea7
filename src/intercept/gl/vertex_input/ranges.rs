//! Boxes around the vertices that draws take from buffers, kept until a buffer changes.
//!
//! Cupola reads a buffer back once for each range that is drawn, and keeps no copy of each upload.
//! This costs no memory, and nothing for vertices that are never drawn as a scene. A read-back
//! waits for the driver. It must not happen for a program that writes its vertices in each frame,
//! so a buffer is read only if it stayed unchanged for a frame.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::state::draw::bounds::Bounds;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::vertex_input::VertexInput;
use crate::intercept::gl::state::vertex_input::vertex_ranges::{Key, Known, Layout, MOST_RANGES, Ranges, Vertices};
use crate::intercept::gl::vertex_input::buffers;

/// Greatest number of bytes of a buffer that are read for a range.
pub const MOST_BYTES: usize = 64 << 20;

/// Returns a box around `vertices` of an array in a buffer.
pub fn around(
    share: &ShareGroup,
    driver: &Driver,
    vertex_input: &mut VertexInput,
    layout: Layout,
    vertices: Vertices,
    indices: u32,
) -> Bounds {
    let buffers = buffers::of(share);
    let Some((version, rests)) = buffers.content(layout.buffer) else { return Bounds::UNKNOWN };
    let (index_version, indices_rest) = match indices {
        0 => (0, true),
        name => match buffers.content(name) {
            Some(content) => content,
            None => return Bounds::UNKNOWN,
        },
    };
    let frame = buffers.frame();
    drop(buffers);
    let (key, versions) = (Key { layout, vertices, indices }, [version, index_version]);
    if let Some(known) = vertex_input.ranges.known.get(&key).filter(|known| known.versions == versions) {
        return known.bounds;
    }
    if !rests || !indices_rest {
        return Bounds::UNKNOWN;
    }
    vertex_input.ranges.follow(frame);
    if vertex_input.ranges.known.len() >= MOST_RANGES && !make_room(share, &mut vertex_input.ranges) {
        return Bounds::UNKNOWN;
    }
    let Some(bytes) = size(&layout, &vertices) else { return Bounds::UNKNOWN };
    if !vertex_input.ranges.afford(bytes) {
        return Bounds::UNKNOWN;
    }
    let bounds = read_bounds(driver.gl, &driver.profile, &layout, &vertices, indices).unwrap_or(Bounds::UNKNOWN);
    vertex_input.ranges.reads += 1;
    vertex_input.ranges.known.insert(key, Known { versions, bounds });
    bounds
}

/// Forgets the ranges of buffers that have changed. Returns true if there is space for a new range
/// then. Does this once per frame.
fn make_room(share: &ShareGroup, ranges: &mut Ranges) -> bool {
    if std::mem::replace(&mut ranges.full, true) {
        return false;
    }
    let mut known = std::mem::take(&mut ranges.known);
    let buffers = buffers::of(share);
    let version = |name: u32| buffers.content(name).map_or(0, |content| content.0);
    known.retain(|key, known| known.versions == [version(key.layout.buffer), version(key.indices)]);
    drop(buffers);
    ranges.known = known;
    ranges.full = ranges.known.len() >= MOST_RANGES;
    !ranges.full
}

/// Returns the approximate number of bytes to read.
fn size(layout: &Layout, vertices: &Vertices) -> Option<usize> {
    match vertices {
        Vertices::Range { count, .. } => usize::try_from(*count).ok()?.checked_mul(layout.stride),
        Vertices::Elements { count, .. } => usize::try_from(*count).ok()?.checked_mul(4 + layout.stride),
    }
}

fn read_bounds(gl: &Gl, profile: &Profile, layout: &Layout, vertices: &Vertices, indices: u32) -> Option<Bounds> {
    match *vertices {
        Vertices::Range { first, count } => {
            let first = usize::try_from(first).ok()?;
            in_buffer(gl, profile, layout, first..first + usize::try_from(count).ok()?)
        }
        Vertices::Elements { count, kind, indices: offset, base } => {
            let width = index_width(kind)?;
            let bytes = read(gl, profile, indices, offset as usize, usize::try_from(count).ok()?.checked_mul(width)?)?;
            let number = |index: usize| {
                // SAFETY: inside the bytes that were read.
                i64::from(unsafe { index_at(bytes.as_ptr(), kind, index) }) + i64::from(base)
            };
            let count = bytes.len() / width;
            if (0..count).any(|index| number(index) < 0) {
                return None;
            }
            in_buffer(gl, profile, layout, (0..count).map(|index| number(index) as usize))
        }
    }
}

/// Reads vertices with these numbers from the buffer of `layout`. Returns a box around them.
pub fn in_buffer(
    gl: &Gl,
    profile: &Profile,
    layout: &Layout,
    numbers: impl Iterator<Item = usize> + Clone,
) -> Option<Bounds> {
    let (least, greatest) = (numbers.clone().min()?, numbers.clone().max()?);
    let start = layout.start.checked_add(least.checked_mul(layout.stride)?)?;
    let size = (greatest - least).checked_mul(layout.stride)?.checked_add(layout.size())?;
    let bytes = read(gl, profile, layout.buffer, start, size)?;
    // SAFETY: the vertices of these numbers lie in the bytes that were read.
    Some(unsafe { in_memory(layout, bytes.as_ptr(), numbers.map(|number| number - least)) })
}

/// Returns a box around the vertices with these numbers in memory.
///
/// # Safety
/// The array that begins at `start` must contain these vertices.
pub unsafe fn in_memory(layout: &Layout, start: *const u8, numbers: impl Iterator<Item = usize>) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for number in numbers {
        // SAFETY: as promised.
        bounds.add(unsafe { layout.position(start.add(number * layout.stride)) });
        if bounds.known().is_none() {
            break;
        }
    }
    bounds
}

/// Returns the number of bytes of an index.
pub fn index_width(kind: u32) -> Option<usize> {
    match kind {
        api::GL_UNSIGNED_BYTE => Some(1),
        api::GL_UNSIGNED_SHORT => Some(2),
        api::GL_UNSIGNED_INT => Some(4),
        _ => None,
    }
}

/// Returns the index with this number. The indices may be unaligned.
///
/// # Safety
/// `indices` must hold more than `number` indices of the type `kind`, and `kind` must have a width.
pub unsafe fn index_at(indices: *const u8, kind: u32, number: usize) -> u32 {
    // SAFETY: as promised.
    unsafe {
        match kind {
            api::GL_UNSIGNED_BYTE => indices.add(number).read().into(),
            api::GL_UNSIGNED_SHORT => indices.cast::<u16>().add(number).read_unaligned().into(),
            _ => indices.cast::<u32>().add(number).read_unaligned(),
        }
    }
}

/// Returns `size` bytes of a buffer from `start` on. `None`: the buffer is too small or cannot be
/// read now.
pub fn read(gl: &Gl, profile: &Profile, buffer: u32, start: usize, size: usize) -> Option<Vec<u8>> {
    if size == 0 || size > MOST_BYTES {
        return None;
    }
    let (mut bound, mut whole, mut mapped) = (0, 0, 0);
    // SAFETY: queries, and a read of bytes that the buffer has; the binding is put back.
    unsafe {
        gl.get_integerv(api::GL_ARRAY_BUFFER_BINDING, &mut bound);
        gl.bind_buffer(api::GL_ARRAY_BUFFER, buffer);
        gl.get_buffer_parameteriv(api::GL_ARRAY_BUFFER, api::GL_BUFFER_SIZE, &mut whole);
        gl.get_buffer_parameteriv(api::GL_ARRAY_BUFFER, api::GL_BUFFER_MAPPED, &mut mapped);
        // The driver may have truncated the size of a larger buffer.
        let whole = usize::try_from(whole).ok().filter(|whole| *whole < i32::MAX as usize).unwrap_or(0);
        let inside = start.checked_add(size).is_some_and(|end| end <= whole);
        let mut bytes = None;
        if inside && mapped == 0 {
            bytes = if profile.es { mapped_bytes(gl, start, size) } else { copied_bytes(gl, start, size) };
        }
        gl.bind_buffer(api::GL_ARRAY_BUFFER, bound as u32);
        bytes
    }
}

/// # Safety
/// The bound buffer must have these bytes, and must not be mapped.
unsafe fn copied_bytes(gl: &Gl, start: usize, size: usize) -> Option<Vec<u8>> {
    let mut bytes = vec![0u8; size];
    // SAFETY: as promised; there is room for them.
    unsafe {
        gl.get_buffer_sub_data(api::GL_ARRAY_BUFFER, start as isize, size as isize, bytes.as_mut_ptr().cast());
    }
    gl.has_get_buffer_sub_data().then_some(bytes)
}

/// Reads the bytes by mapping them, for OpenGL ES, which has no command to copy them.
///
/// # Safety
/// As for [`copied_bytes`].
unsafe fn mapped_bytes(gl: &Gl, start: usize, size: usize) -> Option<Vec<u8>> {
    // SAFETY: as promised. The buffer is unmapped again before other code can use it.
    unsafe {
        let at = gl.map_buffer_range(api::GL_ARRAY_BUFFER, start as isize, size as isize, api::GL_MAP_READ_BIT);
        if at.is_null() {
            return None;
        }
        let bytes = std::slice::from_raw_parts(at.cast::<u8>(), size).to_vec();
        (gl.unmap_buffer(api::GL_ARRAY_BUFFER) != 0).then_some(bytes)
    }
}

/// True if an index may restart the primitive instead of naming a vertex.
pub fn restarts(driver: &Driver) -> bool {
    let (gl, version) = (driver.gl, driver.profile.version);
    let on = |switch: u32| driver.known_state.is_on(gl, switch);
    if driver.profile.es {
        version >= 30 && on(api::GL_PRIMITIVE_RESTART_FIXED_INDEX)
    } else {
        // Before OpenGL 3.1 primitive restart is an extension, with switches of its own.
        version < 31 || on(api::GL_PRIMITIVE_RESTART) || (version >= 43 && on(api::GL_PRIMITIVE_RESTART_FIXED_INDEX))
    }
}
