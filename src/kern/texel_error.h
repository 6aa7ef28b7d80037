/* SPDX-License-Identifier: MIT */
/* Differences of texels. Every version gives the same sums: it adds the same
 * texels in the same order. */
#ifndef IBL_KERN_TEXEL_ERROR_H
#define IBL_KERN_TEXEL_ERROR_H

#include <stddef.h>

#include "kern/isa.h"

enum {
    IBL_ERROR_LANES = 8
};

/* Sums over the texels i with i % IBL_ERROR_LANES equal to the lane; |.| is
 * over three components, t a true and d another texel. */
typedef struct ibl_error_sums {
    double wrong[IBL_ERROR_LANES];    /* |d - t|^2 */
    double truth[IBL_ERROR_LANES];    /* |t|^2 */
    double relative[IBL_ERROR_LANES]; /* |d - t| / |t|; for |t| = 0 0 if |d| is
                                         0, else 1 */
    double light[IBL_ERROR_LANES];    /* t's components above 0, */
    double lost[IBL_ERROR_LANES];     /* and those of them that are 0 in d */
    double count[IBL_ERROR_LANES];    /* of texels; where |t|^2 is not finite,
                                         they are left out of all sums */
} ibl_error_sums;

typedef struct ibl_texel_error_dsp {
    /* Adds count texels of three floats each to sums. Squares are floats: of
     * less than 1e-23 they are 0. No alignment. */
    void (*add)(const float *t, const float *d, size_t count,
                ibl_error_sums *sums);
} ibl_texel_error_dsp;

IBL_DECLARE_KERNEL(ibl_texel_error);

#endif
