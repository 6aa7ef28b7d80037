/* SPDX-License-Identifier: MIT */
/* Lists of the names that a value may be, each ended by NULL. */
#ifndef COMMON_NAMES_H
#define COMMON_NAMES_H

#include <stddef.h>

/* "a, b or c" */
void ibl_names_text(const char *const *names, char *text, size_t size);
/* The number of a word; -1: it is none of them. */
int ibl_names_find(const char *const *names, const char *word);

/* Options, sets, indices and sidecars have the same words for these: by
 * ibl_container, ibl_pixel (of cubes), ibl_overflow, ibl_roughness_map,
 * ibl_method, ibl_lobe and ibl_geometry. */
extern const char *const ibl_container_names[];
extern const char *const ibl_pixel_names[];
extern const char *const ibl_overflow_names[];
extern const char *const ibl_mapping_names[];
extern const char *const ibl_method_names[];
extern const char *const ibl_lobe_names[];
extern const char *const ibl_geometry_names[];

/* The name of the table's file without its extension, by ibl_geometry. */
extern const char *const ibl_lut_stems[];

#endif
