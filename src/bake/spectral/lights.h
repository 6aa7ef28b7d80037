/* SPDX-License-Identifier: MIT */
/*
 * Pixels that outshine the rows around them, such as a sun or a distant lamp.
 * They are taken out of the rows before the analysis.
 */
#ifndef IBL_BAKE_SPECTRAL_LIGHTS_H
#define IBL_BAKE_SPECTRAL_LIGHTS_H

#include <stdbool.h>
#include <stddef.h>

#include "ibl/ibl.h"

enum {
    IBL_LIGHTS_GROUP = 4096, /* most lights of a group of rows */
    IBL_LIGHTS_MOST = 4096   /* most lights of the whole map */
};

/* A pixel, and its radiance above the value that replaced it. */
typedef struct ibl_pixel_light {
    int row, column;
    float rgb[3];
    double energy; /* of all channels; the caller sets it */
} ibl_pixel_light;

/* Values of a group of rows, for each channel. */
typedef struct ibl_row_range {
    float low[3], high[3];
    double mean[3];
} ibl_row_range;

/* Finds the range of `rows` rows of `width` pixels, at most 2^31 floats. */
void ibl_row_range_of(const float *rgb, int width, int rows,
                      ibl_row_range *range);

/* Most lights that are taken out of rows: 256 at the equator, and as many more
 * towards a pole as pixels are narrower, up to IBL_LIGHTS_GROUP.
 *   height     rows of the map
 *   first_row  the first row's index in the map */
int ibl_lights_most(int height, int first_row, int rows);

/* Whether a group of that many pixels may contain lights, `most` at most. */
bool ibl_lights_any(const ibl_row_range *range, size_t pixels, int most);

/*
 * Takes the brightest pixels out of rows, if each is 64 times as bright as the
 * mean of the rest, which replaces them. Returns their number.
 *   first_row  the first row's index in the map
 *   lights     room for `most`
 */
int ibl_lights_take(float *rgb, int width, int rows, int first_row,
                    const ibl_row_range *range, int most,
                    ibl_pixel_light *lights);

#endif
