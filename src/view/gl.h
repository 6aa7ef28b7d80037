/* SPDX-License-Identifier: MIT */
/* OpenGL 3.3 core, and ARB_texture_cube_map_array for the room: gl.Clear is
 * glClear. No loader library supports OSMesa. */
#ifndef VIEW_GL_H
#define VIEW_GL_H

#include <stdbool.h>
#include <stddef.h>

/* Only for the types of the functions; none is linked. */
#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

#include "view/baked_set.h"

/* The functions that the viewer calls. */
/* clang-format off */
#define VIEW_GL_FUNCTIONS(X)                                                   \
    X(ActiveTexture) X(AttachShader) X(BindBuffer) X(BindBufferBase)           \
    X(BindBufferRange) X(BindFramebuffer) X(BindRenderbuffer) X(BindSampler)   \
    X(BindTexture) X(BindVertexArray) X(BlendColor) X(BlendFunc)               \
    X(BlendFuncSeparate) X(BufferData) X(BufferSubData)                        \
    X(CheckFramebufferStatus) X(Clear) X(ClearColor) X(ColorMask)              \
    X(CompileShader) X(CreateProgram) X(CreateShader) X(CullFace)              \
    X(DeleteBuffers) X(DeleteFramebuffers) X(DeleteProgram)                    \
    X(DeleteRenderbuffers) X(DeleteSamplers) X(DeleteShader) X(DeleteTextures) \
    X(DeleteVertexArrays) X(DepthFunc) X(DepthMask) X(Disable) X(DrawArrays)   \
    X(DrawArraysInstanced) X(DrawElements) X(Enable)                           \
    X(EnableVertexAttribArray) X(Finish) X(FramebufferRenderbuffer)            \
    X(FramebufferTexture2D) X(FramebufferTextureLayer) X(FrontFace)            \
    X(GenBuffers) X(GenFramebuffers) X(GenQueries) X(GenRenderbuffers)         \
    X(GenSamplers) X(GenTextures) X(GenVertexArrays) X(GenerateMipmap)         \
    X(GetError) X(GetIntegerv) X(GetProgramInfoLog) X(GetProgramiv)            \
    X(GetQueryObjectui64v) X(GetShaderInfoLog) X(GetShaderiv) X(GetString)     \
    X(GetTexImage) X(GetUniformBlockIndex) X(GetUniformLocation)               \
    X(LinkProgram) X(PixelStorei) X(QueryCounter) X(ReadPixels)                \
    X(RenderbufferStorage) X(SamplerParameteri) X(Scissor) X(ShaderSource)     \
    X(TexBuffer) X(TexImage2D) X(TexImage3D) X(TexParameteri) X(Uniform1i)     \
    X(Uniform2f) X(Uniform4f) X(UniformBlockBinding) X(UseProgram)             \
    X(VertexAttrib4f) X(VertexAttribPointer) X(Viewport)
/* clang-format on */

typedef struct view_gl {
#define VIEW_GL_MEMBER(name) __typeof__(gl##name) *name;
    VIEW_GL_FUNCTIONS(VIEW_GL_MEMBER)
#undef VIEW_GL_MEMBER
} view_gl;

extern view_gl gl;

typedef void view_gl_proc(void);

/* Fills gl for the current context, which is of OpenGL 3.3 core, and sets the
 * state that no other call changes: seamless cubes, rows without padding, and
 * blending by alpha. False, with a message: a function is missing. */
bool view_gl_load(view_gl_proc *(*get)(const char *name));

/* Binds a texture to a unit and activates the unit. */
void view_gl_bind(int unit, GLenum target, GLuint texture);
/* Sets the lookup of the bound texture: GL_NEAREST, or GL_LINEAR, also between
 * levels; clamped to edges. */
void view_gl_filter(GLenum target, GLint filtering, int levels);
/* Makes and binds a buffer of that size, filled from data unless it is NULL. */
GLuint view_gl_buffer(GLenum target, size_t bytes, const void *data);
/* Adds an attribute to the bound vertex array: size floats at an offset of the
 * bound buffer. */
void view_gl_attribute(GLuint at, int size, size_t stride, size_t offset);
/* Draws the triangle of full.vert with a program. */
void view_gl_draw_full(GLuint program);
/* Draws strips of four vertices without attributes. */
void view_gl_draw_quads(GLuint program, int count);

/* The time that OpenGL takes between these calls, in milliseconds; end waits
 * for it. 0: it has no timer. */
void view_gl_time_begin(void);
double view_gl_time_end(void);

/* False, with a message that begins with where, if OpenGL has an error. */
bool view_gl_check(const char *where);

/* ---- shaders ----------------------------------------------------------- */

/* What the build makes of src/view/shaders (build/gen/shaders.c), ended by a
 * NULL name: lines `#include "name.glsl"` put files, each once, before the one
 * that has them. Messages have the line in the file that it is from. */
typedef struct view_shader_file {
    const char *name, *text;
} view_shader_file;
extern const view_shader_file view_shader_files[];

/* Compiles and links shaders after lines "#define NAME VALUE", and binds
 * uniform blocks and samplers by name to the places below. 0, with the
 * compiler's first line as the message, after an error. */
GLuint view_program_from(const view_shader_file *files, const char *defines,
                         const char *vertex_file, const char *fragment_file);
/* The same from view_shader_files, made on first use and kept with the context.
 */
GLuint view_program(const char *defines, const char *vertex_file,
                    const char *fragment_file);

/* Bindings of uniform blocks: "Frame", "Room", "Material". */
enum {
    VIEW_BLOCK_FRAME,
    VIEW_BLOCK_ROOM,
    VIEW_BLOCK_MATERIAL,
    VIEW_BLOCKS
};
/* Replaces what is in the block's own buffer, and binds that. */
void view_gl_block(int block, const void *data, size_t bytes);

/* Texture units, and the names of their samplers. */
/* clang-format off */
#define VIEW_UNITS(X)                                                          \
    X(VIEW_UNIT_SPECULAR, "specular_map")                                      \
    X(VIEW_UNIT_IRRADIANCE, "irradiance_map")                                  \
    X(VIEW_UNIT_LUT, "lut_map")                                                \
    X(VIEW_UNIT_SKY, "sky_map")                                                \
    X(VIEW_UNIT_LOBES, "lobe_map")                                             \
    X(VIEW_UNIT_BACKDROP, "backdrop_map")                                      \
    X(VIEW_UNIT_PICTURE, "picture")                                            \
    X(VIEW_UNIT_OTHER, "other")                                                \
    X(VIEW_TRUTH_UNIT_TOKENS, "aim_tokens")                                    \
    X(VIEW_TRUTH_UNIT_CHANCE, "aim_chance")                                    \
    X(VIEW_GROUND_UNIT, "light_depth")                                         \
    X(VIEW_GROUND_UNIT_BELOW, "below_depth")                                   \
    X(VIEW_ROOM_UNIT_DYNAMIC, "dynamic_specular")                              \
    X(VIEW_ROOM_UNIT_DYNAMIC_MATTE, "dynamic_irradiance")                      \
    X(VIEW_ROOM_UNIT_LOCALS, "local_specular")                                 \
    X(VIEW_ROOM_UNIT_LOCALS_MATTE, "local_irradiance")                         \
    X(VIEW_ROOM_UNIT_BUFFER, "probe_buffer")                                   \
    X(VIEW_CAPTURE_UNIT, "source")                                             \
    X(VIEW_CAPTURE_UNIT_AWAY, "source1")                                       \
    X(VIEW_CAPTURE_UNIT_MORE, "samples")                                       \
    X(VIEW_MODEL_UNITS, "base_map")                                            \
    X(VIEW_MODEL_UNIT_ROUGH, "rough_map")                                      \
    X(VIEW_MODEL_UNIT_NORMAL, "normal_map")                                    \
    X(VIEW_MODEL_UNIT_OCCLUSION, "occlusion_map")                              \
    X(VIEW_MODEL_UNIT_EMISSIVE, "emissive_map")                                \
    X(VIEW_MODEL_UNIT_WEIGHT, "weight_map")                                    \
    X(VIEW_MODEL_UNIT_F0, "f0_map")                                            \
    X(VIEW_MODEL_UNIT_COAT, "coat_map")                                        \
    X(VIEW_MODEL_UNIT_COAT_ROUGH, "coat_rough_map")                            \
    X(VIEW_MODEL_UNIT_COAT_NORMAL, "coat_normal_map")
/* clang-format on */

typedef enum view_unit {
#define VIEW_UNIT_MEMBER(unit, name) unit,
    VIEW_UNITS(VIEW_UNIT_MEMBER)
#undef VIEW_UNIT_MEMBER
    VIEW_UNIT_COUNT
} view_unit;

/* ---- textures ---------------------------------------------------------- */

/* Whether a texture is within GL_MAX_TEXTURE_SIZE or such; else a message. */
bool view_gl_takes(GLenum limit, int width, int height, const char *name);
/* Uploads all levels of a texture without blocks, filtered linearly, and binds
 * it to the active unit: as a cube map or, with one face, a 2D texture or
 * array; cubes: as a cube map array. name: for messages. 0, with a message:
 * OpenGL has no room for it. */
GLuint view_upload(const ibl_texture *tex, bool cubes, const char *name);

/* Uploads the map of a set as an equirectangular picture of RGB floats, bound
 * to the active unit. 0: it is not at hand. */
GLuint view_upload_map(const baked_set *set);

/* Makes a texture of 32-bit floats, GL_RED, GL_RGB or GL_RGBA, or of depth,
 * GL_DEPTH_COMPONENT, that is read texel by texel, on the active unit. texels
 * NULL: undefined. */
GLuint view_float_image(GLenum format, int width, int height,
                        const float *texels);

/* A picture of RGBA floats to draw into, with depth; zeroed: not made yet. */
typedef struct view_image {
    GLuint texture, depth, framebuffer;
    int width, height;
} view_image;

/* Makes it, unless it has that size already. False, with a message. */
bool view_image_make(view_image *i, int width, int height);
/* Binds it, with its viewport, and clears its depth buffer. */
void view_image_begin(const view_image *i);
void view_image_free(view_image *i); /* zeroes it, too */

/* Blends a picture into the mean of several, which is made on first use.
 *   part     its share, 1: it replaces them
 * Leaves the mean bound for drawing, blending off. False, with a message. */
bool view_mean_add(const view_image *picture, float part, view_image *mean);

/* ---- pictures ---------------------------------------------------------- */

/* Reads a framebuffer, 0 for the screen: 3 or 4 channels of 8 bits, rows from
 * the top; the caller must free it. */
unsigned char *view_picture_read(GLuint framebuffer, int width, int height,
                                 int channels);
/* Reverses the order of the rows. */
void view_picture_flip(void *pixels, size_t row_bytes, int height);
/* Whether a picture of that name holds linear floats: it ends in .exr. */
bool view_picture_is_linear(const char *path);
/* Writes a picture, completely or not at all: 8 bits as PNG, with an sRGB chunk
 * if it has 3 channels and else with alpha that is not multiplied in, or 3
 * floats as EXR, as view_picture_is_linear says. False, with a message. */
bool view_picture_write(ibl_ctx *ctx, const char *path, int width, int height,
                        int channels, const void *pixels);
/* The name of a picture of a series: OUT-001.png for OUT.png and 1. The caller
 * must free it. */
char *view_picture_name(const char *path, int number);

/* ---- pictures in memory, without a display ----------------------------- */

/* Makes a context of OpenGL 3.3 core current whose framebuffer 0 has that size,
 * with alpha, and loads gl: by EGL on a GPU, else by OSMesa. libraries: file
 * names, ended by NULL, of EGL, which then draws on any device, or of OSMesa;
 * NULL: the usual ones. One screen at a time. False, with a message: none. */
bool view_screen_memory(int width, int height, const char *const *libraries);
void view_screen_close(void); /* also without one */

/* What made the screen that is open: "EGL" or "OSMesa"; of windows "GLFW". */
const char *view_screen_by(void);

#endif
