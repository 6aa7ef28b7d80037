/* SPDX-License-Identifier: MIT */
/* Error of a picture of the spheres against another. */
#ifndef VIEW_ERRORS_H
#define VIEW_ERRORS_H

#include "view/settings.h"

/*
 * Relative root mean square error of picture against truth over each sphere,
 *     sqrt(sum |picture - truth|^2 / sum |truth|^2),
 * over R, G and B of linear RGB floats, width * height, rows from the top. Only
 * pixels count that, with their eight neighbours, show that sphere alone. -1
 * where there are none; 0 where both are black, infinite where only truth is.
 *   rmse   of each sphere of the grid, row by row from the bottom left
 * Returns how many: rows * columns.
 */
int view_errors(const view_settings *s, int width, int height,
                const float *picture, const float *truth, double *rmse);

#endif
