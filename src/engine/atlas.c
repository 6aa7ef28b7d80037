/* SPDX-License-Identifier: MIT */
/*
 * PlayCanvas's atlas: equirectangular rectangles with a seam of one texel, in
 * which the map goes on. At (512 (1 - 2^-i), the same), 512 / 2^i wide and half
 * as high, the environment, i = 0..5; at (0, 512 (1 - 2^-i)) the level of
 * roughness i / 5, i = 1..5 and once more; at (128, 384) irradiance, E/pi. A
 * texel is RGBP: g = sqrt(c), m = the largest g within 1..8, v = 1 - (m - 1) /
 * 7, rgb = g / (8 - 7 v), a = v. Source: envAtlas, decode and reflectionEnv of
 * its shaders. The middle column is +X, as in maps.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "engine/set.h"
#include "image/cube.h"
#include "image/pyramid.h"
#include "io/container.h"

enum {
    EDGE = 512,
    LEVELS = 6,  /* of roughness 0 .. 1 */
    FACE = 128,  /* edge of the cube that an atlas is read as */
    SAMPLES = 2, /* of the environment, along an edge of a texel */
    RECTANGLES = 13,
    IRRADIANCE = 12
};

typedef struct rectangle {
    int x, y, width, level;
} rectangle;

/* 0..5: the environment, 6..11: levels 1..5 and 5 again, 12: irradiance. */
static rectangle rectangle_of(int i)
{
    const int k = i < LEVELS ? i : i - LEVELS + 1;
    const int from = EDGE - (EDGE >> k);

    if (i == IRRADIANCE)
        return (rectangle){128, 384, 64, 0};
    if (i < LEVELS)
        return (rectangle){from, from, EDGE >> k, 0};
    return (rectangle){0, from, EDGE >> k, k < LEVELS ? k : LEVELS - 1};
}

/* ---- cube to atlas ---------------------------------------------------- */

typedef struct atlas {
    unsigned char *rgbp;
    ibl_pyramid level[LEVELS + 1]; /* of roughness; the last: irradiance */
} atlas;

/* Texels of a face are bordered by those around it. */
typedef struct faces {
    const float *texels, *floor;
    int n;
} faces;

/* What a rectangle shows. Of the environment it is the mip whose texels are
 * half as wide as its own, or the nearest. */
static faces faces_of(const atlas *a, int i)
{
    const rectangle r = rectangle_of(i);
    const ibl_pyramid *p = &a->level[i == IRRADIANCE ? LEVELS : r.level];
    int mip = 0;

    while (mip + 1 < p->levels && 2 * ibl_cube_edge(p->size, mip) > r.width)
        mip++;
    return (faces){p->texels[mip], p->floor, ibl_cube_edge(p->size, mip)};
}

static double along(const signed char axis[3], const double d[3])
{
    return axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2];
}

/* Adds a bilinear sample towards d. */
static void add_sample(const faces *f, const double d[3], double sum[3])
{
    int axis = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(d[i]) > fabs(d[axis]))
            axis = i;
    const int face = 2 * axis + (d[axis] < 0), row = f->n + 2;
    const double scale = 0.5 * f->n / fabs(d[axis]), middle = 0.5 * f->n + 0.5;
    const double x = along(ibl_face[face].right, d) * scale + middle;
    const double y = along(ibl_face[face].down, d) * scale + middle;
    const int left = (int)x, top = (int)y;
    const double right = x - left, down = y - top;
    const float *t = f->texels + 4 * ((face * row + top) * row + left);
    const float *u = t + 4 * row;

    for (int c = 0; c < 3; c++)
        sum[c] +=
            (double)f->floor[c] +
            (1 - down) *
                ((1 - right) * (double)t[c] + right * (double)t[4 + c]) +
            down * ((1 - right) * (double)u[c] + right * (double)u[4 + c]);
}

/* The direction of a point of the map, which goes on beyond 0..1. */
static void direction_of(double u, double v, double d[3])
{
    const double phi = 2 * M_PI * (u - 0.5), theta = M_PI * (0.5 - v);

    d[0] = cos(theta) * cos(phi);
    d[1] = sin(theta);
    d[2] = cos(theta) * sin(phi);
}

static void put_texel(const double c[3], unsigned char rgbp[4])
{
    double g[3], most = 1;

    for (int k = 0; k < 3; k++) {
        g[k] = c[k] > 0 ? c[k] < 64 ? sqrt(c[k]) : 8 : 0;
        most = g[k] > most ? g[k] : most;
    }
    const int v = (int)(255 * (1 - (most - 1) / 7));
    const double range = 8 - 7 * v / 255.0;
    for (int k = 0; k < 3; k++) {
        const double byte = 255 * g[k] / range + 0.5;
        rgbp[k] = (unsigned char)(byte < 255 ? byte : 255);
    }
    rgbp[3] = (unsigned char)v;
}

static unsigned char *place_of(const atlas *a, const rectangle *r, int x, int y)
{
    return a->rgbp + 4 * ((size_t)(r->y + y) * EDGE + (size_t)(r->x + x));
}

/* Sets means to the texels of a row of a rectangle. */
static void take_row(const atlas *a, int i, int y, double (*means)[3])
{
    const faces f = faces_of(a, i);
    const int width = rectangle_of(i).width, s = i < LEVELS ? SAMPLES : 1;
    double around[SAMPLES * EDGE][2];

    memset(means, 0, sizeof *means * (size_t)width);
    for (int k = 0; k < s * width; k++) {
        const double u = ((k + 0.5) / s - 1) / (width - 2);
        around[k][0] = cos(2 * M_PI * (u - 0.5));
        around[k][1] = sin(2 * M_PI * (u - 0.5));
    }
    for (int j = 0; j < s; j++) {
        const double v = (y - 1 + (j + 0.5) / s) / (width / 2 - 2);
        const double up = sin(M_PI * (0.5 - v)), level = cos(M_PI * (0.5 - v));
        for (int k = 0; k < s * width; k++) {
            const double d[3] = {level * around[k][0], up,
                                 level * around[k][1]};
            add_sample(&f, d, means[k / s]);
        }
    }
    for (int k = 0; k < 3 * width; k++)
        means[k / 3][k % 3] /= s * s;
}

static void put_row(const atlas *a, int i, int y)
{
    const rectangle r = rectangle_of(i);
    double means[EDGE][3];

    take_row(a, i, y, means);
    for (int x = 0; x < r.width; x++)
        put_texel(means[x], place_of(a, &r, x, y));
}

/* ---- small rectangles ---------------------------------------------------
 * Their lines between exact texels are all on one side of a curve. Texels whose
 * lines come nearest to it in the mean halve what is wrong. Lines join what is
 * stored: square roots. */

enum {
    FITTED = 64, /* the widest of them */
    POINTS = 4,  /* along an edge of a texel */
    ROUNDS = 5
};
static const double STEP = 1.5; /* in twice as many rounds, 1 does the same */

typedef struct fit {
    double texel[FITTED * FITTED / 2][3]; /* square roots */
    double wrong[FITTED * FITTED / 2][4]; /* sums with weights; the weights' */
} fit;

/* Adds what is wrong at u, v to the texels that it lies between. */
static void add_wrong(const faces *f, int width, double u, double v, fit *t)
{
    const double x = u * (width - 2) + 0.5, y = v * (width / 2 - 2) + 0.5;
    const int left = (int)x, top = (int)y;
    double d[3], wrong[3] = {0}, weight[4];
    int at[4];

    direction_of(u, v, d);
    add_sample(f, d, wrong);
    for (int c = 0; c < 3; c++)
        wrong[c] = sqrt(fmax(wrong[c], 0));
    for (int k = 0; k < 4; k++) {
        const int i = k & 1, j = k >> 1;
        at[k] = (top + j) * width + left + i;
        weight[k] = (i ? x - left : left + 1 - x) * (j ? y - top : top + 1 - y);
        for (int c = 0; c < 3; c++)
            wrong[c] -= weight[k] * t->texel[at[k]][c];
    }
    for (int k = 0; k < 4; k++) {
        const double area = weight[k] * sin(M_PI * v);
        for (int c = 0; c < 3; c++)
            t->wrong[at[k]][c] += area * wrong[c];
        t->wrong[at[k]][3] += area;
    }
}

static void improve(const faces *f, int width, fit *t)
{
    const int columns = POINTS * (width - 2), rows = POINTS * (width / 2 - 2);

    memset(t->wrong, 0, sizeof t->wrong);
    for (int p = 0; p < columns * rows; p++)
        add_wrong(f, width, (p % columns + 0.5) / columns,
                  (p / columns + 0.5) / rows, t);
    for (int i = 0; i < width * width / 2; i++)
        for (int c = 0; c < 3 && t->wrong[i][3] > 0; c++)
            t->texel[i][c] += STEP * t->wrong[i][c] / t->wrong[i][3];
}

static void put_fitted(const atlas *a, int i)
{
    const rectangle r = rectangle_of(i);
    const faces f = faces_of(a, i);
    const int count = r.width * r.width / 2;
    fit t;

    for (int y = 0; y < r.width / 2; y++)
        take_row(a, i, y, t.texel + y * r.width);
    for (int k = 0; k < 3 * count; k++)
        t.texel[k / 3][k % 3] = sqrt(t.texel[k / 3][k % 3]);
    for (int k = 0; k < ROUNDS; k++)
        improve(&f, r.width, &t);
    for (int k = 0; k < count; k++) {
        double rgb[3];
        for (int c = 0; c < 3; c++)
            rgb[c] = t.texel[k][c] * fmax(t.texel[k][c], 0);
        put_texel(rgb, place_of(a, &r, k % r.width, k / r.width));
    }
}

/* ---- all of them ----------------------------------------------------------
 */

/* A row of the atlas, which goes through some rectangles; the first one of a
 * small one has all of it. */
static void row_job(void *arg, int job, int worker)
{
    const atlas *a = arg;

    (void)worker;
    for (int i = 0; i < RECTANGLES; i++) {
        const rectangle r = rectangle_of(i);
        const bool here = job >= r.y && job < r.y + r.width / 2;
        const bool fitted = i >= LEVELS && r.width <= FITTED;
        if (here && !fitted)
            put_row(a, i, job - r.y);
        else if (here && job == r.y)
            put_fitted(a, i);
    }
}

/* ---- atlas to cube ---------------------------------------------------- */

/* Decodes count texels. */
static void get_texels(const unsigned char *rgbp, size_t count, float *rgb)
{
    for (size_t i = 0; i < count; i++) {
        const unsigned char *from = rgbp + 4 * i;
        const double range = 8 - 7 * from[3] / 255.0;
        for (int c = 0; c < 3; c++) {
            const double g = from[c] / 255.0 * range;
            rgb[3 * i + (size_t)c] = (float)(g * g);
        }
    }
}

/* What a rectangle has at u, v of the map, joined by straight lines. */
static void look_up(const float *rgb, const rectangle *r, double u, double v,
                    float to[4])
{
    const double x = u * (r->width - 2) + 0.5;
    const double y = v * (r->width / 2 - 2) + 0.5;
    const int left = (int)x, top = (int)y;
    const double right = x - left, down = y - top;
    const float *first =
        rgb + 3 * ((size_t)(r->y + top) * EDGE + (size_t)(r->x + left));

    for (int c = 0; c < 3; c++, first++)
        to[c] =
            (float)((1 - down) * ((1 - right) * first[0] + right * first[3]) +
                    down * ((1 - right) * first[3 * EDGE] +
                            right * first[3 * EDGE + 3]));
    to[3] = 1;
}

typedef struct reading {
    const float *rgb;
    ibl_texture *tex;
} reading;

/* A row of all faces of a level. */
static void back_job(void *arg, int job, int worker)
{
    const reading *r = arg;
    int level = 0, n = r->tex->width;

    (void)worker;
    for (; job >= n; job -= n, n = ibl_cube_edge(r->tex->width, level))
        level++;
    const rectangle from = rectangle_of(level ? LEVELS + level - 1 : 0);
    float *to =
        (float *)(void *)(r->tex->data + ibl_texture_offset(r->tex, level, 0)) +
        4 * job * n;
    for (int i = 0; i < IBL_FACES * n; i++) {
        double d[3];
        ibl_cube_direction(n, i / n, i % n, job, d);
        look_up(r->rgb, &from, 0.5 + atan2(d[2], d[0]) / (2 * M_PI),
                acos(d[1]) / M_PI, to + 4 * (i / n * n * n + i % n));
    }
}

static ibl_status read_back(ibl_ctx *ctx, const unsigned char *rgbp,
                            ibl_texture *tex)
{
    float *rgb = ibl_alloc_array(EDGE * EDGE, 3 * sizeof *rgb);
    reading r = {rgb, tex};
    int rows = 0;

    if (!rgb)
        return ibl_no_memory(ctx, "an atlas");
    get_texels(rgbp, EDGE * EDGE, rgb);
    for (int l = 0; l < tex->levels; l++)
        rows += ibl_cube_edge(tex->width, l);
    const ibl_status status = ibl_run(ctx, NULL, rows, back_job, &r);
    ibl_free(rgb);
    return status;
}

/* ---- the calls -------------------------------------------------------- */

/* Halves of a cube's edge, while they are whole. */
static int mips_of(int size)
{
    int levels = 1;

    for (; size % 2 == 0; size /= 2)
        levels++;
    return levels;
}

static ibl_status make_levels(ibl_ctx *ctx, const ibl_engine_set *set, atlas *a)
{
    ibl_cube cube = {0}, level = {.levels = 1};
    ibl_status status = ibl_texture_to_cube(ctx, set->specular, &cube);

    for (int l = 0; l <= LEVELS && !status; l++) {
        level.data = l < LEVELS ? ibl_cube_face(&cube, l, 0)
                                : ibl_cube_face(set->irradiance, 0, 0);
        level.size =
            l < LEVELS ? ibl_cube_edge(cube.size, l) : set->irradiance->size;
        status = ibl_pyramid_create(ctx, &level, l ? 1 : mips_of(level.size),
                                    &a->level[l]);
    }
    ibl_cube_free(&cube);
    return status;
}

ibl_status ibl_atlas_encode(ibl_ctx *ctx, const ibl_engine_set *set,
                            ibl_blob *main)
{
    atlas a = {.rgbp = ibl_alloc_zeroed(EDGE * EDGE, 4)};
    ibl_status status =
        a.rgbp ? make_levels(ctx, set, &a) : ibl_no_memory(ctx, "an atlas");

    if (!status)
        status = ibl_run(ctx, NULL, EDGE, row_job, &a);
    if (!status && !ibl_png_encode(a.rgbp, 4, EDGE, EDGE, set->specular, main))
        status = ibl_no_memory(ctx, "a PNG file");
    if (!status)
        status = read_back(ctx, a.rgbp, set->specular);
    for (int l = 0; l <= LEVELS; l++)
        ibl_pyramid_free(&a.level[l]);
    ibl_free(a.rgbp);
    return status;
}

ibl_status ibl_atlas_decode(ibl_ctx *ctx, const char *name,
                            const unsigned char *bytes, size_t size,
                            ibl_texture *tex)
{
    static const double roughness[LEVELS] = {0, 0.2, 0.4, 0.6, 0.8, 1};

    if (!ibl_png_fits(bytes, size, EDGE, EDGE))
        return ibl_fail(ctx, IBL_ERR_UNSUPPORTED,
                        "%s: a PNG that is no atlas of PlayCanvas, which has "
                        "512x512 texels of 8 bits",
                        name);
    *tex = (ibl_texture){.pixel = IBL_PIXEL_RGBA32F,
                         .width = FACE,
                         .height = FACE,
                         .levels = LEVELS,
                         .layers = 1,
                         .faces = IBL_FACES};
    unsigned char *rgbp = ibl_alloc_array(EDGE * EDGE, 4);
    ibl_status status =
        rgbp ? ibl_texture_room(ctx, tex) : ibl_no_memory(ctx, "an atlas");
    if (!status && !ibl_png_decode(bytes, size, EDGE, EDGE, rgbp))
        status = ibl_fail(ctx, IBL_ERR_FORMAT,
                          "%s: damaged: the PNG cannot be decoded", name);
    if (!status)
        status = read_back(ctx, rgbp, tex);
    ibl_free(rgbp);
    if (!status)
        status = ibl_engine_set_roughness(ctx, roughness, tex);
    if (!status)
        status = ibl_png_keys(ctx, bytes, size, tex);
    if (status)
        ibl_texture_free(tex);
    return status;
}
