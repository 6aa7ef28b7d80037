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
 * Opens a JPEG, as ibl_reader says; with a gain map: linear, 1 is the white of
 * a plain screen. Colours are in the primaries of the first JPEG's ICC profile,
 * sRGB without one.
 * IBL_ERR_FORMAT: the gain map or what describes it is damaged or cut off.
 * IBL_ERR_UNSUPPORTED: no bridge; a profile or a kind of gain map that is not
 * known.
 */
ibl_status ibl_jpeg_open(ibl_input *in, const ibl_read_options *opts,
                         ibl_rows **rows);

/*
 * Finds the primaries of an ICC profile (ICC.1:2022) of three colorants. The
 * curve must be that of sRGB. xy: red, green, blue and white. False: it is no
 * such profile, or of primaries other than sRGB's, Display P3's and Rec.
 * 2020's.
 */
bool ibl_icc_primaries(const unsigned char *bytes, size_t size, double xy[8]);

#endif
