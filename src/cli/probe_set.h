/* SPDX-License-Identifier: MIT */
/* A set of reflection probes as SET.json names it: what iblbake-probes(1)
 * says of the file. */
#ifndef CLI_PROBE_SET_H
#define CLI_PROBE_SET_H

#include <stdbool.h>

#include <ibl/ibl.h>
#include <ibl/io.h>
#include <ibl/probes.h>

#include "cli/console.h"
#include "common/json_at.h"

/* Cubes in an array: 2048 layers of six faces is what Direct3D 11 and desktop
 * OpenGL 4 promise. */
#define IBL_MAX_SET_LAYERS 341
#define IBL_SET_VERSION 1
/* Of priorities, the largest and, negative, the least. */
#define IBL_SET_PRIORITY 1000000

typedef enum ibl_capture_kind {
    IBL_CAPTURE_EQUIRECT,
    IBL_CAPTURE_CROSS,
    IBL_CAPTURE_FACES
} ibl_capture_kind;

/* "equirect", "cross" or "faces". */
const char *ibl_capture_name(ibl_capture_kind kind);

typedef struct ibl_capture {
    ibl_capture_kind kind;
    int count;                       /* of files: 1 or 6 */
    char *file[IBL_FACES];           /* relative to the working directory */
    char place[IBL_JSON_PATH_BYTES]; /* "probes[3].capture" */
} ibl_capture;

/* Names of contents: 128 bits of XXH3, as 32 hexadecimal digits. They detect
 * changes, not forgery. */
enum {
    IBL_HASH_SIZE = 33
};

typedef enum ibl_probes_origin {
    IBL_FROM_BAKE,
    IBL_FROM_OLD, /* a layer of the old arrays */
    IBL_FROM_TWIN /* an earlier layer with the same inputs */
} ibl_probes_origin;

/* A probe, or the global environment, and its layer. */
typedef struct ibl_set_entry {
    const char *name; /* "" of the global environment */
    ibl_capture capture;
    ibl_probe probe; /* layer included; unused of the global environment */
    /* While the set is baked: */
    char hash[IBL_HASH_SIZE]; /* of its inputs and options */
    ibl_probes_origin from;
    int source;   /* of the old arrays, or the twin */
    bool alpha;   /* it has not seen everything */
    json_t *note; /* members of its entry in the index */
} ibl_set_entry;

/* How the layers of a set are baked. */
typedef struct ibl_set_bake {
    ibl_bake_options options; /* irradiance's size 0: spherical harmonics in
                                 the index */
    ibl_alpha alpha;          /* of the captures of probes */
    ibl_pixel pixel;
    ibl_overflow overflow;
    ibl_container container;
    int lut_size;
} ibl_set_bake;

typedef struct ibl_probe_set {
    json_t *root; /* has the names */
    ibl_set_bake bake;
    int count;  /* of probes, in the order of ibl_probes_order */
    int layers; /* count, or with the global environment, the last, one more */
    ibl_set_entry *entry; /* of each layer */
} ibl_probe_set;

/* Reads a set; false after one line on stderr. Freed with
 * ibl_probe_set_free, after a failure too. */
bool ibl_probe_set_read(const char *path, ibl_console *console,
                        ibl_probe_set *set);
void ibl_probe_set_free(ibl_probe_set *set);

/* Values of "alpha", and of the option. */
extern const char *const ibl_set_alphas[];

/* Checks and takes a capture: its files as they are named, six or one. */
bool ibl_set_capture(ibl_json_at at, ibl_capture_kind *kind,
                     const char *file[IBL_FACES]);

#endif
