/* SPDX-License-Identifier: MIT */
/* iblbake probes: bakes a set of reflection probes, SET.json of
 * iblbake-probes(1), into arrays with an index. */
#ifndef CLI_PROBES_H
#define CLI_PROBES_H

#include <ibl/probes.h>

#include "cli/console.h"
#include "json/json_at.h"

/* ---- the set ------------------------------------------------------------- */

#define IBL_SET_VERSION 1

/* The layer of a probe, or of the global environment. */
typedef struct ibl_set_entry {
    const char *name; /* "": the global environment */
    char *capture;    /* as in ibl_image_read, from the working directory */
    bool cube;        /* the capture is a cross or six faces */
    char place[IBL_JSON_PATH_BYTES]; /* "probes[3].capture" */
    /* When it is baked: */
    bool alpha;   /* the capture has alpha below IBL_CAPTURE_OPAQUE */
    json_t *note; /* members that the bake adds to its entry in the index */
} ibl_set_entry;

/* How the layers of a set are baked. */
typedef struct ibl_set_bake {
    ibl_bake_options options; /* irradiance size 0: spherical harmonics in the
                                 index instead of cubes */
    ibl_alpha alpha;          /* how the alpha of probes' captures is read */
    ibl_texel_options texels;
    ibl_container container;
    int zstd; /* level of Zstandard; 0: none */
    int lut_size;
} ibl_set_bake;

typedef struct ibl_probe_set {
    json_t *root; /* owns the names */
    ibl_set_bake bake;
    int count;  /* of probes, in the order of ibl_probes_order */
    int layers; /* count, plus 1 for the global environment, the last layer */
    ibl_probe *probe;     /* of each, with its layer */
    ibl_set_entry *entry; /* of each layer */
} ibl_probe_set;

/* Reads a set; false after one line on stderr. In both cases the caller must
 * free it with ibl_probe_set_free. */
bool ibl_probe_set_read(const char *path, ibl_console *console,
                        ibl_probe_set *set);
void ibl_probe_set_free(ibl_probe_set *set);

/* How a layer's alpha is read. The global environment's is ignored: there is
 * nothing behind it. */
ibl_alpha ibl_probes_alpha(const ibl_probe_set *set, int layer);

/* ---- options ------------------------------------------------------------ */

enum {
    IBL_MOST_SETS = 4096 /* of one call */
};

typedef struct ibl_probes_opts {
    ibl_common common;
    int count;
    const char *input[IBL_MOST_SETS]; /* SET.json, or a grid's description */
    const char *output; /* DIR; with grid a file or NULL, standard output */
    int force;
    int grid;
    int sync;
    ibl_shard shard;
    ibl_set_bake said; /* fields of options that were given count */
    ibl_given given;
} ibl_probes_opts;

/* Reads "defaults" of a set by the options' table. */
bool ibl_probes_defaults(ibl_json_at at, ibl_set_bake *bake);
/* Replaces the set's settings by those of the command line. */
void ibl_probes_override(const ibl_probes_opts *opts, ibl_set_bake *bake);

/* ---- runs -------------------------------------------------------------- */

/* --grid: writes the set of a grid. False after a line on stderr. */
bool ibl_probes_grid(const ibl_probes_opts *opts, ibl_console *console,
                     ibl_ctx *ctx);
/* Runs the command; returns the exit status. */
int ibl_probes_run(const void *settings);

#endif
