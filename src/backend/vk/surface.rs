//! Images to draw views into.

use super::images::SourceImage;
use super::memory::Image;
use crate::backend::vk::driver::api::Api;
use crate::correct::{Arrangement, ImageSize};
use crate::error::{Error, ErrorKind, Result};
use ash::vk;

/// Images of Cupola, one set for each frame that may be pending. Only [`Surface::destroy`] destroys
/// them; dropping does not.
pub struct Surface {
    images: Vec<Image>,
    sources: Vec<SourceImage>,
}

impl Surface {
    /// Layout of the images before and after a correction.
    pub const LAYOUT: vk::ImageLayout = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;

    /// Makes `sets` sets of images of these sizes. They can be drawn to, cleared and copied.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where the device cannot draw to `format`, or has too little memory.
    pub fn new(
        api: &Api,
        arrangement: Arrangement,
        sizes: &[ImageSize],
        format: vk::Format,
        sets: usize,
    ) -> Result<Self> {
        if !api.features(format).contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT) {
            let message = format!("The device cannot draw views to images of {format:?}.");
            return Err(Error::new(ErrorKind::Graphics, message));
        }
        let mut surface = Self { images: Vec::new(), sources: Vec::new() };
        for size in std::iter::repeat_n(sizes, sets).flatten() {
            if let Err(error) = surface.add(api, arrangement, *size, format) {
                surface.destroy(api);
                return Err(error);
            }
        }
        Ok(surface)
    }

    fn add(&mut self, api: &Api, arrangement: Arrangement, size: ImageSize, format: vk::Format) -> Result<()> {
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let extent = (size.width, size.height);
        let layers = (arrangement == Arrangement::Layers).then_some(size.layers);
        let image = Image::layered(api, format, extent, layers, usage)?;
        self.sources.push(SourceImage {
            image: image.handle,
            view: image.view,
            format,
            extent,
            layout: Self::LAYOUT,
            stages: vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT,
            access: vk::AccessFlags::COLOR_ATTACHMENT_WRITE,
        });
        self.images.push(image);
        Ok(())
    }

    /// Returns the images, set by set.
    pub fn sources(&self) -> &[SourceImage] {
        &self.sources
    }

    /// Destroys the images. No pending commands may use them.
    pub fn destroy(&mut self, api: &Api) {
        self.sources.clear();
        for mut image in self.images.drain(..) {
            image.destroy(api);
        }
    }
}
