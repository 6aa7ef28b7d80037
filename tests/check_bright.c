/* SPDX-License-Identifier: MIT */
/*
 * Bright pixels: lobes against their formulas and closed integrals in double,
 * then whole levels of lights against sums over them.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bake/spectral/bright.h"
#include "bake/spectral/resample.h"
#include "core/cpu.h"
#include "test.h"
#include "truth.h"

#define PI 3.14159265358979323846

/* ---- the lobes of ibl/ibl.h, by q, in double ---------------------------- */

typedef struct lobe {
    const char *name;
    double (*weight)(double q, double alpha);
    double (*integral)(double alpha);
    double alpha;
} lobe;

static double ggx(double q, double alpha)
{
    const double a2 = alpha * alpha, t = a2 + (1 - a2) * 0.25 * q;
    return a2 * (1 - 0.5 * q) / (PI * t * t);
}

/* With A = alpha^2 and B = (1 - A) / 4: pi times the integral over q = 0..2
 * of (1 - q/2) / (A + B q)^2, times A / pi. */
static double ggx_integral(double alpha)
{
    const double a = alpha * alpha, b = 0.25 * (1 - a);
    if (b < 1e-3)
        return 1;
    return a * ((1 + a / (2 * b)) / b * (1 / a - 1 / (a + 2 * b)) -
                log1p(2 * b / a) / (2 * b * b));
}

static double phong_power(double alpha)
{
    return 0.5 * (1 / (alpha * alpha) + 1);
}

static double phong(double q, double alpha)
{
    return exp(phong_power(alpha) * log1p(-0.5 * q));
}

static double phong_integral(double alpha)
{
    return 2 * PI / (phong_power(alpha) + 1);
}

static double charlie(double q, double alpha)
{
    return pow(0.25 * q, 0.5 / alpha) * (1 - 0.5 * q);
}

/* 4 pi times the integral over s = 0..1/2 of s^e (1 - 2 s). */
static double charlie_integral(double alpha)
{
    const double e = 0.5 / alpha;
    return 4 * PI * pow(0.5, e + 1) * (1 / (e + 1) - 1 / (e + 2));
}

static const lobe lobes[] = {{"ggx", ggx, ggx_integral, 0.003},
                             {"ggx", ggx, ggx_integral, 0.04},
                             {"ggx", ggx, ggx_integral, 0.3},
                             {"ggx", ggx, ggx_integral, 0.9},
                             {"ggx", ggx, ggx_integral, 1},
                             {"phong", phong, phong_integral, 0.003},
                             {"phong", phong, phong_integral, 0.04},
                             {"phong", phong, phong_integral, 0.3},
                             {"phong", phong, phong_integral, 0.8},
                             {"phong", phong, phong_integral, 0.97},
                             {"phong", phong, phong_integral, 1},
                             {"charlie", charlie, charlie_integral, 0.04},
                             {"charlie", charlie, charlie_integral, 0.3},
                             {"charlie", charlie, charlie_integral, 0.6},
                             {"charlie", charlie, charlie_integral, 1}};

enum {
    LOBES = sizeof lobes / sizeof lobes[0]
};

static double truth(const lobe *l, double q)
{
    return q < 2 ? l->weight(q, l->alpha) / l->integral(l->alpha) : 0;
}

static double by_chord(double chord, const void *arg)
{
    const lobe *l = arg;
    return chord * chord < 2 ? l->weight(chord * chord, l->alpha) : 0;
}

/* The lobe by table or, GGX alone, by formula. */
static ibl_status make(ibl_ctx *ctx, const lobe *l, bool table, ibl_radial *out)
{
    if (table)
        return ibl_radial_table(ctx, by_chord, l, out);
    ibl_radial_ggx(l->alpha, out);
    return IBL_OK;
}

/* ---- values ------------------------------------------------------------ */

/* K at 16 chords. */
static void evaluate(const ibl_radial_dsp *dsp, const ibl_radial *radial,
                     const float chord[16], float k[16])
{
    const ibl_radial_light light = {.rgb = {1, 1, 1, 1}};
    float point[6 * 16] = {0}, rgba[4 * 16] = {0};
    memcpy(point, chord, 16 * sizeof *chord);
    dsp->add(radial, &light, 1, point, 16, rgba);
    for (int i = 0; i < 16; i++)
        k[i] = rgba[4 * i + 1];
}

/*
 * 2e-6 of the value, of 1e-8 of the peak where it is less (and 3e-8 of the
 * peak where a lobe ends in a fractional power); and what a rounding of q
 * alone makes of it, an epsilon at the horizon.
 */
static double worst_of(const ibl_radial_dsp *dsp, const lobe *l,
                       const ibl_radial *radial, double peak)
{
    test_random r = {3};
    double worst = 0;
    for (int round = 0; round < 2000; round++) {
        float chord[16], k[16];
        for (int i = 0; i < 16; i++) {
            const double x = pow(10, -6 * test_random_unit(&r));
            chord[i] = (float)sqrt(round % 2 ? 2 * x : 2 - 2 * x);
        }
        evaluate(dsp, radial, chord, k);
        for (int i = 0; i < 16; i++) {
            const double q = (double)chord[i] * (double)chord[i];
            const double want = truth(l, q);
            const double step =
                truth(l, q * (1 - 1e-7)) - truth(l, q * (1 + 1e-7));
            const double limit = 2e-6 * fmax(want, 1e-8 * peak) + fabs(step) +
                                 (want < 2e-6 * peak ? 4e-8 * peak : 0);
            const double e = fabs((double)k[i] - want) / limit;
            worst = e > worst || isnan(e) ? e : worst;
        }
    }
    return worst;
}

static double peak_of(const lobe *l)
{
    double peak = 0;
    for (int i = 0; i <= 1000; i++)
        peak = fmax(peak, truth(l, 2e-3 * i));
    return peak;
}

static void check_values(ibl_isa isa)
{
    ibl_ctx *ctx = test_ctx(1, isa);
    ibl_radial_dsp dsp;
    ibl_radial_dsp_init(&dsp, isa);
    for (int i = 0; i < 2 * LOBES; i++) {
        const lobe *l = &lobes[i / 2];
        ibl_radial radial;
        if (i % 2 == 0 && strcmp(l->name, "ggx"))
            continue;
        NEED(!make(ctx, l, i % 2, &radial));
        const double worst = worst_of(&dsp, l, &radial, peak_of(l));
        CHECK_MSG(worst <= 1, "%s: %s %g, %s: %.2f times the limit",
                  ibl_isa_name(isa), l->name, l->alpha,
                  i % 2 ? "table" : "formula", worst);
        ibl_radial_free(&radial);
    }
    ibl_ctx_free(ctx);
}

static void values(void)
{
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++)
        if (ibl_cpu_has(isa))
            check_values(isa);
}

/* The peak, to rounding: it is the integral that it tells of. */
static void peaks(void)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_radial_dsp dsp;
    ibl_radial_dsp_init(&dsp, ibl_ctx_isa(ctx));
    for (int i = 0; i < LOBES; i++) {
        const float zero[16] = {0};
        float k[16];
        ibl_radial radial;
        if (!strcmp(lobes[i].name, "charlie"))
            continue;
        for (int table = strcmp(lobes[i].name, "ggx") != 0; table < 2;
             table++) {
            NEED(!make(ctx, &lobes[i], table, &radial));
            evaluate(&dsp, &radial, zero, k);
            CHECK_NEAR((double)k[0] / truth(&lobes[i], 0), 1, 1e-6);
            ibl_radial_free(&radial);
        }
    }
    ibl_ctx_free(ctx);
}

/* Beyond the horizon nothing, exactly; before it what there is. */
static void horizon(void)
{
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
        if (!ibl_cpu_has(isa))
            continue;
        ibl_ctx *ctx = test_ctx(1, isa);
        ibl_radial_dsp dsp;
        ibl_radial_dsp_init(&dsp, isa);
        for (int i = 0; i < 2 * LOBES; i++) {
            ibl_radial radial;
            float chord[16], k[16];
            int bad = 0;
            if (i % 2 == 0 && strcmp(lobes[i / 2].name, "ggx"))
                continue;
            NEED(!make(ctx, &lobes[i / 2], i % 2, &radial));
            /* sqrt(2) is no float; the next one has a square above 2. */
            for (int n = 0; n < 16; n++)
                chord[n] = 1.41421366f + (n < 8 ? 1e-6f : 0.07f) * (float)n;
            chord[15] = 2;
            evaluate(&dsp, &radial, chord, k);
            for (int n = 0; n < 16; n++)
                bad += k[n] != 0;
            CHECK(!bad);
            chord[3] = 1.41f;
            evaluate(&dsp, &radial, chord, k);
            CHECK(strcmp(lobes[i / 2].name, "phong") ||
                  lobes[i / 2].alpha < 0.5 || k[3] > 0);
            CHECK(k[2] == 0 && k[4] == 0);
            ibl_radial_free(&radial);
        }
        ibl_ctx_free(ctx);
    }
}

static double nothing(double chord, const void *arg)
{
    (void)chord;
    (void)arg;
    return 0;
}

static void no_lobe(void)
{
    test_messages said = {0};
    ibl_radial radial;
    ibl_ctx *ctx = test_keeping_ctx(1, &said);
    CHECK(ibl_radial_table(ctx, nothing, NULL, &radial) == IBL_ERR_ARGUMENT);
    CHECK(!radial.coef && strstr(said.text[IBL_LOG_ERROR], "integral"));
    ibl_radial_free(&radial);
    ibl_radial_free(NULL);
    ibl_ctx_free(ctx);
}

/* ---- levels ------------------------------------------------------------ */

/* Some anywhere, some on texel centres, corners of the cube and poles. */
static void random_lights(ibl_light *lights, int count, int n)
{
    test_random r = {11};
    for (int i = 0; i < count; i++) {
        double *d = lights[i].direction;
        const double y = 2 * test_random_unit(&r) - 1, s = sqrt(1 - y * y);
        const double phi = 2 * PI * test_random_unit(&r);
        d[0] = s * cos(phi);
        d[1] = y;
        d[2] = s * sin(phi);
        if (i % 4 == 0)
            truth_cube_direction(n, i / 4 % 6, i % n, i * 7 % n, d);
        if (i == 1)
            d[0] = d[1] = d[2] = sqrt(1 / 3.0);
        if (i == 2) {
            d[0] = d[2] = 0;
            d[1] = -1;
        }
        for (int c = 0; c < 3; c++)
            lights[i].energy[c] = (float)pow(10, 6 * test_random_unit(&r) - 3);
    }
}

/* Largest error of a level of lights, in parts of its limit: 3e-6 of the sum,
 * what two roundings of the distances make of it, and 1e-12 of the peak. */
static double level_error(ibl_ctx *ctx, const lobe *l, bool table, int n,
                          int count)
{
    ibl_light *lights = malloc((size_t)(count + 1) * sizeof *lights);
    ibl_bright *bright = NULL;
    ibl_radial radial = {0};
    ibl_ring_grid grid = {0};
    ibl_cube cube = {0};
    double worst = 0;
    if (!lights || ibl_cube_alloc(ctx, n, 1, &cube) ||
        ibl_ring_grid_alloc(ctx, 8, 16, &grid))
        return INFINITY;
    memset(grid.data, 0, grid.room * sizeof *grid.data);
    random_lights(lights, count, n);
    const ibl_level_sum sum = {.grid = &grid,
                               .degree = 2,
                               .lobe = &radial,
                               .gain = 1,
                               .low = {-1, -1, -1},
                               .high = {INFINITY, INFINITY, INFINITY}};
    ibl_level_sum with = sum;
    if (ibl_bright_create(ctx, lights, NULL, count, INFINITY, &bright) ||
        make(ctx, l, table, &radial))
        return INFINITY;
    with.bright = bright;
    if (ibl_spectral_texels(ctx, NULL, &with, &cube, 0))
        return INFINITY;
    for (int i = 0; i < 6 * n * n; i++) {
        double d[3], want = 0, limit = 1e-12 * truth(l, 0);
        truth_cube_direction(n, i / (n * n), i % n, i / n % n, d);
        for (int k = 0; k < count; k++) {
            const double energy = (double)lights[k].energy[1];
            double q = 0;
            for (int c = 0; c < 3; c++)
                q += pow(d[c] - lights[k].direction[c], 2);
            want += energy * truth(l, q);
            limit += energy *
                     fabs(truth(l, q * (1 - 2e-7)) - truth(l, q * (1 + 2e-7)));
        }
        limit += 3e-6 * want;
        const double e = fabs((double)cube.data[3 * i + 1] - want) / limit;
        worst = e > worst || isnan(e) ? e : worst;
    }
    ibl_bright_free(bright);
    ibl_radial_free(&radial);
    ibl_ring_grid_free(&grid);
    ibl_cube_free(&cube);
    free(lights);
    return worst;
}

static void levels(void)
{
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
        if (!ibl_cpu_has(isa))
            continue;
        ibl_ctx *ctx = test_ctx(2, isa);
        for (int i = 0; i < LOBES; i++) {
            if (!strcmp(lobes[i].name, "charlie"))
                continue;
            const bool table = strcmp(lobes[i].name, "ggx") != 0;
            const int n = 1 + 5 * i;
            const double e = level_error(ctx, &lobes[i], table, n, 12);
            CHECK_MSG(e <= 1, "%s: %s %g, edge %d: %.2f times the limit",
                      ibl_isa_name(isa), lobes[i].name, lobes[i].alpha, n, e);
        }
        ibl_ctx_free(ctx);
    }
}

static void many_lights(void)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    CHECK(level_error(ctx, &lobes[1], false, 20, 1024) <= 1);
    CHECK(level_error(ctx, &lobes[2], true, 9, 1024) <= 1);
    CHECK(level_error(ctx, &lobes[2], false, 7, 0) <= 0);
    CHECK(level_error(ctx, &lobes[2], false, 40, 1) <= 1);
    ibl_ctx_free(ctx);
}

/* The integral over the sphere: a light seen by all of a level. */
static void energy(void)
{
    const ibl_light light = {{0.6, -0.48, 0.64}, {1, 2, 4}};
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_bright *bright;
    ibl_ring_grid grid = {0};
    ibl_cube cube;
    ibl_radial radial;
    NEED(!ibl_cube_alloc(ctx, 64, 1, &cube));
    NEED(!ibl_ring_grid_alloc(ctx, 8, 16, &grid));
    NEED(!ibl_bright_create(ctx, &light, NULL, 1, INFINITY, &bright));
    memset(grid.data, 0, grid.room * sizeof *grid.data);
    for (int i = 2; i < LOBES; i++) {
        double sum[3] = {0};
        if (lobes[i].alpha < 0.3)
            continue;
        NEED(!ibl_radial_table(ctx, by_chord, &lobes[i], &radial));
        const ibl_level_sum level = {.grid = &grid,
                                     .bright = bright,
                                     .lobe = &radial,
                                     .gain = 1,
                                     .high = {INFINITY, INFINITY, INFINITY}};
        CHECK(!ibl_spectral_texels(ctx, NULL, &level, &cube, 0));
        for (int t = 0; t < 6 * 64 * 64; t++)
            for (int c = 0; c < 3; c++)
                sum[c] += (double)cube.data[3 * t + c] *
                          ibl_cube_solid_angle(64, t % 64, t / 64 % 64);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(sum[c], ldexp(1, c), 1e-3 * ldexp(1, c));
        ibl_radial_free(&radial);
    }
    ibl_bright_free(bright);
    ibl_ring_grid_free(&grid);
    ibl_cube_free(&cube);
    ibl_ctx_free(ctx);
}

static const test tests[] = {TEST(values),  TEST(peaks),  TEST(horizon),
                             TEST(no_lobe), TEST(levels), TEST(many_lights),
                             TEST(energy)};
TEST_MAIN(tests)
