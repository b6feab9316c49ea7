//! Scenes off screen get new views when the window does.
//!
//! A program that makes a new swapchain may keep the images that it draws its scene to, although
//! the rig's file changed the views. These images get the new views at once. View copies of the old
//! views are kept as long as recorded commands sample them. Atlases and other atlas copies are kept
//! until the program destroys its image, because recorded barriers may name them. They are used
//! again if the same size is needed again.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::scene::viewport;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::images::{Image, Images};
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::intercept::vk::state::views::view_target::ViewTarget;
use crate::lock::Lock;
use std::sync::Arc;
use std::sync::atomic::Ordering;

impl Images {
    /// Gives the images that hold a scene the window's new layout, or new layouts of off-screen
    /// scenes.
    ///
    /// # Errors
    /// The request that the driver refuses. The image is then drawn as the program's own.
    pub fn follow(&self, device: &Device, layout: &Arc<AtlasLayout>) -> Result<(), Obstacle> {
        device.scene_graph.begin_waiting();
        for image in self.duplicated() {
            let old = {
                let mut images = self.images.locked();
                let fits = |state: &Image| {
                    // A part of another window is not known until it is seen again.
                    let in_part = state.target.as_ref().is_some_and(|target| target.layout.part.is_some());
                    in_part || viewport::has_shape(state.size, layout.window)
                };
                let state = images.get_mut(&image).filter(|state| fits(state));
                let even = self.even.load(Ordering::Relaxed);
                let own_read = self.own_read.load(Ordering::Relaxed);
                let other = |target: &mut Arc<ViewTarget>| {
                    let known = &target.layout;
                    !known.has_views_of(layout) || known.even != even || even && own_read && known.own().is_none()
                };
                state.and_then(|state| state.target.take_if(other))
            };
            if let Some(old) = old {
                self.retired.locked().push(old);
                self.duplicate(device, image, layout)?;
            }
        }
        Ok(())
    }

    /// Destroys view copies that no recorded commands use any more.
    pub fn sweep(&self, device: &Device) {
        let unused: Vec<Arc<ViewTarget>> = {
            let mut retired = self.retired.locked();
            // Recordings hold references to the targets that they use, and are dropped only when
            // the device has finished with them.
            retired.extract_if(.., |target| Arc::strong_count(target) == 1).collect()
        };
        unused.iter().for_each(|target| self.destroy_view_copies(device, target));
    }

    /// Destroys all retired targets, before the device is destroyed.
    pub fn clear(&self, device: &Device) {
        let mut all = std::mem::take(&mut *self.retired.locked());
        all.extend(self.of_window.locked().take());
        all.iter().for_each(|target| self.destroy_view_copies(device, target));
        self.clear_coverage(device);
    }

    /// Destroys the view copies of a scene and their views.
    pub(in crate::intercept::vk) fn destroy_view_copies(&self, device: &Device, target: &ViewTarget) {
        for view_copy in target.view_copies.iter().chain(&target.nothing) {
            self.pending.locked().retain(|pending| pending.image != view_copy.image);
            let mut views = self.views.locked();
            let atlas_copies =
                views.values_mut().flat_map(|view| view.atlas_copies.extract_if(.., |(of, _)| *of == view_copy.image));
            // SAFETY: both are objects of Cupola, and the device has finished with them.
            unsafe {
                atlas_copies.for_each(|(_, view)| device.driver.functions.destroy_image_view(view, None));
                view_copy.destroy(&device.driver);
            }
        }
    }
}
