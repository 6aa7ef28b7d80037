/* SPDX-License-Identifier: MIT */
/* A set while it is baked: what the parts of the work share. */
#ifndef CLI_PROBES_BAKE_H
#define CLI_PROBES_BAKE_H

#include "cli/probes.h"

typedef enum ibl_probes_origin {
    IBL_FROM_BAKE,
    IBL_FROM_OLD, /* a layer of the old arrays */
    IBL_FROM_TWIN /* an earlier layer with the same inputs */
} ibl_probes_origin;

/* Where a layer comes from. */
typedef struct ibl_probes_source {
    ibl_probes_origin from;
    int layer; /* of the old arrays, or the twin */
} ibl_probes_source;

enum {
    IBL_PROBES_INDEX = IBL_PROBES_TEXTURES
};

typedef struct ibl_probes_bake {
    const ibl_probes_opts *opts;
    ibl_console *console;
    ibl_ctx *ctx;
    ibl_outputs *outputs;
    ibl_isa isa;
    ibl_probe_set set;
    ibl_bake_options options;
    int layers;
    char *path[IBL_PROBES_TEXTURES + 1]; /* the last: the index */
    char *old_text;                      /* of the index */
    ibl_probes_index old, index;
    bool whole[IBL_PROBES_TEXTURES]; /* the old file is what its index says */
    bool same[IBL_PROBES_TEXTURES + 1]; /* and what we would write */
    ibl_probes_source *source;
    ibl_texture array[2]; /* specular, irradiance; as layers come */
    int held;             /* the output directory, or -1 */
} ibl_probes_bake;

/* IBL_ERR_MEMORY, after a line on stderr. */
ibl_status ibl_probes_no_memory(const ibl_probes_bake *p);
/* Refuses outputs that would replace what they are made from. */
ibl_status ibl_probes_check_input(const ibl_probes_bake *p, const char *input);

/* Waits until no other run is at work in the output directory, and keeps others
 * waiting until it is released. False: there is no such directory. */
bool ibl_probes_hold(ibl_probes_bake *p);
void ibl_probes_release(ibl_probes_bake *p);

/* Finds the hash of each layer and of the table. */
ibl_status ibl_probes_hash_inputs(ibl_probes_bake *p);
/* Reads the old index and sees which of its files are still what it says. */
ibl_status ibl_probes_look_back(ibl_probes_bake *p);
/* Where each layer comes from, and which files stay as they are. */
void ibl_probes_plan(ibl_probes_bake *p);

/* Writes what is not the same: arrays, table, index. */
ibl_status ibl_probes_put(ibl_probes_bake *p);

#endif
