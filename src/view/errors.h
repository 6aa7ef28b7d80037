/* SPDX-License-Identifier: MIT */
/* Errors of a picture against another, for each sphere or material. */
#ifndef VIEW_ERRORS_H
#define VIEW_ERRORS_H

#include "view/settings.h"

/* Sums over pixels and their R, G and B. */
typedef struct view_error {
    double difference2, truth2;
    int pixels;
} view_error;

/* sqrt(sum |picture - truth|^2 / sum |truth|^2): -1 without pixels; 0 where
 * both are black, infinite where only truth is. */
double view_error_rmse(view_error e);

/* The sphere that each pixel shows, of the grid row by row from the bottom
 * left; -1: none. Rows from the top. */
void view_errors_spheres(const view_settings *s, int width, int height,
                         int *shown);
/*
 * Sums errors over what is shown, of pictures of linear RGB floats, width *
 * height, rows from the top. Only pixels count whose eight neighbours show the
 * same.
 *   shown   for each pixel 0..count-1, or -1
 *   errors  count
 */
void view_errors(const int *shown, int count, int width, int height,
                 const float *picture, const float *truth, view_error *errors);

#endif
