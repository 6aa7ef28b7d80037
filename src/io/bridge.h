/* SPDX-License-Identifier: MIT */
/* The image bridge: OpenImageIO in a shared object, loaded when needed. */
#ifndef IBL_IO_BRIDGE_H
#define IBL_IO_BRIDGE_H

#include "io/rows.h"

typedef struct ibl_image_kind {
    const char *name;   /* for messages: "PNG" */
    const char *reader; /* OpenImageIO's name of the format */
} ibl_image_kind;

/*
 * Reads a whole image by the bridge: linear RGB floats, not yet mended. Fills
 * in the report of the rows. in   loaded into memory; not needed afterwards
 * IBL_ERR_UNSUPPORTED: the bridge is not installed.
 */
ibl_status ibl_bridge_rows(const ibl_input *in, const ibl_image_kind *kind,
                           const ibl_read_options *opts, ibl_rows **rows);

/* Finds a function of a shared object beside the image bridge, which stays
 * open: threads and statics of C++ libraries do not survive unloading. `call`
 * is a pointer to a pointer to a function. object  its file's name, or NULL for
 * the bridge itself needs   what the file is, for messages: "is PNG" */
ibl_status ibl_bridge_find(const ibl_input *in, const char *object,
                           const char *needs, const char *function, void *call);

#endif
