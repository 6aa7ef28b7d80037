/* SPDX-License-Identifier: MIT */
#include "bake/spectral/near_table.h"

#include <math.h>

#include "bake/spectral/gauss.h"
#include "core/alloc.h"

enum {
    PIECES = 1 << IBL_NEAR_BITS, /* an octave */
    NODES = 4                    /* of a piece: 0, 1/3, 2/3, 1 */
};

/* exp(-REACH) of the near part of GGX is left out, exp(-NOTHING) of Phong. */
static const double REACH = 12, NOTHING = 20;

static double reach_of(const ibl_lobe_shape *s)
{
    if (s->lobe == IBL_LOBE_PHONG)
        return -0.5 * expm1(-NOTHING / (s->power + 2));
    return s->split > 0 ? fmin(REACH / s->split, 0.5) : 0.5;
}

static double weight(const ibl_lobe_shape *s, double q)
{
    const double k = ibl_lobe_value(s, q, 1 - 2 * q);
    return s->split > 0 ? k * ibl_lobe_near_share(s, q) : k;
}

/* 2 int K dq, by four points of Gauss and Legendre. */
static double integral(const ibl_lobe_shape *s, double from, double to)
{
    double sum = 0;
    for (int k = 0; k < IBL_GAUSS_POINTS; k++)
        sum += ibl_gauss_mass[k] *
               weight(s, from + (to - from) * ibl_gauss_node[k]);
    return 2 * (to - from) * sum;
}

/* Where a node of a piece stands, as q. */
static double place(const ibl_near_table *t, int piece, int node)
{
    const double octave = ldexp(t->start, piece / PIECES);
    const double part = piece % PIECES + node / (NODES - 1.0);
    return fmin(octave * (1 + part / PIECES) - t->start, t->reach);
}

/* The cubic of x = 0..1 through values at 0, 1/3, 2/3, 1. */
static void fit(const double f[NODES], double c[4])
{
    c[0] = f[0];
    c[1] = (-11 * f[0] + 18 * f[1] - 9 * f[2] + 2 * f[3]) / 2;
    c[2] = 4.5 * (2 * f[0] - 5 * f[1] + 4 * f[2] - f[3]);
    c[3] = 4.5 * (f[3] - 3 * f[2] + 3 * f[1] - f[0]);
}

/* Integrals from 0 to the nodes, upwards, and from the reach to them,
 * downwards, so that neither is a small difference of large ones. */
static void fill(const ibl_lobe_shape *s, int pieces, ibl_near_table *t)
{
    double sum = 0, nodes[NODES];
    for (int k = 0; k < pieces; k++) {
        double *c = t->coef + 8 * (ptrdiff_t)k;
        for (int i = 0; i < NODES; i++) {
            const double q = place(t, k, i);
            if (i > 0)
                sum += integral(s, place(t, k, i - 1), q);
            nodes[i] = q > 0 ? sum / q : 2 * weight(s, 0);
        }
        fit(nodes, c + 4);
    }
    t->peak = sum;
    sum = 0;
    for (int k = pieces - 1; k >= 0; k--) {
        for (int i = NODES - 1; i >= 0; i--) {
            if (i < NODES - 1)
                sum += integral(s, place(t, k, i), place(t, k, i + 1));
            nodes[i] = sum;
        }
        fit(nodes, t->coef + 8 * (ptrdiff_t)k);
    }
}

int ibl_near_table_make(const ibl_lobe_shape *shape, ibl_near_table *out)
{
    const double size = 0.0625 * shape->alpha * shape->alpha;
    int64_t bits;
    *out = (ibl_near_table){.start = exp2(floor(log2(size))),
                            .reach = reach_of(shape)};
    const double octaves = log2(1 + out->reach / out->start);
    const int pieces = PIECES * (int)ceil(octaves) + 1;
    out->coef = ibl_alloc_array(8 * (size_t)pieces, sizeof *out->coef);
    if (!out->coef)
        return 0;
    memcpy(&bits, &out->start, sizeof bits);
    out->base = bits >> (52 - IBL_NEAR_BITS);
    fill(shape, pieces, out);
    return 1;
}

void ibl_near_table_free(ibl_near_table *table)
{
    ibl_free(table->coef);
    *table = (ibl_near_table){0};
}
