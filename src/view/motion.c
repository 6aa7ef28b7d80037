/* SPDX-License-Identifier: MIT */
#include "view/motion.h"

#include <math.h>

#include "view/inspect.h"
#include "view/scene_captures.h"
#include "view/sphere_grid.h"
#include "view/vector.h"

/* The same angle in (-180, 180]. */
static double turned(double degrees)
{
    const double x = remainder(degrees, 360);
    return x == -180 ? 180 : x;
}

static bool shows_map(const view_settings *s)
{
    return !view_shows_materials(s) && s->mode != VIEW_SCENE;
}

void view_drag(view_settings *s, const baked_set *set, int width, int height,
               double dx, double dy)
{
    if (shows_map(s)) {
        view_inspect_drag(set, s, width, height, dx, dy);
        return;
    }
    s->yaw = turned(s->yaw - 180 * dx / height);
    s->pitch = fmin(fmax(s->pitch + 180 * dy / height, -89), 89);
}

void view_approach(view_settings *s, const baked_set *set, view_place at,
                   double steps)
{
    const double factor = pow(1.1, steps);

    if (shows_map(s)) {
        view_inspect_zoom(set, s, at.width, at.height, at.x, at.y, factor);
        return;
    }
    if (s->distance <= 0 && s->mode == VIEW_SCENE)
        s->distance = view_scene_distance;
    if (s->distance <= 0) {
        const view_camera c = view_camera_of(s, at.width, at.height);
        s->distance = -dot3(c.eye, c.forward);
    }
    s->distance = fmin(
        fmax(s->distance / factor, s->mode == VIEW_MODEL ? 0.05 : 0.6), 1000);
}

void view_pan(view_settings *s, int width, int height, double dx, double dy)
{
    const view_camera c = view_camera_of(s, width, height);
    const double pixel =
        sqrt(dot3(c.up, c.up)) / height * -dot3(c.eye, c.forward);

    s->pan[0] = fmin(fmax(s->pan[0] - pixel * dx, -0.5), 0.5);
    s->pan[1] = fmin(fmax(s->pan[1] - pixel * dy, -0.5), 0.5);
}

void view_move_light(view_settings *s, double around, double up)
{
    const double degree = M_PI / 180;
    double *p = s->light[0].position;
    const double away = sqrt(dot3(p, p));

    if (!s->light_count)
        s->light_count = 1;
    if (away <= 0)
        return;
    const double height = asin(p[1] / away) + up * degree;
    const double lift = fmin(fmax(height, -89 * degree), 89 * degree);
    const double angle = atan2(p[0], p[2]) + around * degree;
    p[0] = away * cos(lift) * sin(angle);
    p[1] = away * sin(lift);
    p[2] = away * cos(lift) * cos(angle);
}

void view_spin(view_settings *s, double degrees)
{
    s->turn = turned(s->turn + degrees);
}
