/* SPDX-License-Identifier: MIT */
/* iblbake probes: bakes a set of reflection probes, SET.json of
 * iblbake-probes(1), into arrays with an index. */
#ifndef CLI_PROBES_H
#define CLI_PROBES_H

#include <ibl/probes.h>

#include "cli/console.h"
#include "cli/hash.h"
#include "cli/shard.h"
#include "json/json_at.h"

/* ---- the set ------------------------------------------------------------- */

#define IBL_SET_VERSION 1

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
    const char *name; /* "": the global environment */
    ibl_capture capture;
    ibl_probe probe; /* with its layer; unused for the global environment */
    /* While the set is baked: */
    char hash[IBL_HASH_SIZE]; /* of its inputs and options */
    ibl_probes_origin from;
    int source;   /* layer of the old arrays, or the twin's */
    int whole;    /* with --shard: its layer in the whole set */
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
    ibl_set_entry *entry; /* of each layer */
} ibl_probe_set;

/* Reads a set; false after one line on stderr. In both cases the caller must
 * free it with ibl_probe_set_free. */
bool ibl_probe_set_read(const char *path, ibl_console *console,
                        ibl_probe_set *set);
void ibl_probe_set_free(ibl_probe_set *set);
/* Drops the layers that another shard owns, and numbers the others anew. */
void ibl_probe_set_keep(ibl_probe_set *set, const int *owner, int shard);

/* Values of "alpha" in a set and of --alpha, ended by NULL. */
extern const char *const ibl_set_alphas[];

/* Checks and reads a capture: its kind and the names of its 1 or 6 files, as
 * they are in the JSON. */
bool ibl_set_capture(ibl_json_at at, ibl_capture_kind *kind,
                     const char *file[IBL_FACES]);

/* ---- options ------------------------------------------------------------ */

typedef struct ibl_probes_opts {
    ibl_common common;
    const char *input;  /* SET.json, or the grid's description */
    const char *output; /* DIR; with grid a file or NULL, standard output */
    int force;
    int grid;
    int sync;
    ibl_shard shard;
    ibl_set_bake said; /* -1 in fields not given: the set's value stays */
    ibl_given given;
} ibl_probes_opts;

/* Replaces the set's settings by those of the command line. */
void ibl_probes_override(const ibl_probes_opts *opts, ibl_set_bake *bake);

/* ---- a set while it is baked ------------------------------------------- */

/* The files of a set, and their keys in its index. */
typedef enum ibl_probes_kind {
    IBL_PROBES_SPECULAR,
    IBL_PROBES_IRRADIANCE,
    IBL_PROBES_LUT,
    IBL_PROBES_INDEX,
    IBL_PROBES_FILES,
    IBL_PROBES_TEXTURES = IBL_PROBES_INDEX,
    IBL_PROBES_ARRAYS = IBL_PROBES_LUT
} ibl_probes_kind;
extern const char *const ibl_probes_keys[IBL_PROBES_TEXTURES];

typedef struct ibl_probes_file {
    char *path; /* NULL: not wanted */
    char *old;  /* the file that the old index names; NULL: none or changed */
    char hash[IBL_HASH_SIZE]; /* of its bytes; before it is written, of the old
                                 file's */
    bool same;                /* the old file is already what is wanted */
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
    char whole[IBL_HASH_SIZE];      /* with --shard: of the whole set and the
                                       options */
    ibl_probes_file file[IBL_PROBES_FILES];
    ibl_texture array[IBL_PROBES_ARRAYS]; /* filled layer by layer */
    int old_probes, dropped; /* in the old index; of these, not in the set */
    int held;                /* of ibl_probes_hold, on the output directory */
} ibl_probes_bake;

/* Functions return false after a line on stderr. */

/* Reports that memory ran out; returns false. */
bool ibl_probes_no_memory(const ibl_probes_bake *p);
/* Starts the context and the outputs; makes and locks the output directory. */
bool ibl_probes_start(ibl_probes_bake *p);
/* Copies layer `source` of an array into a layer of p->array. */
bool ibl_probes_copy_layer(ibl_probes_bake *p, int kind, int layer, int source,
                           const ibl_texture *array);
/* Hashes and writes a texture that has all keys but that of alpha, which
 * follows from the entries of the set. tex may be empty afterwards. */
bool ibl_probes_put_texture(ibl_probes_bake *p, ibl_probes_kind kind,
                            ibl_texture *tex);
void ibl_probes_free(ibl_probes_bake *p);
/* Fails if an output would replace this input. */
bool ibl_probes_check_input(const ibl_probes_bake *p, const char *input);

/* Locks a directory with flock's LOCK_EX or LOCK_SH until the result is closed;
 * waits for another run that holds the lock. So no run replaces the old arrays
 * while another copies their layers, and files of two runs do not mix.
 * -1: the directory does not exist. */
int ibl_probes_hold(ibl_console *console, const char *directory, int lock);

/* How a layer's alpha is read. The global environment's is ignored: there is
 * nothing behind it. */
ibl_alpha ibl_probes_alpha(const ibl_probe_set *set, int layer);

/* Alpha of at least this counts as 1, since renderers round it. */
#define IBL_CAPTURE_OPAQUE 0.999f

/* The parts of a capture: colours (multiplied by alpha), and alpha as greys. */
typedef enum ibl_capture_part {
    IBL_CAPTURE_COLOUR,
    IBL_CAPTURE_ALPHA,
    IBL_CAPTURE_PARTS
} ibl_capture_part;

/*
 * Bakes the capture of a layer. An equirectangular one is read row by row.
 * Faces and crosses become a map; but if their edge is 2^k times the specular
 * cube's, level 0 is the faces (k = 0) or means of their texels.
 *   made  empty; the caller must free both parts with ibl_bake_result_free.
 *         IBL_CAPTURE_ALPHA stays empty unless the layer's alpha is read and
 *         some is below IBL_CAPTURE_OPAQUE.
 * Alpha that is 0 everywhere is an error.
 */
bool ibl_capture_bake(const ibl_probes_bake *p, int layer,
                      ibl_bake_result made[IBL_CAPTURE_PARTS]);

/* Warns of probes whose walls, those of their proxies, get light from outside,
 * and says which influence would do. With --strict fails. */
bool ibl_probes_check_walls(const ibl_probes_bake *p);
/* With --shard, keeps only the layers of that shard. */
bool ibl_probes_take_shard(ibl_probes_bake *p);
/* Pixels that are read for a layer. */
bool ibl_capture_pixels(const ibl_probes_bake *p, int layer, uint64_t *pixels);

/* Hashes the set and all options, but not the contents of captures. */
bool ibl_probes_hash_set(const ibl_probes_bake *p, char hash[IBL_HASH_SIZE]);
/* Hashes the inputs of each layer and of the LUT. */
bool ibl_probes_hash_inputs(ibl_probes_bake *p);
/* Decides where each layer comes from and which files stay. Compares the set
 * with the index of an earlier run, perhaps of another set; a file counts only
 * if it still has its hash. An index that is missing, damaged, edited or of
 * another version is ignored: then everything is baked again. */
bool ibl_probes_plan(ibl_probes_bake *p);

/* What the pixel format changes of a layer. */
typedef struct ibl_probes_loss {
    size_t values;             /* components above the largest value */
    ibl_overflow_level beyond; /* over all cubes and levels */
    double dark;               /* largest share of light that became 0 */
    bool blocks;               /* of texels: then the errors are known */
    int levels;                /* of the specular cube */
    ibl_pixel_error error[IBL_MAX_LEVELS];
} ibl_probes_loss;

/* The note of a baked layer; the caller must json_decref it, NULL: no
 * memory. */
json_t *ibl_probes_note(const ibl_bake_result made[IBL_CAPTURE_PARTS],
                        const ibl_probes_loss *loss);

/* The text of the index. The caller must free it; NULL: no memory. */
char *ibl_probes_index_text(const ibl_probes_bake *p);
/* Reads an index without its member "hash", and what index has of it, which the
 * caller must free. NULL: there is none, or it is damaged, edited or of another
 * version. ctx and console, which it reports to, are NULL for silence. */
json_t *ibl_probes_index_load(const char *path, ibl_ctx *ctx,
                              ibl_console *console, ibl_probe_index *index);
/* Adds "hash" to an index, frees it and returns its text as above. NULL is
 * fine. */
char *ibl_probes_index_seal(json_t *root);

/* Run the command; return the exit status. */
int ibl_probes_run(const void *settings);
int ibl_probes_grid(const ibl_probes_opts *opts);

#endif
