/* SPDX-License-Identifier: MIT */
/* The levels by samples: the ends of their options, and sets of samples. What
 * they are against the truth is in check_levels. */
#include <math.h>
#include <stdlib.h>

#include "bake/sampled.h"
#include "bake/spectral/lobe_coefficients.h"
#include "maps.h"

static const double u = 0x1p-24;

/* Float sums of groups of 256 samples, 8 products each, all >= 0. */
static const double gathered = 8 * 256 * 0x1p-24;

static ibl_specular_options options(int size, int levels, int samples)
{
    ibl_specular_options o = ibl_specular_options_default();
    o.method = IBL_METHOD_SAMPLED;
    o.mapping = IBL_ROUGHNESS_LINEAR;
    o.size = size;
    o.levels = levels;
    o.samples = samples;
    return o;
}

static ibl_cube bake(ibl_ctx *ctx, const ibl_image *map,
                     const ibl_specular_options *o)
{
    ibl_cube cube = {0};
    if (ibl_bake_specular(ctx, map, o, &cube, NULL))
        exit(1);
    return test_cube(cube);
}

/* ---- options ------------------------------------------------------------ */

/*
 * r = 1e-4, alpha = 1e-8, and towards 0. All N half vectors are within
 * alpha sqrt(2 N) of the normal (u of the last sample is 1 - 1 / 2N), samples
 * within twice that, and of edge n a texel is at least 1 / n wide: lookups
 * stay within x = 2 n alpha sqrt(2 N) texels of the centre, and the float
 * position within 4 n u more. A bilinear lookup x from the centre along two
 * axes takes 2 x of a neighbour, at most the peak.
 */
TEST(nearly_mirror)
{
    static const double alphas[] = {1e-8, 1e-12, 1e-30, 1e-300};
    enum {
        N = 32,
        COUNT = 1024
    };
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = map_constant(ctx, 128, 64, 1);
    map_set(&map, 80, 25, 1e6f, 1e6f, 1e6f);
    ibl_cube source = cube_level0(ctx, &map, 0, N);
    ibl_cube out = cube_alloc(ctx, 2 * N, 2);
    ibl_pyramid pyramid;
    double most = 0;
    NEED(!ibl_pyramid_create(ctx, &source, 6, &pyramid));
    double peak = 0;
    for (size_t i = 0; i < cube_floats(&source); i++)
        peak = fmax(peak, source.data[i]);
    for (size_t k = 0; k < sizeof alphas / sizeof alphas[0]; k++) {
        const ibl_sampling lobe = {
            .shape = ibl_lobe_shape_of(IBL_LOBE_GGX, alphas[k]),
            .count = COUNT,
            .edge = N,
            .levels = 6,
            .lod_bias = 1,
            .pdf_mip = true,
            .footprint = 1e-4};
        const double x = N * (2 * alphas[k] * sqrt(2 * COUNT) + 4 * u);
        ibl_samples samples;
        NEED(!ibl_samples_specular(ctx, &lobe, &samples));
        NEED(!ibl_filter_level(ctx, "x", &pyramid, &samples, k % 2, &out, 1));
        const float *p = ibl_cube_face(&out, 1, 0);
        for (size_t i = 0; i < cube_floats(&source); i++) {
            const double want = source.data[i];
            const double slack = gathered * want + 2 * x * peak;
            CHECK_MSG(fabs((double)p[i] - want) <= slack,
                      "alpha %g: %.9g, not %.9g", alphas[k], (double)p[i],
                      want);
            most = fmax(most, fabs((double)p[i] - want) / slack);
        }
        ibl_samples_free(&samples);
    }
    test_measured("nearly_mirror, share of the bound", most, 1);
    ibl_pyramid_free(&pyramid);
}

/* The lookups' cube is as fine as half a pixel of the larger side, or as one
 * less lod bias makes it; sizes are powers of two. */
TEST(lookup_sizes)
{
    static const int shapes[][2] = {{128, 16}, {32, 64}, {128, 64}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_specular_options o = options(4, 3, 4096);
    ibl_specular_report report;
    ibl_cube cube;
    ibl_image env;

    for (int k = 0; k < 3; k++) {
        env = map_constant(ctx, shapes[k][0], shapes[k][1], 1);
        NEED(!ibl_bake_specular(ctx, &env, &o, &cube, &report));
        CHECK_MSG(report.lookup_size == 64, "%dx%d: %d", env.width, env.height,
                  report.lookup_size);
        ibl_cube_free(&cube);
    }
    o.samples = 64;
    for (int last = 0, bias = 3; bias >= 0; bias--) {
        o.lod_bias = bias;
        NEED(!ibl_bake_specular(ctx, &env, &o, &cube, &report));
        CHECK_MSG(!last || report.lookup_size == 2 * last,
                  "bias %d: %d, not twice %d", bias, report.lookup_size, last);
        last = report.lookup_size;
        ibl_cube_free(&cube);
    }
}

/* Equal columns give equal sides, but with jitter each texel is turned. */
TEST(jitter_differs)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_specular_options o = options(16, 3, 8);
    ibl_image env = map_constant(ctx, 64, 32, 1);
    const size_t face = 3 * 64;

    for (int i = 0; i < 3 * 64 * 32; i++)
        env.data[i] = i / 192 % 5 < 2 ? 1 : 0.1f;
    for (int jitter = 0; jitter < 2; jitter++) {
        int differ = 0;
        o.jitter = jitter;
        ibl_cube cube = bake(ctx, &env, &o);
        const float *level = ibl_cube_face(&cube, 1, 0);
        for (size_t i = 0; i < face; i += 3)
            differ += fabsf(level[i] / level[4 * face + i] - 1) > 1e-4f;
        CHECK_MSG(jitter ? differ > 32 : !differ, "jitter %d: %d texels differ",
                  jitter, differ);
    }
}

/* ---- sample sets ------------------------------------------------------ */

static void check_set(const ibl_samples *s, int levels)
{
    double sum = 0;
    int count = 0;
    for (int g = 0; g < s->set.group_count; g++) {
        const ibl_gather_group *group = &s->groups[g];
        CHECK(group->first % IBL_GATHER_ALIGN == 0);
        CHECK(group->count >= 1 && group->count <= IBL_GATHER_MAX_GROUP);
        CHECK(group->level >= 0 && group->level + group->mips <= levels);
        for (int i = group->first; i < group->first + group->count; i++) {
            const double x = (double)s->set.x[i], y = (double)s->set.y[i];
            const double z = (double)s->set.z[i];
            CHECK_NEAR(x * x + y * y + z * z, 1, 1e-6);
            CHECK(z > 0);
            CHECK(s->set.fine[i] >= 0 && s->set.coarse[i] >= 0);
            CHECK(group->mips == 2 || s->set.coarse[i] <= 0);
            sum += (double)s->set.fine[i] + (double)s->set.coarse[i];
            count++;
        }
    }
    CHECK(count == s->count);
    CHECK_NEAR(sum, 1, 1e-6);
}

/* From a delta to a cosine, few samples and many: nothing but numbers. */
TEST(sample_sets_are_sound)
{
    static const double alphas[] = {1e-300, 1e-30, 1e-8, 1e-4, 0.018, 0.5, 1};
    static const int counts[] = {1, 2, 15, 16, 17, 1024, 5000};
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    for (int k = 0; k < 7 * 7 * 3 * 3; k++) {
        ibl_samples s;
        const ibl_lobe which = (ibl_lobe)(k / 147);
        const ibl_sampling lobe = {.shape =
                                       ibl_lobe_shape_of(which, alphas[k % 7]),
                                   .count = counts[k / 7 % 7],
                                   .edge = 128,
                                   .levels = 8,
                                   .lod_bias = 4 * (k / 49 % 3) - 4,
                                   .pdf_mip = k % 5 > 0,
                                   .footprint = 1e-5};
        NEED(!ibl_samples_specular(ctx, &lobe, &s));
        check_set(&s, 8);
        ibl_samples_free(&s);
    }
}

/* The variance along an axis of what a sample looks up, as samples.c says. */
static double blur_of(const ibl_samples *s, const ibl_gather_group *group,
                      int i, double texel)
{
    const double coarse = (double)s->set.coarse[i];
    const double part = coarse / ((double)s->set.fine[i] + coarse);
    const double grown = pow(4, group->level + part) * 5 / 12;
    return texel * (grown - 1.0 / 6);
}

/* Blur by v along each axis takes v from the mean cosine: with it, samples have
 * the lobe's, but for what is left of the second order. */
TEST(sets_take_blur_back)
{
    const double texel = 4 * M_PI / (6 * 16 * 16);
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    const ibl_lobe_shape shape = ibl_lobe_shape_of(IBL_LOBE_GGX, 0.5);
    double k[2];

    NEED(!ibl_lobe_coefficients(ctx, &shape, 1, k));
    for (int mip = 0; mip < 2; mip++) {
        const ibl_sampling sampling = {.shape = shape,
                                       .count = 20000,
                                       .edge = 16,
                                       .levels = 5,
                                       .lod_bias = 4,
                                       .pdf_mip = mip,
                                       .footprint = mip ? 2 * texel : 0};
        double sum = 0, blur = 0;
        ibl_samples s;
        NEED(!ibl_samples_specular(ctx, &sampling, &s));
        for (int g = 0; g < s.set.group_count; g++) {
            const ibl_gather_group *group = &s.groups[g];
            for (int i = group->first; i < group->first + group->count; i++) {
                const double w =
                    (double)s.set.fine[i] + (double)s.set.coarse[i];
                const double v =
                    sampling.footprint + blur_of(&s, group, i, texel);
                sum += w * (double)s.set.z[i] * (1 - v);
                blur += w * v;
            }
        }
        CHECK_NEAR(sum, k[1], (mip ? 0.2 : 0.1) * blur);
        ibl_samples_free(&s);
    }
}
