/* SPDX-License-Identifier: MIT */
/*
 * The error of what a shader draws, over all rotations of a map, from its
 * spectrum alone: sums over the harmonics of the lobes of the lookup and of the
 * surface (bake/lobe_bands.h).
 */
#include <math.h>
#include <string.h>

#include "bake/lobe_bands.h"
#include "bake/lobe_kernels.h"
#include "bake/options.h"
#include "core/alloc.h"
#include "core/context.h"
#include "kern/brdf_quadrature.h"

enum {
    VIEWS = 5, /* Gauss-Legendre points of N.V */
    MOST_ROUGHNESSES = 64,
    WAYS = IBL_LOOKUP_COUNT,
    APART = IBL_BANDS_DIRECTIONS,
    ANGLES = IBL_BANDS_DIRECTIONS + 2,
    MOST = IBL_BANDS_MOST
};

/* A lookup: the directions from N towards R of its taps, and what it reads. */
typedef struct lookup {
    int taps;
    int at[2]; /* of the directions of the bands */
    double lod, weight;
} lookup;

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

/* ---- lookups --------------------------------------------------------------
 */

enum {
    TO_N, /* directions of the bands */
    TO_R,
    BENT
};

/* A table's bilinear value, clamped to its edges. */
static void fetch(const ibl_lobe_table *t, int layer, double u, double v,
                  double q[4])
{
    const size_t n = (size_t)t->size;
    const double x = fmin(fmax(u * t->size - 0.5, 0), t->size - 1);
    const double y = fmin(fmax(v * t->size - 0.5, 0), t->size - 1);
    const size_t i = (size_t)x, j = (size_t)y;
    const size_t i1 = i + 1 < n ? i + 1 : i, j1 = j + 1 < n ? j + 1 : j;
    const float *rows = t->data + 4 * (size_t)layer * n * n;
    for (size_t c = 0; c < 4; c++) {
        const double top = rows[4 * (j * n + i) + c] * (1 - (x - (double)i)) +
                           rows[4 * (j * n + i1) + c] * (x - (double)i);
        const double low = rows[4 * (j1 * n + i) + c] * (1 - (x - (double)i)) +
                           rows[4 * (j1 * n + i1) + c] * (x - (double)i);
        q[c] = top + (y - (double)j) * (low - top);
    }
}

static int add_direction(ibl_lobe_bands *b, double n_v, double bend)
{
    const double sine = sqrt((1 - n_v) * (1 + n_v));
    b->angle[b->directions] = atan2((1 - bend) * sine, (1 - bend) * n_v + bend);
    return b->directions++;
}

static lookup table_lookup(const struct work *w, int f, int taps, double n_v,
                           double r, ibl_lobe_bands *b)
{
    double q[4];
    fetch(w->table, 2 * (taps - 1) + f, n_v, r, q);
    const ibl_specular_layout *layout = &w->kernels.layout;
    const double most = ibl_lod_of_roughness(layout, fmin(1.25 * r, 1));
    lookup l = {.taps = taps,
                .lod = fmin(q[1] * (layout->levels - 1), most),
                .weight = q[2]};
    for (int i = 0; i < taps; i++)
        l.at[i] =
            add_direction(b, n_v, q[0] + (taps > 1 ? 2 * i - 1 : 0) * q[3]);
    return l;
}

/* ---- sums ------------------------------------------------------------------
 */

/* The lobes of a view and what multiplies them. */
typedef struct view {
    ibl_lobe_bands bands;
    double p[ANGLES][MOST]; /* P_l(cos(angle)): of the directions; of those of
                               two taps from each other, for each F0 */
} view;

static void legendre(const double angle[ANGLES], view *v)
{
    double c[ANGLES], here[ANGLES], before[ANGLES] = {0};
    int l = 0;
    for (int k = 0; k < ANGLES; k++) {
        c[k] = cos(angle[k]);
        here[k] = 1;
    }
    for (int i = 0; i < v->bands.count; i++) {
        for (; l < v->bands.degree[i]; l++) {
            const double inverse = 1.0 / (l + 1);
            const double up = (2 * l + 1) * inverse, down = l * inverse;
            for (int k = 0; k < ANGLES; k++) {
                const double next = up * c[k] * here[k] - down * before[k];
                before[k] = here[k];
                here[k] = next;
            }
        }
        for (int k = 0; k < ANGLES; k++)
            v->p[k][i] = here[k];
    }
}

/* <S - T, S - T> of a lookup. */
static double error_of(const struct work *w, const view *v, int f,
                       const lookup *s)
{
    const ibl_lobe_kernels *k = &w->kernels;
    const ibl_lobe_bands *b = &v->bands;
    const int a = (int)fmin(s->lod, k->layout.levels - 2);
    const int first = s->at[0], last = s->at[s->taps - 1];
    const double t = s->lod - a, own = 1 - s->weight;
    const double *low = ibl_lobe_of(k, a), *high = ibl_lobe_of(k, a + 1);
    const double *cosine = ibl_lobe_of(k, k->layout.levels);
    double sum = 0;
    for (int i = b->count - 1; i >= 0; i--) {
        const int l = b->degree[i];
        const double lobe = own * ((1 - t) * low[l] + t * high[l]);
        const double even = s->weight * cosine[l];
        const double apart = s->taps > 1 ? v->p[APART + f][i] : 1;
        const double towards = 0.5 * (v->p[first][i] + v->p[last][i]);
        const double seen =
            0.5 * (b->toward[f][first][i] + b->toward[f][last][i]);
        const double ss = lobe * lobe * 0.5 * (1 + apart) +
                          2 * lobe * even * towards + even * even;
        const double st = lobe * seen + even * b->toward[f][TO_N][i];
        const double n = (2 * l + 1) / (4 * IBL_PI);
        sum += b->share[i] * (ss + (b->power[f][i] - 2 * st) / n);
    }
    return fmax(sum, 0);
}

static void add_sums(const struct work *w, const view *v,
                     lookup lookups[2][WAYS], double weight, sums *to)
{
    const ibl_lobe_bands *b = &v->bands;
    for (int f = 0; f < 2; f++) {
        const double share = weight * b->energy[f] * b->energy[f];
        double power = w->kernels.mean;
        for (int i = b->count - 1; i >= 0; i--)
            power += b->share[i] * b->power[f][i] * 4 * IBL_PI /
                     (2 * b->degree[i] + 1);
        to->power[f] = share * power;
        for (int way = 0; way < (w->table ? WAYS : 1); way++)
            to->error[f][way] = share * error_of(w, v, f, &lookups[f][way]);
    }
}

static void view_sums(const struct work *w, double r, int job_view, sums *to)
{
    const double n_v = w->view[job_view];
    view v = {.bands = {.count = 0}};
    ibl_lobe_bands *b = &v.bands;
    lookup lookups[2][WAYS] = {{{0}}};
    double angle[ANGLES] = {0};
    ibl_bands_degrees(w->kernels.power, r, b);
    add_direction(b, n_v, 1); /* TO_N */
    add_direction(b, n_v, 0); /* TO_R */
    for (int f = 0; f < 2; f++) {
        lookups[f][IBL_LOOKUP_SPLIT] = (lookup){
            1, {TO_R, TO_R}, ibl_lod_of_roughness(&w->kernels.layout, r), 0};
        for (int taps = 1; taps <= 2 && w->table; taps++)
            lookups[f][taps == 1 ? IBL_LOOKUP_TABLE : IBL_LOOKUP_TWO_TAPS] =
                table_lookup(w, f, taps, n_v, r, b);
        const lookup *two = &lookups[f][IBL_LOOKUP_TWO_TAPS];
        angle[APART + f] = b->angle[two->at[0]] - b->angle[two->at[1]];
    }
    memcpy(angle, b->angle, sizeof b->angle);
    legendre(angle, &v);
    ibl_lobe_bands_make(&w->rule, n_v, r * r, b);
    add_sums(w, &v, lookups, w->weight[job_view] * 2 * n_v, to);
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
