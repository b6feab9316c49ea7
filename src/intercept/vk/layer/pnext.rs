//! Chains of structures of the program: what is in them, and copies of which something is changed.

use ash::vk;
use std::ffi::c_void;

/// A structure in a chain, by its kind.
///
/// # Safety
/// `chain` must be a chain of Vulkan structures, `T` the one of that kind.
pub unsafe fn in_chain<'a, T>(chain: *const c_void, kind: vk::StructureType) -> Option<&'a T> {
    let mut at = chain.cast::<vk::BaseInStructure<'_>>();
    while !at.is_null() {
        // SAFETY: each structure begins with its kind and the next one.
        unsafe {
            if (*at).s_type == kind {
                return Some(&*at.cast::<T>());
            }
            at = (*at).p_next;
        }
    }
    None
}

/// A chain like the program's: copies of the structures up to one of a certain kind, of which something may be changed. What
/// follows is the program's.
pub struct Copied(Vec<Box<[u64]>>);

impl Copied {
    /// `None` where there is no structure of the kind `last`, or one before it whose length, bytes, is not known.
    ///
    /// # Safety
    /// `chain` must be the program's.
    pub unsafe fn up_to(
        chain: *const c_void,
        last: vk::StructureType,
        length: fn(vk::StructureType) -> Option<usize>,
    ) -> Option<Self> {
        let mut copies: Vec<Box<[u64]>> = Vec::new();
        let mut at = chain.cast::<vk::BaseInStructure<'_>>();
        loop {
            // SAFETY: as promised; a structure of a known kind is as long as that, and begins with kind and next one.
            unsafe {
                let given = at.as_ref()?;
                let bytes = length(given.s_type)?;
                let mut copy = vec![0u64; bytes.div_ceil(8)].into_boxed_slice();
                std::ptr::copy_nonoverlapping(at.cast::<u8>(), copy.as_mut_ptr().cast(), bytes);
                if let Some(before) = copies.last_mut() {
                    (*before.as_mut_ptr().cast::<vk::BaseOutStructure<'_>>()).p_next = copy.as_mut_ptr().cast();
                }
                copies.push(copy);
                if given.s_type == last {
                    return Some(Self(copies));
                }
                at = given.p_next;
            }
        }
    }

    /// The first structure.
    pub fn first(&self) -> *const c_void {
        self.0.first().map_or(std::ptr::null(), |copy| copy.as_ptr().cast())
    }

    /// The last one that is a copy.
    ///
    /// # Safety
    /// `T` must be the structure of the kind up to which was copied.
    pub unsafe fn last<T>(&mut self) -> Option<&mut T> {
        let last = self.0.last_mut().filter(|copy| 8 * copy.len() >= size_of::<T>())?;
        // SAFETY: as promised; the copy is aligned as the pointers and numbers of such structures.
        Some(unsafe { &mut *last.as_mut_ptr().cast::<T>() })
    }
}

macro_rules! lengths {
    ($kind:ident; $($structure:ident,)*) => {
        $(
            if $kind == <vk::$structure<'_> as vk::TaggedStructure>::STRUCTURE_TYPE {
                return Some(size_of::<vk::$structure<'_>>());
            }
        )*
    };
}

/// How long a structure is that may come before the features with which a device is made: those that Vulkan's registry names
/// and the loader's own.
#[rustfmt::skip]
pub fn length_for_device(kind: vk::StructureType) -> Option<usize> {
    if kind == vk::StructureType::LOADER_DEVICE_CREATE_INFO {
        return Some(crate::intercept::vk::layer::negotiate::LAYER_INFO_LENGTH);
    }
    lengths! { kind;
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
    }
    None
}
