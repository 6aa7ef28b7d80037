/* SPDX-License-Identifier: MIT */
/* Orders are independent of each other: a job does ORDERS of them. */
#include "bake/spectral/transform.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "kern/legendre.h"

enum {
    LINE = 16, /* floats in a cache line */
    PARTS = 6,
    PAIRS = PARTS / 2,
    ORDERS = 4, /* in a job: a few milliseconds of the largest analysis */
    KEPT = 4    /* jobs that share a state */
};

/* ---- two doubles, in one vector on most CPUs ---------------------------- */

typedef double two __attribute__((vector_size(16)));
typedef float two_floats __attribute__((vector_size(8)));

static two two_at(const double *p)
{
    two v;
    memcpy(&v, p, sizeof v);
    return v;
}

static void put_two(double *p, two v)
{
    memcpy(p, &v, sizeof v);
}

static two two_at_floats(const float *p)
{
    two_floats v;
    memcpy(&v, p, sizeof v);
    return __builtin_convertvector(v, two);
}

static void put_two_floats(float *p, two v)
{
    const two_floats f = __builtin_convertvector(v, two_floats);
    memcpy(p, &f, sizeof f);
}

/* ---- what is transformed ------------------------------------------------ */

ibl_status ibl_ring_spectra_alloc(ibl_ctx *ctx, int rings, int orders,
                                  ibl_ring_spectra *out)
{
    const size_t stride = (((size_t)rings + LINE - 1) / LINE | 1) * LINE;

    *out = (ibl_ring_spectra){0};
    assert(rings >= 1 && rings <= IBL_MAX_EDGE);
    assert(orders >= 1 && orders <= IBL_SHT_MAX_DEGREE + 1);
    float *data = ibl_alloc_array(6 * (size_t)orders, stride * sizeof *data);
    if (!data)
        return ibl_no_memory(ctx, "the spectra of the rings");
    *out = (ibl_ring_spectra){rings, orders, stride, data};
    return IBL_OK;
}

void ibl_ring_spectra_free(ibl_ring_spectra *s)
{
    ibl_free(s->data);
    *s = (ibl_ring_spectra){0};
}

/* Beyond the turning point m = l sin theta, P_lm falls like an Airy function of
 * a width that grows with the cube root of the degree. */
int ibl_row_orders(int rows, int degree, int group)
{
    const double first = group * IBL_ROW_GROUP, equator = 0.5 * rows;
    const double nearest = fmax(fmin(equator, first + IBL_ROW_GROUP), first);
    const double orders =
        degree * sin(IBL_PI * nearest / rows) + 4.5 * cbrt(degree) + 2;
    return orders <= degree ? (int)orders : degree + 1;
}

ibl_status ibl_row_spectra_alloc(ibl_ctx *ctx, int rows, int degree,
                                 ibl_row_spectra *out)
{
    const int groups = (rows + IBL_ROW_GROUP - 1) / IBL_ROW_GROUP;

    assert(rows >= 1 && rows <= IBL_MAX_EDGE);
    assert(degree >= 0 && degree <= IBL_SHT_MAX_DEGREE);
    *out = (ibl_row_spectra){.rows = rows, .degree = degree, .groups = groups};
    out->at = ibl_alloc_array((size_t)groups + 1, sizeof *out->at);
    if (out->at) {
        out->at[0] = 0;
        for (int g = 0; g < groups; g++)
            out->at[g + 1] =
                out->at[g] +
                (size_t)ibl_row_orders(rows, degree, g) * PARTS * IBL_ROW_GROUP;
        out->data = ibl_alloc_array(out->at[groups], sizeof *out->data);
    }
    if (!out->data) {
        ibl_row_spectra_free(out);
        return ibl_no_memory(ctx, "the spectra of the rows");
    }
    return IBL_OK;
}

void ibl_row_spectra_free(ibl_row_spectra *s)
{
    ibl_free(s->at);
    ibl_free(s->data);
    *s = (ibl_row_spectra){0};
}

ibl_status ibl_harmonics_alloc(ibl_ctx *ctx, int degree, ibl_harmonics *out)
{
    *out = (ibl_harmonics){0};
    assert(degree >= 0 && degree <= IBL_SHT_MAX_DEGREE);
    const size_t n = (size_t)degree + 1;
    float *data = ibl_alloc_array(n * (n + 1) / 2, 6 * sizeof *data);
    if (!data)
        return ibl_no_memory(ctx, "spherical harmonics");
    *out = (ibl_harmonics){degree, degree + 1, data};
    return IBL_OK;
}

void ibl_harmonics_free(ibl_harmonics *h)
{
    ibl_free(h->data);
    *h = (ibl_harmonics){0};
}

void ibl_sht_power(const ibl_harmonics *h, double *power)
{
    for (int l = 0; l <= h->degree; l++)
        power[l] = 0.0;
    for (int m = 0; m <= h->degree; m++) {
        const float *a = ibl_harmonics_at(h, m);
        for (int l = m; l <= h->degree; l++, a += PARTS) {
            two square = {0};
#pragma GCC unroll 3
            for (int p = 0; p < PARTS; p += 2)
                square += two_at_floats(a + p) * two_at_floats(a + p);
            power[l] += (m ? 2 : 1) * (square[0] + square[1]);
        }
    }
}

/* ---- integrals over rows ------------------------------------------------ */

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

/* A power below this is negligible beside 1. */
static const double nothing = 1e-30;

/* Constant after creation. */
typedef struct row_integrals {
    int rows;
    int edges;      /* from the pole to the equator */
    double *x;      /* cos theta of each */
    double *sine;   /* sin theta */
    double *states; /* of the first order of every KEPT jobs */
} row_integrals;

/* Doubles in a state: (sin theta)^m, S_m and S_m+-1 for each edge; before
 * them, the first edge where the power matters. */
static size_t state_size(const row_integrals *r)
{
    return ((size_t)3 * (size_t)r->edges + 1 + 7) / 8 * 8;
}

static double *sums_of(const row_integrals *r, int m, double *state)
{
    return state + 1 + (size_t)r->edges * (size_t)(1 + (m & 1));
}

static void begin(const row_integrals *r, double *state)
{
    state[0] = 0;
    for (int j = 0; j < r->edges; j++) {
        state[1 + j] = 1;
        sums_of(r, 0, state)[j] = r->x[j];
        /* S_-1 is the latitude. */
        sums_of(r, 1, state)[j] = IBL_PI / 2 - IBL_PI * j / r->rows;
    }
}

/* Advances a state from order m to m + 1. */
static void next_order(const row_integrals *r, int m, double *state)
{
    double *restrict s = sums_of(r, m + 1, state), *restrict power = state + 1;
    const double share = (m + 1) / (m + 2.0), inverse = 1 / (m + 2.0);
    int j = (int)state[0];
    while (j + 1 < r->edges && power[j + 1] < nothing)
        j++;
    state[0] = j;
    for (; j + 2 <= r->edges; j += 2) {
        const two p = two_at(power + j) * two_at(r->sine + j);
        put_two(power + j, p);
        put_two(s + j, two_at(r->x + j) * p * inverse + two_at(s + j) * share);
    }
    for (; j < r->edges; j++) {
        power[j] *= r->sine[j];
        s[j] = r->x[j] * power[j] * inverse + s[j] * share;
    }
}

static bool row_integrals_init(row_integrals *r, int rows, int degree)
{
    const size_t kept = (size_t)degree / (KEPT * ORDERS) + 1;
    *r = (row_integrals){.rows = rows, .edges = rows / 2 + 1};
    const size_t edges = (size_t)r->edges, each = state_size(r);
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
        for (int m = (int)(k - 1) * KEPT * ORDERS; m < (int)k * KEPT * ORDERS;
             m++)
            next_order(r, m, state);
    }
    return true;
}

static void row_integrals_free(row_integrals *r)
{
    ibl_free(r->x);
    *r = (row_integrals){0};
}

/* e_l */
static double ratio(int l, int m)
{
    return sqrt(((double)l - m) * (l + m) / ((2.0 * l - 1) * (2.0 * l + 1)));
}

/* ---- both ways ---------------------------------------------------------- */

struct transform {
    ibl_legendre_dsp dsp;
    ibl_legendre_rings rings;
    int degree, single; /* see ibl_legendre_order */
    double *scratch;    /* for each worker */
    const ibl_harmonics *harmonics;
    const ibl_ring_spectra *spectra; /* of a synthesis */
    const double *factor;
    const ibl_row_spectra *rows; /* of an analysis */
    const double *width;         /* for each order */
    row_integrals integrals;
};

/* Floats between the parts of an order of all rows. */
static size_t row_stride(const struct transform *t)
{
    return ((size_t)t->rows->groups | 1) * IBL_ROW_GROUP;
}

/* Doubles of scratch for a worker: of an analysis also a state, and the rows
 * and the sums of an order. */
static size_t scratch_of(const struct transform *t)
{
    return ibl_legendre_scratch(t->degree) +
           (t->rows ? state_size(&t->integrals) + PARTS * row_stride(t) / 2 +
                          PARTS * ((size_t)t->degree + 1)
                    : 0);
}

static ibl_status prepare(ibl_ctx *ctx, struct transform *t, ibl_ring_kind kind,
                          int rings, int first, int end)
{
    const size_t workers = (size_t)ibl_ctx_threads(ctx);

    ibl_legendre_dsp_init(&t->dsp, ibl_ctx_isa(ctx));
    t->scratch = ibl_alloc_array(workers, scratch_of(t) * sizeof *t->scratch);
    if (!t->scratch ||
        !ibl_legendre_rings_init(&t->rings, kind, rings, first, end, t->degree))
        return ibl_no_memory(ctx, "a spherical harmonic transform");
    return IBL_OK;
}

static void release(struct transform *t)
{
    row_integrals_free(&t->integrals);
    ibl_legendre_rings_free(&t->rings);
    ibl_free(t->scratch);
}

static int last_order(const struct transform *t, int job)
{
    const int last = (job + 1) * ORDERS - 1;
    return last < t->degree ? last : t->degree;
}

static ibl_legendre_order order(const struct transform *t, int m, int worker)
{
    return (ibl_legendre_order){&t->rings, m, t->degree, t->single,
                                t->scratch + (size_t)worker * scratch_of(t)};
}

/* Sums over all rows with the integrals of (sin theta)^m. */
static void integrate(const struct transform *t, double *state, int m,
                      const float *f, double sum[PARTS])
{
    const row_integrals *r = &t->integrals;
    const double *s = sums_of(r, m, state);
    const size_t stride = row_stride(t);

    memset(sum, 0, PARTS * sizeof *sum);
    t->dsp.add_rows(s, (int)state[0], r->edges - 1, r->rows, f, stride, sum);
    if (r->rows % 2 == 0)
        return;
    /* A row across the equator. */
    for (size_t p = 0; p < PARTS; p++)
        sum[p] += 2 * s[r->rows / 2] * (double)f[p * stride + r->rows / 2];
}

/* Fills order m of the harmonics with A_l times the order's width, from B_l in
 * b[6 (l - m) + part]. */
static void finish_order(const struct transform *t, double *state, int m,
                         const float *f, const double *b)
{
    const double scale = t->width[m];
    double sum[PARTS], last = 0;
    float *a = ibl_harmonics_at(t->harmonics, m);
    two now[PAIRS], older[PAIRS] = {{0}}, before[PAIRS];

    integrate(t, state, m, f, sum);
    for (int p = 0; p < PAIRS; p++) {
        now[p] = two_at(sum + 2 * p) * (t->rings.start[m] * scale);
        before[p] = two_at(b + 2 * p);
        put_two_floats(a + 2 * p, now[p]);
    }
    for (int l = m + 1; l <= t->degree; l++) {
        const double e = ratio(l, m), inverse = 1 / ((l + 1) * e);
        const double keep = (l - 2) * last * inverse, add = scale * inverse;
        a += PARTS;
        b += PARTS;
#pragma GCC unroll 3
        for (int p = 0; p < PAIRS; p++) {
            const two next = keep * older[p] - add * before[p];
            older[p] = now[p];
            now[p] = next;
            before[p] = two_at(b + 2 * p);
            put_two_floats(a + 2 * p, next);
        }
        last = e;
    }
}

/* Copies F_m of all rows, 0 where it does not reach them. */
static void collect_rows(const struct transform *t, int m, float *to)
{
    const size_t stride = row_stride(t);
    for (int g = 0; g < t->rows->groups; g++, to += IBL_ROW_GROUP)
        for (int p = 0; p < PARTS; p++) {
            float *row = to + (size_t)p * stride;
            if (m < ibl_row_spectra_orders(t->rows, g))
                memcpy(row, ibl_row_spectra_at(t->rows, g, m, p),
                       IBL_ROW_GROUP * sizeof *row);
            else
                memset(row, 0, IBL_ROW_GROUP * sizeof *row);
        }
}

static void analyse_job(void *arg, int job, int worker)
{
    const struct transform *t = arg;
    const size_t each = state_size(&t->integrals);
    double *state = t->scratch + (size_t)worker * scratch_of(t) +
                    ibl_legendre_scratch(t->degree);
    double *sums = state + each;
    float *rows = (float *)(sums + PARTS * ((size_t)t->degree + 1));

    memcpy(state, t->integrals.states + (size_t)(job / KEPT) * each,
           each * sizeof *state);
    for (int m = job / KEPT * KEPT * ORDERS; m < job * ORDERS; m++)
        next_order(&t->integrals, m, state);
    for (int m = job * ORDERS; m <= last_order(t, job); m++) {
        const ibl_legendre_order o = order(t, m, worker);
        collect_rows(t, m, rows);
        t->dsp.analyse(&o, rows, row_stride(t), sums);
        finish_order(t, state, m, rows, sums);
        next_order(&t->integrals, m, state);
    }
}

ibl_status ibl_sht_analyse(ibl_ctx *ctx, const char *stage,
                           const ibl_row_spectra *in, const double *width,
                           ibl_harmonics *out)
{
    struct transform t = {.degree = out->degree,
                          .single = out->single,
                          .harmonics = out,
                          .rows = in,
                          .width = width};
    ibl_status status;

    assert(in->degree == out->degree);
    if (!row_integrals_init(&t.integrals, in->rows, out->degree))
        return ibl_no_memory(ctx, "a spherical harmonic transform");
    status = prepare(ctx, &t, IBL_RINGS_EDGES, in->rows - 1, 0, in->rows / 2);
    if (!status)
        status = ibl_run(ctx, stage, t.degree / ORDERS + 1, analyse_job, &t);
    release(&t);
    return status;
}

static void synthesise_job(void *arg, int job, int worker)
{
    const struct transform *t = arg;

    for (int m = job * ORDERS; m <= last_order(t, job); m++) {
        const ibl_legendre_order o = order(t, m, worker);
        t->dsp.synthesise(&o, ibl_harmonics_at(t->harmonics, m), t->factor,
                          ibl_ring_spectra_at(t->spectra, m, 0),
                          t->spectra->stride);
    }
}

/* The degree from which on all factors are small enough for floats. */
static int small_from(const double *factor, int degree)
{
    double most = 0;
    int l = degree + 1;
    for (int i = 0; i <= degree; i++)
        most = fmax(most, fabs(factor[i]));
    while (l > 0 && fabs(factor[l - 1]) < IBL_SHT_SMALL * most)
        l--;
    return l;
}

ibl_status ibl_sht_synthesise(ibl_ctx *ctx, const ibl_harmonics *in,
                              const double *factor, int degree, int rings,
                              int first, ibl_ring_spectra *out)
{
    struct transform t = {.degree = degree,
                          .single = small_from(factor, degree),
                          .harmonics = in,
                          .spectra = out,
                          .factor = factor};

    assert(degree >= 0 && degree <= in->degree && degree < out->orders);
    ibl_status status = prepare(ctx, &t, IBL_RINGS_CENTRES, rings, first,
                                first + (out->rings + 1) / 2);
    if (!status)
        status = ibl_run(ctx, NULL, degree / ORDERS + 1, synthesise_job, &t);
    release(&t);
    return status;
}
