/* SPDX-License-Identifier: MIT */
/*
 * Levels and irradiance: laws that hold for every map and every way to bake it.
 * The tables below have the maps, hard ones by name, and the bakes; each test
 * is a law. A law takes each map with one of the bakes, which are dealt in
 * turn, so that no two laws take the same pair.
 *
 *     IBL_TEST_PAIR='stars, sheen' build/tests/check_levels reference
 *
 * takes the pairs whose names have these words, and IBL_TEST_SEED=N other
 * random numbers and other pairs. Bounds are derived beside the laws; u is the
 * unit roundoff of float.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image/cube.h"
#include "reference.h"
#include "truth.h"

static const double u = 0x1p-24;

/* ---- maps --------------------------------------------------------------- */

/* A map is its ground, on which paint() puts what the row says. */
typedef struct map_row {
    const char *name;
    int width, height;
    float ground;
    void (*paint)(const ibl_image *map, const struct map_row *row,
                  test_random *r);
    double is[3]; /* what paint() says of itself, in that order */
} map_row;

static void light(const ibl_image *map, int x, int y)
{
    const int w = map->width;
    map_set(map, (x % w + w) % w, y, 1e6f, 0.25e6f, map->data[2]);
}

/* From this column and row, so many pixels squared. */
static void square(const ibl_image *map, const map_row *row, test_random *r)
{
    (void)r;
    for (int i = 0; i < row->is[2] * row->is[2]; i++)
        light(map, (int)row->is[0] + i % (int)row->is[2],
              (int)row->is[1] + i / (int)row->is[2]);
}

/* So far from the zenith, at this azimuth, so wide: in degrees. */
static void disc(const ibl_image *map, const map_row *row, test_random *r)
{
    double at[3], d[3];
    (void)r;
    polar_direction(row->is[0] * M_PI / 180, row->is[1] * M_PI / 180, at);
    for (int i = 0; i < map->width * map->height; i++) {
        const int x = i % map->width, y = i / map->width;
        truth_latlong_direction(map->width, map->height, x, y, d);
        if (test_dot(d, at) > cos(row->is[2] * M_PI / 360))
            light(map, x, y);
    }
}

/* Of this map_kind. */
static void kind(const ibl_image *map, const map_row *row, test_random *r)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const ibl_image made =
        map_of_kind(ctx, r, (map_kind)row->is[0], map->width, map->height);
    memcpy(map->data, made.data, map_floats(map) * sizeof *map->data);
}

/* Above this row all is one value, below it another; blue is twice that. */
static void halves(const ibl_image *map, const map_row *row, test_random *r)
{
    (void)r;
    for (int i = 0; i < map->width * map->height; i++) {
        const float v =
            (float)(i / map->width < row->is[0] ? row->is[1] : row->is[2]);
        map_set(map, i % map->width, i / map->width, v, v, 2 * v);
    }
}

/* So many single pixels, of so many decades. */
static void stars(const ibl_image *map, const map_row *row, test_random *r)
{
    for (int k = 0; k < row->is[0]; k++) {
        const int x = test_random_below(r, map->width);
        const int y = test_random_below(r, map->height);
        const float v = (float)pow(10, row->is[1] * test_random_unit(r));
        map_set(map, x, y, v, 0.9f * v, 0.4f * v);
    }
}

/* A dark floor, a sky that falls by 1e3 to the horizon, and stars. */
static void lamps(const ibl_image *map, const map_row *row, test_random *r)
{
    for (int i = 0; i < map->width * map->height / 2; i++) {
        const double up = 1 - (i / map->width) / (map->height / 2.0);
        const float v = (float)(1e-2 + pow(up, 3));
        map_set(map, i % map->width, i / map->width, v, 1.2f * v, 2 * v);
    }
    stars(map, row, r);
}

/* Squares of so many pixels, half of them bright: coefficients that fall
 * slowly. */
static void tiles(const ibl_image *map, const map_row *row, test_random *r)
{
    const int n = (int)row->is[0];
    (void)r;
    for (int i = 0; i < map->width * map->height; i++)
        if ((i % map->width / n + i / map->width / n) % 2)
            map_set(map, i % map->width, i / map->width, 1, 1e-2f, 1e2f);
}

/* Noise of five decades in each pixel. */
static void decades(const ibl_image *map, const map_row *row, test_random *r)
{
    (void)row;
    for (size_t i = 0; i < map_floats(map); i++)
        map->data[i] = (float)pow(10, 5 * test_random_unit(r));
}

static void gradient(const ibl_image *map, const map_row *row, test_random *r)
{
    (void)r;
    for (int i = 0; i < map->width * map->height; i++) {
        double d[3];
        truth_latlong_direction(map->width, map->height, i % map->width,
                                i / map->width, d);
        for (int c = 0; c < 3; c++)
            map->data[3 * i + c] = (float)(row->is[0] + d[c]);
    }
}

static const map_row maps[] = {
    {"a sun at the zenith", 256, 128, 1e-3f, square, {77, 0, 1}},
    {"a sun at the nadir", 255, 127, 1e-3f, square, {200, 126, 1}},
    {"a sun at the seam", 256, 128, 1e-3f, square, {0, 63, 1}},
    {"a sun left of the seam", 64, 32, 1e-3f, square, {-1, 16, 1}},
    {"a sun on an edge", 256, 128, 1e-3f, square, {160, 64, 1}},
    {"a sun on a corner", 256, 128, 0, square, {160, 38, 1}},
    {"a sun anywhere", 256, 128, 0, square, {37, 12, 1}},
    {"a sun of 2x2 at a pole", 512, 256, 1e-3f, square, {130, 0, 2}},
    {"a sun of 3x3 on the seam", 256, 128, 1e-3f, square, {-1, 70, 3}},
    {"a sun of 10x10", 128, 64, 0, square, {90, 20, 10}},
    {"a disc of 5 degrees", 256, 128, 0, disc, {90, 17, 5}},
    {"a disc at a pole", 128, 64, 1e-3f, disc, {0, 0, 5}},
    {"a low coloured sun", 512, 256, 1e-2f, disc, {88, -130, 2}},
    {"a sun of all the first rows", 256, 128, 0, halves, {2, 1e5, 0.05}},
    {"a sun of all the last rows", 256, 128, 0, halves, {126, 0.05, 1e5}},
    {"a huge pixel", 8, 4, 0, square, {2, 1, 1}},
    {"stars", 128, 64, 0, stars, {60, 5}},
    {"lamps", 128, 64, 1e-2f, lamps, {400, 3}},
    {"noise of five decades", 128, 64, 0, decades, {0}},
    {"noise of sixteen", 64, 32, 0, kind, {MAP_DECADES}},
    {"noise with suns", 128, 64, 0, kind, {MAP_SUNNY}},
    {"noise of 37x19", 37, 19, 0, kind, {MAP_NOISE}},
    {"noise of primes", 167, 83, 0, kind, {MAP_NOISE}},
    {"black rows", 101, 51, 0, kind, {MAP_BLACK_ROWS}},
    {"tall pixels", 300, 20, 0, kind, {MAP_SUNNY}},
    {"wide pixels", 20, 150, 0, kind, {MAP_SUNNY}},
    {"long rows", 1100, 11, 0, kind, {MAP_NOISE}},
    {"1600x800", 1600, 800, 0, kind, {MAP_SUNNY}},
    {"1x1", 1, 1, 0.3f, square, {0, 0, 0}},
    {"2x1", 2, 1, 0, kind, {MAP_NOISE}},
    {"1x2", 1, 2, 0, kind, {MAP_NOISE}},
    {"3x2", 3, 2, 0, kind, {MAP_SUNNY}},
    {"a smooth map", 96, 48, 0, kind, {MAP_SMOOTH}},
    {"a gradient", 60, 30, 0, gradient, {1.01}},
    {"a checkerboard of pixels", 64, 32, 0, kind, {MAP_CHECKERBOARD}},
    {"tiles", 128, 64, 0, tiles, {16}},
    {"1 above, 2 below", 128, 64, 0, halves, {32, 1, 2}},
    {"black", 64, 32, 0, square, {0, 0, 0}},
    {"denormal halves", 64, 32, 0, kind, {MAP_DENORMAL_HALVES}},
    {"denormal floats", 64, 32, 0, kind, {MAP_DENORMAL}},
    {"the largest floats", 64, 32, FLT_MAX, square, {20, 9, 3}},
};

enum {
    MAPS = sizeof maps / sizeof *maps
};

/* ---- bakes -------------------------------------------------------------- */

typedef struct bake_row {
    const char *name;
    ibl_lobe lobe;
    ibl_roughness_map mapping;
    ibl_projection projection;
    int size, levels, samples; /* samples > 0: the method */
    double tolerance, yaw;     /* tolerance 0: the default */
    double roughest;           /* 0: 1 */
    int jitter;
} bake_row;

#define GGX IBL_LOBE_GGX
#define SHEEN IBL_LOBE_CHARLIE
#define PHONG IBL_LOBE_PHONG
#define LINEAR IBL_ROUGHNESS_LINEAR
#define FILAMENT IBL_ROUGHNESS_FILAMENT
#define BABYLON IBL_ROUGHNESS_BABYLON
#define CUBE IBL_PROJECTION_CUBE
#define FLAT IBL_PROJECTION_EQUIRECT
#define FOLDED IBL_PROJECTION_OCTAHEDRAL
static const bake_row bakes[] = {
    {"ggx", GGX, LINEAR, CUBE, 32, 4, 0, 0, 0, 0, 0},
    {"ggx, equirect", GGX, FILAMENT, FLAT, 16, 5, 0, 0, -70, 0, 0},
    {"ggx, octahedral", GGX, LINEAR, FOLDED, 16, 4, 0, 0, 25, 0, 0},
    {"ggx, narrow", GGX, LINEAR, CUBE, 44, 3, 0, 0, 10, 0.25, 0},
    {"ggx, to 1e-5", GGX, LINEAR, FLAT, 16, 3, 0, 1e-5, 0, 0.9, 0},
    {"ggx, to .02", GGX, FILAMENT, CUBE, 27, 4, 0, 0.02, 180, 0, 0},
    {"sheen", SHEEN, LINEAR, CUBE, 24, 3, 0, 0, 90, 0, 0},
    {"sheen, octahedral", SHEEN, FILAMENT, FOLDED, 16, 3, 0, 0, 0, 0, 0},
    {"phong", PHONG, BABYLON, CUBE, 32, 6, 0, 0, 33, 0, 0},
    {"phong, equirect", PHONG, LINEAR, FLAT, 8, 4, 0, 0, 0, 0, 0},
    {"phong, narrow", PHONG, LINEAR, FOLDED, 20, 3, 0, 0, 0, 0.25, 0},
    {"ggx, sampled", GGX, LINEAR, CUBE, 16, 3, 128, 0, 0, 0, 0},
    {"sheen, sampled", SHEEN, FILAMENT, CUBE, 13, 3, 500, 0, 0, 0, 1},
    {"phong, sampled", PHONG, LINEAR, CUBE, 8, 3, 400, 0, 0, 0, 0},
};

enum {
    BAKES = sizeof bakes / sizeof *bakes
};

enum {
    SLOTS = TEST_RACES ? 160 : TEST_SANITIZED ? 96 : BAKES
};

/* A map and a way to bake it. */
typedef struct pair {
    const map_row *map_row;
    const bake_row *row;
    ibl_image map;
    ibl_bake_options options;
    test_random random;         /* for further choices */
    const ibl_reference *truth; /* in the law of that name */
    char name[96];
} pair;

static ibl_bake_options options_of(const bake_row *b)
{
    ibl_bake_options o = ibl_bake_options_default();
    ibl_specular_options *s = &o.specular_options;
    s->lobe = b->lobe;
    s->mapping = b->mapping;
    s->projection = o.irradiance_options.projection = b->projection;
    s->size = b->size;
    s->levels = b->levels;
    s->roughness_max = b->roughest > 0 ? b->roughest : 1;
    s->tolerance = b->tolerance > 0 ? b->tolerance : IBL_TOLERANCE_DEFAULT;
    s->method = b->samples ? IBL_METHOD_SAMPLED : IBL_METHOD_SPECTRAL;
    s->samples = b->samples ? b->samples : s->samples;
    s->jitter = b->jitter;
    o.irradiance_options.size = 8;
    o.yaw_deg = b->yaw;
    return o;
}

static uint64_t seed(void)
{
    const char *text = getenv("IBL_TEST_SEED");
    return text && *text ? strtoull(text, NULL, 10) : 1;
}

/* Pairs that a law sees whatever the seed: of what only they show. */
static bool kept(const char *law, const char *name)
{
    static const char *const all[][2] = {
        {"positive", "the largest floats"},         /* sums are infinite */
        {"reference", "a gradient, ggx, to 1e-5"},  /* beyond poles */
        {"reference", "a huge pixel, ggx, to .02"}, /* a tolerance is missed */
        {"reference", "tall pixels, sheen"}, /* its percentile is no median */
        /* on whose borders the probes of degrees once lay */
        {"reference", "a checkerboard of pixels, ggx, to 1e-5"}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (!strcmp(all[i][0], law) && strstr(name, all[i][1]))
            return true;
    return false;
}

/* Runs a law for the pairs of some slots: each law has its own. There are as
 * many as bakes, so that each slot has each map once; of sanitizers fewer. */
static void each_pair(void (*law)(ibl_ctx *ctx, pair *p), const char *law_name,
                      int first, int count)
{
    const char *only = getenv("IBL_TEST_PAIR");
    static test_messages said; /* of tolerances missed: see reference() */
    ibl_ctx *ctx = test_keeping_ctx(2, &said);
    for (int k = 0; k < MAPS * BAKES; k++) {
        const int m = k / BAKES, b = k % BAKES;
        const int slot = (5 * m + b + (int)seed()) % SLOTS;
        pair p = {.map_row = &maps[m], .row = &bakes[b]};
        snprintf(p.name, sizeof p.name, "%s, %s", maps[m].name, bakes[b].name);
        const bool taken = slot >= first && slot < first + count;
        if (only ? !strstr(p.name, only) : !taken && !kept(law_name, p.name))
            continue;
        p.random.state = seed() + (uint64_t)m;
        p.map =
            map_constant(ctx, maps[m].width, maps[m].height, maps[m].ground);
        maps[m].paint(&p.map, &maps[m], &p.random);
        p.options = options_of(&bakes[b]);
        law(ctx, &p);
    }
}

/* Of threads alone ThreadSanitizer says something. */
#define LAW(f, first, count) LAW_OF(f, first, count, TEST_RACES)
#define LAW_OF(f, first, count, slow)                                          \
    TEST_OF(each_##f, #f, slow)                                                \
    {                                                                          \
        each_pair(f, #f, first, count);                                        \
    }

/* ---- levels ------------------------------------------------------------- */

/* One of a bake: a level of specular or, the last one, the irradiance. */
typedef struct level {
    const float *texels;
    ibl_level_shape shape;
    int count; /* of texels */
    ibl_lobe lobe;
    double roughness; /* 0: the map itself */
    bool sampled;
    double tolerance, error; /* error < 0: none is said */
    char name[24];
} level;

static int levels_of(const ibl_bake_result *r, const pair *p,
                     level to[IBL_MAX_LEVELS + 1])
{
    const int count = r->specular.levels;
    for (int k = 0; k <= count; k++) {
        const ibl_cube *cube = k < count ? &r->specular : &r->irradiance;
        const int at = k < count ? k : 0;
        level *l = &to[k];
        /* the cosine is the power lobe of roughness 1 */
        *l = (level){.texels = ibl_cube_face(cube, at, 0),
                     .shape = ibl_level_shape_of(cube->projection,
                                                 ibl_cube_edge(cube->size, at)),
                     .lobe = k < count ? p->row->lobe : IBL_LOBE_PHONG,
                     .roughness = k < count ? r->report.layout.roughness[k] : 1,
                     .sampled = k < count && r->report.level[k].samples > 0,
                     .tolerance = p->options.specular_options.tolerance,
                     .error = k < count ? r->report.level[k].error : -1};
        l->count = l->shape.faces * l->shape.width * l->shape.height;
        snprintf(l->name, sizeof l->name, k < count ? "level %d" : "irradiance",
                 k);
    }
    return count + 1;
}

static void direction_of(const level *l, int i, double d[3])
{
    const ibl_level_shape *s = &l->shape;
    const int face = i / (s->width * s->height);
    ibl_level_direction(s, face, i % s->width, i / s->width % s->height, d);
}

static double angle_of(const level *l, int i)
{
    const ibl_level_shape *s = &l->shape;
    return ibl_level_solid_angle(s, i % s->width, i / s->width % s->height);
}

static int texel_at(const level *l, const double d[3])
{
    int at[3];
    ibl_level_texel(&l->shape, d, at);
    return (at[0] * l->shape.height + at[2]) * l->shape.width + at[1];
}

/* What a level differs from another one, or from the truth. */
typedef struct difference {
    double nrmse, p95, worst; /* the last two relative: ibl_relative_error */
    double absolute, peak;    /* of the components */
} difference;

static int rising(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static difference differ(const double *seen, const double *want, int count,
                         const double mean[3])
{
    double *error = test_alloc((size_t)count, sizeof *error);
    double off = 0, all = 0;
    difference to = {0};
    for (int i = 0; i < 3 * count; i++) {
        off += pow(seen[i] - want[i], 2);
        all += want[i] * want[i];
        to.absolute = fmax(to.absolute, fabs(seen[i] - want[i]));
        to.peak = fmax(to.peak, want[i]);
    }
    for (int i = 0; i < count; i++)
        error[i] = ibl_relative_error(seen + 3 * i, want + 3 * i, mean);
    qsort(error, (size_t)count, sizeof *error, rising);
    to.nrmse = all > 0 ? sqrt(off / all) : off > 0;
    to.p95 = error[(count - 1) * 19 / 20];
    to.worst = error[count - 1];
    return to;
}

/* Texels of b, each with a's that it looks like: factor * a[from(i)]. */
static difference moved(const level *a, const level *b,
                        void (*from)(double d[3]), const double mean[3])
{
    double *seen = test_alloc(6 * (size_t)a->count, sizeof *seen);
    double *want = seen + 3 * a->count;
    for (int i = 0; i < a->count; i++) {
        double d[3];
        int at = i;
        direction_of(b, i, d);
        if (from) {
            from(d);
            at = texel_at(a, d);
        }
        for (int c = 0; c < 3; c++) {
            seen[3 * i + c] = (double)b->texels[3 * i + c];
            want[3 * i + c] = (double)a->texels[3 * at + c];
        }
    }
    return differ(seen, want, a->count, mean);
}

static bool tiny(const pair *p)
{
    return p->map_row->paint == kind && p->map_row->is[0] == MAP_DENORMAL;
}

/* Whether a lobe is 4 pixels wide: others see borders of pixels, and what is
 * promised of them is less. */
static bool resolved(const pair *p, const level *l)
{
    const double pixel = fmax(M_PI / p->map.height, 2 * M_PI / p->map.width);
    return l->roughness * l->roughness >= 4 * pixel;
}

/* Denormals are rounded to 2^-149 in each of many products; relative errors of
 * them say nothing. The largest floats overflow in what tests sum. */
static bool ordinary(const pair *p)
{
    return !tiny(p) && p->map_row->ground < 1e30f;
}

/* What samples that are drawn at random leave of a small sun: a lookup spreads
 * it over a footprint of variance 5/12 h^2 an axis (bake/samples.c), and a
 * mip's texel h^2 holds 4 samples, so 4 pi 5/12 4 = 20.9 see it. Those of a
 * ring all along the horizon see four times less of it. */
static double random_of(const level *l)
{
    return 0.2186 * (l->lobe == IBL_LOBE_CHARLIE ? 4 : 1);
}

/* Groups of 256 samples, 8 products each, are summed in float, all >= 0. */
static const double gathered = 8 * 256 * 0x1p-24;

/* ---- laws of one bake --------------------------------------------------- */

/* A constant channel stays that beside the map in the others, to the rounding
 * of sums of 8 x 8 weights; and of a map of one value all is that value, to
 * the bit. */
static void constant(ibl_ctx *ctx, pair *p)
{
    static const float values[] = {1, 0.1f,  1e6f,    3e-5f,
                                   0, 65504, FLT_MAX, 0x1p-140f};
    const float only = values[test_random_below(&p->random, 8)];
    for (int whole = 0; whole < 2; whole++) {
        const float v = whole ? only : 0.3f;
        level l[IBL_MAX_LEVELS + 1];
        for (size_t i = 0; i < map_floats(&p->map); i++)
            p->map.data[i] = whole || i % 3 == 1 ? v : p->map.data[i];
        const ibl_bake_result r = map_bake(ctx, &p->map, &p->options);
        const int count = levels_of(&r, p, l);
        for (int k = 0; k < count; k++) {
            double worst = 0;
            for (int i = 0; i < 3 * l[k].count; i++)
                if (whole || i % 3 == 1)
                    worst = fmax(worst, fabs((double)l[k].texels[i] / v - 1));
            CHECK_MSG(worst <= (whole ? 0 : 64 * u),
                      "%s, %s: %g becomes %g times that", p->name, l[k].name,
                      (double)v, 1 + worst);
        }
    }
}
LAW(constant, 0, 1)

/* Nothing is brighter than the brightest pixel or darker than the darkest: so
 * all is finite and no texel negative. Averages of level 0 round once. */
static void positive(ibl_ctx *ctx, pair *p)
{
    level l[IBL_MAX_LEVELS + 1];
    const ibl_bake_result r = map_bake(ctx, &p->map, &p->options);
    const int count = levels_of(&r, p, l);
    for (int k = 0; k < 3 * count; k++) {
        const level *at = &l[k / 3];
        double low, high, slack = 0;
        int bad = 0;
        map_range(&p->map, k % 3, &low, &high);
        if (at->sampled) /* and 16 products of each rounded to denormals */
            slack = gathered * high + 16 * p->row->samples * 0x1p-150;
        else if (at->roughness <= 0)
            slack = u * high;
        for (int i = k % 3; i < 3 * at->count; i += 3)
            bad += !((double)at->texels[i] >= fmax(low - slack, 0) &&
                     (double)at->texels[i] <= fmin(high + slack, FLT_MAX));
        CHECK_MSG(!bad, "%s, %s: %d values are not from %g to %g", p->name,
                  at->name, bad, low, high);
    }
}
LAW(positive, 1, 1)

/* What the centres of a level's texels miss of its lobe, as a share: the most
 * over points of light on axes, edges, corners and centres of texels. */
static double missed_of(const level *l, test_random *r)
{
    const double alpha = l->roughness * l->roughness;
    const double whole = truth_lobe_integral(l->lobe, alpha);
    double most = 0;
    for (int k = 0; k < 40; k++) { /* among them those of the cube's corners */
        double at[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1}, d[3], sum = 0;
        const double length = sqrt(test_dot(at, at));
        for (int c = 0; c < 3; c++)
            at[c] /= fmax(length, 1);
        if (k == 13 || k >= 27)
            direction_of(l, test_random_below(r, l->count), at);
        for (int i = 0; i < l->count; i++) {
            direction_of(l, i, d);
            const double q = (1 - test_dot(d, at)) / 2;
            sum += q < 0.5 ? angle_of(l, i) *
                                 truth_lobe_weight(l->lobe, alpha, fmax(q, 0))
                           : 0;
        }
        most = fmax(most, fabs(sum / whole - 1));
    }
    return 1.5 * most;
}

/* The mean of each level is the map's. Texels of level 0 divide by solid angles
 * that are off by what their borders are, cut into pieces of lines with a bow:
 * 1.3e-5 of them at most up to 24 texels an edge. */
static void energy(ibl_ctx *ctx, pair *p)
{
    level l[IBL_MAX_LEVELS + 1];
    double mean[3];
    if (!ordinary(p))
        return;
    const ibl_bake_result r = map_bake(ctx, &p->map, &p->options);
    const int count = levels_of(&r, p, l);
    reference_mean(&p->map, mean);
    for (int k = 0; k < count; k++) {
        if (l[k].count > 2100)
            continue;
        const double bound =
            l[k].roughness <= 0
                ? 1.4e-5
                : missed_of(&l[k], &p->random) +
                      (l[k].sampled ? random_of(&l[k]) : 2 * l[k].tolerance);
        for (int c = 0; c < 3; c++) {
            double sum = 0;
            for (int i = 0; i < l[k].count; i++)
                sum += angle_of(&l[k], i) * (double)l[k].texels[3 * i + c];
            const double off = fabs(sum / (4 * M_PI) - mean[c]);
            CHECK_MSG(off <= bound * mean[c], "%s, %s: mean %g of %g, off %g",
                      p->name, l[k].name, sum / (4 * M_PI), mean[c],
                      off / mean[c]);
            test_measured("energy", off, bound * mean[c]);
        }
    }
}
LAW(energy, 2, 1)

/* The texel beyond an edge of texel i, k = 0..3; -1: none, or none that is
 * near. Beyond a face of a cube its plane goes on. */
static int beside(const level *l, int i, int k, bool *seam)
{
    const ibl_level_shape *s = &l->shape;
    const int w = s->width, h = s->height, face = i / (w * h);
    const int x = i % w + (k == 0) - (k == 1);
    const int y = i / w % h + (k == 2) - (k == 3);
    double d[3];
    *seam = x < 0 || y < 0 || x >= w || y >= h;
    if (!*seam)
        return face * w * h + y * w + x;
    if (s->projection == IBL_PROJECTION_EQUIRECT && (y < 0 || y >= h))
        return -1;
    if (s->projection != IBL_PROJECTION_CUBE)
        return (int)ibl_flat_neighbour(s, x, y);
    truth_cube_direction(w, face, x, y, d);
    return texel_at(l, d);
}

/* Across seams a level is no steeper than inside. */
static void seams(ibl_ctx *ctx, pair *p)
{
    level l[IBL_MAX_LEVELS + 1];
    const ibl_bake_result r = map_bake(ctx, &p->map, &p->options);
    const int count = levels_of(&r, p, l);
    for (int k = 0; k < count; k++) {
        double steepest[2] = {0};
        if (l[k].roughness < 0.2 || l[k].count < 256)
            continue;
        for (int i = 0; i < 4 * l[k].count; i++) {
            double d[3], e[3], off = 0;
            bool seam;
            const int at = beside(&l[k], i / 4, i % 4, &seam);
            if (at < 0)
                continue;
            direction_of(&l[k], i / 4, d);
            direction_of(&l[k], at, e);
            for (int c = 0; c < 3; c++)
                off = fmax(off, fabs((double)l[k].texels[3 * (i / 4) + c] -
                                     (double)l[k].texels[3 * at + c]));
            off /= acos(fmin(test_dot(d, e), 1));
            steepest[seam] = fmax(steepest[seam], off);
        }
        CHECK_MSG(steepest[1] <= 1.25 * steepest[0],
                  "%s, %s: %g a radian at seams, %g inside", p->name, l[k].name,
                  steepest[1], steepest[0]);
        test_measured("seams", steepest[1], 1.25 * steepest[0]);
    }
}
LAW(seams, 3, 1)

/* ---- laws of two bakes -------------------------------------------------- */

/* What two bakes of the same harmonics differ by: the rounding of floats, in
 * the transforms and in the texels, and of the degree. */
static double rounding_of(const pair *p, const level *l)
{
    if (l->roughness <= 0)
        return 4 * u;
    return fmax(1e-5, l->tolerance / 100) * (resolved(p, l) ? 1 : 200);
}

/* Each level against where it was. What is cut off is the same in both. */
static void check_moved(const pair *p, const ibl_bake_result *before,
                        const ibl_bake_result *after, void (*from)(double d[3]),
                        const char *how)
{
    level a[IBL_MAX_LEVELS + 1], b[IBL_MAX_LEVELS + 1];
    const int count = levels_of(before, p, a);
    double mean[3];
    levels_of(after, p, b);
    reference_mean(&p->map, mean);
    for (int k = 0; k < count; k++) {
        const difference d = moved(&a[k], &b[k], from, mean);
        const double bound =
            a[k].sampled ? sqrt(2) * random_of(&a[k]) : rounding_of(p, &a[k]);
        CHECK_MSG(d.nrmse <= bound, "%s, %s, %s: nRMSE %g", p->name, a[k].name,
                  how, d.nrmse);
        CHECK_MSG(
            a[k].sampled || !resolved(p, &a[k]) || d.p95 <= a[k].tolerance,
            "%s, %s, %s: 95th percentile %g", p->name, a[k].name, how, d.p95);
        test_measured(how, d.nrmse, bound);
    }
}

/* What is at +X now was at +Z. */
static void turn_back(double d[3])
{
    const double x = d[0];
    d[0] = -d[2];
    d[2] = x;
}

static void mirror(double d[3])
{
    d[2] = -d[2];
}

/* By 90 degrees: of yaw, or of columns where a quarter of them is whole. */
static void turned(ibl_ctx *ctx, pair *p)
{
    if (!ordinary(p))
        return;
    const ibl_bake_result a = map_bake(ctx, &p->map, &p->options);
    const bool columns =
        p->map.width % 4 == 0 && test_random_below(&p->random, 2);
    const ibl_image map =
        columns ? map_turned(ctx, &p->map, p->map.width / 4) : p->map;
    p->options.yaw_deg += columns ? 0 : 90;
    const ibl_bake_result b = map_bake(ctx, &map, &p->options);
    check_moved(p, &a, &b, turn_back, columns ? "columns" : "yaw");
}
LAW(turned, 4, 1)

static void mirrored(ibl_ctx *ctx, pair *p)
{
    if (!ordinary(p))
        return;
    const ibl_bake_result a = map_bake(ctx, &p->map, &p->options);
    const ibl_image map = map_mirrored(ctx, &p->map);
    p->options.yaw_deg *= -1;
    const ibl_bake_result b = map_bake(ctx, &map, &p->options);
    check_moved(p, &a, &b, mirror, "mirrored");
}
LAW(mirrored, 5, 1)

/* Nothing is measured in absolute radiance: powers of two change no bits, but
 * of denormals. */
static void scaled(ibl_ctx *ctx, pair *p)
{
    const int power = test_random_below(&p->random, 80) - 20;
    level a[IBL_MAX_LEVELS + 1], b[IBL_MAX_LEVELS + 1];
    if (!ordinary(p))
        return;
    const ibl_image map = map_scaled(ctx, &p->map, ldexpf(1, power));
    const ibl_bake_result x = map_bake(ctx, &p->map, &p->options);
    const ibl_bake_result y = map_bake(ctx, &map, &p->options);
    const int count = levels_of(&x, p, a);
    levels_of(&y, p, b);
    for (int k = 0; k < count; k++) {
        double worst = 0;
        for (int i = 0; i < 3 * a[k].count; i++)
            worst = fmax(worst, fabs(ldexp((double)b[k].texels[i], -power) -
                                     (double)a[k].texels[i]));
        CHECK_MSG(worst <= 0x1p-100, "%s, %s: times 2^%d, %g off", p->name,
                  a[k].name, power, worst);
    }
}
LAW(scaled, 6, 1)

/* The levels of a sum are the sums of the levels: within the tolerances of
 * three bakes, and of samples to the rounding of sums. */
static void linear(ibl_ctx *ctx, pair *p)
{
    static const map_kind others[] = {MAP_NOISE, MAP_SUNNY, MAP_SMOOTH};
    level l[3][IBL_MAX_LEVELS + 1];
    ibl_bake_result r[3];
    double mean[3];
    int count = 0;
    if (!ordinary(p))
        return;
    ibl_image map[3] = {p->map};
    map[1] =
        map_of_kind(ctx, &p->random, others[test_random_below(&p->random, 3)],
                    p->map.width, p->map.height);
    map[2] = map_scaled(ctx, &p->map, 1);
    for (size_t i = 0; i < map_floats(&p->map); i++)
        map[2].data[i] += map[1].data[i];
    for (int k = 0; k < 3; k++) {
        r[k] = map_bake(ctx, &map[k], &p->options);
        count = levels_of(&r[k], p, l[k]);
    }
    reference_mean(&map[2], mean);
    for (int k = 0; k < count; k++) {
        const level *at = &l[2][k];
        double *sum = test_alloc(6 * (size_t)at->count, sizeof *sum);
        double *want = sum + 3 * at->count;
        for (int i = 0; i < 3 * at->count; i++) {
            sum[i] = (double)l[0][k].texels[i] + (double)l[1][k].texels[i];
            want[i] = (double)at->texels[i];
        }
        double scale[3];
        for (int c = 0; c < 3; c++)
            scale[c] = mean[c] * (resolved(p, at) ? 1 : 1 / IBL_RELATIVE_FLOOR);
        const difference d = differ(sum, want, at->count, scale);
        const double bound = at->sampled          ? 2 * gathered
                             : at->roughness <= 0 ? 8 * u
                                                  : 3 * at->tolerance;
        CHECK_MSG(d.p95 <= bound && d.worst <= 10 * bound,
                  "%s, %s: the sum is off by %g, at worst %g", p->name,
                  at->name, d.p95, d.worst);
        test_measured("linear", d.p95, bound);
    }
}
LAW(linear, 7, 1)

/* ---- laws of machines --------------------------------------------------- */

static ibl_bake_result bake_by(const pair *p, int threads, ibl_isa isa)
{
    ibl_ctx_options o = ibl_ctx_options_default();
    ibl_ctx *ctx = NULL;
    o.threads = threads;
    o.isa = isa;
    NEED(!ibl_ctx_create(&o, &ctx));
    const ibl_bake_result r = map_bake(ctx, &p->map, &p->options);
    ibl_ctx_free(ctx);
    return r;
}

/* The same bytes from any number of threads. */
static void threads(ibl_ctx *ctx, pair *p)
{
    static const int others[] = {2, 3, 7};
    level a[IBL_MAX_LEVELS + 1], b[IBL_MAX_LEVELS + 1];
    const int many = others[test_random_below(&p->random, 3)];
    (void)ctx;
    const ibl_bake_result x = bake_by(p, 1, IBL_ISA_AUTO);
    const ibl_bake_result y = bake_by(p, many, IBL_ISA_AUTO);
    const int count = levels_of(&x, p, a);
    levels_of(&y, p, b);
    for (int k = 0; k < count; k++)
        CHECK_MSG(!memcmp(a[k].texels, b[k].texels,
                          3 * (size_t)a[k].count * sizeof(float)),
                  "%s, %s: other bytes from %d threads", p->name, a[k].name,
                  many);
    CHECK(!memcmp(x.sh, y.sh, 27 * sizeof *x.sh));
    CHECK(!memcmp(&x.report, &y.report, sizeof x.report));
}
LAW_OF(threads, 9, 1, false)

/* Each instruction set differs from plain C by rounding only. */
static void isas(ibl_ctx *ctx, pair *p)
{
    const double mean[3] = {0, 0, 0};
    level a[IBL_MAX_LEVELS + 1], b[IBL_MAX_LEVELS + 1];
    (void)ctx;
    if (!ordinary(p))
        return;
    const ibl_bake_result x = bake_by(p, 2, IBL_ISA_C);
    const int count = levels_of(&x, p, a);
    for (ibl_isa isa = test_next_isa(IBL_ISA_C); isa < IBL_ISA_COUNT;
         isa = test_next_isa(isa)) {
        const ibl_bake_result y = bake_by(p, 2, isa);
        levels_of(&y, p, b);
        for (int k = 0; k < count; k++) {
            const difference d = moved(&a[k], &b[k], NULL, mean);
            const double bound =
                a[k].sampled ? 2 * gathered : rounding_of(p, &a[k]);
            CHECK_MSG(d.nrmse <= bound, "%s, %s, %s: %g", p->name, a[k].name,
                      ibl_isa_name(isa), d.nrmse);
            test_measured(ibl_isa_name(isa), d.nrmse, bound);
        }
    }
}
LAW(isas, 10, 1)

/* ---- laws of truth ------------------------------------------------------ */

/* Whether at most 60 pixels are not the ground. */
static bool sparse(const pair *p)
{
    int count = 0;
    for (size_t i = 0; i < map_floats(&p->map); i += 3)
        for (size_t c = i; c < i + 3; c++)
            if (fabsf(p->map.data[c] - p->map_row->ground) > 0) {
                count++;
                break;
            }
    return p->map.width > 60 && count <= 60;
}

/* Some texels of a level, also at the poles, against the truth. What is left of
 * a sun on nothing is relative to a tenth of the mean, and of lobes narrower
 * than pixels to it. */
static difference judge(const pair *p, const level *l)
{
    double mean[3];
    const bool dense = !sparse(p) || l->roughness <= 0;
    const double floor_at = !resolved(p, l) ? 1 : dense ? 0 : 0.1;
    const int at_most =
        (int)fmin(fmax(1e5 / p->map.width / p->map.height, 16), 70);
    const int count = l->count < at_most ? l->count : at_most;
    double *seen = test_alloc(9 * (size_t)count, sizeof *seen);
    double *want = seen + 3 * count, *dirs = want + 3 * count;
    ibl_texel *at = test_alloc((size_t)count, sizeof *at);
    for (int i = 0; i < count; i++) {
        const ibl_level_shape *s = &l->shape;
        const double pole[3] = {1e-9, i ? -1 : 1, 1e-9};
        const int k = i < 2
                          ? texel_at(l, pole)
                          : (int)(((long)i * l->count + l->count / 2) / count);
        direction_of(l, k, dirs + 3 * i);
        at[i] = (ibl_texel){k / (s->width * s->height), k % s->width,
                            k / s->width % s->height};
        for (int c = 0; c < 3; c++)
            seen[3 * i + c] = (double)l->texels[3 * k + c];
    }
    if (l->roughness > 0) {
        NEED(!ibl_reference_lobe(p->truth, l->lobe, l->roughness, dirs,
                                 (size_t)count, want));
    } else {
        NEED(!ibl_reference_texels(p->truth, l->shape.projection, p->row->size,
                                   p->row->size, at, (size_t)count, want));
    }
    reference_mean(&p->map, mean);
    for (int c = 0; c < 3; c++)
        mean[c] *= fmax(floor_at / IBL_RELATIVE_FLOOR, 1);
    return differ(seen, want, count, mean);
}

/* Each level is the integral over all pixels to the tolerance, and no worse
 * than twice what it says, for few texels are judged; ten times the tolerance
 * is left to single ones. */
static void reference(ibl_ctx *ctx, pair *p)
{
    test_messages said = {0};
    level l[IBL_MAX_LEVELS + 1];
    bool missed = false;
    if (!ordinary(p))
        return;
    p->truth = reference_of(ctx, &p->map, p->options.yaw_deg);
    const ibl_bake_result r =
        map_bake(test_keeping_ctx(2, &said), &p->map, &p->options);
    const int count = levels_of(&r, p, l);
    const bool few = sparse(p); /* no estimate is of them */
    for (int k = 0; k < count; k++) {
        const difference d = judge(p, &l[k]);
        const bool told = l[k].error >= 0 && l[k].count >= 20 && !few;
        const double bound =
            fmax(l[k].tolerance, 4e-5) * (resolved(p, &l[k]) ? 1 : 10);
        if (l[k].roughness <= 0)
            CHECK_MSG(d.absolute <= 2e-5 * d.peak, "%s, %s: %g off, peak %g",
                      p->name, l[k].name, d.absolute, d.peak);
        else if (l[k].sampled)
            CHECK_MSG(d.nrmse <= random_of(&l[k]) * (p->map.width < 30 ? 2 : 1),
                      "%s, %s: nRMSE %g", p->name, l[k].name, d.nrmse);
        else
            CHECK_MSG(d.p95 <= bound && d.worst <= 10 * bound,
                      "%s, %s: 95th percentile %g, worst %g, not %g", p->name,
                      l[k].name, d.p95, d.worst, l[k].error);
        CHECK_MSG(!told || !resolved(p, &l[k]) || d.p95 <= 2 * l[k].error,
                  "%s, %s: %g, not %g", p->name, l[k].name, d.p95, l[k].error);
        missed |= l[k].error > l[k].tolerance;
        if (l[k].error >= 0) {
            test_measured("95th percentile", d.p95, bound);
            test_measured("worst", d.worst, 10 * bound);
        }
    }
    CHECK_MSG(!strstr(said.text[IBL_LOG_WARNING], "is not reached") ==
                  !(missed && p->row->tolerance > IBL_TOLERANCE_DEFAULT),
              "%s: %s", p->name, said.text[IBL_LOG_WARNING]);
}
LAW(reference, 13, 1)

/* As samples grow, sampled levels come closer to the exact ones; what stays is
 * the blur of lookups in level 0, whose first order is taken back. */
static void converges(ibl_ctx *ctx, pair *p)
{
    static const int counts[] = {64, 1024, 16384};
    const double mean[3] = {0, 0, 0};
    level exact[IBL_MAX_LEVELS + 1], l[IBL_MAX_LEVELS + 1];
    double before[IBL_MAX_LEVELS + 1];
    ibl_specular_options *o = &p->options.specular_options;
    if (!ordinary(p) || !p->row->samples || p->map.width < 30)
        return;
    o->method = IBL_METHOD_SPECTRAL;
    const ibl_bake_result x = map_bake(ctx, &p->map, &p->options);
    const int count = levels_of(&x, p, exact);
    for (int n = 0; n < 3; n++) {
        o->method = IBL_METHOD_SAMPLED;
        o->samples = counts[n];
        const ibl_bake_result y = map_bake(ctx, &p->map, &p->options);
        levels_of(&y, p, l);
        for (int k = 1; k + 1 < count; k++) {
            const double off = moved(&exact[k], &l[k], NULL, mean).nrmse;
            CHECK_MSG(y.report.level[k].samples == counts[n] &&
                          (!n || off <= fmax(before[k], 2e-3)),
                      "%s, %s, %d samples: %g after %g", p->name, l[k].name,
                      counts[n], off, n ? before[k] : 0);
            before[k] = off;
        }
    }
}
LAW(converges, 0, 3)
