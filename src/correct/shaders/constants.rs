//! Values that specialise a pass's shader: structs generated from the WGSL sources at build time.

use crate::error::{Error, ErrorKind, Result};
use glam::DMat3;

/// Greatest number of views that one batch may sample.
pub const MAX_VIEWS: usize = 8;
/// Greatest number of other projectors that may overlap one batch.
pub const MAX_NEIGHBOURS: usize = 12;
/// Greatest number of ramps in dome angles of one output.
pub const MAX_RAMPS: usize = 8;

/// Kind of correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Pass {
    /// A fisheye picture.
    Fisheye,
    /// A projector that lights a sphere.
    Projector,
    /// A projector with a fisheye, or with a mirror.
    Optics,
    /// A flat perspective picture.
    Perspective,
    /// An unrolled picture of all directions.
    Panorama,
    /// Directions and weights from a texture.
    Table,
    /// Directions and weights at the corners of triangles.
    Mesh,
    /// Nothing: black.
    Black,
}

#[allow(missing_docs, reason = "generated; the members are documented in the WGSL sources")]
mod generated {
    use super::Pass;

    include!(concat!(env!("OUT_DIR"), "/shader_constants.rs"));
}
pub use generated::*;

/// The constants of one draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Constants {
    values: Values,
    scalars: Vec<f32>,
    base: DMat3,
}

impl Constants {
    /// Returns constants for directions in `base` (viewer axes → base).
    ///
    /// # Errors
    /// [`ErrorKind::Internal`] where a value is not finite.
    pub(in crate::correct) fn new(values: Values, base: DMat3) -> Result<Self> {
        let scalars = values.scalars();
        match scalars.iter().position(|value| !value.is_finite()) {
            None => Ok(Self { values, scalars, base }),
            Some(index) => {
                let pass = values.pass();
                let mut ends = members(pass).iter().scan(0, |end, (path, count)| {
                    *end += count;
                    Some((path, *end))
                });
                let path = ends.find(|(_, end)| index < *end).map_or("", |(path, _)| path);
                Err(Error::new(
                    ErrorKind::Internal,
                    format!("The {pass:?} shader's constant {path} is {}, which is not finite.", scalars[index]),
                ))
            }
        }
    }

    /// Returns the constants of the pass that shows nothing.
    pub fn black() -> Self {
        Self { values: Values::Black, scalars: Vec::new(), base: DMat3::IDENTITY }
    }

    /// Returns the pass.
    pub fn pass(&self) -> Pass {
        self.values.pass()
    }

    /// Returns the matrix from viewer axes to base, the axes in which the views' transforms take
    /// directions. Directions at the corners of triangles are in these axes.
    pub(in crate::correct) fn base(&self) -> DMat3 {
        self.base
    }

    /// Returns the constants that every pass with views has; `None` for black.
    pub fn shared(&self) -> Option<&Shared> {
        self.values.shared()
    }

    /// Returns true if the picture is content, not views.
    pub(in crate::correct) fn shows_content(&self) -> bool {
        self.shared().is_some_and(|shared| shared.content.kind != 0)
    }

    /// Returns the scalars in the order of the shader's constant.
    pub fn scalars(&self) -> &[f32] {
        &self.scalars
    }
}

/// Returns an error where there are more than `most`.
pub(in crate::correct) fn limit(what: &str, count: usize, most: usize) -> Result<()> {
    if count <= most {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Internal, format!("A batch has {count} {what}; the shaders support {most}.")))
}
