//! Images of the program that hold a scene on its way to the window, as far as they have been
//! found.

use crate::correct::LowerLeftRect;
use crate::intercept::scene::image_graph::{self, ImageGraph};
use crate::intercept::scene::obstacle::SHOWN_SMALL;
use crate::intercept::scene::viewport::{self, alone::Viewports};
use crate::lock::Lock;
use crate::rig::Duplicate;
use ash::vk;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Greatest number of vertices of a draw that covers a viewport: one triangle, or a square.
pub const COVERING_VERTICES: u32 = 6;

/// Use of an image of the program.
pub type Made = image_graph::Made<vk::Image>;

/// Uses of the program's images, found so far.
#[derive(Default)]
pub(in crate::intercept::vk) struct Seen {
    pub(in crate::intercept::vk) graph: ImageGraph<vk::Image>,
    /// Images that compute shaders read or write.
    pub(in crate::intercept::vk) computed: HashSet<vk::Image>,
    /// Images from which compute shaders make numbers that all views share.
    pub(in crate::intercept::vk) measured: HashSet<vk::Image>,
    /// Images that the program copies to memory, for example to find the object at a position.
    pub(in crate::intercept::vk) copied: HashSet<vk::Image>,
    /// Images whose picture fills only a part of them.
    pub(in crate::intercept::vk) partial: HashSet<vk::Image>,
    /// True if something new was found.
    pub(in crate::intercept::vk) news: bool,
}

/// Number of times that the window may get a picture that is not followed, before Cupola decides
/// that it never will be. In the first frames no picture is followed.
const PATIENCE: u32 = 60;

/// Uses of the program's images.
#[derive(Default)]
pub struct SceneGraph {
    pub(in crate::intercept::vk) seen: Mutex<Seen>,
    /// Number of times that compute shaders or copies made a picture for the window that was not
    /// followed.
    unfollowed: AtomicU32,
    /// Viewports that are drawn to in images: those of all draws, and those of draws with matrices.
    viewports: Mutex<HashMap<vk::Image, [Viewports; 2]>>,
    /// Number of frames that the program presented.
    frames: AtomicU64,
}

impl SceneGraph {
    /// Begins to count such pictures anew, because the window is new or a picture is followed.
    pub(in crate::intercept::vk) fn begin_waiting(&self) {
        self.unfollowed.store(0, Ordering::Relaxed);
    }

    /// Ends a frame.
    pub(in crate::intercept::vk) fn end_frame(&self) {
        self.frames.fetch_add(1, Ordering::Relaxed);
    }

    /// Returns whether a viewport shows the main picture of an image of this size: it has more than half
    /// of the area, or is the only one, with the image's shape. Notes it for later draws.
    /// `has_matrices`: of the draw.
    pub(in crate::intercept::vk) fn is_main(
        &self,
        image: vk::Image,
        viewport: &vk::Viewport,
        (size, has_matrices): ((u32, u32), bool),
    ) -> bool {
        let [x, y, width, height] = [viewport.x, viewport.y, viewport.width, viewport.height].map(|n| n.round() as i32);
        let rect = LowerLeftRect::new(x, y.saturating_add(height.min(0)), width, height.saturating_abs());
        let frame = self.frames.load(Ordering::Relaxed);
        let mut all = self.viewports.locked();
        let [of_all, of_matrices] = all.entry(image).or_default();
        of_all.note(rect, frame);
        if has_matrices {
            of_matrices.note(rect, frame);
        }
        let seen = if of_matrices.are_unknown() { of_all } else { of_matrices };
        let area = f64::from(size.0) * f64::from(size.1);
        let main = viewport::is_main(width.into(), rect.height.into(), area)
            || seen.are_only(rect) && viewport::has_shape_of_window(rect.size(), size);
        if main && seen.are_only(rect) && rect.size() != size.into() {
            let mut seen = self.seen.locked();
            let news = seen.partial.insert(image);
            seen.news |= news;
        }
        main
    }

    /// Notes that other images may be found now.
    pub(in crate::intercept::vk) fn look_again(&self) {
        self.seen.locked().news = true;
    }

    /// Counts a picture for the window that is not followed. Returns whether it may be followed
    /// later.
    pub(in crate::intercept::vk) fn may_be_followed(&self) -> bool {
        self.unfollowed.fetch_add(1, Ordering::Relaxed) < PATIENCE
    }

    /// Notes that something is made from `image`.
    pub fn note_made(&self, image: vk::Image, to: Made) {
        let mut seen = self.seen.locked();
        let news = seen.graph.note_made(image, to);
        seen.news |= news;
    }

    /// Notes that compute shaders make `image`, or make something from it.
    pub fn note_computed(&self, image: vk::Image) {
        let mut seen = self.seen.locked();
        let news = seen.computed.insert(image);
        seen.news |= news;
    }

    /// Notes that compute shaders make numbers from `image` that all views share.
    pub fn note_measured(&self, image: vk::Image) {
        let mut seen = self.seen.locked();
        let news = seen.measured.insert(image);
        seen.news |= news;
    }

    /// Returns whether compute shaders make one of these images or make something from it. The
    /// second value is true if the results are numbers that all views share.
    pub(in crate::intercept::vk) fn is_computed(&self, images: &HashSet<vk::Image>) -> (bool, bool) {
        let seen = self.seen.locked();
        (!seen.computed.is_disjoint(images), !seen.measured.is_disjoint(images))
    }

    /// True if the picture of one of these images fills only a part of it.
    pub(in crate::intercept::vk) fn is_partial(&self, images: &HashSet<vk::Image>) -> bool {
        !self.seen.locked().partial.is_disjoint(images)
    }

    /// Notes that the program copies `image` to memory.
    pub fn note_copied(&self, image: vk::Image) {
        let mut seen = self.seen.locked();
        let news = seen.copied.insert(image);
        seen.news |= news;
    }

    /// True if the program copies a picture of its scene to memory, or an image that is drawn with
    /// it.
    pub(in crate::intercept::vk) fn is_copied(&self) -> bool {
        let seen = self.seen.locked();
        let copied = &seen.copied;
        seen.graph.scenes().any(|image| copied.contains(&image))
    }

    /// Notes that perspective draws reach `image`.
    pub fn note_scene(&self, image: vk::Image) {
        let mut seen = self.seen.locked();
        let news = seen.graph.note_scene(image);
        seen.news |= news;
    }

    /// True if something that cannot be followed is made from `image`.
    pub(in crate::intercept::vk) fn is_lost(&self, image: vk::Image) -> bool {
        let seen = self.seen.locked();
        seen.graph.makes(image, Made::Elsewhere)
    }

    /// Returns the images from which something is made that cannot be followed.
    pub(in crate::intercept::vk) fn lost(&self) -> Vec<vk::Image> {
        let seen = self.seen.locked();
        seen.graph.scenes().filter(|image| seen.graph.makes(*image, Made::Elsewhere)).collect()
    }

    /// Forgets a destroyed image.
    pub fn forget(&self, image: vk::Image) {
        self.viewports.locked().remove(&image);
        let mut seen = self.seen.locked();
        seen.graph.forget(image);
        seen.partial.remove(&image);
        seen.computed.remove(&image);
        seen.measured.remove(&image);
        seen.copied.remove(&image);
    }

    /// Returns the images that have to be drawn for each view, if something new was found since the
    /// last call.
    pub(in crate::intercept::vk) fn news(&self, rule: Duplicate) -> Option<HashSet<vk::Image>> {
        let mut seen = self.seen.locked();
        std::mem::take(&mut seen.news).then(|| seen.chosen(rule))
    }

    /// Returns the reasons why images that perspective draws reach are drawn only once, with the
    /// number of images for each reason. `shown_small`: an image was seen in a small part of the
    /// window.
    pub fn single(&self, rule: Duplicate, shown_small: impl Fn(vk::Image) -> bool) -> BTreeMap<String, u64> {
        let seen = self.seen.locked();
        let chosen = seen.chosen(rule);
        let mut reasons = BTreeMap::new();
        for image in seen.graph.scenes().filter(|image| !chosen.contains(image)) {
            let reason = match rule {
                Duplicate::Never => "the rig says so",
                _ if shown_small(image) => SHOWN_SMALL,
                _ if seen.graph.makes(image, Made::Elsewhere) => {
                    "it is read by compute shaders that cannot be followed, in parts, or by passes of another shape"
                }
                _ => "it was not found on its way to the window",
            };
            *reasons.entry(reason.to_owned()).or_default() += 1;
        }
        reasons
    }
}

impl Seen {
    /// Returns the images between a scene and the window from which only images and results are
    /// made that can be followed.
    pub(in crate::intercept::vk) fn chosen(&self, rule: Duplicate) -> HashSet<vk::Image> {
        if rule == Duplicate::Never {
            return HashSet::new();
        }
        self.graph.followed(rule == Duplicate::Always)
    }
}

#[cfg(test)]
mod tests {
    use super::{Made, SceneGraph};
    use crate::rig::Duplicate;
    use ash::vk::{self, Handle};
    use std::collections::HashSet;

    fn image(number: u64) -> vk::Image {
        vk::Image::from_raw(number)
    }

    fn chosen(paths: &SceneGraph, rule: Duplicate) -> Vec<u64> {
        let seen = paths.seen.lock().expect("no panic");
        let mut all: Vec<u64> = seen.chosen(rule).into_iter().map(Handle::as_raw).collect();
        all.sort_unstable();
        all
    }

    #[test]
    fn what_lies_between_a_scene_and_the_window_is_chosen() {
        let paths = SceneGraph::default();
        paths.note_scene(image(1));
        paths.note_scene(image(5));
        assert!(chosen(&paths, Duplicate::Auto).is_empty(), "nothing is on the window yet");
        paths.note_made(image(1), Made::Image(image(2)));
        paths.note_made(image(2), Made::Window);
        paths.note_made(image(9), Made::Window);
        assert_eq!(chosen(&paths, Duplicate::Auto), [1, 2], "5 goes nowhere, 9 is no scene");
        assert_eq!(chosen(&paths, Duplicate::Always), [1, 2, 5]);
        assert!(chosen(&paths, Duplicate::Never).is_empty());
        assert_eq!(paths.single(Duplicate::Auto, |_| false).values().sum::<u64>(), 1);
    }

    #[test]
    fn what_cannot_be_followed_takes_with_it_what_it_is_made_of() {
        let paths = SceneGraph::default();
        paths.note_scene(image(1));
        paths.note_made(image(1), Made::Image(image(2)));
        paths.note_made(image(1), Made::Window);
        paths.note_made(image(2), Made::Window);
        paths.note_made(image(2), Made::Elsewhere);
        assert!(chosen(&paths, Duplicate::Auto).is_empty());
        paths.forget(image(2));
        assert_eq!(chosen(&paths, Duplicate::Auto), [1]);
    }

    #[test]
    fn news_are_told_once() {
        let paths = SceneGraph::default();
        assert!(paths.news(Duplicate::Auto).is_none());
        paths.note_scene(image(1));
        paths.note_made(image(1), Made::Window);
        assert_eq!(paths.news(Duplicate::Auto), Some(HashSet::from([image(1)])));
        paths.note_made(image(1), Made::Window);
        assert!(paths.news(Duplicate::Auto).is_none());
    }

    #[test]
    fn images_in_a_circle_do_no_harm() {
        let paths = SceneGraph::default();
        paths.note_scene(image(1));
        paths.note_made(image(1), Made::Image(image(2)));
        paths.note_made(image(2), Made::Image(image(1)));
        assert!(chosen(&paths, Duplicate::Auto).is_empty());
        paths.note_made(image(2), Made::Window);
        assert_eq!(chosen(&paths, Duplicate::Auto), [1, 2]);
    }
}
