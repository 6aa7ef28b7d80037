/* SPDX-License-Identifier: MIT */
/* Primaries, exposure and clamp of rows that were repaired: see ibl/io.h. */
#ifndef IBL_IO_COLOUR_H
#define IBL_IO_COLOUR_H

#include <stdbool.h>
#include <stdint.h>

#include "io/rows.h"

typedef struct ibl_colour {
    ibl_rows *rows;
    ibl_primaries primaries;
    bool converts;    /* to other primaries; else the matrix is 1 */
    bool changes;     /* anything at all */
    double matrix[9]; /* of primaries and exposure */
    double luma[3];   /* luminance of the result's R, G and B */
    double clamp;     /* INFINITY: none */
    double *light;    /* two for each row of the map: its luminance before the
                         clamp, and what the clamp took; NULL without clamp */
} ibl_colour;

/* Sets the report's primaries. The caller must free c, after errors too.
 * IBL_ERR_FORMAT: opts wants a conversion, but the file's primaries are no
 * colour space. */
ibl_status ibl_colour_init(ibl_colour *c, const ibl_input *in, ibl_rows *rows,
                           const ibl_read_options *opts);
/* Changes count rows from row `first` of the map. Counts in the report. */
ibl_status ibl_colour_apply(ibl_colour *c, int first, int count, float *rgb);
/* After the last row: sets the report's clamp_removed. */
void ibl_colour_end(const ibl_colour *c);
void ibl_colour_free(ibl_colour *c);

#endif
