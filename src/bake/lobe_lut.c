/* SPDX-License-Identifier: MIT */
/*
 * The lobe table: each texel is a fit (bake/lobe_fit.h). Texels at the edges
 * are of 0 and 1. The tables of the default chains are in lobe_tables.f16.
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
    MAX_SIZE = 256
};

/* The N.V that are fitted: at 0 a surface is not seen, at 1 R is N. */
static const double least_n_v = 0.02, most_n_v = 0.995;

struct bake {
    ibl_lobe_kernels kernels;
    ibl_true_lobe_rule rule;
    ibl_f0 f0;
    int size, levels, layers;
    float *out;
};

static void put(const struct bake *b, int layer, int row, int column,
                const ibl_lobe_lookup *l)
{
    const double lod = b->levels > 1 ? l->lod / (b->levels - 1) : 0;
    const double q[4] = {l->bend, lod, l->weight, l->half};
    float *out =
        b->out + 4 * ((size_t)(layer * b->size + row) * (size_t)b->size +
                      (size_t)column);
    for (int c = 0; c < 4; c++)
        out[c] = ibl_half_to_float(ibl_half_from_float((float)q[c]));
}

static void row_job(void *arg, int row, int worker)
{
    const struct bake *b = arg;
    const double last = b->size - 1;
    (void)worker;
    for (int i = 0; i < b->size; i++) {
        ibl_lobe_view v;
        if (row)
            ibl_lobe_view_make(&b->kernels, &b->rule,
                               fmin(fmax(i / last, least_n_v), most_n_v),
                               row / last, &v);
        for (int f = 0; f < b->layers / 2; f++) {
            /* A mirror: R, level 0. */
            ibl_lobe_lookup best[2] = {{0}};
            if (row)
                ibl_lobe_fit(&v, b->f0 == IBL_F0_DIELECTRICS ? 1 : f, best);
            for (int k = 0; k < 2; k++)
                put(b, k * b->layers / 2 + f, row, i, &best[k]);
        }
    }
}

/* ---- the call ----------------------------------------------------------- */

ibl_lobe_table_options ibl_lobe_table_options_default(void)
{
    const ibl_specular_options specular = ibl_specular_options_default();
    ibl_lobe_table_options o = {.size = 16};

    (void)ibl_specular_layout_of(&specular, &o.layout);
    return o;
}

void ibl_lobe_table_free(ibl_lobe_table *t)
{
    if (!t)
        return;
    ibl_free(t->data);
    *t = (ibl_lobe_table){0};
}

static ibl_status check(ibl_ctx *ctx, const ibl_lobe_table_options *o)
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

static ibl_status make(ibl_ctx *ctx, const ibl_lobe_table_options *o,
                       struct bake *b)
{
    ibl_status status = ibl_lobe_kernels_make(ctx, &o->layout, &b->kernels);
    ibl_true_lobe_rule_init(&b->rule);
    if (!status)
        status = ibl_run(ctx, "lobe table", b->size, row_job, b);
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

ibl_status ibl_bake_lobe_table(ibl_ctx *ctx, const ibl_lobe_table_options *opts,
                               ibl_lobe_table *out)
{
    const ibl_lobe_table_options usual = ibl_lobe_table_options_default();

    if (!ctx || !out)
        return ibl_missing(ctx, "ibl_bake_lobe_table: out");
    if (!opts)
        opts = &usual;
    ibl_status status = check(ctx, opts);
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
