/* SPDX-License-Identifier: MIT */
/* The room is drawn as floats. The picture, clamped to the range of half
 * floats, fills the lookups: a cube whose levels are more and more blurred. */
#include "view/room.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "view/gl.h"
#include "view/message.h"

/* Programs that fill a face. */
enum {
    FACE,
    PARABOLOID,
    BLUR,
    LOBE,
    PASSES
};

/* A level of a cube in an array that a pass fills. */
typedef struct cube_level {
    GLuint cubes;
    int layer, level, edge;
} cube_level;

struct view_capture {
    view_probe_capture kind;
    int size, levels;
    GLuint program[PASSES];
    GLint at[PASSES];      /* the uniform of each */
    view_image picture[2]; /* one for all faces, or one per paraboloid */
    GLuint framebuffer;
    GLuint lookup;  /* cube of a level more, blurred from level 1 on */
    GLuint samples; /* as from make_samples */
};

/* ---- cubes ------------------------------------------------------------- */

/* False: OpenGL has no memory. */
static bool make_cubes(GLuint *cubes, int size, int levels, int count)
{
    const GLenum target = GL_TEXTURE_CUBE_MAP_ARRAY;
    bool ok = true;

    gl.GenTextures(1, cubes);
    view_gl_bind(VIEW_CAPTURE_UNIT, target, *cubes);
    for (int l = 0; l < levels && ok; l++) {
        const int n = ibl_cube_edge(size, l);
        gl.TexImage3D(target, l, GL_RGBA16F, n, n, IBL_FACES * count, 0,
                      GL_RGBA, GL_FLOAT, NULL);
        ok = gl.GetError() == GL_NO_ERROR;
    }
    view_gl_filter(target, GL_LINEAR, levels);
    return ok;
}

bool view_probe_maps_make(view_probe_maps *m, int size, int count)
{
    const int levels = ibl_default_levels(size);

    *m = (view_probe_maps){.lod = {(float)(levels - 1), 0, (float)(levels - 1)},
                           .irradiance_scale = 1};
    if (make_cubes(&m->specular, size, levels, count) &&
        make_cubes(&m->irradiance, VIEW_CAPTURE_IRRADIANCE, 1, count))
        return true;
    view_probe_maps_free(m);
    return false;
}

void view_probe_maps_free(view_probe_maps *m)
{
    gl.DeleteTextures(1, &m->irradiance);
    gl.DeleteTextures(1, &m->specular);
    *m = (view_probe_maps){0};
}

/* ---- passes ------------------------------------------------------------ */

/* Fills a face, -1: all, from the bound textures. */
static void fill(const view_capture *c, int pass, cube_level to, int face,
                 double x, double y)
{
    gl.BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer);
    gl.Viewport(0, 0, to.edge, to.edge);
    for (int i = 0; i < IBL_FACES; i++) {
        if (face >= 0 && face != i)
            continue;
        gl.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                                   to.cubes, to.level,
                                   IBL_FACES * to.layer + i);
        gl.UseProgram(c->program[pass]);
        gl.Uniform4f(c->at[pass], (float)i, (float)to.edge, (float)x, (float)y);
        view_gl_draw_full(c->program[pass]);
    }
}

/* ---- samples ------------------------------------------------------------ */

/*
 * Sample sets of filtered levels. Points cover the GGX half vectors whose
 * reflection is above the horizon (Walter et al. 2007, eq. 35, 36); each turns
 * by the golden angle from the one before, and counts by N.L (Karis 2013). Each
 * looks up the environment, blurred by the solid angle that the point stands
 * for (Krivanek and Colbert 2008).
 */

/* Samples for each texel: of a level, and of irradiance, whose small cube must
 * be as accurate as a level. */
enum {
    SAMPLES = 64,
    MOST_SAMPLES = 128
};

/* Variance along an axis of a lookup in a level from 1 on, in mean solid angles
 * of a texel: wide enough to hide that texel sizes vary 5-fold. */
static const double blur_variance = 5.0 / 3;

/* Turn from one point to the next: the golden ratio - 1. */
static const double golden = 0.6180339887498949;

/* Fills samples with x, y of a direction about +Z, weight and level of each
 * point. */
static void place_points(double alpha, int count, int size, float *samples)
{
    const double a2 = alpha * alpha, part = 1 / (1 + a2);
    const double texel = 4 * M_PI / (6.0 * size * size); /* of level 0, in sr */
    /* Lookups in level 0 show its texels. Level 1 must do where it is narrow
     * enough for the lobe. */
    const double least = 4 * blur_variance * texel < a2;
    const double most = ibl_default_levels(size);
    double sum = 0;

    for (int i = 0; i < count; i++) {
        const double u = (i + 0.5) / count * part;
        const double s2 = a2 * u, c2 = 1 - u;
        const double sin_h = sqrt(s2 / (s2 + c2)), cos_h = sqrt(c2 / (s2 + c2));
        const double t = sin_h * sin_h + a2 * cos_h * cos_h;
        const double pdf = a2 / (M_PI * t * t) / (4 * part);
        /* A quarter of the point's solid angle: less shows single points, more
         * widens the lobe. */
        const double variance = 0.25 / (count * pdf);
        const double lod = 0.5 * log2(variance / (blur_variance * texel));
        const double angle = 2 * atan2(sin_h, cos_h);
        const double phi = 2 * M_PI * fmod(i * golden, 1);
        samples[4 * i] = (float)(sin(angle) * cos(phi));
        samples[4 * i + 1] = (float)(sin(angle) * sin(phi));
        samples[4 * i + 2] = (float)cos(angle);
        samples[4 * i + 3] = (float)fmin(fmax(lod, least), most);
        sum += cos(angle);
    }
    for (int i = 0; i < count; i++)
        samples[4 * i + 2] /= (float)sum;
}

/* A row for each level; the first for irradiance: of roughness 1 it is N.L. */
static void make_samples(view_capture *c)
{
    const size_t row = (size_t)4 * MOST_SAMPLES;
    float *all = ibl_need(calloc((size_t)c->levels, row * sizeof *all));

    for (int l = 0; l < c->levels; l++) {
        const double r =
            l ? ibl_level_roughness(IBL_ROUGHNESS_LINEAR, l, c->levels) : 1;
        place_points(r * r, l ? SAMPLES : MOST_SAMPLES, c->size,
                     all + row * (size_t)l);
    }
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_CAPTURE_UNIT_MORE);
    c->samples = view_float_image(GL_RGBA, MOST_SAMPLES, c->levels, all);
    free(all);
}

/* ---- create and free --------------------------------------------------- */

view_capture *view_capture_create(view_probe_capture kind, int size)
{
    static const char *const defines[PASSES] = {
        "#define FACE\n", "#define PARABOLOID\n", "#define BLUR\n",
        "#define LOBE\n"};
    view_capture *c = ibl_need(calloc(1, sizeof *c));
    const int pictures = kind == VIEW_PROBE_PARABOLOIDS ? 2 : 1;
    bool ok = true;

    assert(size >= 16 && size <= 1024 && !(size & (size - 1)));
    c->kind = kind;
    c->size = size;
    c->levels = ibl_default_levels(size);
    for (int i = 0; i < pictures; i++) {
        ok = ok &&
             view_image_make(&c->picture[i], pictures * size, pictures * size);
        view_gl_filter(GL_TEXTURE_2D, GL_LINEAR, 1);
    }
    gl.GenFramebuffers(1, &c->framebuffer);
    for (int i = 0; i < PASSES && ok; i++) {
        c->program[i] = view_program_from(view_shader_files, defines[i],
                                          "full.vert", "capture.frag");
        c->at[i] = gl.GetUniformLocation(c->program[i], "target");
        ok = c->program[i];
    }
    if (ok && !make_cubes(&c->lookup, size, c->levels + 1, 1))
        ok = view_fail("this OpenGL has no room for the cubes of a capture");
    make_samples(c);
    if (ok && view_gl_check("making a capture"))
        return c;
    view_capture_free(c);
    return NULL;
}

void view_capture_free(view_capture *c)
{
    if (!c)
        return;
    const GLuint textures[] = {c->samples, c->lookup};

    gl.DeleteTextures(2, textures);
    gl.DeleteFramebuffers(1, &c->framebuffer);
    view_image_free(&c->picture[0]);
    view_image_free(&c->picture[1]);
    for (int i = 0; i < PASSES; i++)
        gl.DeleteProgram(c->program[i]);
    free(c);
}

/* ---- updates ----------------------------------------------------------- */

/* For each face, then for the paraboloids towards +Z and -Z, which are upright:
 * view direction, x axis (next column), y axis (next row). OpenGL stores the
 * lowest row of a picture first: it is the face's row 0. */
static const int axes[IBL_FACES + 2][3][3] = {
    {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
    {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
    {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}},
    {{0, 0, 1}, {-1, 0, 0}, {0, 1, 0}},  {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}},
};

/* Binds the lookups and limits passes to their levels first..last. */
static void use_lookups(const view_capture *c, int first, int last)
{
    const GLenum target = GL_TEXTURE_CUBE_MAP_ARRAY;

    view_gl_bind(VIEW_CAPTURE_UNIT, target, c->lookup);
    gl.TexParameteri(target, GL_TEXTURE_BASE_LEVEL, first);
    gl.TexParameteri(target, GL_TEXTURE_MAX_LEVEL, last);
}

void view_capture_update(view_capture *c, view_room *room,
                         const view_room_draw *draw, const view_probe_maps *to,
                         int layer)
{
    const bool two = c->kind == VIEW_PROBE_PARABOLOIDS;
    const cube_level sharp[2] = {{c->lookup, 0, 0, c->size},
                                 {to->specular, layer, 0, c->size}};
    view_room_draw d = *draw;

    d.paraboloid = two;
    for (int i = 0; i < (two ? 2 : IBL_FACES); i++) {
        const int(*axis)[3] = axes[two ? IBL_FACES + i : i];
        for (int k = 0; k < 3; k++) {
            d.camera.forward[k] = axis[0][k];
            d.camera.right[k] = axis[1][k];
            d.camera.up[k] = axis[2][k];
        }
        if (!view_room_render(room, &d, &c->picture[two ? i : 0]))
            return;
        view_gl_bind(VIEW_CAPTURE_UNIT, GL_TEXTURE_2D, c->picture[0].texture);
        view_gl_bind(VIEW_CAPTURE_UNIT_AWAY, GL_TEXTURE_2D,
                     c->picture[1].texture);
        for (int k = 0; k < 2 && !two; k++)
            fill(c, FACE, sharp[k], i, 0, 0);
    }
    for (int k = 0; k < 2 && two; k++)
        fill(c, PARABOLOID, sharp[k], -1, 0, 0);
    /* Each level of the lookups from the one before, so that they have the
     * variance blur_variance everywhere. The blur adds what is missing. Already
     * there: 1/6 of a texel of that place, by interpolation, and from level 1
     * on a quarter of the whole. */
    for (int l = 1; l <= c->levels; l++) {
        const int n = c->size >> l;
        const double mean = 4 * M_PI / (6.0 * n * n);
        const double middle = 4.0 / n / n; /* the solid angle there */
        use_lookups(c, l - 1, l - 1);
        fill(c, BLUR, (cube_level){c->lookup, 0, l, n}, -1,
             blur_variance * mean * (l > 1 ? 0.75 : 1),
             middle / (l > 1 ? 6 : 24));
    }
    use_lookups(c, 0, c->levels);
    view_gl_bind(VIEW_CAPTURE_UNIT_MORE, GL_TEXTURE_2D, c->samples);
    fill(c, LOBE,
         (cube_level){to->irradiance, layer, 0, VIEW_CAPTURE_IRRADIANCE}, -1, 0,
         MOST_SAMPLES);
    for (int l = 1; l < c->levels; l++) {
        const int n = ibl_cube_edge(c->size, l);
        fill(c, LOBE, (cube_level){to->specular, layer, l, n}, -1, l, SAMPLES);
    }
    gl.UseProgram(0);
    gl.ActiveTexture(GL_TEXTURE0);
}
