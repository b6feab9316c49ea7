//! What a call of OpenGL may change, told by its name.
//!
//! The build script reads this file, too: it generates a function for each call that has no hook (`build/gl_taps.rs`).
//! What is not named here may change anything, so that a call that was forgotten costs a saving, never a picture.

/// What a call may change of the pictures that follow. Numbers are places of arguments, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing: questions, labels, fences.
    Nothing,
    /// It sets state to what its arguments say, whatever that was before.
    State,
    /// The same, to numbers in memory.
    Numbers {
        /// The argument that points at them.
        pointer: u8,
        /// The argument that says how many times `components` they are; none: once.
        count: Option<u8>,
        /// How many.
        components: u8,
    },
    /// The same, to as many numbers as the parameter has that the argument before the pointer names.
    Parameter {
        /// The argument that points at them.
        pointer: u8,
    },
    /// The same, of a part of a buffer: to bytes in memory.
    Bytes {
        /// The argument that says how many.
        size: u8,
        /// The argument that points at them.
        pointer: u8,
    },
    /// A matrix, whose value may follow from the last one.
    Matrix,
    /// The same, by sixteen numbers that the first argument points at.
    MatrixNumbers,
    /// Where an array is: in a buffer, or where the argument points.
    Pointer(u8),
    /// It draws, but not from arrays.
    Draw,
    /// It draws from arrays.
    Arrays,
    /// It draws from arrays with indices: from a buffer, or from where the argument points.
    Elements(u8),
    /// It draws from arrays several times, as two lists in memory say; the last argument tells how often.
    Draws {
        /// With indices: the lists are the second and the fourth argument, not the second and the third.
        elements: bool,
    },
    /// It draws from arrays as a buffer says, if one is bound.
    Indirect,
    /// It runs the lists whose names the last argument points at.
    Lists,
    /// It selects which buffers are drawn to: the one that the first argument names, or (`true`) as many as that says of those that
    /// the second points at.
    Buffers(bool),
    /// It copies between framebuffers.
    Blit,
    /// It draws an image from memory, which a display list keeps.
    Pixels,
    /// It binds a buffer to the target that its first argument names.
    BindBuffer,
    /// It maps a buffer, in the way that the argument says.
    Map(u8),
    /// It may change anything, now.
    Change,
    /// From now on anything may change without a call.
    Never,
}

impl Kind {
    /// Whether such a call draws.
    #[allow(dead_code)] // The build script does not ask.
    pub const fn draws(self) -> bool {
        self.draws_arrays() || matches!(self, Self::Draw | Self::Lists | Self::Blit)
    }

    /// Whether it draws from arrays.
    #[allow(dead_code)] // The build script does not ask.
    pub const fn draws_arrays(self) -> bool {
        matches!(self, Self::Arrays | Self::Elements(_) | Self::Draws { .. } | Self::Indirect)
    }
}

/// Calls that only answer, name, count or wait.
const NOTHING: [&str; 14] = [
    "AreTexturesResident",
    "CheckFramebufferStatus",
    "CheckNamedFramebufferStatus",
    "ClientWaitSync",
    "DeleteSync",
    "FenceSync",
    "Finish",
    "Flush",
    "FrameTerminator",
    "PopDebugGroup",
    "PushDebugGroup",
    "QueryCounter",
    "StringMarker",
    "WaitSync",
];

/// The same, with more in their names. Other questions may answer into a buffer.
const NOTHING_BEGINNINGS: [&str; 39] = [
    "BeginQuery",
    "Debug",
    "EndQuery",
    "GetActive",
    "GetAttached",
    "GetAttrib",
    "GetBoolean",
    "GetBufferParameter",
    "GetClipPlane",
    "GetDebug",
    "GetDouble",
    "GetError",
    "GetFloat",
    "GetFragData",
    "GetFramebuffer",
    "GetGraphicsReset",
    "GetHandle",
    "GetInfoLog",
    "GetInteger",
    "GetInternalformat",
    "GetLight",
    "GetMaterial",
    "GetMultisample",
    "GetObject",
    "GetPointer",
    "GetProgram",
    "GetQueryObject",
    "GetQueryiv",
    "GetRenderbuffer",
    "GetSampler",
    "GetShader",
    "GetString",
    "GetSync",
    "GetTexLevelParameter",
    "GetTexParameter",
    "GetUniform",
    "GetVertexAttrib",
    "Is",
    "ObjectLabel",
];

/// Calls that set state by numbers among their arguments.
const STATE: [&str; 60] = [
    "ActiveShaderProgram",
    "ActiveTexture",
    "AlphaFunc",
    "BindFramebuffer",
    "BindProgram",
    "BindProgramPipeline",
    "BindRenderbuffer",
    "BindSampler",
    "BindTexture",
    "BindTextureUnit",
    "BindVertexArray",
    "BindVertexBuffer",
    "BlendColor",
    "ClampColor",
    "Clear",
    "ClearBufferfi",
    "ClearColor",
    "ClearDepth",
    "ClearDepthd",
    "ClearDepthf",
    "ClearIndex",
    "ClearStencil",
    "ClientActiveTexture",
    "ClipControl",
    "ColorMaterial",
    "CullFace",
    "DepthBounds",
    "DepthFunc",
    "DepthMask",
    "DepthRange",
    "DepthRangef",
    "End",
    "EndList",
    "EvalPoint1",
    "EvalPoint2",
    "FrontFace",
    "Hint",
    "IndexMask",
    "LineStipple",
    "LineWidth",
    "ListBase",
    "LogicOp",
    "MinSampleShading",
    "PatchParameteri",
    "PixelZoom",
    "PointSize",
    "PolygonMode",
    "ProvokingVertex",
    "ReadBuffer",
    "SampleCoverage",
    "SampleMaski",
    "Scissor",
    "ShadeModel",
    "UniformBlockBinding",
    "UseProgram",
    "UseProgramStages",
    "VertexAttribBinding",
    "VertexAttribDivisor",
    "VertexBindingDivisor",
    "Viewport",
];

/// The same, with more in their names.
const STATE_BEGINNINGS: [&str; 17] = [
    "BlendEquation",
    "BlendFunc",
    "ColorMask",
    "Disable",
    "Enable",
    "PixelStore",
    "PixelTransfer",
    "PolygonOffset",
    "PopAttrib",
    "PrimitiveRestart",
    "PushAttrib",
    "StencilFunc",
    "StencilMask",
    "StencilOp",
    "VertexAttribFormat",
    "VertexAttribIFormat",
    "VertexAttribLFormat",
];

/// Families of calls that set numbers (`glUniform3fv`), with the argument that says how many there are of the components.
const FAMILIES: [(&str, Option<u8>); 20] = [
    ("Color", None),
    ("EdgeFlag", None),
    ("EvalCoord", None),
    ("FogCoord", None),
    ("Index", None),
    ("MapGrid", None),
    ("MultiTexCoord", None),
    ("Normal", None),
    ("ProgramEnvParameter", None),
    ("ProgramLocalParameter", None),
    ("ProgramUniform", Some(2)),
    ("ProgramUniformMatrix", Some(2)),
    ("RasterPos", None),
    ("SecondaryColor", None),
    ("TexCoord", None),
    ("Uniform", Some(1)),
    ("UniformMatrix", Some(1)),
    ("Vertex", None),
    ("VertexAttrib", None),
    ("WindowPos", None),
];

/// Families whose last argument points at as many numbers as the parameter before it has.
const PARAMETERS: [&str; 10] = [
    "Fog",
    "Light",
    "LightModel",
    "Material",
    "PointParameter",
    "SamplerParameter",
    "TexEnv",
    "TexGen",
    "TexParameter",
    "TextureParameter",
];

/// Calls of a matrix.
const MATRIX: [&str; 20] = [
    "Frustum",
    "LoadIdentity",
    "LoadMatrixd",
    "LoadMatrixf",
    "LoadTransposeMatrixd",
    "LoadTransposeMatrixf",
    "MatrixMode",
    "MultMatrixd",
    "MultMatrixf",
    "MultTransposeMatrixd",
    "MultTransposeMatrixf",
    "Ortho",
    "PopMatrix",
    "PushMatrix",
    "Rotated",
    "Rotatef",
    "Scaled",
    "Scalef",
    "Translated",
    "Translatef",
];

/// Memory that shaders, other programs or other interfaces write to without a call of OpenGL.
const NEVER_BEGINNINGS: [&str; 20] = [
    "AcquireKeyedMutex",
    "BindImageTexture",
    "BindVideo",
    "BufferAddressRange",
    "BufferStorageExternal",
    "BufferStorageMem",
    "EGLImageTarget",
    "ImportMemory",
    "ImportSemaphore",
    "ImportSync",
    "MakeBufferResident",
    "MakeImageHandleResident",
    "MakeNamedBufferResident",
    "NamedBufferStorageExternal",
    "NamedBufferStorageMem",
    "TexStorageMem",
    "TextureStorageMem",
    "VDPAU",
    "VideoCapture",
    "WaitSemaphore",
];

/// What the call `name` (`glEnable`) may change. `arguments`: for each whether it points at something.
pub const fn kind(name: &str, arguments: &[bool]) -> Kind {
    let Some((b"gl", name)) = name.as_bytes().split_first_chunk::<2>() else { return Kind::Change };
    let points = pointers(arguments);
    let last = arguments.len().saturating_sub(1) as u8;
    if any_begins(name, &NEVER_BEGINNINGS) {
        Kind::Never
    } else if any_is(name, &NOTHING) || any_begins(name, &NOTHING_BEGINNINGS) {
        Kind::Nothing
    } else if is(name, "BlitFramebuffer") {
        Kind::Blit
    } else if is(name, "Bitmap") || is(name, "DrawPixels") {
        Kind::Pixels
    } else if is(name, "MultiDrawArrays") || is(name, "MultiDrawElements") {
        Kind::Draws { elements: is(name, "MultiDrawElements") }
    } else if is(name, "DrawArraysIndirect")
        || is(name, "DrawElementsIndirect")
        || is(name, "MultiDrawArraysIndirect")
        || is(name, "MultiDrawElementsIndirect")
    {
        Kind::Indirect
    } else if is(name, "MapBufferRange") || is(name, "MapNamedBufferRange") {
        Kind::Map(3)
    } else if is(name, "BufferData") || is(name, "NamedBufferData") {
        Kind::Bytes { size: 1, pointer: 2 }
    } else if is(name, "BufferSubData") || is(name, "NamedBufferSubData") {
        Kind::Bytes { size: 2, pointer: 3 }
    } else if begins(name, "BindBuffer") {
        if points == 0 { Kind::BindBuffer } else { Kind::Never }
    } else if any_is(name, &MATRIX) {
        if points == 0 { Kind::Matrix } else { Kind::MatrixNumbers }
    } else if is(name, "CallLists") {
        Kind::Lists
    } else if is(name, "DrawBuffer") || is(name, "DrawBuffers") {
        Kind::Buffers(points == 1)
    } else if is(name, "ClipPlane") {
        Kind::Numbers { pointer: 1, count: None, components: 4 }
    } else if points == 1 && (begins(name, "DrawElements") || begins(name, "DrawRangeElements")) {
        Kind::Elements(first(arguments))
    } else if points == 0 && begins(name, "DrawArrays") {
        Kind::Arrays
    } else if points == 0 && (begins(name, "Rect") || is_other_draw(name)) {
        Kind::Draw
    } else if points == 1 && is_array(name) {
        Kind::Pointer(last)
    } else if points == 0 && (any_is(name, &STATE) || any_begins(name, &STATE_BEGINNINGS)) {
        Kind::State
    } else {
        of_numbers(name, points, last)
    }
}

const fn is_other_draw(name: &[u8]) -> bool {
    any_is(name, &["Begin", "CallList", "EvalMesh1", "EvalMesh2"])
}

/// `glVertexPointer`, `glVertexAttribIPointer` and their like.
const fn is_array(name: &[u8]) -> bool {
    let mut end = name.len();
    while end > 0 && name[end - 1].is_ascii_uppercase() {
        end -= 1;
    }
    let word = b"Pointer";
    let ends = end >= word.len() && begins(name.split_at(end - word.len()).1, "Pointer");
    is(name, "InterleavedArrays") || (ends && !begins(name, "Get"))
}

/// What a call of a family may change.
const fn of_numbers(name: &[u8], points: usize, last: u8) -> Kind {
    let mut i = 0;
    while i < PARAMETERS.len() {
        if begins(name, PARAMETERS[i])
            && let Some((1, vector)) = components(name, PARAMETERS[i].len())
        {
            return match (vector, points) {
                (true, 1) => Kind::Parameter { pointer: last },
                (false, 0) => Kind::State,
                _ => Kind::Change,
            };
        }
        i += 1;
    }
    let mut i = 0;
    while i < FAMILIES.len() {
        let (family, count) = FAMILIES[i];
        if begins(name, family)
            && let Some((components, vector)) = components(name, family.len())
        {
            return match (vector, points) {
                (true, 1) => Kind::Numbers { pointer: last, count, components },
                (false, 0) => Kind::State,
                _ => Kind::Change,
            };
        }
        i += 1;
    }
    Kind::Change
}

/// How a name goes on after its family, from `at`: `3f`, `4Nubv`, `P2ui`, `I4i`, `fv`, `2x3dv` (which is six), `3fv` of a matrix (which
/// is nine). The numbers of one element, and whether they are pointed at; none if it goes on in another way.
const fn components(name: &[u8], mut at: usize) -> Option<(u8, bool)> {
    let matrix = at >= 6 && begins(name.split_at(at - 6).1, "Matrix");
    let packed = at < name.len() && name[at] == b'P';
    if at < name.len() && matches!(name[at], b'P' | b'I' | b'L') {
        at += 1;
    }
    let mut components = 1;
    if at < name.len() && name[at].is_ascii_digit() {
        components = name[at] - b'0';
        at += 1;
        if at + 1 < name.len() && name[at] == b'x' && name[at + 1].is_ascii_digit() {
            components *= name[at + 1] - b'0';
            at += 2;
        } else if matrix {
            components *= components;
        }
    }
    if at < name.len() && name[at] == b'N' {
        at += 1;
    }
    at = after_type(name, at);
    let vector = at < name.len() && name[at] == b'v';
    at += vector as usize;
    if !is_vendor(name, at) {
        return None;
    }
    Some((if packed { 1 } else { components }, vector))
}

/// The place after the name of a number's type; only edge flags have none.
const fn after_type(name: &[u8], at: usize) -> usize {
    let types = ["ui64", "i64", "ub", "us", "ui", "b", "s", "i", "f", "d", "h"];
    let rest = name.split_at(at).1;
    let mut i = 0;
    while i < types.len() {
        if begins(rest, types[i]) {
            return at + types[i].len();
        }
        i += 1;
    }
    at
}

/// How many arguments point at something.
const fn pointers(arguments: &[bool]) -> usize {
    let (mut count, mut i) = (0, 0);
    while i < arguments.len() {
        count += arguments[i] as usize;
        i += 1;
    }
    count
}

/// The first of them.
const fn first(arguments: &[bool]) -> u8 {
    let mut i = 0;
    while i < arguments.len() && !arguments[i] {
        i += 1;
    }
    i as u8
}

const fn begins(name: &[u8], stem: &str) -> bool {
    let stem = stem.as_bytes();
    let mut i = 0;
    while i < stem.len() {
        if i >= name.len() || name[i] != stem[i] {
            return false;
        }
        i += 1;
    }
    true
}

/// Whether the name is this, perhaps with a vendor's letters.
const fn is(name: &[u8], stem: &str) -> bool {
    begins(name, stem) && is_vendor(name, stem.len())
}

/// Whether nothing but capital letters follows.
const fn is_vendor(name: &[u8], mut from: usize) -> bool {
    while from < name.len() {
        if !name[from].is_ascii_uppercase() {
            return false;
        }
        from += 1;
    }
    true
}

const fn any_begins(name: &[u8], stems: &[&str]) -> bool {
    let mut i = 0;
    while i < stems.len() {
        if begins(name, stems[i]) {
            return true;
        }
        i += 1;
    }
    false
}

const fn any_is(name: &[u8], stems: &[&str]) -> bool {
    let mut i = 0;
    while i < stems.len() {
        if is(name, stems[i]) {
            return true;
        }
        i += 1;
    }
    false
}
