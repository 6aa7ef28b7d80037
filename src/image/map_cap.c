/* SPDX-License-Identifier: MIT */
#include "image/map_cap.h"

#include <math.h>

#include "core/alloc.h"
#include "core/pi.h"
#include "core/vector.h"

static void fill_row(const ibl_map_grid *g, int j)
{
    const double half = IBL_PI / g->width, dtheta = IBL_PI / g->height;
    const double top = j * dtheta, bottom = top + dtheta;
    const double theta = top + 0.5 * dtheta;
    ibl_map_row *row = &g->rows[j];

    row->sine = sin(theta);
    row->cosine = cos(theta);
    row->solid_angle = 4 * half * row->sine * sin(0.5 * dtheta);
    row->side = 2 * sin(half) *
                (0.5 * dtheta + 0.25 * (sin(2 * top) - sin(2 * bottom)));
    row->up = half * (cos(top) - cos(bottom)) * (cos(top) + cos(bottom));
}

bool ibl_map_grid_create(int width, int height, ibl_map_grid *grid)
{
    ibl_map_grid g = {width,
                      height,
                      fmax(2 * IBL_PI / width, IBL_PI / height),
                      ibl_alloc_array((size_t)height, sizeof *g.rows),
                      ibl_alloc_array((size_t)width, 2 * sizeof *g.cosine),
                      NULL};

    if (!g.rows || !g.cosine) {
        ibl_map_grid_free(&g);
        return false;
    }
    g.sine = g.cosine + width;
    for (int j = 0; j < height; j++)
        fill_row(&g, j);
    for (int i = 0; i < width; i++) {
        const double phi = 2 * IBL_PI * ((i + 0.5) / width - 0.5);
        g.cosine[i] = cos(phi);
        g.sine[i] = sin(phi);
    }
    *grid = g;
    return true;
}

void ibl_map_grid_free(ibl_map_grid *grid)
{
    ibl_free(grid->rows);
    ibl_free(grid->cosine);
    *grid = (ibl_map_grid){0};
}

static void direction(const ibl_map_grid *g, int i, int j, double dir[3])
{
    dir[0] = g->rows[j].sine * g->cosine[i];
    dir[1] = g->rows[j].cosine;
    dir[2] = g->rows[j].sine * g->sine[i];
}

void ibl_map_direction(const ibl_map_grid *grid, size_t pixel, double dir[3])
{
    const size_t width = (size_t)grid->width;
    direction(grid, (int)(pixel % width), (int)(pixel / width), dir);
}

void ibl_map_flux(const ibl_map_grid *grid, size_t pixel, double flux[3])
{
    const size_t width = (size_t)grid->width;
    const ibl_map_row *row = &grid->rows[pixel / width];

    flux[0] = row->side * grid->cosine[pixel % width];
    flux[1] = row->up;
    flux[2] = row->side * grid->sine[pixel % width];
}

/* floor(x), in 0..n - 1. */
static int index_below(double x, int n)
{
    return (int)fmin(fmax(floor(x), 0), n - 1);
}

/* Column, from 0 to width, of an azimuth. */
static double column_of(const ibl_map_grid *g, const double dir[3])
{
    return (atan2(dir[2], dir[0]) / (2 * IBL_PI) + 0.5) * g->width;
}

size_t ibl_map_pixel(const ibl_map_grid *grid, const double dir[3])
{
    const double theta = acos(fmin(fmax(dir[1], -1), 1));
    const int i = index_below(column_of(grid, dir), grid->width);
    const int j = index_below(theta / IBL_PI * grid->height, grid->height);
    return (size_t)j * (size_t)grid->width + (size_t)i;
}

/* Columns on either side of the centre's that a row has within the circle: half
 * the angle by the law of cosines. */
static double columns_beside(const ibl_map_grid *g, const ibl_map_row *row,
                             double centre_up, double cos_radius)
{
    const double across = row->sine * sqrt(fmax(1 - centre_up * centre_up, 0));
    const double along = cos_radius - row->cosine * centre_up;

    if (along <= -across)
        return g->width;
    return along >= across ? 0 : acos(along / across) / (2 * IBL_PI) * g->width;
}

void ibl_map_visit_cap(const ibl_map_grid *grid, const double centre[3],
                       double radius, ibl_cap_fn *fn, void *cookie)
{
    const int w = grid->width, h = grid->height;
    const double theta = acos(fmin(fmax(centre[1], -1), 1));
    const double cos_radius = cos(fmin(radius, IBL_PI));
    const double middle = column_of(grid, centre);
    const int first = index_below((theta - radius) / IBL_PI * h - 1, h);
    const int last = index_below((theta + radius) / IBL_PI * h + 1, h);
    ibl_cap_pixel p;

    for (int j = first; j <= last; j++) {
        p.row = &grid->rows[j];
        const double beside =
            columns_beside(grid, p.row, centre[1], cos_radius) + 1;
        const bool whole = 2 * beside + 1 >= w;
        const int from = whole ? 0 : (int)floor(middle - beside) + w;
        const int count = whole ? w : (int)(2 * beside) + 2;
        for (int k = 0; k < count && k < w; k++) {
            const int i = (from + k) % w;
            direction(grid, i, j, p.direction);
            p.cosine = dot3(p.direction, centre);
            p.index = (size_t)j * (size_t)w + (size_t)i;
            if (p.cosine > cos_radius)
                fn(cookie, &p);
        }
    }
}
