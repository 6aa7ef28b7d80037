/* SPDX-License-Identifier: MIT */
#ifndef CLI_RESAMPLE_H
#define CLI_RESAMPLE_H

#include <stdio.h>

#include <ibl/ibl.h>

/*
 * Writes an equirectangular map, resampled to width x height, as a Radiance
 * .hdr without run lengths. Reducing takes means over the solid angle;
 * enlarging is bilinear and wraps at the seam. Returns 0 or an errno.
 */
int ibl_resample_write(const ibl_image *env, int width, int height, FILE *to);

#endif
