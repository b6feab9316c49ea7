//! A picture that an output shows where the program shows black.

use crate::error::Result;
use crate::formats::pictures::levels;
use crate::formats::{Levels, read_file};
use std::path::{Path, PathBuf};

/// Values for black in each pixel, read from a file.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Black {
    /// The file.
    pub file: PathBuf,
    /// A value for each channel of each pixel, stretched over the output from any size.
    pub levels: Levels,
    /// Meaning of the values.
    pub values: BlackValues,
}

/// Meaning of the values of a picture of black.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub enum BlackValues {
    /// Displayed values.
    #[default]
    Displayed,
    /// Parts of white in linear light.
    Light,
}

/// Reads the picture from a PNG or PFM file.
///
/// # Errors
/// [`ErrorKind::Io`](crate::ErrorKind::Io) if the file cannot be read,
/// [`ErrorKind::InvalidRig`](crate::ErrorKind::InvalidRig) with the reason if it is no picture or a
/// value is not 0…1.
pub(in crate::rig) fn read(file: &Path, values: BlackValues) -> Result<Black> {
    let levels = levels::read(&file.display().to_string(), &read_file(file)?)?;
    Ok(Black { file: file.to_owned(), levels, values })
}
