/* SPDX-License-Identifier: MIT */
#include "bake/lobe_bands.h"

#include <math.h>
#include <string.h>

#include "bake/true_lobe.h"
#include "brdf/ggx.h"
#include "core/alloc.h"
#include "kern/brdf_quadrature.h"

enum {
    RINGS = 40,   /* around the mirror direction */
    COLUMNS = 32, /* on half a ring */
    ORDERS = 12,
    EXTRA = IBL_BANDS_DIRECTIONS,
    ALL = RINGS + EXTRA
};

/* Fourier coefficients of the lobe on rings, and Legendre's functions there
 * and, after them, in the directions. */
typedef struct rings {
    double cosine[ALL], sine[ALL];
    double weight[RINGS];
    double sign[EXTRA]; /* of cos(phi): towards or away from N */
    double f[2][ORDERS][RINGS];
} rings;

typedef struct view {
    double sine, cosine, alpha;
} view;

/* f N.L at a direction, for F0 = 1 and .04. */
static void lobe_at(const view *v, const double l[3], double value[2])
{
    const double h[3] = {l[0] - v->sine, l[1], l[2] + v->cosine};
    const double flat = h[0] * h[0] + h[1] * h[1], square = flat + h[2] * h[2];
    const double a2 = v->alpha * v->alpha;
    value[0] = value[1] = 0;
    if (!(l[2] > 0 && square > 0))
        return;
    const double d = ibl_ggx_d((flat + a2 * h[2] * h[2]) / square, v->alpha);
    const double fresnel = ibl_fresnel_weight(0.5 * sqrt(square));
    value[0] = d * ibl_smith_visibility(l[2], v->cosine, v->alpha) * l[2];
    value[1] =
        value[0] * (IBL_DIELECTRIC_F0 + (1 - IBL_DIELECTRIC_F0) * fresnel);
}

/* Integrals of the lobe on a ring with cos(m phi). */
static void transform_ring(const view *v, rings *r, int i)
{
    for (int k = 0; k < COLUMNS; k++) {
        const double phi = IBL_PI * (k + 0.5) / COLUMNS;
        const double c = cos(phi), across = r->sine[i] * c;
        const double l[3] = {v->sine * r->cosine[i] - v->cosine * across,
                             r->sine[i] * sin(phi),
                             v->cosine * r->cosine[i] + v->sine * across};
        double value[2], before = 1, here = c;
        lobe_at(v, l, value);
        for (int m = 0; m < ORDERS; m++) {
            const double wave = m == 0 ? 1 : here;
            r->f[0][m][i] += value[0] * wave * 2 * IBL_PI / COLUMNS;
            r->f[1][m][i] += value[1] * wave * 2 * IBL_PI / COLUMNS;
            if (m) {
                const double next = 2 * c * here - before;
                before = here;
                here = next;
            }
        }
    }
}

/* Rings at angles alpha sinh(u): dense at the peak, sparse in the tail. */
static void make_rings(const view *v, rings *r)
{
    double at[RINGS], weight[RINGS];
    const double end = asinh(IBL_PI / v->alpha);
    memset(r, 0, sizeof *r);
    ibl_gauss_points(RINGS, at, weight);
    for (int i = 0; i < RINGS; i++) {
        const double psi = v->alpha * sinh(end * at[i]);
        r->cosine[i] = cos(psi);
        r->sine[i] = sin(psi);
        r->weight[i] =
            weight[i] * end * v->alpha * cosh(end * at[i]) * r->sine[i];
        transform_ring(v, r, i);
    }
}

static void place_directions(const ibl_lobe_bands *b, double angle, rings *r)
{
    for (int k = 0; k < b->directions; k++) {
        const double psi = angle - b->angle[k];
        r->cosine[RINGS + k] = cos(psi);
        r->sine[RINGS + k] = fabs(sin(psi));
        r->sign[k] = psi < 0 ? -1 : 1;
    }
}

/* Adds the harmonics of order m, given P_mm and 0. */
static void add_order(const rings *r, int m, double here[ALL],
                      double before[ALL], ibl_lobe_bands *b)
{
    const double twice = m ? 2 : 1; /* sqrt(2) cos(m phi), squared */
    double last = 0;                /* the recurrence's factor of before */
    for (int l = m; l <= b->degree; l++) {
        double t[2] = {0, 0};
        for (int i = 0; i < RINGS; i++) {
            t[0] += r->f[0][m][i] * here[i];
            t[1] += r->f[1][m][i] * here[i];
        }
        for (int f = 0; f < 2; f++) {
            b->power[f][l] += twice * t[f] * t[f];
            for (int k = 0; k < b->directions; k++)
                b->toward[f][k][l] +=
                    twice * t[f] * here[RINGS + k] * (m % 2 ? r->sign[k] : 1);
        }
        const double n = l + 1;
        const double factor = sqrt((4 * n * n - 1) / (n * n - m * m));
        for (int i = 0; i < ALL; i++) {
            const double next =
                factor * (r->cosine[i] * here[i] - last * before[i]);
            before[i] = here[i];
            here[i] = next;
        }
        last = 1 / factor;
    }
}

static void clear(ibl_lobe_bands *b)
{
    for (int f = 0; f < 2; f++) {
        memset(b->power[f], 0, (size_t)(b->degree + 1) * sizeof(double));
        for (int k = 0; k < b->directions; k++)
            memset(b->toward[f][k], 0,
                   (size_t)(b->degree + 1) * sizeof(double));
    }
}

/* Scales the lobes to the energy 1 and multiplies by the rings' weights. */
static void normalise(rings *r, double energy[2])
{
    for (int f = 0; f < 2; f++) {
        double sum = 0;
        for (int i = 0; i < RINGS; i++)
            sum += r->weight[i] * r->f[f][0][i];
        energy[f] = sum;
        for (int m = 0; m < ORDERS; m++)
            for (int i = 0; i < RINGS; i++)
                r->f[f][m][i] *= r->weight[i] / sum;
    }
}

ibl_status ibl_lobe_bands_make(double n_dot_v, double alpha, ibl_lobe_bands *b)
{
    const view v = {sqrt((1 - n_dot_v) * (1 + n_dot_v)), n_dot_v, alpha};
    rings *r = ibl_alloc_array(1, sizeof *r);
    double first[ALL];
    if (!r)
        return IBL_ERR_MEMORY;
    make_rings(&v, r);
    place_directions(b, acos(n_dot_v), r);
    normalise(r, b->energy);
    clear(b);
    for (int i = 0; i < ALL; i++)
        first[i] = sqrt(1 / (4 * IBL_PI));
    for (int m = 0; m < ORDERS && m <= b->degree; m++) {
        double here[ALL], before[ALL] = {0};
        memcpy(here, first, sizeof here);
        add_order(r, m, here, before, b);
        for (int i = 0; i < ALL; i++)
            first[i] *= r->sine[i] * sqrt((2 * m + 3) / (2.0 * m + 2));
    }
    ibl_free(r);
    return IBL_OK;
}
