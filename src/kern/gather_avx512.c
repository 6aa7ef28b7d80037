/* SPDX-License-Identifier: MIT */
/* As gather_avx2.c, sixteen samples at a time and all four taps of a lookup
 * in one vector. */
#include <immintrin.h>
#include <stddef.h>

#include "kern/gather.h"

enum {
    BATCH = 16
};

/* One mip's part of a batch. The weights of sample i, w00 w01 w10 w11, are
 * part i / 4 of vector i % 4. */
typedef struct taps {
    _Alignas(64) int at[BATCH]; /* of the first tap, in floats */
    _Alignas(64) float weight[4 * BATCH];
} taps;

typedef struct points {
    __m512 u, v;
    __m512i face;
} points;

static inline __m512 component(const ibl_gather_samples *s, int i,
                               const float frame[9], int k)
{
    const __m512 x =
        _mm512_mul_ps(_mm512_load_ps(s->x + i), _mm512_set1_ps(frame[k]));
    const __m512 y =
        _mm512_mul_ps(_mm512_load_ps(s->y + i), _mm512_set1_ps(frame[3 + k]));
    const __m512 z =
        _mm512_mul_ps(_mm512_load_ps(s->z + i), _mm512_set1_ps(frame[6 + k]));
    return _mm512_add_ps(_mm512_add_ps(x, y), z);
}

static inline points project(const ibl_gather_samples *s, int i,
                             const float frame[9])
{
    const __m512 sign = _mm512_set1_ps(-0.0f);
    const __m512 dx = component(s, i, frame, 0);
    const __m512 dy = component(s, i, frame, 1);
    const __m512 dz = component(s, i, frame, 2);
    const __m512 ax = _mm512_andnot_ps(sign, dx);
    const __m512 ay = _mm512_andnot_ps(sign, dy);
    const __m512 az = _mm512_andnot_ps(sign, dz);
    const __mmask16 on_x = _mm512_mask_cmp_ps_mask(
        _mm512_cmp_ps_mask(ax, ay, _CMP_GE_OQ), ax, az, _CMP_GE_OQ);
    const __mmask16 on_y =
        (__mmask16)(~on_x & _mm512_cmp_ps_mask(ay, az, _CMP_GE_OQ));

    const __m512 major =
        _mm512_mask_mov_ps(_mm512_mask_mov_ps(dz, on_y, dy), on_x, dx);
    const __m512 negative = _mm512_and_ps(major, sign);
    const __m512 size = _mm512_andnot_ps(sign, major);
    __m512 u = _mm512_mask_xor_ps(dx, on_x, dz, sign);
    u = _mm512_mask_xor_ps(u, (__mmask16)~on_y, u, negative);
    const __m512 v =
        _mm512_mask_xor_ps(_mm512_xor_ps(dy, sign), on_y, dz, negative);
    __m512i axis =
        _mm512_mask_mov_epi32(_mm512_set1_epi32(4), on_y, _mm512_set1_epi32(2));
    axis = _mm512_mask_mov_epi32(axis, on_x, _mm512_setzero_si512());
    const __m512i face = _mm512_add_epi32(
        axis, _mm512_srli_epi32(_mm512_castps_si512(major), 31));
    return (points){_mm512_div_ps(u, size), _mm512_div_ps(v, size), face};
}

/* Offsets and weights of the lookups at one mip. */
static inline void make_taps(const points *p, const ibl_gather_level *level,
                             const float *weights, taps *t)
{
    const int edge = level->edge;
    const __m512i row = _mm512_set1_epi32(edge + 2);
    const __m512 half = _mm512_set1_ps(0.5f * (float)edge);
    const __m512 start = _mm512_set1_ps(0.5f * (float)edge + 0.5f);
    const __m512 one = _mm512_set1_ps(1);
    const __m512 px = _mm512_add_ps(_mm512_mul_ps(p->u, half), start);
    const __m512 py = _mm512_add_ps(_mm512_mul_ps(p->v, half), start);
    const __m512i x = _mm512_cvttps_epi32(px), y = _mm512_cvttps_epi32(py);
    const __m512 fx = _mm512_sub_ps(px, _mm512_cvtepi32_ps(x));
    const __m512 fy = _mm512_sub_ps(py, _mm512_cvtepi32_ps(y));
    const __m512i rows = _mm512_add_epi32(_mm512_mullo_epi32(p->face, row), y);
    const __m512i at = _mm512_add_epi32(_mm512_mullo_epi32(rows, row), x);
    _mm512_store_si512(t->at, _mm512_slli_epi32(at, 2));

    const __m512 w = _mm512_load_ps(weights);
    const __m512 gx = _mm512_sub_ps(one, fx);
    const __m512 top = _mm512_mul_ps(w, _mm512_sub_ps(one, fy));
    const __m512 bottom = _mm512_mul_ps(w, fy);
    const __m512 w00 = _mm512_mul_ps(top, gx), w01 = _mm512_mul_ps(top, fx);
    const __m512 w10 = _mm512_mul_ps(bottom, gx);
    const __m512 w11 = _mm512_mul_ps(bottom, fx);
    const __m512d lo0 = _mm512_castps_pd(_mm512_unpacklo_ps(w00, w01));
    const __m512d lo1 = _mm512_castps_pd(_mm512_unpacklo_ps(w10, w11));
    const __m512d hi0 = _mm512_castps_pd(_mm512_unpackhi_ps(w00, w01));
    const __m512d hi1 = _mm512_castps_pd(_mm512_unpackhi_ps(w10, w11));
    double *out = (double *)t->weight;
    _mm512_store_pd(out, _mm512_unpacklo_pd(lo0, lo1));
    _mm512_store_pd(out + 8, _mm512_unpackhi_pd(lo0, lo1));
    _mm512_store_pd(out + 16, _mm512_unpacklo_pd(hi0, hi1));
    _mm512_store_pd(out + 24, _mm512_unpackhi_pd(hi0, hi1));
}

/* One sample's taps, added. */
static inline __m512 add_taps(const taps *t, int i, const float *texels,
                              size_t row, __m512 sum)
{
    const __m512i spread =
        _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
    const __m512i mine = _mm512_add_epi32(spread, _mm512_set1_epi32(i / 4 * 4));
    const float *p = texels + (size_t)t->at[i];
    const __m512 w = _mm512_load_ps(t->weight + i % 4 * BATCH);
    const __m512 texel =
        _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(p)),
                           _mm256_loadu_ps(p + row), 1);
    return _mm512_fmadd_ps(texel, _mm512_permutexvar_ps(mine, w), sum);
}

/* Samples i to i + 3; two sums, so that one addition need not wait for the
 * last. */
static inline void add_four(const taps *t, int i, const float *texels,
                            size_t row, __m512 sums[2])
{
    sums[0] = add_taps(t, i, texels, row, sums[0]);
    sums[1] = add_taps(t, i + 1, texels, row, sums[1]);
    sums[0] = add_taps(t, i + 2, texels, row, sums[0]);
    sums[1] = add_taps(t, i + 3, texels, row, sums[1]);
}

static inline void add_batch(const taps *t, int count,
                             const ibl_gather_level *level, __m512 sums[2])
{
    const size_t row = 4 * ((size_t)level->edge + 2);
    if (count >= BATCH) {
        add_four(t, 0, level->texels, row, sums);
        add_four(t, 4, level->texels, row, sums);
        add_four(t, 8, level->texels, row, sums);
        add_four(t, 12, level->texels, row, sums);
    } else {
        for (int i = 0; i < count; i++)
            sums[0] = add_taps(t, i, level->texels, row, sums[0]);
    }
}

void ibl_gather_avx512(const ibl_gather_samples *s,
                       const ibl_gather_level *levels, const float frame[9],
                       double rgb[3])
{
    __m256d total = _mm256_setzero_pd();
    for (int g = 0; g < s->group_count; g++) {
        const ibl_gather_group group = s->groups[g];
        const ibl_gather_level *level = &levels[group.level];
        __m512 fine[2] = {_mm512_setzero_ps(), _mm512_setzero_ps()};
        __m512 coarse[2] = {_mm512_setzero_ps(), _mm512_setzero_ps()};
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
        const __m512 sum = _mm512_add_ps(_mm512_add_ps(fine[0], fine[1]),
                                         _mm512_add_ps(coarse[0], coarse[1]));
        const __m256 pair = _mm256_add_ps(_mm512_castps512_ps256(sum),
                                          _mm512_extractf32x8_ps(sum, 1));
        const __m128 one = _mm_add_ps(_mm256_castps256_ps128(pair),
                                      _mm256_extractf128_ps(pair, 1));
        total = _mm256_add_pd(total, _mm256_cvtps_pd(one));
    }
    double out[4];
    _mm256_storeu_pd(out, total);
    for (int c = 0; c < 3; c++)
        rgb[c] = out[c];
}
