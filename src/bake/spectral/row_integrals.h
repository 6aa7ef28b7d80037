/* SPDX-License-Identifier: MIT */
/*
 * Integrals of associated Legendre functions over the rows of a map, all rows
 * of the same height in theta, weighted by a value of each row:
 *     A_lm = sum over rows j of F_j int P_lm(x) dx,   x = cos theta.
 *
 * The normalised functions of transform.h have antiderivatives Q_lm with
 *     (l + 1) e_l Q_l = (l - 2) e_l-1 Q_l-2 - (1 - x^2) P_l-1,
 *     e_l = sqrt((l^2 - m^2) / (4 l^2 - 1))
 * (Paul 1978, "Recurrence relations for integrals of associated Legendre
 * functions", Bulletin Geodesique 52, there without the norm). It holds at
 * every edge between two rows, hence for sums over them: with
 *     B_l = sum over edges of (1 - x^2) P_l(x) (F_below - F_above),
 * an analysis on the edges,
 *     (l + 1) e_l A_l = (l - 2) e_l-1 A_l-2 - B_l-1,
 * and the factor of A_l-2 is below 1: errors are damped. The first, A_m, needs
 * the integral of (sin theta)^m dx from the equator,
 *     (m + 1) S_m = x (sin theta)^m + m S_m-2,
 * all of whose terms are positive.
 */
#ifndef IBL_BAKE_SPECTRAL_ROW_INTEGRALS_H
#define IBL_BAKE_SPECTRAL_ROW_INTEGRALS_H

#include <stdbool.h>
#include <stddef.h>

/* Constant after creation. */
typedef struct ibl_row_integrals {
    int rows;
    int edges;      /* from the pole to the equator */
    double *x;      /* cos theta of each */
    double *sine;   /* sin theta */
    double *states; /* of every IBL_ROW_INTEGRALS_EVERY-th order */
} ibl_row_integrals;

enum {
    IBL_ROW_INTEGRALS_EVERY = 32
};

/* For rows >= 1 and orders 0..degree. False if there is no memory; then r is
 * empty. */
bool ibl_row_integrals_init(ibl_row_integrals *r, int rows, int degree);
void ibl_row_integrals_free(ibl_row_integrals *r);

/* Doubles of a state, one for each thread. */
size_t ibl_row_integrals_state(const ibl_row_integrals *r);
/* Makes state that of order m, and then of the order after it. */
void ibl_row_integrals_seek(const ibl_row_integrals *r, int m, double *state);
void ibl_row_integrals_next(const ibl_row_integrals *r, int m, double *state);

/*
 * Turns B_l of order m, in a[6 (l - m) + part] for l = m..degree, into
 * scale A_l.
 *   f, stride  F_j of part p is f[p * stride + j]
 *   start      P_mm / (sin theta)^m
 */
void ibl_row_integrals_finish(const ibl_row_integrals *r, const double *state,
                              int m, int degree, const float *f, size_t stride,
                              double start, double scale, double *a);

#endif
