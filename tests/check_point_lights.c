/* SPDX-License-Identifier: MIT */
/*
 * Bright pixels seen through lobes, against integrals over the pixels in
 * double, which are cut at the horizon.
 */
#include <math.h>
#include <stdlib.h>

#include "bake/spectral/point_lights.h"
#include "reference.h"
#include "truth.h"

enum {
    BLOCK = IBL_RADIAL_BLOCK
};

typedef struct lobe {
    ibl_lobe of;
    double alpha;
} lobe;

static const lobe lobes[] = {
    {IBL_LOBE_GGX, 0.003},   {IBL_LOBE_GGX, 0.04},    {IBL_LOBE_GGX, 0.3},
    {IBL_LOBE_GGX, 0.9},     {IBL_LOBE_GGX, 1},       {IBL_LOBE_PHONG, 0.01},
    {IBL_LOBE_PHONG, 0.04},  {IBL_LOBE_PHONG, 0.3},   {IBL_LOBE_PHONG, 0.97},
    {IBL_LOBE_PHONG, 1},     {IBL_LOBE_CHARLIE, 0.1}, {IBL_LOBE_CHARLIE, 0.3},
    {IBL_LOBE_CHARLIE, 0.6}, {IBL_LOBE_CHARLIE, 1}};

enum {
    LOBES = sizeof lobes / sizeof lobes[0]
};

/* ---- pixels ------------------------------------------------------------- */

/* Of a map of height rows and twice as many columns. */
typedef struct pixel {
    int height, row, column;
} pixel;

static ibl_patch patch_of(const pixel *p)
{
    const double size = M_PI / p->height;
    return (ibl_patch){.theta = {size * p->row, size * (p->row + 1)},
                       .phi = size * (p->column + 0.5) - M_PI,
                       .width = size,
                       .rgb = {3, 1, 0}};
}

enum where {
    NEAR,    /* three radii of the pixel */
    LOBE,    /* two widths of the lobe */
    AT_ONCE, /* the horizon crosses the pixel, */
    HORIZON, /* or some texels of a block are beyond it */
    FAR,
    POLE,
    PLACES
};

/* Texels of a block, and as floats with what they lack. */
static void place(test_random *r, const lobe *l, const ibl_patch *p,
                  enum where at, double d[BLOCK][3], float point[6 * BLOCK])
{
    static const double pole[3] = {0, 1, 0};
    const double middle = 0.5 * (p->theta[0] + p->theta[1]);
    const double size = p->theta[1] - p->theta[0];
    double sun[3], base[3];
    polar_direction(middle, p->phi, sun);
    const double x = test_random_unit(r);
    const double spread = (r->state % 3 ? 0.3 : 3) * size;
    const double angle[PLACES] = {2 * x * size,
                                  2 * x * l->alpha,
                                  M_PI / 2 + (x - 0.5) * size,
                                  M_PI / 2 + (x - 0.5) * 4 * size,
                                  x * M_PI / 2,
                                  x * size};
    random_view(r, at == POLE ? pole : sun, cos(angle[at]), base);
    for (int i = 0; i < BLOCK; i++)
        random_view(
            r, base,
            cos(at == AT_ONCE ? 0.1 * size : spread * test_random_unit(r)),
            d[i]);
    for (int i = 0; i < 3 * BLOCK; i++) {
        const double exact = d[i % BLOCK][i / BLOCK];
        point[i] = (float)exact;
        point[3 * BLOCK + i] = (float)(exact - (double)point[i]);
    }
}

static int larger(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? 1 : x > y ? -1 : 0;
}

enum {
    ROUNDS = 3,
    TEXELS = ROUNDS * BLOCK
};

/* Relative errors, the largest first, of the worst instruction set. */
static void errors_of(const lobe *l, const pixel *p, enum where at,
                      double error[TEXELS])
{
    const ibl_lobe_shape shape = ibl_lobe_shape_of(l->of, l->alpha);
    const ibl_patch patch = patch_of(p);
    const double whole =
        truth_latlong_solid_angle(2 * p->height, p->height, p->row);
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_point_lights *lights;
    test_random r = {5};

    NEED(!ibl_point_lights_create(ctx, &patch, 1, &shape, 1e-5, &lights));
    for (int n = 0; n < TEXELS; n += BLOCK) {
        float point[6 * BLOCK];
        double d[BLOCK][3], want[BLOCK];
        place(&r, l, &patch, at, d, point);
        for (int i = 0; i < BLOCK; i++) {
            error[n + i] = 0;
            want[i] = truth_pixel_weight(2 * p->height, p->height, p->column,
                                         p->row, d[i], l->of, sqrt(l->alpha)) /
                      truth_lobe_integral(l->of, l->alpha);
        }
        for (ibl_isa isa = IBL_ISA_C; isa < IBL_ISA_COUNT;
             isa = test_next_isa(isa)) {
            float rgba[4 * BLOCK] = {0};
            ibl_radial_dsp dsp;
            ibl_radial_dsp_init(&dsp, isa);
            ibl_point_lights_add(lights, &dsp, point, BLOCK, rgba);
            for (int i = 0; i < BLOCK; i++) {
                const double off = fabs((double)rgba[4 * i + 1] - want[i]);
                CHECK(rgba[4 * i + 2] == 0 && rgba[4 * i + 3] == 0);
                error[n + i] =
                    fmax(error[n + i], off / fmax(want[i], whole / (4 * M_PI)));
            }
        }
    }
    ibl_point_lights_free(lights);
    qsort(error, TEXELS, sizeof *error, larger);
}

/* Near the poles, on both sides of the seam, and anywhere. */
TEST(pixels)
{
    static const pixel pixels[] = {
        {32, 0, 5},    {32, 31, 40},    {32, 16, 0},   {32, 9, 63},
        {512, 0, 700}, {512, 511, 3},   {512, 1, 0},   {512, 255, 1023},
        {512, 100, 0}, {512, 201, 317}, {512, 30, 800}};
    static const char *const names[] = {"near",    "in the lobe", "crossed",
                                        "horizon", "far",         "pole"};
    for (int i = 0; i < LOBES; i++)
        for (size_t k = 0; k < sizeof pixels / sizeof *pixels; k++)
            for (int at = 0; at < PLACES; at++) {
                const lobe *l = &lobes[i];
                const pixel *p = &pixels[k];
                double error[TEXELS];
                errors_of(l, p, (enum where)at, error);
                /* The middle of Charlie bends. */
                const bool bent = l->of == IBL_LOBE_CHARLIE;
                CHECK_MSG(error[TEXELS / 20] <= (bent ? 2e-3 : 7e-5) &&
                              error[0] <= (bent ? 3e-3 : 1e-4),
                          "%s %g, pixel %d, %d of %d rows, %s: 95th %.2e, "
                          "worst %.2e",
                          ibl_lobe_name(l->of), l->alpha, p->column, p->row,
                          p->height, names[at], error[TEXELS / 20], error[0]);
            }
}

/* Many at once give the sum of each. */
TEST(groups)
{
    enum {
        SIDE = 6,
        LIGHTS = SIDE * SIDE + 2
    };
    static const lobe ggx = {.of = IBL_LOBE_GGX, .alpha = 0.3};
    const ibl_lobe_shape shape = ibl_lobe_shape_of(ggx.of, ggx.alpha);
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_point_lights *all, *one[LIGHTS];
    ibl_patch patches[LIGHTS];
    test_random r = {5};
    ibl_radial_dsp dsp;

    ibl_radial_dsp_init(&dsp, ibl_ctx_isa(ctx));
    for (int i = 0; i < LIGHTS; i++) {
        const pixel p = {256, i < LIGHTS - 2 ? 90 + i / SIDE : 3 * i,
                         200 + i % SIDE};
        patches[i] = patch_of(&p);
        NEED(!ibl_point_lights_create(ctx, &patches[i], 1, &shape, 1e-5,
                                      &one[i]));
    }
    NEED(!ibl_point_lights_create(ctx, patches, LIGHTS, &shape, 1e-5, &all));
    for (int n = 0; n < LIGHTS * PLACES; n++) {
        float point[6 * BLOCK], got[4 * BLOCK] = {0}, sum[4 * BLOCK] = {0};
        double d[BLOCK][3];
        place(&r, &ggx, &patches[n % LIGHTS], (enum where)(n / LIGHTS), d,
              point);
        ibl_point_lights_add(all, &dsp, point, BLOCK, got);
        for (int i = 0; i < LIGHTS; i++)
            ibl_point_lights_add(one[i], &dsp, point, BLOCK, sum);
        for (int i = 0; i < 4 * BLOCK; i++)
            CHECK_NEAR((double)got[i], (double)sum[i],
                       3e-5 * (double)sum[i] + 1e-12);
    }
    for (int i = 0; i < LIGHTS; i++)
        ibl_point_lights_free(one[i]);
    ibl_point_lights_free(all);
}
