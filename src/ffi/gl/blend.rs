//! Blending that an operator adjusts while a program runs.

use super::cupola_gl;
use crate::error::{Error, ErrorKind, Result};
use crate::ffi::handle::Handle;
use crate::ffi::sized::{self, Growing, SizedPlace, first_size};
use crate::ffi::status::{call, cupola_status};
use crate::rig::{AngleRamp, Blend, DomeAngle, RampShape, Transfer};

/// Shape of a ramp: `3t^2 - 2t^3`.
pub const CUPOLA_RAMP_SMOOTHSTEP: u32 = 0;
/// Shape of a ramp: `1/2 - 1/2 cos(pi t)`.
pub const CUPOLA_RAMP_COSINE: u32 = 1;
/// Shape of a ramp: `(2t)^p / 2` for t up to 1/2, and its point reflection beyond.
pub const CUPOLA_RAMP_POWER: u32 = 2;

/// Angle from the pole of the dome.
pub const CUPOLA_ANGLE_POLAR: u32 = 0;
/// Angle around the pole of the dome.
pub const CUPOLA_ANGLE_AZIMUTH: u32 = 1;

/// Greatest number of ramps in angles of the dome.
pub const CUPOLA_MOST_RAMPS: usize = 8;

/// Ramp in an angle of the dome. The struct is an element of `cupola_blend` and never grows.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct cupola_angle_ramp {
    /// `CUPOLA_ANGLE_POLAR` or `CUPOLA_ANGLE_AZIMUTH`.
    pub angle: u32,
    /// `CUPOLA_RAMP_SMOOTHSTEP`, `CUPOLA_RAMP_COSINE` or `CUPOLA_RAMP_POWER`.
    pub shape: u32,
    /// Power p of `CUPOLA_RAMP_POWER`, 0.5 to 4; 1 is a straight line. Other shapes ignore it.
    pub power: f64,
    /// Angle at which the weight is 0, in degrees.
    pub zero: f64,
    /// Angle at which the weight is 1, in degrees.
    pub full: f64,
}

/// Blending of an output: the keys of `[output.blend]` in a rig file.
#[repr(C)]
pub struct cupola_blend {
    /// `sizeof(cupola_blend)`.
    pub struct_size: usize,
    /// Other than 0: projectors share the light where they overlap. For projectors only.
    pub overlap: u32,
    /// Shape of the ramp at the borders of the picture: `CUPOLA_RAMP_SMOOTHSTEP`,
    /// `CUPOLA_RAMP_COSINE` or `CUPOLA_RAMP_POWER`.
    pub shape: u32,
    /// Power p of `CUPOLA_RAMP_POWER`, 0.5 to 4. Other shapes ignore it.
    pub power: f64,
    /// Width of that ramp as a part of the picture's width and height, 1e-6 to 0.5.
    pub ramp: f64,
    /// Exponent of the picture's raw weight, 1 to 2.
    pub exponent: f64,
    /// Exponent of the display's response, 1 to 4. Ignored where `srgb` is not 0.
    pub gamma: f64,
    /// Light added to black, 0 (included) to 1 (excluded). Ignored where the rig has a picture of
    /// black.
    pub black_level: f64,
    /// Light of white divided by that of black, at least 10; 0: overlaps of black are not evened
    /// out.
    pub contrast: f64,
    /// Number of bits for which the picture is dithered, 6 to 16; 0 for no dithering.
    pub dither: u32,
    /// Response of the display. 0: the power `gamma`. 1: sRGB. 2: the responses in the rig, of each
    /// channel or measured; only an output that has them accepts it.
    pub srgb: u32,
    /// Number of elements of `ramps` that are used, 0 to `CUPOLA_MOST_RAMPS`.
    pub ramp_count: usize,
    /// Ramps in angles of the dome.
    pub ramps: [cupola_angle_ramp; 8],
}

// SAFETY: `repr(C)` with the size first; numbers only.
unsafe impl Growing for cupola_blend {
    const FIRST_SIZE: usize = first_size!(cupola_blend, ramps);
}

/// Returns the blending of an output.
///
/// # Parameters
/// - `gl`: the object.
/// - `output`: index of the output in the rig, from 0.
/// - `blend`: receives the values. The caller sets `blend->struct_size` before.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, a wrong `struct_size`, or an output that does not
///   exist.
///
/// # Threads
/// Any thread; no context is needed.
///
/// # Safety
/// `gl` is a live handle; `blend` points to `blend->struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_get_blend(
    gl: *mut cupola_gl,
    output: u32,
    blend: *mut cupola_blend,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (gl, blend) = unsafe { (cupola_gl::borrow(gl)?, SizedPlace::new(blend, "blend")?) };
        blend.set(&described(gl.embedded.blend(output as usize)?));
        Ok(())
    })
}

/// Changes the blending of an output from the next frame on. The views stay. Shaders are compiled
/// again, which takes milliseconds. On an error everything stays.
///
/// To change single values, read all with `cupola_gl_get_blend` first.
///
/// # Parameters
/// - `gl`: the object, outside a frame.
/// - `output`: index of the output in the rig, from 0.
/// - `blend`: the values. Not kept.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, a wrong `struct_size`, a field that this version
///   does not know, an output that does not exist, a value out of its range, or `overlap` for an
///   output that is no projector.
/// - `CUPOLA_INVALID_STATE`: a frame has begun and not ended.
/// - `CUPOLA_GRAPHICS`: the driver refused a request.
///
/// # Threads
/// Context current.
///
/// # Safety
/// `gl` is a live handle; `blend` points to `blend->struct_size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_set_blend(
    gl: *mut cupola_gl,
    output: u32,
    blend: *const cupola_blend,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (gl, blend) = unsafe { (cupola_gl::borrow_mut(gl)?, sized::read(blend, "blend")?) };
        let wanted = wanted(&blend, gl.embedded.blend(output as usize)?)?;
        gl.embedded.set_blend(output as usize, wanted)
    })
}

fn described(blend: &Blend) -> cupola_blend {
    let (shape, power) = shape_number(blend.shape);
    let none = cupola_angle_ramp { angle: 0, shape: 0, power: 1.0, zero: 0.0, full: 0.0 };
    let mut ramps = [none; CUPOLA_MOST_RAMPS];
    for (to, from) in ramps.iter_mut().zip(&blend.ramps) {
        let (shape, power) = shape_number(from.shape);
        let angle = if from.angle == DomeAngle::Azimuth { CUPOLA_ANGLE_AZIMUTH } else { CUPOLA_ANGLE_POLAR };
        *to = cupola_angle_ramp { angle, shape, power, zero: from.zero.to_degrees(), full: from.full.to_degrees() };
    }
    cupola_blend {
        struct_size: size_of::<cupola_blend>(),
        overlap: blend.overlap.into(),
        shape,
        power,
        ramp: blend.ramp,
        exponent: blend.exponent,
        gamma: blend.gamma,
        black_level: blend.black_level,
        contrast: blend.contrast.unwrap_or_default(),
        dither: blend.dither.unwrap_or_default(),
        srgb: match blend.transfer {
            Transfer::Power => 0,
            Transfer::Srgb => 1,
            Transfer::Powers(_) | Transfer::Measured(_) => 2,
        },
        ramp_count: blend.ramps.len().min(CUPOLA_MOST_RAMPS),
        ramps,
    }
}

fn wanted(given: &cupola_blend, now: &Blend) -> Result<Blend> {
    let ramps = given.ramps.get(..given.ramp_count).ok_or_else(|| {
        let message = format!("blend.ramp_count = {}; expected 0 to {CUPOLA_MOST_RAMPS}", given.ramp_count);
        Error::new(ErrorKind::InvalidArgument, message)
    })?;
    Ok(Blend {
        overlap: given.overlap != 0,
        ramp: given.ramp,
        shape: shape_of(given.shape, given.power)?,
        exponent: given.exponent,
        ramps: ramps.iter().map(angle_ramp).collect::<Result<_>>()?,
        gamma: given.gamma,
        transfer: match given.srgb {
            0 => Transfer::Power,
            2 if !now.transfer.is_plain() => now.transfer.clone(),
            2 => return Err(unknown("srgb", given.srgb)),
            _ => Transfer::Srgb,
        },
        black_level: given.black_level,
        contrast: (given.contrast != 0.0).then_some(given.contrast),
        dither: (given.dither != 0).then_some(given.dither),
    })
}

fn angle_ramp(given: &cupola_angle_ramp) -> Result<AngleRamp> {
    let angle = match given.angle {
        CUPOLA_ANGLE_POLAR => DomeAngle::Polar,
        CUPOLA_ANGLE_AZIMUTH => DomeAngle::Azimuth,
        other => return Err(unknown("angle", other)),
    };
    let (zero, full) = (given.zero.to_radians(), given.full.to_radians());
    Ok(AngleRamp { angle, zero, full, shape: shape_of(given.shape, given.power)? })
}

fn shape_number(shape: RampShape) -> (u32, f64) {
    match shape {
        RampShape::Smoothstep => (CUPOLA_RAMP_SMOOTHSTEP, 1.0),
        RampShape::Cosine => (CUPOLA_RAMP_COSINE, 1.0),
        RampShape::Power(power) => (CUPOLA_RAMP_POWER, power),
    }
}

fn shape_of(number: u32, power: f64) -> Result<RampShape> {
    match number {
        CUPOLA_RAMP_SMOOTHSTEP => Ok(RampShape::Smoothstep),
        CUPOLA_RAMP_COSINE => Ok(RampShape::Cosine),
        CUPOLA_RAMP_POWER => Ok(RampShape::Power(power)),
        other => Err(unknown("shape", other)),
    }
}

fn unknown(name: &str, number: u32) -> Error {
    Error::new(ErrorKind::InvalidArgument, format!("{name} = {number} is not one of the values in cupola.h"))
}
