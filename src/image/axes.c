/* SPDX-License-Identifier: MIT */
#include "image/axes.h"

#include <stdbool.h>
#include <string.h>

#include "core/context.h"
#include "image/cube.h"

/* Its own inverse. */
static void mirror(ibl_mirror across, double d[3])
{
    const double x = d[0], z = d[2];

    d[0] = across == IBL_MIRROR_XZ ? z : across == IBL_MIRROR_X ? -x : x;
    d[2] = across == IBL_MIRROR_XZ ? x : across == IBL_MIRROR_Z ? -z : z;
}

const char *ibl_mirror_name(ibl_mirror mirror)
{
    static const char *const names[] = {[IBL_MIRROR_NONE] = "none",
                                        [IBL_MIRROR_X] = "x",
                                        [IBL_MIRROR_Z] = "z",
                                        [IBL_MIRROR_XZ] = "xz"};

    return (unsigned)mirror <= IBL_MIRROR_XZ ? names[mirror] : "unknown";
}

const char *ibl_up_name(ibl_up up)
{
    return up == IBL_UP_Y ? "y" : up == IBL_UP_Z ? "z" : "unknown";
}

void ibl_axes_turn(ibl_axes axes, int back, const double from[3], double to[3])
{
    double d[3] = {from[0], from[1], from[2]};

    if (!back)
        mirror(axes.mirror, d);
    if (axes.up == IBL_UP_Z) {
        const double y = d[1];
        d[1] = back ? d[2] : -d[2];
        d[2] = back ? -y : y;
    }
    if (back)
        mirror(axes.mirror, d);
    memcpy(to, d, sizeof d);
}

ibl_status ibl_check_axes(ibl_ctx *ctx, ibl_axes axes)
{
    if (axes.mirror < IBL_MIRROR_NONE || axes.mirror > IBL_MIRROR_XZ)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "mirror %d: must be none (%d), x (%d), z (%d) or xz "
                        "(%d)",
                        (int)axes.mirror, IBL_MIRROR_NONE, IBL_MIRROR_X,
                        IBL_MIRROR_Z, IBL_MIRROR_XZ);
    if (axes.up < IBL_UP_Y || axes.up > IBL_UP_Z)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "up %d: must be y (%d) or z (%d)", (int)axes.up,
                        IBL_UP_Y, IBL_UP_Z);
    return IBL_OK;
}

/* ---- cubes -------------------------------------------------------------- */

typedef struct turning {
    int n, words, back;
    ibl_axes axes;
    const char *from;
    char *to;
} turning;

/* The texel of `from` with the direction of texel (x, y) of a face of `to`. */
static size_t texel_from(const turning *t, int face, int x, int y)
{
    const ibl_face_axes *axes = &ibl_face[face];
    const int u = 2 * x + 1 - t->n, v = 2 * y + 1 - t->n;
    double d[3], from[3];

    for (int k = 0; k < 3; k++)
        d[k] = t->n * axes->forward[k] + u * axes->right[k] + v * axes->down[k];
    ibl_axes_turn(t->axes, !t->back, d, from);
    return ibl_cube_texel_at(t->n,
                             (int[]){(int)from[0], (int)from[1], (int)from[2]});
}

/* A row of a face comes from a row or a column. */
static void row_job(void *arg, int row, int worker)
{
    const turning *t = arg;
    const int n = t->n, face = row / n, y = row % n;
    const ptrdiff_t bytes = 4 * (ptrdiff_t)t->words;
    const size_t first = texel_from(t, face, 0, y);
    const ptrdiff_t step =
        (ptrdiff_t)texel_from(t, face, n > 1, y) - (ptrdiff_t)first;
    const char *from = t->from + (ptrdiff_t)first * bytes;
    char *to = t->to + (ptrdiff_t)row * n * bytes;
    (void)worker;

    for (int x = 0; x < n; x++, from += step * bytes)
        for (int w = 0; w < t->words; w++, to += 4)
            memcpy(to, from + 4 * (ptrdiff_t)w, 4);
}

ibl_status ibl_level_turn_axes(ibl_ctx *ctx, ibl_level_shape s, int words,
                               ibl_axes axes, int back, const void *from,
                               void *to)
{
    turning t = {s.width, words, back, axes, from, to};
    const ptrdiff_t bytes = 4 * (ptrdiff_t)words;

    if (s.projection == IBL_PROJECTION_CUBE)
        return ibl_run(ctx, NULL, IBL_FACES * t.n, row_job, &t);
    /* Mirrors put centres of texels onto centres in every projection. */
    for (int i = 0; i < s.width * s.height; i++) {
        double d[3];
        int at[3];
        ibl_level_direction(&s, 0, i % s.width, i / s.width, d);
        ibl_axes_turn(axes, !back, d, d);
        ibl_level_texel(&s, d, at);
        memcpy(t.to + i * bytes,
               t.from + ((ptrdiff_t)at[2] * s.width + at[1]) * bytes,
               (size_t)bytes);
    }
    return IBL_OK;
}

ibl_status ibl_cube_turn_axes(ibl_ctx *ctx, const ibl_cube *from, ibl_axes axes,
                              int back, ibl_cube *out)
{
    ibl_cube to = {0};
    ibl_status status = ibl_check_map(ctx, from);
    const bool flat = !status && from->projection != IBL_PROJECTION_CUBE;
    if (!status && !out)
        status = ibl_missing(ctx, "ibl_cube_turn_axes: out");
    if (!status)
        status = ibl_check_axes(ctx, axes);
    if (!status && flat && axes.up != IBL_UP_Y)
        status = ibl_fail(ctx, IBL_ERR_ARGUMENT,
                          "an %s map with +Z up: must be a cube",
                          ibl_projection_name(from->projection));
    if (!status)
        status = ibl_cube_alloc_as(ctx, from->projection, from->size,
                                   from->levels, &to);
    for (int l = 0; !status && l < from->levels; l++)
        status = ibl_level_turn_axes(ctx, ibl_map_shape(from, l), 3, axes, back,
                                     ibl_cube_face(from, l, 0),
                                     ibl_cube_face(&to, l, 0));
    if (status)
        ibl_cube_free(&to);
    else
        *out = to;
    return status;
}
