/* SPDX-License-Identifier: MIT */
/*
 * The error of what a shader draws, over all rotations of a map, from its
 * spectrum alone: sums over the harmonics of the lobes of the lookup and of the
 * surface (bake/lobe_bands.h).
 */
#include <math.h>

#include "bake/lobe_bands.h"
#include "bake/lobe_kernels.h"
#include "bake/options.h"
#include "core/alloc.h"
#include "core/context.h"
#include "kern/brdf_quadrature.h"

enum {
    VIEWS = 6, /* Gauss-Legendre points of N.V */
    MOST = 64, /* roughnesses */
    WAYS = IBL_LOOKUP_COUNT,
    DEGREE = IBL_LOBE_DEGREE
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
    sums *sum; /* of each roughness and view */
    ibl_status *status;
};

/* ---- lookups --------------------------------------------------------------
 */

enum {
    TO_N, /* directions of the bands */
    TO_R,
    BENT
};

static double lod_of(const ibl_specular_layout *l, double r)
{
    const double x = ibl_roughness_x(l->mapping, r);
    return fmin(fmax(x * l->lod_scale + l->lod_offset, 0), l->levels - 1);
}

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
    lookup l = {.taps = taps,
                .lod = q[1] * (w->kernels.layout.levels - 1),
                .weight = q[2]};
    for (int i = 0; i < taps; i++)
        l.at[i] =
            add_direction(b, n_v, q[0] + (taps > 1 ? 2 * i - 1 : 0) * q[3]);
    return l;
}

/* ---- sums ------------------------------------------------------------------
 */

/* Fills P_l(cos(angle)). */
static void legendre(double angle, double p[DEGREE + 1])
{
    const double c = cos(angle);
    p[0] = 1;
    p[1] = c;
    for (int l = 1; l < DEGREE; l++)
        p[l + 1] = ((2 * l + 1) * c * p[l] - l * p[l - 1]) / (l + 1);
}

/* <S - T, S - T> of a lookup. */
static double error_of(const struct work *w, const ibl_lobe_bands *b, int f,
                       const lookup *s)
{
    const ibl_lobe_kernels *k = &w->kernels;
    const int a = (int)fmin(s->lod, k->layout.levels - 2);
    const double t = s->lod - a, own = 1 - s->weight;
    const double *low = ibl_lobe_of(k, a), *high = ibl_lobe_of(k, a + 1);
    const double *cosine = ibl_lobe_of(k, k->layout.levels);
    double p[2][DEGREE + 1], apart[DEGREE + 1];
    double sum = 0;
    for (int i = 0; i < s->taps; i++)
        legendre(b->angle[s->at[i]], p[i]);
    legendre(b->angle[s->at[0]] - b->angle[s->at[s->taps - 1]], apart);
    for (int l = b->degree; l > 0; l--) {
        const double lobe = own * ((1 - t) * low[l] + t * high[l]);
        const double even = s->weight * cosine[l];
        const double n = (2 * l + 1) / (4 * IBL_PI);
        const int last = s->taps - 1;
        const double towards = 0.5 * (p[0][l] + p[last][l]);
        const double seen =
            0.5 * (b->toward[f][s->at[0]][l] + b->toward[f][s->at[last]][l]);
        const double ss = n * (lobe * lobe * 0.5 * (1 + apart[l]) +
                               2 * lobe * even * towards + even * even);
        const double st = lobe * seen + even * b->toward[f][TO_N][l];
        sum += k->power[l] * (ss - 2 * st + b->power[f][l]);
    }
    return fmax(sum, 0);
}

static void add_sums(const struct work *w, const ibl_lobe_bands *b,
                     lookup lookups[2][WAYS], double weight, sums *to)
{
    for (int f = 0; f < 2; f++) {
        const double share = weight * b->energy[f] * b->energy[f];
        double power = w->kernels.mean;
        for (int l = b->degree; l > 0; l--)
            power += w->kernels.power[l] * b->power[f][l];
        to->power[f] = share * power;
        for (int way = 0; way < (w->table ? WAYS : 1); way++)
            to->error[f][way] = share * error_of(w, b, f, &lookups[f][way]);
    }
}

/* The degree beyond which a lobe has nothing to see. */
static int degree_of(double r)
{
    return (int)fmin(DEGREE, 6 / (r * r) + 24);
}

static ibl_status view_sums(const struct work *w, double r, int view, sums *to)
{
    const double n_v = w->view[view];
    const int degree = degree_of(r);
    ibl_lobe_bands b = {.degree = degree};
    lookup lookups[2][WAYS] = {{{0}}};
    const size_t size = (size_t)degree + 1;
    double *memory =
        ibl_alloc_array(2 * (IBL_BANDS_DIRECTIONS + 1) * size, sizeof *memory);
    if (!memory)
        return IBL_ERR_MEMORY;
    for (int f = 0, i = 0; f < 2; f++) {
        b.power[f] = memory + size * (size_t)i++;
        for (int d = 0; d < IBL_BANDS_DIRECTIONS; d++)
            b.toward[f][d] = memory + size * (size_t)i++;
    }
    add_direction(&b, n_v, 1); /* TO_N */
    add_direction(&b, n_v, 0); /* TO_R */
    for (int f = 0; f < 2; f++) {
        lookups[f][IBL_LOOKUP_SPLIT] =
            (lookup){1, {TO_R, TO_R}, lod_of(&w->kernels.layout, r), 0};
        for (int taps = 1; taps <= 2 && w->table; taps++)
            lookups[f][taps == 1 ? IBL_LOOKUP_TABLE : IBL_LOOKUP_TWO_TAPS] =
                table_lookup(w, f, taps, n_v, r, &b);
    }
    const ibl_status status = ibl_lobe_bands_make(n_v, r * r, &b);
    if (!status)
        add_sums(w, &b, lookups, w->weight[view] * 2 * n_v, to);
    ibl_free(memory);
    return status;
}

static void view_job(void *arg, int job, int worker)
{
    const struct work *w = arg;
    (void)worker;
    w->status[job] =
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
    if (count < 1 || count > MOST)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "the error at %d roughnesses: must be 1 to %d", count,
                        MOST);
    for (int i = 0; i < count; i++)
        if (!(roughness[i] >= IBL_EXPECTED_LEAST && roughness[i] <= 1))
            return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                            "the error at roughness %g: must be %g to 1",
                            roughness[i], IBL_EXPECTED_LEAST);
    return IBL_OK;
}

static ibl_status sum_all(ibl_ctx *ctx, struct work *w, int count)
{
    const int jobs = count * VIEWS;
    w->sum = ibl_alloc_zeroed((size_t)jobs, sizeof *w->sum);
    w->status = ibl_alloc_zeroed((size_t)jobs, sizeof *w->status);
    if (!w->sum || !w->status)
        return ibl_no_memory(ctx, "the expected error");
    const ibl_status status = ibl_run(ctx, "expected error", jobs, view_job, w);
    for (int i = 0; i < jobs && !status; i++)
        if (w->status[i])
            return ibl_no_memory(ctx, "the expected error");
    return status;
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
    ibl_gauss_points(VIEWS, w.view, w.weight);
    status = sum_all(ctx, &w, count);
    for (int i = 0; i < count && !status; i++)
        divide(&w, i, &errors[i]);
    ibl_free(w.sum);
    ibl_free(w.status);
    ibl_lobe_kernels_free(&w.kernels);
    return status;
}
