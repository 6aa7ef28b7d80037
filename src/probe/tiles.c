/* SPDX-License-Identifier: MIT */
/*
 * All computations are in (x, y, w) of clip space. There a tile is the cone of
 * four rays (x, y, 1) from the origin for every camera, a box a parallelepiped
 * (flat without perspective) and a sphere an ellipsoid. Convex bodies are apart
 * if and only if a plane separates them. If one is a cone, the plane can go
 * through the origin; its normal n has n'p >= 0 on the rays and n'p < 0 on the
 * body.
 *
 *   box     the candidates are the cone's faces, the box's faces, and planes
 *           along an edge of each (the separating axis theorem)
 *   sphere  a plane misses the sphere if n'Dn > 0, D = bb' - r^2 AA', with the
 *           matrix (A t) to (x, y, w) and the centre b. These normals are a
 *           cone. It meets the cone of normals with n'p >= 0 on the rays in one
 *           of the latter's edges or faces, or lies inside it.
 *
 * Rounding must not separate bodies that touch: margins are `tiny` times the
 * size of the terms compared.
 */
#include <math.h>
#include <string.h>

#include "core/vector.h"
#include "ibl/probes.h"

static const double tiny = 1e-12;

/* A volume in (x, y, w). */
struct body {
    bool round;
    double centre[3];
    double size;       /* bound of |x| + |y| + |w| in the body */
    double edge[3][3]; /* of a box: half of each edge, as vectors */
    double d[3][3];    /* of a sphere: D, with margin */
    double apex[3];    /* of a sphere: n with n'Dn > 0, if there is any */
};

/* Rays of a tile, in order around it, and the inward normals of the faces
 * between each ray and the next. */
struct cone {
    double ray[4][3];
    double face[4][3];
};

static double size3(const double v[3])
{
    return fabs(v[0]) + fabs(v[1]) + fabs(v[2]);
}

/* Entry (row, column) of the 3x4 matrix from the world to (x, y, w). */
static double entry(const ibl_tiles *tiles, int row, int column)
{
    return tiles->clip[4 * column + (row < 2 ? row : 3)];
}

/* x is m^-1 v times the determinant of m, which is symmetric. */
static void solve(double m[3][3], const double v[3], double x[3])
{
    double adjoint[3][3];

    for (int i = 0; i < 3; i++)
        cross3(m[(i + 1) % 3], m[(i + 2) % 3], adjoint[i]);
    for (int i = 0; i < 3; i++)
        x[i] = dot3(adjoint[i], v);
}

static void make_round(struct body *body, double a[3][3], double radius)
{
    const double margin = tiny * body->size * body->size;
    double squares[3][3];

    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            squares[i][j] = radius * radius * dot3(a[i], a[j]);
            body->d[i][j] = body->centre[i] * body->centre[j] -
                            squares[i][j] * (1 + tiny) - (i == j ? margin : 0);
        }
    }
    solve(squares, body->centre, body->apex);
    for (int i = 0; i < 3; i++)
        body->apex[i] = -body->apex[i];
}

static void make_body(const ibl_tiles *tiles, const ibl_volume *volume,
                      struct body *body)
{
    double a[3][3];

    *body = (struct body){.round = volume->shape == IBL_SHAPE_SPHERE};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            const double half = volume->half[body->round ? 0 : j];

            a[i][j] = entry(tiles, i, j);
            body->edge[j][i] = a[i][j] * half;
            body->size += fabs(a[i][j]) * (fabs(volume->centre[j]) + half);
        }
        body->size += fabs(entry(tiles, i, 3));
        body->centre[i] = dot3(a[i], volume->centre) + entry(tiles, i, 3);
    }
    if (body->round)
        make_round(body, a, volume->half[0]);
}

/* n'Dm */
static double form(const struct body *body, const double n[3],
                   const double m[3])
{
    return n[0] * dot3(body->d[0], m) + n[1] * dot3(body->d[1], m) +
           n[2] * dot3(body->d[2], m);
}

/* Whether the whole body is on the negative side of the plane n. */
static bool behind(const struct body *body, const double n[3])
{
    const double middle = dot3(n, body->centre);

    if (body->round)
        return middle < 0 && form(body, n, n) > 0;
    const double half = fabs(dot3(n, body->edge[0])) +
                        fabs(dot3(n, body->edge[1])) +
                        fabs(dot3(n, body->edge[2]));

    return middle + half < -tiny * size3(n) * body->size;
}

/* Whether the plane n or -n separates body and cone. A ray that n was made from
 * is in the plane, but rounding may put it on either side: hence the margin. */
static bool separates(const struct body *body, const struct cone *cone,
                      const double n[3])
{
    const double minus[3] = {-n[0], -n[1], -n[2]};
    const double margin = 0.1 * tiny * size3(n);
    bool above = true, below = true;

    for (int i = 0; i < 4; i++) {
        const double side = dot3(n, cone->ray[i]);

        above = above && side >= -margin;
        below = below && side <= margin;
    }
    return (above && behind(body, n)) || (below && behind(body, minus));
}

static bool box_apart(const struct body *body, const struct cone *cone)
{
    double n[3];

    for (int i = 0; i < 3; i++) {
        cross3(body->edge[i], body->edge[(i + 1) % 3], n);
        if (separates(body, cone, n))
            return true;
        for (int k = 0; k < 4; k++) {
            cross3(body->edge[i], cone->ray[k], n);
            if (separates(body, cone, n))
                return true;
        }
    }
    return false;
}

/* Whether a plane a + s b, s > 0, has the sphere behind it, if neither a nor b
 * has: tries the maximum of n'Dn, a parabola in s. */
static bool sphere_apart_along(const struct body *body, const double a[3],
                               const double b[3])
{
    const double aa = form(body, a, a), bb = form(body, b, b);
    const double ab = form(body, a, b);

    return aa <= 0 && bb < 0 && ab > 0 && ab * ab > aa * bb &&
           ab * dot3(b, body->centre) - bb * dot3(a, body->centre) < 0;
}

static bool sphere_apart(const struct body *body, const struct cone *cone)
{
    for (int i = 0; i < 4; i++) {
        if (sphere_apart_along(body, cone->face[i], cone->face[(i + 1) % 4]))
            return true;
    }
    return separates(body, cone, body->apex);
}

/* The cone of the tile from (left, bottom) to (right, top), -1..1. */
static void make_cone(double left, double bottom, double right, double top,
                      struct cone *cone)
{
    const double ray[4][3] = {
        {left, bottom, 1}, {right, bottom, 1}, {right, top, 1}, {left, top, 1}};
    const double face[4][3] = {
        {0, 1, -bottom}, {-1, 0, right}, {0, -1, top}, {1, 0, -left}};

    memcpy(cone->ray, ray, sizeof ray);
    memcpy(cone->face, face, sizeof face);
}

static bool touches(const struct body *body, const struct cone *cone)
{
    for (int i = 0; i < 4; i++) {
        if (behind(body, cone->face[i]))
            return false;
    }
    return !(body->round ? sphere_apart(body, cone) : box_apart(body, cone));
}

/* The beginning of tile i, -1..1. */
static double tile_at(int i, int tile, int edge)
{
    const double at = (double)i * tile;

    return at < edge ? 2 * at / edge - 1 : 1;
}

static int tiles_over(int edge, int tile)
{
    return (edge - 1) / tile + 1;
}

int ibl_tiles_columns(const ibl_tiles *tiles)
{
    return tiles_over(tiles->width, tiles->tile);
}

int ibl_tiles_rows(const ibl_tiles *tiles)
{
    return tiles_over(tiles->height, tiles->tile);
}

/* Sets the bit in the tiles that the body touches. */
static void cull(const ibl_tiles *tiles, const struct body *body,
                 unsigned long long bit, unsigned long long *masks)
{
    const int columns = ibl_tiles_columns(tiles), rows = ibl_tiles_rows(tiles);
    struct cone cone;

    for (int row = 0; row < rows; row++) {
        const double bottom = tile_at(row, tiles->tile, tiles->height);
        const double top = tile_at(row + 1, tiles->tile, tiles->height);

        make_cone(-1, bottom, 1, top, &cone);
        if (!touches(body, &cone))
            continue;
        for (int column = 0; column < columns; column++) {
            make_cone(tile_at(column, tiles->tile, tiles->width), bottom,
                      tile_at(column + 1, tiles->tile, tiles->width), top,
                      &cone);
            if (touches(body, &cone))
                masks[(size_t)row * (size_t)columns + (size_t)column] |= bit;
        }
    }
}

ibl_status ibl_tiles_cull(const ibl_tiles *tiles, const ibl_probe *probes,
                          int count, unsigned long long *masks)
{
    struct body body;

    if (!tiles || !masks || (!probes && count))
        return IBL_ERR_ARGUMENT;
    if (tiles->width < 1 || tiles->width > IBL_MAX_EDGE || tiles->height < 1 ||
        tiles->height > IBL_MAX_EDGE || tiles->tile < 1 || count < 0 ||
        count > IBL_MAX_TILE_PROBES)
        return IBL_ERR_ARGUMENT;
    memset(masks, 0,
           sizeof *masks * (size_t)ibl_tiles_columns(tiles) *
               (size_t)ibl_tiles_rows(tiles));
    for (int i = 0; i < count; i++) {
        make_body(tiles, &probes[i].influence, &body);
        cull(tiles, &body, 1ULL << i, masks);
    }
    return IBL_OK;
}
