/* SPDX-License-Identifier: MIT */
/* Orders are independent of each other: a job does some that follow each
 * other, and what an order becomes does not depend on its job. */
#include "bake/spectral/transform.h"

#include <string.h>

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

static ibl_status prepare(ibl_ctx *ctx, struct transform *t, int rings,
                          const double *weight)
{
    const size_t workers = (size_t)ibl_ctx_threads(ctx);

    ibl_legendre_dsp_init(&t->dsp, ibl_ctx_isa(ctx));
    t->first = ibl_alloc_array((size_t)t->orders + 1, sizeof *t->first);
    t->scratch = ibl_alloc_array(workers, ibl_legendre_scratch(t->degree) *
                                              sizeof *t->scratch);
    if (!t->first || !t->scratch ||
        !ibl_legendre_rings_init(&t->rings, rings, t->degree, weight))
        return ibl_no_memory(ctx, "a spherical harmonic transform");
    plan_jobs(t);
    return IBL_OK;
}

static void release(struct transform *t)
{
    ibl_legendre_rings_free(&t->rings);
    ibl_free(t->scratch);
    ibl_free(t->first);
}

static ibl_legendre_order order(const struct transform *t, int m, int worker)
{
    return (ibl_legendre_order){
        &t->rings, m, t->degree,
        t->scratch + (size_t)worker * ibl_legendre_scratch(t->degree)};
}

static void analyse_job(void *arg, int job, int worker)
{
    const struct transform *t = arg;

    for (int m = t->first[job]; m < t->first[job + 1]; m++) {
        const ibl_legendre_order o = order(t, m, worker);
        t->dsp.analyse(&o, ibl_ring_spectra_at(t->spectra, m, 0),
                       t->spectra->stride, ibl_harmonics_at(t->harmonics, m));
    }
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
    ibl_status status = prepare(ctx, &t, in->rings, weight);

    if (!status)
        status = ibl_run(ctx, stage, t.jobs, analyse_job, &t);
    for (int m = t.orders; m < all; m++)
        memset(ibl_harmonics_at(out, m), 0,
               (size_t)(all - m) * 6 * sizeof *out->data);
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
    ibl_status status = prepare(ctx, &t, out->rings, NULL);
    if (!status)
        status = ibl_run(ctx, stage, t.jobs, synthesise_job, &t);
    if (degree + 1 < out->orders)
        memset(ibl_ring_spectra_at(out, degree + 1, 0), 0,
               (size_t)(out->orders - degree - 1) * 6 * out->stride *
                   sizeof *out->data);
    release(&t);
    return status;
}
