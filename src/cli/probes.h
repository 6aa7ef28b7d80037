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
    /* What the command line says in place of the set; -1: nothing. */
    int container, pixel, overflow, size, levels;
    int irradiance; /* edge; 0: spherical harmonics */
    int alpha;      /* ibl_alpha */
} ibl_probes_opts;

typedef enum ibl_probes_file {
    IBL_PROBES_SPECULAR,
    IBL_PROBES_IRRADIANCE,
    IBL_PROBES_LUT,
    IBL_PROBES_TEXTURES /* how many there are */
} ibl_probes_file;

#define IBL_PROBES_SH_DEGREE 2
#define IBL_PROBES_SH_NUMBERS (3 * 9)

/* What the index notes of a layer. */
typedef struct ibl_probes_layer {
    char hash[IBL_HASH_SIZE];         /* of its inputs and options */
    size_t saturated;                 /* values beyond what the pixel holds */
    ibl_overflow_level beyond;        /* of all its levels together */
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

/* Does what the options ask for. The exit status. */
int ibl_probes_run(const void *settings);
int ibl_probes_grid(const ibl_probes_opts *opts);

#endif
