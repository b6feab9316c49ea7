/*
 * Direction test in a core 4.3 context. The cube is drawn with inverted colours to a texture.
 * Compute shaders make another texture from it, and a triangle shows that one. --mode:
 *   sampled    one dispatch that samples the texture
 *   stored     one dispatch that loads from it
 *   same       one dispatch that changes it
 *   indirect   an indirect dispatch
 *   half       two dispatches with an image of half the size
 *   depths     the dispatch reads the depth, too
 *   light      the dispatch uses a matrix of the camera
 *   declared   the dispatch declares a block of the camera's matrices and uses only its other
 *              member
 *   exposure   with a sum over the whole picture
 *   places     with values of each place in a buffer
 *   pipeline   by a separable program
 *   blit       the result is blitted to the window
 *   tiles      with lists whose lengths are atomic sums
 *   volume     with an image of three dimensions
 *   dots       after a dispatch that stores dots together with places in a buffer
 *   gathered   with sums in an image
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char vertex[] = "#version 430 core\n"
                             "layout(location = 0) in vec3 position;\n"
                             "layout(location = 1) in vec3 colour;\n"
                             "uniform mat4 MVP;\n"
                             "out vec3 shade;\n"
                             "void main() { shade = colour; gl_Position = MVP * vec4(position, 1.0); }\n";
static const char fragment[] = "#version 430 core\n"
                               "in vec3 shade;\n"
                               "out vec4 result;\n"
                               "void main() { result = vec4(1.0 - shade, 1.0); }\n";
static const char screen_vertex[] = "#version 430 core\n"
                                    "out vec2 place;\n"
                                    "void main() {\n"
                                    "    place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;\n"
                                    "    gl_Position = vec4(place * 2.0 - 1.0, 0.0, 1.0);\n"
                                    "}\n";
static const char screen_fragment[] = "#version 430 core\n"
                                      "in vec2 place;\n"
                                      "uniform sampler2D picture;\n"
                                      "out vec4 result;\n"
                                      "void main() { result = vec4(texture(picture, place).rgb, 1.0); }\n";

#define HEAD "#version 430 core\nlayout(local_size_x = 8, local_size_y = 8) in;\n" \
             "vec4 inverted(vec4 c) { return vec4(1.0 - c.rgb, 1.0); }\n"
#define PICTURE "layout(binding = 0) uniform sampler2D picture;\n"
#define RESULT "layout(rgba8, binding = 0) uniform writeonly image2D result;\n"
#define BEGIN \
    "void main() {\n" \
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(result);\n" \
    "    if (any(greaterThanEqual(at, size))) return;\n"
#define STORE(value) BEGIN "    imageStore(result, at, " value ");\n}\n"
#define NUMBERS "layout(std430, binding = 0) buffer Numbers { uint sum, expected; float factor; float values[]; };\n"
#define SOURCE "layout(rgba8, binding = 1) uniform image2D source;\n"

static const char sampled[] = HEAD PICTURE RESULT STORE("inverted(texelFetch(picture, at, 0))");
/* A block as in a header that all shaders of an engine share. */
static const char declared[] = HEAD PICTURE RESULT
    "layout(std140, binding = 0) uniform Camera { mat4 view, projection, inverse_all; vec4 screen; };\n"
    STORE("inverted(texelFetch(picture, min(at, ivec2(screen.xy) - 1), 0))");
static const char stored[] = HEAD "layout(rgba8, binding = 1) uniform readonly image2D source;\n" RESULT
    STORE("inverted(imageLoad(source, at))");
static const char same[] = HEAD SOURCE
    "void main() {\n"
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy);\n"
    "    if (all(lessThan(at, imageSize(source)))) imageStore(source, at, inverted(imageLoad(source, at)));\n"
    "}\n";
static const char halve[] = HEAD PICTURE RESULT STORE("textureLod(picture, (vec2(at) + 0.5) / vec2(size), 0.0)");
static const char join[] = HEAD PICTURE "layout(binding = 1) uniform sampler2D small;\n" RESULT
    STORE("inverted(0.5 * (texelFetch(picture, at, 0) + textureLod(small, (vec2(at) + 0.5) / vec2(size), 0.0)))");
static const char depths[] = HEAD PICTURE "layout(binding = 2) uniform sampler2D deep;\n" RESULT
    STORE("texelFetch(deep, at, 0).r < 1.0 ? inverted(texelFetch(picture, at, 0)) : vec4(0.0)");
/*
 * Colour of a place on the cube. A place that is computed with the matrix of another view is not on
 * the cube.
 */
static const char light[] = HEAD "layout(binding = 2) uniform sampler2D deep;\nuniform mat4 inverse_all;\n" RESULT
    "vec4 on_cube(vec4 p) {\n"
    "    p /= p.w;\n"
    "    float far = max(max(abs(p.x), abs(p.y)), abs(p.z));\n"
    "    return abs(far - 1.0) < 0.01 ? vec4(0.5 + 0.5 * p.xyz, 1.0) : vec4(0.0);\n"
    "}\n"
    STORE("on_cube(inverse_all * vec4(2.0 * vec3((vec2(at) + 0.5) / vec2(size), texelFetch(deep, at, 0).r) - 1.0, 1.0))");
static const char count[] = HEAD PICTURE NUMBERS
    "void main() {\n"
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy);\n"
    "    if (all(lessThan(at, textureSize(picture, 0))) && texelFetch(picture, at, 0).r > 0.5) atomicAdd(sum, 1u);\n"
    "}\n";
static const char judge[] = HEAD PICTURE NUMBERS
    "void main() {\n"
    "    if (gl_LocalInvocationIndex == 0u) {\n"
    "        ivec2 size = textureSize(picture, 0);\n"
    "        factor = abs(float(sum) - float(expected)) < 0.02 * float(size.x * size.y) ? 1.0 : 0.5;\n"
    "        sum = 0u;\n"
    "    }\n"
    "}\n";
static const char expose[] = HEAD PICTURE RESULT
    "layout(std430, binding = 0) readonly buffer Numbers { uint sum, expected; float factor; float values[]; };\n"
    STORE("vec4(factor * inverted(texelFetch(picture, at, 0)).rgb, 1.0)");
static const char places[] = HEAD PICTURE NUMBERS
    "void main() {\n"
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = textureSize(picture, 0);\n"
    "    if (all(lessThan(at, size))) values[at.y * size.x + at.x] = texelFetch(picture, at, 0).r;\n"
    "}\n";
static const char values[] = HEAD PICTURE RESULT
    "layout(std430, binding = 0) readonly buffer Numbers { uint sum, expected; float factor; float values[]; };\n"
    STORE("inverted(vec4(values[at.y * size.x + at.x])) + 0.0 * texelFetch(picture, at, 0)");

static const char tiles[] = HEAD PICTURE NUMBERS "shared uint nearest;\n"
    "void main() {\n"
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = textureSize(picture, 0);\n"
    "    atomicMin(nearest, 3u);\n"
    "    if (all(lessThan(at, size))) values[at.y * size.x + at.x] = texelFetch(picture, at, 0).r;\n"
    "}\n";
static const char volume[] = HEAD PICTURE RESULT "layout(rgba8, binding = 2) uniform writeonly image3D fog;\n"
    STORE("inverted(texelFetch(picture, at, 0)));\n    imageStore(fog, ivec3(at, 0), vec4(1.0)");
static const char dots[] = HEAD "layout(rgba8, binding = 1) uniform writeonly image2D source;\n" NUMBERS
    "void main() {\n"
    "    ivec2 at = ivec2(gl_GlobalInvocationID.xy);\n"
    "    values[at.x] = 1.0;\n"
    "    if (all(lessThan(at, ivec2(64)))) imageStore(source, at, vec4(1.0, 1.0, 1.0, 1.0));\n"
    "}\n";
static const char gathered[] = HEAD PICTURE RESULT "layout(r32ui, binding = 3) uniform uimage2D sums;\n"
    STORE("inverted(texelFetch(picture, at, 0)));\n    imageAtomicAdd(sums, ivec2(0), 1u");

enum { SCENE, FIRST, SMALL, TEXTURES, MOST = 3 };

static const struct {
    const char *name;
    const char *steps[MOST];
} modes[] = {{"sampled", {sampled}}, {"stored", {stored}},           {"same", {same}},     {"indirect", {sampled}},
             {"half", {halve, join}}, {"depths", {depths}},           {"light", {light}},   {"exposure", {count, judge, expose}},
             {"places", {places, values}}, {"blit", {sampled}},             {"pipeline", {sampled}},
             {"tiles", {tiles, values}}, {"volume", {volume}},        {"dots", {dots, stored}}, {"gathered", {gathered}},
             {"declared", {declared}}};

static mesh cube;
static int chosen;
static GLuint scene, screen, steps[MOST], framebuffers[2], textures[TEXTURES], depth, numbers, groups, pipeline, empty;
static GLuint fog, sums, camera;

static bool is(const char *name)
{
    return strcmp(modes[chosen].name, name) == 0;
}

static GLuint make_step(const char *text)
{
    const shader_source stage = {GL_COMPUTE_SHADER, text};
    if (!is("pipeline"))
        return program_build(&stage, 1);
    glGenProgramPipelines(1, &pipeline);
    const GLuint program = glCreateShaderProgramv(GL_COMPUTE_SHADER, 1, &text);
    glUseProgramStages(pipeline, GL_COMPUTE_SHADER_BIT, program);
    return program;
}

static void make_texture(int i, int width, int height)
{
    glBindTexture(GL_TEXTURE_2D, textures[i]);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, width, height);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

static void setup(app *a)
{
    const int width = a->window.width, height = a->window.height;
    for (int m = 0; a->mode != NULL && m < (int)(sizeof modes / sizeof *modes); m++)
        if (strcmp(a->mode, modes[m].name) == 0)
            chosen = m;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    const shader_source of_screen[] = {{GL_VERTEX_SHADER, screen_vertex}, {GL_FRAGMENT_SHADER, screen_fragment}};
    scene = program_build(stages, 2);
    screen = program_build(of_screen, 2);
    for (int s = 0; s < MOST && modes[chosen].steps[s] != NULL; s++)
        steps[s] = make_step(modes[chosen].steps[s]);
    cube = mesh_cube();
    glGenVertexArrays(1, &empty);
    glGenFramebuffers(2, framebuffers);
    glGenTextures(TEXTURES, textures);
    make_texture(SCENE, width, height);
    make_texture(FIRST, width, height);
    make_texture(SMALL, width / 2, height / 2);
    glGenTextures(1, &depth);
    glBindTexture(GL_TEXTURE_2D, depth);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_DEPTH_COMPONENT32F, width, height);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glGenTextures(1, &fog);
    glBindTexture(GL_TEXTURE_3D, fog);
    glTexStorage3D(GL_TEXTURE_3D, 1, GL_RGBA8, 8, 8, 2);
    glGenTextures(1, &sums);
    glBindTexture(GL_TEXTURE_2D, sums);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_R32UI, 1, 1);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[0]);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures[SCENE], 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[1]);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures[FIRST], 0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    const GLuint size[] = {((GLuint)width + 7) / 8, ((GLuint)height + 7) / 8, 1};
    glGenBuffers(1, &numbers);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, numbers);
    unsigned *first = calloc((size_t)(width * height + 3), 4);
    const matrix4 back = matrix_inverse(matrix_multiply(a->projection, a->modelview));
    first[1] = pixels_to_the_left(&back, (unsigned)width, (unsigned)height);
    glBufferData(GL_SHADER_STORAGE_BUFFER, 4 * (width * height + 3), first, GL_DYNAMIC_DRAW);
    free(first);
    const matrix4 matrices[] = {a->view, a->projection, back, {{(float)width, (float)height}}};
    glGenBuffers(1, &camera);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, camera);
    glBufferData(GL_UNIFORM_BUFFER, sizeof matrices, matrices, GL_STATIC_DRAW);
    glGenBuffers(1, &groups);
    glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, groups);
    glBufferData(GL_DISPATCH_INDIRECT_BUFFER, sizeof size, size, GL_STATIC_DRAW);
}

static void run_step(app *a, int s)
{
    const char *text = modes[chosen].steps[s];
    const int to = text == halve ? SMALL : FIRST;
    const int width = a->window.width / (to == SMALL ? 2 : 1), height = a->window.height / (to == SMALL ? 2 : 1);
    glUseProgram(is("pipeline") ? 0 : steps[s]);
    if (is("pipeline"))
        glBindProgramPipeline(pipeline);
    if (text == light) {
        const matrix4 back = matrix_inverse(matrix_multiply(a->projection, a->modelview));
        glUniformMatrix4fv(glGetUniformLocation(steps[s], "inverse_all"), 1, GL_FALSE, back.m);
    }
    const GLuint seen[] = {textures[SCENE], textures[SMALL], depth};
    for (int i = 0; i < 3; i++) {
        glActiveTexture(GL_TEXTURE0 + (GLenum)i);
        glBindTexture(GL_TEXTURE_2D, seen[i]);
    }
    glActiveTexture(GL_TEXTURE0);
    glBindImageTexture(0, textures[to], 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
    const GLenum access = text == same ? GL_READ_WRITE : text == dots ? GL_WRITE_ONLY : GL_READ_ONLY;
    glBindImageTexture(1, textures[SCENE], 0, GL_FALSE, 0, access, GL_RGBA8);
    glBindImageTexture(2, fog, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA8);
    glBindImageTexture(3, sums, 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
    if (is("indirect"))
        glDispatchComputeIndirect(0);
    else if (text == judge)
        glDispatchCompute(1, 1, 1);
    else
        glDispatchCompute(((GLuint)width + 7) / 8, ((GLuint)height + 7) / 8, 1);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

static void draw(app *a)
{
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[0]);
    app_clear();
    glUseProgram(scene);
    const matrix4 all = matrix_multiply(a->projection, a->modelview);
    glUniformMatrix4fv(glGetUniformLocation(scene, "MVP"), 1, GL_FALSE, all.m);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    for (int s = 0; s < MOST && steps[s] != 0; s++)
        run_step(a, s);
    if (is("blit")) {
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers[1]);
        const int width = a->window.width, height = a->window.height;
        glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        return;
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glDisable(GL_DEPTH_TEST);
    glUseProgram(screen);
    glBindVertexArray(empty);
    glBindTexture(GL_TEXTURE_2D, textures[is("same") ? SCENE : FIRST]);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

int main(int argc, char **argv)
{
    static const app_program self = {"computed", API_GL_CORE, 4, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
