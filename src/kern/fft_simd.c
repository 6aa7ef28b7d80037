/* SPDX-License-Identifier: MIT */
/*
 * The transforms of kern/fft.h, by decimation in frequency, and in time for the
 * inverse. Two stages are done at a time (radix 4), then each quarter is
 * finished before the next, so that a block that fits a cache stays there. If
 * the number of stages is odd, the last step has three.
 */
#include <string.h>

#include "kern/fft.h"
#include "kern/lanes.h"

typedef struct vc {
    vf re, im;
} vc;

static inline vc vc_load(const float *z, size_t k)
{
    z += k * IBL_FFT_VALUE;
    return (vc){vf_load(z), vf_load(z + IBL_FFT_LANES)};
}

static inline void vc_store(float *z, size_t k, vc v)
{
    z += k * IBL_FFT_VALUE;
    vf_store(z, v.re);
    vf_store(z + IBL_FFT_LANES, v.im);
}

static inline vc vc_add(vc a, vc b)
{
    return (vc){a.re + b.re, a.im + b.im};
}

static inline vc vc_sub(vc a, vc b)
{
    return (vc){a.re - b.re, a.im - b.im};
}

/* a + i b */
static inline vc vc_add_i(vc a, vc b)
{
    return (vc){a.re - b.im, a.im + b.re};
}

/* a - i b */
static inline vc vc_sub_i(vc a, vc b)
{
    return (vc){a.re + b.im, a.im - b.re};
}

/* a w */
static inline vc vc_mul(vc a, const float w[2])
{
    const vf c = vf_all(w[0]), s = vf_all(w[1]);
    return (vc){vf_less(a.re, c, a.im, s), vf_fma(a.im, c, a.re * s)};
}

/* a conj(w) */
static inline vc vc_mul_conj(vc a, const float w[2])
{
    const vf c = vf_all(w[0]), s = vf_all(w[1]);
    return (vc){vf_fma(a.re, c, a.im * s), vf_less(a.im, c, a.re, s)};
}

/* Two stages of a block of four values without factors, and their inverse. */
static inline void quarter(vc v[4])
{
    const vc s0 = vc_add(v[0], v[2]), d0 = vc_sub(v[0], v[2]);
    const vc s1 = vc_add(v[1], v[3]), d1 = vc_sub(v[1], v[3]);
    v[0] = vc_add(s0, s1);
    v[1] = vc_sub(s0, s1);
    v[2] = vc_sub_i(d0, d1);
    v[3] = vc_add_i(d0, d1);
}

static inline void quarter_inverse(vc v[4])
{
    const vc s0 = vc_add(v[0], v[1]), d0 = vc_sub(v[0], v[1]);
    const vc s1 = vc_add(v[2], v[3]), d1 = vc_sub(v[2], v[3]);
    v[0] = vc_add(s0, s1);
    v[1] = vc_add_i(d0, d1);
    v[2] = vc_sub(s0, s1);
    v[3] = vc_sub_i(d0, d1);
}

/* Loads four values, `apart` values from each other. */
static inline void load_four(const float *z, size_t apart, vc v[4])
{
#pragma GCC unroll 4
    for (size_t k = 0; k < 4; k++)
        v[k] = vc_load(z, k * apart);
}

static inline void store_four(float *z, size_t apart, const vc v[4])
{
#pragma GCC unroll 4
    for (size_t k = 0; k < 4; k++)
        vc_store(z, k * apart, v[k]);
}

/* e^(-2 pi i k / 8), k = 1..3 */
static const float eighths[3][2] = {{0x1.6a09e6p-1f, -0x1.6a09e6p-1f},
                                    {0, -1},
                                    {-0x1.6a09e6p-1f, -0x1.6a09e6p-1f}};

/* The last stages, or the first inverse ones: blocks of at most eight
 * values. */
static inline void leaf(float *z, int size, bool back)
{
    vc v[4], u[4];
    if (size == 2) {
        const vc x = vc_load(z, 0), y = vc_load(z, 1);
        vc_store(z, 0, vc_add(x, y));
        vc_store(z, 1, vc_sub(x, y));
        return;
    }
    load_four(z, 1, v);
    if (back)
        quarter_inverse(v);
    if (size == 8) {
        load_four(z + 4 * IBL_FFT_VALUE, 1, u);
        if (back)
            quarter_inverse(u);
#pragma GCC unroll 4
        for (size_t k = 0; k < 4; k++) {
            const vc x = v[k];
            const vc y = back && k ? vc_mul_conj(u[k], eighths[k - 1]) : u[k];
            const vc d = vc_sub(x, y);
            v[k] = vc_add(x, y);
            u[k] = !back && k ? vc_mul(d, eighths[k - 1]) : d;
        }
        if (!back)
            quarter(u);
        store_four(z + 4 * IBL_FFT_VALUE, 1, u);
    }
    if (!back)
        quarter(v);
    store_four(z, 1, v);
}

/* Multiplies the three values that have factors by them or, if back, by their
 * conjugates. */
static inline void turn_three(vc v[4], const float *w, bool back)
{
    v[1] = back ? vc_mul_conj(v[1], w + 2) : vc_mul(v[1], w + 2);
    v[2] = back ? vc_mul_conj(v[2], w) : vc_mul(v[2], w);
    v[3] = back ? vc_mul_conj(v[3], w + 4) : vc_mul(v[3], w + 4);
}

/* Two stages of a block of `size` values. */
static inline void pass(float *z, size_t size, const float *w, bool back)
{
    const size_t q = size / 4;
    for (size_t j = 0; j < q; j++, w += 6) {
        float turns[6];
        memcpy(turns, w, sizeof turns);
        for (size_t l = 0; l < IBL_FFT_LANES; l += VF) {
            float *at = z + j * IBL_FFT_VALUE + l;
            vc v[4];
            load_four(at, q, v);
            if (!back)
                quarter(v);
            turn_three(v, turns, back);
            if (back)
                quarter_inverse(v);
            store_four(at, q, v);
        }
    }
}

static void transform(float *const *passes, float *z, int size, bool back)
{
    if (size <= 8) {
        for (size_t l = 0; l < IBL_FFT_LANES; l += VF)
            leaf(z + l, size, back);
        return;
    }
    if (!back)
        pass(z, (size_t)size, *passes, false);
    for (size_t k = 0; k < 4; k++)
        transform(passes + 1, z + k * ((size_t)size / 4) * IBL_FFT_VALUE,
                  size / 4, back);
    if (back)
        pass(z, (size_t)size, *passes, true);
}

/* a x + b conj(y); imaginary parts are `part` after real ones. */
static inline vc combine(const ibl_fft_pair *p, const float *x, const float *y,
                         size_t part)
{
    const vf ar = vf_all(p->a[0]), ai = vf_all(p->a[1]);
    const vf br = vf_all(p->b[0]), bi = vf_all(p->b[1]);
    const vf xr = vf_load(x), xi = vf_load(x + part);
    const vf yr = vf_load(y), yi = vf_load(y + part);
    return (vc){vf_fma(ar, xr, br * yr) + vf_less(bi, yi, ai, xi),
                vf_fma(ar, xi, ai * xr) + vf_less(bi, yr, br, yi)};
}

static void split(const float *z, const ibl_fft_pair *pairs, int count,
                  const ibl_fft_spectrum *out)
{
    const ibl_fft_spectrum to = *out;

    for (int m = 0; m < count; m++) {
        const ibl_fft_pair p = pairs[m];
        const float *x = z + (size_t)p.first * IBL_FFT_VALUE;
        const float *y = z + (size_t)p.second * IBL_FFT_VALUE;
        float *re = to.data + (size_t)m * to.bin, *im = re + to.part;
        for (size_t l = 0; l < IBL_FFT_LANES; l += VF) {
            const vc v = combine(&p, x + l, y + l, IBL_FFT_LANES);
            vf_store(re + l, v.re);
            vf_store(im + l, v.im);
        }
    }
}

static void merge(const ibl_fft_spectrum *in, const ibl_fft_pair *pairs,
                  int count, float *z)
{
    const ibl_fft_spectrum from = *in;

    for (int k = 0; k < count; k++) {
        const ibl_fft_pair p = pairs[k];
        const float *x = from.data + (size_t)p.first * from.bin;
        const float *y = from.data + (size_t)p.second * from.bin;
        for (size_t l = 0; l < IBL_FFT_LANES; l += VF)
            vc_store(z + l, (size_t)k, combine(&p, x + l, y + l, from.part));
    }
}

static void forward(const ibl_fft *fft, float *z)
{
    transform(fft->passes, z, fft->size, false);
}

static void inverse(const ibl_fft *fft, float *z)
{
    transform(fft->passes, z, fft->size, true);
}

IBL_VECTOR_KERNEL(ibl_fft, forward, inverse, split, merge)
