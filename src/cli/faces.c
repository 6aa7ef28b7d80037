/* SPDX-License-Identifier: MIT */
#include "cli/faces.h"

#include <math.h>

const int ibl_cross_place[IBL_FACES][2] = {{2, 1}, {0, 1}, {1, 0},
                                           {1, 2}, {1, 1}, {3, 1}};

void ibl_face_direction(int face, double u, double v, double dir[3])
{
    const double d[IBL_FACES][3] = {{1, -v, -u}, {-1, -v, u}, {u, 1, v},
                                    {u, -1, -v}, {u, -v, 1},  {-u, -v, -1}};
    for (int k = 0; k < 3; k++)
        dir[k] = d[face][k];
}

int ibl_face_point(const double dir[3], double *u, double *v)
{
    const double x = dir[0], y = dir[1], z = dir[2];
    double s, t, m;
    int face;

    if (fabs(x) >= fabs(y) && fabs(x) >= fabs(z))
        face = x < 0, m = fabs(x), s = x < 0 ? z : -z, t = -y;
    else if (fabs(y) >= fabs(z))
        face = 2 + (y < 0), m = fabs(y), s = x, t = y < 0 ? -z : z;
    else
        face = 4 + (z < 0), m = fabs(z), s = z < 0 ? -x : x, t = -y;
    *u = s / m;
    *v = t / m;
    return face;
}

ibl_texel ibl_face_texel(int size, const double dir[3])
{
    double u, v;
    const int face = ibl_face_point(dir, &u, &v);

    return (ibl_texel){face,
                       (int)fmin(fmax(floor((u + 1) / 2 * size), 0), size - 1),
                       (int)fmin(fmax(floor((v + 1) / 2 * size), 0), size - 1)};
}

bool ibl_face_neighbour(int n, ibl_texel at, int dx, int dy, ibl_texel *to)
{
    const double u = 2 * (at.x + dx + 0.5) / n - 1;
    const double v = 2 * (at.y + dy + 0.5) / n - 1;
    double d[3];

    if (fabs(u) > 1 && fabs(v) > 1)
        return false;
    ibl_face_direction(at.face, u, v, d);
    if (fabs(u) > 1 || fabs(v) > 1) {
        /* Fold to half a texel from the edge on the next face. */
        d[at.face / 2] *= 1 - 1.0 / n;
        for (int k = 0; k < 3; k++)
            d[k] = fmax(-1, fmin(d[k], 1));
    }
    *to = ibl_face_texel(n, d);
    return true;
}

ibl_texel ibl_level_hit(const ibl_level_shape *s, const double dir[3])
{
    int at[3];
    if (s->projection == IBL_PROJECTION_CUBE)
        return ibl_face_texel(s->width, dir);
    ibl_level_texel(s, dir, at);
    return (ibl_texel){at[0], at[1], at[2]};
}

bool ibl_level_neighbour(const ibl_level_shape *s, ibl_texel at, int dx, int dy,
                         ibl_texel *to)
{
    if (s->projection == IBL_PROJECTION_CUBE)
        return ibl_face_neighbour(s->width, at, dx, dy, to);
    const size_t i = ibl_flat_neighbour(s, at.x + dx, at.y + dy);
    const size_t width = (size_t)s->width;
    *to = (ibl_texel){0, (int)(i % width), (int)(i / width)};
    return true;
}

void ibl_mean_rgb(const float *image, int width, int x0, int x1, int y0, int y1,
                  double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int y = y0; y < y1; y++) {
        const float *p = image + 3 * ((size_t)y * (size_t)width + (size_t)x0);
        for (int k = 0; k < 3 * (x1 - x0); k++)
            rgb[k % 3] += (double)p[k];
    }
    for (int c = 0; c < 3; c++)
        rgb[c] /= (double)(x1 - x0) * (y1 - y0);
}
