//! Stage outputs in carrier variables, for a stage of Cupola that follows.

use crate::intercept::gl::projected_vertices::geometry_stage;
use crate::intercept::gl::projected_vertices::interface::Interface;
use crate::intercept::gl::shader::source::patch::{end_of_version_line, strip_comments, version};

/// Returns `source`, a stage of desktop OpenGL with the outputs `interface`, with these outputs in
/// carrier variables for a stage of Cupola that follows.
pub fn carry(source: &str, interface: &Interface) -> String {
    let edited = interface.edited(source);
    let bare = strip_comments(&edited);
    let out = if version(&bare, false).0 < 130 { "varying" } else { "out" };
    let (declarations, copies) = geometry_stage::carriers(interface, out);
    let (head, body) = edited.split_at(end_of_version_line(&edited, &bare));
    format!(
        "{head}#define main cupola_main\n{body}\n#undef main\n{declarations}void main() {{ cupola_main();{copies} }}\n"
    )
}
