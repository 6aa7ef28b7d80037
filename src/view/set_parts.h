/* SPDX-License-Identifier: MIT */
/* Shared by the files set_*.c, which read and make a baked_set. */
#ifndef VIEW_SET_PARTS_H
#define VIEW_SET_PARTS_H

#include <jansson.h>

#include "common/about.h"
#include "view/baked_set.h"

/* ---- files by content and by name (set_open.c) ------------------------- */

typedef enum view_file_kind {
    VIEW_FILE_TEXTURE, /* KTX2, KTX or DDS */
    VIEW_FILE_JSON,
    VIEW_FILE_OTHER,
    VIEW_FILE_DIRECTORY,
    VIEW_FILE_PIPE,   /* or a device; its content is not examined */
    VIEW_FILE_MISSING /* errno holds the reason */
} view_file_kind;

/* Kind of a file by its content. */
view_file_kind view_file_look(const char *path);

/* The file name without its last extension; the caller must free it. */
char *view_file_stem(const char *path);
/* Reports that there is no memory to open path; returns false. */
bool view_file_no_memory(const char *path);

/* Moves an allocated path to *out, if a file has it, else frees it. False, with
 * a message about `of`: it is NULL. */
bool view_file_take(char *path, const char *of, char **out);

/* Stores the state of file i in set->seen; call it before reading the file. */
void view_set_see(baked_set *set, int i);

/* Makes the table of sheen for a chain of levels with rising roughness. False:
 * no memory. */
bool view_set_fill_sheen(ibl_ctx *ctx, const double *roughness, int levels,
                         baked_set *set);

/* ---- how a file was baked (set_about.c) --------------------------------- */

/* ibl_about_read of a texture of the set; a note where keys and sidecar differ.
 * False, with a message, if a value is invalid or the sidecar belongs to
 * another bake. */
bool view_about_read(const baked_set *set, view_content content,
                     const json_t *sidecar, ibl_about *a);

/* Reads NAME.json; the caller must free *root with json_decref. *root is NULL
 * if there is no such file, or if iblbake did not write it (with a note).
 * False, with a message, if it is damaged. */
bool view_sidecar_open(const char *path, json_t **root);
/* The name, without a directory, of a content's file; NULL: none. */
const char *view_sidecar_file(const json_t *root, view_content content);
/* Reads harmonics and lights, turned back from axes, and expected errors into
 * set, and finds its map.
 * False, with a message. */
bool view_sidecar_read(ibl_ctx *ctx, const json_t *root, ibl_axes axes,
                       baked_set *set);

/* ---- missing textures (set_make.c) --------------------------------------- */

/* Makes the missing table and irradiance of a set that has its specular chain
 * and roughness. */
bool view_set_fill(ibl_ctx *ctx, baked_set *set);
/* Stores the cosine-weighted harmonics of radiance: 3 for each (l, m) up to
 * degree, which is VIEW_SH_DEGREE or less. */
void view_set_harmonics(baked_set *set, int degree, const double *radiance);

#endif
