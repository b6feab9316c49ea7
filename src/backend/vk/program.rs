//! The fixed objects of the correction: render passes, layouts, samplers, and a pipeline per
//! shader.

use super::binaries;
use crate::backend::vk::driver::api::{Api, refused};
use crate::correct::Arrangement;
use crate::correct::shaders::draws::{FLOATS, SOURCE_FLOATS};
use crate::correct::shaders::spirv::{Modules, VERTEX_ENTRY, binding};
use crate::error::Result;
use ash::vk;

/// Objects that all pipelines of one target format share.
#[derive(Debug, Default)]
pub(super) struct Common {
    pub set_layout: vk::DescriptorSetLayout,
    pub layout: vk::PipelineLayout,
    /// Linear, nearest.
    pub samplers: [vk::Sampler; 2],
    /// Render passes: the first keeps the target's content, the second clears it to black. They are
    /// compatible.
    pub render_passes: [vk::RenderPass; 2],
}

/// Returns the bindings of a shader's pictures, in the order of the batch's views.
pub(super) fn picture_bindings(arrangement: Arrangement) -> impl Iterator<Item = u32> {
    let others = if arrangement == Arrangement::Images { binding::IMAGES } else { 0..0 };
    std::iter::once(binding::ATLAS).chain(others)
}

impl Common {
    pub fn new(api: &Api, format: vk::Format, arrangement: Arrangement) -> Result<Self> {
        let mut common = Self::default();
        common.make(api, format, arrangement).inspect_err(|_| common.destroy(api))?;
        Ok(common)
    }

    fn make(&mut self, api: &Api, format: vk::Format, arrangement: Arrangement) -> Result<()> {
        let bound = |binding, kind| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding)
                .descriptor_type(kind)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::FRAGMENT)
        };
        let mut bindings = vec![
            bound(binding::ATLAS_SAMPLER, vk::DescriptorType::SAMPLER),
            bound(binding::MASK, vk::DescriptorType::SAMPLED_IMAGE),
            bound(binding::MASK_SAMPLER, vk::DescriptorType::SAMPLER),
            bound(binding::TABLE, vk::DescriptorType::SAMPLED_IMAGE),
            bound(binding::BLACK, vk::DescriptorType::SAMPLED_IMAGE),
        ];
        bindings.extend(picture_bindings(arrangement).map(|at| bound(at, vk::DescriptorType::SAMPLED_IMAGE)));
        // SAFETY: the device is live, and every structure is complete and lives during its call.
        unsafe {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            self.set_layout =
                api.device.create_descriptor_set_layout(&info, None).map_err(refused("a layout of descriptors"))?;
            let layouts = [self.set_layout];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts);
            self.layout = api.device.create_pipeline_layout(&info, None).map_err(refused("a layout of a pipeline"))?;
            for (sampler, filter) in self.samplers.iter_mut().zip([vk::Filter::LINEAR, vk::Filter::NEAREST]) {
                let edge = vk::SamplerAddressMode::CLAMP_TO_EDGE;
                let info = vk::SamplerCreateInfo::default()
                    .min_filter(filter)
                    .mag_filter(filter)
                    .address_mode_u(edge)
                    .address_mode_v(edge)
                    .address_mode_w(edge);
                *sampler = api.device.create_sampler(&info, None).map_err(refused("a sampler"))?;
            }
            for (pass, load) in
                self.render_passes.iter_mut().zip([vk::AttachmentLoadOp::LOAD, vk::AttachmentLoadOp::CLEAR])
            {
                *pass = render_pass(api, format, load)?;
            }
        }
        Ok(())
    }

    /// Destroys the objects. No pending commands may use them.
    pub fn destroy(&mut self, api: &Api) {
        let old = std::mem::take(self);
        // SAFETY: all are objects of Cupola or null.
        unsafe {
            for pass in old.render_passes {
                api.device.destroy_render_pass(pass, None);
            }
            for sampler in old.samplers {
                api.device.destroy_sampler(sampler, None);
            }
            api.device.destroy_pipeline_layout(old.layout, None);
            api.device.destroy_descriptor_set_layout(old.set_layout, None);
        }
    }

    /// Makes the pipeline of a specialised shader. The caller destroys it.
    pub fn pipeline(&self, api: &Api, modules: &Modules) -> Result<vk::Pipeline> {
        let vertex = module(api, modules.vertex)?;
        let pipeline = module(api, &modules.fragment).and_then(|fragment| {
            let pipeline = binaries::pipeline(api, modules, |cache| self.link(api, vertex, fragment, modules, cache));
            // SAFETY: an object of Cupola; a pipeline does not need its modules once it is made.
            unsafe { api.device.destroy_shader_module(fragment, None) };
            pipeline
        });
        // SAFETY: as above.
        unsafe { api.device.destroy_shader_module(vertex, None) };
        pipeline
    }

    fn link(
        &self,
        api: &Api,
        vertex: vk::ShaderModule,
        fragment: vk::ShaderModule,
        modules: &Modules,
        cache: vk::PipelineCache,
    ) -> Result<vk::Pipeline> {
        let stage =
            |stage, module, name| vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module).name(name);
        let stages = [
            stage(vk::ShaderStageFlags::VERTEX, vertex, VERTEX_ENTRY),
            stage(vk::ShaderStageFlags::FRAGMENT, fragment, modules.fragment_entry),
        ];
        let stride = (FLOATS * size_of::<f32>()) as u32;
        let buffers = [vk::VertexInputBindingDescription::default().stride(stride)];
        let attribute = |location, format, offset| {
            vk::VertexInputAttributeDescription::default().location(location).format(format).offset(offset)
        };
        let source = ((FLOATS - SOURCE_FLOATS) * size_of::<f32>()) as u32;
        let attributes =
            [attribute(0, vk::Format::R32G32_SFLOAT, 0), attribute(1, vk::Format::R32G32B32A32_SFLOAT, source)];
        let input = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(&buffers)
            .vertex_attribute_descriptions(&attributes);
        let assembly =
            vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
        let samples =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let attachments =
            [vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA)];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&attachments);
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
            .layout(self.layout)
            .render_pass(self.render_passes[0]);
        // SAFETY: the device is live; all objects in the structure are Cupola's and live during the
        // call.
        let made = unsafe { api.device.create_graphics_pipelines(cache, &[info], None) };
        made.map(|pipelines| pipelines[0]).map_err(|(_, result)| refused("a pipeline of the correction")(result))
    }
}

fn module(api: &Api, words: &[u32]) -> Result<vk::ShaderModule> {
    let info = vk::ShaderModuleCreateInfo::default().code(words);
    // SAFETY: the device is live; the words are a valid module of SPIR-V 1.0.
    unsafe { api.device.create_shader_module(&info, None) }.map_err(refused("a shader of the correction"))
}

fn render_pass(api: &Api, format: vk::Format, load: vk::AttachmentLoadOp) -> Result<vk::RenderPass> {
    let layout = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
    let attachments = [vk::AttachmentDescription::default()
        .format(format)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(load)
        .store_op(vk::AttachmentStoreOp::STORE)
        .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
        .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
        .initial_layout(layout)
        .final_layout(layout)];
    let colors = [vk::AttachmentReference { attachment: 0, layout }];
    let subpasses = [vk::SubpassDescription::default().color_attachments(&colors)];
    let info = vk::RenderPassCreateInfo::default().attachments(&attachments).subpasses(&subpasses);
    // SAFETY: the device is live; the structure is complete.
    unsafe { api.device.create_render_pass(&info, None) }.map_err(refused("a render pass"))
}
