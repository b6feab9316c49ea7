//! Drivers that compute the maps under test.

use crate::failure::Failure;
use cupola::backend::{gl, vk};
use cupola::correct::Plan;
use cupola::correct::shaders::map::MapPixel;
use glam::DVec3;

/// Place where the maps are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Backend {
    /// Shaders on OpenGL and OpenGL ES in turn
    Gl,
    /// Shaders on Vulkan
    Vk,
    /// Formulas of the shaders in double precision, without a graphics driver and without weights
    Cpu,
}

/// Direction that a pixel shows, of any length, and the sampled view, if the driver reports it.
pub type Sampled = (DVec3, Option<usize>);

/// An open driver, or none.
pub enum Driver {
    /// A context, current on this thread.
    Gl(Box<gl::driver::headless::Headless>),
    /// A device.
    Vk(Box<vk::driver::headless::Headless>),
    /// The formulas themselves.
    Cpu,
}

impl Driver {
    /// Opens a driver for the case with this seed. OpenGL and OpenGL ES take turns, so that only
    /// one context is current.
    pub fn new(backend: Backend, seed: u64) -> Result<Self, Failure> {
        let api = if seed.is_multiple_of(2) { gl::driver::headless::Api::Core } else { gl::driver::headless::Api::Es3 };
        Ok(match backend {
            Backend::Gl => Self::Gl(Box::new(gl::driver::headless::Headless::new(api)?)),
            Backend::Vk => Self::Vk(Box::new(vk::driver::headless::Headless::new(&[])?)),
            Backend::Cpu => Self::Cpu,
        })
    }

    /// The map of output `output`, row 0 at the top; `None` if the driver computes no weights.
    pub fn map(&self, plan: &Plan, output: usize) -> Result<Option<Vec<MapPixel>>, Failure> {
        Ok(match self {
            Self::Gl(context) => Some(gl::gpu_map(&context.gl, context.is_gles, plan, output)?),
            Self::Vk(device) => Some(vk::gpu_map(device, plan, output)?),
            Self::Cpu => None,
        })
    }

    /// Directions that output `output` shows, row 0 at the top.
    pub fn directions(&self, plan: &Plan, output: usize) -> Result<Vec<Option<Sampled>>, Failure> {
        if let Some(map) = self.map(plan, output)? {
            let direction = |pixel: &MapPixel| {
                pixel.view.map(|view| (DVec3::from_array(pixel.direction.map(f64::from)), Some(view)))
            };
            return Ok(map.iter().map(direction).collect());
        }
        let pass = &plan.passes[output];
        let (width, height) = pass.size;
        let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (f64::from(column), f64::from(row))));
        let direction = |(column, row)| {
            let (x, y) = pass.source.normalised(pass.size, column + 0.5, row + 0.5);
            pass.source.direction(x, y).map(|direction| (direction, None))
        };
        Ok(pixels.map(direction).collect())
    }
}
