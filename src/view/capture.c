/* SPDX-License-Identifier: MIT */
/* An update is a row of steps, each of which fills one face of a cube that is
 * not shown. The scene draws into a picture of floats. That goes, cut to the
 * range of halves, into the lookups: a cube with levels, each more blurred. */
#include "view/capture.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view/capture_samples.h"
#include "view/clock.h"
#include "view/message.h"
#include "view/program.h"
#include "view/upload.h"

/* The parts of an update whose times are kept. */
enum {
    DRAWING,
    LEVELS,
    DIFFUSE,
    PARTS
};

/* Programs that fill a face. */
enum {
    FACE,
    PARABOLOID,
    MIP,
    BLUR,
    LOBE,
    EQUIRECT,
    PASSES
};

typedef struct pass {
    GLuint program;
    GLint face, edge, row, count, spread, rings;
} pass;

typedef struct cubes {
    GLuint specular, irradiance;
} cubes;

struct view_capture {
    view_capture_options options; /* levels resolved */
    pass pass[PASSES];
    GLuint picture[2];      /* RGBA32F: one, or two paraboloids */
    GLuint depth, drawn[2]; /* their depth, framebuffers */
    GLuint target, source;  /* framebuffers of what is drawn and copied */
    GLuint halved;          /* cube of half the edge, one level */
    GLuint lookup;          /* cube with blurred levels from 1 on */
    GLuint samples;         /* as view_capture_samples has them */
    cubes set[2];
    int shown; /* of the sets */
    int step;  /* that is next */
    bool failed;
    double position[3];
    double doing[PARTS], ms[PARTS];
};

view_capture_options view_capture_options_default(void)
{
    return (view_capture_options){.kind = VIEW_PROBE_FACES,
                                  .size = 256,
                                  .samples = 64,
                                  .near = 0.05,
                                  .far = 100};
}

static bool paraboloids(const view_capture *c)
{
    return c->options.kind == VIEW_PROBE_PARABOLOIDS;
}

static int sides(const view_capture *c)
{
    return paraboloids(c) ? 2 : 1;
}

/* Edge of what the scene draws. */
static int picture_edge(const view_capture *c)
{
    return sides(c) * c->options.size;
}

/* ---- passes ------------------------------------------------------------ */

/* The state of OpenGL that is another's, from begin to end. */
typedef struct kept_state {
    GLint framebuffer, viewport[4];
} kept_state;

static kept_state begin(void)
{
    kept_state s = {0};

    gl.GetIntegerv(GL_FRAMEBUFFER_BINDING, &s.framebuffer);
    gl.GetIntegerv(GL_VIEWPORT, s.viewport);
    gl.Enable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    return s;
}

static void end(const kept_state *s)
{
    gl.BindFramebuffer(GL_FRAMEBUFFER, (GLuint)s->framebuffer);
    gl.Viewport(s->viewport[0], s->viewport[1], s->viewport[2], s->viewport[3]);
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    gl.UseProgram(0);
    gl.ActiveTexture(GL_TEXTURE0);
}

static void attach(GLenum framebuffer, GLuint cube, int level, int face)
{
    gl.FramebufferTexture2D(framebuffer, GL_COLOR_ATTACHMENT0,
                            view_gl_face(face), cube, level);
}

/* Fills a face of a level of a cube, n x n, from the bound captures units. */
static void fill(const view_capture *c, int which, GLuint cube, int level,
                 int face, int n)
{
    const pass *p = &c->pass[which];

    gl.BindFramebuffer(GL_FRAMEBUFFER, c->target);
    attach(GL_FRAMEBUFFER, cube, level, face);
    gl.Viewport(0, 0, n, n);
    gl.UseProgram(p->program);
    gl.Uniform1i(p->face, face);
    gl.Uniform1f(p->edge, (float)n);
    view_gl_draw_full(p->program);
}

static bool make_passes(view_capture *c)
{
    const GLuint programs[PASSES] = {
        [FACE] = view_program("full.vert", "capture_face.frag"),
        [PARABOLOID] = view_program("full.vert", "capture_paraboloid.frag"),
        [MIP] = view_program("full.vert", "capture_mip.frag"),
        [BLUR] = view_program("full.vert", "capture_blur.frag"),
        [LOBE] = view_program("full.vert", "capture_lobe.frag"),
        [EQUIRECT] = view_program("full.vert", "capture_equirect.frag"),
    };
    bool ok = true;

    for (int i = 0; i < PASSES; i++) {
        pass *p = &c->pass[i];
        p->program = programs[i];
        ok = ok && p->program;
        p->face = gl.GetUniformLocation(p->program, "face");
        p->edge = gl.GetUniformLocation(p->program, "edge");
        p->row = gl.GetUniformLocation(p->program, "row");
        p->count = gl.GetUniformLocation(p->program, "count");
        p->spread = gl.GetUniformLocation(p->program, "spread");
        p->rings = gl.GetUniformLocation(p->program, "rings");
    }
    return ok;
}

/* ---- life -------------------------------------------------------------- */

/* Black. */
static GLuint make_cube(const view_capture *c, int size, int levels)
{
    GLuint cube = 0;

    gl.GenTextures(1, &cube);
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, cube);
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->target);
    gl.ClearColor(0, 0, 0, 0);
    for (int i = 0; i < levels * IBL_FACES; i++) {
        const int level = i / IBL_FACES, n = ibl_cube_edge(size, level);
        gl.TexImage2D(view_gl_face(i % IBL_FACES), level, GL_RGBA16F, n, n, 0,
                      GL_RGBA, GL_FLOAT, NULL);
    }
    view_gl_filter(GL_TEXTURE_CUBE_MAP, GL_LINEAR, levels);
    for (int i = 0; i < levels * IBL_FACES; i++) {
        attach(GL_FRAMEBUFFER, cube, i / IBL_FACES, i % IBL_FACES);
        gl.Clear(GL_COLOR_BUFFER_BIT);
    }
    return cube;
}

static bool make_pictures(view_capture *c)
{
    const int n = picture_edge(c);

    gl.GenFramebuffers(sides(c), c->drawn);
    gl.GenRenderbuffers(1, &c->depth);
    gl.BindRenderbuffer(GL_RENDERBUFFER, c->depth);
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, n, n);
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_CAPTURE_UNIT);
    for (int i = 0; i < sides(c); i++) {
        c->picture[i] = view_float_target(n, n);
        view_gl_filter(GL_TEXTURE_2D, GL_LINEAR, 1);
        gl.BindFramebuffer(GL_FRAMEBUFFER, c->drawn[i]);
        gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT,
                                   GL_RENDERBUFFER, c->depth);
        if (!view_gl_target(c->drawn[i], c->picture[i]))
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
    return gl.CheckFramebufferStatus(GL_FRAMEBUFFER) ==
               GL_FRAMEBUFFER_COMPLETE ||
           view_fail("OpenGL does not draw into cubes of halves");
}

static bool make_samples(view_capture *c)
{
    const view_capture_options *o = &c->options;
    float *all = view_capture_samples(o->size, o->levels, o->samples);

    if (!all)
        return false;
    gl.GenTextures(1, &c->samples);
    view_gl_bind(VIEW_CAPTURE_UNIT_MORE, GL_TEXTURE_2D, c->samples);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F,
                  view_capture_diffuse_samples(o->samples), o->levels, 0,
                  GL_RGBA, GL_FLOAT, all);
    view_gl_filter(GL_TEXTURE_2D, GL_NEAREST, 1);
    free(all);
    return true;
}

view_capture *view_capture_create(const view_capture_options *options)
{
    const int size = options->size;
    view_capture *c = calloc(1, sizeof *c);

    assert(size >= 16 && size <= 1024 && !(size & (size - 1)));
    if (!c) {
        view_fail("no memory for a capture");
        return NULL;
    }
    c->options = *options;
    if (!c->options.levels)
        c->options.levels = ibl_default_levels(size);
    const kept_state state = begin();
    const bool ok = make_passes(c) && make_pictures(c) && make_cubes(c) &&
                    make_samples(c) && view_gl_check("the cubes of a capture");
    end(&state);
    if (ok)
        return c;
    view_capture_free(c);
    return NULL;
}

void view_capture_free(view_capture *c)
{
    if (!c)
        return;
    const GLuint textures[] = {
        c->samples,           c->lookup,          c->halved,
        c->picture[0],        c->picture[1],      c->set[0].specular,
        c->set[0].irradiance, c->set[1].specular, c->set[1].irradiance};
    const GLuint framebuffers[] = {c->source, c->target, c->drawn[0],
                                   c->drawn[1]};

    gl.DeleteTextures(sizeof textures / sizeof *textures, textures);
    gl.DeleteFramebuffers(4, framebuffers);
    gl.DeleteRenderbuffers(1, &c->depth);
    for (int i = 0; i < PASSES; i++)
        gl.DeleteProgram(c->pass[i].program);
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
            gl.GetTexImage(view_gl_face(f), l, GL_RGB, GL_FLOAT,
                           ibl_cube_face(cube, l, f));
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

/* ---- through the library ----------------------------------------------- */

/* The cube's mean over each pixel of a map: 4 floats a pixel; free() it. */
static float *read_equirect(const view_capture *c, GLuint cube, int width,
                            int height)
{
    float *rgba = malloc((size_t)width * height * 4 * sizeof *rgba);

    if (!rgba) {
        view_fail("no memory for a capture's map of %d x %d pixels", width,
                  height);
        return NULL;
    }
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_CAPTURE_UNIT_MORE);
    const GLuint map = view_float_target(width, height);
    view_gl_target(c->target, map);
    gl.Viewport(0, 0, width, height);
    gl.UseProgram(c->pass[EQUIRECT].program);
    gl.Uniform1f(c->pass[EQUIRECT].edge, (float)height);
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, cube);
    view_gl_draw_full(c->pass[EQUIRECT].program);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, rgba);
    view_gl_target(c->target, 0);
    gl.DeleteTextures(1, &map);
    return rgba;
}

/* Levels from first on. alpha without texels: 1. */
static bool upload(const ibl_cube *rgb, const ibl_cube *alpha, int first,
                   GLuint cube)
{
    const size_t most = (size_t)rgb->size * rgb->size;
    const float largest = ibl_pixel_max(IBL_PIXEL_RGBA16F);
    float *rgba = malloc(4 * most * sizeof *rgba);

    if (!rgba)
        return view_fail("no memory for a level of a capture");
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, cube);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    for (int l = first; l < rgb->levels; l++)
        for (int f = 0; f < IBL_FACES; f++) {
            const int n = ibl_cube_edge(rgb->size, l);
            const float *from = ibl_cube_face(rgb, l, f);
            const float *a = alpha->data ? ibl_cube_face(alpha, l, f) : NULL;
            for (int i = 0; i < n * n; i++) {
                for (int k = 0; k < 3; k++)
                    rgba[4 * i + k] = fminf(from[3 * i + k], largest);
                rgba[4 * i + 3] = a ? fminf(a[3 * i], 1) : 1;
            }
            gl.TexImage2D(view_gl_face(f), l, GL_RGBA16F, n, n, 0, GL_RGBA,
                          GL_FLOAT, rgba);
        }
    free(rgba);
    return true;
}

/* The colours, or alpha as a map of greys. */
static void take(const float *rgba, bool alpha, ibl_image *map)
{
    for (size_t i = 0; i < (size_t)map->width * map->height; i++)
        for (int k = 0; k < 3; k++)
            map->data[3 * i + k] = rgba[4 * i + (alpha ? 3 : k)];
}

static bool whole(const float *rgba, size_t pixels)
{
    for (size_t i = 0; i < pixels; i++)
        if (rgba[4 * i + 3] < 0.999F) /* more than rounding */
            return false;
    return true;
}

static bool bake(const view_capture *c, ibl_ctx *ctx, const ibl_image *map,
                 ibl_bake_result *result)
{
    const ibl_environment env = {.image = map};
    ibl_bake_options opts = ibl_bake_options_default();

    opts.specular_options.size = c->options.size;
    opts.specular_options.levels = c->options.levels;
    opts.irradiance_options.size = VIEW_CAPTURE_IRRADIANCE;
    opts.sh_degree = -1;
    return !ibl_bake_environment(ctx, &env, &opts, result);
}

/* Filters level 0 of a set into its other levels and its irradiance; the
 * library takes equirectangular maps. False, with a message, and they are as
 * they were. */
static bool filter_by_library(view_capture *c, ibl_ctx *ctx, const cubes *set)
{
    const int width = 4 * c->options.size, height = 2 * c->options.size;
    ibl_bake_result rgb = {0}, alpha = {0};
    ibl_image map = {0};

    float *rgba = read_equirect(c, set->specular, width, height);
    bool ok = rgba && !ibl_image_alloc(ctx, width, height, &map);
    if (ok) {
        take(rgba, false, &map);
        ok = bake(c, ctx, &map, &rgb);
    }
    if (ok && !whole(rgba, (size_t)width * height)) {
        take(rgba, true, &map);
        ok = bake(c, ctx, &map, &alpha);
    }
    ok = ok && upload(&rgb.specular, &alpha.specular, 1, set->specular) &&
         upload(&rgb.irradiance, &alpha.irradiance, 0, set->irradiance);
    ibl_bake_result_free(&alpha);
    ibl_bake_result_free(&rgb);
    ibl_image_free(&map);
    free(rgba);
    return ok;
}

/* ---- drawing the scene ------------------------------------------------- */

/* Of each face: where it looks, where its columns and rows go. Pictures of an
 * ordinary camera begin below, and so draw the first row first. */
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

static void draw(view_capture *c, int index, view_capture_scene *scene,
                 void *cookie)
{
    const bool two = paraboloids(c);
    const int n = picture_edge(c);
    double clip[16];

    (two ? half_clip : face_clip)(c, index, clip);
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->drawn[two ? index : 0]);
    gl.Viewport(0, 0, n, n);
    gl.ClearColor(0, 0, 0, 0);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    gl.Enable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    gl.ActiveTexture(GL_TEXTURE0);
    scene(cookie, clip, c->position, n, two ? index : -1);
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    if (two)
        return;
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_2D, c->picture[0]);
    fill(c, FACE, c->lookup, 0, index, n);
}

/* ---- lookups ----------------------------------------------------------- */

static void resample(view_capture *c)
{
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_2D, c->picture[0]);
    view_gl_bind(VIEW_CAPTURE_UNIT_MORE, GL_TEXTURE_2D, c->picture[1]);
    for (int f = 0; f < IBL_FACES; f++)
        fill(c, PARABOLOID, c->lookup, 0, f, c->options.size);
}

/* The set that is not shown. */
static const cubes *back(const view_capture *c)
{
    return &c->set[!c->shown];
}

/* Level 0 of the set: the texels of the lookups. */
static void copy(view_capture *c)
{
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, c->source);
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, c->target);
    for (int f = 0; f < IBL_FACES; f++) {
        attach(GL_READ_FRAMEBUFFER, c->lookup, 0, f);
        attach(GL_DRAW_FRAMEBUFFER, back(c)->specular, 0, f);
        view_gl_copy(c->options.size);
    }
}

/* Binds the lookups, of which passes see levels first to last. */
static void use_lookups(const view_capture *c, int first, int last)
{
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, c->lookup);
    gl.TexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_BASE_LEVEL, first);
    gl.TexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_MAX_LEVEL, last);
}

/* Makes a level of the lookups from the bound source, so that a lookup has the
 * variance VIEW_CAPTURE_BLUR everywhere. The blur adds what is missing: not the
 * step between texels, 1/6 of one as large as it is there, and not the variance
 * of lookups in the source. That is a quarter of the whole in the level above.
 * In the halved cube it is 1/6, and 3/16 less 1/48 from the first texels to the
 * halved ones. */
static void blur(const view_capture *c, int level)
{
    const pass *p = &c->pass[BLUR];
    const int n = c->options.size >> level;
    const double mean = 4 * M_PI / (6.0 * n * n);
    const double middle = 4.0 / n / n; /* of the solid angles there */
    const bool first = level == 1;
    const double all = VIEW_CAPTURE_BLUR * mean * (first ? 1 : 0.75);

    gl.UseProgram(p->program);
    gl.Uniform2f(p->spread, (float)all,
                 (float)(middle * (first ? 0.5 : 1.0 / 6)));
    gl.Uniform1i(p->rings, first ? 2 : 3);
    for (int f = 0; f < IBL_FACES; f++)
        fill(c, BLUR, c->lookup, level, f, n);
}

static void make_lookups(view_capture *c)
{
    const int last = view_capture_lookups(c->options.size) - 1;

    use_lookups(c, 0, 0);
    for (int f = 0; f < IBL_FACES; f++)
        fill(c, MIP, c->halved, 0, f, c->options.size / 2);
    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, c->halved);
    blur(c, 1);
    for (int level = 2; level <= last; level++) {
        use_lookups(c, level - 1, level - 1);
        blur(c, level);
    }
    use_lookups(c, 0, last);
}

/* level options.levels: irradiance. */
static void filter(view_capture *c, int level, int face)
{
    const pass *p = &c->pass[LOBE];
    const bool diffuse = level == c->options.levels;
    const int samples = c->options.samples;

    view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_CUBE_MAP, c->lookup);
    view_gl_bind(VIEW_CAPTURE_UNIT_MORE, GL_TEXTURE_2D, c->samples);
    gl.UseProgram(p->program);
    gl.Uniform1i(p->row, level - 1);
    gl.Uniform1i(p->count,
                 diffuse ? view_capture_diffuse_samples(samples) : samples);
    if (diffuse)
        fill(c, LOBE, back(c)->irradiance, 0, face, VIEW_CAPTURE_IRRADIANCE);
    else
        fill(c, LOBE, back(c)->specular, level, face,
             ibl_cube_edge(c->options.size, level));
}

/* ---- updates ----------------------------------------------------------- */

int view_capture_draws(const view_capture *c)
{
    return paraboloids(c) ? 2 : IBL_FACES;
}

int view_capture_steps(const view_capture *c)
{
    return view_capture_draws(c) + 1 +
           (c->options.cpu ? 0 : IBL_FACES * c->options.levels);
}

/* The part that its time counts to; -1: it failed. */
static int do_step(view_capture *c, view_capture_scene *scene, void *cookie)
{
    const int index = c->step - view_capture_draws(c);

    if (index < 0) {
        draw(c, c->step, scene, cookie);
        return DRAWING;
    }
    if (index > 0) {
        const int level = 1 + (index - 1) / IBL_FACES;
        filter(c, level, (index - 1) % IBL_FACES);
        return level == c->options.levels ? DIFFUSE : LEVELS;
    }
    if (paraboloids(c))
        resample(c);
    copy(c);
    if (!c->options.cpu)
        make_lookups(c);
    else if (!filter_by_library(c, c->options.cpu, back(c)))
        return -1;
    return LEVELS;
}

static bool timed_step(view_capture *c, view_capture_scene *scene, void *cookie)
{
    const double started = view_clock();
    const int part = do_step(c, scene, cookie);

    if (part < 0)
        return false;
    if (c->options.timed)
        gl.Finish();
    c->doing[part] += 1e3 * (view_clock() - started);
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
    const kept_state state = begin();
    const int all = view_capture_steps(c);
    bool ok = true;

    if (!c->step)
        memcpy(c->position, position, sizeof c->position);
    for (int i = 0; i < steps && c->step < all && ok; i++)
        ok = timed_step(c, scene, cookie);
    if (!ok)
        view_capture_restart(c);
    const bool done = c->step == all;
    end(&state);
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
    const kept_state state = begin();
    const double started = view_clock();

    view_capture_restart(c);
    const bool ok = filter_by_library(c, ctx, &c->set[c->shown]);
    if (ok && c->options.timed)
        gl.Finish();
    if (ok) {
        c->ms[LEVELS] = 1e3 * (view_clock() - started);
        c->ms[DIFFUSE] = 0;
    }
    end(&state);
    return view_gl_check("a capture that the library filters") && ok;
}
