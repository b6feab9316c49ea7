//! Cost of the correction on Vulkan, in units of drawing one bilinear full-screen quad.
//!
//! `cargo bench --bench vk_warp [-- WIDTH HEIGHT ROUNDS]`. All passes are timed in turn, round by
//! round, so that other load slows all of them equally. The medians of the ratios are printed.
//! Needs glslangValidator, for the quad's shader.

use cupola::backend::vk::ash::vk;
use cupola::backend::vk::driver::headless::Headless;
use cupola::backend::vk::{SourceImage, Surface, Use, VkBackend, barrier};
use cupola::correct::{Arrangement, ImageSize, Plan, build};
use cupola::geom::UpperLeftRect;
use cupola::rig;
use cupola::views::Request;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

const VERTEX: &str = "#version 450
layout(location = 0) out vec2 at;
void main() {
    at = vec2(gl_VertexIndex == 1 || gl_VertexIndex == 2 || gl_VertexIndex == 4,
              gl_VertexIndex == 2 || gl_VertexIndex == 4 || gl_VertexIndex == 5);
    gl_Position = vec4(2.0 * at - 1.0, 0.0, 1.0);
}";
const FRAGMENT: &str = "#version 450
layout(set = 0, binding = 0) uniform sampler2D picture;
layout(location = 0) in vec2 at;
layout(location = 0) out vec4 color;
void main() { color = vec4(texture(picture, at).rgb, 1.0); }";

const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// Three projectors side by side; the first is drawn.
const PROJECTORS: &str = r#"
[dome]
radius = 5.0
coverage = 360.0
[[output]]
name = "one"
kind = "projector"
position = [0.0, 0.0, 3.0]
pitch = 5.7
fov = [60.0, 40.0]
"#;
const NEIGHBOURS: &str = r#"
[[output]]
name = "two"
kind = "projector"
position = [0.0, 0.0, 3.0]
yaw = 40.0
pitch = 5.7
fov = [60.0, 40.0]
[[output]]
name = "three"
kind = "projector"
position = [0.0, 0.0, 3.0]
yaw = -40.0
pitch = 5.7
fov = [60.0, 40.0]
"#;

type Failure = Box<dyn std::error::Error>;

/// One pass that is timed.
struct Contestant {
    name: String,
    /// `None` for the plain quad.
    backend: Option<VkBackend>,
    surface: Surface,
    /// Seconds of each round: elapsed, and processor time of all threads, which other load disturbs
    /// less.
    seconds: Vec<f64>,
    processor: Vec<f64>,
}

fn main() -> Result<(), Failure> {
    let numbers: Vec<u32> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let size = (numbers.first().copied().unwrap_or(1920), numbers.get(1).copied().unwrap_or(1080));
    let rounds = numbers.get(2).copied().unwrap_or(15);
    let device = Headless::new(&[])?;
    println!("{}; {}×{}, {rounds} rounds", device.driver, size.0, size.1);
    let whole = ImageSize { width: size.0, height: size.1, layers: 1 };
    let mut target = Surface::new(&device.api, Arrangement::Atlas, &[whole], FORMAT, 1)?;
    let shown = target.sources()[0];
    let picture = filled(&device, Arrangement::Atlas, &[whole])?;
    let quad = Quad::new(&device, &picture.sources()[0], &shown)?;
    let mut contestants = vec![contestant("bilinear quad".into(), None, picture)];
    for (name, text, arrangement) in rigs() {
        let plan = arrangement.arrange(plan(&text, size)?);
        let started = Instant::now();
        let surface = filled(&device, arrangement, &arrangement.images(&plan))?;
        let backend = prepared(&device, &plan, arrangement, &surface, &shown)?;
        let batches = plan.passes[0].batches.len();
        let milliseconds = started.elapsed().as_secs_f64() * 1e3;
        println!("{name}: {} views, {batches} batches prepared in {milliseconds:.0} ms", plan.views.views.len());
        contestants.push(contestant(name, Some(backend), surface));
    }
    for round in 0..rounds + 2 {
        for contestant in &mut contestants {
            let (started, used) = (Instant::now(), processor_seconds());
            device.run(|commands| match &mut contestant.backend {
                // SAFETY: the command buffer is being recorded, and all images are live and in
                // their layouts.
                Some(backend) => unsafe {
                    backend.record(commands, 0, 0, &[UpperLeftRect::new(0, 0, size.0 as i32, size.1 as i32)])
                },
                None => {
                    quad.record(&device, commands, size);
                    Ok(())
                }
            })?;
            // The first rounds warm up.
            if round >= 2 {
                contestant.seconds.push(started.elapsed().as_secs_f64());
                contestant.processor.push(processor_seconds() - used);
            }
        }
    }
    report(&contestants);
    for mut contestant in contestants {
        if let Some(backend) = &mut contestant.backend {
            backend.destroy();
        }
        contestant.surface.destroy(&device.api);
    }
    quad.destroy(&device);
    target.destroy(&device.api);
    Ok(())
}

fn contestant(name: String, backend: Option<VkBackend>, surface: Surface) -> Contestant {
    Contestant { name, backend, surface, seconds: Vec::new(), processor: Vec::new() }
}

fn report(contestants: &[Contestant]) {
    println!("\n{:32} {:>10} {:>10} {:>7} {:>17}", "pass", "median ms", "least ms", "ratio", "processor's ratio");
    let ratio = |of: &[f64], base: &[f64]| median(of.iter().zip(base).map(|(a, b)| a / b).collect());
    let base = &contestants[0];
    for contestant in contestants {
        println!(
            "{:32} {:10.2} {:10.2} {:7.2} {:17.2}",
            contestant.name,
            median(contestant.seconds.clone()) * 1e3,
            contestant.seconds.iter().copied().fold(f64::INFINITY, f64::min) * 1e3,
            ratio(&contestant.seconds, &base.seconds),
            ratio(&contestant.processor, &base.processor),
        );
    }
}

/// Processor time of all threads of this process so far.
fn processor_seconds() -> f64 {
    let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the pointer is to the local structure above.
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &mut now) };
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Name, rig and arrangement of each pass that is compared; the rig's first output is drawn.
fn rigs() -> Vec<(String, String, Arrangement)> {
    let dome = |degrees: u32| {
        format!("[dome]\ntilt = 90.0\n[[output]]\nname = \"dome\"\nkind = \"domemaster\"\naperture = {degrees}.0\n")
    };
    let atlas = Arrangement::Atlas;
    vec![
        ("projector 60×40° at 0.6 R".into(), PROJECTORS.into(), atlas),
        ("blended on both sides".into(), format!("{PROJECTORS}{NEIGHBOURS}"), atlas),
        ("fisheye 180°".into(), dome(180), atlas),
        ("fisheye 180°, layers".into(), dome(180), Arrangement::Layers),
        ("fisheye 180°, images".into(), dome(180), Arrangement::Images),
        ("fisheye 240°".into(), dome(240), atlas),
    ]
}

fn plan(text: &str, size: (u32, u32)) -> Result<Plan, Failure> {
    let rig = rig::parse(text, "bench", Path::new("."))?;
    let output_sizes = vec![size; rig.outputs.len()];
    let request = Request { output_sizes, window: size, panel: false, primary: false, max_atlas: 16384 };
    let mut plan = build(&rig, &request)?;
    plan.passes.truncate(1);
    Ok(plan)
}

/// Images for views, of one colour: their content does not change the time.
fn filled(device: &Headless, arrangement: Arrangement, sizes: &[ImageSize]) -> Result<Surface, Failure> {
    let surface = Surface::new(&device.api, arrangement, sizes, FORMAT, 1)?;
    device.fill(surface.sources(), sizes, [0.3, 0.5, 0.7, 1.0])?;
    Ok(surface)
}

fn prepared(
    device: &Headless,
    plan: &Plan,
    arrangement: Arrangement,
    surface: &Surface,
    shown: &SourceImage,
) -> Result<VkBackend, Failure> {
    let mut backend = VkBackend::new(&device.api);
    backend.prepare_arranged(plan, arrangement, FORMAT)?;
    backend.set_sources(surface.sources())?;
    backend.set_targets(&[shown.overwritten()])?;
    Ok(backend)
}

/// The plain quad.
struct Quad {
    sampler: vk::Sampler,
    set_layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    layout: vk::PipelineLayout,
    pass: vk::RenderPass,
    framebuffer: vk::Framebuffer,
    pipeline: vk::Pipeline,
}

impl Quad {
    /// Makes a quad that draws `picture` to `shown`. Changes the layout of `picture` to one for
    /// sampling.
    fn new(device: &Headless, picture: &SourceImage, shown: &SourceImage) -> Result<Self, Failure> {
        let sampled = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        let api = device.api.device();
        device.run(|commands| {
            let before = Use { layout: picture.layout, stages: picture.stages, access: picture.access };
            // SAFETY: the command buffer is being recorded, and the image is live.
            unsafe { barrier(api, commands, (picture.image, 1), before, Use::sampled(sampled)) };
            Ok(())
        })?;
        // SAFETY: the device is live, and every structure is complete and lives during its call.
        unsafe {
            let linear = vk::SamplerCreateInfo::default().mag_filter(vk::Filter::LINEAR).min_filter(vk::Filter::LINEAR);
            let sampler = api.create_sampler(&linear, None)?;
            let bindings = [vk::DescriptorSetLayoutBinding::default()
                .descriptor_type(vk::DescriptorType::COMBINED_IMAGE_SAMPLER)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::FRAGMENT)];
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            let set_layout = api.create_descriptor_set_layout(&info, None)?;
            let sizes =
                [vk::DescriptorPoolSize::default().ty(vk::DescriptorType::COMBINED_IMAGE_SAMPLER).descriptor_count(1)];
            let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
            let pool = api.create_descriptor_pool(&info, None)?;
            let layouts = [set_layout];
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            let set = api.allocate_descriptor_sets(&info)?[0];
            let image = [vk::DescriptorImageInfo { sampler, image_view: picture.view, image_layout: sampled }];
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .descriptor_type(vk::DescriptorType::COMBINED_IMAGE_SAMPLER)
                .image_info(&image);
            api.update_descriptor_sets(&[write], &[]);
            let layout =
                api.create_pipeline_layout(&vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts), None)?;
            let pass = render_pass(api, shown.layout)?;
            let views = [shown.view];
            let info = vk::FramebufferCreateInfo::default()
                .render_pass(pass)
                .attachments(&views)
                .width(shown.extent.0)
                .height(shown.extent.1)
                .layers(1);
            let framebuffer = api.create_framebuffer(&info, None)?;
            let pipeline = pipeline(api, layout, pass)?;
            Ok(Self { sampler, set_layout, pool, set, layout, pass, framebuffer, pipeline })
        }
    }

    fn record(&self, device: &Headless, commands: vk::CommandBuffer, size: (u32, u32)) {
        let area = vk::Rect2D::from(vk::Extent2D { width: size.0, height: size.1 });
        let viewport =
            vk::Viewport { width: size.0 as f32, height: size.1 as f32, max_depth: 1.0, ..Default::default() };
        let begin =
            vk::RenderPassBeginInfo::default().render_pass(self.pass).framebuffer(self.framebuffer).render_area(area);
        let (api, graphics) = (device.api.device(), vk::PipelineBindPoint::GRAPHICS);
        // SAFETY: the command buffer is being recorded; all objects are live.
        unsafe {
            api.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE);
            api.cmd_bind_pipeline(commands, graphics, self.pipeline);
            api.cmd_bind_descriptor_sets(commands, graphics, self.layout, 0, &[self.set], &[]);
            api.cmd_set_viewport(commands, 0, &[viewport]);
            api.cmd_set_scissor(commands, 0, &[area]);
            api.cmd_draw(commands, 6, 1, 0, 0);
            api.cmd_end_render_pass(commands);
        }
    }

    fn destroy(self, device: &Headless) {
        let api = device.api.device();
        // SAFETY: all were created by `new`, and nothing is pending.
        unsafe {
            api.destroy_pipeline(self.pipeline, None);
            api.destroy_framebuffer(self.framebuffer, None);
            api.destroy_render_pass(self.pass, None);
            api.destroy_pipeline_layout(self.layout, None);
            api.destroy_descriptor_pool(self.pool, None);
            api.destroy_descriptor_set_layout(self.set_layout, None);
            api.destroy_sampler(self.sampler, None);
        }
    }
}

/// # Safety
/// The device is live.
unsafe fn render_pass(
    api: &cupola::backend::vk::ash::Device,
    layout: vk::ImageLayout,
) -> Result<vk::RenderPass, vk::Result> {
    let attachments = [vk::AttachmentDescription::default()
        .format(FORMAT)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(vk::AttachmentLoadOp::DONT_CARE)
        .store_op(vk::AttachmentStoreOp::STORE)
        .initial_layout(vk::ImageLayout::UNDEFINED)
        .final_layout(layout)];
    let colors = [vk::AttachmentReference { attachment: 0, layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL }];
    let subpasses = [vk::SubpassDescription::default().color_attachments(&colors)];
    let info = vk::RenderPassCreateInfo::default().attachments(&attachments).subpasses(&subpasses);
    // SAFETY: the caller guarantees a live device; the structure is complete.
    unsafe { api.create_render_pass(&info, None) }
}

/// # Safety
/// The device is live, layout and render pass are its own.
unsafe fn pipeline(
    api: &cupola::backend::vk::ash::Device,
    layout: vk::PipelineLayout,
    pass: vk::RenderPass,
) -> Result<vk::Pipeline, Failure> {
    let (vertex, fragment) = (compiled(VERTEX, "vert")?, compiled(FRAGMENT, "frag")?);
    let module = |words: &[u32]| {
        // SAFETY: the caller guarantees a live device; glslangValidator makes valid modules.
        unsafe { api.create_shader_module(&vk::ShaderModuleCreateInfo::default().code(words), None) }
    };
    let (vertex, fragment) = (module(&vertex)?, module(&fragment)?);
    let stage = |stage, module| vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module).name(c"main");
    let stages = [stage(vk::ShaderStageFlags::VERTEX, vertex), stage(vk::ShaderStageFlags::FRAGMENT, fragment)];
    let input = vk::PipelineVertexInputStateCreateInfo::default();
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
    let samples = vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let colors = [vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA)];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&colors);
    let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
    let info = vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&samples)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout)
        .render_pass(pass);
    // SAFETY: the caller guarantees a live device and its objects; the structures are complete. A
    // pipeline does not need its modules after its creation.
    unsafe {
        let made = api.create_graphics_pipelines(vk::PipelineCache::null(), &[info], None);
        api.destroy_shader_module(vertex, None);
        api.destroy_shader_module(fragment, None);
        made.map(|pipelines| pipelines[0]).map_err(|(_, result)| result.into())
    }
}

/// Compiles a shader with glslangValidator; returns its words.
fn compiled(text: &str, stage: &str) -> Result<Vec<u32>, Failure> {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (source, words) = (directory.join(format!("quad.{stage}")), directory.join(format!("quad-{stage}.spv")));
    std::fs::write(&source, text)?;
    let run = Command::new("glslangValidator").args(["--quiet", "-V", "-o"]).arg(&words).arg(&source).output();
    let run = run.map_err(|error| format!("glslangValidator cannot be started (package glslang-tools): {error}"))?;
    if !run.status.success() {
        return Err(String::from_utf8_lossy(&run.stdout).into_owned().into());
    }
    let bytes = std::fs::read(words)?;
    Ok(bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect())
}
