/* SPDX-License-Identifier: MIT */
#ifndef COMMON_PATH_H
#define COMMON_PATH_H

#include <stdbool.h>
#include <stddef.h>

/* The part after the last slash. */
const char *ibl_path_name(const char *path);
/* 1: both exist and are the same file; 0: not; -1: unknown, with errno. */
int ibl_path_same(const char *a, const char *b);
/* Whether files can be made in path's directory; false sets errno. */
bool ibl_path_is_open(const char *path);

/* The caller must free the result; NULL: no memory. */

/* directory/name; directory is not empty and may end in a slash. */
char *ibl_path_join(const char *directory, const char *name);
/* name in the directory of file; an absolute name stays. */
char *ibl_path_beside(const char *file, const char *name);

/* The names in a folder that are wanted, by their bytes. The caller frees each
 * and the list. Returns their number; -1: it cannot be listed, see errno. */
int ibl_path_list(const char *folder, bool (*want)(const char *name),
                  char ***names);

/* Decodes %XX of a URI in place, as browsers do: a % that encodes nothing
 * stays. Returns the number of bytes, which may be any. */
size_t ibl_uri_bytes(char *text);
/* The same of a name. False: it has a NUL. */
bool ibl_uri_decode(char *text);

enum {
    IBL_PART_BYTES = 4352
};
/* Finds a part of the program that is loaded on demand: beside it (in a build)
 * or in ../lib/iblbake (installed). False: not found, so the path that was
 * compiled in applies. */
bool ibl_path_of_part(const char *name, char path[IBL_PART_BYTES]);
/* The same for the image bridge; not to be freed, or NULL. */
const char *ibl_bridge_beside(void);

#endif
