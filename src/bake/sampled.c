/* SPDX-License-Identifier: MIT */
#include "bake/sampled.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "bake/options.h"
#include "brdf/lobe.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"

enum {
    LOOKUPS_PER_TEXEL = 128, /* cost of a texel of the cube; measured */
    CHEAP_EDGE = 128,        /* a cube up to this edge is always worth making */
    MAX_GRID_EDGE = 1024,    /* texels far smaller than any sensible step */
    /* A few milliseconds in the slowest kernel, at 50 ns a sample. */
    SAMPLES_PER_JOB = 1 << 17
};

/* ---- a level by one set of samples ----------------------------------------
 */

void ibl_texel_frame(int n, int face, int x, int y, double turn, float frame[9])
{
    const ibl_face_axes *axes = &ibl_face[face];
    double normal[3], t[3], b[3], along = 0, length = 0;
    ibl_cube_direction(n, face, x, y, normal);
    for (int k = 0; k < 3; k++)
        along += normal[k] * axes->right[k];
    for (int k = 0; k < 3; k++) {
        t[k] = axes->right[k] - along * normal[k];
        length += t[k] * t[k];
    }
    for (int k = 0; k < 3; k++)
        t[k] /= sqrt(length);
    for (int k = 0; k < 3; k++) {
        const int p = (k + 1) % 3, q = (k + 2) % 3;
        b[k] = normal[p] * t[q] - normal[q] * t[p];
    }
    const double c = cos(turn), s = sin(turn);
    for (int k = 0; k < 3; k++) {
        frame[k] = (float)(c * t[k] + s * b[k]);
        frame[3 + k] = (float)(c * b[k] - s * t[k]);
        frame[6 + k] = (float)normal[k];
    }
}

typedef struct filter {
    ibl_gather_level levels[IBL_MAX_LEVELS];
    ibl_gather_dsp dsp;
    const ibl_pyramid *pyramid;
    const ibl_samples *samples;
    bool jitter;
    int level, edge;
    long count; /* texels */
    int chunk;  /* texels in a job */
    float *out;
} filter;

/* Pseudo-random angle of a texel, 0..2 pi: splitmix64 of level and index. */
static double turn_of(int level, long texel)
{
    uint64_t z = ((uint64_t)level << 32 | (uint64_t)texel) + 1;
    z *= 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return 2 * IBL_PI * 0x1p-53 * (double)((z ^ z >> 31) >> 11);
}

static void filter_texel(const filter *a, long texel)
{
    const int n = a->edge;
    const int face = (int)(texel / ((long)n * n));
    const int y = (int)(texel / n % n), x = (int)(texel % n);
    float frame[9];
    double rgb[3];
    ibl_texel_frame(n, face, x, y, a->jitter ? turn_of(a->level, texel) : 0,
                    frame);
    a->dsp.gather(&a->samples->set, a->levels, frame, rgb);
    /* Weights sum to 1 up to rounding, which the largest floats exceed. */
    for (int c = 0; c < 3; c++)
        a->out[3 * texel + c] =
            (float)fmin(rgb[c] + a->pyramid->floor[c], FLT_MAX);
}

static void filter_job(void *arg, int job, int worker)
{
    const filter *a = arg;
    const long begin = (long)job * a->chunk;
    const long end = begin + a->chunk < a->count ? begin + a->chunk : a->count;
    (void)worker;
    for (long i = begin; i < end; i++)
        filter_texel(a, i);
}

ibl_status ibl_filter_level(ibl_ctx *ctx, const char *stage,
                            const ibl_pyramid *pyramid,
                            const ibl_samples *samples, bool jitter,
                            const ibl_cube *out, int level)
{
    const int n = ibl_cube_edge(out->size, level);
    const int fit = SAMPLES_PER_JOB / samples->count;
    filter a = {.pyramid = pyramid,
                .samples = samples,
                .jitter = jitter,
                .level = level,
                .edge = n,
                .count = (long)IBL_FACES * n * n,
                .chunk = fit > 1 ? fit : 1,
                .out = ibl_cube_face(out, level, 0)};
    for (int l = 0; l < pyramid->levels; l++)
        a.levels[l] = (ibl_gather_level){pyramid->texels[l],
                                         ibl_cube_edge(pyramid->size, l)};
    ibl_gather_dsp_init(&a.dsp, ibl_ctx_isa(ctx));
    return ibl_run(ctx, stage, (int)((a.count + a.chunk - 1) / a.chunk),
                   filter_job, &a);
}

/* ---- specular levels ----------------------------------------------------- */

typedef struct bake {
    ibl_ctx *ctx;
    const ibl_image *env;
    const ibl_specular_options *opts; /* in range */
    const ibl_specular_layout *layout;
    const ibl_cube *cube; /* with this layout */
    ibl_pyramid pyramid;  /* for lookups */
} bake;

static int lookup_limit(const ibl_image *env)
{
    const double wanted = fmax(env->width / 2.0, env->height);
    int edge = 1;
    while (edge < wanted && edge < IBL_GATHER_MAX_EDGE)
        edge *= 2;
    return edge;
}

static double lookup_cost(int edge)
{
    return (double)LOOKUPS_PER_TEXEL * IBL_FACES * edge * edge;
}

static bool has_level0(const bake *b)
{
    const int size = b->layout->size;
    return b->layout->roughness[0] <= 0 && (size & (size - 1)) == 0 &&
           size <= IBL_GATHER_MAX_EDGE;
}

/*
 * Edge of the cube for lookups, a power of two. The finest sample should use
 * level 1, since level 0 puts a light in the middle of its texel
 * (image/pyramid.h). Texels smaller than half a pixel of the source are
 * useless. A texel costs about as much as LOOKUPS_PER_TEXEL samples: making a
 * cube finer than the output should not take longer than using it.
 */
static int lookup_edge(const bake *b)
{
    const int size = b->layout->size, samples = b->opts->samples;
    double wanted = 1, lookups = 0;
    for (int l = 0; l < b->layout->levels; l++) {
        /* lod_of() in samples.c at the lobe's peak, solved for the edge where
         * it is 1. */
        const double r = b->layout->roughness[l];
        if (r <= 0)
            continue;
        const ibl_lobe_shape shape = ibl_lobe_shape_of(b->opts->lobe, r * r);
        const double edge =
            sqrt(samples / 6.0 * 4 * IBL_PI * ibl_lobe_peak(&shape)) /
            exp2(ibl_lod_bias_of(b->opts) - 1);
        const double n = ibl_cube_edge(size, l);
        wanted = fmax(wanted, edge);
        lookups += IBL_FACES * n * n * samples;
    }
    wanted = fmin(wanted, lookup_limit(b->env));

    int edge = 1;
    while (edge < wanted)
        edge *= 2;
    while (edge > CHEAP_EDGE && edge > size && lookup_cost(edge) > lookups)
        edge /= 2;
    /* Level 0 of the output exists already and may serve. */
    if (has_level0(b) && size >= edge && size <= 4 * edge)
        return size;
    return edge;
}

/* Makes the pyramid for lookups from the map. */
static ibl_status make_pyramid(ibl_ctx *ctx, const ibl_image *env, double yaw,
                               int edge, int levels, ibl_pyramid *pyramid)
{
    ibl_cube cube = {0};
    ibl_status status = ibl_cube_alloc(ctx, edge, 1, &cube);
    if (!status)
        status = ibl_cube_from_latlong(ctx, env, yaw, &cube);
    if (!status)
        status = ibl_pyramid_create(ctx, &cube, levels, pyramid);
    ibl_cube_free(&cube);
    return status;
}

/* Variance of a source pixel along one axis, in square radians, in a cube of
 * this edge: a constant patch or, if larger than the texels, a tent. */
static double footprint(const ibl_image *env, int edge)
{
    const double angle = 4 * IBL_PI / ((double)env->width * env->height);
    const bool tent = env->width < 4 * edge || env->height < 2 * edge;
    return angle / (tent ? 6 : 12);
}

static ibl_status bake_level(const bake *b, int level)
{
    const double r = b->layout->roughness[level];
    const ibl_sampling sampling = {
        .shape = ibl_lobe_shape_of(b->opts->lobe, r * r),
        .count = b->opts->samples,
        .edge = b->pyramid.size,
        .levels = b->pyramid.levels,
        .lod_bias = ibl_lod_bias_of(b->opts),
        .pdf_mip = b->opts->pdf_mip,
        .footprint = footprint(b->env, b->pyramid.size),
    };
    char stage[32];
    ibl_samples samples;
    ibl_status status = ibl_samples_specular(b->ctx, &sampling, &samples);
    if (status)
        return status;
    snprintf(stage, sizeof stage, "specular %d", level);
    status = ibl_filter_level(b->ctx, stage, &b->pyramid, &samples,
                              b->opts->jitter, b->cube, level);
    ibl_samples_free(&samples);
    return status;
}

ibl_status ibl_sample_levels(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                             const ibl_specular_options *opts,
                             const ibl_cube *cube, ibl_specular_report *report)
{
    bake b = {.ctx = ctx,
              .env = env,
              .opts = opts,
              .layout = &report->layout,
              .cube = cube};
    if (b.layout->roughness[b.layout->levels - 1] <= 0)
        return IBL_OK;
    const int edge = lookup_edge(&b), levels = ibl_cube_most_levels(edge);
    ibl_status status =
        edge == cube->size && report->layout.roughness[0] <= 0
            ? ibl_pyramid_create(ctx, cube, levels, &b.pyramid)
            : make_pyramid(ctx, env, yaw_deg, edge, levels, &b.pyramid);
    for (int l = 0; l < cube->levels && !status; l++)
        if (report->layout.roughness[l] > 0) {
            report->level[l].samples = opts->samples;
            status = bake_level(&b, l);
        }
    report->lookup_size = b.pyramid.size;
    ibl_pyramid_free(&b.pyramid);
    return status;
}

/* ---- irradiance -----------------------------------------------------------
 */

/* Edge of the cube for lookups: texels like the source's pixels. */
static int grid_edge(const ibl_image *env)
{
    const int across = env->width / 4, down = env->height / 2;
    const int edge = across > down ? across : down;
    if (edge < 1)
        return 1;
    return edge < MAX_GRID_EDGE ? edge : MAX_GRID_EDGE;
}

ibl_status ibl_irradiance_grid(ibl_ctx *ctx, const ibl_image *env,
                               const ibl_irradiance_options *opts,
                               const ibl_cube *out)
{
    ibl_pyramid pyramid = {0};
    ibl_samples samples = {0};
    ibl_status status =
        make_pyramid(ctx, env, opts->yaw_deg, grid_edge(env), 1, &pyramid);
    if (!status)
        status = ibl_samples_hemisphere(ctx, opts->step, &samples);
    if (!status)
        status = ibl_filter_level(ctx, "irradiance", &pyramid, &samples, false,
                                  out, 0);
    ibl_samples_free(&samples);
    ibl_pyramid_free(&pyramid);
    return status;
}
