/* SPDX-License-Identifier: MIT */
#include "kern/legendre_sums.h"

enum {
    BLOCK = 8 /* points at once: a step waits for the last one */
};

/* The recurrence is linear: started with the weight it gives weighted P_l. */
static void add_block(const double *y, const double *w, const double *inverse,
                      int degree, double *k)
{
    double p[BLOCK], e[BLOCK];
    double sum = 0;
    for (int i = 0; i < BLOCK; i++) {
        p[i] = w[i];
        e[i] = 0;
        sum += p[i];
    }
    k[0] += sum;
    for (int l = 0; l < degree; l++) {
        sum = 0;
        for (int i = 0; i < BLOCK; i++) {
            e[i] -= (2 * l + 1) * (y[i] * p[i]);
            p[i] += e[i] * inverse[l];
            sum += p[i];
        }
        k[l + 1] += sum;
    }
}

static void sums(const double *y, const double *w, int count,
                 const double *inverse, int degree, double *scratch, double *k)
{
    (void)scratch;
    for (int l = 0; l <= degree; l++)
        k[l] = 0;
    for (int i = 0; i < count; i += BLOCK)
        add_block(y + i, w + i, inverse, degree, k);
}

IBL_KERNEL(ibl_legendre_sums, sums)
