/* SPDX-License-Identifier: MIT */
#include "view/errors.h"

#include <math.h>
#include <stdlib.h>

#include "view/message.h"
#include "view/sphere_grid.h"

/* The sphere that each pixel of a row shows, -1 for none. */
static void hit_row(const view_camera *camera, const view_sphere *spheres,
                    int count, int width, int height, int y, int *row)
{
    double direction[3];

    for (int x = 0; x < width; ++x) {
        view_camera_ray(camera, width, height, x, y, direction);
        row[x] = view_grid_hit(spheres, count, camera->eye, direction, NULL);
    }
}

/* Whether pixel x of the middle row and its neighbours show one sphere. */
static bool inside(int *const rows[3], int width, int x)
{
    const int sphere = rows[1][x];

    if (sphere < 0 || x == 0 || x == width - 1)
        return false;
    for (int j = 0; j < 3; ++j)
        for (int i = x - 1; i <= x + 1; ++i)
            if (rows[j][i] != sphere)
                return false;
    return true;
}

static void add_pixel(const float *picture, const float *truth, double sum[2])
{
    for (int c = 0; c < 3; ++c) {
        const double t = truth[c], d = picture[c] - t;

        sum[0] += d * d;
        sum[1] += t * t;
    }
}

static double relative(const double sum[2], bool shown)
{
    if (!shown)
        return -1.0;
    return sum[0] == 0.0 ? 0.0 : sqrt(sum[0] / sum[1]);
}

int view_errors(const view_settings *s, int width, int height,
                const float *picture, const float *truth, double *rmse)
{
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    double sums[VIEW_MAX_GRID * VIEW_MAX_GRID][2] = {{0.0}};
    bool shown[VIEW_MAX_GRID * VIEW_MAX_GRID] = {false};
    const view_camera camera = view_camera_of(s, width, height);
    const int count = view_grid(s, spheres);
    const size_t row = (size_t)width;
    int *hits = malloc(3 * row * sizeof *hits);

    if (!hits) {
        view_fail("no memory for %d pixels of spheres", 3 * width);
        return 0;
    }
    for (int y = 0; y < height; ++y) {
        int *const rows[3] = {hits + (size_t)(y + 1) % 3 * row,
                              hits + (size_t)(y + 2) % 3 * row,
                              hits + (size_t)y % 3 * row};

        hit_row(&camera, spheres, count, width, height, y, rows[2]);
        for (int x = 0; y > 1 && x < width; ++x) {
            const size_t at = 3 * ((size_t)(y - 1) * row + (size_t)x);

            if (!inside(rows, width, x))
                continue;
            shown[rows[1][x]] = true;
            add_pixel(picture + at, truth + at, sums[rows[1][x]]);
        }
    }
    for (int i = 0; i < count; ++i)
        rmse[i] = relative(sums[i], shown[i]);
    free(hits);
    return count;
}
