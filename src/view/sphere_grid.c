/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "view/sphere_grid.h"
#include "view/vector.h"

static const double radius = 0.45;

/*
 * F0 of metals: Akenine-Moller et al. 2018, "Real-Time Rendering", 4th edition,
 * table 9.2, linear Rec. 709; their other end is a plastic of that colour. F0
 * of dielectrics is ((n - 1) / (n + 1))^2 of n at 589 nm:
 *   acrylic (PMMA) 1.491, polystyrene 1.590   Sultanova et al. 2003, Optical
 *                                 and Quantum Electronics 35, pp. 21-34
 *   water 1.333     Hale and Querry 1973, Applied Optics 12, pp. 555-563
 *   diamond 2.417   Phillip and Taft 1964, Physical Review 136, A1445
 * Diffuse colours are chosen. Water and diamond have none, and the same F0 at
 * both ends; the metal end of plastics has their colour.
 */
#define GLOSS 0.04 /* other dielectrics: n = 1.5 */

/* clang-format off */
const view_material view_materials[VIEW_MATERIALS] = {
    {{1.000, 0.782, 0.344}, GLOSS, 1}, /* gold */
    {{0.955, 0.638, 0.538}, GLOSS, 1}, /* copper */
    {{0.562, 0.565, 0.578}, GLOSS, 1}, /* iron */
    {{0.972, 0.960, 0.915}, GLOSS, 1}, /* silver */
    {{0.913, 0.922, 0.924}, GLOSS, 1}, /* aluminium */
    {{0.542, 0.497, 0.449}, GLOSS, 1}, /* titanium */
    {{0.60, 0.04, 0.03}, 0.0389, 1}, /* red acrylic */
    {{0.03, 0.10, 0.50}, 0.0389, 1}, /* blue acrylic */
    {{0.80, 0.80, 0.80}, 0.0519, 1}, /* polystyrene */
    {{0.0204, 0.0204, 0.0204}, 0.0204, 0}, /* water */
    {{0.172, 0.172, 0.172}, 0.172, 0}, /* diamond */
    {{1, 1, 1}, GLOSS, 1}, /* white */
};
/* clang-format on */

const char *const view_material_names[VIEW_MATERIALS + 1] = {
    "gold",        "copper",   "iron",        "silver",
    "aluminium",   "titanium", "red acrylic", "blue acrylic",
    "polystyrene", "water",    "diamond",     "white"};

static double mix(double a, double b, double t)
{
    return a + (b - a) * t;
}

static double step(const double range[2], int i, int count)
{
    return count > 1 ? mix(range[0], range[1], i / (count - 1.0)) : range[0];
}

int view_grid(const view_settings *s,
              view_sphere spheres[VIEW_MAX_GRID * VIEW_MAX_GRID])
{
    const view_material *m = &view_materials[s->material];

    for (int i = 0; i < s->rows * s->columns; i++) {
        const int row = i / s->columns, column = i % s->columns;
        view_sphere *p = &spheres[i];
        p->centre[0] = column - 0.5 * (s->columns - 1);
        p->centre[1] = row - 0.5 * (s->rows - 1);
        p->centre[2] = 0;
        p->radius = radius;
        p->metallic = step(s->metallic, row, s->rows);
        p->roughness = step(s->roughness, column, s->columns);
        for (int k = 0; k < 3; k++) {
            p->f0[k] = mix(m->dielectric_f0, m->metal[k], p->metallic);
            p->albedo[k] = m->diffuse * m->metal[k] * (1 - p->metallic);
        }
    }
    return s->rows * s->columns;
}

static const double degree = M_PI / 180;

/* The distance that shows the spheres in the corners, and so all. axes: right,
 * up and back. */
static double fitting_distance(const view_settings *s, const double axes[3][3],
                               double tan_x, double tan_y)
{
    double distance = 0;

    for (int i = 0; i < 4; i++) {
        const double corner[3] = {(i % 2 - 0.5) * (s->columns - 1),
                                  (i / 2 - 0.5) * (s->rows - 1), 0};
        const double w = fabs(dot3(corner, axes[0])) + radius;
        const double h = fabs(dot3(corner, axes[1])) + radius;
        const double needed = dot3(corner, axes[2]) + radius +
                              fmax(w / tan_x, h / tan_y) / (1 - 2 * s->border);
        distance = fmax(distance, needed);
    }
    return distance;
}

view_camera view_camera_of(const view_settings *s, int width, int height)
{
    const bool model = s->mode == VIEW_MODEL;
    const view_pose *file = model ? s->pose : NULL;
    const double yaw = s->yaw * degree, pitch = s->pitch * degree;
    const double orbit[3][3] = {
        {cos(yaw), 0, -sin(yaw)},
        {-sin(yaw) * sin(pitch), cos(pitch), -cos(yaw) * sin(pitch)},
        {sin(yaw) * cos(pitch), sin(pitch), cos(yaw) * cos(pitch)}};
    const double(*axes)[3] = file ? file->axes : orbit;
    double tan_y = tan(0.5 * (file ? file->yfov : s->fov * degree));
    /* The picture holds what the file's does. */
    if (file && file->aspect > 0)
        tan_y *= fmax(file->aspect * height / width, 1);
    const double tan_x = tan_y * width / height;
    /* That shows a sphere of radius 1. */
    const double across = (1 - 2 * s->border) * fmin(tan_x, tan_y);
    const double distance = file              ? sqrt(dot3(file->eye, file->eye))
                            : s->distance > 0 ? s->distance
                            : model           ? sqrt(1 + 1 / (across * across))
                                    : fitting_distance(s, axes, tan_x, tan_y);
    view_camera c = {
        .near = model ? fmax(distance - 1.01, 0.01) : 0.01,
        .far = model ? distance + 1.01 : 1000 + 2 * distance,
        .shift = {2 * s->pixel[0] / width, 2 * s->pixel[1] / height}};

    for (int k = 0; k < 3; k++) {
        /* The point of the pan is in the middle. */
        const double pan = s->pan[0] * axes[0][k] - s->pan[1] * axes[1][k];
        c.eye[k] =
            file ? file->eye[k] : distance * axes[2][k] + model * 2 * pan;
        c.forward[k] = -axes[2][k];
        c.right[k] = tan_x * axes[0][k];
        c.up[k] = tan_y * axes[1][k];
    }
    return c;
}

void view_camera_matrix(const view_camera *c, double matrix[16])
{
    const double w2 = dot3(c->right, c->right), h2 = dot3(c->up, c->up);
    /* Depth d from near to far becomes -1..1: (d a + b) / d. */
    const double a = (c->far + c->near) / (c->far - c->near);
    const double b = -2 * c->far * c->near / (c->far - c->near);
    double rows[4][4];

    for (int k = 0; k < 3; k++) {
        rows[0][k] = c->right[k] / w2 - c->shift[0] * c->forward[k];
        rows[1][k] = c->up[k] / h2 - c->shift[1] * c->forward[k];
        rows[2][k] = a * c->forward[k];
        rows[3][k] = c->forward[k];
    }
    for (int i = 0; i < 4; i++)
        rows[i][3] = -dot3(rows[i], c->eye) + (i == 2 ? b : 0);
    for (int i = 0; i < 16; i++)
        matrix[i] = rows[i % 4][i / 4];
}

void view_turn(double turn_deg, const double world[3], double env[3])
{
    const double c = cos(turn_deg * degree), s = sin(turn_deg * degree);
    const double x = world[0], z = world[2];

    env[0] = c * x - s * z;
    env[1] = world[1];
    env[2] = s * x + c * z;
}
