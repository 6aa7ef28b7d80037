/* SPDX-License-Identifier: MIT */
/*
 * Vectors as wide as the file that includes this is compiled for. A kernel
 * whose versions differ only in width is written once with them: see isa.h.
 *
 * Arithmetic, comparisons and masks are written with operators, of gcc and
 * clang; a fused multiply-add is asked for by name, vf_fma(a, b, c) = a b + c,
 * and is a product and a sum where the CPU has none.
 */
#ifndef IBL_KERN_LANES_H
#define IBL_KERN_LANES_H

#include <immintrin.h>

#if defined(__AVX512F__)
#define VF 16 /* floats in a vf */
#define MM(operation) _mm512_##operation
typedef __m512 vf;
typedef __m512d vd;
#define VI __m512i
#elif defined(__AVX2__) && defined(__FMA__)
#define VF 8
#define MM(operation) _mm256_##operation
typedef __m256 vf;
typedef __m256d vd;
#define VI __m256i
#else
#define VF 4
#define MM(operation) _mm_##operation
typedef __m128 vf;
typedef __m128d vd;
#endif
#define VD (VF / 2) /* doubles in a vd */

/* As many integers; a comparison's are 0 or -1. */
typedef int vi __attribute__((vector_size(4 * VF)));
typedef long long vl __attribute__((vector_size(8 * VD)));

static inline vf vf_load(const float *p)
{
    return MM(loadu_ps)(p);
}

static inline void vf_store(float *p, vf v)
{
    MM(storeu_ps)(p, v);
}

static inline vf vf_all(float x)
{
    return MM(set1_ps)(x);
}

static inline vf vf_sqrt(vf v)
{
    return MM(sqrt_ps)(v);
}

/* b where one of them is NaN. */
static inline vf vf_min(vf a, vf b)
{
    return MM(min_ps)(a, b);
}

static inline vf vf_max(vf a, vf b)
{
    return MM(max_ps)(a, b);
}

static inline vf vf_either(vi mask, vf yes, vf no)
{
    return (vf)((mask & (vi)yes) | (~mask & (vi)no));
}

static inline vd vd_load(const double *p)
{
    return MM(loadu_pd)(p);
}

static inline void vd_store(double *p, vd v)
{
    MM(storeu_pd)(p, v);
}

static inline vd vd_all(double x)
{
    return MM(set1_pd)(x);
}

static inline vd vd_sqrt(vd v)
{
    return MM(sqrt_pd)(v);
}

/* What a CPU without AVX2 lacks. */
#if VF == 4
static inline vf vf_fma(vf a, vf b, vf c)
{
    return a * b + c;
}

static inline vd vd_fma(vd a, vd b, vd c)
{
    return a * b + c;
}

static inline vi vi_max(vi a, vi b)
{
    return (vi)vf_either(a > b, (vf)a, (vf)b);
}
#else
static inline vf vf_fma(vf a, vf b, vf c)
{
    return MM(fmadd_ps)(a, b, c);
}

static inline vd vd_fma(vd a, vd b, vd c)
{
    return MM(fmadd_pd)(a, b, c);
}

static inline vi vi_max(vi a, vi b)
{
    return (vi)MM(max_epi32)((VI)a, (VI)b);
}
#endif

/* VD floats from p, widened; and the sum of a vector's quarters of four. */
#if VF == 16
static inline vd vd_load_floats(const float *p)
{
    return _mm512_cvtps_pd(_mm256_loadu_ps(p));
}

static inline void vd_store_floats(float *p, vd v)
{
    _mm256_storeu_ps(p, _mm512_cvtpd_ps(v));
}

static inline __m128 vf_fold(vf v)
{
    const __m256 half =
        _mm256_add_ps(_mm512_castps512_ps256(v), _mm512_extractf32x8_ps(v, 1));
    return _mm_add_ps(_mm256_castps256_ps128(half),
                      _mm256_extractf128_ps(half, 1));
}
#elif VF == 8
static inline vd vd_load_floats(const float *p)
{
    return _mm256_cvtps_pd(_mm_loadu_ps(p));
}

static inline void vd_store_floats(float *p, vd v)
{
    _mm_storeu_ps(p, _mm256_cvtpd_ps(v));
}

static inline __m128 vf_fold(vf v)
{
    return _mm_add_ps(_mm256_castps256_ps128(v), _mm256_extractf128_ps(v, 1));
}
#else
static inline vd vd_load_floats(const float *p)
{
    return _mm_cvtps_pd(_mm_castsi128_ps(_mm_loadl_epi64((const __m128i *)p)));
}

static inline void vd_store_floats(float *p, vd v)
{
    _mm_storel_pi((__m64 *)p, _mm_cvtpd_ps(v));
}

static inline __m128 vf_fold(vf v)
{
    return v;
}
#endif

/* Turns rows into columns, in each quarter of four. */
static inline void vf_transpose(vf v[4])
{
    const vf a = MM(unpacklo_ps)(v[0], v[1]), b = MM(unpackhi_ps)(v[0], v[1]);
    const vf c = MM(unpacklo_ps)(v[2], v[3]), d = MM(unpackhi_ps)(v[2], v[3]);
    v[0] = MM(shuffle_ps)(a, c, 0x44);
    v[1] = MM(shuffle_ps)(a, c, 0xEE);
    v[2] = MM(shuffle_ps)(b, d, 0x44);
    v[3] = MM(shuffle_ps)(b, d, 0xEE);
}

#endif
