/* SPDX-License-Identifier: MIT */
/* Antialiasing: edges by the area that a sphere covers, and comparisons are the
 * mean of the places and nothing else. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "maps.h"
#include "shade.h"
#include "view.h"

enum {
    WIDTH = 48,
    HEIGHT = 40
};

static shade_set *const set = &shade_sets[0];
static const float grey[3] = {0.5F, 0.5F, 0.5F};

/* One sphere, which reflects all light. */
static view_settings white_ball(int antialias)
{
    view_settings s = view_settings_default();

    s.rows = s.columns = 1;
    s.metallic[0] = 1;
    s.material = shade_material("white");
    s.antialias = antialias;
    return s;
}

/* Draws until all places are in. */
static float *draw(const view_settings *s)
{
    view_renderer *r = shade_renderer();
    float *rgb = test_alloc(3 * WIDTH * HEIGHT, sizeof *rgb);

    CHECK(view_renderer_load(r, &set->set));
    view_renderer_restart(r);
    for (int i = 0; i < view_places(s); i++)
        CHECK(!(i && view_renderer_complete(r)) &&
              view_renderer_draw(r, s, WIDTH, HEIGHT));
    CHECK(view_renderer_complete(r));
    CHECK(view_renderer_read(r, false, rgb));
    return rgb;
}

/* White spheres on black, some before others: a pixel is the part of it that
 * they cover, by 32 x 32 rays, but for where outlines cross. */
TEST(edges_by_area)
{
    enum {
        N = 32
    };
    static const double most[] = {0, 0.16, 0.1, 0.05, 0.04};

    shade_begin(WIDTH, HEIGHT);
    shade_constant(set, grey);
    for (int n = 1; n <= 4; n++) {
        view_settings s = white_ball(n);
        view_sphere balls[VIEW_MAX_GRID * VIEW_MAX_GRID];
        double sum = 0, all = 0, worst = 0;
        s.sky = false;
        s.rows = s.columns = 2;
        s.yaw = 25;
        s.pitch = -20;
        s.fov = 60;
        const view_camera c = view_camera_of(&s, WIDTH, HEIGHT);
        const int count = view_grid(&s, balls);
        const float *rgb = draw(&s);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            int hits = 0;
            for (int k = 0; k < N * N; k++) {
                double d[3];
                view_camera_ray(&c, WIDTH, HEIGHT,
                                i % WIDTH + (k % N + 0.5) / N - 0.5,
                                i / WIDTH + (k / N + 0.5) / N - 0.5, d);
                hits += view_grid_hit(balls, count, c.eye, d, NULL) >= 0;
            }
            const double part = hits / (double)(N * N);
            sum += rgb[3 * i] / 0.5;
            all += part;
            worst = fmax(worst, fabs(rgb[3 * i] / 0.5 - part));
        }
        CHECK_MSG(worst < most[n], "%d: %g", n, worst);
        CHECK_NEAR(sum / all, 1, 2e-3);
    }
}

/* Mean distance of two pictures. */
static double apart(const float *a, const float *b)
{
    double sum = 0;

    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)
        sum += fabs((double)a[i] - b[i]);
    return sum / (3 * WIDTH * HEIGHT);
}

static void bake_noise(void)
{
    ibl_specular_options o = ibl_specular_options_default();
    const ibl_image map = map_constant(shade_ctx(), 64, 32, 0);

    map_fill(&map, 7);
    o.size = 32;
    o.levels = 4;
    shade_bake(set, &map, &o);
}

/* The more places, the nearer to what very many give. */
static void converges(view_settings s)
{
    double off[4] = {0};

    s.antialias = 8;
    const float *exact = draw(&s);
    for (int n = 1; n <= 3; n++) {
        s.antialias = n;
        off[n] = apart(draw(&s), exact);
    }
    CHECK_MSG(off[2] < 0.4 * off[1] && off[3] < off[2], "%g, %g, %g", off[1],
              off[2], off[3]);
}

/* Mirrors, and the scene's pillars, cables and mirror. */
TEST(places_converge)
{
    shade_begin(WIDTH, HEIGHT);
    bake_noise();
    view_settings s = white_ball(1);
    s.rows = s.columns = 2;
    s.roughness[1] = 0;
    converges(s);
    shade_constant(set, grey);
    s = white_ball(1);
    s.mode = VIEW_SCENE;
    s.probe_size = 16;
    converges(s);
}

/* Comparisons do not widen lobes. */
TEST(compared_sides_are_means_of_places)
{
    float mean[3 * WIDTH * HEIGHT] = {0};

    shade_begin(WIDTH, HEIGHT);
    bake_noise();
    view_settings s = white_ball(3);
    s.compare = VIEW_SPLIT;
    s.against = VIEW_FIT;
    const float *rgb = draw(&s);
    for (int i = 0; i < 9; i++) {
        view_settings at = s;
        at.compare = VIEW_ALONE;
        view_set_place(&at, i);
        at.antialias = 1;
        const float *one = draw(&at);
        for (int k = 0; k < 3 * WIDTH * HEIGHT; k++)
            mean[k] += one[k] / 9;
    }
    /* Edges are narrower in the parts. */
    double worst = 0;
    const shade_pixel *shown = shade_pixels(&s);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        for (int k = 0; k < 3 && shown[i].sphere >= 0; k++)
            worst = fmax(worst, fabs((double)rgb[3 * i + k] - mean[3 * i + k]));
    CHECK_MSG(worst < 1e-4, "%g", worst);
    CHECK(view_widening(&s) <= 0);
    s.compare = VIEW_ALONE;
    CHECK_NEAR(view_widening(&s), 1 / 3.0, 1e-12);
}

/* Each place of a lattice is in a row and a column of its own, and their mean
 * is the pixel's centre. */
TEST(places_are_apart)
{
    for (int n = 1; n <= VIEW_MAX_ANTIALIAS; n++) {
        view_settings s = white_ball(n);
        const int count = view_places(&s);
        bool rows[64] = {false}, columns[64] = {false};
        double sum[2] = {0};
        CHECK(count == n * n);
        for (int i = 0; i < count; i++) {
            view_set_place(&s, i);
            const double x = (s.pixel[0] + 0.5) * count;
            const double y = (s.pixel[1] + 0.5) * count;
            CHECK(!columns[(int)x] && !rows[(int)y]);
            columns[(int)x] = rows[(int)y] = true;
            CHECK_NEAR(x - floor(x), 0.5, 1e-9);
            CHECK_NEAR(y - floor(y), 0.5, 1e-9);
            sum[0] += s.pixel[0], sum[1] += s.pixel[1];
        }
        CHECK_NEAR(sum[0], 0, 1e-9);
        CHECK_NEAR(sum[1], 0, 1e-9);
    }
}
