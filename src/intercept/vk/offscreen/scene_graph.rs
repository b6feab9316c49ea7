//! Scenes that are drawn off screen: which of the program's images hold a scene on its way to the window.
//!
//! What each image gets, and what is made of it, is remembered as it is recorded. Between two frames those images are
//! found that perspective draws reach and that lead to the window: by a flat draw of a few vertices over all of it
//! that samples the image, or by a copy of the whole. From then on they are drawn once for each view.

use crate::intercept::scene::image_graph::{self, ImageGraph};
use crate::intercept::vk::commands::recording::Recording;
use crate::intercept::vk::layer::device::Device;
use crate::intercept::vk::submit::draw_groups::{self, Source};
use crate::intercept::{lens, settings};
use crate::rig::Duplicate;
use ash::vk;
use std::collections::{BTreeMap, HashSet};
use std::sync::{Mutex, PoisonError};

/// A draw of as many vertices covers a viewport: one triangle, or a square.
pub const FEW: u32 = 6;

/// Passes that were recorded before, for the program's own image, are given up after so many.
pub const PATIENCE: u32 = 8;

/// What is made of an image of the program.
pub type Made = image_graph::Made<vk::Image>;

/// What was seen of the program's images.
#[derive(Default)]
struct Seen {
    graph: ImageGraph<vk::Image>,
    /// Something was seen for the first time.
    news: bool,
}

/// See the module.
#[derive(Default)]
pub struct Paths {
    seen: Mutex<Seen>,
}

impl Paths {
    /// Something is made of `image`.
    pub fn leads(&self, image: vk::Image, to: Made) {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let news = seen.graph.note_made(image, to);
        seen.news |= news;
    }

    /// Perspective draws reach `image`.
    pub fn is_scene(&self, image: vk::Image) {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let news = seen.graph.note_scene(image);
        seen.news |= news;
    }

    /// Whether something is made of `image` that cannot be followed.
    fn strays(&self, image: vk::Image) -> bool {
        let seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        seen.graph.makes(image, Made::Elsewhere)
    }

    /// An image is gone.
    pub fn forget(&self, image: vk::Image) {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        seen.graph.forget(image);
    }

    /// The images that have to be drawn for each view, if something new was seen since this was asked last.
    fn news(&self, rule: Duplicate) -> Option<HashSet<vk::Image>> {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut seen.news).then(|| seen.chosen(rule))
    }

    /// Why images that perspective draws reach are drawn once only, with their number.
    pub fn single(&self, rule: Duplicate) -> BTreeMap<String, u64> {
        let seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let chosen = seen.chosen(rule);
        let mut reasons = BTreeMap::new();
        for image in seen.graph.scenes().filter(|image| !chosen.contains(image)) {
            let reason = match rule {
                Duplicate::Never => "the rig says so",
                _ if seen.graph.makes(image, Made::Elsewhere) => {
                    "it is read by compute shaders, in parts, or by passes of another size"
                }
                _ => "it was not seen on the window",
            };
            *reasons.entry(reason.to_owned()).or_default() += 1;
        }
        reasons
    }
}

impl Seen {
    /// Those images between a scene and the window of which nothing is made that cannot be followed.
    fn chosen(&self, rule: Duplicate) -> HashSet<vk::Image> {
        if rule == Duplicate::Never {
            return HashSet::new();
        }
        self.graph.followed(rule == Duplicate::Always)
    }
}

/// A frame ended: images that were found to hold a scene on its way to the window are drawn for each view from now on.
pub fn decide(device: &Device) {
    device.images.sweep(device);
    let Some(settings) = settings::settings() else { return };
    let Some(chosen) = device.paths.news(settings.rig.views.duplicate) else { return };
    if !device.draws_views() {
        return;
    }
    let Some(layout) = device.latest_layout() else { return };
    for image in &chosen {
        if let Err(why) = device.images.duplicate(device, *image, &layout) {
            return device.give_up(&why);
        }
    }
    if device.images.duplicated().any(|image| device.paths.strays(image)) {
        device.give_up("a picture of its scene is used in a way that was not seen before");
    }
}

/// What a draw in a pass that is not drawn for each view says of the images that it draws to. The matrices that it may use
/// are looked at when the commands run.
pub fn drawn(
    device: &Device,
    recording: &mut Recording,
    matrices: &[crate::intercept::vk::spirv::Matrix],
    (main, few): (bool, bool),
) {
    let Some(targets) = recording.plain.clone() else { return };
    let follows = main && (few || !matrices.is_empty()) && !targets.is_empty();
    for picture in pictures(device, recording) {
        let made = targets.iter().map(|target| Made::Image(*target)).filter(|_| follows);
        let elsewhere = (!follows).then_some(Made::Elsewhere);
        made.chain(elsewhere).for_each(|made| device.paths.leads(picture, made));
    }
    if !main || targets.is_empty() {
        return;
    }
    let sources: Vec<Source> =
        matrices.iter().filter_map(|matrix| draw_groups::source(device, recording, matrix)).collect();
    recording.suspect(targets, sources);
}

/// The images that may hold a scene among what shaders of the next draw can sample.
pub fn pictures(device: &Device, recording: &Recording) -> Vec<vk::Image> {
    if !device.images.has_candidates() {
        return Vec::new();
    }
    let sets =
        recording.pipeline.as_ref().and_then(|pipeline| pipeline.layout.as_ref()).map_or(0, |layout| layout.ours);
    let bound = recording.bound.iter().take(sets as usize).flatten();
    let images = bound.flat_map(|bound| device.descriptors.pictures(bound.set)).collect::<Vec<_>>();
    images.into_iter().filter_map(|view| device.images.candidate_of(view)).collect()
}

/// Draws with these matrices ran in passes to these images.
pub fn ran(device: &Device, targets: &[vk::Image], sources: &[Source]) {
    let matrices: Vec<_> = sources
        .iter()
        .filter_map(|source| draw_groups::matrix(device, source).map(|m| (source.matrix.rank, m)))
        .collect();
    if lens::find(matrices.iter().map(|(rank, value)| (*rank, value))).is_none() {
        return;
    }
    for target in targets {
        device.paths.is_scene(*target);
        if device.images.shown_image(*target).is_some_and(|shown| shown.was_missed()) {
            device.give_up("the commands that draw its scene were recorded before it was seen on the window");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Made, Paths};
    use crate::rig::Duplicate;
    use ash::vk::{self, Handle};
    use std::collections::HashSet;

    fn image(number: u64) -> vk::Image {
        vk::Image::from_raw(number)
    }

    fn chosen(paths: &Paths, rule: Duplicate) -> Vec<u64> {
        let seen = paths.seen.lock().expect("no panic");
        let mut all: Vec<u64> = seen.chosen(rule).into_iter().map(Handle::as_raw).collect();
        all.sort_unstable();
        all
    }

    #[test]
    fn what_lies_between_a_scene_and_the_window_is_chosen() {
        let paths = Paths::default();
        paths.is_scene(image(1));
        paths.is_scene(image(5));
        assert!(chosen(&paths, Duplicate::Auto).is_empty(), "nothing is on the window yet");
        paths.leads(image(1), Made::Image(image(2)));
        paths.leads(image(2), Made::Window);
        paths.leads(image(9), Made::Window);
        assert_eq!(chosen(&paths, Duplicate::Auto), [1, 2], "5 goes nowhere, 9 is no scene");
        assert_eq!(chosen(&paths, Duplicate::Always), [1, 2, 5]);
        assert!(chosen(&paths, Duplicate::Never).is_empty());
        assert_eq!(paths.single(Duplicate::Auto).values().sum::<u64>(), 1);
    }

    #[test]
    fn what_cannot_be_followed_takes_with_it_what_it_is_made_of() {
        let paths = Paths::default();
        paths.is_scene(image(1));
        paths.leads(image(1), Made::Image(image(2)));
        paths.leads(image(1), Made::Window);
        paths.leads(image(2), Made::Window);
        paths.leads(image(2), Made::Elsewhere);
        assert!(chosen(&paths, Duplicate::Auto).is_empty());
        paths.forget(image(2));
        assert_eq!(chosen(&paths, Duplicate::Auto), [1]);
    }

    #[test]
    fn news_are_told_once() {
        let paths = Paths::default();
        assert!(paths.news(Duplicate::Auto).is_none());
        paths.is_scene(image(1));
        paths.leads(image(1), Made::Window);
        assert_eq!(paths.news(Duplicate::Auto), Some(HashSet::from([image(1)])));
        paths.leads(image(1), Made::Window);
        assert!(paths.news(Duplicate::Auto).is_none());
    }

    #[test]
    fn images_in_a_circle_do_no_harm() {
        let paths = Paths::default();
        paths.is_scene(image(1));
        paths.leads(image(1), Made::Image(image(2)));
        paths.leads(image(2), Made::Image(image(1)));
        assert!(chosen(&paths, Duplicate::Auto).is_empty());
        paths.leads(image(2), Made::Window);
        assert_eq!(chosen(&paths, Duplicate::Auto), [1, 2]);
    }
}
