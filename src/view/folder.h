/* SPDX-License-Identifier: MIT */
/* What paths are, and what of a folder can be opened. */
#ifndef VIEW_FOLDER_H
#define VIEW_FOLDER_H

#include <stdbool.h>

#include "ibl/io.h"

typedef enum view_kind {
    VIEW_KIND_NONE,
    VIEW_KIND_MAP,
    VIEW_KIND_SET,
    VIEW_KIND_MODEL,
    VIEW_KIND_PROBES, /* index.json of `iblbake probes`, or its directory */
    VIEW_KIND_FOLDER  /* a directory of several sets, or without one, but with
                         maps, models or directories */
} view_kind;

/* Whether a path has the extension of a model, .gltf or .glb, and is not the
 * light that --target gltf writes. */
bool view_is_model(const char *path);
/* What a path is, by its content. A map is "-", a pipe, a file that is neither
 * KTX, KTX2, DDS nor JSON, or the name of six files, as of ibl_image_read.
 * *why: of NONE the reason, until the next call. */
view_kind view_kind_of(const char *path, const char **why);

typedef struct view_entry {
    char *name;
    view_kind kind; /* by its name; of directories by the names in them */
} view_entry;

/* What can be opened there: directories first, each kind by name. Zeroed: a
 * folder without entries. */
typedef struct view_folder {
    char *path;
    view_entry *entry;
    int count;
} view_folder;

/* Lists a directory, without what is hidden. False, with a message: it cannot
 * be read; *f is then empty. */
bool view_folder_read(const char *path, view_folder *f);
void view_folder_free(view_folder *f); /* zeroes it, too */
/* The next entry of a kind after that of a name, with a step below 0 the one
 * before, round the end; -1: there is none. */
int view_folder_step(const view_folder *f, view_kind kind, const char *name,
                     int step);

/* The map that is installed with the program, for models without a set; NULL,
 * with a message: it is not there. */
const char *view_shipped_map(void);

#endif
