//! Requests to the device: a steady frame makes no objects, every object that is made is destroyed,
//! and each refusal of the device is an error.

use super::headless;
use crate::backend::vk::driver::headless::Headless;
use crate::backend::vk::memory::Image;
use crate::backend::vk::{Api, SourceImage, Surface, TargetImage, Use, VkBackend, barrier};
use crate::cache::Cache;
use crate::correct::{Arrangement, Plan, UpperLeftRect};
use crate::correct::{Mask, build};
use crate::error::{ErrorKind, Result};
use crate::{rig, views::Request};
use ash::vk;
use std::cell::RefCell;
use std::collections::HashSet;
use std::ffi::{CStr, c_void};

/// Functions that make and destroy a kind of object, given by (device, structure, allocator, place)
/// and (device, object, allocator).
const KINDS: [(&CStr, &CStr); 13] = [
    (c"vkCreateBuffer", c"vkDestroyBuffer"),
    (c"vkCreateImage", c"vkDestroyImage"),
    (c"vkCreateImageView", c"vkDestroyImageView"),
    (c"vkAllocateMemory", c"vkFreeMemory"),
    (c"vkCreateShaderModule", c"vkDestroyShaderModule"),
    (c"vkCreatePipelineLayout", c"vkDestroyPipelineLayout"),
    (c"vkCreateDescriptorSetLayout", c"vkDestroyDescriptorSetLayout"),
    (c"vkCreateDescriptorPool", c"vkDestroyDescriptorPool"),
    (c"vkCreateSampler", c"vkDestroySampler"),
    (c"vkCreateRenderPass", c"vkDestroyRenderPass"),
    (c"vkCreateFramebuffer", c"vkDestroyFramebuffer"),
    (c"vkCreateQueryPool", c"vkDestroyQueryPool"),
    (c"vkCreatePipelineCache", c"vkDestroyPipelineCache"),
];
const PIPELINE_CACHES: usize = KINDS.len() - 1;
const PIPELINES: usize = KINDS.len();

/// Requests to this thread's device.
#[derive(Default)]
struct Asked {
    /// The device's own functions.
    makers: [usize; PIPELINES + 1],
    destroyers: [usize; PIPELINES + 1],
    sets: usize,
    /// Number of calls that make something.
    calls: usize,
    /// Number of the call that fails.
    fails: Option<usize>,
    /// Kind of the object that was refused.
    refused: Option<usize>,
    live: HashSet<(usize, u64)>,
    /// Number of destroyed objects that were not live.
    strangers: usize,
    /// True: pipelines are only numbers. Nothing is drawn with them, and real ones take long to
    /// make.
    numbered_pipelines: bool,
    /// The last of these numbers.
    last_pipeline: u64,
}

thread_local! {
    static ASKED: RefCell<Asked> = RefCell::default();
}

/// Counts a call. Returns the device's own function, or `None` if the call has to fail.
fn asked(own: impl Fn(&Asked) -> usize) -> Option<usize> {
    ASKED.with_borrow_mut(|asked| {
        let call = asked.calls;
        asked.calls += 1;
        (asked.fails != Some(call)).then(|| own(asked))
    })
}

fn made(kind: usize, object: u64) {
    ASKED.with_borrow_mut(|asked| asked.live.insert((kind, object)));
}

type Make = unsafe extern "system" fn(vk::Device, *const c_void, *const c_void, *mut u64) -> vk::Result;
type MakePipelines =
    unsafe extern "system" fn(vk::Device, u64, u32, *const c_void, *const c_void, *mut u64) -> vk::Result;
type MakeSets = unsafe extern "system" fn(vk::Device, *const c_void, *mut u64) -> vk::Result;
type Destroy = unsafe extern "system" fn(vk::Device, u64, *const c_void);

unsafe extern "system" fn make<const KIND: usize>(
    device: vk::Device,
    info: *const c_void,
    allocator: *const c_void,
    place: *mut u64,
) -> vk::Result {
    let Some(own) = asked(|asked| asked.makers[KIND]) else {
        ASKED.with_borrow_mut(|asked| asked.refused = Some(KIND));
        return vk::Result::ERROR_DEVICE_LOST;
    };
    // SAFETY: the device's own function of this type, with the caller's arguments.
    unsafe {
        let result = std::mem::transmute::<usize, Make>(own)(device, info, allocator, place);
        if result == vk::Result::SUCCESS {
            made(KIND, *place);
        }
        result
    }
}

unsafe extern "system" fn make_pipelines(
    device: vk::Device,
    cache: u64,
    count: u32,
    infos: *const c_void,
    allocator: *const c_void,
    place: *mut u64,
) -> vk::Result {
    let Some(own) = asked(|asked| asked.makers[PIPELINES]) else { return vk::Result::ERROR_DEVICE_LOST };
    let number = || {
        ASKED.with_borrow_mut(|asked| {
            asked.last_pipeline += 1;
            asked.last_pipeline
        })
    };
    // SAFETY: as above; `place` has room for `count` pipelines.
    unsafe {
        let result = match ASKED.with_borrow(|asked| asked.numbered_pipelines) {
            true => {
                (0..count as usize).for_each(|index| *place.add(index) = number());
                vk::Result::SUCCESS
            }
            false => std::mem::transmute::<usize, MakePipelines>(own)(device, cache, count, infos, allocator, place),
        };
        (0..count as usize).for_each(|index| made(PIPELINES, *place.add(index)));
        result
    }
}

unsafe extern "system" fn make_sets(device: vk::Device, info: *const c_void, place: *mut u64) -> vk::Result {
    let Some(own) = asked(|asked| asked.sets) else { return vk::Result::ERROR_DEVICE_LOST };
    // SAFETY: as above. Sets are freed with their pool.
    unsafe { std::mem::transmute::<usize, MakeSets>(own)(device, info, place) }
}

unsafe extern "system" fn destroy<const KIND: usize>(device: vk::Device, object: u64, allocator: *const c_void) {
    let (own, is_number) = ASKED.with_borrow_mut(|asked| {
        asked.strangers += usize::from(object != 0 && !asked.live.remove(&(KIND, object)));
        (asked.destroyers[KIND], KIND == PIPELINES && asked.numbered_pipelines)
    });
    if is_number {
        return;
    }
    // SAFETY: as above.
    unsafe { std::mem::transmute::<usize, Destroy>(own)(device, object, allocator) };
}

macro_rules! for_each_kind {
    ($($kind:literal),+) => {
        (
            [$(make::<$kind> as Make as usize),+, make_pipelines as MakePipelines as usize],
            [$(destroy::<$kind> as Destroy as usize),+, destroy::<PIPELINES> as Destroy as usize],
        )
    };
}

/// Returns the device with functions that count calls.
fn watched(headless: &Headless) -> Api {
    let (makers, destroyers) = for_each_kind!(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12);
    let names = KINDS.iter().copied().chain([(c"vkCreateGraphicsPipelines", c"vkDestroyPipeline")]);
    let names: Vec<(&CStr, &CStr)> = names.collect();
    let (instance, device) = (headless.api.instance(), headless.api.device().handle());
    let find = |name: &CStr| {
        // SAFETY: the device is live.
        let own = unsafe { instance.get_device_proc_addr(device, name.as_ptr()) }.map_or(0, |f| f as usize);
        ASKED.with_borrow_mut(|asked| {
            if name == c"vkAllocateDescriptorSets" {
                asked.sets = own;
                return make_sets as MakeSets as usize as *const c_void;
            }
            for (kind, (maker, destroyer)) in names.iter().enumerate() {
                if name == *maker {
                    asked.makers[kind] = own;
                    return makers[kind] as *const c_void;
                }
                if name == *destroyer {
                    asked.destroyers[kind] = own;
                    return destroyers[kind] as *const c_void;
                }
            }
            own as *const c_void
        })
    };
    // SAFETY: each function has the type of the function that it replaces.
    let table = unsafe { ash::Device::load_with(find, device) };
    Api::new(instance, headless.api.physical_device(), &table)
}

const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// Returns a plan with a table, a mask and several views.
fn plan(arrangement: Arrangement) -> Plan {
    let rig = rig::load("idome").expect("a preset loads");
    let request =
        Request { output_sizes: vec![(96, 64)], window: (96, 64), panel: false, primary: false, max_atlas: 4096 };
    let mut plan = build(&rig, &request).expect("a preset can be planned");
    plan.passes[0].mask = Some(Mask { width: 2, height: 2, weights: vec![u16::MAX, 0, 9000, 40000] });
    arrangement.arrange(plan)
}

/// All objects of Cupola on a device.
struct Stage {
    api: Api,
    backend: VkBackend,
    surface: Option<Surface>,
    target: Image,
}

impl Stage {
    fn new(api: &Api) -> Self {
        Self { api: api.clone(), backend: VkBackend::new(api), surface: None, target: Image::default() }
    }

    /// Makes all objects, with two sources.
    fn make(&mut self, plan: &Plan, arrangement: Arrangement, family: u32) -> Result<()> {
        let api = &self.api;
        self.backend.prepare_arranged(plan, arrangement, FORMAT)?;
        self.backend.measure(2, family)?;
        let surface = self.surface.insert(Surface::new(api, arrangement, &arrangement.images(plan), FORMAT, 2)?);
        self.backend.set_sources(surface.sources())?;
        self.target = Image::new(api, FORMAT, (96, 64), vk::ImageUsageFlags::COLOR_ATTACHMENT)?;
        self.backend.set_targets(&[TargetImage {
            image: self.target.handle,
            view: self.target.view,
            format: FORMAT,
            extent: (96, 64),
            initial_layout: vk::ImageLayout::UNDEFINED,
            final_layout: vk::ImageLayout::GENERAL,
            before: (vk::PipelineStageFlags::empty(), vk::AccessFlags::empty()),
            after: (vk::PipelineStageFlags::empty(), vk::AccessFlags::empty()),
        }])
    }

    /// Runs the correction of a source.
    fn frame(&mut self, headless: &Headless, source: usize) -> Result<()> {
        let all = self.surface.as_ref().map_or(&[][..], Surface::sources);
        let images: Vec<SourceImage> = all[source * all.len() / 2..(source + 1) * all.len() / 2].to_vec();
        let (device, backend) = (self.api.device(), &mut self.backend);
        headless.run(|commands| {
            // SAFETY: the command buffer is being recorded, and the images are live.
            unsafe {
                for image in &images {
                    let (before, after) = (Use::nothing(vk::ImageLayout::UNDEFINED), Use::sampled(image.layout));
                    let layers = if images.len() == 1 { vk::REMAINING_ARRAY_LAYERS } else { 1 };
                    barrier(device, commands, (image.image, layers), before, after);
                }
                backend.record(commands, source, 0, &[UpperLeftRect::new(0, 0, 96, 64)])
            }
        })
    }

    fn destroy(&mut self) {
        self.backend.destroy();
        if let Some(mut surface) = self.surface.take() {
            surface.destroy(&self.api);
        }
        self.target.destroy(&self.api);
    }
}

/// Returns the number of live objects, and the number of destroyed objects that were none.
fn left() -> (usize, usize) {
    ASKED.with_borrow(|asked| (asked.live.len(), asked.strangers))
}

#[test]
fn a_steady_frame_makes_nothing_and_everything_is_destroyed() {
    let headless = headless();
    let api = watched(&headless);
    for arrangement in [Arrangement::Atlas, Arrangement::Layers, Arrangement::Images] {
        let plan = plan(arrangement);
        let mut stage = Stage::new(&api);
        let before = ASKED.with_borrow(|asked| asked.calls);
        stage.make(&plan, arrangement, headless.queue_family()).expect("a device that refuses nothing");
        let calls = ASKED.with_borrow(|asked| asked.calls);
        assert!(calls > before + 20, "the watch sees what is made: {calls}");
        assert!(left().0 > 10);
        for frame in 0..6 {
            stage.frame(&headless, frame % 2).expect("a frame");
        }
        assert_eq!(ASKED.with_borrow(|asked| asked.calls), calls, "{arrangement:?}: made in a steady frame");
        let timing = stage.backend.timing();
        assert!(timing.corrections == 4 && timing.last > 0.0 && timing.total >= timing.last, "{timing:?}");
        stage.destroy();
        assert_eq!(left(), (0, 0), "{arrangement:?}");
    }
}

#[test]
fn whatever_the_device_refuses_is_an_error_and_leaves_nothing() {
    let headless = headless();
    let api = watched(&headless);
    let arrangement = Arrangement::Layers;
    let plan = plan(arrangement);
    ASKED.with_borrow_mut(|asked| asked.numbered_pipelines = true);
    for call in 0.. {
        ASKED.with_borrow_mut(|asked| (asked.calls, asked.fails) = (0, Some(call)));
        let mut stage = Stage::new(&api);
        let result = stage.make(&plan, arrangement, headless.queue_family());
        if ASKED.with_borrow(|asked| asked.calls) <= call {
            result.expect("nothing failed");
            assert!(call > 20, "every call was refused once");
            stage.destroy();
            break;
        }
        let error = result.expect_err("a call failed");
        assert_eq!(error.kind, ErrorKind::Graphics, "call {call}: {error}");
        assert!(error.message.contains("ERROR_DEVICE_LOST"), "call {call}: {error}");
        stage.destroy();
        assert_eq!(left(), (0, 0), "call {call}: {error}");
    }
}

/// The cache of pipelines only saves time: pipelines are made even if the driver refuses it.
#[test]
fn a_refused_cache_of_pipelines_is_no_obstacle() {
    let headless = headless();
    let arrangement = Arrangement::Atlas;
    let plan = plan(arrangement);
    ASKED.with_borrow_mut(|asked| asked.numbered_pipelines = true);
    let (mut refused, mut others) = (0, 0);
    for call in 0.. {
        let api = watched(&headless).with_cache(&Cache::in_memory());
        ASKED.with_borrow_mut(|asked| (asked.calls, asked.fails, asked.refused) = (0, Some(call), None));
        let mut stage = Stage::new(&api);
        let result = stage.make(&plan, arrangement, headless.queue_family());
        let (calls, kind) = ASKED.with_borrow(|asked| (asked.calls, asked.refused));
        stage.destroy();
        assert_eq!(left(), (0, 0), "call {call}");
        if calls <= call {
            result.expect("nothing failed");
            break;
        }
        assert_eq!(result.is_ok(), kind == Some(PIPELINE_CACHES), "call {call}");
        *(if result.is_ok() { &mut refused } else { &mut others }) += 1;
    }
    assert!(refused > 0 && others > 20, "{refused} caches and {others} others were refused");
}
