//! Blending that an operator adjusts while a program runs.

use super::gl::{cupola_gl, handle};
use super::status::{call, check_size, cupola_status, null};
use crate::error::{Error, ErrorKind, Result};
use crate::rig::{AngleRamp, Blend, DomeAngle, RampShape, Transfer};

/// A ramp `3t² − 2t³`.
pub const CUPOLA_RAMP_SMOOTHSTEP: u32 = 0;
/// A ramp `½ − ½·cos(πt)`.
pub const CUPOLA_RAMP_COSINE: u32 = 1;
/// A ramp of two halves of a power.
pub const CUPOLA_RAMP_POWER: u32 = 2;

/// An angle from the dome's pole.
pub const CUPOLA_ANGLE_POLAR: u32 = 0;
/// An angle around the dome's pole.
pub const CUPOLA_ANGLE_AZIMUTH: u32 = 1;

/// Most ramps in angles of the dome.
pub const CUPOLA_MOST_RAMPS: usize = 8;

/// A ramp in an angle of the dome.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct cupola_angle_ramp {
    /// `CUPOLA_ANGLE_POLAR` or `CUPOLA_ANGLE_AZIMUTH`.
    pub angle: u32,
    /// `CUPOLA_RAMP_SMOOTHSTEP`, `CUPOLA_RAMP_COSINE` or `CUPOLA_RAMP_POWER`.
    pub shape: u32,
    /// The power, 0.5…4, of `CUPOLA_RAMP_POWER`.
    pub power: f64,
    /// Where the weight is 0, degrees.
    pub zero: f64,
    /// Where the weight is 1, degrees.
    pub full: f64,
}

/// How an output is blended: the keys of `[output.blend]` in a rig file.
#[repr(C)]
pub struct cupola_blend {
    /// `sizeof(cupola_blend)`.
    pub struct_size: usize,
    /// Not 0: the light is shared where projectors overlap.
    pub overlap: u32,
    /// Shape of the ramp at the borders: `CUPOLA_RAMP_SMOOTHSTEP`, `CUPOLA_RAMP_COSINE` or `CUPOLA_RAMP_POWER`.
    pub shape: u32,
    /// The power, 0.5…4, of `CUPOLA_RAMP_POWER`.
    pub power: f64,
    /// Width of that ramp as a part of the picture's width and height, 1e-6…0.5.
    pub ramp: f64,
    /// Exponent of the picture's claim on a point, 1…2.
    pub exponent: f64,
    /// Exponent of the display's response, 1…4.
    pub gamma: f64,
    /// Light added to black, 0…1 (excluded); without effect where the rig file has a picture of black.
    pub black_level: f64,
    /// White over black, at least 10; 0: not evened out.
    pub contrast: f64,
    /// Bits to dither for, 6…16; 0: not dithered.
    pub dither: u32,
    /// 1: the display has the response of sRGB; 2: those of the rig, which `gamma` does not describe; 0: `gamma`.
    pub srgb: u32,
    /// How many of `ramps` there are.
    pub ramp_count: usize,
    /// Ramps in angles of the dome.
    pub ramps: [cupola_angle_ramp; 8],
}

/// How an output (numbered as in the rig, from 0) is blended now. Set `blend->struct_size` before.
///
/// # Safety
/// `gl` is a live handle; `blend` points at a struct of `blend->struct_size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_get_blend(
    gl: *mut cupola_gl,
    output: u32,
    blend: *mut cupola_blend,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let gl = unsafe { handle(gl) }?;
        if blend.is_null() {
            return Err(null("blend"));
        }
        // SAFETY: the size comes first; the rest is written only if it is there.
        check_size(unsafe { (*blend).struct_size }, size_of::<cupola_blend>(), "blend")?;
        let described = described(gl.embedded.blend(output as usize)?);
        // SAFETY: as large as it must be.
        unsafe { *blend = described };
        Ok(())
    })
}

/// Blends an output otherwise from the next frame on; between frames. Shaders are made anew, which takes
/// milliseconds; views stay. On an error everything stays.
///
/// # Safety
/// `gl` is a live handle whose context is current; `blend` points at a struct of `blend->struct_size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_set_blend(
    gl: *mut cupola_gl,
    output: u32,
    blend: *const cupola_blend,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let gl = unsafe { handle(gl) }?;
        if blend.is_null() {
            return Err(null("blend"));
        }
        // SAFETY: the size comes first; the rest is read only if it is there.
        check_size(unsafe { (*blend).struct_size }, size_of::<cupola_blend>(), "blend")?;
        // SAFETY: as large as it must be.
        let wanted = wanted(unsafe { &*blend }, gl.embedded.blend(output as usize)?)?;
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

/// What `given` asks of an output that is blended as `now`.
fn wanted(given: &cupola_blend, now: &Blend) -> Result<Blend> {
    let ramps = given.ramps.get(..given.ramp_count).ok_or_else(|| {
        let message = format!("blend.ramp_count = {}; right would be 0 to {CUPOLA_MOST_RAMPS}", given.ramp_count);
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
    Error::new(ErrorKind::InvalidArgument, format!("{name} = {number} is none of those that cupola.h names"))
}
