/* SPDX-License-Identifier: MIT */
/*
 * Flat maps, equirectangular and octahedral: where their texels are, what they
 * hold, and their way through textures.
 */
#include <math.h>
#include <string.h>

#include "ibl/io.h"
#include "maps.h"
#include "reference.h"

static const ibl_projection flat[] = {IBL_PROJECTION_EQUIRECT,
                                      IBL_PROJECTION_OCTAHEDRAL};

enum {
    FLAT = sizeof flat / sizeof flat[0]
};

static ibl_cube flat_alloc(ibl_ctx *ctx, ibl_projection projection, int size,
                           int levels)
{
    ibl_cube map = {0};
    NEED(!ibl_cube_alloc_as(ctx, projection, size, levels, &map));
    return test_cube(map);
}

static ibl_level_shape shape_of(const ibl_cube *map, int level)
{
    return ibl_level_shape_of(map->projection, ibl_cube_edge(map->size, level));
}

static size_t texels_of(const ibl_level_shape *s)
{
    return (size_t)s->width * (size_t)s->height;
}

/* ---- where texels are -------------------------------------------------- */

/* Where a direction is in a flat map, 0..1, by the textbook's encoding. */
static void encode(ibl_projection projection, const double d[3], double at[2])
{
    if (projection == IBL_PROJECTION_EQUIRECT) {
        at[0] = atan2(d[2], d[0]) / (2 * M_PI) + 0.5;
        at[1] = acos(d[1]) / M_PI;
        return;
    }
    const double sum = fabs(d[0]) + fabs(d[1]) + fabs(d[2]);
    double p[2] = {d[0] / sum, d[2] / sum};
    if (d[1] < 0) {
        const double x = (1 - fabs(p[1])) * (p[0] < 0 ? -1 : 1);
        p[1] = (1 - fabs(p[0])) * (p[1] < 0 ? -1 : 1);
        p[0] = x;
    }
    at[0] = 0.5 + 0.5 * p[0];
    at[1] = 0.5 + 0.5 * p[1];
}

TEST(each_texel_looks_where_the_encoding_puts_it)
{
    for (int k = 0; k < FLAT; k++) {
        const ibl_level_shape s = ibl_level_shape_of(flat[k], 8);
        CHECK(s.faces == 1 && s.height == 16);
        for (int y = 0; y < s.height; y++)
            for (int x = 0; x < s.width; x++) {
                double d[3], at[2];
                ibl_level_direction(&s, 0, x, y, d);
                encode(flat[k], d, at);
                CHECK_NEAR(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], 1, 1e-14);
                CHECK_NEAR(at[0] * s.width, x + 0.5, 1e-12);
                CHECK_NEAR(at[1] * s.height, y + 0.5, 1e-12);
            }
    }
}

/* Against the density of the projection at 16 x 16 points of each texel. */
TEST(solid_angles_are_the_integrals_of_the_density)
{
    const ibl_level_shape s = ibl_level_shape_of(IBL_PROJECTION_OCTAHEDRAL, 4);
    double sum = 0;

    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++) {
            double angle = 0;
            for (int i = 0; i < 256; i++) {
                const double p = (x + (i % 16 + 0.5) / 16) / 4 - 1;
                const double q = (y + (i / 16 + 0.5) / 16) / 4 - 1;
                const double h = 1 - fabs(p) - fabs(q);
                const double a = h < 0 ? 1 - fabs(q) : p;
                const double b = h < 0 ? 1 - fabs(p) : q;
                angle += pow(a * a + b * b + h * h, -1.5) / 4096;
            }
            CHECK_NEAR(ibl_level_solid_angle(&s, x, y), angle, 1e-3 * angle);
            sum += ibl_level_solid_angle(&s, x, y);
        }
    CHECK_NEAR(sum, 4 * M_PI, 1e-12);
    const ibl_level_shape e = ibl_level_shape_of(IBL_PROJECTION_EQUIRECT, 3);
    sum = 0;
    for (int y = 0; y < e.height; y++)
        sum += e.width * ibl_level_solid_angle(&e, 0, y);
    CHECK_NEAR(sum, 4 * M_PI, 1e-12);
    CHECK_NEAR(ibl_level_solid_angle(&e, 0, 1), (double)row_angle(12, 6, 1),
               1e-14);
}

/* ---- what they hold ------------------------------------------------------ */

/* Every texel of the sky and its mips, against the mean over its solid angle;
 * of maps that are finer than the texels and coarser. */
TEST(flat_environments_are_the_means_over_their_texels)
{
    /* and by how many degrees they are turned */
    static const int sizes[][3] = {{256, 128, 25}, {37, 19, 25}, {64, 32, 90}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {5};

    for (int k = 0; k < 3 * FLAT; k++) {
        const int *size = sizes[k / FLAT];
        const ibl_image map =
            map_of_kind(ctx, &rnd, MAP_NOISE, size[0], size[1]);
        ibl_reference *ref = reference_of(ctx, &map, size[2]);
        const ibl_cube to = flat_alloc(ctx, flat[k % FLAT], 16, 5);
        NEED(!ibl_flat_from_latlong(ctx, &map, size[2], &to));
        for (int l = 0; l < 5; l++) {
            const ibl_level_shape s = shape_of(&to, l);
            double worst = 0;
            for (size_t i = 0; i < texels_of(&s); i += l ? 1 : 5) {
                const ibl_texel at = {0, (int)i % s.width, (int)i / s.width};
                double truth[3];
                NEED(!ibl_reference_texels(ref, to.projection, 16, 16 >> l, &at,
                                           1, truth));
                const float *rgb = ibl_cube_face(&to, l, 0) + 3 * i;
                worst = fmax(worst, fabs((double)rgb[1] - truth[1]));
            }
            test_measured("largest difference", worst, 1e-6);
            CHECK_MSG(worst <= 1e-6, "%s, level %d: %g",
                      ibl_projection_name(to.projection), l, worst);
        }
    }
}

/* ---- textures ------------------------------------------------------------ */

static double mean_of(const ibl_cube *map)
{
    const ibl_level_shape s = shape_of(map, 0);
    double sum = 0;

    for (int i = 0; i < s.width * s.height; i++)
        sum += (double)map->data[3 * i] *
               ibl_level_solid_angle(&s, i % s.width, i / s.width);
    return sum / (4 * M_PI);
}

/* A sun beyond a half float, in the corner of the map and at its seam. */
TEST(light_beyond_a_format_spreads_over_the_seams)
{
    static const int places[][2] = {{0, 0}, {0, 9}, {5, 15}, {15, 15}};
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);

    for (int k = 0; k < 4 * FLAT; k++) {
        ibl_overflow_report report;
        ibl_cube map, read;
        ibl_texture tex;
        map = flat_alloc(ctx, flat[k / 4], 8, 1);
        const ibl_level_shape s = shape_of(&map, 0);
        for (size_t i = 0; i < 3 * texels_of(&s); i++)
            map.data[i] = 1;
        const int x = places[k % 4][0], y = places[k % 4][1];
        map.data[3 * (y * s.width + x)] = 2e5F;
        NEED(!ibl_texture_from_cube(ctx, &map, NULL, &tex, &report));
        NEED(!ibl_texture_to_cube(ctx, &tex, &read));
        CHECK(report.values == 1 && report.level[0].moved > 0);
        CHECK_NEAR(mean_of(&read) / mean_of(&map), 1, 1e-3);
        const int over = k / 4 ? 15 - y : y;
        const int beside = k / 4 ? 0 : s.width - 1;
        if (x == 0)
            CHECK(read.data[3 * (over * s.width + beside)] > 1);
        ibl_cube_free(&read);
        ibl_texture_free(&tex);
    }
}

/* A texture tells the projection by its shape. Turned axes put each texel where
 * its direction goes. */
TEST(textures_and_axes)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    const ibl_texel_options as = {.pixel = IBL_PIXEL_RGBA32F};

    for (int k = 0; k < 4 * FLAT; k++) {
        const ibl_axes axes = {.mirror = (ibl_mirror)(k / FLAT)};
        const ibl_cube map = flat_alloc(ctx, flat[k % FLAT], 16, 3);
        ibl_texture tex, back;
        ibl_cube read, turned;
        void *bytes;
        size_t size;
        size_t floats = 0;
        for (int l = 0; l < 3; l++) {
            const ibl_level_shape s = shape_of(&map, l);
            floats += 3 * texels_of(&s);
        }
        for (size_t i = 0; i < floats; i++)
            map.data[i] = (float)i;
        NEED(!ibl_texture_from_cube(ctx, &map, &as, &tex, NULL));
        CHECK(tex.faces == 1 && tex.height == 32 &&
              tex.width == (k % FLAT ? 32 : 64));
        NEED(!ibl_texture_encode(ctx, &tex, IBL_CONTAINER_DDS, &bytes, &size));
        NEED(!ibl_texture_decode(ctx, "flat", bytes, size, &back, NULL));
        NEED(!ibl_texture_to_cube(ctx, &back, &read));
        CHECK(read.projection == map.projection && read.size == 16 &&
              read.levels == 3 &&
              !memcmp(read.data, map.data, floats * sizeof(float)));
        NEED(!ibl_cube_turn_axes(ctx, &map, axes, 0, &turned));
        for (int l = 0; l < 3; l++) {
            const ibl_level_shape s = shape_of(&map, l);
            for (int i = 0; i < s.width * s.height; i++) {
                double d[3], to[3], at[2];
                ibl_level_direction(&s, 0, i % s.width, i / s.width, d);
                ibl_axes_turn(axes, 0, d, to);
                encode(map.projection, to, at);
                const int there =
                    (int)(at[1] * s.height) * s.width + (int)(at[0] * s.width);
                CHECK(ibl_cube_face(&turned, l, 0)[3 * there] ==
                      ibl_cube_face(&map, l, 0)[3 * i]);
            }
        }
        ibl_cube_free(&read);
        ibl_cube_free(&turned);
        ibl_texture_free(&tex);
        ibl_texture_free(&back);
        ibl_bytes_free(bytes);
    }
}

/* By way of a cube: of a soft level the lookup is near the cube's own texels.
 */
TEST(a_flat_map_becomes_a_cube)
{
    ibl_ctx *ctx = test_ctx(2, IBL_ISA_AUTO);
    test_random rnd = {19};
    const ibl_image map = map_of_kind(ctx, &rnd, MAP_SMOOTH, 64, 32);

    for (int k = 0; k < FLAT; k++) {
        ibl_irradiance_options o = ibl_irradiance_options_default();
        ibl_cube of[2], cube;
        o.size = 16;
        o.projection = flat[k];
        NEED(!ibl_bake_irradiance(ctx, &map, &o, &of[0]));
        o = ibl_irradiance_options_default();
        NEED(!ibl_bake_irradiance(ctx, &map, &o, &of[1]));
        NEED(!ibl_cube_from_flat(ctx, &of[0], &cube));
        CHECK(cube.size == 32);
        CHECK_NEAR(cube_nrmse(&cube, &of[1], 0), 0, 3e-3);
        ibl_cube_free(&of[0]);
        ibl_cube_free(&of[1]);
        ibl_cube_free(&cube);
    }
}
