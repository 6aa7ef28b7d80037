/* SPDX-License-Identifier: MIT */
/*
 * Along the rows of a map: Fourier coefficients of each row, and back. One
 * call is one batch of up to IBL_ROW_GROUP rows on one thread, without
 * allocation: made to be called from jobs, each with its worker's scratch.
 * A row's result depends on nothing but the row.
 *
 * Column i of n is at phi_i = 2 pi (i + 1/2) / n - pi.
 *
 * Rows of a power of two are transformed as they are, exactly (to rounding).
 * Others, and long ones of which few orders are wanted, are first spread
 * onto a ring of a power of two, n >= IBL_ROW_FFT_OVER (orders - 1): pixel i
 * adds its value times g(j - x_i) to sample j, x_i = (i + 1/2) n / width, and
 * the transform of g is divided out of the coefficients. This is the
 * non-uniform FFT of type 1 (Dutt and Rokhlin 1993; g: Barnett, Magland and
 * af Klinteberg 2019), and for width = k n a polyphase decimation. What
 * orders m + k n leak into F_m is at most IBL_ROW_FFT_STOP times the sum of
 * |f_i| of the row.
 */
#ifndef IBL_BAKE_SPECTRAL_ROW_FFT_H
#define IBL_BAKE_SPECTRAL_ROW_FFT_H

#include <stddef.h>

#include "bake/spectral/transform.h"
#include "ibl/ibl.h"
#include "kern/row_block.h"

#define IBL_ROW_FFT_OVER 4    /* samples of the spread ring an order */
#define IBL_ROW_FFT_STOP 1e-7 /* stop band of the spreading */

/* Constant after creation: any number of threads may use one. */
typedef struct ibl_row_fft ibl_row_fft;

/*
 * A plan for rows of width pixels to orders m = 0..orders - 1:
 *     F_m = sum over i of f_i e^(-i m (phi_i - turn_rad))
 * exactly as written also where orders > width / 2.
 *   width     1..IBL_MAX_EDGE, any
 *   orders    1..IBL_SHT_MAX_DEGREE + 1
 *   turn_rad  the azimuth that becomes 0
 * IBL_ERR_MEMORY: *out is NULL.
 */
ibl_status ibl_row_fft_create(ibl_ctx *ctx, int width, int orders,
                              double turn_rad, ibl_row_fft **out);

/*
 * A plan for the way back, orders m = 0..orders - 1 to columns samples:
 *     f_i = Re F_0 + 2 Re sum over m > 0 of F_m e^(i m phi_i)
 *   columns  a power of two, 4..IBL_MAX_EDGE, at least 2 orders
 * IBL_ERR_MEMORY: *out is NULL.
 */
ibl_status ibl_row_fft_create_inverse(ibl_ctx *ctx, int columns, int orders,
                                      ibl_row_fft **out);
void ibl_row_fft_free(ibl_row_fft *plan); /* NULL is fine */

/* Scratch that a call needs, one for each worker: floats, 64-byte aligned,
 * contents irrelevant before and after. */
size_t ibl_row_fft_scratch(const ibl_row_fft *plan);

/* Up to IBL_ROW_GROUP rows of a map. */
typedef struct ibl_row_fft_rows {
    const float *rgb; /* interleaved, finite; row j begins at rgb + j stride */
    size_t stride;    /* floats from row to row */
    int count;        /* 1..IBL_ROW_GROUP */
    float scale;      /* of pixels, first: a power of two */
} ibl_row_fft_rows;

/*
 * Writes F_m of rows to a group of out, in the orders that it has. Lanes
 * without a row become undefined. F_0 is exactly real.
 *   plan  of ibl_row_fft_create, with at least those orders
 */
void ibl_row_fft_forward(const ibl_row_fft *plan, const ibl_row_fft_rows *rows,
                         float *scratch, ibl_row_spectra *out, int group);

/*
 * Writes the samples of rings first_ring..first_ring + count - 1 of in to
 * rgba[0], ...: columns texels of R, G, B, 0 each.
 *   plan        of ibl_row_fft_create_inverse
 *   in          at least the plan's orders; those beyond are ignored
 *   first_ring  a multiple of IBL_ROW_GROUP
 *   count       1..IBL_ROW_GROUP
 */
void ibl_row_fft_inverse(const ibl_row_fft *plan, const ibl_ring_spectra *in,
                         int first_ring, int count, float *scratch,
                         float *const rgba[]);

#endif
