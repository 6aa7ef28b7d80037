/* SPDX-License-Identifier: MIT */
/* Colour spaces, defined by the chromaticities of their primaries. */
#ifndef IBL_IO_COLOUR_SPACE_H
#define IBL_IO_COLOUR_SPACE_H

#include <stdbool.h>

#include "ibl/io.h"

/*
 * Computes a colour space from the xy of red, green, blue and white.
 *   rgb_from_xyz  row-major; R = G = B = Y = 1 for white
 *   luma          weights of R, G and B in Y; may be NULL
 * Returns false if they define no colour space.
 */
bool ibl_colour_space(const double xy[8], double rgb_from_xyz[9],
                      float luma[3]);

/* The xy of red, green, blue and white. primaries: none of them is "keep". */
const double *ibl_primaries_xy(ibl_primaries primaries);

/* "Rec.709", "ACES2065-1", ...; NULL: no usual ones. Accepts what is 0.002 away
 * in x or y, more than files round. */
const char *ibl_colour_space_name(const double xy[8]);

/* The xy of a colorPrimaries of KTX2, NULL: not known; and the reverse, for
 * ibl_texture. */
const double *ibl_khronos_xy(int number);
int ibl_khronos_number(const double xy[8]);

/*
 * Computes the matrix (row-major) from one RGB to another. White becomes white,
 * by Bradford's adaptation (Lam 1985; the matrix of ICC.1:2022, annex E).
 * luma: of the result; may be NULL. False: one of them is no colour space.
 */
bool ibl_colour_matrix(const double from[8], const double to[8],
                       double matrix[9], float luma[3]);

#endif
