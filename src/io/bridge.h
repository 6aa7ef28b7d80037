/* SPDX-License-Identifier: MIT */
/* The image bridge: OpenImageIO in a shared object, opened when needed. */
#ifndef IBL_IO_BRIDGE_H
#define IBL_IO_BRIDGE_H

#include "io/bridge/bridge.h"
#include "io/rows.h"

typedef struct ibl_bridge_source {
    const ibl_input *in; /* with bytes */
    char kind[64];       /* of the file, for messages; "": unknown */
    bool is_luma;        /* the channels are Y RY BY, with these weights */
    float luma[3];
    /* The format, the part and the channels; the rest is filled in. */
    ibl_bridge_request request;
} ibl_bridge_source;

/*
 * Opens it for its rows: linear RGB floats, not yet mended; the display window
 * is the map. Fills the rows' report.
 *   source   its input must stay as long as rows
 * IBL_ERR_UNSUPPORTED: the bridge is not there.
 */
ibl_status ibl_bridge_rows(const ibl_bridge_source *source,
                           const ibl_read_options *opts, ibl_rows **rows);

#endif
