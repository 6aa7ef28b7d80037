/* SPDX-License-Identifier: MIT */
/* A baked environment, from files or from a bake in this process, and how it
 * was baked. */
#ifndef VIEW_BAKED_SET_H
#define VIEW_BAKED_SET_H

#include <stdbool.h>

#include "ibl/set.h"
#include "view/settings.h"
#include "view/vector.h"

typedef struct baked_set {
    /* With a name, for titles. Cubes are in the world's axes; those of flat
     * maps are cubes, too. The specular chain is there, with a lod_scale; a
     * missing table is made by ibl_bake_lut, with a note. The skybox and the
     * lobe table may be absent: then level 0 is the sky, and there are no table
     * and taps of view_reflection. Lights are those that were taken out of the
     * maps, not of the sky. Baked here, files have no path. */
    ibl_set baked;
    ibl_image map;  /* of view_set_source; data NULL: it is not read */
    bool map_tried; /* to read it */
    bool own_sky;   /* the skybox was asked for */
    int layer;      /* of arrays of cubes; 0: or no array */
    /* Irradiance E/pi, not radiance: 3 for each (l, m) to sh_degree, ordered
     * and with the basis of ibl_bake_sh. sh_degree -1: none. */
    int sh_degree; /* -1..VIEW_SH_DEGREE; higher degrees are dropped */
    double sh[3 * VIEW_SH_COUNT];
    /* What the set's engine lights matte surfaces by (iblbake-engines(7)): its
     * irradiance map; without one harmonics, but of the targets three and
     * filament, as without harmonics, the last level. */
    view_diffuse diffuse;
} baked_set;

/* Paths of the set to open. */
typedef struct view_request {
    const char *path; /* a directory, a specular file or, by its content, an
                         environment to bake */
    int layer;        /* of arrays of cubes */
    const char *irradiance, *lut, *sky; /* NULL: searched beside path */
    const char *map; /* that was baked; NULL: where the sidecar says */
} view_request;

/* Reads a set as ibl_set_open does, and notes what its files do not say and is
 * taken as the default. ctx logs through view_log. False, with a message that
 * says what does not fit and what to do, and *set zeroed. */
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

/* The map of the set, as it was baked, but of at most 8192 columns: it is read
 * once, and freed with the set. NULL: it is not known, or, with a note the
 * first time, another file is there or none. */
const ibl_image *view_set_source(const baked_set *set);
/* What the reference integrates: the map of the set, if it is at hand; else the
 * skybox if level 0 is rough; else level 0. */
typedef enum view_environment {
    VIEW_BY_LEVEL0,
    VIEW_BY_MAP,
    VIEW_BY_SKY
} view_environment;
view_environment view_set_lit_by(const baked_set *set);
/* Gives its equirectangular map: set->map, or one that is made of the cube and
 * to be freed. *what: which it is, until the set is freed. False, with a
 * message: no memory, or the format clips what is there. */
bool view_set_environment(const baked_set *set, ibl_image *map,
                          const char **what);

/* "is no irradiance map" if a set has no such diffuse light; NULL: it has. */
const char *view_set_lacks(const baked_set *set, view_diffuse by);

/* Stores the cosine-weighted harmonics of radiance: 3 for each (l, m) up to
 * degree; those above VIEW_SH_DEGREE are dropped. */
void view_set_harmonics(baked_set *set, int degree, const double *radiance);

/* ---- a bake beside the window ------------------------------------------ */

/* Runs view_set_bake on a thread. */
typedef struct view_baker view_baker;

/* What paths name must stay until the end. NULL, with a message. */
view_baker *view_baker_start(const view_request *what);
/* Gives the share of the bake that is done, 0..1, never decreasing; returns
 * true once it has ended. */
bool view_baker_poll(view_baker *baker, double *done);
/* Waits, moves the result into *set and frees the baker. False, with its
 * message and *set zeroed, if the bake failed. set NULL: cancels the bake;
 * false without a message. */
bool view_baker_finish(view_baker *baker, baked_set *set);

#endif
