/* SPDX-License-Identifier: MIT */
/*
 * Sources: Karis 2013, "Real Shading in Unreal Engine 4" (N.L weights);
 * Krivanek and Colbert 2008, "Real-time Shading with Filtered Importance
 * Sampling" (mip from pdf). The sampling of each lobe is in brdf/lobe.h.
 */
#include "bake/samples.h"

#include <limits.h>
#include <math.h>

#include "brdf/hammersley.h"
#include "core/alloc.h"
#include "core/context.h"

enum {
    ARRAYS = 5,       /* x, y, z, fine, coarse */
    JOB_SAMPLES = 256 /* some tens of microseconds */
};

/* One sample before it is stored. lod never falls from one sample to the next,
 * since D falls with the regular coordinate of the Hammersley points. */
typedef struct sample {
    double x, y, z, weight, lod;
} sample;

/* ---- storage ---------------------------------------------------------- */

static int level_of(const sample *s)
{
    return (int)s->lod;
}

static int mips_of(const sample *s)
{
    return s->lod > level_of(s) ? 2 : 1;
}

/* Cuts the samples into groups; with groups NULL it only counts them. Returns
 * their number and writes the length of the arrays to *stored. */
static int make_groups(const sample *all, int count, ibl_gather_group *groups,
                       size_t *stored)
{
    int made = 0;
    *stored = 0;
    for (int i = 0; i < count;) {
        int n = 1;
        while (i + n < count && n < IBL_GATHER_MAX_GROUP &&
               level_of(&all[i + n]) == level_of(&all[i]) &&
               mips_of(&all[i + n]) == mips_of(&all[i]))
            n++;
        if (groups)
            groups[made] = (ibl_gather_group){
                (int)*stored, n, level_of(&all[i]), mips_of(&all[i])};
        made++;
        *stored += (size_t)(n + IBL_GATHER_ALIGN - 1) / IBL_GATHER_ALIGN *
                   IBL_GATHER_ALIGN;
        i += n;
    }
    return made;
}

static void store(const sample *all, size_t length, double sum,
                  ibl_samples *out)
{
    float *a = out->memory;
    for (int g = 0; g < out->set.group_count; g++) {
        const ibl_gather_group *group = &out->groups[g];
        size_t at = (size_t)group->first;
        for (int i = 0; i < group->count; i++, at++, all++) {
            const double w = all->weight / sum;
            const double f = all->lod - level_of(all);
            a[at] = (float)all->x;
            a[length + at] = (float)all->y;
            a[2 * length + at] = (float)all->z;
            a[3 * length + at] = (float)(w * (1 - f));
            a[4 * length + at] = (float)(w * f);
        }
        for (; at % IBL_GATHER_ALIGN; at++) {
            a[at] = a[length + at] = 0;
            a[2 * length + at] = 1;
            a[3 * length + at] = a[4 * length + at] = 0;
        }
    }
}

/* Stores count samples, sorted by lod, with weights that sum to 1. */
static ibl_status finish(ibl_ctx *ctx, const sample *all, int count,
                         ibl_samples *out)
{
    size_t length;
    double sum = 0;
    const int groups = make_groups(all, count, NULL, &length);
    *out = (ibl_samples){.count = count};
    out->memory = ibl_alloc_array(length, ARRAYS * sizeof *out->memory);
    out->groups = ibl_alloc_array((size_t)groups, sizeof *out->groups);
    if (!out->memory || !out->groups) {
        ibl_samples_free(out);
        return ibl_no_memory(ctx, "a set of samples");
    }
    make_groups(all, count, out->groups, &length);
    const float *m = out->memory;
    out->set = (ibl_gather_samples){
        m,           m + length, m + 2 * length, m + 3 * length, m + 4 * length,
        out->groups, groups};
    for (int i = 0; i < count; i++)
        sum += all[i].weight;
    store(all, length, sum, out);
    return IBL_OK;
}

void ibl_samples_free(ibl_samples *samples)
{
    ibl_free(samples->memory);
    ibl_free(samples->groups);
    *samples = (ibl_samples){0};
}

/* ---- specular --------------------------------------------------------- */

/* Mean solid angle of a texel of the pyramid's level 0. */
static double texel_angle(const ibl_sampling *s)
{
    return 4 * IBL_PI / (6.0 * s->edge * s->edge);
}

/* Mip level of a sample; below 0 if it needs a finer level than there is. */
static double lod_of(const ibl_sampling *s, double pdf)
{
    if (!s->pdf_mip)
        return -1;
    return 0.5 * log2(1 / (s->count * pdf * texel_angle(s))) + s->lod_bias;
}

/* d(ln D) / d(angle), the angle from R: q = sin^2(angle / 2). */
static double slope(const ibl_lobe_shape *shape, double sin_h, double cos_h,
                    double cosine)
{
    return ibl_lobe_slope(shape, sin_h * sin_h, cosine) * sin_h * cos_h;
}

/*
 * A sample's angle from the normal, moved so that the blur of its lookup does
 * not widen the lobe.
 *
 * A lookup averages the environment over a footprint. A footprint with variance
 * v along an axis turns the lobe k into k + 1/2 laplace(v k). Moving samples by
 * a small s changes their density by -div(k s), which cancels the blur if
 *     k s = 1/2 grad(v k).
 * With h the edge of a texel of level 0, v is h^2 (4^lod 5/12 - 1/6) at the
 * pyramid's levels (1/12 for level 0 itself, 3/4 4^l for each step down,
 * 4^lod / 6 for the bilinear tent) and 1/4 h^2 where the level is clamped to 0.
 * The footprint of the source's pixels is added everywhere. With k = D N.L:
 *
 *   - The part that grows as 4^lod is proportional to 1/D: of v k only N.L has
 *     a gradient. The gradients of N.L together give s = -v/2 tan(angle). For a
 *     cosine lobe this is sin -> sin / sqrt(1 + v); in this form no light leaks
 *     over the horizon.
 *   - The constant part c adds s = c/2 d(ln D), which matters for lobes little
 *     wider than a texel. Narrower lobes exceed this first order: their samples
 *     move by half their angle at most and stay above the horizon.
 */
static double moved_angle(const ibl_sampling *s, const ibl_lobe_sample *at,
                          double lod)
{
    const double angle = 2 * atan2(at->sin_h, at->cos_h);
    const double h2 = texel_angle(s);
    double grown = 0, constant = s->footprint + h2 / 4;

    if (lod > 0) {
        grown = h2 * 5 / 12 * pow(4, fmin(lod, s->levels - 1));
        constant = s->footprint - h2 / 6;
    }
    double move =
        0.5 * constant * slope(&s->shape, at->sin_h, at->cos_h, at->cosine);
    move =
        fmin(fmax(move, -0.5 * angle), fmin(0.5 * angle, 0.5 * IBL_PI - angle));
    return asin(fmin(sin(angle + move), 1) / sqrt(1 + grown + constant));
}

static sample make_sample(const ibl_sampling *s, int i)
{
    double u1, u2;
    ibl_hammersley((uint32_t)i, (uint32_t)s->count, &u1, &u2);
    const ibl_lobe_sample at = ibl_lobe_draw(&s->shape, u1);
    const double lod = lod_of(s, at.pdf);
    const double angle = moved_angle(s, &at, lod);
    const double phi = 2 * IBL_PI * u2;
    return (sample){.x = sin(angle) * cos(phi),
                    .y = sin(angle) * sin(phi),
                    .z = cos(angle),
                    .weight = at.cosine,
                    .lod = fmin(fmax(lod, 0), s->levels - 1)};
}

struct drawing {
    const ibl_sampling *sampling;
    sample *all;
};

static void sample_job(void *arg, int job, int worker)
{
    const struct drawing *d = arg;
    const int first = job * JOB_SAMPLES;
    (void)worker;
    for (int i = first; i < first + JOB_SAMPLES && i < d->sampling->count; i++)
        d->all[i] = make_sample(d->sampling, i);
}

ibl_status ibl_samples_specular(ibl_ctx *ctx, const ibl_sampling *sampling,
                                ibl_samples *samples)
{
    struct drawing d = {.sampling = sampling};
    ibl_status status;

    d.all = ibl_alloc_array((size_t)sampling->count, sizeof *d.all);
    if (!d.all)
        return ibl_no_memory(ctx, "a set of samples");
    status = ibl_run(ctx, NULL, (sampling->count - 1) / JOB_SAMPLES + 1,
                     sample_job, &d);
    if (!status)
        status = finish(ctx, d.all, sampling->count, samples);
    ibl_free(d.all);
    return status;
}

/* ---- hemisphere ------------------------------------------------------- */

ibl_status ibl_samples_hemisphere(ibl_ctx *ctx, double step,
                                  ibl_samples *samples)
{
    const double wanted = ceil(IBL_PI / 2 / step) * ceil(2 * IBL_PI / step);
    if (!(wanted < INT_MAX / 2))
        return ibl_no_memory(ctx, "a hemisphere of samples");
    const int rings = (int)ceil(IBL_PI / 2 / step);
    const int spokes = (int)ceil(2 * IBL_PI / step);
    sample *all = ibl_alloc_array((size_t)rings * (size_t)spokes, sizeof *all);
    sample *s = all;
    if (!all)
        return ibl_no_memory(ctx, "a hemisphere of samples");
    for (int j = 0; j < rings; j++) {
        const double theta = IBL_PI / 2 * (j + 0.5) / rings;
        for (int i = 0; i < spokes; i++) {
            const double phi = 2 * IBL_PI * (i + 0.5) / spokes;
            *s++ = (sample){sin(theta) * cos(phi), sin(theta) * sin(phi),
                            cos(theta), cos(theta) * sin(theta), 0};
        }
    }
    const ibl_status status = finish(ctx, all, rings * spokes, samples);
    ibl_free(all);
    return status;
}
