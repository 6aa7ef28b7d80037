/* SPDX-License-Identifier: MIT */
/* Sets of the viewer: read from what iblbake writes, and baked here. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "files.h"
#include "maps.h"
#include "reference.h"
#include "sets.h"
#include "test.h"
#include "truth.h"
#include "view.h"
#include "view/baked_set.h"

/* Floats of level 0. */
static float *decode(const ibl_texture *tex)
{
    const size_t n = (size_t)tex->faces * tex->width * tex->height;
    float *rgb = test_alloc(3 * n, sizeof *rgb);

    ibl_pixel_decode(tex->pixel, tex->data, n, rgb);
    return rgb;
}

/* ---- roughness ------------------------------------------------------- */

static void check_lod(const baked_set *set, double low, double high)
{
    const int last = set->texture[VIEW_SPECULAR].levels - 1;
    const bool linear = set->mapping == IBL_ROUGHNESS_LINEAR;
    const double from = linear ? low : low * (2 - low);
    const double to = linear ? high : high * (2 - high);

    for (int l = 0; l <= last; l++) {
        const double x = last ? from + (to - from) * l / last : from;
        CHECK_NEAR(set->roughness[l], linear ? x : 1 - sqrt(1 - x), 1e-8);
        if (last)
            CHECK_NEAR(x * set->lod_scale + set->lod_offset, l, 1e-6);
    }
}

TEST(mappings_and_ranges)
{
    static const struct {
        const char *options;
        ibl_roughness_map mapping;
        double low, high;
    } cases[] = {
        {"--mapping linear", IBL_ROUGHNESS_LINEAR, 0, 1},
        {"--mapping filament --levels 5", IBL_ROUGHNESS_FILAMENT, 0, 1},
        {"--roughness-range 0.2:0.8 --levels 4", IBL_ROUGHNESS_FILAMENT, 0.2,
         0.8},
        {"--mapping linear --roughness-range 0.1:0.6 --levels 3",
         IBL_ROUGHNESS_LINEAR, 0.1, 0.6},
        {"--roughness-range 0.5:0.5", IBL_ROUGHNESS_FILAMENT, 0.5, 0.5},
    };
    ibl_ctx *ctx = view_test_ctx(2);

    for (int i = 0; i < 5; i++) {
        baked_set set;
        /* By the sidecar alone, by the keys alone. */
        for (int dds = 0; dds < 2; dds++) {
            const char *path = test_text("lod%d%d", i, dds);
            NEED(sets_bake(path, test_text("%s --format %s", cases[i].options,
                                           dds ? "dds" : "ktx")));
            if (!dds)
                NEED(file_run("rm %s/sky.json", path));
            const char *said = sets_open(ctx, path, &set);
            /* With a sidecar the map is at hand. */
            CHECK_MSG(sets_lines(said) == (!dds && cases[i].low > 0),
                      "%s: said %s", path, said);
            CHECK(!*said || strstr(said, "level 0 is of roughness"));
            CHECK(set.mapping == cases[i].mapping);
            CHECK(set.sh_degree == (dds ? 2 : -1));
            check_lod(&set, cases[i].low, cases[i].high);
        }
    }
}

/* Neither keys nor sidecar: defaults, and a line for each. */
TEST(nothing_is_told)
{
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set set;

    NEED(sets_bake("bare", "--format dds --levels 4 --mapping filament"));
    NEED(file_run("rm bare/sky.json"));
    const char *said = sets_open(ctx, "bare", &set);
    CHECK(sets_lines(said) == 3 && strstr(said, "linear mapping") &&
          strstr(said, "irradiance / pi") && strstr(said, "smith"));
    CHECK(set.mapping == IBL_ROUGHNESS_LINEAR && set.sh_degree == -1);
    check_lod(&set, 0, 1);
}

/* ---- what a set has not ----------------------------------------------- */

static void check_irradiance(ibl_ctx *ctx, const baked_set *set, double bound)
{
    const ibl_texture *tex = &set->texture[VIEW_IRRADIANCE];
    ibl_image map = sets_read_map(ctx);
    float *rgb = decode(tex);
    double worst = 0;

    for (int face = 0; face < 6; face++) {
        for (int i = 0; i < tex->width * tex->width; i += 7) {
            double n[3], truth[3];
            const float *p = rgb + 3 * (face * tex->width * tex->width + i);
            truth_cube_direction(tex->width, face, i % tex->width,
                                 i / tex->width, n);
            reference_irradiance(&map, n, truth);
            for (int c = 0; c < 3; c++)
                worst = fmax(
                    worst,
                    fabs((double)p[c] * set->irradiance_scale / truth[c] - 1));
        }
    }
    CHECK_MSG(worst <= bound, "irradiance is off by %g of itself", worst);
    if (getenv("IBL_TEST_VERBOSE"))
        printf("irradiance %g of %g\n", worst, bound);
}

TEST(table_is_made)
{
    ibl_ctx *ctx = view_test_ctx(2);
    baked_set set;

    NEED(sets_bake("table", "--geometry schlick-ibl"));
    NEED(file_run("rm table/brdf_lut_schlick-ibl.ktx2"));
    const char *said = sets_open(ctx, "table", &set);
    CHECK(sets_lines(said) == 1 && strstr(said, "no BRDF table"));
    CHECK(set.geometry == IBL_GEOMETRY_SMITH && !set.path[VIEW_LUT]);
    const ibl_texture *tex = &set.texture[VIEW_LUT];
    for (int i = 3; i < tex->width; i += 50) {
        float pair[2];
        double truth[2];
        ibl_pixel_decode(tex->pixel,
                         tex->data + ibl_pixel_bytes(tex->pixel) *
                                         ((size_t)i * tex->width + 40),
                         1, pair);
        reference_lut(40.5 / tex->width, (i + 0.5) / tex->width,
                      IBL_GEOMETRY_SMITH, truth);
        /* The quadrature's 5e-5 and half a bit of a half. */
        CHECK_NEAR((double)pair[0], truth[0], 5e-5 + 0x1p-12);
        CHECK_NEAR((double)pair[1], truth[1], 5e-5 + 0x1p-12);
    }
}

/* Bounds: the sum puts what is in a texel of 2.8 degrees in its centre, at most
 * 2 degrees beside, which is 0.035 of what the sun adds (a tenth of the light
 * here); harmonics to degree 4 miss at most 5 % of a sun (l = 6: 13/64 of 17/4
 * at the pole); a level of roughness 0.3 has its light 2 alpha, 10 degrees,
 * away from where it was, and some of it in GGX's tails. */
TEST_OF(irradiance_is_made, "irradiance_is_made", TEST_RACES || !TEST_SANITIZED)
{
    static const struct {
        const char *options, *from;
        double bound;
    } cases[] = {
        {"", "level 0", 0.01},
        {"--levels 1", "level 0", 0.01},
        {"--roughness-range 0.3:1 --levels 2 --size 64", "last specular level",
         0.01},
        /* Too small, and of a lobe whose roughest is no cosine. */
        {"--roughness-range 0.3:1 --levels 4 --sh 4", "spherical harmonics",
         0.02},
        {"--roughness-range 0.3:1 --levels 2 --lobe charlie --sh 4",
         "spherical harmonics", 0.02},
        {"--roughness-range 0.3:0.8 --levels 2 --sh 4", "spherical harmonics",
         0.02},
        {"--roughness-range 0.3:0.8 --levels 2 --sh 1", "blurred or clipped",
         0.05},
    };
    ibl_ctx *ctx = view_test_ctx(2);

    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        baked_set set;
        NEED(file_run("rm -rf light"));
        NEED(sets_bake("light", cases[i].options));
        NEED(!unlink(file_path("light/sky_irradiance.ktx2")));
        const char *said = sets_open(ctx, "light", &set);
        CHECK_MSG(sets_lines(said) == 1 + (set.lobe != IBL_LOBE_GGX) &&
                      strstr(said, cases[i].from),
                  "%s: %s", cases[i].options, said);
        check_irradiance(ctx, &set, cases[i].bound);
    }
}

/* A sun that halves do not hold: the last level knows what it gave. */
TEST(clipped_sun)
{
    ibl_ctx *ctx = view_test_ctx(2);
    ibl_specular_options opts = ibl_specular_options_default();
    ibl_image map = sets_map(ctx, 128, 1e7);
    baked_set baked, set;

    /* A set without irradiance, written from one that was baked. */
    opts.size = 64;
    opts.levels = 4;
    view_test_catch();
    const bool ok = sets_bake_image(ctx, "sun", &map, &opts, &baked);
    const char *said = view_test_caught();
    NEED(ok);
    CHECK(strstr(said, "beyond 65504"));
    NEED(sets_save(ctx, "sun_specular.ktx2", &baked.texture[VIEW_SPECULAR],
                   IBL_CONTAINER_KTX2));
    NEED(file_run("mkdir sun && mv sun_specular.ktx2 sun"));
    said = sets_open(ctx, "sun", &set);
    CHECK(strstr(said, "the last specular level"));
    CHECK(set.texture[VIEW_IRRADIANCE].width == 8);
    float *last = decode(&set.texture[VIEW_IRRADIANCE]);
    for (int i = 0; i < 6 * 64; i += 5) {
        double n[3], truth[3];
        truth_cube_direction(8, i / 64, i % 8, i / 8 % 8, n);
        reference_irradiance(&map, n, truth);
        CHECK_NEAR((double)last[3 * i], truth[0], 0.02 * truth[0]);
    }
    view_set_free(&baked);
}

/* ---- harmonics -------------------------------------------------------- */

/* L = 1 + a.d + b d_x d_y has E/pi = 1 + 2/3 a.d + 1/4 b d_x d_y. */
TEST(harmonics_are_irradiance)
{
    ibl_ctx *ctx = view_test_ctx(2);
    ibl_image map = map_constant(ctx, 256, 128, 0);
    const double a[3] = {0.2, -0.3, 0.4};
    ibl_specular_options opts = ibl_specular_options_default();
    baked_set set;

    for (int y = 0; y < map.height; y++) {
        for (int x = 0; x < map.width; x++) {
            double d[3];
            truth_latlong_direction(map.width, map.height, x, y, d);
            const double ad = a[0] * d[0] + a[1] * d[1] + a[2] * d[2];
            map_set(&map, x, y, (float)(1 + ad), (float)(1 + 0.5 * d[0] * d[1]),
                    (float)(1 + 0.25 * d[2] * d[1]));
        }
    }
    opts.size = 16;
    for (int turned = 0; turned < 2; turned++) {
        opts.yaw_deg = turned ? 90 : 0;
        NEED(sets_bake_image(ctx, "linear", &map, &opts, &set));
        CHECK(set.sh_degree == VIEW_SH_DEGREE);
        for (int face = 0; face < 6; face++) {
            double w[3], rgb[3];
            truth_cube_direction(16, face, 5, 11, w);
            view_harmonics_sum(set.sh, VIEW_SH_COUNT, 3, w, rgb);
            /* Counter-clockwise from above: what was at +X is at -Z. */
            const double d[3] = {turned ? -w[2] : w[0], w[1],
                                 turned ? w[0] : w[2]};
            const double ad = a[0] * d[0] + a[1] * d[1] + a[2] * d[2];
            /* Pixel centres stand for pixels: (pi/128)^2 / 24 of the map. */
            CHECK_NEAR(rgb[0], 1 + 2 * ad / 3, 1e-4);
            CHECK_NEAR(rgb[1], 1 + 0.125 * d[0] * d[1], 1e-4);
            CHECK_NEAR(rgb[2], 1 + 0.0625 * d[2] * d[1], 1e-4);
        }
        view_set_free(&set);
    }
}

/* Each Y_lm against tests/truth.c. */
TEST(harmonics_basis)
{
    const double d[][3] = {
        {0.36, 0.48, 0.8}, {-0.8, 0.36, 0.48}, {0.48, -0.8, -0.36}};

    for (int l = 0, i = 0; l <= VIEW_SH_DEGREE; l++) {
        for (int m = -l; m <= l; m++, i++) {
            double sh[3 * VIEW_SH_COUNT] = {0};
            sh[3 * i + 1] = 1;
            for (int k = 0; k < 3; k++) {
                double rgb[3];
                view_harmonics_sum(sh, VIEW_SH_COUNT, 3, d[k], rgb);
                CHECK_NEAR(rgb[1], truth_sh(l, m, d[k]), 1e-12);
                CHECK(rgb[0] == 0 && rgb[2] == 0);
            }
        }
    }
}

/* ---- others' ---------------------------------------------------------- */

TEST(of_cmgen)
{
    ibl_ctx *ctx;
    baked_set set;

    if (!file_have("cmgen"))
        test_skip("cmgen (package filament) is not installed");
    ctx = view_test_ctx(2);
    NEED(file_run("mkdir -p cm && timeout 100 cmgen -q --format=ktx --size=64 "
                  "--ibl-samples=64 --deploy=cm '%s'",
                  sets_file()));
    const char *said = sets_open(ctx, "cm/cm_ibl.ktx", &set);
    CHECK_MSG(strstr(said, "as cmgen has it"), "%s", said);
    CHECK(set.mapping == IBL_ROUGHNESS_FILAMENT);
    CHECK(set.irradiance_scale == 1);
    check_lod(&set, 0, 1);
    sets_refused(ctx, file_path("cm/cm_skybox.ktx"), "no specular levels");
}
