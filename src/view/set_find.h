/* SPDX-License-Identifier: MIT */
/* The files of a set by content and by name. Parts of set.c, used there alone.
 */
#ifndef VIEW_SET_FIND_H
#define VIEW_SET_FIND_H

#include "view/set_about.h"

typedef enum view_file_kind {
    VIEW_FILE_TEXTURE, /* KTX2, KTX or DDS */
    VIEW_FILE_JSON,
    VIEW_FILE_OTHER,
    VIEW_FILE_DIRECTORY,
    VIEW_FILE_PIPE,   /* or another thing that cannot be looked into */
    VIEW_FILE_MISSING /* errno says why */
} view_file_kind;

/* *words: what to call what is neither a texture, a pipe nor missing, as "a PNG
 * picture" after "is". */
view_file_kind view_file_look(const char *path, const char **words);

/* The name in a path. */
const char *view_file_name(const char *path);
/* The content whose name ends stem, "brdf_lut" or after a "_"; VIEW_CONTENTS:
 * none. *length is that of what is before. */
view_content view_file_content(const char *stem, size_t *length);
/* The specular file that a file's or directory's path means, for free(). NULL,
 * with a message. */
char *view_file_specular(const char *path);

/* Text for free(); NULL: no memory. */
char *view_file_print(const char *fmt, ...)
    __attribute__((format(printf, 1, 2)));
/* Says so of path. */
bool view_file_no_memory(const char *path);

#endif
