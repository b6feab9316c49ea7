#include "call_private.h"

#include "../common/gl.h"

/* Whether arrays may be in the memory of the process. */
static bool may_be_outside;

/* Whether the vertices at this address are in memory that a draw may read. */
static bool is_readable(uint64_t address)
{
    return may_be_outside && address >= CALL_MEMORY && address < CALL_MEMORY + CALL_INPUT_SIZE / 2;
}

static bool is_safe_array(GLenum array, GLenum binding, GLenum address_name)
{
    GLint buffer = 0;
    void *address = NULL;
    if (!glIsEnabled(array))
        return true;
    glGetIntegerv(binding, &buffer);
    glGetPointerv(address_name, &address);
    return buffer != 0 || is_readable((uint64_t)(uintptr_t)address);
}

static bool fixed_arrays_are_safe(void)
{
    static const GLenum arrays[][3] = {
        {GL_VERTEX_ARRAY, GL_VERTEX_ARRAY_BUFFER_BINDING, GL_VERTEX_ARRAY_POINTER},
        {GL_NORMAL_ARRAY, GL_NORMAL_ARRAY_BUFFER_BINDING, GL_NORMAL_ARRAY_POINTER},
        {GL_COLOR_ARRAY, GL_COLOR_ARRAY_BUFFER_BINDING, GL_COLOR_ARRAY_POINTER},
        {GL_INDEX_ARRAY, GL_INDEX_ARRAY_BUFFER_BINDING, GL_INDEX_ARRAY_POINTER},
        {GL_EDGE_FLAG_ARRAY, GL_EDGE_FLAG_ARRAY_BUFFER_BINDING, GL_EDGE_FLAG_ARRAY_POINTER},
        {GL_FOG_COORD_ARRAY, GL_FOG_COORD_ARRAY_BUFFER_BINDING, GL_FOG_COORD_ARRAY_POINTER},
        {GL_SECONDARY_COLOR_ARRAY, GL_SECONDARY_COLOR_ARRAY_BUFFER_BINDING, GL_SECONDARY_COLOR_ARRAY_POINTER},
    };
    bool safe = true;
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        safe = safe && is_safe_array(arrays[i][0], arrays[i][1], arrays[i][2]);
    GLint unit = GL_TEXTURE0;
    glGetIntegerv(GL_CLIENT_ACTIVE_TEXTURE, &unit);
    for (GLenum i = 0; i < 8; i++) {
        glClientActiveTexture(GL_TEXTURE0 + i);
        safe = safe && is_safe_array(GL_TEXTURE_COORD_ARRAY, GL_TEXTURE_COORD_ARRAY_BUFFER_BINDING,
                                     GL_TEXTURE_COORD_ARRAY_POINTER);
    }
    glClientActiveTexture((GLenum)unit);
    return safe;
}

static bool generic_arrays_are_safe(void)
{
    GLint most = 0;
    glGetIntegerv(GL_MAX_VERTEX_ATTRIBS, &most);
    for (GLuint i = 0; i < (GLuint)most; i++) {
        GLint enabled = 0, buffer = 0, binding = (GLint)i;
        glGetVertexAttribiv(i, GL_VERTEX_ATTRIB_ARRAY_ENABLED, &enabled);
        glGetVertexAttribiv(i, GL_VERTEX_ATTRIB_ARRAY_BUFFER_BINDING, &buffer);
        if (!enabled || buffer != 0)
            continue;
        void *address = NULL;
        GLint64 offset = 0;
        glGetVertexAttribPointerv(i, GL_VERTEX_ATTRIB_ARRAY_POINTER, &address);
        glGetVertexAttribiv(i, GL_VERTEX_ATTRIB_BINDING, &binding);
        if (binding < 0 || binding >= most)
            return false;
        glGetInteger64i_v(GL_VERTEX_BINDING_OFFSET, (GLuint)binding, &offset);
        /* Some drivers and versions answer with an offset and no address: such an array is not safe. */
        if (!is_readable((uint64_t)(uintptr_t)address) || (offset >= 0 && offset < 1 << 24))
            return false;
    }
    return true;
}

/*
 * The calls before may have written any indices to a buffer. So if the indices are in a buffer, no
 * array may be in the memory of the process.
 */
bool call_is_safe(const call_function *function)
{
    GLint indices = 0;
    if (function->takes_indices)
        glGetIntegerv(GL_ELEMENT_ARRAY_BUFFER_BINDING, &indices);
    may_be_outside = indices == 0;
    return (!call_has_fixed_function || fixed_arrays_are_safe()) && generic_arrays_are_safe();
}

/*
 * Whether a read fits into the buffer that takes it. Mesa 22.3 checks only the part inside the
 * framebuffer, and then writes as far as the whole rectangle reaches.
 */
static bool read_is_safe(const uint64_t *arguments, uint64_t offset)
{
    enum { LARGEST_PIXEL = 16, SMALLEST_FRAMEBUFFER = 16 };
    int64_t x = (GLint)arguments[0], y = (GLint)arguments[1], width = (GLsizei)arguments[2], height = (GLsizei)arguments[3];
    bool is_inside = x >= 0 && y >= 0 && x + width <= SMALLEST_FRAMEBUFFER && y + height <= SMALLEST_FRAMEBUFFER;
    GLint buffer = 0, size = 0, length = 0, rows = 0, pixels = 0;
    glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &buffer);
    if (buffer == 0 || is_inside || width <= 0 || height <= 0)
        return true;
    glGetBufferParameteriv(GL_PIXEL_PACK_BUFFER, GL_BUFFER_SIZE, &size);
    glGetIntegerv(GL_PACK_ROW_LENGTH, &length);
    glGetIntegerv(GL_PACK_SKIP_ROWS, &rows);
    glGetIntegerv(GL_PACK_SKIP_PIXELS, &pixels);
    int64_t row = length > 0 ? length : width;
    int64_t end = (rows + height) * row + pixels + width;
    return offset < (uint64_t)size && end * LARGEST_PIXEL <= size - (int64_t)offset;
}

/* After a link without success Mesa 22.3 reads varyings in the freed result of the link before. */
static bool varyings_are_safe(GLuint program)
{
    GLint linked = GL_FALSE;
    if (!glIsProgram(program))
        return true;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    return linked;
}

bool call_arguments_are_safe(const call_function *function, const uint64_t *arguments, uint64_t seventh)
{
    if (function->is_read)
        return read_is_safe(arguments, seventh);
    GLenum name = (GLenum)arguments[1];
    bool of_varyings = name == GL_TRANSFORM_FEEDBACK_VARYINGS || name == GL_TRANSFORM_FEEDBACK_VARYING_MAX_LENGTH;
    if (function->asks_varying || (function->asks_program && of_varyings))
        return varyings_are_safe((GLuint)arguments[0]);
    return true;
}
