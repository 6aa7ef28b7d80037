/* SPDX-License-Identifier: MIT */
/*
 * The split-sum table (Karis 2013, "Real Shading in Unreal Engine 4"), by the
 * quadrature of kern/brdf_quadrature.h or by samples, and the albedos of sheen,
 * by that of kern/sheen_quadrature.h. Both are tables of pairs.
 *
 * The table is smooth in ln(N.V) and ln(roughness + constant). It is integrated
 * at Chebyshev points of these and interpolated by polynomials. Errors against
 * an adaptive double integral, all sizes: 2e-5 at most (tests/check_lut.c). A
 * half float near 1 rounds by up to 2.4e-4. The albedos of sheen fall like
 * exp(-(N.V / roughness)^2 / 8) at low roughness, which needs more points the
 * lower that begins.
 */
#include <assert.h>
#include <math.h>
#include <stdbool.h>

#include "brdf/hammersley.h"
#include "core/alloc.h"
#include "core/context.h"
#include "kern/brdf_quadrature.h"
#include "kern/sheen_quadrature.h"

enum {
    MAX_SIZE = 4096,
    MAX_SAMPLES = 1048576,
    MAX_POINTS = 120, /* in a grid */
    ROWS = 16         /* in a job of interpolation */
};

/* Interpolation from Chebyshev points in ln(x + shift). */
typedef struct grid {
    int size, points;
    double shift, from, half;
    double angle_cos[MAX_POINTS], angle_sin[MAX_POINTS];
    double at[MAX_POINTS]; /* x of the points */
} grid;

struct bake {
    bool sheen; /* the pair: the albedos of sheen, else scale and bias */
    ibl_geometry geometry;
    int size, samples;
    ibl_brdf_dsp dsp;
    ibl_brdf_rule rule;
    ibl_sheen_rule sheen_rule;
    grid view, rough;
    float *nodes; /* pairs at the points of rough and view */
    float *basis; /* weight of each point of view in each texel, twice */
    double *turn; /* cos(phi) of each sample */
    float *out;
};

/* ---- interpolation -------------------------------------------------- */

/* Chebyshev points of the first kind over the texel centres of an edge. */
static void grid_init(grid *g, int points, int size, double shift)
{
    assert(points <= MAX_POINTS);
    g->size = size;
    g->points = points;
    g->shift = shift;
    g->from = log(0.5 / size + shift);
    g->half = 0.5 * (log(1.0 - 0.5 / size + shift) - g->from);
    for (int k = 0; k < points; k++) {
        const double angle = IBL_PI * (k + 0.5) / points;
        g->angle_cos[k] = cos(angle);
        g->angle_sin[k] = k % 2 ? -sin(angle) : sin(angle);
        g->at[k] = exp(g->from + g->half * (1.0 + g->angle_cos[k])) - shift;
    }
}

/* The texel centres themselves, for small tables: every texel is integrated. */
static void grid_of_texels(grid *g, int size)
{
    g->points = size;
    for (int k = 0; k < size; k++)
        g->at[k] = (k + 0.5) / size;
}

/* The weight of each point in texel i, barycentric (Berrut and Trefethen
 * 2004, section 5). */
static void grid_weights(const grid *g, int i, double weight[MAX_POINTS])
{
    const double x =
        (log((i + 0.5) / g->size + g->shift) - g->from) / g->half - 1.0;
    double sum = 0.0;

    for (int k = 0; k < g->points; k++) {
        double gap = x - g->angle_cos[k];
        /* At a point: this weight is so large that the others round to 0. */
        if (fabs(gap) < 1e-200)
            gap = 1e-200;
        weight[k] = g->angle_sin[k] / gap;
        sum += weight[k];
    }
    for (int k = 0; k < g->points; k++)
        weight[k] /= sum;
}

static void fill_basis(struct bake *b)
{
    double weight[MAX_POINTS];

    for (int i = 0; i < b->size; i++) {
        grid_weights(&b->view, i, weight);
        for (int k = 0; k < b->view.points; k++) {
            float *to =
                b->basis + 2 * ((size_t)k * (size_t)b->size + (size_t)i);
            to[0] = to[1] = (float)weight[k];
        }
    }
}

static void node_job(void *arg, int job, int worker)
{
    const struct bake *b = arg;
    const double r = b->rough.at[job];
    float *sums = b->nodes + 2 * (size_t)job * (size_t)b->view.points;
    (void)worker;

    if (b->sheen)
        ibl_sheen_sums(&b->sheen_rule, r * r, b->view.at, b->view.points, sums);
    else
        b->dsp.sums(&b->rule, b->geometry, r * r, b->view.at, b->view.points,
                    sums);
}

/* Interpolates the values at the points of view, then all texels of a row. */
static void interpolate_row(const struct bake *b, int row)
{
    const int n = b->view.points, m = b->rough.points;
    float *out = b->out + 2 * (size_t)row * (size_t)b->size;
    double weight[MAX_POINTS];
    float down[2 * MAX_POINTS], across[2 * MAX_POINTS];

    grid_weights(&b->rough, row, weight);
    for (int j = 0; j < m; j++)
        down[2 * j] = down[2 * j + 1] = (float)weight[j];
    b->dsp.mix(b->nodes, 2 * (size_t)n, down, m, 2 * n, across);
    b->dsp.mix(b->basis, 2 * (size_t)b->size, across, n, 2 * b->size, out);
    for (int i = 0; i < 2 * b->size; i++)
        if (out[i] < 0)
            out[i] = 0;
}

static void row_job(void *arg, int job, int worker)
{
    const struct bake *b = arg;
    (void)worker;

    for (int row = ROWS * job; row < ROWS * (job + 1) && row < b->size; row++)
        interpolate_row(b, row);
}

static ibl_status interpolate(ibl_ctx *ctx, struct bake *b)
{
    const size_t nodes = (size_t)b->view.points * (size_t)b->rough.points;
    const size_t basis = (size_t)b->view.points * (size_t)b->size;
    ibl_status status;

    b->nodes = ibl_alloc_array(nodes, 2 * sizeof *b->nodes);
    b->basis = ibl_alloc_array(basis, 2 * sizeof *b->basis);
    if (b->nodes && b->basis) {
        fill_basis(b);
        status = ibl_run(ctx, NULL, b->rough.points, node_job, b);
        if (!status)
            status =
                ibl_run(ctx, "lut", (b->size + ROWS - 1) / ROWS, row_job, b);
    } else {
        status = ibl_no_memory(ctx, "the BRDF table");
    }
    ibl_free(b->nodes);
    ibl_free(b->basis);
    return status;
}

static ibl_status quadrature(ibl_ctx *ctx, struct bake *b)
{
    const double octaves = log2(b->size);
    const int views = b->sheen ? (int)fmax(56.0, ceil(14.0 * octaves) - 48.0)
                               : 8 + 2 * (int)ceil(1.25 * octaves);
    const int roughs = b->sheen ? views : 24 + (int)ceil(2.0 * octaves);

    ibl_brdf_dsp_init(&b->dsp, ibl_ctx_isa(ctx));
    ibl_brdf_rule_init(&b->rule);
    ibl_sheen_rule_init(&b->sheen_rule);
    if (b->size * b->size <= views * roughs) {
        grid_of_texels(&b->view, b->size);
        grid_of_texels(&b->rough, b->size);
        b->nodes = b->out;
        return ibl_run(ctx, "lut", b->size, node_job, b);
    }
    grid_init(&b->view, views, b->size, 0.0);
    /* About half the roughness whose alpha is the smallest N.V. The table is
     * flat below it. */
    grid_init(&b->rough, roughs, b->size, 0.45 * sqrt(0.5 / b->size));
    return interpolate(ctx, b);
}

/* ---- samples -------------------------------------------------------- */

static void sample_job(void *arg, int job, int worker)
{
    const struct bake *b = arg;
    const double n = b->samples, r = (job / b->size + 0.5) / b->size;
    const ibl_split_view v =
        ibl_split_view_of((job % b->size + 0.5) / b->size, r * r, b->geometry);
    double sum[2] = {0.0, 0.0};
    (void)worker;

    for (int k = 0; k < b->samples; k++) {
        double sin_h, cos_h;
        ibl_ggx_sample_half((k + 0.5) / n, v.alpha, &sin_h, &cos_h);
        ibl_split_add(&v, sin_h, cos_h, b->turn[k], 1.0, sum);
    }
    for (int c = 0; c < 2; c++)
        b->out[2 * (ptrdiff_t)job + c] = (float)(sum[c] / n);
}

static ibl_status sample(ibl_ctx *ctx, struct bake *b)
{
    ibl_status status;

    b->turn = ibl_alloc_array((size_t)b->samples, sizeof *b->turn);
    if (!b->turn)
        return ibl_no_memory(ctx, "the BRDF table's samples");
    for (int k = 0; k < b->samples; k++)
        b->turn[k] = cos(2.0 * IBL_PI * ibl_radical_inverse((uint32_t)k));
    status = ibl_run(ctx, "lut", b->size * b->size, sample_job, b);
    ibl_free(b->turn);
    return status;
}

/* ---- the call ------------------------------------------------------- */

const char *ibl_geometry_name(ibl_geometry geometry)
{
    return geometry == IBL_GEOMETRY_SCHLICK_IBL ? "schlick-ibl" : "smith";
}

const char *ibl_lut_name(ibl_lut_kind kind)
{
    static const char *const names[] = {IBL_LUT_NAMES};
    return names[kind];
}

int ibl_lut_channels(ibl_lut_kind kind)
{
    return kind == IBL_LUT_MULTISCATTER ? 3 : 2;
}

ibl_lut_options ibl_lut_options_default(void)
{
    return (ibl_lut_options){.size = 256};
}

void ibl_lut_free(ibl_lut *lut)
{
    if (!lut)
        return;
    ibl_free(lut->data);
    *lut = (ibl_lut){0};
}

static ibl_status check_options(ibl_ctx *ctx, const ibl_lut_options *opts)
{
    if (opts->size < 1 || opts->size > MAX_SIZE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a BRDF table of size %d: must be 1 to %d", opts->size,
                        MAX_SIZE);
    if (opts->samples < 0 || opts->samples > MAX_SAMPLES)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a BRDF table of %d samples: must be 0 to %d",
                        opts->samples, MAX_SAMPLES);
    if (opts->geometry != IBL_GEOMETRY_SMITH &&
        opts->geometry != IBL_GEOMETRY_SCHLICK_IBL)
        return ibl_fail(
            ctx, IBL_ERR_ARGUMENT, "unknown BRDF geometry %d: must be %s or %s",
            (int)opts->geometry, ibl_geometry_name(IBL_GEOMETRY_SMITH),
            ibl_geometry_name(IBL_GEOMETRY_SCHLICK_IBL));
    if (opts->kind > IBL_LUT_CHARLIE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "unknown kind %d of BRDF table: must be 0 to %d",
                        (int)opts->kind, IBL_LUT_CHARLIE);
    if (opts->kind && (opts->samples || opts->geometry))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a %s table has neither samples nor a geometry",
                        ibl_lut_name(opts->kind));
    return IBL_OK;
}

/* Allocates and fills a table of pairs. */
static ibl_status make_pairs(ibl_ctx *ctx, const ibl_lut_options *opts,
                             bool sheen, float **out)
{
    const size_t size = (size_t)opts->size;
    struct bake b = {.sheen = sheen,
                     .geometry = opts->geometry,
                     .size = opts->size,
                     .samples = opts->samples};
    ibl_status status;

    b.out = ibl_alloc_array(size * size, 2 * sizeof *b.out);
    if (!b.out)
        return ibl_no_memory(ctx, "the BRDF table");
    status = b.samples ? sample(ctx, &b) : quadrature(ctx, &b);
    if (status)
        ibl_free(b.out);
    else
        *out = b.out;
    return status;
}

/* Bias, scale + bias, and the first albedo of sheen. */
static ibl_status make_multiscatter(ibl_ctx *ctx, const ibl_lut_options *opts,
                                    float **out)
{
    const size_t texels = (size_t)opts->size * (size_t)opts->size;
    float *split = NULL, *sheen = NULL;
    ibl_status status = make_pairs(ctx, opts, false, &split);

    if (!status)
        status = make_pairs(ctx, opts, true, &sheen);
    if (!status && !(*out = ibl_alloc_array(texels, 3 * sizeof **out)))
        status = ibl_no_memory(ctx, "the BRDF table");
    for (size_t i = 0; !status && i < texels; i++) {
        (*out)[3 * i] = split[2 * i + 1];
        (*out)[3 * i + 1] = split[2 * i] + split[2 * i + 1];
        (*out)[3 * i + 2] = sheen[2 * i];
    }
    ibl_free(split);
    ibl_free(sheen);
    return status;
}

ibl_status ibl_bake_lut(ibl_ctx *ctx, const ibl_lut_options *opts, ibl_lut *out)
{
    const ibl_lut_options usual = ibl_lut_options_default();
    float *data = NULL;

    if (!ctx || !out)
        return ibl_missing(ctx, "ibl_bake_lut: out");
    if (!opts)
        opts = &usual;
    ibl_status status = check_options(ctx, opts);
    if (status)
        return status;
    if (opts->kind == IBL_LUT_MULTISCATTER)
        status = make_multiscatter(ctx, opts, &data);
    else
        status = make_pairs(ctx, opts, opts->kind == IBL_LUT_CHARLIE, &data);
    if (!status)
        *out = (ibl_lut){opts->size, data, opts->kind};
    return status;
}
