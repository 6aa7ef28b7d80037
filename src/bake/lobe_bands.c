/* SPDX-License-Identifier: MIT */
#include "bake/lobe_bands.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "bake/lobe_kernels.h"
#include "bake/true_lobe.h"
#include "brdf/ggx.h"
#include "core/two.h"
#include "kern/brdf_quadrature.h"

enum {
    RINGS = IBL_BANDS_RINGS,
    COLUMNS = IBL_BANDS_COLUMNS,
    ORDERS = IBL_BANDS_ORDERS,
    EXTRA = IBL_BANDS_DIRECTIONS
};

/* Orders below this share of the lobe are left out. */
static const double negligible = 1e-3;

/* Fourier coefficients of the lobe on rings. */
typedef struct rings {
    double cosine[RINGS], sine[RINGS];
    double weight[RINGS];
    double f[ORDERS][2][RINGS];
} rings;

typedef struct view {
    double sine, cosine, alpha;
} view;

/*
 * The normalised functions have
 *     P_l+1 = a_l x P_l - a_l / a_l-1 P_l-1,
 *     a_l = sqrt((4 n^2 - 1) / (n^2 - m^2)), n = l + 1.
 * P_l = s_l Q_l with s_l+1 = a_l / s_l, of alternating sign, leaves one factor:
 *     Q_l+1 = +-s_l^2 x Q_l + Q_l-1.
 */
static void fill_recurrence(int m, double *factor, double *scale)
{
    scale[m] = 1;
    for (int l = m; l < IBL_LOBE_DEGREE; l++) {
        const double n = l + 1, sign = (l - m) % 2 ? -1 : 1;
        factor[l] = sign * scale[l] * scale[l];
        scale[l + 1] =
            sqrt((4 * n * n - 1) / (n * n - m * m)) / (sign * scale[l]);
    }
}

void ibl_bands_rule_init(ibl_bands_rule *rule, ibl_isa isa)
{
    ibl_legendre_sums_dsp_init(&rule->dsp, isa);
    ibl_gauss_points(RINGS, rule->at, rule->weight);
    for (int k = 0; k < COLUMNS; k++) {
        const double phi = IBL_PI * (k + 0.5) / COLUMNS;
        rule->sine[k] = sin(phi);
        for (int m = 0; m < ORDERS; m++)
            rule->wave[k][m] = cos(m * phi);
    }
    for (int m = 0; m < ORDERS; m++)
        fill_recurrence(m, rule->factor[m], rule->scale[m]);
}

_Static_assert(RINGS % IBL_LEGENDRE_VALUES_POINTS == 0 &&
                   (int)EXTRA == (int)IBL_LEGENDRE_VALUES_POINTS &&
                   ORDERS % 2 == 0,
               "vectors");

/* f N.L at a direction, for F0 = 1 and .04; false: it is 0. */
static bool lobe_at(const view *v, const double l[3], double value[2])
{
    const double h[3] = {l[0] - v->sine, l[1], l[2] + v->cosine};
    const double flat = h[0] * h[0] + h[1] * h[1], square = flat + h[2] * h[2];
    const double a2 = v->alpha * v->alpha;
    if (!(l[2] > 0 && square > 0))
        return false;
    const double d = ibl_ggx_d((flat + a2 * h[2] * h[2]) / square, v->alpha);
    const double fresnel = ibl_fresnel_weight(0.5 * sqrt(square));
    value[0] = d * ibl_smith_visibility(l[2], v->cosine, v->alpha) * l[2];
    value[1] =
        value[0] * (IBL_DIELECTRIC_F0 + (1 - IBL_DIELECTRIC_F0) * fresnel);
    return true;
}

/* Integrals of the lobe on a ring with cos(m phi). */
static void transform_ring(const ibl_bands_rule *rule, const view *v, rings *r,
                           int i)
{
    ibl_two sum[2][ORDERS / 2] = {{{0}}};
    for (int k = 0; k < COLUMNS; k++) {
        const double *wave = rule->wave[k];
        const double across = r->sine[i] * wave[1];
        const double l[3] = {v->sine * r->cosine[i] - v->cosine * across,
                             r->sine[i] * rule->sine[k],
                             v->cosine * r->cosine[i] + v->sine * across};
        double value[2];
        if (!lobe_at(v, l, value))
            continue;
#pragma GCC unroll 6
        for (int m = 0; m < ORDERS / 2; m++) {
            sum[0][m] += value[0] * ibl_two_at(wave + 2 * m);
            sum[1][m] += value[1] * ibl_two_at(wave + 2 * m);
        }
    }
    for (int m = 0; m < ORDERS; m++)
        for (int f = 0; f < 2; f++)
            r->f[m][f][i] =
                sum[f][m / 2][m % 2] * r->weight[i] * 2 * IBL_PI / COLUMNS;
}

/* Rings at angles alpha sinh(u): dense at the peak, sparse in the tail. */
static void make_rings(const ibl_bands_rule *rule, const view *v, rings *r)
{
    const double end = asinh(IBL_PI / v->alpha);
    for (int i = 0; i < RINGS; i++) {
        const double e = exp(end * rule->at[i]);
        const double psi = 0.5 * v->alpha * (e - 1 / e);
        r->cosine[i] = cos(psi);
        r->sine[i] = sin(psi);
        r->weight[i] =
            rule->weight[i] * end * 0.5 * v->alpha * (e + 1 / e) * r->sine[i];
        transform_ring(rule, v, r, i);
    }
}

/* Points, and Legendre's normalised functions there, of order m and at the
 * degrees of bands from index at on. */
typedef struct legendre {
    int count; /* points */
    double cosine[RINGS], sine[RINGS];
    int m, at;
    double first[RINGS];                 /* of degree m */
    double value[IBL_BANDS_MOST][RINGS]; /* over the rule's scale */
} legendre;

static void find_values(const ibl_bands_rule *rule, const ibl_lobe_bands *b,
                        legendre *p)
{
    while (p->at < b->count && b->degree[p->at] < p->m)
        p->at++;
    rule->dsp.values(p->cosine, p->first, p->count, rule->factor[p->m], p->m,
                     b->degree + p->at, b->count - p->at, RINGS,
                     p->value[p->at]);
}

static void start_orders(legendre *p)
{
    p->m = p->at = 0;
    for (int i = 0; i < p->count; i++)
        p->first[i] = sqrt(1 / (4 * IBL_PI));
}

static void next_order(legendre *p)
{
    for (int i = 0; i < p->count; i++)
        p->first[i] *= p->sine[i] * sqrt((2 * p->m + 3) / (2.0 * p->m + 2));
    p->m++;
}

/* Adds the harmonics of an order. */
static void add_harmonics(const ibl_bands_rule *rule, const rings *r,
                          const legendre *p, ibl_lobe_bands *b)
{
    const int m = p->m;
    const double twice = m ? 2 : 1; /* sqrt(2) cos(m phi), squared */
    for (int at = p->at; at < b->count; at++) {
        const double scale = rule->scale[m][b->degree[at]];
        ibl_two part[2] = {{0}};
#pragma GCC unroll 4
        for (int i = 0; i < RINGS; i += 2)
            for (int f = 0; f < 2; f++)
                part[f] +=
                    ibl_two_at(r->f[m][f] + i) * ibl_two_at(p->value[at] + i);
        for (int f = 0; f < 2; f++) {
            const double sum = scale * (part[f][0] + part[f][1]);
            b->power[f][at] += twice * sum * sum;
            b->order[f][m][at] = twice * scale * sum;
        }
    }
}

/* Scales the lobes to the energy 1. */
static void normalise(rings *r, double energy[2])
{
    for (int f = 0; f < 2; f++) {
        energy[f] = 0;
        for (int i = 0; i < RINGS; i++)
            energy[f] += r->f[0][f][i];
        for (int m = 0; m < ORDERS; m++)
            for (int i = 0; i < RINGS; i++)
                r->f[m][f][i] /= energy[f];
    }
}

/* The number of orders that matter. */
static int orders_of(const rings *r)
{
    int m = ORDERS;
    for (double sum = 0; sum < negligible && m > 1; m--) {
        sum = 0;
        for (int i = 0; i < RINGS; i++)
            sum += fabs(r->f[m - 1][0][i]);
    }
    return m + 1;
}

void ibl_bands_degrees(const double *power, double roughness, ibl_lobe_bands *b)
{
    ibl_bands_fill(power,
                   (int)fmin(IBL_LOBE_DEGREE, 6 / (roughness * roughness) + 24),
                   16, b);
}

void ibl_bands_fill(const double *power, int last, int part, ibl_lobe_bands *b)
{
    b->count = 0;
    memset(b->share, 0, sizeof b->share);
    for (int l = 1; l < last; l += 1 + l / part)
        b->degree[b->count++] = l;
    b->degree[b->count++] = last;
    for (int i = 0; i + 1 < b->count; i++) {
        const int low = b->degree[i], high = b->degree[i + 1];
        for (int l = low + !!i; l <= high; l++) {
            const double c = (2 * l + 1) / (4 * IBL_PI) * power[l];
            const double t = (double)(l - low) / (high - low);
            b->share[i] += (1 - t) * c;
            b->share[i + 1] += t * c;
        }
    }
}

void ibl_lobe_bands_toward(const ibl_bands_rule *rule, double n_dot_v,
                           int first, ibl_lobe_bands *b)
{
    legendre p;
    p.count = EXTRA;
    memset(p.cosine, 0, sizeof p.cosine);
    memset(p.sine, 0, sizeof p.sine);
    for (int k = 0; k < b->directions - first; k++) {
        const double psi = acos(n_dot_v) - b->angle[first + k];
        p.cosine[k] = cos(psi);
        p.sine[k] = sin(psi); /* towards N: phi = 0 */
        for (int f = 0; f < 2; f++)
            memset(b->toward[f][first + k], 0, sizeof b->toward[f][first + k]);
    }
    for (start_orders(&p); p.m < b->orders; next_order(&p)) {
        find_values(rule, b, &p);
        for (int f = 0; f < 2; f++)
            for (int k = 0; k < b->directions - first; k++)
                for (int at = p.at; at < b->count; at++)
                    b->toward[f][first + k][at] +=
                        b->order[f][p.m][at] * p.value[at][k];
    }
}

void ibl_lobe_bands_make(const ibl_bands_rule *rule, double n_dot_v,
                         double alpha, ibl_lobe_bands *b)
{
    const view v = {sqrt((1 - n_dot_v) * (1 + n_dot_v)), n_dot_v, alpha};
    legendre p;
    rings r;
    p.count = RINGS;
    make_rings(rule, &v, &r);
    normalise(&r, b->energy);
    b->orders = orders_of(&r);
    memset(b->power, 0, sizeof b->power);
    memcpy(p.cosine, r.cosine, sizeof p.cosine);
    memcpy(p.sine, r.sine, sizeof p.sine);
    for (start_orders(&p); p.m < b->orders; next_order(&p)) {
        find_values(rule, b, &p);
        add_harmonics(rule, &r, &p, b);
    }
    ibl_lobe_bands_toward(rule, n_dot_v, 0, b);
}
