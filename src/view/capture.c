/* SPDX-License-Identifier: MIT */
/*
 * An update is a row of steps, each of which fills one face of something in
 * what is not shown. What a scene draws goes into a picture of floats first,
 * and from there, cut to what a half holds, into a cube with levels, each more
 * blurred, that all lookups are in.
 */
#include "view/capture_parts.h"

#include <stdlib.h>
#include <string.h>

#include "view/message.h"

view_capture_options view_capture_options_default(void)
{
    return (view_capture_options){.kind = VIEW_CAPTURE_FACES,
                                  .size = 256,
                                  .samples = 64,
                                  .near = 0.05,
                                  .far = 100};
}

/* ---- passes ------------------------------------------------------------ */

static void attach(GLenum framebuffer, GLuint cube, int level, int face)
{
    gl.FramebufferTexture2D(framebuffer, GL_COLOR_ATTACHMENT0,
                            GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)face, cube,
                            level);
}

void view_capture_fill(const view_capture *c, const view_capture_pass *pass,
                       GLuint cube, int level, int face, int n)
{
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->target);
    attach(GL_FRAMEBUFFER, cube, level, face);
    gl.Viewport(0, 0, n, n);
    gl.UseProgram(pass->program);
    gl.Uniform1i(pass->face, face);
    gl.Uniform1f(pass->edge, (float)n);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
}

view_capture_set *view_capture_back(view_capture *c)
{
    return &c->set[!c->shown];
}

static bool make_pass(view_capture_pass *p, GLuint program)
{
    p->program = program;
    if (!program)
        return false;
    p->face = gl.GetUniformLocation(program, "face");
    p->edge = gl.GetUniformLocation(program, "edge");
    p->row = gl.GetUniformLocation(program, "row");
    p->count = gl.GetUniformLocation(program, "count");
    p->spread = gl.GetUniformLocation(program, "spread");
    p->rings = gl.GetUniformLocation(program, "rings");
    gl.UseProgram(program);
    gl.Uniform1i(gl.GetUniformLocation(program, "source"), VIEW_CAPTURE_UNIT);
    gl.Uniform1i(gl.GetUniformLocation(program, "source1"),
                 VIEW_CAPTURE_UNIT_MORE);
    gl.Uniform1i(gl.GetUniformLocation(program, "samples"),
                 VIEW_CAPTURE_UNIT_MORE);
    gl.UseProgram(0);
    return true;
}

static bool make_passes(view_capture *c)
{
    return make_pass(&c->face,
                     view_program("full.vert", "capture_face.frag")) &&
           make_pass(&c->paraboloid,
                     view_program("full.vert", "capture_paraboloid.frag")) &&
           make_pass(&c->mip, view_program("full.vert", "capture_mip.frag")) &&
           make_pass(&c->blur,
                     view_program("full.vert", "capture_blur.frag")) &&
           make_pass(&c->lobe,
                     view_program("full.vert", "capture_lobe.frag")) &&
           make_pass(&c->equirect,
                     view_program("full.vert", "capture_equirect.frag"));
}

/* ---- what there is ----------------------------------------------------- */

static int most_levels(int size)
{
    int levels = 1;

    while (size >> levels)
        levels++;
    return levels;
}

int view_capture_lookups(int size)
{
    return most_levels(size) - 2;
}

static bool check(const view_capture_options *o)
{
    if (o->size < 16 || o->size > 1024 || (o->size & (o->size - 1)))
        return view_fail("a capture of %d texels: must be a power of two, 16 "
                         "to 1024",
                         o->size);
    if (o->levels < 0 || o->levels > most_levels(o->size))
        return view_fail("a capture of %d levels: must be 1 to %d, or 0 for "
                         "the default",
                         o->levels, most_levels(o->size));
    if (o->samples < 1 || o->samples > 1024)
        return view_fail("a capture of %d samples: must be 1 to 1024",
                         o->samples);
    if (!(o->near > 0 && o->near < o->far))
        return view_fail("a capture from %g to %g: must be above 0, the nearer "
                         "first",
                         o->near, o->far);
    return true;
}

/* Black. */
static GLuint make_cube(const view_capture *c, int size, int levels)
{
    GLuint cube = 0;

    gl.GenTextures(1, &cube);
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, cube);
    for (int l = 0; l < levels; l++)
        for (int f = 0; f < IBL_FACES; f++)
            gl.TexImage2D(GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)f, l,
                          GL_RGBA16F, ibl_cube_edge(size, l),
                          ibl_cube_edge(size, l), 0, GL_RGBA, GL_FLOAT, NULL);
    view_gl_filter(GL_TEXTURE_CUBE_MAP, GL_LINEAR, levels);
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->target);
    gl.ClearColor(0, 0, 0, 0);
    for (int l = 0; l < levels; l++)
        for (int f = 0; f < IBL_FACES; f++) {
            attach(GL_FRAMEBUFFER, cube, l, f);
            gl.Clear(GL_COLOR_BUFFER_BIT);
        }
    return cube;
}

static int sides(const view_capture *c)
{
    return c->options.kind == VIEW_CAPTURE_PARABOLOIDS ? 2 : 1;
}

/* Edge of what the scene draws. */
static int picture_edge(const view_capture *c)
{
    return sides(c) * c->options.size;
}

static bool make_pictures(view_capture *c)
{
    const int n = picture_edge(c);

    gl.GenTextures(sides(c), c->picture);
    gl.GenFramebuffers(sides(c), c->drawn);
    gl.GenRenderbuffers(1, &c->depth);
    gl.BindRenderbuffer(GL_RENDERBUFFER, c->depth);
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, n, n);
    for (int i = 0; i < sides(c); i++) {
        view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_2D, c->picture[i]);
        gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, n, n, 0, GL_RGBA, GL_FLOAT,
                      NULL);
        view_gl_filter(GL_TEXTURE_2D, GL_LINEAR, 1);
        gl.BindFramebuffer(GL_FRAMEBUFFER, c->drawn[i]);
        gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                                GL_TEXTURE_2D, c->picture[i], 0);
        gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT,
                                   GL_RENDERBUFFER, c->depth);
        if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) !=
            GL_FRAMEBUFFER_COMPLETE)
            return view_fail("OpenGL has no picture of %dx%d RGBA floats for "
                             "a capture: make it smaller",
                             n, n);
    }
    return true;
}

static bool make_cubes(view_capture *c)
{
    const int size = c->options.size;

    gl.GenFramebuffers(1, &c->target);
    gl.GenFramebuffers(1, &c->source);
    c->halved = make_cube(c, size / 2, 1);
    c->lookup = make_cube(c, size, view_capture_lookups(size));
    for (int i = 0; i < 2; i++) {
        c->set[i].specular = make_cube(c, size, c->options.levels);
        c->set[i].irradiance = make_cube(c, VIEW_CAPTURE_IRRADIANCE, 1);
    }
    gl.GenTextures(1, &c->samples);
    return gl.CheckFramebufferStatus(GL_FRAMEBUFFER) ==
               GL_FRAMEBUFFER_COMPLETE ||
           view_fail("OpenGL does not draw into cubes of halves");
}

view_capture_state view_capture_begin(const view_capture *c)
{
    view_capture_state s = {0};

    gl.GetIntegerv(GL_FRAMEBUFFER_BINDING, &s.framebuffer);
    gl.GetIntegerv(GL_VIEWPORT, s.viewport);
    gl.Enable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    gl.BindVertexArray(c->corners);
    return s;
}

void view_capture_end(const view_capture_state *s)
{
    gl.BindFramebuffer(GL_FRAMEBUFFER, (GLuint)s->framebuffer);
    gl.Viewport(s->viewport[0], s->viewport[1], s->viewport[2], s->viewport[3]);
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    gl.UseProgram(0);
    gl.ActiveTexture(GL_TEXTURE0);
}

view_capture *view_capture_create(const view_capture_options *options)
{
    view_capture *c;

    if (!check(options))
        return NULL;
    c = calloc(1, sizeof *c);
    if (!c) {
        view_fail("no memory for a capture");
        return NULL;
    }
    c->options = *options;
    if (!c->options.levels)
        c->options.levels = ibl_default_levels(options->size);
    gl.GenVertexArrays(1, &c->corners);
    const view_capture_state state = view_capture_begin(c);
    const bool ok = make_passes(c) && make_pictures(c) && make_cubes(c) &&
                    view_capture_make_samples(c) &&
                    view_gl_check("the cubes of a capture");
    view_capture_end(&state);
    if (ok)
        return c;
    view_capture_free(c);
    return NULL;
}

void view_capture_free(view_capture *c)
{
    if (!c)
        return;
    gl.DeleteTextures(1, &c->samples);
    for (int i = 0; i < 2; i++) {
        gl.DeleteTextures(1, &c->set[i].irradiance);
        gl.DeleteTextures(1, &c->set[i].specular);
    }
    gl.DeleteTextures(1, &c->lookup);
    gl.DeleteTextures(1, &c->halved);
    gl.DeleteFramebuffers(1, &c->source);
    gl.DeleteFramebuffers(1, &c->target);
    gl.DeleteRenderbuffers(1, &c->depth);
    gl.DeleteFramebuffers(2, c->drawn);
    gl.DeleteTextures(2, c->picture);
    gl.DeleteVertexArrays(1, &c->corners);
    gl.DeleteProgram(c->equirect.program);
    gl.DeleteProgram(c->lobe.program);
    gl.DeleteProgram(c->blur.program);
    gl.DeleteProgram(c->mip.program);
    gl.DeleteProgram(c->paraboloid.program);
    gl.DeleteProgram(c->face.program);
    free(c);
}

/* ---- what is shown ----------------------------------------------------- */

GLuint view_capture_specular(const view_capture *c)
{
    return c->set[c->shown].specular;
}

GLuint view_capture_irradiance(const view_capture *c)
{
    return c->set[c->shown].irradiance;
}

int view_capture_size(const view_capture *c)
{
    return c->options.size;
}

int view_capture_levels(const view_capture *c)
{
    return c->options.levels;
}

void view_capture_times(const view_capture *c, double ms[3])
{
    memcpy(ms, c->ms, sizeof c->ms);
}

static bool read(GLuint texture, int size, int levels, ibl_cube *cube)
{
    if (cube->size != size || cube->levels > levels)
        return view_fail("a cube of %d texels, %d levels for a capture of %d, "
                         "%d",
                         cube->size, cube->levels, size, levels);
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, texture);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
    for (int l = 0; l < cube->levels; l++)
        for (int f = 0; f < IBL_FACES; f++)
            gl.GetTexImage(GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)f, l,
                           GL_RGB, GL_FLOAT, ibl_cube_face(cube, l, f));
    gl.ActiveTexture(GL_TEXTURE0);
    return view_gl_check("reading a capture");
}

bool view_capture_read(const view_capture *c, ibl_cube *cube)
{
    return read(view_capture_specular(c), c->options.size, c->options.levels,
                cube);
}

bool view_capture_read_irradiance(const view_capture *c, ibl_cube *cube)
{
    return read(view_capture_irradiance(c), VIEW_CAPTURE_IRRADIANCE, 1, cube);
}
