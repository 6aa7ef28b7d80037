/* SPDX-License-Identifier: MIT */
/* A baked environment, from files or from a bake in this process, and how it
 * was baked. */
#ifndef VIEW_BAKED_SET_H
#define VIEW_BAKED_SET_H

#include <stdbool.h>

#include "ibl/io.h"
#include "view/file_stamp.h"
#include "view/vector.h"

typedef enum view_content {
    VIEW_SPECULAR,
    VIEW_IRRADIANCE,
    VIEW_LUT,
    VIEW_SKY,   /* --skybox; if absent, level 0 of the specular chain is the sky
                 */
    VIEW_LOBES, /* --lobe-table: the lobe of each N.V and roughness; if absent,
                   there are no table and taps of view_reflection */
    VIEW_SHEEN, /* levels of IBL_LOBE_CHARLIE; if absent, models have no
                   sheen */
    VIEW_SHEEN_TABLE, /* made here for them, by N.V and roughness: the albedo of
                         sheen, the level */
    VIEW_CONTENTS
} view_content;

/* "specular", "irradiance" and so on in file names, keys, sidecars and
 * messages; ended by NULL. */
extern const char *const view_content_names[VIEW_CONTENTS + 1];

/* Indices of a set's files: its textures, then these. */
enum {
    VIEW_SIDECAR = VIEW_CONTENTS,
    VIEW_MAP, /* the map of a set that was baked in this process */
    VIEW_FILES
};

typedef struct baked_set {
    char *name; /* for titles, such as "sky" */
    /* Texels as in the files, in the world's axes; blocks as rgba16f. Only the
     * sky and the lobes may be missing, and are then zeroed. A missing table is
     * made by ibl_bake_lut. Missing irradiance is made from level 0 as a map;
     * if level 0 is rough or clipped, from the last level if its roughness is
     * 1, else from the spherical harmonics. A note reports both. */
    ibl_texture texture[VIEW_CONTENTS];
    ibl_pixel pixel[VIEW_CONTENTS]; /* of the files */
    char *path[VIEW_FILES];         /* NULL: none */
    char *source; /* the map of the set, if its file is at hand, or NULL */
    ibl_read_options source_read; /* how its colours were changed */
    double source_yaw;            /* its turn, as of ibl_cube_from_latlong */
    double source_peak;           /* its largest value, to know it by, or 0 */
    char source_hash[IBL_FILE_HASH];  /* the same of the file's bytes, or "" */
    bool own_sky;                     /* texture[VIEW_SKY] was asked for */
    view_file_stamp seen[VIEW_FILES]; /* state just before reading */

    ibl_roughness_map mapping;
    double lod_scale, lod_offset;     /* as in ibl_specular_layout */
    double roughness[IBL_MAX_LEVELS]; /* of each level */
    int layer;                        /* of arrays of cubes; 0: or no array */
    ibl_lobe lobe;
    ibl_geometry geometry;   /* of the table */
    double irradiance_scale; /* factor from the map to E/pi; 1 for maps made
                                here */
    int light_count; /* that --lights took out of the maps, not of the sky */
    ibl_light light[IBL_MAX_LIGHTS];
    /* Irradiance E/pi, not radiance: 3 for each (l, m) to sh_degree, ordered
     * and with the basis of ibl_bake_sh. sh_degree -1: none. */
    int sh_degree; /* -1..VIEW_SH_DEGREE; higher degrees are dropped */
    double sh[3 * VIEW_SH_COUNT];
} baked_set;

/* Paths of the set to open. */
typedef struct view_request {
    const char *path; /* a directory, a specular file or, by its content, an
                         environment to bake */
    int layer;        /* of arrays of cubes */
    const char *irradiance, *lut, *sky; /* NULL: searched beside path */
    const char *map;         /* that was baked; NULL: where the sidecar says */
    ibl_input_layout layout; /* of a map; AUTO: by its content, and a cube
                                texture is no map */
    unsigned char face_order[IBL_FACES]; /* of a map, as ibl_read_options */
    ibl_transfer transfer;
} view_request;

/* Whether path is a map rather than a baked set: "-", a pipe, a file whose
 * content is neither KTX, KTX2, DDS nor JSON, the name of six files, as of
 * ibl_image_read, or whatever has a layout. */
bool view_is_map(const char *path, ibl_input_layout layout);

/* Whether a path has the extension of a model, .gltf or .glb, and is not the
 * light that --target gltf writes. */
bool view_is_model(const char *path);

/*
 * Reads a set. In a directory the only NAME_specular.ktx2, .ktx or .dds is
 * taken; several are an error that names them. NAME.json beside it and the
 * keys of the containers say how it was baked; where both do and differ, the
 * keys hold, with a note. Files from other programs have neither. They get the
 * defaults of ibl_specular_options (linear mapping, E/pi) with a note; those of
 * cmgen (KTX with a key "sh") get Filament's mapping. ctx logs through
 * view_log. False, with a message that says what does not fit and what to do,
 * and *set zeroed.
 */
bool view_set_open(ibl_ctx *ctx, const view_request *what, baked_set *set);
void view_set_free(baked_set *set); /* zeroed is fine */

/* Makes the set of a map: the defaults of the library, rgba16f, sky from level
 * 0, harmonics to VIEW_SH_DEGREE. Progress goes to ctx's callback. */
bool view_set_bake(ibl_ctx *ctx, const view_request *what, baked_set *set);
/* Adds the textures of env to a set that has its name, or NULL after strdup had
 * no memory. specular NULL: defaults, with lobes. The caller frees set after a
 * failure. */
bool view_set_bake_environment(ibl_ctx *ctx, const ibl_environment *env,
                               const ibl_specular_options *specular,
                               baked_set *set);

/* Reads the map of the set, as it was baked. False: it is not at hand, or
 * another file is, with a note. */
bool view_set_map(const baked_set *set, ibl_image *map);
/* Makes the environment that the reference integrates: the map of the set, if
 * it is at hand, as a cube of RGBA32F, which nothing clips. *env zeroed: it is
 * the skybox if level 0 is rough, else level 0. *what: which, until the set is
 * freed. False, with a message: no memory, or the format clips what is there.
 */
bool view_set_environment(const baked_set *set, ibl_texture *env,
                          const char **what);

/* The level of a roughness, between those of rising roughnesses. */
double view_level_at(const double *roughness, int levels, double r);

/* ---- files that change ------------------------------------------------- */

/* Whether a file differs from the one that was last read or seen, and all such
 * files are unchanged for `settle` seconds, longer if one is gone. Never while
 * the specular file or the map is missing. Sees changes during the reading. */
bool view_set_changed(const baked_set *set, double settle);
/* Takes the present state of the files as seen. */
void view_set_seen(baked_set *set);

/* ---- a bake beside the window ------------------------------------------ */

/* Runs view_set_bake on a thread. */
typedef struct view_baker view_baker;

/* NULL, with a message. */
view_baker *view_baker_start(const view_request *what);
/* Gives the present stage and the share of the whole bake that is done, 0..1,
 * never decreasing; returns true once it has ended. stage: room for 64. */
bool view_baker_poll(view_baker *baker, char *stage, double *done);
/* Waits, moves the result into *set and frees the baker. False, with its
 * message and *set zeroed, if the bake failed. set NULL: cancels the bake;
 * false without a message. */
bool view_baker_finish(view_baker *baker, baked_set *set);

#endif
