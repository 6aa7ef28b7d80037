/* SPDX-License-Identifier: MIT */
/* What the files set_*.c share: they read and make a baked_set. */
#ifndef VIEW_SET_PARTS_H
#define VIEW_SET_PARTS_H

#include <jansson.h>

#include "view/baked_set.h"

/* "specular", "irradiance", "brdf_lut", "skybox": in names of files, keys and
 * sidecars. Ended by NULL. */
extern const char *const view_content_names[VIEW_CONTENTS + 1];

/* ---- files by content and by name (set_files.c) ------------------------- */

typedef enum view_file_kind {
    VIEW_FILE_TEXTURE, /* KTX2, KTX or DDS */
    VIEW_FILE_JSON,
    VIEW_FILE_OTHER,
    VIEW_FILE_DIRECTORY,
    VIEW_FILE_PIPE,   /* or a device: it has no content to look at */
    VIEW_FILE_MISSING /* errno says why */
} view_file_kind;

/* *words: what to call anything but a texture, a pipe or a missing file, as "a
 * PNG picture" after "is". */
view_file_kind view_file_look(const char *path, const char **words);

/* The name in a path without its last extension, for free(). */
char *view_file_stem(const char *path);
/* The content whose name ends that, "brdf_lut" or after a "_"; VIEW_CONTENTS:
 * none. *length is that of what is before "_", or of all. */
view_content view_file_content(const char *path, size_t *length);
/* The specular file that a directory's or its own path means, for free(). NULL,
 * with a message. */
char *view_file_specular(const char *path);
/* Prints that there is no memory to open path; false. */
bool view_file_no_memory(const char *path);

/* Fills entry i of set->seen; called before that file is read. */
void view_set_see(baked_set *set, int i);

/* ---- how a file was baked (set_about.c) --------------------------------- */

/* Places in view_about. Mapping, lobe and geometry are the library's
 * enumerations, content is view_content, scale is 0 for E/pi and 1 for E. */
enum {
    VIEW_ABOUT_CONTENT,
    VIEW_ABOUT_MAPPING,
    VIEW_ABOUT_LOBE,
    VIEW_ABOUT_GEOMETRY,
    VIEW_ABOUT_SCALE,
    VIEW_ABOUT_LOD_SCALE,
    VIEW_ABOUT_LOD_OFFSET,
    VIEW_ABOUT_LEVELS, /* how many roughnesses follow */
    VIEW_ABOUT_ROUGHNESS,
    VIEW_ABOUT_COUNT = VIEW_ABOUT_ROUGHNESS + IBL_MAX_LEVELS
};

typedef struct view_about {
    bool known[VIEW_ABOUT_COUNT];
    double value[VIEW_ABOUT_COUNT];
} view_about;

/* From the keys iblbake.* of a texture of the set and, what they do not say,
 * from the sidecar's entry of its file; a note where they differ. Nothing known
 * is no failure. False, with a message, if a value makes no sense or the
 * sidecar is of another bake. */
bool view_about_read(const baked_set *set, view_content content,
                     const json_t *sidecar, view_about *a);

/* Reads NAME.json; *root is to be freed with json_decref. It is NULL where
 * there is no such file, or one that iblbake did not write (with a note).
 * False, with a message, if it is damaged. */
bool view_sidecar_open(const char *path, json_t **root);
/* The name, never a path, of a content's file; NULL: none. */
const char *view_sidecar_file(const json_t *root, view_content content);
/* The harmonics into set; its degree is -1 where there are none. */
bool view_sidecar_sh(const json_t *root, baked_set *set);

/* ---- missing textures (set_make.c) --------------------------------------- */

/* Makes the table and irradiance of a set whose specular chain is there, with
 * its roughness, where they are missing. */
bool view_set_fill(ibl_ctx *ctx, baked_set *set);
/* The cosine-weighted harmonics of radiance, 3 for each (l, m) to a degree of
 * VIEW_SH_DEGREE or less. */
void view_set_harmonics(baked_set *set, int degree, const double *radiance);

#endif
