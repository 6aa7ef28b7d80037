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

#include "bake/spectral/lobe_table.h"
#include "bake/spectral/point_lights.h"
#include "bake/spectral/resample.h"
#include "test.h"
#include "truth.h"

#define PI 3.14159265358979323846

/* ---- lobes -------------------------------------------------------------- */

typedef struct lobe {
    ibl_lobe of;
    double alpha;
} lobe;

static const lobe lobes[] = {
    {IBL_LOBE_GGX, 0.003},   {IBL_LOBE_GGX, 0.04},    {IBL_LOBE_GGX, 0.3},
    {IBL_LOBE_GGX, 0.9},     {IBL_LOBE_GGX, 1},       {IBL_LOBE_PHONG, 0.003},
    {IBL_LOBE_PHONG, 0.04},  {IBL_LOBE_PHONG, 0.3},   {IBL_LOBE_PHONG, 0.8},
    {IBL_LOBE_PHONG, 0.97},  {IBL_LOBE_PHONG, 1},     {IBL_LOBE_CHARLIE, 0.04},
    {IBL_LOBE_CHARLIE, 0.3}, {IBL_LOBE_CHARLIE, 0.6}, {IBL_LOBE_CHARLIE, 1}};

enum {
    LOBES = sizeof lobes / sizeof lobes[0]
};

/* By the square of the chord. */
static double truth(const lobe *l, double q)
{
    return truth_lobe_weight(l->of, l->alpha, q / 4) /
           truth_lobe_integral(l->of, l->alpha);
}

static double by_chord(double chord, const void *arg)
{
    const lobe *l = arg;
    return truth(l, chord * chord);
}

/* The lobe by its table or, GGX, by its formula. */
static ibl_status make(ibl_ctx *ctx, const lobe *l, bool table, ibl_radial *out)
{
    const ibl_lobe_shape shape = ibl_lobe_shape_of(l->of, l->alpha);
    return table ? ibl_radial_table(ctx, by_chord, l, out)
                 : ibl_radial_make(ctx, &shape, out);
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
        NEED(!make(ctx, l, i % 2, &radial));
        const double worst = worst_of(&dsp, l, &radial, peak_of(l));
        CHECK_MSG(worst <= 1, "%s: %s %g, %s: %.2f times the limit",
                  ibl_isa_name(isa), ibl_lobe_name(l->of), l->alpha,
                  i % 2 ? "table" : "shape", worst);
        ibl_radial_free(&radial);
    }
}

TEST(values)
{
    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT; isa = test_next_isa(isa))
        check_values(isa);
}

/* The peak, to rounding: it is the integral that it tells of. */
TEST(peaks)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_radial_dsp dsp;
    ibl_radial_dsp_init(&dsp, ibl_ctx_isa(ctx));
    for (int i = 0; i < LOBES; i++) {
        const float zero[16] = {0};
        float k[16];
        ibl_radial radial;
        if (lobes[i].of == IBL_LOBE_CHARLIE)
            continue;
        for (int table = 0; table < 2; table++) {
            NEED(!make(ctx, &lobes[i], table, &radial));
            evaluate(&dsp, &radial, zero, k);
            CHECK_NEAR((double)k[0] / truth(&lobes[i], 0), 1, 1e-6);
            ibl_radial_free(&radial);
        }
    }
}

/* Beyond the horizon nothing, exactly; before it what there is. */
TEST(horizon)
{
    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
         isa = test_next_isa(isa)) {
        ibl_ctx *ctx = test_ctx(1, isa);
        ibl_radial_dsp dsp;
        ibl_radial_dsp_init(&dsp, isa);
        for (int i = 0; i < 2 * LOBES; i++) {
            ibl_radial radial;
            float chord[16], k[16];
            int bad = 0;
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
            CHECK(lobes[i / 2].of != IBL_LOBE_PHONG ||
                  lobes[i / 2].alpha < 0.5 || k[3] > 0);
            CHECK(k[2] == 0 && k[4] == 0);
            ibl_radial_free(&radial);
        }
    }
}

/* ---- levels ------------------------------------------------------------ */

/* A patch so small that it is a point, with so much light. */
static ibl_patch point_at(const double d[3], const float energy[3])
{
    const double size = 1e-9;
    const double theta =
        fmin(fmax(atan2(hypot(d[0], d[2]), d[1]), size), PI - size);
    const double sine = fmax(sin(theta), size);
    ibl_patch p = {.theta = {theta - size / 2, theta + size / 2},
                   .phi = atan2(d[2], d[0]),
                   .width = size / sine};
    for (int c = 0; c < 3; c++)
        p.rgb[c] = energy[c] / (float)ibl_patch_angle(&p);
    return p;
}

/* Some anywhere, some on texel centres, corners of the cube and poles. */
static void random_lights(ibl_patch_light *lights, int count, int n)
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
            lights[i].rgb[c] = pow(10, 6 * test_random_unit(&r) - 3);
    }
}

/* Nothing but lights, on faces of n x n. */
static ibl_status light_level(ibl_ctx *ctx, const ibl_point_lights *bright,
                              int n, ibl_cube *cube)
{
    ibl_ring_grid grid = {0};
    ibl_status status = ibl_cube_alloc(ctx, n, 1, cube);
    if (!status)
        status = ibl_ring_grid_alloc(ctx, 8, 16, &grid);
    if (!status)
        memset(grid.data, 0,
               (8 + 2 * IBL_GRID_BORDER) * grid.stride * sizeof *grid.data);
    const ibl_level_sum sum = {.grid = &grid,
                               .degree = 2,
                               .bright = bright,
                               .range.gain = 1,
                               .range.low = {-1, -1, -1},
                               .range.high = {INFINITY, INFINITY, INFINITY}};
    if (!status)
        status = ibl_spectral_texels(ctx, NULL, &sum, cube, 0);
    ibl_ring_grid_free(&grid);
    return status;
}

/* Largest error of a level of lights, in parts of its limit: 3e-6 of the sum,
 * what two roundings of the distances make of it, and 1e-12 of the peak. */
static double level_error(ibl_ctx *ctx, const lobe *l, int n, int count)
{
    const ibl_lobe_shape shape = ibl_lobe_shape_of(l->of, l->alpha);
    ibl_patch_light *lights = test_alloc((size_t)(count + 1), sizeof *lights);
    ibl_patch *patches = test_alloc((size_t)(count + 1), sizeof *patches);
    ibl_point_lights *bright = NULL;
    ibl_cube cube = {0};
    double worst = 0;
    random_lights(lights, count, n);
    for (int i = 0; i < count; i++) {
        float energy[3];
        for (int c = 0; c < 3; c++)
            energy[c] = (float)lights[i].rgb[c];
        patches[i] = point_at(lights[i].direction, energy);
    }
    if (ibl_point_lights_create(ctx, patches, count, &shape, 1e-7, 0,
                                &bright) ||
        light_level(ctx, bright, n, &cube))
        return INFINITY;
    for (int i = 0; i < 6 * n * n; i++) {
        double d[3], want = 0, limit = 1e-12 * truth(l, 0);
        truth_cube_direction(n, i / (n * n), i % n, i / n % n, d);
        for (int k = 0; k < count; k++) {
            const double energy = lights[k].rgb[1];
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
    ibl_point_lights_free(bright);
    ibl_cube_free(&cube);
    return worst;
}

TEST(levels)
{
    for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
         isa = test_next_isa(isa)) {
        ibl_ctx *ctx = test_ctx(2, isa);
        for (int i = 0; i < LOBES; i++) {
            if (lobes[i].of == IBL_LOBE_CHARLIE)
                continue;
            const int n = 1 + 5 * i;
            const double e = level_error(ctx, &lobes[i], n, 12);
            CHECK_MSG(e <= 1, "%s: %s %g, edge %d: %.2f times the limit",
                      ibl_isa_name(isa), ibl_lobe_name(lobes[i].of),
                      lobes[i].alpha, n, e);
        }
    }
}

TEST(many_lights)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    CHECK(level_error(ctx, &lobes[1], 20, 1024) <= 1);
    CHECK(level_error(ctx, &lobes[2], 7, 0) <= 0);
    CHECK(level_error(ctx, &lobes[2], 40, 1) <= 1);
}

/* ---- suns --------------------------------------------------------------- */

enum {
    SIDE = 4,
    CUT = 12 /* parts of a pixel's side */
};

/* A disc of pixels of a map 512 wide, around a direction, of many a
 * brightness; returns how many. */
static int make_sun(double theta, double phi, ibl_patch *out)
{
    const double size = PI / 256;
    const int row = (int)(theta / size), column = (int)(phi / size);
    int count = 0;
    for (int j = row - SIDE; j <= row + SIDE; j++)
        for (int i = 0; j >= 0 && j < 256 && i < 512; i++) {
            const double at = (j + 0.5) * size, to = (i + 0.5) * size;
            const double cosine =
                cos(theta) * cos(at) + sin(theta) * sin(at) * cos(phi - to);
            const double distance = acos(fmin(cosine, 1)) / size;
            const float bright = (float)(1 + (i + column) % 3 + j % 2);
            if (distance < SIDE)
                out[count++] = (ibl_patch){.theta = {j * size, (j + 1) * size},
                                           .phi = to,
                                           .width = size,
                                           .rgb = {bright, 1, 2}};
        }
    return count;
}

/* By many parts of each pixel, those below the horizon left out. */
static double sun_truth(const lobe *l, const ibl_patch *patches, int count,
                        const double d[3])
{
    double sum = 0;
    for (int i = 0; i < count * CUT; i++) {
        const ibl_patch *p = &patches[i / CUT];
        const double height = (p->theta[1] - p->theta[0]) / CUT;
        const double theta = p->theta[0] + (i % CUT + 0.5) * height;
        const int parts = 1 + (int)(CUT * sin(theta));
        for (int k = 0; k < parts; k++) {
            const double phi = p->phi + p->width * ((k + 0.5) / parts - 0.5);
            const double cosine = d[1] * cos(theta) +
                                  d[0] * sin(theta) * cos(phi) +
                                  d[2] * sin(theta) * sin(phi);
            sum += truth(l, 2 - 2 * cosine) * (double)p->rgb[0] * sin(theta) *
                   2 * sin(height / 2) * p->width / parts;
        }
    }
    return sum;
}

/* Suns anywhere, on a pole, and on both sides of the seam: what stands for
 * their pixels is as good as they are, near, far and on the horizon. */
TEST_SLOW(suns)
{
    const double at[][2] = {{1.1, 2}, {0.001, 0}, {0.9, 0}, {3.1, 4}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    for (int s = 0; s < 4; s++)
        for (int k = 0; k < 5; k++) {
            static const int of[] = {1, 2, 4, 7, 10};
            static ibl_patch patches[4096];
            const lobe *l = &lobes[of[k]];
            const ibl_lobe_shape shape = ibl_lobe_shape_of(l->of, l->alpha);
            const int count = make_sun(at[s][0], at[s][1], patches), n = 16;
            ibl_point_lights *bright;
            ibl_cube cube;
            double worst = 0, most = 0;
            NEED(!ibl_point_lights_create(ctx, patches, count, &shape, 2e-5, 0,
                                          &bright));
            NEED(!light_level(ctx, bright, n, &cube));
            for (int i = 0; i < 6 * n * n; i += 5)
                most = fmax(most, (double)cube.data[3 * i]);
            for (int i = 0; i < 6 * n * n; i += 5) {
                double d[3];
                truth_cube_direction(n, i / (n * n), i % n, i / n % n, d);
                const double want = sun_truth(l, patches, count, d);
                const double e = fabs((double)cube.data[3 * i] - want) /
                                 (4e-5 * want + 5e-6 * most);
                worst = e > worst || isnan(e) ? e : worst;
            }
            CHECK_MSG(worst <= 1,
                      "sun %d, %s %g: %d pixels, %d points, %.2f "
                      "times the limit",
                      s, ibl_lobe_name(l->of), l->alpha, count,
                      ibl_point_lights_count(bright), worst);
            ibl_point_lights_free(bright);
            ibl_cube_free(&cube);
        }
}
