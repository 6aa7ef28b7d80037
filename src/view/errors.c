/* SPDX-License-Identifier: MIT */
#include "view/errors.h"

#include <math.h>
#include <stdlib.h>

#include "view/message.h"
#include "view/sphere_grid.h"

/* Finds the sphere that each pixel shows, -1 for none. */
static void find_spheres(const view_camera *camera, const view_sphere *spheres,
                         int count, int width, int height, int *shown)
{
    double direction[3];

    for (int i = 0; i < width * height; ++i) {
        view_camera_ray(camera, width, height, i % width, i / width, direction);
        shown[i] = view_grid_hit(spheres, count, camera->eye, direction, NULL);
    }
}

/* Whether a pixel and its eight neighbours show the same sphere; not for pixels
 * at the picture's edge. */
static bool inside(const int *shown, int width)
{
    if (*shown < 0)
        return false;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
            if (shown[y * width + x] != *shown)
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

int view_errors(const view_settings *s, int width, int height,
                const float *picture, const float *truth, double *rmse)
{
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    double sums[VIEW_MAX_GRID * VIEW_MAX_GRID][2] = {{0.0}};
    bool seen[VIEW_MAX_GRID * VIEW_MAX_GRID] = {false};
    const view_camera camera = view_camera_of(s, width, height);
    const int count = view_grid(s, spheres);
    int *shown = malloc((size_t)width * (size_t)height * sizeof *shown);

    if (!shown) {
        view_fail("no memory for %d pixels of spheres", width * height);
        return 0;
    }
    find_spheres(&camera, spheres, count, width, height, shown);
    for (int y = 1; y < height - 1; ++y)
        for (int x = 1; x < width - 1; ++x) {
            const size_t i = (size_t)y * (size_t)width + (size_t)x;
            if (!inside(shown + i, width))
                continue;
            seen[shown[i]] = true;
            add_pixel(picture + 3 * i, truth + 3 * i, sums[shown[i]]);
        }
    for (int i = 0; i < count; ++i)
        rmse[i] = !seen[i]            ? -1.0
                  : sums[i][0] == 0.0 ? 0.0
                                      : sqrt(sums[i][0] / sums[i][1]);
    free(shown);
    return count;
}
