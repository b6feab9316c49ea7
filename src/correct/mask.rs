//! Weight images from files.

use super::plan::Mask;
use crate::error::{Error, ErrorKind, Result};
use std::path::Path;

/// Reads a weight image: a PNG of 8 or 16 bits, grey or colour (its luma counts; transparency does not).
///
/// The values are taken as linear weights, white = 1.
///
/// # Errors
///
/// [`ErrorKind::Io`] if the file cannot be read, [`ErrorKind::InvalidRig`] if it is no image; both name the path.
pub fn load(path: &Path) -> Result<Mask> {
    let failed = |kind, what: &dyn std::fmt::Display| Error::new(kind, format!("mask {}: {what}", path.display()));
    let reader = image::ImageReader::open(path)
        .and_then(image::ImageReader::with_guessed_format)
        .map_err(|error| failed(ErrorKind::Io, &error))?;
    let picture = reader.decode().map_err(|error| match error {
        image::ImageError::IoError(error) => failed(ErrorKind::Io, &error),
        error => failed(ErrorKind::InvalidRig, &error),
    })?;
    let grey = picture.into_luma16();
    let (width, height) = grey.dimensions();
    Ok(Mask { width, height, weights: grey.into_raw() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, GrayImage, ImageBuffer, Luma, Rgb, RgbImage};

    /// Saves `picture` under a name of its own, loads it, and removes it.
    fn reloaded(name: &str, picture: DynamicImage) -> Mask {
        let path = std::env::temp_dir().join(format!("cupola-mask-{}-{name}.png", std::process::id()));
        picture.save(&path).unwrap();
        let mask = load(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        mask
    }

    #[test]
    fn reads_grey_of_8_and_16_bits_and_the_luma_of_colour() {
        let eight = GrayImage::from_fn(3, 2, |x, y| Luma([(100 * x + 20 * y) as u8]));
        let mask = reloaded("8", eight.into());
        assert_eq!((mask.width, mask.height), (3, 2));
        assert_eq!(mask.weights, [0, 100, 200, 20, 120, 220].map(|value: u16| value * 257));

        let sixteen = ImageBuffer::from_fn(2, 2, |x, y| Luma([(1 + 1000 * x + 30000 * y) as u16]));
        assert_eq!(reloaded("16", sixteen.into()).weights, [1, 1001, 30001, 31001]);

        let colour = RgbImage::from_fn(2, 1, |x, _| if x == 0 { Rgb([255; 3]) } else { Rgb([0, 255, 0]) });
        let weights = reloaded("colour", colour.into()).weights;
        assert_eq!(weights[0], 65535);
        assert!((30000..60000).contains(&weights[1]), "green is bright, but not white: {}", weights[1]);
    }

    #[test]
    fn names_the_path_of_what_it_cannot_read() {
        let missing = load(Path::new("no/such/mask.png")).unwrap_err();
        assert_eq!(missing.kind, ErrorKind::Io);
        assert!(missing.message.contains("no/such/mask.png"));

        let path = std::env::temp_dir().join(format!("cupola-mask-{}-text.png", std::process::id()));
        std::fs::write(&path, "not a picture").unwrap();
        let wrong = load(&path).unwrap_err();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(wrong.kind, ErrorKind::InvalidRig);
        assert!(wrong.message.contains(&*path.to_string_lossy()));
    }
}
