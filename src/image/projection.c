/* SPDX-License-Identifier: MIT */
/* Where the texels of a level are: cubes and flat maps. */
#include <math.h>
#include <stdlib.h>

#include "core/pi.h"
#include "image/cube.h"

const char *ibl_projection_name(ibl_projection projection)
{
    static const char *const names[] = {"cube", "equirect", "octahedral"};
    return names[projection];
}

ibl_level_shape ibl_level_shape_of(ibl_projection projection, int n)
{
    static const struct {
        int width, height, faces;
    } times[] = {{1, 1, IBL_FACES}, {4, 2, 1}, {2, 2, 1}};
    return (ibl_level_shape){projection, times[projection].width * n,
                             times[projection].height * n,
                             times[projection].faces};
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
