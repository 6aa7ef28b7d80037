/* SPDX-License-Identifier: MIT */
/* In vectors of any width. */
#include <stddef.h>

#include "kern/interp.h"
#include "kern/lanes.h"

enum {
    VECTORS = 4 * IBL_TAPS / VF, /* vectors for a ring's samples */
    PARTS = IBL_TAPS / VD        /* vectors for the weights */
};

/*
 * Arc tangent of |x| <= sqrt(2), within 1e-12. Half the angle has the tangent
 * t = x / (1 + sqrt(1 + x^2)) <= 0.518, and atan(t) = t P(t^2), with P fitted
 * at Chebyshev's nodes of 0..0.2687.
 */
static inline vd arc_tangent(vd x)
{
    static const double p[] = {-0.017315685631039551, 0.042863083998511908,
                               -0.062181526705302472, 0.076122702165109538,
                               -0.090818427245336286, 0.11110476614546801,
                               -0.14285688536604699,  0.19999999465709115,
                               -0.33333333329009529,  0.99999999999994194};
    const vd t = x / (1.0 + vd_sqrt(1.0 + x * x));
    const vd z = t * t;
    vd s = vd_all(p[0]);
    for (size_t i = 1; i < sizeof p / sizeof p[0]; i++)
        s = vd_fma(s, z, vd_all(p[i]));
    return 2.0 * t * s;
}

/* u of texels i..i + VD - 1. */
static inline vd coordinates(int i, int size)
{
    static const double odd[8] = {1, 3, 5, 7, 9, 11, 13, 15};
    return (vd_load(odd) + 2.0 * i) / (double)size - 1.0;
}

static void latitudes(double v, int size, int count, double *angle)
{
    for (int i = 0; i < count; i += VD) {
        const vd u = coordinates(i, size);
        vd_store(angle + i, arc_tangent(v / vd_sqrt(1.0 + u * u)));
    }
}

/* The azimuth is measured from the diagonal: its tangent is (|v| - |u|) / (|v|
 * + |u|), at most 1; at the pole it is 0 / 1e-300. */
static void polar(double v, int size, int count, double *angle, double *azimuth)
{
    const vd b = vd_abs(vd_all(v));
    for (int i = 0; i < count; i += VD) {
        const vd u = coordinates(i, size), a = vd_abs(u);
        const vd turn = arc_tangent((b - a) / (b + a + 1e-300));
        vd_store(angle + i, arc_tangent(vd_sqrt(u * u + v * v)));
        vd_store(azimuth + i, turn + 0.78539816339744830962);
    }
}

/* Rounds the weights to float; returns the rounding errors. */
static inline vd round_weights(vd exact, float *w)
{
    vd_store_floats(w, exact);
    return exact - vd_load_floats(w);
}

static void weights(const ibl_interp_weights *taps, double shift, double scale,
                    const double *angle, int count, int *first, float *weight)
{
    for (int i = 0; i < count; i++) {
        /* Casts round towards zero, and positions are above -64. */
        const double position = shift + scale * angle[i];
        const int whole = (int)(position + 64) - 64;
        const double t = position - whole - 0.5;
        float *w = weight + (size_t)i * IBL_TAPS;
        double rest[VD];
        vd lost = vd_all(0);
        for (int k = 0; k < PARTS; k++) {
            vd exact = vd_load(taps->coef[IBL_TAPS_DEGREE] + k * VD);
#pragma GCC unroll 9
            for (int d = IBL_TAPS_DEGREE - 1; d >= 0; d--)
                exact =
                    vd_fma(exact, vd_all(t), vd_load(taps->coef[d] + k * VD));
            lost += round_weights(exact, w + k * VD);
        }
        vd_store(rest, lost);
        for (int n = VD / 2; n; n /= 2)
            for (int k = 0; k < n; k++)
                rest[k] += rest[k + n];
        w[t < 0 ? IBL_TAPS_FIRST : IBL_TAPS_FIRST + 1] += (float)rest[0];
        first[i] = whole - IBL_TAPS_FIRST;
    }
}

/* Adds weight times a ring's samples; the first ring begins the sums. */
static inline void add_ring(const float *grid, float weight, bool first,
                            vf along[VECTORS])
{
    const vf w = vf_all(weight);
#pragma GCC unroll 2
    for (int k = 0; k < VECTORS; k += 4) {
        vf v[4];
        vf_load_four(grid + k * VF, v);
#pragma GCC unroll 4
        for (int i = 0; i < 4; i++)
            if (first)
                along[k + i] = v[i] * w;
            else
                along[k + i] = vf_fma(v[i], w, along[k + i]);
    }
}

/* Sums across the columns; even and odd vectors have separate sums. */
static inline vf across(const vf along[VECTORS], const float *w)
{
    vf sum[2] = {along[0] * vf_spread(w, 0), along[1] * vf_spread(w, 1)};
#pragma GCC unroll 8
    for (int k = 2; k < VECTORS; k++)
        sum[k % 2] = vf_fma(along[k], vf_spread(w, k), sum[k % 2]);
    return sum[0] + sum[1];
}

/* Sums down the rings per channel and column first, then across columns. */
static void row(const ibl_interp_row *row)
{
    const ibl_interp_row a = *row;
    const ptrdiff_t stride = a.stride;
    for (int i = 0; i < a.count; i++) {
        const ptrdiff_t r = i * a.ring_step, c = i * a.column_step;
        const float *grid =
            a.grid + a.ring[r] * stride + 4 * (ptrdiff_t)a.column[c];
        const float *w = a.ring_weight + r * IBL_TAPS;
        vf along[VECTORS];
        /* Prefetch for the following texels and rows. */
        __builtin_prefetch(grid + 8 * stride + 16);
        __builtin_prefetch(grid - stride + 16);
#pragma GCC unroll 8
        for (int k = 0; k < IBL_TAPS; k++)
            add_ring(grid + k * stride, w[k], k == 0, along);
        vq_store(a.rgba + 4 * (size_t)i,
                 vf_fold(across(along, a.column_weight + c * IBL_TAPS)));
    }
}

IBL_VECTOR_KERNEL(ibl_interp, latitudes, polar, weights, row)
