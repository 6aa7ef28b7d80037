/* SPDX-License-Identifier: MIT */
/*
 * The spectral method against the sums of truth.c, where it is hard: single
 * suns on black, skies of five decades, maps of any size, every lobe.
 *
 * What is promised: nRMSE 1e-4 and a relative error of 1e-3 at every texel, of
 * suns on black of what is above a tenth of the mean, and where a lobe is
 * below 1e-6 of its peak, no more than four times that.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/ibl.h"
#include "ibl/io.h"
#include "maps.h"
#include "reference.h"
#include "truth.h"

static const double nrmse_bound = 1e-4, worst_bound = 1e-3, dark_bound = 4e-6;
/* Of the mean: a sun on black is told to that, where the horizon cuts it. */
static const double sun_floor = 0.1;
/* Directions are floats: N.L is off by 4 roundings, a lobe next to its horizon
 * by that part of its peak. */
static const double rounded = 4 * 0x1p-24;

enum {
    LOBES = 3,
    /* Of these maps, where every level but the first has a lobe that is at
     * least 10 pixels wide, alpha >= 4 pi / HIGH: 1/9 at the first. */
    WIDE = 256,
    HIGH = 128,
    SIZE = 64,
    LEVELS = 4,
    DIFFUSE = 16
};

static ibl_bake_result bake(ibl_ctx *ctx, const ibl_image *map,
                            ibl_method method, ibl_lobe lobe, double yaw)
{
    ibl_bake_options o = ibl_bake_options_default();

    o.specular_options.method = method;
    o.specular_options.mapping = IBL_ROUGHNESS_LINEAR;
    o.specular_options.lobe = lobe;
    o.specular_options.size = SIZE;
    o.specular_options.levels = LEVELS;
    o.irradiance_options.size = DIFFUSE;
    o.yaw_deg = yaw;
    return map_bake(ctx, map, &o);
}

/* A cube's level of a bake: those of specular, then irradiance. */
typedef struct level {
    const float *texels;
    int size;
    double roughness;
    ibl_lobe lobe;
    const char *name;
} level;

enum {
    JUDGED = LEVELS /* levels 1.. and irradiance */
};

static level level_of(const ibl_bake_result *r, ibl_lobe lobe, int k)
{
    static const char *const names[] = {"level 1", "level 2", "level 3",
                                        "irradiance"};
    if (k == JUDGED - 1) /* the cosine is the power lobe of roughness 1 */
        return (level){r->irradiance.data, r->irradiance.size, 1,
                       IBL_LOBE_PHONG, names[k]};
    return (level){ibl_cube_face(&r->specular, k + 1, 0),
                   ibl_cube_edge(r->specular.size, k + 1),
                   r->report.layout.roughness[k + 1], lobe, names[k]};
}

static void direction_of(const level *l, int i, double dir[3])
{
    truth_cube_direction(l->size, i / (l->size * l->size), i % l->size,
                         i / l->size % l->size, dir);
}

/* Where the map has what is seen in dir of a world turned by yaw degrees. */
static void to_map(double dir[3], double yaw)
{
    const double c = cos(yaw * M_PI / 180), s = sin(yaw * M_PI / 180);
    const double x = dir[0], z = dir[2];
    dir[0] = c * x - s * z;
    dir[2] = s * x + c * z;
}

/* ---- suns on black ----------------------------------------------------- */

/* Pixels of one value on black. */
typedef struct suns {
    int width, height, count;
    int *pixel;
    double value, total; /* of each; solid angles times that */
} suns;

static suns suns_of(const ibl_image *map)
{
    suns s = {.width = map->width, .height = map->height};
    const int n = map->width * map->height;

    s.pixel = test_alloc((size_t)n, sizeof *s.pixel);
    if (!s.pixel)
        exit(1);
    for (int i = 0; i < n; i++) {
        if (!(map->data[3 * i] > 0))
            continue;
        s.value = (double)map->data[3 * i];
        s.total += s.value * truth_latlong_solid_angle(map->width, map->height,
                                                       i / map->width);
        s.pixel[s.count++] = i;
    }
    return s;
}

/* ---- what lobes sum to ------------------------------------------------- */

static double seen(const suns *s, const level *l, const double dir[3])
{
    double sum = 0;

    for (int i = 0; i < s->count; i++)
        sum += truth_pixel_weight(s->width, s->height, s->pixel[i] % s->width,
                                  s->pixel[i] / s->width, dir, l->lobe,
                                  l->roughness);
    return sum * s->value /
           truth_lobe_integral(l->lobe, l->roughness * l->roughness);
}

/* The largest that any direction could see. */
static double peak_of(const suns *s, const level *l)
{
    const double alpha = l->roughness * l->roughness;
    double most = 0;

    for (int k = 0; k <= 1000; k++)
        most = fmax(most, truth_lobe_weight(l->lobe, alpha, 0.5e-3 * k));
    return most * s->total / truth_lobe_integral(l->lobe, alpha);
}

/* Every stride-th texel of a level: red and a quarter of it as green sees
 * the suns, blue is black. Errors are relative to what is seen, or floor_share
 * of the mean. */
static void check_suns_in(const suns *s, const level *l, int stride,
                          double floor_share, const char *where)
{
    const double peak = peak_of(s, l);
    const double floor_at = floor_share * s->total / (4 * M_PI);
    const bool whole = floor_share > sun_floor;
    const double limit = fmax(dark_bound * (1 + worst_bound),
                              whole ? worst_bound * floor_at / peak : 0);
    double off = 0, all = 0, worst = 0, low = 0, dark = 0, blue = 0;

    for (int i = 0; i < 6 * l->size * l->size; i += stride) {
        const float *x = l->texels + 3 * i;
        double dir[3];
        direction_of(l, i, dir);
        const double t = seen(s, l, dir);
        for (int c = 0; c < 3; c++)
            low = fmin(low, x[c]);
        off += pow(x[0] - t, 2) + pow(4 * (double)x[1] - t, 2);
        all += 2 * t * t;
        worst = fmax(worst, fmax(fabs(x[0] - t) - rounded * peak, 0) /
                                fmax(t, floor_at));
        if (t < dark_bound * peak)
            dark = fmax(dark, x[0] / peak);
        blue = fmax(blue, fabs((double)x[2]) / peak);
    }
    const double nrmse = sqrt(off / all);
    CHECK_MSG(low >= 0, "%s, %s: %g", where, l->name, low);
    CHECK_MSG(nrmse <= nrmse_bound, "%s, %s: nRMSE %g", where, l->name, nrmse);
    CHECK_MSG(worst <= worst_bound, "%s, %s: worst %g", where, l->name, worst);
    CHECK_MSG(dark <= limit, "%s, %s: %g of the peak in the dark", where,
              l->name, dark);
    CHECK_MSG(blue <= dark_bound, "%s, %s: %g of the peak in black blue", where,
              l->name, blue);
    test_measured(whole ? "suns in the series, nRMSE" : "suns, nRMSE", nrmse,
                  nrmse_bound);
    test_measured(whole ? "suns in the series, worst" : "suns, worst", worst,
                  worst_bound);
    test_measured(whole ? "suns in the series, dark" : "suns, dark", dark,
                  limit);
}

/* With a sanitizer each map is baked with one lobe, in turn: they are other
 * numbers for the same code. Charlie has the highest degrees, so the longest
 * transforms, and one turn. */
static bool left_out(int lobe)
{
    static const ibl_lobe turns[] = {
        IBL_LOBE_GGX,   IBL_LOBE_CHARLIE, IBL_LOBE_PHONG, IBL_LOBE_GGX,
        IBL_LOBE_PHONG, IBL_LOBE_GGX,     IBL_LOBE_PHONG};
    static int asked;
    return TEST_SANITIZED && lobe != (int)turns[asked++ / LOBES % 7];
}

static void check_suns(ibl_ctx *ctx, const ibl_image *map, double floor_at,
                       const char *where)
{
    static const char *const names[] = {"ggx", "charlie", "phong"};
    const suns s = suns_of(map);

    for (int lobe = 0; lobe < LOBES; lobe++) {
        if (left_out(lobe))
            continue;
        ibl_bake_result r =
            bake(ctx, map, IBL_METHOD_SPECTRAL, (ibl_lobe)lobe, 0);
        char text[96];
        snprintf(text, sizeof text, "%s, %s", where, names[lobe]);
        for (int k = 0; k < JUDGED; k++) {
            const level l = level_of(&r, (ibl_lobe)lobe, k);
            const int texels = 6 * l.size * l.size;
            /* 100,000 pixels a level, of 100 texels at least. */
            const int most = s.count < 1000 ? 100000 / s.count : 100;
            const int stride = texels > most ? (texels / most) | 1 : 1;
            CHECK_MSG(k == JUDGED - 1 || r.report.level[k + 1].degree > 0,
                      "%s, %s: not spectral", text, l.name);
            check_suns_in(&s, &l, stride, floor_at, text);
        }
    }
}

static void light(const ibl_image *map, int x, int y)
{
    map_set(map, (x + map->width) % map->width, y, 1e6f, 0.25e6f, 0);
}

/* Poles, both sides of the seam, an edge and a corner of the cube, anywhere. */
TEST(one_pixel_suns)
{
    static const int at[][2] = {
        {0, 0},    {77, 0},   {200, HIGH - 1}, {0, 63},  {-1, 64},   {160, 64},
        {128, 31}, {160, 38}, {159, 89},       {37, 12}, {211, 101}, {128, 64},
    };
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (size_t k = 0; k < sizeof at / sizeof *at;
         k += TEST_SANITIZED ? 12 : 1) {
        ibl_image map = map_constant(ctx, WIDE, HIGH, 0);
        char where[48];
        light(&map, at[k][0], at[k][1]);
        snprintf(where, sizeof where, "%d, %d", at[k][0], at[k][1]);
        check_suns(ctx, &map, sun_floor, where);
    }
}

/* A level has the mean of the map. */
static void check_mean(const suns *s, const level *l, const char *where)
{
    double sum = 0;

    for (int i = 0; i < 6 * l->size * l->size; i++)
        sum +=
            (double)l->texels[3 * i] *
            ibl_cube_solid_angle(l->size, i % l->size, i / l->size % l->size);
    CHECK_MSG(fabs(sum / s->total - 1) <= nrmse_bound, "%s, %s: mean %g of %g",
              where, l->name, sum, s->total);
}

/* Pixels that are much of the sphere are no lights: the series holds them, and
 * no texel takes long. What it leaves is relative to the mean. */
TEST(huge_pixels)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int width = 2; width <= 16; width *= 2) {
        ibl_image map = map_constant(ctx, width, width / 2, 0);
        char where[32];
        light(&map, width / 3, width / 4);
        snprintf(where, sizeof where, "of %d columns", width);
        if (width == 16) {
            check_suns(ctx, &map, 1, where);
            continue;
        }
        const suns s = suns_of(&map);
        ibl_bake_result r =
            bake(ctx, &map, IBL_METHOD_SPECTRAL, IBL_LOBE_GGX, 0);
        for (int k = 0; k < JUDGED; k++) {
            const level l = level_of(&r, IBL_LOBE_GGX, k);
            check_mean(&s, &l, where);
        }
    }
}

/* 2x2, 3x3 and 10x10 pixels: in the open, over the seam, at a pole; of a map
 * of 4 WIDE columns and, 14 degrees wide, of WIDE. */
TEST_SLOW(square_suns)
{
    static const int edges[] = {2, 3, 10};
    static const int at[][2] = {{360, 200}, {-4, 280}, {130, 0}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int k = 0; k < 18; k += TEST_RACES ? 18 : TEST_SANITIZED ? 13 : 1) {
        const int size = k < 9 ? 4 : 1, n = edges[k % 3];
        const int x = at[k / 3 % 3][0] * size / 4,
                  y = at[k / 3 % 3][1] * size / 4;
        ibl_image map = map_constant(ctx, size * WIDE, size * HIGH, 0);
        char where[64];
        for (int i = 0; i < n * n; i++)
            light(&map, x + i % n, y + i / n);
        snprintf(where, sizeof where, "%dx%d at %d, %d of %d columns", n, n, x,
                 y, map.width);
        check_suns(ctx, &map, sun_floor, where);
    }
}

/* Disks of 5 degrees. At a pole they are more pixels than anywhere else. */
TEST_SLOW(wide_suns)
{
    static const double at[][2] = {{90, 17}, {40, 179}, {15, 100}, {0, 0}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int k = 0; k < 4; k += TEST_SANITIZED ? 4 : 1) {
        ibl_image map = map_constant(ctx, 2 * WIDE, 2 * HIGH, 0);
        const double theta = at[k][0] * M_PI / 180, phi = at[k][1] * M_PI / 180;
        const double d[3] = {sin(theta) * cos(phi), cos(theta),
                             sin(theta) * sin(phi)};
        char where[48];
        for (int i = 0; i < map.width * map.height; i++) {
            const int x = i % map.width, y = i / map.width;
            double l[3];
            truth_latlong_direction(map.width, map.height, x, y, l);
            if (l[0] * d[0] + l[1] * d[1] + l[2] * d[2] > cos(2.5 * M_PI / 180))
                light(&map, x, y);
        }
        snprintf(where, sizeof where, "disk at %g, %g", at[k][0], at[k][1]);
        check_suns(ctx, &map, sun_floor, where);
    }
}

/* ---- whole maps -------------------------------------------------------- */

/* About count texels of a level against the sum over the map. */
static void check_level(const ibl_image *map, const level *l, double yaw,
                        int count, const char *what)
{
    const int n = 6 * l->size * l->size;
    const int stride = n > count ? (n / count) | 1 : 1;
    double off = 0, all = 0, worst = 0, mean[3];

    truth_mean(map, mean);
    for (int i = stride / 2; i < n; i += stride) {
        const float *x = l->texels + 3 * i;
        double dir[3], t[3], got[3];
        direction_of(l, i, dir);
        to_map(dir, yaw);
        if (l->lobe == IBL_LOBE_PHONG && l->roughness == 1)
            truth_irradiance(map, dir, t);
        else
            truth_lobe(map, dir, l->lobe, l->roughness, t);
        for (int c = 0; c < 3; c++) {
            got[c] = x[c];
            off += pow(got[c] - t[c], 2);
            all += t[c] * t[c];
        }
        worst = fmax(worst, ibl_relative_error(got, t, mean));
        CHECK_MSG(got[0] >= 0 && got[1] >= 0 && got[2] >= 0, "%s, %s: %g %g %g",
                  what, l->name, got[0], got[1], got[2]);
    }
    const double nrmse = sqrt(off / all);
    CHECK_MSG(nrmse <= nrmse_bound, "%s, %s: nRMSE %g", what, l->name, nrmse);
    CHECK_MSG(worst <= worst_bound, "%s, %s: worst %g", what, l->name, worst);
    test_measured("map, nRMSE", nrmse, nrmse_bound);
    test_measured("map, worst", worst, worst_bound);
}

static void check_map(ibl_ctx *ctx, const ibl_image *map, ibl_method method,
                      double yaw, const char *what)
{
    for (int lobe = 0; lobe < LOBES; lobe++) {
        if (left_out(lobe))
            continue;
        ibl_bake_result r = bake(ctx, map, method, (ibl_lobe)lobe, yaw);
        char text[96];
        snprintf(text, sizeof text, "%s, %s", what,
                 ibl_lobe_name((ibl_lobe)lobe));
        for (int k = 0; k < JUDGED; k++) {
            const level l = level_of(&r, (ibl_lobe)lobe, k);
            check_level(map, &l, yaw, TEST_SANITIZED ? 24 : 64, text);
        }
    }
}

/* Every pixel by itself anywhere in five decades. */
TEST_SLOW(noise_of_five_decades)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = map_constant(ctx, WIDE, HIGH, 0);
    test_random r = {8};

    for (size_t i = 0; i < map_floats(&map); i++)
        map.data[i] = (float)pow(10, 5 * test_random_unit(&r));
    check_map(ctx, &map, IBL_METHOD_SPECTRAL, 0, "noise");
}

/* A sun that fills the first rows, or the last, two million times as bright as
 * the floor. */
TEST(sun_at_a_pole)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int nadir = 0; nadir < 2; nadir++) {
        ibl_image map = map_constant(ctx, WIDE, HIGH, 0.05f);
        for (int i = 0; i < WIDE * HIGH / 2; i++)
            map_set(&map, i % WIDE, i / WIDE, 0.5f, 0.6f, 0.9f);
        for (int i = 0; i < 2 * WIDE; i++)
            map_set(&map, i % WIDE, nadir ? HIGH - 1 - i / WIDE : i / WIDE,
                    1e5f, 1e5f, 1e5f);
        check_map(ctx, &map, IBL_METHOD_SPECTRAL, 0,
                  nadir ? "nadir" : "zenith");
    }
}

/* A dark floor, a sky that falls by 1e3 to the horizon, and 400 lamps of up
 * to 1e5 times the floor, more than can be taken out one by one; turned. */
TEST_SLOW(lamps_on_a_sky)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = map_constant(ctx, WIDE, HIGH, 1e-2f);
    test_random r = {9};

    for (int i = 0; i < WIDE * HIGH / 2; i++) {
        const float v = (float)(1e-2 + pow(1 - (i / WIDE) / (HIGH / 2.0), 3));
        map_set(&map, i % WIDE, i / WIDE, v, 1.2f * v, 2 * v);
    }
    for (int k = 0; k < 400; k++) {
        const float v = (float)(1e-2 * pow(10, 5 * test_random_unit(&r)));
        map_set(&map, (int)(WIDE * test_random_unit(&r)),
                (int)(HIGH * test_random_unit(&r)), v, 0.9f * v, 0.4f * v);
    }
    check_map(ctx, &map, IBL_METHOD_SPECTRAL, 37, "lamps");
}

/* Half of the map black, half white: coefficients that fall slowly. */
TEST_SLOW(edges)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = map_constant(ctx, WIDE, HIGH, 0);

    for (int i = 0; i < WIDE * HIGH; i++)
        if ((i % WIDE / 32 + i / WIDE / 32) % 2)
            map_set(&map, i % WIDE, i / WIDE, 1, 1e-2f, 1e2f);
    check_map(ctx, &map, IBL_METHOD_SPECTRAL, -90, "edges");
}

/* ---- sizes ------------------------------------------------------------- */

/* Whether the report says one thing of each level, and the right one. */
static void check_report(const ibl_bake_result *r, const ibl_image *map,
                         ibl_method method, const char *what)
{
    const double pixel = fmax(M_PI / map->height, 2 * M_PI / map->width);

    for (int k = 0; k < r->report.layout.levels; k++) {
        const ibl_specular_level *l = &r->report.level[k];
        const double roughness = r->report.layout.roughness[k];
        CHECK_MSG((l->samples > 0) + (l->degree > 0) == (roughness > 0),
                  "%s, level %d: %d samples, degree %d", what, k, l->samples,
                  l->degree);
        if (roughness > 0 && method == IBL_METHOD_SPECTRAL)
            CHECK_MSG(l->degree > 0 || roughness * roughness < 4 * pixel,
                      "%s, level %d: sampled", what, k);
        if (method == IBL_METHOD_SAMPLED)
            CHECK_MSG(l->degree == 0, "%s, level %d: spectral", what, k);
    }
}

static void check_finite(const ibl_cube *cube, const char *what)
{
    int bad = 0;

    for (size_t i = 0; i < cube_floats(cube); i++)
        bad += !(cube->data[i] >= 0 && isfinite(cube->data[i]));
    CHECK_MSG(!bad, "%s: %d values", what, bad);
}

static void check_size(ibl_ctx *ctx, const ibl_image *map, ibl_method method)
{
    const double pixel = fmax(M_PI / map->height, 2 * M_PI / map->width);
    ibl_bake_result r = bake(ctx, map, method, IBL_LOBE_GGX, 0);
    char what[64];

    snprintf(what, sizeof what, "%dx%d, %s", map->width, map->height,
             ibl_method_name(method));
    check_report(&r, map, method, what);
    check_finite(&r.specular, what);
    check_finite(&r.irradiance, what);
    for (int k = 0; k < JUDGED; k++) {
        const level l = level_of(&r, IBL_LOBE_GGX, k);
        const bool diffuse = k == JUDGED - 1;
        /* Narrower lobes the truth has patches for; without a pixel above
         * the horizon there is the mean. */
        if (diffuse ? map->width > 2
                    : l.roughness * l.roughness >= 4 * pixel &&
                          r.report.level[k + 1].degree > 0)
            check_level(map, &l, 0, 24, what);
    }
}

TEST_SLOW(sizes)
{
    static const int all[][2] = {{1, 1},    {2, 1},    {1, 2},    {3, 2},
                                 {37, 19},  {101, 51}, {64, 200}, {300, 40},
                                 {640, 12}, {331, 167}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random random = {11};

    for (size_t k = 0; k < sizeof all / sizeof *all; k += TEST_RACES ? 4
                                                          : TEST_SANITIZED
                                                              ? 2
                                                              : 1) {
        ibl_image map =
            map_of_kind(ctx, &random, MAP_SUNNY, all[k][0], all[k][1]);
        check_size(ctx, &map, IBL_METHOD_SPECTRAL);
        check_size(ctx, &map, IBL_METHOD_AUTO);
    }
}

/* ---- a photograph ------------------------------------------------------ */

/* More than 200 texels of each level: a grid, and the 5x5 around the sun. */
static size_t choose(int n, const double sun[3], double *dirs, int *texels)
{
    const int cells = n < 6 ? n : 6;
    size_t count = 0;

    for (int i = 0; i < 6 * n * n; i++) {
        const int x = i % n, y = i / n % n;
        double d[3];
        truth_cube_direction(n, i / (n * n), x, y, d);
        const double c = d[0] * sun[0] + d[1] * sun[1] + d[2] * sun[2];
        const bool on_grid = x * cells / n != (x - 1 + n) % n * cells / n &&
                             y * cells / n != (y - 1 + n) % n * cells / n;
        if (!on_grid && acos(fmin(c, 1)) > 2.5 * M_PI / 2 / n)
            continue;
        memcpy(dirs + 3 * count, d, sizeof d);
        texels[count++] = i;
    }
    return count;
}

static void check_photograph(ibl_ctx *ctx, const ibl_reference *ref,
                             const ibl_cube *cube, int level_at,
                             double roughness, const double sun[3])
{
    const int n = ibl_cube_edge(cube->size, level_at);
    const float *texels = ibl_cube_face(cube, level_at, 0);
    double *dirs = test_alloc(7 * 600, sizeof *dirs), *t = dirs + 1800;
    int *at = test_alloc(600, sizeof *at);
    double mean[3], off = 0, all = 0, worst = 0;

    (void)ctx;
    if (!dirs || !at)
        exit(1);
    const size_t count = choose(n, sun, dirs, at);
    CHECK_MSG(count >= 200 && count <= 600, "%zu texels", count);
    CHECK(!ibl_reference_mean(ref, mean));
    CHECK(roughness < 0
              ? !ibl_reference_irradiance(ref, dirs, count, t)
              : !ibl_reference_specular(ref, roughness, dirs, count, t));
    for (size_t i = 0; i < count; i++) {
        const float *x = texels + 3 * at[i];
        const double got[3] = {x[0], x[1], x[2]};
        for (int c = 0; c < 3; c++) {
            off += pow(got[c] - t[3 * i + c], 2);
            all += pow(t[3 * i + c], 2);
        }
        worst = fmax(worst, ibl_relative_error(got, t + 3 * i, mean));
    }
    const double nrmse = sqrt(off / all);
    CHECK_MSG(nrmse <= nrmse_bound, "r %g: nRMSE %g", roughness, nrmse);
    CHECK_MSG(worst <= worst_bound, "r %g: worst %g", roughness, worst);
    test_measured("photograph, nRMSE", nrmse, nrmse_bound);
    test_measured("photograph, worst", worst, worst_bound);
}

TEST_SLOW(photograph)
{
    const char *path = test_shared_data("quarry_01_1k.hdr");
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_bake_options o = ibl_bake_options_default();
    ibl_image map = {0};
    double sun[3];
    int brightest = 0;

    if (TEST_SANITIZED)
        path = NULL; /* a minute, for nothing that small maps do not show */
    if (!path)
        test_skip("no quarry_01_1k.hdr, or too slow with a sanitizer");
    NEED(!ibl_image_read(ctx, path, NULL, &map, NULL));
    test_image(map);
    const ibl_bake_result r = map_bake(ctx, &map, &o);
    const ibl_reference *ref = reference_of(ctx, &map, 0);
    for (int i = 0; i < map.width * map.height; i++)
        if (map.data[3 * i] > map.data[3 * brightest])
            brightest = i;
    truth_latlong_direction(map.width, map.height, brightest % map.width,
                            brightest / map.width, sun);
    check_report(&r, &map, IBL_METHOD_AUTO, "photograph");
    for (int l = 1; l < r.report.layout.levels; l++) {
        CHECK(r.report.level[l].degree > 0);
        check_photograph(ctx, ref, &r.specular, l, r.report.layout.roughness[l],
                         sun);
    }
    check_photograph(ctx, ref, &r.irradiance, 0, -1, sun);
}
