//! Colours, normals and texture coordinates between Begin and End.
//!
//! A Begin/End of the program is drawn from a list. What is current afterwards is what the program set
//! last, but a list that ends with an attribute after its last vertex leaves something else on Mesa. So
//! the last values are noted, and set again after the list has run.

use super::context::Context;
use super::hook::hooks;
use crate::backend::gl::api::Gl;

/// The last colour, normal and texture coordinate that were set since Begin.
pub type Last = [Option<[f32; 4]>; 3];

const COLOR: usize = 0;
const NORMAL: usize = 1;
const TEXTURE: usize = 2;

/// Sets what was set last, and forgets it.
pub fn restore(gl: &Gl, last: &mut Last) {
    let [color, normal, texture] = std::mem::take(last);
    // SAFETY: reads three or four floats.
    unsafe {
        if let Some(color) = color {
            gl.color4fv(color.as_ptr());
        }
        if let Some(normal) = normal {
            gl.normal3fv(normal.as_ptr());
        }
        if let Some(texture) = texture {
            gl.tex_coord4fv(texture.as_ptr());
        }
    }
}

/// Notes what the program sets; missing components are 0, 0, 0, 1 as OpenGL says.
fn note<const N: usize>(ctx: &mut Context, which: usize, values: [f32; N]) {
    if ctx.in_begin {
        let mut four = [0.0, 0.0, 0.0, 1.0];
        four[..N].copy_from_slice(&values);
        ctx.last_attributes[which] = Some(four);
    }
}

/// The program's array of `N` numbers.
///
/// # Safety
/// `v` points at `N` numbers.
unsafe fn array<T: Copy, const N: usize>(v: *const T, convert: impl Fn(T) -> f32) -> [f32; N] {
    // SAFETY: as promised above.
    std::array::from_fn(|i| convert(unsafe { *v.add(i) }))
}

macro_rules! attribute_hooks {
    ($( $which:ident $t:ty, $convert:expr;
        $( $name:literal $method:ident ($($p:ident),*) $vector:literal $vector_method:ident $count:literal; )* )*) => {
        hooks! {
            $( $(
                $name $method($($p: $t),*) = |ctx, gl| {
                    gl.$method($($p),*);
                    note(ctx, $which, [$($convert($p)),*]);
                };
                $vector $vector_method(v: *const $t) = |ctx, gl| {
                    gl.$vector_method(v);
                    note::<$count>(ctx, $which, array(v, $convert));
                };
            )* )*
        }
    };
}

// Signed integers become colours and normals by (2c + 1)/(2ⁿ − 1), unsigned ones by c/(2ⁿ − 1): what Mesa
// does in compatibility contexts, which `tests/apps/trailing_attribute.c` checks.
attribute_hooks! {
    COLOR f32, |c: f32| c;
        "glColor3f" color3f(r, g, b) "glColor3fv" color3fv 3; "glColor4f" color4f(r, g, b, a) "glColor4fv" color4fv 4;
    COLOR f64, |c: f64| c as f32;
        "glColor3d" color3d(r, g, b) "glColor3dv" color3dv 3; "glColor4d" color4d(r, g, b, a) "glColor4dv" color4dv 4;
    COLOR u8, |c: u8| f32::from(c) / 255.0;
        "glColor3ub" color3ub(r, g, b) "glColor3ubv" color3ubv 3; "glColor4ub" color4ub(r, g, b, a) "glColor4ubv" color4ubv 4;
    COLOR u16, |c: u16| f32::from(c) / 65535.0;
        "glColor3us" color3us(r, g, b) "glColor3usv" color3usv 3; "glColor4us" color4us(r, g, b, a) "glColor4usv" color4usv 4;
    COLOR u32, |c: u32| (f64::from(c) / 4_294_967_295.0) as f32;
        "glColor3ui" color3ui(r, g, b) "glColor3uiv" color3uiv 3; "glColor4ui" color4ui(r, g, b, a) "glColor4uiv" color4uiv 4;
    COLOR i8, |c: i8| (2.0 * f32::from(c) + 1.0) / 255.0;
        "glColor3b" color3b(r, g, b) "glColor3bv" color3bv 3; "glColor4b" color4b(r, g, b, a) "glColor4bv" color4bv 4;
    COLOR i16, |c: i16| (2.0 * f32::from(c) + 1.0) / 65535.0;
        "glColor3s" color3s(r, g, b) "glColor3sv" color3sv 3; "glColor4s" color4s(r, g, b, a) "glColor4sv" color4sv 4;
    COLOR i32, |c: i32| ((2.0 * f64::from(c) + 1.0) / 4_294_967_295.0) as f32;
        "glColor3i" color3i(r, g, b) "glColor3iv" color3iv 3; "glColor4i" color4i(r, g, b, a) "glColor4iv" color4iv 4;
    NORMAL f32, |c: f32| c; "glNormal3f" normal3f(x, y, z) "glNormal3fv" normal3fv 3;
    NORMAL f64, |c: f64| c as f32; "glNormal3d" normal3d(x, y, z) "glNormal3dv" normal3dv 3;
    NORMAL i8, |c: i8| (2.0 * f32::from(c) + 1.0) / 255.0; "glNormal3b" normal3b(x, y, z) "glNormal3bv" normal3bv 3;
    NORMAL i16, |c: i16| (2.0 * f32::from(c) + 1.0) / 65535.0; "glNormal3s" normal3s(x, y, z) "glNormal3sv" normal3sv 3;
    NORMAL i32, |c: i32| ((2.0 * f64::from(c) + 1.0) / 4_294_967_295.0) as f32;
        "glNormal3i" normal3i(x, y, z) "glNormal3iv" normal3iv 3;
    TEXTURE f32, |c: f32| c;
        "glTexCoord1f" tex_coord1f(s) "glTexCoord1fv" tex_coord1fv 1; "glTexCoord2f" tex_coord2f(s, t) "glTexCoord2fv" tex_coord2fv 2;
        "glTexCoord3f" tex_coord3f(s, t, r) "glTexCoord3fv" tex_coord3fv 3; "glTexCoord4f" tex_coord4f(s, t, r, q) "glTexCoord4fv" tex_coord4fv 4;
    TEXTURE f64, |c: f64| c as f32;
        "glTexCoord1d" tex_coord1d(s) "glTexCoord1dv" tex_coord1dv 1; "glTexCoord2d" tex_coord2d(s, t) "glTexCoord2dv" tex_coord2dv 2;
        "glTexCoord3d" tex_coord3d(s, t, r) "glTexCoord3dv" tex_coord3dv 3; "glTexCoord4d" tex_coord4d(s, t, r, q) "glTexCoord4dv" tex_coord4dv 4;
    TEXTURE i32, |c: i32| c as f32;
        "glTexCoord1i" tex_coord1i(s) "glTexCoord1iv" tex_coord1iv 1; "glTexCoord2i" tex_coord2i(s, t) "glTexCoord2iv" tex_coord2iv 2;
        "glTexCoord3i" tex_coord3i(s, t, r) "glTexCoord3iv" tex_coord3iv 3; "glTexCoord4i" tex_coord4i(s, t, r, q) "glTexCoord4iv" tex_coord4iv 4;
    TEXTURE i16, |c: i16| f32::from(c);
        "glTexCoord1s" tex_coord1s(s) "glTexCoord1sv" tex_coord1sv 1; "glTexCoord2s" tex_coord2s(s, t) "glTexCoord2sv" tex_coord2sv 2;
        "glTexCoord3s" tex_coord3s(s, t, r) "glTexCoord3sv" tex_coord3sv 3; "glTexCoord4s" tex_coord4s(s, t, r, q) "glTexCoord4sv" tex_coord4sv 4;
}
