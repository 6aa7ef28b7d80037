/* SPDX-License-Identifier: MIT */
/* An update is a sequence of steps; each draws a picture or fills a face of a
 * cube. The room is drawn as floats. The picture, clamped to the range of half
 * floats, fills the lookups: a cube whose levels are more and more blurred. */
#include "view/capture.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/process.h"
#include "common/signals.h"
#include "view/message.h"
#include "view/program.h"
#include "view/upload.h"

static const double near = 0.05;

/* Programs that fill a face. */
enum {
    FACE,
    PARABOLOID,
    MIP,
    BLUR,
    LOBE,
    PASSES
};

typedef struct pass {
    GLuint program;
    GLint face, edge, row, count, spread, rings;
} pass;

struct view_capture {
    view_probe_capture kind;
    int size, levels;
    pass pass[PASSES];
    view_image picture[2]; /* one for all faces, or one per paraboloid */
    GLuint depth;          /* of these */
    GLuint target, source; /* framebuffers: drawn to, read from */
    GLuint halved;         /* cube of half the edge, one level */
    GLuint lookup;         /* cube, blurred from level 1 on */
    GLuint samples;        /* as from view_capture_samples */
    int step;              /* index of the next one */
    double ms[VIEW_CAPTURE_PARTS];
};

/* Number of sides that are drawn. */
static int side_count(const view_capture *c)
{
    return c->kind == VIEW_PROBE_PARABOLOIDS ? 2 : IBL_FACES;
}

/* Number of pictures: faces share one. */
static int picture_count(const view_capture *c)
{
    return c->kind == VIEW_PROBE_PARABOLOIDS ? 2 : 1;
}

/* ---- cubes ------------------------------------------------------------- */

static void bind(int unit, GLuint cubes)
{
    view_gl_bind(unit, GL_TEXTURE_CUBE_MAP_ARRAY, cubes);
}

static void attach(GLenum framebuffer, GLuint cubes, int layer, int level,
                   int face)
{
    gl.FramebufferTextureLayer(framebuffer, GL_COLOR_ATTACHMENT0, cubes, level,
                               IBL_FACES * layer + face);
}

/* False: OpenGL has no memory. */
static bool make_cubes(GLuint *cubes, int size, int levels, int count)
{
    const GLenum target = GL_TEXTURE_CUBE_MAP_ARRAY;
    bool ok = true;

    gl.GenTextures(1, cubes);
    bind(VIEW_CAPTURE_UNIT, *cubes);
    for (int l = 0; l < levels && ok; l++) {
        const int n = ibl_cube_edge(size, l);
        gl.TexImage3D(target, l, GL_RGBA16F, n, n, IBL_FACES * count, 0,
                      GL_RGBA, GL_FLOAT, NULL);
        ok = gl.GetError() == GL_NO_ERROR;
    }
    view_gl_filter(target, GL_LINEAR, levels);
    return ok;
}

bool view_cubes_make(view_cubes *c, int size, int count)
{
    if (make_cubes(&c->specular, size, ibl_default_levels(size), count) &&
        make_cubes(&c->irradiance, VIEW_CAPTURE_IRRADIANCE, 1, count))
        return true;
    view_cubes_free(c);
    return false;
}

void view_cubes_free(view_cubes *c)
{
    gl.DeleteTextures(1, &c->irradiance);
    gl.DeleteTextures(1, &c->specular);
    *c = (view_cubes){0};
}

/* ---- passes ------------------------------------------------------------ */

/* Fills a face of a level of a cube, n x n texels, from the bound textures. */
static void fill(const view_capture *c, int which, GLuint cubes, int layer,
                 int level, int face, int n)
{
    const pass *p = &c->pass[which];

    gl.BindFramebuffer(GL_FRAMEBUFFER, c->target);
    attach(GL_FRAMEBUFFER, cubes, layer, level, face);
    gl.Viewport(0, 0, n, n);
    gl.UseProgram(p->program);
    gl.Uniform1i(p->face, face);
    gl.Uniform1f(p->edge, (float)n);
    view_gl_draw_full(p->program);
}

static bool make_passes(view_capture *c)
{
    static const char *const files[PASSES] = {
        [FACE] = "capture_face.frag", [PARABOLOID] = "capture_paraboloid.frag",
        [MIP] = "capture_mip.frag",   [BLUR] = "capture_blur.frag",
        [LOBE] = "capture_lobe.frag",
    };

    for (int i = 0; i < PASSES; i++) {
        pass *p = &c->pass[i];
        p->program = view_program("full.vert", files[i]);
        if (!p->program)
            return false;
        p->face = gl.GetUniformLocation(p->program, "face");
        p->edge = gl.GetUniformLocation(p->program, "edge");
        p->row = gl.GetUniformLocation(p->program, "row");
        p->count = gl.GetUniformLocation(p->program, "count");
        p->spread = gl.GetUniformLocation(p->program, "spread");
        p->rings = gl.GetUniformLocation(p->program, "rings");
    }
    return true;
}

/* ---- create and free --------------------------------------------------- */

static bool make_pictures(view_capture *c)
{
    const int n = picture_count(c) * c->size;

    gl.GenRenderbuffers(1, &c->depth);
    gl.BindRenderbuffer(GL_RENDERBUFFER, c->depth);
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, n, n);
    for (int i = 0; i < picture_count(c); i++) {
        if (!view_image_make(&c->picture[i], n, n))
            return false;
        view_gl_filter(GL_TEXTURE_2D, GL_LINEAR, 1);
        gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT,
                                   GL_RENDERBUFFER, c->depth);
    }
    return true;
}

static void make_samples(view_capture *c)
{
    float *all = view_capture_samples(c->size, c->levels);

    gl.ActiveTexture(GL_TEXTURE0 + VIEW_CAPTURE_UNIT_MORE);
    c->samples =
        view_float_image(GL_RGBA, VIEW_CAPTURE_MOST_SAMPLES, c->levels, all);
    free(all);
}

static bool make(view_capture *c)
{
    gl.GenFramebuffers(1, &c->target);
    gl.GenFramebuffers(1, &c->source);
    if (!make_passes(c) || !make_pictures(c))
        return false;
    if (!make_cubes(&c->halved, c->size / 2, 1, 1) ||
        !make_cubes(&c->lookup, c->size, view_capture_lookups(c->size), 1))
        return view_fail("this OpenGL has no room for the cubes of a capture");
    make_samples(c);
    return view_gl_check("making a capture");
}

view_capture *view_capture_create(view_probe_capture kind, int size)
{
    view_capture *c = ibl_need(calloc(1, sizeof *c));

    assert(size >= 16 && size <= 1024 && !(size & (size - 1)));
    c->kind = kind;
    c->size = size;
    c->levels = ibl_default_levels(size);
    if (make(c))
        return c;
    view_capture_free(c);
    return NULL;
}

void view_capture_free(view_capture *c)
{
    if (!c)
        return;
    const GLuint textures[] = {c->samples, c->lookup, c->halved};
    const GLuint framebuffers[] = {c->source, c->target};

    gl.DeleteTextures(3, textures);
    gl.DeleteFramebuffers(2, framebuffers);
    view_image_free(&c->picture[0]);
    view_image_free(&c->picture[1]);
    gl.DeleteRenderbuffers(1, &c->depth);
    for (int i = 0; i < PASSES; i++)
        gl.DeleteProgram(c->pass[i].program);
    free(c);
}

/* Binds the lookups and limits passes to their levels first..last. */
static void use_lookups(const view_capture *c, int first, int last)
{
    const GLenum target = GL_TEXTURE_CUBE_MAP_ARRAY;

    bind(VIEW_CAPTURE_UNIT, c->lookup);
    gl.TexParameteri(target, GL_TEXTURE_BASE_LEVEL, first);
    gl.TexParameteri(target, GL_TEXTURE_MAX_LEVEL, last);
}

/* ---- drawing the scene ------------------------------------------------- */

/* For each face: view direction, x axis (next column), y axis (next row).
 * OpenGL stores the lowest row of a picture first: it is the face's row 0. */
static const int faces[IBL_FACES][3][3] = {
    {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
    {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
    {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}},
};
/* The same for the paraboloids, upright, towards +Z and -Z. */
static const int paraboloids[2][3][3] = {
    {{0, 0, 1}, {-1, 0, 0}, {0, 1, 0}},
    {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}},
};

/* Sets a row of a column-major matrix: scale * (axis . (p - eye)) + add. */
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

/* bent: for shaders/paraboloid.glsl, distances in units of far. */
static void set_clip(const view_capture_shot *s, const int axes[3][3],
                     bool bent, double clip[16])
{
    static const int none[3];
    const double far = s->far, *eye = s->draw.eye;
    const double unit = bent ? 1 / far : 1;

    set_row(clip, 0, axes[1], eye, unit, 0);
    set_row(clip, 1, axes[2], eye, unit, 0);
    if (bent) {
        set_row(clip, 2, axes[0], eye, unit, 0);
        set_row(clip, 3, none, eye, 0, near / far);
    } else {
        set_row(clip, 2, axes[0], eye, (far + near) / (far - near),
                -2 * far * near / (far - near));
        set_row(clip, 3, axes[0], eye, 1, 0);
    }
}

static void draw(const view_capture *c, const view_capture_shot *shot,
                 int index)
{
    const bool two = picture_count(c) == 2;
    const int n = picture_count(c) * c->size;
    view_room_draw d = shot->draw;

    d.paraboloid = two;
    set_clip(shot, two ? paraboloids[index] : faces[index], two, d.clip);
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->picture[two ? index : 0].framebuffer);
    gl.Viewport(0, 0, n, n);
    view_room_render(shot->room, &d);
    if (two)
        return;
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_2D, c->picture[0].texture);
    fill(c, FACE, c->lookup, 0, 0, index, n);
}

/* ---- lookups ----------------------------------------------------------- */

static void resample(const view_capture *c)
{
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_2D, c->picture[0].texture);
    view_gl_bind(VIEW_CAPTURE_UNIT_MORE, GL_TEXTURE_2D, c->picture[1].texture);
    for (int f = 0; f < IBL_FACES; f++)
        fill(c, PARABOLOID, c->lookup, 0, 0, f, c->size);
}

/* Copies level 0 of the lookups to level 0 of the shot's cube. */
static void copy(const view_capture *c, const view_capture_shot *shot)
{
    const int n = c->size;

    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, c->source);
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, c->target);
    for (int f = 0; f < IBL_FACES; f++) {
        attach(GL_READ_FRAMEBUFFER, c->lookup, 0, 0, f);
        attach(GL_DRAW_FRAMEBUFFER, shot->to->specular, shot->layer, 0, f);
        gl.BlitFramebuffer(0, 0, n, n, 0, 0, n, n, GL_COLOR_BUFFER_BIT,
                           GL_NEAREST);
    }
}

/* Makes a level of the lookups from the bound source, so that lookups have the
 * variance VIEW_CAPTURE_BLUR everywhere. The blur adds what is missing. Already
 * there, in texels of this level: 1/6 of a texel of that place, by
 * interpolation; from level - 1 a quarter of the whole; from the halved cube
 * 1/6 by interpolation and 3/16 - 1/48 by halving. */
static void blur(const view_capture *c, int level)
{
    const pass *p = &c->pass[BLUR];
    const int n = c->size >> level;
    const double mean = 4 * M_PI / (6.0 * n * n);
    const double middle = 4.0 / n / n; /* the solid angle there */
    const bool first = level == 1;
    const double all = VIEW_CAPTURE_BLUR * mean * (first ? 1 : 0.75);

    gl.UseProgram(p->program);
    gl.Uniform2f(p->spread, (float)all,
                 (float)(middle * (first ? 0.5 : 1.0 / 6)));
    gl.Uniform1i(p->rings, first ? 2 : 3);
    for (int f = 0; f < IBL_FACES; f++)
        fill(c, BLUR, c->lookup, 0, level, f, n);
}

static void make_lookups(const view_capture *c)
{
    const int last = view_capture_lookups(c->size) - 1;

    use_lookups(c, 0, 0);
    for (int f = 0; f < IBL_FACES; f++)
        fill(c, MIP, c->halved, 0, 0, f, c->size / 2);
    bind(VIEW_CAPTURE_UNIT, c->halved);
    blur(c, 1);
    for (int level = 2; level <= last; level++) {
        use_lookups(c, level - 1, level - 1);
        blur(c, level);
    }
    use_lookups(c, 0, last);
}

/* level c->levels: irradiance. */
static void filter(const view_capture *c, const view_capture_shot *shot,
                   int level, int face)
{
    const pass *p = &c->pass[LOBE];
    const bool diffuse = level == c->levels;

    bind(VIEW_CAPTURE_UNIT, c->lookup);
    view_gl_bind(VIEW_CAPTURE_UNIT_MORE, GL_TEXTURE_2D, c->samples);
    gl.UseProgram(p->program);
    gl.Uniform1i(p->row, level - 1);
    gl.Uniform1i(p->count,
                 diffuse ? VIEW_CAPTURE_MOST_SAMPLES : VIEW_CAPTURE_SAMPLES);
    if (diffuse)
        fill(c, LOBE, shot->to->irradiance, shot->layer, 0, face,
             VIEW_CAPTURE_IRRADIANCE);
    else
        fill(c, LOBE, shot->to->specular, shot->layer, level, face,
             ibl_cube_edge(c->size, level));
}

/* ---- updates ----------------------------------------------------------- */

static int step_count(const view_capture *c)
{
    return side_count(c) + 1 + IBL_FACES * c->levels;
}

/* Returns the part that the step's time counts for. */
static int do_step(const view_capture *c, const view_capture_shot *shot)
{
    const int index = c->step - side_count(c);

    if (index < 0) {
        draw(c, shot, c->step);
        return VIEW_CAPTURE_DRAWING;
    }
    if (index > 0) {
        const int level = 1 + (index - 1) / IBL_FACES;
        filter(c, shot, level, (index - 1) % IBL_FACES);
        return level == c->levels ? VIEW_CAPTURE_DIFFUSE : VIEW_CAPTURE_LEVELS;
    }
    if (c->kind == VIEW_PROBE_PARABOLOIDS)
        resample(c);
    copy(c, shot);
    make_lookups(c);
    return VIEW_CAPTURE_LEVELS;
}

static void timed_step(view_capture *c, const view_capture_shot *shot)
{
    const double started = ibl_now();
    const int part = do_step(c, shot);

    if (shot->timed)
        gl.Finish();
    c->ms[part] += 1e3 * (ibl_now() - started);
    c->step++;
}

view_capture_state view_capture_update(view_capture *c,
                                       const view_capture_shot *shot, int steps)
{
    const int all = step_count(c);

    if (!steps)
        c->step = 0;
    if (!c->step)
        memset(c->ms, 0, sizeof c->ms);
    const int end = steps && c->step + steps < all ? c->step + steps : all;
    while (c->step < end)
        timed_step(c, shot);
    gl.UseProgram(0);
    gl.ActiveTexture(GL_TEXTURE0);
    if (c->step < all)
        return VIEW_CAPTURE_BEGUN;
    c->step = 0;
    return view_gl_check("a capture") ? VIEW_CAPTURE_DONE : VIEW_CAPTURE_FAILED;
}

const double *view_capture_times(const view_capture *c)
{
    return c->ms;
}
