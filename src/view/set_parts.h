/* SPDX-License-Identifier: MIT */
/* What the files set_*.c share: they read and make a baked_set. */
#ifndef VIEW_SET_PARTS_H
#define VIEW_SET_PARTS_H

#include <jansson.h>

#include "view/baked_set.h"

/* "specular", "irradiance", "brdf_lut", "skybox": in names of files, keys and
 * sidecars. Ended by NULL. */
extern const char *const view_content_names[VIEW_CONTENTS + 1];
/* For messages: "a specular chain", "a BRDF table", ... */
const char *view_content_words(view_content content);

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

/* The name in a path; and, for free(), that without its last extension. */
const char *view_file_name(const char *path);
char *view_file_stem(const char *path);
/* The content whose name ends stem, "brdf_lut" or after a "_"; VIEW_CONTENTS:
 * none. *length is that of what is before. */
view_content view_file_content(const char *stem, size_t *length);
/* The specular file that a file's or directory's path means, for free(). NULL,
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

/* From the keys iblbake.* of a texture; nothing known is no failure. False,
 * with a message about path, if one makes no sense. */
bool view_about_keys(const ibl_texture *tex, const char *path, view_about *a);
/* The same of an entry of the sidecar at path. */
bool view_about_entry(const json_t *entry, const char *path, view_about *a);
/* Adds what only `from` knows. */
void view_about_add(view_about *a, const view_about *from);
/* Whether both know a value and disagree about it; content aside. */
bool view_about_differ(const view_about *a, const view_about *b);

/* Reads NAME.json; *root is to be freed with json_decref. It is NULL where
 * there is no such file, or one that iblbake did not write (with a note).
 * False, with a message, if it is damaged. */
bool view_sidecar_open(const char *path, json_t **root);
/* The entry of an output whose member has that value; NULL: none. */
const json_t *view_sidecar_entry(const json_t *root, const char *member,
                                 const char *value);
/* Its file's name, never a path; NULL: none. */
const char *view_entry_file(const json_t *entry);
/* The content that it names; VIEW_CONTENTS: none. */
view_content view_entry_content(const json_t *entry);
/* Edge and levels of its texture; false if it has none. */
bool view_entry_shape(const json_t *entry, int *width, int *levels);
/* The harmonics into set; its degree is -1 where there are none. */
bool view_sidecar_sh(const json_t *root, baked_set *set);

/* ---- missing textures (set_make.c) --------------------------------------- */

/* Makes the table and irradiance of a set whose specular chain is there, with
 * its roughness, where they are missing. */
bool view_set_fill(ibl_ctx *ctx, baked_set *set);
/* The largest finite component of level 0 of the specular chain. */
double view_set_peak(const baked_set *set);

#endif
