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

enum {
    EDGE = 512,
    LEVELS = 6, /* of roughness 0 .. 1 */
    FACE = 128, /* edge of the cube that an atlas is read as */
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

/* Texels of a level of a cube, so many floats apart. */
typedef struct faces {
    const float *texels;
    int n, stride;
} faces;

/* Beyond a corner there is no texel: the one beyond the upper or lower edge
 * stands for it. */
static const float *texel_at(const faces *f, int face, int x, int y)
{
    const int n = f->n;
    const bool beyond_x = x < 0 || x >= n, beyond_y = y < 0 || y >= n;

    if (beyond_x && beyond_y)
        x = x < 0 ? 0 : n - 1;
    const size_t i =
        beyond_x || beyond_y
            ? ibl_cube_neighbour(n, face, x, y)
            : ((size_t)face * (size_t)n + (size_t)y) * (size_t)n + (size_t)x;
    return f->texels + i * (size_t)f->stride;
}

static double along(const signed char axis[3], const double d[3])
{
    return axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2];
}

/* Adds the texels around x, y, joined by straight lines. */
static void add_texels(const faces *f, int face, double x, double y,
                       double sum[3])
{
    const int left = (int)(x + 1) - 1, top = (int)(y + 1) - 1, n = f->n;
    const double right = x - left, down = y - top;
    const double weight[4] = {(1 - right) * (1 - down), right * (1 - down),
                              (1 - right) * down, right * down};
    const bool inside = left >= 0 && top >= 0 && left + 1 < n && top + 1 < n;
    const float *first = inside ? texel_at(f, face, left, top) : NULL;

    for (int k = 0; k < 4; k++) {
        const int i = k & 1, j = k >> 1;
        const float *texel = inside ? first + (j * n + i) * f->stride
                                    : texel_at(f, face, left + i, top + j);
        for (int c = 0; c < 3; c++)
            sum[c] += weight[k] * (double)texel[c];
    }
}

/* Adds a bilinear sample towards d. */
static void add_sample(const faces *f, const double d[3], double sum[3])
{
    int axis = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(d[i]) > fabs(d[axis]))
            axis = i;
    const int face = 2 * axis + (d[axis] < 0);
    const double scale = 0.5 * f->n / fabs(d[axis]), middle = 0.5 * f->n - 0.5;

    add_texels(f, face, along(ibl_face[face].right, d) * scale + middle,
               along(ibl_face[face].down, d) * scale + middle, sum);
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

typedef struct atlas {
    const ibl_engine_set *set;
    unsigned char *rgbp;
    faces mip[LEVELS]; /* the environment, halved as its rectangles are */
    float *halves[LEVELS];
    double (*around[RECTANGLES])[2]; /* cosine and sine of columns' azimuths */
} atlas;

static faces level_of(const ibl_texture *tex, int level)
{
    const unsigned char *first = tex->data + ibl_texture_offset(tex, level, 0);

    return (faces){(const float *)(const void *)first,
                   ibl_cube_edge(tex->width, level), 4};
}

static faces faces_of(const atlas *a, int i)
{
    const ibl_cube *irradiance = a->set->irradiance;

    if (i == IRRADIANCE)
        return (faces){ibl_cube_face(irradiance, 0, 0), irradiance->size, 3};
    return i < LEVELS ? a->mip[i]
                      : level_of(a->set->specular, rectangle_of(i).level);
}

/* Samples along an edge of a texel of a rectangle. Of the environment, a texel
 * is the mean of as many as the cube has texels in it; other levels are smooth.
 */
static int samples_of(const atlas *a, int i)
{
    const int width = rectangle_of(i).width, n = i < LEVELS ? a->mip[i].n : 0;

    return 4 * n > width ? 4 * n / width : 1;
}

/* Means of 2x2 texels, for an even edge. */
static void halve(const faces *from, float *to)
{
    const size_t n = (size_t)from->n, row = n * (size_t)from->stride;

    for (size_t y = 0; y < IBL_FACES * n; y += 2)
        for (size_t x = 0; x < n; x += 2, to += 3) {
            const float *t = from->texels + y * row + x * (size_t)from->stride;
            const float *u = t + row;
            for (int c = 0; c < 3; c++)
                to[c] =
                    (t[c] + t[from->stride + c] + u[c] + u[from->stride + c]) /
                    4;
        }
}

/* Of an edge that is odd, the last one serves for the rest. False: no memory.
 */
static bool make_mips(atlas *a)
{
    a->mip[0] = level_of(a->set->specular, 0);
    for (int i = 1; i < LEVELS; i++) {
        const int n = a->mip[i - 1].n / 2;
        a->mip[i] = a->mip[i - 1];
        if (a->mip[i].n % 2)
            continue;
        a->halves[i] = ibl_alloc_array((size_t)(IBL_FACES * n) * (size_t)n,
                                       3 * sizeof(float));
        if (!a->halves[i])
            return false;
        halve(&a->mip[i - 1], a->halves[i]);
        a->mip[i] = (faces){a->halves[i], n, 3};
    }
    return true;
}

/* False: no memory. */
static bool make_columns(atlas *a)
{
    for (int i = 0; i < RECTANGLES; i++) {
        const int width = rectangle_of(i).width, s = samples_of(a, i);
        const int count = width * s;
        a->around[i] = ibl_alloc_array((size_t)count, sizeof **a->around);
        if (!a->around[i])
            return false;
        for (int k = 0; k < count; k++) {
            const double u = ((k + 0.5) / s - 1) / (width - 2);
            a->around[i][k][0] = cos(2 * M_PI * (u - 0.5));
            a->around[i][k][1] = sin(2 * M_PI * (u - 0.5));
        }
    }
    return true;
}

static unsigned char *place_of(const atlas *a, const rectangle *r, int x, int y)
{
    return a->rgbp + 4 * ((size_t)(r->y + y) * EDGE + (size_t)(r->x + x));
}

/* Sets means to the texels of a row of a rectangle. */
static void take_row(const atlas *a, int i, int y, double (*means)[3])
{
    const faces f = faces_of(a, i);
    const int s = samples_of(a, i), width = rectangle_of(i).width;

    memset(means, 0, sizeof *means * (size_t)width);
    for (int j = 0; j < s; j++) {
        const double v = (y - 1 + (j + 0.5) / s) / (width / 2 - 2);
        const double up = sin(M_PI * (0.5 - v)), level = cos(M_PI * (0.5 - v));
        for (int k = 0; k < width * s; k++) {
            const double *at = a->around[i][k];
            const double d[3] = {level * at[0], up, level * at[1]};
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

/* A row of all faces of a level: those at the sides differ by quarter turns,
 * the upper and the lower one are mirrored. */
static void back_job(void *arg, int job, int worker)
{
    /* Where the middle of a side is. */
    static const double middle[IBL_FACES] = {0.5, 1, 0, 0, 0.75, 0.25};
    const reading *r = arg;
    int level = 0, n = r->tex->width;

    (void)worker;
    for (; job >= n; job -= n, n = ibl_cube_edge(r->tex->width, level))
        level++;
    const rectangle from = rectangle_of(level ? LEVELS + level - 1 : 0);
    float *to =
        (float *)(void *)(r->tex->data + ibl_texture_offset(r->tex, level, 0)) +
        4 * job * n;
    const double y = (2 * job + 1.0) / n - 1;
    for (int i = 0; i < n; i++, to += 4) {
        const double x = (2 * i + 1.0) / n - 1;
        const double length = sqrt(1 + x * x + y * y);
        const double turn = atan(x) / (2 * M_PI),
                     sink = asin(y / length) / M_PI;
        const double about = atan2(y, x) / (2 * M_PI);
        const double rise = asin(1 / length) / M_PI;
        for (int f = 0; f < IBL_FACES; f++) {
            double u = middle[f] - turn, v = 0.5 + sink;
            if (f / 2 == 1) {
                u = 0.5 + (f == 2 ? about : -about);
                v = 0.5 + (f == 2 ? -rise : rise);
            }
            look_up(r->rgb, &from, u < 1 ? u : u - 1, v, to + 4 * f * n * n);
        }
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

ibl_status ibl_atlas_encode(ibl_ctx *ctx, const ibl_engine_set *set,
                            ibl_blob *main)
{
    atlas a = {.set = set, .rgbp = ibl_alloc_zeroed(EDGE * EDGE, 4)};
    ibl_status status = a.rgbp && make_mips(&a) && make_columns(&a)
                            ? ibl_run(ctx, NULL, EDGE, row_job, &a)
                            : ibl_no_memory(ctx, "an atlas");

    if (!status && !ibl_png_encode(a.rgbp, EDGE, EDGE, set->specular, main))
        status = ibl_no_memory(ctx, "a PNG file");
    if (!status)
        status = read_back(ctx, a.rgbp, set->specular);
    for (int i = 0; i < LEVELS; i++)
        ibl_free(a.halves[i]);
    for (int i = 0; i < RECTANGLES; i++)
        ibl_free(a.around[i]);
    ibl_free(a.rgbp);
    return status;
}

static ibl_status make_cube(ibl_ctx *ctx, const unsigned char *rgbp,
                            ibl_texture *tex)
{
    *tex = (ibl_texture){.pixel = IBL_PIXEL_RGBA32F,
                         .width = FACE,
                         .height = FACE,
                         .levels = LEVELS,
                         .layers = 1,
                         .faces = IBL_FACES};
    tex->bytes = ibl_texture_offset(tex, LEVELS, 0);
    tex->data = ibl_alloc_array(tex->bytes, 1);
    return tex->data ? read_back(ctx, rgbp, tex)
                     : ibl_no_memory(ctx, "a texture");
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
    unsigned char *rgbp = ibl_alloc_array(EDGE * EDGE, 4);
    ibl_status status =
        !rgbp ? ibl_no_memory(ctx, "an atlas")
        : ibl_png_decode(bytes, size, EDGE, EDGE, rgbp)
            ? make_cube(ctx, rgbp, tex)
            : ibl_fail(ctx, IBL_ERR_FORMAT,
                       "%s: damaged: the PNG cannot be decoded", name);
    ibl_free(rgbp);
    if (!status)
        status = ibl_engine_set_roughness(ctx, roughness, tex);
    if (!status)
        status = ibl_png_keys(ctx, bytes, size, tex);
    if (status)
        ibl_texture_free(tex);
    return status;
}
