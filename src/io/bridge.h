/* SPDX-License-Identifier: MIT */
/* The image bridge: OpenImageIO in a shared object, opened when needed. */
#ifndef IBL_IO_BRIDGE_H
#define IBL_IO_BRIDGE_H

#include <stddef.h>

#include "io/rows.h"

typedef struct ibl_bridge_source {
    const char *name; /* stands in messages */
    const unsigned char *bytes;
    size_t size;
    const char *kind;        /* what the file is, for messages; NULL: unknown */
    const char *reader;      /* OpenImageIO's name of the format; NULL: any */
    int subimage;            /* EXR part, else 0 */
    const char *channels[3]; /* NULL: R, G, B or the first; one grey channel
                                stands for all three */
    const char *alpha;       /* with channels, NULL: none */
    const float *luma;       /* they are Y RY BY: the weights; NULL: they are
                                not */
} ibl_bridge_source;

/*
 * Opens it for its rows: linear RGB floats, not yet mended; the display window
 * is the map. Fills the rows' report.
 *   source   its name and bytes must stay as long as rows
 * IBL_ERR_UNSUPPORTED: the bridge is not there.
 */
ibl_status ibl_bridge_rows(ibl_ctx *ctx, const ibl_bridge_source *source,
                           const ibl_read_options *opts, ibl_rows **rows);

#endif
