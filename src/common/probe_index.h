/* SPDX-License-Identifier: MIT */
/* The index.json of baked probes, as iblbake-probes(1) describes it. */
#ifndef COMMON_PROBE_INDEX_H
#define COMMON_PROBE_INDEX_H

#include <ibl/io.h>

#include "json/json_at.h"

/* As many as a cube array has layers for. */
#define IBL_INDEX_PROBES (IBL_MAX_LAYERS / IBL_FACES)

enum {
    IBL_INDEX_VERSION = 1,
    IBL_INDEX_SH = 9 /* coefficients of irradiance */
};

/* The textures of a set, and their keys in the index. */
enum {
    IBL_INDEX_SPECULAR,
    IBL_INDEX_IRRADIANCE,
    IBL_INDEX_LUT,
    IBL_INDEX_FILES
};
extern const char *const ibl_index_keys[IBL_INDEX_FILES];

typedef struct ibl_index_file {
    const char *name;          /* beside the index; NULL: there is none */
    const char *hash, *inputs; /* "": not said */
    int zstd;
    ibl_pixel pixel;
    int size, levels, layers;
} ibl_index_file;

typedef struct ibl_probe_index {
    ibl_index_file file[IBL_INDEX_FILES]; /* texts are the JSON's */
    int filament; /* levels are linear in r (2 - r), not in roughness r */
    double lod_scale, lod_offset;
    double irradiance_scale; /* texel * scale = E / pi */
    int count;
    ibl_probe probe[IBL_INDEX_PROBES]; /* in the order of ibl_probes_order */
    bool holes;                        /* of a probe that has not seen all */
    /* RGBA of the harmonics of irradiance of each layer, for free(); NULL: it
     * is a file. */
    double (*sh)[4 * IBL_INDEX_SH];
} ibl_probe_index;

/* Takes an index from file, which is open; ignores the global environment.
 * False: reported. The caller must free index->sh either way. */
bool ibl_probe_index_take(const ibl_json_file *file, ibl_probe_index *index);

#endif
