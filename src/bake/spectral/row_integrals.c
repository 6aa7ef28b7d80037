/* SPDX-License-Identifier: MIT */
#include "bake/spectral/row_integrals.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/pi.h"

enum {
    EVERY = IBL_ROW_INTEGRALS_EVERY,
    PARTS = 6
};

/* Below this a power is nothing beside 1, and soon slow. */
static const double nothing = 1e-280;

/* ---- states: (sin theta)^m, S_m and S_m+-1 of each edge ------------------ */

size_t ibl_row_integrals_state(const ibl_row_integrals *r)
{
    return ((size_t)3 * (size_t)r->edges + 7) / 8 * 8;
}

static double *sums_of(const ibl_row_integrals *r, int m, double *state)
{
    return state + (size_t)r->edges * (size_t)(1 + (m & 1));
}

static void begin(const ibl_row_integrals *r, double *state)
{
    for (int j = 0; j < r->edges; j++) {
        state[j] = 1;
        sums_of(r, 0, state)[j] = r->x[j];
        /* S_-1 is the latitude. */
        sums_of(r, 1, state)[j] = IBL_PI / 2 - IBL_PI * j / r->rows;
    }
}

void ibl_row_integrals_next(const ibl_row_integrals *r, int m, double *state)
{
    double *s = sums_of(r, m + 1, state);
    const double share = (m + 1) / (m + 2.0), inverse = 1 / (m + 2.0);
    for (int j = 0; j < r->edges; j++) {
        const double power = state[j] * r->sine[j];
        state[j] = power > nothing ? power : 0;
        s[j] = r->x[j] * state[j] * inverse + s[j] * share;
    }
}

void ibl_row_integrals_seek(const ibl_row_integrals *r, int m, double *state)
{
    const size_t each = ibl_row_integrals_state(r);
    memcpy(state, r->states + (size_t)(m / EVERY) * each, each * sizeof *state);
    for (int k = m / EVERY * EVERY; k < m; k++)
        ibl_row_integrals_next(r, k, state);
}

bool ibl_row_integrals_init(ibl_row_integrals *r, int rows, int degree)
{
    const size_t kept = (size_t)degree / EVERY + 1;
    *r = (ibl_row_integrals){.rows = rows, .edges = rows / 2 + 1};
    const size_t edges = (size_t)r->edges, each = ibl_row_integrals_state(r);
    r->x = ibl_alloc_array(2 * edges + kept * each, sizeof *r->x);
    if (!r->x)
        return false;
    r->sine = r->x + edges;
    r->states = r->sine + edges;
    for (int j = 0; j < r->edges; j++) {
        r->x[j] = sin(0.5 * IBL_PI * (rows - 2 * j) / rows);
        r->sine[j] = sin(IBL_PI * j / rows);
    }
    begin(r, r->states);
    for (size_t k = 1; k < kept; k++) {
        double *state = r->states + k * each;
        memcpy(state, state - each, each * sizeof *state);
        for (int m = (int)(k - 1) * EVERY; m < (int)k * EVERY; m++)
            ibl_row_integrals_next(r, m, state);
    }
    return true;
}

void ibl_row_integrals_free(ibl_row_integrals *r)
{
    ibl_free(r->x);
    *r = (ibl_row_integrals){0};
}

/* ---- sums --------------------------------------------------------------- */

/* Sums over all rows with the integrals of (sin theta)^m. */
static void add_rows(const ibl_row_integrals *r, const double *s,
                     const float *f, size_t stride, double sum[PARTS])
{
    const int last = r->rows - 1;
    for (int j = 0; j < r->rows / 2; j++) {
        const double mass = s[j] - s[j + 1];
        for (int p = 0; p < PARTS; p++) {
            const float *part = f + (size_t)p * stride;
            sum[p] += mass * ((double)part[j] + (double)part[last - j]);
        }
    }
    /* A row across the equator. */
    for (int p = 0; p < PARTS && r->rows % 2; p++)
        sum[p] += 2 * s[last / 2] * (double)f[(size_t)p * stride + last / 2];
}

/* e_l */
static double ratio(int l, int m)
{
    return sqrt(((double)l - m) * (l + m) / ((2.0 * l - 1) * (2.0 * l + 1)));
}

void ibl_row_integrals_finish(const ibl_row_integrals *r, const double *state,
                              int m, int degree, const float *f, size_t stride,
                              double start, double scale, double *a)
{
    const double *s = state + (size_t)r->edges * (size_t)(1 + (m & 1));
    double sum[PARTS] = {0}, before[PARTS], last = 0;

    add_rows(r, s, f, stride, sum);
    memcpy(before, a, sizeof before);
    for (int p = 0; p < PARTS; p++)
        a[p] = start * scale * sum[p];
    for (int l = m + 1; l <= degree; l++) {
        const double e = ratio(l, m), inverse = 1 / ((l + 1) * e);
        const double keep = (l - 2) * last * inverse;
        a += PARTS;
        for (int p = 0; p < PARTS; p++) {
            const double b = a[p];
            a[p] = -before[p] * scale * inverse;
            if (l >= m + 2)
                a[p] += keep * a[p - 2 * PARTS];
            before[p] = b;
        }
        last = e;
    }
}
