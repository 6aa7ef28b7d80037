/* SPDX-License-Identifier: MIT */
/*
 * H of near.h as a function of q = sin^2(psi / 2), where
 *     H(q) = 2 int_q^reach K dq',
 * since sin(psi) dpsi = 2 dq; and (H(0) - H(q)) / q, which keeps its digits
 * where q is small. Cubic pieces, 2^BITS an octave of q + start: within 1e-6.
 */
#ifndef IBL_BAKE_SPECTRAL_NEAR_TABLE_H
#define IBL_BAKE_SPECTRAL_NEAR_TABLE_H

#include <stdint.h>
#include <string.h>

#include "brdf/lobe.h"

enum {
    IBL_NEAR_BITS = 5
};

typedef struct ibl_near_table {
    double start; /* a power of two */
    double reach; /* the largest q; beyond it H is 0 */
    double peak;  /* H(0) */
    int64_t base; /* number of the first piece */
    double *coef; /* 8 a piece: of H, and of (H(0) - H) / q */
} ibl_near_table;

/* False if there is no memory. Free with ibl_near_table_free. */
int ibl_near_table_make(const ibl_lobe_shape *shape, ibl_near_table *out);
void ibl_near_table_free(ibl_near_table *table);

/* H(q) for which = 0, (H(0) - H(q)) / q for which = 1; q in 0..reach. */
static inline double ibl_near_at(const ibl_near_table *t, double q, int which)
{
    const double v = q + t->start;
    int64_t bits;
    double x;

    memcpy(&bits, &v, sizeof bits);
    const double *c =
        t->coef + 8 * ((bits >> (52 - IBL_NEAR_BITS)) - t->base) + 4 * which;
    /* The rest of the fraction, as a number in 0..1. */
    const int64_t rest =
        (int64_t)((uint64_t)bits << (12 + IBL_NEAR_BITS) >> 12);
    const int64_t one = rest | 0x3ff0000000000000;
    memcpy(&x, &one, sizeof x);
    x -= 1;
    return ((c[3] * x + c[2]) * x + c[1]) * x + c[0];
}

#endif
