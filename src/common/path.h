/* SPDX-License-Identifier: MIT */
#ifndef COMMON_PATH_H
#define COMMON_PATH_H

#include <stdbool.h>

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

/* Decodes %XX of a URI in place. False: no such code, or a NUL. */
bool ibl_uri_decode(char *text);

/* Path of the image bridge beside the program (in a build) or in ../lib/iblbake
 * (installed), not to be freed. NULL: not found, so the library's compiled-in
 * path applies. */
const char *ibl_bridge_beside(void);

#endif
