/* SPDX-License-Identifier: MIT */
#include "view/errors.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "view/sphere_grid.h"

double view_error_rmse(view_error e)
{
    return !e.pixels              ? -1
           : e.difference2 == 0.0 ? 0
                                  : sqrt(e.difference2 / e.truth2);
}

void view_errors_spheres(const view_settings *s, int width, int height,
                         int *shown)
{
    view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID];
    const view_camera camera = view_camera_of(s, width, height);
    const int count = view_grid(s, spheres);
    double direction[3];

    for (int i = 0; i < width * height; ++i) {
        view_camera_ray(&camera, width, height, i % width, i / width,
                        direction);
        shown[i] = view_grid_hit(spheres, count, camera.eye, direction, NULL);
    }
}

/* Whether a pixel and its eight neighbours show the same; not for pixels at the
 * picture's edge. */
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

static void add_pixel(const float *picture, const float *truth, view_error *e)
{
    for (int c = 0; c < 3; ++c) {
        const double t = truth[c], d = picture[c] - t;

        e->difference2 += d * d;
        e->truth2 += t * t;
    }
    e->pixels++;
}

void view_errors(const int *shown, int count, int width, int height,
                 const float *picture, const float *truth, view_error *errors)
{
    for (int i = 0; i < count; ++i)
        errors[i] = (view_error){0};
    for (int y = 1; y < height - 1; ++y)
        for (int x = 1; x < width - 1; ++x) {
            const size_t i = (size_t)y * (size_t)width + (size_t)x;
            if (inside(shown + i, width))
                add_pixel(picture + 3 * i, truth + 3 * i, &errors[shown[i]]);
        }
}
