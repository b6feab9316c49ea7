//! Timing of corrections on a Vulkan device.

use cupola::backend::vk::ash::vk;
use cupola::backend::vk::driver::headless::Headless;
use cupola::backend::vk::{Surface, VkBackend, gpu_map};
use cupola::correct::shaders::map::MapPixel;
use cupola::correct::{Arrangement, ImageSize, Plan};
use cupola::geom::UpperLeftRect;
use cupola::{Error, ErrorKind, Result};
use std::time::Instant;

const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// A Vulkan device and the corrections that are timed on it.
pub struct Trial {
    device: Headless,
    size: (u32, u32),
    target: Surface,
    contestants: Vec<(VkBackend, Surface)>,
}

impl Trial {
    /// Creates a device and an output of `size` pixels.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] if there is no device.
    pub fn new(size: (u32, u32)) -> Result<Self> {
        let device = Headless::new(&[])?;
        let whole = ImageSize { width: size.0, height: size.1, layers: 1 };
        let target = Surface::new(&device.api, Arrangement::Atlas, &[whole], FORMAT, 1)?;
        Ok(Self { device, size, target, contestants: Vec::new() })
    }

    /// Adds the correction of the first output of `plan`. The views have one colour, since their
    /// content does not affect the time. Returns its number.
    ///
    /// # Errors
    /// Those of [`VkBackend::prepare`].
    pub fn add_plan(&mut self, plan: &Plan) -> Result<usize> {
        let api = &self.device.api;
        let only = Plan { views: plan.views.clone(), passes: plan.passes.iter().take(1).cloned().collect() };
        let views = Surface::new(api, Arrangement::Atlas, &Arrangement::Atlas.images(&only), FORMAT, 1)?;
        let mut backend = VkBackend::new(api);
        let made = self.prepare(&mut backend, &only, &views);
        self.contestants.push((backend, views));
        made.map(|()| self.contestants.len() - 1)
    }

    fn prepare(&self, backend: &mut VkBackend, plan: &Plan, views: &Surface) -> Result<()> {
        backend.prepare(plan, false, FORMAT)?;
        backend.set_sources(views.sources())?;
        let shown = self.target.sources().first();
        let shown = shown.ok_or_else(|| Error::new(ErrorKind::Internal, "a surface has no image"))?;
        backend.set_targets(&[shown.overwritten()])?;
        self.device.fill(views.sources(), &Arrangement::Atlas.images(plan), [0.3, 0.5, 0.7, 1.0])
    }

    /// Corrects once. Returns the seconds from recording until the device has finished.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an unknown number; [`ErrorKind::Graphics`] if the device
    /// fails.
    pub fn time(&mut self, number: usize) -> Result<f64> {
        let (device, (width, height)) = (&self.device, self.size);
        let missing = || Error::new(ErrorKind::InvalidArgument, format!("there is no contestant {number}"));
        let (backend, _) = self.contestants.get_mut(number).ok_or_else(missing)?;
        let started = Instant::now();
        // SAFETY: the command buffer is being recorded, and all images are live and in their
        // layouts.
        device.run(|commands| unsafe {
            backend.record(commands, 0, 0, &[UpperLeftRect::new(0, 0, width as i32, height as i32)])
        })?;
        Ok(started.elapsed().as_secs_f64())
    }

    /// The map of the first output of `plan`.
    ///
    /// # Errors
    /// Those of [`gpu_map`].
    pub fn map(&self, plan: &Plan) -> Result<Vec<MapPixel>> {
        gpu_map(&self.device, plan, 0)
    }
}

impl Drop for Trial {
    fn drop(&mut self) {
        let api = &self.device.api;
        for (backend, views) in &mut self.contestants {
            backend.destroy();
            views.destroy(api);
        }
        self.target.destroy(api);
    }
}
