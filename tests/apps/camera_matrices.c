/*
 * Fragments and vertices that compute places of the scene from places on the screen, or the
 * reverse, with matrices of the camera. There is one form for each --mode. In each form the window
 * shows the colours of the cube around the eye.
 *
 *   sky_…     a triangle over the window; its colour in a direction is computed from the pixel
 *   light_…   the cube's depth is drawn or copied to a texture; a triangle computes the place from
 *             it, and from the place the colour
 *   place_…   the cube; fragments that are not at the pixel that they compute are discarded
 */
#include "common/app.h"
#include "common/forms.h"
#include "common/mesh.h"
#include "common/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEAD "#version 410 core\n"
/* The cube is at a distance of 10. */
#define COLOUR \
    "vec3 colour(vec3 d) { d /= max(max(abs(d.x), abs(d.y)), abs(d.z)); return d * 0.5 + 0.5; }\n"
#define TRIANGLE \
    HEAD "out vec2 at;\nvoid main() {\n" \
         "    at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;\n" \
         "    gl_Position = vec4(at, 0.5, 1.0);\n" \
         "}\n"
#define CUBE \
    HEAD "layout(location = 0) in vec3 position;\nlayout(location = 1) in vec3 colour;\n" \
         "uniform mat4 P, MV;\nout vec3 shade, place;\n" \
         "void main() { shade = colour; place = position; gl_Position = P * MV * vec4(position, 1.0); }\n"
#define SKY(uniforms, direction) \
    HEAD "in vec2 at;\nout vec4 result;\n" uniforms COLOUR \
         "void main() { result = vec4(colour(" direction "), 1.0); }\n"
#define LIGHT(uniforms, place) \
    HEAD "in vec2 at;\nout vec4 result;\nuniform sampler2D depths, colours;\nuniform vec2 size;\n" uniforms COLOUR \
         "void main() {\n" \
         "    float depth = texelFetch(depths, ivec2(gl_FragCoord.xy), 0).r;\n" \
         "    vec4 ndc = vec4(at, depth * 2.0 - 1.0, 1.0), p;\n" place "\n}\n"
/* The place is on the cube, unless the depth is that of another view. */
#define SHOW \
    "p /= p.w; float far = max(max(abs(p.x), abs(p.y)), abs(p.z));\n" \
    "    result = abs(far - 1.0) < 0.01 ? vec4(colour(p.xyz), 1.0) : vec4(0.0);"
#define PLACE(uniforms, statements) \
    HEAD "in vec3 shade, place;\nout vec4 result;\nuniform vec2 size;\n" uniforms \
         "void main() {\n" statements \
         "    if (distance(seen * size, gl_FragCoord.xy) > 0.02) discard;\n" \
         "    result = vec4(shade, 1.0);\n}\n"

typedef struct {
    const char *name, *vertex, *fragment;
} form;

static const form forms[] = {
    {"sky_all", TRIANGLE, SKY("uniform mat4 inversePMV;\n", "(inversePMV * vec4(at, 1.0, 1.0)).xyz")},
    {"sky_apart", TRIANGLE,
     SKY("uniform mat4 inverseP, inverseMV;\n", "mat3(inverseMV) * (inverseP * vec4(at, 1.0, 1.0)).xyz")},
    {"sky_inverted", TRIANGLE, SKY("uniform mat4 P, MV;\n", "(inverse(P * MV) * vec4(at, -1.0, 1.0)).xyz")},
    {"sky_row_vector", TRIANGLE, SKY("uniform mat4 rowsPMV;\n", "(vec4(at, 1.0, 1.0) * rowsPMV).xyz")},
    {"sky_block", TRIANGLE,
     SKY("layout(std140) uniform B { vec4 tint; mat4 inversePMV; } camera;\n",
         "(camera.inversePMV * vec4(at, 1.0, 1.0)).xyz")},
    {"sky_structure", TRIANGLE,
     SKY("struct Camera { mat4 inversePMV; };\nuniform Camera camera;\n#define INVERSE camera.inversePMV\n",
         "(INVERSE * vec4(at, 1.0, 1.0)).xyz")},
    {"sky_texture", TRIANGLE,
     SKY("uniform mat4 inverseTPMV;\n", "(inverseTPMV * vec4(at * 0.5 + 0.5, 1.0, 1.0)).xyz")},
    {"sky_vertices",
     HEAD "out vec3 direction;\nuniform mat4 inversePMV;\nvoid main() {\n"
          "    vec2 at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;\n"
          "    vec4 near = inversePMV * vec4(at, -1.0, 1.0);\n    direction = near.xyz / near.w;\n"
          "    gl_Position = vec4(at, 0.5, 1.0);\n}\n",
     HEAD "in vec3 direction;\nout vec4 result;\n" COLOUR "void main() { result = vec4(colour(direction), 1.0); }\n"},
    {"sky_old",
     "#version 120\nattribute vec3 position;\nvarying vec2 at;\n"
     "void main() { at = position.xy; gl_Position = vec4(position.xy, 0.5, 1.0); }\n",
     "#version 120\nvarying vec2 at;\nuniform mat4 inversePMV;\n" COLOUR
     "void main() { gl_FragColor = vec4(colour((inversePMV * vec4(at, 1.0, 1.0)).xyz), 1.0); }\n"},
    {"sky_forced", TRIANGLE,
     SKY("uniform mat4 inverseP, inverseMV;\nvec3 direction() {\n    vec4 eye = inverseP * vec4(at, -1.0, 1.0);\n"
         "    return (inverseMV * vec4(eye.xy, -1.0, 0.0)).xyz;\n}\n",
         "direction()")},
    {"sky_forced_view", TRIANGLE,
     SKY("uniform mat4 P, view;\nvec3 direction() {\n    vec4 eye = inverse(P) * vec4(at, -1.0, 1.0);\n"
         "    return inverse(mat3(view)) * vec3(eye.xy / -eye.z, -1.0);\n}\n",
         "direction()")},
    {"sky_off", TRIANGLE, SKY("uniform mat4 inversePMV;\n", "(inversePMV * vec4(at, 1.0, 1.0)).xyz")},
    {"light_all", TRIANGLE, LIGHT("uniform mat4 inversePMV;\n", "p = inversePMV * ndc;" SHOW)},
    {"light_apart", TRIANGLE,
     LIGHT("uniform mat4 inverseP, inverseMV;\n", "p = inverseP * ndc; p = inverseMV * (p / p.w);" SHOW)},
    {"light_texture", TRIANGLE,
     LIGHT("uniform mat4 inverseTDPMV;\n", "p = inverseTDPMV * vec4(at * 0.5 + 0.5, depth, 1.0);" SHOW)},
    {"light_copied", TRIANGLE, LIGHT("uniform mat4 inversePMV;\n", "p = inversePMV * ndc;" SHOW)},
    {"light_converted", TRIANGLE, LIGHT("uniform mat4 inversePMV;\n", "p = inversePMV * ndc;" SHOW)},
    {"light_back", TRIANGLE,
     LIGHT("uniform mat4 P, inverseP;\n",
           "p = inverseP * ndc; p /= p.w;\n    p = P * p; vec2 uv = p.xy / p.w * 0.5 + 0.5;\n"
           "    result = distance(uv * size, gl_FragCoord.xy) < 0.05 ? texture(colours, uv) : vec4(0.0);")},
    {"place_all", CUBE,
     PLACE("uniform mat4 PMV;\n", "    vec4 c = PMV * vec4(place, 1.0); vec2 seen = c.xy / c.w * 0.5 + 0.5;\n")},
    {"place_shared", CUBE,
     PLACE("uniform mat4 P, MV;\n", "    vec4 c = P * (MV * vec4(place, 1.0)); vec2 seen = c.xy / c.w * 0.5 + 0.5;\n")},
    {"place_texture", CUBE,
     PLACE("uniform mat4 TPMV;\n", "    vec4 c = TPMV * vec4(place, 1.0); vec2 seen = c.xy / c.w;\n")},
    {"place_geometry", CUBE,
     HEAD "in vec3 tint, clip;\nout vec4 result;\nuniform vec2 size;\n"
          "void main() {\n    vec2 seen = clip.xy / clip.z * 0.5 + 0.5;\n"
          "    if (distance(seen * size, gl_FragCoord.xy) > 0.02) discard;\n    result = vec4(tint, 1.0);\n}\n"},
    {"place_lamp", CUBE,
     PLACE("uniform mat4 lamp;\nuniform vec4 lamps[4];\n",
           "    vec4 c = lamp * vec4(place, 1.0);\n"
           "    vec4 d = lamps[0] * place.x + lamps[1] * place.y + lamps[2] * place.z + lamps[3];\n"
           "    vec2 seen = gl_FragCoord.xy / size + 1000.0 * (c.xy / c.w - d.xy / d.w);\n")},
};

/* Passes positions and the places of pixels on. */
static const char geometry[] =
    HEAD "layout(triangles) in;\nlayout(triangle_strip, max_vertices = 3) out;\n"
         "in vec3 shade[], place[];\nout vec3 tint, clip;\n"
         "void main() {\n    for (int i = 0; i < 3; i++) {\n"
         "        tint = shade[i]; clip = gl_in[i].gl_Position.xyw;\n"
         "        gl_Position = gl_in[i].gl_Position; EmitVertex();\n    }\n}\n";

static const form *chosen;
static mesh cube;
static GLuint program, scene, empty, buffer, framebuffer, textures[3], show;

static bool is(const char *kind)
{
    return strncmp(chosen->name, kind, strlen(kind)) == 0;
}

static GLuint build(const char *vertex, const char *fragment, const char *between)
{
    const shader_source stages[] = {
        {GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}, {GL_GEOMETRY_SHADER, between}};
    return program_build(stages, between == NULL ? 2 : 3);
}

static void make_texture(const app *a, int i, GLenum format, GLenum pixels, GLenum attachment)
{
    glActiveTexture(GL_TEXTURE0 + i);
    glBindTexture(GL_TEXTURE_2D, textures[i]);
    glTexImage2D(GL_TEXTURE_2D, 0, format, a->window.width, a->window.height, 0, pixels, GL_UNSIGNED_INT, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, textures[i], 0);
}

static void setup(app *a)
{
    chosen = form_of(a, forms, sizeof *forms, sizeof forms / sizeof *forms);
    cube = mesh_cube();
    program = build(chosen->vertex, chosen->fragment, is("place_geometry") ? geometry : NULL);
    glGenVertexArrays(1, &empty);
    form_block(program);
    if (is("light") || is("sky_off")) {
        glGenFramebuffers(1, &framebuffer);
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        glGenTextures(3, textures);
        make_texture(a, 0, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_DEPTH_ATTACHMENT);
        make_texture(a, 1, GL_RGBA8, GL_RGBA, GL_COLOR_ATTACHMENT0);
        scene = build(CUBE, HEAD "in vec3 shade;\nout vec4 result;\nvoid main() { result = vec4(shade, 1.0); }\n", NULL);
        show = build(TRIANGLE, HEAD "in vec2 at;\nout vec4 result;\nuniform sampler2D colours;\n"
                                    "void main() { result = texture(colours, at * 0.5 + 0.5); }\n", NULL);
    }
}

static void set(GLuint of, const char *name, matrix4 m)
{
    glUniformMatrix4fv(glGetUniformLocation(of, name), 1, GL_FALSE, m.m);
    if (strcmp(name, "inversePMV") == 0) {
        glUniformMatrix4fv(glGetUniformLocation(of, "camera.inversePMV"), 1, GL_FALSE, m.m);
        float block[20] = {1, 1, 1, 1};
        memcpy(block + 4, m.m, sizeof m.m);
        if (glGetUniformBlockIndex(of, "B") != GL_INVALID_INDEX)
            glBufferData(GL_UNIFORM_BUFFER, sizeof block, block, GL_DYNAMIC_DRAW);
    }
}

static void use(const app *a, GLuint of)
{
    const matrix4 p = a->projection, mv = a->modelview, pmv = matrix_multiply(p, mv);
    matrix4 texture = matrix_scale(0.5), with_depth = texture;
    texture.m[10] = 1;
    texture.m[12] = texture.m[13] = 0.5f;
    with_depth.m[12] = with_depth.m[13] = with_depth.m[14] = 0.5f;
    const matrix4 lamp = matrix_multiply(matrix_perspective(70, 1, a->near, a->far), matrix_camera(40, -20));
    glUseProgram(of);
    set(of, "P", p);
    set(of, "MV", mv);
    set(of, "view", a->view);
    set(of, "PMV", pmv);
    set(of, "inverseP", matrix_inverse(p));
    set(of, "inverseMV", matrix_inverse(mv));
    set(of, "inversePMV", matrix_inverse(pmv));
    set(of, "rowsPMV", matrix_transposed(matrix_inverse(pmv)));
    set(of, "TPMV", matrix_multiply(texture, pmv));
    set(of, "inverseTPMV", matrix_inverse(matrix_multiply(texture, pmv)));
    set(of, "inverseTDPMV", matrix_inverse(matrix_multiply(with_depth, pmv)));
    set(of, "lamp", lamp);
    glUniform4fv(glGetUniformLocation(of, "lamps"), 4, lamp.m);
    glUniform2f(glGetUniformLocation(of, "size"), (float)a->window.width, (float)a->window.height);
    glUniform1i(glGetUniformLocation(of, "depths"), 0);
    glUniform1i(glGetUniformLocation(of, "colours"), 1);
}

static void draw_cube(void)
{
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
}

static void draw_triangle(void)
{
    static const float corners[] = {-1, -1, 0, 3, -1, 0, -1, 3, 0};
    glDisable(GL_DEPTH_TEST);
    if (is("sky_old")) {
        if (buffer == 0) {
            glGenBuffers(1, &buffer);
            glBindVertexArray(empty);
            glBindBuffer(GL_ARRAY_BUFFER, buffer);
            glBufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STATIC_DRAW);
            glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
            glEnableVertexAttribArray(0);
        }
        glBindAttribLocation(program, 0, "position");
    }
    glBindVertexArray(empty);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glEnable(GL_DEPTH_TEST);
}

/* Copies the depth to a texture of the same format, or of another. */
static void copy_depth(const app *a)
{
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, textures[2]);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glCopyTexImage2D(GL_TEXTURE_2D, 0, is("light_copied") ? GL_DEPTH_COMPONENT24 : GL_DEPTH_COMPONENT32F, 0, 0,
                     a->window.width, a->window.height, 0);
}

static void draw(app *a)
{
    if (is("light") || is("sky_off")) {
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        app_clear();
        if (is("light")) {
            use(a, scene);
            draw_cube();
            if (is("light_co"))
                copy_depth(a);
        } else {
            use(a, program);
            draw_triangle();
        }
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
    }
    app_clear();
    use(a, is("sky_off") ? show : program);
    if (is("place"))
        draw_cube();
    else
        draw_triangle();
}

int main(int argc, char **argv)
{
    static const app_program self = {"camera_matrices", API_GL_COMPATIBILITY, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
