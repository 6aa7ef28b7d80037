/* SPDX-License-Identifier: MIT */
#include "image/upsample.h"

#include <math.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/pi.h"
#include "image/image.h"

enum {
    MIN_COLUMNS = 512 /* keeps strips short; ibl_cube_from_latlong documents it
                         for interpolation */
};

static int ceil_div(int a, int b)
{
    return (a + b - 1) / b;
}

/* Position of a fine row between the centres of two source rows, 0..1. *above:
 * the upper one, -1 beyond the zenith. */
static double between_rows(const ibl_upsample *f, int row, int *above)
{
    const double y = (row + 0.5) / f->scale_y - 0.5;
    *above = (int)floor(y);
    return y - *above;
}

/*
 * Rows differ in solid angle, so a linear weight t of the lower row would give
 * pixels more or less light than they have: a sun next to a pole 8 % more. With
 * t + bend t (1 - t) each row gets, between its centre and the next, exactly
 * the solid angle from its centre to the border. bend is at most 1/4, at the
 * poles. The weights stay in 0..1 and sum to 1. Beyond a pole the same row
 * continues.
 */
static void bend_rows(ibl_upsample *f)
{
    double missing = 0, room = 0, top = 1;
    int pair = -1;
    for (int row = 0; row < f->rows; row++) {
        int above;
        const double t = between_rows(f, row, &above);
        const double bottom = cos(IBL_PI * (row + 1) / f->rows);
        if (above != pair)
            missing = room = 0;
        pair = above;
        missing += ((t > 0.5) - t) * (top - bottom);
        room += t * (1 - t) * (top - bottom);
        if (pair >= 0 && pair < f->height - 1 && room > 0)
            f->bend[pair + 1] = missing / room;
        top = bottom;
    }
}

static ibl_octant_tap column_tap(const ibl_upsample *f, int column)
{
    if (!f->bilinear) {
        const int at = 3 * (column / f->scale_x);
        return (ibl_octant_tap){{at, at}, 0};
    }
    const double x = (column + 0.5) / f->scale_x - 0.5;
    const int left = (int)floor(x);
    return (ibl_octant_tap){
        {3 * ibl_wrap(left, f->width), 3 * ibl_wrap(left + 1, f->width)},
        x - left};
}

/* A quarter turn has n texels, and the middle one of a face is 2/n wide. */
ibl_status ibl_upsample_init(ibl_ctx *ctx, int width, int height, int n,
                             ibl_upsample *f)
{
    *f = (ibl_upsample){.width = width, .height = height};
    f->bilinear = width < 4 * n || height < 2 * n;
    const int columns = 4 * n > MIN_COLUMNS ? 4 * n : MIN_COLUMNS;
    f->scale_x = width < columns ? ceil_div(columns, width) : 1;
    f->scale_y = height < 2 * n ? ceil_div(2 * n, height) : 1;
    /* An even number of columns: half a turn beyond a pole is whole columns. */
    if (f->bilinear && width % 2 && f->scale_x % 2)
        f->scale_x++;
    f->columns = width * f->scale_x;
    f->rows = height * f->scale_y;
    if (f->scale_x == 1 && f->scale_y == 1)
        return IBL_OK;
    f->taps = ibl_alloc_array((size_t)f->columns, sizeof *f->taps);
    f->bend = ibl_alloc_zeroed((size_t)height + 1, sizeof *f->bend);
    if (!f->taps || !f->bend) {
        ibl_upsample_free(f);
        return ibl_no_memory(ctx, "level 0's tables");
    }
    for (int i = 0; i < f->columns; i++)
        f->taps[i] = column_tap(f, i);
    if (f->bilinear)
        bend_rows(f);
    return IBL_OK;
}

void ibl_upsample_free(ibl_upsample *f)
{
    ibl_free(f->taps);
    ibl_free(f->bend);
    *f = (ibl_upsample){0};
}

ibl_octant_blend ibl_upsample_between(const ibl_upsample *f, int row,
                                      int source[2])
{
    ibl_octant_blend r = {
        .weight = {1, 0}, .columns = f->columns, .taps = f->taps};
    source[0] = source[1] = row;
    if (!f->bilinear)
        return r;
    int above;
    const double t = between_rows(f, row, &above);
    const double lower = t + f->bend[above + 1] * t * (1 - t);
    const int turn = f->columns / 2;
    r.weight[0] = 1 - lower;
    r.weight[1] = lower;
    source[0] = above;
    source[1] = above + 1;
    if (above < 0) {
        source[0] = 0;
        r.turn[0] = turn;
    }
    if (above + 1 >= f->height) {
        source[1] = f->height - 1;
        r.turn[1] = turn;
    }
    return r;
}
