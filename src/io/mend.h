/* SPDX-License-Identifier: MIT */
/* What happens to the pixels of a file, as ibl/io.h says: their repair, then
 * primaries, exposure and clamp, then alpha. */
#ifndef IBL_IO_MEND_H
#define IBL_IO_MEND_H

#include "io/rows.h"

/* What was found in a row of the map. Rows are added up in order, so that sums
 * do not depend on threads. */
typedef struct ibl_row_facts {
    double left;    /* about the sum of the components that are left */
    double removed; /* the sum of the negative ones */
    double light;   /* its luminance before the clamp, and what that took; */
    double clamped_light; /* 0 without clamp */
    /* pixels, as in the report */
    uint32_t nonfinite, negative, outside, clamped;
    uint32_t alpha_nonfinite, alpha_beyond, alpha_hidden;
    float peak, alpha_least, alpha_most;
} ibl_row_facts;

/* Reads rows and mends them. The facts in the rows' report, which it gets with
 * the last row, do not depend on threads or on the division into calls. -0
 * becomes 0 and is not counted. */
typedef struct ibl_mender {
    ibl_rows *rows;
    const char *name; /* of the file */
    bool strict;
    ibl_row_facts *facts; /* of each row of the map */

    /* colours */
    ibl_primaries primaries;
    bool converts;    /* to other primaries; else the matrix is 1 */
    bool changes;     /* anything at all */
    double matrix[9]; /* of primaries and exposure */
    double luma[3];   /* luminance of the result's R, G and B */
    double clamp;     /* INFINITY: none */

    bool straight; /* colours are not multiplied by alpha yet */
} ibl_mender;

/* Sets the report's primaries. The caller must free m, after errors too, and
 * still owns the rows.
 * IBL_ERR_FORMAT: opts wants a conversion, but the file's primaries are no
 * colour space. */
ibl_status ibl_mender_init(ibl_mender *m, const ibl_input *in, ibl_rows *rows,
                           const ibl_read_options *opts);
/* Reads the next count rows; they must exist. rgb is undefined on errors. After
 * the last row warns of what was mended or, if strict, refuses it. */
ibl_status ibl_mender_read(ibl_mender *m, int count, float *rgb);
void ibl_mender_free(ibl_mender *m);

#endif
