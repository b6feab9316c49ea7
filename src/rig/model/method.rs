//! Methods by which an output is computed from the views, and their replacement for one run.

use crate::error::{Error, ErrorKind, Result};
use crate::rig::reading::allowed::Allowed;
use crate::rig::reading::one_line::OneLine;
use crate::rig::reading::problems::Problems;
use crate::rig::{Rig, validate};

/// Method that makes an output's picture from the views.
///
/// Errors are in pixels of the output: the angle between the direction that a pixel shows and the
/// one that it should show, divided by the angle of the pixel there.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub enum Method {
    /// A ray for each pixel: the exact formula where there is one, otherwise an exact table of all
    /// pixels.
    #[default]
    Fragment,
    /// A table of directions and weights that is interpolated between its entries, as coarse as the
    /// greatest error allows.
    Table {
        /// Greatest error in pixels, 0.005…2.
        max_error: f64,
    },
    /// Triangles over the output with a direction and a weight at each corner, as large as the
    /// greatest error allows.
    Mesh {
        /// Greatest error in pixels, 0.005…2.
        max_error: f64,
    },
    /// The dome as a mesh, seen from the projector, or flattened to a domemaster; the error has no
    /// limit.
    CubeMesh {
        /// Cells along the edge of the cube whose faces are inflated to the dome, 4…512.
        density: u32,
    },
    /// The program's vertices are projected straight to the output's pixels, in one pass and
    /// without views. Between vertices the picture is as straight as the program's triangles are.
    Vertex,
    /// As [`Method::Vertex`], with lines and triangles divided until they are curved enough.
    Primitive {
        /// Greatest distance in pixels between the places where a divided primitive shows something
        /// and where it should be, 0.05…16.
        max_error: f64,
        /// Stage that divides primitives of programs with shaders.
        by: Divider,
    },
}

/// Stage of the graphics processor that divides primitives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub enum Divider {
    /// A geometry shader: divides every strip and fan, up to the number of parts that it can emit.
    #[default]
    Geometry,
    /// A tessellation shader if there is one and the primitives have vertices of their own,
    /// otherwise a geometry shader.
    Tessellation,
}

/// Range of `max_error`. Below it, 32-bit interpolation is no more exact. Above it, pixels would
/// sample directions that no view has to show.
pub(in crate::rig) const MAX_ERROR: Allowed = Allowed::closed(0.005, 2.0, "an error in pixels");
/// Default: a tenth of a pixel is invisible.
pub(in crate::rig) const DEFAULT_ERROR: f64 = 0.1;
/// Range of `max_error` of divided primitives. Below it, triangles are as small as pixels.
pub(in crate::rig) const DIVISION_ERROR: Allowed = Allowed::closed(0.05, 16.0, "an error in pixels");
/// Default: half a pixel, the error of any raster.
pub(in crate::rig) const DEFAULT_DIVISION_ERROR: f64 = 0.5;
/// Range of `density`.
pub(in crate::rig) const DENSITY: Allowed = Allowed::closed(4.0, 512.0, "whole cells along the edge of a cube");
/// Default of `density`.
pub(in crate::rig) const DEFAULT_DENSITY: f64 = 32.0;

/// Example of a method with its key, for messages.
const EXAMPLE: &str = "mesh,max_error=0.1";

impl Method {
    /// Greatest permitted error, pixels: 0 for exact methods, `None` if it follows from a density.
    pub fn max_error(&self) -> Option<f64> {
        match self {
            Self::Fragment => Some(0.0),
            Self::Table { max_error } | Self::Mesh { max_error } | Self::Primitive { max_error, .. } => {
                Some(*max_error)
            }
            Self::CubeMesh { .. } | Self::Vertex => None,
        }
    }

    /// True if vertices are projected straight to the output's pixels.
    pub fn projects_vertices(&self) -> bool {
        matches!(self, Self::Vertex | Self::Primitive { .. })
    }

    /// True if lines and triangles are divided before their vertices are projected.
    pub fn divides(&self) -> bool {
        matches!(self, Self::Primitive { .. })
    }

    /// Parses a method of the form `mesh,max_error=0.1` or `cube-mesh,density=64`: the name, then
    /// its keys, which may be absent.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for unknown names and keys, and for numbers missing,
    /// unreadable or out of range.
    pub fn parse(text: &str) -> Result<Self> {
        let (name, rest) = text.split_once(',').unwrap_or((text, ""));
        let line = OneLine { what: "method", example: EXAMPLE, text: rest };
        let entries = line.entries()?;
        let key = |wanted: &str, allowed: &Allowed, default: f64| {
            if let Some(other) = entries.iter().find(|entry| entry.key != wanted) {
                return Err(line.unknown(other.key, &[wanted]));
            }
            entries.first().map_or(Ok(default), |entry| entry.number(allowed))
        };
        let max_error = || key("max_error", &MAX_ERROR, DEFAULT_ERROR);
        let division = || key("max_error", &DIVISION_ERROR, DEFAULT_DIVISION_ERROR);
        match name.trim() {
            "fragment" if entries.is_empty() => Ok(Self::Fragment),
            "vertex" if entries.is_empty() => Ok(Self::Vertex),
            "primitive" => Ok(Self::Primitive { max_error: division()?, by: Divider::Geometry }),
            "primitive-tessellation" => Ok(Self::Primitive { max_error: division()?, by: Divider::Tessellation }),
            "table" => Ok(Self::Table { max_error: max_error()? }),
            "mesh" => Ok(Self::Mesh { max_error: max_error()? }),
            "cube-mesh" => {
                let density = key("density", &DENSITY, DEFAULT_DENSITY)?;
                whole(density).map(|density| Self::CubeMesh { density }).ok_or_else(|| {
                    Error::new(
                        ErrorKind::InvalidArgument,
                        format!("method {text:?}: `density`: {density} is not whole"),
                    )
                })
            }
            _ => Err(Error::new(
                ErrorKind::InvalidArgument,
                format!(
                    "method {text:?}: expected fragment, table, mesh, cube-mesh, vertex, primitive or primitive-tessellation, for example {EXAMPLE}"
                ),
            )),
        }
    }
}

/// A density, if it is a whole number.
pub(in crate::rig) fn whole(density: f64) -> Option<u32> {
    (density.fract() == 0.0).then_some(density as u32)
}

impl Rig {
    /// Returns the same rig for a caller that cannot serve `refused` methods: such outputs get
    /// [`Method::Fragment`], which shows the same from views.
    pub fn with_views_for(&self, refused: impl Fn(&Method) -> bool) -> Self {
        let mut rig = self.clone();
        for output in rig.outputs.iter_mut().chain(&mut rig.beside).filter(|output| refused(&output.method)) {
            output.method = Method::Fragment;
        }
        rig
    }

    /// Returns the same rig with the method of all outputs replaced by that of `text`, see
    /// [`Method::parse`].
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] as for [`Method::parse`], and if the method cannot make an
    /// output's picture.
    pub fn with_method_override(&self, text: &str) -> Result<Self> {
        let method = Method::parse(text)?;
        let mut rig = self.clone();
        for output in &mut rig.outputs {
            output.method = method;
        }
        let mut problems = Problems::new("");
        validate::check(&rig, &mut problems);
        match problems.is_empty() {
            true => Ok(rig),
            false => Err(Error::new(ErrorKind::InvalidArgument, problems.message(&self.name))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_are_read_from_one_line() {
        assert_eq!(Method::parse("fragment").expect("a method"), Method::Fragment);
        assert_eq!(Method::parse("mesh").expect("a method"), Method::Mesh { max_error: DEFAULT_ERROR });
        assert_eq!(Method::parse("table,max_error=0.5").expect("a method"), Method::Table { max_error: 0.5 });
        assert_eq!(Method::parse("cube-mesh, density=8").expect("a method"), Method::CubeMesh { density: 8 });
        assert_eq!(Method::parse("vertex").expect("a method"), Method::Vertex);
        assert_eq!(
            Method::parse("primitive,max_error=2").expect("a method"),
            Method::Primitive { max_error: 2.0, by: Divider::Geometry }
        );
        let tessellated = Method::Primitive { max_error: DEFAULT_DIVISION_ERROR, by: Divider::Tessellation };
        assert_eq!(Method::parse("primitive-tessellation").expect("a method"), tessellated);
        for wrong in [
            "",
            "vertex,max_error=1",
            "primitive,max_error=0",
            "mash",
            "mesh,density=3",
            "mesh,max_error=9",
            "mesh,max_error=0.1,density=4",
            "fragment,density=8",
            "cube-mesh,density=8.5",
        ] {
            assert_eq!(Method::parse(wrong).expect_err(wrong).kind, ErrorKind::InvalidArgument);
        }
    }

    #[test]
    fn all_outputs_are_replaced_or_none() {
        let rig = crate::rig::load("planetarium-2").expect("a preset");
        let meshed = rig.with_method_override("mesh,max_error=0.25").expect("possible");
        assert!(meshed.outputs.iter().all(|output| output.method == Method::Mesh { max_error: 0.25 }));
        let projected = rig.with_method_override("vertex").expect("pinholes within the dome");
        assert!(projected.outputs.iter().all(|output| output.method == Method::Vertex));
        let views = projected.with_views_for(Method::projects_vertices);
        assert!(views.outputs.iter().all(|output| output.method == Method::Fragment));
        assert_eq!(projected.with_views_for(Method::divides), projected, "nothing is divided");
        let own_lens = crate::rig::load("identity-captured").expect("a preset");
        let refused = own_lens.with_method_override("mesh").expect_err("no map is known before the program draws");
        assert!(refused.message.contains("method"), "{refused}");
    }
}
