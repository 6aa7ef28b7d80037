/* SPDX-License-Identifier: MIT */
/*
 * Vectors as wide as the file that includes this is compiled for. A kernel
 * whose versions differ only in width is written once with them: see isa.h.
 *
 * Arithmetic is written with operators, of gcc and clang; a fused
 * multiply-add is asked for by name, vf_fma(a, b, c) = a b + c, and is a
 * product and a sum where the CPU has none.
 */
#ifndef IBL_KERN_LANES_H
#define IBL_KERN_LANES_H

#include <immintrin.h>

#if defined(__AVX512F__)
#define VF 16 /* floats in a vf */
#define VD 8  /* doubles in a vd */
typedef __m512 vf;
typedef __m512d vd;

static inline vf vf_load(const float *p)
{
    return _mm512_loadu_ps(p);
}

static inline void vf_store(float *p, vf v)
{
    _mm512_storeu_ps(p, v);
}

static inline vf vf_all(float x)
{
    return _mm512_set1_ps(x);
}

static inline vf vf_sqrt(vf v)
{
    return _mm512_sqrt_ps(v);
}

/* b where one of them is NaN. */
static inline vf vf_min(vf a, vf b)
{
    return _mm512_min_ps(a, b);
}

static inline vf vf_max(vf a, vf b)
{
    return _mm512_max_ps(a, b);
}

static inline vf vf_fma(vf a, vf b, vf c)
{
    return _mm512_fmadd_ps(a, b, c);
}

static inline vd vd_load(const double *p)
{
    return _mm512_loadu_pd(p);
}

static inline void vd_store(double *p, vd v)
{
    _mm512_storeu_pd(p, v);
}

static inline vd vd_all(double x)
{
    return _mm512_set1_pd(x);
}

static inline vd vd_sqrt(vd v)
{
    return _mm512_sqrt_pd(v);
}

static inline vd vd_fma(vd a, vd b, vd c)
{
    return _mm512_fmadd_pd(a, b, c);
}

/* VD floats from p, widened. */
static inline vd vd_load_floats(const float *p)
{
    return _mm512_cvtps_pd(_mm256_loadu_ps(p));
}

static inline void vd_store_floats(float *p, vd v)
{
    _mm256_storeu_ps(p, _mm512_cvtpd_ps(v));
}

#elif defined(__AVX2__) && defined(__FMA__)
#define VF 8
#define VD 4
typedef __m256 vf;
typedef __m256d vd;

static inline vf vf_load(const float *p)
{
    return _mm256_loadu_ps(p);
}

static inline void vf_store(float *p, vf v)
{
    _mm256_storeu_ps(p, v);
}

static inline vf vf_all(float x)
{
    return _mm256_set1_ps(x);
}

static inline vf vf_sqrt(vf v)
{
    return _mm256_sqrt_ps(v);
}

static inline vf vf_min(vf a, vf b)
{
    return _mm256_min_ps(a, b);
}

static inline vf vf_max(vf a, vf b)
{
    return _mm256_max_ps(a, b);
}

static inline vf vf_fma(vf a, vf b, vf c)
{
    return _mm256_fmadd_ps(a, b, c);
}

static inline vd vd_load(const double *p)
{
    return _mm256_loadu_pd(p);
}

static inline void vd_store(double *p, vd v)
{
    _mm256_storeu_pd(p, v);
}

static inline vd vd_all(double x)
{
    return _mm256_set1_pd(x);
}

static inline vd vd_sqrt(vd v)
{
    return _mm256_sqrt_pd(v);
}

static inline vd vd_fma(vd a, vd b, vd c)
{
    return _mm256_fmadd_pd(a, b, c);
}

static inline vd vd_load_floats(const float *p)
{
    return _mm256_cvtps_pd(_mm_loadu_ps(p));
}

static inline void vd_store_floats(float *p, vd v)
{
    _mm_storeu_ps(p, _mm256_cvtpd_ps(v));
}

#else
#define VF 4
#define VD 2
typedef __m128 vf;
typedef __m128d vd;

static inline vf vf_load(const float *p)
{
    return _mm_loadu_ps(p);
}

static inline void vf_store(float *p, vf v)
{
    _mm_storeu_ps(p, v);
}

static inline vf vf_all(float x)
{
    return _mm_set1_ps(x);
}

static inline vf vf_sqrt(vf v)
{
    return _mm_sqrt_ps(v);
}

static inline vf vf_min(vf a, vf b)
{
    return _mm_min_ps(a, b);
}

static inline vf vf_max(vf a, vf b)
{
    return _mm_max_ps(a, b);
}

static inline vf vf_fma(vf a, vf b, vf c)
{
    return a * b + c;
}

static inline vd vd_load(const double *p)
{
    return _mm_loadu_pd(p);
}

static inline void vd_store(double *p, vd v)
{
    _mm_storeu_pd(p, v);
}

static inline vd vd_all(double x)
{
    return _mm_set1_pd(x);
}

static inline vd vd_sqrt(vd v)
{
    return _mm_sqrt_pd(v);
}

static inline vd vd_fma(vd a, vd b, vd c)
{
    return a * b + c;
}

static inline vd vd_load_floats(const float *p)
{
    return _mm_cvtps_pd(_mm_castsi128_ps(_mm_loadl_epi64((const __m128i *)p)));
}

static inline void vd_store_floats(float *p, vd v)
{
    _mm_storel_pi((__m64 *)p, _mm_cvtpd_ps(v));
}
#endif

#endif
