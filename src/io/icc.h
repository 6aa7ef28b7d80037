/* SPDX-License-Identifier: MIT */
#ifndef IBL_IO_ICC_H
#define IBL_IO_ICC_H

#include <stdbool.h>
#include <stddef.h>

/*
 * Finds the primaries of an ICC profile (ICC.1:2022) of three colorants. The
 * curve must be that of sRGB. xy: red, green, blue and white. False: it is no
 * such profile, or of primaries other than sRGB's, Display P3's and Rec.
 * 2020's.
 */
bool ibl_icc_primaries(const unsigned char *bytes, size_t size, double xy[8]);

#endif
