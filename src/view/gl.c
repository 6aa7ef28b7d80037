/* SPDX-License-Identifier: MIT */
#include "view/gl.h"

#include "view/message.h"
#include <stdint.h>
#include <stdio.h>
#include <string.h>

view_gl gl;

static GLuint nothing; /* a vertex array without attributes */

/* ISO C converts between types of functions, but not through void *. */
static bool find_all(view_gl_proc *(*get)(const char *))
{
#define VIEW_GL_FIND(name)                                                     \
    gl.name = (__typeof__(gl.name))get("gl" #name);                            \
    if (!gl.name)                                                              \
        return view_fail("this OpenGL has no gl" #name                         \
                         ": its driver is too old or broken");
    VIEW_GL_FUNCTIONS(VIEW_GL_FIND)
#undef VIEW_GL_FIND
    return true;
}

bool view_gl_load(view_gl_proc *(*get)(const char *name))
{
    int major = 0, minor = 0;
    GLint profile = 0;

    gl.GetString = (__typeof__(gl.GetString))get("glGetString");
    if (!gl.GetString)
        return view_fail("OpenGL has no glGetString: it is not installed as "
                         "a whole");
    const char *version = (const char *)gl.GetString(GL_VERSION);
    if (!version || sscanf(version, "%d.%d", &major, &minor) != 2)
        return view_fail("OpenGL does not tell its version: no context");
    if (major < 3 || (major == 3 && minor < 3))
        return view_fail("OpenGL 3.3 core is needed, this is \"%s\"", version);
    if (!find_all(get))
        return false;
    gl.GetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
    if (!(profile & GL_CONTEXT_CORE_PROFILE_BIT))
        return view_fail("OpenGL 3.3 core is needed, this is \"%s\" without "
                         "a core profile",
                         version);
    gl.GenVertexArrays(1, &nothing);
    gl.Enable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    /* Coverage is alpha; alpha of pictures stays 1. */
    gl.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
    return true;
}

bool view_gl_has_cube_arrays(void)
{
    GLint major = 0, count = 0;

    gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    if (major >= 4)
        return true;
    gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (int i = 0; i < count; i++) {
        const GLubyte *name = gl.GetStringi(GL_EXTENSIONS, (GLuint)i);
        if (name &&
            !strcmp((const char *)name, "GL_ARB_texture_cube_map_array"))
            return true;
    }
    return false;
}

void view_gl_bind(int unit, GLenum target, GLuint texture)
{
    gl.ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    gl.BindTexture(target, texture);
}

void view_gl_filter(GLenum target, GLint filtering, int levels)
{
    const bool mips = filtering == GL_LINEAR && levels > 1;

    gl.TexParameteri(target, GL_TEXTURE_BASE_LEVEL, 0);
    gl.TexParameteri(target, GL_TEXTURE_MAX_LEVEL, levels - 1);
    gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, filtering);
    gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER,
                     mips ? GL_LINEAR_MIPMAP_LINEAR : filtering);
    gl.TexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl.TexParameteri(target, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
}

GLuint view_gl_buffer(GLenum target, size_t bytes, const void *data)
{
    GLuint buffer;

    gl.GenBuffers(1, &buffer);
    gl.BindBuffer(target, buffer);
    gl.BufferData(target, (GLsizeiptr)bytes, data,
                  data ? GL_STATIC_DRAW : GL_DYNAMIC_DRAW);
    return buffer;
}

void view_gl_attribute(GLuint at, int size, size_t stride, size_t offset,
                       GLuint divisor)
{
    gl.EnableVertexAttribArray(at);
    gl.VertexAttribPointer(at, size, GL_FLOAT, GL_FALSE, (GLsizei)stride,
                           (const void *)(uintptr_t)offset);
    gl.VertexAttribDivisor(at, divisor);
}

bool view_gl_target(GLuint framebuffer, GLuint texture)
{
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                            texture, 0);
    return gl.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

void view_gl_draw(GLuint program, GLenum mode, int count)
{
    gl.UseProgram(program);
    gl.BindVertexArray(nothing);
    gl.DrawArrays(mode, 0, count);
}

void view_gl_draw_full(GLuint program)
{
    view_gl_draw(program, GL_TRIANGLES, 3);
}

static const char *error_name(GLenum error)
{
    static const char *const names[] = {"invalid enum",
                                        "invalid value",
                                        "invalid operation",
                                        "stack overflow",
                                        "stack underflow",
                                        "out of memory",
                                        "framebuffer not complete"};
    const GLenum i = error - GL_INVALID_ENUM;

    return i < sizeof names / sizeof *names ? names[i] : "unknown error";
}

bool view_gl_check(const char *where)
{
    const GLenum first = gl.GetError();

    if (first == GL_NO_ERROR)
        return true;
    /* A lost context reports errors without end. */
    for (int i = 0; i < 64 && gl.GetError() != GL_NO_ERROR; i++)
        continue;
    return view_fail("%s: OpenGL says %s (0x%04x)", where, error_name(first),
                     first);
}

/* ---- pictures of triangles, with depth --------------------------------- */

void view_canvas_free(view_canvas *c)
{
    gl.DeleteFramebuffers(1, &c->framebuffer);
    gl.DeleteRenderbuffers(2, c->buffer);
    *c = (view_canvas){0};
}

static void attach(const view_canvas *c, int i, GLenum format, GLenum place)
{
    GLint most = 0;

    gl.GetIntegerv(GL_MAX_SAMPLES, &most);
    const int samples = c->samples < most ? c->samples : most;
    gl.BindRenderbuffer(GL_RENDERBUFFER, c->buffer[i]);
    gl.RenderbufferStorageMultisample(GL_RENDERBUFFER,
                                      samples > 1 ? samples : 0, format,
                                      c->width, c->height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, place, GL_RENDERBUFFER,
                               c->buffer[i]);
}

static void make(view_canvas *c, int width, int height, int samples)
{
    view_canvas_free(c);
    c->width = width, c->height = height, c->samples = samples;
    gl.GenFramebuffers(1, &c->framebuffer);
    gl.GenRenderbuffers(2, c->buffer);
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer);
    attach(c, 0, GL_RGBA32F, GL_COLOR_ATTACHMENT0);
    attach(c, 1, GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
}

bool view_canvas_begin(view_canvas *c, int width, int height, int samples)
{
    if (width != c->width || height != c->height || samples != c->samples)
        make(c, width, height, samples);
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer);
    gl.Viewport(0, 0, width, height);
    if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE)
        return true;
    return view_fail("this OpenGL has no picture of %d x %d floats with "
                     "depth: ask for a smaller one",
                     width, height);
}

void view_canvas_end(const view_canvas *c, GLuint framebuffer)
{
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, c->framebuffer);
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    gl.BlitFramebuffer(0, 0, c->width, c->height, 0, 0, c->width, c->height,
                       GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
}
