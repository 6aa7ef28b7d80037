/* SPDX-License-Identifier: MIT */
/* Colour spaces, defined by the chromaticities of their primaries. */
#ifndef IBL_IO_COLOUR_SPACE_H
#define IBL_IO_COLOUR_SPACE_H

#include <stdbool.h>

/*
 * Computes a colour space from the xy of red, green, blue and white.
 *   rgb_from_xyz  row-major; R = G = B = Y = 1 for white
 *   luma          weights of R, G and B in Y; may be NULL
 * Returns false if they define no colour space.
 */
bool ibl_colour_space(const double xy[8], double rgb_from_xyz[9],
                      float luma[3]);

/* Converts count pixels of Y, RY = (R - Y) / Y, BY = (B - Y) / Y to R G B. */
void ibl_luma_to_rgb(const float luma[3], float *p, int count);

#endif
