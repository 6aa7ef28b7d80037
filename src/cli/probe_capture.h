/* SPDX-License-Identifier: MIT */
/* The capture of a probe, read and baked. */
#ifndef CLI_PROBE_CAPTURE_H
#define CLI_PROBE_CAPTURE_H

#include "cli/console.h"
#include "cli/probe_set.h"

/* Alpha from here on counts as 1, since renderers round it. */
#define IBL_CAPTURE_OPAQUE 0.999f

/* What a capture has: colours (multiplied by alpha), and alpha as greys. */
typedef enum ibl_capture_part {
    IBL_CAPTURE_COLOUR,
    IBL_CAPTURE_ALPHA,
    IBL_CAPTURE_PARTS
} ibl_capture_part;

/*
 * Bakes a capture. An equirectangular one row by row, as the bake of the file
 * alone. Faces and crosses become a map; level 0 of the specular cube is then
 * not from that but the faces themselves, or the means of their texels, where
 * they are 2^k times as large.
 *   read  of each file
 *   made  empty; the caller's to free with ibl_bake_result_free. Alpha stays
 *         empty unless read asks for it and some is below IBL_CAPTURE_OPAQUE
 * Alpha that is 0 everywhere is an error.
 */
ibl_status ibl_capture_bake(ibl_ctx *ctx, ibl_console *console, const char *set,
                            const ibl_capture *capture,
                            const ibl_read_options *read,
                            const ibl_bake_options *options,
                            ibl_bake_result made[IBL_CAPTURE_PARTS]);

#endif
