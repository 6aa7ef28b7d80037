/* SPDX-License-Identifier: MIT */
/*
 * Spherical harmonics over rings of constant latitude: coefficients from the
 * Fourier coefficients of each ring, and back.
 *
 * CONVENTIONS
 *
 *   Axis      theta is the angle from the pole, +Y for a map; phi goes around
 *             it as the columns of a map do.
 *   Rings     `count` of them at theta_j = pi (j + 1/2) / count, ring 0 next
 *             to the pole. Ring j and ring count - 1 - j are mirror images in
 *             the equator; with an odd count the middle one is on it.
 *   P_lm      associated Legendre functions, normalised so that the integral
 *             of P_lm(x)^2 over -1..1 is 1 / (2 pi), without the
 *             Condon-Shortley phase: P_00 = sqrt(1 / 4 pi), P_mm > 0.
 *   Y_lm      P_lm(cos theta) e^(i m phi), orthonormal on the sphere.
 *   a_lm      the integral of f conj(Y_lm). For real f, a_l,-m is the
 *             conjugate of a_lm in this sign convention, so only m >= 0 is
 *             stored:
 *               f = sum over l of a_l0 P_l0
 *                               + 2 Re sum over m > 0 of a_lm P_lm e^(i m phi).
 *
 * HOW EXACT
 *
 *   Sums are in double, P_lm as exact as kern/legendre.h says. Input and output
 *   are floats, whose rounding is by far the larger error.
 */
#ifndef IBL_BAKE_SPECTRAL_TRANSFORM_H
#define IBL_BAKE_SPECTRAL_TRANSFORM_H

#include <stddef.h>

#include "ibl/ibl.h"

#define IBL_SHT_MAX_DEGREE 16384

/*
 * Fourier coefficients F_m, m = 0..orders - 1, of every ring, of three
 * channels. Part p = 2 channel + (0: real, 1: imaginary) of F_m on ring j is
 *     data[(m * 6 + p) * stride + j].
 * Floats between the rings and the stride may be written and are never used.
 */
typedef struct ibl_ring_spectra {
    int rings;     /* 1..IBL_MAX_EDGE */
    int orders;    /* 1..IBL_SHT_MAX_DEGREE + 1 */
    size_t stride; /* floats: a multiple of 16, and an odd one, so that the
                      parts of a ring do not share the sets of a cache */
    float *data;   /* 64-byte aligned, 6 * orders * stride floats */
} ibl_ring_spectra;

/* Allocates the spectra of rings, contents undefined, of all rings. out is
 * empty after an error; free with ibl_ring_spectra_free. */
ibl_status ibl_ring_spectra_alloc(ibl_ctx *ctx, int rings, int orders,
                                  ibl_ring_spectra *out);
void ibl_ring_spectra_free(ibl_ring_spectra *s); /* zeroed is fine */

/* Part `part` of F_m: `rings` floats. */
static inline float *ibl_ring_spectra_at(const ibl_ring_spectra *s, int m,
                                         int part)
{
    return s->data + ((size_t)m * 6 + (size_t)part) * s->stride;
}

enum {
    IBL_ROW_GROUP = 16 /* rows */
};

/*
 * The same of the rows of a map, for an analysis, in groups of rows. A group
 * has the orders that reach it: P_lm is below 1e-12 there for the others, up to
 * the degree. Part p of F_m on row i of a group is
 *     data[at[group] + (m * 6 + p) * IBL_ROW_GROUP + i].
 */
typedef struct ibl_row_spectra {
    int rows, degree, groups;
    size_t *at;  /* groups + 1 */
    float *data; /* 64-byte aligned */
} ibl_row_spectra;

/* Number of orders that a group of the rows of a map has. */
int ibl_row_orders(int rows, int degree, int group);

/* Contents undefined; out is empty after an error. */
ibl_status ibl_row_spectra_alloc(ibl_ctx *ctx, int rows, int degree,
                                 ibl_row_spectra *out);
void ibl_row_spectra_free(ibl_row_spectra *s); /* zeroed is fine */

static inline int ibl_row_spectra_orders(const ibl_row_spectra *s, int group)
{
    return (int)((s->at[group + 1] - s->at[group]) / (6 * IBL_ROW_GROUP));
}

/* Part `part` of F_m of a group that has it: IBL_ROW_GROUP floats. */
static inline float *ibl_row_spectra_at(const ibl_row_spectra *s, int group,
                                        int m, int part)
{
    return s->data + s->at[group] +
           ((size_t)m * 6 + (size_t)part) * IBL_ROW_GROUP;
}

/*
 * Coefficients a_lm of three channels, order after order: for each m the
 * degrees l = m..degree, 6 floats each (R re, R im, G re, G im, B re, B im).
 */
typedef struct ibl_harmonics {
    int degree;  /* 0..IBL_SHT_MAX_DEGREE */
    int single;  /* from this degree on an analysis may use floats */
    float *data; /* 64-byte aligned, 3 (degree + 1)(degree + 2) floats */
} ibl_harmonics;

/* Allocates coefficients, contents undefined. out is empty
 * after an error; free with ibl_harmonics_free. */
ibl_status ibl_harmonics_alloc(ibl_ctx *ctx, int degree, ibl_harmonics *out);
void ibl_harmonics_free(ibl_harmonics *h); /* zeroed is fine */

/* The coefficients of order m: 6 floats each for l = m, m + 1, ..., degree. */
static inline float *ibl_harmonics_at(const ibl_harmonics *h, int m)
{
    return h->data +
           (size_t)m * (size_t)(2 * (ptrdiff_t)h->degree + 3 - m) / 2 * 6;
}

/*
 * The analysis of a map of constant patches: its row j covers the latitudes
 * pi j / rings to pi (j + 1) / rings, and F_m(j) is that of the row's pixels
 * as points at their centres. The coefficients are the integrals over the
 * patches,
 *     a_lm = width[m] sum over rows j of F_m(j) int P_lm dx,
 * x = cos theta over the row, for l <= out->degree, which is that of in. Runs
 * on ctx's pool and reports progress under stage (NULL: silently).
 *   width  for each m, the integral of e^(-i m phi) over a pixel's width
 * IBL_ERR_MEMORY, IBL_ERR_CANCELLED: out unspecified. The same bytes for any
 * number of threads.
 */
ibl_status ibl_sht_analyse(ibl_ctx *ctx, const char *stage,
                           const ibl_row_spectra *in, const double *width,
                           ibl_harmonics *out);

/* Share of a level from which floats do. */
#define IBL_SHT_SMALL 0.2

/*
 * The synthesis on `rings` rings, or on some pairs of them, which out holds as
 * if there were no others: pair first + j in the rings j and out->rings - 1 -
 * j. G_m(j) = sum over l = m..degree of factor[l] a_lm P_lm(cos theta_j) for m
 * <= degree; orders of out beyond that do not change. Sums in floats from where
 * all factors are below IBL_SHT_SMALL times the largest: errors of 1e-6 of the
 * terms.
 *   factor  one for each l <= degree, finite
 *   degree  at most that of in, and below out->orders
 * IBL_ERR_MEMORY, IBL_ERR_CANCELLED: out unspecified. The same bytes for any
 * number of threads.
 */
ibl_status ibl_sht_synthesise(ibl_ctx *ctx, const ibl_harmonics *in,
                              const double *factor, int degree, int rings,
                              int first, ibl_ring_spectra *out);

/* The power in each degree l = 0..h->degree: power[l] is the sum of |a_lm|^2
 * over m = -l..l and the channels. */
void ibl_sht_power(const ibl_harmonics *h, double *power);

#endif
