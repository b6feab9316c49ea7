//! Viewports: the program's main picture, pictures within it, and pictures of the window's shape.
//! [`parts`]: large parts of the window that pictures fill. [`alone`]: small viewports in images.

pub mod alone;
pub mod parts;

use crate::correct::Size;

/// True if a viewport of `width` × `height` pixels shows the main picture and not one within it: it
/// covers more than half of `picture_area`. Smaller pictures, such as side-by-side ones, are not
/// changed.
pub fn is_main(width: f64, height: f64, picture_area: f64) -> bool {
    width * height * 2.0 > picture_area
}

/// True if a picture has the window's shape, up to rounding to whole pixels, and at least a quarter
/// of its width. Such a picture is assumed to hold the scene as the window would, and not the view
/// of a lamp or a mirror.
pub fn has_shape_of_window(picture: impl Into<Size>, window: impl Into<Size>) -> bool {
    let (picture, window) = (picture.into(), window.into());
    4 * i64::from(picture.width) >= i64::from(window.width) && has_shape(picture, window)
}

/// True if a picture has the window's shape, up to rounding to whole pixels.
pub fn has_shape(picture: impl Into<Size>, window: impl Into<Size>) -> bool {
    let (picture, window) = (picture.into(), window.into());
    let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
    let difference = product(picture.width, window.height) - product(picture.height, window.width);
    difference.abs() <= window.width.max(window.height).into()
}

#[cfg(test)]
mod tests {
    use super::{has_shape_of_window, is_main};

    #[test]
    fn more_than_half_is_the_main_picture() {
        let area = 640.0 * 480.0;
        assert!(is_main(640.0, 480.0, area) && is_main(640.0, 241.0, area));
        assert!(!is_main(320.0, 480.0, area) && !is_main(640.0, 240.0, area) && !is_main(0.0, 0.0, area));
    }

    #[test]
    fn shapes() {
        let window = (1280, 720);
        for picture in [(1280, 720), (640, 360), (320, 180), (427, 240), (2560, 1440)] {
            assert!(has_shape_of_window(picture, window), "{picture:?}");
        }
        for picture in [(1024, 1024), (64, 36), (2048, 1024), (1280, 700), (0, 0)] {
            assert!(!has_shape_of_window(picture, window), "{picture:?}");
        }
    }
}
