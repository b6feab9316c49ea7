//! Images of the program that lie between a scene and the window.

use crate::intercept::gl::state::offscreen::images::Image;
use crate::intercept::scene::image_graph::{ImageGraph, Made};

/// Returns for each image whether it is to be drawn once per view. `always`: includes images that
/// no draw was seen to bring to the window.
pub fn wanted(images: &[Image], always: bool) -> Vec<bool> {
    let mut graph = ImageGraph::default();
    for image in images {
        if image.scene || image.copies_window {
            graph.note_scene(image.name);
        }
        if image.displayed {
            graph.note_made(image.name, Made::Window);
        }
        for from in &image.reads {
            graph.note_made(*from, Made::Image(image.name));
        }
    }
    let between = graph.between(always);
    if images.iter().any(|image| image.lost && between.contains(&image.name)) {
        return vec![false; images.len()];
    }
    images.iter().map(|image| between.contains(&image.name)).collect()
}

#[cfg(test)]
mod tests {
    use super::wanted;
    use crate::intercept::gl::state::offscreen::images::{Image, Name};

    fn image(name: u32, set: impl FnOnce(&mut Image)) -> Image {
        let plain = Image::new(Name::Renderbuffer(name), [64, 64, 0, 0, 0, 0, 0]).expect("a size that images have");
        let mut image = Image { format: 0, mask: 0, ..plain };
        set(&mut image);
        image
    }

    #[test]
    fn a_chain_is_wanted_and_what_hangs_beside_it_is_not() {
        let mut images = [
            image(1, |i| i.displayed = true),
            image(2, |i| i.scene = true),
            image(3, |i| i.scene = true),
            image(4, |i| i.reads = vec![Name::Renderbuffer(2)]),
            image(5, |i| i.displayed = true),
        ];
        assert_eq!(wanted(&images, false), [false; 5], "nothing leads from a scene to the window");
        images[0].reads = vec![Name::Renderbuffer(4), Name::Renderbuffer(1)];
        assert_eq!(wanted(&images, false), [true, true, false, true, false]);
        assert_eq!(wanted(&images, true), [true, true, true, true, false]);
    }
}
