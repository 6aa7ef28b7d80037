/* SPDX-License-Identifier: MIT */
/*
 * The error of what a shader draws, over all rotations of a map, from its
 * spectrum alone: that of bake/lookup_error.h as a mean over views.
 */
#include <math.h>
#include <string.h>

#include "bake/lookup_error.h"
#include "bake/options.h"
#include "core/alloc.h"
#include "core/context.h"
#include "kern/brdf_quadrature.h"

enum {
    VIEWS = 5, /* Gauss-Legendre points of N.V */
    MOST_ROUGHNESSES = 64,
    WAYS = IBL_LOOKUP_COUNT
};

/* Sums of a view, weighted: of the error, and of the lobe's power. */
typedef struct sums {
    double error[2][WAYS], power[2];
} sums;

struct work {
    ibl_lobe_kernels kernels;
    const ibl_lobe_table *table; /* or NULL */
    double view[VIEWS], weight[VIEWS];
    const double *roughness;
    ibl_bands_rule rule;
    sums *sum; /* of each roughness and view */
};

static void add_sums(const struct work *w, const ibl_lookup_view *v,
                     ibl_lookup_use uses[2][WAYS], double weight, sums *to)
{
    const ibl_lobe_bands *b = &v->bands;
    for (int f = 0; f < 2; f++) {
        const double share = weight * b->energy[f] * b->energy[f];
        to->power[f] = share * ibl_lookup_power(&w->kernels, v, f, 0);
        for (int way = 0; way < (w->table ? WAYS : 1); way++)
            to->error[f][way] = share * ibl_lookup_error(&w->kernels, v, f,
                                                         &uses[f][way], NULL);
    }
}

static void view_sums(const struct work *w, double r, int job_view, sums *to)
{
    const double n_v = w->view[job_view];
    ibl_lookup_view v = {.bands = {.count = 0}};
    ibl_lobe_bands *b = &v.bands;
    ibl_lookup_use uses[2][WAYS] = {{{0}}};
    double angle[IBL_LOOKUP_ANGLES] = {0};
    ibl_bands_degrees(w->kernels.power, r, b);
    ibl_lookup_direction(b, n_v, 1); /* IBL_TO_N */
    ibl_lookup_direction(b, n_v, 0); /* IBL_TO_R */
    for (int f = 0; f < 2; f++) {
        uses[f][IBL_LOOKUP_SPLIT] =
            (ibl_lookup_use){1,
                             {IBL_TO_R, IBL_TO_R},
                             ibl_lod_of_roughness(&w->kernels.layout, r),
                             0};
        for (int taps = 1; taps <= 2 && w->table; taps++)
            uses[f][taps == 1 ? IBL_LOOKUP_TABLE : IBL_LOOKUP_TWO_TAPS] =
                ibl_lookup_by_table(w->table, &w->kernels, f, taps, n_v, r, b);
        const ibl_lookup_use *two = &uses[f][IBL_LOOKUP_TWO_TAPS];
        angle[IBL_LOOKUP_APART + f] =
            b->angle[two->at[0]] - b->angle[two->at[1]];
    }
    memcpy(angle, b->angle, sizeof b->angle);
    ibl_lookup_legendre(angle, IBL_LOOKUP_ANGLES, b, v.p);
    ibl_lobe_bands_make(&w->rule, n_v, r * r, b);
    add_sums(w, &v, uses, w->weight[job_view] * 2 * n_v, to);
}

static void view_job(void *arg, int job, int worker)
{
    const struct work *w = arg;
    (void)worker;
    view_sums(w, w->roughness[job / VIEWS], job % VIEWS, &w->sum[job]);
}

/* ---- the call --------------------------------------------------------------
 */

static void divide(const struct work *w, int i, ibl_expected_error *out)
{
    for (int f = 0; f < 2; f++) {
        double power = 0, error[WAYS] = {0};
        for (int v = 0; v < VIEWS; v++) {
            const sums *s = &w->sum[i * VIEWS + v];
            power += s->power[f];
            for (int way = 0; way < WAYS; way++)
                error[way] += s->error[f][way];
        }
        for (int way = 0; way < WAYS; way++)
            out->nrmse[f][way] = way && !w->table ? -1
                                 : power > 0      ? sqrt(error[way] / power)
                                                  : 0;
    }
}

static ibl_status check(ibl_ctx *ctx, const double *roughness, int count)
{
    if (count < 1 || count > MOST_ROUGHNESSES)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "the error at %d roughnesses: must be 1 to %d", count,
                        MOST_ROUGHNESSES);
    for (int i = 0; i < count; i++)
        if (!(roughness[i] >= IBL_EXPECTED_LEAST && roughness[i] <= 1))
            return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                            "the error at roughness %g: must be %g to 1",
                            roughness[i], IBL_EXPECTED_LEAST);
    return IBL_OK;
}

static ibl_status sum_all(ibl_ctx *ctx, struct work *w, int count)
{
    w->sum = ibl_alloc_zeroed((size_t)count * VIEWS, sizeof *w->sum);
    if (!w->sum)
        return ibl_no_memory(ctx, "the expected error");
    ibl_gauss_points(VIEWS, w->view, w->weight);
    ibl_bands_rule_init(&w->rule);
    return ibl_run(ctx, "expected error", count * VIEWS, view_job, w);
}

ibl_status ibl_bake_expected_error(ibl_ctx *ctx,
                                   const ibl_lobe_table_options *opts,
                                   const ibl_lobe_table *table,
                                   const double *roughness, int count,
                                   ibl_expected_error *errors)
{
    const ibl_lobe_table_options defaults = ibl_lobe_table_options_default();
    struct work w = {.table = table, .roughness = roughness};
    if (!ctx || !roughness || !errors || (table && !table->data))
        return ibl_missing(ctx, "ibl_bake_expected_error: table's data, "
                                "roughness or errors");
    if (!opts)
        opts = &defaults;
    ibl_status status = check(ctx, roughness, count);
    if (!status)
        status = ibl_lobe_table_check(ctx, opts);
    if (!status)
        status = ibl_lobe_kernels_make(ctx, &opts->layout, opts->power,
                                       opts->power_degree, &w.kernels);
    if (status)
        return status;
    status = sum_all(ctx, &w, count);
    for (int i = 0; i < count && !status; i++)
        divide(&w, i, &errors[i]);
    ibl_free(w.sum);
    ibl_lobe_kernels_free(&w.kernels);
    return status;
}
