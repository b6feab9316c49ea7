//! Lengths of the structures in the chain of `VkDeviceCreateInfo`.

use crate::intercept::vk::layer::chain_links::LAYER_INFO_LENGTH;
use ash::vk;

macro_rules! lengths {
    ($($structure:ident,)*) => {
        &[$((
            <vk::$structure<'static> as vk::TaggedStructure>::STRUCTURE_TYPE,
            size_of::<vk::$structure<'static>>(),
        ),)*]
    };
}

/// Returns the length of a structure that may come before the features in the chain that creates a
/// device: a structure of Vulkan's registry, or the loader's own.
pub fn length_for_device(kind: vk::StructureType) -> Option<usize> {
    if kind == vk::StructureType::LOADER_DEVICE_CREATE_INFO {
        return Some(LAYER_INFO_LENGTH);
    }
    LENGTHS.iter().find(|(own, _)| *own == kind).map(|(_, length)| *length)
}

/// Lengths of the structures of the registry.
#[rustfmt::skip]
const LENGTHS: &[(vk::StructureType, usize)] = lengths! {
    PhysicalDeviceFeatures2,
    DeviceDeviceMemoryReportCreateInfoEXT, DeviceDiagnosticsConfigCreateInfoNV, DeviceGroupDeviceCreateInfo,
    DeviceMemoryOverallocationCreateInfoAMD, DevicePrivateDataCreateInfo, DeviceQueueShaderCoreControlCreateInfoARM,
    PhysicalDevice16BitStorageFeatures, PhysicalDevice4444FormatsFeaturesEXT, PhysicalDevice8BitStorageFeatures,
    PhysicalDeviceASTCDecodeFeaturesEXT, PhysicalDeviceAccelerationStructureFeaturesKHR,
    PhysicalDeviceAddressBindingReportFeaturesEXT, PhysicalDeviceAmigoProfilingFeaturesSEC,
    PhysicalDeviceAttachmentFeedbackLoopLayoutFeaturesEXT, PhysicalDeviceBlendOperationAdvancedFeaturesEXT,
    PhysicalDeviceBorderColorSwizzleFeaturesEXT, PhysicalDeviceBufferDeviceAddressFeatures,
    PhysicalDeviceBufferDeviceAddressFeaturesEXT, PhysicalDeviceClusterCullingShaderFeaturesHUAWEI,
    PhysicalDeviceCoherentMemoryFeaturesAMD, PhysicalDeviceColorWriteEnableFeaturesEXT,
    PhysicalDeviceComputeShaderDerivativesFeaturesNV, PhysicalDeviceConditionalRenderingFeaturesEXT,
    PhysicalDeviceCooperativeMatrixFeaturesKHR, PhysicalDeviceCooperativeMatrixFeaturesNV,
    PhysicalDeviceCopyMemoryIndirectFeaturesNV, PhysicalDeviceCornerSampledImageFeaturesNV,
    PhysicalDeviceCoverageReductionModeFeaturesNV, PhysicalDeviceCubicClampFeaturesQCOM,
    PhysicalDeviceCubicWeightsFeaturesQCOM, PhysicalDeviceCudaKernelLaunchFeaturesNV,
    PhysicalDeviceCustomBorderColorFeaturesEXT, PhysicalDeviceDepthBiasControlFeaturesEXT,
    PhysicalDeviceDepthClampZeroOneFeaturesEXT, PhysicalDeviceDepthClipControlFeaturesEXT,
    PhysicalDeviceDepthClipEnableFeaturesEXT, PhysicalDeviceDescriptorBufferFeaturesEXT,
    PhysicalDeviceDescriptorIndexingFeatures, PhysicalDeviceDescriptorPoolOverallocationFeaturesNV,
    PhysicalDeviceDescriptorSetHostMappingFeaturesVALVE, PhysicalDeviceDeviceGeneratedCommandsComputeFeaturesNV,
    PhysicalDeviceDeviceGeneratedCommandsFeaturesNV, PhysicalDeviceDeviceMemoryReportFeaturesEXT,
    PhysicalDeviceDiagnosticsConfigFeaturesNV, PhysicalDeviceDisplacementMicromapFeaturesNV,
    PhysicalDeviceDynamicRenderingFeatures, PhysicalDeviceDynamicRenderingLocalReadFeaturesKHR,
    PhysicalDeviceExclusiveScissorFeaturesNV, PhysicalDeviceExtendedDynamicState2FeaturesEXT,
    PhysicalDeviceExtendedDynamicState3FeaturesEXT, PhysicalDeviceExtendedDynamicStateFeaturesEXT,
    PhysicalDeviceExtendedSparseAddressSpaceFeaturesNV, PhysicalDeviceExternalFormatResolveFeaturesANDROID,
    PhysicalDeviceExternalMemoryRDMAFeaturesNV, PhysicalDeviceExternalMemoryScreenBufferFeaturesQNX,
    PhysicalDeviceFaultFeaturesEXT, PhysicalDeviceFragmentDensityMap2FeaturesEXT,
    PhysicalDeviceFragmentDensityMapFeaturesEXT, PhysicalDeviceFragmentDensityMapOffsetFeaturesQCOM,
    PhysicalDeviceFragmentShaderBarycentricFeaturesKHR, PhysicalDeviceFragmentShaderInterlockFeaturesEXT,
    PhysicalDeviceFragmentShadingRateEnumsFeaturesNV, PhysicalDeviceFragmentShadingRateFeaturesKHR,
    PhysicalDeviceFrameBoundaryFeaturesEXT, PhysicalDeviceGlobalPriorityQueryFeaturesKHR,
    PhysicalDeviceGraphicsPipelineLibraryFeaturesEXT, PhysicalDeviceHostImageCopyFeaturesEXT,
    PhysicalDeviceHostQueryResetFeatures, PhysicalDeviceImage2DViewOf3DFeaturesEXT,
    PhysicalDeviceImageCompressionControlFeaturesEXT, PhysicalDeviceImageProcessing2FeaturesQCOM,
    PhysicalDeviceImageProcessingFeaturesQCOM, PhysicalDeviceImageRobustnessFeatures,
    PhysicalDeviceImageSlicedViewOf3DFeaturesEXT, PhysicalDeviceImageViewMinLodFeaturesEXT,
    PhysicalDeviceImagelessFramebufferFeatures, PhysicalDeviceIndexTypeUint8FeaturesKHR,
    PhysicalDeviceInheritedViewportScissorFeaturesNV, PhysicalDeviceInlineUniformBlockFeatures,
    PhysicalDeviceInvocationMaskFeaturesHUAWEI, PhysicalDeviceLegacyDitheringFeaturesEXT,
    PhysicalDeviceLineRasterizationFeaturesKHR, PhysicalDeviceLinearColorAttachmentFeaturesNV,
    PhysicalDeviceMaintenance4Features, PhysicalDeviceMaintenance5FeaturesKHR, PhysicalDeviceMaintenance6FeaturesKHR,
    PhysicalDeviceMapMemoryPlacedFeaturesEXT, PhysicalDeviceMemoryDecompressionFeaturesNV,
    PhysicalDeviceMemoryPriorityFeaturesEXT, PhysicalDeviceMeshShaderFeaturesEXT, PhysicalDeviceMeshShaderFeaturesNV,
    PhysicalDeviceMultiDrawFeaturesEXT, PhysicalDeviceMultiviewFeatures,
    PhysicalDeviceMultiviewPerViewRenderAreasFeaturesQCOM, PhysicalDeviceMultiviewPerViewViewportsFeaturesQCOM,
    PhysicalDeviceMutableDescriptorTypeFeaturesEXT, PhysicalDeviceNestedCommandBufferFeaturesEXT,
    PhysicalDeviceNonSeamlessCubeMapFeaturesEXT, PhysicalDeviceOpacityMicromapFeaturesEXT,
    PhysicalDeviceOpticalFlowFeaturesNV, PhysicalDevicePageableDeviceLocalMemoryFeaturesEXT,
    PhysicalDevicePerStageDescriptorSetFeaturesNV, PhysicalDevicePerformanceQueryFeaturesKHR,
    PhysicalDevicePipelineCreationCacheControlFeatures, PhysicalDevicePipelineExecutablePropertiesFeaturesKHR,
    PhysicalDevicePipelineLibraryGroupHandlesFeaturesEXT, PhysicalDevicePipelinePropertiesFeaturesEXT,
    PhysicalDevicePipelineProtectedAccessFeaturesEXT, PhysicalDevicePipelineRobustnessFeaturesEXT,
    PhysicalDevicePortabilitySubsetFeaturesKHR, PhysicalDevicePresentBarrierFeaturesNV,
    PhysicalDevicePresentIdFeaturesKHR, PhysicalDevicePresentWaitFeaturesKHR,
    PhysicalDevicePrimitiveTopologyListRestartFeaturesEXT, PhysicalDevicePrimitivesGeneratedQueryFeaturesEXT,
    PhysicalDevicePrivateDataFeatures, PhysicalDeviceProtectedMemoryFeatures,
    PhysicalDeviceProvokingVertexFeaturesEXT, PhysicalDeviceRGBA10X6FormatsFeaturesEXT,
    PhysicalDeviceRawAccessChainsFeaturesNV, PhysicalDeviceRayQueryFeaturesKHR,
    PhysicalDeviceRayTracingInvocationReorderFeaturesNV, PhysicalDeviceRayTracingMaintenance1FeaturesKHR,
    PhysicalDeviceRayTracingMotionBlurFeaturesNV, PhysicalDeviceRayTracingPipelineFeaturesKHR,
    PhysicalDeviceRayTracingPositionFetchFeaturesKHR, PhysicalDeviceRayTracingValidationFeaturesNV,
    PhysicalDeviceRelaxedLineRasterizationFeaturesIMG, PhysicalDeviceRenderPassStripedFeaturesARM,
    PhysicalDeviceRepresentativeFragmentTestFeaturesNV, PhysicalDeviceRobustness2FeaturesEXT,
    PhysicalDeviceSamplerYcbcrConversionFeatures, PhysicalDeviceScalarBlockLayoutFeatures,
    PhysicalDeviceSchedulingControlsFeaturesARM, PhysicalDeviceSeparateDepthStencilLayoutsFeatures,
    PhysicalDeviceShaderAtomicFloat16VectorFeaturesNV, PhysicalDeviceShaderAtomicFloat2FeaturesEXT,
    PhysicalDeviceShaderAtomicFloatFeaturesEXT, PhysicalDeviceShaderAtomicInt64Features,
    PhysicalDeviceShaderClockFeaturesKHR, PhysicalDeviceShaderCoreBuiltinsFeaturesARM,
    PhysicalDeviceShaderDemoteToHelperInvocationFeatures, PhysicalDeviceShaderDrawParametersFeatures,
    PhysicalDeviceShaderEnqueueFeaturesAMDX, PhysicalDeviceShaderExpectAssumeFeaturesKHR,
    PhysicalDeviceShaderFloat16Int8Features, PhysicalDeviceShaderFloatControls2FeaturesKHR,
    PhysicalDeviceShaderImageAtomicInt64FeaturesEXT, PhysicalDeviceShaderImageFootprintFeaturesNV,
    PhysicalDeviceShaderIntegerDotProductFeatures, PhysicalDeviceShaderIntegerFunctions2FeaturesINTEL,
    PhysicalDeviceShaderMaximalReconvergenceFeaturesKHR, PhysicalDeviceShaderModuleIdentifierFeaturesEXT,
    PhysicalDeviceShaderObjectFeaturesEXT, PhysicalDeviceShaderQuadControlFeaturesKHR,
    PhysicalDeviceShaderSMBuiltinsFeaturesNV, PhysicalDeviceShaderSubgroupExtendedTypesFeatures,
    PhysicalDeviceShaderSubgroupRotateFeaturesKHR, PhysicalDeviceShaderTerminateInvocationFeatures,
    PhysicalDeviceShaderTileImageFeaturesEXT, PhysicalDeviceShadingRateImageFeaturesNV,
    PhysicalDeviceSubgroupSizeControlFeatures, PhysicalDeviceSubpassMergeFeedbackFeaturesEXT,
    PhysicalDeviceSubpassShadingFeaturesHUAWEI, PhysicalDeviceSwapchainMaintenance1FeaturesEXT,
    PhysicalDeviceSynchronization2Features, PhysicalDeviceTexelBufferAlignmentFeaturesEXT,
    PhysicalDeviceTextureCompressionASTCHDRFeatures, PhysicalDeviceTilePropertiesFeaturesQCOM,
    PhysicalDeviceTimelineSemaphoreFeatures, PhysicalDeviceTransformFeedbackFeaturesEXT,
    PhysicalDeviceUniformBufferStandardLayoutFeatures, PhysicalDeviceVariablePointersFeatures,
    PhysicalDeviceVertexAttributeDivisorFeaturesKHR, PhysicalDeviceVertexInputDynamicStateFeaturesEXT,
    PhysicalDeviceVideoMaintenance1FeaturesKHR, PhysicalDeviceVulkan11Features, PhysicalDeviceVulkan12Features,
    PhysicalDeviceVulkan13Features, PhysicalDeviceVulkanMemoryModelFeatures,
    PhysicalDeviceWorkgroupMemoryExplicitLayoutFeaturesKHR, PhysicalDeviceYcbcr2Plane444FormatsFeaturesEXT,
    PhysicalDeviceYcbcrDegammaFeaturesQCOM, PhysicalDeviceYcbcrImageArraysFeaturesEXT,
    PhysicalDeviceZeroInitializeWorkgroupMemoryFeatures,
};
