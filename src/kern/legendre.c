/* SPDX-License-Identifier: MIT */
/*
 * The plain version. For fixed m, with
 *     e_l = sqrt((l^2 - m^2) / (4 l^2 - 1)),
 *     e_l+1 P_l+1 = x P_l - e_l P_l-1,
 * upwards from P_mm, P_m-1,m = 0: stable, as P is the solution that grows
 * where it does not oscillate.
 */
#include "kern/legendre.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/pi.h"

static const double pi = IBL_PI;

enum {
    PAD = 16,   /* pairs; a multiple of the lanes of every vector */
    ARRAYS = 7, /* arrays of ibl_legendre_rings, without start */
    PARTS = 6
};

/* ---- what all versions share ---------------------------------------- */

/* value = mantissa 2^exponent, the mantissa in [sqrt(1/2), sqrt(2)). */
static void split(double value, double *mantissa, double *exponent)
{
    int e;
    double f = frexp(value, &e);

    if (f < sqrt(0.5)) {
        f *= 2.0;
        e--;
    }
    *mantissa = f;
    *exponent = e;
}

static void fill_pair(ibl_legendre_rings *r, ibl_ring_kind kind, int j)
{
    const int edges = kind == IBL_RINGS_EDGES;
    const double half = 0.5 * pi / (r->count + edges);

    /* Written as the sine of the latitude: exact also near the equator. */
    r->x[j] = sin(half * (r->count - 1 - 2 * j));
    r->x2[j] = r->x[j] * r->x[j];
    r->sine[j] = sin(half * (2 * j + 1 + edges));
    split(r->sine[j], &r->mantissa[j], &r->exponent[j]);
    /* The mantissa's power is at most 2^256. */
    split(pow(r->mantissa[j], 512.0), &r->mantissa_512[j], &r->exponent_512[j]);
}

/* P_mm = sqrt((2m + 1)!! / (2m)!! / 4 pi) (sin theta)^m. */
static void fill_start(double *start, int degree)
{
    start[0] = sqrt(0.25 / pi);
    for (int m = 1; m <= degree; m++)
        start[m] = start[m - 1] * sqrt((2.0 * m + 1.0) / (2.0 * m));
}

bool ibl_legendre_rings_init(ibl_legendre_rings *r, ibl_ring_kind kind,
                             int count, int degree)
{
    const int pairs = (count + 1) / 2;
    const size_t padded = ((size_t)pairs + PAD - 1) / PAD * PAD;
    double *memory =
        ibl_alloc_array(ARRAYS * padded + (size_t)degree + 1, sizeof *memory);

    *r = (ibl_legendre_rings){0};
    if (!memory)
        return false;
    *r = (ibl_legendre_rings){
        count,
        pairs,
        memory,
        memory + padded,
        memory + 2 * padded,
        memory + 3 * padded,
        memory + 4 * padded,
        memory + 5 * padded,
        memory + 6 * padded,
        memory + ARRAYS * padded,
    };
    for (int j = 0; j < pairs; j++)
        fill_pair(r, kind, j);
    for (size_t j = (size_t)pairs; j < padded; j++) {
        r->x[j] = r->x2[j] = 0.0;
        r->sine[j] = r->mantissa[j] = r->mantissa_512[j] = 1.0;
        r->exponent[j] = r->exponent_512[j] = 0.0;
    }
    fill_start(r->start, degree);
    return true;
}

void ibl_legendre_rings_free(ibl_legendre_rings *r)
{
    if (!r)
        return;
    ibl_free(r->x);
    *r = (ibl_legendre_rings){0};
}

/* ---- the plain version ---------------------------------------------- */

/* P_lm on one ring for increasing l. The value is p 2^(-512 scaled). */
struct legendre {
    double x, p, last; /* p at l, last at l - 1 */
    int scaled;
};

/* Lowers `scaled` once p has grown past 2^256. */
static void rescale(struct legendre *q)
{
    if (q->scaled && q->p > 0x1p256) {
        q->p *= 0x1p-512;
        q->last *= 0x1p-512;
        q->scaled--;
    }
}

static struct legendre begin(const ibl_legendre_order *o, int j)
{
    struct legendre q = {o->rings->x[j], o->rings->start[o->m], 0.0, 0};

    for (int i = 0; i < o->m; i++) {
        q.p *= o->rings->sine[j];
        if (q.p < 0x1p-256) {
            q.p *= 0x1p512;
            q.scaled++;
        }
    }
    return q;
}

/* Steps from l to l + 1; e[0] is e_l. */
static void step(struct legendre *q, const double *e)
{
    const double next = (q->x * q->p - e[0] * q->last) / e[1];

    q->last = q->p;
    q->p = next;
    rescale(q);
}

/* Computes e_l for l = m..degree + 1. */
static const double *coefficients(const ibl_legendre_order *o)
{
    const double m = o->m;

    for (int l = o->m; l <= o->degree + 1; l++)
        o->scratch[l - o->m] =
            sqrt(((double)l - m) * (l + m) / ((2.0 * l - 1.0) * (2.0 * l + 1)));
    return o->scratch;
}

/* The difference of the rows beside an edge. */
static double step_of(const float *f, int j)
{
    return (double)f[j + 1] - (double)f[j];
}

static void analyse(const ibl_legendre_order *o, const float *f, size_t stride,
                    double *a)
{
    const ibl_legendre_rings *r = o->rings;
    const int terms = o->degree - o->m + 1;
    const double *e = coefficients(o);

    memset(a, 0, (size_t)terms * PARTS * sizeof *a);
    for (int j = 0; j < r->pairs; j++) {
        struct legendre q = begin(o, j);
        double sum[2][PARTS]; /* one for even, one for odd l - m */
        const int mirror = r->count - 1 - j;
        const double weight = r->sine[j] * r->sine[j];
        for (int part = 0; part < PARTS; part++) {
            const float *ring = f + (size_t)part * stride;
            const double north = weight * step_of(ring, j);
            const double south =
                mirror == j ? 0.0 : weight * step_of(ring, mirror);
            sum[0][part] = north + south;
            sum[1][part] = north - south;
        }
        for (int l = 0; l < terms; l++) {
            for (int part = 0; part < PARTS && !q.scaled; part++)
                a[PARTS * l + part] += q.p * sum[l % 2][part];
            step(&q, e + l);
        }
    }
}

static void synthesise(const ibl_legendre_order *o, const double *a,
                       const double *factor, float *g, size_t stride)
{
    const ibl_legendre_rings *r = o->rings;
    const int terms = o->degree - o->m + 1;
    const double *e = coefficients(o);

    for (int j = 0; j < r->pairs; j++) {
        struct legendre q = begin(o, j);
        double sum[2][PARTS] = {{0.0}};
        for (int l = 0; l < terms; l++) {
            const double p = q.scaled ? 0.0 : q.p * factor[o->m + l];
            for (int part = 0; part < PARTS; part++)
                sum[l % 2][part] += p * a[PARTS * l + part];
            step(&q, e + l);
        }
        for (int part = 0; part < PARTS; part++) {
            float *ring = g + (size_t)part * stride;
            ring[j] = (float)(sum[0][part] + sum[1][part]);
            ring[r->count - 1 - j] = (float)(sum[0][part] - sum[1][part]);
        }
    }
}

/* A multiple of 8 doubles, so that the scratch of each worker stays aligned.
 * legendre_simd.c has the layout of the vector versions. */
size_t ibl_legendre_scratch(int degree)
{
    return ((size_t)degree / 2 / 8 + 3) * 8 * 25 + 25 * 256;
}

IBL_KERNEL(ibl_legendre, analyse, synthesise)
