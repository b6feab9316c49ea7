//! The embedded form for Vulkan: the program draws the views into images, and has their correction
//! recorded into its own command buffers.

use super::matrices::{check_planes, joined, no_view, projection, rotation, vectors_of_view};
use super::{Planner, check_request, log_plan};
use crate::backend::vk::ash::vk;
use crate::backend::vk::{Api, Recording, SourceImage, Surface, TargetImage, Timing, VkBackend};
use crate::correct::{Arrangement, ImageSize, Plan, UpperLeftRect};
use crate::error::{Error, ErrorKind, Result};
use crate::rig::Rig;
use crate::runtime::session::{Extras, Session};
use glam::{DMat4, DVec4};

/// Greatest number of frames in flight.
pub const MOST_FRAMES: usize = 16;

/// Options of a new [`EmbeddedVulkan`].
#[derive(Clone, Copy, Debug)]
pub struct VulkanOptions {
    /// Width and height in pixels of the picture that all outputs share, 1…16384.
    pub size: (u32, u32),
    /// Family of the queues to which the command buffers are submitted.
    pub queue_family: u32,
    /// Number of frames in flight, 1…[`MOST_FRAMES`]. Each has images of its own.
    pub frames: usize,
    /// Format of the target images.
    pub target_format: vk::Format,
    /// Format of the images that Cupola creates for the views; `UNDEFINED`: the program brings its
    /// own.
    pub view_format: vk::Format,
    /// Arrangement of the views in their images.
    pub arrangement: Arrangement,
    /// True if the program's depth is 1 at the near plane and 0 at the far one.
    pub reversed_depth: bool,
}

/// Facts that a program needs to draw one view on Vulkan.
#[derive(Clone, Debug, PartialEq)]
pub struct VulkanView {
    /// Name: `front`, `left`, `projector-3` …
    pub name: String,
    /// Camera axes of the program → axes of the view.
    pub rotation: DMat4,
    /// Axes of the view → Vulkan's clip space: x right, y down, depth 0…1.
    pub frustum: DMat4,
    /// Index of its image among those of a frame.
    pub image: usize,
    /// Layer of that image.
    pub layer: usize,
    /// Rectangle in that image, in texels.
    pub tile: UpperLeftRect,
}

/// A rig on a program's Vulkan device.
///
/// Nothing is submitted, and no queue is used: all work is recorded into the program's command
/// buffers. Methods that change something, except [`EmbeddedVulkan::record`], may be called only
/// while no command buffer is pending that was recorded with it. Dropping it destroys nothing:
/// [`EmbeddedVulkan::destroy`] does.
pub struct EmbeddedVulkan {
    api: Api,
    rig: Rig,
    options: VulkanOptions,
    planner: Planner,
    session: Session,
    plan: Plan,
    backend: VkBackend,
    /// Images that Cupola created.
    surface: Option<Surface>,
    frames: u64,
}

impl EmbeddedVulkan {
    /// Plans `rig` and creates everything that does not depend on images of the program.
    ///
    /// # Errors
    /// Errors of the planner and of the driver; [`ErrorKind::InvalidArgument`] for a number out of
    /// range, a queue family that cannot draw, or a rig that corrects nothing.
    pub fn new(api: Api, rig: &Rig, options: VulkanOptions) -> Result<Self> {
        Self::planned(api, rig, options, Session::new)
    }

    /// The same for a program whose shaders project vertices by [`EmbeddedVulkan::projection`]:
    /// outputs with the methods `vertex` and `primitive` have a view that is their own picture.
    /// Primitives are not divided.
    ///
    /// # Errors
    /// As for [`EmbeddedVulkan::new`].
    pub fn projecting(api: Api, rig: &Rig, options: VulkanOptions) -> Result<Self> {
        Self::planned(api, rig, options, Session::projecting)
    }

    fn planned(api: Api, rig: &Rig, options: VulkanOptions, planner: Planner) -> Result<Self> {
        api.check_queue_family(options.queue_family)?;
        if !(1..=MOST_FRAMES).contains(&options.frames) {
            let message = format!("{} frames in flight; expected 1 to {MOST_FRAMES}", options.frames);
            return Err(Error::new(ErrorKind::InvalidArgument, message));
        }
        let (session, plan) = prepare(&api, rig, &options, planner)?;
        let backend = VkBackend::new(&api);
        let mut made =
            Self { api, rig: rig.clone(), options, planner, session, plan, backend, surface: None, frames: 0 };
        match made.make() {
            Ok(()) => Ok(made),
            Err(error) => {
                made.destroy();
                Err(error)
            }
        }
    }

    /// Creates the objects and images of the plan.
    fn make(&mut self) -> Result<()> {
        let VulkanOptions { arrangement, target_format, view_format, frames, .. } = self.options;
        self.backend.prepare_arranged(&self.plan, arrangement, target_format)?;
        self.backend.measure(frames, self.options.queue_family)?;
        if view_format != vk::Format::UNDEFINED {
            let mut surface =
                Surface::new(&self.api, arrangement, &arrangement.images(&self.plan), view_format, frames)?;
            self.backend.set_sources(surface.sources()).inspect_err(|_| surface.destroy(&self.api))?;
            self.surface = Some(surface);
        }
        Ok(())
    }

    /// Plans again for pictures of another size. Sources and targets of the program are forgotten,
    /// and Cupola's own images are created again. If the planner refuses, everything stays. If the
    /// driver does, only [`EmbeddedVulkan::resize`] and [`EmbeddedVulkan::destroy`] are useful
    /// afterwards.
    ///
    /// # Errors
    /// As for [`EmbeddedVulkan::new`].
    pub fn resize(&mut self, size: (u32, u32)) -> Result<()> {
        let options = VulkanOptions { size, ..self.options };
        let (session, plan) = prepare(&self.api, &self.rig, &options, self.planner)?;
        if let Some(mut surface) = self.surface.take() {
            surface.destroy(&self.api);
        }
        (self.options, self.session, self.plan) = (options, session, plan);
        self.make()
    }

    /// Returns the number of views; it changes only with [`EmbeddedVulkan::resize`].
    pub fn view_count(&self) -> usize {
        self.plan.views.views.len()
    }

    /// Describes a view, for a program whose camera has `near` and `far` planes (0 < near < far;
    /// far may be infinite).
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an index that does not exist or for wrong planes.
    pub fn view(&self, index: usize, near: f64, far: f64) -> Result<VulkanView> {
        let view = self.plan.views.views.get(index).ok_or_else(|| no_view(index, self.view_count()))?;
        check_planes(near, far)?;
        let arrangement = self.options.arrangement;
        let tile = view.tile;
        let top = self.plan.views.picture_size(view).1 - tile.y - tile.height;
        Ok(VulkanView {
            name: view.name.clone(),
            rotation: rotation(&self.session, view),
            frustum: clip_space(self.options.reversed_depth) * projection(&view.frustum, near, far),
            image: if arrangement == Arrangement::Images { index } else { 0 },
            layer: if arrangement == Arrangement::Layers { index } else { 0 },
            tile: UpperLeftRect::new(tile.x as i32, top as i32, tile.width as i32, tile.height as i32),
        })
    }

    /// Returns the numbers of `cupola_view` for a view, for the functions of
    /// [`correct::projected::projection`](crate::correct::projected::projection), if the program
    /// draws with the perspective `matrix` of Vulkan's clip space, with y down.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an index that does not exist, or a matrix that is no
    /// perspective.
    pub fn projection(&self, index: usize, matrix: &DMat4) -> Result<[f32; 32]> {
        let (rows, lens) = vectors_of_view(&self.session, index, matrix)?;
        Ok(joined(&rows.y_down(), &lens.y_down()))
    }

    /// Format of the target images.
    pub fn target_format(&self) -> vk::Format {
        self.options.target_format
    }

    /// Sizes of a frame's images; only [`EmbeddedVulkan::resize`] changes them.
    pub fn image_sizes(&self) -> Vec<ImageSize> {
        self.options.arrangement.images(&self.plan)
    }

    /// Images that Cupola created for frame `frame`; none if the program brings its own.
    pub fn images(&self, frame: usize) -> &[SourceImage] {
        let all = self.surface.as_ref().map_or(&[][..], Surface::sources);
        all.chunks_exact((all.len() / self.options.frames).max(1)).nth(frame).unwrap_or(&[])
    }

    /// Sets the images into which the program draws the views: [`EmbeddedVulkan::image_sizes`] for
    /// each frame. Cupola's own images are destroyed.
    ///
    /// # Errors
    /// Errors of [`VkBackend::set_sources`]; [`ErrorKind::InvalidArgument`] if the number of images
    /// is wrong.
    pub fn set_sources(&mut self, images: &[SourceImage]) -> Result<()> {
        let needed = self.image_sizes().len() * self.options.frames;
        if images.len() != needed {
            let message = format!("{} images; expected {needed}, those of all frames in flight", images.len());
            return Err(Error::new(ErrorKind::InvalidArgument, message));
        }
        self.backend.set_sources(images)?;
        if let Some(mut surface) = self.surface.take() {
            surface.destroy(&self.api);
        }
        Ok(())
    }

    /// Sets the target images of the correction, for example those of a swapchain.
    ///
    /// # Errors
    /// Errors of [`VkBackend::set_targets`].
    pub fn set_targets(&mut self, images: &[TargetImage]) -> Result<()> {
        self.backend.set_targets(images)
    }

    /// Records the correction of frame `frame`'s images into target `target`, with the picture's
    /// upper left corner at `place` (pixels from the target's upper left corner; parts outside are
    /// cut off). Creates no Vulkan object and allocates no device memory.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an index that was not set. Nothing is recorded then.
    pub fn record(&mut self, recording: &Recording, frame: usize, target: usize, place: (i32, i32)) -> Result<()> {
        self.backend.correct(recording, frame, target, &self.session.viewports_from_top(place))?;
        self.frames += 1;
        Ok(())
    }

    /// Number of frames recorded so far.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Returns the time that the device took for the corrections since the last
    /// [`EmbeddedVulkan::resize`]. A frame's time is known when the next frame with the same images
    /// is recorded.
    pub fn timing(&self) -> Timing {
        self.backend.timing()
    }

    /// Destroys everything on the device, which must be live.
    pub fn destroy(mut self) {
        self.backend.destroy();
        if let Some(mut surface) = self.surface.take() {
            surface.destroy(&self.api);
        }
    }
}

/// Plans the views as `options` ask.
fn prepare(api: &Api, rig: &Rig, options: &VulkanOptions, plan: Planner) -> Result<(Session, Plan)> {
    check_request(rig, options.size)?;
    let session = plan(rig, options.size, false, api.largest_image(), Extras::default())?;
    log_plan(rig, &session);
    let plan = options.arrangement.arrange(session.plan().clone());
    Ok((session, plan))
}

/// OpenGL's clip space → Vulkan's: y down, depth 0…1 or, reversed, 1…0.
fn clip_space(reversed_depth: bool) -> DMat4 {
    let depth = if reversed_depth { -0.5 } else { 0.5 };
    DMat4::from_cols(DVec4::X, DVec4::NEG_Y, DVec4::new(0.0, 0.0, depth, 0.0), DVec4::new(0.0, 0.0, 0.5, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Frustum;

    #[test]
    fn clip_space_is_that_of_vulkan() {
        let frustum = Frustum { left: -1.0, right: 1.2, bottom: -0.7, top: 0.6 };
        for (far, reversed) in [(50.0, false), (50.0, true), (f64::INFINITY, false), (f64::INFINITY, true)] {
            let matrix = clip_space(reversed) * projection(&frustum, 0.25, far);
            let at = |x: f64, y: f64, depth: f64| {
                let clip = matrix * DVec4::new(x * depth, y * depth, -depth, 1.0);
                (clip / clip.w).truncate().to_array()
            };
            let near = at(frustum.left, frustum.top, 0.25);
            let distant = at(frustum.right, frustum.bottom, far.min(1e12));
            let (first, last) = if reversed { (1.0, 0.0) } else { (0.0, 1.0) };
            for (found, right) in near.into_iter().chain(distant).zip([-1.0, -1.0, first, 1.0, 1.0, last]) {
                assert!((found - right).abs() < 1e-9, "far {far}, reversed {reversed}: {near:?} {distant:?}");
            }
        }
    }
}
