//! The end of a frame: its picture is corrected, counted, captured and presented.

use crate::correct::PixelRect;
use crate::error::{Error, ErrorKind, Result};
use crate::intercept::inspection::common_statistics;
use crate::intercept::inspection::last_frame::{self, LastFrame};
use crate::intercept::process::clock;
use crate::intercept::process::ending;
use crate::intercept::process::settings::Settings;
use crate::intercept::process::{log, nodes, publishing, settings};
use crate::intercept::scene::flat_program::OffScreen;
use crate::intercept::vk::state::device;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::Queue;
use crate::intercept::vk::state::driver::structures::slice;
use crate::intercept::vk::state::swapchains::Swapchain;
use crate::intercept::vk::swapchain::{publish, read_back};
use crate::lock::Lock;
use crate::rig::{Duplicate, Rig};
use crate::runtime::run_results::{Picture, Statistics, ViewStatistics};
use crate::system::thread_time;
use ash::vk::{self, Handle};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// `vkQueuePresentKHR`.
///
/// # Safety
/// Called by the program.
pub unsafe extern "system" fn present(queue: vk::Queue, info: *const vk::PresentInfoKHR<'_>) -> vk::Result {
    let Some(device) = device::get(queue) else { return vk::Result::ERROR_INITIALIZATION_FAILED };
    // SAFETY: the program's structure.
    let mut changed = unsafe { *info };
    if ending::has_begun() {
        // SAFETY: the program's own call.
        return unsafe { (device.driver.swapchain.queue_present_khr)(queue, &changed) };
    }
    ending::watch(None);
    let frames = device.presented.frames.fetch_add(1, Ordering::Relaxed) + 1;
    let settings = settings::settings();
    let last = settings.is_some_and(|settings| last_frame::is_last(settings, frames));
    let (mut ready, mut outdated) = (None, false);
    // SAFETY: the program presents on this queue, so that no other thread uses it.
    let prepared = crate::fence::guard(|| unsafe {
        outdated = follow_rig(&device, &changed);
        outdated |= !prepare(&device, queue, &changed, frames, last, &mut ready);
    });
    if prepared.is_none() {
        log::once("Vulkan: a frame could not be corrected after a failure");
    }
    if let Some(ready) = &ready {
        // Cupola's semaphores are signalled after the program's, so they replace them.
        changed = changed.wait_semaphores(ready);
    }
    // SAFETY: the lengths and arrays of the program's structure.
    if let Some(first) = unsafe { slice(changed.p_swapchains, changed.swapchain_count) }.first() {
        // A late frame is presented all the same, because an acquired image has to be presented.
        let size = || {
            let extent = device.swapchains.managed(*first).map(|managed| managed.locked().extent).unwrap_or_default();
            (extent.width, extent.height)
        };
        nodes::end_frame(clock::window_of_swapchain(first.as_raw()), size);
    }
    // SAFETY: the program's own call; the structure differs only in its semaphores.
    let result = unsafe { (device.driver.swapchain.queue_present_khr)(queue, &changed) };
    device.host_memory.end_frame();
    if last {
        last_frame::end_program();
    }
    if let Some(settings) = settings {
        last_frame::begin(settings, frames + 1);
    }
    if result == vk::Result::SUCCESS && outdated { vk::Result::SUBOPTIMAL_KHR } else { result }
}

/// Applies changes of the rig's file to the presented swapchains. Returns whether the program
/// should make new ones.
///
/// # Safety
/// As for [`present`].
unsafe fn follow_rig(device: &Device, info: &vk::PresentInfoKHR<'_>) -> bool {
    // SAFETY: the lengths and arrays of the program's structure.
    let swapchains = unsafe { slice(info.p_swapchains, info.swapchain_count) };
    let mut outdated = false;
    for handle in swapchains {
        if let Some(managed) = device.swapchains.managed(*handle) {
            // SAFETY: as promised.
            outdated |= unsafe { managed.locked().follow_rig(device) };
        }
    }
    outdated
}

/// Corrects each image that is presented. `ready` gets the semaphores that the presentation has to
/// wait for instead of the program's, if the program's were waited for here. Returns whether each
/// image has a picture.
///
/// # Safety
/// As for [`present`].
unsafe fn prepare(
    device: &Device,
    queue: vk::Queue,
    info: &vk::PresentInfoKHR<'_>,
    frames: u64,
    last: bool,
    ready: &mut Option<Vec<vk::Semaphore>>,
) -> bool {
    device.scene_graph.end_frame();
    device.frame.locked().end(device.draws_views(), || off_screen(device));
    crate::intercept::vk::offscreen::coverage::take_results(device);
    crate::intercept::vk::offscreen::scene_graph::decide(device);
    let Some(settings) = settings::settings() else { return true };
    if settings.needs_statistics() {
        device.presented.times.locked().end_frame();
    }
    // SAFETY: the lengths and arrays of the program's structure; empty arrays may be null.
    let (swapchains, indices, waits) = unsafe {
        (
            slice(info.p_swapchains, info.swapchain_count),
            slice(info.p_image_indices, info.swapchain_count),
            slice(info.p_wait_semaphores, info.wait_semaphore_count),
        )
    };
    let mut complete = true;
    let mut presentation =
        Presentation { device, settings, queue: device.queue(queue), number: frames, last, waits, ready };
    for (handle, &index) in swapchains.iter().zip(indices) {
        let Some(managed) = device.swapchains.managed(*handle) else { continue };
        // SAFETY: as promised; the handle is that of the swapchain.
        complete &= unsafe { presentation.prepare(*handle, &mut managed.locked(), index as usize) };
    }
    complete
}

/// One call of `vkQueuePresentKHR`.
struct Presentation<'a> {
    device: &'a Device,
    settings: &'a Settings,
    queue: Queue,
    /// Number of this frame, from 1.
    number: u64,
    /// True if the program ends after this frame.
    last: bool,
    /// Semaphores that the next submission has to wait for. Only the first submission waits for
    /// them, since later commands on the queue come after it.
    waits: &'a [vk::Semaphore],
    /// Semaphores for which the presentation waits, as for [`prepare`].
    ready: &'a mut Option<Vec<vk::Semaphore>>,
}

impl Presentation<'_> {
    /// Corrects, publishes and captures image `index` of a swapchain. Returns whether the image has
    /// a picture.
    ///
    /// # Safety
    /// As for [`present`].
    unsafe fn prepare(&mut self, handle: vk::SwapchainKHR, managed: &mut Swapchain, index: usize) -> bool {
        let timed = self.settings.needs_statistics();
        // SAFETY: as promised.
        let made = unsafe { timed_make(self.device, self.queue, managed, index, self.waits, timed) };
        if let PictureOutcome::Submitted(signal) = made {
            self.submitted(Some(signal));
        }
        if publishing::wants(handle.as_raw(), managed.shown) {
            // SAFETY: as promised.
            unsafe { self.publish(managed, index) };
        }
        if (self.last || self.settings.frames.is_none()) && self.settings.has_report() {
            // SAFETY: as promised.
            unsafe { self.store(managed, index, timed) };
        }
        !matches!(made, PictureOutcome::Lost)
    }

    /// Notes a submission that waited for [`Presentation::waits`], and the semaphore that it
    /// signals.
    fn submitted(&mut self, signal: Option<vk::Semaphore>) {
        self.ready.get_or_insert_default().extend(signal);
        self.waits = &[];
    }

    /// # Safety
    /// As for [`present`].
    unsafe fn publish(&mut self, managed: &mut Swapchain, index: usize) {
        // SAFETY: as promised.
        match unsafe { publish::frame(self.device, self.queue, managed, index, self.waits, self.number) } {
            Ok(Some(copied)) => self.submitted(Some(copied)),
            Ok(None) => {}
            Err(error) => log::once(&format!("Vulkan: a frame could not be published: {error}")),
        }
        if let Some(reading) = managed.publishing.as_mut().filter(|_| self.last) {
            reading.publish(&self.device.driver, true);
        }
    }

    /// Stores pictures and statistics for the exit report.
    ///
    /// # Safety
    /// As for [`present`].
    unsafe fn store(&mut self, managed: &Swapchain, index: usize, timed: bool) {
        let (device, settings) = (self.device, self.settings);
        let mut kept = LastFrame { statistics: None, times: None, pictures: Vec::new(), views: Vec::new() };
        if last_frame::wants_outputs(settings) || last_frame::wants_views(settings) {
            // SAFETY: as promised.
            match unsafe { captured(device, self.queue, managed, index, self.waits, settings) } {
                Ok((outputs, views)) => {
                    (kept.pictures, kept.views) = (outputs, views);
                    self.submitted(None);
                }
                Err(error) => log::once(&format!("Vulkan: a frame could not be captured: {error}")),
            }
        }
        if self.last {
            wait_for_counts(device, managed);
        }
        kept.times = timed.then(|| Arc::clone(&device.presented.times));
        kept.statistics = timed.then(|| statistics(device, managed, &settings.rig, self.number));
        device.presented.report.store(last_frame::store(kept), Ordering::Relaxed);
    }
}

/// Waits until the counts of the last frame are complete.
fn wait_for_counts(device: &Device, managed: &Swapchain) {
    if let Some(stand_in) = &managed.stand_in {
        // SAFETY: the device is live.
        unsafe { stand_in.wait(device) };
    }
}

/// As [`make`], and adds its time to the statistics if `timed`.
///
/// # Safety
/// As for [`present`].
unsafe fn timed_make(
    device: &Device,
    queue: Queue,
    managed: &mut Swapchain,
    index: usize,
    waits: &[vk::Semaphore],
    timed: bool,
) -> PictureOutcome {
    let before = timed.then(thread_time);
    // SAFETY: as promised.
    let made = unsafe { make(device, queue, managed, index, waits) };
    if let Some(before) = before {
        device.presented.times.locked().correction.add(thread_time().saturating_sub(before));
    }
    made
}

/// Returns the kind of the program's drawing to images.
fn off_screen(device: &Device) -> OffScreen {
    let rule = settings::settings().map_or(Duplicate::Auto, |settings| settings.rig.views.duplicate);
    match device.single_images(rule).into_keys().next() {
        Some(reason) => OffScreen::Scene(Some(reason)),
        None if device.images.has_candidates() => OffScreen::Flat,
        None => OffScreen::Nothing,
    }
}

/// How the picture of a window was made.
enum PictureOutcome {
    /// Its commands were submitted; the semaphore is signalled when it can be presented.
    Submitted(vk::Semaphore),
    /// The program draws to the real image.
    AsItIs,
    /// The driver refuses the commands.
    Lost,
}

/// Makes the window's picture: the corrected one, or after a failure the program's own. If the
/// driver refuses this as well, the program is asked for a new swapchain, which is left alone.
///
/// # Safety
/// As for [`present`].
unsafe fn make(
    device: &Device,
    queue: Queue,
    managed: &mut Swapchain,
    index: usize,
    waits: &[vk::Semaphore],
) -> PictureOutcome {
    loop {
        let show = managed.show(index);
        let Some((show, stand_in)) = show.zip(managed.stand_in.as_mut()) else { return PictureOutcome::AsItIs };
        // SAFETY: as promised.
        match unsafe { stand_in.submit(device, queue, index, show, waits) } {
            Ok(signal) => return PictureOutcome::Submitted(signal),
            Err(error) if managed.failed => {
                log::once(&format!(
                    "Vulkan: frames are lost until the program makes a new swapchain: {}",
                    error.message
                ));
                device.swapchains.given_up.store(true, Ordering::Relaxed);
                return PictureOutcome::Lost;
            }
            Err(error) => {
                // Drawing that is recorded from now on goes to that picture, and not to views.
                device.flatness.show_own(&error.message);
                managed.failed = true;
            }
        }
    }
}

/// Returns the outputs of the frame that was just made, and the views that they were made from.
///
/// # Safety
/// As for [`present`].
unsafe fn captured(
    device: &Device,
    queue: Queue,
    managed: &Swapchain,
    index: usize,
    mut waits: &[vk::Semaphore],
    settings: &Settings,
) -> Result<(Vec<Picture>, Vec<Picture>)> {
    let failed = |error: vk::Result| Error::new(ErrorKind::Graphics, error.to_string());
    let vk::Extent2D { width, height } = managed.extent;
    let texel_format = managed.texel_format;
    let cut = |bytes: &[u8], name: &str, rect: PixelRect| read_back::cut(bytes, width, texel_format, name, rect);
    let (Some(&real), Some(given)) = (managed.real.get(index), managed.given(index)) else {
        return Ok(Default::default());
    };
    let mut read = |image| {
        // SAFETY: the images are live, as large as the window, and can be copied.
        let bytes = unsafe { read_back::read(device, queue, image, texel_format.size(), managed.extent, waits) }
            .map_err(failed);
        waits = &[];
        bytes
    };
    let corrected = read(real)?;
    let now = managed.stand_in.as_ref().map(|stand_in| stand_in.layout.session.rig());
    let rig = now.unwrap_or(&settings.rig);
    let outputs = match &managed.stand_in {
        Some(_) => {
            let places = rig.outputs.iter().zip(rig.layout((width, height))).filter(|(output, _)| output.here);
            places.map(|(output, rect)| cut(&corrected, &output.name, rect)).collect()
        }
        None => {
            let name = rig.outputs.first().map_or("window", |output| &output.name);
            vec![cut(&corrected, name, PixelRect::new(0, 0, width, height))]
        }
    };
    if !last_frame::wants_views(settings) {
        return Ok((outputs, Vec::new()));
    }
    let views = match &managed.stand_in {
        Some(stand_in) if stand_in.in_views(index) => {
            let (layout, atlas) = (&stand_in.layout, stand_in.atlas(index).unwrap_or_default());
            let extent = vk::Extent2D { width: layout.atlas.0, height: layout.atlas.1 };
            // SAFETY: the atlas has the size of its layout, and is in the layout for presentation.
            let bytes =
                unsafe { read_back::read(device, queue, atlas, texel_format.size(), extent, &[]) }.map_err(failed)?;
            let tiles = layout.tiles();
            tiles.map(|(name, rect)| read_back::cut(&bytes, extent.width, texel_format, name, rect)).collect()
        }
        _ => vec![cut(&read(given)?, "program", PixelRect::new(0, 0, width, height))],
    };
    Ok((outputs, views))
}

/// Returns the number of primitives that were not divided enough so far, if they are counted.
fn coarse(device: &Device) -> Option<u64> {
    let counts = device.pipelines.divided.uncounted().is_none();
    counts.then(|| device.view_constants.counted().unwrap_or(0).into())
}

/// Completes the exit report of the last frame. The device has finished all work and is about to be
/// destroyed. The report was incomplete because nobody knew that the frame was the last.
pub fn count_again(device: &Device) {
    last_frame::amend(device.presented.report.load(Ordering::Relaxed), |statistics| {
        statistics.coarse_primitives = coarse(device)
    });
}

fn statistics(device: &Device, managed: &Swapchain, rig: &Rig, frames: u64) -> Statistics {
    let (counts, lenses, flat) = {
        let frame = device.frame.locked();
        let lenses = common_statistics::lenses(frame.cameras()).collect();
        (frame.counts().clone(), lenses, frame.flat_note().map(str::to_owned))
    };
    let divided = &device.pipelines.divided;
    let uncounted = divided
        .uncounted()
        .map(|why| format!("Vulkan: primitives that are not divided far enough are not counted: {why}"));
    let mut statistics = Statistics {
        notes: device.flatness.note().into_iter().chain(uncounted).chain(flat).collect(),
        draws_seen: counts.seen,
        panel_draws: counts.flat,
        duplicated_draws: counts.duplicated,
        draws_out_of_sight: counts.left_out,
        lenses,
        duplicated_framebuffers: device.images.duplicated().count() as u64,
        single_framebuffers: device.single_images(rig.views.duplicate),
        coarse_primitives: coarse(device),
        undivided_pipelines: divided.undivided(),
        projection_found: counts.found.iter().map(|(how, draws)| ((*how).to_owned(), *draws)).collect(),
        ..common_statistics::begin(frames, &rig.name, device.driver.name.clone())
    };
    let view = |name: &str, width, height, draws_issued| ViewStatistics {
        name: name.to_owned(),
        width,
        height,
        draws_issued,
        ..ViewStatistics::default()
    };
    match &managed.stand_in {
        Some(stand_in) if device.draws_views() => {
            let session = &stand_in.layout.session;
            common_statistics::add_plan(&mut statistics, session);
            let views = session.views().iter();
            statistics.views = views.map(|v| view(&v.name, v.tile.width, v.tile.height, counts.in_views)).collect();
        }
        _ => statistics.views = vec![view("program", managed.extent.width, managed.extent.height, 0)],
    }
    statistics
}
