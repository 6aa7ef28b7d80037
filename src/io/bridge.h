/* SPDX-License-Identifier: MIT */
/* The image bridge: OpenImageIO in a shared object, opened when needed. */
#ifndef IBL_IO_BRIDGE_H
#define IBL_IO_BRIDGE_H

#include <stddef.h>

#include "ibl/io.h"

typedef struct ibl_bridge_source {
    const char *name; /* stands in messages */
    const unsigned char *bytes;
    size_t size;
    const char *kind;        /* what the file is, for messages; NULL: unknown */
    const char *reader;      /* OpenImageIO's name of the format; NULL: any */
    int subimage;            /* EXR part, else 0 */
    const char *channels[3]; /* NULL: R, G, B or the first; one grey channel
                                stands for all three */
} ibl_bridge_source;

/*
 * Decodes to linear RGB floats, not yet mended; the display window is the
 * map. Fills report->format (unless the caller has), low_range and bridged.
 * IBL_ERR_UNSUPPORTED: the bridge is not there.
 */
ibl_status ibl_bridge_decode(ibl_ctx *ctx, const ibl_bridge_source *source,
                             const ibl_read_options *opts, ibl_image *img,
                             ibl_read_report *report);

#endif
