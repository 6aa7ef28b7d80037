/* SPDX-License-Identifier: MIT */
#include "maps.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "truth.h"

/* ---- maps ------------------------------------------------------------- */

ibl_image map_constant(ibl_ctx *ctx, int width, int height, float value)
{
    ibl_image map = {0};
    if (ibl_image_alloc(ctx, width, height, &map))
        exit(1);
    for (size_t i = 0; i < map_floats(&map); i++)
        map.data[i] = value;
    return test_image(map);
}

float *map_pixel(const ibl_image *map, int x, int y)
{
    return map->data + 3 * ((size_t)y * (size_t)map->width + (size_t)x);
}

void map_set(const ibl_image *map, int x, int y, float r, float g, float b)
{
    float *p = map_pixel(map, x, y);

    p[0] = r;
    p[1] = g;
    p[2] = b;
}

void map_fill(const ibl_image *map, uint64_t seed)
{
    test_random r = {seed};

    for (size_t i = 0; i < map_floats(map); i++)
        map->data[i] = (float)pow(test_random_unit(&r), 4.0);
}

size_t map_floats(const ibl_image *map)
{
    return 3 * (size_t)map->width * (size_t)map->height;
}

bool map_same(const ibl_image *a, const ibl_image *b)
{
    return a->data && b->data && a->width == b->width &&
           a->height == b->height &&
           !memcmp(a->data, b->data, map_floats(a) * sizeof *a->data);
}

ibl_image map_turned(ibl_ctx *ctx, const ibl_image *map, int columns)
{
    const int w = map->width;
    ibl_image to = map_constant(ctx, w, map->height, 0);
    for (int i = 0; i < w * map->height; i++)
        memcpy(to.data + 3 * i,
               map->data + 3 * (i / w * w + (i % w + columns) % w),
               3 * sizeof(float));
    return to;
}

ibl_image map_mirrored(ibl_ctx *ctx, const ibl_image *map)
{
    const int w = map->width;
    ibl_image to = map_constant(ctx, w, map->height, 0);
    for (int i = 0; i < w * map->height; i++)
        memcpy(to.data + 3 * i, map->data + 3 * (i / w * w + w - 1 - i % w),
               3 * sizeof(float));
    return to;
}

ibl_image map_scaled(ibl_ctx *ctx, const ibl_image *map, float factor)
{
    ibl_image to = map_constant(ctx, map->width, map->height, 0);
    for (size_t i = 0; i < map_floats(map); i++)
        to.data[i] = map->data[i] * factor;
    return to;
}

void map_range(const ibl_image *map, int channel, double *low, double *high)
{
    *low = *high = map->data[channel];
    for (size_t i = (size_t)channel; i < map_floats(map); i += 3) {
        *low = fmin(*low, map->data[i]);
        *high = fmax(*high, map->data[i]);
    }
}

/* ---- random maps ------------------------------------------------------ */

static void add_suns(ibl_image *map, test_random *r)
{
    for (int k = 1 + test_random_below(r, 4); k > 0; k--) {
        /* One draw per statement: C leaves the order of arguments open. */
        const int x = test_random_below(r, map->width);
        const int y = test_random_below(r, map->height);
        const double red = 1e6 * test_random_unit(r);
        const double green = 1e6 * test_random_unit(r);
        map_set(map, x, y, (float)red, (float)green, 1e6f);
    }
}

static void fill_smooth(ibl_image *map, test_random *r)
{
    double lobes[3][3];
    for (int k = 0; k < 3; k++) {
        const int face = test_random_below(r, 6);
        const double x = test_random_unit(r) - 0.5;
        const double y = test_random_unit(r) - 0.5;
        truth_cube_direction(1, face, x, y, lobes[k]);
    }
    for (int i = 0; i < map->width * map->height; i++) {
        double d[3];
        truth_latlong_direction(map->width, map->height, i % map->width,
                                i / map->width, d);
        for (int k = 0; k < 3; k++) {
            const double *e = lobes[k];
            const double c = d[0] * e[0] + d[1] * e[1] + d[2] * e[2];
            map->data[3 * i + k] = (float)(0.1 + exp(3 * (c - 1)));
        }
    }
}

static void blacken(ibl_image *map, test_random *r)
{
    const int row = test_random_below(r, map->height),
              column = test_random_below(r, map->width);
    for (int i = 0; i < map->width * map->height; i++) {
        if (i / map->width == row || i % map->width == column ||
            i / map->width % 3 == 1)
            memset(map->data + 3 * i, 0, 3 * sizeof(float));
    }
}

/* Value i of a map that is w wide. */
static float value_of(map_kind kind, test_random *r, int i, int w)
{
    switch (kind) {
    case MAP_NOISE:
    case MAP_SUNNY:
    case MAP_BLACK_ROWS:
        return (float)test_random_unit(r);
    case MAP_DECADES:
        return (float)pow(10, 16 * test_random_unit(r) - 8);
    case MAP_DENORMAL:
        return ldexpf((float)test_random_below(r, 1 << 23), -149);
    case MAP_DENORMAL_HALVES:
        return ldexpf((float)test_random_below(r, 1024), -24);
    case MAP_CHECKERBOARD:
        return (float)((i / 3 % w + i / 3 / w + (i % 3 == 1)) & 1);
    default:
        return 0;
    }
}

ibl_image map_of_kind(ibl_ctx *ctx, test_random *r, map_kind kind, int width,
                      int height)
{
    ibl_image map = map_constant(ctx, width, height, 0);
    for (size_t i = 0; i < map_floats(&map); i++)
        map.data[i] = value_of(kind, r, (int)i, width);
    if (kind == MAP_SUNS || kind == MAP_SUNNY)
        add_suns(&map, r);
    if (kind == MAP_SMOOTH)
        fill_smooth(&map, r);
    if (kind == MAP_BLACK_ROWS)
        blacken(&map, r);
    return map;
}

/* ---- cubes ------------------------------------------------------------ */

ibl_cube cube_alloc(ibl_ctx *ctx, int n, int levels)
{
    ibl_cube cube = {0};
    if (ibl_cube_alloc(ctx, n, levels, &cube))
        exit(1);
    return test_cube(cube);
}

size_t cube_floats(const ibl_cube *cube)
{
    return 3 * ibl_cube_texels(cube->size, cube->levels);
}

/* The rectangle from a face's middle to (u, v), seen from the cube's. */
static double corner_angle(double u, double v)
{
    return atan2(u * v, sqrt(1 + u * u + v * v));
}

static double texel_angle(int n, int x, int y)
{
    const double u = 2.0 * x / n - 1, v = 2.0 * y / n - 1, d = 2.0 / n;
    return corner_angle(u, v) + corner_angle(u + d, v + d) -
           corner_angle(u + d, v) - corner_angle(u, v + d);
}

double cube_mean(const ibl_cube *cube, int level, int channel)
{
    const int n = ibl_cube_edge(cube->size, level);
    const float *p = ibl_cube_face(cube, level, 0);
    double sum = 0;
    for (int i = 0; i < IBL_FACES * n * n; i++)
        sum += texel_angle(n, i % n, i / n % n) * (double)p[3 * i + channel];
    return sum / (4 * M_PI);
}

double cube_nrmse(const ibl_cube *a, const ibl_cube *b, int level)
{
    const int n = ibl_cube_edge(a->size, level);
    const float *p = ibl_cube_face(a, level, 0);
    const float *q = ibl_cube_face(b, level, 0);
    double error = 0, norm = 0;
    for (int i = 0; i < 3 * IBL_FACES * n * n; i++) {
        error += pow((double)p[i] - (double)q[i], 2);
        norm += pow((double)q[i], 2);
    }
    return norm > 0 ? sqrt(error / norm) : sqrt(error);
}

/* ---- bakes ------------------------------------------------------------ */

ibl_cube cube_level0(ibl_ctx *ctx, const ibl_image *map, double yaw, int n)
{
    ibl_cube cube = cube_alloc(ctx, n, 1);
    if (ibl_cube_from_latlong(ctx, map, yaw, &cube))
        exit(1);
    return cube;
}

static void free_result(void *result)
{
    ibl_bake_result_free(result);
}

ibl_bake_result map_bake(ibl_ctx *ctx, const ibl_image *map,
                         const ibl_bake_options *options)
{
    const ibl_environment env = {.image = map};
    ibl_bake_result r = {0};
    if (ibl_bake_environment(ctx, &env, options, &r))
        exit(1);
    test_defer_copy(free_result, &r, sizeof r);
    return r;
}
