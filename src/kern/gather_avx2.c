/* SPDX-License-Identifier: MIT */
/*
 * Eight samples at a time are turned, projected and given their weights. What
 * that leaves, an offset and four weights for each sample and mip, goes to
 * the sums, which take the taps of one sample at a time: a row's two texels
 * are one load, and one permutation puts the two weights beside them.
 */
#include <immintrin.h>
#include <stddef.h>

#include "kern/gather.h"

enum {
    BATCH = 8
};

/* One mip's part of a batch. The weights of sample i, w00 w01 w10 w11, are
 * half i / 4 of vector i % 4. */
typedef struct taps {
    _Alignas(32) int at[BATCH]; /* of the first tap, in floats */
    _Alignas(32) float weight[4 * BATCH];
} taps;

typedef struct points {
    __m256 u, v;
    __m256i face;
} points;

static inline __m256 component(const ibl_gather_samples *s, int i,
                               const float frame[9], int k)
{
    const __m256 x =
        _mm256_mul_ps(_mm256_load_ps(s->x + i), _mm256_broadcast_ss(frame + k));
    const __m256 y = _mm256_mul_ps(_mm256_load_ps(s->y + i),
                                   _mm256_broadcast_ss(frame + 3 + k));
    const __m256 z = _mm256_mul_ps(_mm256_load_ps(s->z + i),
                                   _mm256_broadcast_ss(frame + 6 + k));
    return _mm256_add_ps(_mm256_add_ps(x, y), z);
}

static inline points project(const ibl_gather_samples *s, int i,
                             const float frame[9])
{
    const __m256 sign = _mm256_set1_ps(-0.0f);
    const __m256 dx = component(s, i, frame, 0);
    const __m256 dy = component(s, i, frame, 1);
    const __m256 dz = component(s, i, frame, 2);
    const __m256 ax = _mm256_andnot_ps(sign, dx);
    const __m256 ay = _mm256_andnot_ps(sign, dy);
    const __m256 az = _mm256_andnot_ps(sign, dz);
    const __m256 on_x = _mm256_and_ps(_mm256_cmp_ps(ax, ay, _CMP_GE_OQ),
                                      _mm256_cmp_ps(ax, az, _CMP_GE_OQ));
    const __m256 on_y =
        _mm256_andnot_ps(on_x, _mm256_cmp_ps(ay, az, _CMP_GE_OQ));

    /* major component; u is -z x z times the signs -, none, -: see
     * project() in gather.c. */
    __m256 major = _mm256_blendv_ps(dz, dy, on_y);
    major = _mm256_blendv_ps(major, dx, on_x);
    const __m256 negative = _mm256_and_ps(major, sign);
    const __m256 size = _mm256_andnot_ps(sign, major);
    __m256 u = _mm256_blendv_ps(dx, _mm256_xor_ps(dz, sign), on_x);
    u = _mm256_xor_ps(u, _mm256_andnot_ps(on_y, negative));
    const __m256 v = _mm256_blendv_ps(_mm256_xor_ps(dy, sign),
                                      _mm256_xor_ps(dz, negative), on_y);

    const __m256i four = _mm256_set1_epi32(4);
    const __m256i axis = _mm256_andnot_si256(
        _mm256_castps_si256(on_x),
        _mm256_sub_epi32(four, _mm256_and_si256(_mm256_castps_si256(on_y),
                                                _mm256_set1_epi32(2))));
    return (points){
        _mm256_div_ps(u, size), _mm256_div_ps(v, size),
        _mm256_add_epi32(axis,
                         _mm256_srli_epi32(_mm256_castps_si256(major), 31))};
}

/* Offsets and weights of the lookups at one mip. */
static inline void make_taps(const points *p, const ibl_gather_level *level,
                             const float *weights, taps *t)
{
    const int edge = level->edge, row = edge + 2;
    const __m256 half = _mm256_set1_ps(0.5f * (float)edge);
    const __m256 start = _mm256_set1_ps(0.5f * (float)edge + 0.5f);
    const __m256 one = _mm256_set1_ps(1);
    const __m256 px = _mm256_add_ps(_mm256_mul_ps(p->u, half), start);
    const __m256 py = _mm256_add_ps(_mm256_mul_ps(p->v, half), start);
    const __m256i x = _mm256_cvttps_epi32(px), y = _mm256_cvttps_epi32(py);
    const __m256 fx = _mm256_sub_ps(px, _mm256_cvtepi32_ps(x));
    const __m256 fy = _mm256_sub_ps(py, _mm256_cvtepi32_ps(y));
    const __m256i rows = _mm256_add_epi32(
        _mm256_mullo_epi32(p->face, _mm256_set1_epi32(row)), y);
    const __m256i at =
        _mm256_add_epi32(_mm256_mullo_epi32(rows, _mm256_set1_epi32(row)), x);
    _mm256_store_si256((__m256i *)t->at, _mm256_slli_epi32(at, 2));

    const __m256 w = _mm256_load_ps(weights);
    const __m256 gx = _mm256_sub_ps(one, fx);
    const __m256 top = _mm256_mul_ps(w, _mm256_sub_ps(one, fy));
    const __m256 bottom = _mm256_mul_ps(w, fy);
    const __m256 w00 = _mm256_mul_ps(top, gx), w01 = _mm256_mul_ps(top, fx);
    const __m256 w10 = _mm256_mul_ps(bottom, gx);
    const __m256 w11 = _mm256_mul_ps(bottom, fx);
    const __m256d lo0 = _mm256_castps_pd(_mm256_unpacklo_ps(w00, w01));
    const __m256d lo1 = _mm256_castps_pd(_mm256_unpacklo_ps(w10, w11));
    const __m256d hi0 = _mm256_castps_pd(_mm256_unpackhi_ps(w00, w01));
    const __m256d hi1 = _mm256_castps_pd(_mm256_unpackhi_ps(w10, w11));
    double *out = (double *)t->weight;
    _mm256_store_pd(out, _mm256_unpacklo_pd(lo0, lo1));
    _mm256_store_pd(out + 4, _mm256_unpackhi_pd(lo0, lo1));
    _mm256_store_pd(out + 8, _mm256_unpacklo_pd(hi0, hi1));
    _mm256_store_pd(out + 12, _mm256_unpackhi_pd(hi0, hi1));
}

/* Adds one sample's taps: sums[0] the upper rows, sums[1] the lower. */
static inline void add_taps(const taps *t, int i, const float *texels,
                            size_t row, __m256 sums[2])
{
    const __m256i part = _mm256_set1_epi32(i / 4 * 4);
    const __m256i upper =
        _mm256_add_epi32(part, _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1));
    const __m256i lower =
        _mm256_add_epi32(part, _mm256_setr_epi32(2, 2, 2, 2, 3, 3, 3, 3));
    const float *p = texels + (size_t)t->at[i];
    const __m256 w = _mm256_load_ps(t->weight + i % 4 * BATCH);
    sums[0] = _mm256_fmadd_ps(_mm256_loadu_ps(p),
                              _mm256_permutevar8x32_ps(w, upper), sums[0]);
    sums[1] = _mm256_fmadd_ps(_mm256_loadu_ps(p + row),
                              _mm256_permutevar8x32_ps(w, lower), sums[1]);
}

static inline void add_four(const taps *t, int i, const float *texels,
                            size_t row, __m256 sums[2])
{
    add_taps(t, i, texels, row, sums);
    add_taps(t, i + 1, texels, row, sums);
    add_taps(t, i + 2, texels, row, sums);
    add_taps(t, i + 3, texels, row, sums);
}

static inline void add_batch(const taps *t, int count,
                             const ibl_gather_level *level, __m256 sums[2])
{
    const size_t row = 4 * ((size_t)level->edge + 2);
    if (count >= BATCH) {
        add_four(t, 0, level->texels, row, sums);
        add_four(t, 4, level->texels, row, sums);
    } else {
        for (int i = 0; i < count; i++)
            add_taps(t, i, level->texels, row, sums);
    }
}

void ibl_gather_avx2(const ibl_gather_samples *s,
                     const ibl_gather_level *levels, const float frame[9],
                     double rgb[3])
{
    __m256d total = _mm256_setzero_pd();
    for (int g = 0; g < s->group_count; g++) {
        const ibl_gather_group group = s->groups[g];
        const ibl_gather_level *level = &levels[group.level];
        __m256 fine[2] = {_mm256_setzero_ps(), _mm256_setzero_ps()};
        __m256 coarse[2] = {_mm256_setzero_ps(), _mm256_setzero_ps()};
        for (int done = 0; done < group.count; done += BATCH) {
            const int first = group.first + done, left = group.count - done;
            const points p = project(s, first, frame);
            taps t;
            make_taps(&p, level, s->fine + first, &t);
            add_batch(&t, left, level, fine);
            if (group.mips == 2) {
                taps c;
                make_taps(&p, level + 1, s->coarse + first, &c);
                add_batch(&c, left, level + 1, coarse);
            }
        }
        const __m256 sum = _mm256_add_ps(_mm256_add_ps(fine[0], fine[1]),
                                         _mm256_add_ps(coarse[0], coarse[1]));
        const __m128 both = _mm_add_ps(_mm256_castps256_ps128(sum),
                                       _mm256_extractf128_ps(sum, 1));
        total = _mm256_add_pd(total, _mm256_cvtps_pd(both));
    }
    double out[4];
    _mm256_storeu_pd(out, total);
    for (int c = 0; c < 3; c++)
        rgb[c] = out[c];
}
