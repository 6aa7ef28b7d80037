/* SPDX-License-Identifier: MIT */
#include "view/room.h"

#include <math.h>

#define MATERIAL(r, g, b, rough, reflectance)                                  \
    {                                                                          \
        .albedo = {r, g, b}, .roughness = rough, .f0 = {                       \
            reflectance,                                                       \
            reflectance,                                                       \
            reflectance                                                        \
        }                                                                      \
    }
#define WHITE MATERIAL(0.75f, 0.75f, 0.75f, 0.9f, 0.04f)
#define RED MATERIAL(0.63f, 0.1f, 0.07f, 0.8f, 0.04f)
#define GREEN MATERIAL(0.15f, 0.45f, 0.12f, 0.8f, 0.04f)
#define BLUE MATERIAL(0.12f, 0.2f, 0.6f, 0.8f, 0.04f)
#define YELLOW MATERIAL(0.6f, 0.5f, 0.18f, 0.8f, 0.04f)
#define DARK MATERIAL(0.1f, 0.1f, 0.11f, 0.08f, 0.06f)
#define LIGHT MATERIAL(0.3f, 0.29f, 0.27f, 0.08f, 0.06f)
#define STONE MATERIAL(0.5f, 0.47f, 0.42f, 0.35f, 0.04f)
/* A panel emits light and reflects none. */
#define LAMP(r, g, b)                                                          \
    {                                                                          \
        .roughness = 1, .emission = { r, g, b }                                \
    }

/* Thickness of walls, which are outside the room. */
#define WALL 0.25
#define OUT (5 + WALL)

const double view_room_centre[3] = {0, 2, 0}, view_room_half[3] = {5, 2, 5};

/* A row of five tiles of the floor, from -X to +X. */
#define TILES(from, to, even, odd)                                             \
    {{-OUT, -WALL, from}, {-3, 0, to}, even},                                  \
        {{-3, -WALL, from}, {-1, 0, to}, odd},                                 \
        {{-1, -WALL, from}, {1, 0, to}, even},                                 \
        {{1, -WALL, from}, {3, 0, to}, odd},                                   \
    {                                                                          \
        {3, -WALL, from}, {OUT, 0, to}, even                                   \
    }

/* Boxes touch and do not overlap, so no two sides coincide. */
static const view_room_box boxes[VIEW_ROOM_BOXES] = {
    TILES(-OUT, -3, DARK, LIGHT),
    TILES(-3, -1, LIGHT, DARK),
    TILES(-1, 1, DARK, LIGHT),
    TILES(1, 3, LIGHT, DARK),
    TILES(3, OUT, DARK, LIGHT),
    {{-OUT, 4, -OUT}, {OUT, 4 + WALL, OUT}, WHITE}, /* the ceiling */
    /* -X, with two windows: below, above, and three piers */
    {{-OUT, 0, -5}, {-5, 1, 5}, RED},
    {{-OUT, 3, -5}, {-5, 4, 5}, RED},
    {{-OUT, 1, -5}, {-5, 3, -3.8}, RED},
    {{-OUT, 1, -1.2}, {-5, 3, 1.2}, RED},
    {{-OUT, 1, 3.8}, {-5, 3, 5}, RED},
    {{5, 0, -5}, {OUT, 4, 5}, GREEN},      /* +X */
    {{-OUT, 0, -OUT}, {OUT, 4, -5}, BLUE}, /* -Z */
    /* +Z, with two windows */
    {{-OUT, 0, 5}, {OUT, 1, OUT}, YELLOW},
    {{-OUT, 3, 5}, {OUT, 4, OUT}, YELLOW},
    {{-OUT, 1, 5}, {-3.8, 3, OUT}, YELLOW},
    {{-1.2, 1, 5}, {1.2, 3, OUT}, YELLOW},
    {{3.8, 1, 5}, {OUT, 3, OUT}, YELLOW},
    /* pillars */
    {{-2.8, 0, -2.8}, {-2.2, 4, -2.2}, STONE},
    {{2.2, 0, -2.8}, {2.8, 4, -2.2}, STONE},
    {{-2.8, 0, 2.2}, {-2.2, 4, 2.8}, STONE},
    {{2.2, 0, 2.2}, {2.8, 4, 2.8}, STONE},
    {{3, 0, -5}, {3.15, 4, -2.9}, WHITE}, /* a wall in a corner */
    /* panels */
    {{4.95, 0.8, -3.6}, {5, 3.2, -2}, LAMP(5, 1.6f, 0.3f)},
    {{4.95, 0.8, 1}, {5, 3.2, 2.6}, LAMP(0.3f, 2.6f, 4)},
    {{-4, 1.2, -5}, {-1, 2.8, -4.95}, LAMP(4, 3.6f, 3)},
    {{1.4, 0.6, -5}, {2, 3.4, -4.95}, LAMP(4, 0.4f, 2.4f)},
    {{-1.5, 3.95, -3.4}, {1.5, 4, -3}, LAMP(7, 6.6f, 6)},
    {{-1.5, 3.95, 3}, {1.5, 4, 3.4}, LAMP(7, 6.6f, 6)},
};

const view_room_box *view_room_box_at(int i)
{
    return &boxes[i];
}

bool view_room_box_hides(int i)
{
    const view_room_box *box = &boxes[i];

    return box->material.emission[0] <= 0 && box->low[0] > -5 &&
           box->high[0] < 5 && box->low[1] >= 0 && box->low[2] >= -5 &&
           box->high[2] < 5;
}

/* ---- spheres ----------------------------------------------------------- */

/* Each swings along every axis as an independent sine. Phase is in turns. */
static const struct {
    double radius, middle[3], reach[3], seconds[3], phase[3];
    view_room_material material;
} spheres[VIEW_ROOM_SPHERES] = {
    {.radius = 0.6,
     .middle = {0, 0.9, 0},
     .seconds = {1, 1, 1},
     .material = {.f0 = {0.95f, 0.95f, 0.95f}}},
    {.radius = 0.22,
     .middle = {0, 1.1, 0},
     .reach = {1.8, 0.5, 1.8},
     .seconds = {8, 5, 8},
     .phase = {0.25, 0, 0},
     .material = LAMP(12, 5, 1.5f)},
    {.radius = 0.45,
     .middle = {0, 0.45, 3.7},
     .reach = {3.6, 0, 0},
     .seconds = {11, 1, 1},
     .material = {.roughness = 0.25f, .f0 = {1, 0.78f, 0.34f}}},
    {.radius = 0.5,
     .middle = {-3.7, 1.2, 0},
     .reach = {0, 0.7, 2.4},
     .seconds = {1, 3, 13},
     .phase = {0, 0, 0.25},
     .material = MATERIAL(0.05f, 0.2f, 0.55f, 0.3f, 0.04f)},
};

void view_room_sphere(int i, double seconds, double centre[3], double *radius)
{
    const double turn = 2 * M_PI;

    for (int k = 0; k < 3; k++) {
        const double turns =
            seconds / spheres[i].seconds[k] + spheres[i].phase[k];
        centre[k] =
            spheres[i].middle[k] + spheres[i].reach[k] * sin(turn * turns);
    }
    *radius = spheres[i].radius;
}

bool view_room_sphere_moves(int i)
{
    const double *reach = spheres[i].reach;

    return reach[0] != 0 || reach[1] != 0 || reach[2] != 0;
}

const view_room_material *view_room_sphere_material(int i)
{
    return &spheres[i].material;
}
