/* SPDX-License-Identifier: MIT */
/* Finds the brightest source of a map while its rows go by: ibl_brightest. */
#ifndef IBL_IO_BRIGHTEST_H
#define IBL_IO_BRIGHTEST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ibl/io.h"

typedef struct ibl_bright_pixel {
    uint16_t x, y; /* IBL_MAX_EDGE allows it */
    float rgb[3];
} ibl_bright_pixel;

/* Pixels that may belong to the source, in the order of the map. */
typedef struct ibl_bright_pixels {
    int width, height;
    float peak; /* the largest component so far */
    int peak_x, peak_y;
    float dropped; /* pixels below it may be missing, beside the peak too */
    float least;   /* pixels below it are not looked at */
    ibl_bright_pixel *list;
    size_t count, room;
} ibl_bright_pixels;

/* Takes row y; rows must come in order. most: at least the row's largest
 * component, which decides at once about most rows. False: no memory. */
bool ibl_bright_take(ibl_bright_pixels *b, const float *rgb, int y, float most);
void ibl_bright_sum(const ibl_bright_pixels *b, ibl_brightest *out);
void ibl_bright_free(ibl_bright_pixels *b);

#endif
