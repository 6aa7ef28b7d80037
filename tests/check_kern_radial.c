/* SPDX-License-Identifier: MIT */
/*
 * The kernels of point lights: points against the cube rule, sums of the
 * vector versions against the plain one (which check_bright compares with the
 * lobes themselves).
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "bake/spectral/lobe_table.h"
#include "core/cpu.h"
#include "kern/radial.h"
#include "test.h"

enum {
    BLOCKS = 3,
    MAX = BLOCKS * IBL_RADIAL_BLOCK,
    GUARD = 16,
    LIGHTS = 9
};

static const float guard = 12345.0f;

static void check_points(const ibl_radial_dsp *dsp, int size, int first,
                         int stride)
{
    float point[6 * MAX + GUARD];
    int bad = 0;
    for (int y = 0; y < size; y++) {
        const double v = (2 * y + 1) / (double)size - 1;
        for (int i = 0; i < 6 * MAX + GUARD; i++)
            point[i] = guard;
        dsp->points(v, size, first, stride, point);
        for (int i = 0; i < stride; i++) {
            const double u = (2 * (first + i) + 1) / (double)size - 1;
            const double d[3] = {1, u, v};
            for (int k = 0; k < 3; k++) {
                const double want = d[k] / sqrt(1 + u * u + v * v);
                const float *at = point + k * stride + i;
                bad += !(fabs((double)at[0] + (double)at[3 * stride] - want) <=
                         1e-14 * fabs(want) + 1e-17);
                bad += at[0] != (float)want && first + i < size;
            }
        }
        for (int i = 6 * stride; i < 6 * MAX + GUARD; i++)
            bad += point[i] != guard;
    }
    CHECK_MSG(!bad, "edge %d, first %d, %d: %d differences", size, first,
              stride, bad);
}

static void points(void)
{
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
        ibl_radial_dsp dsp;
        if (!ibl_cpu_has(isa))
            continue;
        ibl_radial_dsp_init(&dsp, isa);
        for (int blocks = 1; blocks <= BLOCKS; blocks++) {
            check_points(&dsp, 1, 0, blocks * IBL_RADIAL_BLOCK);
            check_points(&dsp, 16 * blocks, 0, blocks * IBL_RADIAL_BLOCK);
            check_points(&dsp, 64, 16, blocks * IBL_RADIAL_BLOCK);
            check_points(&dsp, 100, 37, blocks * IBL_RADIAL_BLOCK);
        }
    }
}

static double ring_lobe(double chord, const void *arg)
{
    (void)arg;
    return chord < 1.2 ? chord * (1.2 - chord) : 0;
}

/* Which ends at the horizon and nowhere else. */
static double flat_lobe(double chord, const void *arg)
{
    (void)chord;
    (void)arg;
    return 1;
}

/* Points anywhere, some of them lights' own places and beyond all horizons. */
static void random_scene(uint64_t seed, float point[6 * MAX],
                         ibl_radial_light lights[LIGHTS])
{
    test_random r = {seed};
    for (int i = 0; i < 6 * MAX; i++)
        point[i] =
            (float)((2 * test_random_unit(&r) - 1) * (i < 3 * MAX ? 1 : 1e-8));
    for (int l = 0; l < LIGHTS; l++) {
        for (int k = 0; k < 3; k++) {
            lights[l].at[k] = (float)(2 * test_random_unit(&r) - 1);
            lights[l].rest[k] = (float)(1e-8 * test_random_unit(&r));
            lights[l].rgb[k] = (float)pow(10, 8 * test_random_unit(&r) - 4);
        }
        lights[l].rgb[3] = NAN;
        for (int k = 0; k < 3; k++) {
            point[k * MAX + 5 * l] = lights[l].at[k];
            point[(k + 3) * MAX + 5 * l] = lights[l].rest[k];
        }
    }
    for (int i = 16; i < 32 && seed % 2; i++)
        point[i] = 9;
}

/* Roundings of q cost a lobe no more than a few of themselves, but near the
 * horizon: there what they do to 1 - q/2 counts. `steep` is how much K falls
 * by there. */
static void compare(ibl_isa isa, const ibl_radial *lobe, double steep,
                    int count, uint64_t seed)
{
    ibl_radial_dsp plain, dsp;
    ibl_radial_light lights[LIGHTS];
    float point[6 * MAX], want[4 * MAX + GUARD], got[4 * MAX + GUARD];
    double worst = 0, slack[3] = {1e-30, 1e-30, 1e-30};
    random_scene(seed, point, lights);
    for (int l = 0; l < count; l++)
        for (int c = 0; c < 3; c++)
            slack[c] += 1e-6 * steep * (double)lights[l].rgb[c];
    for (int i = 0; i < 4 * MAX + GUARD; i++)
        want[i] = got[i] = guard;
    for (int i = 0; i < 4 * MAX; i++)
        want[i] = got[i] = i % 4 == 3 ? guard : 0;
    ibl_radial_dsp_init(&plain, IBL_ISA_C);
    ibl_radial_dsp_init(&dsp, isa);
    plain.add(lobe, lights, count, point, MAX, want);
    dsp.add(lobe, lights, count, point, MAX, got);
    for (int i = 0; i < 4 * MAX + GUARD; i++) {
        if (i % 4 == 3 || i >= 4 * MAX) {
            CHECK(got[i] == guard);
            continue;
        }
        const double w = (double)want[i];
        const double e = fabs((double)got[i] - w) / (3e-6 * w + slack[i % 4]);
        worst = e > worst || isnan(e) ? e : worst;
    }
    CHECK_MSG(worst <= 1, "%s, %d lights, seed %d: %.2f", ibl_isa_name(isa),
              count, (int)seed, worst);
}

static void sums(void)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_C);
    ibl_radial ggx[2], table, flat;
    for (int n = 0; n < 2; n++) {
        const ibl_lobe_shape shape =
            ibl_lobe_shape_of(IBL_LOBE_GGX, n ? 1 : 0.01);
        NEED(!ibl_radial_make(ctx, &shape, &ggx[n]));
    }
    NEED(!ibl_radial_table(ctx, ring_lobe, NULL, &table));
    NEED(!ibl_radial_table(ctx, flat_lobe, NULL, &flat));
    for (ibl_isa isa = IBL_ISA_C; isa <= IBL_ISA_AVX512; isa++) {
        for (int k = 0; ibl_cpu_has(isa) && k < 40; k++) {
            for (int n = 0; n < 2; n++) {
                const double t = 1 + (double)ggx[n].slope;
                compare(isa, &ggx[n], (double)ggx[n].peak / (t * t),
                        k % (LIGHTS + 1), (uint64_t)k);
            }
            compare(isa, &table, 1, k % (LIGHTS + 1), (uint64_t)k);
            compare(isa, &flat, 1, k % (LIGHTS + 1), (uint64_t)k);
        }
    }
    ibl_radial_free(&table);
    ibl_radial_free(&flat);
    ibl_ctx_free(ctx);
}

static const test tests[] = {TEST(points), TEST(sums)};
TEST_MAIN(tests)
