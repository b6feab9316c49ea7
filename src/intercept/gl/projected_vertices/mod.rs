//! Methods `vertex` and `primitive`: vertices are projected straight to an output.
//!
//! Shaders get the lens of an output beside the matrix ([`begin_view`]). Where primitives have to
//! be divided, a variant of the program with a geometry or tessellation stage is put in use
//! (`variants`), or the processor divides them ([`draw_divided`]). For the fixed-function pipeline
//! a program of Cupola stands in ([`begin_stand_in`]). Other rooms use what is exported here.
//!
//! ```text
//! vertex shader → [geometry or tessellation stage that divides] → lens of the output
//! ```

pub mod carriers;
mod fixed_function;
mod geometry_stage;
pub mod interface;
mod lens;
mod tessellation;
mod variants;

pub use fixed_function::arrays::read as read_arrays;
pub use fixed_function::division::{draw as draw_divided, whole as draw_whole};
pub use fixed_function::substitute::{
    HOOKS, begin as begin_stand_in, end as end_stand_in, reads as reads_vertices, switch,
};
pub use fixed_function::vertices::{Attribute, Vertices};
pub use lens::{begin as begin_view, variant};
