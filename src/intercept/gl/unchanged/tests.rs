//! What calls may change, by their names, and what is made of their arguments.

use super::call::Digest;
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

#[test]
fn sums_tell_order_length_and_every_bit() {
    let sum = |words: &[u64]| {
        let mut digest = Digest::default();
        words.iter().for_each(|word| digest.add(*word));
        digest
    };
    assert_eq!(sum(&[1, 2, 3]), sum(&[1, 2, 3]));
    let mut seen = vec![sum(&[]), sum(&[0]), sum(&[0, 0]), sum(&[1, 2]), sum(&[2, 1])];
    for bit in 0..64 {
        seen.push(sum(&[5, 1 << bit, 7]));
        seen.push(sum(&[1 << bit]));
    }
    // Words that undo what the first multiplication has, so that a product is nothing.
    seen.push(sum(&[Digest::default().0[0], 1]));
    seen.push(sum(&[Digest::default().0[0], 2]));
    for (i, one) in seen.iter().enumerate() {
        assert!(seen[..i].iter().all(|other| one != other), "{i}");
    }
    let memory = |bytes: &[u8]| {
        let mut digest = Digest::default();
        // SAFETY: as many bytes as there are.
        unsafe { digest.add_memory(bytes.as_ptr() as u64, bytes.len() as u64) };
        digest
    };
    assert_ne!(memory(&[1, 2, 3]), memory(&[1, 2, 3, 0]));
    assert_ne!(memory(&[0; 8]), memory(&[0; 9]));
    assert_eq!(memory(&[9; 20]), memory(&[9; 20]));
}
