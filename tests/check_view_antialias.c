/* SPDX-License-Identifier: MIT */
/* Antialiasing: edges by the area that a sphere covers, what is constant stays
 * so, and comparisons are the mean of the places and nothing else. */
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

TEST(constant_stays_constant)
{
    shade_begin(WIDTH, HEIGHT);
    shade_constant(set, grey);
    for (int n = 1; n <= 4; n++) {
        view_settings s = white_ball(n);
        s.rows = s.columns = 3;
        const float *rgb = draw(&s);
        for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)
            CHECK_NEAR(rgb[i], 0.5, 2e-4);
    }
}

/* Part of a pixel that the sphere covers, by 32 x 32 rays. */
static double covered(const view_camera *c, const view_sphere *ball, int x,
                      int y)
{
    enum {
        N = 32
    };
    int hits = 0;

    for (int i = 0; i < N * N; i++) {
        double d[3];
        view_camera_ray(c, WIDTH, HEIGHT, x + (i % N + 0.5) / N - 0.5,
                        y + (i / N + 0.5) / N - 0.5, d);
        hits += view_grid_hit(ball, 1, c->eye, d, NULL) == 0;
    }
    return hits / (double)(N * N);
}

/* Each pixel of an edge, and all of them: the disc's area. */
TEST(edges_by_area)
{
    static const double most[] = {0, 0.16, 0.07, 0.05, 0.04};

    shade_begin(WIDTH, HEIGHT);
    shade_constant(set, grey);
    for (int n = 1; n <= 4; n++) {
        view_settings s = white_ball(n);
        view_sphere ball[VIEW_MAX_GRID * VIEW_MAX_GRID];
        s.sky = false;
        const view_camera c = view_camera_of(&s, WIDTH, HEIGHT);
        view_grid(&s, ball);
        const float *rgb = draw(&s);
        double sum = 0, worst = 0;
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            const double got = rgb[3 * i] / 0.5;
            sum += got;
            worst = fmax(worst,
                         fabs(got - covered(&c, ball, i % WIDTH, i / WIDTH)));
        }
        const double d = c.eye[2], sine = ball[0].radius / d;
        const double r = sine / sqrt(1 - sine * sine) / c.up[1] * HEIGHT / 2;
        CHECK_MSG(worst < most[n], "%d: %g", n, worst);
        CHECK_NEAR(sum, M_PI * r * r, 0.6);
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

TEST(mirrors_converge)
{
    shade_begin(WIDTH, HEIGHT);
    bake_noise();
    view_settings s = white_ball(1);
    s.rows = s.columns = 2;
    s.roughness[1] = 0;
    converges(s);
}

/* Pillars, cables and the mirror. */
TEST(the_scene_converges)
{
    shade_begin(WIDTH, HEIGHT);
    shade_constant(set, grey);
    view_settings s = white_ball(1);
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
