/* SPDX-License-Identifier: MIT */
/* OpenGL 3.3 core: gl.Clear is glClear. No loader library knows OSMesa. Missing
 * functions may come back as stubs, so the version decides what is there. */
#ifndef VIEW_GL_H
#define VIEW_GL_H

#include <stdbool.h>
#include <stddef.h>

/* For the types of the functions: none is linked. */
#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

/* What the viewer calls, without gl. */
/* clang-format off */
#define VIEW_GL_FUNCTIONS(X)                                                   \
    X(ActiveTexture) X(AttachShader) X(BindBuffer) X(BindBufferBase)           \
    X(BindFramebuffer)                                                         \
    X(BindRenderbuffer) X(BindSampler) X(BindTexture) X(BindVertexArray)       \
    X(BlendFuncSeparate) X(BlitFramebuffer) X(BufferData) X(BufferSubData)     \
    X(CheckFramebufferStatus) X(Clear) X(ClearColor) X(CompileShader)          \
    X(CreateProgram) X(CreateShader) X(DeleteBuffers) X(DeleteFramebuffers)    \
    X(DeleteProgram) X(DeleteRenderbuffers) X(DeleteSamplers) X(DeleteShader)  \
    X(DeleteTextures) X(DeleteVertexArrays) X(DepthFunc) X(DepthMask)          \
    X(DetachShader) X(Disable) X(DrawArrays) X(DrawArraysInstanced)            \
    X(DrawBuffer) X(DrawElements) X(Enable) X(EnableVertexAttribArray)         \
    X(Finish) X(FramebufferRenderbuffer)                                       \
    X(FramebufferTexture2D) X(FramebufferTextureLayer) X(FrontFace)            \
    X(GenBuffers) X(GenFramebuffers) X(GenRenderbuffers) X(GenSamplers)        \
    X(GenTextures) X(GenVertexArrays) X(GetError) X(GetIntegerv)               \
    X(GetProgramInfoLog) X(GetProgramiv) X(GetShaderInfoLog) X(GetShaderiv)    \
    X(GetString) X(GetStringi) X(GetTexImage) X(GetUniformBlockIndex)          \
    X(GetUniformLocation) X(LinkProgram) X(PixelStorei) X(ReadBuffer)          \
    X(ReadPixels) X(RenderbufferStorage) X(SamplerParameteri) X(ShaderSource)  \
    X(TexBuffer) X(TexImage2D) X(TexImage3D) X(TexParameteri) X(TexSubImage3D) \
    X(Uniform1f) X(Uniform1i) X(Uniform2f) X(UniformBlockBinding)              \
    X(UseProgram) X(VertexAttrib4f) X(VertexAttribDivisor)                     \
    X(VertexAttribPointer) X(Viewport)
/* clang-format on */

typedef struct view_gl {
#define VIEW_GL_MEMBER(name) __typeof__(gl##name) *name;
    VIEW_GL_FUNCTIONS(VIEW_GL_MEMBER)
#undef VIEW_GL_MEMBER
} view_gl;

extern view_gl gl;

typedef void view_gl_proc(void);

/* Fills gl for the current context and sets what no other call changes: cubes
 * have no seams, rows of pixels have no padding, and blending is source over
 * with the alpha kept. False, with a message, if that has no
 * OpenGL 3.3 core. */
bool view_gl_load(view_gl_proc *(*get)(const char *name));
/* Whether shaders of 3.30 have samplerCubeArray: OpenGL 4.0, or
 * ARB_texture_cube_map_array. */
bool view_gl_has_cube_arrays(void);

/* Binds a texture to a unit, which is active then. */
void view_gl_bind(int unit, GLenum target, GLuint texture);
/* How the bound texture is looked up: GL_NEAREST or GL_LINEAR, then between
 * its levels too; clamped to edges. */
void view_gl_filter(GLenum target, GLint filtering, int levels);
/* Makes and binds a buffer of so many bytes, from data unless that is NULL. */
GLuint view_gl_buffer(GLenum target, size_t bytes, const void *data);
/* An attribute of the bound vertex array: size floats at an offset of the bound
 * buffer. divisor 1: of each instance. */
void view_gl_attribute(GLuint at, int size, size_t stride, size_t offset,
                       GLuint divisor);
/* Binds a framebuffer that draws into a flat texture; false if it cannot. */
bool view_gl_target(GLuint framebuffer, GLuint texture);
/* Draws the three vertices of full.vert by a program. */
void view_gl_draw_full(GLuint program);
/* Copies n x n pixels from the read framebuffer to the draw framebuffer. */
void view_gl_copy(int n);
/* The target that is a face of the bound cube. */
GLenum view_gl_face(int face);

/* False, with a message that says where, if OpenGL has noted an error. */
bool view_gl_check(const char *where);

#endif
