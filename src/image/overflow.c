/* SPDX-License-Identifier: MIT */
/*
 * Each channel is treated separately, from its brightest texel down. The full
 * texels connected to it form a patch. The patch's excess is spread over the
 * ring of texels around the patch, then over the ring around that, until none
 * is left. If a ring can hold the rest, each of its texels is filled by the
 * same part of its free room, which keeps a light symmetric. Else the ring
 * becomes full. So each texel is visited only a few times, for any excess.
 */
#include "image/overflow.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "image/cube.h"

typedef struct basin {
    float *level; /* copy of the input level */
    ibl_level_shape shape;
    int n, half;     /* of a cube */
    double *corner;  /* ibl_face_angle at the corners of half x half texels, a
                        quarter of a face; solid angles are its differences */
    uint32_t *queue; /* texels of a patch, then of its rings */
    bool *seen;      /* for each texel: it is in the queue */
    int channel;
    float max;
} basin;

static size_t texels_of(const basin *b)
{
    return ibl_level_texels(&b->shape);
}

static float *value(const basin *b, uint32_t texel)
{
    return b->level + 3 * (size_t)texel + b->channel;
}

static double angle_at(const basin *b, int x, int y)
{
    const size_t i = (size_t)(x < b->half ? x : b->n - 1 - x);
    const size_t j = (size_t)(y < b->half ? y : b->n - 1 - y);
    const size_t line = (size_t)b->half + 1;
    const double *top = b->corner + j * line + i, *bottom = top + line;
    return bottom[1] - bottom[0] - top[1] + top[0];
}

static double solid_angle(const basin *b, uint32_t texel)
{
    const uint32_t n = (uint32_t)b->shape.width;
    if (b->shape.projection != IBL_PROJECTION_CUBE)
        return ibl_level_solid_angle(&b->shape, (int)(texel % n),
                                     (int)(texel / n));
    return angle_at(b, (int)(texel % n), (int)(texel / n % n));
}

static bool basin_init(basin *b, const ibl_level_shape *shape)
{
    const bool flat = shape->projection != IBL_PROJECTION_CUBE;
    const int n = shape->width, half = flat ? 0 : (n + 1) / 2;
    const size_t line = (size_t)half + 1;

    *b = (basin){.shape = *shape, .n = n, .half = half};
    b->corner = ibl_alloc_array(line * line, sizeof *b->corner);
    b->queue = ibl_alloc_array(texels_of(b), sizeof *b->queue);
    b->seen = ibl_alloc_zeroed(texels_of(b), sizeof *b->seen);
    if (!b->corner || !b->queue || !b->seen)
        return false;
    for (int y = 0; y <= half; y++)
        for (int x = 0; x <= half; x++)
            b->corner[(size_t)y * line + (size_t)x] =
                ibl_face_angle(2.0 * x / n - 1, 2.0 * y / n - 1);
    return true;
}

static void basin_free(basin *b)
{
    ibl_free(b->corner);
    ibl_free(b->queue);
    ibl_free(b->seen);
}

/* ---- neighbours ------------------------------------------------------- */

/* Appends the unseen neighbours of a texel to the queue: those with a common
 * edge, with corners also those with a common corner, with full only full ones.
 * Returns the new end. */
static size_t add_neighbours(basin *b, uint32_t texel, bool corners, bool full,
                             size_t end)
{
    const bool flat = b->shape.projection != IBL_PROJECTION_CUBE;
    const int n = b->n, h = b->shape.height, x = (int)(texel % (uint32_t)n);
    const int line = (int)(texel / (uint32_t)n), face = line / h;
    const int y = line % h;

    for (int k = 0; k < 9; k++) {
        const int dx = k % 3 - 1, dy = k / 3 - 1, i = x + dx, j = y + dy;
        const bool beyond_x = i < 0 || i >= n, beyond_y = j < 0 || j >= h;
        if (k == 4 || (dx && dy && !corners) || (beyond_x && beyond_y && !flat))
            continue; /* only three texels meet at a cube's corner */
        const uint32_t to = flat ? (uint32_t)ibl_flat_neighbour(&b->shape, i, j)
                            : beyond_x || beyond_y
                                ? (uint32_t)ibl_cube_neighbour(n, face, i, j)
                                : texel + (uint32_t)(dy * n + dx);
        if (b->seen[to] || (full && *value(b, to) < b->max))
            continue;
        b->seen[to] = true;
        b->queue[end++] = to;
    }
    return end;
}

/* ---- pouring ---------------------------------------------------------- */

/* Cuts a texel to max; returns its excess light, 0 for infinity. */
static double take_excess(const basin *b, uint32_t texel)
{
    float *at = value(b, texel);
    if (!(*at > b->max))
        return 0;
    const double excess = isinf(*at) ? 0 : (double)*at - (double)b->max;
    *at = b->max;
    return excess * solid_angle(b, texel);
}

/* Light that a texel can still take; 0 for NaN and below -max. */
static double room(const basin *b, uint32_t texel)
{
    const float at = *value(b, texel);
    if (!(at < b->max && at >= -b->max))
        return 0;
    return ((double)b->max - (double)at) * solid_angle(b, texel);
}

/* Spreads light over the ring queue[first..end - 1]; returns the rest. */
static double fill(const basin *b, size_t first, size_t end, double light)
{
    double all = 0;

    for (size_t i = first; i < end; i++) {
        light += take_excess(b, b->queue[i]);
        all += room(b, b->queue[i]);
    }
    const double part = light < all ? light / all : 1;
    for (size_t i = first; i < end; i++) {
        float *at = value(b, b->queue[i]);
        if (room(b, b->queue[i]) > 0)
            *at = part < 1 ? (float)((double)*at +
                                     part * ((double)b->max - (double)*at))
                           : b->max;
    }
    return light < all ? 0 : light - all;
}

/*
 * Spreads the excess of the patch around a texel; returns the rest that found
 * no room. Every second ring leaves out its corners, which gives octagons:
 * rounder than squares.
 */
static double pour(basin *b, uint32_t texel)
{
    size_t first = 0, end = 1;
    double light = 0;
    bool corners = true;

    b->queue[0] = texel;
    b->seen[texel] = true;
    for (size_t i = 0; i < end; i++) {
        light += take_excess(b, b->queue[i]);
        end = add_neighbours(b, b->queue[i], true, true, end);
    }
    for (size_t last = end; light > 0; corners = !corners, last = end) {
        for (; first < last; first++)
            end = add_neighbours(b, b->queue[first], corners, false, end);
        if (end == last)
            break;
        light = fill(b, last, end, light);
    }
    for (size_t i = 0; i < end; i++)
        b->seen[b->queue[i]] = false;
    return light;
}

typedef struct source {
    float value;
    uint32_t texel;
} source;

static int brightest_first(const void *a, const void *b)
{
    const source *x = a, *y = b;
    if (x->value != y->value)
        return x->value < y->value ? 1 : -1;
    return (x->texel > y->texel) - (x->texel < y->texel);
}

/* Treats a whole channel; adds the lost light to *lost. False: no memory. */
static bool spread(basin *b, int channel, float max, double *lost)
{
    size_t count = 0, found = 0;

    b->channel = channel;
    b->max = max;
    for (uint32_t i = 0; i < texels_of(b); i++)
        count += *value(b, i) > max;
    source *sources = ibl_alloc_array(count, sizeof *sources);
    if (!sources)
        return false;
    for (uint32_t i = 0; i < texels_of(b); i++)
        if (*value(b, i) > max)
            sources[found++] = (source){*value(b, i), i};
    qsort(sources, count, sizeof *sources, brightest_first);
    for (size_t i = 0; i < count; i++)
        if (*value(b, sources[i].texel) > max)
            *lost += pour(b, sources[i].texel);
    ibl_free(sources);
    return true;
}

/* ---- the call --------------------------------------------------------- */

typedef struct survey {
    size_t texels; /* texels above max in a channel */
    double light, beyond;
} survey;

static bool any_beyond(const float max[3], size_t texels, const float *level)
{
    bool any = false;
    for (size_t i = 0; i < 3 * texels; i += 3)
        any |= (level[i] > max[0]) | (level[i + 1] > max[1]) |
               (level[i + 2] > max[2]);
    return any;
}

/* Measures the light and its excess; infinite components count as 0. */
static survey look(const basin *b, const float max[3], const float *level)
{
    survey s = {0};

    for (uint32_t i = 0; i < texels_of(b); i++, level += 3) {
        const double angle = solid_angle(b, i);
        bool beyond = false;
        for (int c = 0; c < 3; c++) {
            const double value = isfinite(level[c]) ? (double)level[c] : 0;
            s.light += angle * value;
            if (value > (double)max[c])
                s.beyond += angle * (value - (double)max[c]);
            beyond |= level[c] > max[c];
        }
        s.texels += beyond;
    }
    return s;
}

/* Spreads the excess in a copy of the level. */
static bool spread_all(basin *b, const float max[3], const float *level,
                       double *lost)
{
    bool ok = true;

    b->level = ibl_alloc_array(texels_of(b), 3 * sizeof *level);
    if (!b->level)
        return false;
    memcpy(b->level, level, 3 * texels_of(b) * sizeof *level);
    for (int c = 0; c < 3 && ok; c++)
        ok = spread(b, c, max[c], lost);
    return ok;
}

ibl_status ibl_overflow_settle(ibl_ctx *ctx, ibl_overflow how,
                               const float max[3], const ibl_level_shape *shape,
                               const float *level, float **settled,
                               ibl_overflow_level *out)
{
    basin b;

    *settled = NULL;
    *out = (ibl_overflow_level){0};
    if (!any_beyond(max, ibl_level_texels(shape), level))
        return IBL_OK;
    bool ok = basin_init(&b, shape);
    if (ok) {
        const survey s = look(&b, max, level);
        double lost = how == IBL_OVERFLOW_SPREAD ? 0 : s.beyond;
        if (how == IBL_OVERFLOW_SPREAD)
            ok = spread_all(&b, max, level, &lost);
        out->texels = s.texels;
        if (s.light > 0) {
            /* A smaller difference is rounding. */
            const double moved = s.beyond - lost;
            out->lost = lost / s.light;
            out->moved = moved > 1e-12 * s.beyond ? moved / s.light : 0;
        }
    }
    basin_free(&b);
    if (!ok) {
        ibl_free(b.level);
        return ibl_no_memory(ctx, "light that a format cannot hold");
    }
    *settled = b.level;
    return IBL_OK;
}
