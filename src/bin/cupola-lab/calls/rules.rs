//! Choice of the commands that are called, with the reasons for those that are not.

/// Extensions whose commands are called in addition to those of all versions: those of Mesa's
/// software renderers.
pub const EXTENSIONS: &str = "AMD_draw_buffers_blend ARB_ES3_1_compatibility ARB_base_instance ARB_buffer_storage \
    ARB_clear_buffer_object ARB_clear_texture ARB_copy_buffer ARB_copy_image ARB_debug_output ARB_direct_state_access \
    ARB_draw_buffers ARB_draw_elements_base_vertex ARB_draw_instanced ARB_fragment_program ARB_framebuffer_object \
    ARB_gpu_shader_fp64 ARB_instanced_arrays ARB_invalidate_subdata ARB_map_buffer_range ARB_multi_bind \
    ARB_multitexture ARB_occlusion_query ARB_program_interface_query ARB_provoking_vertex ARB_robustness \
    ARB_sample_shading ARB_sampler_objects ARB_separate_shader_objects ARB_shader_image_load_store ARB_shader_objects \
    ARB_shader_subroutine ARB_sync ARB_tessellation_shader ARB_texture_buffer_object ARB_texture_buffer_range \
    ARB_texture_multisample ARB_texture_storage ARB_texture_view ARB_transform_feedback2 ARB_transform_feedback3 \
    ARB_transpose_matrix ARB_uniform_buffer_object ARB_vertex_array_object ARB_vertex_attrib_64bit \
    ARB_vertex_attrib_binding ARB_vertex_buffer_object ARB_vertex_program ARB_vertex_shader ARB_viewport_array \
    ARB_window_pos ATI_draw_buffers ATI_separate_stencil EXT_blend_color EXT_blend_equation_separate \
    EXT_blend_func_separate EXT_blend_minmax EXT_copy_texture EXT_direct_state_access EXT_discard_framebuffer \
    EXT_draw_buffers2 EXT_draw_buffers_indexed EXT_draw_instanced EXT_draw_range_elements EXT_fog_coord \
    EXT_framebuffer_blit EXT_framebuffer_multisample EXT_framebuffer_object EXT_gpu_program_parameters \
    EXT_gpu_shader4 EXT_occlusion_query_boolean EXT_point_parameters EXT_polygon_offset_clamp \
    EXT_primitive_bounding_box EXT_secondary_color EXT_separate_shader_objects EXT_stencil_two_side EXT_subtexture \
    EXT_texture3D EXT_texture_border_clamp EXT_texture_integer EXT_texture_object EXT_transform_feedback \
    EXT_vertex_array EXT_vertex_attrib_64bit KHR_debug MESA_window_pos NV_conditional_render NV_copy_image \
    NV_draw_buffers NV_primitive_restart NV_read_buffer OES_draw_buffers_indexed OES_framebuffer_object OES_mapbuffer \
    OES_texture_3D OES_texture_border_clamp OES_vertex_array_object OES_viewport_array";

/// True if a name has this prefix; `$` is the end of the name.
pub fn begins(name: &str, beginning: &str) -> bool {
    beginning.strip_suffix('$').map_or_else(|| name.starts_with(beginning), |whole| name == whole)
}

/// Prefixes of the names of commands that are not called, with the reason.
pub const LEFT_OUT: [(&str, &str); 40] = [
    ("glGetn", "takes sizes of areas that are not those of the areas here"),
    ("glReadnPixels", "the same"),
    ("glMultiModeDraw", "takes lists of modes by a stride"),
    ("glEGLImage", "takes images of EGL"),
    ("glFramebufferTexture3DOES", "limit: for the window it is not refused"),
    ("glFramebufferParameteri", "Mesa 22.3 waits for itself at the next flush if a primitive was just drawn"),
    ("glNamedFramebufferParameteri", "the same"),
    ("glEvalCoord", "Mesa 22.3 leaves the values of evaluators in current attributes"),
    ("glEvalPoint", "the same"),
    ("glProgramBinary", "binaries of programs are a known limit"),
    ("glGetProgramBinary", "the same"),
    ("glGetCompressedTexture", "Mesa 22.3 crashes for textures that are not compressed"),
    ("glGetCompressedMultiTex", "the same"),
    ("glMultiTexSubImage", "Mesa 22.3 crashes for textures without images"),
    ("glInvalidateTexSubImage", "the same"),
    ("glMultiDrawElements", "takes a list of addresses"),
    ("glGetTexLevelParameter", "Mesa 22.3 writes what lay in its memory where it refuses the question"),
    ("glGetTextureLevelParameter", "the same"),
    ("glGetMultiTexLevelParameter", "the same"),
    ("glNamedFramebufferTextureEXT", "Mesa 22.3 has none; its error depends on when its address was asked for"),
    ("glNamedFramebufferTextureLayerEXT", "the same"),
    ("glMaterialf$", "Mesa 22.3 reads as many numbers as the property has"),
    ("glMateriali$", "the same"),
    ("glNamedProgramString", "Mesa 22.3 crashes where a list with one that it refused is replaced"),
    ("glShaderBinary", "takes the code of SPIR-V, which Mesa does not check"),
    ("glSpecializeShader", "the same"),
    ("glGetAttached", "asked for by the questions, without the names"),
    ("glObjectLabel", "takes names of any kind, which the driver chooses"),
    ("glGetObjectLabel", "the same"),
    ("glLabelObject", "the same"),
    ("glGetPointerv", "asked for by the questions"),
    ("glGetDebugMessageLog", "messages of the driver's work, which is another"),
    ("glDebugMessage", "the same"),
    ("glWaitSync", "the driver may wait for good"),
    ("glGetGraphicsResetStatus", "says nothing about a call"),
    ("glFinish", "slow, and says nothing"),
    ("glGetSynciv", "depends on the time"),
    ("glClientWaitSync", "depends on the time"),
    ("glQueryCounter", "depends on the time"),
    ("glAreTexturesResident", "depends on the driver's memory"),
];

/// Weights of commands by prefixes of their names. The first match counts; without a match the
/// weight is 4.
pub const WEIGHTS: [(&str, u32); 52] = [
    ("glBindFramebuffer", 40),
    ("glUseProgram", 20),
    ("glBindBuffer", 16),
    ("glBindTexture", 16),
    ("glBindVertexArray", 16),
    ("glBind", 8),
    ("glEnablei", 4),
    ("glDisablei", 4),
    ("glEnable", 20),
    ("glDisable", 30),
    ("glViewport", 12),
    ("glScissor", 12),
    ("glDrawBuffer", 12),
    ("glReadBuffer", 12),
    ("glClear", 8),
    ("glDepthRange", 10),
    ("glColorMask", 8),
    ("glDepthMask", 8),
    ("glStencil", 8),
    ("glMatrix", 6),
    ("glPushAttrib", 12),
    ("glPopAttrib", 12),
    ("glActiveTexture", 10),
    ("glGet", 3),
    ("glIs", 2),
    ("glBegin", 0),
    ("glEnd", 1),
    ("glNewList", 0),
    ("glCallList", 6),
    ("glDeleteProgram", 2),
    ("glDelete", 3),
    ("glGen", 4),
    ("glCreate", 4),
    ("glUniform", 2),
    ("glProgramUniform", 1),
    ("glVertexAttrib", 1),
    ("glVertexStream", 0),
    ("glVertex", 1),
    ("glMultiTexCoord", 1),
    ("glTexCoord", 1),
    ("glSecondaryColor", 1),
    ("glColor", 1),
    ("glNormal", 1),
    ("glRasterPos", 1),
    ("glWindowPos", 1),
    ("glRect", 1),
    ("glMultiDraw", 2),
    ("glDraw", 3),
    ("glProgramEnvParameter", 1),
    ("glProgramLocalParameter", 1),
    ("glMap", 2),
    ("glMaterial", 2),
];

/// Values that are never used, by the names of command (its prefix) and value, with the reason.
pub const VALUES_LEFT_OUT: [(&str, &str, &str); 12] = [
    ("glNewList", "GL_COMPILE_AND_EXECUTE", "limit: the list is executed when it is complete"),
    ("glEnable", "GL_DEBUG_OUTPUT_SYNCHRONOUS", "messages are not compared"),
    ("glDrawBuffer", "GL_FRONT", "limit: front and back buffer are one"),
    ("glDrawBuffer", "GL_LEFT", "limit: one buffer, so that blending with two sources is no error"),
    ("glDrawBuffer", "GL_FRONT_AND_BACK", "the same"),
    ("glFramebufferDrawBuffer", "GL_LEFT", "the same"),
    ("glFramebufferDrawBuffer", "GL_FRONT_AND_BACK", "the same"),
    ("glNamedFramebufferDrawBuffer", "GL_LEFT", "the same"),
    ("glNamedFramebufferDrawBuffer", "GL_FRONT_AND_BACK", "the same"),
    ("glReadBuffer", "GL_FRONT", "limit: front and back buffer are one"),
    ("glGet", "GL_TIMESTAMP", "the time"),
    ("glBeginQuery", "GL_TIME_ELAPSED", "the time"),
];

/// True if Mesa 22.3 crashes in this call, or gives a wrong or undefined answer, without Cupola. `draws`:
/// Mesa draws; without drawing it keeps no memory for textures without width, maps no arrays, and
/// computes no raster positions by shaders.
pub fn crashes_mesa(line: &str, draws: bool) -> bool {
    let mut words = line.split(' ').skip(1);
    let (name, arguments) = (words.next().unwrap_or(""), words.collect::<Vec<_>>());
    match name {
        "glBindImageTextures" | "glGetInternalformati64v" => arguments.contains(&"-1"),
        // The matrix of textures, of a unit without coordinates.
        _ if name.starts_with("glMatrix") && name.ends_with("EXT") => arguments.first() == Some(&"0x1702"),
        // A list with a text of this length frees memory of others when it is replaced.
        "glProgramStringARB" | "glNamedProgramStringEXT" => arguments.iter().rev().nth(1) == Some(&"-1"),
        // The window has no front buffer until a command on what is bound names it, and no type to
        // read with after its read buffer was set by name while it was not bound.
        "glNamedFramebufferReadBuffer" | "glFramebufferReadBufferEXT" => {
            arguments.first() == Some(&"0") && arguments.get(1).is_some_and(|name| name.starts_with("0x40"))
        }
        "glNamedFramebufferDrawBuffers" | "glFramebufferDrawBuffersEXT" => {
            arguments.first() == Some(&"0") && arguments.get(2).is_some_and(|names| names.contains("1024"))
        }
        // A unit without coordinates is the place of other arrays, or foreign memory.
        "glMultiTexCoordPointerEXT" => !has_coordinates(arguments.first()),
        "glVertexArrayMultiTexCoordOffsetEXT" => !has_coordinates(arguments.get(2)),
        // An index or a number of parameters below 0 writes to foreign memory.
        _ if name.contains("NamedProgramLocalParameter") => arguments.iter().skip(2).take(2).any(|word| *word == "-1"),
        _ => !draws && ["glArrayElement", "glBitmap", "glRasterPos"].iter().any(|start| name.starts_with(start)),
    }
}

/// True if this is the name of a texture unit with coordinates.
fn has_coordinates(unit: Option<&&str>) -> bool {
    let number = unit.and_then(|unit| u32::from_str_radix(unit.trim_start_matches("0x"), 16).ok());
    number.is_some_and(|number| (0x84c0..0x84c8).contains(&number))
}

#[cfg(test)]
mod tests {
    use super::crashes_mesa;

    #[test]
    fn crashes_of_mesa_are_left_out() {
        assert!(crashes_mesa("v glBindImageTextures 80 -1 [nt0,t3", true));
        assert!(!crashes_mesa("v glBindImageTextures 80 1 [nt0", true));
        assert!(crashes_mesa("v glNamedProgramLocalParameter4dvEXT %p2 0x9083 -1 [d0.25", true));
        assert!(crashes_mesa("v glNamedProgramLocalParameters4fvEXT %p1 0x958c 2 -1 ~0", true));
        assert!(crashes_mesa("v glBitmap 0 64 f1 f64 f0.5 f-0.5 @u0", false));
        assert!(crashes_mesa("v glProgramStringARB 0x86cd 0x86d2 -1 ~16", true));
        assert!(!crashes_mesa("v glProgramStringARB 0x86cd 0x86d2 16 ~16", true));
        assert!(crashes_mesa("v glNamedFramebufferReadBuffer 0 0x405", true));
        assert!(!crashes_mesa("v glNamedFramebufferReadBuffer %f0 0x405", true));
        assert!(crashes_mesa("v- glFramebufferDrawBuffersEXT 0 2 [i1026,1024", true));
        assert!(!crashes_mesa("v glFramebufferDrawBuffersEXT 0 1 [i1026", true));
        assert!(crashes_mesa("v glMatrixLoadIdentityEXT 0x1702", true));
        assert!(crashes_mesa("v glMultiTexCoordPointerEXT 0x857d 2 0x140a 32 @a0", false));
        assert!(!crashes_mesa("v glMultiTexCoordPointerEXT 0x84c7 2 0x140a 32 @a0", false));
        assert!(crashes_mesa("v glVertexArrayMultiTexCoordOffsetEXT %v3 %b1 0x867c 1 0x1406 16 8", true));
        assert!(!crashes_mesa("v glVertexArrayMultiTexCoordOffsetEXT %v3 %b1 0x84c0 1 0x1406 16 8", true));
        assert!(!crashes_mesa("v glBitmap 0 64 f1 f64 f0.5 f-0.5 @u0", true));
        assert!(!crashes_mesa("v glArrayElement 7", true) && !crashes_mesa("ask", false));
    }
}
