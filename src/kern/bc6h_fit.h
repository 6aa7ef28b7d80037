/* SPDX-License-Identifier: MIT */
/*
 * What the encoder of BC6H computes most often, for one block. All versions
 * give the same bits: sums of 16 texels x add in the order
 *     s_i = (x_i + x_i+8) + (x_i+4 + x_i+12),   (s_0 + s_1) + (s_2 + s_3).
 */
#ifndef IBL_KERN_BC6H_FIT_H
#define IBL_KERN_BC6H_FIT_H

#include "kern/bc6h.h"
#include "kern/bc6h_modes.h"

enum {
    IBL_BC6H_TEXELS = IBL_BLOCK_TEXELS
};

/*
 * A block. Colours are mixed linearly in u, 0..65535, which are half floats'
 * bits times 64/31: nearly logarithms. A small difference there, times itself
 * and slope, is what it adds to the error.
 */
typedef struct ibl_bc6h_texels {
    float rgb[3][IBL_BC6H_TEXELS];
    float weight[IBL_BC6H_TEXELS]; /* of |decoded - rgb|^2 */
    float mean[3];                 /* of u */
    float u[3][IBL_BC6H_TEXELS];   /* minus mean */
    float slope[3][IBL_BC6H_TEXELS];
    float slope_u[3][IBL_BC6H_TEXELS];
    float y[3][IBL_BC6H_TEXELS]; /* u in units of equal error */
} ibl_bc6h_texels;

/* For a channel of a region's texels, each with a share b of the second
 * endpoint: the sums of slope times 1, u, b, b b and u b. */
typedef struct ibl_bc6h_sums {
    float one, u, b, bb, ub;
} ibl_bc6h_sums;

/* For each partition: the direction in y along which each region is longest,
 * not normalised, and the error to expect. */
typedef struct ibl_bc6h_guesses {
    float axis[2][3][IBL_BC6H_PARTITIONS];
    float error[IBL_BC6H_PARTITIONS];
} ibl_bc6h_guesses;

typedef struct ibl_bc6h_fit {
    /*
     * Gives each texel its nearest colour, the first of equals, and returns the
     * sum of the errors, each with a relative error of 2^-19.
     *   ends    unquantised endpoints, two of each region
     *   second  texels of the second region, as in ibl_bc6h_partitions; 0:
     *           there is only one region, and indices have 4 bits
     */
    float (*assign)(const ibl_bc6h_texels *t, const int ends[4][3],
                    unsigned second, int index[IBL_BC6H_TEXELS]);
    /* sums[1] only with a second region. */
    void (*sum)(const ibl_bc6h_texels *t, const float b[IBL_BC6H_TEXELS],
                unsigned second, ibl_bc6h_sums sums[2][3]);
    void (*guess)(const ibl_bc6h_texels *t, ibl_bc6h_guesses *guesses);
} ibl_bc6h_fit;

/* The encoder by means of these. */
void ibl_bc6h_encode(const ibl_bc6h_fit *fit, const float *texels, size_t count,
                     ibl_quality quality, unsigned char *blocks);

#endif
