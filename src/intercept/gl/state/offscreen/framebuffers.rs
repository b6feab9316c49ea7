//! The framebuffers that the program draws into, their attachments, and the framebuffers of Cupola
//! that replace them.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::own_names;
use crate::backend::gl::objects::framebuffers::FramebufferBindings;
use crate::intercept::gl::state::offscreen::images::{self, Image, Name};
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::scene::viewport::alone::Viewports;

/// Greatest number of colour attachments that are followed.
pub const COLOURS: usize = 8;

/// Images that are attached to a framebuffer: colours, depth, stencil.
pub type Attachments = [Option<Name>; COLOURS + 2];

/// Indices of depth and stencil in [`Attachments`].
const DEPTH: usize = COLOURS;
const STENCIL: usize = COLOURS + 1;

/// A framebuffer of the program.
pub struct Framebuffer {
    /// Its OpenGL name.
    pub name: u32,
    /// Attached images, if they are `known`.
    pub attachments: Attachments,
    /// True if nothing was changed since the driver was asked for `attachments`.
    pub known: bool,
    /// Reason why nothing in the framebuffer can be drawn once per view.
    pub obstacle: Option<Obstacle>,
    /// Framebuffer of Cupola with the view copies of the attached images; 0 = none.
    pub view_copy: u32,
    /// True if a scene was drawn to the framebuffer since it was cleared.
    pub has_scene: bool,
    /// Viewports that scenes are drawn to.
    pub viewports: Viewports,
}

impl Framebuffer {
    /// Returns a framebuffer of which nothing is known.
    pub fn new(name: u32) -> Self {
        Self {
            name,
            attachments: [None; COLOURS + 2],
            known: false,
            obstacle: None,
            view_copy: 0,
            has_scene: false,
            viewports: Viewports::default(),
        }
    }

    /// Returns the attached images.
    pub fn images(&self) -> impl Iterator<Item = Name> + '_ {
        self.attachments.iter().flatten().copied()
    }

    /// True if any attached image is drawn once per view. `images` are the followed images.
    pub fn has_view_copies(&self, images: &[Image]) -> bool {
        let has_view_copy = |name: Name| images.iter().any(|image| image.name == name && image.view_copy.is_some());
        self.known && self.obstacle.is_none() && self.images().any(has_view_copy)
    }

    /// Returns the attached depth image.
    pub fn depth(&self) -> Option<Name> {
        self.attachments[DEPTH]
    }

    /// Returns the attached colour images.
    pub fn colours(&self) -> impl Iterator<Item = Name> + '_ {
        self.attachments[..COLOURS].iter().flatten().copied()
    }

    /// Asks the driver for the attached images, and adds new images to `images`. The framebuffer
    /// must be bound for drawing. Errors may be left.
    pub fn examine(&mut self, gl: &Gl, images: &mut Vec<Image>) {
        self.known = true;
        self.obstacle = None;
        let mut attachments = [None; COLOURS + 2];
        let mut size = None;
        for (index, attachment) in attachments.iter_mut().enumerate() {
            match look(gl, point(index)) {
                Attached::Nothing => {}
                Attached::Other(reason) => self.obstacle = self.obstacle.take().or(Some(reason.into())),
                Attached::Image(image) => {
                    *attachment = Some(image.name);
                    if size.is_some_and(|size| size != image.size) {
                        self.obstacle = Some("its attachments have several sizes".into());
                    }
                    size = Some(image.size);
                    if !images.iter().any(|known| known.name == image.name) {
                        images.push(*image);
                    }
                }
            }
        }
        if attachments != self.attachments {
            self.attachments = attachments;
            self.viewports = Viewports::default();
            self.destroy_view_copy(gl);
        }
    }

    /// Makes the framebuffer of Cupola. All attached images must have view copies. Bindings are put
    /// back; errors may be left. Returns false if the driver gives no such framebuffer.
    pub fn make_view_copy(&mut self, gl: &Gl, view_copy_of: impl Fn(Name) -> Option<u32>) -> bool {
        let mut buffers = [api::GL_NONE; COLOURS];
        // SAFETY: makes an object of Cupola; the bindings are put back.
        let complete = unsafe {
            let bindings = FramebufferBindings::save(gl);
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, self.name);
            for (i, buffer) in buffers.iter_mut().enumerate() {
                let mut value = 0;
                gl.get_integerv(api::GL_DRAW_BUFFER0 + i as u32, &mut value);
                *buffer = value as u32;
            }
            if self.view_copy == 0 {
                self.view_copy = own_names::framebuffer(gl);
            }
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, self.view_copy);
            for (index, attachment) in self.attachments.iter().enumerate() {
                if let Some(renderbuffer) = attachment.and_then(&view_copy_of) {
                    images::attach(gl, point(index), Name::Renderbuffer(renderbuffer));
                }
            }
            gl.draw_buffers(COLOURS as i32, buffers.as_ptr());
            let status = gl.check_framebuffer_status(api::GL_DRAW_FRAMEBUFFER);
            bindings.restore(gl);
            status == api::GL_FRAMEBUFFER_COMPLETE && gl.get_error() == api::GL_NO_ERROR
        };
        if !complete {
            self.destroy_view_copy(gl);
        }
        complete
    }

    /// Deletes the framebuffer of Cupola.
    pub fn destroy_view_copy(&mut self, gl: &Gl) {
        let name = std::mem::take(&mut self.view_copy);
        if name != 0 {
            // SAFETY: an object of Cupola.
            unsafe { gl.delete_framebuffers(1, &name) };
        }
    }
}

/// Returns the attachment point at an index of [`Attachments`].
fn point(index: usize) -> u32 {
    match index {
        DEPTH => api::GL_DEPTH_ATTACHMENT,
        STENCIL => api::GL_STENCIL_ATTACHMENT,
        colour => api::GL_COLOR_ATTACHMENT0 + colour as u32,
    }
}

/// Object that is attached at a point.
enum Attached {
    Nothing,
    Image(Box<Image>),
    Other(&'static str),
}

/// Examines an attachment point of the framebuffer that is bound for drawing.
fn look(gl: &Gl, point: u32) -> Attached {
    let ask = |what: u32| {
        let mut answer = 0;
        // SAFETY: writes one integer about the program's framebuffer.
        unsafe { gl.get_framebuffer_attachment_parameteriv(api::GL_DRAW_FRAMEBUFFER, point, what, &mut answer) };
        answer
    };
    let name = |()| ask(api::GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME) as u32;
    let image = match ask(api::GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE) as u32 {
        api::GL_RENDERBUFFER => Image::examine_renderbuffer(gl, name(())),
        api::GL_TEXTURE => {
            if ask(api::GL_FRAMEBUFFER_ATTACHMENT_TEXTURE_CUBE_MAP_FACE) != 0 {
                return Attached::Other("it is a face of a cube map");
            }
            if ask(api::GL_FRAMEBUFFER_ATTACHMENT_LAYERED) != 0 {
                return Attached::Other("it has layers");
            }
            Image::examine_texture(gl, name(()), ask(api::GL_FRAMEBUFFER_ATTACHMENT_TEXTURE_LEVEL))
        }
        _ => return Attached::Nothing,
    };
    image.map_or(Attached::Other("it is a layer of a texture, or the driver does not tell its size"), |image| {
        Attached::Image(Box::new(image))
    })
}
