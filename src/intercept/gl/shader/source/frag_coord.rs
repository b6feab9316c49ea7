//! `gl_FragCoord` of the program's fragment shaders, in the coordinates of the program's window.
//!
//! A view is a tile of the atlas, with another position and size than the window. If the text of a
//! fragment shader uses `gl_FragCoord`, an expression replaces it. The expression moves the tile to
//! the window's origin and scales it to the window's size. So the program computes the same values
//! as in a window that shows the view.

use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::shader::programs;
use crate::intercept::gl::shader::source::head::Head;
use crate::intercept::gl::shader::source::patch::strip_comments;
use crate::intercept::gl::state::draw::DrawState;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::programs::{FragCoord, Program};
use crate::lock::Lock;

const UNIFORM: &str = FragCoord::UNIFORM;

const NAME: &str = "gl_FragCoord";

/// Declaration of the coordinates in a fragment shader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Convention {
    /// `layout(origin_upper_left)`.
    pub upper_left: bool,
    /// `layout(pixel_center_integer)`.
    pub integer: bool,
}

/// Returns `source` with coordinates of the program's window. `None`: the text does not use them,
/// or declares them only under a condition. `es_context`: as for [`patch`](super::patch::patch).
pub fn patch(source: &str, es_context: bool) -> Option<(String, Convention)> {
    let bare = strip_comments(source);
    let mut places = words(&bare, NAME).peekable();
    places.peek()?;
    let head = Head::of(source, &bare, es_context)?;
    let mut convention = Convention::default();
    let mut uses = Vec::new();
    for at in places {
        match declaration(&bare, at) {
            Some(_) if condition_depth(&bare[..at]) > 0 => return None,
            Some(declared) => convention = declared,
            None if at < head.length() => return None,
            None => uses.push(at),
        }
    }
    let expression = match convention.integer {
        false => format!("vec4(({NAME}.xy-{UNIFORM}.xy)*{UNIFORM}.zw,{NAME}.zw)"),
        true => format!("vec4(({NAME}.xy+0.5-{UNIFORM}.xy)*{UNIFORM}.zw-0.5,{NAME}.zw)"),
    };
    let mut text = String::new();
    let mut end = head.length();
    for at in uses {
        text.push_str(&source[end..at]);
        text.push_str(&expression);
        end = at + NAME.len();
    }
    text.push_str(&source[end..]);
    let declared = head.uniform("vec4", UNIFORM, Some("vec4(0.0,0.0,1.0,1.0)"));
    Some((head.declaring(&declared, &text), convention))
}

/// Returns the places of `word` as a whole identifier.
fn words<'a>(bare: &'a str, word: &'a str) -> impl Iterator<Item = usize> + 'a {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    bare.match_indices(word)
        .map(|(at, _)| at)
        .filter(move |at| !bare[..*at].ends_with(is_name) && !bare[at + word.len()..].starts_with(is_name))
}

/// Returns the declared convention if this place declares the name.
fn declaration(bare: &str, at: usize) -> Option<Convention> {
    bare[..at].trim_end().strip_suffix("vec4").filter(|before| before.ends_with(|c: char| c.is_whitespace()))?;
    let start = bare[..at].rfind([';', '}']).map_or(0, |end| end + 1);
    let says = |word: &str| words(&bare[start..at], word).next().is_some();
    Some(Convention { upper_left: says("origin_upper_left"), integer: says("pixel_center_integer") })
}

/// Returns the number of preprocessor conditions that are open at the end of a text.
fn condition_depth(bare: &str) -> usize {
    bare.lines().fold(0, |depth: usize, line| {
        let directive = line.trim_start().strip_prefix('#').map_or("", str::trim_start);
        match () {
            () if directive.starts_with("if") => depth + 1,
            () if directive.starts_with("endif") => depth.saturating_sub(1),
            () => depth,
        }
    })
}

/// Sends the transformation to window coordinates to the present fragment shader, unless the shader
/// has it already.
pub fn upload(share: &ShareGroup, driver: &Driver, draw: &DrawState, shaders: &Shaders) {
    if shaders.used() != 0 {
        if let Some(program) = shaders.program() {
            send(driver, draw, shaders, program);
        }
    } else if shaders.bound_pipeline() != 0
        && let Some(program) = programs::record(share, shaders.stages().fragment())
    {
        send(driver, draw, shaders, &program);
    }
}

fn send(driver: &Driver, draw: &DrawState, shaders: &Shaders, program: &Program) {
    let Some(FragCoord { location, upper_left }) = program.frag_coord else { return };
    let vector = draw.to_window().vector(upper_left);
    let mut uploaded = program.uploaded.locked();
    if uploaded.to_window != Some(vector) {
        programs::set_vectors(driver, shaders, program, location, &vector);
        uploaded.to_window = Some(vector);
    }
}

#[cfg(test)]
mod tests {
    use super::{Convention, patch};

    const USE: &str = "vec4((gl_FragCoord.xy-cupola_to_window.xy)*cupola_to_window.zw,gl_FragCoord.zw)";

    fn patched(source: &str, es_context: bool) -> (String, Convention) {
        patch(source, es_context).expect("a use of it")
    }

    #[test]
    fn each_use_is_replaced_and_lines_stay() {
        let source =
            "#version 330\nout vec4 c;\nvoid main() { c = gl_FragCoord /* gl_FragCoord */ + gl_FragCoord.xxxx; }\n";
        let (text, convention) = patched(source, false);
        assert_eq!(text.matches(USE).count(), 2);
        assert!(
            text.starts_with("#version 330\nuniform vec4 cupola_to_window=vec4(0.0,0.0,1.0,1.0);\n#line 2\nout"),
            "{text}"
        );
        assert!(text.contains("/* gl_FragCoord */"));
        assert_eq!(convention, Convention::default());
        assert_eq!(patch("void main() { /* gl_FragCoord */ gl_FragColor = my_gl_FragCoord; }", false), None);
    }

    #[test]
    fn the_declaration_follows_extensions_and_the_conditions_around_them() {
        let source = "#version 100\n#ifdef A\n#extension GL_x : enable\n#endif\nprecision mediump float;\nvoid main() { gl_FragColor = gl_FragCoord; }\n";
        let (text, _) = patched(source, true);
        let head = "#version 100\n#ifdef A\n#extension GL_x : enable\n#endif\n#ifdef GL_FRAGMENT_PRECISION_HIGH\n";
        assert!(text.starts_with(head) && text.contains("#endif\n#line 4\nprecision"), "{text}");
    }

    #[test]
    fn conventions_are_those_of_the_shader() {
        let source = "#version 150\nlayout(origin_upper_left, pixel_center_integer) in vec4 gl_FragCoord;\nvoid main() { gl_FragColor = gl_FragCoord; }\n";
        let (text, convention) = patched(source, false);
        assert_eq!(convention, Convention { upper_left: true, integer: true });
        assert!(text.contains("in vec4 gl_FragCoord;") && text.contains("+0.5-cupola_to_window.xy"));
        let conditional = "#version 150\n#if 1\nlayout(origin_upper_left) in vec4 gl_FragCoord;\n#endif\nvoid main() { gl_FragColor = gl_FragCoord; }\n";
        assert_eq!(patch(conditional, false), None);
    }

    #[test]
    fn what_has_no_line_of_its_own_stays() {
        assert_eq!(patch("#version 330 void main() { gl_FragColor = gl_FragCoord; }", false), None);
        assert!(patch("void main() { gl_FragColor = gl_FragCoord; }", false).is_some());
    }
}
