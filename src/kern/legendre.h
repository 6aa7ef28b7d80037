/* SPDX-License-Identifier: MIT */
/*
 * Sums with associated Legendre functions over rings of constant latitude,
 * one order m at a time: the inner loops of bake/spectral/transform.h, whose
 * conventions (rings, P_lm) are kept.
 *
 * All versions work in double. A ring in the north and its mirror image in
 * the south share their P_lm except for the sign (-1)^(l - m), so sums are
 * taken over pairs of them. Near the poles P_mm, which is (sin theta)^m times a
 * factor, underflows a double, although P_lm matters at higher l. So values
 * start with a separate exponent (Holmes and Featherstone 2002, "A unified
 * approach to the Clenshaw summation ...", J. Geodesy 76) and are summed only
 * from where they matter (Reinecke and Seljebotn 2013, "Libsharp", A&A 554;
 * Schaeffer 2013, "Efficient spherical harmonic transforms ...", G-cubed 14).
 *
 * Errors. Each P_lm is within
 *     DBL_EPSILON (l + 1)^1.5 min(l + 1, 2 / sin theta)
 *     + IBL_LEGENDRE_NOTHING
 * of the exact value (P_lm itself reaches sqrt(l / 2 pi)): a rounding of cos
 * theta moves theta by DBL_EPSILON / sin theta and P_lm by l times that, and
 * next to a pole, where P_lm is even or odd in theta, by l^2 DBL_EPSILON. The
 * second term bounds the values of omitted rings. The tests check it, and the
 * sums, to degree 16384, against long double.
 */
#ifndef IBL_KERN_LEGENDRE_H
#define IBL_KERN_LEGENDRE_H

#include <stdbool.h>
#include <stddef.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

/* Values below this are lost among the roundings of floats. */
#define IBL_LEGENDRE_NOTHING 0x1p-28

/*
 * CENTRES: theta_j = pi (j + 1/2) / count, of rows of equal height.
 * EDGES: theta_j = pi (j + 1) / (count + 1), between count + 1 such rows.
 */
typedef enum ibl_ring_kind {
    IBL_RINGS_CENTRES,
    IBL_RINGS_EDGES
} ibl_ring_kind;

/*
 * Properties of the rings that the sums need, the same for all orders. Arrays
 * have an entry per pair, from the pole to the equator, and are padded to a
 * multiple of 16 with entries at the equator.
 */
typedef struct ibl_legendre_rings {
    int count;            /* rings */
    int pairs;            /* (count + 1) / 2: a middle ring pairs with itself */
    double *x;            /* cos theta, >= 0 */
    double *x2;           /* x^2 */
    double *sine;         /* sin theta */
    double *mantissa;     /* sin theta = mantissa 2^exponent, the mantissa in */
    double *exponent;     /*   [sqrt(1/2), sqrt(2)) */
    double *mantissa_512; /* the same of mantissa^512 */
    double *exponent_512;
    double *start; /* P_mm / (sin theta)^m, m = 0..degree */
} ibl_legendre_rings;

/* Pairs first..end - 1 of `count` rings, as if there were no others;
 * end <= (count + 1) / 2. False if there is no memory; then r is empty. */
bool ibl_legendre_rings_init(ibl_legendre_rings *r, ibl_ring_kind kind,
                             int count, int first, int end, int degree);
void ibl_legendre_rings_free(ibl_legendre_rings *r);

/* The order to work on. */
typedef struct ibl_legendre_order {
    const ibl_legendre_rings *rings;
    int m, degree;   /* 0 <= m <= degree <= that of start */
    int single;      /* from this degree on floats may do; > degree: nowhere */
    double *scratch; /* ibl_legendre_scratch(degree) doubles, 64-byte aligned,
                        contents undefined */
} ibl_legendre_order;

size_t ibl_legendre_scratch(int degree);

typedef struct ibl_legendre_dsp {
    /*
     * Rings are EDGES: a[6 (l - m) + part] =
     *     sum over rings j of (sin theta_j)^2 P_lm(cos theta_j) (f_j+1 - f_j)
     * for l = m..degree and 6 parts, f_j = f[part * stride + j] the value of a
     * row; the difference is taken in double.
     */
    void (*analyse)(const ibl_legendre_order *o, const float *f, size_t stride,
                    double *a);
    /*
     * g[part * stride + j] = sum over l = m..degree of
     * factor[l] a[6 (l - m) + part] P_lm(cos theta_j). Nothing beyond the rings
     * is written.
     */
    void (*synthesise)(const ibl_legendre_order *o, const float *a,
                       const double *factor, float *g, size_t stride);
    /*
     * sum[part] += sum over j = from..until - 1 of
     * (edge[j] - edge[j + 1]) (f_j + f_rows-1-j), in double; until <= rows / 2.
     */
    void (*add_rows)(const double *edge, int from, int until, int rows,
                     const float *f, size_t stride, double sum[6]);
} ibl_legendre_dsp;

IBL_DECLARE_KERNEL(ibl_legendre);

#endif
