//! Read-back of the pictures that are published. Each frame is read into a buffer, which is read
//! when the device has filled it.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::own_names;
use crate::backend::gl::{OwnFramebuffer, Target};
use crate::correct::LowerLeftRect;
use crate::intercept::process::publishing;
use crate::ring::{Format, Pictures, Shape, Stamp};
use crate::runtime::session::Session;
use std::ffi::c_void;
use std::sync::Arc;

/// Greatest number of frames that are read back at the same time. Other frames are left out.
const FRAMES: usize = 3;

/// Duration of one wait for the device, in nanoseconds.
const WAIT: u64 = 1_000_000_000;

/// A frame that is being read back.
#[derive(Clone, Copy, Debug, Default)]
struct Transfer {
    buffer: u32,
    /// Address of its fence; 0 = no frame is being read back.
    fence: usize,
    stamp: Stamp,
}

/// Source of the pictures of one window.
pub struct Publishing {
    /// Plan of the window; `None`: the window is not corrected.
    pub(in crate::intercept::gl) session: Option<Arc<Session>>,
    /// Size of the window.
    pub(in crate::intercept::gl) window: (u32, u32),
    /// Version of the rig of the last frame that was read.
    pub(in crate::intercept::gl) version: Option<u64>,
    shapes: Vec<Shape>,
    /// Framebuffer and rectangle from which each picture is read.
    places: Vec<Target>,
    /// Targets of outputs that are drawn outside the window, by their index in the plan. The
    /// rectangle is empty if the output is not drawn.
    pub(in crate::intercept::gl) targets: Vec<Target>,
    canvases: Vec<OwnFramebuffer>,
    /// Format of the published pixels.
    format: Format,
    /// First byte of each picture.
    offsets: Vec<usize>,
    bytes: usize,
    transfers: [Transfer; FRAMES],
    /// Number of the next transfer; `oldest`: number of the oldest transfer that is not finished.
    next: usize,
    oldest: usize,
    /// Memory for the pictures, if the context has no buffers and fences.
    memory: Option<Vec<u8>>,
    /// True if the driver writes to the memory of the readers.
    is_direct: bool,
}

/// How pixels are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// To memory, and from there to that of the readers.
    Copied,
    /// To buffers, which the device fills meanwhile.
    Buffers,
    /// To the memory of the readers. Alpha must have the largest value.
    Direct,
}

impl Publishing {
    /// Returns the source of a window's pictures. `pictures`: name and rectangle of each picture in
    /// the window. `beside`: name, index in the plan, and size of each picture that is drawn
    /// outside the window. `way`: how they are read. `format`: of the published pixels.
    pub fn new(
        gl: &Gl,
        (session, window): (Option<Arc<Session>>, (u32, u32)),
        pictures: impl Iterator<Item = (String, LowerLeftRect)>,
        beside: impl Iterator<Item = (String, usize, (u32, u32))>,
        (way, format): (Way, Format),
    ) -> Self {
        let mut new = Self {
            session,
            window,
            version: None,
            shapes: Vec::new(),
            places: Vec::new(),
            targets: Vec::new(),
            canvases: Vec::new(),
            format,
            offsets: Vec::new(),
            bytes: 0,
            transfers: [Transfer::default(); FRAMES],
            next: 0,
            oldest: 0,
            memory: None,
            is_direct: way == Way::Direct,
        };
        for (name, viewport) in pictures {
            new.add(name, Target { framebuffer: 0, viewport });
        }
        for (name, index, size) in beside {
            let viewport = LowerLeftRect::of_size(size);
            let of_canvas = if format == Format::Rgba16 { api::GL_RGBA16 } else { api::GL_RGBA8 };
            let canvas = OwnFramebuffer::with_format(gl, (viewport.width, viewport.height), of_canvas);
            let target = Target { framebuffer: canvas.framebuffer, viewport };
            let nowhere = Target { framebuffer: canvas.framebuffer, viewport: LowerLeftRect::default() };
            new.targets.resize(new.targets.len().max(index + 1), nowhere);
            new.targets[index] = target;
            new.canvases.push(canvas);
            new.add(name, target);
        }
        match way {
            Way::Copied => new.memory = Some(vec![0; new.bytes]),
            Way::Buffers => new.make_buffers(gl),
            Way::Direct => {}
        }
        new
    }

    fn add(&mut self, name: String, place: Target) {
        let LowerLeftRect { width, height, .. } = place.viewport;
        // An output outside of the window has nothing to read.
        if let (Ok(width @ 1..), Ok(height @ 1..)) = (u32::try_from(width), u32::try_from(height)) {
            self.shapes.push(Shape { name, size: (width, height), format: self.format });
            self.places.push(place);
            self.offsets.push(self.bytes);
            self.bytes += width as usize * height as usize * self.format.pixel_bytes();
        }
    }

    fn make_buffers(&mut self, gl: &Gl) {
        for transfer in &mut self.transfers {
            transfer.buffer = own_names::buffer(gl);
            bound(gl, transfer.buffer, || {
                let size = self.bytes as isize;
                // SAFETY: gives storage to a buffer of Cupola, which is bound.
                unsafe { gl.buffer_data(api::GL_PIXEL_PACK_BUFFER, size, std::ptr::null(), api::GL_STREAM_READ) };
            });
        }
    }

    /// True if there is anything to publish.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// Reads the pictures of a frame. They are published when the device has copied them. Pixel
    /// storage must be without gaps. The bindings of pixel buffer and read framebuffer are not put
    /// back.
    pub fn read(&mut self, gl: &Gl, stamp: Stamp) {
        if self.is_direct {
            publishing::publish(&self.shapes, stamp, |pictures| self.read_directly(gl, pictures));
            return;
        }
        if let Some(mut memory) = self.memory.take() {
            self.read_to(gl, 0, memory.as_mut_ptr().cast());
            publishing::publish(&self.shapes, stamp, |pictures| self.write(pictures, &memory));
            self.memory = Some(memory);
            return;
        }
        if self.next - self.oldest == FRAMES {
            publishing::left_out();
            return;
        }
        let buffer = self.transfers[self.next % FRAMES].buffer;
        self.read_to(gl, buffer, std::ptr::null_mut());
        // SAFETY: makes a fence of Cupola.
        let fence = unsafe { gl.fence_sync(api::GL_SYNC_GPU_COMMANDS_COMPLETE, 0) };
        self.transfers[self.next % FRAMES] = Transfer { buffer, fence: fence.addr(), stamp };
        self.next += 1;
    }

    /// Reads into the memory of the readers, the highest row first.
    fn read_directly(&self, gl: &Gl, pictures: &mut Pictures<'_>) {
        let mut inverted = 0;
        // SAFETY: a setting of the extension, which the driver has, and which is put back.
        unsafe {
            gl.get_integerv(api::GL_PACK_INVERT_MESA, &mut inverted);
            gl.pixel_storei(api::GL_PACK_INVERT_MESA, 1);
            gl.bind_buffer(api::GL_PIXEL_PACK_BUFFER, 0);
        }
        for (number, place) in self.places.iter().enumerate() {
            let LowerLeftRect { width, height, .. } = place.viewport;
            let bytes = width as usize * height as usize * self.format.pixel_bytes();
            if let Some((to, _)) = pictures.memory(number).filter(|(_, room)| *room >= bytes) {
                self.read_place(gl, place, to.cast());
            }
        }
        // SAFETY: as above.
        unsafe { gl.pixel_storei(api::GL_PACK_INVERT_MESA, inverted) };
    }

    /// Reads into a buffer or, if `buffer` is 0, into memory from `to` on.
    fn read_to(&self, gl: &Gl, buffer: u32, to: *mut c_void) {
        // SAFETY: a buffer of Cupola, or none.
        unsafe { gl.bind_buffer(api::GL_PIXEL_PACK_BUFFER, buffer) };
        for (place, offset) in self.places.iter().zip(&self.offsets) {
            self.read_place(gl, place, to.wrapping_byte_add(*offset));
        }
    }

    /// Reads a picture to `to`, which counts from the bound buffer's start, if one is bound. It must have room for it.
    fn read_place(&self, gl: &Gl, place: &Target, to: *mut c_void) {
        let kind = if self.format == Format::Rgba16 { api::GL_UNSIGNED_SHORT } else { api::GL_UNSIGNED_BYTE };
        let LowerLeftRect { x, y, width, height } = place.viewport;
        // SAFETY: the buffer, or the memory, has room for the picture.
        unsafe {
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, place.framebuffer);
            gl.read_pixels(x, y, width, height, api::GL_RGBA, kind, to);
        }
    }

    /// Publishes the frames that the device has copied; `all`: waits for the others, too.
    pub fn publish(&mut self, gl: &Gl, all: bool) {
        while self.oldest < self.next {
            let Transfer { buffer, fence, stamp } = self.transfers[self.oldest % FRAMES];
            let fence: *const c_void = std::ptr::with_exposed_provenance(fence);
            let (flags, wait) = if all { (api::GL_SYNC_FLUSH_COMMANDS_BIT, WAIT) } else { (0, 0) };
            // SAFETY: a fence of Cupola.
            match unsafe { gl.client_wait_sync(fence, flags, wait) } {
                api::GL_ALREADY_SIGNALED | api::GL_CONDITION_SATISFIED => self.publish_buffer(gl, buffer, stamp),
                api::GL_TIMEOUT_EXPIRED if all => continue,
                api::GL_TIMEOUT_EXPIRED => break,
                _ => publishing::left_out(),
            }
            // SAFETY: as above; the fence is not used any more.
            unsafe { gl.delete_sync(fence) };
            self.oldest += 1;
        }
    }

    fn publish_buffer(&self, gl: &Gl, buffer: u32, stamp: Stamp) {
        bound(gl, buffer, || {
            let size = self.bytes as isize;
            // SAFETY: a buffer of Cupola of that size is bound, and stays mapped while its bytes
            // are borrowed.
            unsafe {
                let at = gl.map_buffer_range(api::GL_PIXEL_PACK_BUFFER, 0, size, api::GL_MAP_READ_BIT);
                if at.is_null() {
                    publishing::left_out();
                    return;
                }
                let bytes = std::slice::from_raw_parts(at.cast::<u8>(), self.bytes);
                publishing::publish(&self.shapes, stamp, |pictures| self.write(pictures, bytes));
                gl.unmap_buffer(api::GL_PIXEL_PACK_BUFFER);
            }
        });
    }

    fn write(&self, pictures: &mut Pictures<'_>, bytes: &[u8]) {
        for (number, (shape, offset)) in self.shapes.iter().zip(&self.offsets).enumerate() {
            let row = shape.size.0 as usize * self.format.pixel_bytes();
            let pixels = &bytes[*offset..offset + row * shape.size.1 as usize];
            // OpenGL's first row is the lowest.
            (0..).zip(pixels.chunks_exact(row).rev()).for_each(|(y, row)| pictures.row(number, y, row));
        }
    }

    /// Publishes the frames that are being read back, and deletes everything. The context must be
    /// current.
    pub fn destroy(mut self, gl: &Gl) {
        self.publish(gl, true);
        for transfer in self.transfers.iter().filter(|transfer| transfer.buffer != 0) {
            // SAFETY: a buffer of Cupola.
            unsafe { gl.delete_buffers(1, &transfer.buffer) };
        }
        self.canvases.into_iter().for_each(|canvas| canvas.destroy(gl));
    }
}

/// Runs `work` with a buffer bound for reads of pixels.
fn bound(gl: &Gl, buffer: u32, work: impl FnOnce()) {
    let mut before = 0;
    // SAFETY: a binding, which is put back.
    unsafe {
        gl.get_integerv(api::GL_PIXEL_PACK_BUFFER_BINDING, &mut before);
        gl.bind_buffer(api::GL_PIXEL_PACK_BUFFER, buffer);
        work();
        gl.bind_buffer(api::GL_PIXEL_PACK_BUFFER, before as u32);
    }
}
