/* SPDX-License-Identifier: MIT */
#include "view/canvas.h"

#include "view/message.h"

void view_canvas_free(view_canvas *c)
{
    gl.DeleteFramebuffers(1, &c->framebuffer);
    gl.DeleteFramebuffers(1, &c->many);
    gl.DeleteRenderbuffers(1, &c->depth);
    gl.DeleteRenderbuffers(2, c->many_buffer);
    *c = (view_canvas){0};
}

static void attach(GLuint buffer, GLenum format, GLenum place, int samples,
                   const view_canvas *c)
{
    gl.BindRenderbuffer(GL_RENDERBUFFER, buffer);
    gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format,
                                      c->width, c->height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, place, GL_RENDERBUFFER, buffer);
}

static bool make(view_canvas *c, int width, int height, int samples)
{
    GLint most = 0;

    view_canvas_free(c);
    gl.GetIntegerv(GL_MAX_SAMPLES, &most);
    c->width = width, c->height = height, c->samples = samples;
    gl.GenFramebuffers(1, &c->framebuffer);
    gl.GenRenderbuffers(1, &c->depth);
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer);
    attach(c->depth, GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT, 0, c);
    if (samples > 1 && most > 1) {
        samples = samples < most ? samples : most;
        gl.GenFramebuffers(1, &c->many);
        gl.GenRenderbuffers(2, c->many_buffer);
        gl.BindFramebuffer(GL_FRAMEBUFFER, c->many);
        attach(c->many_buffer[0], GL_RGBA32F, GL_COLOR_ATTACHMENT0, samples, c);
        attach(c->many_buffer[1], GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT,
               samples, c);
        if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) !=
            GL_FRAMEBUFFER_COMPLETE) {
            gl.DeleteFramebuffers(1, &c->many);
            c->many = 0;
        }
    }
    return view_gl_check("making a picture with depth");
}

bool view_canvas_begin(view_canvas *c, GLuint picture, int width, int height,
                       int samples)
{
    if ((!c->framebuffer || width != c->width || height != c->height ||
         samples != c->samples) &&
        !make(c, width, height, samples))
        return false;
    if (!view_gl_target(c->framebuffer, picture))
        return view_fail("this OpenGL has no picture of %d x %d floats with "
                         "depth: ask for a smaller one",
                         width, height);
    if (c->many)
        gl.BindFramebuffer(GL_FRAMEBUFFER, c->many);
    gl.Viewport(0, 0, width, height);
    return true;
}

void view_canvas_end(const view_canvas *c)
{
    if (c->many) {
        gl.BindFramebuffer(GL_READ_FRAMEBUFFER, c->many);
        gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, c->framebuffer);
        gl.BlitFramebuffer(0, 0, c->width, c->height, 0, 0, c->width, c->height,
                           GL_COLOR_BUFFER_BIT, GL_NEAREST);
    }
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer);
}
