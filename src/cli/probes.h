/* SPDX-License-Identifier: MIT */
/* iblbake probes: a set of reflection probes, as iblbake-probes(1) describes
 * SET.json, baked into arrays, and their index. */
#ifndef CLI_PROBES_H
#define CLI_PROBES_H

#include <ibl/probes.h>

#include "cli/console.h"
#include "common/json_at.h"

/* ---- hashes ------------------------------------------------------------- */

/* Names of contents: 128 bits of XXH3, as 32 hexadecimal digits. They detect
 * changes, not forgery. */
enum {
    IBL_HASH_SIZE = 33
};

void ibl_hash_bytes(const void *bytes, size_t size, char hash[IBL_HASH_SIZE]);

/* Of the file that the texture is in a container; see ibl_texture_visit. */
ibl_status ibl_hash_texture(ibl_ctx *ctx, const ibl_texture *tex,
                            ibl_container container, char hash[IBL_HASH_SIZE]);

/* Of a regular file; false with errno if it cannot be read, EINVAL if it is
 * something else than a file. */
bool ibl_hash_file(const char *path, char hash[IBL_HASH_SIZE]);

/* ---- the set ------------------------------------------------------------- */

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

/* Reads a set; false after one line on stderr. Free it with ibl_probe_set_free,
 * after a failure too. */
bool ibl_probe_set_read(const char *path, ibl_console *console,
                        ibl_probe_set *set);
void ibl_probe_set_free(ibl_probe_set *set);

/* Values of "alpha", and of the option. */
extern const char *const ibl_set_alphas[];

/* Checks and takes a capture: its files as they are named, six or one. */
bool ibl_set_capture(ibl_json_at at, ibl_capture_kind *kind,
                     const char *file[IBL_FACES]);

/* ---- options ------------------------------------------------------------ */

typedef struct ibl_probes_opts {
    ibl_common common;
    const char *input;  /* SET.json, or the grid's description */
    const char *output; /* DIR; with grid a file, NULL: standard output */
    int force;
    int grid;
    int sync;
    ibl_set_bake said; /* -1 in fields that keep the set's value */
} ibl_probes_opts;

/* Replaces the set's settings by those of the command line. */
void ibl_probes_override(const ibl_probes_opts *opts, ibl_set_bake *bake);

/* ---- a set while it is baked ------------------------------------------- */

/* The files of a set. */
typedef enum ibl_probes_kind {
    IBL_PROBES_SPECULAR,
    IBL_PROBES_IRRADIANCE,
    IBL_PROBES_LUT,
    IBL_PROBES_INDEX,
    IBL_PROBES_FILES,
    IBL_PROBES_TEXTURES = IBL_PROBES_INDEX,
    IBL_PROBES_ARRAYS = IBL_PROBES_LUT
} ibl_probes_kind;

typedef struct ibl_probes_file {
    char *path; /* NULL: not wanted */
    char *old;  /* the file in the old index if it is unchanged, else NULL */
    char hash[IBL_HASH_SIZE]; /* of its bytes: the old file's until it is
                                 written */
    bool same;                /* the old file is what would be written */
} ibl_probes_file;

#define IBL_PROBES_SH_DEGREE 2

typedef struct ibl_probes_bake {
    const ibl_probes_opts *opts;
    ibl_console *console;
    ibl_ctx *ctx;
    ibl_outputs *outputs;
    ibl_isa isa;
    ibl_probe_set set;
    ibl_specular_layout layout;
    ibl_pixel lut_pixel;
    char lut_inputs[IBL_HASH_SIZE]; /* hash of the inputs of the LUT */
    ibl_probes_file file[IBL_PROBES_FILES];
    ibl_texture array[IBL_PROBES_ARRAYS]; /* as layers come */
    int old_probes, dropped; /* of the old index, and not in the set */
    int held;                /* the output directory, or -1 */
} ibl_probes_bake;

/* Functions return false after a line on stderr. */

/* False: reports that there is no memory. */
bool ibl_probes_no_memory(const ibl_probes_bake *p);
/* Refuses outputs that would replace an input. */
bool ibl_probes_check_input(const ibl_probes_bake *p, const char *input);

/* Waits until no other run works in the output directory, and makes others wait
 * until p->held is closed: the old arrays that one takes layers from must not
 * be replaced, nor the files of two be mixed. Without the directory, does
 * nothing. */
void ibl_probes_hold(ibl_probes_bake *p);

/* How a layer's alpha is read. Nothing lies behind the global environment that
 * could fill in, so its alpha is ignored. */
ibl_alpha ibl_probes_alpha(const ibl_probe_set *set, int layer);

/* Alpha from here on counts as 1, since renderers round it. */
#define IBL_CAPTURE_OPAQUE 0.999f

/* The parts of a capture: colours (multiplied by alpha), and alpha as greys. */
typedef enum ibl_capture_part {
    IBL_CAPTURE_COLOUR,
    IBL_CAPTURE_ALPHA,
    IBL_CAPTURE_PARTS
} ibl_capture_part;

/*
 * Bakes the capture of a layer. An equirectangular one is read row by row, as
 * in the bake of that file. Faces and crosses become a map; level 0 of the
 * specular cube is then not made from the map but is the faces themselves, or
 * the means of their texels, where they are 2^k times as large.
 *   made  empty; the caller's to free with ibl_bake_result_free. Alpha stays
 *         empty unless the layer's is read and some is below
 *         IBL_CAPTURE_OPAQUE.
 * Alpha that is 0 everywhere is an error.
 */
bool ibl_capture_bake(const ibl_probes_bake *p, int layer,
                      ibl_bake_result made[IBL_CAPTURE_PARTS]);

/* Finds the hash of each layer and of the table. */
bool ibl_probes_hash_inputs(ibl_probes_bake *p);
/* Where each layer comes from, and which files stay as they are: by the index
 * that a former run of perhaps another set left, and by those of its files that
 * still are what it says. An index that is missing, damaged, edited or of
 * another version is ignored: then everything is baked again. */
bool ibl_probes_plan(ibl_probes_bake *p);

/* The note of a layer that was baked; for json_decref, NULL: no memory. sum has
 * the overflow of all its cubes and levels as level 0. */
json_t *ibl_probes_note(const ibl_bake_result made[IBL_CAPTURE_PARTS],
                        const ibl_overflow_report *sum);

/* The text of the index; for free(), NULL: no memory. */
char *ibl_probes_index_text(const ibl_probes_bake *p);

/* Run the command; the exit status. */
int ibl_probes_run(const void *settings);
int ibl_probes_grid(const ibl_probes_opts *opts);

#endif
