/* SPDX-License-Identifier: MIT */
/* Directions and solid angles of a map's pixels, and those within a circle. */
#ifndef IBL_IMAGE_MAP_CAP_H
#define IBL_IMAGE_MAP_CAP_H

#include <stdbool.h>
#include <stddef.h>

#include "ibl/ibl.h"

typedef struct ibl_map_row {
    double sine, cosine; /* of theta at the middle */
    double solid_angle;  /* of a pixel, exact */
    double side, up;     /* int w dO of a pixel: along its middle's azimuth and
                            along +Y, exact */
} ibl_map_row;

/* A map's directions, without a yaw. */
typedef struct ibl_map_grid {
    int width, height;
    double edge; /* larger edge of a pixel, in radians, at the equator */
    ibl_map_row *rows;
    double *cosine, *sine; /* of the azimuth at the middle of each column */
} ibl_map_grid;

/* False: no memory; then there is nothing to free. */
bool ibl_map_grid_create(int width, int height, ibl_map_grid *grid);
void ibl_map_grid_free(ibl_map_grid *grid); /* zeroed is fine */

/* The direction of a pixel's middle. */
void ibl_map_direction(const ibl_map_grid *grid, size_t pixel, double dir[3]);
/* int w dO over a pixel: its solid angle times its mean direction. */
void ibl_map_flux(const ibl_map_grid *grid, size_t pixel, double flux[3]);
/* The pixel that contains a unit direction. */
size_t ibl_map_pixel(const ibl_map_grid *grid, const double dir[3]);

/* A pixel whose middle is within a circle, and the cosine of its angle from the
 * centre. */
typedef struct ibl_cap_pixel {
    size_t index;
    const ibl_map_row *row;
    double direction[3], cosine;
} ibl_cap_pixel;

typedef void ibl_cap_fn(void *cookie, const ibl_cap_pixel *pixel);

/* Calls fn for each pixel whose middle is less than radius away from centre,
 * always in the same order. */
void ibl_map_visit_cap(const ibl_map_grid *grid, const double centre[3],
                       double radius, ibl_cap_fn *fn, void *cookie);

#endif
