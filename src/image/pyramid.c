/* SPDX-License-Identifier: MIT */
#include "image/pyramid.h"

#include <assert.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"

enum {
    CHANNELS = 4
};

/* The level being filled. */
typedef struct fill {
    const ibl_cube *cube;
    ibl_pyramid *pyramid;
    int level, edge;
} fill;

/* x and y are -1..edge. */
static float *texel_at(const fill *a, int face, int x, int y)
{
    const size_t row = (size_t)a->edge + 2;
    return a->pyramid->texels[a->level] +
           CHANNELS *
               (((size_t)face * row + (size_t)(y + 1)) * row + (size_t)(x + 1));
}

/* ---- borders ---------------------------------------------------------- */

static void copy_neighbour(const fill *a, int face, int x, int y)
{
    const int n = a->edge, i = (int)ibl_cube_neighbour(n, face, x, y);
    memcpy(texel_at(a, face, x, y), texel_at(a, i / n / n, i % n, i / n % n),
           CHANNELS * sizeof(float));
}

/* (x, y) is a corner of the border, (ix, iy) the face's texel next to it. */
static void fill_corner(const fill *a, int face, int x, int y, int ix, int iy)
{
    const float *own = texel_at(a, face, ix, iy);
    const float *beside = texel_at(a, face, x, iy);
    const float *above = texel_at(a, face, ix, y);
    float *dst = texel_at(a, face, x, y);
    for (int c = 0; c < CHANNELS; c++)
        dst[c] =
            (float)(((double)own[c] + (double)beside[c] + (double)above[c]) /
                    3);
}

static void fill_border(const fill *a)
{
    const int n = a->edge;
    for (int face = 0; face < IBL_FACES; face++) {
        for (int i = 0; i < n; i++) {
            copy_neighbour(a, face, i, -1);
            copy_neighbour(a, face, i, n);
            copy_neighbour(a, face, -1, i);
            copy_neighbour(a, face, n, i);
        }
        fill_corner(a, face, -1, -1, 0, 0);
        fill_corner(a, face, n, -1, n - 1, 0);
        fill_corner(a, face, -1, n, 0, n - 1);
        fill_corner(a, face, n, n, n - 1, n - 1);
    }
}

/* ---- level 0 ---------------------------------------------------------- */

/* Finds the smallest value of each channel. */
static void find_floor(const fill *a)
{
    float *low = a->pyramid->floor;
    const size_t floats = 3 * ibl_cube_texels(a->edge, 1);
    memcpy(low, a->cube->data, 3 * sizeof *low);
    for (size_t i = 3; i < floats; i += 3)
        for (size_t c = 0; c < 3; c++)
            low[c] =
                a->cube->data[i + c] < low[c] ? a->cube->data[i + c] : low[c];
}

/* Copies row y of every face; mirrored texels get exactly the same angle. */
static void copy_job(void *arg, int y, int worker)
{
    const fill *a = arg;
    const int n = a->edge, mirror = n - 1 - y;
    const float *low = a->pyramid->floor;
    (void)worker;
    for (int x = 0; x < n; x++) {
        const float angle = (float)ibl_cube_solid_angle(
            n, x < n - 1 - x ? x : n - 1 - x, y < mirror ? y : mirror);
        for (int face = 0; face < IBL_FACES; face++) {
            const float *src = ibl_cube_face(a->cube, 0, face) +
                               3 * ((size_t)y * (size_t)n + (size_t)x);
            float *dst = texel_at(a, face, x, y);
            for (int c = 0; c < 3; c++)
                dst[c] = src[c] - low[c];
            dst[3] = angle;
        }
    }
}

/* ---- the levels below ------------------------------------------------- */

/* Writes one texel from 4x4 texels at above, row floats from row to row. */
static void reduce(const float *above, size_t row, float *dst)
{
    static const double tent[4] = {0.125, 0.375, 0.375, 0.125};
    double sum[CHANNELS] = {0};
    for (int j = 0; j < 4; j++, above += row) {
        for (int i = 0; i < 4; i++) {
            const float *p = above + CHANNELS * i;
            const double w = tent[i] * tent[j] * (double)p[3];
            for (int c = 0; c < 3; c++)
                sum[c] += w * (double)p[c];
            sum[3] += w;
        }
    }
    for (int c = 0; c < 3; c++)
        dst[c] = (float)(sum[c] / sum[3]);
    /* A texel above adds 1/4 of its angle in all: its weights sum to 1/4. */
    dst[3] = (float)(4 * sum[3]);
}

static void reduce_job(void *arg, int y, int worker)
{
    const fill *a = arg;
    const fill above = {
        .pyramid = a->pyramid, .level = a->level - 1, .edge = 2 * a->edge};
    (void)worker;
    for (int face = 0; face < IBL_FACES; face++) {
        for (int x = 0; x < a->edge; x++)
            reduce(texel_at(&above, face, 2 * x - 1, 2 * y - 1),
                   CHANNELS * ((size_t)above.edge + 2),
                   texel_at(a, face, x, y));
    }
}

/* ---- all together ----------------------------------------------------- */

static size_t level_floats(int size, int level)
{
    const size_t row = (size_t)ibl_cube_edge(size, level) + 2;
    return CHANNELS * IBL_FACES * row * row;
}

static ibl_status fill_levels(ibl_ctx *ctx, fill *a)
{
    a->edge = a->pyramid->size;
    find_floor(a);
    ibl_status status = ibl_run(ctx, NULL, a->edge, copy_job, a);
    if (!status)
        fill_border(a);
    for (a->level = 1; a->level < a->pyramid->levels && !status; a->level++) {
        assert(a->edge % 2 == 0);
        a->edge /= 2;
        status = ibl_run(ctx, NULL, a->edge, reduce_job, a);
        if (!status)
            fill_border(a);
    }
    return status;
}

ibl_status ibl_pyramid_create(ibl_ctx *ctx, const ibl_cube *cube, int levels,
                              ibl_pyramid *pyramid)
{
    size_t floats = 0;
    for (int l = 0; l < levels; l++)
        floats += level_floats(cube->size, l);
    *pyramid = (ibl_pyramid){.size = cube->size, .levels = levels};
    pyramid->texels[0] = ibl_alloc_array(floats, sizeof(float));
    if (!pyramid->texels[0])
        return ibl_no_memory(ctx, "a cube for lookups");
    for (int l = 1; l < levels; l++)
        pyramid->texels[l] =
            pyramid->texels[l - 1] + level_floats(cube->size, l - 1);

    fill a = {.cube = cube, .pyramid = pyramid};
    ibl_progress(ctx, "mips", 0);
    const ibl_status status = fill_levels(ctx, &a);
    if (status)
        ibl_pyramid_free(pyramid);
    else
        ibl_progress(ctx, "mips", 1);
    return status;
}

void ibl_pyramid_free(ibl_pyramid *pyramid)
{
    if (!pyramid)
        return;
    ibl_free(pyramid->texels[0]);
    *pyramid = (ibl_pyramid){0};
}
