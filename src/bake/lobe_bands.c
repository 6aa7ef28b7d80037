/* SPDX-License-Identifier: MIT */
#include "bake/lobe_bands.h"

#include <math.h>
#include <string.h>

#include "bake/lobe_kernels.h"
#include "bake/true_lobe.h"
#include "brdf/ggx.h"
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

void ibl_bands_rule_init(ibl_bands_rule *rule)
{
    ibl_gauss_points(RINGS, rule->at, rule->weight);
    for (int k = 0; k < COLUMNS; k++) {
        const double phi = IBL_PI * (k + 0.5) / COLUMNS;
        rule->sine[k] = sin(phi);
        for (int m = 0; m < ORDERS; m++)
            rule->wave[k][m] = cos(m * phi);
    }
}

/* Two numbers, in one vector on most CPUs. */
typedef double two __attribute__((vector_size(16)));

_Static_assert(RINGS % 2 == 0 && ORDERS % 2 == 0 && EXTRA % 2 == 0, "pairs");

static two load(const double *p)
{
    two v;
    memcpy(&v, p, sizeof v);
    return v;
}

static void store(double *p, two v)
{
    memcpy(p, &v, sizeof v);
}

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
static void transform_ring(const ibl_bands_rule *rule, const view *v, rings *r,
                           int i)
{
    two sum[2][ORDERS / 2] = {{{0}}};
    for (int k = 0; k < COLUMNS; k++) {
        const double *wave = rule->wave[k];
        const double across = r->sine[i] * wave[1];
        const double l[3] = {v->sine * r->cosine[i] - v->cosine * across,
                             r->sine[i] * rule->sine[k],
                             v->cosine * r->cosine[i] + v->sine * across};
        double value[2];
        lobe_at(v, l, value);
#pragma GCC unroll 6
        for (int m = 0; m < ORDERS / 2; m++) {
            sum[0][m] += value[0] * load(wave + 2 * m);
            sum[1][m] += value[1] * load(wave + 2 * m);
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

/* Legendre's normalised functions of an order m at some points. */
typedef struct legendre {
    int m, l;
    double last; /* the recurrence's factor of l - 1 */
    double value[2][RINGS];
} legendre;

/* Those of degree l; the other half of value is of l - 1. */
static inline const double *here(const legendre *p)
{
    return p->value[p->l & 1];
}

/* first: P_mm; count: points, an even number */
static void start_order(int m, const double *first, int count, legendre *p)
{
    p->m = p->l = m;
    p->last = 0;
    for (int i = 0; i < count; i++) {
        p->value[m & 1][i] = first[i];
        p->value[~m & 1][i] = 0;
    }
}

static inline void next_degree(legendre *p, const double *cosine, int count)
{
    const double *now = here(p);
    const double n = ++p->l, last = p->last;
    const double factor = sqrt((4 * n * n - 1) / (n * n - p->m * p->m));
    double *next = p->value[p->l & 1];
    for (int i = 0; i < count; i += 2)
        store(next + i, factor * (load(cosine + i) * load(now + i) -
                                  last * load(next + i)));
    p->last = 1 / factor;
}

/* P_mm of order m + 1, given that of m. */
static void next_order(int m, const double *sine, int count, double *first)
{
    for (int i = 0; i < count; i++)
        first[i] *= sine[i] * sqrt((2 * m + 3) / (2.0 * m + 2));
}

static int first_degree(const ibl_lobe_bands *b, int m)
{
    int at = 0;
    while (at < b->count && b->degree[at] < m)
        at++;
    return at;
}

/* Adds the harmonics of order m at the degree of index at. */
static void add_harmonics(const rings *r, int m, const double value[RINGS],
                          int at, ibl_lobe_bands *b)
{
    const double twice = m ? 2 : 1; /* sqrt(2) cos(m phi), squared */
    two part[2] = {{0}};
    for (int i = 0; i < RINGS; i += 2)
        for (int f = 0; f < 2; f++)
            part[f] += load(r->f[m][f] + i) * load(value + i);
    for (int f = 0; f < 2; f++) {
        const double sum = part[f][0] + part[f][1], t = twice * sum;
        b->power[f][at] += t * sum;
        b->order[f][m][at] = t;
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

void ibl_lobe_bands_toward(double n_dot_v, int first, ibl_lobe_bands *b)
{
    const int count = b->directions - first, even = count + count % 2;
    double cosine[EXTRA] = {0}, sine[EXTRA] = {0}, sign[EXTRA];
    double start[EXTRA] = {0};
    legendre p;
    for (int k = 0; k < count; k++) {
        const double psi = acos(n_dot_v) - b->angle[first + k];
        cosine[k] = cos(psi);
        sine[k] = fabs(sin(psi));
        sign[k] = psi < 0 ? -1 : 1; /* towards or away from N */
        start[k] = sqrt(1 / (4 * IBL_PI));
        for (int f = 0; f < 2; f++)
            memset(b->toward[f][first + k], 0, sizeof b->toward[f][first + k]);
    }
    for (int m = 0; m < b->orders; m++) {
        start_order(m, start, even, &p);
        for (int at = first_degree(b, m); at < b->count; at++) {
            while (p.l < b->degree[at])
                next_degree(&p, cosine, even);
            for (int f = 0; f < 2; f++)
                for (int k = 0; k < count; k++)
                    b->toward[f][first + k][at] += b->order[f][m][at] *
                                                   here(&p)[k] *
                                                   (m % 2 ? sign[k] : 1);
        }
        next_order(m, sine, even, start);
    }
}

void ibl_lobe_bands_make(const ibl_bands_rule *rule, double n_dot_v,
                         double alpha, ibl_lobe_bands *b)
{
    const view v = {sqrt((1 - n_dot_v) * (1 + n_dot_v)), n_dot_v, alpha};
    double first[RINGS];
    legendre p;
    rings r;
    make_rings(rule, &v, &r);
    normalise(&r, b->energy);
    b->orders = orders_of(&r);
    memset(b->power, 0, sizeof b->power);
    for (int i = 0; i < RINGS; i++)
        first[i] = sqrt(1 / (4 * IBL_PI));
    for (int m = 0; m < b->orders; m++) {
        start_order(m, first, RINGS, &p);
        for (int at = first_degree(b, m); at < b->count; at++) {
            while (p.l < b->degree[at])
                next_degree(&p, r.cosine, RINGS);
            add_harmonics(&r, m, here(&p), at, b);
        }
        next_order(m, r.sine, RINGS, first);
    }
    ibl_lobe_bands_toward(n_dot_v, 0, b);
}
