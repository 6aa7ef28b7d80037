/* SPDX-License-Identifier: MIT */
/* Repairs values that radiance and alpha cannot have, as ibl/io.h says. */
#ifndef IBL_IO_REPAIR_H
#define IBL_IO_REPAIR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "io/rows.h"

/* Reads rows and mends their Inf, NaN and negative values. The counts in the
 * rows' report do not depend on threads or on the division into calls. -0
 * becomes 0 and is not counted. */
typedef struct ibl_mender {
    ibl_rows *rows;
    uint32_t *most;     /* of each row of the map that was read: the bits of its
                           largest component, or IBL_INFINITE_BITS */
    const float *above; /* the row above the next one, before its repair */
    float *before[2];   /* rows before their repair, used alternately */
    int turn;
    float *ahead; /* the next row, if has_ahead */
    bool has_ahead;
    double light;   /* about the sum of the components that are left */
    double removed; /* the sum of the negative ones */
    float *below;   /* of each row of the map, that sum */
} ibl_mender;

/* The caller must free m, after errors too, and still owns the rows. */
ibl_status ibl_mender_init(ibl_mender *m, ibl_rows *rows);
/* Reads the next count rows; they must exist. rgb is undefined on errors. */
ibl_status ibl_mender_read(ibl_mender *m, int count, float *rgb);
void ibl_mender_free(ibl_mender *m);

typedef struct ibl_alpha_range {
    float lowest, highest;
} ibl_alpha_range;

/* Mends alpha and counts in report. Multiplies straight colours by alpha; other
 * colours become black where alpha is 0. range: extended by the finite values
 * before repair. */
void ibl_alpha_mend(float *alpha, float *rgb, size_t pixels, bool straight,
                    ibl_alpha_range *range, ibl_read_report *report);

#endif
