//! Entry points of a device that have hooks: their names, and the next layer's functions.
//!
//! The hooks themselves are in the other modules. Each
//! [`hooks!`](crate::intercept::vk::state::hooks) names the entries of this table that it answers.

use ash::vk;
use std::ffi::CStr;

/// Defines [`NextLayer`] and [`names`].
macro_rules! entry_points {
    ($( $method:ident: $pfn:ident [$($name:literal),+] )*) => {
        /// The next layer's functions; `None` if it does not have one.
        pub struct NextLayer { $( pub(in crate::intercept::vk) $method: Option<vk::$pfn>, )* }

        impl NextLayer {
            /// # Safety
            /// `find` must return a device's functions.
            pub unsafe fn load(find: &dyn Fn(&CStr) -> vk::PFN_vkVoidFunction) -> Self {
                // SAFETY: as promised; a function has the type that belongs to its name in Vulkan.
                unsafe {
                    Self { $( $method: [$($name),+].into_iter().find_map(find).map(|f| std::mem::transmute::<unsafe extern "system" fn(), vk::$pfn>(f)), )* }
                }
            }
        }

        /// The names of each entry point: its own, and those from extensions.
        #[allow(non_upper_case_globals, missing_docs)]
        pub mod names {
            use std::ffi::CStr;
            $( pub const $method: &[&CStr] = &[$($name),+]; )*
        }
    };
}

entry_points! {
    // Command buffers.
    allocate_command_buffers: PFN_vkAllocateCommandBuffers [c"vkAllocateCommandBuffers"]
    free_command_buffers: PFN_vkFreeCommandBuffers [c"vkFreeCommandBuffers"]
    destroy_command_pool: PFN_vkDestroyCommandPool [c"vkDestroyCommandPool"]
    begin_command_buffer: PFN_vkBeginCommandBuffer [c"vkBeginCommandBuffer"]
    cmd_execute_commands: PFN_vkCmdExecuteCommands [c"vkCmdExecuteCommands"]

    // Bound state.
    cmd_bind_pipeline: PFN_vkCmdBindPipeline [c"vkCmdBindPipeline"]
    cmd_bind_descriptor_sets: PFN_vkCmdBindDescriptorSets [c"vkCmdBindDescriptorSets"]
    cmd_push_constants: PFN_vkCmdPushConstants [c"vkCmdPushConstants"]
    cmd_set_viewport: PFN_vkCmdSetViewport [c"vkCmdSetViewport"]
    cmd_set_scissor: PFN_vkCmdSetScissor [c"vkCmdSetScissor"]
    cmd_set_viewport_with_count: PFN_vkCmdSetViewportWithCount [c"vkCmdSetViewportWithCount", c"vkCmdSetViewportWithCountEXT"]
    cmd_set_scissor_with_count: PFN_vkCmdSetScissorWithCount [c"vkCmdSetScissorWithCount", c"vkCmdSetScissorWithCountEXT"]
    cmd_bind_vertex_buffers: PFN_vkCmdBindVertexBuffers [c"vkCmdBindVertexBuffers"]
    cmd_bind_vertex_buffers2: PFN_vkCmdBindVertexBuffers2 [c"vkCmdBindVertexBuffers2", c"vkCmdBindVertexBuffers2EXT"]
    cmd_bind_shaders: PFN_vkCmdBindShadersEXT [c"vkCmdBindShadersEXT"]

    // Draws.
    cmd_draw: PFN_vkCmdDraw [c"vkCmdDraw"]
    cmd_draw_indexed: PFN_vkCmdDrawIndexed [c"vkCmdDrawIndexed"]
    cmd_draw_indirect: PFN_vkCmdDrawIndirect [c"vkCmdDrawIndirect"]
    cmd_draw_indexed_indirect: PFN_vkCmdDrawIndexedIndirect [c"vkCmdDrawIndexedIndirect"]
    cmd_draw_indirect_count: PFN_vkCmdDrawIndirectCount [c"vkCmdDrawIndirectCount", c"vkCmdDrawIndirectCountKHR", c"vkCmdDrawIndirectCountAMD"]
    cmd_draw_indexed_indirect_count: PFN_vkCmdDrawIndexedIndirectCount [c"vkCmdDrawIndexedIndirectCount", c"vkCmdDrawIndexedIndirectCountKHR", c"vkCmdDrawIndexedIndirectCountAMD"]
    cmd_draw_multi: PFN_vkCmdDrawMultiEXT [c"vkCmdDrawMultiEXT"]
    cmd_draw_multi_indexed: PFN_vkCmdDrawMultiIndexedEXT [c"vkCmdDrawMultiIndexedEXT"]
    cmd_draw_mesh_tasks: PFN_vkCmdDrawMeshTasksEXT [c"vkCmdDrawMeshTasksEXT"]
    cmd_draw_mesh_tasks_nv: PFN_vkCmdDrawMeshTasksNV [c"vkCmdDrawMeshTasksNV"]
    cmd_draw_mesh_tasks_indirect: PFN_vkCmdDrawMeshTasksIndirectEXT [c"vkCmdDrawMeshTasksIndirectEXT"]
    cmd_draw_mesh_tasks_indirect_nv: PFN_vkCmdDrawMeshTasksIndirectNV [c"vkCmdDrawMeshTasksIndirectNV"]
    cmd_draw_mesh_tasks_count: PFN_vkCmdDrawMeshTasksIndirectCountEXT [c"vkCmdDrawMeshTasksIndirectCountEXT"]
    cmd_draw_mesh_tasks_count_nv: PFN_vkCmdDrawMeshTasksIndirectCountNV [c"vkCmdDrawMeshTasksIndirectCountNV"]
    cmd_draw_indirect_byte_count: PFN_vkCmdDrawIndirectByteCountEXT [c"vkCmdDrawIndirectByteCountEXT"]
    cmd_begin_transform_feedback: PFN_vkCmdBeginTransformFeedbackEXT [c"vkCmdBeginTransformFeedbackEXT"]

    // Compute shaders.
    cmd_dispatch: PFN_vkCmdDispatch [c"vkCmdDispatch"]
    cmd_dispatch_base: PFN_vkCmdDispatchBase [c"vkCmdDispatchBase", c"vkCmdDispatchBaseKHR"]
    cmd_dispatch_indirect: PFN_vkCmdDispatchIndirect [c"vkCmdDispatchIndirect"]

    // Render passes and framebuffers.
    create_render_pass: PFN_vkCreateRenderPass [c"vkCreateRenderPass"]
    create_render_pass2: PFN_vkCreateRenderPass2 [c"vkCreateRenderPass2", c"vkCreateRenderPass2KHR"]
    destroy_render_pass: PFN_vkDestroyRenderPass [c"vkDestroyRenderPass"]
    create_framebuffer: PFN_vkCreateFramebuffer [c"vkCreateFramebuffer"]
    destroy_framebuffer: PFN_vkDestroyFramebuffer [c"vkDestroyFramebuffer"]

    // Begin and end of passes.
    cmd_begin_render_pass: PFN_vkCmdBeginRenderPass [c"vkCmdBeginRenderPass"]
    cmd_begin_render_pass2: PFN_vkCmdBeginRenderPass2 [c"vkCmdBeginRenderPass2", c"vkCmdBeginRenderPass2KHR"]
    cmd_next_subpass: PFN_vkCmdNextSubpass [c"vkCmdNextSubpass"]
    cmd_next_subpass2: PFN_vkCmdNextSubpass2 [c"vkCmdNextSubpass2", c"vkCmdNextSubpass2KHR"]
    cmd_end_render_pass: PFN_vkCmdEndRenderPass [c"vkCmdEndRenderPass"]
    cmd_end_render_pass2: PFN_vkCmdEndRenderPass2 [c"vkCmdEndRenderPass2", c"vkCmdEndRenderPass2KHR"]
    cmd_begin_rendering: PFN_vkCmdBeginRendering [c"vkCmdBeginRendering", c"vkCmdBeginRenderingKHR"]
    cmd_end_rendering: PFN_vkCmdEndRendering [c"vkCmdEndRendering", c"vkCmdEndRenderingKHR"]

    // Barriers and clears, and writes to buffers.
    cmd_pipeline_barrier: PFN_vkCmdPipelineBarrier [c"vkCmdPipelineBarrier"]
    cmd_pipeline_barrier2: PFN_vkCmdPipelineBarrier2 [c"vkCmdPipelineBarrier2", c"vkCmdPipelineBarrier2KHR"]
    cmd_wait_events: PFN_vkCmdWaitEvents [c"vkCmdWaitEvents"]
    cmd_set_event2: PFN_vkCmdSetEvent2 [c"vkCmdSetEvent2", c"vkCmdSetEvent2KHR"]
    cmd_wait_events2: PFN_vkCmdWaitEvents2 [c"vkCmdWaitEvents2", c"vkCmdWaitEvents2KHR"]
    cmd_clear_attachments: PFN_vkCmdClearAttachments [c"vkCmdClearAttachments"]
    cmd_clear_color_image: PFN_vkCmdClearColorImage [c"vkCmdClearColorImage"]
    cmd_clear_depth_stencil_image: PFN_vkCmdClearDepthStencilImage [c"vkCmdClearDepthStencilImage"]
    cmd_copy_buffer: PFN_vkCmdCopyBuffer [c"vkCmdCopyBuffer"]
    cmd_copy_buffer2: PFN_vkCmdCopyBuffer2 [c"vkCmdCopyBuffer2", c"vkCmdCopyBuffer2KHR"]
    cmd_update_buffer: PFN_vkCmdUpdateBuffer [c"vkCmdUpdateBuffer"]

    // Copies of images.
    cmd_copy_image: PFN_vkCmdCopyImage [c"vkCmdCopyImage"]
    cmd_blit_image: PFN_vkCmdBlitImage [c"vkCmdBlitImage"]
    cmd_resolve_image: PFN_vkCmdResolveImage [c"vkCmdResolveImage"]
    cmd_copy_image2: PFN_vkCmdCopyImage2 [c"vkCmdCopyImage2", c"vkCmdCopyImage2KHR"]
    cmd_blit_image2: PFN_vkCmdBlitImage2 [c"vkCmdBlitImage2", c"vkCmdBlitImage2KHR"]
    cmd_resolve_image2: PFN_vkCmdResolveImage2 [c"vkCmdResolveImage2", c"vkCmdResolveImage2KHR"]
    cmd_copy_buffer_to_image: PFN_vkCmdCopyBufferToImage [c"vkCmdCopyBufferToImage"]
    cmd_copy_buffer_to_image2: PFN_vkCmdCopyBufferToImage2 [c"vkCmdCopyBufferToImage2", c"vkCmdCopyBufferToImage2KHR"]
    cmd_copy_image_to_buffer: PFN_vkCmdCopyImageToBuffer [c"vkCmdCopyImageToBuffer"]
    cmd_copy_image_to_buffer2: PFN_vkCmdCopyImageToBuffer2 [c"vkCmdCopyImageToBuffer2", c"vkCmdCopyImageToBuffer2KHR"]

    // Conditional rendering.
    cmd_begin_conditional_rendering: PFN_vkCmdBeginConditionalRenderingEXT [c"vkCmdBeginConditionalRenderingEXT"]
    cmd_end_conditional_rendering: PFN_vkCmdEndConditionalRenderingEXT [c"vkCmdEndConditionalRenderingEXT"]

    // Commands that cannot be followed.
    cmd_bind_descriptor_sets2: PFN_vkCmdBindDescriptorSets2KHR [c"vkCmdBindDescriptorSets2KHR", c"vkCmdBindDescriptorSets2"]
    cmd_push_constants2: PFN_vkCmdPushConstants2KHR [c"vkCmdPushConstants2KHR", c"vkCmdPushConstants2"]
    cmd_push_descriptor_set2: PFN_vkCmdPushDescriptorSet2KHR [c"vkCmdPushDescriptorSet2KHR", c"vkCmdPushDescriptorSet2"]
    cmd_push_with_template2: PFN_vkCmdPushDescriptorSetWithTemplate2KHR [c"vkCmdPushDescriptorSetWithTemplate2KHR", c"vkCmdPushDescriptorSetWithTemplate2"]
    cmd_bind_descriptor_buffers: PFN_vkCmdBindDescriptorBuffersEXT [c"vkCmdBindDescriptorBuffersEXT"]
    cmd_bind_shader_group: PFN_vkCmdBindPipelineShaderGroupNV [c"vkCmdBindPipelineShaderGroupNV"]
    cmd_execute_generated: PFN_vkCmdExecuteGeneratedCommandsNV [c"vkCmdExecuteGeneratedCommandsNV"]
    cmd_draw_cluster: PFN_vkCmdDrawClusterHUAWEI [c"vkCmdDrawClusterHUAWEI"]
    cmd_draw_cluster_indirect: PFN_vkCmdDrawClusterIndirectHUAWEI [c"vkCmdDrawClusterIndirectHUAWEI"]
    cmd_subpass_shading: PFN_vkCmdSubpassShadingHUAWEI [c"vkCmdSubpassShadingHUAWEI"]
    cmd_set_discard_rectangle: PFN_vkCmdSetDiscardRectangleEXT [c"vkCmdSetDiscardRectangleEXT"]
    cmd_set_exclusive_scissor: PFN_vkCmdSetExclusiveScissorNV [c"vkCmdSetExclusiveScissorNV"]
    cmd_set_viewport_w_scaling: PFN_vkCmdSetViewportWScalingNV [c"vkCmdSetViewportWScalingNV"]
    cmd_set_viewport_swizzle: PFN_vkCmdSetViewportSwizzleNV [c"vkCmdSetViewportSwizzleNV"]
    cmd_bind_shading_rate_image: PFN_vkCmdBindShadingRateImageNV [c"vkCmdBindShadingRateImageNV"]
    cmd_bind_invocation_mask: PFN_vkCmdBindInvocationMaskHUAWEI [c"vkCmdBindInvocationMaskHUAWEI"]
    cmd_set_attachment_locations: PFN_vkCmdSetRenderingAttachmentLocationsKHR [c"vkCmdSetRenderingAttachmentLocationsKHR", c"vkCmdSetRenderingAttachmentLocations"]
    cmd_set_input_indices: PFN_vkCmdSetRenderingInputAttachmentIndicesKHR [c"vkCmdSetRenderingInputAttachmentIndicesKHR", c"vkCmdSetRenderingInputAttachmentIndices"]
    cmd_copy_memory_to_image: PFN_vkCmdCopyMemoryToImageIndirectNV [c"vkCmdCopyMemoryToImageIndirectNV"]
    copy_memory_to_image: PFN_vkCopyMemoryToImageEXT [c"vkCopyMemoryToImageEXT", c"vkCopyMemoryToImage"]
    copy_image_to_memory: PFN_vkCopyImageToMemoryEXT [c"vkCopyImageToMemoryEXT", c"vkCopyImageToMemory"]
    copy_image_to_image: PFN_vkCopyImageToImageEXT [c"vkCopyImageToImageEXT", c"vkCopyImageToImage"]
    transition_image_layout: PFN_vkTransitionImageLayoutEXT [c"vkTransitionImageLayoutEXT", c"vkTransitionImageLayout"]

    // Descriptor sets.
    create_descriptor_set_layout: PFN_vkCreateDescriptorSetLayout [c"vkCreateDescriptorSetLayout"]
    destroy_descriptor_set_layout: PFN_vkDestroyDescriptorSetLayout [c"vkDestroyDescriptorSetLayout"]
    allocate_descriptor_sets: PFN_vkAllocateDescriptorSets [c"vkAllocateDescriptorSets"]
    free_descriptor_sets: PFN_vkFreeDescriptorSets [c"vkFreeDescriptorSets"]
    reset_descriptor_pool: PFN_vkResetDescriptorPool [c"vkResetDescriptorPool"]
    destroy_descriptor_pool: PFN_vkDestroyDescriptorPool [c"vkDestroyDescriptorPool"]
    update_descriptor_sets: PFN_vkUpdateDescriptorSets [c"vkUpdateDescriptorSets"]
    create_template: PFN_vkCreateDescriptorUpdateTemplate [c"vkCreateDescriptorUpdateTemplate", c"vkCreateDescriptorUpdateTemplateKHR"]
    destroy_template: PFN_vkDestroyDescriptorUpdateTemplate [c"vkDestroyDescriptorUpdateTemplate", c"vkDestroyDescriptorUpdateTemplateKHR"]
    update_with_template: PFN_vkUpdateDescriptorSetWithTemplate [c"vkUpdateDescriptorSetWithTemplate", c"vkUpdateDescriptorSetWithTemplateKHR"]

    // Push descriptors.
    cmd_push_descriptor_set: PFN_vkCmdPushDescriptorSetKHR [c"vkCmdPushDescriptorSetKHR", c"vkCmdPushDescriptorSet"]
    cmd_push_with_template: PFN_vkCmdPushDescriptorSetWithTemplateKHR [c"vkCmdPushDescriptorSetWithTemplateKHR", c"vkCmdPushDescriptorSetWithTemplate"]

    // Images and image views.
    create_image: PFN_vkCreateImage [c"vkCreateImage"]
    destroy_image: PFN_vkDestroyImage [c"vkDestroyImage"]
    create_image_view: PFN_vkCreateImageView [c"vkCreateImageView"]
    destroy_image_view: PFN_vkDestroyImageView [c"vkDestroyImageView"]

    // Shader modules and pipeline layouts.
    create_shader_module: PFN_vkCreateShaderModule [c"vkCreateShaderModule"]
    destroy_shader_module: PFN_vkDestroyShaderModule [c"vkDestroyShaderModule"]
    create_pipeline_layout: PFN_vkCreatePipelineLayout [c"vkCreatePipelineLayout"]
    destroy_pipeline_layout: PFN_vkDestroyPipelineLayout [c"vkDestroyPipelineLayout"]

    // Pipelines.
    create_graphics_pipelines: PFN_vkCreateGraphicsPipelines [c"vkCreateGraphicsPipelines"]
    create_compute_pipelines: PFN_vkCreateComputePipelines [c"vkCreateComputePipelines"]
    destroy_pipeline: PFN_vkDestroyPipeline [c"vkDestroyPipeline"]

    // Queries.
    create_query_pool: PFN_vkCreateQueryPool [c"vkCreateQueryPool"]
    destroy_query_pool: PFN_vkDestroyQueryPool [c"vkDestroyQueryPool"]
    cmd_begin_query: PFN_vkCmdBeginQuery [c"vkCmdBeginQuery"]
    cmd_begin_query_indexed: PFN_vkCmdBeginQueryIndexedEXT [c"vkCmdBeginQueryIndexedEXT"]
    cmd_end_query: PFN_vkCmdEndQuery [c"vkCmdEndQuery"]
    cmd_end_query_indexed: PFN_vkCmdEndQueryIndexedEXT [c"vkCmdEndQueryIndexedEXT"]
    get_query_pool_results: PFN_vkGetQueryPoolResults [c"vkGetQueryPoolResults"]
    cmd_copy_query_pool_results: PFN_vkCmdCopyQueryPoolResults [c"vkCmdCopyQueryPoolResults"]

    // Buffers and memory.
    create_buffer: PFN_vkCreateBuffer [c"vkCreateBuffer"]
    destroy_buffer: PFN_vkDestroyBuffer [c"vkDestroyBuffer"]
    get_buffer_address: PFN_vkGetBufferDeviceAddress [c"vkGetBufferDeviceAddress", c"vkGetBufferDeviceAddressKHR", c"vkGetBufferDeviceAddressEXT"]
    bind_buffer_memory: PFN_vkBindBufferMemory [c"vkBindBufferMemory"]
    bind_buffer_memory2: PFN_vkBindBufferMemory2 [c"vkBindBufferMemory2", c"vkBindBufferMemory2KHR"]
    map_memory: PFN_vkMapMemory [c"vkMapMemory"]
    map_memory2: PFN_vkMapMemory2KHR [c"vkMapMemory2KHR"]
    unmap_memory: PFN_vkUnmapMemory [c"vkUnmapMemory"]
    unmap_memory2: PFN_vkUnmapMemory2KHR [c"vkUnmapMemory2KHR"]
    free_memory: PFN_vkFreeMemory [c"vkFreeMemory"]

    // Submissions.
    queue_submit: PFN_vkQueueSubmit [c"vkQueueSubmit"]
    queue_submit2: PFN_vkQueueSubmit2 [c"vkQueueSubmit2", c"vkQueueSubmit2KHR"]
}

impl NextLayer {
    /// True if there may be imageless framebuffers, which state how their images may be used.
    pub fn compares_usage(&self) -> bool {
        self.create_render_pass2.is_some()
    }
}
