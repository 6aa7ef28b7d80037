/* SPDX-License-Identifier: MIT */
/* What a probe saw, read and baked. */
#ifndef CLI_CAPTURE_H
#define CLI_CAPTURE_H

#include "cli/console.h"
#include "cli/probe_set.h"

/*
 * What a pixel that was seen has at least, so that what renderers round is not
 * taken for a hole.
 */
#define IBL_CAPTURE_OPAQUE 0.999f

/*
 * Bakes a capture. An equirectangular one row by row, as the bake of the file
 * alone. Of faces and crosses a map is made; level 0 of the specular cube is
 * then not from that but the faces themselves, or the means of their texels,
 * where they are 2^k times as large.
 *   read   of each file
 *   made   empty; the caller's to free with ibl_bake_result_free
 *   alpha  the same, of greys that are alpha: made with the same options if
 *          read asks for alpha and some is below IBL_CAPTURE_OPAQUE, else it
 *          stays empty. Colours in made are multiplied by it then.
 * Alpha that is 0 everywhere is an error.
 */
ibl_status ibl_capture_bake(ibl_ctx *ctx, ibl_console *console, const char *set,
                            const ibl_capture *capture,
                            const ibl_read_options *read,
                            const ibl_bake_options *options,
                            ibl_bake_result *made, ibl_bake_result *alpha);

#endif
