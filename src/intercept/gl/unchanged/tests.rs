//! What calls may change, by their names, and what is made of their arguments.

use super::calls::{Kind, kind};

/// The kind of a call with `arguments` arguments, the last of which points at something if `points`.
fn of(name: &str, arguments: usize, points: bool) -> Kind {
    let mut pointers = vec![false; arguments];
    if let Some(last) = pointers.last_mut() {
        *last = points;
    }
    kind(name, &pointers)
}

#[test]
fn calls_are_told_apart_by_their_names() {
    for (name, arguments) in [("glEnable", 1), ("glUniform3f", 4), ("glColor4ub", 4), ("glVertexAttrib4Nub", 5)] {
        assert_eq!(of(name, arguments, false), Kind::State, "{name}");
    }
    for name in ["glTexImage2D", "glGenTextures", "glCopyTexImage2D", "glAccum", "glLinkProgram", "glDispatchCompute"] {
        assert_eq!(of(name, 3, false), Kind::Change, "{name}");
    }
    // Calls that begin as others do.
    for name in ["glColorFragmentOp1ATI", "glVertexAttribs3fvNV", "glColorTable", "glFlushMappedBufferRange"] {
        assert_eq!(of(name, 3, true), Kind::Change, "{name}");
    }
    for name in ["glNormal3fVertex3fvSUN", "glGenerateMipmap", "glClearTexImage", "glClearBufferData", "glBindTextures"]
    {
        assert_eq!(of(name, 3, true), Kind::Change, "{name}");
    }
    for name in ["glGetIntegerv", "glIsEnabled", "glFenceSync", "glBeginQuery", "glFlush", "glPushDebugGroup"] {
        assert_eq!(of(name, 2, true), Kind::Nothing, "{name}");
    }
    // These may answer into a buffer.
    for name in ["glReadPixels", "glGetTexImage", "glGetQueryBufferObjectiv", "glGetCompressedTexImage"] {
        assert_eq!(of(name, 3, true), Kind::Change, "{name}");
    }
    for name in ["glBindImageTexture", "glEGLImageTargetTexture2DOES", "glMakeImageHandleResidentARB"] {
        assert_eq!(of(name, 2, false), Kind::Never, "{name}");
    }
    assert_eq!(of("glVertexAttribIPointerEXT", 5, true), Kind::Pointer(4));
    assert_eq!(of("glInterleavedArrays", 3, true), Kind::Pointer(2));
    assert_eq!(of("glGetVertexAttribPointerv", 3, true), Kind::Nothing);
    assert_eq!(of("glDrawElements", 4, true), Kind::Elements(3));
    assert_eq!(of("glDrawElementsIndirect", 3, true), Kind::Indirect);
    assert_eq!(of("glDrawArraysInstancedARB", 4, false), Kind::Arrays);
    assert_eq!(
        (of("glDrawBuffers", 2, true), of("glDrawBuffer", 1, false)),
        (Kind::Buffers(true), Kind::Buffers(false))
    );
    assert_eq!(of("glBindBufferRange", 5, false), Kind::BindBuffer);
    assert_eq!(of("glBindBuffersRange", 6, true), Kind::Never, "it may bind what the device writes");
}

#[test]
fn numbers_that_are_pointed_at_are_counted() {
    let numbers = |name: &str, arguments: usize| match of(name, arguments, true) {
        Kind::Numbers { count, components, .. } => Some((count, components)),
        _ => None,
    };
    for (name, arguments, expected) in [
        ("glUniform4fv", 3, (Some(1), 4)),
        ("glUniform2ui64vARB", 3, (Some(1), 2)),
        ("glUniformMatrix3fv", 4, (Some(1), 9)),
        ("glUniformMatrix2x3dv", 4, (Some(1), 6)),
        ("glProgramUniformMatrix4fv", 5, (Some(2), 16)),
        ("glProgramUniform1iv", 4, (Some(2), 1)),
        ("glColor4ubv", 1, (None, 4)),
        ("glVertexAttribI4usv", 2, (None, 4)),
        ("glVertexAttribP3uiv", 4, (None, 1)),
        ("glMultiTexCoord2sv", 2, (None, 2)),
        ("glEdgeFlagv", 1, (None, 1)),
        ("glProgramEnvParameter4fvARB", 3, (None, 4)),
    ] {
        assert_eq!(numbers(name, arguments), Some(expected), "{name}");
    }
    for name in ["glLightfv", "glTexParameterIiv", "glFogfv", "glSamplerParameterfv", "glTexGendv"] {
        assert_eq!(of(name, 3, true), Kind::Parameter { pointer: 2 }, "{name}");
    }
    assert_eq!(of("glLightModelfv", 2, true), Kind::Parameter { pointer: 1 });
}
