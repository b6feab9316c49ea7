//! Vertex programs in assembly language.

use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::scene::lens::Order;
use glam::DMat4;
use std::sync::Mutex;

/// A vertex program in assembly language that re-projects its position.
pub struct AssemblyProgram {
    /// Text that the program gave.
    pub(in crate::intercept::gl) own_text: Box<[u8]>,
    /// First of the four local parameters that hold the reprojection matrix.
    pub(in crate::intercept::gl) first_local: u32,
    /// Parameters that may be the program's matrix.
    pub(in crate::intercept::gl) matrices: Vec<ParameterMatrix>,
    /// Reprojection matrix that the four parameters hold.
    pub(in crate::intercept::gl) uploaded: Uploaded,
    /// Values of the matrices, for the search of the lens.
    pub(in crate::intercept::gl) values: Mutex<Vec<DMat4>>,
}

/// The reprojection matrix that was uploaded to a program.
pub(in crate::intercept::gl) type Uploaded = Mutex<Option<ReprojectionMatrix>>;

/// Four parameters that may be a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterMatrix {
    /// First of the four parameters.
    pub first: Parameter,
    /// Order of the four parameters: columns or rows.
    pub order: Order,
}

/// A parameter of vertex programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Parameter {
    /// A parameter of all programs.
    Environment(u32),
    /// A parameter of one program.
    Local(u32),
}
