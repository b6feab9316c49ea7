//! Vertices and their attributes: recorded between Begin and End, examined while a list is
//! compiled.
//!
//! The rows come from the registry (`build/gl_attributes.rs`). Commands that are allowed between
//! Begin and End, but do not fit that form, are below the rows.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::compat::begin_end;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::ListState;
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::compat::begin_end::Phase;
use crate::intercept::gl::state::compat::vertex_commands::VertexCommand;
use crate::intercept::gl::state::compat::vertex_recorder::{Number, Sets, add_vertex};
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::process::call_sum;

/// Records a command of the program. Returns false if the driver must get the command too.
#[inline]
fn note<T: Number>(
    gl: &Gl,
    compat: &mut Compat,
    lists: &mut ListState,
    command: VertexCommand,
    sets: Sets,
    prefix: &[u64],
    values: &[T],
) -> bool {
    if compat.immediate.phase == Phase::Outside && lists.recording.is_none() {
        return false;
    }
    if compat.immediate.under_way() && is_refused(compat.immediate.generic_attributes, sets, prefix) {
        // An error, which the driver reports before those of the following commands.
        compat.immediate.close_elements(gl);
        return false;
    }
    if sets.is_vertex(prefix) {
        let bounds = match &mut lists.recording {
            Some(list) if compat.immediate.phase == Phase::Outside => &mut list.bounds,
            _ => &mut compat.immediate.bounds,
        };
        add_vertex(bounds, sets, values);
    }
    if compat.immediate.phase != Phase::Outside {
        compat.immediate.close_elements(gl);
        compat.immediate.recorder.push(command, sets, prefix, values);
    }
    compat.immediate.phase == Phase::Recording
}

/// True if the driver refuses a command for the numbers before its values: a generic attribute of
/// `attributes` or higher, or a packed value of a type that is none.
fn is_refused(attributes: u32, sets: Sets, prefix: &[u64]) -> bool {
    const PACKED: [u32; 2] = [api::GL_INT_2_10_10_10_REV, api::GL_UNSIGNED_INT_2_10_10_10_REV];
    let generic = matches!(sets, Sets::Generic | Sets::ConvertedGeneric);
    let (number, kind) = match (sets, prefix) {
        (Sets::Material, _) => (None, None),
        (Sets::Generic | Sets::ConvertedGeneric | Sets::TextureUnit, [number, rest @ ..]) => {
            (Some(*number), rest.first())
        }
        (_, prefix) => (None, prefix.first()),
    };
    let packed = |kind: u64| {
        PACKED.into_iter().any(|packed| kind == u64::from(packed))
            || generic && kind == u64::from(api::GL_UNSIGNED_INT_10F_11F_11F_REV)
    };
    generic && number.is_some_and(|number| number >= attributes.into()) || kind.is_some_and(|kind| !packed(*kind))
}

/// Returns the program's array of `N` numbers, and adds them to the checksum of the frame's calls.
///
/// # Safety
/// `v` points at `N` numbers.
unsafe fn array<T: Copy, const N: usize>(v: *const T) -> [T; N] {
    // SAFETY: as promised above.
    unsafe { call_sum::add_values(v, N) };
    // SAFETY: as promised above; the array may be unaligned.
    std::array::from_fn(|i| unsafe { v.add(i).read_unaligned() })
}

/// Records a property of a material; `name` determines the number of its values. Returns false if
/// the driver must get the command too.
fn note_material<T: Number + Default>(
    driver: &Driver,
    compat: &mut Compat,
    lists: &mut ListState,
    command: VertexCommand,
    [face, name]: [u32; 2],
    value: impl Fn(usize) -> T,
) -> bool {
    let count = match name {
        api::GL_AMBIENT | api::GL_DIFFUSE | api::GL_SPECULAR | api::GL_EMISSION | api::GL_AMBIENT_AND_DIFFUSE => 4,
        api::GL_COLOR_INDEXES => 3,
        api::GL_SHININESS if (0.0..=128.0).contains(&value(0).value()) => 1,
        // An error, which the driver reports.
        _ => return false,
    };
    if !matches!(face, api::GL_FRONT | api::GL_BACK | api::GL_FRONT_AND_BACK) {
        return false;
    }
    let values: [T; 4] = std::array::from_fn(|i| if i < count { value(i) } else { T::default() });
    // SAFETY: the array above.
    unsafe { call_sum::add_values(values.as_ptr(), values.len()) };
    note(driver.gl, compat, lists, command, Sets::Material, &[face.into(), name.into()], &values)
}

macro_rules! attribute_commands {
    ({ $( $name:literal $method:ident ($($p:ident: $t:ty),*) as $array:ident = $sets:ident [$($before:ident),*] $values:expr; )* }
     { $( $arrays:tt )* }) => {
        hooks! {
            between;
            $( $name $method($($p: $t),*) = |ctx, gl| {
                if !note(ctx.driver.gl, &mut ctx.compat, &mut ctx.lists, VertexCommand::$array, Sets::$sets, &[$(u64::from($before)),*], &$values) {
                    gl.$method($($p),*);
                }
            }; )*
            "glMaterialf" materialf(face: u32, name: u32, value: f32) = |ctx, gl| {
                if !note_material(&ctx.driver, &mut ctx.compat, &mut ctx.lists, VertexCommand::materialfv, [face, name], |_| value) { gl.materialf(face, name, value) }
            };
            "glMaterialfv" materialfv(face: u32, name: u32, values: *const f32) = |ctx, gl| {
                if !note_material(&ctx.driver, &mut ctx.compat, &mut ctx.lists, VertexCommand::materialfv, [face, name], |i| values.add(i).read_unaligned()) {
                    gl.materialfv(face, name, values);
                }
            };
            "glMateriali" materiali(face: u32, name: u32, value: i32) = |ctx, gl| {
                if !note_material(&ctx.driver, &mut ctx.compat, &mut ctx.lists, VertexCommand::materialiv, [face, name], |_| value) { gl.materiali(face, name, value) }
            };
            "glMaterialiv" materialiv(face: u32, name: u32, values: *const i32) = |ctx, gl| {
                if !note_material(&ctx.driver, &mut ctx.compat, &mut ctx.lists, VertexCommand::materialiv, [face, name], |i| values.add(i).read_unaligned()) {
                    gl.materialiv(face, name, values);
                }
            };
            "glArrayElement" array_element(i: i32) = |ctx, gl| {
                begin_end::note_element(ctx);
                gl.array_element(i);
            };
            "glPrimitiveRestartNV" primitive_restart_nv() = |ctx, gl| {
                begin_end::note_element(ctx);
                gl.primitive_restart_nv();
            };
            "glEvalPoint1" eval_point1(i: i32) = |ctx, gl| {
                begin_end::note_element(ctx);
                gl.eval_point1(i);
            };
            "glEvalPoint2" eval_point2(i: i32, j: i32) = |ctx, gl| {
                begin_end::note_element(ctx);
                gl.eval_point2(i, j);
            };
        }
    };
}

include!(concat!(env!("OUT_DIR"), "/gl_attributes.rs"));

#[cfg(test)]
mod tests {
    use super::{HOOKS, Sets, api, is_refused};

    #[test]
    fn attributes_and_packed_types_that_there_are_not_are_refused() {
        let packed = u64::from(api::GL_INT_2_10_10_10_REV);
        for (sets, prefix) in [
            (Sets::Color, &[][..]),
            (Sets::Vertex, &[packed]),
            (Sets::TextureUnit, &[0x84c0]),
            (Sets::TextureUnit, &[0x84c0, packed]),
            (Sets::Generic, &[15]),
            (Sets::ConvertedGeneric, &[15, packed, 0]),
            (Sets::ConvertedGeneric, &[1, api::GL_UNSIGNED_INT_10F_11F_11F_REV.into(), 0]),
            (Sets::Material, &[0x404, 0x1200]),
        ] {
            assert!(!is_refused(16, sets, prefix), "{sets:?} {prefix:?}");
        }
        for (sets, prefix) in [
            (Sets::Generic, &[16][..]),
            (Sets::ConvertedGeneric, &[16, packed, 0]),
            (Sets::ConvertedGeneric, &[1, 0x1406, 0]),
            (Sets::TextureUnit, &[0x84c0, 0x1406]),
            (Sets::Normal, &[api::GL_UNSIGNED_INT_10F_11F_11F_REV.into()]),
        ] {
            assert!(is_refused(16, sets, prefix), "{sets:?} {prefix:?}");
        }
    }

    #[test]
    fn every_kind_of_command_is_found_in_the_registry() {
        let known = |name: &str| HOOKS.iter().any(|hook| hook.name == name);
        for name in ["glVertex2s", "glVertex4dv", "glVertexP3uiv", "glVertex3hNV", "glVertex2bOES", "glColor4ubv"] {
            assert!(known(name), "{name}");
        }
        for name in ["glVertexAttrib4Nusv", "glVertexAttribI4bv", "glVertexAttribL1ui64vARB", "glVertexAttribP2ui"] {
            assert!(known(name), "{name}");
        }
        for name in
            ["glMultiTexCoord3sv", "glTexCoordP1ui", "glFogCoorddv", "glEdgeFlag", "glIndexubv", "glEvalCoord2f"]
        {
            assert!(known(name), "{name}");
        }
        for name in ["glVertexPointer", "glColorMask", "glVertexAttribDivisor", "glIndexMask", "glColorMaterial"] {
            assert!(!known(name), "{name}");
        }
    }
}
