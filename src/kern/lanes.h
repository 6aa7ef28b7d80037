/* SPDX-License-Identifier: MIT */
/*
 * Vectors as wide as the instruction set of the including file allows. Kernels
 * whose versions differ only in width are written once with them: see isa.h.
 *
 * With IBL_PLAIN there are no intrinsics, and vectors are of 16 bytes: the
 * compiler makes of them what the CPU has.
 *
 * Arithmetic, comparisons and masks use the operators of gcc and clang. Only a
 * fused multiply-add has a name, vf_fma(a, b, c) = a b + c; it is a product and
 * a sum where the CPU has none. vf_min(a, b) and vf_max(a, b) are b where a is
 * NaN; b is not.
 */
#ifndef IBL_KERN_LANES_H
#define IBL_KERN_LANES_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>
#ifdef IBL_PLAIN
#elif defined(__aarch64__)
#include <arm_neon.h>
#define IBL_NEON
#else
#include <immintrin.h>
#endif

#if defined(__AVX2__) && defined(__FMA__)
#define VF 8 /* floats in a vf */
#define MM(operation) _mm256_##operation
typedef __m256 vf;
typedef __m256d vd;
#define VI __m256i
#elif defined(__SSE2__) && !defined(IBL_PLAIN)
#define VF 4
#define MM(operation) _mm_##operation
typedef __m128 vf;
typedef __m128d vd;
#else
#define VF 4
typedef float vf __attribute__((vector_size(16)));
typedef double vd __attribute__((vector_size(16)));
#endif

#define VD (VF / 2) /* doubles in a vd */

/* Registers for vectors. Plain C counts on what all CPUs have. */
#ifdef IBL_NEON
#define REGISTERS 32
#else
#define REGISTERS 16
#endif

/* VF integers; a comparison gives 0 or -1 in each. */
typedef int vi __attribute__((vector_size(4 * VF)));
typedef long long vl __attribute__((vector_size(8 * VD)));
typedef float vq __attribute__((vector_size(16))); /* a quad, see below */

static inline vf vf_either(vi mask, vf yes, vf no)
{
    return (vf)((mask & (vi)yes) | (~mask & (vi)no));
}

static inline vd vd_either(vl mask, vd yes, vd no)
{
    return (vd)((mask & (vl)yes) | (~mask & (vl)no));
}

#ifdef IBL_PLAIN
static inline vf vf_load(const float *p)
{
    vf v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline void vf_store(float *p, vf v)
{
    memcpy(p, &v, sizeof v);
}

static inline vf vf_all(float x)
{
    return (vf){x, x, x, x};
}

static inline vf vf_sqrt(vf v)
{
    return (vf){sqrtf(v[0]), sqrtf(v[1]), sqrtf(v[2]), sqrtf(v[3])};
}

static inline vf vf_min(vf a, vf b)
{
    return vf_either(a < b, a, b);
}

static inline vf vf_max(vf a, vf b)
{
    return vf_either(a > b, a, b);
}

static inline vd vd_load(const double *p)
{
    vd v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline void vd_store(double *p, vd v)
{
    memcpy(p, &v, sizeof v);
}

static inline vd vd_all(double x)
{
    return (vd){x, x};
}

static inline vd vd_sqrt(vd v)
{
    return (vd){sqrt(v[0]), sqrt(v[1])};
}

static inline bool vi_any(vi mask)
{
    return mask[0] | mask[1] | mask[2] | mask[3];
}
#elif defined(IBL_NEON)
static inline vf vf_load(const float *p)
{
    return vld1q_f32(p);
}

static inline void vf_store(float *p, vf v)
{
    vst1q_f32(p, v);
}

static inline vf vf_all(float x)
{
    return vdupq_n_f32(x);
}

static inline vf vf_sqrt(vf v)
{
    return vsqrtq_f32(v);
}

static inline vd vd_load(const double *p)
{
    return vld1q_f64(p);
}

static inline void vd_store(double *p, vd v)
{
    vst1q_f64(p, v);
}

static inline vd vd_all(double x)
{
    return vdupq_n_f64(x);
}

static inline vd vd_sqrt(vd v)
{
    return vsqrtq_f64(v);
}

static inline bool vi_any(vi mask)
{
    return vmaxvq_u32((uint32x4_t)mask) != 0;
}

static inline vf vf_fma(vf a, vf b, vf c)
{
    return vfmaq_f32(c, a, b);
}

static inline vd vd_fma(vd a, vd b, vd c)
{
    return vfmaq_f64(c, a, b);
}

static inline vf vf_min(vf a, vf b)
{
    return vminnmq_f32(a, b);
}

static inline vf vf_max(vf a, vf b)
{
    return vmaxnmq_f32(a, b);
}

static inline vi vi_max(vi a, vi b)
{
    return vmaxq_s32(a, b);
}

#define HALVES /* loads and stores VF of them, rounded to nearest even */
static inline vf vf_load_halves(const void *p)
{
    float16x4_t v;
    memcpy(&v, p, sizeof v);
    return vcvt_f32_f16(v);
}

static inline void vf_store_halves(void *p, vf v)
{
    const float16x4_t halves = vcvt_f16_f32(v);
    memcpy(p, &halves, sizeof halves);
}
#else
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

static inline vf vf_min(vf a, vf b)
{
    return MM(min_ps)(a, b);
}

static inline vf vf_max(vf a, vf b)
{
    return MM(max_ps)(a, b);
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

static inline bool vi_any(vi mask)
{
    return MM(movemask_ps)((vf)mask) != 0;
}

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

#ifndef MM
/* Transposes 4x4 floats, separately in each quad of the four vectors. */
static inline void vf_transpose(vf v[4])
{
    const vf a = __builtin_shufflevector(v[0], v[1], 0, 4, 1, 5);
    const vf b = __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7);
    const vf c = __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5);
    const vf d = __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7);
    v[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
    v[1] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
    v[2] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
    v[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}
#endif

/* Loads four vectors, by one instruction where there is one. */
static inline void vf_load_four(const float *p, vf v[4])
{
#ifdef IBL_NEON
    const float32x4x4_t four = vld1q_f32_x4(p);
#endif
#pragma GCC unroll 4
    for (size_t i = 0; i < 4; i++)
#ifdef IBL_NEON
        v[i] = four.val[i];
#else
        v[i] = vf_load(p + i * VF);
#endif
}

static inline vd vd_abs(vd v)
{
    return (vd)((vl)v & ~(vl)vd_all(-0.0));
}

/* Replacements for instructions that need AVX2. */
#if VF == 4 && !defined(IBL_NEON)
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
#elif VF > 4
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

/* a b - c d; the first product is rounded. */
static inline vf vf_less(vf a, vf b, vf c, vf d)
{
    return vf_fma(-c, d, a * b);
}

#if VF == 8
#define HALVES
static inline vf vf_load_halves(const void *p)
{
    return _mm256_cvtph_ps(_mm_loadu_si128(p));
}

static inline void vf_store_halves(void *p, vf v)
{
    _mm_storeu_si128(p, _mm256_cvtps_ph(v, _MM_FROUND_TO_NEAREST_INT));
}
#endif

/* Adds r w[i] to sums[i], i = 0..3. */
static inline void vf_add_four(vf r, const float *w, vf sums[4])
{
#ifdef IBL_NEON
    vf four = vf_load(w);
    __asm__("" : "+w"(four)); /* else gcc loads each of them */
    sums[0] = vfmaq_laneq_f32(sums[0], r, four, 0);
    sums[1] = vfmaq_laneq_f32(sums[1], r, four, 1);
    sums[2] = vfmaq_laneq_f32(sums[2], r, four, 2);
    sums[3] = vfmaq_laneq_f32(sums[3], r, four, 3);
#else
    sums[0] = vf_fma(r, vf_all(w[0]), sums[0]);
    sums[1] = vf_fma(r, vf_all(w[1]), sums[1]);
    sums[2] = vf_fma(r, vf_all(w[2]), sums[2]);
    sums[3] = vf_fma(r, vf_all(w[3]), sums[3]);
#endif
}

/* The same of doubles, i = 0, 1. */
static inline void vd_add_two(vd r, const double *w, vd sums[2])
{
#ifdef IBL_NEON
    vd two = vd_load(w);
    __asm__("" : "+w"(two));
    sums[0] = vfmaq_laneq_f64(sums[0], r, two, 0);
    sums[1] = vfmaq_laneq_f64(sums[1], r, two, 1);
#else
    sums[0] = vd_fma(r, vd_all(w[0]), sums[0]);
    sums[1] = vd_fma(r, vd_all(w[1]), sums[1]);
#endif
}

/* Loads VD floats as doubles, and stores doubles as VD floats. gcc 12 converts
 * vectors of another size in halves or single lanes. */
typedef float vd_floats
    __attribute__((vector_size(4 * VD), aligned(4), may_alias));

static inline vd vd_load_floats(const float *p)
{
#if VD == 4
    return _mm256_cvtps_pd(_mm_loadu_ps(p));
#elif defined(IBL_NEON)
    return vcvt_f64_f32(vld1_f32(p));
#else
    return __builtin_convertvector(*(const vd_floats *)p, vd);
#endif
}

static inline void vd_store_floats(float *p, vd v)
{
#if VD == 4
    _mm_storeu_ps(p, _mm256_cvtpd_ps(v));
#elif defined(IBL_NEON)
    vst1_f32(p, vcvt_f32_f64(v));
#else
    *(vd_floats *)p = __builtin_convertvector(v, vd_floats);
#endif
}

/* The first and the last VD lanes as doubles. */
static inline void vf_widen(vf v, vd half[2])
{
#ifdef IBL_NEON
    half[0] = vcvt_f64_f32(vget_low_f32(v));
    half[1] = vcvt_high_f64_f32(v);
#elif VD == 4
    half[0] = _mm256_cvtps_pd(_mm256_castps256_ps128(v));
    half[1] = _mm256_cvtps_pd(_mm256_extractf128_ps(v, 1));
#else
    float floats[VF] __attribute__((aligned(64)));

    vf_store(floats, v);
    half[0] = vd_load_floats(floats);
    half[1] = vd_load_floats(floats + VD);
#endif
}

/*
 * Quads are the groups of four floats in a vector, VF / 4 of them.
 * vf_all_quads: the same quad everywhere. vf_load_quads: quad i from p[i].
 * vf_quad: quad k. vf_spread: quad i is filled with w[VF / 4 k + i]; w has
 * eight floats. vi_any: whether any lane is set.
 */
static inline vq vq_load(const float *p)
{
    vq v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline void vq_store(float *p, vq v)
{
    memcpy(p, &v, sizeof v);
}

#if VF == 8
static inline vf vf_all_quads(__m128 quad)
{
    return _mm256_set_m128(quad, quad);
}

static inline vf vf_load_quads(const float *const p[VF / 4])
{
    const __m256 a = _mm256_castps128_ps256(_mm_loadu_ps(p[0]));
    return _mm256_insertf128_ps(a, _mm_loadu_ps(p[1]), 1);
}

static inline __m128 vf_quad(vf v, size_t k)
{
    return k ? _mm256_extractf128_ps(v, 1) : _mm256_castps256_ps128(v);
}

static inline vf vf_spread(const float *w, int k)
{
    const __m256i which = _mm256_add_epi32(
        _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1), _mm256_set1_epi32(2 * k));
    return _mm256_permutevar8x32_ps(_mm256_loadu_ps(w), which);
}
#elif VF == 4
static inline vf vf_all_quads(vq quad)
{
    return quad;
}

static inline vf vf_load_quads(const float *const p[VF / 4])
{
    return vf_load(p[0]);
}

static inline vq vf_quad(vf v, size_t k)
{
    (void)k;
    return v;
}

static inline vf vf_spread(const float *w, int k)
{
    return vf_all(w[k]);
}
#endif

/* Stores VF pixels as R G B R G B ... and writes one float beyond them. */
static inline void vf_store_rgb(float *dst, vf r, vf g, vf b)
{
#ifdef IBL_NEON
    const float32x4x3_t rgb = {{r, g, b}};
    vst3q_f32(dst, rgb);
#else
    vf v[4] = {r, g, b, b};
    vf_transpose(v); /* pixels 0 4, 1 5, ... */
#pragma GCC unroll 8
    for (size_t i = 0; i < VF; i++)
        vq_store(dst + 3 * i, vf_quad(v[i % 4], i / 4));
#endif
}

/* Sixteen lanes as four: halves are added, and their halves. */
static inline vq vf_fold_16(const vf v[16 / VF])
{
#if VF == 8
    const vf sum = v[0] + v[1];
    return vf_quad(sum, 0) + vf_quad(sum, 1);
#else
    return (v[0] + v[2]) + (v[1] + v[3]);
#endif
}

#endif
