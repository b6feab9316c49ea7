//! Methods `vertex` and `primitive`: vertices are projected straight to an output.
//!
//! Shaders get the lens of an output in addition to the matrix ([`begin_view`]). If primitives have
//! to be divided, a variant of the program with a geometry or tessellation stage is used
//! (`variants`), or the processor divides them ([`draw_divided`]). A program of Cupola replaces the
//! fixed-function pipeline ([`begin_stand_in`]). Other folders use only the exports of this file.
//! `draw::divided` issues the draws that the processor divides: it stands higher, because it routes
//! them.
//!
//! ```text
//! vertex shader → [geometry or tessellation stage that divides] → lens of the output
//! ```

mod carriers;
mod fixed_function;
mod geometry_stage;
mod interface;
mod lens;
mod tessellation;
mod variants;

pub use carriers::carry;
pub use fixed_function::arrays::read as read_arrays;
pub use fixed_function::division::{draw as draw_divided, whole as draw_whole};
pub use fixed_function::substitute::{
    HOOKS, begin as begin_stand_in, end as end_stand_in, reads as reads_vertices, switch,
};
pub use fixed_function::vertices::{Attribute, Vertices};
pub use interface::{Interface, read as read_interface};
pub use lens::{begin as begin_view, variant};
