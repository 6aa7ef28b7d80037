/* SPDX-License-Identifier: MIT */
#include "kern/gather.h"

#include <immintrin.h>
#include <stddef.h>

#if defined(__AVX512F__)

/* As AVX2 below, sixteen samples at a time and all four taps of a lookup
 * in one vector. */

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

static void gather_simd(const ibl_gather_samples *s,
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

#elif defined(__AVX2__)

/*
 * Eight samples at a time are turned, projected and given their weights. What
 * that leaves, an offset and four weights for each sample and mip, goes to
 * the sums, which take the taps of one sample at a time: a row's two texels
 * are one load, and one permutation puts the two weights beside them.
 */

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

static void gather_simd(const ibl_gather_samples *s,
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

#else /* SSE2 */

/* As AVX2 above, four samples at a time and one texel a vector. */

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

static void gather_simd(const ibl_gather_samples *s,
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

#endif

void IBL_FOR_ISA(ibl_gather_init)(ibl_gather_dsp *dsp)
{
    dsp->gather = gather_simd;
}
