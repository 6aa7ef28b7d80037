/* SPDX-License-Identifier: MIT */
#include "bake/spectral/plan.h"

#include <math.h>

#include "bake/options.h"
#include "bake/spectral/lobe_coefficients.h"
#include "bake/spectral/resample.h"
#include "bake/spectral/transform.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"

static const int min_degree = 32;
static const int least_degree = 128; /* of an analysis for levels */

/* Highest degree of a level: a power of two less 1, for the columns of its
 * grid. GGX needs it from roughness 0.032 down. The corner of a wide lobe on
 * the horizon, a ring around the sphere, averages what lower degrees omit, so
 * it does not count. */
static const double most_degree = 4095, most_of_corner = 768;
static const double corner_from = 20; /* / alpha */

/* If the tolerance grows by a factor, this share grows by its square root: dark
 * texels must keep the tolerance, too. */
static double tail_of(double tolerance)
{
    const double factor = tolerance / IBL_TOLERANCE_DEFAULT;
    const double tail = ibl_error_parts.tail * IBL_TOLERANCE_DEFAULT;
    return fmin(tail * (factor > 1 ? sqrt(factor) : factor), 1);
}

/* Share of a point light from which floats do. */
static const double single_tail = 0.2;

/* Adds the degree that a lobe needs, at *degree. */
static ibl_status add_lobe(ibl_ctx *ctx, const ibl_lobe_shape *shape,
                           double tolerance, ibl_spectral_plan *plan,
                           int *degree)
{
    const double narrow = fmin(corner_from / shape->alpha, most_degree);
    const double ring =
        tolerance < IBL_TOLERANCE_DEFAULT ? 2 * most_of_corner : most_of_corner;
    const double most =
        shape->kind == IBL_LOBE_RING ? ring : fmax(narrow, most_of_corner);
    int single = 0;
    ibl_status status =
        ibl_lobe_degree(ctx, shape, tail_of(tolerance), (int)most, degree);

    if (*degree < min_degree)
        *degree = min_degree;
    if (!status && *degree > min_degree && *degree > plan->single)
        status = ibl_lobe_degree(ctx, shape, single_tail, *degree, &single);
    plan->degree = *degree > plan->degree ? *degree : plan->degree;
    plan->single = single > plan->single ? single : plan->single;
    return status;
}

ibl_status ibl_spectral_plan_make(ibl_ctx *ctx, const ibl_bake_options *opts,
                                  ibl_spectral_plan *plan)
{
    const ibl_lobe_shape cosine = ibl_lobe_shape_of(IBL_LOBE_GGX, 1);
    ibl_status status = IBL_OK;

    *plan =
        (ibl_spectral_plan){.degree = -1, .irradiance = IBL_METHOD_SPECTRAL};
    if (opts->irradiance && opts->irradiance_options.step > 0) {
        plan->irradiance = IBL_METHOD_SAMPLED;
        plan->whole = true;
    } else if (opts->irradiance) {
        status = add_lobe(ctx, &cosine, opts->specular_options.tolerance, plan,
                          &plan->irradiance_degree);
    }
    if (opts->sh_degree > plan->degree)
        plan->degree = opts->sh_degree;
    plan->single = opts->sh_degree + 1;
    if (opts->specular && plan->degree < least_degree)
        plan->degree = least_degree;
    return status;
}

ibl_status ibl_spectral_plan_chain(ibl_ctx *ctx,
                                   const ibl_specular_options *opts,
                                   const ibl_specular_layout *layout,
                                   int degree[IBL_MAX_LEVELS],
                                   ibl_spectral_plan *plan)
{
    ibl_status status = IBL_OK;

    for (int l = 0; l < layout->levels && !status; l++) {
        const double r = layout->roughness[l];
        const ibl_lobe_shape shape = ibl_lobe_shape_of(opts->lobe, r * r);
        if (r > 0 && opts->method == IBL_METHOD_SAMPLED)
            plan->whole = true;
        else if (r > 0)
            status = add_lobe(ctx, &shape, opts->tolerance, plan, &degree[l]);
    }
    return status;
}

/* ---- memory ------------------------------------------------------------ */

/* What a bake takes: the largest arrays of its stages, as level0_octants.c,
 * engine.c, transform.c and level.c allocate them. */

typedef struct estimate {
    int width, height, threads;
    double results; /* cubes */
    double reading; /* beside them, while rows are read */
    int degree;     /* of levels */
} estimate;

/* Bytes of a chain of so many levels. */
static double chain_bytes(ibl_projection projection, int size, int levels)
{
    return 12.0 * (double)ibl_map_texels(projection, size, levels);
}

/* Sums of level 0 around the row that is read, and 2 MiB of cuts. */
static double level0_bytes(const estimate *e, int size)
{
    double columns = e->width, rows = e->height;

    while (columns < 4 * size) {
        columns *= 2;
        rows *= 2;
    }
    const double lines = 0.4 * size * fmin(size / rows, 1) + 24;
    return lines * size / 2 * 200 + e->threads * columns * 40 + (2 << 20);
}

static ibl_status add_chain(ibl_ctx *ctx, const ibl_specular_options *o,
                            ibl_spectral_plan *plan, estimate *e)
{
    int degree[IBL_MAX_LEVELS];
    ibl_specular_layout layout;
    ibl_status status = ibl_specular_layout_of(o, &layout);

    if (!status)
        status = ibl_spectral_plan_chain(ctx, o, &layout, degree, plan);
    if (status)
        return status;
    e->results += chain_bytes(o->projection, layout.size, layout.levels);
    if (layout.roughness[0] <= 0)
        e->reading += o->projection == IBL_PROJECTION_CUBE
                          ? level0_bytes(e, layout.size)
                          : 0;
    plan->whole |=
        layout.roughness[0] <= 0 && o->projection != IBL_PROJECTION_CUBE;
    e->degree = plan->degree;
    return IBL_OK;
}

/* Spectra of rings up to a degree. */
static double spectra_bytes(double rings, int degree)
{
    return 24.0 * (degree + 1) * (rings + 32);
}

/* Spectra of the rows of a map up to a degree. */
static double rows_bytes(const estimate *e, int degree)
{
    double orders = 0;
    for (int g = 0; g * IBL_ROW_GROUP < e->height; g++)
        orders += ibl_row_orders((int)e->height, degree, g);
    return 24.0 * IBL_ROW_GROUP * orders;
}

/* The harmonics, and beside them the rows that they come from, or the grid of
 * a level. */
static double analysis_bytes(const estimate *e, const ibl_spectral_plan *plan)
{
    const double harmonics = 12.0 * (plan->degree + 1) * (plan->degree + 2);
    if (plan->degree < 0)
        return 0;
    const double rows =
        rows_bytes(e, plan->degree) + 1.0 * e->height * plan->degree;
    const ibl_ring_grid held = ibl_ring_grid_for(e->degree);
    const double pairs = held.pairs + 2 * IBL_GRID_BORDER;
    const double grid = 32.0 * (held.columns + 2 * IBL_GRID_BORDER) * pairs +
                        spectra_bytes(2 * pairs, e->degree);
    return harmonics + fmax(rows, grid);
}

static double reading_bytes(const estimate *e, const ibl_spectral_plan *plan)
{
    const double row = 12.0 * e->width, whole = row * e->height;
    const double batch =
        fmin(fmax(1 << 20, (e->threads + 1) / 2 * 32 * row), 16 << 20);

    return e->reading + fmin(2 * fmax(batch, 32 * row), whole) +
           (plan->degree < 0
                ? 0
                : e->threads * 40 * row + rows_bytes(e, plan->degree));
}

ibl_status ibl_bake_memory(ibl_ctx *ctx, int width, int height,
                           const ibl_bake_options *opts, size_t *bytes)
{
    const ibl_bake_options usual = ibl_bake_options_default();
    static float nothing;
    ibl_image none = {width, height, &nothing};
    const ibl_environment env = {
        .image = &none, .width = width, .height = height};
    estimate e = {.width = width, .height = height};
    ibl_spectral_plan plan = {0};

    if (!ctx || !bytes)
        return ibl_missing(ctx, "ibl_bake_memory: bytes");
    if (!opts)
        opts = &usual;
    ibl_status status = ibl_check_bake(ctx, &env, opts);
    if (!status)
        status = ibl_spectral_plan_make(ctx, opts, &plan);
    e.threads = ibl_ctx_threads(ctx);
    e.degree = opts->irradiance ? 32 : 0;
    if (!status && opts->specular)
        status = add_chain(ctx, &opts->specular_options, &plan, &e);
    for (int i = 0; i < opts->more_count && !status; i++)
        status = add_chain(ctx, &opts->more[i], &plan, &e);
    if (status)
        return status;
    if (opts->skybox) {
        e.results +=
            4.0 / 3 * chain_bytes(opts->skybox_projection, opts->skybox, 1);
        e.reading += level0_bytes(&e, opts->skybox);
    }
    if (opts->irradiance)
        e.results += chain_bytes(opts->irradiance_options.projection,
                                 opts->irradiance_options.size, 1);
    /* Samples are taken from the map and its mips. */
    const double whole = plan.whole ? 16.0 * width * height : 0;
    *bytes =
        (size_t)(e.results + whole +
                 fmax(reading_bytes(&e, &plan), analysis_bytes(&e, &plan)));
    return IBL_OK;
}
