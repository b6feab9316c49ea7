//! Test: each command of Vulkan has a hook, or is listed here as a command that needs none.

use crate::intercept::vk::layer::table;
use std::collections::BTreeSet;
use std::ffi::CString;
use std::process::Command;

/// States of pipelines that apply to each view as they apply to the window.
const STATES: &str = "
    SetAlphaToCoverageEnableEXT SetAlphaToOneEnableEXT SetAttachmentFeedbackLoopEnableEXT SetBlendConstants
    SetCoarseSampleOrderNV SetColorBlendAdvancedEXT SetColorBlendEnableEXT SetColorBlendEquationEXT
    SetColorWriteEnableEXT SetColorWriteMaskEXT SetConservativeRasterizationModeEXT SetCoverageModulationModeNV
    SetCoverageModulationTableEnableNV SetCoverageModulationTableNV SetCoverageReductionModeNV
    SetCoverageToColorEnableNV SetCoverageToColorLocationNV SetCullMode SetCullModeEXT SetDepthBias SetDepthBias2EXT
    SetDepthBiasEnable SetDepthBiasEnableEXT SetDepthBounds SetDepthBoundsTestEnable SetDepthBoundsTestEnableEXT
    SetDepthClampEnableEXT SetDepthClipEnableEXT SetDepthClipNegativeOneToOneEXT SetDepthCompareOp
    SetDepthCompareOpEXT SetDepthTestEnable SetDepthTestEnableEXT SetDepthWriteEnable SetDepthWriteEnableEXT
    SetDescriptorBufferOffsets2EXT SetDescriptorBufferOffsetsEXT SetDiscardRectangleEnableEXT
    SetDiscardRectangleModeEXT SetExclusiveScissorEnableNV SetExtraPrimitiveOverestimationSizeEXT
    SetFragmentShadingRateEnumNV SetFragmentShadingRateKHR SetFrontFace SetFrontFaceEXT SetLineRasterizationModeEXT
    SetLineStippleEXT SetLineStippleEnableEXT SetLineStippleKHR SetLineWidth SetLogicOpEXT SetLogicOpEnableEXT
    SetPatchControlPointsEXT SetPolygonModeEXT SetPrimitiveRestartEnable SetPrimitiveRestartEnableEXT
    SetPrimitiveTopology SetPrimitiveTopologyEXT SetProvokingVertexModeEXT SetRasterizationSamplesEXT
    SetRasterizationStreamEXT SetRasterizerDiscardEnable SetRasterizerDiscardEnableEXT
    SetRayTracingPipelineStackSizeKHR SetRepresentativeFragmentTestEnableNV SetSampleLocationsEXT
    SetSampleLocationsEnableEXT SetSampleMaskEXT SetShadingRateImageEnableNV SetStencilCompareMask SetStencilOp
    SetStencilOpEXT SetStencilReference SetStencilTestEnable SetStencilTestEnableEXT SetStencilWriteMask
    SetTessellationDomainOriginEXT SetVertexInputEXT SetViewportShadingRatePaletteNV SetViewportWScalingEnableNV
";

/// Markers, events without barriers for images, and timestamps.
const MARKS: &str = "
    BeginDebugUtilsLabelEXT DebugMarkerBeginEXT DebugMarkerEndEXT DebugMarkerInsertEXT EndDebugUtilsLabelEXT
    InsertDebugUtilsLabelEXT ResetEvent ResetEvent2 ResetEvent2KHR ResetQueryPool SetCheckpointNV SetDeviceMask
    SetDeviceMaskKHR SetEvent SetPerformanceMarkerINTEL SetPerformanceOverrideINTEL SetPerformanceStreamMarkerINTEL
    WriteBufferMarker2AMD WriteBufferMarkerAMD WriteTimestamp WriteTimestamp2 WriteTimestamp2KHR
";

/// Inputs of draws that are the same for all views.
const INPUTS: &str = "
    BindDescriptorBufferEmbeddedSamplers2EXT BindDescriptorBufferEmbeddedSamplersEXT BindIndexBuffer
    BindIndexBuffer2KHR BindTransformFeedbackBuffersEXT
";

/// Work that draws nothing: compute, ray tracing, video, and work on memory and its own structures.
/// Images that it writes are descriptors of its shaders, which Cupola follows.
const WORK: &str = "
    BeginVideoCodingKHR BuildAccelerationStructureNV BuildAccelerationStructuresIndirectKHR
    BuildAccelerationStructuresKHR BuildMicromapsEXT ControlVideoCodingKHR CopyAccelerationStructureKHR
    CopyAccelerationStructureNV CopyAccelerationStructureToMemoryKHR CopyMemoryIndirectNV
    CopyMemoryToAccelerationStructureKHR CopyMemoryToMicromapEXT CopyMicromapEXT CopyMicromapToMemoryEXT
    CuLaunchKernelNVX CudaLaunchKernelNV DecodeVideoKHR DecompressMemoryIndirectCountNV DecompressMemoryNV
    DispatchGraphAMDX DispatchGraphIndirectAMDX DispatchGraphIndirectCountAMDX
    EncodeVideoKHR EndTransformFeedbackEXT EndVideoCodingKHR FillBuffer
    InitializeGraphScratchMemoryAMDX OpticalFlowExecuteNV PreprocessGeneratedCommandsNV TraceRaysIndirect2KHR
    TraceRaysIndirectKHR TraceRaysKHR TraceRaysNV UpdatePipelineIndirectBufferNV
    WriteAccelerationStructuresPropertiesKHR WriteAccelerationStructuresPropertiesNV WriteMicromapsPropertiesEXT
";

/// Returns the commands of the Vulkan crate, without the prefix of their names.
fn known() -> BTreeSet<String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(cargo)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["metadata", "--offline", "--locked", "--format-version", "1"])
        // Crates for other platforms may be missing.
        .args(["--filter-platform", &format!("{}-unknown-linux-gnu", std::env::consts::ARCH)])
        .output()
        .expect("cargo tells where crates are");
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("cargo's answer");
    let packages = metadata["packages"].as_array().expect("packages").iter();
    let ash = packages.filter(|package| package["name"] == "ash").find_map(|ash| ash["manifest_path"].as_str());
    let sources = std::path::Path::new(ash.expect("the crate is used")).with_file_name("src");
    let mut found = BTreeSet::new();
    for file in ["tables.rs", "extensions_generated.rs"] {
        let text = std::fs::read_to_string(sources.join(file)).expect("the crate's sources");
        let names = text.split("\"vkCmd").skip(1).filter_map(|rest| rest.split(['"', '\\']).next());
        found.extend(names.map(str::to_owned));
    }
    found
}

#[test]
fn every_command_has_a_hook_or_needs_none() {
    let known = known();
    assert!(known.len() > 200 && known.contains("DrawIndexed"), "{} commands", known.len());
    let listed: Vec<&str> = [STATES, MARKS, INPUTS, WORK].into_iter().flat_map(str::split_whitespace).collect();
    let harmless: BTreeSet<&str> = listed.iter().copied().collect();
    assert_eq!(harmless.len(), listed.len(), "a command is named twice");
    let hooked = |name: &str| {
        let name = CString::new(format!("vkCmd{name}")).expect("a name");
        table::find(&name).is_some()
    };
    let missed: Vec<_> = known.iter().filter(|name| !hooked(name) && !harmless.contains(name.as_str())).collect();
    assert!(missed.is_empty(), "neither hooked nor harmless: {missed:?}");
    let both: Vec<_> = harmless.iter().filter(|name| hooked(name)).collect();
    assert!(both.is_empty(), "hooked, and said to need no hook: {both:?}");
    let gone: Vec<_> = harmless.iter().filter(|name| !known.contains(**name)).collect();
    assert!(gone.is_empty(), "commands that are not there: {gone:?}");
}
