/* SPDX-License-Identifier: MIT */
/* What a bake takes: the largest arrays of its stages, as level0_octants.c,
 * spectral/engine.c, transform.c and level.c allocate them. */
#include <math.h>

#include "bake/options.h"
#include "bake/spectral/plan.h"
#include "bake/spectral/resample.h"
#include "bake/spectral/transform.h"
#include "core/context.h"
#include "image/cube.h"

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
    ibl_chain_plan chain;
    ibl_specular_layout layout;
    ibl_status status = ibl_specular_layout_of(o, &layout);

    if (!status)
        status = ibl_spectral_plan_chain(ctx, o, &layout, &chain, plan);
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
