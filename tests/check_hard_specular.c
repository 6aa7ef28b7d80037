/* SPDX-License-Identifier: MIT */
/*
 * The hard cases of the specular chain: the ends of roughness, the ends of the
 * sample count, instruction sets and threads. See check_hard.c.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/filter.h"
#include "bake/samples.h"
#include "core/cpu.h"
#include "ibl/ibl.h"
#include "image/pyramid.h"
#include "maps.h"
#include "truth.h"

static const double u = 0x1p-24, pi = 3.14159265358979323846;
/* Float sums of groups of 256 samples, 8 products each, all >= 0. */
static const double gathered = 8 * 256 * 0x1p-24;

static void measured(const char *what, double seen, double limit)
{
    const char *verbose = getenv("IBL_TEST_VERBOSE");
    if (verbose && *verbose && *verbose != '0')
        printf("%s: %.3g of %.3g\n", what, seen, limit);
}

static ibl_cube bake(ibl_ctx *ctx, const ibl_image *map,
                     const ibl_specular_options *o)
{
    ibl_cube cube = {0};
    if (ibl_bake_specular(ctx, map, o, &cube))
        exit(1);
    return cube;
}

static ibl_specular_options options(int size, int levels, int samples)
{
    ibl_specular_options o = ibl_specular_options_default();
    o.method = IBL_METHOD_SAMPLED;
    o.size = size;
    o.levels = levels;
    o.samples = samples;
    return o;
}

/* A sun of 1e6, off every symmetry, on a sky of 1. */
static ibl_image sun_map(ibl_ctx *ctx, int w, int h)
{
    ibl_image map = map_constant(ctx, w, h, 1);
    map_set(&map, w * 5 / 8, h * 2 / 5, 1e6f, 1e6f, 1e6f);
    return map;
}

/* ---- the ends of roughness --------------------------------------------- */

/* r = 0 is no lobe at all: level 0, byte for byte, alone or in a chain. */
static void mirror_is_level0(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = sun_map(ctx, 60, 31);
    const ibl_specular_options o = options(24, 1, 16), p = options(24, 4, 16);
    ibl_cube a = bake(ctx, &map, &o), b = bake(ctx, &map, &p), c = {0};
    NEED(!ibl_cube_alloc(ctx, 24, 1, &c));
    NEED(!ibl_cube_from_latlong(ctx, &map, 0, &c));
    CHECK(!memcmp(a.data, c.data, cube_floats(&c) * sizeof(float)));
    CHECK(!memcmp(b.data, c.data, cube_floats(&c) * sizeof(float)));
    CHECK(ibl_level_roughness(IBL_ROUGHNESS_LINEAR, 0, 4) == 0 &&
          ibl_level_roughness(IBL_ROUGHNESS_FILAMENT, 0, 4) == 0);
    ibl_cube_free(&a);
    ibl_cube_free(&b);
    ibl_cube_free(&c);
    ibl_image_free(&map);
    ibl_ctx_free(ctx);
}

/*
 * r = 1e-4, alpha = 1e-8, and towards 0. All N half vectors are within
 * alpha sqrt(2 N) of the normal (u of the last sample is 1 - 1 / 2N), samples
 * within twice that, and of edge n a texel is at least 1 / n wide: lookups
 * stay within x = 2 n alpha sqrt(2 N) texels of the centre, and the float
 * position within 4 n u more. A bilinear lookup x from the centre along two
 * axes takes 2 x of a neighbour, at most the peak.
 */
static void nearly_mirror(void)
{
    static const double alphas[] = {1e-8, 1e-12, 1e-30, 1e-300};
    enum {
        N = 32,
        COUNT = 1024
    };
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = sun_map(ctx, 128, 64);
    ibl_cube source = {0}, out = {0};
    ibl_pyramid pyramid;
    double most = 0;
    NEED(!ibl_cube_alloc(ctx, N, 1, &source));
    NEED(!ibl_cube_alloc(ctx, 2 * N, 2, &out));
    NEED(!ibl_cube_from_latlong(ctx, &map, 0, &source));
    NEED(!ibl_pyramid_create(ctx, &source, 6, &pyramid));
    double low, peak;
    cube_range(&source, 0, 0, &low, &peak);
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
    measured("nearly_mirror, share of the bound", most, 1);
    ibl_pyramid_free(&pyramid);
    ibl_cube_free(&source);
    ibl_cube_free(&out);
    ibl_image_free(&map);
    ibl_ctx_free(ctx);
}

/* ---- more samples ------------------------------------------------------ */

/*
 * Standard deviation, as a share, of what a small sun at that angle from R
 * gives if N samples are drawn at random: 1 / sqrt(4 pi v N pdf) with v the
 * variance of a lookup's footprint along an axis (bake/samples.c): of the
 * level chosen, or that of level 0 where no finer is left, and of the pixel.
 */
static double random_error(double cosine, double alpha, int count, int edge,
                           double pixel)
{
    const double q = (1 - cosine) / 2, a2 = alpha * alpha;
    const double t = q + a2 * (1 - q), part = 1 / (1 + a2);
    const double pdf = a2 / (t * t) / pi / (4 * part);
    const double h2 = 4 * pi / (6.0 * edge * edge);
    const double texels = 4 / (count * pdf * h2); /* 4^lod, lod_bias 1 */
    const double variance =
        (texels > 1 ? h2 * (texels * 5 / 12 - 1.0 / 6) : h2 / 4) + pixel / 12;
    return 1 / sqrt(4 * pi * variance * count * pdf);
}

/*
 * Against the truth the sampled levels come closer as samples grow, at each
 * count better than random ones would: the bound is their deviation, weighted
 * by the square of what each texel sees of the sun. What stays is the blur of
 * lookups in level 0 itself; its first order is taken back by moved samples,
 * all of it would be half its variance times the lobe's Laplacian over itself,
 * at most 8 / (4 alpha^2). (Of 16 samples the footprints are as wide as the
 * lobe, which no first order takes back: 64 is where the bound begins.)
 */
static void samples_converge(void)
{
    static const int counts[] = {64, 256, 1024, 4096, 16384, 65536};
    enum {
        W = 128,
        H = 64,
        N = 8
    };
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const double pixel = 4 * pi / (W * H), alpha = 0.25;
    ibl_image map = sun_map(ctx, W, H);
    double sun[3], last = 1;
    truth_latlong_direction(W, H, W * 5 / 8, H * 2 / 5, sun);
    const size_t steps = TEST_RACES ? 4 : sizeof counts / sizeof counts[0];
    for (size_t k = 0; k < steps; k++) {
        ibl_specular_options o = options(2 * N, 3, 1);
        double error = 0, bound = 0, norm = 0;
        o.level_samples[1] = counts[k];
        ibl_cube cube = bake(ctx, &map, &o);
        for (int i = 0; i < IBL_FACES * N * N; i++) {
            double d[3], want[3];
            truth_cube_direction(N, i / (N * N), i % N, i / N % N, d);
            const double c = d[0] * sun[0] + d[1] * sun[1] + d[2] * sun[2];
            truth_specular(&map, d, 0.5, want);
            error += pow(ibl_cube_face(&cube, 1, 0)[3 * i] - want[0], 2);
            norm += want[0] * want[0];
            if (c > 0) /* 64: the most that the source is worth */
                bound += pow(
                    want[0] * random_error(c, alpha, counts[k], 64, pixel), 2);
        }
        const double h2 = 4 * pi / (6 * 64 * 64);
        const double blur =
            0.5 * (h2 / 4 + pixel / 6) * 8 / (4 * alpha * alpha);
        const double e = sqrt(error / norm), most = sqrt(bound / norm) + blur;
        char what[64];
        snprintf(what, sizeof what, "samples_converge, %d", counts[k]);
        measured(what, e, most);
        CHECK_MSG(e <= most, "%d samples: %.4f, random ones %.4f", counts[k], e,
                  most);
        CHECK_MSG(e < last || e <= blur, "%d samples: %.5f after %.5f",
                  counts[k], e, last);
        last = e;
        ibl_cube_free(&cube);
    }
    CHECK_MSG(TEST_RACES ||
                  last <= 0.5 * (4 * pi / (6 * 64 * 64) / 4 + pixel / 6) * 32,
              "65536 samples leave %.5f", last);
    ibl_image_free(&map);
    ibl_ctx_free(ctx);
}

/* ---- how it runs ------------------------------------------------------- */

/*
 * Sets share lookup positions and weights to the last bit (kern/gather.h), so
 * two of them differ by the rounding of two sums of the same terms; irradiance
 * is made of rows of floats, within 1e-5. Level 0 has one version.
 */
static void every_isa(void)
{
    const ibl_specular_options o = options(32, 5, 700);
    const ibl_irradiance_options io = {.size = 9};
    ibl_cube plain = {0}, even = {0};
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
        if (!ibl_cpu_has(isa))
            continue;
        ibl_ctx *ctx = test_ctx(2, isa);
        ibl_image map = sun_map(ctx, 97, 53);
        ibl_cube cube = bake(ctx, &map, &o), irr = {0};
        double worst = 0, most = 0;
        NEED(!ibl_bake_irradiance(ctx, &map, &io, &irr));
        ibl_image_free(&map);
        ibl_ctx_free(ctx);
        if (isa == IBL_ISA_C) {
            plain = cube;
            even = irr;
            continue;
        }
        CHECK(!memcmp(cube.data, plain.data, 18 * 32 * 32 * sizeof(float)));
        for (size_t i = 0; i < cube_floats(&cube); i++)
            worst = fmax(
                worst, fabs((double)cube.data[i] / (double)plain.data[i] - 1));
        for (size_t i = 0; i < cube_floats(&irr); i++)
            most = fmax(most,
                        fabs((double)irr.data[i] / (double)even.data[i] - 1));
        CHECK_MSG(worst <= 2 * gathered, "%s: %.3g", ibl_isa_name(isa), worst);
        CHECK_MSG(most <= 1e-5, "%s: irradiance %.3g", ibl_isa_name(isa), most);
        measured(ibl_isa_name(isa), worst, 2 * gathered);
        ibl_cube_free(&cube);
        ibl_cube_free(&irr);
    }
    ibl_cube_free(&plain);
    ibl_cube_free(&even);
}

/* More threads than jobs, and numbers that share nothing with tiles. */
static void every_thread_count(void)
{
    static const int counts[] = {1, 2, 3, 7, 64};
    ibl_specular_options o = options(48, 5, 100);
    ibl_cube first = {0};
    o.jitter = 1;
    for (int k = 0; k < 5; k++) {
        ibl_ctx *ctx = test_ctx(counts[k], IBL_ISA_AUTO);
        ibl_image map = sun_map(ctx, 301, 149);
        ibl_cube cube = bake(ctx, &map, &o);
        ibl_image_free(&map);
        ibl_ctx_free(ctx);
        if (!first.data) {
            first = cube;
            continue;
        }
        CHECK_MSG(
            !memcmp(first.data, cube.data, cube_floats(&cube) * sizeof(float)),
            "%d threads", counts[k]);
        ibl_cube_free(&cube);
    }
    ibl_cube_free(&first);
}

/*
 * Every texel is an average, so none is above the brightest pixel
 * (check_property, range_of_*); but the largest value of a level may be above
 * that of the level before. Level 0 spreads a pixel over a texel, of about
 * 4 / n^2, and a lobe over 4 pi alpha^2 (its integral over its peak): with
 * n = 8 and Filament's roughness, alpha = 0.034, a pixel that a texel's centre
 * of level 1 looks at comes out brighter there. So no bound by the level
 * above is tested.
 */
static void levels_may_rise(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    ibl_image map = map_constant(ctx, 512, 256, 0);
    ibl_specular_options o = options(8, 4, 4096);
    double d[3], want[3], low, high[4];
    int i, j;
    truth_cube_direction(4, 0, 2, 1, d);
    truth_latlong_pixel(512, 256, d, &i, &j);
    map_set(&map, i, j, 1, 1, 1);
    o.mapping = IBL_ROUGHNESS_FILAMENT;
    ibl_cube cube = bake(ctx, &map, &o);
    for (int l = 0; l < 4; l++) {
        cube_range(&cube, l, 0, &low, &high[l]);
        CHECK(low >= 0 && high[l] <= 1);
    }
    truth_specular(&map, d, ibl_level_roughness(o.mapping, 1, 4), want);
    measured("levels_may_rise, level 1 over level 0", high[1] / high[0],
             want[0] / high[0]);
    CHECK(want[0] > high[0] && high[1] > high[0]);
    ibl_cube_free(&cube);
    ibl_image_free(&map);
    ibl_ctx_free(ctx);
}

static const test tests[] = {
    TEST(mirror_is_level0), TEST(nearly_mirror),      TEST(samples_converge),
    TEST(every_isa),        TEST(every_thread_count), TEST(levels_may_rise),
};
TEST_MAIN(tests)
