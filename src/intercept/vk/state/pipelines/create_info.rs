//! Create infos of complete pipelines, or of the parts that a library has. Pointers of other parts
//! may be invalid and are not followed.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::state::driver::structures::{Copied, in_chain, slice};
use crate::intercept::vk::state::pipelines::InstanceColumn;
use ash::vk::{self, GraphicsPipelineLibraryFlagsEXT as Flags};
use std::ffi::c_void;

/// The parts of a pipeline that a structure describes.
pub struct Parts<'a> {
    /// The structure.
    pub info: &'a vk::GraphicsPipelineCreateInfo<'a>,
    /// Parts that it describes.
    flags: Flags,
    /// The libraries that contain the other parts.
    pub libraries: &'a [vk::Pipeline],
    /// Its shaders.
    pub stages: Vec<vk::PipelineShaderStageCreateInfo<'a>>,
    /// Viewports and scissors.
    pub viewports: Option<&'a vk::PipelineViewportStateCreateInfo<'a>>,
    /// The depth test.
    pub depth: Option<&'a vk::PipelineDepthStencilStateCreateInfo<'a>>,
    /// Blending of colours.
    pub blend: Option<&'a vk::PipelineColorBlendStateCreateInfo<'a>>,
    /// The states that commands set.
    pub dynamic: &'a [vk::DynamicState],
    discards: bool,
}

impl<'a> Parts<'a> {
    /// # Safety
    /// `info` must be the program's.
    pub unsafe fn of(info: &'a vk::GraphicsPipelineCreateInfo<'a>) -> Self {
        // SAFETY: as promised; a pointer is followed only if its part is described.
        unsafe {
            let part = vk::StructureType::GRAPHICS_PIPELINE_LIBRARY_CREATE_INFO_EXT;
            let part = in_chain::<vk::GraphicsPipelineLibraryCreateInfoEXT<'_>>(info.p_next, part);
            let linked = vk::StructureType::PIPELINE_LIBRARY_CREATE_INFO_KHR;
            let linked = in_chain::<vk::PipelineLibraryCreateInfoKHR<'_>>(info.p_next, linked);
            let libraries = linked.map_or(&[][..], |l| slice(l.p_libraries, l.library_count));
            let whole = libraries.is_empty() && !info.flags.contains(vk::PipelineCreateFlags::LIBRARY_KHR);
            let all = Flags::VERTEX_INPUT_INTERFACE
                | Flags::PRE_RASTERIZATION_SHADERS
                | Flags::FRAGMENT_SHADER
                | Flags::FRAGMENT_OUTPUT_INTERFACE;
            let flags = part.map_or(if whole { all } else { Flags::empty() }, |part| part.flags);
            let before = flags.contains(Flags::PRE_RASTERIZATION_SHADERS);
            let fragment = flags.contains(Flags::FRAGMENT_SHADER);
            let dynamic = info.p_dynamic_state.as_ref().filter(|_| !flags.is_empty());
            let dynamic = dynamic.map_or(&[][..], |d| slice(d.p_dynamic_states, d.dynamic_state_count));
            let raster = info.p_rasterization_state.as_ref().filter(|_| before);
            let discards = !dynamic.contains(&vk::DynamicState::RASTERIZER_DISCARD_ENABLE)
                && raster.is_some_and(|raster| raster.rasterizer_discard_enable == vk::TRUE);
            let stages = if before || fragment { slice(info.p_stages, info.stage_count) } else { &[] };
            let of_part = |stage: &&vk::PipelineShaderStageCreateInfo<'_>| match stage.stage {
                vk::ShaderStageFlags::FRAGMENT => fragment,
                _ => before,
            };
            Self {
                info,
                flags,
                libraries,
                stages: stages.iter().filter(of_part).copied().collect(),
                viewports: info.p_viewport_state.as_ref().filter(|_| before && !discards),
                depth: info.p_depth_stencil_state.as_ref().filter(|_| fragment && !discards),
                blend: info
                    .p_color_blend_state
                    .as_ref()
                    .filter(|_| flags.contains(Flags::FRAGMENT_OUTPUT_INTERFACE) && !discards),
                dynamic,
                discards,
            }
        }
    }

    /// True if its drawing can be visible.
    pub fn is_seen(&self) -> bool {
        !self.discards
    }

    /// True if it has the stages before rasterisation.
    pub fn places_vertices(&self) -> bool {
        self.flags.contains(Flags::PRE_RASTERIZATION_SHADERS)
    }

    /// True if it has vertex input and all shaders.
    pub fn shades_all(&self) -> bool {
        let input = self.flags.contains(Flags::VERTEX_INPUT_INTERFACE);
        input && self.flags.contains(Flags::PRE_RASTERIZATION_SHADERS | Flags::FRAGMENT_SHADER)
    }

    /// The vertex input; `None` if this part does not describe it.
    fn vertex_input(&self) -> Option<&'a vk::PipelineVertexInputStateCreateInfo<'a>> {
        let described = self.flags.contains(Flags::VERTEX_INPUT_INTERFACE);
        let fixed = described && !self.dynamic.contains(&vk::DynamicState::VERTEX_INPUT_EXT);
        let state = Some(self.info.p_vertex_input_state).filter(|_| fixed)?;
        // SAFETY: the program's pointer, to a part that is described here.
        unsafe { state.as_ref() }
    }

    /// Number of vertex attributes; `None` if this part does not describe them.
    pub fn attributes(&self) -> Option<u32> {
        self.vertex_input().map(|state| state.vertex_attribute_description_count)
    }

    /// True if this part describes triangles whose vertices have no attributes. If commands set the
    /// kind of primitives, only its class is given here.
    pub fn has_bare_triangles(&self) -> bool {
        use vk::PrimitiveTopology as T;
        let described = self.flags.contains(Flags::VERTEX_INPUT_INTERFACE);
        let assembly = Some(self.info.p_input_assembly_state).filter(|_| described);
        // SAFETY: the program's pointer, to a part that is described here.
        let assembly = assembly.and_then(|assembly| unsafe { assembly.as_ref() });
        let triangles = [T::TRIANGLE_LIST, T::TRIANGLE_STRIP, T::TRIANGLE_FAN];
        self.attributes() == Some(0) && assembly.is_some_and(|assembly| triangles.contains(&assembly.topology))
    }

    /// Attributes of instances that may be columns of a matrix.
    pub fn columns(&self) -> Vec<InstanceColumn> {
        let Some(state) = self.vertex_input() else { return Vec::new() };
        // SAFETY: the program's arrays.
        let (bindings, attributes) = unsafe {
            let bindings = slice(state.p_vertex_binding_descriptions, state.vertex_binding_description_count);
            (bindings, slice(state.p_vertex_attribute_descriptions, state.vertex_attribute_description_count))
        };
        let column = |attribute: &vk::VertexInputAttributeDescription| {
            let of_binding = bindings.iter().find(|binding| binding.binding == attribute.binding)?;
            let is_column = attribute.format == vk::Format::R32G32B32A32_SFLOAT
                && of_binding.input_rate == vk::VertexInputRate::INSTANCE;
            let vk::VertexInputAttributeDescription { location, binding, offset, .. } = *attribute;
            is_column.then_some(InstanceColumn { location, binding, offset, stride: of_binding.stride })
        };
        attributes.iter().filter_map(column).collect()
    }

    /// True if it has shaders, and so needs a layout.
    pub fn shades(&self) -> bool {
        self.flags.intersects(Flags::PRE_RASTERIZATION_SHADERS | Flags::FRAGMENT_SHADER)
    }

    /// Returns the reason why it can have no variants; `None` if it can.
    pub fn obstacle(&self) -> Option<Obstacle> {
        let rendering = vk::StructureType::PIPELINE_RENDERING_CREATE_INFO;
        // SAFETY: the program's chain.
        let rendering = unsafe { in_chain::<vk::PipelineRenderingCreateInfo<'_>>(self.info.p_next, rendering) };
        if rendering.is_some_and(|rendering| rendering.view_mask != 0) {
            return Some("it uses multiview or layers".into());
        }
        let several = self.viewports.is_some_and(|state| state.viewport_count > 1 || state.scissor_count > 1);
        several.then(|| "several viewports".into())
    }

    /// The first viewport, unless commands set it.
    pub fn viewport(&self) -> Option<vk::Viewport> {
        let state = self.fixed([vk::DynamicState::VIEWPORT, vk::DynamicState::VIEWPORT_WITH_COUNT])?;
        // SAFETY: the program's array, which is read only if it is not set by commands.
        unsafe { slice(state.p_viewports, state.viewport_count) }.first().copied()
    }

    /// The first scissor, unless commands set it.
    pub fn scissor(&self) -> Option<vk::Rect2D> {
        let state = self.fixed([vk::DynamicState::SCISSOR, vk::DynamicState::SCISSOR_WITH_COUNT])?;
        // SAFETY: as above.
        unsafe { slice(state.p_scissors, state.scissor_count) }.first().copied()
    }

    fn fixed(&self, by: [vk::DynamicState; 2]) -> Option<&'a vk::PipelineViewportStateCreateInfo<'a>> {
        self.viewports.filter(|_| !by.iter().any(|state| self.dynamic.contains(state)))
    }
}

/// Copy of a chain of structures of the program, with other libraries.
pub struct Relinked {
    chain: Copied,
    _libraries: Vec<vk::Pipeline>,
}

impl Relinked {
    /// `None` if an unknown structure comes before the structure that names the libraries.
    ///
    /// # Safety
    /// `chain` must be the program's, with a structure that names libraries.
    pub unsafe fn new(chain: *const c_void, libraries: Vec<vk::Pipeline>) -> Option<Self> {
        // SAFETY: as promised.
        unsafe {
            let mut chain = Copied::up_to(chain, vk::StructureType::PIPELINE_LIBRARY_CREATE_INFO_KHR, length)?;
            chain.last::<vk::PipelineLibraryCreateInfoKHR<'_>>()?.p_libraries = libraries.as_ptr();
            Some(Self { chain, _libraries: libraries })
        }
    }

    /// The first structure.
    pub fn first(&self) -> *const c_void {
        self.chain.first()
    }
}

/// Returns the length of a structure that may come before the one that names libraries.
fn length(kind: vk::StructureType) -> Option<usize> {
    use vk::StructureType as K;
    Some(match kind {
        K::PIPELINE_LIBRARY_CREATE_INFO_KHR => size_of::<vk::PipelineLibraryCreateInfoKHR<'_>>(),
        K::GRAPHICS_PIPELINE_LIBRARY_CREATE_INFO_EXT => size_of::<vk::GraphicsPipelineLibraryCreateInfoEXT<'_>>(),
        K::PIPELINE_RENDERING_CREATE_INFO => size_of::<vk::PipelineRenderingCreateInfo<'_>>(),
        K::PIPELINE_CREATION_FEEDBACK_CREATE_INFO => size_of::<vk::PipelineCreationFeedbackCreateInfo<'_>>(),
        K::PIPELINE_CREATE_FLAGS_2_CREATE_INFO_KHR => size_of::<vk::PipelineCreateFlags2CreateInfoKHR<'_>>(),
        K::PIPELINE_ROBUSTNESS_CREATE_INFO_EXT => size_of::<vk::PipelineRobustnessCreateInfoEXT<'_>>(),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::{Parts, Relinked};
    use ash::vk::{self, GraphicsPipelineLibraryFlagsEXT as Flags, Handle};

    fn library(number: u64) -> vk::Pipeline {
        vk::Pipeline::from_raw(number)
    }

    #[test]
    fn only_the_parts_that_are_described_are_looked_at() {
        let mut part = vk::GraphicsPipelineLibraryCreateInfoEXT::default().flags(Flags::FRAGMENT_OUTPUT_INTERFACE);
        let blend = vk::PipelineColorBlendStateCreateInfo::default();
        let mut info = vk::GraphicsPipelineCreateInfo::default()
            .flags(vk::PipelineCreateFlags::LIBRARY_KHR)
            .color_blend_state(&blend)
            .push_next(&mut part);
        // Pointers of other parts may be invalid.
        (info.p_viewport_state, info.p_rasterization_state) = (std::ptr::dangling(), std::ptr::dangling());
        (info.p_depth_stencil_state, info.p_stages, info.stage_count) = (std::ptr::dangling(), std::ptr::dangling(), 2);
        // SAFETY: the pointers of this part are valid.
        let parts = unsafe { Parts::of(&info) };
        assert!(parts.stages.is_empty() && parts.viewports.is_none() && parts.depth.is_none() && parts.blend.is_some());
        assert!(parts.is_seen() && !parts.places_vertices() && !parts.shades());
    }

    #[test]
    fn lines_and_vertices_with_attributes_are_no_bare_triangles() {
        use vk::PrimitiveTopology as T;
        let bare = |topology, attributes: &[vk::VertexInputAttributeDescription]| {
            let input = vk::PipelineVertexInputStateCreateInfo::default().vertex_attribute_descriptions(attributes);
            let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(topology);
            let info = vk::GraphicsPipelineCreateInfo::default();
            let info = info.vertex_input_state(&input).input_assembly_state(&assembly);
            // SAFETY: the pointers are valid or null.
            unsafe { Parts::of(&info) }.has_bare_triangles()
        };
        assert!(bare(T::TRIANGLE_LIST, &[]) && bare(T::TRIANGLE_STRIP, &[]));
        assert!(
            !bare(T::LINE_LIST, &[]) && !bare(T::POINT_LIST, &[]) && !bare(T::TRIANGLE_LIST, &[Default::default()])
        );
    }

    #[test]
    fn a_pipeline_of_libraries_alone_describes_nothing() {
        let libraries = [library(1), library(2)];
        let mut linked = vk::PipelineLibraryCreateInfoKHR::default().libraries(&libraries);
        let mut info = vk::GraphicsPipelineCreateInfo::default().push_next(&mut linked);
        (info.p_rasterization_state, info.p_dynamic_state) = (std::ptr::dangling(), std::ptr::dangling());
        // SAFETY: only the list belongs to it.
        let parts = unsafe { Parts::of(&info) };
        assert_eq!(parts.libraries, libraries);
        assert!(parts.dynamic.is_empty() && !parts.shades());
    }

    #[test]
    fn other_libraries_take_the_place_of_the_programs() {
        let libraries = [library(1), library(2)];
        let mut rendering = vk::PipelineRenderingCreateInfo::default().view_mask(7);
        let mut linked = vk::PipelineLibraryCreateInfoKHR::default().libraries(&libraries);
        let mut part = vk::GraphicsPipelineLibraryCreateInfoEXT::default();
        // push_next puts each structure before the others.
        let info = vk::GraphicsPipelineCreateInfo::default();
        let info = info.push_next(&mut rendering).push_next(&mut linked).push_next(&mut part);
        // SAFETY: a chain of Vulkan's structures.
        let changed = unsafe { Relinked::new(info.p_next, vec![library(8), library(9)]) }.expect("all are known");
        let other = vk::GraphicsPipelineCreateInfo { p_next: changed.first(), ..Default::default() };
        // SAFETY: as above; the copies live.
        let (parts, kept) = unsafe {
            let kind = vk::StructureType::PIPELINE_RENDERING_CREATE_INFO;
            (Parts::of(&other), super::in_chain::<vk::PipelineRenderingCreateInfo<'_>>(other.p_next, kind))
        };
        assert_eq!(parts.libraries, [library(8), library(9)]);
        assert_eq!(kept.map(|rendering| rendering.view_mask), Some(7));
        // SAFETY: as above.
        assert_eq!(unsafe { Parts::of(&info) }.libraries, libraries, "the program's own chain is unchanged");
    }
}
