/* SPDX-License-Identifier: MIT */
/* The index of baked probes, as iblbake-probes(1) has it: a part of
 * probe_set.c, used there alone. Needs no OpenGL. */
#ifndef VIEW_PROBE_INDEX_H
#define VIEW_PROBE_INDEX_H

#include <stdbool.h>

#include "ibl/io.h"
#include "ibl/probes.h"

enum {
    VIEW_PROBE_SH = 9 /* coefficients of irradiance in an index */
};

/* What an index says of an array. */
typedef struct view_probe_array {
    char *path; /* NULL: there is none */
    ibl_pixel pixel;
    int size, levels, layers;
} view_probe_array;

typedef struct view_probe_index {
    int count;
    ibl_probe *probe; /* in the order of ibl_probes_order, with their layers */
    bool holes;       /* of some there are directions that have not been seen */
    view_probe_array specular, irradiance;
    ibl_roughness_map mapping;
    double lod_scale, lod_offset;
    double irradiance_scale; /* times the map, or sh, is E / pi */
    /* Without an irradiance array: of each probe, in order, RGBA of
     * VIEW_PROBE_SH coefficients. */
    double (*sh)[4 * VIEW_PROBE_SH];
} view_probe_index;

/* False, with a message, and *index zeroed. */
bool view_probe_index_read(const char *path, view_probe_index *index);
void view_probe_index_free(view_probe_index *index); /* zeroed is fine */

#endif
