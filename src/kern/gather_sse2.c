/* SPDX-License-Identifier: MIT */
/* As gather_avx2.c, four samples at a time and one texel a vector. */
#include <emmintrin.h>
#include <stddef.h>

#include "kern/gather.h"

enum {
    BATCH = 4
};

/* One mip's part of a batch: weights w00 w01 w10 w11 of each sample. */
typedef struct taps {
    _Alignas(16) int at[BATCH]; /* of the first tap, in floats */
    _Alignas(16) float weight[4 * BATCH];
} taps;

typedef struct points {
    __m128 u, v;
    __m128i face;
} points;

static inline __m128 blend(__m128 a, __m128 b, __m128 mask)
{
    return _mm_or_ps(_mm_andnot_ps(mask, a), _mm_and_ps(mask, b));
}

/* a * b for products below 2^31. */
static inline __m128i mul_epi32(__m128i a, __m128i b)
{
    const __m128i even = _mm_mul_epu32(a, b);
    const __m128i odd =
        _mm_mul_epu32(_mm_srli_si128(a, 4), _mm_srli_si128(b, 4));
    return _mm_unpacklo_epi32(_mm_shuffle_epi32(even, _MM_SHUFFLE(3, 1, 2, 0)),
                              _mm_shuffle_epi32(odd, _MM_SHUFFLE(3, 1, 2, 0)));
}

static inline __m128 component(const ibl_gather_samples *s, int i,
                               const float frame[9], int k)
{
    const __m128 x = _mm_mul_ps(_mm_load_ps(s->x + i), _mm_set1_ps(frame[k]));
    const __m128 y =
        _mm_mul_ps(_mm_load_ps(s->y + i), _mm_set1_ps(frame[3 + k]));
    const __m128 z =
        _mm_mul_ps(_mm_load_ps(s->z + i), _mm_set1_ps(frame[6 + k]));
    return _mm_add_ps(_mm_add_ps(x, y), z);
}

static inline points project(const ibl_gather_samples *s, int i,
                             const float frame[9])
{
    const __m128 sign = _mm_set1_ps(-0.0f);
    const __m128 dx = component(s, i, frame, 0);
    const __m128 dy = component(s, i, frame, 1);
    const __m128 dz = component(s, i, frame, 2);
    const __m128 ax = _mm_andnot_ps(sign, dx);
    const __m128 ay = _mm_andnot_ps(sign, dy);
    const __m128 az = _mm_andnot_ps(sign, dz);
    const __m128 on_x = _mm_and_ps(_mm_cmpge_ps(ax, ay), _mm_cmpge_ps(ax, az));
    const __m128 on_y = _mm_andnot_ps(on_x, _mm_cmpge_ps(ay, az));

    const __m128 major = blend(blend(dz, dy, on_y), dx, on_x);
    const __m128 negative = _mm_and_ps(major, sign);
    const __m128 size = _mm_andnot_ps(sign, major);
    __m128 u = blend(dx, _mm_xor_ps(dz, sign), on_x);
    u = _mm_xor_ps(u, _mm_andnot_ps(on_y, negative));
    const __m128 v =
        blend(_mm_xor_ps(dy, sign), _mm_xor_ps(dz, negative), on_y);

    const __m128i two =
        _mm_and_si128(_mm_castps_si128(on_y), _mm_set1_epi32(2));
    const __m128i axis = _mm_andnot_si128(
        _mm_castps_si128(on_x), _mm_sub_epi32(_mm_set1_epi32(4), two));
    const __m128i face =
        _mm_add_epi32(axis, _mm_srli_epi32(_mm_castps_si128(major), 31));
    return (points){_mm_div_ps(u, size), _mm_div_ps(v, size), face};
}

/* Offsets and weights of the lookups at one mip. */
static inline void make_taps(const points *p, const ibl_gather_level *level,
                             const float *weights, taps *t)
{
    const int edge = level->edge;
    const __m128i row = _mm_set1_epi32(edge + 2);
    const __m128 half = _mm_set1_ps(0.5f * (float)edge);
    const __m128 start = _mm_set1_ps(0.5f * (float)edge + 0.5f);
    const __m128 one = _mm_set1_ps(1);
    const __m128 px = _mm_add_ps(_mm_mul_ps(p->u, half), start);
    const __m128 py = _mm_add_ps(_mm_mul_ps(p->v, half), start);
    const __m128i x = _mm_cvttps_epi32(px), y = _mm_cvttps_epi32(py);
    const __m128 fx = _mm_sub_ps(px, _mm_cvtepi32_ps(x));
    const __m128 fy = _mm_sub_ps(py, _mm_cvtepi32_ps(y));
    const __m128i rows = _mm_add_epi32(mul_epi32(p->face, row), y);
    const __m128i at = _mm_add_epi32(mul_epi32(rows, row), x);
    _mm_store_si128((__m128i *)t->at, _mm_slli_epi32(at, 2));

    const __m128 w = _mm_load_ps(weights);
    const __m128 gx = _mm_sub_ps(one, fx);
    const __m128 top = _mm_mul_ps(w, _mm_sub_ps(one, fy));
    const __m128 bottom = _mm_mul_ps(w, fy);
    __m128 w00 = _mm_mul_ps(top, gx), w01 = _mm_mul_ps(top, fx);
    __m128 w10 = _mm_mul_ps(bottom, gx), w11 = _mm_mul_ps(bottom, fx);
    _MM_TRANSPOSE4_PS(w00, w01, w10, w11);
    _mm_store_ps(t->weight, w00);
    _mm_store_ps(t->weight + 4, w01);
    _mm_store_ps(t->weight + 8, w10);
    _mm_store_ps(t->weight + 12, w11);
}

/* Adds one sample's taps: sums[0] the upper row, sums[1] the lower. */
static inline void add_taps(const taps *t, int i, const float *texels,
                            size_t row, __m128 sums[2])
{
    const float *p = texels + (size_t)t->at[i];
    const __m128 w = _mm_load_ps(t->weight + 4 * i);
    const __m128 a = _mm_mul_ps(_mm_loadu_ps(p), _mm_shuffle_ps(w, w, 0x00));
    const __m128 b =
        _mm_mul_ps(_mm_loadu_ps(p + 4), _mm_shuffle_ps(w, w, 0x55));
    const __m128 c =
        _mm_mul_ps(_mm_loadu_ps(p + row), _mm_shuffle_ps(w, w, 0xaa));
    const __m128 d =
        _mm_mul_ps(_mm_loadu_ps(p + row + 4), _mm_shuffle_ps(w, w, 0xff));
    sums[0] = _mm_add_ps(sums[0], _mm_add_ps(a, b));
    sums[1] = _mm_add_ps(sums[1], _mm_add_ps(c, d));
}

static inline void add_batch(const taps *t, int count,
                             const ibl_gather_level *level, __m128 sums[2])
{
    const size_t row = 4 * ((size_t)level->edge + 2);
    if (count >= BATCH) {
        for (int i = 0; i < BATCH; i++)
            add_taps(t, i, level->texels, row, sums);
    } else {
        for (int i = 0; i < count; i++)
            add_taps(t, i, level->texels, row, sums);
    }
}

void ibl_gather_sse2(const ibl_gather_samples *s,
                     const ibl_gather_level *levels, const float frame[9],
                     double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int g = 0; g < s->group_count; g++) {
        const ibl_gather_group group = s->groups[g];
        const ibl_gather_level *level = &levels[group.level];
        __m128 fine[2] = {_mm_setzero_ps(), _mm_setzero_ps()};
        __m128 coarse[2] = {_mm_setzero_ps(), _mm_setzero_ps()};
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
        float out[4];
        _mm_storeu_ps(out, _mm_add_ps(_mm_add_ps(fine[0], fine[1]),
                                      _mm_add_ps(coarse[0], coarse[1])));
        for (int c = 0; c < 3; c++)
            rgb[c] += out[c];
    }
}
