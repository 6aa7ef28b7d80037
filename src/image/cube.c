/* SPDX-License-Identifier: MIT */
#include "image/cube.h"

#include <math.h>
#include <stdlib.h>

#include "core/alloc.h"
#include "core/context.h"
#include "image/image.h"

/* ---- images ------------------------------------------------------------- */

static ibl_status check_size(ibl_ctx *ctx, int width, int height)
{
    if (width < 1 || width > IBL_MAX_EDGE || height < 1 ||
        height > IBL_MAX_EDGE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an image of %dx%d: each edge must be 1 to %d", width,
                        height, IBL_MAX_EDGE);
    return IBL_OK;
}

ibl_status ibl_check_image(ibl_ctx *ctx, const ibl_image *img)
{
    if (!ctx || !img || !img->data)
        return ibl_missing(ctx, "an image or its data");
    return check_size(ctx, img->width, img->height);
}

ibl_status ibl_image_alloc(ibl_ctx *ctx, int width, int height, ibl_image *img)
{
    if (!ctx || !img)
        return ibl_missing(ctx, "ibl_image_alloc: img");
    const ibl_status status = check_size(ctx, width, height);
    if (status)
        return status;
    float *data =
        ibl_alloc_array((size_t)width * (size_t)height, 3 * sizeof *data);
    if (!data)
        return ibl_no_memory(ctx, "an image");
    *img = (ibl_image){width, height, data};
    return IBL_OK;
}

void ibl_image_free(ibl_image *img)
{
    if (!img)
        return;
    ibl_free(img->data);
    *img = (ibl_image){0};
}

/* ---- cubes -------------------------------------------------------------- */

const ibl_face_axes ibl_face[IBL_FACES] = {
    {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, /* +X  ( 1, -v, -u) */
    {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, /* -X  (-1, -v,  u) */
    {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   /* +Y  ( u,  1,  v) */
    {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}}, /* -Y  ( u, -1, -v) */
    {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  /* +Z  ( u, -v,  1) */
    {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}} /* -Z  (-u, -v, -1) */
};

int ibl_cube_most_levels(int size)
{
    int levels = 1;
    for (; size > 1; size /= 2)
        levels++;
    return levels;
}

static ibl_status check_shape(ibl_ctx *ctx, int size, int levels)
{
    if (size < 1 || size > IBL_MAX_CUBE_SIZE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "a cube of size %d: must be 1 to %d", size,
                        IBL_MAX_CUBE_SIZE);
    if (levels < 1 || levels > ibl_cube_most_levels(size))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%d levels of a cube of size %d: must be 1 to %d",
                        levels, size, ibl_cube_most_levels(size));
    return IBL_OK;
}

/* Checks what flat maps need more. */
static ibl_status check_flat(ibl_ctx *ctx, ibl_projection projection, int size,
                             int levels)
{
    if (projection < IBL_PROJECTION_CUBE ||
        projection > IBL_PROJECTION_OCTAHEDRAL)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "projection %d: must be cube (%d), equirect (%d) or "
                        "octahedral (%d)",
                        (int)projection, IBL_PROJECTION_CUBE,
                        IBL_PROJECTION_EQUIRECT, IBL_PROJECTION_OCTAHEDRAL);
    if (projection != IBL_PROJECTION_CUBE && size % (1 << (levels - 1)))
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "%d levels of an %s map of size %d: each must halve "
                        "the one before: take a multiple of %d",
                        levels, ibl_projection_name(projection), size,
                        1 << (levels - 1));
    return IBL_OK;
}

ibl_status ibl_check_map(ibl_ctx *ctx, const ibl_cube *map)
{
    if (!ctx || !map || !map->data)
        return ibl_missing(ctx, "a cube or its data");
    const ibl_status status = check_shape(ctx, map->size, map->levels);
    return status ? status
                  : check_flat(ctx, map->projection, map->size, map->levels);
}

ibl_status ibl_check_cube(ibl_ctx *ctx, const ibl_cube *cube)
{
    const ibl_status status = ibl_check_map(ctx, cube);
    if (!status && cube->projection != IBL_PROJECTION_CUBE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT, "an %s map: must be a cube",
                        ibl_projection_name(cube->projection));
    return status;
}

ibl_status ibl_cube_alloc_as(ibl_ctx *ctx, ibl_projection projection, int size,
                             int levels, ibl_cube *map)
{
    if (!ctx || !map)
        return ibl_missing(ctx, "ibl_cube_alloc: cube");
    ibl_status status = check_shape(ctx, size, levels);
    if (!status)
        status = check_flat(ctx, projection, size, levels);
    if (status)
        return status;
    float *data = ibl_alloc_array(ibl_map_texels(projection, size, levels),
                                  3 * sizeof *data);
    if (!data)
        return ibl_no_memory(ctx, "a cube");
    *map = (ibl_cube){size, levels, data, projection};
    return IBL_OK;
}

ibl_status ibl_cube_alloc(ibl_ctx *ctx, int size, int levels, ibl_cube *cube)
{
    return ibl_cube_alloc_as(ctx, IBL_PROJECTION_CUBE, size, levels, cube);
}

void ibl_cube_free(ibl_cube *cube)
{
    if (!cube)
        return;
    ibl_free(cube->data);
    *cube = (ibl_cube){0};
}

int ibl_cube_edge(int size, int level)
{
    const int edge = size >> level;
    return edge ? edge : 1;
}

size_t ibl_map_texels(ibl_projection projection, int size, int levels)
{
    size_t texels = 0;
    for (int l = 0; l < levels; l++) {
        const ibl_level_shape s =
            ibl_level_shape_of(projection, ibl_cube_edge(size, l));
        texels += ibl_level_texels(&s);
    }
    return texels;
}

size_t ibl_cube_texels(int size, int levels)
{
    return ibl_map_texels(IBL_PROJECTION_CUBE, size, levels);
}

float *ibl_cube_face(const ibl_cube *cube, int level, int face)
{
    const size_t n = (size_t)ibl_cube_edge(cube->size, level);
    return cube->data +
           3 * (ibl_map_texels(cube->projection, cube->size, level) +
                (size_t)face * n * n);
}

void ibl_cube_direction(int size, int face, int x, int y, double dir[3])
{
    const double u = (2 * x + 1) / (double)size - 1;
    const double v = (2 * y + 1) / (double)size - 1;
    const double scale = 1 / sqrt(1 + u * u + v * v);
    const ibl_face_axes *axes = &ibl_face[face];
    for (int i = 0; i < 3; i++)
        dir[i] =
            scale * (axes->forward[i] + u * axes->right[i] + v * axes->down[i]);
}

double ibl_face_angle(double u, double v)
{
    return atan2(u * v, sqrt(1 + u * u + v * v));
}

double ibl_cube_solid_angle(int size, int x, int y)
{
    const double u0 = 2.0 * x / size - 1, u1 = 2.0 * (x + 1) / size - 1;
    const double v0 = 2.0 * y / size - 1, v1 = 2.0 * (y + 1) / size - 1;
    return ibl_face_angle(u1, v1) - ibl_face_angle(u0, v1) -
           ibl_face_angle(u1, v0) + ibl_face_angle(u0, v0);
}

size_t ibl_cube_texel_at(int n, const int d[3])
{
    int face = 0, x = n - 1, y = n - 1;
    for (int k = 0; k < 3; k++)
        if (abs(d[k]) == n)
            face = 2 * k + (d[k] < 0);
    for (int k = 0; k < 3; k++) {
        x += d[k] * ibl_face[face].right[k];
        y += d[k] * ibl_face[face].down[k];
    }
    return ((size_t)face * (size_t)n + (size_t)(y / 2)) * (size_t)n +
           (size_t)(x / 2);
}

static int clamp(int a, int most)
{
    return a < -most ? -most : a > most ? most : a;
}

/* The centre is folded over the edge to the next face, half a texel from the
 * edge. */
size_t ibl_cube_neighbour(int n, int face, int x, int y)
{
    const ibl_face_axes *from = &ibl_face[face];
    const int u = clamp(2 * x + 1 - n, n), v = clamp(2 * y + 1 - n, n);
    int d[3];
    for (int k = 0; k < 3; k++)
        d[k] =
            (n - 1) * from->forward[k] + u * from->right[k] + v * from->down[k];
    return ibl_cube_texel_at(n, d);
}

static size_t octant_texel(int n, int k, ibl_octant_face face, int line, int z)
{
    static const int axes[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    const int *begin = axes[k / 2], *end = axes[(k / 2 + 1) % 4];
    const int *foot = k % 2 ? end : begin, *side = k % 2 ? begin : end;
    const int centre = 1 - n % 2, along = 2 * z + centre;
    const int out = face == IBL_OCTANT_SIDE ? n : 2 * line + centre;
    const int up = face == IBL_OCTANT_SIDE  ? n - 1 - 2 * line
                   : face == IBL_OCTANT_TOP ? n
                                            : -n;
    return ibl_cube_texel_at(n, (int[]){out * foot[0] + along * side[0], up,
                                        out * foot[1] + along * side[1]});
}

ibl_octant_place ibl_octant_place_of(const ibl_cube *cube, int k,
                                     ibl_octant_face face)
{
    const int n = cube->size, lines = face == IBL_OCTANT_SIDE ? n : (n + 1) / 2;
    float *base = cube->data + 3 * octant_texel(n, k, face, 0, 0);
    const float *below =
        cube->data + 3 * octant_texel(n, k, face, lines > 1, 0);
    const float *beside = cube->data + 3 * octant_texel(n, k, face, 0, n > 2);
    return (ibl_octant_place){base, below - base, beside - base};
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
