/* SPDX-License-Identifier: MIT */
/*
 * Ultra HDR JPEG: a JPEG of what a plain screen shows, and a second one, the
 * gain map, that says how much brighter each pixel is. The second is found by
 * the index of the Multi-Picture Format (CIPA DC-007).
 */
#ifndef IBL_IO_ULTRA_HDR_H
#define IBL_IO_ULTRA_HDR_H

#include "io/input.h"
#include "io/rows.h"

/*
 * Opens a JPEG with a gain map: linear, 1 is the white of a plain screen. *rows
 * stays NULL if it has none. Colours are in the primaries of the first JPEG's
 * ICC profile, sRGB without one.
 *   in  loaded into memory; must live as long as rows
 * IBL_ERR_FORMAT: the gain map or what describes it is damaged or cut off.
 * IBL_ERR_UNSUPPORTED: no bridge; a profile or a kind of gain map that is not
 * known.
 */
ibl_status ibl_ultra_hdr_open(const ibl_input *in, const ibl_read_options *opts,
                              ibl_rows **rows);

#endif
