/* SPDX-License-Identifier: MIT */
#include "kern/gather.h"

#include <math.h>
#include <stddef.h>

/* The face that a direction hits, and the point (u, v) on it, -1..1: the
 * inverse of the rule in ibl/ibl.h. Among equal components x wins, then y. */
static int project(const float d[3], float *u, float *v)
{
    const float ax = fabsf(d[0]), ay = fabsf(d[1]), az = fabsf(d[2]);
    if (ax >= ay && ax >= az) {
        *u = (d[0] < 0 ? d[2] : -d[2]) / ax;
        *v = -d[1] / ax;
        return d[0] < 0 ? 1 : 0;
    }
    if (ay >= az) {
        *u = d[0] / ay;
        *v = (d[1] < 0 ? -d[2] : d[2]) / ay;
        return d[1] < 0 ? 3 : 2;
    }
    *u = (d[2] < 0 ? -d[0] : d[0]) / az;
    *v = -d[1] / az;
    return d[2] < 0 ? 5 : 4;
}

/*
 * Adds weight times the bilinear lookup. In the bordered face the centres of
 * the face's own texels are at 1..edge. So positions are in 0.5..edge + 0.5,
 * and all four taps are inside (edge + 2)^2.
 */
static void add_lookup(const ibl_gather_level *level, int face, float u,
                       float v, float weight, float sum[3])
{
    const float half = 0.5f * (float)level->edge;
    const float px = u * half + (half + 0.5f);
    const float py = v * half + (half + 0.5f);
    const int x = (int)px, y = (int)py;
    const float fx = px - (float)x, fy = py - (float)y;
    const float top = weight * (1 - fy), bottom = weight * fy;
    const size_t row = (size_t)level->edge + 2;
    const float *t = level->texels +
                     4 * (((size_t)face * row + (size_t)y) * row + (size_t)x);
    const float *b = t + 4 * row;
    for (int c = 0; c < 3; c++) {
        sum[c] += top * (1 - fx) * t[c];
        sum[c] += top * fx * t[4 + c];
        sum[c] += bottom * (1 - fx) * b[c];
        sum[c] += bottom * fx * b[4 + c];
    }
}

static void gather(const ibl_gather_samples *s, const ibl_gather_level *levels,
                   const float frame[9], double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int g = 0; g < s->group_count; g++) {
        const ibl_gather_group *group = &s->groups[g];
        float sum[3] = {0, 0, 0};
        for (int i = group->first; i < group->first + group->count; i++) {
            float d[3], u, v;
            for (int k = 0; k < 3; k++)
                d[k] = s->x[i] * frame[k] + s->y[i] * frame[3 + k] +
                       s->z[i] * frame[6 + k];
            const int face = project(d, &u, &v);
            add_lookup(&levels[group->level], face, u, v, s->fine[i], sum);
            if (group->mips == 2)
                add_lookup(&levels[group->level + 1], face, u, v, s->coarse[i],
                           sum);
        }
        for (int c = 0; c < 3; c++)
            rgb[c] += sum[c];
    }
}

IBL_KERNEL(ibl_gather, gather)
