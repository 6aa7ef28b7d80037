/* SPDX-License-Identifier: MIT */
#include "view/canvas.h"

#include "view/message.h"

void view_canvas_free(view_canvas *c)
{
    gl.DeleteFramebuffers(2, c->framebuffer);
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
    gl.GenFramebuffers(2, c->framebuffer);
    gl.GenRenderbuffers(2, c->buffer);
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer[0]);
    attach(c, 0, GL_RGBA32F, GL_COLOR_ATTACHMENT0);
    attach(c, 1, GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
}

bool view_canvas_begin(view_canvas *c, GLuint picture, int width, int height,
                       int samples)
{
    if (width != c->width || height != c->height || samples != c->samples)
        make(c, width, height, samples);
    const bool whole = view_gl_target(c->framebuffer[1], picture);
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer[0]);
    gl.Viewport(0, 0, width, height);
    if (whole &&
        gl.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE)
        return true;
    return view_fail("this OpenGL has no picture of %d x %d floats with "
                     "depth: ask for a smaller one",
                     width, height);
}

void view_canvas_end(const view_canvas *c)
{
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, c->framebuffer[0]);
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, c->framebuffer[1]);
    gl.BlitFramebuffer(0, 0, c->width, c->height, 0, 0, c->width, c->height,
                       GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer[1]);
}
