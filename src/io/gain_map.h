/* SPDX-License-Identifier: MIT */
/*
 * What a gain map means: the metadata of Android ("Ultra HDR Image Format
 * v1.1", XMP properties hdrgm:) and of ISO 21496-1 (binary).
 */
#ifndef IBL_IO_GAIN_MAP_H
#define IBL_IO_GAIN_MAP_H

#include <stdbool.h>
#include <stddef.h>

/* HDR = (SDR + base_offset) * 2^(min + (max - min) g^(1 / gamma)) - offset, for
 * a display that shows all of it; g is 0..1. */
typedef struct ibl_gain_map {
    double min[3], max[3]; /* log2 of the gain */
    double gamma[3];
    double base_offset[3], offset[3];
    bool of_base_space; /* gains are of the base image's colour space */
} ibl_gain_map;

/* Both return NULL, or why the metadata is not accepted, for the middle of a
 * sentence. xmp: a text ended by 0. */
const char *ibl_gain_map_of_xmp(char *xmp, ibl_gain_map *g);
const char *ibl_gain_map_of_iso(const unsigned char *bytes, size_t size,
                                ibl_gain_map *g);

#endif
