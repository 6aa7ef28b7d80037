/* SPDX-License-Identifier: MIT */
/*
 * The lobe table: fits at some views and roughnesses (bake/lobe_fit.h), each
 * column of one view from the smoothest roughness upwards, and monotone cubics
 * between them. Those of the default chains are in lobe_tables.f16.
 */
#include <math.h>
#include <string.h>

#include "bake/lobe_fit.h"
#include "bake/options.h"
#include "core/alloc.h"
#include "core/context.h"
#include "core/half.h"

enum {
    MIN_SIZE = 4,
    MAX_SIZE = 256,
    VIEWS = 8,
    ROUGHS = 20
};

/* N.V of the columns. Below the first one the table is constant; above the last
 * one, too, where R is N. */
static const double view_at[VIEWS] = {0.03, 0.09, 0.18, 0.3,
                                      0.46, 0.64, 0.82, 0.96};

typedef struct entry {
    double value[4]; /* as in a texel */
} entry;

struct bake {
    ibl_lobe_kernels kernels;
    ibl_true_lobe_rule rule;
    ibl_f0 f0;
    int size, levels, layers;
    entry node[IBL_LOBE_LAYERS][ROUGHS][VIEWS];
    float *out;
};

static double rough_at(int i)
{
    return (i + 1.0) / ROUGHS;
}

/* ---- nodes -------------------------------------------------------------- */

static entry entry_of(const struct bake *b, const ibl_lobe_lookup *l)
{
    const double lod = b->levels > 1 ? l->lod / (b->levels - 1) : 0;
    return (entry){{l->bend, lod, l->weight, l->half}};
}

static void fit_node(struct bake *b, int view, int rough,
                     ibl_lobe_lookup lookup[IBL_LOBE_LAYERS])
{
    ibl_lobe_view v;
    ibl_lobe_view_make(&b->kernels, &b->rule, view_at[view], rough_at(rough),
                       &v);
    for (int layer = 0; layer < b->layers; layer++) {
        const int f =
            b->f0 == IBL_F0_BOTH ? layer % 2 : b->f0 == IBL_F0_DIELECTRICS;
        ibl_lobe_fit(&v, f, 2 * layer / b->layers + 1, &lookup[layer]);
        b->node[layer][rough][view] = entry_of(b, &lookup[layer]);
    }
}

static void column_job(void *arg, int job, int worker)
{
    ibl_lobe_lookup lookup[IBL_LOBE_LAYERS] = {{0}};
    (void)worker;
    for (int i = 0; i < ROUGHS; i++)
        fit_node(arg, job, i, lookup);
}

/* ---- texels ------------------------------------------------------------- */

/* The cubic between y[0] and y[1] with slopes of Fritsch and Butland (1984):
 * no value outside those of the nodes. */
static double slope_of(double h0, double h1, double d0, double d1)
{
    if (d0 * d1 <= 0)
        return 0;
    return 3 * (h0 + h1) / ((2 * h1 + h0) / d0 + (h1 + 2 * h0) / d1);
}

static double cubic(const double *x, const double *y, int count, double at)
{
    int i = 0;
    if (at <= x[0])
        return y[0];
    if (at >= x[count - 1])
        return y[count - 1];
    while (at > x[i + 1])
        i++;
    const double h = x[i + 1] - x[i], d = (y[i + 1] - y[i]) / h;
    double m0 = d, m1 = d;
    if (i > 0)
        m0 = slope_of(x[i] - x[i - 1], h, (y[i] - y[i - 1]) / (x[i] - x[i - 1]),
                      d);
    if (i + 2 < count)
        m1 = slope_of(h, x[i + 2] - x[i + 1], d,
                      (y[i + 2] - y[i + 1]) / (x[i + 2] - x[i + 1]));
    const double t = (at - x[i]) / h;
    return y[i] +
           h * t * (m0 + t * ((3 * d - 2 * m0 - m1) + t * (m0 + m1 - 2 * d)));
}

static void column(const struct bake *b, int layer, int c, int view,
                   double y[ROUGHS + 1])
{
    /* A mirror: R itself, level 0. */
    y[0] = c ? 0 : b->node[layer][0][view].value[c];
    for (int i = 0; i < ROUGHS; i++)
        y[i + 1] = b->node[layer][i][view].value[c];
}

static void row_job(void *arg, int job, int worker)
{
    const struct bake *b = arg;
    const int layer = job / b->size, row = job % b->size;
    double x[ROUGHS + 1], y[ROUGHS + 1], across[VIEWS];
    float *out = b->out + 4 * (size_t)job * (size_t)b->size;
    (void)worker;
    for (int i = 0; i <= ROUGHS; i++)
        x[i] = (double)i / ROUGHS;
    for (int c = 0; c < 4; c++) {
        for (int v = 0; v < VIEWS; v++) {
            column(b, layer, c, v, y);
            across[v] = cubic(x, y, ROUGHS + 1, (row + 0.5) / b->size);
        }
        for (int i = 0; i < b->size; i++)
            out[4 * i + c] = ibl_half_to_float(ibl_half_from_float(
                (float)cubic(view_at, across, VIEWS, (i + 0.5) / b->size)));
    }
}

/* ---- the call ----------------------------------------------------------- */

void ibl_lobe_table_options_init(ibl_lobe_table_options *opts,
                                 size_t struct_size)
{
    ibl_lobe_table_options o = {.size = 16};
    const ibl_specular_options specular = ibl_specular_options_default();
    (void)ibl_specular_layout_of(&specular, &o.layout);
    ibl_give_options(opts, struct_size, &o, sizeof o);
}

void ibl_lobe_table_free(ibl_lobe_table *t)
{
    if (!t)
        return;
    ibl_free(t->data);
    *t = (ibl_lobe_table){0};
}

ibl_status ibl_lobe_table_check(ibl_ctx *ctx, const ibl_lobe_table_options *o)
{
    const ibl_specular_layout *l = &o->layout;

    if (o->size < MIN_SIZE || o->size > MAX_SIZE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a lobe table of size %d: must be %d to %d", o->size,
                        MIN_SIZE, MAX_SIZE);
    if (l->levels < 1 || l->levels > IBL_MAX_LEVELS || l->size < 1)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a chain of %d levels from %d texels: must be 1 to %d, "
                        "from 1 or more",
                        l->levels, l->size, IBL_MAX_LEVELS);
    for (int i = 0; i < l->levels; i++)
        if (!(l->roughness[i] >= (i ? l->roughness[i - 1] : 0) &&
              l->roughness[i] <= 1))
            return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                            "a level of roughness %g: must be 0 to 1, in "
                            "rising order",
                            l->roughness[i]);
    if ((unsigned)o->f0 > IBL_F0_DIELECTRICS)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "no such ibl_f0: %d",
                        (int)o->f0);
    return IBL_OK;
}

ibl_status ibl_lobe_table_take(ibl_ctx *ctx, const ibl_lobe_table_options *opts,
                               ibl_lobe_table_options *own)
{
    *own = ibl_lobe_table_options_default();
    const ibl_status status = ibl_take_options(ctx, opts, own, sizeof *own);
    return status ? status : ibl_lobe_table_check(ctx, own);
}

static ibl_status make(ibl_ctx *ctx, const ibl_lobe_table_options *o,
                       struct bake *b)
{
    ibl_status status = ibl_lobe_kernels_make(ctx, &o->layout, &b->kernels);
    ibl_true_lobe_rule_init(&b->rule);
    if (!status)
        status = ibl_run(ctx, "lobe table", VIEWS, column_job, b);
    if (!status)
        status = ibl_run(ctx, NULL, b->layers * b->size, row_job, b);
    ibl_lobe_kernels_free(&b->kernels);
    return status;
}

static int layers_of(const ibl_lobe_table_options *o)
{
    return IBL_LOBE_LAYERS / (o->f0 == IBL_F0_BOTH ? 1 : 2);
}

ibl_status ibl_lobe_table_fit(ibl_ctx *ctx, const ibl_lobe_table_options *o,
                              float *data)
{
    struct bake *b = ibl_alloc_zeroed(1, sizeof *b);
    if (!b)
        return ibl_no_memory(ctx, "the lobe table");
    b->f0 = o->f0;
    b->size = o->size;
    b->layers = layers_of(o);
    b->levels = o->layout.levels;
    b->out = data;
    const ibl_status status = make(ctx, o, b);
    ibl_free(b);
    return status;
}

/* The halves of lobe_tables.f16 for these options, or NULL. */
static const unsigned char *known(const ibl_lobe_table_options *o)
{
    const ibl_lobe_table_options usual = ibl_lobe_table_options_default();
    ibl_specular_options s = ibl_specular_options_default();
    ibl_specular_layout l;
    s.size = o->layout.size;
    if (o->size != usual.size || o->f0 != usual.f0 ||
        ibl_specular_layout_of(&s, &l) || l.levels != o->layout.levels ||
        memcmp(l.roughness, o->layout.roughness, sizeof l.roughness) != 0)
        return NULL;
    for (int i = 0; i < IBL_LOBE_KNOWN; i++)
        if (l.size == IBL_LOBE_KNOWN_SIZE << i)
            return ibl_lobe_tables + i * IBL_LOBE_KNOWN_BYTES;
    return NULL;
}

ibl_status ibl_bake_lobe_table(ibl_ctx *ctx,
                               const ibl_lobe_table_options *given,
                               ibl_lobe_table *out)
{
    ibl_lobe_table_options own;
    const ibl_lobe_table_options *opts = &own;
    if (!ctx || !out)
        return ibl_missing(ctx, "ibl_bake_lobe_table: out");
    ibl_status status = ibl_lobe_table_take(ctx, given, &own);
    if (status)
        return status;
    const unsigned char *halves = known(opts);
    const size_t count =
        4 * (size_t)layers_of(opts) * (size_t)opts->size * (size_t)opts->size;
    float *data = ibl_alloc_array(count, sizeof *data);
    if (!data)
        return ibl_no_memory(ctx, "the lobe table");
    for (size_t i = 0; i < count && halves; i++)
        data[i] = ibl_half_to_float(
            (uint16_t)(halves[2 * i] | halves[2 * i + 1] << 8));
    if (!halves)
        status = ibl_lobe_table_fit(ctx, opts, data);
    if (status)
        ibl_free(data);
    else
        *out = (ibl_lobe_table){opts->size, data, layers_of(opts)};
    return status;
}
