/* SPDX-License-Identifier: MIT */
/*
 * What a file of a set says about itself: by the keys in it, or by the entry
 * for it in the sidecar. Parts of set.c, used there alone.
 */
#ifndef VIEW_SET_ABOUT_H
#define VIEW_SET_ABOUT_H

#include "view/baked_set.h"

/* Which members are known. */
enum {
    VIEW_KNOWS_MAPPING = 1,
    VIEW_KNOWS_LOD = 2,
    VIEW_KNOWS_ROUGHNESS = 4,
    VIEW_KNOWS_LOBE = 8,
    VIEW_KNOWS_GEOMETRY = 16,
    VIEW_KNOWS_SCALE = 32,
    VIEW_KNOWS_CONTENT = 64
};

typedef struct view_about {
    unsigned known;
    view_content content;
    ibl_roughness_map mapping;
    double lod_scale, lod_offset;
    double roughness[IBL_MAX_LEVELS];
    int levels; /* of roughness */
    ibl_lobe lobe;
    ibl_geometry geometry;
    double irradiance_scale;
} view_about;

/* "specular", "irradiance", "brdf_lut", "skybox": as iblbake says, in names of
 * files, keys and sidecars. */
const char *view_content_name(view_content content);
/* What people call it: "specular chain", "BRDF table", ... */
const char *view_content_words(view_content content);

/* As keys and sidecars have them; NULL: not there. */
typedef struct view_words {
    const char *content, *mapping, *lobe, *geometry, *scale;
} view_words;

/* Takes the words that stand in `where`. False, with a message, if one is
 * unknown. */
bool view_about_words(view_about *a, const char *where,
                      const view_words *words);
/* Checks numbers once all are there. */
bool view_about_check(const view_about *a, const char *where);

/* From the keys iblbake.* of a texture; nothing known is no failure. */
bool view_about_keys(const ibl_texture *tex, const char *path, view_about *a);
/* Adds what only `from` knows. */
void view_about_add(view_about *a, const view_about *from);
/* Whether both know something that they do not agree about. */
bool view_about_differ(const view_about *a, const view_about *b);

/* ---- the sidecar -------------------------------------------------------- */

typedef struct view_sidecar view_sidecar;

/* Reads NAME.json. *out is NULL where there is none, or one that iblbake did
 * not write (a note tells). False, with a message, for a damaged one. */
bool view_sidecar_open(const char *path, view_sidecar **out);
void view_sidecar_free(view_sidecar *s); /* NULL is fine */

/* Name of the file of a content, or NULL; owned by s. */
const char *view_sidecar_file(const view_sidecar *s, view_content content);
/* What it says of that file. */
bool view_sidecar_about(const view_sidecar *s, view_content content,
                        view_about *a);
/* Which content the file of that name has; VIEW_CONTENTS: none known. */
view_content view_sidecar_content(const view_sidecar *s, const char *file);
/* Edge and levels of a content's file; false if it does not tell. */
bool view_sidecar_shape(const view_sidecar *s, view_content content, int *width,
                        int *levels);
/* The harmonics, as baked_set has them; degree -1 where there are none. */
bool view_sidecar_sh(const view_sidecar *s, baked_set *set);

/* ---- what a set has not ------------------------------------------------- */

/* Makes the table and irradiance of a set whose specular chain is there, with
 * its roughness. */
bool view_set_fill(ibl_ctx *ctx, baked_set *set);
/* The largest finite component of level 0 of the specular chain. */
double view_set_peak(const baked_set *set);
/* Fills entry i of set->read: before that file is read. */
void view_stamp_read(baked_set *set, int i);
/* File's name without directory, and without its last extension: for
 * free(). */
char *view_set_stem(const char *path);

#endif
