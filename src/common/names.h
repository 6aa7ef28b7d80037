/* SPDX-License-Identifier: MIT */
/* Lists of the names of values, each ended by NULL. */
#ifndef COMMON_NAMES_H
#define COMMON_NAMES_H

#include "json/text.h"

/* Names in options, sets and sidecars, in the order of their enumerations. */
/* Of containers, then ibl_engine from ENV, then ibl_picture from EXR. */
extern const char *const ibl_format_names[];
extern const char *const ibl_array_container_names[]; /* of those of arrays */
extern const char *const ibl_pixel_names[];           /* of cubes */
extern const char *const ibl_quality_names[];
extern const char *const ibl_overflow_names[];
extern const char *const ibl_mapping_names[]; /* ibl_roughness_map */
extern const char *const ibl_mirror_names[];
extern const char *const ibl_up_names[];
extern const char *const ibl_method_names[];
extern const char *const ibl_projection_names[];
/* The same, and the faces of a cube as one picture. */
extern const char *const ibl_layout_names[];
enum {
    IBL_LAYOUT_CROSS = 3
};
extern const char *const ibl_lobe_names[];
extern const char *const ibl_geometry_names[];
extern const char *const ibl_lut_names[]; /* ibl_lut_kind */
extern const char *const ibl_primaries_names[];
extern const char *const ibl_transfer_names[];
#define IBL_FACE_ORDER_ALLOWED                                                 \
    "px, nx, py, ny, pz and nz in any order, each with /90, /180, /270, /m, "  \
    "/m90, /m180 or /m270 where it is turned"
extern const char *const ibl_input_names[];

/* The LUT's file name without extension, indexed by ibl_geometry. */
extern const char *const ibl_lut_stems[];
/* Indexed by ibl_lut_kind; that of SPLIT is one of ibl_lut_stems. */
extern const char *const ibl_table_stems[];

#endif
