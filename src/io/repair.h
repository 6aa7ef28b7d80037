/* SPDX-License-Identifier: MIT */
/* Pixels that no radiance has: Inf, NaN and negative values. */
#ifndef IBL_IO_REPAIR_H
#define IBL_IO_REPAIR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "io/rows.h"

typedef struct ibl_repair {
    size_t nonfinite; /* pixels that held Inf or NaN */
    size_t negative;  /* pixels that held a finite value below 0 */
    float peak;       /* largest component after */
} ibl_repair;

/*
 * Mends rows as they come, as ibl_image_read says: the same for any number of
 * threads and any division into calls. -0 becomes 0 and is not counted. Rows
 * that have nothing to mend are only copied once in a while.
 */
typedef struct ibl_mender {
    ibl_rows *rows;
    ibl_repair done; /* so far */
    uint32_t *most;  /* what is known of each row of the map */
    float *above;    /* the last row that was given, as it was */
    float *spare;    /* the next to be above */
    float *ahead;    /* the next row, where it has been read already */
    bool has_ahead;
} ibl_mender;

/* To be freed in any case; the rows stay the caller's. */
ibl_status ibl_mender_init(ibl_mender *m, ibl_rows *rows);
/* The next count rows, which are there. After an error rgb is unspecified. */
ibl_status ibl_mender_read(ibl_mender *m, int count, float *rgb);
void ibl_mender_free(ibl_mender *m);

#endif
