/* SPDX-License-Identifier: MIT */
/* iblbake probes: a set of probes baked into arrays, and their index. */
#ifndef CLI_PROBES_H
#define CLI_PROBES_H

#include "cli/common_options.h"
#include "cli/console.h"
#include "cli/probe_hash.h"
#include "cli/probe_set.h"

typedef struct ibl_probes_opts {
    ibl_common common;
    const char *input;  /* SET.json, or the grid's description */
    const char *output; /* DIR; with grid a file, NULL: standard output */
    int force;
    int grid;
    int sync;
    ibl_set_bake said; /* in place of the set's; -1: nothing */
} ibl_probes_opts;

/* The files of a set. */
typedef enum ibl_probes_file {
    IBL_PROBES_SPECULAR,
    IBL_PROBES_IRRADIANCE,
    IBL_PROBES_LUT,
    IBL_PROBES_INDEX,
    IBL_PROBES_FILES,
    IBL_PROBES_TEXTURES = IBL_PROBES_INDEX,
    IBL_PROBES_ARRAYS = IBL_PROBES_LUT
} ibl_probes_file;

#define IBL_PROBES_SH_DEGREE 2
#define IBL_PROBES_SH_NUMBERS (3 * 9)

/* What the index notes of a layer. */
typedef struct ibl_probes_layer {
    char hash[IBL_HASH_SIZE];         /* of its inputs and options */
    size_t overflow_values;           /* values beyond what the pixel holds */
    ibl_overflow_level overflow;      /* of all its levels together */
    double sh[IBL_PROBES_SH_NUMBERS]; /* irradiance / pi, if asked for */
    bool alpha;                       /* it has not seen everything */
    double alpha_sh[IBL_PROBES_SH_NUMBERS / 3]; /* as sh, of alpha */
} ibl_probes_layer;

/* A file of the set; its name is without the directory, "" where there is
 * none. */
typedef struct ibl_probes_texture {
    char name[32];
    char hash[IBL_HASH_SIZE];   /* of its bytes */
    char inputs[IBL_HASH_SIZE]; /* of what it was made from: the LUT */
} ibl_probes_texture;

/* What an index says, or will say. */
typedef struct ibl_probes_index {
    int layers;
    int probes, dropped; /* of one that was read, and those of them that the
                            set has no more */
    ibl_probes_layer *layer;
    ibl_probes_texture file[IBL_PROBES_TEXTURES];
} ibl_probes_index;

void ibl_probes_index_free(ibl_probes_index *index);

/* Reads what a former run of perhaps another set left in a directory; text is
 * the file's (to be freed) and index what it says. Silently empty where there
 * is none or it is damaged, of another version or edited: then everything is
 * baked again. */
void ibl_probes_index_read(const char *path, const ibl_probe_set *set,
                           char **text, ibl_probes_index *index);

/* The text of an index; to be freed, NULL: no memory. options are those of
 * the specular cubes. */
char *ibl_probes_index_text(const ibl_probe_set *set,
                            const ibl_probes_index *index,
                            const ibl_specular_options *options, ibl_isa isa);

/* Of the table of a set. */
ibl_pixel ibl_probes_lut_pixel(const ibl_set_bake *bake);

/* ---- a set while it is baked ------------------------------------------- */

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

typedef struct ibl_probes_bake {
    const ibl_probes_opts *opts;
    ibl_console *console;
    ibl_ctx *ctx;
    ibl_outputs *outputs;
    ibl_isa isa;
    ibl_probe_set set;
    ibl_bake_options options;
    int layers;
    char *path[IBL_PROBES_FILES];
    char *old_text; /* of the index */
    ibl_probes_index old, index;
    bool whole[IBL_PROBES_TEXTURES]; /* the old file is what its index says */
    bool same[IBL_PROBES_FILES];     /* and what we would write */
    ibl_probes_source *source;
    ibl_texture array[IBL_PROBES_ARRAYS]; /* as layers come */
    int held;                             /* the output directory, or -1 */
} ibl_probes_bake;

/* IBL_ERR_MEMORY, after a line on stderr. */
ibl_status ibl_probes_no_memory(const ibl_probes_bake *p);
/* Refuses outputs that would replace what they are made from. */
ibl_status ibl_probes_check_input(const ibl_probes_bake *p, const char *input);

/* Waits until no other run works in the output directory, and makes others wait
 * until p->held is closed: the old arrays that one takes layers from must not
 * be replaced, nor the files of two be mixed. False: there is no such
 * directory. */
bool ibl_probes_hold(ibl_probes_bake *p);

/* How a layer's alpha is read. Nothing lies behind the global environment that
 * could fill in, so its alpha is ignored. */
ibl_alpha ibl_probes_alpha(const ibl_probe_set *set, int layer);

/* Finds the hash of each layer and of the table. */
ibl_status ibl_probes_hash_inputs(ibl_probes_bake *p);
/* Reads the old index and sees which of its files are still what it says. */
ibl_status ibl_probes_look_back(ibl_probes_bake *p);
/* Where each layer comes from, and which files stay as they are. */
void ibl_probes_plan(ibl_probes_bake *p);

/* Writes what is not the same: arrays, table, index. */
ibl_status ibl_probes_put(ibl_probes_bake *p);

/* Does what the options ask for. The exit status. */
int ibl_probes_run(const void *settings);
int ibl_probes_grid(const ibl_probes_opts *opts);

#endif
