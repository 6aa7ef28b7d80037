/* SPDX-License-Identifier: MIT */
/* What is behind the spheres: the map itself by a closed form, levels of the
 * chain, and what is no map of the set. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "float_exr.h"
#include "maps.h"
#include "shade.h"
#include "view.h"

enum {
    WIDTH = 48,
    HEIGHT = 32,
    COLUMNS = 256
};

static shade_set *const set = &shade_sets[0];

/* Radiance of a direction: harmonics of degree 1. */
static double light(const double d[3], int k)
{
    return 2 + 0.5 * d[k] + 0.25 * d[(k + 1) % 3];
}

static void save_map(const char *path)
{
    const ibl_image map = map_constant(shade_ctx(), COLUMNS, COLUMNS / 2, 0);

    for (int i = 0; i < COLUMNS * COLUMNS / 2; i++) {
        const double phi = 2 * M_PI * ((i % COLUMNS + 0.5) / COLUMNS - 0.5);
        const double theta = 2 * M_PI * (i / COLUMNS + 0.5) / COLUMNS;
        const double d[3] = {sin(theta) * cos(phi), cos(theta),
                             sin(theta) * sin(phi)};
        for (int k = 0; k < 3; k++)
            map.data[3 * i + k] = (float)light(d, k);
    }
    CHECK(file_save_exr(path, &map, NULL));
}

/* One ball, far enough to leave pixels beside it. */
static view_settings behind(void)
{
    view_settings s = view_settings_default();

    s.rows = s.columns = 1;
    s.distance = 8;
    s.fov = 60;
    s.yaw = 20;
    s.pitch = 35;
    s.turn = 70;
    return s;
}

/* The direction of a pixel in the frame of the environment. */
static void towards(const view_settings *s, int i, double env[3])
{
    const view_camera c = view_camera_of(s, WIDTH, HEIGHT);
    double world[3];

    view_camera_ray(&c, WIDTH, HEIGHT, i % WIDTH, i / WIDTH, world);
    view_turn(s->turn, world, env);
}

static void begin_with_map(void)
{
    shade_begin(WIDTH, HEIGHT);
    shade_constant(set, (const float[3]){1, 1, 1});
    set->set.source_read = ibl_read_options_default();
    set->set.source = strdup(file_path("map.exr"));
    test_defer(free, set->set.source);
    save_map(set->set.source);
}

TEST(map_itself)
{
    begin_with_map();
    const view_settings s = behind();
    for (int yaw = 0; yaw < 360; yaw += 130) {
        set->set.source_yaw = yaw;
        const float *rgb = shade_draw(&set->set, &s);
        const shade_pixel *shown = shade_pixels(&s);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            double env[3], d[3];
            towards(&s, i, env);
            view_turn(yaw, env, d);
            for (int k = 0; k < 3 && shown[i].sphere == -1; k++)
                CHECK_NEAR(rgb[3 * i + k], light(d, k), 2e-3);
        }
    }
}

/* Pixels of the sky of the constant set, where the map is not shown. */
static void shows_no_map(const view_settings *s)
{
    const float *rgb = shade_draw(&set->set, s);
    const shade_pixel *shown = shade_pixels(s);

    for (int i = 0; i < WIDTH * HEIGHT; i++)
        if (shown[i].sphere == -1)
            CHECK_NEAR(rgb[3 * i], 1, 1e-6);
}

TEST(another_map)
{
    begin_with_map();
    view_settings s = behind();
    view_test_catch();
    strcpy(set->set.source_hash, "0123456789abcdef0123456789abcdef");
    shows_no_map(&s);
    CHECK(strstr(view_test_caught(), "map.exr: cannot be read again"));
    *set->set.source_hash = '\0';
    set->set.own_sky = true;
    shows_no_map(&s);
    set->set.own_sky = false;
    s.blur = 0.5;
    shows_no_map(&s);
}

/* A level of the chain, by the mapping of the set. */
TEST(blurred)
{
    ibl_specular_options o = ibl_specular_options_default();

    shade_begin(WIDTH, HEIGHT);
    const ibl_image map = map_constant(shade_ctx(), 64, 32, 0);
    map_fill(&map, 3);
    o.size = 32;
    o.levels = 4;
    o.mapping = IBL_ROUGHNESS_LINEAR;
    shade_bake(set, &map, &o);
    view_settings s = behind();
    s.blur = 0.5;
    const float *rgb = shade_draw(&set->set, &s);
    const shade_pixel *shown = shade_pixels(&s);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double env[3], exact[3];
        towards(&s, i, env);
        shade_cube(&set->specular, 1.5, env, exact);
        for (int k = 0; k < 3 && shown[i].sphere == -1; k++)
            CHECK_NEAR(rgb[3 * i + k], exact[k], 2e-3);
    }
}

/* Nothing takes clipped light for the truth. */
TEST(clipped_is_no_reference)
{
    shade_begin(WIDTH, HEIGHT);
    shade_constant(set, (const float[3]){65504, 65504, 65504});
    shade_pack(set, IBL_PIXEL_RGBA16F, IBL_PIXEL_RG32F);
    set->set.pixel[VIEW_SPECULAR] = IBL_PIXEL_RGBA16F;
    view_settings s = behind();
    s.reflection = VIEW_REFERENCE;
    view_test_catch();
    CHECK(view_renderer_load(shade_renderer(), &set->set));
    CHECK(!view_renderer_draw(shade_renderer(), &s, WIDTH, HEIGHT));
    CHECK(strstr(view_test_caught(), "level 0 is clipped by rgba16f"));
    s.reflection = VIEW_SPLIT_SUM;
    CHECK(view_renderer_draw(shade_renderer(), &s, WIDTH, HEIGHT));
}
