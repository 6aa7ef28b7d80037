/* SPDX-License-Identifier: MIT */
#include "view/aim.h"

#include <math.h>
#include <stdlib.h>

#include "common/signals.h"
#include "view/message.h"

/* Least share of the light above the mean that the table is made for: less is
 * rounding in an even environment, and would only add noise. */
static const double worth = 1.0 / 64.0;

static size_t cell_of(int edge, int face, int x, int y)
{
    return ((size_t)face * (size_t)edge + (size_t)y) * (size_t)edge + (size_t)x;
}

/* Brightness that chances are proportional to; 0 for negative and non-finite
 * values. */
static double brightness(const float *rgb)
{
    const double b = (double)rgb[0] + (double)rgb[1] + (double)rgb[2];

    return isfinite(b) && b > 0.0 ? b : 0.0;
}

/* Adds the means of the texels whose centres are in each cell. row: room for
 * one row of texels. */
static void pool_face(const ibl_texture *cube, int face, int edge, float *row,
                      float *cells)
{
    const int n = cube->width;
    const size_t row_bytes = (size_t)n * ibl_pixel_bytes(cube->pixel);
    const unsigned char *src = cube->data + ibl_texture_offset(cube, 0, face);
    /* A cell has about (n / edge)^2 texels, so its mean is their sum times its
     * share of the face. */
    const double share = (double)edge / n * ((double)edge / n);

    for (int y = 0; y < n; ++y) {
        const int to = (int)((2LL * y + 1) * edge / (2LL * n));

        ibl_pixel_decode(cube->pixel, src + (size_t)y * row_bytes, (size_t)n,
                         row);
        for (int x = 0; x < n; ++x) {
            const int at = (int)((2LL * x + 1) * edge / (2LL * n));

            cells[cell_of(edge, face, at, to)] +=
                (float)(share * brightness(row + 3 * x));
        }
    }
}

/* The value of a cell, or of the one beyond an edge, on the next face. */
static double value_at(const float *cells, int edge, int face, int x, int y)
{
    if (x < 0 || x >= edge || y < 0 || y >= edge) {
        /* Half a cell beyond the edge: this direction meets the next face, in
         * the same row of cells. */
        const ibl_level_shape shape =
            ibl_level_shape_of(IBL_PROJECTION_CUBE, edge);
        double d[3];
        int at[3];
        ibl_cube_direction(edge, face, x, y, d);
        ibl_level_texel(&shape, d, at);
        face = at[0], x = at[1], y = at[2];
    }
    return cells[cell_of(edge, face, x, y)];
}

/* The value of a cell; at an edge of a face, its mean with the cell of the next
 * face, since filtering crosses the edge and drawing does not. */
static double edge_value(const float *cells, int edge, int face, int x, int y)
{
    double value = value_at(cells, edge, face, x, y);

    if (x == 0 || x == edge - 1)
        value = 0.5 * (value + value_at(cells, edge, face, x ? edge : -1, y));
    if (y == 0 || y == edge - 1)
        value = 0.5 * (value + value_at(cells, edge, face, x, y ? edge : -1));
    return value;
}

/* Stores the light of each cell above the mean. Returns the share of all light
 * that this is. */
static double take_mean_off(const float *cells, int edge, float *light)
{
    const int face_cells = edge * edge;
    double all = 0.0, above = 0.0;

    for (int i = 0; i < 6 * face_cells; ++i) {
        const int x = i % edge, y = i / edge % edge;
        const double value = edge_value(cells, edge, i / face_cells, x, y);

        light[i] = (float)value;
        all += value * ibl_cube_solid_angle(edge, x, y);
    }
    for (int i = 0; i < 6 * face_cells; ++i) {
        const double value = light[i] - all / (4.0 * acos(-1.0));
        const double solid_angle =
            ibl_cube_solid_angle(edge, i % edge, i / edge % edge);

        light[i] = value > 0.0 ? (float)(value * solid_angle) : 0.0F;
        above += light[i];
    }
    return all > 0.0 ? above / all : 0.0;
}

/* The bits at even places of a number, packed. */
static int even_bits(unsigned bits)
{
    unsigned x = 0;

    for (int i = 0; i < 16; ++i)
        x |= (bits >> i) & (1U << i);
    return (int)x;
}

/* Gives each token k the cell where the running sum of light reaches (k + 1/2)
 * / VIEW_AIM_TOKENS of all. Cells follow a Morton curve (Morton 1966), face by
 * face. chance holds light before, chances after. */
static void hand_out(int edge, float *chance, float *tokens)
{
    const size_t count = cell_of(edge, 6, 0, 0);
    double all = 0.0, sum = 0.0;
    unsigned side = 1;
    int token = 0;

    for (size_t i = 0; i < count; ++i)
        all += chance[i];
    while (side < (unsigned)edge)
        side *= 2;
    for (unsigned k = 0; k < 6 * side * side; ++k) {
        const int x = even_bits(k % (side * side));
        const int y = even_bits(k % (side * side) >> 1);
        const int first = token;

        if (x >= edge || y >= edge)
            continue;
        const size_t cell = cell_of(edge, (int)(k / (side * side)), x, y);
        sum += chance[cell];
        while (token < VIEW_AIM_TOKENS &&
               (token + 0.5) * (all / VIEW_AIM_TOKENS) < sum)
            tokens[token++] = (float)cell;
        chance[cell] = (float)(token - first) / VIEW_AIM_TOKENS;
    }
}

void view_aim_make(const ibl_texture *cube, view_aim *aim)
{
    const int edge = cube->width < VIEW_AIM_EDGE ? cube->width : VIEW_AIM_EDGE;
    const size_t count = cell_of(edge, 6, 0, 0);
    float *row = ibl_need(malloc(3 * (size_t)cube->width * sizeof *row));
    float *cells = ibl_need(calloc(count, sizeof *cells));

    *aim = (view_aim){0};
    aim->chance = ibl_need(malloc(count * sizeof *aim->chance));
    aim->tokens = ibl_need(malloc(VIEW_AIM_TOKENS * sizeof *aim->tokens));
    for (int face = 0; face < 6; ++face)
        pool_face(cube, face, edge, row, cells);
    if (take_mean_off(cells, edge, aim->chance) > worth) {
        hand_out(edge, aim->chance, aim->tokens);
        aim->edge = edge;
    }
    if (!aim->edge)
        view_aim_free(aim);
    free(cells);
    free(row);
}

void view_aim_free(view_aim *aim)
{
    free(aim->tokens);
    free(aim->chance);
    *aim = (view_aim){0};
}
