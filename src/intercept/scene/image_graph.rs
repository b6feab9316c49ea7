//! Images between a scene and the window. They are drawn once per view.
//!
//! ```text
//! perspective draws → image ─ sampled by → image ─ shown on → window
//!                       └──── sampled by → something that cannot be followed
//! ```

use std::collections::{HashMap, HashSet};
use std::hash::Hash;

/// Result that is made from an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Made<Id> {
    /// A part of the window's picture.
    Window,
    /// Another image.
    Image(Id),
    /// Something that cannot be followed.
    Elsewhere,
}

/// The program's images, as far as scenes are concerned.
#[derive(Clone, Debug)]
pub struct ImageGraph<Id> {
    scenes: HashSet<Id>,
    made: HashMap<Id, HashSet<Made<Id>>>,
}

impl<Id> Default for ImageGraph<Id> {
    fn default() -> Self {
        Self { scenes: HashSet::new(), made: HashMap::new() }
    }
}

impl<Id: Copy + Eq + Hash> ImageGraph<Id> {
    /// Notes that perspective draws reach `image`. Returns whether this is new.
    pub fn note_scene(&mut self, image: Id) -> bool {
        self.scenes.insert(image)
    }

    /// Notes the result that is made from `image`. Returns whether this is new.
    pub fn note_made(&mut self, image: Id, made: Made<Id>) -> bool {
        self.made.entry(image).or_default().insert(made)
    }

    /// Forgets an image that was destroyed.
    pub fn forget(&mut self, image: Id) {
        self.scenes.remove(&image);
        self.made.remove(&image);
        self.made.values_mut().for_each(|made| _ = made.remove(&Made::Image(image)));
    }

    /// The images to which perspective draws go.
    pub fn scenes(&self) -> impl Iterator<Item = Id> {
        self.scenes.iter().copied()
    }

    /// True if `made` is made from `image`.
    pub fn makes(&self, image: Id, made: Made<Id>) -> bool {
        self.made.get(&image).is_some_and(|all| all.contains(&made))
    }

    /// True if anything is made from `image`.
    pub fn makes_anything(&self, image: Id) -> bool {
        self.made.get(&image).is_some_and(|all| !all.is_empty())
    }

    /// Returns the images on a path from a scene to the window. `always`: also images whose path to
    /// the window is not known.
    pub fn between(&self, always: bool) -> HashSet<Id> {
        let mut images = self.reached();
        if !always {
            let shown = self.to_window(&images);
            images.retain(|image| shown.contains(image));
        }
        images
    }

    /// Returns those of [`between`](Self::between) from which only other returned images or the
    /// window are made. If anything else is made from an image, that image is left out, and so are
    /// the images that it is made from.
    pub fn followed(&self, always: bool) -> HashSet<Id> {
        let mut images = self.reached();
        loop {
            let shown = self.to_window(&images);
            let kept = |made: &Made<Id>| match made {
                Made::Window => true,
                Made::Image(to) => images.contains(to),
                Made::Elsewhere => false,
            };
            let follows = |image: &Id| (always || shown.contains(image)) && self.made_of(image).all(kept);
            let left: HashSet<Id> = images.iter().copied().filter(follows).collect();
            if left.len() == images.len() {
                return left;
            }
            images = left;
        }
    }

    fn made_of(&self, image: &Id) -> impl Iterator<Item = &Made<Id>> {
        self.made.get(image).into_iter().flatten()
    }

    fn images_of(&self, image: &Id) -> impl Iterator<Item = Id> {
        self.made_of(image).filter_map(|made| if let Made::Image(to) = made { Some(*to) } else { None })
    }

    /// Returns the scenes, and all images that are made from them.
    fn reached(&self) -> HashSet<Id> {
        let mut found = self.scenes.clone();
        let mut new: Vec<Id> = found.iter().copied().collect();
        while let Some(image) = new.pop() {
            new.extend(self.images_of(&image).filter(|to| found.insert(*to)));
        }
        found
    }

    /// Returns those of `images` that lead to the window through other ones of them.
    fn to_window(&self, images: &HashSet<Id>) -> HashSet<Id> {
        let on_window = |image: &Id| self.makes(*image, Made::Window);
        let mut shown: HashSet<Id> = images.iter().copied().filter(on_window).collect();
        let next = |shown: &HashSet<Id>| {
            let leads = |image: &Id| !shown.contains(image) && self.images_of(image).any(|to| shown.contains(&to));
            images.iter().copied().find(leads)
        };
        while let Some(image) = next(&shown) {
            shown.insert(image);
        }
        shown
    }
}

#[cfg(test)]
mod tests {
    use super::{ImageGraph, Made};
    use std::collections::HashSet;

    fn graph(scenes: &[u32], made: &[(u32, Made<u32>)]) -> ImageGraph<u32> {
        let mut graph = ImageGraph::default();
        scenes.iter().for_each(|image| assert!(graph.note_scene(*image)));
        made.iter().for_each(|(image, made)| assert!(graph.note_made(*image, *made)));
        graph
    }

    fn sorted(images: HashSet<u32>) -> Vec<u32> {
        let mut images: Vec<u32> = images.into_iter().collect();
        images.sort_unstable();
        images
    }

    #[test]
    fn a_chain_is_found_and_what_hangs_beside_it_is_not() {
        let mut graph = graph(&[2, 3], &[(1, Made::Window), (2, Made::Image(4)), (5, Made::Window)]);
        assert!(graph.between(false).is_empty(), "nothing leads from a scene to the window");
        graph.note_made(4, Made::Image(1));
        graph.note_made(1, Made::Image(1));
        assert_eq!(sorted(graph.between(false)), [1, 2, 4]);
        assert_eq!(sorted(graph.between(true)), [1, 2, 3, 4]);
        assert_eq!(sorted(graph.followed(false)), [1, 2, 4]);
    }

    #[test]
    fn what_cannot_be_followed_takes_with_it_what_it_is_made_of() {
        let mut graph = graph(&[1], &[(1, Made::Image(2)), (1, Made::Window), (2, Made::Window), (2, Made::Elsewhere)]);
        assert!(graph.followed(false).is_empty());
        assert_eq!(sorted(graph.between(false)), [1, 2]);
        graph.forget(2);
        assert_eq!(sorted(graph.followed(false)), [1]);
    }

    #[test]
    fn circles_end() {
        let graph = graph(&[1], &[(1, Made::Image(2)), (2, Made::Image(1)), (2, Made::Window)]);
        assert_eq!(sorted(graph.followed(false)), [1, 2]);
        assert_eq!(sorted(graph.between(false)), [1, 2]);
    }

    #[test]
    fn news_are_told() {
        let mut graph = graph(&[1], &[(1, Made::Window)]);
        assert!(!graph.note_scene(1) && !graph.note_made(1, Made::Window));
        assert!(graph.note_scene(2) && graph.makes(1, Made::Window) && !graph.makes_anything(2));
    }
}
