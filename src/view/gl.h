/* SPDX-License-Identifier: MIT */
/* OpenGL 3.3 core: gl.Clear is glClear. No loader library supports OSMesa.
 * Missing functions may be stubs, so the version decides what is available. */
#ifndef VIEW_GL_H
#define VIEW_GL_H

#include <stdbool.h>
#include <stddef.h>

/* Only for the types of the functions; none is linked. */
#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

/* The functions that the viewer calls. */
/* clang-format off */
#define VIEW_GL_FUNCTIONS(X)                                                   \
    X(ActiveTexture) X(AttachShader) X(BindBuffer) X(BindBufferBase)           \
    X(BindBufferRange) X(BindFramebuffer) X(BindRenderbuffer) X(BindSampler)   \
    X(BindTexture) X(BindVertexArray) X(BlendFuncSeparate) X(BlitFramebuffer)  \
    X(BufferData) X(BufferSubData) X(CheckFramebufferStatus) X(Clear)          \
    X(ClearColor) X(ColorMask) X(CompileShader) X(CreateProgram)               \
    X(CreateShader) X(CullFace) X(DeleteBuffers) X(DeleteFramebuffers)         \
    X(DeleteProgram) X(DeleteRenderbuffers) X(DeleteSamplers) X(DeleteShader)  \
    X(DeleteTextures) X(DeleteVertexArrays) X(DepthFunc) X(DepthMask)          \
    X(DetachShader) X(Disable) X(DrawArrays) X(DrawArraysInstanced)            \
    X(DrawElements) X(Enable) X(EnableVertexAttribArray) X(Finish)             \
    X(FramebufferRenderbuffer) X(FramebufferTexture2D)                         \
    X(FramebufferTextureLayer) X(FrontFace) X(GenBuffers) X(GenFramebuffers)   \
    X(GenRenderbuffers) X(GenSamplers) X(GenTextures) X(GenVertexArrays)       \
    X(GetError) X(GetIntegerv) X(GetProgramInfoLog) X(GetProgramiv)            \
    X(GetShaderInfoLog) X(GetShaderiv) X(GetString) X(GetStringi)              \
    X(GetTexImage) X(GetUniformBlockIndex) X(GetUniformLocation)               \
    X(LinkProgram) X(PixelStorei) X(ReadPixels) X(RenderbufferStorage)         \
    X(RenderbufferStorageMultisample) X(SamplerParameteri) X(ShaderSource)     \
    X(GenerateMipmap) X(TexBuffer) X(TexImage2D) X(TexImage3D)                 \
    X(TexParameteri) X(TexSubImage3D) X(Uniform1f) X(Uniform1i) X(Uniform2f)   \
    X(UniformBlockBinding) X(UseProgram) X(VertexAttrib4f)                     \
    X(VertexAttribDivisor) X(VertexAttribPointer) X(Viewport)
/* clang-format on */

typedef struct view_gl {
#define VIEW_GL_MEMBER(name) __typeof__(gl##name) *name;
    VIEW_GL_FUNCTIONS(VIEW_GL_MEMBER)
#undef VIEW_GL_MEMBER
} view_gl;

extern view_gl gl;

typedef void view_gl_proc(void);

/* Fills gl for the current context and sets the state that no other call
 * changes: seamless cubes, rows without padding, and blending source over with
 * the alpha kept. False, with a message, without OpenGL 3.3 core. */
bool view_gl_load(view_gl_proc *(*get)(const char *name));
/* Whether shaders of 3.30 have samplerCubeArray: OpenGL 4.0, or
 * ARB_texture_cube_map_array. */
bool view_gl_has_cube_arrays(void);

/* Binds a texture to a unit and activates the unit. */
void view_gl_bind(int unit, GLenum target, GLuint texture);
/* Sets the lookup of the bound texture: GL_NEAREST, or GL_LINEAR, also between
 * levels; clamped to edges. */
void view_gl_filter(GLenum target, GLint filtering, int levels);
/* Makes and binds a buffer of that size, filled from data unless it is NULL. */
GLuint view_gl_buffer(GLenum target, size_t bytes, const void *data);
/* Adds an attribute to the bound vertex array: size floats at an offset of the
 * bound buffer. divisor 1: per instance. */
void view_gl_attribute(GLuint at, int size, size_t stride, size_t offset,
                       GLuint divisor);
/* Attaches a 2D texture to a framebuffer and binds it; false if it is
 * incomplete. */
bool view_gl_target(GLuint framebuffer, GLuint texture);
/* Draws vertices that have only a number. */
void view_gl_draw(GLuint program, GLenum mode, int count);
/* Draws the triangle of full.vert with a program. */
void view_gl_draw_full(GLuint program);

/* False, with a message that begins with where, if OpenGL has an error. */
bool view_gl_check(const char *where);

/* ---- pictures of triangles, with depth --------------------------------- */

typedef struct view_canvas {
    GLuint framebuffer, buffer[2]; /* colour and depth */
    int width, height, samples;
} view_canvas;

/* Binds a framebuffer for a picture of width x height pixels, with that many
 * samples of each pixel or as many as OpenGL has, and sets the viewport.
 * Allocates only if size or samples change. False, with a message. */
bool view_canvas_begin(view_canvas *c, int width, int height, int samples);
/* Writes the picture, the mean of the samples, to a framebuffer of that size,
 * and binds that. */
void view_canvas_end(const view_canvas *c, GLuint framebuffer);
void view_canvas_free(view_canvas *c); /* zeroed is fine */

#endif
