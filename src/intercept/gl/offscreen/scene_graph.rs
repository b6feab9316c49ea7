//! Which images lie between a scene and the window.

use crate::intercept::gl::offscreen::images::{Image, Name};

/// For each image whether it is to be drawn once per view. `always`: also where it was not seen on its way to
/// the window.
pub fn wanted(images: &[Image], always: bool) -> Vec<bool> {
    let from_scene = spread(images, |image| image.scene || image.copies_window, |from, to| to.reads.contains(&from));
    let to_window = spread(
        images,
        |image| image.shown,
        |to, from| images.iter().any(|i| i.name == to && i.reads.contains(&from.name)),
    );
    from_scene.into_iter().zip(to_window).map(|(from, to)| from && (to || always)).collect()
}

/// Marks images that `start`, and then again and again those that a marked one is a `step` away from.
fn spread(images: &[Image], start: impl Fn(&Image) -> bool, step: impl Fn(Name, &Image) -> bool) -> Vec<bool> {
    let mut marks: Vec<bool> = images.iter().map(start).collect();
    loop {
        let next: Vec<bool> = images
            .iter()
            .zip(&marks)
            .map(|(image, mark)| *mark || images.iter().zip(&marks).any(|(from, mark)| *mark && step(from.name, image)))
            .collect();
        if next == marks {
            return marks;
        }
        marks = next;
    }
}

/// Whether a viewport has the window's shape, up to rounding to whole pixels, and at least a quarter of its
/// width: then it holds the scene as the window would, and not what a lamp or a mirror sees.
pub fn like_window(viewport: [i32; 4], window: (u32, u32)) -> bool {
    let [_, _, width, height] = viewport.map(i64::from);
    let (across, up) = (i64::from(window.0), i64::from(window.1));
    4 * width >= across && (width * up - height * across).abs() <= across.max(up)
}

#[cfg(test)]
mod tests {
    use super::{like_window, wanted};
    use crate::intercept::gl::offscreen::images::{Image, Name};

    fn image(name: u32, set: impl FnOnce(&mut Image)) -> Image {
        let plain = Image::new(Name::Renderbuffer(name), [64, 64, 0, 0, 0, 0, 0]).expect("a size that images have");
        let mut image = Image { format: 0, mask: 0, ..plain };
        set(&mut image);
        image
    }

    #[test]
    fn a_chain_is_wanted_and_what_hangs_beside_it_is_not() {
        let images = [
            image(1, |i| i.shown = true),
            image(2, |i| i.scene = true),
            image(3, |i| i.scene = true),
            image(4, |i| i.reads = vec![Name::Renderbuffer(2)]),
            image(5, |i| i.shown = true),
        ];
        assert_eq!(wanted(&images, false), [false; 5], "nothing leads from a scene to the window");
        let mut images = images;
        images[0].reads = vec![Name::Renderbuffer(4), Name::Renderbuffer(1)];
        assert_eq!(wanted(&images, false), [true, true, false, true, false]);
        assert_eq!(wanted(&images, true), [true, true, true, true, false]);
    }

    #[test]
    fn shapes() {
        let window = (1280, 720);
        for [width, height] in [[1280, 720], [640, 360], [320, 180], [427, 240], [2560, 1440]] {
            assert!(like_window([0, 0, width, height], window), "{width} × {height}");
        }
        for [width, height] in [[1024, 1024], [64, 36], [2048, 1024], [1280, 700], [0, 0]] {
            assert!(!like_window([0, 0, width, height], window), "{width} × {height}");
        }
    }
}
