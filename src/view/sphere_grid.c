/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stddef.h>

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

int view_grid_hit(const view_sphere *spheres, int count, const double eye[3],
                  const double direction[3], double normal[3])
{
    double nearest = INFINITY;
    int hit = -1;

    for (int i = 0; i < count; i++) {
        const view_sphere *p = &spheres[i];
        double to[3], off[3];
        for (int k = 0; k < 3; k++)
            to[k] = p->centre[k] - eye[k];
        const double along = dot3(to, direction);
        for (int k = 0; k < 3; k++)
            off[k] = along * direction[k] - to[k];
        const double half2 = p->radius * p->radius - dot3(off, off);
        if (half2 < 0)
            continue;
        const double half = sqrt(half2);
        if (along - half <= 0 || along - half >= nearest)
            continue;
        nearest = along - half;
        hit = i;
        for (int k = 0; normal && k < 3; k++)
            normal[k] = (off[k] - half * direction[k]) / p->radius;
    }
    return hit;
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

/* The picture holds what the file's does. */
static view_camera camera_of_file(const view_pose *p, double ratio)
{
    const double tan_y =
        tan(0.5 * p->yfov) * (p->aspect > 0 ? fmax(p->aspect / ratio, 1) : 1);
    const double distance = sqrt(dot3(p->eye, p->eye));
    view_camera c = {.near = fmax(distance - 1.01, 0.01),
                     .far = distance + 1.01};

    for (int k = 0; k < 3; k++) {
        c.eye[k] = p->eye[k];
        c.forward[k] = -p->axes[2][k];
        c.right[k] = tan_y * ratio * p->axes[0][k];
        c.up[k] = tan_y * p->axes[1][k];
    }
    return c;
}

view_camera view_camera_of(const view_settings *s, int width, int height)
{
    const double yaw = s->yaw * degree, pitch = s->pitch * degree;
    const double tan_y = tan(0.5 * s->fov * degree);
    const double tan_x = tan_y * width / height;
    const bool model = s->mode == VIEW_MODEL;
    const double axes[3][3] = {
        {cos(yaw), 0, -sin(yaw)},
        {-sin(yaw) * sin(pitch), cos(pitch), -cos(yaw) * sin(pitch)},
        {sin(yaw) * cos(pitch), sin(pitch), cos(yaw) * cos(pitch)}};
    /* That shows a sphere of radius 1. */
    const double across = (1 - 2 * s->border) * fmin(tan_x, tan_y);
    const double distance = s->distance > 0 ? s->distance
                            : model         ? sqrt(1 + 1 / (across * across))
                                    : fitting_distance(s, axes, tan_x, tan_y);
    view_camera c = {.near = 0.01, .far = 1000 + 2 * distance};

    for (int k = 0; k < 3; k++) {
        c.eye[k] = distance * axes[2][k];
        c.forward[k] = -axes[2][k];
        c.right[k] = tan_x * axes[0][k];
        c.up[k] = tan_y * axes[1][k];
        /* The point of the pan is in the middle. */
        c.eye[k] +=
            model * 2 * (s->pan[0] * axes[0][k] - s->pan[1] * axes[1][k]);
    }
    if (model) {
        c.near = fmax(distance - 1.01, 0.01);
        c.far = distance + 1.01;
    }
    if (model && s->pose)
        c = camera_of_file(s->pose, (double)width / height);
    c.shift[0] = 2 * s->pixel[0] / width;
    c.shift[1] = 2 * s->pixel[1] / height;
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

void view_camera_ray(const view_camera *c, int width, int height, double x,
                     double y, double direction[3])
{
    const double u = 2 * (x + 0.5) / width - 1 + c->shift[0];
    const double v = 1 - 2 * (y + 0.5) / height + c->shift[1];

    for (int k = 0; k < 3; k++)
        direction[k] = c->forward[k] + u * c->right[k] + v * c->up[k];
    normalise3(direction);
}

void view_turn(double turn_deg, const double world[3], double env[3])
{
    const double c = cos(turn_deg * degree), s = sin(turn_deg * degree);
    const double x = world[0], z = world[2];

    env[0] = c * x - s * z;
    env[1] = world[1];
    env[2] = s * x + c * z;
}
