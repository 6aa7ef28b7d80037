/* SPDX-License-Identifier: MIT */
/* The steps of an update, one after the other. */
#include <math.h>
#include <string.h>

#include "view/capture_parts.h"
#include "view/clock.h"
#include "view/message.h"

/* ---- what scenes are told ---------------------------------------------- */

/* Of each face: where it looks, where its columns and its rows go. An ordinary
 * camera, whose pictures begin below, thus draws the first row first. */
static const int faces[IBL_FACES][3][3] = {
    {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
    {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
    {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}},
};
/* The same of paraboloids, upright: towards +Z and -Z. */
static const int halves[2][3][3] = {
    {{0, 0, 1}, {-1, 0, 0}, {0, 1, 0}},
    {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}},
};

/* A row of a column-major matrix: scale * (axis . (p - eye)) + add. */
static void set_row(double clip[16], int row, const int axis[3],
                    const double eye[3], double scale, double add)
{
    double along = 0;

    for (int k = 0; k < 3; k++) {
        clip[4 * k + row] = scale * axis[k];
        along += axis[k] * eye[k];
    }
    clip[12 + row] = add - scale * along;
}

static void face_clip(const view_capture *c, int face, double clip[16])
{
    const double near = c->options.near, far = c->options.far;

    set_row(clip, 0, faces[face][1], c->position, 1, 0);
    set_row(clip, 1, faces[face][2], c->position, 1, 0);
    set_row(clip, 2, faces[face][0], c->position, (far + near) / (far - near),
            -2 * far * near / (far - near));
    set_row(clip, 3, faces[face][0], c->position, 1, 0);
}

/* What shaders/paraboloid.glsl wants: distances in parts of far. */
static void half_clip(const view_capture *c, int side, double clip[16])
{
    static const int none[3];
    const double far = c->options.far;

    set_row(clip, 0, halves[side][1], c->position, 1 / far, 0);
    set_row(clip, 1, halves[side][2], c->position, 1 / far, 0);
    set_row(clip, 2, halves[side][0], c->position, 1 / far, 0);
    set_row(clip, 3, none, c->position, 0, c->options.near / far);
}

/* ---- steps ------------------------------------------------------------- */

static bool paraboloids(const view_capture *c)
{
    return c->options.kind == VIEW_CAPTURE_PARABOLOIDS;
}

static void draw(view_capture *c, int index, view_capture_scene *scene,
                 void *cookie)
{
    const int n = paraboloids(c) ? 2 * c->options.size : c->options.size;
    const int picture = paraboloids(c) ? index : 0;
    double clip[16];

    if (paraboloids(c))
        half_clip(c, index, clip);
    else
        face_clip(c, index, clip);
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->drawn[picture]);
    gl.Viewport(0, 0, n, n);
    gl.ClearColor(0, 0, 0, 0);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    gl.Enable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    gl.ActiveTexture(GL_TEXTURE0);
    scene(cookie, clip, c->position, n, paraboloids(c) ? index : -1);
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    gl.BindVertexArray(c->corners);
    if (paraboloids(c))
        return;
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_2D, c->picture[0]);
    view_capture_fill(c, &c->face, c->lookup, 0, index, n);
}

static void resample(view_capture *c)
{
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_2D, c->picture[0]);
    view_gl_bind(VIEW_CAPTURE_UNIT_MORE, GL_TEXTURE_2D, c->picture[1]);
    for (int f = 0; f < IBL_FACES; f++)
        view_capture_fill(c, &c->paraboloid, c->lookup, 0, f, c->options.size);
}

/* Level 0 as what is shown has it: the same texels. */
static void copy(view_capture *c)
{
    const int n = c->options.size;

    for (int f = 0; f < IBL_FACES; f++) {
        const GLenum face = GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)f;
        gl.BindFramebuffer(GL_READ_FRAMEBUFFER, c->source);
        gl.FramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, face,
                                c->lookup, 0);
        gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, c->target);
        gl.FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, face,
                                view_capture_back(c)->specular, 0);
        gl.BlitFramebuffer(0, 0, n, n, 0, 0, n, n, GL_COLOR_BUFFER_BIT,
                           GL_NEAREST);
    }
}

/* What passes read of the lookups: levels first to last. */
static void lookups(const view_capture *c, int first, int last)
{
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, c->lookup);
    gl.TexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_BASE_LEVEL, first);
    gl.TexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_MAX_LEVEL, last);
}

/*
 * A level of the lookups out of what is bound, so that a lookup in it has the
 * variance that is wanted, VIEW_CAPTURE_BLUR, everywhere. What the blur does
 * not have to add is the step from texel to texel, 1/6 of one as large as it
 * is there, and what lookups in the source have: in the level above, a quarter
 * of it all; where it is halved, 1/6 once more as its texels are, and from the
 * first texels to those 3/16 less the 1/48 that the former have themselves.
 */
static void blur(const view_capture *c, int level)
{
    const int n = c->options.size >> level;
    const double mean = 4 * M_PI / (6.0 * n * n);
    const double middle = 4.0 / n / n; /* of the solid angles there */
    const bool first = level == 1;
    const double all = VIEW_CAPTURE_BLUR * mean * (first ? 1 : 0.75);

    gl.UseProgram(c->blur.program);
    gl.Uniform2f(c->blur.spread, (float)all,
                 (float)(middle * (first ? 0.5 : 1.0 / 6)));
    gl.Uniform1i(c->blur.rings, first ? 2 : 3);
    for (int f = 0; f < IBL_FACES; f++)
        view_capture_fill(c, &c->blur, c->lookup, level, f, n);
}

static void make_lookups(view_capture *c)
{
    const int last = view_capture_lookups(c->options.size) - 1;

    lookups(c, 0, 0);
    for (int f = 0; f < IBL_FACES; f++)
        view_capture_fill(c, &c->mip, c->halved, 0, f, c->options.size / 2);
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, c->halved);
    blur(c, 1);
    for (int level = 2; level <= last; level++) {
        lookups(c, level - 1, level - 1);
        blur(c, level);
    }
    lookups(c, 0, last);
}

/* level options.levels: irradiance. */
static void filter(view_capture *c, int level, int face)
{
    const view_capture_set *set = view_capture_back(c);
    const bool diffuse = level == c->options.levels;

    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, c->lookup);
    view_gl_bind(VIEW_CAPTURE_UNIT_MORE, GL_TEXTURE_2D, c->samples);
    gl.UseProgram(c->lobe.program);
    gl.Uniform1i(c->lobe.row, level - 1);
    gl.Uniform1i(c->lobe.count, diffuse ? view_capture_diffuse_samples(c)
                                        : c->options.samples);
    if (diffuse)
        view_capture_fill(c, &c->lobe, set->irradiance, 0, face,
                          VIEW_CAPTURE_IRRADIANCE);
    else
        view_capture_fill(c, &c->lobe, set->specular, level, face,
                          ibl_cube_edge(c->options.size, level));
}

int view_capture_draws(const view_capture *c)
{
    return paraboloids(c) ? 2 : IBL_FACES;
}

int view_capture_steps(const view_capture *c)
{
    return view_capture_draws(c) + 1 +
           (c->options.cpu ? 0 : IBL_FACES * c->options.levels);
}

/* The part of the times that it counts to; -1: it failed. */
static int do_step(view_capture *c, view_capture_scene *scene, void *cookie)
{
    const int index = c->step - view_capture_draws(c);

    if (index < 0) {
        draw(c, c->step, scene, cookie);
        return VIEW_CAPTURE_DRAWING;
    }
    if (index > 0) {
        const int level = 1 + (index - 1) / IBL_FACES;
        filter(c, level, (index - 1) % IBL_FACES);
        return level == c->options.levels ? VIEW_CAPTURE_DIFFUSE
                                          : VIEW_CAPTURE_LEVELS;
    }
    if (paraboloids(c))
        resample(c);
    copy(c);
    if (!c->options.cpu)
        make_lookups(c);
    else if (!view_capture_by_library(c, c->options.cpu, view_capture_back(c)))
        return -1;
    return VIEW_CAPTURE_LEVELS;
}

/* ---- updates ----------------------------------------------------------- */

static bool timed_step(view_capture *c, view_capture_scene *scene, void *cookie)
{
    const double begin = view_clock();
    const int part = do_step(c, scene, cookie);

    if (part < 0)
        return false;
    if (c->options.timed)
        gl.Finish();
    c->doing[part] += 1e3 * (view_clock() - begin);
    c->step++;
    return true;
}

static bool show(view_capture *c)
{
    c->shown = !c->shown;
    memcpy(c->ms, c->doing, sizeof c->ms);
    view_capture_restart(c);
    return view_gl_check("a capture");
}

bool view_capture_advance(view_capture *c, const double position[3],
                          view_capture_scene *scene, void *cookie, int steps)
{
    const view_capture_state kept = view_capture_begin(c);
    const int all = view_capture_steps(c);
    bool ok = true;

    if (!c->step)
        memcpy(c->position, position, sizeof c->position);
    for (int i = 0; i < steps && c->step < all && ok; i++)
        ok = timed_step(c, scene, cookie);
    if (!ok)
        view_capture_restart(c);
    const bool done = c->step == all;
    view_capture_end(&kept);
    c->failed = !ok || (done && !show(c));
    return done && !c->failed;
}

bool view_capture_failed(const view_capture *c)
{
    return c->failed;
}

bool view_capture_update(view_capture *c, const double position[3],
                         view_capture_scene *scene, void *cookie)
{
    view_capture_restart(c);
    return view_capture_advance(c, position, scene, cookie,
                                view_capture_steps(c));
}

void view_capture_set_far(view_capture *c, double far)
{
    c->options.far = far;
}

void view_capture_restart(view_capture *c)
{
    c->step = 0;
    memset(c->doing, 0, sizeof c->doing);
}

bool view_capture_filter_cpu(view_capture *c, ibl_ctx *ctx)
{
    const view_capture_state kept = view_capture_begin(c);
    const double begin = view_clock();

    view_capture_restart(c);
    const bool ok = view_capture_by_library(c, ctx, &c->set[c->shown]);
    if (ok && c->options.timed)
        gl.Finish();
    if (ok) {
        c->ms[VIEW_CAPTURE_LEVELS] = 1e3 * (view_clock() - begin);
        c->ms[VIEW_CAPTURE_DIFFUSE] = 0;
    }
    view_capture_end(&kept);
    return view_gl_check("a capture that the library filters") && ok;
}
