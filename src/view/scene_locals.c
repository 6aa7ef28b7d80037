/* SPDX-License-Identifier: MIT */
#include "view/scene_captures.h"

#include <math.h>

#include "view/room.h"
#include "view/settings.h"

static const double height = 1.5;
/* Distance to keep from boxes and the mirror. */
static const double clearance = 0.25;
/* Extent of influence beyond walls, besides the blend width. */
static const double beyond = 0.25;
/* Blend width relative to the shortest side of a cell. It is the same for all
 * probes, so neighbours sum to at least 1. */
static const double blend_part = 0.4;

static bool is_in(const double point[3], const double low[3],
                  const double high[3])
{
    for (int k = 0; k < 3; k++)
        if (point[k] <= low[k] - clearance || point[k] >= high[k] + clearance)
            return false;
    return true;
}

/* Moves to the nearest side; of equal ones to that nearer the middle. */
static void move_out(double point[3], const double low[3], const double high[3])
{
    double least = INFINITY, best = 0;
    int axis = 0;

    if (!is_in(point, low, high))
        return;
    for (int side = 0; side < 4; side++) {
        const int k = side < 2 ? 0 : 2;
        const double to = side % 2 ? high[k] + clearance : low[k] - clearance;
        const double cost = fabs(to - point[k]) + 1e-3 * fabs(to);
        if (cost < least) {
            least = cost;
            best = to;
            axis = k;
        }
    }
    point[axis] = best;
}

static void move_out_of_all(double point[3])
{
    double low[3], high[3], radius;

    for (int i = 0; i < VIEW_ROOM_BOXES; i++)
        move_out(point, view_room_box_at(i)->low, view_room_box_at(i)->high);
    view_room_sphere(0, 0, low, &radius);
    for (int k = 0; k < 3; k++) {
        high[k] = low[k] + radius;
        low[k] -= radius;
    }
    move_out(point, low, high);
}

/* A border of an influence, which extends beyond a wall or into a neighbour. */
static double reach(double border, double outwards, double wall, double blend)
{
    const bool last = fabs(border - wall) < 1e-6;

    return border + outwards * (last ? blend + beyond : blend / 2);
}

/* Places the probe of the floor's cell from low to high, x and z. */
static void place(ibl_probe *p, const double low[2], const double high[2],
                  double blend)
{
    const double *c = view_room_centre, *h = view_room_half;

    *p = (ibl_probe){.has_proxy = 1, .blend = blend};
    for (int k = 0; k < 3; k++) {
        const double wall[2] = {c[k] - h[k], c[k] + h[k]};
        const double from = k == 1 ? wall[0] : low[k / 2];
        const double to = k == 1 ? wall[1] : high[k / 2];
        const double first = reach(from, -1, wall[0], p->blend);
        const double last = reach(to, 1, wall[1], p->blend);
        p->position[k] = k == 1 ? height : (from + to) / 2;
        p->influence.centre[k] = (first + last) / 2;
        p->influence.half[k] = (last - first) / 2;
        p->proxy.centre[k] = c[k];
        p->proxy.half[k] = h[k];
    }
    move_out_of_all(p->position);
}

static double between(int k, int part, int parts)
{
    return view_room_centre[k] + view_room_half[k] * (2.0 * part / parts - 1);
}

void view_scene_place(ibl_probe *probes, int count)
{
    const int rows = (int)lround(sqrt(count));
    const int columns = (count + rows - 1) / rows; /* maximum of a row */
    const double blend =
        2 * blend_part *
        fmin(view_room_half[0] / columns, view_room_half[2] / rows);
    ibl_probe placed[VIEW_MAX_LOCALS];
    int order[VIEW_MAX_LOCALS];

    for (int row = 0; row < rows; row++) {
        const int first = count * row / rows, end = count * (row + 1) / rows;
        for (int i = first; i < end; i++) {
            const double low[2] = {between(0, i - first, end - first),
                                   between(2, row, rows)};
            const double high[2] = {between(0, i - first + 1, end - first),
                                    between(2, row + 1, rows)};
            place(&placed[i], low, high, blend);
        }
    }
    ibl_probes_order(placed, count, order);
    for (int i = 0; i < count; i++) {
        probes[i] = placed[order[i]];
        probes[i].layer = i;
    }
}
