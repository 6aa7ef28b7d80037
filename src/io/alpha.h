/* SPDX-License-Identifier: MIT */
/* Alpha as files have it, mended, and colours multiplied by it. */
#ifndef IBL_IO_ALPHA_H
#define IBL_IO_ALPHA_H

#include <stdbool.h>
#include <stddef.h>

/* What was found so far. */
typedef struct ibl_alpha_count {
    size_t nonfinite; /* pixels with Inf or NaN */
    size_t beyond;    /* pixels below 0 or above 1, by more than rounding */
    size_t hidden;    /* pixels whose colour became 0, of those not straight */
    float lowest, highest; /* finite alpha as it was */
    float least, most;     /* and as it is */
} ibl_alpha_count;

ibl_alpha_count ibl_alpha_count_none(void);

/*
 * Mends `pixels` of alpha and applies it to the colours, as ibl_source_alpha
 * says: they are multiplied if they are straight, and 0 where alpha is.
 */
void ibl_alpha_apply(float *alpha, float *rgb, size_t pixels, bool straight,
                     ibl_alpha_count *count);

#endif
