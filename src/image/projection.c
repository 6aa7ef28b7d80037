/* SPDX-License-Identifier: MIT */
/* Where the texels of a level are: cubes and flat maps. */
#include <math.h>
#include <stdlib.h>

#include "core/context.h"
#include "core/pi.h"
#include "image/cube.h"

const char *ibl_projection_name(ibl_projection projection)
{
    static const char *const names[] = {"cube", "equirect", "octahedral"};
    return names[projection];
}

/* The point of the octahedron at u, v, both -1..1. */
static void unfold(double u, double v, double d[3])
{
    const double h = 1 - fabs(u) - fabs(v);
    d[0] = h < 0 ? copysign(1 - fabs(v), u) : u;
    d[1] = h;
    d[2] = h < 0 ? copysign(1 - fabs(u), v) : v;
}

void ibl_level_direction(const ibl_level_shape *s, int face, int x, int y,
                         double dir[3])
{
    const double u = (2 * x + 1) / (double)s->width - 1;
    const double v = (2 * y + 1) / (double)s->height - 1;

    switch (s->projection) {
    case IBL_PROJECTION_CUBE:
        ibl_cube_direction(s->width, face, x, y, dir);
        break;
    case IBL_PROJECTION_EQUIRECT:
        dir[0] = cos(IBL_PI / 2 * v) * cos(IBL_PI * u);
        dir[1] = -sin(IBL_PI / 2 * v);
        dir[2] = cos(IBL_PI / 2 * v) * sin(IBL_PI * u);
        break;
    case IBL_PROJECTION_OCTAHEDRAL: {
        unfold(u, v, dir);
        const double length =
            sqrt(dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2]);
        for (int k = 0; k < 3; k++)
            dir[k] /= length;
        break;
    }
    }
}

/* Solid angle of a triangle of the octahedron with corners of any length: Van
 * Oosterom and Strackee 1983. */
static double triangle(double a[3], double b[3], double c[3])
{
    double *const p[3] = {a, b, c};
    double dot[3], length[3];
    const double volume = a[0] * (b[1] * c[2] - b[2] * c[1]) +
                          a[1] * (b[2] * c[0] - b[0] * c[2]) +
                          a[2] * (b[0] * c[1] - b[1] * c[0]);

    for (int i = 0; i < 3; i++) {
        const double *q = p[i], *r = p[(i + 1) % 3];
        length[i] = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
        dot[i] = q[0] * r[0] + q[1] * r[1] + q[2] * r[2];
    }
    return 2 * atan2(fabs(volume), length[0] * length[1] * length[2] +
                                       dot[0] * length[2] + dot[1] * length[0] +
                                       dot[2] * length[1]);
}

/* Of a texel in the quadrant u, v >= 0. The equator crosses texels along the
 * diagonal, so each half is in one face of the octahedron. */
static double octahedral_angle(double u0, double v0, double u1, double v1)
{
    double corner[4][3];

    unfold(u0, v0, corner[0]);
    unfold(u1, v0, corner[1]);
    unfold(u0, v1, corner[2]);
    unfold(u1, v1, corner[3]);
    return triangle(corner[0], corner[1], corner[2]) +
           triangle(corner[3], corner[1], corner[2]);
}

double ibl_level_solid_angle(const ibl_level_shape *s, int x, int y)
{
    const int n = s->width;

    switch (s->projection) {
    case IBL_PROJECTION_CUBE:
        return ibl_cube_solid_angle(n, x, y);
    case IBL_PROJECTION_EQUIRECT:
        return 4 * IBL_PI / n * sin(IBL_PI / 2 / s->height) *
               sin(IBL_PI * (y + 0.5) / s->height);
    case IBL_PROJECTION_OCTAHEDRAL:
        break;
    }
    x = 2 * x < n ? n - 1 - x : x;
    y = 2 * y < n ? n - 1 - y : y;
    return octahedral_angle(2.0 * x / n - 1, 2.0 * y / n - 1,
                            2.0 * (x + 1) / n - 1, 2.0 * (y + 1) / n - 1);
}

size_t ibl_flat_neighbour(const ibl_level_shape *s, int x, int y)
{
    const int w = s->width, h = s->height;
    const int over = x < 0 ? 0 : x >= w ? w - 1 : x;
    const int under = y < 0 ? 0 : y >= h ? h - 1 : y;

    if (s->projection == IBL_PROJECTION_EQUIRECT)
        return (size_t)under * (size_t)w +
               (size_t)((under == y ? x + w : x + w + w / 2) % w);
    const int column = under == y ? over : w - 1 - over;
    const int row = over == x ? under : h - 1 - under;
    return (size_t)row * (size_t)w + (size_t)column;
}

/* Where a direction is on an image, 0..width and 0..height; returns the face.
 */
static int place_of(const ibl_level_shape *s, const double d[3], double at[2])
{
    const double x = d[0], y = d[1], z = d[2];
    const double sum = fabs(x) + fabs(y) + fabs(z);
    double u = 0, v = 0;
    int face = 0;

    switch (s->projection) {
    case IBL_PROJECTION_CUBE:
        for (int f = 0; f < IBL_FACES; f++) {
            const ibl_face_axes *a = &ibl_face[f];
            const double forward =
                x * a->forward[0] + y * a->forward[1] + z * a->forward[2];
            const double right =
                x * a->right[0] + y * a->right[1] + z * a->right[2];
            const double down =
                x * a->down[0] + y * a->down[1] + z * a->down[2];
            if (forward < fabs(right) || forward < fabs(down))
                continue;
            face = f;
            u = right / forward;
            v = down / forward;
        }
        break;
    case IBL_PROJECTION_EQUIRECT:
        u = atan2(z, x) / IBL_PI;
        v = 2 * atan2(hypot(x, z), y) / IBL_PI - 1;
        break;
    case IBL_PROJECTION_OCTAHEDRAL:
        u = y < 0 ? copysign(1 - fabs(z) / sum, x) : x / sum;
        v = y < 0 ? copysign(1 - fabs(x) / sum, z) : z / sum;
        break;
    }
    at[0] = 0.5 * (u + 1) * s->width;
    at[1] = 0.5 * (v + 1) * s->height;
    return face;
}

static int within(double at, int n)
{
    const int i = (int)floor(at);
    return i < 0 ? 0 : i >= n ? n - 1 : i;
}

void ibl_level_texel(const ibl_level_shape *s, const double dir[3], int to[3])
{
    double at[2];
    to[0] = place_of(s, dir, at);
    to[1] = within(at[0], s->width);
    to[2] = within(at[1], s->height);
}

void ibl_flat_lookup(const ibl_cube *map, int level, const double dir[3],
                     double rgb[3])
{
    const ibl_level_shape s = ibl_map_shape(map, level);
    const float *texels = ibl_cube_face(map, level, 0);
    double at[2];

    place_of(&s, dir, at);
    const double left = floor(at[0] - 0.5), top = floor(at[1] - 0.5);
    const double p = at[0] - 0.5 - left, q = at[1] - 0.5 - top;
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int k = 0; k < 4; k++) {
        const int i = k % 2, j = k / 2;
        const double weight = (i ? p : 1 - p) * (j ? q : 1 - q);
        const float *texel =
            texels + 3 * ibl_flat_neighbour(&s, (int)left + i, (int)top + j);
        for (int c = 0; c < 3; c++)
            rgb[c] += weight * (double)texel[c];
    }
}

typedef struct to_cube {
    const ibl_cube *flat, *cube;
    int level;
} to_cube;

static void cube_row(void *arg, int job, int worker)
{
    const to_cube *t = arg;
    const int n = ibl_cube_edge(t->cube->size, t->level);
    float *to = ibl_cube_face(t->cube, t->level, job / n) +
                3 * (size_t)(job % n) * (size_t)n;

    (void)worker;
    for (int x = 0; x < n; x++, to += 3) {
        double d[3], rgb[3];
        ibl_cube_direction(n, job / n, x, job % n, d);
        ibl_flat_lookup(t->flat, t->level, d, rgb);
        for (int c = 0; c < 3; c++)
            to[c] = (float)rgb[c];
    }
}

ibl_status ibl_cube_from_flat(ibl_ctx *ctx, const ibl_cube *flat,
                              ibl_cube *cube)
{
    ibl_status status = ibl_check_map(ctx, flat);
    if (!status && flat->projection == IBL_PROJECTION_CUBE)
        status = ibl_fail(ctx, IBL_ERR_ARGUMENT, "a cube: must be flat");
    if (!status)
        status = ibl_cube_alloc(ctx, 2 * flat->size, flat->levels, cube);
    if (status)
        return status;
    for (int l = 0; l < flat->levels && !status; l++) {
        to_cube t = {flat, cube, l};
        status = ibl_run(ctx, NULL, IBL_FACES * ibl_cube_edge(cube->size, l),
                         cube_row, &t);
    }
    if (status)
        ibl_cube_free(cube);
    return status;
}
