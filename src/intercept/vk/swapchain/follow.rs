//! Windows follow the rig while its file changes.

use crate::error::Result;
use crate::intercept::process::live::{self, Live};
use crate::intercept::process::log;
use crate::intercept::process::settings::{self, Settings};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::swapchains::{Due, StandIn, Swapchain};
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::intercept::vk::swapchain::create::{plan, report_methods};
use crate::lock::Lock;
use crate::rig::{Camera, Rig};
use std::sync::Arc;
use std::time::{Duration, Instant};

impl Swapchain {
    /// Applies the rig as its file is now, before a picture is made. Returns whether the program
    /// should be asked for a new swapchain. While somebody edits the rig, that has to wait until the
    /// rig rests.
    ///
    /// # Safety
    /// The device must be live, and no other thread may present this swapchain meanwhile.
    pub unsafe fn follow_rig(&mut self, device: &Device) -> bool {
        let lacks_own = self.stand_in.as_ref().is_some_and(|s| device.pipelines.write() && !s.layout.read);
        self.shown = self.coming.take().unwrap_or(self.shown);
        let version = live::version();
        let is_watched = settings::settings().is_some_and(Settings::is_watched);
        if self.stand_in.is_some() && !self.failed && self.version != version {
            self.version = version;
            // SAFETY: as promised.
            let adopted = live::rig().map_or(Ok(()), |live| unsafe { self.adopt(device, &live, is_watched) });
            if let Err(error) = adopted {
                log::once(&format!("Vulkan: the rig stays as it was: {}", error.message));
            }
        }
        let rest = if is_watched { live::REST } else { Duration::ZERO };
        let Some(due) = self.due.take_if(|due| due.since.elapsed() >= rest) else { return lacks_own };
        // SAFETY: as promised.
        if due.rough
            && let Err(error) = unsafe { self.leave_rough(device) }
        {
            log::once(&format!(
                "Vulkan: a changed rig is shown roughly until the program makes its next swapchain: {}",
                error.message
            ));
            return true;
        }
        due.outdated || lacks_own
    }

    /// Shows another rig. The program's images and recorded commands fit the views that they have, so
    /// the correction is made again over these: roughly if `is_watched`, since that needs no new
    /// shaders. What the views show of the program's world is decided when commands are submitted, so
    /// a changed camera is followed as well, unless another lens is given. If planning fails, nothing
    /// changes.
    ///
    /// # Safety
    /// As for [`Swapchain::follow_rig`].
    unsafe fn adopt(&mut self, device: &Device, live: &Live, is_watched: bool) -> Result<()> {
        let Some(stand_in) = &mut self.stand_in else { return Ok(()) };
        let (old, camera, version) = (Arc::clone(&stand_in.layout), live.rig.camera, live.version);
        let (known, old_rig) = (old.session.program_camera(), old.session.rig());
        let follows = (known.lens, known.answer_wide) == (camera.lens, camera.answer_wide);
        let rig = device.role.vertices.vertices.rig(&live.rig);
        report_methods(device, &live.rig);
        if follows && *old_rig == (Rig { camera: old_rig.camera, ..rig.clone() }) {
            self.set_camera(device, camera, version);
            if let Some(due) = &mut self.due {
                due.since = Instant::now();
            }
            return Ok(());
        }
        let rough = if follows && is_watched { old.roughly_over(&rig) } else { None };
        let is_rough = rough.is_some();
        // What these views cannot serve, a plan may.
        let over = rough.or_else(|| if follows { old.over(&rig).unwrap_or_default() } else { None });
        let over = over.map(|layout| Arc::new(AtlasLayout { version, ..layout }));
        // SAFETY: as promised.
        if over.is_some_and(|layout| unsafe { stand_in.adopt(device, layout) }.is_ok()) {
            self.set_camera(device, camera, version);
            let is_planned = rig.has_views_of(old_rig);
            if !is_planned {
                log::once(
                    "Vulkan: a changed rig is shown over the views that the window has; they are planned anew for \
                     the program's next swapchain, as after a change of size",
                );
            }
            self.note_due(is_rough, !is_planned);
            return Ok(());
        }
        let new = plan(device, &live.rig, old.window, old.read)?;
        let (before, after) = (&old.plan.views, &new.plan.views);
        if follows && (&before.views, &before.panel, before.atlas) == (&after.views, &after.panel, after.atlas) {
            // SAFETY: as promised.
            unsafe { stand_in.adopt(device, Arc::new(AtlasLayout { version, ..new }))? };
            self.set_camera(device, camera, version);
            self.note_due(false, false);
            return Ok(());
        }
        log::once(
            "Vulkan: the rig's views have changed; a window follows when the program makes its next swapchain, as \
             after a change of size",
        );
        self.note_due(self.due.is_some_and(|due| due.rough), true);
        Ok(())
    }

    /// Notes what the rig that is now shown lacks. The program is also asked for a swapchain that an
    /// earlier change needs.
    fn note_due(&mut self, rough: bool, outdated: bool) {
        let outdated = outdated || self.due.is_some_and(|due| due.outdated);
        self.due = (rough || outdated).then(|| Due { since: Instant::now(), rough, outdated });
    }

    /// Shows exactly the rig that is shown roughly.
    ///
    /// # Safety
    /// As for [`Swapchain::follow_rig`].
    unsafe fn leave_rough(&mut self, device: &Device) -> Result<()> {
        let Some(stand_in) = &mut self.stand_in else { return Ok(()) };
        let rough = Arc::clone(&stand_in.layout);
        let Some(exact) = rough.over(rough.session.rig())? else { return Ok(()) };
        exact.session.set_camera(rough.session.program_camera());
        // SAFETY: as promised.
        unsafe { stand_in.adopt(device, Arc::new(AtlasLayout { version: rough.version, ..exact })) }
    }

    /// Draws by an adaptation of the program's camera from the next submission on. The next picture
    /// is then the first that shows this version of the rig.
    fn set_camera(&mut self, device: &Device, camera: Camera, version: u64) {
        let mut changes = false;
        for session in self.stand_in.iter().flat_map(StandIn::sessions) {
            changes |= session.program_camera() != camera;
            session.set_camera(camera);
        }
        if changes {
            device.frame.locked().adjust_cameras();
            self.coming = Some(version);
        } else {
            self.shown = version;
        }
    }
}
