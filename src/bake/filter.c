/* SPDX-License-Identifier: MIT */
#include "bake/filter.h"

#include <float.h>
#include <math.h>
#include <stdint.h>

#include "core/context.h"
#include "core/pi.h"

enum {
    /* Some milliseconds at the slowest kernel's 50 ns a sample. */
    SAMPLES_PER_JOB = 1 << 17
};

typedef struct filter {
    ibl_gather_level levels[IBL_MAX_LEVELS];
    ibl_gather_dsp dsp;
    const ibl_pyramid *pyramid;
    const ibl_samples *samples;
    bool jitter;
    int level, edge;
    long count; /* texels */
    int chunk;  /* of them in a job */
    float *out;
} filter;

/* A turn that looks random from texel to texel: splitmix64 of its index. */
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
    /* Weights sum to 1 but for rounding, too much for the largest floats. */
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

static ibl_status run(ibl_ctx *ctx, const char *stage, filter *a)
{
    for (int l = 0; l < a->pyramid->levels; l++)
        a->levels[l] = (ibl_gather_level){a->pyramid->texels[l],
                                          ibl_cube_edge(a->pyramid->size, l)};
    ibl_gather_dsp_init(&a->dsp, ibl_ctx_isa(ctx));
    a->chunk = SAMPLES_PER_JOB / a->samples->count;
    if (a->chunk < 1)
        a->chunk = 1;
    return ibl_run(ctx, stage, (int)((a->count + a->chunk - 1) / a->chunk),
                   filter_job, a);
}

ibl_status ibl_filter_level(ibl_ctx *ctx, const char *stage,
                            const ibl_pyramid *pyramid,
                            const ibl_samples *samples, bool jitter,
                            ibl_cube *out, int level)
{
    const int n = ibl_cube_edge(out->size, level);
    filter a = {.pyramid = pyramid,
                .samples = samples,
                .jitter = jitter,
                .level = level,
                .edge = n,
                .count = (long)IBL_FACES * n * n,
                .out = ibl_cube_face(out, level, 0)};
    return run(ctx, stage, &a);
}
