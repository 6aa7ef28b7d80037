/* SPDX-License-Identifier: MIT */
/* Repairs values that no radiance or alpha has, as ibl/io.h says. */
#ifndef IBL_IO_REPAIR_H
#define IBL_IO_REPAIR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "io/rows.h"

/* Reads rows and mends their Inf, NaN and negative values, which it counts in
 * the rows' report: the same for any number of threads and any division into
 * calls. -0 becomes 0 and is not counted. */
typedef struct ibl_mender {
    ibl_rows *rows;
    uint32_t *most;     /* ibl_max_finite of each row of the map */
    const float *above; /* the last row of the last call, before its repair */
    float *before[2];   /* rows before their repair, in turns */
    int turn;
    float *ahead; /* the next row, where it has been read already */
    bool has_ahead;
} ibl_mender;

/* To be freed in any case; the rows stay the caller's. */
ibl_status ibl_mender_init(ibl_mender *m, ibl_rows *rows);
/* The next count rows, which are there. After an error rgb is unspecified. */
ibl_status ibl_mender_read(ibl_mender *m, int count, float *rgb);
void ibl_mender_free(ibl_mender *m);

typedef struct ibl_alpha_range {
    float lowest, highest;
} ibl_alpha_range;

/* Mends alpha, applies it to the colours, which it multiplies if they are
 * straight, and counts in report. range: finite alpha before its repair. */
void ibl_alpha_mend(float *alpha, float *rgb, size_t pixels, bool straight,
                    ibl_alpha_range *range, ibl_read_report *report);

#endif
