/* SPDX-License-Identifier: MIT */
/*
 * OpenGL 3.3 core, by the names of GL/glcorearb.h: gl.Clear is glClear. There
 * is no loader library that knows OSMesa, and names that an implementation does
 * not have come back as stubs, so that only its version says what is there.
 */
#ifndef VIEW_GL_H
#define VIEW_GL_H

#include <stdbool.h>

#include <GL/glcorearb.h>

/* What the viewer calls: type of the function, name without gl. */
#define VIEW_GL_FUNCTIONS(X)                                                   \
    X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                                   \
    X(PFNGLATTACHSHADERPROC, AttachShader)                                     \
    X(PFNGLBINDBUFFERPROC, BindBuffer)                                         \
    X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                                 \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                               \
    X(PFNGLBINDRENDERBUFFERPROC, BindRenderbuffer)                             \
    X(PFNGLBINDSAMPLERPROC, BindSampler)                                       \
    X(PFNGLBINDTEXTUREPROC, BindTexture)                                       \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                               \
    X(PFNGLBLENDFUNCSEPARATEPROC, BlendFuncSeparate)                           \
    X(PFNGLBLITFRAMEBUFFERPROC, BlitFramebuffer)                               \
    X(PFNGLBUFFERDATAPROC, BufferData)                                         \
    X(PFNGLBUFFERSUBDATAPROC, BufferSubData)                                   \
    X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus)                 \
    X(PFNGLCLEARPROC, Clear)                                                   \
    X(PFNGLCLEARCOLORPROC, ClearColor)                                         \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                                   \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                                   \
    X(PFNGLCREATESHADERPROC, CreateShader)                                     \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                                   \
    X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                         \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                   \
    X(PFNGLDELETERENDERBUFFERSPROC, DeleteRenderbuffers)                       \
    X(PFNGLDELETESAMPLERSPROC, DeleteSamplers)                                 \
    X(PFNGLDELETESHADERPROC, DeleteShader)                                     \
    X(PFNGLDELETETEXTURESPROC, DeleteTextures)                                 \
    X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                         \
    X(PFNGLDEPTHFUNCPROC, DepthFunc)                                           \
    X(PFNGLDEPTHMASKPROC, DepthMask)                                           \
    X(PFNGLDETACHSHADERPROC, DetachShader)                                     \
    X(PFNGLDISABLEPROC, Disable)                                               \
    X(PFNGLDRAWARRAYSPROC, DrawArrays)                                         \
    X(PFNGLDRAWARRAYSINSTANCEDPROC, DrawArraysInstanced)                       \
    X(PFNGLDRAWBUFFERPROC, DrawBuffer)                                         \
    X(PFNGLDRAWELEMENTSPROC, DrawElements)                                     \
    X(PFNGLDRAWELEMENTSINSTANCEDPROC, DrawElementsInstanced)                   \
    X(PFNGLENABLEPROC, Enable)                                                 \
    X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray)               \
    X(PFNGLFINISHPROC, Finish)                                                 \
    X(PFNGLFRAMEBUFFERRENDERBUFFERPROC, FramebufferRenderbuffer)               \
    X(PFNGLFRAMEBUFFERTEXTURE2DPROC, FramebufferTexture2D)                     \
    X(PFNGLFRAMEBUFFERTEXTURELAYERPROC, FramebufferTextureLayer)               \
    X(PFNGLFRONTFACEPROC, FrontFace)                                           \
    X(PFNGLGENBUFFERSPROC, GenBuffers)                                         \
    X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                               \
    X(PFNGLGENRENDERBUFFERSPROC, GenRenderbuffers)                             \
    X(PFNGLGENSAMPLERSPROC, GenSamplers)                                       \
    X(PFNGLGENTEXTURESPROC, GenTextures)                                       \
    X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                               \
    X(PFNGLGETERRORPROC, GetError)                                             \
    X(PFNGLGETINTEGERVPROC, GetIntegerv)                                       \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                           \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                     \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                             \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                       \
    X(PFNGLGETSTRINGPROC, GetString)                                           \
    X(PFNGLGETSTRINGIPROC, GetStringi)                                         \
    X(PFNGLGETTEXIMAGEPROC, GetTexImage)                                       \
    X(PFNGLGETUNIFORMBLOCKINDEXPROC, GetUniformBlockIndex)                     \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                         \
    X(PFNGLLINKPROGRAMPROC, LinkProgram)                                       \
    X(PFNGLPIXELSTOREIPROC, PixelStorei)                                       \
    X(PFNGLREADBUFFERPROC, ReadBuffer)                                         \
    X(PFNGLREADPIXELSPROC, ReadPixels)                                         \
    X(PFNGLRENDERBUFFERSTORAGEPROC, RenderbufferStorage)                       \
    X(PFNGLSAMPLERPARAMETERIPROC, SamplerParameteri)                           \
    X(PFNGLSHADERSOURCEPROC, ShaderSource)                                     \
    X(PFNGLTEXBUFFERPROC, TexBuffer)                                           \
    X(PFNGLTEXIMAGE2DPROC, TexImage2D)                                         \
    X(PFNGLTEXIMAGE3DPROC, TexImage3D)                                         \
    X(PFNGLTEXPARAMETERIPROC, TexParameteri)                                   \
    X(PFNGLUNIFORM1FPROC, Uniform1f)                                           \
    X(PFNGLUNIFORM1IPROC, Uniform1i)                                           \
    X(PFNGLUNIFORM2FPROC, Uniform2f)                                           \
    X(PFNGLUNIFORMBLOCKBINDINGPROC, UniformBlockBinding)                       \
    X(PFNGLUSEPROGRAMPROC, UseProgram)                                         \
    X(PFNGLVERTEXATTRIBDIVISORPROC, VertexAttribDivisor)                       \
    X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)                       \
    X(PFNGLVIEWPORTPROC, Viewport)

typedef struct view_gl {
#define VIEW_GL_MEMBER(type, name) type name;
    VIEW_GL_FUNCTIONS(VIEW_GL_MEMBER)
#undef VIEW_GL_MEMBER
} view_gl;

extern view_gl gl;

typedef void view_gl_proc(void);

/* Fills gl by get, of the current context. False, with a message, if that has
   no OpenGL 3.3 core. */
bool view_gl_load(view_gl_proc *(*get)(const char *name));
/* Whether shaders of 3.30 have samplerCubeArray: OpenGL 4.0, or
 * ARB_texture_cube_map_array. */
bool view_gl_has_cube_arrays(void);

/* Binds a texture to a unit, which is active then. */
void view_gl_bind(int unit, GLenum target, GLuint texture);
/* How the texture that is bound is looked up: GL_NEAREST or GL_LINEAR, then
 * between levels too, of which there are so many; clamped to edges. */
void view_gl_filter(GLenum target, GLint filtering, int levels);

/* False, with a message that says where, if OpenGL has noted an error. */
bool view_gl_check(const char *where);

#endif
