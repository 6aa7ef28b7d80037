/* SPDX-License-Identifier: MIT */
#include <assert.h>
#include <string.h>

#include "bake/spectral/resample.h"
#include "core/alloc.h"
#include "core/context.h"

ibl_status ibl_ring_grid_alloc(ibl_ctx *ctx, int rings, int columns,
                               ibl_ring_grid *grid)
{
    assert(rings >= 1 && rings <= IBL_MAX_EDGE && columns >= 4 &&
           columns <= IBL_MAX_EDGE && !(columns & (columns - 1)));
    grid->rings = rings;
    grid->columns = columns;
    grid->stride = 4 * ((size_t)columns + 2 * IBL_GRID_BORDER);
    const size_t rows = (size_t)rings + 2 * IBL_GRID_BORDER;
    if (grid->room / grid->stride >= rows)
        return IBL_OK;
    ibl_free(grid->data);
    grid->data = ibl_alloc_array(rows, grid->stride * sizeof *grid->data);
    grid->room = rows * grid->stride;
    if (!grid->data) {
        *grid = (ibl_ring_grid){0};
        return ibl_no_memory(ctx, "a grid of rings");
    }
    return IBL_OK;
}

void ibl_ring_grid_free(ibl_ring_grid *grid)
{
    if (!grid)
        return;
    ibl_free(grid->data);
    *grid = (ibl_ring_grid){0};
}

int ibl_ring_grid_behind(const ibl_ring_grid *grid, int row, bool *turned)
{
    const int around = 2 * grid->rings;
    row = (row % around + around) % around;
    *turned = row >= grid->rings;
    return *turned ? around - 1 - row : row;
}

/* Writes a row with its border from column `shift` on of another. */
static void copy_ring(const ibl_ring_grid *grid, const float *from, int shift,
                      float *to)
{
    const int n = grid->columns;
    for (int i = -IBL_GRID_BORDER; i < n + IBL_GRID_BORDER; i++)
        memcpy(to + 4 * i, from + 4 * (size_t)((i + shift + 2 * n) & (n - 1)),
               4 * sizeof *to);
}

static void close_ring(const ibl_ring_grid *grid, int ring)
{
    const int n = grid->columns, rings = grid->rings;
    float *row = ibl_ring_grid_at(grid, ring);
    for (int i = 0; i < IBL_GRID_BORDER; i++) {
        memcpy(row + 4 * (i - IBL_GRID_BORDER),
               row + 4 * (size_t)((i - IBL_GRID_BORDER + n) & (n - 1)),
               4 * sizeof *row);
        memcpy(row + 4 * ((size_t)n + i), row + 4 * (size_t)(i & (n - 1)),
               4 * sizeof *row);
    }
    for (int i = 0; i < 2 * IBL_GRID_BORDER; i++) {
        const int at = i < IBL_GRID_BORDER ? i - IBL_GRID_BORDER
                                           : rings + i - IBL_GRID_BORDER;
        bool turned;
        if (ibl_ring_grid_behind(grid, at, &turned) == ring)
            copy_ring(grid, row, turned ? n / 2 : 0,
                      ibl_ring_grid_at(grid, at));
    }
}

void ibl_ring_grid_close(const ibl_ring_grid *grid, int first, int count)
{
    for (int ring = first; ring < first + count; ring++)
        close_ring(grid, ring);
}
