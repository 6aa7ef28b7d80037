/* SPDX-License-Identifier: MIT */
/* Orders are independent of each other: a job does some that follow each
 * other, and what an order becomes does not depend on its job. */
#include "bake/spectral/transform.h"

#include <string.h>

#include "bake/spectral/row_integrals.h"
#include "core/alloc.h"
#include "core/context.h"
#include "kern/legendre.h"

/* Products of P_lm and a pair of rings in a job: well below a millisecond. */
static const double job_work = 2e5;

struct transform {
    ibl_legendre_dsp dsp;
    ibl_legendre_rings rings;
    int degree, orders; /* orders 0..orders - 1 are summed */
    int *first;         /* orders of job i: first[i]..first[i + 1] - 1 */
    int jobs;
    double *scratch; /* of each worker */
    const ibl_harmonics *harmonics;
    const ibl_ring_spectra *spectra;
    const double *factor;
    const double *width; /* of each order, where rows are patches */
    ibl_row_integrals integrals;
};

/* The work of an order: its Legendre functions, and something for a start. */
static double work_of(const struct transform *t, int m)
{
    return (t->degree - m + 16.0) * t->rings.pairs;
}

static void plan_jobs(struct transform *t)
{
    double work = 0.0;

    for (int m = 0; m < t->orders; m++) {
        if (!m || work >= job_work) {
            t->first[t->jobs++] = m;
            work = 0.0;
        }
        work += work_of(t, m);
    }
    t->first[t->jobs] = t->orders;
}

/* Doubles of scratch for a worker. */
static size_t scratch_of(const struct transform *t)
{
    return ibl_legendre_scratch(t->degree) +
           (t->width ? ibl_row_integrals_state(&t->integrals) : 0);
}

static ibl_status prepare(ibl_ctx *ctx, struct transform *t, ibl_ring_kind kind,
                          int rings, const double *weight)
{
    const size_t workers = (size_t)ibl_ctx_threads(ctx);

    ibl_legendre_dsp_init(&t->dsp, ibl_ctx_isa(ctx));
    t->first = ibl_alloc_array((size_t)t->orders + 1, sizeof *t->first);
    t->scratch = ibl_alloc_array(workers, scratch_of(t) * sizeof *t->scratch);
    if (!t->first || !t->scratch ||
        !ibl_legendre_rings_init(&t->rings, kind, rings, t->degree, weight))
        return ibl_no_memory(ctx, "a spherical harmonic transform");
    plan_jobs(t);
    return IBL_OK;
}

static void release(struct transform *t)
{
    ibl_row_integrals_free(&t->integrals);
    ibl_legendre_rings_free(&t->rings);
    ibl_free(t->scratch);
    ibl_free(t->first);
}

static ibl_legendre_order order(const struct transform *t, int m, int worker)
{
    return (ibl_legendre_order){&t->rings, m, t->degree,
                                t->scratch + (size_t)worker * scratch_of(t)};
}

static void analyse_order(const struct transform *t, int m, int worker)
{
    const ibl_legendre_order o = order(t, m, worker);
    t->dsp.analyse(&o, ibl_ring_spectra_at(t->spectra, m, 0),
                   t->spectra->stride, ibl_harmonics_at(t->harmonics, m));
}

static void analyse_job(void *arg, int job, int worker)
{
    const struct transform *t = arg;
    for (int m = t->first[job]; m < t->first[job + 1]; m++)
        analyse_order(t, m, worker);
}

static void patches_job(void *arg, int job, int worker)
{
    const struct transform *t = arg;
    double *state = t->scratch + (size_t)worker * scratch_of(t) +
                    ibl_legendre_scratch(t->degree);

    ibl_row_integrals_seek(&t->integrals, t->first[job], state);
    for (int m = t->first[job]; m < t->first[job + 1]; m++) {
        analyse_order(t, m, worker);
        ibl_row_integrals_finish(
            &t->integrals, state, m, t->degree,
            ibl_ring_spectra_at(t->spectra, m, 0), t->spectra->stride,
            t->rings.start[m], t->width[m], ibl_harmonics_at(t->harmonics, m));
        ibl_row_integrals_next(&t->integrals, m, state);
    }
}

/* The orders that are not summed. */
static void clear_rest(const struct transform *t)
{
    for (int m = t->orders; m <= t->degree; m++)
        memset(ibl_harmonics_at(t->harmonics, m), 0,
               (size_t)(t->degree + 1 - m) * 6 * sizeof *t->harmonics->data);
}

ibl_status ibl_sht_analyse(ibl_ctx *ctx, const char *stage,
                           const ibl_ring_spectra *in, const double *weight,
                           ibl_harmonics *out)
{
    const int all = out->degree + 1;
    struct transform t = {.degree = out->degree,
                          .orders = in->orders < all ? in->orders : all,
                          .harmonics = out,
                          .spectra = in};
    ibl_status status = prepare(ctx, &t, IBL_RINGS_CENTRES, in->rings, weight);

    if (!status)
        status = ibl_run(ctx, stage, t.jobs, analyse_job, &t);
    clear_rest(&t);
    release(&t);
    return status;
}

ibl_status ibl_sht_analyse_patches(ibl_ctx *ctx, const char *stage,
                                   const ibl_ring_spectra *in,
                                   const double *width, ibl_harmonics *out)
{
    const int all = out->degree + 1;
    struct transform t = {.degree = out->degree,
                          .orders = in->orders < all ? in->orders : all,
                          .harmonics = out,
                          .spectra = in,
                          .width = width};
    ibl_status status = IBL_OK;

    if (!ibl_row_integrals_init(&t.integrals, in->rings, out->degree))
        return ibl_no_memory(ctx, "a spherical harmonic transform");
    status = prepare(ctx, &t, IBL_RINGS_EDGES, in->rings - 1, NULL);
    for (int j = 0; !status && j < t.rings.pairs; j++) {
        const double square = t.rings.sine[j] * t.rings.sine[j];
        t.rings.north[j] *= square;
        t.rings.south[j] *= square;
    }
    if (!status)
        status = ibl_run(ctx, stage, t.jobs, patches_job, &t);
    clear_rest(&t);
    release(&t);
    return status;
}

static void synthesise_job(void *arg, int job, int worker)
{
    const struct transform *t = arg;

    for (int m = t->first[job]; m < t->first[job + 1]; m++) {
        const ibl_legendre_order o = order(t, m, worker);
        t->dsp.synthesise(&o, ibl_harmonics_at(t->harmonics, m), t->factor,
                          ibl_ring_spectra_at(t->spectra, m, 0),
                          t->spectra->stride);
    }
}

ibl_status ibl_sht_synthesise(ibl_ctx *ctx, const char *stage,
                              const ibl_harmonics *in, const double *factor,
                              int degree, ibl_ring_spectra *out)
{
    struct transform t = {.degree = degree,
                          .orders = degree + 1,
                          .harmonics = in,
                          .spectra = out,
                          .factor = factor};

    if (degree < 0 || degree > in->degree || degree >= out->orders)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a synthesis of degree %d from harmonics of degree %d "
                        "on rings of %d orders: must be in both",
                        degree, in->degree, out->orders);
    ibl_status status = prepare(ctx, &t, IBL_RINGS_CENTRES, out->rings, NULL);
    if (!status)
        status = ibl_run(ctx, stage, t.jobs, synthesise_job, &t);
    if (degree + 1 < out->orders)
        memset(ibl_ring_spectra_at(out, degree + 1, 0), 0,
               (size_t)(out->orders - degree - 1) * 6 * out->stride *
                   sizeof *out->data);
    release(&t);
    return status;
}
