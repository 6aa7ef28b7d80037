/* SPDX-License-Identifier: MIT */
/*
 * Turns, projects and weights VF samples at a time. The result is an offset and
 * four weights for each sample and mip; the sums then add the texels of one
 * sample at a time.
 */
#include "kern/gather.h"

#include <stddef.h>

#include "kern/lanes.h"

enum {
    CHAINS = 16 / VF
};

/* Lookups of VF samples in one mip. The weights of sample i, w00 w01 w10 w11,
 * are quarter i / 4 of vector i % 4. */
typedef struct taps {
    _Alignas(64) int at[VF]; /* of the first texel, in floats */
    _Alignas(64) float weight[4 * VF];
} taps;

typedef struct points {
    vf u, v;
    vi face;
} points;

static inline vf component(const ibl_gather_samples *s, int i,
                           const float frame[9], int k)
{
    return vf_load(s->x + i) * vf_all(frame[k]) +
           vf_load(s->y + i) * vf_all(frame[3 + k]) +
           vf_load(s->z + i) * vf_all(frame[6 + k]);
}

/* The face that a direction hits, and the point (u, v) on it, -1..1: the
 * inverse of the rule in ibl/ibl.h. Among equal components x wins, then y. */
static inline points project(const ibl_gather_samples *s, int i,
                             const float frame[9])
{
    const vi sign = (vi)vf_all(-0.0f);
    const vf dx = component(s, i, frame, 0);
    const vf dy = component(s, i, frame, 1);
    const vf dz = component(s, i, frame, 2);
    const vf ax = (vf)(~sign & (vi)dx), ay = (vf)(~sign & (vi)dy);
    const vf az = (vf)(~sign & (vi)dz);
    const vi on_x = (vi)(ax >= ay) & (vi)(ax >= az);
    const vi on_y = ~on_x & (vi)(ay >= az);

    const vi major = (vi)vf_either(on_x, dx, vf_either(on_y, dy, dz));
    const vi negative = major & sign;
    const vf size = (vf)(major & ~sign);
    const vi u =
        (vi)vf_either(on_x, (vf)((vi)dz ^ sign), dx) ^ (~on_y & negative);
    const vf v = vf_either(on_y, (vf)((vi)dz ^ negative), (vf)((vi)dy ^ sign));
    /* Face 0, 2 or 4, plus 1 where the sign is set. */
    const vi axis = ~on_x & (4 - (on_y & 2));
    return (points){(vf)u / size, v / size, axis - (negative != 0)};
}

/* Computes offsets and weights of the lookups in one mip. In the bordered face
 * the centres of the face's own texels are at 1..edge. So positions are in
 * 0.5..edge + 0.5, and all four taps are inside (edge + 2)^2. */
static inline void make_taps(const points *p, const ibl_gather_level *level,
                             const float *weights, taps *t)
{
    const int row = level->edge + 2;
    const vf half = vf_all(0.5f * (float)level->edge);
    const vf start = vf_all(0.5f * (float)level->edge + 0.5f);
    const vf one = vf_all(1);
    const vf px = p->u * half + start, py = p->v * half + start;
    const vi x = __builtin_convertvector(px, vi);
    const vi y = __builtin_convertvector(py, vi);
    const vf fx = px - __builtin_convertvector(x, vf);
    const vf fy = py - __builtin_convertvector(y, vf);
    *(vi *)t->at = ((p->face * row + y) * row + x) * 4;

    const vf w = vf_load(weights), gx = one - fx;
    const vf top = w * (one - fy), bottom = w * fy;
    vf v[4] = {top * gx, top * fx, bottom * gx, bottom * fx};
    vf_transpose(v);
    for (int k = 0; k < 4; k++)
        vf_store(t->weight + k * VF, v[k]);
}

/* Adds one sample's texels, in sixteen lanes: four for each of them. */
#if VF == 8
static inline void add_taps(const taps *t, int i, const float *texels,
                            size_t row, vf sums[CHAINS])
{
    const float *p = texels + (size_t)t->at[i], *w = t->weight + i % 4 * VF;
    sums[0] = vf_fma(vf_load(p), vf_spread(w, i / 4 * 2), sums[0]);
    sums[1] = vf_fma(vf_load(p + row), vf_spread(w, i / 4 * 2 + 1), sums[1]);
}
#else
static inline void add_taps(const taps *t, int i, const float *texels,
                            size_t row, vf sums[CHAINS])
{
    const float *p = texels + (size_t)t->at[i], *q = p + row;
    const float *w = t->weight + VF * i;
    sums[0] = vf_fma(vf_load(p), vf_all(w[0]), sums[0]);
    sums[1] = vf_fma(vf_load(p + 4), vf_all(w[1]), sums[1]);
    sums[2] = vf_fma(vf_load(q), vf_all(w[2]), sums[2]);
    sums[3] = vf_fma(vf_load(q + 4), vf_all(w[3]), sums[3]);
}
#endif

static inline void add_batch(const taps *t, int count,
                             const ibl_gather_level *level, vf sums[CHAINS])
{
    const size_t row = 4 * ((size_t)level->edge + 2);
    if (count >= VF) {
#pragma GCC unroll 8
        for (int i = 0; i < VF; i++)
            add_taps(t, i, level->texels, row, sums);
    } else {
        for (int i = 0; i < count; i++)
            add_taps(t, i, level->texels, row, sums);
    }
}

static void gather(const ibl_gather_samples *s, const ibl_gather_level *levels,
                   const float frame[9], double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int g = 0; g < s->group_count; g++) {
        const ibl_gather_group group = s->groups[g];
        const ibl_gather_level *level = &levels[group.level];
        vf fine[CHAINS] = {{0}}, coarse[CHAINS] = {{0}};
        for (int done = 0; done < group.count; done += VF) {
            const int first = group.first + done, left = group.count - done;
            const points p = project(s, first, frame);
            taps t;
            make_taps(&p, level, s->fine + first, &t);
            add_batch(&t, left, level, fine);
            if (group.mips == 2) {
                make_taps(&p, level + 1, s->coarse + first, &t);
                add_batch(&t, left, level + 1, coarse);
            }
        }
        float sum[4];
#pragma GCC unroll 4
        for (int k = 0; k < CHAINS; k++)
            fine[k] += coarse[k];
        vq_store(sum, vf_fold_16(fine));
        for (int c = 0; c < 3; c++)
            rgb[c] += (double)sum[c];
    }
}

IBL_VECTOR_KERNEL(ibl_gather, gather)
