//! Where the vertices of Begin/End and of display lists are.

use super::super::context::Context;
use super::super::hook::hooks;
use super::bounds::Bounds;

/// The box that grows while vertices are recorded: that of a Begin/End, or of a list's present part.
fn growing(ctx: &mut Context) -> Option<&mut Bounds> {
    match &mut ctx.recording {
        Some(recording) => Some(&mut recording.bounds),
        None if ctx.in_begin => Some(&mut ctx.begin_bounds),
        None => None,
    }
}

/// Notes a vertex; missing coordinates are 0, 0, 1 as OpenGL says.
fn note<const N: usize>(ctx: &mut Context, values: [f64; N]) {
    if let Some(bounds) = growing(ctx) {
        let mut position = [0.0, 0.0, 0.0, 1.0];
        position[..N].copy_from_slice(&values);
        bounds.add(position);
    }
}

/// Notes vertices that are not followed.
pub fn note_unknown(ctx: &mut Context) {
    if let Some(bounds) = growing(ctx) {
        bounds.add_unknown();
    }
}

/// The program's array of `N` numbers.
///
/// # Safety
/// `v` points at `N` numbers.
unsafe fn array<T: Copy + Into<f64>, const N: usize>(v: *const T) -> [f64; N] {
    // SAFETY: as promised above.
    std::array::from_fn(|i| unsafe { (*v.add(i)).into() })
}

/// Three tables: vertices; vertices that are not followed; generic attributes, of which number 0 is a vertex.
macro_rules! vertex_hooks {
    ({ $( $name:literal $method:ident ($($p:ident),*) $vector:literal $vector_method:ident $count:literal $t:ty; )* }
     { $( $other:literal $other_method:ident ($($o:ident: $ot:ty),*); )* }
     { $( $generic:literal $generic_method:ident ($($g:ident: $gt:ty),*); )* }) => {
        hooks! {
            $(
                $name $method($($p: $t),*) = |ctx, gl| {
                    note(ctx, [$($p.into()),*]);
                    gl.$method($($p),*);
                };
                $vector $vector_method(v: *const $t) = |ctx, gl| {
                    note::<$count>(ctx, array(v));
                    gl.$vector_method(v);
                };
            )*
            $(
                $other $other_method($($o: $ot),*) = |ctx, gl| {
                    note_unknown(ctx);
                    gl.$other_method($($o),*);
                };
            )*
            $(
                $generic $generic_method(index: u32, $($g: $gt),*) = |ctx, gl| {
                    if index == 0 {
                        note_unknown(ctx);
                    }
                    gl.$generic_method(index, $($g),*);
                };
            )*
            "glPointSize" point_size(size: f32) = |ctx, gl| {
                ctx.widest.note(size);
                gl.point_size(size);
            };
            "glLineWidth" line_width(width: f32) = |ctx, gl| {
                ctx.widest.note(width);
                gl.line_width(width);
            };
            "glPointParameterf" point_parameterf(name: u32, value: f32) = |ctx, gl| {
                ctx.widest.note_unknown();
                gl.point_parameterf(name, value);
            };
            "glPointParameterfv" point_parameterfv(name: u32, values: *const f32) = |ctx, gl| {
                ctx.widest.note_unknown();
                gl.point_parameterfv(name, values);
            };
            "glPointParameteri" point_parameteri(name: u32, value: i32) = |ctx, gl| {
                ctx.widest.note_unknown();
                gl.point_parameteri(name, value);
            };
            "glPointParameteriv" point_parameteriv(name: u32, values: *const i32) = |ctx, gl| {
                ctx.widest.note_unknown();
                gl.point_parameteriv(name, values);
            };
        }
    };
}

vertex_hooks! {
    {
        "glVertex2d" vertex2d(x, y) "glVertex2dv" vertex2dv 2 f64;
        "glVertex2f" vertex2f(x, y) "glVertex2fv" vertex2fv 2 f32;
        "glVertex2i" vertex2i(x, y) "glVertex2iv" vertex2iv 2 i32;
        "glVertex2s" vertex2s(x, y) "glVertex2sv" vertex2sv 2 i16;
        "glVertex3d" vertex3d(x, y, z) "glVertex3dv" vertex3dv 3 f64;
        "glVertex3f" vertex3f(x, y, z) "glVertex3fv" vertex3fv 3 f32;
        "glVertex3i" vertex3i(x, y, z) "glVertex3iv" vertex3iv 3 i32;
        "glVertex3s" vertex3s(x, y, z) "glVertex3sv" vertex3sv 3 i16;
        "glVertex4d" vertex4d(x, y, z, w) "glVertex4dv" vertex4dv 4 f64;
        "glVertex4f" vertex4f(x, y, z, w) "glVertex4fv" vertex4fv 4 f32;
        "glVertex4i" vertex4i(x, y, z, w) "glVertex4iv" vertex4iv 4 i32;
        "glVertex4s" vertex4s(x, y, z, w) "glVertex4sv" vertex4sv 4 i16;
    }
    {
        "glArrayElement" array_element(i: i32);
        "glEvalCoord1d" eval_coord1d(u: f64);
        "glEvalCoord1dv" eval_coord1dv(u: *const f64);
        "glEvalCoord1f" eval_coord1f(u: f32);
        "glEvalCoord1fv" eval_coord1fv(u: *const f32);
        "glEvalCoord2d" eval_coord2d(u: f64, v: f64);
        "glEvalCoord2dv" eval_coord2dv(u: *const f64);
        "glEvalCoord2f" eval_coord2f(u: f32, v: f32);
        "glEvalCoord2fv" eval_coord2fv(u: *const f32);
        "glEvalPoint1" eval_point1(i: i32);
        "glEvalPoint2" eval_point2(i: i32, j: i32);
        "glVertexP2ui" vertex_p2ui(kind: u32, value: u32);
        "glVertexP2uiv" vertex_p2uiv(kind: u32, value: *const u32);
        "glVertexP3ui" vertex_p3ui(kind: u32, value: u32);
        "glVertexP3uiv" vertex_p3uiv(kind: u32, value: *const u32);
        "glVertexP4ui" vertex_p4ui(kind: u32, value: u32);
        "glVertexP4uiv" vertex_p4uiv(kind: u32, value: *const u32);
    }
    {
        "glVertexAttrib1d" vertex_attrib1d(x: f64);
        "glVertexAttrib1dv" vertex_attrib1dv(v: *const f64);
        "glVertexAttrib1f" vertex_attrib1f(x: f32);
        "glVertexAttrib1fv" vertex_attrib1fv(v: *const f32);
        "glVertexAttrib1s" vertex_attrib1s(x: i16);
        "glVertexAttrib1sv" vertex_attrib1sv(v: *const i16);
        "glVertexAttrib2d" vertex_attrib2d(x: f64, y: f64);
        "glVertexAttrib2dv" vertex_attrib2dv(v: *const f64);
        "glVertexAttrib2f" vertex_attrib2f(x: f32, y: f32);
        "glVertexAttrib2fv" vertex_attrib2fv(v: *const f32);
        "glVertexAttrib2s" vertex_attrib2s(x: i16, y: i16);
        "glVertexAttrib2sv" vertex_attrib2sv(v: *const i16);
        "glVertexAttrib3d" vertex_attrib3d(x: f64, y: f64, z: f64);
        "glVertexAttrib3dv" vertex_attrib3dv(v: *const f64);
        "glVertexAttrib3f" vertex_attrib3f(x: f32, y: f32, z: f32);
        "glVertexAttrib3fv" vertex_attrib3fv(v: *const f32);
        "glVertexAttrib3s" vertex_attrib3s(x: i16, y: i16, z: i16);
        "glVertexAttrib3sv" vertex_attrib3sv(v: *const i16);
        "glVertexAttrib4Nbv" vertex_attrib4_nbv(v: *const i8);
        "glVertexAttrib4Niv" vertex_attrib4_niv(v: *const i32);
        "glVertexAttrib4Nsv" vertex_attrib4_nsv(v: *const i16);
        "glVertexAttrib4Nub" vertex_attrib4_nub(x: u8, y: u8, z: u8, w: u8);
        "glVertexAttrib4Nubv" vertex_attrib4_nubv(v: *const u8);
        "glVertexAttrib4Nuiv" vertex_attrib4_nuiv(v: *const u32);
        "glVertexAttrib4Nusv" vertex_attrib4_nusv(v: *const u16);
        "glVertexAttrib4bv" vertex_attrib4bv(v: *const i8);
        "glVertexAttrib4d" vertex_attrib4d(x: f64, y: f64, z: f64, w: f64);
        "glVertexAttrib4dv" vertex_attrib4dv(v: *const f64);
        "glVertexAttrib4f" vertex_attrib4f(x: f32, y: f32, z: f32, w: f32);
        "glVertexAttrib4fv" vertex_attrib4fv(v: *const f32);
        "glVertexAttrib4iv" vertex_attrib4iv(v: *const i32);
        "glVertexAttrib4s" vertex_attrib4s(x: i16, y: i16, z: i16, w: i16);
        "glVertexAttrib4sv" vertex_attrib4sv(v: *const i16);
        "glVertexAttrib4ubv" vertex_attrib4ubv(v: *const u8);
        "glVertexAttrib4uiv" vertex_attrib4uiv(v: *const u32);
        "glVertexAttrib4usv" vertex_attrib4usv(v: *const u16);
        "glVertexAttribI1i" vertex_attrib_i1i(x: i32);
        "glVertexAttribI1iv" vertex_attrib_i1iv(v: *const i32);
        "glVertexAttribI1ui" vertex_attrib_i1ui(x: u32);
        "glVertexAttribI1uiv" vertex_attrib_i1uiv(v: *const u32);
        "glVertexAttribI2i" vertex_attrib_i2i(x: i32, y: i32);
        "glVertexAttribI2iv" vertex_attrib_i2iv(v: *const i32);
        "glVertexAttribI2ui" vertex_attrib_i2ui(x: u32, y: u32);
        "glVertexAttribI2uiv" vertex_attrib_i2uiv(v: *const u32);
        "glVertexAttribI3i" vertex_attrib_i3i(x: i32, y: i32, z: i32);
        "glVertexAttribI3iv" vertex_attrib_i3iv(v: *const i32);
        "glVertexAttribI3ui" vertex_attrib_i3ui(x: u32, y: u32, z: u32);
        "glVertexAttribI3uiv" vertex_attrib_i3uiv(v: *const u32);
        "glVertexAttribI4bv" vertex_attrib_i4bv(v: *const i8);
        "glVertexAttribI4i" vertex_attrib_i4i(x: i32, y: i32, z: i32, w: i32);
        "glVertexAttribI4iv" vertex_attrib_i4iv(v: *const i32);
        "glVertexAttribI4sv" vertex_attrib_i4sv(v: *const i16);
        "glVertexAttribI4ubv" vertex_attrib_i4ubv(v: *const u8);
        "glVertexAttribI4ui" vertex_attrib_i4ui(x: u32, y: u32, z: u32, w: u32);
        "glVertexAttribI4uiv" vertex_attrib_i4uiv(v: *const u32);
        "glVertexAttribI4usv" vertex_attrib_i4usv(v: *const u16);
        "glVertexAttribL1d" vertex_attrib_l1d(x: f64);
        "glVertexAttribL1dv" vertex_attrib_l1dv(v: *const f64);
        "glVertexAttribL2d" vertex_attrib_l2d(x: f64, y: f64);
        "glVertexAttribL2dv" vertex_attrib_l2dv(v: *const f64);
        "glVertexAttribL3d" vertex_attrib_l3d(x: f64, y: f64, z: f64);
        "glVertexAttribL3dv" vertex_attrib_l3dv(v: *const f64);
        "glVertexAttribL4d" vertex_attrib_l4d(x: f64, y: f64, z: f64, w: f64);
        "glVertexAttribL4dv" vertex_attrib_l4dv(v: *const f64);
        "glVertexAttribP1ui" vertex_attrib_p1ui(kind: u32, normalized: u8, value: u32);
        "glVertexAttribP1uiv" vertex_attrib_p1uiv(kind: u32, normalized: u8, value: *const u32);
        "glVertexAttribP2ui" vertex_attrib_p2ui(kind: u32, normalized: u8, value: u32);
        "glVertexAttribP2uiv" vertex_attrib_p2uiv(kind: u32, normalized: u8, value: *const u32);
        "glVertexAttribP3ui" vertex_attrib_p3ui(kind: u32, normalized: u8, value: u32);
        "glVertexAttribP3uiv" vertex_attrib_p3uiv(kind: u32, normalized: u8, value: *const u32);
        "glVertexAttribP4ui" vertex_attrib_p4ui(kind: u32, normalized: u8, value: u32);
        "glVertexAttribP4uiv" vertex_attrib_p4uiv(kind: u32, normalized: u8, value: *const u32);
    }
}
