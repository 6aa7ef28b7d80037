/* SPDX-License-Identifier: MIT */
/* In vectors of any width. */
#include <stddef.h>

#include "kern/interp.h"
#include "kern/lanes.h"

enum {
    VECTORS = 4 * IBL_TAPS / VF, /* vectors for a ring's samples */
    CHAINS = 16 / VF,
    DEGREE = 5 /* of the weights' polynomials */
};

static const double PI = 3.14159265358979323846;

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

/* The azimuth is measured from the diagonal of its quadrant: its tangent is
 * (|z| - |x|) / (|z| + |x|), at most 1; at the pole it is 0 / 1e-300. */
static void angles(const float *point, int stride, int count, double *theta,
                   double *phi)
{
    for (int i = 0; i < count; i += VD) {
        vd p[3];
        for (int k = 0; k < 3; k++)
            p[k] = vd_load_floats(point + k * stride + i) +
                   vd_load_floats(point + (k + 3) * stride + i);
        const vd x = vd_abs(p[0]), y = vd_abs(p[1]), z = vd_abs(p[2]);
        const vd r = vd_sqrt(p[0] * p[0] + p[2] * p[2]);
        const vd down = arc_tangent((r - y) / (r + y)) + 0.25 * PI;
        const vd turn = arc_tangent((z - x) / (z + x + 1e-300)) + 0.25 * PI;
        const vd around = vd_either(p[0] < 0, PI - turn, turn);
        vd_store(theta + i, vd_either(p[1] < 0, PI - down, down));
        vd_store(phi + i, vd_either(p[2] < 0, -around, around));
    }
}

/*
 * The weight of tap k at whole + t, 0 <= t < 1, is a polynomial in t - 1/2,
 * with these coefficients, constant first; tap 7 - k is tap k mirrored. They
 * sum to 1. They interpolate a field at three samples a wave of its degree,
 * whose amplitude falls exponentially to 1e-5 there, with the least mean square
 * error (Wiener): 2e-5 of the field without its mean, and less at more samples.
 * tests/check_kern.c makes them again.
 */
static const float taps[][IBL_TAPS] = {
    {-0.00401042462937488f, 0.0310095350522202f, -0.131532619788555f,
     0.604533509366579f, 0.604533509366579f, -0.131532619788555f,
     0.0310095350522202f, -0.00401042462937488f},
    {0.00123620572485146f, -0.0128954711694867f, 0.0889281944607499f,
     -1.21095770700123f, 1.21095770700123f, -0.0889281944607499f,
     0.0128954711694867f, -0.00123620572485146f},
    {0.0185831797363994f, -0.141420985861519f, 0.56307691218891f,
     -0.44023910604646f, -0.44023910604646f, 0.56307691218891f,
     -0.141420985861519f, 0.0185831797363994f},
    {-0.00573536907032629f, 0.0588855245192595f, -0.381227712276624f,
     0.889389156503926f, -0.889389156503926f, 0.381227712276624f,
     -0.0588855245192595f, 0.00573536907032629f},
    {-0.0101779718016946f, 0.0695883015824416f, -0.147884501641821f,
     0.0884741718006799f, 0.0884741718006799f, -0.147884501641821f,
     0.0695883015824416f, -0.0101779718016946f},
    {0.0031653341107398f, -0.0292355600730655f, 0.102120816802306f,
     -0.182333589317523f, 0.182333589317523f, -0.102120816802306f,
     0.0292355600730655f, -0.0031653341107398f},
};

static void weights(double shift, double scale, const double *angle, int count,
                    int *first, float *weight)
{
    for (int i = 0; i < count; i++) {
        /* Casts round towards zero, and positions are above -64. */
        const double position = shift + scale * angle[i];
        const int whole = (int)(position + 64) - 64;
        const vf t = vf_all((float)(position - whole - 0.5));
        for (int k = 0; k < IBL_TAPS; k += VF) {
            vf w = vf_load(taps[DEGREE] + k);
#pragma GCC unroll 5
            for (int d = DEGREE - 1; d >= 0; d--)
                w = vf_fma(w, t, vf_load(taps[d] + k));
            vf_store(weight + (size_t)i * IBL_TAPS + k, w);
        }
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

/* Sums across the columns, in sixteen lanes. */
static inline vq across(const vf along[VECTORS], const float *w)
{
    vf sum[CHAINS];
#pragma GCC unroll 8
    for (int k = 0; k < VECTORS; k++)
        if (k < CHAINS)
            sum[k] = along[k] * vf_spread(w, k);
        else
            sum[k % CHAINS] =
                vf_fma(along[k], vf_spread(w, k), sum[k % CHAINS]);
    return vf_fold_16(sum);
}

/* Sums down the rings per channel and column first, then across columns. */
static void row(const ibl_interp_row *row)
{
    const ibl_interp_row a = *row;
    const ptrdiff_t stride = a.stride;
    for (int i = 0; i < a.count; i++) {
        const float *grid =
            a.grid + a.ring[i] * stride + 4 * (ptrdiff_t)a.column[i];
        const float *w = a.ring_weight + (ptrdiff_t)i * IBL_TAPS;
        vf along[VECTORS];
        /* Prefetch for the following texels and rows. */
        __builtin_prefetch(grid + 8 * stride + 16);
        __builtin_prefetch(grid - stride + 16);
#pragma GCC unroll 8
        for (int k = 0; k < IBL_TAPS; k++)
            add_ring(grid + k * stride, w[k], k == 0, along);
        vq_store(a.rgba + 4 * (size_t)i,
                 across(along, a.column_weight + (ptrdiff_t)i * IBL_TAPS));
    }
}

IBL_VECTOR_KERNEL(ibl_interp, angles, weights, row)
