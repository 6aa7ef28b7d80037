/* SPDX-License-Identifier: MIT */
/* Errors of pictures that are known. */
#include <math.h>
#include <string.h>

#include "test.h"
#include "view/errors.h"
#include "view/sphere_grid.h"

enum {
    WIDTH = 120,
    HEIGHT = 90
};

/* Of the running test. */
static struct {
    view_settings settings;
    float *picture, *truth;
    double rmse[VIEW_MAX_GRID * VIEW_MAX_GRID];
} p;

static void begin(int rows, int columns)
{
    const size_t floats = (size_t)3 * WIDTH * HEIGHT;
    test_random random = {7};

    p.settings = view_settings_default();
    p.settings.rows = rows;
    p.settings.columns = columns;
    p.picture = test_alloc(floats, sizeof(float));
    p.truth = test_alloc(floats, sizeof(float));
    for (size_t i = 0; i < floats; ++i) {
        p.truth[i] = (float)(0.5 + test_random_unit(&random));
        p.picture[i] = p.truth[i];
    }
}

static int compare(void)
{
    const int count = p.settings.rows * p.settings.columns;
    int *shown = test_alloc(WIDTH * HEIGHT, sizeof *shown);
    view_error errors[VIEW_MAX_GRID * VIEW_MAX_GRID];

    view_errors_spheres(&p.settings, WIDTH, HEIGHT, shown);
    view_errors(shown, count, WIDTH, HEIGHT, p.picture, p.truth, errors);
    for (int i = 0; i < count; ++i)
        p.rmse[i] = view_error_rmse(errors[i]);
    return count;
}

/* The sphere of the pixel, -1 for none. */
static int sphere_of(int x, int y)
{
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    const view_camera c = view_camera_of(&p.settings, WIDTH, HEIGHT);
    const int count = view_grid(&p.settings, spheres);
    double direction[3];

    view_camera_ray(&c, WIDTH, HEIGHT, x, y, direction);
    return view_grid_hit(spheres, count, c.eye, direction, NULL);
}

/* A picture of f times the truth is off by |f - 1|; each sphere has its f. The
 * outline and what is around it have no part. */
TEST(known_errors)
{
    begin(2, 3);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        const int x = i % WIDTH, y = i / WIDTH, sphere = sphere_of(x, y);
        for (int c = 0; c < 3; ++c)
            p.picture[3 * i + c] *= 1.0F + 0.25F * (float)(sphere - 2);
        if (sphere < 0 || sphere_of(x + 1, y) < 0 || sphere_of(x, y - 1) < 0)
            p.picture[3 * i] = 1e6F;
    }
    CHECK(compare() == 6);
    for (int i = 0; i < 6; ++i)
        CHECK_NEAR(p.rmse[i], fabs(0.25 * (i - 2)), 1e-6);
}

/* A single pixel in the middle, by hand. */
TEST(one_pixel)
{
    double sum = 0.0;
    const size_t at = (size_t)3 * (HEIGHT / 2 * WIDTH + WIDTH / 2);

    begin(1, 1);
    for (int y = 1; y < HEIGHT - 1; ++y)
        for (int x = 1; x < WIDTH - 1; ++x) {
            bool inside = true;
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i)
                    inside = inside && sphere_of(x + i, y + j) == 0;
            for (int c = 0; inside && c < 3; ++c)
                sum += pow(p.truth[3 * (y * WIDTH + x) + c], 2.0);
        }
    p.picture[at + 1] = p.truth[at + 1] + 2.0F;
    CHECK(compare() == 1);
    CHECK_NEAR(p.rmse[0], 2.0 / sqrt(sum), 1e-6);
}

/* What is beyond the picture's edges is not known. */
TEST(edges_of_the_picture)
{
    begin(1, 1);
    p.settings.distance = 0.6;
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            CHECK(sphere_of(x, y) == 0);
            if (x == 0 || y == 0 || x == WIDTH - 1 || y == HEIGHT - 1)
                p.picture[3 * (y * WIDTH + x)] = 1e6F;
        }
    CHECK(compare() == 1 && p.rmse[0] == 0.0);
    p.picture[3 * (WIDTH + 1)] = 1e6F;
    CHECK(compare() == 1 && p.rmse[0] > 0.0);
}

TEST(black_and_unseen)
{
    begin(1, 1);
    memset(p.truth, 0, (size_t)3 * WIDTH * HEIGHT * sizeof(float));
    CHECK(compare() == 1 && isinf(p.rmse[0]));
    memset(p.picture, 0, (size_t)3 * WIDTH * HEIGHT * sizeof(float));
    CHECK(compare() == 1 && p.rmse[0] == 0.0);
    /* So far away that no pixel has it alone. */
    p.settings.distance = 1000.0;
    CHECK(compare() == 1 && p.rmse[0] == -1.0);
}
