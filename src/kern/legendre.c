/* SPDX-License-Identifier: MIT */
#include "kern/legendre.h"

#include <math.h>

#include "core/alloc.h"
#include "core/pi.h"

static const double pi = IBL_PI;

enum {
    PAD = 16,  /* pairs; a multiple of the lanes of every vector */
    ARRAYS = 7 /* arrays of ibl_legendre_rings, without start */
};

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

/* Ring `ring` of count becomes pair j. */
static void fill_pair(const ibl_legendre_rings *r, ibl_ring_kind kind,
                      int count, int ring, int j)
{
    const int edges = kind == IBL_RINGS_EDGES;
    const double half = 0.5 * pi / (count + edges);

    /* Written as the sine of the latitude: exact also near the equator. */
    r->x[j] = sin(half * (count - 1 - 2 * ring));
    r->x2[j] = r->x[j] * r->x[j];
    r->sine[j] = sin(half * (2 * ring + 1 + edges));
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
                             int count, int first, int end, int degree)
{
    const int pairs = end - first, middle = 2 * end > count;
    const size_t padded = ((size_t)pairs + PAD - 1) / PAD * PAD;
    double *memory =
        ibl_alloc_array(ARRAYS * padded + (size_t)degree + 1, sizeof *memory);

    *r = (ibl_legendre_rings){0};
    if (!memory)
        return false;
    *r = (ibl_legendre_rings){
        2 * pairs - middle,
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
        fill_pair(r, kind, count, first + j, j);
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

/* A multiple of 8 doubles, so that the scratch of each worker stays aligned.
 * legendre_simd.c has its layout. */
size_t ibl_legendre_scratch(int degree)
{
    return ((size_t)degree / 2 / 8 + 3) * 8 * 25 + 25 * 256;
}
