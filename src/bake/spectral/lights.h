/* SPDX-License-Identifier: MIT */
/*
 * The pixels that outshine the rows around them: a sun, a lamp far away. They
 * are taken out of the rows before the analysis.
 */
#ifndef IBL_BAKE_SPECTRAL_LIGHTS_H
#define IBL_BAKE_SPECTRAL_LIGHTS_H

#include <stdbool.h>
#include <stddef.h>

#include "ibl/ibl.h"

enum {
    IBL_LIGHTS_GROUP = 256, /* the most that are taken from a group of rows */
    IBL_LIGHTS_MOST = 1024  /* the most that are kept of all */
};

/* A pixel, and its radiance above what was left in its place. */
typedef struct ibl_pixel_light {
    int row, column;
    float rgb[3];
    double energy; /* of the channels together; the caller's to set */
} ibl_pixel_light;

/* What is known of a group of rows, of each channel. */
typedef struct ibl_row_range {
    float low[3], high[3];
    double mean[3];
} ibl_row_range;

/*
 * Looks at `rows` rows of `width` pixels.
 *   squares  of each row, the sum of squares of what all channels have above
 *            base. Values that are less than 2^-60 of the group's high or of
 *            base may not count.
 */
void ibl_row_range_of(const float *rgb, int width, int rows,
                      const float base[3], ibl_row_range *range,
                      double *squares);

/* Whether a group of so many pixels may have one to be taken out. */
bool ibl_lights_any(const ibl_row_range *range, size_t pixels);

/*
 * Takes the brightest pixels out of rows, if each is 64 times as bright as
 * the others are on average: their mean stays in its place. first_row is the
 * map's row of the first. lights   room for IBL_LIGHTS_GROUP Returns how many
 * there are.
 */
int ibl_lights_take(float *rgb, int width, int rows, int first_row,
                    const ibl_row_range *range, ibl_pixel_light *lights);

#endif
